//! From particles to the grid: mass and momentum of faces, mass of cells.

use crate::grid::near_rows::NearRows;
use crate::grid::staggered_grid::StaggeredGrid;
use crate::particles::hat_weights::HatWeights;
use crate::particles::lane_weights::{LaneWeights, SideBySide, load_points};
use crate::particles::particle_arrays::ParticleArrays;
use tremie_team::instructions::VectorWork;
use tremie_team::{SimdGather, Variant};

/// Weight and weighted velocity that the faces across an axis gather. Those of a face and of the
/// next along the first axis lie side by side: a particle adds to both at once.
pub type FaceSums = Vec<[f64; 2]>;

/// Mass and velocity of the faces across one axis: `m = sum m_p S`, `u = sum m_p u_p S / m`. A face
/// that no particle reaches has no mass, and velocity 0. With gradients, a particle's velocity is
/// that at the face. `sums` is room to work in.
pub fn to_faces<const D: usize>(
    variant: Variant,
    (grid, near): (&StaggeredGrid<D>, &NearRows),
    particles: &ParticleArrays<D>,
    axis: usize,
    sums: &mut FaceSums,
    (mass, velocity): (&mut [f64], &mut [f64]),
) {
    for array in [&mut *mass, &mut *velocity] {
        near.clear_left(array, 0.0);
    }
    sums.resize(grid.stored, [0.0; 2]);
    near.fill(sums, [0.0; 2]);
    variant.run_in_vectors(AddToFaces { grid, particles, axis, sums });
    for at in near.spans().flatten() {
        [mass[at], velocity[at]] = sums[at];
    }
    grid.ghosts.fold(mass);
    grid.ghosts.fold(velocity);
    for at in near.spans().flatten() {
        let (mass, velocity) = (&mut mass[at], &mut velocity[at]);
        *velocity = if *mass > 0.0 { *velocity / *mass } else { 0.0 };
        *mass *= particles.mass;
    }
}

/// Particles add weight and velocity to faces.
struct AddToFaces<'a, const D: usize> {
    grid: &'a StaggeredGrid<D>,
    particles: &'a ParticleArrays<D>,
    axis: usize,
    sums: &'a mut [[f64; 2]],
}

impl<const D: usize> VectorWork for AddToFaces<'_, D> {
    #[inline(always)]
    unsafe fn run<V: SimdGather>(self) {
        let Self { grid, particles, axis, sums } = self;
        let is_affine = !particles.gradient[axis][0].is_empty();
        for first in (0..particles.len()).step_by(V::N) {
            let count = V::N.min(particles.len() - first);
            // SAFETY: by contract.
            let around = unsafe { weights::<V, D>(grid, Some(axis), particles, first, count) };
            for lane in 0..count {
                let (around, particle) = (around.of(lane), first + lane);
                if is_affine {
                    add_affine_velocity(grid, (particles, particle), axis, around, sums);
                } else {
                    add_velocity(grid, particles.velocity[axis][particle], around, sums);
                }
            }
        }
    }
}

/// Particles add weight to cells.
struct AddToCells<'a, const D: usize> {
    grid: &'a StaggeredGrid<D>,
    particles: &'a ParticleArrays<D>,
    mass: &'a mut [f64],
}

impl<const D: usize> VectorWork for AddToCells<'_, D> {
    #[inline(always)]
    unsafe fn run<V: SimdGather>(self) {
        let Self { grid, particles, mass } = self;
        for first in (0..particles.len()).step_by(V::N) {
            let count = V::N.min(particles.len() - first);
            // SAFETY: by contract.
            let around = unsafe { weights::<V, D>(grid, None, particles, first, count) };
            for lane in 0..count {
                let around = around.of(lane);
                let shares = [1.0 - around.upper[0], around.upper[0]];
                for (place, weight) in around.pairs(grid).into_iter().take(1 << (D - 1)) {
                    for (sum, share) in mass[place..place + 2].iter_mut().zip(shares) {
                        *sum += weight * share;
                    }
                }
            }
        }
    }
}

