//! Linked cells: the bodies sorted into boxes no smaller than the range of a contact.

use crate::{
    Vec3,
    bodies::Ball,
    periodic::{PeriodicBox, image},
};

/// Bodies sorted by cell. Buffers are kept from one sorting to the next.
#[derive(Clone, Debug)]
pub(crate) struct Cells {
    bounds: PeriodicBox,
    count: [usize; 3],
    per_length: Vec3,
    cell_of: Vec<[u32; 3]>,
    start: Vec<u32>,
    order: Vec<u32>,
}

impl Cells {
    /// Cells for `bodies` bodies that meet within `range`. There are at most a few cells a body:
    /// larger cells are as correct, and cheaper than many empty ones.
    pub fn new(bounds: PeriodicBox, range: f64, bodies: usize) -> Self {
        let most = 4 * bodies + 64;
        let mut edge = range;
        let count = loop {
            let count: [usize; 3] =
                std::array::from_fn(|a| ((bounds.size[a] / edge) as usize).clamp(1, 1 << 20));
            if count.iter().product::<usize>() <= most {
                break count;
            }
            edge *= 1.1;
        };
        let per_length = Vec3::from_fn(|a, _| count[a] as f64 / bounds.size[a]);
        Self {
            bounds,
            count,
            per_length,
            cell_of: Vec::with_capacity(bodies),
            start: vec![0; count.iter().product::<usize>() + 1],
            order: vec![0; bodies],
        }
    }

    /// Sorts bodies by cell, and by index within a cell.
    pub fn sort(&mut self, balls: &[Ball]) {
        self.cell_of.clear();
        self.start.fill(0);
        for ball in balls {
            let cell = self.cell_at(ball.x);
            self.cell_of.push(cell);
            let slot = self.slot(cell) + 1;
            self.start[slot] += 1;
        }
        for c in 1..self.start.len() {
            self.start[c] += self.start[c - 1];
        }
        // Filling from the back turns each cell's end into its start, without a second array.
        for i in (0..balls.len()).rev() {
            let slot = self.slot(self.cell_of[i]) + 1;
            self.start[slot] -= 1;
            self.order[self.start[slot] as usize] = i as u32;
        }
        // start[c + 1] is now the start of cell c; shift it into place.
        let cells = self.start.len() - 1;
        self.start.copy_within(1.., 0);
        self.start[cells] = balls.len() as u32;
    }

    /// The bodies in the order of cells.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// Calls `visit(j, image)` for every body j in the cells around body i, itself included; the
    /// image tells across which faces j is seen.
    pub fn around(&self, i: usize, mut visit: impl FnMut(u32, u32)) {
        let home = self.cell_of[i];
        for dz in -1..=1 {
            let Some((z, across_z)) = self.step(home, 2, dz) else {
                continue;
            };
            for dy in -1..=1 {
                let Some((y, across_y)) = self.step(home, 1, dy) else {
                    continue;
                };
                for dx in -1..=1 {
                    let Some((x, across_x)) = self.step(home, 0, dx) else {
                        continue;
                    };
                    let seen = image([across_x, across_y, across_z]);
                    let slot = self.slot([x, y, z]);
                    let (begin, end) = (self.start[slot], self.start[slot + 1]);
                    for &j in &self.order[begin as usize..end as usize] {
                        visit(j, seen);
                    }
                }
            }
        }
    }

    /// The cell `d` further along an axis, and the face crossed on the way there.
    fn step(&self, home: [u32; 3], axis: usize, d: i32) -> Option<(u32, i32)> {
        let last = self.count[axis] as i32 - 1;
        let to = home[axis] as i32 + d;
        let across = i32::from(to > last) - i32::from(to < 0);
        match (across, self.bounds.periodic[axis]) {
            (0, _) => Some((to as u32, 0)),
            (1, true) => Some((0, 1)),
            (-1, true) => Some((last as u32, -1)),
            _ => None,
        }
    }

    fn cell_at(&self, x: Vec3) -> [u32; 3] {
        std::array::from_fn(|a| {
            // The cast takes what is left of the box to 0; the minimum what is right of it.
            let cell = ((x[a] - self.bounds.min[a]) * self.per_length[a]) as usize;
            cell.min(self.count[a] - 1) as u32
        })
    }

    fn slot(&self, cell: [u32; 3]) -> usize {
        (cell[2] as usize * self.count[1] + cell[1] as usize) * self.count[0] + cell[0] as usize
    }
}
