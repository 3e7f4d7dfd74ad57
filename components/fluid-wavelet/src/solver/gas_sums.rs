//! Sums over the gas, and its extremes.

use crate::bodies::gas_body::GasBody;
use crate::gas::gas_law::{Gas, GasState, MOST_FIELDS};
use crate::grid::block_shape::BlockShape;
use crate::solver::wavelet_solver::WaveletSolver;
use serde::{Deserialize, Serialize};

/// Sums and extremes of the gas outside of bodies. Of a plane gas, sums are for a metre of depth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GasSums {
    /// Integrals of the fields: mass, momentum, energy.
    pub fields: [f64; MOST_FIELDS],
    /// Largest speed [m/s].
    pub max_speed: f64,
    /// Largest Mach number.
    pub max_mach: f64,
    /// Least and largest density [kg/m^3].
    pub density: [f64; 2],
    /// Least and largest pressure [Pa].
    pub pressure: [f64; 2],
}

/// A quantity of the gas whose greatest value has a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GasExtreme {
    /// Mach number.
    Mach,
    /// How far the density has left its range at the start.
    DensityDeviation,
}

/// Weights of the points of a block along an axis in an integral over it, from the point below its
/// first to the second beyond its last: of fourth order, between any blocks.
fn weights(shape: &BlockShape, axis: usize) -> Vec<f64> {
    if axis >= shape.dims {
        return vec![1.0];
    }
    let edge = shape.edge[axis];
    let ends = [-1.0 / 24.0, 12.0 / 24.0, 25.0 / 24.0];
    let weight = |k: usize| ends.get(k.min(edge + 2 - k)).copied().unwrap_or(1.0);
    (0..edge + 3).map(weight).collect()
}

impl WaveletSolver {
    /// Sums and extremes; ghosts are filled.
    pub fn sums(&self, bodies: &[impl GasBody]) -> GasSums {
        let (shape, places) = (self.shape(), self.places());
        let (gas, dims, count) = (&self.settings.gas, shape.dims, self.values.fields);
        let weights = [0, 1, 2].map(|a| weights(&shape, a));
        let mut sums = GasSums::of_nothing();
        for &leaf in &self.tree.leaves {
            let (slot, block) = (leaf as usize, self.tree.blocks[leaf as usize]);
            let spacing = places.spacing(block.level);
            let near = self.mask.near(slot);
            let mut of_block = [0.0; MOST_FIELDS];
            for (z, wz) in weights[2].iter().enumerate() {
                for (y, wy) in weights[1].iter().enumerate() {
                    for (x, wx) in weights[0].iter().enumerate() {
                        // From the ghost below the first point on.
                        let at = [x, y, z];
                        let at = std::array::from_fn(|a| at[a] + shape.ghosts[a].saturating_sub(1));
                        let place = shape.place(at);
                        let share = if near.is_empty() {
                            1.0
                        } else {
                            share_of_gas(bodies, near, places.padded_point(block, at), spacing)
                        };
                        if share == 0.0 {
                            continue;
                        }
                        let mut fields = [0.0; MOST_FIELDS];
                        for (field, value) in fields.iter_mut().enumerate().take(count) {
                            let first = (slot * count + field) * shape.stored;
                            *value = self.values.padded[first + place];
                            of_block[field] += share * wx * wy * wz * *value;
                        }
                        sums.see(gas.state(dims, &fields), gas);
                    }
                }
            }
            let volume = spacing.powi(dims as i32);
            for (sum, of_block) in sums.fields.iter_mut().zip(of_block) {
                *sum += volume * of_block;
            }
        }
        sums
    }
}

impl WaveletSolver {
    /// Place at which a quantity is greatest now, the first of several, along the grid's axes [m];
    /// ghosts are filled. `first`: the sums at the start.
    pub fn place_of(
        &self,
        bodies: &[impl GasBody],
        first: &GasSums,
        extreme: GasExtreme,
    ) -> Option<[f64; 3]> {
        let (shape, places) = (self.shape(), self.places());
        let (gas, dims, count) = (&self.settings.gas, shape.dims, self.values.fields);
        let points = |axis: usize| if axis < dims { shape.edge[axis] + 1 } else { 1 };
        let mut most: Option<(f64, [f64; 3])> = None;
        for &leaf in &self.tree.leaves {
            let (slot, block) = (leaf as usize, self.tree.blocks[leaf as usize]);
            let (spacing, near) = (places.spacing(block.level), self.mask.near(slot));
            for k in 0..points(0) * points(1) * points(2) {
                let at = [k % points(0), k / points(0) % points(1), k / (points(0) * points(1))];
                // Up to the next block's first point; ghosts may lie beyond the domain.
                let at = std::array::from_fn(|a| at[a] + shape.ghosts[a]);
                let position = places.padded_point(block, at);
                if !near.is_empty() && share_of_gas(bodies, near, position, spacing) == 0.0 {
                    continue;
                }
                let mut fields = [0.0; MOST_FIELDS];
                for (field, value) in fields.iter_mut().enumerate().take(count) {
                    *value =
                        self.values.padded[(slot * count + field) * shape.stored + shape.place(at)];
                }
                let mut own = GasSums::of_nothing();
                own.see(gas.state(dims, &fields), gas);
                let value = match extreme {
                    GasExtreme::Mach => own.max_mach,
                    GasExtreme::DensityDeviation => own.density_deviation(first),
                };
                if most.is_none_or(|(most, _)| value > most) {
                    most = Some((value, position));
                }
            }
        }
        most.map(|(_, position)| position)
    }
}

impl GasSums {
    fn of_nothing() -> Self {
        Self { density: [f64::INFINITY, 0.0], pressure: [f64::INFINITY, 0.0], ..Self::default() }
    }

    /// How far densities have left the range that they had `first`: 0 within it.
    pub fn density_deviation(&self, first: &Self) -> f64 {
        let above = self.density[1] / first.density[1] - 1.0;
        let below = first.density[0] / self.density[0] - 1.0;
        above.max(below).max(0.0)
    }

    fn see(&mut self, state: GasState, gas: &Gas) {
        let speed = state.velocity.iter().map(|u| u * u).sum::<f64>().sqrt();
        let mach = speed / gas.sound_speed(state.density, state.pressure);
        self.max_speed = self.max_speed.max(speed);
        self.max_mach = self.max_mach.max(mach);
        for ([least, most], value) in
            [(&mut self.density, state.density), (&mut self.pressure, state.pressure)]
        {
            (*least, *most) = (least.min(value), most.max(value));
        }
    }
}

/// Share of a point's surroundings that gas fills.
fn share_of_gas(bodies: &[impl GasBody], near: &[u16], at: [f64; 3], spacing: f64) -> f64 {
    let heights = near.iter().map(|body| bodies[usize::from(*body)].height(at).0);
    let least = heights.fold(f64::INFINITY, f64::min);
    (0.5 + least / spacing).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubics_are_integrated_exactly() {
        let shape = BlockShape::new(1, 8);
        let weights = weights(&shape, 0);
        assert_eq!(weights.len(), 11);
        for power in 0..4 {
            let sum: f64 = (weights.iter().enumerate())
                .map(|(k, weight)| weight * (k as f64 - 1.0).powi(power))
                .sum();
            let exact = 8.0_f64.powi(power + 1) / f64::from(power + 1);
            assert!((sum - exact).abs() < 1e-10 * exact, "{power}: {sum} for {exact}");
        }
    }
}
