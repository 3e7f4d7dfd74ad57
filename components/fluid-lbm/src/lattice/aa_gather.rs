//! Lines whose odd places are in pieces, collected so that they can collide as others do, and
//! written back.

use crate::lattice::collision::AHEAD;
use crate::lattice::collision_kernel::{Sweep, all_lanes};
use crate::lattice::contiguous_lines::LineRun;
use crate::lattice::d3q19::Q;
use crate::lattice::populations::LatticeVector;
use crate::lattice::populations::{Real, prefetch, prefetch_early};

/// Lines after a run whose pieces are asked for before it. Whole lines need no such help: the lines
/// before ask for what follows their own places.
pub const PIECES_AHEAD: usize = 4;

/// Does some work with the pieces of each direction of a line that is in pieces.
macro_rules! of_pieces {
    ($sweep:ident, $line:ident, |$pieces:ident| $work:block) => {
        let kind = $sweep.places.kind($line);
        // SAFETY: the table's lines point to pieces of its own; so many are there as is said here.
        let mut rest = unsafe { $sweep.places.pieces().get_unchecked(kind.first as usize..) };
        of_pieces!(rest, kind.two, 2, |$pieces| $work);
        of_pieces!(rest, kind.three, 3, |$pieces| $work);
        for _ in 0..kind.others {
            let $pieces;
            ($pieces, rest) =
                rest.split_at(rest.iter().take_while(|piece| !piece.last).count() + 1);
            $work
        }
    };
    ($rest:ident, $times:expr, $count:literal, |$pieces:ident| $work:block) => {
        for _ in 0..$times {
            let $pieces;
            // SAFETY: as above.
            ($pieces, $rest) = unsafe { $rest.split_at_unchecked($count) };
            $work
        }
    };
}

/// Asks memory for what a line will need that is in pieces.
#[inline(always)]
pub fn ask<T: Real>(sweep: &Sweep<T>, line: usize) {
    // The table itself is read first here.
    prefetch(sweep.places.lines().as_ptr().wrapping_add(line + 4 * PIECES_AHEAD));
    of_pieces!(sweep, line, |pieces| {
        prefetch(pieces.as_ptr().wrapping_add(64));
        for piece in pieces {
            let lane = piece.lanes.trailing_zeros() as usize;
            prefetch(sweep.field.base().wrapping_add(piece.place as usize + lane));
        }
    });
}

/// Room for a line in each direction.
#[repr(align(64))]
pub struct Scratch<T>([[T; 16]; Q]);

impl<T: Real> Scratch<T> {
    /// Without anything in it.
    pub fn new() -> Self {
        Self([[T::from_f64(0.0); 16]; Q])
    }

    /// Collects the directions of a line that are in pieces: where all of them are then.
    ///
    /// # Safety
    /// As for [`crate::lattice::collision_kernel::Kernel`]; the line is one of the sweep.
    #[inline(always)]
    pub unsafe fn gather<V: LatticeVector<Scalar = T>>(
        &mut self,
        sweep: &Sweep<T>,
        line: usize,
    ) -> LineRun<T> {
        let base = sweep.field.base();
        let mut run = LineRun::collected(sweep, line);
        of_pieces!(sweep, line, |pieces| {
            let i = usize::from(pieces[0].dir);
            run.places[i] = self.0[i].as_mut_ptr();
            // Lines after this go on from one of them.
            for piece in pieces {
                prefetch_early(base.wrapping_add(piece.place as usize + AHEAD * T::LINE));
            }
            let mut x = 0;
            while x < T::LINE {
                // SAFETY: by contract; the lanes of a piece are places of the field.
                unsafe {
                    let mut v = V::splat(0.0);
                    for piece in pieces {
                        let lanes = u32::from(piece.lanes) >> x & all_lanes::<V>();
                        let from = base.wrapping_add(piece.place as usize + x);
                        v = v.load_lanes(from, V::mask(lanes));
                    }
                    v.store(run.places[i].add(x));
                }
                x += V::N;
            }
        });
        run
    }

    /// Writes the directions of a line that are in pieces from where [`Scratch::gather`] had put
    /// them.
    ///
    /// # Safety
    /// As for [`Scratch::gather`].
    #[inline(always)]
    pub unsafe fn scatter<V: LatticeVector<Scalar = T>>(&self, sweep: &Sweep<T>, line: usize) {
        let base = sweep.field.base();
        of_pieces!(sweep, line, |pieces| {
            let i = usize::from(pieces[0].dir);
            let mut x = 0;
            while x < T::LINE {
                // SAFETY: by contract.
                unsafe {
                    let v = V::load(self.0[i].as_ptr().add(x));
                    for piece in pieces {
                        let lanes = u32::from(piece.lanes) >> x & all_lanes::<V>();
                        v.store_lanes(base.wrapping_add(piece.place as usize + x), lanes);
                    }
                }
                x += V::N;
            }
        });
    }
}
