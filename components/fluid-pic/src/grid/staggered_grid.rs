//! A box of cells with velocities on their faces (Harlow & Welch, *Phys. Fluids* 8 (1965) 2182).

use crate::grid::periodic_ghosts::PeriodicGhosts;

/// Ghost cells on each side of the box.
pub const GHOST: usize = 1;

/// Cells for which an axis of so many has room: pairs of them make a coarser cell, so that an odd
/// one has a neighbour that is never part of the fluid.
pub fn room(cells: usize) -> usize {
    if cells > 1 { cells.next_multiple_of(2) } else { 1 }
}

/// Steps in memory along the axes, and all stored cells, of a box with so much room and a layer of
/// ghosts.
pub fn storage<const D: usize>(room: [usize; D]) -> ([usize; D], usize) {
    let (mut stride, mut stored) = ([1; D], 1);
    for a in 0..D {
        stride[a] = stored;
        stored *= room[a] + 2 * GHOST;
    }
    (stride, stored)
}

/// Cells of a box in `D` dimensions, stored in rows along the first axis, with a layer of ghost
/// cells all around. An array of cells has a value for each stored cell. An array of faces across
/// an axis has one for the *lower* face of each stored cell.
#[derive(Clone, Debug, PartialEq)]
pub struct StaggeredGrid<const D: usize> {
    /// Cells along each axis, without ghosts.
    pub cells: [usize; D],
    /// Edge of a cell [m].
    pub spacing: f64,
    /// Lower corner of the first cell [m].
    pub origin: [f64; D],
    /// Axes along which the last cell's neighbour is the first.
    pub periodic: [bool; D],
    /// Steps in memory from a cell to the next along each axis.
    pub stride: [usize; D],
    /// Stored cells, ghosts included.
    pub stored: usize,
    /// Ghosts that stand for cells at the other end.
    pub ghosts: PeriodicGhosts,
}

impl<const D: usize> StaggeredGrid<D> {
    /// Of cells of one edge.
    ///
    /// # Panics
    /// If there is no cell along an axis.
    pub fn new(cells: [usize; D], spacing: f64, origin: [f64; D], periodic: [bool; D]) -> Self {
        assert!(cells.iter().all(|&n| n > 0), "a grid has cells: {cells:?}");
        let (stride, stored) = storage(cells.map(room));
        let ghosts = PeriodicGhosts::new(cells, cells.map(room), periodic);
        Self { cells, spacing, origin, periodic, stride, stored, ghosts }
    }

    /// Stored cells of a row.
    pub fn row_length(&self) -> usize {
        room(self.cells[0]) + 2 * GHOST
    }

    /// Number of cells without ghosts.
    pub fn count(&self) -> usize {
        self.cells.iter().product()
    }

    /// True if an axis wraps around.
    pub fn is_periodic(&self) -> bool {
        self.periodic.contains(&true)
    }

    /// The cell in the box that one beyond the ends of axes that wrap around stands for.
    #[inline]
    pub fn wrapped(&self, at: [isize; D]) -> [isize; D] {
        std::array::from_fn(|a| {
            if self.periodic[a] { at[a].rem_euclid(self.cells[a] as isize) } else { at[a] }
        })
    }

    /// The coordinate inside that one along an axis stands for, if the axis wraps around [m].
    #[inline]
    pub fn wrapped_along(&self, axis: usize, along: f64) -> f64 {
        if !self.periodic[axis] {
            return along;
        }
        let length = self.cells[axis] as f64 * self.spacing;
        self.origin[axis] + (along - self.origin[axis]).rem_euclid(length)
    }

    /// A point, or that among those which it stands for along axes that wrap around which is
    /// nearest to the middle of a box [m]. Boxes as long as the axis hold the point itself.
    #[inline]
    pub fn nearest_image(&self, point: [f64; D], box_of: [[f64; D]; 2]) -> [f64; D] {
        std::array::from_fn(|a| {
            let length = self.cells[a] as f64 * self.spacing;
            let [low, high] = [box_of[0][a], box_of[1][a]];
            if !self.periodic[a] || high - low >= length {
                return point[a];
            }
            let off = point[a] - 0.5 * (low + high);
            point[a] - length * (off / length).round()
        })
    }

    /// Place in memory of a cell; -1 and the number of cells along an axis are ghosts.
    #[inline]
    pub fn place(&self, at: [isize; D]) -> usize {
        let along = |a: usize| (at[a] + GHOST as isize) as usize * self.stride[a];
        (0..D).map(along).sum()
    }

    /// Place in memory of the cell that one at a place stands for.
    #[inline]
    pub fn place_inside(&self, place: usize) -> usize {
        if self.is_periodic() { self.place(self.wrapped(self.cell_at(place))) } else { place }
    }

    /// The cell at a place in memory.
    #[inline]
    pub fn cell_at(&self, place: usize) -> [isize; D] {
        let mut rest = place;
        let mut at = [0; D];
        for a in (0..D).rev() {
            at[a] = (rest / self.stride[a]) as isize - GHOST as isize;
            rest %= self.stride[a];
        }
        at
    }

    /// True if a place is that of a cell in the box, and no ghost.
    pub fn is_inside(&self, place: usize) -> bool {
        let at = self.cell_at(place);
        (0..D).all(|a| (0..self.cells[a] as isize).contains(&at[a]))
    }

    /// Centre of a cell [m].
    #[inline]
    pub fn centre(&self, at: [isize; D]) -> [f64; D] {
        std::array::from_fn(|a| self.origin[a] + (at[a] as f64 + 0.5) * self.spacing)
    }

    /// Centre of the lower face of a cell across an axis [m].
    #[inline]
    pub fn face_centre(&self, axis: usize, at: [isize; D]) -> [f64; D] {
        let mut centre = self.centre(at);
        centre[axis] -= 0.5 * self.spacing;
        centre
    }

    /// Upper corner of the box [m].
    pub fn end(&self) -> [f64; D] {
        std::array::from_fn(|a| self.origin[a] + self.cells[a] as f64 * self.spacing)
    }

    /// Volume of a cell [m³]; in two dimensions its area [m²].
    pub fn cell_volume(&self) -> f64 {
        self.spacing.powi(D as i32)
    }

    /// All cells without ghosts, the first axis fastest.
    pub fn all(&self) -> impl Iterator<Item = [isize; D]> + use<D> {
        let cells = self.cells;
        (0..cells.iter().product::<usize>()).map(move |mut number| {
            std::array::from_fn(|a| {
                let at = number % cells[a];
                number /= cells[a];
                at as isize
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_cells_are_inverse() {
        let grid = StaggeredGrid::<3>::new([5, 4, 3], 0.1, [1.0, 2.0, 3.0], [false; 3]);
        for (number, at) in grid.all().enumerate() {
            assert_eq!(grid.cell_at(grid.place(at)), at);
            assert!(number < grid.count());
        }
        assert_eq!(grid.stored, 8 * 6 * 6);
        let centre = grid.face_centre(1, [0, 0, 0]);
        assert!((centre[0] - 1.05).abs() < 1e-14 && (centre[1] - 2.0).abs() < 1e-14);
    }
}
