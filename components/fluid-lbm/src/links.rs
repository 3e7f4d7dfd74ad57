//! Links between fluid and bodies: reflection at a moving curved wall, and the force that it takes.
//!
//! A link runs from the fluid cell `x_f` along `c_i` into a body and meets its surface at `x_f + q
//! c_i`. The reflected population is interpolated linearly (Bouzidi, Firdaouss & Lallemand 2001),
//! `i'` being the opposite direction, `u_w` the surface's velocity, `rho` the density at `x_f`:
//!
//! ```text
//! q < 1/2 :  f_i'(x_f) = 2q g_i(x_f) + (1-2q) g_i(x_f - c_i)               - 6 w_i rho (c_i.u_w)
//! q >= 1/2:  f_i'(x_f) = g_i(x_f)/(2q) + (2q-1)/(2q) g_i'(x_f)             - 3 (w_i/q) rho (c_i.u_w)
//! ```
//!
//! Where `x_f - c_i` is not fluid and `q < 1/2`, the wall is taken half-way (`q = 1/2`). If several
//! bodies hold the link's end, the one with the smallest `q` has it. A link that ends beyond a face
//! of the domain belongs to the face.
//!
//! The force on the body is the Galilean-invariant exchange of Wen et al. 2014, `g_i (c_i - u_w) -
//! f_i' (c_i' - u_w)`, in deviations from the fluid at rest, so that it counts gauge pressure.

use crate::bodies::{Bodies, Body};
use crate::field::{Field, Real};
use crate::grid::{Cell, Grid, Parity};
use crate::lattice::{C, C_F64, OPPOSITE, Q, W, cross, dot};
use crate::ledger::add_scaled;
use crate::owners::{FLUID, Owners, SHARED};
use crate::sphere::{Span, wall_distance};

/// Rows of a body's shell that are one item of work.
const ROWS_PER_ITEM: i32 = 256;

/// Layers of a body's links, and what they exchanged in the last step. The cut into items depends
/// on the body's size alone, and items are added up in their order.
#[derive(Clone, Debug)]
pub struct Item {
    /// Place of the body among the living.
    pub body: usize,
    /// Layers of the shell, along z.
    layers: std::ops::Range<i32>,
    /// The exchange.
    pub exchange: Exchange,
}

/// What links exchanged in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exchange {
    /// Force on the body.
    pub force: [f64; 3],
    /// Torque on the body about its centre.
    pub torque: [f64; 3],
    /// Momentum that went to the fluid besides: `(f_i' - g_i) u_w`.
    pub swept: [f64; 3],
    /// Mass that went to the fluid.
    pub mass: f64,
    /// Number of links.
    pub links: usize,
    /// Those without a second fluid cell where it was needed.
    pub fallbacks: usize,
}

impl Exchange {
    /// Adds another.
    pub fn join(&mut self, other: &Self) {
        add_scaled(&mut self.force, other.force, 1.0);
        add_scaled(&mut self.torque, other.torque, 1.0);
        add_scaled(&mut self.swept, other.swept, 1.0);
        self.mass += other.mass;
        self.links += other.links;
        self.fallbacks += other.fallbacks;
    }
}

/// The items of all bodies.
pub fn items(bodies: &Bodies) -> Vec<Item> {
    let mut items = Vec::new();
    for (place, body) in bodies.living.iter().enumerate() {
        let side = body.spans.shell_side();
        let layers = (ROWS_PER_ITEM / side).max(1);
        let mut first = 0;
        while first < side {
            let layers = first..(first + layers).min(side);
            first = layers.end;
            items.push(Item { body: place, layers, exchange: Exchange::default() });
        }
    }
    items
}

/// The fluid after a collision, before its links are reflected.
#[derive(Clone, Copy)]
pub struct After<'a, T: Real> {
    /// Populations.
    pub field: &'a Field<T>,
    /// Shape of the box.
    pub grid: &'a Grid,
    /// Who owns which cell.
    pub owners: &'a Owners,
    /// Parity of the collision just done.
    pub parity: Parity,
}

/// For each direction, the cells of a row whose links end inside a body.
type Starts = [Span; Q];

/// A cell at which links begin.
struct Start {
    cell: Cell,
    /// Vector from the body's centre to the cell's.
    arm: [f64; 3],
    /// Post-collision populations.
    g: [f64; Q],
    /// Density.
    rho: f64,
}

