//! Spheres whose motion is prescribed by points in time.

use crate::bodies::body_arrays::{Bodies, PlacedSphere, Twist};
use tremie_grains_kit::motion::prescribed_motion::Path;
use tremie_messages::scene::{Motion, Scene};
use tremie_state::{StateError, StateExchange};

/// Paths, and the spheres that follow them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Driven {
    paths: Vec<Path>,
    /// Rank of the body and index of its path.
    followers: Vec<(u32, u32)>,
}

impl Driven {
    /// Keeps which bodies follow which path, or puts it back.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.value("followers", &mut self.followers)
    }

    /// The spheres of sets with points; those without keep their velocity as free ones do.
    pub fn of_scene(scene: &Scene, spheres: &[PlacedSphere]) -> Self {
        let mut driven = Self::default();
        let mut path_of = vec![None; scene.bodies.len()];
        for (set, bodies) in scene.bodies.iter().enumerate() {
            if let Motion::Prescribed(points) = &bodies.motion
                && !points.is_empty()
            {
                path_of[set] = Some(driven.paths.len() as u32);
                driven.paths.push(Path::new(points, Twist::zero()));
            }
        }
        for (rank, sphere) in (0..).zip(spheres) {
            let path = match &scene.bodies[sphere.set].motion {
                // Each has velocities of its own.
                Motion::Timed(timed) => {
                    driven.paths.push(Path::of_factor(sphere.twist, &timed.course));
                    Some(driven.paths.len() as u32 - 1)
                }
                _ => path_of[sphere.set],
            };
            driven.followers.extend(path.map(|path| (rank, path)));
        }
        driven
    }

    /// Forgets the bodies of the ranks `gone`, which ascend; the others move up.
    pub fn remove(&mut self, gone: &[u32]) {
        self.followers.retain_mut(|(rank, _)| match gone.binary_search(rank) {
            Ok(_) => false,
            Err(before) => {
                *rank -= before as u32;
                true
            }
        });
    }

    /// Gives them the mean velocities of a step.
    pub fn begin(&self, bodies: &mut Bodies, from: f64, to: f64) {
        for &(rank, path) in &self.followers {
            let mean = self.paths[path as usize].travelled(from, to);
            let scale = 1.0 / (to - from);
            bodies.twists[bodies.slot[rank as usize] as usize] =
                Twist { v: mean.v * scale, w: mean.w * scale };
        }
    }

    /// Gives them the velocities of a time.
    pub fn end(&self, bodies: &mut Bodies, time: f64) {
        for &(rank, path) in &self.followers {
            let slot = bodies.slot[rank as usize] as usize;
            let twist = self.paths[path as usize].twist(time);
            bodies.twists[slot] = twist;
            bodies.predicted[slot] = twist;
        }
    }
}
