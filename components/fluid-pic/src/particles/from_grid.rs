//! From the grid to particles, and the particles' motion.

use crate::grid::near_rows::NearRows;
use crate::grid::staggered_grid::StaggeredGrid;
use crate::particles::hat_weights::HatWeights;
use crate::particles::particle_arrays::{ParticleArrays, Transfer};
use tremie_team::instructions::Work;
use tremie_team::{Cut, Team, Variant};

/// Particles that are one piece of work.
pub const PIECE: usize = 2048;

/// Velocities on faces.
pub type FaceVelocity<const D: usize> = [Vec<f64>; D];

/// What a particle takes of the faces across an axis where its step begins: the velocity at the
/// step's end [m/s], its change in the step [m/s], and the displacement that keeps the volume [m].
/// The fourth number is 0: a face's values are one vector of the processor's.
pub type StartValues = Vec<[f64; 4]>;

/// Brings together what particles take where their step begins.
pub fn gather_start_values<const D: usize>(
    team: &mut Team,
    near: &NearRows,
    [before, after, shift]: [&FaceVelocity<D>; 3],
    start: &mut [StartValues; D],
) {
    team.for_pieces(Cut::every(start, 1), |a, start: &mut [StartValues]| {
        let start = &mut start[0];
        start.resize(after[a].len(), [0.0; 4]);
        for at in near.touched().flatten() {
            start[at] = [after[a][at], after[a][at] - before[a][at], shift[a][at], 0.0];
        }
    });
}

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
#[derive(Clone, Copy, Debug)]
pub struct ParticleMotion<'a, const D: usize> {
    /// The grid.
    pub grid: &'a StaggeredGrid<D>,
    /// The grid's velocity at the end of the step.
    pub after: &'a FaceVelocity<D>,
    /// That and more, where the step begins.
    pub start: &'a [StartValues; D],
    /// Transfer of velocities.
    pub transfer: Transfer,
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

/// The particles of a piece: velocities are taken, positions moved, or both.
struct PiecePass<'a, const TAKES: bool, const MOVES: bool, const D: usize> {
    motion: &'a ParticleMotion<'a, D>,
    first: usize,
    position: [&'a mut [f64]; D],
    velocity: [&'a mut [f64]; D],
}

impl<const TAKES: bool, const MOVES: bool, const D: usize> Work for PiecePass<'_, TAKES, MOVES, D> {
    #[inline(always)]
    fn run(self) {
        let Self { motion, first, position, velocity } = self;
        for k in 0..position[0].len() {
            let mut at = [0.0; D];
            let mut own = [0.0; D];
            for a in 0..D {
                (at[a], own[a]) = (position[a][k], velocity[a][k]);
            }
            let end = if motion.is_adrift[first + k] {
                motion.flown::<TAKES, MOVES>(at, &mut own)
            } else {
                motion.carried::<TAKES, MOVES>(at, &mut own)
            };
            for a in 0..D {
                velocity[a][k] = own[a];
                if MOVES {
                    position[a][k] = end[a];
                }
            }
        }
    }
}

/// The particles of a piece take the gradients of the velocity along an axis.
struct PieceGradients<'a, const D: usize> {
    motion: &'a ParticleMotion<'a, D>,
    axis: usize,
    first: usize,
    position: &'a [Vec<f64>; D],
    gradient: [&'a mut [f64]; D],
}

impl<const D: usize> Work for PieceGradients<'_, D> {
    #[inline(always)]
    fn run(self) {
        let Self { motion, axis, first, position, gradient } = self;
        for k in 0..gradient[0].len() {
            let particle = first + k;
            let mut at = [0.0; D];
            (0..D).for_each(|a| at[a] = position[a][particle]);
            let around = HatWeights::new(motion.grid, Some(axis), at);
            let slope = around.gradient(motion.grid, &motion.after[axis]);
            for a in 0..D {
                gradient[a][k] = if motion.is_adrift[particle] { 0.0 } else { slope[a] };
            }
        }
    }
}

