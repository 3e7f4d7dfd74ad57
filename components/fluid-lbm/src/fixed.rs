//! Links at things that stand still, where reflection half-way alone does not do: curved walls,
//! walls that slide along themselves, regions that prescribe velocity or pressure.
//!
//! With `g` the populations after the collision, `i'` opposite to `i`, the link `i` leaving `x_f` and
//! meeting the surface at `x_f + q c_i`:
//!
//! ```text
//! wall      f_i'(x_f) as in `links`, with the wall's velocity (Bouzidi et al. 2001)
//! pressure  f_i'(x_f) = -g_i(x_f) + 2 w_i rho_w [1 + 9/2 (c_i.u)^2 - 3/2 u.u],  u that of x_f
//! ```
//!
//! (anti-bounce-back, Ginzburg, Verhaeghe & d'Humieres 2008, eq. 22; the surface half-way). A part
//! that prescribes a velocity is a wall that has it. The force on the part is that of the
//! populations exchanged, `g_i c_i - f_i' c_i'`, in deviations from rest.
//!
//! All links of a cell are one unit of work: the place of a link's result is that of its own `g_i`
//! (see `places`), which another link of the same cell may want to read before.

use crate::cells::Fixture;
use crate::course::Now;
use crate::field::Real;
use crate::lattice::{C_F64, OPPOSITE, Q, W, cross, dot};
use crate::ledger::add_scaled;
use crate::links::{After, Exchange, density};
use crate::places::Blocked;
use std::ops::Range;

/// Cells that are one item of work.
const CELLS_PER_ITEM: usize = 1024;

/// A link.
#[derive(Clone, Copy, Debug)]
struct Link {
    /// Where it meets the surface, as a fraction of its length.
    q: f64,
    /// Direction.
    dir: u8,
    /// Place of its fixture in the item's list.
    fixture: u16,
}

/// All such links, by cell.
#[derive(Clone, Debug, Default)]
pub struct FixedLinks {
    cells: Vec<u32>,
    /// First link of each cell, and the end.
    first: Vec<u32>,
    links: Vec<Link>,
}

/// Cells whose links are one item of work, and what these exchanged.
#[derive(Clone, Debug)]
pub struct Item {
    cells: Range<usize>,
    /// For each fixture that the item's links meet, their exchange.
    pub exchanges: Vec<(Fixture, Exchange)>,
}

impl FixedLinks {
    /// Of blocked links in the order of cells, with `q` of each.
    pub fn new(blocked: impl Iterator<Item = (Blocked, f64)>) -> (Self, Vec<Item>) {
        let mut own = Self::default();
        let mut items: Vec<Item> = Vec::new();
        for (Blocked { cell, dir, fixture }, q) in blocked {
            if own.cells.last() != Some(&cell) {
                if own.cells.len() % CELLS_PER_ITEM == 0 {
                    let start = own.cells.len();
                    items.push(Item { cells: start..start, exchanges: Vec::new() });
                }
                own.cells.push(cell);
                own.first.push(own.links.len() as u32);
            }
            let item = items.last_mut().expect("an item was begun");
            item.cells.end = own.cells.len();
            let exchanges = &mut item.exchanges;
            let place = exchanges.iter().position(|e| e.0 == fixture).unwrap_or(exchanges.len());
            if place == exchanges.len() {
                exchanges.push((fixture, Exchange::default()));
            }
            own.links.push(Link { q, dir, fixture: place as u16 });
        }
        own.first.push(own.links.len() as u32);
        (own, items)
    }

    /// Memory that the tables take [bytes].
    pub fn bytes(&self) -> usize {
        size_of_val(self.links.as_slice()) + 4 * (self.cells.len() + self.first.len())
    }
}

