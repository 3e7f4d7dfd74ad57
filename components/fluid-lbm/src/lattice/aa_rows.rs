//! Way of a sweep from one line to the next, and lines at the ends of rows.

use crate::lattice::aa_pattern::Piece;
use crate::lattice::d3q19::{C, Q};

/// Way of a sweep from one line to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Way {
    /// True if its odd places are those after the places of the line before, at least of most of
    /// its cells.
    pub follows: bool,
    /// End of a row that the line holds, if its only pieces are those of that end.
    pub row_end: Option<RowEnd>,
}

/// An end of a row that ends with a line. In the directions from there the line is in two pieces:
/// the row's last cell, which sees another place than those beside it, and the others, whose place
/// is the line's entry in the table. The pieces are listed in the order of directions, and of
/// lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowEnd {
    /// The first cell of the line is the first of its row.
    Lower,
    /// The last cell of the line is the last of its row.
    Upper,
}

impl Way {
    /// Lines that a sweep may look ahead.
    pub const AHEAD: usize = 4;
}

impl RowEnd {
    /// Directions in pieces.
    pub const COUNT: usize = 5;

    /// Those that come from beyond this end.
    pub const fn directions(self) -> [usize; Self::COUNT] {
        let mut directions = [0; Self::COUNT];
        let (mut i, mut k) = (1, 0);
        while i < Q {
            if C[i][0] == if matches!(self, Self::Lower) { 1 } else { -1 } {
                directions[k] = i;
                k += 1;
            }
            i += 1;
        }
        directions
    }

    /// Number of a direction among these.
    pub const fn number_of(self, i: usize) -> usize {
        let mut k = 0;
        while self.directions()[k] != i {
            k += 1;
        }
        k
    }

    /// Index, among the two pieces of a direction, of the cells beside the last one of the row.
    #[inline(always)]
    pub const fn others(self) -> usize {
        match self {
            Self::Lower => 1,
            Self::Upper => 0,
        }
    }

    /// End that a line with these pieces holds; `None` unless five directions have two pieces each,
    /// as at an end. `all` has the bits of all lanes.
    pub fn of(pieces: &[Piece], all: u16) -> Option<Self> {
        let last = all ^ all >> 1;
        [(Self::Lower, [1, all ^ 1]), (Self::Upper, [all ^ last, last])].into_iter().find_map(
            |(end, lanes)| {
                let expected =
                    end.directions().into_iter().flat_map(|i| lanes.map(|lanes| (i, lanes)));
                let found = pieces.iter().map(|piece| (usize::from(piece.dir), piece.lanes));
                expected.eq(found).then_some(end)
            },
        )
    }
}
