//! The folder of a flow through or around a part: its manifest from the text `templates/part.toml`, and the
//! part.

use super::annotate::ManifestHead;
use super::domain_face::DomainFace;
use super::file_unit::{edges_text, three_digits};
use super::part_scene::{FlowKind, PartScene};
use super::quantity_text::{length, lengths, quoted, speed, time};
use super::{fill_in, write_file};
use crate::tools::shell::shell_word;
use std::path::Path;
use tremie_results::CommandError;

/// The text, with names for the numbers.
const TEXT: &str = include_str!("templates/part.toml");

/// Names of the axes.
const AXES: [&str; 3] = ["x", "y", "z"];

impl PartScene {
    /// Writes manifest and part into a folder.
    ///
    /// # Errors
    /// The system's.
    pub fn write(
        &self,
        head: &ManifestHead,
        folder: &Path,
    ) -> Result<Vec<(String, String)>, CommandError> {
        write_file(folder, "manifest.toml", self.manifest(head).as_bytes())?;
        std::fs::copy(&self.path, folder.join(&self.file)).map_err(|error| {
            CommandError::failed(format!("cannot copy {}: {error}", self.path.display()))
        })?;
        let size = edges_text(self.bounds.size().into());
        Ok(vec![
            ("manifest.toml".into(), "the scene, with comments".into()),
            (self.file.clone(), format!("the part, in {}: {size}", self.unit.plural())),
        ])
    }

    fn manifest(&self, head: &ManifestHead) -> String {
        let domain = &self.domain;
        let frame = three_digits(domain.until / 50.0);
        let title = match self.kind {
            FlowKind::Through => format!("Water flows through {}.", self.file),
            FlowKind::Around => format!("Water flows around {}.", self.file),
            FlowKind::Inside => {
                format!("Water flows through the space inside the surface {}.", self.file)
            }
        };
        let [packing_min, packing_max] = self.packing();
        fill_in(
            TEXT,
            &[
                ("title", head.text(&title)),
                ("passing", time(domain.passing)),
                ("word", shell_word(head.arguments.name.as_os_str())),
                ("twice", time(2.0 * domain.until)),
                ("until", time(domain.until)),
                ("origin", lengths(domain.origin)),
                ("size", lengths(domain.size())),
                ("inlet", domain.inlet.name().into()),
                ("outlet", domain.outlet.name().into()),
                ("others", self.other_faces().into()),
                ("faces", self.faces()),
                ("fastest", speed(domain.fastest)),
                ("inside", self.inside_text()),
                ("file", quoted(&self.file)),
                ("unit", self.unit.manifest_name().into()),
                ("cavity", self.cavity_text().into()),
                ("probes", self.probes()),
                ("packing_min", packing_min),
                ("packing_max", packing_max),
                ("grain", length(4.0 * domain.cell)),
                ("across", format!("{:.0}", domain.across())),
                ("what", self.what().into()),
                ("width", length(three_digits(domain.width))),
                ("cell", length(domain.cell)),
                ("frames", time(frame)),
                ("signals", time(three_digits(frame / 4.0))),
            ],
        )
    }

    fn other_faces(&self) -> &'static str {
        match self.kind {
            FlowKind::Around => {
                "The others are planes of symmetry, along which the water slips: walls of a channel would hold it."
            }
            FlowKind::Through | FlowKind::Inside => {
                "The others are walls that the water does not reach."
            }
        }
    }

    /// The keys x, y and z of the domain.
    fn faces(&self) -> String {
        let domain = &self.domain;
        let velocity = domain.velocity().map(|v| format!("\"{}\"", speed(v))).join(", ");
        let ramp = time(three_digits(domain.until / 5.0));
        let of = |k: usize| {
            let face = |is_upper: bool| match DomainFace::of(k, is_upper) {
                face if face == domain.inlet => {
                    format!("{{ velocity = [{velocity}], ramp = \"{ramp}\" }}")
                }
                face if face == domain.outlet => {
                    "{ pressure = \"0 Pa\", outflow = \"absorbing\" }".to_string()
                }
                _ => "\"wall\"".to_string(),
            };
            match (face(false), face(true)) {
                // Neither inlet nor outlet.
                (lower, upper) if lower == upper && self.kind == FlowKind::Around => {
                    "\"symmetry\"".to_string()
                }
                (lower, upper) if lower == upper => lower,
                (lower, upper) => format!("{{ lower = {lower}, upper = {upper} }}"),
            }
        };
        (0..3).map(|k| format!("{} = {}", AXES[k], of(k))).collect::<Vec<_>>().join("\n")
    }

    fn inside_text(&self) -> String {
        let Some(point) = self.inside else { return String::new() };
        format!(
            "# A point in the passage: there is water only where a way leads to it, so none outside the part. Add a point to\n\
             # `outside`, and `tremie check` looks for leaks to it.\ninside = [{}]\n",
            lengths(point)
        )
    }

    fn cavity_text(&self) -> &'static str {
        match self.kind {
            FlowKind::Inside => {
                "cavity = true # the space inside the surface is free, and that outside solid\n"
            }
            FlowKind::Through | FlowKind::Around => "",
        }
    }

    fn probes(&self) -> String {
        let domain = &self.domain;
        let section = |name: &str, face: DomainFace| {
            let (axis, at) = (AXES[face.axis()], length(domain.within(face, 1.5)));
            format!(
                "[[scene.probes]]\nname = \"{name}\"\nsection = {{ axis = \"{axis}\", at = \"{at}\" }}\n"
            )
        };
        let mut text =
            format!("{}\n{}", section("inlet", domain.inlet), section("outlet", domain.outlet));
        if self.kind == FlowKind::Around {
            let mut point: [f64; 3] = self.bounds.centre().into();
            let k = domain.outlet.axis();
            let (behind, sign) = match domain.outlet.is_upper() {
                true => (self.bounds.max[k], 1.0),
                false => (self.bounds.min[k], -1.0),
            };
            point[k] = behind + sign * 0.5 * domain.width;
            text += &format!("\n[[scene.probes]]\nname = \"wake\"\npoint = {}\n", lengths(point));
        }
        text
    }

    /// Corners of a small box of fluid near the inlet, for grains.
    fn packing(&self) -> [String; 2] {
        let domain = &self.domain;
        let centre = self.inside.unwrap_or_else(|| {
            let mut centre: [f64; 3] = self.bounds.centre().into();
            centre[domain.inlet.axis()] = domain.within(domain.inlet, 0.0);
            centre
        });
        let k = domain.inlet.axis();
        let half = 0.3 * domain.width;
        let begin = domain.within(domain.inlet, 2.0);
        let end = begin + if domain.inlet.is_upper() { -2.0 * half } else { 2.0 * half };
        let corner = |sign: f64| {
            let mut corner = centre.map(|x| x + sign * half);
            corner[k] = if sign < 0.0 { begin.min(end) } else { begin.max(end) };
            lengths(corner.map(|x| (x / domain.cell).round() * domain.cell))
        };
        [corner(-1.0), corner(1.0)]
    }
}
