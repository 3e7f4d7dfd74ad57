//! A flow through or around the part in a file of triangles: which, and in which domain.

use super::NewArgs;
use super::domain_face::DomainFace;
use super::file_unit::{FileUnit, agreed_unit, in_words, three_digits};
use super::part_domain::{PartDomain, REYNOLDS};
use super::passage::Passage;
use super::quantity_text::{length, speed};
use clap::ValueEnum;
use std::path::{Path, PathBuf};
use tremie_geometry::{Bounds, GeometryError, Surface, load};
use tremie_messages::Problem;
use tremie_messages::scene::Geometry;
use tremie_results::CommandError;

/// Cells across a bore or a part below which its flow is rough.
const ROUGH: f64 = 8.0;

/// Way of a flow past a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FlowKind {
    /// Through a passage in it: a tube, an elbow, a block with a bore.
    Through,
    /// Around it: a body in a stream.
    Around,
    /// In the space inside its surface, which is that of the fluid and not of a wall.
    Inside,
}

/// A flow through or around a part.
#[derive(Clone, Debug, PartialEq)]
pub struct PartScene {
    /// File of triangles.
    pub path: PathBuf,
    /// Its name, which the copy has too.
    pub file: String,
    /// Its unit.
    pub unit: FileUnit,
    /// Box of the part [m].
    pub bounds: Bounds,
    /// Way of the flow.
    pub kind: FlowKind,
    /// True if the command line says the kind.
    pub is_chosen: bool,
    /// A point in the fluid, where only the space that it is in holds any [m].
    pub inside: Option<[f64; 3]>,
    /// Domain, cells, velocity.
    pub domain: PartDomain,
}

impl PartScene {
    /// The scene around the part in a file. The unit is asked for where the command line has none.
    ///
    /// # Errors
    /// The file cannot be read or is no closed surface, in the words of the geometry; nobody knows its unit; no way
    /// leads from inlet to outlet.
    pub fn of(
        path: &Path,
        arguments: &NewArgs,
        ask: &mut dyn FnMut(&str) -> Option<String>,
    ) -> Result<Self, CommandError> {
        let is_plain = |name: &&str| !name.chars().any(char::is_control);
        let name = path.file_name().and_then(|name| name.to_str()).filter(is_plain);
        let file = name.ok_or_else(|| {
            CommandError::input(format!(
                "{path:?}: a manifest cannot name this file; give it a name of letters in UTF-8"
            ))
        })?;
        let unit = match arguments.unit {
            Some(unit) => unit,
            None => {
                // Only its numbers count here.
                let surface = surface(path, None)?;
                let edges = surface.bounds().size() / FileUnit::Mm.metres();
                agreed_unit(file, edges.into(), ask).map_err(CommandError::input)?
            }
        };
        let surface = surface(path, Some(unit))?;
        let bounds = surface.bounds();
        let (kind, passage) = passage(surface, arguments).map_err(CommandError::input)?;
        let domain = match (&passage, kind) {
            (Some(passage), kind) => PartDomain::through(passage, kind == FlowKind::Inside),
            (None, _) => {
                let inlet = inlet(arguments).unwrap_or_else(|| lower_of(longest_first(&bounds)[0]));
                PartDomain::around(&bounds, inlet)
            }
        };
        let is_chosen = arguments.flow.is_some();
        // On the axis of the inlet within the first cells, whatever the voxels were.
        let inside = passage.map(|passage| {
            let step = 0.01 * domain.cell;
            let mut point: [f64; 3] = passage.inside.map(|x| (x / step).round() * step).into();
            point[passage.inlet.axis()] = domain.within(passage.inlet, 1.5);
            point
        });
        Ok(Self {
            path: path.into(),
            file: file.into(),
            unit,
            bounds,
            kind,
            is_chosen,
            inside,
            domain,
        })
    }

    /// What was chosen, in sentences.
    pub fn notes(&self) -> Vec<String> {
        let domain = &self.domain;
        let (inlet, outlet) = (domain.inlet.name(), domain.outlet.name());
        let longest = self.bounds.size().max();
        let ways = format!("from {inlet} to {outlet}");
        let flow = match (self.kind, self.is_chosen) {
            (FlowKind::Through, _) => format!("water flows through the part, {ways}"),
            (FlowKind::Inside, _) => format!("water fills the inside of the surface, {ways}"),
            (FlowKind::Around, true) => format!("water flows around the part, {ways}"),
            (FlowKind::Around, false) => format!(
                "water flows around the part, {ways}: no bore leads through it. If the surface is that of the water itself, \
                 say --flow inside"
            ),
        };
        let mut notes = vec![
            format!("the part is {}", in_words(longest)),
            flow,
            format!(
                "{:.0} cells across the {}, {}; {} at the inlet, a Reynolds number of {REYNOLDS}",
                domain.across(),
                self.what(),
                match self.kind {
                    FlowKind::Around => length(three_digits(domain.width)),
                    // Voxels measure it, and facets lie inside the round that they stand for.
                    _ => format!("about {} at its narrowest", length(three_digits(domain.width))),
                },
                speed(domain.inflow),
            ),
        ];
        let thinnest = self.bounds.size().min();
        if self.kind == FlowKind::Around && thinnest < domain.cell {
            notes.push(format!(
                "the part is {} thin, less than a cell of {}: `tremie check` says what that means",
                length(three_digits(thinnest)),
                length(domain.cell)
            ));
        }
        if domain.across() < ROUGH {
            notes.push(format!(
                "that is rough: {ROUGH} and more cells would be better, but make a first run long; change cell in the manifest"
            ));
        }
        notes
    }

