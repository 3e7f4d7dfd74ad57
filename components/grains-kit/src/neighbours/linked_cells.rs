//! Linked cells in levels: bodies of one class of sizes are sorted into boxes no smaller than the
//! range of their contacts.
//!
//! Bodies of one class find each other in the cells around their own. A body finds larger ones by
//! looking, at each level above its own, at the cells that its range overlaps: at most eight,
//! however large the others are. So what is looked at grows with the number of bodies alone,
//! whatever their sizes are (hierarchical grids: Ogarko & Luding, *Comput. Phys. Commun.* 183,
//! 2012).

use crate::Vec3;
use crate::neighbours::size_classes::Skins;
use crate::space::periodic::{PeriodicBox, image};
use crate::space::rigid_body::BoundingSphere;

/// Bodies sorted by cell. Buffers are kept from one sorting to the next.
#[derive(Clone, Debug)]
pub struct LinkedCells {
    bounds: PeriodicBox,
    skins: Skins,
    /// True if cells fill the box of the bodies where the whole domain would take too many.
    tight: bool,
    /// Class of each body; empty where there is but one.
    class: Vec<u8>,
    /// Each body's cell, at its own level.
    home: Vec<[u32; 3]>,
    /// The largest bodies first.
    levels: Vec<SizeLevel>,
    /// Room for the bodies of a class.
    members: Vec<u32>,
}

/// The cells of one class.
#[derive(Clone, Debug, Default)]
struct SizeLevel {
    /// Least edge of a cell [m].
    range: f64,
    min: Vec3,
    count: [usize; 3],
    per_length: Vec3,
    start: Vec<u32>,
    order: Vec<u32>,
}

impl LinkedCells {
    /// Cells for bodies of these classes.
    pub fn new(bounds: PeriodicBox, skins: Skins) -> Self {
        let range = |k: usize| skins.largest(k) + skins.between(k, k);
        let level = |k: usize| SizeLevel { range: range(k), ..SizeLevel::default() };
        let levels = (0..skins.count()).map(level).collect();
        let (class, home, members) = (Vec::new(), Vec::new(), Vec::new());
        Self { bounds, skins, tight: true, class, home, levels, members }
    }

    /// Cells of one size that fill the whole domain: the order of what is sorted into them depends
    /// on nothing else.
    pub fn over(bounds: PeriodicBox, edge: f64) -> Self {
        Self { tight: false, ..Self::new(bounds, Skins::one(edge)) }
    }

    /// Sorts bodies by class, by cell, and by index within a cell.
    pub fn sort(&mut self, balls: &[BoundingSphere]) {
        let Self { bounds, skins, tight, class, home, levels, members } = self;
        class.clear();
        home.clear();
        levels.iter_mut().for_each(|level| level.order.clear());
        if let [level] = &mut levels[..] {
            level.fit(bounds, balls.len(), tight.then_some(balls.iter()));
            home.extend(balls.iter().map(|ball| level.cell_at(ball.x)));
            level.fill(home, 0..balls.len() as u32);
            return;
        }
        class.extend(balls.iter().map(|ball| skins.class(ball.radius) as u8));
        for (i, &class) in (0..).zip(&*class) {
            levels[class as usize].order.push(i);
        }
        home.resize(balls.len(), [0; 3]);
        for level in levels {
            std::mem::swap(&mut level.order, members);
            let own = members.iter().map(|&i| &balls[i as usize]);
            level.fit(bounds, members.len(), tight.then_some(own));
            for &i in &*members {
                home[i as usize] = level.cell_at(balls[i as usize].x);
            }
            level.fill(home, members.iter().copied());
        }
    }

    /// The classes of the bodies.
    pub fn skins(&self) -> &Skins {
        &self.skins
    }

    /// The class of each body, in the order in which they were sorted; nothing where there is but
    /// one.
    pub fn classes(&self) -> &[u8] {
        &self.class
    }

    /// The class of body i.
    #[inline(always)]
    pub fn class_of(&self, i: usize) -> usize {
        self.class.get(i).map_or(0, |&class| class as usize)
    }

