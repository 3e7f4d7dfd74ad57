//! From the grid to particles, and the particles' motion.

use crate::grid::staggered_grid::StaggeredGrid;
use crate::particles::hat_weights::HatWeights;
use crate::particles::particle_arrays::{ParticleArrays, Transfer};
use tremie_team::{Cut, Team};

/// Particles that are one piece of work.
const PIECE: usize = 2048;

/// Velocities on faces.
pub type FaceVelocity<const D: usize> = [Vec<f64>; D];

/// Velocity at a point [m/s].
#[inline(always)]
pub fn velocity_at<const D: usize>(
    grid: &StaggeredGrid<D>,
    u: &FaceVelocity<D>,
    point: [f64; D],
) -> [f64; D] {
    std::array::from_fn(|a| HatWeights::new(grid, Some(a), point).value(grid, &u[a]))
}

/// Gives particles velocities. `before` is the grid's velocity as it came from them, `after` that
/// at the end of the step.
pub fn take_velocities<const D: usize>(
    grid: &StaggeredGrid<D>,
    team: &mut Team,
    transfer: Transfer,
    before: &FaceVelocity<D>,
    after: &FaceVelocity<D>,
    particles: &mut ParticleArrays<D>,
) {
    let ParticleArrays { position, velocity, gradient, .. } = particles;
    let count = position[0].len();
    let at = |particle: usize| -> [f64; D] { std::array::from_fn(|a| position[a][particle]) };
    for axis in 0..D {
        let (before, after) = (&before[axis], &after[axis]);
        let velocity = &mut velocity[axis];
        match transfer {
            Transfer::Blend { pic } => {
                team.for_pieces(Cut::every(velocity, PIECE), |piece, velocity: &mut [f64]| {
                    for (k, own) in velocity.iter_mut().enumerate() {
                        let around = HatWeights::new(grid, Some(axis), at(piece * PIECE + k));
                        let (old, new) = (around.value(grid, before), around.value(grid, after));
                        *own = (1.0 - pic) * (*own + new - old) + pic * new;
                    }
                });
            }
            Transfer::Affine => {
                for (k, own) in velocity.iter_mut().enumerate() {
                    *own = HatWeights::new(grid, Some(axis), at(k)).value(grid, after);
                }
                gradient[axis].iter_mut().for_each(|gradient| gradient.resize(count, 0.0));
                for k in 0..count {
                    let slope = HatWeights::new(grid, Some(axis), at(k)).gradient(grid, after);
                    for a in 0..D {
                        gradient[axis][a][k] = slope[a];
                    }
                }
            }
        }
    }
}

/// Moves particles through a velocity by Ralston's Runge-Kutta method of third order, and keeps
/// them within `lower` and `upper`.
pub fn advect<const D: usize>(
    grid: &StaggeredGrid<D>,
    u: &FaceVelocity<D>,
    dt: f64,
    lower: [f64; D],
    upper: [f64; D],
    particles: &mut ParticleArrays<D>,
) {
    let inside = |point: [f64; D]| -> [f64; D] {
        std::array::from_fn(|a| {
            let length = upper[a] - lower[a];
            if grid.periodic[a] {
                lower[a] + (point[a] - lower[a]).rem_euclid(length)
            } else {
                point[a].clamp(lower[a], upper[a])
            }
        })
    };
    let shifted = |point: [f64; D], by: f64, k: [f64; D]| -> [f64; D] {
        inside(std::array::from_fn(|a| point[a] + by * k[a]))
    };
    for particle in 0..particles.len() {
        let start = particles.at(particle);
        let k1 = velocity_at(grid, u, start);
        let k2 = velocity_at(grid, u, shifted(start, 0.5 * dt, k1));
        let k3 = velocity_at(grid, u, shifted(start, 0.75 * dt, k2));
        let mean = std::array::from_fn(|a| (2.0 * k1[a] + 3.0 * k2[a] + 4.0 * k3[a]) / 9.0);
        let end = shifted(start, dt, mean);
        for a in 0..D {
            particles.position[a][particle] = end[a];
        }
    }
}
