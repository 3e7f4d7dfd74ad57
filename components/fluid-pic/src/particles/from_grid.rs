//! From the grid to particles, and the particles' motion.

use crate::grid::staggered_grid::StaggeredGrid;
use crate::particles::hat_weights::HatWeights;
use crate::particles::particle_arrays::{ParticleArrays, Transfer};
use tremie_team::{Cut, Team};

/// Particles that are one piece of work.
pub const PIECE: usize = 2048;

/// Velocities on faces.
pub type FaceVelocity<const D: usize> = [Vec<f64>; D];

/// The arrays of a vector, in pieces.
fn cut<const D: usize>(arrays: &mut [Vec<f64>; D]) -> [Cut<'_, f64>; D] {
    arrays.each_mut().map(|array| Cut::every(array, PIECE))
}

/// Velocity at a point [m/s].
#[inline(always)]
pub fn velocity_at<const D: usize>(
    grid: &StaggeredGrid<D>,
    u: &FaceVelocity<D>,
    point: [f64; D],
) -> [f64; D] {
    let mut velocity = [0.0; D];
    for a in 0..D {
        velocity[a] = HatWeights::new(grid, Some(a), point).value(grid, &u[a]);
    }
    velocity
}

/// What particles move by in a step.
#[derive(Clone, Copy)]
pub struct ParticleMotion<'a, const D: usize> {
    /// The grid.
    pub grid: &'a StaggeredGrid<D>,
    /// The grid's velocity as it came from the particles.
    pub before: &'a FaceVelocity<D>,
    /// The grid's velocity at the end of the step.
    pub after: &'a FaceVelocity<D>,
    /// Displacement on faces that keeps the volume [m].
    pub shift: &'a FaceVelocity<D>,
    /// Particles that fly by themselves.
    pub is_adrift: &'a [bool],
    /// Step [s].
    pub dt: f64,
    /// Change of the velocity of those that fly [m/s].
    pub fall: [f64; D],
    /// Lower corner of the box that particles stay in [m].
    pub lower: [f64; D],
    /// Upper corner [m].
    pub upper: [f64; D],
}

impl<const D: usize> ParticleMotion<'_, D> {
    /// Gives particles velocities.
    pub fn take_velocities(
        &self,
        team: &mut Team,
        transfer: Transfer,
        particles: &mut ParticleArrays<D>,
    ) {
        let Self { grid, is_adrift, .. } = *self;
        let ParticleArrays { position, velocity, gradient, .. } = particles;
        let count = position[0].len();
        let at = |particle: usize| -> [f64; D] { std::array::from_fn(|a| position[a][particle]) };
        for axis in 0..D {
            let (before, after) = (&self.before[axis], &self.after[axis]);
            let fall = self.fall[axis];
            let velocity = &mut velocity[axis];
            team.for_pieces(Cut::every(velocity, PIECE), |piece, velocity: &mut [f64]| {
                for (k, own) in velocity.iter_mut().enumerate() {
                    let particle = piece * PIECE + k;
                    if is_adrift[particle] {
                        *own += fall;
                        continue;
                    }
                    let around = HatWeights::new(grid, Some(axis), at(particle));
                    let new = around.value(grid, after);
                    *own = match transfer {
                        Transfer::Blend { pic } => {
                            let old = around.value(grid, before);
                            (1.0 - pic) * (*own + new - old) + pic * new
                        }
                        Transfer::Affine => new,
                    };
                }
            });
            if transfer != Transfer::Affine {
                continue;
            }
            for (a, gradient) in gradient[axis].iter_mut().enumerate() {
                gradient.resize(count, 0.0);
                team.for_pieces(Cut::every(gradient, PIECE), |piece, gradient: &mut [f64]| {
                    for (k, own) in gradient.iter_mut().enumerate() {
                        let particle = piece * PIECE + k;
                        let around = HatWeights::new(grid, Some(axis), at(particle));
                        let slope = around.gradient(grid, after)[a];
                        *own = if is_adrift[particle] { 0.0 } else { slope };
                    }
                });
            }
        }
    }

    /// Moves particles through the velocity at the end of the step by Ralston's Runge-Kutta method
    /// of third order, and keeps them in the box.
    pub fn advect(&self, team: &mut Team, particles: &mut ParticleArrays<D>) {
        let ParticleArrays { position, velocity, .. } = particles;
        team.for_pieces(
            (cut(position), cut(velocity)),
            |piece, (position, velocity): ([&mut [f64]; D], [&mut [f64]; D])| {
                for k in 0..position[0].len() {
                    let start = std::array::from_fn(|a| position[a][k]);
                    if !self.is_adrift[piece * PIECE + k] {
                        let end = self.carried(start);
                        (0..D).for_each(|a| position[a][k] = end[a]);
                        continue;
                    }
                    let end = std::array::from_fn(|a| start[a] + self.dt * velocity[a][k]);
                    let kept = self.inside(end);
                    for a in 0..D {
                        // What meets a wall of the box stays there.
                        if kept[a] != end[a] && !self.grid.periodic[a] {
                            velocity[a][k] = 0.0;
                        }
                        position[a][k] = kept[a];
                    }
                }
            },
        );
    }

    fn inside(&self, point: [f64; D]) -> [f64; D] {
        std::array::from_fn(|a| {
            if self.grid.periodic[a] {
                self.grid.wrapped_along(a, point[a])
            } else {
                point[a].clamp(self.lower[a], self.upper[a])
            }
        })
    }

    /// Where the flow carries a point.
    #[inline(always)]
    fn carried(&self, start: [f64; D]) -> [f64; D] {
        let Self { grid, after, dt, .. } = *self;
        let shifted = |by: f64, k: [f64; D]| -> [f64; D] {
            self.inside(std::array::from_fn(|a| start[a] + by * k[a]))
        };
        let k1 = velocity_at(grid, after, start);
        let k2 = velocity_at(grid, after, shifted(0.5 * dt, k1));
        let k3 = velocity_at(grid, after, shifted(0.75 * dt, k2));
        let apart = velocity_at(grid, self.shift, start);
        let mut end = start;
        for a in 0..D {
            end[a] += dt * (2.0 * k1[a] + 3.0 * k2[a] + 4.0 * k3[a]) / 9.0 + apart[a];
        }
        self.inside(end)
    }
}
