//! Which cells a moving part covers, and where links meet its surface.
//!
//! Both answers come from the part's surface, for the same points: cell centres taken into the
//! part's frame row by row. Lengths in cells, but where the surface is asked.

use crate::grid::Grid;
use std::sync::Arc;
use tremie_geometry::{Frame, Row, RowScratch, Surface};
use tremie_messages::scene::Pose;

/// A part as a body in the fluid.
#[derive(Clone, Debug)]
pub struct PartBody {
    surface: Arc<Surface>,
    /// Edge of a cell [m].
    cell: f64,
    /// Volume.
    pub volume: f64,
    /// Centre of the volume in the part's frame [m].
    centroid: [f64; 3],
    orientation: [f64; 4],
    frame: Frame,
    now: Cover,
    previous: Cover,
    scratch: RowScratch,
    row: Vec<bool>,
}

/// Cells of a cube of the box, which may reach beyond periodic faces.
#[derive(Clone, Debug)]
struct Cover {
    origin: [i32; 3],
    side: i32,
    cells: Vec<bool>,
    /// For each row `(y, z)` whether it holds any cell.
    rows: Vec<bool>,
}

impl PartBody {
    /// A part with a surface; `cell` is the edge of a cell [m].
    pub fn new(surface: Arc<Surface>, cell: f64) -> Self {
        let moments = surface.mesh().moments();
        let side = (2.0 * surface.bounding_radius() / cell).ceil() as i32 + 2;
        let count = (side * side) as usize;
        let cover = Cover {
            origin: [0; 3],
            side,
            cells: vec![false; count * side as usize],
            rows: vec![false; count],
        };
        Self {
            volume: moments.volume / (cell * cell * cell),
            centroid: moments.centroid,
            orientation: [0.0, 0.0, 0.0, 1.0],
            frame: Frame::of(&Pose::IDENTITY),
            now: cover.clone(),
            previous: cover,
            scratch: RowScratch::default(),
            row: vec![false; side as usize],
            surface,
            cell,
        }
    }

    /// Distance of its farthest point from its origin.
    pub fn radius(&self) -> f64 {
        self.surface.bounding_radius() / self.cell
    }

    /// Takes over an orientation; true if it is another than before.
    pub fn turn(&mut self, orientation: [f64; 4]) -> bool {
        std::mem::replace(&mut self.orientation, orientation) != orientation
    }

    /// Rows along y or z that may hold cells.
    pub fn side(&self) -> i32 {
        self.now.side
    }

    /// Coordinates `(y, z)` of the first row.
    pub fn origin(&self) -> [i32; 2] {
        [self.now.origin[1], self.now.origin[2]]
    }

    /// First and last coordinate along x of cells that it may cover.
    pub fn range(&self) -> [i32; 2] {
        [self.now.origin[0], self.now.origin[0] + self.now.side - 1]
    }

    /// Moves the coordinates of its cells.
    pub fn shift(&mut self, by: [i32; 3]) {
        for a in 0..3 {
            self.now.origin[a] += by[a];
        }
    }

    /// Finds the cells inside at a position; along faces that do not wrap around it is cut off.
    pub fn cover(&mut self, grid: &Grid, position: [f64; 3]) {
        std::mem::swap(&mut self.now, &mut self.previous);
        let pose =
            Pose { position: position.map(|x| x * self.cell), orientation: self.orientation };
        self.frame = Frame::of(&pose);
        let (radius, side) = (self.radius(), self.now.side);
        self.now.origin = position.map(|x| (x - radius).floor() as i32);
        let [ox, oy, oz] = self.now.origin;
        let outside = |a: usize, k: i32| !grid.periodic[a] && (k < 0 || k >= grid.n[a]);
        for k in 0..side * side {
            let (y, z) = (oy + k % side, oz + k / side);
            let d = [f64::from(y) + 0.5 - position[1], f64::from(z) + 0.5 - position[2]];
            let first = (k * side) as usize;
            let cells = &mut self.now.cells[first..first + side as usize];
            let far = d[0] * d[0] + d[1] * d[1] > radius * radius;
            if far || outside(1, y) || outside(2, z) {
                cells.fill(false);
            } else {
                let row = self.frame_row(y, z);
                self.surface.fill_row(&row, &mut self.row, &mut self.scratch);
                let cells = &mut self.now.cells[first..first + side as usize];
                for (x, (cell, inside)) in (ox..).zip(cells.iter_mut().zip(&self.row)) {
                    *cell = *inside && !outside(0, x);
                }
            }
            let cells = &self.now.cells[first..first + side as usize];
            self.now.rows[k as usize] = cells.iter().any(|&inside| inside);
        }
    }

