//! A batch of links of one body: geometry, populations, forces, each in one loop.
//!
//! See `links` for the formulae. A link costs the numbers below, some 200 bytes that stay in the
//! first-level cache, three places of the field, and the density, which the collision left.

use crate::body::Body;
use crate::columns::{self, Eight, LANES, Lane, Paid, Sums, Surface};
use crate::field::Real;
use crate::gaps::Gaps;
use crate::lattice::{C_F64, OPPOSITE, Q, W};
use crate::ledger::add_scaled;
use crate::links::{After, CHUNK, Exchange};
use crate::places::Parity;
use crate::shape::{Felt, NO_FACET};

/// Links of a full batch: their cache lines, some three each, must fit in the first-level cache together
/// with what is known of them.
const LINKS: usize = 320;
/// Links of a chunk of cells at most.
const MOST: usize = CHUNK as usize * (Q - 1);

/// The place of a population that there is not.
const NOWHERE: usize = u32::MAX as usize;

/// A link of a body.
#[derive(Clone, Copy, Debug)]
pub struct Link {
    /// The cell where it begins.
    pub cell: u32,
    /// Its direction.
    pub dir: u8,
    /// Its direction as seen by the body: mirrored if the link goes through a mirror.
    pub seen: u8,
    /// Axes at which it is mirrored.
    pub mirrors: u8,
    /// From the body's centre to the cell's, mirrored likewise.
    pub arm: [f64; 3],
    /// Where it meets the surface; found later for a sphere.
    pub q: f64,
}

/// Links that wait to be reflected.
pub struct Batch {
    eights: Box<[Eight]>,
    dirs: [u8; LINKS],
    mirrors: [u8; LINKS],
    cells: [u32; LINKS],
    /// Places of `g_i`, of the other population, and of the result.
    places: [[u32; 3]; LINKS],
    links: usize,
    sums: Sums,
    paid: Paid,
    exchange: Exchange,
    /// Velocity of the wall and facet of each link, of a surface that can deform.
    walls: [([f64; 3], u32); LINKS],
    /// Gaps that the item found, and what facets felt.
    pub gaps: Gaps,
}

impl Default for Batch {
    fn default() -> Self {
        Self {
            eights: vec![Eight::NONE; LINKS / LANES].into(),
            dirs: [0; LINKS],
            mirrors: [0; LINKS],
            cells: [0; LINKS],
            places: [[0; 3]; LINKS],
            links: 0,
            sums: [[0.0; LANES]; 10],
            paid: [[0.0; LANES]; 2],
            exchange: Exchange::default(),
            walls: [([0.0; 3], NO_FACET); LINKS],
            gaps: Gaps::default(),
        }
    }
}

impl Batch {
    /// Begins an item of a body.
    pub fn begin(&mut self, _: &Body) {
        self.links = 0;
        self.sums = [[0.0; LANES]; 10];
        self.paid = [[0.0; LANES]; 2];
        self.exchange = Exchange::default();
    }

    /// What the item exchanged.
    pub fn exchange(&self) -> Exchange {
        let total = |lane: &Lane| lane.iter().fold(0.0, |sum, x| sum + x);
        let sum = |k: usize| total(&self.sums[k]);
        let vector = |k: usize| [sum(k), sum(k + 1), sum(k + 2)];
        let [receded, weight] = self.paid.each_ref().map(total);
        Exchange {
            force: vector(0),
            torque: vector(3),
            swept: vector(6),
            mass: sum(9),
            receded,
            weight,
            ..self.exchange
        }
    }

    /// Counts a volume by which the wall recedes where it has no links; see `mass`.
    pub fn draw(&mut self, volume: f64) {
        self.exchange.drawn += volume;
    }

    /// Makes room for a chunk of cells, if there is not enough.
    #[inline]
    pub fn make_room<T: Real>(&mut self, after: &After<T>, body: &Body) {
        if self.links + MOST > LINKS {
            self.flush(after, body);
        }
    }

    /// Takes a link into the batch.
    #[inline(always)]
    pub fn push(&mut self, link: Link) {
        let (k, c) = (self.links, C_F64[link.seen as usize]);
        let (eight, lane) = (&mut self.eights[k / LANES], k % LANES);
        for a in 0..3 {
            eight.arm[a][lane] = link.arm[a];
            eight.c[a][lane] = c[a];
        }
        eight.q[lane] = link.q;
        eight.cc[lane] = SQUARE[link.seen as usize];
        eight.weight[lane] = 6.0 * W[link.seen as usize];
        self.dirs[k] = link.dir;
        self.mirrors[k] = link.mirrors;
        self.cells[k] = link.cell;
        self.links += 1;
    }

