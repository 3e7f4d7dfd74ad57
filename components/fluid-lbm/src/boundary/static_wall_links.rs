//! Links at things that stand still, where reflection half-way alone does not do: curved walls,
//! walls that slide along themselves, regions that prescribe velocity or pressure. (Half-way
//! reflection: see `halfway_bounce_back`.)
//!
//! With `g` the populations after the collision, `i'` opposite to `i`, the link `i` leaving `x_f`
//! and meeting the surface at `x_f + q c_i`:
//!
//! ```text
//! wall      f_i'(x_f) as in `bouzidi`, with the wall's velocity (Bouzidi et al. 2001)
//! pressure  f_i'(x_f) = -g_i(x_f) + 2 w_i rho_w [1 + 9/2 (c_i.u)^2 - 3/2 u.u],  u that of x_f
//! ```
//!
//! (anti-bounce-back, Ginzburg, Verhaeghe & d'Humieres 2008, eq. 22; the surface half-way). A part
//! that prescribes a velocity is a wall that has it. The force on the part is that of the
//! populations exchanged, `g_i c_i - f_i' c_i'`, in deviations from rest.
//!
//! A face that slides along itself pushes into a cell what it takes from it, link by link in
//! opposite pairs. Where it ends at another wall a pair lacks one link: mass enters at one edge and
//! leaves at the other, as it does in the half cell along the face, which drags it from edge to
//! edge. But the density differs from edge to edge, and so would the mass. So it enters and leaves
//! at the fluid's mean density `rho_m`; the difference is taken from the cell's population at rest:
//!
//! ```text
//! f_0(x) -= sum over links to sliding faces (f_i' - g_i + 6 w_i rho_m (c_i.u))
//! ```
//!
//! The mass that interpolation makes or takes at walls is paid back over some hundred steps, see
//! `wall_mass`; at once at links between two cells of the fluid, see `sheet_links`.
//!
//! All links of a cell are one unit of work: the place of a link's result is that of its own `g_i`
//! (see `aa_pattern`), which another link of the same cell may want to read before.

use crate::boundary::bouzidi::Bouzidi;
use crate::boundary::post_collision::{PostCollision, density};
use crate::boundary::wall_mass::{Patch, Patches, WEIGHT};
use crate::domain::boundary_condition::BoundaryValue;
use crate::lattice::aa_pattern::{Blocked, Parity};
use crate::lattice::cell_list::BoundaryId;
use crate::lattice::d3q19::{C_F64, OPPOSITE, Q, W, dot};
use crate::lattice::layout::{Layout, block_of};
use crate::lattice::ledger::add_scaled;
use crate::lattice::momentum_exchange::MomentumExchange;
use crate::lattice::populations::Real;
use std::ops::Range;
use tremie_fluid_kit::cells::grid::Grid;

/// Cells that are one item of work at most, all of one block.
const CELLS_PER_ITEM: usize = 1024;

/// Bit of a link with `q < 1/2`: the other population is that of the cell behind.
const NEAR: u8 = 1;
/// Bit of a link that leads to another cell of the fluid, and keeps the mass with the one that
/// comes from there (see `sheet_links`).
const CUT: u8 = 2;

/// A link. 12 bytes.
#[derive(Clone, Copy, Debug)]
struct WallLink {
    /// Place of the population `i` of its cell in odd steps.
    odd: u32,
    /// Factor of `g_i`; that of the other population is what it lacks to 1. To 7 digits: a wall is
    /// nowhere known better.
    own: f32,
    /// Direction.
    dir: u8,
    /// See `NEAR` and `CUT`.
    kind: u8,
    /// Place of its fixture in the item's list.
    fixture: u16,
}

impl WallLink {
    #[inline(always)]
    fn is_near(&self) -> bool {
        self.kind & NEAR != 0
    }

    #[inline(always)]
    fn is_cut(&self) -> bool {
        self.kind & CUT != 0
    }

    /// Wall distance, as a fraction of the link's length.
    fn q(&self) -> f64 {
        let own = f64::from(self.own);
        if self.is_near() { 0.5 * own } else { 0.5 / own }
    }
}

/// Number of cells ahead of its use at which memory is asked for.
const AHEAD: usize = 8;

/// Coordinates of cells that mostly share their row with the one before.
#[derive(Default)]
struct RowCursor {
    /// Index of the row's first cell in the box, and of the one after its last.
    first: usize,
    end: usize,
    y: i32,
    z: i32,
}

impl RowCursor {
    #[inline(always)]
    fn at(&mut self, grid: &Grid, index: usize) -> [i32; 3] {
        if index < self.first || index >= self.end {
            let [x, y, z] = grid.at(index);
            self.first = index - x as usize;
            self.end = self.first + grid.n[0] as usize;
            (self.y, self.z) = (y, z);
        }
        [(index - self.first) as i32, self.y, self.z]
    }
}

