//! Where particles begin: in a lattice of each cell, displaced at random.

use crate::grid::staggered_grid::StaggeredGrid;
use crate::particles::particle_arrays::ParticleArrays;
use rand_chacha::{ChaCha8Rng, rand_core::Rng, rand_core::SeedableRng};

/// Seeds `per_axis` particles along each axis of each cell, where `is_wet`. They are displaced from
/// their lattice by up to `jitter` half steps of it, by numbers keyed by `seed` and the cell.
pub fn seed<const D: usize>(
    grid: &StaggeredGrid<D>,
    particles: &mut ParticleArrays<D>,
    per_axis: usize,
    jitter: f64,
    seed: u64,
    is_wet: impl Fn([f64; D]) -> bool,
    velocity: impl Fn([f64; D]) -> [f64; D],
) {
    let step = grid.spacing / per_axis as f64;
    for at in grid.all() {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(grid.place(at) as u64);
        for mut number in 0..per_axis.pow(D as u32) {
            let position: [f64; D] = std::array::from_fn(|a| {
                let along = number % per_axis;
                number /= per_axis;
                let unit = (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
                let shift = jitter * (unit - 0.5);
                grid.origin[a] + at[a] as f64 * grid.spacing + (along as f64 + 0.5 + shift) * step
            });
            if is_wet(position) {
                particles.push(position, velocity(position));
            }
        }
    }
}