impl<T: Real> After<'_, T> {
    /// Reflects the links of an item. `now` says for each fixture what it prescribes, `reference`
    /// the point about which its torque counts.
    pub fn reflect_fixed(
        &self,
        links: &FixedLinks,
        now: &[Now],
        reference: &[[f64; 3]],
        item: &mut Item,
    ) {
        for (_, exchange) in &mut item.exchanges {
            *exchange = Exchange::default();
        }
        for k in item.cells.clone() {
            let cell = links.cells[k];
            if self.owners.is_fluid(cell) {
                let own = &links.links[links.first[k] as usize..links.first[k + 1] as usize];
                self.reflect_cell(cell, own, now, reference, &mut item.exchanges);
            }
        }
    }

    fn reflect_cell(
        &self,
        cell: u32,
        links: &[Link],
        now: &[Now],
        reference: &[[f64; 3]],
        exchanges: &mut [(Fixture, Exchange)],
    ) {
        let still =
            |link: &Link| now[exchanges[link.fixture as usize].0.0 as usize] == Now::Wall([0.0; 3]);
        let all = if links.iter().all(still) { None } else { Some(self.post(cell)) };
        let mut values = [(0.0, 0.0); Q];
        for (link, value) in links.iter().zip(&mut values) {
            let (fixture, exchange) = &mut exchanges[link.fixture as usize];
            let g = self.post_one(cell, link.dir.into());
            let f = match now[fixture.0 as usize] {
                Now::Wall(u) => self.at_wall(cell, link, g, u, all.as_ref(), exchange),
                Now::Density(drho) => at_density(link, g, drho, all.as_ref()),
            };
            *value = (g, f);
        }
        let at = self.layout.at(cell);
        for (link, (g, f)) in links.iter().zip(values) {
            let (fixture, exchange) = &mut exchanges[link.fixture as usize];
            let (i, c) = (link.dir as usize, C_F64[link.dir as usize]);
            let f = self.field.set(self.next_place(cell, OPPOSITE[i]), f);
            let force = c.map(|c| (g + f) * c);
            add_scaled(&mut exchange.force, force, 1.0);
            if fixture.as_solid().is_some() {
                let arm = self.layout.grid.arm(reference[fixture.0 as usize], at);
                let wall = std::array::from_fn(|a| arm[a] + link.q * c[a]);
                add_scaled(&mut exchange.torque, cross(wall, force), 1.0);
            }
            exchange.mass += f - g;
            exchange.links += 1;
        }
    }

    /// What comes back from a wall with velocity `u`.
    fn at_wall(
        &self,
        cell: u32,
        link: &Link,
        g: f64,
        u: [f64; 3],
        all: Option<&[f64; Q]>,
        exchange: &mut Exchange,
    ) -> f64 {
        let (i, q) = (link.dir as usize, link.q);
        let push = all.map_or(0.0, |all| 6.0 * W[i] * density(all) * dot(C_F64[i], u));
        if q == 0.5 {
            g - push
        } else if q > 0.5 {
            let part = 0.5 / q;
            let other = self.field.get(self.layout.place(self.parity, cell, i));
            part * g + (1.0 - part) * other - part * push
        } else if self.has_behind(cell, i) {
            let behind = self.field.get(self.next_place(cell, i));
            2.0 * q * g + (1.0 - 2.0 * q) * behind - push
        } else {
            exchange.fallbacks += 1;
            g - push
        }
    }

    /// Where the next step finds a population.
    #[inline(always)]
    pub fn next_place(&self, cell: u32, i: usize) -> usize {
        self.layout.place(self.parity.flipped(), cell, i)
    }
}

/// What comes back from a surface with density `1 + drho`.
fn at_density(link: &Link, g: f64, drho: f64, all: Option<&[f64; Q]>) -> f64 {
    let i = link.dir as usize;
    let all = all.expect("populations were read because the surface is no wall");
    let rho = density(all);
    let u: [f64; 3] =
        std::array::from_fn(|a| (0..Q).map(|i| all[i] * C_F64[i][a]).sum::<f64>() / rho);
    let cu = dot(C_F64[i], u);
    -g + 2.0 * W[i] * (drho + (1.0 + drho) * (4.5 * cu * cu - 1.5 * dot(u, u)))
}