impl<T: Real> After<'_, T> {
    /// Post-collision population `g_i` of a cell.
    #[inline(always)]
    pub fn post_one(&self, cell: Cell, i: usize) -> f64 {
        self.field.get(self.parity.place(self.grid, cell, OPPOSITE[i]))
    }

    /// All post-collision populations of a cell.
    #[inline(always)]
    pub fn post(&self, cell: Cell) -> [f64; Q] {
        let mut g = [0.0; Q];
        for i in 0..Q {
            g[i] = self.post_one(cell, i);
        }
        g
    }

    /// Writes what the next collision will find as the population `i'` of a cell whose neighbour
    /// along `i` has index `end`.
    #[inline(always)]
    pub fn put_reflected(&self, cell: Cell, i: usize, end: usize, value: f64) -> f64 {
        // This is `self.parity.flipped().place(cell, i')`.
        let place = match self.parity {
            Parity::Even => (i, end),
            Parity::Odd => (OPPOSITE[i], cell.index),
        };
        self.field.set(place, value)
    }

    /// Reflects the links of an item and records what they exchanged.
    pub fn reflect(&self, bodies: &Bodies, item: &mut Item) {
        let body = &bodies.living[item.body];
        let mut exchange = Exchange::default();
        for k in item.layers.clone() {
            for j in 0..body.spans.shell_side() {
                self.reflect_row(bodies, body, body.spans.shell_row(j, k), &mut exchange);
            }
        }
        item.exchange = exchange;
    }

    /// Reflects the links that begin in a row `(y, z)`.
    fn reflect_row(&self, bodies: &Bodies, body: &Body, [y, z]: [i32; 2], exchange: &mut Exchange) {
        let mut starts: Starts = [Span::NONE; Q];
        let (mut first, mut last) = (i32::MAX, i32::MIN);
        for i in 1..Q {
            let ends = body.spans.at(y + C[i][1], z + C[i][2]);
            if !ends.is_empty() {
                starts[i] = Span { first: ends.first - C[i][0], last: ends.last - C[i][0] };
                first = first.min(starts[i].first);
                last = last.max(starts[i].last);
            }
        }
        let grid = self.grid;
        let own = body.spans.at(y, z);
        let mut x = first;
        while x <= last {
            if own.contains(x) {
                x = own.last + 1;
                continue;
            }
            let at = [grid.wrap(0, x), grid.wrap(1, y), grid.wrap(2, z)];
            if grid.contains(at) && self.owners.of(grid.index(at)) == FLUID {
                self.reflect_cell(bodies, body, &starts, grid.cell(at), [x, y, z], exchange);
            }
            x += 1;
        }
    }

    /// Reflects the links that begin in a cell; `seen_at` are its coordinates as seen from the
    /// body.
    fn reflect_cell(
        &self,
        bodies: &Bodies,
        body: &Body,
        starts: &Starts,
        cell: Cell,
        seen_at: [i32; 3],
        exchange: &mut Exchange,
    ) {
        let mut links = 0_u32;
        for i in 1..Q {
            links |= u32::from(starts[i].contains(seen_at[0])) << i;
        }
        if links == 0 {
            return;
        }
        let g = self.post(cell);
        let start = Start {
            cell,
            arm: std::array::from_fn(|a| f64::from(seen_at[a]) + 0.5 - body.position[a]),
            rho: density(&g),
            g,
        };
        while links != 0 {
            self.reflect_link(bodies, body, &start, links.trailing_zeros() as usize, exchange);
            links &= links - 1;
        }
    }

    /// Reflects the link `i` of a cell, if it is the body's.
    #[inline]
    fn reflect_link(
        &self,
        bodies: &Bodies,
        body: &Body,
        start: &Start,
        i: usize,
        exchange: &mut Exchange,
    ) {
        let (cell, arm, c) = (start.cell, start.arm, C_F64[i]);
        let end = self.grid.neighbour(cell, i);
        let q = wall_distance(arm, c, body.r2());
        if self.owners.of(end) == SHARED && !self.is_first(bodies, body, cell, i, q) {
            return;
        }
        let wall = [arm[0] + q * c[0], arm[1] + q * c[1], arm[2] + q * c[2]];
        let u = body.velocity_at(wall);
        let push = 6.0 * W[i] * start.rho * dot(c, u);
        let g = start.g[i];
        let f = if q >= 0.5 {
            let part = 0.5 / q;
            part * g + (1.0 - part) * start.g[OPPOSITE[i]] - part * push
        } else if let Some(behind) = self.post_behind(cell, i) {
            2.0 * q * g + (1.0 - 2.0 * q) * behind - push
        } else {
            exchange.fallbacks += 1;
            g - push
        };
        let f = self.put_reflected(cell, i, end, f);
        let (sum, gain) = (g + f, f - g);
        let force = [sum * c[0] + gain * u[0], sum * c[1] + gain * u[1], sum * c[2] + gain * u[2]];
        add_scaled(&mut exchange.force, force, 1.0);
        add_scaled(&mut exchange.torque, cross(wall, force), 1.0);
        add_scaled(&mut exchange.swept, u, gain);
        exchange.mass += gain;
        exchange.links += 1;
    }

    /// Post-collision population `i` of the cell behind, against direction `i`, if it is fluid.
    #[inline]
    fn post_behind(&self, cell: Cell, i: usize) -> Option<f64> {
        let behind = self.grid.neighbour(cell, OPPOSITE[i]);
        // The place of `i'` of the cell behind, whose neighbour along `i` is `cell`.
        let place = match self.parity {
            Parity::Even => (OPPOSITE[i], behind),
            Parity::Odd => (i, cell.index),
        };
        (self.owners.of(behind) == FLUID).then(|| self.field.get(place))
    }

    /// Whether of all bodies that hold the end of the link, this one is met first (then: has the
    /// lowest id).
    fn is_first(&self, bodies: &Bodies, body: &Body, cell: Cell, i: usize, q: f64) -> bool {
        let end = self.grid.neighbour(cell, i);
        self.owners.claimants(end).filter(|&handle| handle != body.handle).all(|handle| {
            let other = bodies.with_handle(handle);
            let arm = self.grid.arm(other.position, cell.at);
            let of_other = wall_distance(arm, C_F64[i], other.r2());
            q < of_other || (q == of_other && body.id < other.id)
        })
    }
}

/// Density of a cell from its populations.
#[inline]
pub fn density(g: &[f64; Q]) -> f64 {
    let mut drho = [0.0; 3];
    for i in 0..Q {
        drho[i % 3] += g[i];
    }
    1.0 + (drho[0] + drho[1] + drho[2])
}
