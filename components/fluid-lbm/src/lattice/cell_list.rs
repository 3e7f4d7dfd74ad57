//! Stored cells of the box, and the obstacles around them.
//!
//! Only cells that no static solid covers are stored. They have numbers in the order of the box, x
//! running fastest; everything that is kept for cells is an array over these numbers.

use crate::lattice::d3q19::C;
use tremie_fluid_kit::cells::grid::{Grid, Reach};
use tremie_fluid_kit::cells::obstacles::Obstacles;

/// Number of a cell of the box that is not stored.
pub const NONE: u32 = u32::MAX;

/// Whom a link meets that leaves the fluid: a face of the domain or a static solid.
///
/// Faces come first, `2 axis + side`; then the solids of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct BoundaryId(pub u16);

impl BoundaryId {
    /// Number of faces.
    pub const FACES: u16 = 6;

    /// A face of the domain.
    pub fn face(axis: usize, side: usize) -> Self {
        Self((2 * axis + side) as u16)
    }

    /// A static solid.
    pub fn solid(number: u16) -> Self {
        Self(Self::FACES + number)
    }

    /// Index of the solid, unless it is a face.
    pub fn as_solid(self) -> Option<usize> {
        self.0.checked_sub(Self::FACES).map(usize::from)
    }
}

/// End of a link from a stored cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkEnd {
    /// In a stored cell, through a mirror at the axes whose bits are set.
    Cell {
        /// Its number.
        cell: u32,
        /// Axes at which the way was mirrored.
        mirrors: u8,
    },
    /// At something that stands still.
    BoundaryId(BoundaryId),
}

/// Stored cells among 32 consecutive cells of the box.
#[derive(Clone, Copy, Debug, Default)]
struct Word {
    bits: u32,
    /// Stored cells before these.
    before: u32,
}

/// The stored cells.
#[derive(Clone, Debug)]
pub struct CellList {
    /// Stored cells of the box, a bit each. The number of a stored cell is the count of those
    /// before it.
    words: Vec<Word>,
    /// For each stored cell its index in the box.
    at: Vec<u32>,
    /// What links meet that end in a cell which is left out, though no solid covers it.
    beyond: BoundaryId,
}

impl CellList {
    /// Numbers the cells that are not solid and that `holds` wants, by their numbers among all that are not solid.
    /// Links into others of these end `beyond`.
    pub fn new(
        grid: &Grid,
        obstacles: &Obstacles,
        (holds, beyond): (impl Fn(u32) -> bool, BoundaryId),
    ) -> Self {
        let boxed = grid.len();
        let is_fluid = |index: usize| obstacles.solid.get(index).is_none_or(|&s| s == 0);
        let all = (0..boxed).filter(|&index| is_fluid(index));
        let held = (0..).zip(all).filter(|&(number, _)| holds(number));
        let at: Vec<u32> = held.map(|(_, index)| index as u32).collect();
        let mut words = vec![Word::default(); boxed.div_ceil(32)];
        for &index in &at {
            words[index as usize / 32].bits |= 1 << (index % 32);
        }
        let mut before = 0;
        for word in &mut words {
            word.before = before;
            before += word.bits.count_ones();
        }
        Self { words, at, beyond }
    }

    /// Number of stored cells.
    pub fn len(&self) -> usize {
        self.at.len()
    }

    /// Number of the cell with an index in the box, or [`NONE`].
    #[inline(always)]
    pub fn number(&self, index: usize) -> u32 {
        let word = self.words[index / 32];
        let bit = 1 << (index % 32);
        if word.bits & bit == 0 { NONE } else { word.before + (word.bits & (bit - 1)).count_ones() }
    }

    /// Number of a cell of the box, if it is stored.
    #[inline]
    pub fn at(&self, grid: &Grid, at: [i32; 3]) -> Option<u32> {
        let number = self.number(grid.index(at));
        (number != NONE).then_some(number)
    }

    /// Index in the box of a stored cell.
    #[inline(always)]
    pub fn index(&self, cell: u32) -> usize {
        self.at[cell as usize] as usize
    }

    /// Coordinates of a stored cell.
    #[inline]
    pub fn coordinates(&self, grid: &Grid, cell: u32) -> [i32; 3] {
        grid.at(self.index(cell))
    }

    /// End of the link along `i` from a cell at `at`, sheets not counted.
    pub fn end(&self, grid: &Grid, obstacles: &Obstacles, at: [i32; 3], i: usize) -> LinkEnd {
        match grid.reach(std::array::from_fn(|a| at[a] + C[i][a])) {
            Reach::Face { axis, side } => LinkEnd::BoundaryId(BoundaryId::face(axis, side)),
            Reach::Cell { at, mirrors } => match self.at(grid, at) {
                Some(cell) => LinkEnd::Cell { cell, mirrors },
                None => LinkEnd::BoundaryId(self.unstored(obstacles, grid.index(at))),
            },
        }
    }

    /// True if links meet this where they end in a cell that is left out.
    pub fn is_beyond(&self, fixture: BoundaryId) -> bool {
        fixture == self.beyond
    }

    /// What a link meets that ends in a cell which is not stored.
    fn unstored(&self, obstacles: &Obstacles, index: usize) -> BoundaryId {
        let solid = obstacles.solid.get(index).and_then(|solid| solid.checked_sub(1));
        solid.map_or(self.beyond, BoundaryId::solid)
    }

    /// Memory that the tables take [bytes].
    pub fn bytes(&self) -> usize {
        size_of_val(self.words.as_slice()) + size_of_val(self.at.as_slice())
    }
}
