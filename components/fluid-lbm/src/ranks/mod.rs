//! A lattice that several processes compute together, each some of its cells: which cells, the copies
//! that each holds of others' cells, the seam behind which they speak to each other, and sums over all of them.

pub mod cell_shares;
pub mod communicator;
pub mod halo;
pub mod rank_sums;
pub mod whole_ways;
