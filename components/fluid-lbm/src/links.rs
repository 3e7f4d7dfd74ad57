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
//! of the domain or in a static solid belongs to that.
//!
//! The force on the body is the Galilean-invariant exchange of Wen et al. 2014, `g_i (c_i - u_w) -
//! f_i' (c_i' - u_w)`, in deviations from the fluid at rest, so that it counts gauge pressure.
//!
//! # Order of work
//! Links are found row by row and collected in a batch; then one loop does the geometry of the
//! whole batch, one reads and writes populations, one adds up forces. Loops over a batch have no
//! branches where vectors can do them; memory is asked for when a link is found and used when the
//! batch is full. Sums run in eight lanes that are added in order.

use crate::batch::{Batch, Link};
use crate::bodies::Bodies;
use crate::body::Body;
use crate::declared::Intakes;
use crate::field::{Field, Real};
use crate::gaps::Gaps;
use crate::grid::{Grid, Side};
use crate::lanes::Variant;
use crate::lattice::{C, OPPOSITE, Q, each, mirrored};
use crate::layout::Layout;
use crate::ledger::add_scaled;
use crate::owners::{Owners, SHARED};
use crate::part_links::{PartLinks, Site, as_seen};
use crate::places::Parity;
use crate::sphere::Span;
use crate::wall_distances::WallDistances;

/// Rows of a body's shell that are one item of work.
const ROWS_PER_ITEM: i32 = 256;

/// Cells of a row that are searched for links at once.
pub const CHUNK: i32 = 8;

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
    /// Gaps that they found.
    pub gaps: Gaps,
    /// The links, of a part.
    pub found: PartLinks,
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
    /// Of the force, what the mirrored half of the fluid gave: links through a mirror are reckoned
    /// as those of the mirrored cell, whose force is the mirrored one.
    pub image: [f64; 3],
    /// The same for `swept`.
    pub image_swept: [f64; 3],
    /// Mass that went to the fluid.
    pub mass: f64,
    /// Volume by which the wall receded, the sum of `6 w_i (c_i.u_w)`, and the sum of `6 w_i`; where
    /// bodies keep accounts of mass.
    pub receded: f64,
    /// See `receded`.
    pub weight: f64,
    /// Volume by which it receded from gaps that hold no fluid.
    pub drawn: f64,
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
        add_scaled(&mut self.image, other.image, 1.0);
        add_scaled(&mut self.image_swept, other.image_swept, 1.0);
        self.mass += other.mass;
        self.receded += other.receded;
        self.weight += other.weight;
        self.drawn += other.drawn;
        self.links += other.links;
        self.fallbacks += other.fallbacks;
    }
}

/// The items of all bodies.
/// Those that press count for so many declared gaps and intakes.
pub fn items(bodies: &Bodies, gaps_press: bool, [declared, intakes]: [usize; 2]) -> Vec<Item> {
    let mut items = Vec::new();
    for (place, body) in bodies.living.iter().enumerate() {
        let side = body.shell_side();
        let layers = (ROWS_PER_ITEM / side).max(1);
        let mut first = 0;
        while first < side {
            let layers = first..(first + layers).min(side);
            first = layers.end;
            let gaps =
                if gaps_press { Gaps::with_room(declared, intakes) } else { Gaps::default() };
            let found = PartLinks::default();
            items.push(Item { body: place, layers, exchange: Exchange::default(), gaps, found });
        }
    }
    items
}

/// The fluid after a collision, before its links are reflected.
#[derive(Clone, Copy)]
pub struct After<'a, T: Real> {
    /// Populations.
    pub field: &'a Field<T>,
    /// Where they are.
    pub layout: &'a Layout,
    /// Who owns which cell.
    pub owners: &'a Owners,
    /// Parity of the collision just done.
    pub parity: Parity,
    /// Densities of the lines near bodies.
    pub drho: &'a Field<T>,
    /// Which vector instructions.
    pub variant: Variant,
    /// Whether bodies keep accounts of mass.
    pub keeps_mass: bool,
    /// See [`nearest_wall`].
    pub nearest_wall: f64,
    /// The static geometry, if gaps press.
    pub walls: Option<&'a WallDistances>,
    /// For each cell the declared gap that it may be frozen in; empty without such gaps.
    pub gap_of: &'a [u16],
    /// Where what such gaps draw in leaves the fluid.
    pub intakes: &'a Intakes,
}