    /// Makes the last link push as much more fluid as others that it stands for would.
    pub fn widen(&mut self, by: f64) {
        let last = self.links - 1;
        self.eights[last / LANES].weight[last % LANES] *= by;
    }

    /// Says how the wall moves where the last link meets it, and which facet that is on.
    pub fn wall(&mut self, velocity: [f64; 3], facet: u32) {
        self.walls[self.links - 1] = (velocity, facet);
    }

    /// Reflects all links of the batch and empties it.
    pub fn flush<T: Real>(&mut self, after: &After<T>, body: &Body) {
        if self.links == 0 {
            return;
        }
        let full = self.links.div_ceil(LANES);
        self.fill_up(full);
        let r2 = body.part.is_none().then(|| body.r2());
        let nearest = if body.is_part() { 0.0 } else { after.nearest_wall };
        let (velocity, spin, change) = (body.velocity, body.spin, body.change);
        let surface = Surface { r2, velocity, spin, change, nearest };
        columns::locate(after.variant, &mut self.eights[..full], surface);
        let is_soft = body.part.as_ref().is_some_and(|part| part.shape.is_some());
        if is_soft {
            self.move_walls();
        }
        if after.keeps_mass {
            self.pay(after, body);
        }
        self.ask(after);
        self.reflect(after);
        for k in self.links..full * LANES {
            let (eight, lane) = (&mut self.eights[k / LANES], k % LANES);
            (eight.sum[lane], eight.gain[lane]) = (0.0, 0.0);
        }
        columns::add_up(after.variant, &self.eights[..full], &mut self.sums);
        self.add_images();
        if is_soft {
            self.feel();
        }
        self.exchange.links += self.links;
        self.links = 0;
    }

    /// Fills the lanes beyond the last link with links as it that weigh nothing.
    fn fill_up(&mut self, full: usize) {
        let last = self.links - 1;
        let (model, from) = (self.eights[last / LANES], last % LANES);
        let eight = &mut self.eights[full - 1];
        for lane in from + 1..LANES {
            for a in 0..3 {
                eight.arm[a][lane] = model.arm[a][from];
                eight.c[a][lane] = model.c[a][from];
            }
            eight.q[lane] = model.q[from];
            eight.cc[lane] = model.cc[from];
            eight.weight[lane] = 0.0;
        }
    }

    /// Takes the walls' velocities, which no rigid motion gives.
    fn move_walls(&mut self) {
        for k in 0..self.links {
            let (s, l) = (&mut self.eights[k / LANES], k % LANES);
            let u = self.walls[k].0;
            let push = s.weight[l] * (s.c[0][l] * u[0] + s.c[1][l] * u[1] + s.c[2][l] * u[2]);
            s.push[l] = if s.q[l] >= 0.5 { 0.5 / s.q[l] * push } else { push };
            for a in 0..3 {
                s.u[a][l] = u[a];
            }
        }
    }

    /// Notes the force on each facet; that of links through mirrors as the facet feels it.
    fn feel(&mut self) {
        for k in 0..self.links {
            let (s, l) = (&self.eights[k / LANES], k % LANES);
            let force = std::array::from_fn(|a| s.sum[l] * s.c[a][l] + s.gain[l] * s.u[a][l]);
            let at = std::array::from_fn(|a| s.arm[a][l]);
            self.gaps.felt.push(Felt { facet: self.walls[k].1, gap: Felt::FLUID, force, at });
        }
    }

    /// Adds up by how much the wall recedes, and adds what the body pays to what its motion pushes;
    /// see `mass`.
    fn pay<T: Real>(&mut self, after: &After<T>, body: &Body) {
        let full = self.links.div_ceil(LANES);
        columns::pay(after.variant, &mut self.eights[..full], body.account.pay, &mut self.paid);
        if body.is_part() && !self.gaps.given.is_empty() {
            self.give(after);
        }
    }