    /// The bodies in the order of cells, class by class.
    pub fn order(&self) -> impl Iterator<Item = u32> + '_ {
        self.levels.iter().flat_map(|level| level.order.iter().copied())
    }

    /// Calls `visit(j, image)` for the bodies j of body i's class that may be near it, so that each
    /// pair of the class is met once: those in its own cell that come after it, and all in half of
    /// the cells around. The image tells across which faces j is seen.
    #[inline(always)]
    pub fn ahead(&self, i: usize, mut visit: impl FnMut(u32, u32)) {
        let (level, home) = (&self.levels[self.class_of(i)], self.home[i]);
        let own = level.slot(home);
        let cell = &level.order[level.start[own] as usize..level.start[own + 1] as usize];
        for &j in cell {
            if j as usize > i {
                visit(j, image([0, 0, 0]));
            }
        }
        let periodic = self.bounds.periodic;
        level.run(periodic, home, [1, 1], [0, 0], &mut visit);
        for beside in [[1, 0], [-1, 1], [0, 1], [1, 1]] {
            level.run(periodic, home, [-1, 1], beside, &mut visit);
        }
    }

    /// Calls `visit(j, image)` for the bodies of a class above body i's, all within `reach` [m] of
    /// its centre at `x`.
    #[inline(always)]
    pub fn above(&self, class: usize, x: Vec3, reach: f64, mut visit: impl FnMut(u32, u32)) {
        self.levels[class].around(self.bounds.periodic, x, reach, &mut visit);
    }

    /// Writes the bodies in an order that keeps near ones together: that of the smallest cells
    /// along Morton's curve, and by index within a cell. `keys` is room to sort in.
    pub fn curve(
        &self,
        balls: &[BoundingSphere],
        keys: &mut Vec<(u64, u32)>,
        order: &mut Vec<u32>,
    ) {
        keys.clear();
        let Some(finest) = self.levels.last() else { return };
        let spread = |ball: &BoundingSphere| {
            let cell = finest.cell_at(ball.x);
            interleave(cell[0]) | interleave(cell[1]) << 1 | interleave(cell[2]) << 2
        };
        keys.extend(balls.iter().map(spread).zip(0..));
        keys.sort_unstable();
        order.clear();
        order.extend(keys.iter().map(|&(_, body)| body));
    }
}

