//! From the grid to particles, and the particles' motion.

use crate::grid::near_rows::NearRows;
use crate::grid::staggered_grid::StaggeredGrid;
use crate::particles::hat_weights::HatWeights;
use crate::particles::lane_weights::{LaneWeights, load_points};
use crate::particles::particle_arrays::{ParticleArrays, Transfer};
use tremie_team::instructions::{VectorWork, Work};
use tremie_team::{Cut, SimdGather, Team, Variant};

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

/// What each of a few particles takes of the faces across each axis where its step begins:
/// [`StartValues`], interpolated.
type TakenAtStart<const D: usize> = [[[f64; 4]; 8]; D];

impl<const TAKES: bool, const MOVES: bool, const D: usize> VectorWork
    for PiecePass<'_, TAKES, MOVES, D>
{
    #[inline(always)]
    unsafe fn run<V: SimdGather>(mut self) {
        let count = self.position[0].len();
        for first in (0..count).step_by(V::N) {
            // SAFETY: by contract.
            unsafe { self.side_by_side::<V>(first, V::N.min(count - first)) };
        }
    }
}

impl<const TAKES: bool, const MOVES: bool, const D: usize> PiecePass<'_, TAKES, MOVES, D> {
    /// `count` particles from one on, side by side.
    ///
    /// # Safety
    /// The processor has the instructions of `V`.
    #[inline(always)]
    unsafe fn side_by_side<V: SimdGather>(&mut self, first: usize, count: usize) {
        let motion = self.motion;
        let position = self.position.each_ref().map(|along| &**along);
        let mut end = [[0.0; 8]; D];
        // SAFETY: by contract; no vector has more than eight lanes.
        unsafe {
            let at = load_points::<V, D>(position, first, count);
            let taken = self.take_at_start(at, first, count);
            if MOVES {
                let moved = motion.carried(at, &taken);
                for a in 0..D {
                    moved[a].store(end[a].as_mut_ptr());
                }
            }
        }
        for lane in 0..count {
            let particle = first + lane;
            if motion.is_adrift[self.first + particle] {
                self.fly(particle);
            } else if MOVES {
                (0..D).for_each(|a| self.position[a][particle] = end[a][lane]);
            }
        }
    }

    /// What particles take where they are. Those that fly keep their velocity.
    ///
    /// # Safety
    /// The processor has the instructions of `V`.
    #[inline(always)]
    unsafe fn take_at_start<V: SimdGather>(
        &mut self,
        at: [V; D],
        first: usize,
        count: usize,
    ) -> TakenAtStart<D> {
        let motion = self.motion;
        let mut taken = [[[0.0; 4]; 8]; D];
        for a in 0..D {
            // SAFETY: by contract.
            let around = unsafe { LaneWeights::new(motion.grid, Some(a), at) }.one_by_one();
            for lane in 0..count {
                taken[a][lane] = around.of(lane).values(motion.grid, &motion.start[a]);
            }
            for lane in 0..if TAKES { count } else { 0 } {
                let [new, change, ..] = taken[a][lane];
                let own = &mut self.velocity[a][first + lane];
                if !motion.is_adrift[self.first + first + lane] {
                    *own = match motion.transfer {
                        Transfer::Blend { pic } => (1.0 - pic) * (*own + change) + pic * new,
                        Transfer::Affine => new,
                    };
                }
            }
        }
        taken
    }

    /// A particle flies by itself. What meets a wall of the box stays there.
    #[inline(always)]
    fn fly(&mut self, particle: usize) {
        let motion = self.motion;
        for a in 0..D {
            let own = &mut self.velocity[a][particle];
            *own += if TAKES { motion.fall[a] } else { 0.0 };
            if MOVES {
                let along = &mut self.position[a][particle];
                let free = *along + motion.dt * *own;
                let stays = free.clamp(motion.lower[a], motion.upper[a]);
                *along = if motion.grid.periodic[a] {
                    motion.grid.wrapped_along(a, free)
                } else {
                    *own = if stays == free { *own } else { 0.0 };
                    stays
                };
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
            let pass = PiecePass::<TAKES, MOVES, D> { motion, first, position, velocity };
            variant.run_in_vectors(pass);
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

    /// Points that stand in the box, or at its other end along axes that wrap around.
    #[inline(always)]
    fn inside<V: SimdGather>(&self, point: [V; D]) -> [V; D] {
        let mut kept = point;
        for a in 0..D {
            let along = point[a];
            kept[a] = if self.grid.periodic[a] {
                let origin = along.all(self.grid.origin[a]);
                let length = along.all(self.grid.cells[a] as f64 * self.grid.spacing);
                let along = along.less(origin, along + length, along);
                (origin + length).at_most(along, along - length, along)
            } else {
                along.max(along.all(self.lower[a])).min(along.all(self.upper[a]))
            };
        }
        kept
    }

    /// Where the flow carries particles.
    ///
    /// # Safety
    /// The processor has the instructions of `V`.
    #[inline(always)]
    unsafe fn carried<V: SimdGather>(&self, start: [V; D], taken: &TakenAtStart<D>) -> [V; D] {
        let (mut k1, mut apart) = (start, start);
        for a in 0..D {
            let speed = taken[a].map(|[new, ..]| new);
            let shift = taken[a].map(|[_, _, shift, _]| shift);
            // SAFETY: by contract; no vector has more than eight lanes.
            (k1[a], apart[a]) = unsafe { (V::load(speed.as_ptr()), V::load(shift.as_ptr())) };
        }
        // SAFETY: by contract.
        let (k2, k3) = unsafe {
            let k2 = self.velocity_from(start, 0.5 * self.dt, k1);
            (k2, self.velocity_from(start, 0.75 * self.dt, k2))
        };
        let ninth = start[0].all(self.dt / 9.0);
        let mut end = start;
        for a in 0..D {
            let sum = ninth.all(2.0) * k1[a] + ninth.all(3.0) * k2[a] + ninth.all(4.0) * k3[a];
            end[a] = start[a] + (ninth * sum + apart[a]);
        }
        self.inside(end)
    }

    /// The velocity where points come that go on for a time at a speed [m/s].
    ///
    /// # Safety
    /// The processor has the instructions of `V`.
    #[inline(always)]
    unsafe fn velocity_from<V: SimdGather>(
        &self,
        start: [V; D],
        time: f64,
        speed: [V; D],
    ) -> [V; D] {
        let mut point = start;
        for a in 0..D {
            point[a] = start[a] + start[a].all(time) * speed[a];
        }
        let point = self.inside(point);
        let mut velocity = point;
        for a in 0..D {
            // SAFETY: by contract.
            let around = unsafe { LaneWeights::new(self.grid, Some(a), point) };
            velocity[a] = around.value(self.grid, &self.after[a]);
        }
        velocity
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::seeding::seed;

    /// Particles in a vortex, after a few steps in some instructions.
    fn carried(variant: Variant, periodic: bool) -> ParticleArrays<3> {
        let grid = StaggeredGrid::<3>::new([7, 6, 5], 0.1, [0.0; 3], [periodic, false, false]);
        let near = NearRows::whole(&grid);
        let mut particles = ParticleArrays::new(0.3);
        seed(&grid, &mut particles, 2, 0.9, 3, |x| x[2] < 0.43, |x| [x[1], -x[0], 0.2]);
        let faces = |scale: f64| -> FaceVelocity<3> {
            std::array::from_fn(|a| {
                (0..grid.stored).map(|at| scale * ((at * (a + 2)) as f64).sin()).collect()
            })
        };
        let (before, after, shift) = (faces(0.9), faces(1.0), faces(1e-4));
        let mut team = Team::new("test", 2).expect("threads");
        let mut start = std::array::from_fn(|_| StartValues::new());
        gather_start_values(&mut team, &near, [&before, &after, &shift], &mut start);
        let is_adrift: Vec<bool> = (0..particles.len()).map(|k| k % 11 == 3).collect();
        let motion = ParticleMotion {
            grid: &grid,
            after: &after,
            start: &start,
            transfer: Transfer::Blend { pic: 0.05 },
            is_adrift: &is_adrift,
            dt: 0.02,
            fall: [0.0, 0.0, -0.2],
            lower: [0.001; 3],
            upper: [0.699, 0.599, 0.499],
        };
        (0..5).for_each(|_| motion.carry(&mut team, variant, &mut particles));
        particles
    }

    #[test]
    fn every_variant_carries_particles_to_the_same_bits() {
        for periodic in [false, true] {
            let portable = carried(Variant::Portable, periodic);
            let end = [0.7, 0.6, 0.5];
            assert!((0..portable.len()).all(|k| (0..3).all(|a| portable.at(k)[a] <= end[a])));
            for variant in Variant::ALL.into_iter().filter(|variant| variant.available()) {
                let found = carried(variant, periodic);
                assert_eq!(found.position, portable.position, "{variant:?}");
                assert_eq!(found.velocity, portable.velocity, "{variant:?}");
            }
        }
    }
}
