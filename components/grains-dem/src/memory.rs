//! Memory that a run's spheres take, counted from the arrays that hold them.

use crate::{
    Vec3,
    bodies::{Ball, Mobility, Twist, Wrench},
    law::Reduced,
    pairs::{Entry, Record, Rolling},
};
use tremie_messages::body::BodyEvent;

/// Pairs that are listed for each sphere of a dense packing of nearly equal ones, with the default
/// skin: half of its neighbours.
pub(crate) const PAIRS: usize = 5;

const INDEX: usize = size_of::<u32>();

/// The state of a sphere, and that of one being put in another order.
const STATE: usize = 2 * size_of::<Ball>()
    + 3 * size_of::<Twist>()
    + 2 * size_of::<Wrench>()
    + 2 * size_of::<Mobility>()
    + 2 * size_of::<[f64; 4]>()
    + size_of::<Vec3>()
    + 8 * INDEX
    + 2 * size_of::<u16>();

/// Cells, orders, places, sums, and what the others are told at the start.
const SEARCH: usize = 12 * INDEX
    + size_of::<bool>()
    + size_of::<(u64, u32)>()
    + size_of::<f64>()
    + size_of::<BodyEvent>();

/// A pair in a list, with the places where its bodies find it, listed and acting.
const LISTED: usize = size_of::<Entry>()
    + size_of::<f32>()
    + size_of::<Reduced>()
    + size_of::<u8>()
    + size_of::<Vec3>()
    + size_of::<Record>()
    + 4 * INDEX;

/// A pair while the list is made.
const FOUND: usize = 2 * size_of::<Entry>() + INDEX + 2 * size_of::<u64>();

/// Bytes for each sphere of a dense packing: state, and two lists of pairs, the one before and the one
/// that is used.
pub(crate) fn of_sphere(rolling: bool) -> usize {
    let rolling = if rolling { size_of::<Rolling>() } else { 0 };
    STATE + SEARCH + PAIRS * (2 * (LISTED + rolling) + FOUND)
}