impl Item {
    /// Finds the links of a part, if it has moved.
    pub fn find(&mut self, site: &Site, bodies: &Bodies) {
        self.found.find(site, &bodies.living[self.body], self.layers.clone());
        let felt = self.found.felt();
        if felt > self.gaps.felt.capacity() {
            self.gaps.felt.clear();
            self.gaps.felt.reserve(felt + felt / 2);
        }
    }
}

impl<T: Real> After<'_, T> {
    /// Post-collision population `g_i` of a cell.
    #[inline(always)]
    pub fn post_one(&self, cell: u32, i: usize) -> f64 {
        self.field.get(self.layout.place(self.parity, cell, OPPOSITE[i]))
    }

    /// All post-collision populations of a cell.
    #[inline(always)]
    pub fn post(&self, cell: u32) -> [f64; Q] {
        each(|i| self.post_one(cell, i))
    }

    /// Reflects the links of an item and records what they exchanged.
    pub fn reflect(&self, bodies: &Bodies, item: &mut Item, batch: &mut Batch) {
        let body = &bodies.living[item.body];
        batch.begin(body);
        std::mem::swap(&mut batch.gaps, &mut item.gaps);
        batch.gaps.clear();
        if let Some(part) = &body.part {
            self.reflect_part(bodies, body, part, &item.found, batch);
        } else {
            for k in item.layers.clone() {
                for j in 0..body.shell_side() {
                    self.row(bodies, body, body.shell_row(j, k), batch);
                }
            }
        }
        batch.flush(self, body);
        item.exchange = batch.exchange();
        std::mem::swap(&mut batch.gaps, &mut item.gaps);
        if let Some(walls) = self.walls.filter(|_| item.layers.start == 0) {
            self.gaps_at_faces(bodies, body, walls, &mut item.gaps);
        }
    }

    /// Finds the links that begin in a row `(y, z)`, given as seen from the body.
    fn row(&self, bodies: &Bodies, body: &Body, [y, z]: [i32; 2], batch: &mut Batch) {
        let grid = &self.layout.grid;
        let (real_y, real_z) = (grid.wrap(1, y), grid.wrap(2, z));
        if real_y < 0 || real_y >= grid.n[1] || real_z < 0 || real_z >= grid.n[2] {
            return;
        }
        // For each direction the cells whose links end inside, and the axes at which they are
        // mirrored on the way along y and z.
        let mut starts = [(Span::NONE, 0_u8); Q];
        let (mut first, mut last) = (i32::MAX, i32::MIN);
        let to_y = [-1, 0, 1].map(|d| fold(grid, 1, y + d));
        let to_z = [-1, 0, 1].map(|d| fold(grid, 2, z + d));
        let around = to_z.map(|(z, _)| to_y.map(|(y, _)| body.spans.at(y, z)));
        if around.iter().flatten().all(|span| span.is_empty()) {
            return;
        }
        for i in 1..Q {
            let [dy, dz] = [1, 2].map(|a| (C[i][a] + 1) as usize);
            let (ends, mirror_y, mirror_z) = (around[dz][dy], to_y[dy].1, to_z[dz].1);
            if !ends.is_empty() {
                let mut start = Span { first: ends.first - C[i][0], last: ends.last - C[i][0] };
                if !grid.periodic[0] {
                    // A body at a mirror goes on behind it.
                    let mirror = |side: usize| grid.sides[0][side] == Side::Symmetry;
                    let begin =
                        if C[i][0] == -1 && ends.first == 0 && mirror(0) { 0 } else { start.first };
                    let end = if C[i][0] == 1 && ends.last == grid.n[0] - 1 && mirror(1) {
                        ends.last
                    } else {
                        start.last
                    };
                    start = Span { first: begin.max(0), last: end.min(grid.n[0] - 1) };
                    if start.is_empty() {
                        continue;
                    }
                }
                starts[i] = (start, mirror_y << 1 | mirror_z << 2);
                first = first.min(start.first);
                last = last.max(start.last);
            }
        }
        let own = body.spans.at(y, z);
        let base = grid.index([0, real_y, real_z]);
        let mirrors = starts.map(|(_, mirrors)| mirrors);
        let row = Row { bodies, body, y, z, base, mirrors: &mirrors };
        let mut x = first;
        while x <= last {
            if own.contains(x) {
                x = own.last + 1;
                continue;
            }
            let until = if own.first > x { own.first - 1 } else { last };
            let end = (x + CHUNK - 1).min(until).min(last);
            let mut links = [0; Q];
            for i in 1..Q {
                let (from, to) = (starts[i].0.first.max(x), starts[i].0.last.min(end));
                if from <= to {
                    links[i] = (u32::MAX >> (31 - (to - from))) << (from - x);
                }
            }
            self.chunk(&row, x, end, &links, batch);
            x = end + 1;
        }
    }

    /// Finds the links that begin in the cells `first..=last` of a row, at most [`CHUNK`] of them.
    /// `inside` says for each direction and cell whether the link's end is in the body.
    fn chunk(&self, row: &Row, first: i32, last: i32, inside: &[u32; Q], batch: &mut Batch) {
        let (grid, cells) = (&self.layout.grid, &self.layout.cells);
        batch.make_room(self, row.body);
        // Fluid cells of the chunk, and the batch's slot of each.
        let (mut fluid, mut slots) = (0_u32, [0; CHUNK as usize]);
        for x in first..=last {
            let index = row.base + grid.wrap(0, x) as usize;
            let number = if cells.are_all() { index as u32 } else { cells.number(index) };
            if number != crate::cells::NONE && self.owners.is_fluid(number) {
                fluid |= 1 << (x - first);
                slots[(x - first) as usize] = batch.cell(number);
            }
        }
        let mut used = 0_u32;
        for i in 1..Q {
            let mut links = fluid & inside[i];
            used |= links;
            while links != 0 {
                let k = links.trailing_zeros();
                links &= links - 1;
                let link = self.link(row, first + k as i32, i, slots[k as usize]);
                if self.is_mine(row, &link, batch) {
                    batch.push(link);
                }
            }
        }
        if let Some(walls) = self.walls {
            let solid = (u32::MAX >> (31 - (last - first))) & !fluid;
            if solid != 0 {
                self.gaps_in(row, walls, first, solid, inside, batch);
            }
        }
        while used != 0 {
            self.layout.places.prefetch(batch.number(slots[used.trailing_zeros() as usize]));
            used &= used - 1;
        }
    }

    /// Finds the gap links that begin in the cells of a row from `first` on whose bits are set in
    /// `solid`; see `gaps`.
    fn gaps_in(
        &self,
        row: &Row,
        walls: &WallDistances,
        first: i32,
        solid: u32,
        inside: &[u32; Q],
        batch: &mut Batch,
    ) {
        let grid = &self.layout.grid;
        for i in (1..Q).filter(|&i| row.mirrors[i] == 0) {
            let mut links = solid & inside[i];
            while links != 0 {
                let x = first + links.trailing_zeros() as i32;
                links &= links - 1;
                let end = x + C[i][0];
                if grid.periodic[0] || (end >= 0 && end < grid.n[0]) {
                    let at = [x, row.y, row.z];
                    self.gap(row.bodies, row.body, walls, at, i, &mut batch.gaps);
                }
            }
        }
    }

    /// The link `i` of a cell at `x` of a row.
    #[inline(always)]
    fn link(&self, row: &Row, x: i32, i: usize, slot: u16) -> Link {
        let (grid, mut mirrors) = (&self.layout.grid, row.mirrors[i]);
        let end = x + C[i][0];
        if !grid.periodic[0] && (end < 0 || end >= grid.n[0]) {
            mirrors |= 1;
        }
        let mut at = [x, row.y, row.z];
        let mut c = i;
        if mirrors != 0 {
            // As seen by the body: the mirrored link of the mirrored cell.
            c = mirrored(i, mirrors);
            for a in 0..3 {
                if mirrors >> a & 1 == 1 {
                    at[a] = if C[i][a] < 0 { -1 - at[a] } else { 2 * grid.n[a] - 1 - at[a] };
                }
            }
        }
        let arm = std::array::from_fn(|a| f64::from(at[a]) + 0.5 - row.body.position[a]);
        Link { slot, dir: i as u8, seen: c as u8, mirrors, arm, q: f64::NAN }
    }

    /// Whether a link ends in no static solid, and no other body holds its end and is met before.
    #[inline(always)]
    fn is_mine(&self, row: &Row, link: &Link, batch: &Batch) -> bool {
        if self.layout.cells.are_all() && !self.owners.any_shared() {
            return true;
        }
        let cell = batch.number(link.slot);
        match self.layout.neighbour(cell, link.dir.into()) {
            None => false,
            Some(end) => {
                self.owners.of(end) != SHARED
                    || self.is_first(row.bodies, row.body, cell, link.dir.into(), end)
            }
        }
    }

    /// Whether of all bodies that hold the end of the link `i` of a cell, this one is met first (then: has the
    /// lowest id). Where a link meets a body does not depend on who asks: else two might take it, or nobody.
    pub fn is_first(&self, bodies: &Bodies, body: &Body, cell: u32, i: usize, end: u32) -> bool {
        let at = self.layout.at(cell);
        let q = self.met_at(body, at, i);
        self.owners.claimants(end).filter(|&handle| handle != body.handle).all(|handle| {
            let other = bodies.with_handle(handle);
            let of_other = self.met_at(other, at, i);
            q < of_other || (q == of_other && body.id < other.id)
        })
    }

    /// Where the link `i` of a cell meets a body that holds its end; a part where its links were found.
    fn met_at(&self, body: &Body, at: [i32; 3], i: usize) -> f64 {
        let grid = &self.layout.grid;
        let mirrors = grid.mirrors_to(std::array::from_fn(|a| at[a] + C[i][a]));
        let (at, seen) = as_seen(grid, at, i, mirrors);
        body.met_at(grid.arm(body.position, at), seen)
    }
}