/// All such links, by cell.
#[derive(Clone, Debug, Default)]
pub struct StaticWallLinks {
    cells: Vec<u32>,
    /// First link of each cell, and the end.
    first: Vec<u32>,
    /// Place of each cell's patch in the item's list.
    patches: Vec<u16>,
    links: Vec<WallLink>,
}

/// Cells whose links are one item of work, and what these exchanged.
#[derive(Clone, Debug, Default)]
pub struct WallItem {
    cells: Range<usize>,
    /// True if this part of the lattice counts its cells.
    pub is_own: bool,
    /// For each fixture that the item's links meet, their exchange.
    pub exchanges: Vec<(BoundaryId, MomentumExchange)>,
    /// For each of these, whether it is a solid wall, whose links have to keep the mass.
    are_walls: Vec<bool>,
    /// Patches of wall that the item's cells belong to.
    pub patches: Vec<Patch>,
}

/// Exchanges and patch of wall that the links of one cell add to.
struct MetByCell<'a> {
    exchanges: &'a mut [(BoundaryId, MomentumExchange)],
    are_walls: &'a [bool],
    patch: &'a mut Patch,
}

impl MetByCell<'_> {
    /// Mass that a link pays back for its patch of wall.
    #[inline(always)]
    fn pay(&mut self, link: &WallLink) -> f64 {
        if link.is_cut() || !self.are_walls[usize::from(link.fixture)] {
            return 0.0;
        }
        let weight = WEIGHT[usize::from(link.dir)];
        self.patch.weight += weight;
        weight * self.patch.pay
    }

    /// Takes note of the mass that links to a fixture gave to the fluid.
    #[inline(always)]
    fn gain(&mut self, fixture: u16, mass: f64) {
        let fixture = usize::from(fixture);
        if self.are_walls[fixture] {
            self.patch.gained += mass;
        } else if self.exchanges[fixture].0.as_solid().is_none() {
            self.patch.of_faces += mass;
        }
    }
}

impl StaticWallLinks {
    /// Of blocked links in the order of cells, with `q` of each; `is_wall` says which fixtures are
    /// solid walls, and `references` the point of each about which its torque counts; `sheets` are
    /// the ends of those that keep the mass in pairs, sorted.
    pub fn new(
        layout: &Layout,
        references: &[[f64; 3]],
        sheets: &[(u32, u8)],
        blocked: impl Iterator<Item = (Blocked, f64)>,
        is_wall: impl Fn(BoundaryId) -> bool,
    ) -> (Self, Vec<WallItem>, Patches) {
        let mut own = Self::default();
        let mut items: Vec<WallItem> = Vec::new();
        let mut patches = Patches::default();
        for (Blocked { cell, dir, fixture }, q) in blocked {
            if own.cells.last() != Some(&cell) {
                let is_full = items.last().is_none_or(|item| item.cells.len() == CELLS_PER_ITEM);
                let of_other = |&last: &u32| block_of(last) != block_of(cell);
                if is_full || own.cells.last().is_some_and(of_other) {
                    let start = own.cells.len();
                    let is_own = layout.is_own(cell);
                    items.push(WallItem { cells: start..start, is_own, ..WallItem::default() });
                }
                let item = items.last_mut().expect("an item was begun");
                // A cell belongs to the patch of the fixture that its first link meets.
                let met = (fixture, references[usize::from(fixture.0)]);
                let patch = patches.place(&layout.grid, layout.at(cell), met, &mut item.patches);
                own.patches.push(patch);
                own.cells.push(cell);
                own.first.push(own.links.len() as u32);
                item.cells.end = own.cells.len();
            }
            let item = items.last_mut().expect("an item was begun");
            let exchanges = &mut item.exchanges;
            let place = exchanges.iter().position(|e| e.0 == fixture).unwrap_or(exchanges.len());
            if place == exchanges.len() {
                exchanges.push((fixture, MomentumExchange::default()));
                item.are_walls.push(is_wall(fixture));
            }
            own.links.push(WallLink {
                odd: layout.places.odd(cell, dir.into()) as u32,
                own: Bouzidi::at(q).own as f32,
                dir,
                kind: if q < 0.5 { NEAR } else { 0 }
                    | if sheets.binary_search(&(cell, dir)).is_ok() { CUT } else { 0 },
                fixture: place as u16,
            });
        }
        own.first.push(own.links.len() as u32);
        (own, items, patches)
    }

    /// The links of a cell, by its place in the list.
    #[inline(always)]
    fn of(&self, k: usize) -> &[WallLink] {
        &self.links[self.first[k] as usize..self.first[k + 1] as usize]
    }