impl<const D: usize> ParticleMotion<'_, D> {
    /// Gives particles velocities, and moves them.
    pub fn carry(&self, team: &mut Team, variant: Variant, particles: &mut ParticleArrays<D>) {
        self.take_gradients(team, variant, particles);
        self.pass::<true, true>(team, variant, particles);
    }

    /// Gives particles velocities.
    pub fn take_velocities(
        &self,
        team: &mut Team,
        variant: Variant,
        particles: &mut ParticleArrays<D>,
    ) {
        self.take_gradients(team, variant, particles);
        self.pass::<true, false>(team, variant, particles);
    }

    /// Moves particles through the velocity at the end of the step by Ralston's Runge-Kutta method
    /// of third order, and keeps them in the box.
    pub fn advect(&self, team: &mut Team, variant: Variant, particles: &mut ParticleArrays<D>) {
        self.pass::<false, true>(team, variant, particles);
    }

    /// Goes through the particles once: velocities are taken, positions moved, or both.
    fn pass<const TAKES: bool, const MOVES: bool>(
        &self,
        team: &mut Team,
        variant: Variant,
        particles: &mut ParticleArrays<D>,
    ) {
        let ParticleArrays { position, velocity, .. } = particles;
        team.for_pieces((cut(position), cut(velocity)), |piece, (position, velocity)| {
            let first = piece * PIECE;
            let motion = self;
            variant.run(PiecePass::<TAKES, MOVES, D> { motion, first, position, velocity });
        });
    }

    /// The gradients of the velocity, where particles have them.
    fn take_gradients(&self, team: &mut Team, variant: Variant, particles: &mut ParticleArrays<D>) {
        if self.transfer != Transfer::Affine {
            return;
        }
        let ParticleArrays { position, gradient, .. } = particles;
        let (position, count) = (&*position, position[0].len());
        for (axis, gradient) in gradient.iter_mut().enumerate() {
            gradient.iter_mut().for_each(|along| along.resize(count, 0.0));
            team.for_pieces(cut(gradient), |piece, gradient: [&mut [f64]; D]| {
                let (motion, first) = (self, piece * PIECE);
                variant.run(PieceGradients { motion, axis, first, position, gradient });
            });
        }
    }

    /// Where a particle comes that flies by itself. What meets a wall of the box stays there.
    #[inline(always)]
    fn flown<const TAKES: bool, const MOVES: bool>(
        &self,
        start: [f64; D],
        own: &mut [f64; D],
    ) -> [f64; D] {
        if TAKES {
            (0..D).for_each(|a| own[a] += self.fall[a]);
        }
        if !MOVES {
            return start;
        }
        let end: [f64; D] = std::array::from_fn(|a| start[a] + self.dt * own[a]);
        let kept = self.inside(end);
        for a in 0..D {
            if kept[a] != end[a] && !self.grid.periodic[a] {
                own[a] = 0.0;
            }
        }
        kept
    }

    #[inline(always)]
    fn inside(&self, point: [f64; D]) -> [f64; D] {
        std::array::from_fn(|a| {
            if self.grid.periodic[a] {
                self.grid.wrapped_along(a, point[a])
            } else {
                point[a].clamp(self.lower[a], self.upper[a])
            }
        })
    }

    /// Where the flow carries a particle.
    #[inline(always)]
    fn carried<const TAKES: bool, const MOVES: bool>(
        &self,
        start: [f64; D],
        own: &mut [f64; D],
    ) -> [f64; D] {
        let Self { grid, after, dt, .. } = *self;
        let (mut k1, mut apart) = ([0.0; D], [0.0; D]);
        for a in 0..D {
            let around = HatWeights::new(grid, Some(a), start);
            let [new, change, shift, _] = around.values(grid, &self.start[a]);
            (k1[a], apart[a]) = (new, shift);
            if TAKES {
                own[a] = match self.transfer {
                    Transfer::Blend { pic } => (1.0 - pic) * (own[a] + change) + pic * new,
                    Transfer::Affine => new,
                };
            }
        }
        if !MOVES {
            return start;
        }
        let shifted = |by: f64, k: [f64; D]| -> [f64; D] {
            self.inside(std::array::from_fn(|a| start[a] + by * k[a]))
        };
        let k2 = velocity_at(grid, after, shifted(0.5 * dt, k1));
        let k3 = velocity_at(grid, after, shifted(0.75 * dt, k2));
        let mut end = start;
        for a in 0..D {
            end[a] += dt * (2.0 * k1[a] + 3.0 * k2[a] + 4.0 * k3[a]) / 9.0 + apart[a];
        }
        self.inside(end)
    }
}