impl<T: Real> After<'_, T> {
    /// Where the link `i` of a cell, at `arm` from a body, meets another body that holds its end.
    pub fn distance(&self, body: &Body, other: &Body, arm: [f64; 3], i: usize) -> f64 {
        // From the other body to the cell, by the shortest way.
        let arm = std::array::from_fn(|a| {
            let d = arm[a] + body.position[a] - other.position[a];
            let n = f64::from(self.layout.grid.n[a]);
            if self.layout.grid.periodic[a] { d - n * (d / n).round() } else { d }
        });
        other.met_at(arm, i)
    }
}

/// A row of cells around a body.
struct Row<'a> {
    bodies: &'a Bodies,
    body: &'a Body,
    /// Coordinates as seen from the body.
    y: i32,
    z: i32,
    /// Index in the box of its first cell.
    base: usize,
    /// For each direction the axes among y and z at which links are mirrored.
    mirrors: &'a [u8; Q],
}

/// A row's coordinate along `axis`, moved back into the box at a mirror, and whether it was.
#[inline]
pub fn fold(grid: &Grid, axis: usize, k: i32) -> (i32, u8) {
    if k == -1 && grid.sides[axis][0] == Side::Symmetry {
        (0, 1)
    } else if k == grid.n[axis] && grid.sides[axis][1] == Side::Symmetry {
        (k - 1, 1)
    } else {
        (k, 0)
    }
}

/// As part of a link, how near a wall may be to the cell where the link begins; one that is nearer counts as
/// that near.
///
/// Interpolation to a wall that nearly touches the last cell amplifies waves between it and a wall across: with
/// BGK below a relaxation time of some 0.514 at a fiftieth of a link, of 0.507 at a tenth. At less than a fifth
/// nothing grows at any relaxation time. So the bound falls from a fifth at 1/2 to nothing at 0.52. Parts that move
/// stay where they are: a valve that stands where a layer of cells opens would hunt for the step in its flow.
pub fn nearest_wall(tau: f64) -> f64 {
    0.2 * (1.0 - (tau - 0.5) / 0.02).clamp(0.0, 1.0)
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
