//! Profiles of grains: bars over the bins of one axis, a coloured sheet over those of two.

use crate::legend;
use crate::scale::{AIR, Map, Scale};
use crate::view::{Eye, facing, part, single};
use rerun::{BarChart, Color, Mesh3D, RecordingStream, RecordingStreamResult};
use tremie_geometry::Vec3;
use tremie_messages::frame::ProfileBin;
use tremie_messages::scene::{GrainProfile, Scene};
use tremie_messages::start::{FrameContent, FrameStream};

/// Solid fraction at the end of the scale: a little above that of spheres poured at random.
const DENSE: f64 = 0.65;
/// Colours of sheets: not those of speeds.
const SHEET: Map = Map::Plasma;
const AXES: [&str; 3] = ["x", "y", "z"];

/// The profiles that are measured in a run.
pub struct Profiles {
    all: Vec<DrawnProfile>,
    scale: Scale,
}

/// A profile and where it is drawn.
struct DrawnProfile {
    profile: GrainProfile,
    path: String,
}

/// A view of a profile.
pub enum ProfileView {
    /// A sheet, and the eye straight before it.
    Sheet {
        /// Name of the view.
        name: String,
        /// Entity.
        path: String,
        /// Eye.
        eye: Eye,
    },
    /// Bars.
    Bars {
        /// Name of the view.
        name: String,
        /// Entity.
        path: String,
    },
}

impl Profiles {
    /// Draws the shapes of the profiles that these streams bring.
    pub fn open(
        stream: &RecordingStream,
        scene: &Scene,
        frames: &[FrameStream],
    ) -> RecordingStreamResult<Self> {
        let is_sent = |profile: &&GrainProfile| {
            frames.iter().any(|f| f.content == FrameContent::Profile(profile.name.clone()))
        };
        let drawn = |profile: &GrainProfile| {
            let folder = if profile.axes.len() == 2 { "scene/profiles" } else { "profiles" };
            let path = format!("{folder}/{}", part(&profile.name));
            DrawnProfile { profile: profile.clone(), path }
        };
        let all: Vec<DrawnProfile> = scene.profiles.iter().filter(is_sent).map(drawn).collect();
        for sheet in all.iter().filter(|drawn| drawn.is_sheet()) {
            sheet.log_shape(stream)?;
        }
        if all.iter().any(DrawnProfile::is_sheet) {
            legend::SOLIDS.log_bar(stream, SHEET)?;
        }
        Ok(Self { all, scale: Scale::new(SHEET, Some(DENSE), None) })
    }

    /// True if there are sheets, which are coloured by solid fraction.
    pub fn has_sheets(&self) -> bool {
        self.all.iter().any(DrawnProfile::is_sheet)
    }

    /// Scale of the sheets.
    pub fn scale(&self) -> &Scale {
        &self.scale
    }

    /// Views of all; sheets are seen from the side of `towards`.
    pub fn views(&self, up: Vec3, towards: Vec3) -> Vec<ProfileView> {
        self.all.iter().flat_map(|drawn| drawn.views(up, towards)).collect()
    }

    /// Draws a table of the profile of a name.
    pub fn log(
        &self,
        stream: &RecordingStream,
        name: &str,
        bins: &[ProfileBin],
    ) -> RecordingStreamResult<()> {
        match self.all.iter().find(|drawn| drawn.profile.name == name) {
            Some(drawn) if drawn.is_sheet() => drawn.log_sheet(stream, bins, &self.scale),
            Some(drawn) => drawn.log_bars(stream, bins),
            None => Ok(()),
        }
    }
}

impl DrawnProfile {
    fn is_sheet(&self) -> bool {
        self.profile.axes.len() == 2
    }

    fn views(&self, up: Vec3, towards: Vec3) -> Vec<ProfileView> {
        let name = &self.profile.name;
        if !self.is_sheet() {
            let along = AXES[self.profile.axes[0].axis];
            let bars = BARS.map(|(quantity, words, unit)| ProfileView::Bars {
                name: format!("{name}: {words}{unit} over {along} [m]"),
                path: format!("{}/{quantity}", self.path),
            });
            return bars.into();
        }
        let name = format!("{name}: solid fraction");
        let corner = self.corner([0, 0]);
        let far = |k: usize| {
            let mut counts = [0, 0];
            counts[k] = self.profile.axes[k].bins;
            self.corner(counts) - corner
        };
        let eye = facing(corner, [far(0), far(1)], up, towards);
        vec![ProfileView::Sheet { name, path: self.path.clone(), eye }]
    }

    /// Where the edges of these numbers meet, in the middle of the box along the third axis.
    fn corner(&self, edges: [usize; 2]) -> Vec3 {
        let profile = &self.profile;
        let mut place = Vec3::from(profile.min).lerp(&profile.max.into(), 0.5);
        for (&along, edge) in profile.axes.iter().zip(edges) {
            place[along.axis] = profile.edge(along, edge);
        }
        place
    }

