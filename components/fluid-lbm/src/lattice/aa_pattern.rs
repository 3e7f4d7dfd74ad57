//! Places of the populations of each cell in even and in odd steps.
//!
//! The pattern "AA" of Bailey et al. 2009 on a list of cells. `A[i][x]` is plane `i` of the array
//! at cell `x`; a *place* is one index into the array, `plane * stride + cell`. A collision reads
//! `f_i` of a cell from its place of direction `i` and leaves `g_i` in the place of the opposite
//! direction `i'`. In even steps these are the cell's own places, `A[i][x]`. In odd steps they
//! depend on where the link from `x` against `i` comes from:
//!
//! ```text
//! from a cell y = x - c_i, maybe through a periodic face:    A[i'][y]
//! from a cell y through a mirror, m the mirrored direction:  A[m(i)'][y]
//! from a wall or an open face:                               A[i][x]
//! ```
//!
//! The third is reflection half-way: the next step finds `g_i'(x)` as `f_i(x)`. No other cell has a
//! use for that place, because the one that would have (`x - c_i`) is not there. Everything else
//! that may happen at such a link (a curved wall, a moving wall, an open face) works in place on
//! that one number.
//!
//! Cells come in lines of 64 bytes. Where the odd places of a whole line are consecutive, one
//! number says where they begin; else a list of pieces does.

mod build;

use crate::lattice::aa_rows::Way;
use crate::lattice::cell_list::BoundaryId;
use crate::lattice::d3q19::{OPPOSITE, Q};
use crate::lattice::populations::prefetch;

pub use self::build::stride;

/// Parity of an in-place step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parity {
    /// Reads and writes within a cell.
    Even,
    /// Reads from and writes to the neighbours.
    Odd,
}

impl Parity {
    /// That of the step after so many.
    pub fn after(steps: u64) -> Self {
        if steps.is_multiple_of(2) { Self::Even } else { Self::Odd }
    }

    /// The other one.
    #[inline]
    pub fn flipped(self) -> Self {
        match self {
            Self::Even => Self::Odd,
            Self::Odd => Self::Even,
        }
    }
}

/// Some cells of a line whose odd places are `place + lane`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Piece {
    /// Place of the first lane of the line, whether it belongs to the piece or not.
    pub place: u32,
    /// Bits of the lanes.
    pub lanes: u16,
    /// Direction.
    pub dir: u8,
    /// True if this is the last piece of its line and direction.
    pub last: bool,
}

/// Pieces of a line, the first number that a sweep reads of it. The pieces of directions in two
/// pieces come first, then those of directions in three, as almost all are, then the others. So
/// loops over them have no branch that is hard to foresee.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Kind {
    /// The first of its pieces.
    pub first: u32,
    /// Directions in two pieces.
    pub two: u8,
    /// Directions in three pieces.
    pub three: u8,
    /// Directions in other numbers of pieces.
    pub others: u8,
}

impl Kind {
    /// True if a direction of the line is in pieces.
    #[inline(always)]
    pub fn is_in_pieces(self) -> bool {
        self.two + self.three + self.others != 0
    }
}

/// Reflecting links of one line and direction: those whose population `f_i`, once streamed, is in
/// `place + lane` in either parity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reflection {
    /// Place of the first lane of the line, whether it reflects or not.
    pub place: u32,
    /// Cell that holds the place of the first lane; another than the line's behind a mirror, where
    /// it may be negative.
    pub mirror_cell: i32,
    /// Line.
    pub line: u32,
    /// Bits of the lanes.
    pub lanes: u16,
    /// Direction `i` of the reflected populations, into the fluid.
    pub dir: u8,
    /// Axes at which the link is mirrored; 0 at a wall.
    pub mirrors: u8,
    /// Whom the link meets; of no meaning for a mirror.
    pub fixture: BoundaryId,
}

/// A link that ends at something that stands still and is not done by reflection half-way alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Blocked {
    /// Cell where the link begins.
    pub cell: u32,
    /// Direction of the link, out of the fluid.
    pub dir: u8,
    /// Whom it meets.
    pub fixture: BoundaryId,
}

