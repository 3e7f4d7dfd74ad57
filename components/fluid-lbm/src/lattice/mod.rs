//! D3Q19: units, storage, the AA pattern, collide and stream. No geometry, no bodies.

pub mod aa_gather;
pub mod aa_pattern;
pub mod aa_row_ends;
pub mod aa_rows;
pub mod cell_flags;
pub mod cell_list;
pub mod collision;
pub mod collision_kernel;
pub mod contiguous_lines;
pub mod d3q19;
pub mod error;
pub mod exact_sum;
pub mod halfway_bounce_back;
pub mod held_blocks;
pub mod layout;
pub mod ledger;
pub mod momentum_exchange;
pub mod populations;
pub mod reductions;
pub mod reflection_impulse;
pub mod reservoir_place;
pub mod units;
pub mod whole_numbers;