    /// Adds what links give to the intakes of gaps; see `declared`.
    fn give<T: Real>(&mut self, after: &After<T>) {
        for k in 0..self.links {
            let cell = self.cells[k];
            if let Some((intake, rate)) = after.intakes.at(cell) {
                let (s, l) = (&mut self.eights[k / LANES], k % LANES);
                s.push[l] += rate * s.weight[l];
                let weight = s.weight[l] * (1.0 + after.drho.get(cell as usize));
                self.gaps.given[intake].add(weight, rate);
            }
        }
    }

    /// Finds the places of each link and asks memory for them.
    fn ask<T: Real>(&mut self, after: &After<T>) {
        let (places, is_even) = (&after.layout.places, after.parity == Parity::Even);
        let stride = places.stride();
        for k in 0..self.links {
            let (cell, i) = (self.cells[k], usize::from(self.dirs[k]));
            // Places within the cell, and those that odd steps use; see `places`.
            let within = [i, OPPOSITE[i]].map(|i| i * stride + cell as usize);
            let back = places.odd(cell, OPPOSITE[i]);
            let [own, result] = if is_even { [within[1], back] } else { [back, within[1]] };
            let near = self.is_near(k);
            let other = if near || !is_even { places.odd(cell, i) } else { within[0] };
            let other = match near {
                true if !after.is_fluid_at(other, cell, i) => NOWHERE,
                true if !is_even => within[0],
                _ => other,
            };
            for place in [own, other, result] {
                after.field.prefetch(place);
            }
            after.drho.prefetch(cell as usize);
            self.places[k] = [own, other, result].map(|place| place as u32);
        }
    }

    /// Whether a link meets the body in its first half, so that the other population is that of the
    /// cell behind.
    #[inline(always)]
    fn is_near(&self, k: usize) -> bool {
        self.eights[k / LANES].q[k % LANES] < 0.5
    }

    /// Reads, interpolates and writes populations.
    fn reflect<T: Real>(&mut self, after: &After<T>) {
        for k in 0..self.links {
            let [own, other, result] = self.places[k].map(|place| place as usize);
            let (s, l) = (&mut self.eights[k / LANES], k % LANES);
            let g = after.field.get(own);
            let push = s.push[l] * (1.0 + after.drho.get(self.cells[k] as usize));
            let f = if other == NOWHERE {
                self.exchange.fallbacks += 1;
                g - push
            } else {
                s.own[l] * g + s.other[l] * after.field.get(other) - push
            };
            let f = after.field.set(result, f);
            (s.sum[l], s.gain[l]) = (g + f, f - g);
        }
    }

    /// Adds up what links through mirrors gave across them.
    fn add_images(&mut self) {
        for k in (0..self.links).filter(|&k| self.mirrors[k] != 0) {
            let (s, l) = (&self.eights[k / LANES], k % LANES);
            let swept: [f64; 3] = std::array::from_fn(|a| s.gain[l] * s.u[a][l]);
            let across =
                |v: f64, a: usize| if self.mirrors[k] >> a & 1 == 1 { 2.0 * v } else { 0.0 };
            let force = std::array::from_fn(|a| across(s.sum[l] * s.c[a][l] + swept[a], a));
            let swept = std::array::from_fn(|a| across(swept[a], a));
            add_scaled(&mut self.exchange.image, force, 1.0);
            add_scaled(&mut self.exchange.image_swept, swept, 1.0);
        }
    }
}

/// Squared lengths of the directions.
const SQUARE: [f64; Q] = {
    let mut square = [0.0; Q];
    let mut i = 0;
    while i < Q {
        let c = C_F64[i];
        square[i] = c[0] * c[0] + c[1] * c[1] + c[2] * c[2];
        i += 1;
    }
    square
};

impl<T: Real> After<'_, T> {
    /// Whether the cell behind a link's beginning, against direction `i`, is fluid.
    #[inline(always)]
    pub fn has_behind(&self, cell: u32, i: usize) -> bool {
        self.is_fluid_at(self.layout.places.odd(cell, i), cell, i)
    }

    /// The same, given the place from which odd steps of the cell read `f_i`: it lies in the cell behind.
    #[inline(always)]
    fn is_fluid_at(&self, place: usize, cell: u32, i: usize) -> bool {
        let stride = self.layout.places.stride();
        if place == i * stride + cell as usize {
            return self.layout.sees_itself(cell, OPPOSITE[i]);
        }
        let plain = OPPOSITE[i] * stride;
        let behind =
            if place >= plain && place < plain + stride { place - plain } else { place % stride };
        self.owners.is_fluid(behind as u32)
    }
}
