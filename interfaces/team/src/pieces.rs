//! Arrays cut into pieces that threads may change at the same time.

use std::marker::PhantomData;

/// Something cut into pieces, no two of which share memory: one or several slices.
///
/// Implemented here alone, for [`Cut`], and for arrays and tuples of what implements it.
pub trait Pieces: Sync + sealed::Sealed {
    /// One of the pieces.
    type Piece;

    /// Number of pieces.
    fn count(&self) -> usize;

    /// Piece number `k`.
    ///
    /// # Safety
    /// `k` is less than the count, and nobody else holds this piece.
    unsafe fn piece(&self, k: usize) -> Self::Piece;
}

/// A slice cut into pieces.
pub struct Cut<'a, T> {
    start: *mut T,
    bounds: Bounds<'a>,
    slice: PhantomData<&'a mut [T]>,
}

enum Bounds<'a> {
    /// Pieces of one length; the last may be shorter.
    Every { length: usize, whole: usize },
    /// Piece k runs from entry k to entry k + 1.
    At(&'a [u32]),
}

// SAFETY: through a shared reference nothing but `piece` reaches the elements, and its callers keep
// pieces apart; a piece may be used on another thread where `T: Send`.
unsafe impl<T: Send> Sync for Cut<'_, T> {}

impl<'a, T> Cut<'a, T> {
    /// Pieces of `length` elements; the last may be shorter.
    ///
    /// # Panics
    /// If `length` is 0.
    pub fn every(slice: &'a mut [T], length: usize) -> Self {
        assert!(length > 0, "pieces have a length");
        let bounds = Bounds::Every { length, whole: slice.len() };
        Self { start: slice.as_mut_ptr(), bounds, slice: PhantomData }
    }

    /// Piece k from `bounds[k]` to `bounds[k + 1]`.
    ///
    /// # Panics
    /// If the bounds do not ascend or lead beyond the slice.
    pub fn at(slice: &'a mut [T], bounds: &'a [u32]) -> Self {
        assert!(bounds.is_sorted(), "bounds ascend");
        assert!(bounds.last().is_none_or(|&end| end as usize <= slice.len()), "bounds lie inside");
        Self { start: slice.as_mut_ptr(), bounds: Bounds::At(bounds), slice: PhantomData }
    }
}

impl<'a, T: Send> Pieces for Cut<'a, T> {
    type Piece = &'a mut [T];

    fn count(&self) -> usize {
        match self.bounds {
            Bounds::Every { length, whole } => whole.div_ceil(length),
            Bounds::At(bounds) => bounds.len().saturating_sub(1),
        }
    }

    unsafe fn piece(&self, k: usize) -> &'a mut [T] {
        let (begin, end) = match self.bounds {
            Bounds::Every { length, whole } => (k * length, whole.min((k + 1) * length)),
            Bounds::At(bounds) => (bounds[k] as usize, bounds[k + 1] as usize),
        };
        // SAFETY: `k` is less than the count, so the range lies inside the slice; ranges of
        // different pieces do not overlap, and the caller asks for each once at a time. The slice
        // is borrowed mutably for 'a.
        unsafe { std::slice::from_raw_parts_mut(self.start.add(begin), end - begin) }
    }
}

macro_rules! tuples {
    ($(($($piece:ident $place:tt),+))+) => {$(
        impl<$($piece: Pieces),+> Pieces for ($($piece,)+) {
            type Piece = ($($piece::Piece,)+);

            fn count(&self) -> usize {
                let counts = [$(self.$place.count()),+];
                assert!(counts.iter().all(|&n| n == counts[0]), "as many pieces of each: {counts:?}");
                counts[0]
            }

            unsafe fn piece(&self, k: usize) -> Self::Piece {
                // SAFETY: the counts are equal, and the caller keeps the contract for all alike.
                unsafe { ($(self.$place.piece(k),)+) }
            }
        }

        impl<$($piece: Pieces),+> sealed::Sealed for ($($piece,)+) {}
    )+};
}

tuples! {
    (A 0, B 1)
    (A 0, B 1, C 2)
    (A 0, B 1, C 2, D 3)
    (A 0, B 1, C 2, D 3, E 4)
    (A 0, B 1, C 2, D 3, E 4, F 5)
    (A 0, B 1, C 2, D 3, E 4, F 5, G 6)
    (A 0, B 1, C 2, D 3, E 4, F 5, G 6, H 7)
}

impl<P: Pieces, const N: usize> Pieces for [P; N] {
    type Piece = [P::Piece; N];

    fn count(&self) -> usize {
        let count = self.first().map_or(0, Pieces::count);
        assert!(self.iter().all(|pieces| pieces.count() == count), "as many pieces of each");
        count
    }

    unsafe fn piece(&self, k: usize) -> Self::Piece {
        // SAFETY: the counts are equal, and the caller keeps the contract for all alike.
        std::array::from_fn(|n| unsafe { self[n].piece(k) })
    }
}

mod sealed {
    pub trait Sealed {}
    impl<T> Sealed for super::Cut<'_, T> {}
    impl<P: super::Pieces, const N: usize> Sealed for [P; N] {}
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Team;

    #[test]
    fn pieces_of_several_slices_come_together() {
        let mut team = Team::new("test", 3).unwrap();
        let (mut even, mut odd) = ([0; 10], [0; 7]);
        let bounds = [0, 1, 1, 5, 7];
        team.for_pieces((Cut::every(&mut even, 3), Cut::at(&mut odd, &bounds)), |k, (a, b)| {
            a.fill(k);
            b.fill(k);
        });
        assert_eq!(even, [0, 0, 0, 1, 1, 1, 2, 2, 2, 3]);
        assert_eq!(odd, [0, 2, 2, 2, 2, 3, 3]);
    }

    #[test]
    #[should_panic(expected = "as many pieces")]
    fn different_numbers_of_pieces_are_refused() {
        let (mut a, mut b) = ([0; 10], [0; 10]);
        let pieces = (Cut::every(&mut a, 3), Cut::every(&mut b, 4));
        Team::new("test", 1).unwrap().for_pieces(pieces, |_, _| {});
    }

    #[test]
    #[should_panic(expected = "bounds ascend")]
    fn bounds_that_overlap_are_refused() {
        Cut::at(&mut [0; 10], &[0, 5, 3, 10]);
    }
}