impl SizeLevel {
    /// Lays out cells for so many bodies: at most a few a body, because larger cells are as
    /// correct, and cheaper than many empty ones. Where the domain would take more, `tight` has the
    /// bodies themselves, and cells fill the box around them.
    fn fit<'a>(
        &mut self,
        bounds: &PeriodicBox,
        bodies: usize,
        tight: Option<impl Iterator<Item = &'a BoundingSphere>>,
    ) {
        let most = 4 * bodies + 64;
        let (mut min, mut size) = (bounds.min, bounds.size);
        let mut edge = self.range;
        let cells = |size: &Vec3, edge: f64| -> [usize; 3] {
            std::array::from_fn(|a| ((size[a] / edge) as usize).clamp(1, 1 << 20))
        };
        let fits = |count: &[usize; 3]| count.iter().product::<usize>() <= most;
        if let Some(balls) = tight
            && !fits(&cells(&size, edge))
        {
            let max = bounds.min + bounds.size;
            let none = (max, bounds.min);
            // What lies beyond a face, or nowhere, counts as at the face.
            let (low, high) =
                balls.fold(none, |(low, high), ball| (low.inf(&ball.x), high.sup(&ball.x)));
            for a in (0..3).filter(|&a| !bounds.periodic[a]) {
                min[a] = low[a].max(bounds.min[a]).min(max[a]);
                size[a] = high[a].max(min[a]).min(max[a]) - min[a];
            }
        }
        let count = loop {
            let count = cells(&size, edge);
            if fits(&count) {
                break count;
            }
            edge *= 1.1;
        };
        self.per_length = Vec3::from_fn(|a, _| count[a] as f64 / size[a].max(f64::MIN_POSITIVE));
        (self.min, self.count) = (min, count);
    }

    /// Sorts bodies, which ascend, by their cells.
    fn fill(&mut self, home: &[[u32; 3]], members: impl DoubleEndedIterator<Item = u32> + Clone) {
        let cells = self.count.iter().product::<usize>();
        self.start.clear();
        self.start.resize(cells + 1, 0);
        for i in members.clone() {
            let slot = self.slot(home[i as usize]) + 1;
            self.start[slot] += 1;
        }
        for c in 1..self.start.len() {
            self.start[c] += self.start[c - 1];
        }
        let bodies = self.start[cells];
        self.order.clear();
        self.order.resize(bodies as usize, 0);
        // Filling from the back turns each cell's end into its start, without a second array.
        for i in members.rev() {
            let slot = self.slot(home[i as usize]) + 1;
            self.start[slot] -= 1;
            self.order[self.start[slot] as usize] = i;
        }
        // start[c + 1] is now the start of cell c; shift it into place.
        self.start.copy_within(1.., 0);
        self.start[cells] = bodies;
    }

    /// Visits the bodies in the cells from `dx[0]` to `dx[1]` further along x in the row of cells
    /// beside.
    #[inline(always)]
    fn run(
        &self,
        periodic: [bool; 3],
        home: [u32; 3],
        dx: [i32; 2],
        [dy, dz]: [i32; 2],
        visit: &mut impl FnMut(u32, u32),
    ) {
        let (Some((y, across_y)), Some((z, across_z))) =
            (self.step(periodic, home, 1, dy), self.step(periodic, home, 2, dz))
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
            let Some((x, across_x)) = self.step(periodic, home, 0, dx) else {
                continue;
            };
            let seen = image([across_x, across_y, across_z]);
            let slot = self.slot([x, y, z]);
            for &j in &self.order[self.start[slot] as usize..self.start[slot + 1] as usize] {
                visit(j, seen);
            }
        }
    }

    /// Visits the bodies in all cells that a cube of half an edge `reach` [m] around `x` overlaps,
    /// through all images.
    #[inline(always)]
    fn around(&self, periodic: [bool; 3], x: Vec3, reach: f64, visit: &mut impl FnMut(u32, u32)) {
        if self.order.is_empty() {
            return;
        }
        let [along_x, along_y, along_z] =
            [0, 1, 2].map(|a| self.overlapped(a, periodic[a], x[a], reach));
        for z in along_z[0]..=along_z[1] {
            let (z, across_z) = self.wrapped(2, z);
            for y in along_y[0]..=along_y[1] {
                let (y, across_y) = self.wrapped(1, y);
                let mut x = along_x[0];
                while x <= along_x[1] {
                    // Up to the next face, cells next to each other along x are next to each other
                    // in memory.
                    let (first, across_x) = self.wrapped(0, x);
                    let run = (along_x[1] - x).min((self.count[0] as u32 - 1 - first) as i64);
                    let begin = self.slot([first, y, z]);
                    let seen = image([across_x, across_y, across_z]);
                    let (begin, end) = (self.start[begin], self.start[begin + run as usize + 1]);
                    for &j in &self.order[begin as usize..end as usize] {
                        visit(j, seen);
                    }
                    x += run + 1;
                }
            }
        }
    }

    /// The first and the last cell along an axis within `reach` [m] of a place; beyond periodic
    /// faces counting goes on.
    #[inline(always)]
    fn overlapped(&self, a: usize, periodic: bool, x: f64, reach: f64) -> [i64; 2] {
        let (place, count) = ((x - self.min[a]) * self.per_length[a], self.count[a] as i64);
        // A hair more than it is: places of bodies were rounded too.
        let reach = reach * self.per_length[a] + 1e-6;
        if periodic {
            // The cast rounds down what is not negative.
            let cell = |place: f64| ((place + count as f64) as i64).clamp(0, 3 * count - 1) - count;
            [cell(place - reach), cell(place + reach)]
        } else {
            [place - reach, place + reach].map(|place| (place as i64).clamp(0, count - 1))
        }
    }

    /// A cell along an axis, and the face crossed on the way there.
    #[inline(always)]
    fn wrapped(&self, a: usize, cell: i64) -> (u32, i32) {
        let count = self.count[a] as i64;
        let across = i64::from(cell >= count) - i64::from(cell < 0);
        ((cell - across * count) as u32, across as i32)
    }

    /// The cell `d` further along an axis, and the face crossed on the way there.
    #[inline(always)]
    fn step(&self, periodic: [bool; 3], home: [u32; 3], axis: usize, d: i32) -> Option<(u32, i32)> {
        let last = self.count[axis] as i32 - 1;
        let to = home[axis] as i32 + d;
        let across = i32::from(to > last) - i32::from(to < 0);
        match (across, periodic[axis]) {
            (0, _) => Some((to as u32, 0)),
            (1, true) => Some((0, 1)),
            (-1, true) => Some((last as u32, -1)),
            _ => None,
        }
    }

    #[inline(always)]
    fn cell_at(&self, x: Vec3) -> [u32; 3] {
        std::array::from_fn(|a| {
            // The cast takes what is left of the box to 0; the minimum what is right of it.
            let cell = ((x[a] - self.min[a]) * self.per_length[a]) as usize;
            cell.min(self.count[a] - 1) as u32
        })
    }

    #[inline(always)]
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
