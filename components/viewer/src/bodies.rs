//! Bodies as spheres coloured by their speed; in a plane scene as cylinders.

use crate::scale::{GREY, Scale, speed};
use crate::session::REPEAT;
use crate::view::{part, single};
use rerun::components::FillMode;
use rerun::external::arrow::array::UInt64Array;
use rerun::{
    AnyValues, AsComponents, Color, Cylinders3D, Points3D, RecordingStream, RecordingStreamResult,
};
use std::sync::Arc;
use tremie_messages::BodyEvent;
use tremie_messages::frame::BodySample;
use tremie_messages::scene::Scene;

/// Draws bodies, a set at a time.
pub struct Bodies {
    sets: Vec<RoundSet>,
}

/// A body set as it was last drawn.
struct RoundSet {
    path: String,
    /// Length of its cylinders, and the turn that takes z to their axis; none of spheres.
    cylinders: Option<(f32, [f32; 4])>,
    radii: Vec<f32>,
    /// Ids of its bodies, which a viewer shows for the one that is hovered over or selected.
    ids: Vec<u64>,
    ids_age: u32,
    age: u32,
    shown: bool,
}

impl Bodies {
    /// For the body sets of a scene.
    pub fn new(scene: &Scene) -> Self {
        let path = |name: &str| format!("scene/bodies/{}", part(name));
        let cylinders = scene.domain.across.zip(scene.domain.depth());
        let cylinders = cylinders.map(|(axis, depth)| (depth as f32, to_axis(axis)));
        let set = |name: &str| RoundSet::new(path(name), cylinders);
        Self { sets: scene.bodies.iter().map(|own| set(&own.name)).collect() }
    }

    /// Draws one moment.
    pub fn log(
        &mut self,
        stream: &RecordingStream,
        bodies: &[BodySample],
        scale: &Scale,
    ) -> RecordingStreamResult<()> {
        for (k, set) in self.sets.iter_mut().enumerate() {
            let own = |body: &&BodySample| body.set == k as u32 && is_round(body);
            set.log(stream, bodies.iter().filter(own), scale)?;
        }
        Ok(())
    }
}

/// Speeds of bodies that can move [m/s].
pub fn speeds(bodies: &[BodySample]) -> Vec<f32> {
    bodies
        .iter()
        .filter(|body| !is_fixed(body) && is_round(body))
        .map(|body| speed(single(body.state.velocity)))
        .collect()
}

fn is_fixed(body: &BodySample) -> bool {
    body.motion == BodyEvent::FIXED
}

fn is_round(body: &BodySample) -> bool {
    matches!(body.shape, BodyEvent::SPHERE | BodyEvent::CYLINDER)
}

impl RoundSet {
    fn new(path: String, cylinders: Option<(f32, [f32; 4])>) -> Self {
        Self {
            path,
            cylinders,
            radii: Vec::new(),
            ids: Vec::new(),
            ids_age: 0,
            age: 0,
            shown: false,
        }
    }

    fn log<'a>(
        &mut self,
        stream: &RecordingStream,
        bodies: impl Iterator<Item = &'a BodySample> + Clone,
        scale: &Scale,
    ) -> RecordingStreamResult<()> {
        let radii = compact(bodies.clone().map(|body| body.radius as f32).collect());
        if radii.is_empty() && !self.shown {
            return Ok(());
        }
        self.shown = !radii.is_empty();
        let ids = self.ids(bodies.clone());
        if let Some((length, turn)) = self.cylinders {
            let cylinders = Cylinders3D::from_lengths_and_radii([length], radii)
                .with_centers(bodies.clone().map(|body| single(body.state.position)))
                .with_quaternions([turn])
                .with_colors(bodies.map(|body| Color::from_u32(colour(body, scale))))
                .with_fill_mode(FillMode::Solid);
            return stream.log(self.path.as_str(), &both(&cylinders, &ids));
        }
        let mut points = Points3D::update_fields()
            .with_positions(bodies.clone().map(|body| single(body.state.position)))
            .with_colors(bodies.map(|body| Color::from_u32(colour(body, scale))));
        self.age += 1;
        if radii != self.radii || self.age >= REPEAT {
            points = points.with_radii(radii.iter().copied());
            self.radii = radii;
            self.age = 0;
        }
        stream.log(self.path.as_str(), &both(&points, &ids))
    }

    /// The ids, where they are others than before, and now and then.
    fn ids<'a>(&mut self, bodies: impl Iterator<Item = &'a BodySample> + Clone) -> AnyValues {
        let is_same = self.ids.iter().copied().eq(bodies.clone().map(|body| body.state.id));
        self.ids_age += 1;
        if is_same && self.ids_age < REPEAT {
            return AnyValues::default();
        }
        self.ids = bodies.map(|body| body.state.id).collect();
        self.ids_age = 0;
        let ids = Arc::new(UInt64Array::from(self.ids.clone()));
        AnyValues::default().with_component_from_data("id", ids)
    }
}

/// A shape with the ids of its bodies, in one row.
fn both<'a>(shape: &'a dyn AsComponents, ids: &'a AnyValues) -> [&'a dyn AsComponents; 2] {
    [shape, ids]
}

/// The turn that takes z to an axis, a unit quaternion.
fn to_axis(axis: usize) -> [f32; 4] {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    [[0.0, half, 0.0, half], [-half, 0.0, 0.0, half], [0.0, 0.0, 0.0, 1.0]][axis]
}

fn colour(body: &BodySample, scale: &Scale) -> u32 {
    if is_fixed(body) { GREY } else { scale.colour(speed(single(body.state.velocity))) }
}

/// One radius for all, if all are alike: Rerun repeats the last one.
fn compact(mut radii: Vec<f32>) -> Vec<f32> {
    if radii.windows(2).all(|pair| pair[0] == pair[1]) {
        radii.truncate(1);
    }
    radii
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_radii_are_sent_once() {
        assert_eq!(compact(vec![1.0, 1.0, 1.0]), [1.0]);
        assert_eq!(compact(vec![1.0, 2.0]), [1.0, 2.0]);
        assert!(compact(Vec::new()).is_empty());
    }
}