/// Weights of values around some particles, from one on.
///
/// # Safety
/// The processor has the instructions of `V`.
#[inline(always)]
unsafe fn weights<V: SimdGather, const D: usize>(
    grid: &StaggeredGrid<D>,
    face: Option<usize>,
    particles: &ParticleArrays<D>,
    first: usize,
    count: usize,
) -> SideBySide<D> {
    let position = particles.position.each_ref().map(|along| &**along);
    // SAFETY: by contract.
    unsafe {
        let at = load_points::<V, D>(position, first, count);
        LaneWeights::new(grid, face, at).one_by_one()
    }
}

/// Adds what a particle brings that has one velocity.
#[inline(always)]
fn add_velocity<const D: usize>(
    grid: &StaggeredGrid<D>,
    own: f64,
    around: HatWeights<D>,
    sums: &mut [[f64; 2]],
) {
    let [lower, upper] = [1.0 - around.upper[0], around.upper[0]];
    let shares = [[lower, lower * own], [upper, upper * own]];
    for (place, weight) in around.pairs(grid).into_iter().take(1 << (D - 1)) {
        add_pair(&mut sums[place..place + 2], weight, shares);
    }
}

/// Adds what a particle brings whose velocity changes along the axes.
#[inline(always)]
fn add_affine_velocity<const D: usize>(
    grid: &StaggeredGrid<D>,
    (particles, particle): (&ParticleArrays<D>, usize),
    axis: usize,
    around: HatWeights<D>,
    sums: &mut [[f64; 2]],
) {
    let slope: [f64; D] =
        std::array::from_fn(|a| particles.gradient[axis][a][particle] * grid.spacing);
    let own = particles.velocity[axis][particle];
    let base: f64 = own - (0..D).map(|a| slope[a] * around.upper[a]).sum::<f64>();
    let [lower, upper] = [1.0 - around.upper[0], around.upper[0]];
    let pairs = around.pairs(grid).into_iter().take(1 << (D - 1));
    for (number, (place, weight)) in pairs.enumerate() {
        let there = (1..D)
            .fold(base, |there, a| there + if number >> (a - 1) & 1 == 1 { slope[a] } else { 0.0 });
        let shares = [[lower, lower * there], [upper, upper * (there + slope[0])]];
        add_pair(&mut sums[place..place + 2], weight, shares);
    }
}

#[inline(always)]
fn add_pair(sums: &mut [[f64; 2]], weight: f64, shares: [[f64; 2]; 2]) {
    for (sum, share) in sums.iter_mut().zip(shares) {
        for (sum, share) in sum.iter_mut().zip(share) {
            *sum += weight * share;
        }
    }
}

/// Mass of cells, spread by the same hat.
pub fn to_cells<const D: usize>(
    variant: Variant,
    (grid, near): (&StaggeredGrid<D>, &NearRows),
    particles: &ParticleArrays<D>,
    mass: &mut [f64],
) {
    near.clear_left(mass, 0.0);
    near.fill(mass, 0.0);
    variant.run_in_vectors(AddToCells { grid, particles, mass });
    grid.ghosts.fold(mass);
    near.spans().flatten().for_each(|at| mass[at] *= particles.mass);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::seeding::seed;

    #[test]
    fn transfers_keep_mass_and_momentum() {
        let grid = StaggeredGrid::<3>::new([6, 5, 4], 0.1, [0.0; 3], [false; 3]);
        let near = NearRows::whole(&grid);
        let mut particles = ParticleArrays::new(0.3);
        let velocity = |x: [f64; 3]| [x[1] - 0.3, 5.0 * x[0], -x[2] * x[0]];
        seed(&grid, &mut particles, 2, 1.0, 1, |_| true, velocity);
        let (mut mass, mut u) = (vec![0.0; grid.stored], vec![0.0; grid.stored]);
        let mut sums = FaceSums::new();
        for axis in 0..3 {
            let grids = (&grid, &near);
            let out = (&mut mass[..], &mut u[..]);
            to_faces(Variant::widest(), grids, &particles, axis, &mut sums, out);
            let all: f64 = mass.iter().sum();
            assert!((all / (0.3 * particles.len() as f64) - 1.0).abs() < 1e-13);
            let momentum: f64 = mass.iter().zip(&u).map(|(m, u)| m * u).sum();
            assert!((momentum - particles.momentum()[axis]).abs() < 1e-11);
        }
        to_cells(Variant::widest(), (&grid, &near), &particles, &mut mass);
        assert!((mass.iter().sum::<f64>() / (0.3 * particles.len() as f64) - 1.0).abs() < 1e-13);
    }
}
