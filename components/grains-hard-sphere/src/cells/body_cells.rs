//! Linked cells as doubly linked lists: a body goes from one to the next at no cost but its own.

use crate::Vec3;
use tremie_grains_kit::space::periodic::PeriodicBox;
use tremie_state::{StateError, StateExchange};

const NONE: u32 = u32::MAX;

/// Cells that fill the domain, no smaller than the largest diameter. Bodies that touch lie in the
/// same cell or in cells beside each other.
#[derive(Clone, Debug)]
pub struct BodyCells {
    /// The domain's box.
    pub bounds: PeriodicBox,
    /// Number of cells along each axis.
    pub count: [usize; 3],
    /// Edges of a cell [m].
    pub edge: Vec3,
    first: Vec<u32>,
    next: Vec<u32>,
    before: Vec<u32>,
    /// The cell of each body.
    home: Vec<[u16; 3]>,
}

/// A cell beside another one along an axis, and the shift of what is seen in it [m].
type Beside = (usize, f64);

impl BodyCells {
    /// Cells for so many bodies up to a diameter [m]; along the axis across a plane scene there is
    /// one.
    pub fn new(bounds: PeriodicBox, bodies: usize, diameter: f64, across: Option<usize>) -> Self {
        let size = bounds.size;
        let dimensions = if across.is_some() { 2.0 } else { 3.0 };
        let area: f64 = (0..3).filter(|&a| Some(a) != across).map(|a| size[a]).product();
        // About a body in a cell: fewer would make lists long, more would make bodies cross often.
        let roomy = libm::pow(area / bodies.max(1) as f64, 1.0 / dimensions);
        let edge = (ROOM * roomy).max(diameter * (1.0 + 1e-9));
        let count = core::array::from_fn(|a| {
            let fits = (size[a] / edge) as usize;
            if Some(a) == across {
                1
            } else if bounds.periodic[a] {
                fits.clamp(3, MOST)
            } else {
                fits.clamp(1, MOST)
            }
        });
        let cells = count.iter().product();
        Self {
            edge: Vec3::from_fn(|a, _| size[a] / count[a] as f64),
            first: vec![NONE; cells],
            next: vec![NONE; bodies],
            before: vec![NONE; bodies],
            home: vec![[0; 3]; bodies],
            bounds,
            count,
        }
    }

    /// Bytes that so many bodies and their cells take.
    pub fn memory(bodies: usize) -> u64 {
        (bodies * (2 * size_of::<u32>() + size_of::<[u16; 3]>() + size_of::<u32>())) as u64
    }

    /// The cell of a place; what lies outside belongs to the nearest one.
    #[inline]
    pub fn cell_of(&self, x: Vec3) -> [u16; 3] {
        core::array::from_fn(|a| {
            let place = (x[a] - self.bounds.min[a]) / self.edge[a];
            (place.max(0.0) as usize).min(self.count[a] - 1) as u16
        })
    }

    /// The cell that a body is in.
    #[inline(always)]
    pub fn home(&self, body: usize) -> [u16; 3] {
        self.home[body]
    }

    /// Number of a cell.
    #[inline(always)]
    pub fn slot(&self, [x, y, z]: [u16; 3]) -> usize {
        (z as usize * self.count[1] + y as usize) * self.count[0] + x as usize
    }

    /// Lower corner of a cell [m].
    pub fn corner(&self, cell: [u16; 3]) -> Vec3 {
        Vec3::from_fn(|a, _| self.bounds.min[a] + self.edge[a] * f64::from(cell[a]))
    }

    /// Puts a body that is in no cell into one.
    pub fn insert(&mut self, body: usize, cell: [u16; 3]) {
        let slot = self.slot(cell);
        let next = self.first[slot];
        (self.before[body], self.next[body]) = (NONE, next);
        if next != NONE {
            self.before[next as usize] = body as u32;
        }
        self.first[slot] = body as u32;
        self.home[body] = cell;
    }

