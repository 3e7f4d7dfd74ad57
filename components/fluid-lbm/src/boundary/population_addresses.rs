//! Places of the populations of a link.

use crate::lattice::aa_pattern::Parity;
use crate::lattice::cell_flags::CellFlags;
use crate::lattice::d3q19::OPPOSITE;
use crate::lattice::layout::Layout;

/// A cell that there is not.
const NONE: u32 = u32::MAX;

/// Places of the populations of a link `i` from a cell `x`, `i'` being the opposite direction; see
/// `aa_pattern`.
#[derive(Clone, Copy, Debug)]
pub struct PopulationAddresses {
    /// The cell where it begins.
    pub cell: u32,
    /// The cell behind, against the link; the cell itself where the link sees itself in a mirror.
    behind: u32,
    /// Places at which even and odd steps find `f_i'(x)` and leave `g_i(x)`.
    back: [u32; 2],
    /// Places at which they find `f_i(x)` and leave `g_i'(x)`.
    along: [u32; 2],
}

impl PopulationAddresses {
    /// Of a link that begins in no stored cell.
    pub const NONE: Self = Self { cell: NONE, behind: NONE, back: [NONE; 2], along: [NONE; 2] };

    /// Those of the link `i` of a cell.
    pub fn new(layout: &Layout, cell: u32, i: usize) -> Self {
        let of = |i: usize| {
            [Parity::Even, Parity::Odd].map(|parity| layout.place(parity, cell, i) as u32)
        };
        let behind = layout.behind(cell, i).unwrap_or(NONE);
        Self { cell, behind, back: of(OPPOSITE[i]), along: of(i) }
    }

    /// Place at which the collision of a parity left `g_i(x)`.
    #[inline(always)]
    pub fn own(&self, parity: Parity) -> usize {
        self.back[usize::from(parity == Parity::Odd)] as usize
    }

    /// Place at which the next collision finds `f_i'(x)`.
    #[inline(always)]
    pub fn result(&self, parity: Parity) -> usize {
        self.back[usize::from(parity == Parity::Even)] as usize
    }

    /// Place at which the collision of a parity left `g_i'(x)`, or `g_i(x - c_i)`, which comes to
    /// `x` from behind.
    #[inline(always)]
    pub fn other(&self, parity: Parity, from_behind: bool) -> usize {
        self.along[usize::from(from_behind == (parity == Parity::Even))] as usize
    }

    /// True if there is a cell behind, and it is fluid.
    #[inline(always)]
    pub fn is_behind_fluid(&self, flags: &CellFlags) -> bool {
        let is_there = self.behind != NONE;
        // Any cell in its place spares a branch.
        flags.is_fluid(if is_there { self.behind } else { self.cell }) & is_there
    }
}
