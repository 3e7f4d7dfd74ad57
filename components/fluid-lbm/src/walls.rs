//! The domain's walls: half-way reflection, `f_i' = g_i - 6 w_i rho (c_i.u_w)` (Ladd 1994).

use crate::field::Real;
use crate::grid::Grid;
use crate::lattice::{C, C_F64, Q, W, dot};
use crate::ledger::add_scaled;
use crate::links::{After, density};
use crate::owners::FLUID;

/// Cells of a face that are one item of work.
const CELLS_PER_ITEM: usize = 2048;

/// A wall: one face of the domain.
#[derive(Clone, Debug)]
pub struct Wall {
    /// Axis across the wall.
    pub axis: usize,
    /// 0 for the lower face, 1 for the upper.
    pub side: usize,
    /// Velocity of the wall, along it.
    pub velocity: [f64; 3],
    /// Directions whose links cross this wall and no wall of a lower axis.
    directions: Vec<(usize, [bool; 3])>,
}

/// Rows of a wall, and what they exchanged in the last step.
#[derive(Clone, Debug)]
pub struct Item {
    /// Place of the wall in the list.
    wall: usize,
    rows: std::ops::Range<usize>,
    /// Momentum that went to the fluid.
    pub impulse: [f64; 3],
    /// Mass that went to the fluid.
    pub mass: f64,
}

/// The walls of a box.
pub fn walls(grid: &Grid) -> Vec<Wall> {
    let walled = grid.periodic.map(|p| !p);
    let mut walls = Vec::new();
    for axis in (0..3).filter(|&a| walled[a]) {
        for side in 0..2 {
            let outward = [-1, 1][side];
            let directions = (1..Q)
                .filter(|&i| C[i][axis] == outward)
                // A link over an edge crosses two walls: the one of the lower axis has it.
                .map(|i| (i, std::array::from_fn(|a| a < axis && walled[a] && C[i][a] != 0)))
                .collect();
            walls.push(Wall { axis, side, velocity: [0.0; 3], directions });
        }
    }
    walls
}

impl Wall {
    /// The axes along the wall, the one that runs along rows first.
    fn axes(&self) -> [usize; 2] {
        [[1, 2], [0, 2], [0, 1]][self.axis]
    }
}

/// The items of all walls.
pub fn items(walls: &[Wall], grid: &Grid) -> Vec<Item> {
    let mut items = Vec::new();
    for (place, wall) in walls.iter().enumerate() {
        let [along, across] = wall.axes().map(|a| grid.n[a] as usize);
        let step = (CELLS_PER_ITEM / along).max(1);
        for first in (0..across).step_by(step) {
            let rows = first..(first + step).min(across);
            items.push(Item { wall: place, rows, impulse: [0.0; 3], mass: 0.0 });
        }
    }
    items
}

/// Reflects the links of an item and records what they exchanged.
pub fn reflect<T: Real>(after: &After<T>, walls: &[Wall], item: &mut Item) {
    let (wall, grid) = (&walls[item.wall], after.grid);
    let [along, across] = wall.axes();
    let (mut impulse, mut mass) = ([0.0; 3], 0.0);
    for row in item.rows.clone() {
        for k in 0..grid.n[along] {
            let mut at = [0; 3];
            at[wall.axis] = [0, grid.n[wall.axis] - 1][wall.side];
            (at[along], at[across]) = (k, row as i32);
            let cell = grid.cell(at);
            if after.owners.of(cell.index) != FLUID {
                continue;
            }
            let rho = if wall.velocity == [0.0; 3] { 1.0 } else { density(&after.post(cell)) };
            for (i, guarded) in &wall.directions {
                let i = *i;
                let beyond = |a: usize| guarded[a] && !(0..grid.n[a]).contains(&(at[a] + C[i][a]));
                if beyond(0) || beyond(1) {
                    continue;
                }
                let g = after.post_one(cell, i);
                let f = g - 6.0 * W[i] * rho * dot(C_F64[i], wall.velocity);
                let f = after.put_reflected(cell, i, grid.neighbour(cell, i), f);
                add_scaled(&mut impulse, C_F64[i], -(g + f));
                mass += f - g;
            }
        }
    }
    (item.impulse, item.mass) = (impulse, mass);
}