    /// Keeps the cells that the bodies are in, or puts the bodies back into them. A body at a cell's
    /// edge may be in either.
    ///
    /// # Errors
    /// A state of other bodies or other cells.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let mut home = self.home.clone();
        state.array("home", &mut home)?;
        if state.restores() {
            let is_there = |cell: &[u16; 3]| (0..3).all(|a| usize::from(cell[a]) < self.count[a]);
            if let Some(cell) = home.iter().find(|cell| !is_there(cell)) {
                return state
                    .unfit(format!("the state has a body in cell {cell:?} of {:?}", self.count));
            }
            self.first.fill(NONE);
            home.into_iter().enumerate().for_each(|(body, cell)| self.insert(body, cell));
        }
        Ok(())
    }

    /// Moves a body to another cell.
    #[inline]
    pub fn relocate(&mut self, body: usize, cell: [u16; 3]) {
        if cell == self.home[body] {
            return;
        }
        let (before, next) = (self.before[body], self.next[body]);
        match before {
            NONE => {
                let slot = self.slot(self.home[body]);
                self.first[slot] = next;
            }
            _ => self.next[before as usize] = next,
        }
        if next != NONE {
            self.before[next as usize] = before;
        }
        self.insert(body, cell);
    }

    /// Visits the bodies of a cell and of those beside it, with the shift at which each is seen.
    #[inline(always)]
    pub fn around(&self, cell: [u16; 3], visit: impl FnMut(usize, Vec3)) {
        self.visit([0, 1, 2].map(|a| self.beside(cell[a], a)), visit);
    }

    /// Visits the bodies of the cells beside a cell that lie on one side of it along an axis.
    #[inline(always)]
    pub fn ahead(&self, cell: [u16; 3], axis: usize, is_up: bool, visit: impl FnMut(usize, Vec3)) {
        let mut beside = [0, 1, 2].map(|a| self.beside(cell[a], a));
        let (cells, count) = &mut beside[axis];
        let wanted = if is_up { cells[2] } else { cells[0] };
        (cells[0], *count) = (wanted, 1);
        if self.is_last(cell[axis], axis, is_up) {
            return;
        }
        self.visit(beside, visit);
    }

    /// True if there is no cell beyond one along an axis.
    #[inline(always)]
    fn is_last(&self, cell: u16, axis: usize, is_up: bool) -> bool {
        let end = if is_up { self.count[axis] - 1 } else { 0 };
        !self.bounds.periodic[axis] && cell as usize == end
    }

    /// The cell beside one along an axis, around periodic faces; with the step of its coordinate
    /// across them, in domain lengths.
    pub fn step(&self, cell: u16, axis: usize, is_up: bool) -> Option<(u16, f64)> {
        if self.is_last(cell, axis, is_up) || self.count[axis] == 1 {
            return None;
        }
        let last = (self.count[axis] - 1) as u16;
        Some(match (is_up, cell) {
            (true, cell) if cell == last => (0, -1.0),
            (true, cell) => (cell + 1, 0.0),
            (false, 0) => (last, 1.0),
            (false, cell) => (cell - 1, 0.0),
        })
    }

    /// Cells around one along an axis: below, itself, above; those that there are come first.
    #[inline(always)]
    fn beside(&self, cell: u16, axis: usize) -> ([Beside; 3], usize) {
        let (cell, count) = (cell as usize, self.count[axis]);
        let size = self.bounds.size[axis];
        if count == 1 {
            return ([(0, 0.0); 3], 1);
        }
        if self.bounds.periodic[axis] {
            let below = if cell == 0 { (count - 1, -size) } else { (cell - 1, 0.0) };
            let above = if cell == count - 1 { (0, size) } else { (cell + 1, 0.0) };
            return ([below, (cell, 0.0), above], 3);
        }
        match (cell == 0, cell == count - 1) {
            (true, _) => ([(0, 0.0), (1, 0.0), (1, 0.0)], 2),
            (_, true) => ([(cell - 1, 0.0), (cell, 0.0), (cell, 0.0)], 2),
            _ => ([(cell - 1, 0.0), (cell, 0.0), (cell + 1, 0.0)], 3),
        }
    }

    #[inline(always)]
    fn visit(&self, beside: [([Beside; 3], usize); 3], mut visit: impl FnMut(usize, Vec3)) {
        let [(xs, nx), (ys, ny), (zs, nz)] = beside;
        for &(z, dz) in &zs[..nz] {
            for &(y, dy) in &ys[..ny] {
                let row = (z * self.count[1] + y) * self.count[0];
                for &(x, dx) in &xs[..nx] {
                    let mut body = self.first[row + x];
                    while body != NONE {
                        visit(body as usize, Vec3::new(dx, dy, dz));
                        body = self.next[body as usize];
                    }
                }
            }
        }
    }
}

/// Edge of a cell over the mean distance of bodies.
const ROOM: f64 = 0.7;

/// Most cells along an axis.
const MOST: usize = 4096;

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_grains_kit::math::random::Random;
    use tremie_messages::scene::{Domain, Face};

    fn place(seed: u64, body: u64, size: Vec3) -> Vec3 {
        let mut random = Random::new(seed, body);
        Vec3::from_fn(|a, _| random.unit() * size[a])
    }

    #[test]
    fn bodies_that_are_near_are_met_once_wherever_they_went() {
        for periodic in [true, false] {
            let face = || if periodic { Face::Periodic } else { Face::WALL };
            let faces = [(); 3].map(|()| [face(), face()]);
            let size = Vec3::new(3.0, 4.0, 5.0);
            let domain = Domain::new([0.0; 3], size.into(), faces);
            let (bounds, bodies) = (PeriodicBox::new(&domain), 60);
            let mut cells = BodyCells::new(bounds.clone(), bodies, 0.9, None);
            let first: Vec<Vec3> = (0..60).map(|k| place(1, k, size)).collect();
            let last: Vec<Vec3> = (0..60).map(|k| place(2, k, size)).collect();
            for (k, &x) in first.iter().enumerate() {
                cells.insert(k, cells.cell_of(x));
            }
            for (k, &x) in last.iter().enumerate() {
                cells.relocate(k, cells.cell_of(x));
            }
            for i in 0..bodies {
                let mut met = Vec::new();
                cells.around(cells.home(i), |j, shift| {
                    if (last[j] + shift - last[i]).norm() < 0.9 {
                        met.push(j);
                    }
                });
                met.sort_unstable();
                let near = |j: &usize| bounds.shortest(last[*j] - last[i]).norm() < 0.9;
                assert_eq!(met, (0..bodies).filter(near).collect::<Vec<_>>());
            }
        }
    }
}
