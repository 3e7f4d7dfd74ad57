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
        self.order.resize(balls.len(), 0);
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

    /// Calls `visit(j, image)` for the bodies j in body i's cell that come after it, and for all in
    /// half of the cells around: each pair of bodies in cells next to each other is met once. The
    /// image tells across which faces j is seen.
    #[inline(always)]
    pub fn ahead(&self, i: usize, mut visit: impl FnMut(u32, u32)) {
        let home = self.cell_of[i];
        let own = self.slot(home);
        let cell = &self.order[self.start[own] as usize..self.start[own + 1] as usize];
        for &j in cell {
            if j as usize > i {
                visit(j, image([0, 0, 0]));
            }
        }
        self.run(home, [1, 1], 0, 0, &mut visit);
        for (dy, dz) in [(1, 0), (-1, 1), (0, 1), (1, 1)] {
            self.run(home, [-1, 1], dy, dz, &mut visit);
        }
    }

    /// Visits the bodies in the cells from `dx[0]` to `dx[1]` further along x in one row of cells.
    #[inline(always)]
    fn run(
        &self,
        home: [u32; 3],
        dx: [i32; 2],
        dy: i32,
        dz: i32,
        visit: &mut impl FnMut(u32, u32),
    ) {
        let (Some((y, across_y)), Some((z, across_z))) =
            (self.step(home, 1, dy), self.step(home, 2, dz))
        else {
            return;
        };
        let x = home[0] as i32;
        if x + dx[0] >= 0 && x + dx[1] < self.count[0] as i32 {
            // Cells next to each other along x are next to each other in memory.
            let seen = image([0, across_y, across_z]);
            let first = self.slot([(x + dx[0]) as u32, y, z]);
            let last = self.slot([(x + dx[1]) as u32, y, z]);
            let (begin, end) = (self.start[first], self.start[last + 1]);
            for &j in &self.order[begin as usize..end as usize] {
                visit(j, seen);
            }
            return;
        }
        for dx in dx[0]..=dx[1] {
            let Some((x, across_x)) = self.step(home, 0, dx) else {
                continue;
            };
            let seen = image([across_x, across_y, across_z]);
            let slot = self.slot([x, y, z]);
            for &j in &self.order[self.start[slot] as usize..self.start[slot + 1] as usize] {
                visit(j, seen);
            }
        }
    }

    /// Writes the bodies in an order that keeps near ones together: that of cells along Morton's
    /// curve, and by index within a cell. `keys` is room to sort in.
    pub fn curve(&self, keys: &mut Vec<(u64, u32)>, order: &mut Vec<u32>) {
        keys.clear();
        let spread = |cell: &[u32; 3]| {
            interleave(cell[0]) | interleave(cell[1]) << 1 | interleave(cell[2]) << 2
        };
        keys.extend(self.cell_of.iter().map(spread).zip(0..));
        keys.sort_unstable();
        order.clear();
        order.extend(keys.iter().map(|&(_, body)| body));
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

/// The lowest 21 bits of `x`, each followed by two zeros.
fn interleave(x: u32) -> u64 {
    let mut x = u64::from(x) & 0x1f_ffff;
    x = (x | x << 32) & 0x001f_0000_0000_ffff;
    x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::interleave;

    #[test]
    fn interleaving_spreads_bits() {
        for bit in 0..21 {
            assert_eq!(interleave(1 << bit), 1 << (3 * bit));
        }
        assert_eq!(interleave(0x1f_ffff).count_ones(), 21);
    }
}
