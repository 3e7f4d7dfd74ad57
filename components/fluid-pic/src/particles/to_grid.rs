//! From particles to the grid: mass and momentum of faces, mass of cells.

use crate::grid::near_rows::NearRows;
use crate::grid::staggered_grid::StaggeredGrid;
use crate::particles::hat_weights::HatWeights;
use crate::particles::particle_arrays::ParticleArrays;

/// Mass and velocity of the faces across one axis: `m = sum m_p S`, `u = sum m_p u_p S / m`. A face
/// that no particle reaches has no mass, and velocity 0. With gradients, a particle's velocity is
/// that at the face.
pub fn to_faces<const D: usize>(
    grid: &StaggeredGrid<D>,
    near: &NearRows,
    particles: &ParticleArrays<D>,
    axis: usize,
    mass: &mut [f64],
    velocity: &mut [f64],
) {
    for array in [&mut *mass, &mut *velocity] {
        near.clear_left(array, 0.0);
        near.fill(array, 0.0);
    }
    let is_affine = !particles.gradient[axis][0].is_empty();
    for particle in 0..particles.len() {
        let around = HatWeights::new(grid, Some(axis), particles.at(particle));
        let own = particles.velocity[axis][particle];
        if is_affine {
            let slope: [f64; D] =
                std::array::from_fn(|a| particles.gradient[axis][a][particle] * grid.spacing);
            let base: f64 = own - (0..D).map(|a| slope[a] * around.upper[a]).sum::<f64>();
            let mut corner = 0_usize;
            around.each(grid, |place, weight| {
                let mut there = base;
                for a in 0..D {
                    there += if corner >> a & 1 == 1 { slope[a] } else { 0.0 };
                }
                corner += 1;
                mass[place] += weight;
                velocity[place] += weight * there;
            });
        } else {
            around.each(grid, |place, weight| {
                mass[place] += weight;
                velocity[place] += weight * own;
            });
        }
    }
    grid.ghosts.fold(mass);
    grid.ghosts.fold(velocity);
    for at in near.spans().flatten() {
        let (mass, velocity) = (&mut mass[at], &mut velocity[at]);
        *velocity = if *mass > 0.0 { *velocity / *mass } else { 0.0 };
        *mass *= particles.mass;
    }
}

/// Mass of cells, spread by the same hat.
pub fn to_cells<const D: usize>(
    grid: &StaggeredGrid<D>,
    near: &NearRows,
    particles: &ParticleArrays<D>,
    mass: &mut [f64],
) {
    near.clear_left(mass, 0.0);
    near.fill(mass, 0.0);
    for particle in 0..particles.len() {
        let around = HatWeights::new(grid, None, particles.at(particle));
        around.each(grid, |place, weight| mass[place] += weight);
    }
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
        for axis in 0..3 {
            to_faces(&grid, &near, &particles, axis, &mut mass, &mut u);
            let all: f64 = mass.iter().sum();
            assert!((all / (0.3 * particles.len() as f64) - 1.0).abs() < 1e-13);
            let momentum: f64 = mass.iter().zip(&u).map(|(m, u)| m * u).sum();
            assert!((momentum - particles.momentum()[axis]).abs() < 1e-11);
        }
        to_cells(&grid, &near, &particles, &mut mass);
        assert!((mass.iter().sum::<f64>() / (0.3 * particles.len() as f64) - 1.0).abs() < 1e-13);
    }
}
