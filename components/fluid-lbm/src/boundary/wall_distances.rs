//! Distances of walls at rest along links. They are found once, when the first body comes, for the
//! gap links that end there in any step.

use crate::lattice::aa_pattern::Blocked;
use crate::lattice::cell_list::BoundaryId;

/// Distance of one solid along one link. 8 bytes.
#[derive(Clone, Copy, Debug)]
struct WallDistance {
    /// As a fraction of the link, to 7 digits: a wall is nowhere known better.
    q: f32,
    fixture: u16,
    /// Direction of the link, out of the fluid.
    dir: u8,
}

/// Distances of solids at rest along the links of all cells.
#[derive(Clone, Debug, Default)]
pub struct WallDistances {
    cells: Vec<u32>,
    /// First meeting of each cell, and the end.
    first: Vec<u32>,
    meetings: Vec<WallDistance>,
}

impl WallDistances {
    /// Of blocked links in the order of cells, with the `q` of each.
    pub fn new(blocked: impl Iterator<Item = (Blocked, f64)>) -> Self {
        let mut own = Self::default();
        for (Blocked { cell, dir, fixture: BoundaryId(fixture) }, q) in blocked {
            if own.cells.last() != Some(&cell) {
                own.cells.push(cell);
                own.first.push(own.meetings.len() as u32);
            }
            own.meetings.push(WallDistance { q: q as f32, fixture, dir });
        }
        own.first.push(own.meetings.len() as u32);
        own
    }

    /// True if they were never found.
    pub fn is_empty(&self) -> bool {
        self.first.is_empty()
    }

    /// Solid at rest that the link `i` of a cell meets first, and its distance as part of the link.
    pub fn meet(&self, cell: u32, i: usize) -> Option<(BoundaryId, f64)> {
        let place = self.cells.binary_search(&cell).ok()?;
        let [first, end] = [self.first[place] as usize, self.first[place + 1] as usize];
        let own = self.meetings[first..end].iter().find(|own| usize::from(own.dir) == i)?;
        Some((BoundaryId(own.fixture), own.q.into()))
    }

    /// Memory that they take [bytes].
    pub fn bytes(&self) -> usize {
        size_of_val(self.cells.as_slice())
            + size_of_val(self.first.as_slice())
            + size_of_val(self.meetings.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_finds_its_own_wall() {
        let link = |cell, dir, solid| Blocked { cell, dir, fixture: BoundaryId::solid(solid) };
        let all = [(link(3, 1, 0), 0.25), (link(3, 7, 1), 0.5), (link(9, 1, 1), 0.75)];
        let walls = WallDistances::new(all.into_iter());
        assert_eq!(walls.meet(3, 7), Some((BoundaryId::solid(1), 0.5)));
        assert_eq!(walls.meet(9, 1), Some((BoundaryId::solid(1), 0.75)));
        assert_eq!((walls.meet(9, 7), walls.meet(4, 1)), (None, None));
    }
}
