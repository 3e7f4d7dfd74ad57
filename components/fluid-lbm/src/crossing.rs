//! Mass that crosses a section, link by link.
//!
//! ```text
//! passed = 1/2 sum over the two sides of the layer of cells of (sum over links across it f_i c_i.n)
//! ```
//!
//! Populations that arrive in fluid cells from fluid cells beyond a side are counted, and none that a wall threw back. This is the
//! flow whose balance the lattice keeps: sections of one steady stream agree to rounding, whatever stands between them,
//! where walls are half-way or along the axes; along interpolated walls aslant some of it passes beyond the last cells,
//! half a per cent in a tube of 9 cells, and comes back within a step of the wall. The sum of the cells' velocities differs
//! from it by the shear at the walls, in a duct of ten cells by some 1 %.
//!
//! Cells at open faces are given other populations than arrived (see `open`). The layer at such a face is read one cell further
//! inside.

use crate::field::Real;
use crate::grid::Side;
use crate::lattice::{C, OPPOSITE, Q, mirrored};
use crate::layout::Layout;
use crate::owners::Owners;
use crate::refill::Before;

/// A link across a side of the layer.
#[derive(Clone, Copy, Debug)]
struct Link {
    from: u32,
    to: u32,
    /// Direction in which it arrives.
    dir: u8,
    /// Sample's weight, by the number of sides of the layer, negative against the axis.
    weight: f32,
}

/// Links that cross a part of a section.
#[derive(Clone, Debug, Default)]
pub struct Crossing {
    /// The section's number among the probes.
    pub probe: usize,
    links: Vec<Link>,
    /// Mass that passed in the last step that was looked at [cells at density 1].
    pub passed: f64,
}

impl Crossing {
    /// Of cells of a layer across an axis, with weights.
    pub fn of(layout: &Layout, axis: usize, probe: usize, layer: &[([i32; 3], f64)]) -> Self {
        let mut links = Vec::new();
        for &(at, weight) in layer {
            let Some((cell, sides)) = sides(layout, axis, at) else { continue };
            let share = weight / sides.iter().filter(|&&read| read).count() as f64;
            for i in (1..Q).filter(|&i| C[i][axis] != 0 && sides[usize::from(C[i][axis] > 0)]) {
                let Some((other, arrives)) = end(layout, cell, i) else { continue };
                let weight = (share * f64::from(C[i][axis])) as f32;
                // What leaves the cell along a link, and what comes back on it.
                links.push(Link { from: cell, to: other, dir: arrives as u8, weight });
                let back = OPPOSITE[i] as u8;
                links.push(Link { from: other, to: cell, dir: back, weight: -weight });
            }
        }
        Self { probe, links, passed: 0.0 }
    }

    /// Adds up what arrived in the last step.
    pub fn look<T: Real>(&mut self, before: &Before<T>, owners: &Owners) {
        self.passed = 0.0;
        for link in &self.links {
            if owners.is_fluid(link.from) && owners.is_fluid(link.to) {
                let place = before.layout.place(before.parity, link.to, usize::from(link.dir));
                self.passed += f64::from(link.weight) * before.field.get(place);
            }
        }
    }
}

/// Which sides of a cell's layer can be read. Cells at open faces have lost what arrived: in place of their layer stands the
/// next one, by its inner side.
fn sides(layout: &Layout, axis: usize, mut at: [i32; 3]) -> Option<(u32, [bool; 2])> {
    let grid = &layout.grid;
    if grid.periodic[axis] {
        return Some((layout.cell(at)?, [true; 2]));
    }
    let last = grid.n[axis] - 1;
    let is_open = grid.sides[axis].map(|side| side == Side::Open);
    let first_read = if is_open[0] { 2 } else { 1 };
    let last_read = if is_open[1] { last - 1 } else { last };
    at[axis] = at[axis].clamp(first_read - 1, last_read);
    let sides = [0, 1].map(|side| (first_read..=last_read).contains(&(at[axis] + side)));
    let cell = layout.cell(at)?;
    sides.contains(&true).then_some((cell, sides))
}

/// The cell in which what leaves a cell along `i` arrives, and the direction in which it does.
fn end(layout: &Layout, cell: u32, i: usize) -> Option<(u32, usize)> {
    let other = layout.neighbour(cell, i)?;
    let (_, mirrors) = layout.near(layout.at(cell), C[i])?;
    Some((other, mirrored(i, mirrors)))
}
