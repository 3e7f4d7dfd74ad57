//! The box of cells: its shape, its faces, and what a link meets beyond them.

/// Kind of a face of the box for links that cross it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Joined to the opposite face.
    Periodic,
    /// A wall half-way between the last cells and those that would follow.
    Wall,
    /// A mirror in the same place.
    Symmetry,
    /// Something that gives the last cells their populations.
    Open,
}

/// Target of coordinates that may lie beyond a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// To a cell of the box, mirrored at the axes whose bits are set.
    Cell {
        /// Its coordinates.
        at: [i32; 3],
        /// Axes at which the way was mirrored.
        mirrors: u8,
    },
    /// Beyond a face that ends the fluid.
    Face {
        /// Its axis.
        axis: usize,
        /// 0 for the lower, 1 for the upper face.
        side: usize,
    },
}

/// Shape of the box.
#[derive(Clone, Debug)]
pub struct Grid {
    /// Cells along each axis.
    pub n: [i32; 3],
    /// Lower and upper face of each axis.
    pub sides: [[Side; 2]; 3],
    /// True for axes that wrap around.
    pub periodic: [bool; 3],
    /// The axes in the order of the world's: of several faces at an edge, the first by it counts.
    pub order: [usize; 3],
}

impl Grid {
    /// A box of `n` cells.
    pub fn new(n: [usize; 3], sides: [[Side; 2]; 3]) -> Self {
        let periodic = sides.map(|s| s[0] == Side::Periodic);
        Self { n: n.map(|n| n as i32), sides, periodic, order: [0, 1, 2] }
    }

    /// With its axes in another order than the world's.
    pub fn ordered(self, order: [usize; 3]) -> Self {
        Self { order, ..self }
    }

    /// A box with periodic axes and walls across the others.
    pub fn walled(n: [usize; 3], periodic: [bool; 3]) -> Self {
        Self::new(n, periodic.map(|p| [if p { Side::Periodic } else { Side::Wall }; 2]))
    }

    /// The open faces at which a cell lies, axis and side, in the order of the world's axes: it
    /// belongs to the first.
    pub fn open_faces(&self, at: [i32; 3]) -> impl Iterator<Item = (usize, usize)> {
        let is_at = move |axis: usize, side: usize| {
            self.sides[axis][side] == Side::Open && at[axis] == [0, self.n[axis] - 1][side]
        };
        self.order.into_iter().filter_map(move |axis| {
            let side = (0..2).find(|&side| is_at(axis, side))?;
            Some((axis, side))
        })
    }

    /// Number of cells of the box.
    #[expect(clippy::len_without_is_empty, reason = "a box has cells")]
    pub fn len(&self) -> usize {
        self.n.iter().map(|&n| n as usize).product()
    }

    /// Index of a cell of the box, x running fastest.
    #[inline]
    pub fn index(&self, at: [i32; 3]) -> usize {
        let [nx, ny, _] = self.n.map(|n| n as usize);
        at[0] as usize + nx * (at[1] as usize + ny * at[2] as usize)
    }

    /// Coordinates of an index.
    #[inline]
    pub fn at(&self, index: usize) -> [i32; 3] {
        let [nx, ny, _] = self.n.map(|n| n as u32);
        let (row, x) = (index as u32 / nx, index as u32 % nx);
        [x as i32, (row % ny) as i32, (row / ny) as i32]
    }

    /// Coordinate moved to the box along a periodic axis, unchanged along another.
    #[inline]
    pub fn wrap(&self, axis: usize, k: i32) -> i32 {
        if self.periodic[axis] && (k < 0 || k >= self.n[axis]) {
            k.rem_euclid(self.n[axis])
        } else {
            k
        }
    }

    /// Coordinate along an axis, moved back into the box at a mirror, and whether it was.
    #[inline]
    pub fn fold(&self, axis: usize, k: i32) -> (i32, u8) {
        if k == -1 && self.sides[axis][0] == Side::Symmetry {
            (0, 1)
        } else if k == self.n[axis] && self.sides[axis][1] == Side::Symmetry {
            (k - 1, 1)
        } else {
            (k, 0)
        }
    }

    /// True if the coordinates are those of a cell of the box.
    #[inline]
    pub fn contains(&self, at: [i32; 3]) -> bool {
        (0..3).all(|a| at[a] >= 0 && at[a] < self.n[a])
    }

