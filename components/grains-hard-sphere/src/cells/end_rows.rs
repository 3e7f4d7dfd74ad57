//! Where bodies are when a step ends, in the order of their cells: those of a row of cells lie side
//! by side in memory, so that a search reads them one after the other.

use crate::Vec3;
use crate::cells::body_cells::BodyCells;
use core::ops::Range;

/// A body at the end of a step.
#[derive(Clone, Copy, Debug)]
struct EndPoint {
    /// Centre [m].
    x: Vec3,
    /// Radius [m].
    radius: f64,
    body: u32,
}

/// Points of cells that follow each other, and the shift at which they are seen [m].
type Stretch = (Range<usize>, Vec3);

/// The ends of all bodies' ways, by cells.
#[derive(Debug)]
pub struct EndRows {
    points: Vec<EndPoint>,
    /// Where the points of each cell begin, and how many there are in all.
    begins: Vec<u32>,
}

impl EndRows {
    /// Room for so many bodies in cells.
    pub fn new(cells: &BodyCells, bodies: usize) -> Self {
        let nowhere = EndPoint { x: Vec3::zeros(), radius: 0.0, body: 0 };
        let slots = cells.count.iter().product::<usize>();
        Self { points: vec![nowhere; bodies], begins: vec![0; slots + 2] }
    }

    /// Sorts the bodies by the cells that they are in, within a cell by their numbers.
    pub fn fill(&mut self, cells: &BodyCells, ends: &[Vec3], radius: impl Fn(usize) -> f64) {
        // Counted two places further on: after the sum a cell's place holds where its next point
        // goes, and once all are there the beginning of the cell that follows.
        self.begins.fill(0);
        for body in 0..ends.len() {
            self.begins[cells.slot(cells.home(body)) + 2] += 1;
        }
        let mut sum = 0;
        for begin in &mut self.begins {
            sum += *begin;
            *begin = sum;
        }
        for (body, &x) in ends.iter().enumerate() {
            let place = &mut self.begins[cells.slot(cells.home(body)) + 1];
            self.points[*place as usize] = EndPoint { x, radius: radius(body), body: body as u32 };
            *place += 1;
        }
    }

    /// Number of rows of cells along x.
    pub fn rows(cells: &BodyCells) -> usize {
        cells.count[1] * cells.count[2]
    }

    /// Visits pairs that overlap, of a body in a row of cells and one in it or in a row after it:
    /// over all rows each pair once.
    pub fn overlaps(&self, cells: &BodyCells, row: usize, mut meet: impl FnMut(usize, usize)) {
        let (after, count) = rows_after(cells, row);
        let nx = cells.count[0];
        let own = self.begins_of(row, nx);
        let others = after.map(|(other, shift)| (self.begins_of(other, nx), shift));
        for x in 0..nx {
            let (first, end) = (own[x] as usize, own[x + 1] as usize);
            if first == end {
                continue;
            }
            let up_to = (x + 2).min(nx);
            for k in first..end {
                self.look(k, &(k + 1..own[up_to] as usize, Vec3::zeros()), &mut meet);
            }
            for (begins, shift) in &others[..count] {
                let range = begins[x.saturating_sub(1)] as usize..begins[up_to] as usize;
                for k in first..end {
                    self.look(k, &(range.clone(), *shift), &mut meet);
                }
            }
            if x == 0 || x + 1 == nx {
                self.overlaps_around(cells, (row, x), &after[..count], &mut meet);
            }
        }
    }

    /// Those of the overlaps that go across a periodic face along x.
    fn overlaps_around(
        &self,
        cells: &BodyCells,
        (row, x): (usize, usize),
        after: &[(usize, Vec3)],
        meet: &mut impl FnMut(usize, usize),
    ) {
        let home = self.points_of(row, cells, x);
        let mut look = |other: usize, (cell, along): (usize, Vec3), shift: &Vec3| {
            let stretch = (self.points_of(other, cells, cell), along + shift);
            home.clone().for_each(|k| self.look(k, &stretch, meet));
        };
        let next = (x + 1 == cells.count[0]).then(|| above(cells, x, 0)).flatten();
        let last = (x == 0).then(|| below(cells, x, 0)).flatten();
        if let Some(next) = next {
            look(row, next, &Vec3::zeros());
        }
        for (other, shift) in after {
            next.into_iter().chain(last).for_each(|cell| look(*other, cell, shift));
        }
    }

