//! Cells that solids cover, and solids thinner than a cell.

/// A thin solid between two cells of the fluid: the link `dir` of the cell `cell` of the box ends
/// at it. Both cells have such a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Sheet {
    /// Index of the cell in the box.
    pub cell: u32,
    /// Direction of the link.
    pub dir: u8,
    /// Index of the static solid.
    pub solid: u16,
}

/// Static solids in a box.
#[derive(Clone, Debug, Default)]
pub struct Obstacles {
    /// For each cell of the box, 0 for fluid, else 1 more than the number of the solid. Empty if
    /// all is fluid.
    pub solid: Vec<u16>,
    /// Thin solids, sorted.
    pub sheets: Vec<Sheet>,
}