    /// Leaves all cells.
    pub fn leave(&mut self) {
        std::mem::swap(&mut self.now, &mut self.previous);
        self.now.cells.fill(false);
        self.now.rows.fill(false);
    }

    /// Calls `left` and `entered` with the coordinates of cells that the last move changed.
    pub fn changes(&self, left: impl FnMut([i32; 3]), entered: impl FnMut([i32; 3])) {
        self.previous.minus(&self.now, left);
        self.now.minus(&self.previous, entered);
    }

    /// Bits of the cells `first..=last` of a row that are inside.
    #[inline]
    pub fn inside(&self, y: i32, z: i32, first: i32, last: i32) -> u32 {
        if !self.now.has_row(y, z) {
            return 0;
        }
        let bits = (first..=last).enumerate();
        bits.fold(0, |bits, (k, x)| bits | u32::from(self.now.holds([x, y, z])) << k)
    }

    /// Where a link between the centres of cells meets the surface first, as part of its length, in
    /// `(0, 1]`; half-way if it does not.
    pub fn meet(&self, from: [i32; 3], c: [i32; 3]) -> f64 {
        let point = |at: [i32; 3]| {
            let row = self.frame_row(at[1], at[2]);
            let x = f64::from(at[0] - self.now.origin[0]);
            std::array::from_fn(|a| row.start[a] + x * row.step[a])
        };
        let to = std::array::from_fn(|a| from[a] + c[a]);
        let found = self.surface.first_crossing(point(from), point(to));
        found.map_or(0.5, |crossing| crossing.fraction.clamp(f64::MIN_POSITIVE, 1.0))
    }

    /// Direction away from the part, at a point seen from its origin.
    pub fn outward(&self, arm: [f64; 3]) -> [f64; 3] {
        let point = self.frame.turn_to_part(arm.map(|x| x * self.cell));
        self.frame.turn_to_world(self.surface.closest(point).normal)
    }

    /// From its origin to the centre of its volume.
    pub fn middle(&self) -> [f64; 3] {
        self.frame.turn_to_world(self.centroid).map(|x| x / self.cell)
    }

    /// Centres of the cells of a row from the cover's origin on, in the part's frame [m].
    fn frame_row(&self, y: i32, z: i32) -> Row {
        let start = [self.now.origin[0], y, z].map(|k| (f64::from(k) + 0.5) * self.cell);
        Row {
            start: self.frame.to_part(start),
            step: self.frame.turn_to_part([self.cell, 0.0, 0.0]),
        }
    }
}

impl Cover {
    #[inline]
    fn has_row(&self, y: i32, z: i32) -> bool {
        let (j, k) = (y - self.origin[1], z - self.origin[2]);
        (0..self.side).contains(&j)
            && (0..self.side).contains(&k)
            && self.rows[(j + self.side * k) as usize]
    }

    #[inline]
    fn holds(&self, at: [i32; 3]) -> bool {
        let [i, j, k] = std::array::from_fn(|a| at[a] - self.origin[a]);
        [i, j, k].iter().all(|k| (0..self.side).contains(k))
            && self.cells[(i + self.side * (j + self.side * k)) as usize]
    }

    fn minus(&self, other: &Self, mut visit: impl FnMut([i32; 3])) {
        for row in (0..self.rows.len()).filter(|&row| self.rows[row]) {
            let (y, z) =
                (self.origin[1] + row as i32 % self.side, self.origin[2] + row as i32 / self.side);
            for x in self.origin[0]..self.origin[0] + self.side {
                if self.holds([x, y, z]) && !other.holds([x, y, z]) {
                    visit([x, y, z]);
                }
            }
        }
    }
}
