//! What is largest in a block: details are measured against it, and the time step follows from it.

use crate::gas::gas_law::{Gas, MOST_FIELDS};

/// Largest values in a block, or of several blocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockScales {
    /// Largest magnitude of each field.
    pub largest: [f64; MOST_FIELDS],
    /// Speed of the fastest signal, summed over the axes [m/s], times the spacing of level 0 over
    /// that of the block.
    pub fastest: f64,
    /// Largest viscosity over density [m²/s].
    pub viscous: f64,
}

impl BlockScales {
    /// Of no points.
    pub const NONE: Self = Self { largest: [0.0; MOST_FIELDS], fastest: 0.0, viscous: 0.0 };

    /// Of a block of a level: `own` has its fields one after the other, each of so many points.
    pub fn of(gas: &Gas, dims: usize, level: u8, own: &[f64], points: usize) -> Self {
        let mut scales = Self::NONE;
        for point in 0..points {
            let mut fields = [0.0; MOST_FIELDS];
            for (k, of_field) in own.chunks_exact(points).enumerate() {
                fields[k] = of_field[point];
                scales.largest[k] = scales.largest[k].max(fields[k].abs());
            }
            let state = gas.state(dims, &fields);
            let sound = gas.sound_speed(state.density, state.pressure);
            let speed = state.velocity[..dims].iter().map(|u| u.abs() + sound).sum::<f64>();
            scales.fastest = scales.fastest.max(speed);
            if gas.viscosity > 0.0 {
                let temperature = state.pressure / (state.density * gas.gas_constant);
                let viscous = gas.viscosity_at(temperature) / state.density;
                scales.viscous = scales.viscous.max(viscous);
            }
        }
        scales.fastest *= f64::from(1_u32 << level);
        scales
    }

    /// Of this and others.
    pub fn with(mut self, other: &Self) -> Self {
        for (own, other) in self.largest.iter_mut().zip(other.largest) {
            *own = own.max(other);
        }
        self.fastest = self.fastest.max(other.fastest);
        self.viscous = self.viscous.max(other.viscous);
        self
    }
}