    /// A rectangle for each bin, so that colours end at its edges.
    fn log_shape(&self, stream: &RecordingStream) -> RecordingStreamResult<()> {
        let [m, n] = [0, 1].map(|k| self.profile.axes[k].bins);
        let bins = (0..m).flat_map(|i| (0..n).map(move |j| [i, j]));
        let corners = bins.flat_map(|[i, j]| [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]]);
        let places = corners.map(|edges| single(self.corner(edges)));
        let triangles = (0..(m * n) as u32).flat_map(|bin| {
            let k = 4 * bin;
            [[k, k + 1, k + 2], [k, k + 2, k + 3]]
        });
        let mesh =
            Mesh3D::update_fields().with_vertex_positions(places).with_triangle_indices(triangles);
        stream.log_static(self.path.as_str(), &mesh)
    }

    fn log_sheet(
        &self,
        stream: &RecordingStream,
        bins: &[ProfileBin],
        scale: &Scale,
    ) -> RecordingStreamResult<()> {
        let colour = |bin: &ProfileBin| match bin.solid_fraction {
            0.0 => AIR,
            fraction => scale.colour(fraction as f32),
        };
        let colours = bins.iter().flat_map(|bin| [Color::from_u32(colour(bin)); 4]);
        let mesh = Mesh3D::update_fields().with_vertex_colors(colours);
        stream.log(self.path.as_str(), &mesh)
    }

    /// Lower edges of the bars and their widths [m]: Rerun draws a bar from its abscissa upwards.
    fn bars(&self) -> (Vec<f64>, Vec<f32>) {
        let along = self.profile.axes[0];
        let edge = |k: usize| self.profile.edge(along, k);
        let width = |k: usize| (edge(k + 1) - edge(k)) as f32;
        ((0..along.bins).map(edge).collect(), (0..along.bins).map(width).collect())
    }

    fn log_bars(&self, stream: &RecordingStream, bins: &[ProfileBin]) -> RecordingStreamResult<()> {
        let (lower, widths) = self.bars();
        let axis = streamwise(bins);
        // A bin without grains has no bar.
        let shown = |value: f64| if value.is_finite() { value } else { 0.0 };
        for (quantity, ..) in BARS {
            let value = |bin: &ProfileBin| match quantity {
                "solid_fraction" => bin.solid_fraction,
                _ => shown(bin.velocity[axis]),
            };
            let values: Vec<f64> = bins.iter().map(value).collect();
            let chart =
                BarChart::new(values).with_abscissa(lower.clone()).with_widths(widths.clone());
            stream.log(format!("{}/{quantity}", self.path), &chart)?;
        }
        Ok(())
    }
}

/// What bars show: name of the entity, words, and unit.
const BARS: [(&str, &str, &str); 2] =
    [("solid_fraction", "solid fraction", ""), ("velocity", "streamwise velocity", " [m/s]")];

/// The axis along which grains are fastest, in the mean over the bins.
fn streamwise(bins: &[ProfileBin]) -> usize {
    let speed = |axis: &usize| -> f64 {
        let values = bins.iter().map(|bin| bin.velocity[*axis]);
        values.filter(|value| value.is_finite()).map(f64::abs).sum()
    };
    [2, 1, 0].into_iter().max_by(|a, b| speed(a).total_cmp(&speed(b))).unwrap_or(2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::scene::{BinnedAxis, ProfileVelocity};

    #[test]
    fn bars_fill_the_box_from_its_lower_to_its_upper_face() {
        let profile = GrainProfile {
            name: "across".into(),
            axes: vec![BinnedAxis { axis: 0, bins: 11 }],
            min: [0.0, 0.08, 0.0],
            max: [0.05, 0.12, 0.009],
            from: 0.0,
            every: None,
            average: None,
            velocity: ProfileVelocity::default(),
        };
        let (lower, widths) = DrawnProfile { profile, path: String::new() }.bars();
        let upper: Vec<f64> = lower.iter().zip(widths).map(|(x, w)| x + f64::from(w)).collect();
        assert_eq!((lower.len(), lower[0]), (11, 0.0));
        assert!((upper[10] - 0.05).abs() < 1e-8, "{}", upper[10]);
        assert!(lower[1..].iter().zip(&upper).all(|(x, end)| (x - end).abs() < 1e-8));
    }

    #[test]
    fn the_streamwise_axis_is_the_fastest() {
        let bin = |velocity| ProfileBin { velocity, ..ProfileBin::default() };
        let bins = [bin([f64::NAN; 3]), bin([0.1, -0.4, 0.2]), bin([0.1, -0.3, 0.3])];
        assert_eq!(streamwise(&bins), 1);
        assert_eq!(streamwise(&bins[..1]), 0, "any will do");
    }
}
