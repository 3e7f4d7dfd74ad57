//! Loads on bodies as arrows, and those on followed bodies as curves.
//!
//! An arrow begins at the body's reference point. Its length is the force over that of a scale that
//! both kinds share, so that they can be compared. Arrows of that force stand above the domain, with
//! the number. The scale follows the run: it is a force that most bodies stay below, since a few
//! contacts are far stronger than all others. Longer arrows are cut off at a few times that length, so
//! that a part, on which all grains lie, does not hide the scene.

use crate::parameters::{LoadKind, Parameters};
use crate::scale::{round_up, speed};
use crate::stage::number;
use crate::view::{centre, single, up, up_vector};
use rerun::components::Radius;
use rerun::{
    Arrows3D, Color, Points3D, RecordingStream, RecordingStreamResult, Scalars, SeriesLines,
};
use tremie_geometry::Vec3;
use tremie_messages::BodyEvent;
use tremie_messages::frame::LoadSample;
use tremie_messages::scene::Scene;

/// Entity of the arrows.
pub const PATH: &str = "scene/loads";
/// Entity of the curves of followed bodies.
pub const FOLLOWED: &str = "coupling/followed";

/// Length of the scale's arrow over the diagonal of the domain.
const REACH: f64 = 0.06;
/// Greatest length of an arrow over that.
const LONGEST: f32 = 4.0;
/// Forces below this share of the scale have no arrow: it would be a dot.
const LEAST: f32 = 0.02;
/// Share of the loads that stay below the force of the scale.
const BELOW: f64 = 0.8;
/// Share of the scale below which a run's forces make it fall, after so many frames.
const FALLS: f64 = 0.3;
const PATIENCE: u32 = 8;
/// Colours of curves, one for each followed body.
const CURVES: [[u8; 3]; 6] =
    [[86, 180, 233], [230, 159, 0], [0, 158, 115], [204, 121, 167], [240, 228, 66], [213, 94, 0]];

impl LoadKind {
    /// Its name, as in the manifest.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fluid => "fluid",
            Self::Contact => "contact",
        }
    }

    /// Colour of its arrows.
    pub fn colour(self) -> Color {
        match self {
            Self::Fluid => Color::from_rgb(86, 180, 233),
            Self::Contact => Color::from_rgb(240, 160, 40),
        }
    }

    fn force(self, load: &LoadSample) -> [f32; 3] {
        single(match self {
            Self::Fluid => load.fluid,
            Self::Contact => load.contact,
        })
    }
}

/// Draws loads.
pub struct Loads {
    kinds: Vec<LoadKind>,
    scale: ForceScale,
    /// Length of the scale's arrow [m].
    reach: f64,
    /// Where the scale's arrows begin, one for each kind, and their direction.
    legend: Vec<Vec3>,
    along: Vec3,
    /// Most bodies with arrows of a kind.
    most: usize,
    followed: Vec<u64>,
    begun: bool,
}

impl Loads {
    /// As the parameters ask for them.
    pub fn new(scene: &Scene, parameters: &Parameters) -> Self {
        let kinds = parameters.load_kinds();
        let size = Vec3::from(scene.domain.size());
        let (reach, up) = (REACH * size.norm(), up(scene).0);
        let across = [(up + 1) % 3, (up + 2) % 3];
        let along =
            Vec3::ith(if size[across[0]] >= size[across[1]] { across[0] } else { across[1] }, 1.0);
        let top = centre(scene) + up_vector(scene) * 0.5 * size[up];
        let place = |row: usize| {
            top + up_vector(scene) * (0.4 + 0.8 * row as f64) * reach - along * 1.8 * reach
        };
        Self {
            legend: (0..kinds.len()).map(place).collect(),
            kinds,
            scale: ForceScale::new(parameters.max_load.map(|force| force.0)),
            reach,
            along,
            most: parameters.load_arrows as usize,
            followed: parameters.followed.clone(),
            begun: false,
        }
    }