/// The table of places.
#[derive(Clone, Debug)]
pub struct AaPattern {
    /// Numbers from one plane to the next.
    stride: usize,
    /// Cells in a line: 2 to this power. Division would cost more than the look-up.
    line_bits: u32,
    /// For each line: bits of the directions that are in pieces, then for each direction the odd
    /// place of its first cell, or that of most of the line at an end of a row, or the first of its
    /// pieces.
    lines: Vec<[u32; Q]>,
    kinds: Vec<Kind>,
    /// For each line, and as many after the last as a sweep looks ahead.
    ways: Vec<Way>,
    pieces: Vec<Piece>,
}

/// Links that end at fixtures, found while the table is built.
#[derive(Debug, Default)]
pub struct BlockedLinks {
    /// Reflecting links, by line.
    pub reflections: Vec<Reflection>,
    /// Links at fixtures for which `special` was true, by cell.
    pub blocked: Vec<Blocked>,
}

impl AaPattern {
    /// Numbers from one plane to the next.
    #[inline(always)]
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// The table, see [`AaPattern`].
    #[inline(always)]
    pub fn lines(&self) -> &[[u32; Q]] {
        &self.lines
    }

    /// See [`Kind`].
    #[inline(always)]
    pub fn kind(&self, line: usize) -> Kind {
        self.kinds[line]
    }

    /// Way to a line in a sweep. [`Way::AHEAD`] lines after the last may be asked for, too.
    #[inline(always)]
    pub fn way(&self, line: usize) -> Way {
        self.ways[line]
    }

    /// The end, up to `end`, of the run of lines from `first` on within which each line's odd
    /// places follow those of the line before. `WITH_ENDS`: ends of rows may be among them.
    #[inline(always)]
    pub fn run_end<const WITH_ENDS: bool>(&self, first: usize, end: usize) -> usize {
        prefetch(self.ways.as_ptr().wrapping_add(first + 256));
        let goes_on = |way: &&Way| way.follows && (WITH_ENDS || way.row_end.is_none());
        let ways = &self.ways[first..end];
        if !WITH_ENDS && ways[0].row_end.is_some() {
            return first + 1;
        }
        first + 1 + ways[1..].iter().take_while(goes_on).count()
    }

    /// The pieces to which the table's lines point.
    #[inline(always)]
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// Place at which the collision of a parity reads `f_i` of a cell. It leaves `g_i` in the place
    /// of the opposite direction.
    #[inline(always)]
    pub fn of(&self, parity: Parity, cell: u32, i: usize) -> usize {
        match parity {
            Parity::Even => i * self.stride + cell as usize,
            Parity::Odd => self.odd(cell, i),
        }
    }

    /// The line of a cell, and its lane there.
    #[inline(always)]
    fn line_and_lane(&self, cell: usize) -> (usize, usize) {
        (cell >> self.line_bits, cell & ((1 << self.line_bits) - 1))
    }

    /// [`AaPattern::of`] in all directions.
    #[inline(always)]
    pub fn of_cell(&self, parity: Parity, cell: u32) -> [usize; Q] {
        let cell = cell as usize;
        if parity == Parity::Even {
            return std::array::from_fn(|i| i * self.stride + cell);
        }
        let (line, lane) = self.line_and_lane(cell);
        let entries = &self.lines[line];
        let mut places = entries.map(|entry| entry as usize + lane);
        places[0] = cell;
        let mut mixed = entries[0];
        while mixed != 0 {
            let i = mixed.trailing_zeros() as usize;
            mixed &= mixed - 1;
            places[i] = self.in_pieces(line, i, lane);
        }
        places
    }

    /// [`AaPattern::of`] in odd steps.
    #[inline(always)]
    pub fn odd(&self, cell: u32, i: usize) -> usize {
        let cell = cell as usize;
        let (line, lane) = self.line_and_lane(cell);
        let entries = &self.lines[line];
        if i == 0 {
            return cell;
        }
        if entries[0] >> i & 1 == 0 {
            return entries[i] as usize + lane;
        }
        self.in_pieces(line, i, lane)
    }

    /// [`AaPattern::of`] of the first cell of a line, if those of the others follow it.
    #[inline(always)]
    pub fn of_line(&self, parity: Parity, line: usize, i: usize) -> Option<usize> {
        let first = line << self.line_bits;
        if parity == Parity::Even || i == 0 {
            return Some(i * self.stride + first);
        }
        let entries = &self.lines[line];
        (entries[0] >> i & 1 == 0).then(|| entries[i] as usize)
    }