    /// Cell and direction of each link, by cell.
    pub fn ends(&self) -> impl Iterator<Item = (u32, u8)> {
        let cells = self.cells.iter().enumerate();
        cells.flat_map(|(k, &cell)| self.of(k).iter().map(move |link| (cell, link.dir)))
    }

    /// Memory that the tables take [bytes].
    pub fn bytes(&self) -> usize {
        size_of_val(self.links.as_slice())
            + 4 * (self.cells.len() + self.first.len())
            + 2 * self.patches.len()
    }
}

impl<T: Real> PostCollision<'_, T> {
    /// Reflects the links of an item. `now` says for each fixture what it prescribes, `reference`
    /// the point about which its torque counts.
    pub fn reflect_fixed(
        &self,
        links: &StaticWallLinks,
        now: &[BoundaryValue],
        reference: &[[f64; 3]],
        item: &mut WallItem,
    ) {
        for (_, exchange) in &mut item.exchanges {
            *exchange = MomentumExchange::default();
        }
        item.patches.iter_mut().for_each(Patch::begin);
        let still = |(fixture, _): &(BoundaryId, MomentumExchange)| {
            now[usize::from(fixture.0)] == BoundaryValue::Wall([0.0; 3])
        };
        let all_still = item.exchanges.iter().all(still);
        let mut row = RowCursor::default();
        for k in item.cells.clone() {
            let cell = links.cells[k];
            if k + AHEAD < links.cells.len() {
                self.ask_for_cell(links.cells[k + AHEAD], links.of(k + AHEAD));
            }
            if !self.flags.is_fluid(cell) {
                continue;
            }
            let at = row.at(&self.layout.grid, self.layout.cells.index(cell));
            let met = MetByCell {
                exchanges: &mut item.exchanges,
                are_walls: &item.are_walls,
                patch: &mut item.patches[usize::from(links.patches[k])],
            };
            // Walls at rest need no density, so that not all populations of the cell are read.
            if all_still {
                self.reflect_still(cell, at, links.of(k), reference, met);
            } else {
                self.reflect_cell(cell, at, links.of(k), now, reference, met);
            }
        }
    }

    /// Places of `g_i` of a link and of the other population that it needs.
    #[inline(always)]
    fn places_of(&self, cell: u32, link: &WallLink) -> (usize, usize) {
        let (i, stride) = (usize::from(link.dir), self.layout.places.stride());
        let own = OPPOSITE[i] * stride + cell as usize;
        let within = i * stride + cell as usize;
        let even = self.parity == Parity::Even;
        (own, if even != link.is_near() { within } else { link.odd as usize })
    }

    /// Asks memory for what a cell's links need.
    #[inline(always)]
    fn ask_for_cell(&self, cell: u32, links: &[WallLink]) {
        for link in links {
            let (own, other) = self.places_of(cell, link);
            self.field.prefetch(own);
            self.field.prefetch(other);
        }
    }

    /// Reflects the links of a cell at walls at rest.
    #[inline]
    fn reflect_still(
        &self,
        cell: u32,
        at: [i32; 3],
        links: &[WallLink],
        reference: &[[f64; 3]],
        mut met: MetByCell,
    ) {
        let all_fluid = self.flags.all_fluid();
        let mut values = [(0.0, 0.0); Q];
        for (link, value) in links.iter().zip(&mut values) {
            let (own, other) = self.places_of(cell, link);
            let g = self.field.get(own);
            let factor = f64::from(link.own);
            let f = if link.own == 1.0 {
                g
            } else if link.is_near() && !all_fluid && !self.has_behind(cell, link.dir.into()) {
                met.exchanges[usize::from(link.fixture)].1.fallbacks += 1;
                g
            } else {
                factor * g + (1.0 - factor) * self.field.get(other)
            };
            *value = (g, f + met.pay(link));
        }
        // Links of a cell mostly meet one fixture: its exchange is added once.
        let (mut force, mut gain, mut unpaired, mut count) = ([0.0; 3], 0.0, 0.0, 0);
        for (k, (link, (g, f))) in links.iter().zip(values).enumerate() {
            let f = self.field.set(self.places_of(cell, link).0, f);
            add_scaled(&mut force, C_F64[usize::from(link.dir)], g + f);
            gain += f - g;
            unpaired += if link.is_cut() { 0.0 } else { f - g };
            count += 1;
            if links.get(k + 1).is_none_or(|next| next.fixture != link.fixture) {
                met.gain(link.fixture, unpaired);
                let (fixture, exchange) = &mut met.exchanges[usize::from(link.fixture)];
                // The arm to the surface is that to the cell but for a part along the force.
                let arm = self.layout.grid.arm(reference[usize::from(fixture.0)], at);
                exchange.add_force(force, arm);
                exchange.mass += gain;
                exchange.links += count;
                (force, gain, unpaired, count) = ([0.0; 3], 0.0, 0.0, 0);
            }
        }
    }

    fn reflect_cell(
        &self,
        cell: u32,
        at: [i32; 3],
        links: &[WallLink],
        now: &[BoundaryValue],
        reference: &[[f64; 3]],
        mut met: MetByCell,
    ) {
        let still = |link: &WallLink| {
            now[met.exchanges[link.fixture as usize].0.0 as usize] == BoundaryValue::Wall([0.0; 3])
        };
        let all = if links.iter().all(still) { None } else { Some(self.post(cell)) };
        let mut values = [(0.0, 0.0); Q];
        for (link, value) in links.iter().zip(&mut values) {
            let (fixture, exchange) = &mut met.exchanges[link.fixture as usize];
            let g = self.post_one(cell, link.dir.into());
            let f = match now[fixture.0 as usize] {
                BoundaryValue::Wall(u) => self.at_wall(cell, link, g, u, all.as_ref(), exchange),
                BoundaryValue::Density(drho) => {
                    let all =
                        all.as_ref().expect("populations were read because the surface is no wall");
                    at_density(link.dir.into(), g, drho, all)
                }
            };
            *value = (g, f + met.pay(link));
        }
        let (mut brought, mut slid) = (0.0, 0.0);
        for (link, (g, f)) in links.iter().zip(values) {
            let (i, c) = (link.dir as usize, C_F64[link.dir as usize]);
            let f = self.field.set(self.next_place(cell, OPPOSITE[i]), f);
            if !link.is_cut() {
                met.gain(link.fixture, f - g);
            }
            let (fixture, exchange) = &mut met.exchanges[link.fixture as usize];
            // The arm to the surface is that to the cell but for a part along the force. A wall at
            // rest sweeps nothing.
            let arm = self.layout.grid.arm(reference[fixture.0 as usize], at);
            exchange.add_link(c, [g + f, f - g], [0.0; 3], arm);
            exchange.links += 1;
            if fixture.as_solid().is_none() {
                brought += f - g;
                if let BoundaryValue::Wall(u) = now[fixture.0 as usize] {
                    slid += 6.0 * W[i] * dot(c, u);
                }
            }
        }
        // Cells at open faces get other populations yet.
        let more = brought + self.mean * slid;
        if more != 0.0 && self.layout.grid.open_faces(at).next().is_none() {
            let exchanges = &mut met.exchanges;
            let is_face =
                |link: &&WallLink| exchanges[link.fixture as usize].0.as_solid().is_none();
            if let Some(link) = links.iter().find(is_face) {
                exchanges[link.fixture as usize].1.mass += self.give(cell, -more);
            }
        }
    }

    /// Gives a mass to a cell, without momentum; returns what it got.
    fn give(&self, cell: u32, mass: f64) -> f64 {
        let place = self.next_place(cell, 0);
        let old = self.field.get(place);
        self.field.set(place, old + mass) - old
    }

    /// Population `f_i'` that comes back from a wall with velocity `u`.
    fn at_wall(
        &self,
        cell: u32,
        link: &WallLink,
        g: f64,
        u: [f64; 3],
        all: Option<&[f64; Q]>,
        exchange: &mut MomentumExchange,
    ) -> f64 {
        let (i, q) = (link.dir as usize, link.q());
        let push = all.map_or(0.0, |all| 6.0 * W[i] * density(all) * dot(C_F64[i], u));
        let place = if q == 0.5 {
            return g - push;
        } else if q > 0.5 {
            self.layout.place(self.parity, cell, i)
        } else if self.has_behind(cell, i) {
            self.next_place(cell, i)
        } else {
            exchange.fallbacks += 1;
            return g - push;
        };
        Bouzidi::at(q).reflect(g, self.field.get(place), push)
    }

    /// True if the cell behind a link's beginning, against direction `i`, is fluid.
    #[inline(always)]
    fn has_behind(&self, cell: u32, i: usize) -> bool {
        self.layout.behind(cell, i).is_some_and(|behind| self.flags.is_fluid(behind))
    }

    /// Place at which the next step finds a population.
    #[inline(always)]
    pub fn next_place(&self, cell: u32, i: usize) -> usize {
        self.layout.place(self.parity.flipped(), cell, i)
    }
}

/// Population `f_i'` that comes back from a surface with density `1 + drho`, of the link `i` of a cell
/// with these populations.
pub fn at_density(i: usize, g: f64, drho: f64, all: &[f64; Q]) -> f64 {
    let rho = density(all);
    let u: [f64; 3] =
        std::array::from_fn(|a| (0..Q).map(|i| all[i] * C_F64[i][a]).sum::<f64>() / rho);
    let cu = dot(C_F64[i], u);
    -g + 2.0 * W[i] * (drho + (1.0 + drho) * (4.5 * cu * cu - 1.5 * dot(u, u)))
}