    /// True if there are arrows.
    pub fn are_drawn(&self) -> bool {
        !self.kinds.is_empty()
    }

    /// Draws one moment.
    pub fn log(
        &mut self,
        stream: &RecordingStream,
        loads: &[LoadSample],
    ) -> RecordingStreamResult<()> {
        let high = self.kinds.iter().map(|kind| high(*kind, loads)).fold(0.0, f64::max);
        if self.scale.follow(high) || !self.begun {
            self.log_legend(stream)?;
        }
        for kind in &self.kinds {
            self.log_arrows(stream, loads, *kind)?;
        }
        self.log_followed(stream, loads)?;
        self.begun = true;
        Ok(())
    }

    fn log_arrows(
        &self,
        stream: &RecordingStream,
        loads: &[LoadSample],
        kind: LoadKind,
    ) -> RecordingStreamResult<()> {
        // Of many bodies every so many, by their ids: the same ones from frame to frame. Parts are few.
        let stride = (loads.len().div_ceil(self.most.max(1)) as u64).max(1);
        let least = LEAST * self.scale.force as f32;
        let drawn = |load: &&LoadSample| {
            let is_picked = self.most > 0 && load.id.is_multiple_of(stride);
            (is_picked || load.shape == BodyEvent::PART) && speed(kind.force(load)) > least
        };
        let drawn: Vec<&LoadSample> = loads.iter().filter(drawn).collect();
        let stretch = (self.reach / self.scale.force) as f32;
        let vector = |load: &&LoadSample| arrow(kind.force(load), stretch, self.reach as f32);
        let arrows = Arrows3D::from_vectors(drawn.iter().map(vector))
            .with_origins(drawn.iter().map(|load| single(load.position)))
            .with_colors([kind.colour()])
            .with_radii([Radius::new_ui_points(1.0)]);
        stream.log(format!("{PATH}/{}", kind.name()), &arrows)
    }

    fn log_legend(&self, stream: &RecordingStream) -> RecordingStreamResult<()> {
        let text = |kind: &LoadKind| {
            let what = match kind {
                LoadKind::Fluid => "fluid, with buoyancy",
                LoadKind::Contact => "contacts",
            };
            format!("{what}: {} N", number(self.scale.force))
        };
        let vector = single(self.along * self.reach);
        let arrows = Arrows3D::from_vectors(self.kinds.iter().map(|_| vector))
            .with_origins(self.legend.iter().copied().map(single))
            .with_colors(self.kinds.iter().map(|kind| kind.colour()))
            .with_radii([Radius::new_ui_points(2.5)]);
        stream.log(format!("{PATH}/scale"), &arrows)?;
        let beside = |place: &Vec3| single(place + self.along * (2.6 * self.reach));
        let labels = Points3D::new(self.legend.iter().map(beside))
            .with_labels(self.kinds.iter().map(text))
            .with_show_labels(true)
            .with_radii([Radius::new_ui_points(0.0)])
            .with_colors([Color::from_rgb(245, 245, 245)]);
        stream.log(format!("{PATH}/scale/labels"), &labels)
    }

    fn log_followed(
        &self,
        stream: &RecordingStream,
        loads: &[LoadSample],
    ) -> RecordingStreamResult<()> {
        for (place, id) in self.followed.iter().enumerate() {
            let Ok(at) = loads.binary_search_by_key(id, |load| load.id) else { continue };
            for (kind, width) in [(LoadKind::Fluid, 1.2), (LoadKind::Contact, 2.4)] {
                let path = format!("{FOLLOWED}/{id}/{}", kind.name());
                if !self.begun {
                    let [r, g, b] = CURVES[place % CURVES.len()];
                    let style = SeriesLines::new()
                        .with_names([format!("{id} {}", kind.name())])
                        .with_colors([Color::from_rgb(r, g, b)])
                        .with_widths([width]);
                    stream.log_static(path.as_str(), &style)?;
                }
                let force = f64::from(speed(kind.force(&loads[at])));
                stream.log(path.as_str(), &Scalars::new([force]))?;
            }
        }
        Ok(())
    }
}

