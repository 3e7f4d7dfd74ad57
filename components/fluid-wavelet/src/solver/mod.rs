//! Steps of the gas on its adaptive grid.

pub mod block_scales;
pub mod domain_faces;
pub mod gas_sums;
pub mod kept_grid;
pub mod observed_point;
pub mod part_times;
pub mod rates_pass;
pub mod sponge;
pub mod wall_forces;
pub mod wavelet_solver;