    /// Target of coordinates at most one cell beyond a face (any number of cells along periodic
    /// axes). Of several faces that end the fluid, walls come before open ones, then the first of
    /// the world's axes; a face that ends the fluid comes before mirrors.
    pub fn reach(&self, at: [i32; 3]) -> Reach {
        let mut to = at;
        let mut mirrors = 0;
        let mut face: Option<(usize, usize)> = None;
        for a in self.order {
            let side = match at[a] {
                k if k < 0 => 0,
                k if k >= self.n[a] => 1,
                _ => continue,
            };
            match self.sides[a][side] {
                Side::Periodic => to[a] = self.wrap(a, at[a]),
                Side::Symmetry => {
                    to[a] = [-1, 2 * self.n[a] - 1][side] - at[a];
                    mirrors |= 1 << a;
                }
                Side::Wall => match face {
                    Some((b, s)) if self.sides[b][s] == Side::Wall => {}
                    _ => face = Some((a, side)),
                },
                Side::Open => face = face.or(Some((a, side))),
            }
        }
        match face {
            Some((axis, side)) => Reach::Face { axis, side },
            None => Reach::Cell { at: to, mirrors },
        }
    }

    /// The axes at which a way that ends at these coordinates is mirrored; none where a face ends
    /// it.
    pub fn mirrors_to(&self, end: [i32; 3]) -> u8 {
        match self.reach(end) {
            Reach::Cell { mirrors, .. } => mirrors,
            Reach::Face { .. } => 0,
        }
    }

    /// A position [cells] moved into the box along periodic axes.
    pub fn canonical(&self, position: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|a| {
            let n = f64::from(self.n[a]);
            if !self.periodic[a] {
                return position[a];
            }
            let wrapped = position[a] - n * (position[a] / n).floor();
            // Rounding can leave `n` itself.
            if wrapped < n { wrapped } else { 0.0 }
        })
    }

    /// Vector from `point` to the centre of `at`, through periodic faces where that is shorter
    /// [cells].
    #[inline]
    pub fn arm(&self, point: [f64; 3], at: [i32; 3]) -> [f64; 3] {
        self.shortest(point, at.map(|k| f64::from(k) + 0.5))
    }

    /// Vector between two points, through periodic faces where that is shorter [cells].
    #[inline]
    pub fn shortest(&self, from: [f64; 3], to: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|a| {
            let d = to[a] - from[a];
            if self.periodic[a] {
                let n = f64::from(self.n[a]);
                d - n * (d / n).round()
            } else {
                d
            }
        })
    }
}

/// Name of a face of the domain in signals and findings: `z_lower`.
pub fn face_name(axis: usize, side: usize) -> String {
    format!("{}_{}", ["x", "y", "z"][axis], ["lower", "upper"][side])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_index_leads_back_to_its_cell() {
        let grid = Grid::walled([5, 4, 3], [false; 3]);
        for index in 0..grid.len() {
            assert!(grid.contains(grid.at(index)));
            assert_eq!(grid.index(grid.at(index)), index);
        }
    }

    #[test]
    fn the_shortest_way_leads_through_periodic_faces() {
        let grid = Grid::walled([10, 10, 10], [true, false, true]);
        let d = grid.arm([9.5, 9.5, 0.5], [0, 0, 9]);
        assert_eq!(d, [1.0, -9.0, -1.0]);
        assert_eq!(grid.canonical([-0.25, -0.25, 10.5]), [9.75, -0.25, 0.5]);
    }

    #[test]
    fn beyond_faces_walls_come_first_and_mirrors_last() {
        use Side::*;
        let grid = Grid::new([6, 6, 6], [[Symmetry, Open], [Periodic; 2], [Open, Wall]]);
        let cell = |at, mirrors| Reach::Cell { at, mirrors };
        let face = |axis, side| Reach::Face { axis, side };
        assert_eq!(grid.reach([2, 3, 4]), cell([2, 3, 4], 0));
        assert_eq!(grid.reach([-1, -1, 4]), cell([0, 5, 4], 1));
        assert_eq!(grid.reach([6, 6, 4]), face(0, 1));
        assert_eq!(grid.reach([6, 0, 6]), face(2, 1));
        assert_eq!(grid.reach([6, 0, -1]), face(0, 1));
        assert_eq!(grid.reach([-1, 0, 6]), face(2, 1));
    }
}