    /// Gives [`AaPattern::of`] of `count` cells of one line that follow each other, after the
    /// number of each among them.
    #[inline(always)]
    pub fn each_of(
        &self,
        parity: Parity,
        (first, count): (u32, usize),
        i: usize,
        mut give: impl FnMut(usize, usize),
    ) {
        let (line, lane) = self.line_and_lane(first as usize);
        if let Some(place) = self.of_line(parity, line, i) {
            (0..count).for_each(|k| give(k, place + lane + k));
            return;
        }
        for piece in self.pieces_of(line, i) {
            let mut lanes = u32::from(piece.lanes) >> lane & ((1 << count) - 1);
            while lanes != 0 {
                let k = lanes.trailing_zeros() as usize;
                lanes &= lanes - 1;
                give(k, piece.place as usize + lane + k);
            }
            if piece.last {
                break;
            }
        }
    }

    /// Cells that follow each other in one line, as [`AaPattern::each_of`] takes them: the first,
    /// and how many.
    pub fn runs(&self, cells: &[u32]) -> impl Iterator<Item = (u32, usize)> {
        let line = |cell: u32| cell >> self.line_bits;
        let follow = move |a: &u32, b: &u32| *b == *a + 1 && line(*a) == line(*b);
        cells.chunk_by(follow).map(|run| (run[0], run.len()))
    }

    /// Asks memory for what [`AaPattern::odd`] reads for some cells in a row.
    #[inline(always)]
    pub fn prefetch(&self, first: u32, count: u32) {
        let [begin, end] = [first, first + count].map(|cell| cell as usize >> self.line_bits);
        let table = self.lines.as_ptr().cast::<u8>();
        for byte in (begin * size_of::<[u32; Q]>()..(end + 1) * size_of::<[u32; Q]>()).step_by(64) {
            prefetch(table.wrapping_add(byte));
        }
    }

    /// The list that begins with the pieces of a direction of a line that is in pieces there.
    #[inline(always)]
    pub fn pieces_of(&self, line: usize, i: usize) -> &[Piece] {
        let first = match self.ways[line].row_end {
            Some(end) => self.kinds[line].first as usize + 2 * end.number_of(i),
            None => self.lines[line][i] as usize,
        };
        &self.pieces[first..]
    }

    /// The odd place of a lane whose line is in pieces.
    fn in_pieces(&self, line: usize, i: usize, lane: usize) -> usize {
        let own = self.pieces_of(line, i).iter().find(|p| p.lanes >> lane & 1 == 1);
        own.expect("every lane is in a piece").place as usize + lane
    }

    /// The cell to which the link along `i` leads, if it ends in a cell. A link that a mirror sends
    /// back to the cell where it began counts as ended there.
    #[inline]
    pub fn neighbour(&self, cell: u32, i: usize) -> Option<u32> {
        self.leads_to(cell, i, self.odd(cell, OPPOSITE[i]))
    }

    /// The cells to which the links of a cell lead, in the order of directions; see
    /// [`AaPattern::neighbour`].
    #[inline]
    pub fn neighbours(&self, cell: u32) -> impl Iterator<Item = u32> {
        let places = self.of_cell(Parity::Odd, cell);
        (1..Q).filter_map(move |i| self.leads_to(cell, i, places[OPPOSITE[i]]))
    }

    /// Cell to which the link `i` of a cell leads, given the odd place of the population that comes
    /// back along it; `None` at a fixture.
    #[inline(always)]
    fn leads_to(&self, cell: u32, i: usize, place: usize) -> Option<u32> {
        if place == OPPOSITE[i] * self.stride + cell as usize {
            return None;
        }
        // Mostly the plane of the link itself; another behind a mirror.
        let plain = place.wrapping_sub(i * self.stride);
        Some(if plain < self.stride { plain } else { place % self.stride } as u32)
    }

    /// Memory that the table takes [bytes].
    pub fn bytes(&self) -> usize {
        size_of_val(self.lines.as_slice())
            + size_of_val(self.kinds.as_slice())
            + size_of_val(self.ways.as_slice())
            + size_of_val(self.pieces.as_slice())
    }
}

#[cfg(test)]
mod tests;
