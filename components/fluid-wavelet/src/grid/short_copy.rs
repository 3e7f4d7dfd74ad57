//! Copies of rows of a block: so short that a call of the system's copy would cost more than they.

use crate::grid::block_shape::GHOSTS;

/// Copies a row onto one of the same length.
#[inline(always)]
pub fn copy_row(from: &[f64], to: &mut [f64]) {
    debug_assert_eq!(from.len(), to.len());
    match to.len() {
        GHOSTS => copy_points::<GHOSTS>(from, to),
        8 => copy_points::<8>(from, to),
        16 => copy_points::<16>(from, to),
        _ => to.copy_from_slice(from),
    }
}

/// Copies so many points that the compiler knows their number.
#[inline(always)]
fn copy_points<const N: usize>(from: &[f64], to: &mut [f64]) {
    if let (Some(from), Some(to)) = (from.first_chunk::<N>(), to.first_chunk_mut::<N>()) {
        *to = *from;
    }
}