    /// Finds those of a stretch that overlap with a point.
    #[inline(always)]
    fn look(&self, k: usize, (range, shift): &Stretch, meet: &mut impl FnMut(usize, usize)) {
        let point = &self.points[k];
        let from = point.x - shift;
        for other in &self.points[range.clone()] {
            let reach = point.radius + other.radius;
            if (other.x - from).norm_squared() < reach * reach {
                meet(point.body as usize, other.body as usize);
            }
        }
    }

    /// Where the points of each cell of a row begin, and where those of the last end.
    #[inline(always)]
    fn begins_of(&self, row: usize, nx: usize) -> &[u32] {
        &self.begins[row * nx..(row + 1) * nx + 1]
    }

    /// The points of a cell of a row.
    fn points_of(&self, row: usize, cells: &BodyCells, x: usize) -> Range<usize> {
        let begins = &self.begins[row * cells.count[0] + x..];
        begins[0] as usize..begins[1] as usize
    }
}

/// The rows that come after one and are beside it, and the shifts at which they are seen.
fn rows_after(cells: &BodyCells, row: usize) -> ([(usize, Vec3); 4], usize) {
    let ny = cells.count[1];
    let (y, z) = (row % ny, row / ny);
    let (mut rows, mut count) = ([(0, Vec3::zeros()); 4], 0);
    let mut add = |y: usize, z: usize, shift: Vec3| {
        rows[count] = (z * ny + y, shift);
        count += 1;
    };
    let next_y = above(cells, y, 1);
    if let Some((y, shift)) = next_y {
        add(y, z, shift);
    }
    if let Some((z, up)) = above(cells, z, 2) {
        let beside = [below(cells, y, 1), Some((y, Vec3::zeros())), next_y];
        for (y, shift) in beside.into_iter().flatten() {
            add(y, z, shift + up);
        }
    }
    (rows, count)
}

/// The cell above one along an axis, and the shift at which what is in it is seen.
fn above(cells: &BodyCells, cell: usize, axis: usize) -> Option<(usize, Vec3)> {
    seen(cells, cell, axis, true)
}

/// The cell below one.
fn below(cells: &BodyCells, cell: usize, axis: usize) -> Option<(usize, Vec3)> {
    seen(cells, cell, axis, false)
}

#[inline(always)]
fn seen(cells: &BodyCells, cell: usize, axis: usize, is_up: bool) -> Option<(usize, Vec3)> {
    let (next, lengths) = cells.step(cell as u16, axis, is_up)?;
    let mut shift = Vec3::zeros();
    shift[axis] = -lengths * cells.bounds.size[axis];
    Some((usize::from(next), shift))
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_grains_kit::math::random::Random;
    use tremie_grains_kit::space::periodic::PeriodicBox;
    use tremie_messages::scene::{Domain, Face};

    #[test]
    fn each_pair_that_overlaps_is_met_once() {
        for (periodic, across) in [(true, None), (false, None), (true, Some(1)), (false, Some(2))] {
            for bodies in [8, 60, 400] {
                let of =
                    |a| if periodic && Some(a) != across { Face::Periodic } else { Face::WALL };
                let faces = [0, 1, 2].map(|a| [of(a), of(a)]);
                let size = Vec3::new(3.0, 4.0, 5.0);
                let bounds = PeriodicBox::new(&Domain::new([0.0; 3], size.into(), faces));
                let mut cells = BodyCells::new(bounds.clone(), bodies, 0.9, across);
                let place = |k: u64| {
                    let mut random = Random::new(7, k);
                    let middle = |a, x| if Some(a) == across { 0.5 } else { x };
                    Vec3::from_fn(|a, _| middle(a, random.unit()) * size[a])
                };
                let ends: Vec<Vec3> = (0..bodies as u64).map(place).collect();
                for (k, &x) in ends.iter().enumerate() {
                    cells.insert(k, cells.cell_of(x));
                }
                let radius = |k: usize| 0.45 - 0.01 * (k % 7) as f64;
                let mut rows = EndRows::new(&cells, bodies);
                rows.fill(&cells, &ends, radius);
                let mut met = Vec::new();
                for row in 0..EndRows::rows(&cells) {
                    rows.overlaps(&cells, row, |i, j| met.push((i.min(j), i.max(j))));
                }
                met.sort_unstable();
                let overlap = |i: usize, j: usize| {
                    bounds.shortest(ends[j] - ends[i]).norm() < radius(i) + radius(j)
                };
                let pairs = (0..bodies).flat_map(|i| (i + 1..bodies).map(move |j| (i, j)));
                assert_eq!(met, pairs.filter(|&(i, j)| overlap(i, j)).collect::<Vec<_>>());
                assert!(bodies == 8 || !met.is_empty());
            }
        }
    }
}
