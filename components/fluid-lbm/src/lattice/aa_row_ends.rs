//! Lines at the end of a row, where a register holds a line: the one cell that sees another place
//! is read and written by itself.

use crate::lattice::aa_pattern::Piece;
use crate::lattice::aa_rows::RowEnd;
use crate::lattice::collision::{After, Populations};
use crate::lattice::collision_kernel::{Sweep, all_lanes};
use crate::lattice::d3q19::C;
use crate::lattice::populations::LatticeVector;
use crate::lattice::populations::{Real, prefetch};

/// The populations of a line at an end of a row, the upper or the lower one.
pub struct AtEnd<'a, V: LatticeVector, const UPPER: bool> {
    /// Places of the line; not those of the cell at the end, in directions that come from beyond.
    line: After<'a, V::Scalar>,
    /// Places of that cell in these directions, as those of a whole line that holds it in its lane.
    ends: [*mut V::Scalar; RowEnd::COUNT],
    /// The other lanes, and that of the cell.
    masks: [V::Mask; 2],
}

/// The pieces of a line at an end of a row.
#[inline(always)]
fn pieces<'a, T: Real>(sweep: &'a Sweep<T>, line: usize) -> &'a [Piece; 2 * RowEnd::COUNT] {
    let first = sweep.places.kind(line).first as usize;
    sweep.places.pieces()[first..]
        .first_chunk()
        .expect("an end of a row has two in five directions")
}

/// Asks memory for what is beyond.
#[inline(always)]
pub fn ask<T: Real>(sweep: &Sweep<T>, line: usize) {
    let upper = usize::from(sweep.places.way(line).row_end == Some(RowEnd::Upper));
    let lane = upper * (T::LINE - 1);
    let pieces = pieces(sweep, line);
    let mut n = 0;
    while n < RowEnd::COUNT {
        prefetch(sweep.field.base().wrapping_add(pieces[2 * n + upper].place as usize + lane));
        n += 1;
    }
}

impl<'a, V: LatticeVector, const UPPER: bool> AtEnd<'a, V, UPPER> {
    const END: RowEnd = if UPPER { RowEnd::Upper } else { RowEnd::Lower };
    /// Bits of the other lanes, and that of the cell.
    const LANES: [u32; 2] = {
        let all = all_lanes::<V>();
        let end = if UPPER { all ^ all >> 1 } else { 1 };
        [all ^ end, end]
    };

    /// Of a line of a sweep.
    ///
    /// # Safety
    /// The processor has the variant's instructions; the line is at this end of a row.
    #[inline(always)]
    pub unsafe fn new(sweep: &Sweep<V::Scalar>, line: usize, at: After<'a, V::Scalar>) -> Self {
        let pieces = pieces(sweep, line);
        let mut ends = [std::ptr::null_mut(); RowEnd::COUNT];
        let mut n = 0;
        while n < RowEnd::COUNT {
            let end = pieces[2 * n + 1 - Self::END.others()];
            ends[n] = sweep.field.base().wrapping_add(end.place as usize);
            n += 1;
        }
        // SAFETY: by contract.
        let masks = unsafe { [V::mask(Self::LANES[0]), V::mask(Self::LANES[1])] };
        Self { line: at, ends, masks }
    }
}

/// True if a direction comes from beyond the end.
const fn is_from_beyond<const UPPER: bool>(i: usize) -> bool {
    C[i][0] == if UPPER { -1 } else { 1 }
}

impl<V: LatticeVector, const UPPER: bool> Populations<V> for AtEnd<'_, V, UPPER> {
    #[inline(always)]
    unsafe fn load(&self, i: usize) -> V {
        // SAFETY: by contract.
        unsafe {
            if !is_from_beyond::<UPPER>(i) {
                return self.line.load(i);
            }
            let After(places, x) = self.line;
            let others = V::splat(0.0).load_lanes(places[i].add(x), self.masks[0]);
            others.load_lanes(self.ends[Self::END.number_of(i)], self.masks[1])
        }
    }

    #[inline(always)]
    unsafe fn store(&self, i: usize, value: V) {
        // SAFETY: by contract.
        unsafe {
            if !is_from_beyond::<UPPER>(i) {
                return self.line.store(i, value);
            }
            let After(places, x) = self.line;
            value.store_lanes(places[i].add(x), Self::LANES[0]);
            value.store_lanes(self.ends[Self::END.number_of(i)], Self::LANES[1]);
        }
    }
}
