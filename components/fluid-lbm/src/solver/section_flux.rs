//! Mass that crosses a section, link by link.
//!
//! ```text
//! passed = 1/2 sum over the two sides of the layer of cells of
//!            ( sum over links between fluid cells across it f_i c_i.n  +  sum over links into moving walls across it 6 w_i rho (c_i.u_w) c_i.n )
//! ```
//!
//! Populations that arrive in fluid cells from fluid cells beyond a side are counted, and none that
//! a wall threw back; a wall that moves carries along what its links take. This is the flow whose
//! balance the lattice keeps: sections of one steady stream agree to rounding, whatever stands
//! between them, where walls are half-way or along the axes. Along interpolated walls aslant some
//! of it passes beyond the last cells, half a per cent in a tube of 9 cells, and comes back within
//! a step of the wall. The sum of the cells' velocities differs from it by the shear at the walls,
//! in a duct of ten cells by some 1 %.
//!
//! Cells at open faces are given other populations than arrived (see `open_boundary`). The layer at
//! such a face is read one cell further inside. Of walls that stand still those that slide along
//! themselves are left out, but for faces of the domain.

use crate::bodies::body_list::Bodies;
use crate::boundary::refill::PreCollision;
use crate::domain::boundary_condition::BoundaryValue;
use crate::lattice::cell_flags::CellFlags;
use crate::lattice::d3q19::{C, C_F64, OPPOSITE, Q, W, dot, mirrored};
use crate::lattice::exact_sum::BinnedSum;
use crate::lattice::layout::Layout;
use crate::lattice::populations::Real;
use tremie_fluid_kit::cells::grid::{Reach, Side};

/// A link across a side of the layer.
#[derive(Clone, Copy, Debug)]
struct CrossingLink {
    /// Of the layer.
    cell: u32,
    end: FluxEnd,
    /// Direction in which it leaves the layer.
    dir: u8,
    /// Sample's weight, by the number of sides of the layer, negative against the axis.
    weight: f32,
}

/// End of a link that crosses a section.
#[derive(Clone, Copy, Debug)]
enum FluxEnd {
    /// In a cell, in which what leaves the layer arrives in a direction, mirrored at some axes.
    Cell { cell: u32, dir: u8, mirrors: u8 },
    /// At a face of the domain, `2 axis + side`.
    Face(u8),
}

/// Surroundings that the links of a section need.
#[derive(Clone, Copy)]
pub struct Sight<'a, T: Real> {
    /// The fluid.
    pub before: PreCollision<'a, T>,
    /// Owners of the cells.
    pub flags: &'a CellFlags,
    /// The bodies.
    pub bodies: &'a Bodies,
    /// Values that fixtures prescribe.
    pub now: &'a [BoundaryValue],
}

/// Links that cross a part of a section.
#[derive(Clone, Debug, Default)]
pub struct Crossing {
    /// The section's number among the probes.
    pub probe: usize,
    links: Vec<CrossingLink>,
    /// Mass that passed in the last step that was looked at [cells at density 1].
    pub passed: BinnedSum,
}

impl Crossing {
    /// Of cells of a layer across an axis, with weights.
    pub fn of(layout: &Layout, axis: usize, probe: usize, layer: &[([i32; 3], f64)]) -> Self {
        let mut links = Vec::new();
        for &(at, weight) in layer {
            let found = sides(layout, axis, at).filter(|(cell, _)| layout.is_own(*cell));
            let Some((cell, sides)) = found else { continue };
            let share = weight / sides.iter().filter(|&&read| read).count() as f64;
            for i in (1..Q).filter(|&i| C[i][axis] != 0 && sides[usize::from(C[i][axis] > 0)]) {
                let Some(end) = end(layout, cell, i) else { continue };
                let weight = (share * f64::from(C[i][axis])) as f32;
                links.push(CrossingLink { cell, end, dir: i as u8, weight });
            }
        }
        Self { probe, links, passed: BinnedSum::default() }
    }

    /// Adds up what passed in the last step.
    pub fn look<T: Real>(&mut self, sight: &Sight<T>) {
        self.passed = BinnedSum::default();
        for link in &self.links {
            if sight.flags.is_fluid(link.cell) {
                self.passed.add(f64::from(link.weight) * sight.passed(link));
            }
        }
    }
}

impl<T: Real> Sight<'_, T> {
    /// Mass that passed along a link out of its cell.
    fn passed(&self, link: &CrossingLink) -> f64 {
        let PreCollision { layout, parity, field, .. } = self.before;
        let i = usize::from(link.dir);
        match link.end {
            FluxEnd::Cell { cell, dir, .. } if self.flags.is_fluid(cell) => {
                let arrived = |cell: u32, i: usize| field.get(layout.place(parity, cell, i));
                arrived(cell, dir.into()) - arrived(link.cell, OPPOSITE[i])
            }
            FluxEnd::Cell { cell, mirrors, .. } => {
                self.velocity_in(cell, mirrors).map_or(0.0, |u| self.carried(link.cell, i, u))
            }
            FluxEnd::Face(face) => match self.now[usize::from(face)] {
                BoundaryValue::Wall(u) if u != [0.0; 3] => self.carried(link.cell, i, u),
                _ => 0.0,
            },
        }
    }

    /// Mass that a wall with a velocity takes from a cell along a link.
    fn carried(&self, cell: u32, i: usize, u: [f64; 3]) -> f64 {
        6.0 * W[i] * (1.0 + self.before.content(cell).drho) * dot(C_F64[i], u)
    }

    /// Velocity of the body that holds a cell, if one does; as seen in mirrors.
    fn velocity_in(&self, cell: u32, mirrors: u8) -> Option<[f64; 3]> {
        let body = self.bodies.with_handle(self.flags.holder(cell)?);
        let layout = self.before.layout;
        let u = body.velocity_at(layout.grid.arm(body.position, layout.at(cell)));
        Some(std::array::from_fn(|a| if mirrors >> a & 1 == 1 { -u[a] } else { u[a] }))
    }
}

/// Cell whose layer stands for a cell's, and its sides that can be read. Cells at open faces have
/// lost the populations that arrived: in place of their layer stands the next one, by its inner
/// side.
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

/// End of the link along `i` from a cell, if that is neither in a part that stands still nor beyond
/// an open face.
fn end(layout: &Layout, cell: u32, i: usize) -> Option<FluxEnd> {
    let at = layout.at(cell);
    if let Some(other) = layout.neighbour(cell, i) {
        let (_, mirrors) = layout.near(at, C[i])?;
        return Some(FluxEnd::Cell { cell: other, dir: mirrored(i, mirrors) as u8, mirrors });
    }
    match layout.grid.reach(std::array::from_fn(|a| at[a] + C[i][a])) {
        Reach::Face { axis, side } if layout.grid.sides[axis][side] == Side::Wall => {
            Some(FluxEnd::Face((2 * axis + side) as u8))
        }
        _ => None,
    }
}