/// The force of the scale: round, and such that most arrows are shorter [N].
struct ForceScale {
    force: f64,
    fixed: bool,
    /// True once a frame had loads.
    begun: bool,
    /// Frames in a row whose loads were far below it.
    low: u32,
}

impl ForceScale {
    fn new(fixed: Option<f64>) -> Self {
        Self { force: fixed.unwrap_or(1e-6), fixed: fixed.is_some(), begun: false, low: 0 }
    }

    /// Takes a frame into account, most of whose loads are below `high`. Returns whether the scale changed.
    fn follow(&mut self, high: f64) -> bool {
        if self.fixed || !high.is_finite() || high <= 0.0 {
            return false;
        }
        self.low = if high < FALLS * self.force { self.low + 1 } else { 0 };
        if self.begun && high <= self.force && self.low < PATIENCE {
            return false;
        }
        let before = std::mem::replace(&mut self.force, round_up(high));
        (self.begun, self.low) = (true, 0);
        before != self.force
    }
}

/// The force of a kind that most loaded bodies stay below, parts left out [N].
fn high(kind: LoadKind, loads: &[LoadSample]) -> f64 {
    let bodies = loads.iter().filter(|load| load.shape != BodyEvent::PART);
    let sizes = bodies.map(|load| speed(kind.force(load)));
    let mut sizes: Vec<f32> = sizes.filter(|size| size.is_finite() && *size > 0.0).collect();
    if sizes.is_empty() {
        return 0.0;
    }
    let place = (sizes.len() as f64 * BELOW) as usize;
    let place = place.min(sizes.len() - 1);
    f64::from(*sizes.select_nth_unstable_by(place, f32::total_cmp).1)
}

/// An arrow along a force, `stretch` times as long, but not too long.
fn arrow(force: [f32; 3], stretch: f32, reach: f32) -> [f32; 3] {
    let length = speed(force) * stretch;
    let shrink = if length > LONGEST * reach { LONGEST * reach / length } else { 1.0 };
    force.map(|x| x * stretch * shrink)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_grows_at_once_and_falls_after_some_frames() {
        let mut scale = ForceScale::new(None);
        assert!(scale.follow(0.7) && !scale.follow(0.4));
        assert_eq!(scale.force, 1.0);
        assert!(scale.follow(3.0));
        assert_eq!(scale.force, 5.0);
        assert!(!(1..PATIENCE).any(|_| scale.follow(0.1)));
        assert!(scale.follow(0.1));
        assert!((scale.force / 0.1 - 1.0).abs() < 1e-12);
        let mut fixed = ForceScale::new(Some(2.0));
        assert!(!fixed.follow(9.0));
        assert_eq!(fixed.force, 2.0);
    }

    #[test]
    fn a_few_strong_contacts_do_not_make_the_scale() {
        let load = |id: u64, force: f64| LoadSample {
            id,
            contact: [0.0, 0.0, force],
            shape: BodyEvent::SPHERE,
            ..LoadSample::default()
        };
        let mut loads: Vec<_> = (0..95).map(|id| load(id, 1e-3)).collect();
        loads.extend((95..100).map(|id| load(id, 1.0)));
        loads.push(LoadSample { shape: BodyEvent::PART, ..load(100, 50.0) });
        assert!((high(LoadKind::Contact, &loads) / 1e-3 - 1.0).abs() < 1e-6);
        assert_eq!(high(LoadKind::Fluid, &loads), 0.0);
    }

    #[test]
    fn arrows_are_as_long_as_the_force_up_to_a_limit() {
        assert_eq!(arrow([0.0, 0.0, 2.0], 0.5, 1.0), [0.0, 0.0, 1.0]);
        assert_eq!(arrow([0.0, 100.0, 0.0], 0.5, 1.0), [0.0, 4.0, 0.0]);
    }
}
