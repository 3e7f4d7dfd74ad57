//! Where particles begin: in a lattice of each cell, displaced at random.

use crate::grid::staggered_grid::StaggeredGrid;
use crate::particles::particle_arrays::ParticleArrays;

/// A number from 0 to 1 that depends on a key alone (the finaliser of MurmurHash3).
fn unit(key: u64) -> f64 {
    let mut x = key;
    for factor in [0xff51_afd7_ed55_8ccd, 0xc4ce_b9fe_1a85_ec53] {
        x = (x ^ (x >> 33)).wrapping_mul(factor);
    }
    ((x ^ (x >> 33)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Seeds `per_axis` particles along each axis of each cell, where `is_wet`. They are displaced from
/// their lattice by up to `jitter` half steps of it, by numbers keyed by `seed` and place.
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
        let place = grid.place(at);
        for mut number in 0..per_axis.pow(D as u32) {
            let key = (place * per_axis.pow(D as u32) + number) as u64;
            let position: [f64; D] = std::array::from_fn(|a| {
                let along = number % per_axis;
                number /= per_axis;
                let shift = jitter * (unit(key * 4 + a as u64 + (seed << 40)) - 0.5);
                grid.origin[a] + at[a] as f64 * grid.spacing + (along as f64 + 0.5 + shift) * step
            });
            if is_wet(position) {
                particles.push(position, velocity(position));
            }
        }
    }
}