    /// What the cells are counted across.
    pub fn what(&self) -> &'static str {
        match self.kind {
            FlowKind::Around => "width",
            FlowKind::Through | FlowKind::Inside => "bore",
        }
    }
}

/// The surface of a part in a file; in millimetres, which most files are, where its unit is not known yet.
fn surface(path: &Path, unit: Option<FileUnit>) -> Result<Surface, CommandError> {
    let shown = path.display().to_string();
    let metres = unit.unwrap_or(FileUnit::Mm).metres();
    let geometry = Geometry::File { path: shown.clone(), unit: metres };
    let surface = load(&geometry).and_then(|loaded| Surface::new(loaded.mesh));
    surface.map_err(|error| {
        let mut sentences = sentences(&error, &shown);
        if unit.is_none() && matches!(error, GeometryError::Faults(_)) {
            sentences
                .push("places are as if the file was in millimetres: --unit says in what".into());
        }
        CommandError::Input(sentences)
    })
}

/// What is wrong with a file, with remedies.
fn sentences(error: &GeometryError, path: &str) -> Vec<String> {
    let problems = error.problems(path);
    let sentence = |problem: &Problem| {
        // Some of the geometry's sentences begin with the path.
        let named = problem.message.contains(path);
        let mut text = if named { String::new() } else { format!("{path}: ") };
        text += &problem.message;
        if let Some(help) = &problem.help {
            text += &format!("\nhelp: {help}");
        }
        text
    };
    problems.iter().map(sentence).collect()
}

/// The kind of flow, and its passage where it has one.
fn passage(surface: Surface, arguments: &NewArgs) -> Result<(FlowKind, Option<Passage>), String> {
    let bounds = surface.bounds();
    let ends = ends(arguments, &bounds)?;
    let asked = arguments.flow;
    if asked == Some(FlowKind::Around) {
        return match ends[0] {
            [inlet, outlet] if outlet != inlet.opposite() => Err(turns(inlet, outlet)),
            _ => Ok((FlowKind::Around, None)),
        };
    }
    let surface = if asked == Some(FlowKind::Inside) { surface.inside_out() } else { surface };
    match (Passage::find(&surface, &ends), asked, ends[0]) {
        (Some(passage), kind, _) => Ok((kind.unwrap_or(FlowKind::Through), Some(passage))),
        (None, None, [inlet, outlet]) if outlet == inlet.opposite() => Ok((FlowKind::Around, None)),
        (None, None, [inlet, outlet]) => Err(turns(inlet, outlet)),
        (None, Some(_), [inlet, outlet]) => Err(format!(
            "no way leads through the part from {} to {} that is closed to the other faces of its box; expected a bore, \
             open at both; name other faces with --inlet and --outlet, or take --flow around",
            inlet.name(),
            outlet.name()
        )),
    }
}

fn turns(inlet: DomainFace, outlet: DomainFace) -> String {
    format!(
        "no way leads through the part from {} to {}, and a stream around it goes straight; expected --outlet {}, or a part \
         with a bore from the one face to the other",
        inlet.name(),
        outlet.name(),
        inlet.opposite().name()
    )
}

/// The face of the inlet, if the command line names one of the two.
fn inlet(arguments: &NewArgs) -> Option<DomainFace> {
    arguments.inlet.or(arguments.outlet.map(DomainFace::opposite))
}

/// Inlet and outlet: as the command line has them, else those of all axes, the longest first, and then those
/// of bends.
fn ends(arguments: &NewArgs, bounds: &Bounds) -> Result<Vec<[DomainFace; 2]>, String> {
    let Some(inlet) = inlet(arguments) else {
        let [a, b, c] = longest_first(bounds);
        let straight = [a, b, c].map(|k| [lower_of(k), lower_of(k).opposite()]);
        let faces = |k: usize| [false, true].map(|is_upper| DomainFace::of(k, is_upper));
        let bends = [(a, b), (a, c), (b, c)]
            .into_iter()
            .flat_map(|(k, l)| faces(k).into_iter().map(move |inlet| (inlet, l)))
            .flat_map(|(inlet, l)| faces(l).map(|outlet| [inlet, outlet]));
        return Ok(straight.into_iter().chain(bends).collect());
    };
    let outlet = arguments.outlet.unwrap_or(inlet.opposite());
    match outlet == inlet {
        true => Err(format!("inlet and outlet are both {}; expected two faces", inlet.name())),
        false => Ok(vec![[inlet, outlet]]),
    }
}

fn lower_of(axis: usize) -> DomainFace {
    DomainFace::of(axis, false)
}

/// The axes by the length of the box along them.
fn longest_first(bounds: &Bounds) -> [usize; 3] {
    let size = bounds.size();
    let mut axes = [0, 1, 2];
    // Stable: of equal edges the first.
    axes.sort_by(|&a, &b| size[b].total_cmp(&size[a]));
    axes
}
