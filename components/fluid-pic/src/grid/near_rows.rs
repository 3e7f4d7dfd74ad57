//! Rows of cells near particles: what is farther away is air, and stays as it is.

use crate::grid::cell_rows::CellRows;
use crate::grid::staggered_grid::StaggeredGrid;
use std::ops::Range;

/// Cells around those with particles that a step may reach: a hat reaches one, velocities three
/// beyond.
const MARGIN: usize = 5;

/// The rows near particles, now and in the step before.
#[derive(Clone, Debug, Default)]
pub struct NearRows {
    now: CellRows,
    before: CellRows,
    /// Without ghosts.
    inside: CellRows,
    /// Cells that were near and are not.
    left: Vec<Range<usize>>,
    /// First and last cell with particles of each row, and beyond; none where the first is larger.
    of_row: Vec<[u32; 2]>,
    spread: Vec<[u32; 2]>,
}

/// No cell.
const NONE: [u32; 2] = [u32::MAX, 0];

impl NearRows {
    /// Finds the rows, given where particles are in rows; with `all`, every row is near.
    pub fn find<const D: usize>(
        &mut self,
        grid: &StaggeredGrid<D>,
        all: bool,
        places: impl Iterator<Item = u32>,
    ) {
        std::mem::swap(&mut self.now, &mut self.before);
        self.find_rows(grid, all || grid.is_periodic(), places);
        self.find_inside(grid);
        self.find_left();
    }

    fn find_rows<const D: usize>(
        &mut self,
        grid: &StaggeredGrid<D>,
        all: bool,
        places: impl Iterator<Item = u32>,
    ) {
        let row = grid.row_length();
        if all {
            self.now.rebuild_spans(grid.stored, row, |start| Some(start..start + row));
            return;
        }
        self.of_row.clear();
        self.of_row.resize(grid.stored / row, NONE);
        for place in places {
            let [first, last] = &mut self.of_row[place as usize / row];
            (*first, *last) = ((*first).min(place % row as u32), (*last).max(place % row as u32));
        }
        for a in 1..D {
            self.spread_along(grid.stride[a] / row, grid, a);
        }
        let of_row = &self.of_row;
        self.now.rebuild_spans(grid.stored, row, |start| {
            let [first, last] = of_row[start / row];
            if first > last {
                return None;
            }
            let first = (first as usize).saturating_sub(MARGIN);
            Some(start + first..start + (last as usize + MARGIN + 1).min(row))
        });
    }

    fn find_inside<const D: usize>(&mut self, grid: &StaggeredGrid<D>) {
        let row = grid.row_length();
        let mut near = self.now.all_spans().peekable();
        self.inside.rebuild_spans(grid.stored, row, |start| {
            let span = near.next_if(|span| span.start < start + row)?;
            let at = grid.cell_at(start + 1);
            let is_inside = (1..D).all(|a| at[a] >= 0 && at[a] < grid.cells[a] as isize);
            let clipped = span.start.max(start + 1)..span.end.min(start + 1 + grid.cells[0]);
            (is_inside && !clipped.is_empty()).then_some(clipped)
        });
    }

    fn find_left(&mut self) {
        let Self { now, before, left, .. } = self;
        left.clear();
        let mut near = now.all_spans().peekable();
        for old in before.all_spans() {
            while near.next_if(|span| span.end <= old.start).is_some() {}
            // A row has one span: at most one of those now meets an old one.
            match near.peek() {
                Some(span) if span.start < old.end => {
                    left.push(old.start..span.start.max(old.start));
                    left.push(span.end.min(old.end)..old.end);
                }
                _ => left.push(old),
            }
        }
    }

    /// Gives rows what the rows near them along an axis have.
    fn spread_along<const D: usize>(
        &mut self,
        stride: usize,
        grid: &StaggeredGrid<D>,
        axis: usize,
    ) {
        let end = if axis + 1 < D { grid.stride[axis + 1] } else { grid.stored };
        let stored = end / grid.stride[axis];
        let Self { of_row, spread, .. } = self;
        spread.clear();
        spread.resize(of_row.len(), NONE);
        for (number, own) in spread.iter_mut().enumerate() {
            let along = number / stride % stored;
            let first = along.saturating_sub(MARGIN);
            let last = (along + MARGIN).min(stored - 1);
            for other in first..=last {
                let [low, high] = of_row[number - along * stride + other * stride];
                if low <= high {
                    *own = [own[0].min(low), own[1].max(high)];
                }
            }
        }
        std::mem::swap(of_row, spread);
    }

    /// Ranges of stored cells near particles, ghosts included.
    pub fn spans(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        self.now.all_spans()
    }

    /// Stored cells near particles that are no ghosts.
    pub fn cells(&self) -> impl Iterator<Item = usize> + '_ {
        self.inside.all_spans().flatten()
    }

    /// Ranges near particles now, and those that were near in the step before and are not.
    pub fn touched(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        self.spans().chain(self.left.iter().cloned())
    }

    /// Gives a value to the cells that were near in the step before, and are not now.
    pub fn clear_left<T: Copy>(&self, values: &mut [T], value: T) {
        for span in &self.left {
            values[span.clone()].fill(value);
        }
    }

    /// All rows of a grid.
    #[cfg(test)]
    pub fn whole<const D: usize>(grid: &StaggeredGrid<D>) -> Self {
        let mut near = Self::default();
        near.find(grid, true, std::iter::empty());
        near
    }

    /// Gives a value to the cells near.
    pub fn fill<T: Copy>(&self, values: &mut [T], value: T) {
        for span in self.spans() {
            values[span].fill(value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_reach_five_cells_around() {
        let grid = StaggeredGrid::<3>::new([40, 30, 20], 0.1, [0.0; 3], [false; 3]);
        let mut near = NearRows::default();
        let centre = [20, 10, 3];
        near.find(&grid, false, [grid.place(centre) as u32].into_iter());
        let is_near: Vec<bool> = {
            let mut all = vec![false; grid.stored];
            near.fill(&mut all, true);
            all
        };
        for at in grid.all() {
            let expected = (0..3).all(|a| (at[a] - centre[a]).abs() <= 5);
            assert_eq!(is_near[grid.place(at)], expected, "{at:?}");
        }
        near.find(&grid, false, std::iter::empty());
        assert_eq!(near.spans().count(), 0);
        let mut left = is_near;
        near.clear_left(&mut left, false);
        assert!(!left.contains(&true));
        near.find(&grid, true, std::iter::empty());
        assert_eq!(near.spans().map(|span| span.len()).sum::<usize>(), grid.stored);
    }
}
