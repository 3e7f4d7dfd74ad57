//! Open area of each cell of a face, where walls of parts cross the face.
//!
//! The open area of a cell that a wall crosses is the part outside of the solid, found at points in
//! the plane of the cells' centres. The open area of a cell whose own centre is solid goes to its
//! neighbours in the face that are fluid, in equal parts: so the areas of all cells add up to the
//! open area of the face.

use crate::lattice::aa_pattern::Blocked;
use crate::lattice::layout::Layout;
use std::collections::{HashMap, HashSet};
use tremie_fluid_kit::cells::grid::{Grid, Reach};
use tremie_fluid_kit::survey::static_geometry::StaticGeometry;

/// Points along an edge of a cell: its area is known to some 1e-3.
const POINTS: i32 = 32;

/// Open areas of the cells at a face [cells].
#[derive(Default)]
pub struct OpenAreas {
    /// Of those that walls cross.
    crossed: HashMap<u32, f64>,
}

impl OpenAreas {
    /// Of cells, each with the axis across its face; `walls` are the links of all cells that meet
    /// something that stands still, by cell.
    pub fn new(
        ground: &StaticGeometry,
        layout: &Layout,
        cells: impl Iterator<Item = (u32, usize)>,
        walls: &[(Blocked, f64)],
    ) -> Self {
        let mut found = Self::default();
        let mut shared = HashSet::new();
        for (cell, axis) in cells {
            let first = walls.partition_point(|(link, _)| link.cell < cell);
            let mut own = walls[first..].iter().take_while(|(link, _)| link.cell == cell);
            if !own.any(|(link, _)| link.fixture.as_solid().is_some()) {
                continue;
            }
            let at = layout.at(cell);
            *found.crossed.entry(cell).or_default() += open_part(ground, at, axis);
            for near in beside(&ground.grid, at, axis) {
                if is_solid(ground, near) && shared.insert((near, axis)) {
                    found.share(ground, layout, near, axis);
                }
            }
        }
        found
    }

    /// Gives what is open of a solid cell to its neighbours.
    fn share(&mut self, ground: &StaticGeometry, layout: &Layout, at: [i32; 3], axis: usize) {
        let neighbours = beside(&ground.grid, at, axis);
        let fluid: Vec<u32> = neighbours.filter_map(|at| layout.cell(at)).collect();
        let open = open_part(ground, at, axis);
        for &cell in &fluid {
            *self.crossed.entry(cell).or_default() += open / fluid.len() as f64;
        }
    }

    /// Of a cell.
    pub fn of(&self, cell: u32) -> f64 {
        self.crossed.get(&cell).copied().unwrap_or(1.0)
    }
}

/// The cells beside one in the plane across an axis, those with a common edge.
fn beside(grid: &Grid, at: [i32; 3], axis: usize) -> impl Iterator<Item = [i32; 3]> {
    let along = (0..3).filter(move |&a| a != axis);
    let steps = along.flat_map(|a| [-1, 1].map(|step| (a, step)));
    steps.filter_map(move |(a, step)| {
        let mut to = at;
        to[a] += step;
        match grid.reach(to) {
            Reach::Cell { at: reached, mirrors: 0 } => Some(reached),
            _ => None,
        }
    })
}

/// True if the centre of a cell is in a solid.
fn is_solid(ground: &StaticGeometry, at: [i32; 3]) -> bool {
    let centre = ground.centres().of(at);
    ground.solids.iter().any(|solid| solid.holds(centre))
}

/// Part of a cell that no solid covers, in the plane of its centre across an axis.
fn open_part(ground: &StaticGeometry, at: [i32; 3], axis: usize) -> f64 {
    let centres = ground.centres();
    let middle = centres.of(at);
    let along = |k: i32| (f64::from(2 * k + 1) / f64::from(2 * POINTS) - 0.5) * centres.cell;
    let [a, b] = [(axis + 1) % 3, (axis + 2) % 3];
    let is_open = |k: &i32| {
        let mut point = middle;
        point[a] += along(k % POINTS);
        point[b] += along(k / POINTS);
        !ground.solids.iter().any(|solid| solid.holds(point))
    };
    (0..POINTS * POINTS).filter(is_open).count() as f64 / f64::from(POINTS * POINTS)
}
