//! Bodies as spheres coloured by their speed.

use crate::scale::{GREY, Scale, speed};
use crate::view::{part, single};
use rerun::{Color, Points3D, RecordingStream, RecordingStreamResult};
use tremie_messages::BodyEvent;
use tremie_messages::frame::BodySample;
use tremie_messages::scene::Scene;

/// Frames after which radii are sent again although they did not change: a server that drops its
/// oldest frames must not lose the only copy.
const REPEAT: u32 = 64;

/// Draws bodies, a set at a time.
pub struct Bodies {
    sets: Vec<SphereSet>,
}

/// A body set as it was last drawn.
struct SphereSet {
    path: String,
    radii: Vec<f32>,
    age: u32,
    shown: bool,
}

impl Bodies {
    /// For the body sets of a scene.
    pub fn new(scene: &Scene) -> Self {
        let path = |name: &str| format!("scene/bodies/{}", part(name));
        Self { sets: scene.bodies.iter().map(|set| SphereSet::new(path(&set.name))).collect() }
    }

    /// Draws one moment.
    pub fn log(
        &mut self,
        stream: &RecordingStream,
        bodies: &[BodySample],
        scale: &Scale,
    ) -> RecordingStreamResult<()> {
        for (k, set) in self.sets.iter_mut().enumerate() {
            let own = |body: &&BodySample| body.set == k as u32 && is_sphere(body);
            set.log(stream, bodies.iter().filter(own), scale)?;
        }
        Ok(())
    }
}

/// Speeds of bodies that can move [m/s].
pub fn speeds(bodies: &[BodySample]) -> Vec<f32> {
    bodies
        .iter()
        .filter(|body| !is_fixed(body) && is_sphere(body))
        .map(|body| speed(single(body.state.velocity)))
        .collect()
}

fn is_fixed(body: &BodySample) -> bool {
    body.motion == BodyEvent::FIXED
}

fn is_sphere(body: &BodySample) -> bool {
    body.shape == BodyEvent::SPHERE
}

impl SphereSet {
    fn new(path: String) -> Self {
        Self { path, radii: Vec::new(), age: 0, shown: false }
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
        let mut points = Points3D::update_fields()
            .with_positions(bodies.clone().map(|body| single(body.state.position)))
            .with_colors(bodies.map(|body| Color::from_u32(colour(body, scale))));
        self.age += 1;
        if radii != self.radii || self.age >= REPEAT {
            points = points.with_radii(radii.iter().copied());
            self.radii = radii;
            self.age = 0;
        }
        stream.log(self.path.as_str(), &points)
    }
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
