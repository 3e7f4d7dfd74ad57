//! Gaps whose walls slip: where they do, and whose walls they are.

use super::{ModelledGaps, Wall};
use crate::bodies::body_list::Bodies;
use std::ops::Range;

impl ModelledGaps {
    /// Axis across the gap of a fluid cell whose walls slip; `None` if they do not.
    pub fn slips_at(&self, cell: u32) -> Option<usize> {
        let gap = &self.gaps[usize::from(self.of(cell)?)];
        let candidate = self.candidate(cell)?;
        (candidate.thickness < gap.slip_below).then(|| usize::from(candidate.axis))
    }

    /// True if the gap of a cell holds one layer of cells.
    pub fn is_one_cell(&self, cell: u32) -> bool {
        self.candidate(cell).is_some_and(|candidate| candidate.thickness < 1.5)
    }

    /// Numbers of cells that may be in gaps, by item of work.
    pub fn items(&self) -> impl Iterator<Item = usize> {
        self.items.iter().map(Range::len)
    }

    /// The cells of an item.
    pub fn cells_of(&self, item: usize) -> impl Iterator<Item = u32> {
        self.item(item).iter().map(|candidate| candidate.cell)
    }

    /// The side that stands still of the gap of a cell.
    pub fn still_side_at(&self, cell: u32) -> Option<usize> {
        self.still_side(self.of(cell)?)
    }

    /// True if a body is a side of the gap of a cell.
    pub fn is_side_at(&self, cell: u32, bodies: &Bodies, handle: u32) -> bool {
        let part = bodies.with_handle(handle).part.as_ref().map(|part| Wall::Part(part.index));
        let gap = self.of(cell).map(|gap| &self.gaps[usize::from(gap)]);
        gap.zip(part).is_some_and(|(gap, part)| gap.sides.contains(&part))
    }

    /// True if the walls of any gap may slip.
    pub fn any_slips(&self) -> bool {
        self.gaps.iter().any(|gap| gap.slip_below > 0.0)
    }
}
