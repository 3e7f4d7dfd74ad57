//! A batch of links of one body: geometry, populations, forces, each in one loop.
//!
//! See `post_collision` for the formulae. A link costs the numbers below, some 200 bytes that stay
//! in the first-level cache, three places of the field, and the density, which the collision left.

use crate::bodies::body::Body;
use crate::bodies::deformable_shape::{Felt, NO_FACET};
use crate::boundary::bouzidi::Bouzidi;
use crate::boundary::link_kernels::{
    CorrectMass, ExchangeSums, InterpolateBouzidi, LANES, LinkBlock, Paid, PlaceLinks,
    SumMomentumExchange, Surface,
};
use crate::boundary::population_addresses::PopulationAddresses;
use crate::boundary::post_collision::PostCollision;
use crate::boundary::sphere_links::SphereLinks;
use crate::boundary::unresolved_gaps::Gaps;
use crate::lattice::d3q19::{C_F64, Q, W};
use crate::lattice::exact_sum::add_vector;
use crate::lattice::momentum_exchange::ExchangeTally;
use crate::lattice::populations::{Real, prefetch};

/// Links of a full batch: their cache lines, some three each, must fit in the first-level cache
/// together with what is known of them.
const LINKS: usize = 320;
/// Links of a cell at most.
const MOST: usize = Q - 1;

/// The place of a population that there is not.
const NOWHERE: usize = u32::MAX as usize;

/// A link of a part.
#[derive(Clone, Copy, Debug)]
pub struct BatchLink {
    /// Places of its populations.
    pub slots: PopulationAddresses,
    /// Its direction as seen by the body: mirrored if the link goes through a mirror.
    pub seen: u8,
    /// Axes at which it is mirrored.
    pub mirrors: u8,
    /// From the body's origin to the cell where it begins, mirrored likewise.
    pub arm: [f64; 3],
    /// Wall distance, as part of the link's length.
    pub q: f64,
}

/// Places and mirrors of links that stand in columns.
#[derive(Clone, Copy)]
struct Known<'a> {
    /// Places of their populations.
    slots: &'a [PopulationAddresses],
    /// Axes at which each is mirrored; none if no link is.
    mirrors: &'a [u8],
}

/// Links that wait to be reflected.
pub struct Batch {
    eights: Box<[LinkBlock]>,
    /// Of links that wait.
    slots: Vec<PopulationAddresses>,
    mirrors: Vec<u8>,
    /// Places of `g_i`, of the other population, and of the result.
    places: [[u32; 3]; LINKS],
    sums: ExchangeSums,
    paid: Paid,
    exchange: ExchangeTally,
    /// Velocity of the wall and facet of each link, of a surface that can deform.
    walls: [([f64; 3], u32); LINKS],
    /// Gaps that the item found, and what facets felt.
    pub gaps: Gaps,
}

impl Default for Batch {
    fn default() -> Self {
        Self {
            eights: vec![LinkBlock::NONE; LINKS / LANES].into(),
            slots: Vec::with_capacity(LINKS),
            mirrors: Vec::with_capacity(LINKS),
            places: [[0; 3]; LINKS],
            sums: ExchangeSums::NONE,
            paid: Paid::NONE,
            exchange: ExchangeTally::default(),
            walls: [([0.0; 3], NO_FACET); LINKS],
            gaps: Gaps::default(),
        }
    }
}

impl Batch {
    /// Begins an item of a body.
    pub fn begin(&mut self) {
        self.sums = ExchangeSums::NONE;
        self.paid = Paid::NONE;
        self.exchange = ExchangeTally::default();
    }

    /// Exchange of the item.
    pub fn exchange(&self) -> ExchangeTally {
        let vector = |k: usize| [k, k + 1, k + 2].map(|k| self.sums.total(k));
        ExchangeTally {
            force: vector(0),
            torque: vector(3),
            swept: vector(6),
            mass: self.sums.total(9),
            receded: self.paid.total(0),
            weight: self.paid.total(1),
            ..self.exchange
        }
    }

    /// Counts a volume by which the wall recedes where it has no links; see `mass_correction`.
    pub fn draw(&mut self, volume: f64) {
        self.exchange.drawn.add(volume);
    }

    /// Makes room for the links of a cell, if there is not enough.
    #[inline]
    pub fn make_room<T: Real>(&mut self, after: &PostCollision<T>, body: &Body) {
        if self.slots.len() + MOST > LINKS {
            self.flush(after, body);
        }
    }

    /// Takes a link into the batch.
    #[inline(always)]
    pub fn push(&mut self, link: BatchLink) {
        let (k, c) = (self.slots.len(), C_F64[link.seen as usize]);
        let (eight, lane) = (&mut self.eights[k / LANES], k % LANES);
        for a in 0..3 {
            eight.arm[a][lane] = link.arm[a];
            eight.c[a][lane] = c[a];
        }
        eight.q[lane] = link.q;
        eight.cc[lane] = SQUARE[link.seen as usize];
        eight.weight[lane] = 6.0 * W[link.seen as usize];
        self.slots.push(link.slots);
        self.mirrors.push(link.mirrors);
    }

    /// Makes the last link push as much more fluid as others that it stands for would.
    pub fn widen(&mut self, by: f64) {
        let last = self.slots.len() - 1;
        self.eights[last / LANES].weight[last % LANES] *= by;
    }

    /// Says how the wall moves where the last link meets it, and which facet that is on.
    pub fn wall(&mut self, velocity: [f64; 3], facet: u32) {
        self.walls[self.slots.len() - 1] = (velocity, facet);
    }

    /// Reflects all links that wait.
    pub fn flush<T: Real>(&mut self, after: &PostCollision<T>, body: &Body) {
        let (mut slots, mut mirrors) =
            (std::mem::take(&mut self.slots), std::mem::take(&mut self.mirrors));
        self.work(after, body, Known { slots: &slots, mirrors: &mirrors });
        slots.clear();
        mirrors.clear();
        (self.slots, self.mirrors) = (slots, mirrors);
    }

    /// Reflects the links of a sphere.
    pub fn reflect_sphere<T: Real>(
        &mut self,
        after: &PostCollision<T>,
        body: &Body,
        links: &SphereLinks,
    ) {
        let origin = body.shell.origin();
        for (number, slots) in links.slots.chunks(LINKS).enumerate() {
            let first = number * LINKS;
            let full = slots.len().div_ceil(LANES);
            prefetch_all(slots);
            let standing = &links.standing[first / LANES..][..full];
            let (position, eights) = (body.position, &mut self.eights[..full]);
            after.variant.run(PlaceLinks { standing, origin, position, links: eights });
            let mirrors = links.mirrors.get(first..first + slots.len()).unwrap_or_default();
            self.work(after, body, Known { slots, mirrors });
        }
    }

    /// Reflects the links whose geometry is in the columns.
    fn work<T: Real>(&mut self, after: &PostCollision<T>, body: &Body, known: Known) {
        let links = known.slots.len();
        if links == 0 {
            return;
        }
        let full = links.div_ceil(LANES);
        self.fill_up(links);
        let r2 = body.part.is_none().then(|| body.r2());
        let nearest = if body.is_part() { 0.0 } else { after.nearest_wall };
        let (velocity, spin, change) = (body.velocity, body.spin, body.change);
        let surface = Surface { r2, velocity, spin, change, nearest };
        after.variant.run(InterpolateBouzidi { links: &mut self.eights[..full], body: surface });
        let is_soft = body.part.as_ref().is_some_and(|part| part.shape.is_some());
        if is_soft {
            self.move_walls(links);
        }
        if after.keeps_mass || body.is_part() {
            self.pay(after, body, known);
        }
        // All places are asked for before the first is read, so that memory fetches them side by
        // side.
        self.ask(after, known);
        self.reflect(after, known);
        // `reflect` leaves the lanes beyond the last link as an earlier batch left them.
        for k in links..full * LANES {
            let (eight, lane) = (&mut self.eights[k / LANES], k % LANES);
            (eight.sum[lane], eight.gain[lane]) = (0.0, 0.0);
        }
        after
            .variant
            .run(SumMomentumExchange { links: &self.eights[..full], sums: &mut self.sums });
        self.add_images(known);
        if is_soft {
            self.feel(links);
        }
    }

    /// Fills the lanes beyond the last link with links as it that weigh nothing.
    fn fill_up(&mut self, links: usize) {
        let last = links - 1;
        let (model, from) = (self.eights[last / LANES], last % LANES);
        let eight = &mut self.eights[last / LANES];
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
    fn move_walls(&mut self, links: usize) {
        for k in 0..links {
            let (s, l) = (&mut self.eights[k / LANES], k % LANES);
            let u = self.walls[k].0;
            let push = s.weight[l] * (s.c[0][l] * u[0] + s.c[1][l] * u[1] + s.c[2][l] * u[2]);
            s.push[l] = Bouzidi::at(s.q[l]).push * push;
            for a in 0..3 {
                s.u[a][l] = u[a];
            }
        }
    }

    /// Notes the force on each facet; that of links through mirrors as the facet feels it.
    fn feel(&mut self, links: usize) {
        for k in 0..links {
            let (s, l) = (&self.eights[k / LANES], k % LANES);
            let force = std::array::from_fn(|a| s.sum[l] * s.c[a][l] + s.gain[l] * s.u[a][l]);
            let at = std::array::from_fn(|a| s.arm[a][l]);
            self.gaps.felt.push(Felt { facet: self.walls[k].1, gap: Felt::FLUID, force, at });
        }
    }

    /// Adds up by how much the wall recedes, and adds what the body pays to what its motion pushes;
    /// see `mass_correction`.
    fn pay<T: Real>(&mut self, after: &PostCollision<T>, body: &Body, known: Known) {
        let full = known.slots.len().div_ceil(LANES);
        for (k, slots) in known.slots.iter().enumerate() {
            self.eights[k / LANES].own_cell[k % LANES] =
                f64::from(u8::from(after.layout.is_own(slots.cell)));
        }
        let (links, rate) = (&mut self.eights[..full], body.account.pay);
        after.variant.run(CorrectMass { links, rate, sums: &mut self.paid });
        if after.keeps_mass && body.is_part() && !self.gaps.given.is_empty() {
            self.give(after, known);
        }
    }

    /// Adds what links give to the intakes of gaps; see `modelled`.
    fn give<T: Real>(&mut self, after: &PostCollision<T>, known: Known) {
        for (k, &PopulationAddresses { cell, .. }) in known.slots.iter().enumerate() {
            if let Some((intake, rate)) = after.gaps.sinks.at(cell) {
                let (s, l) = (&mut self.eights[k / LANES], k % LANES);
                s.push[l] += rate * s.weight[l];
                let weight = s.weight[l] * (1.0 + after.drho.get(cell as usize));
                if after.layout.is_own(cell) {
                    self.gaps.given[intake].add(weight, rate);
                }
            }
        }
    }

    /// Finds the places of each link and asks memory for them.
    fn ask<T: Real>(&mut self, after: &PostCollision<T>, known: Known) {
        let parity = after.parity;
        for (k, slots) in known.slots.iter().enumerate() {
            // A link that meets the body in its first half needs the population of the cell behind.
            // Without a branch: in which half a link meets it cannot be foretold.
            let near = self.eights[k / LANES].q[k % LANES] < 0.5;
            let is_there = !near | slots.is_behind_fluid(after.flags);
            let other = slots.other(parity, near);
            let other = if is_there { other } else { NOWHERE };
            let places = [slots.own(parity), other, slots.result(parity)];
            for place in places {
                after.field.prefetch(place);
            }
            after.drho.prefetch(slots.cell as usize);
            self.places[k] = places.map(|place| place as u32);
        }
    }

    /// Reads, interpolates and writes populations.
    fn reflect<T: Real>(&mut self, after: &PostCollision<T>, known: Known) {
        for (k, slots) in known.slots.iter().enumerate() {
            let [own, other, result] = self.places[k].map(|place| place as usize);
            let (s, l) = (&mut self.eights[k / LANES], k % LANES);
            let g = after.field.get(own);
            let push = s.push[l] * (1.0 + after.drho.get(slots.cell as usize));
            let is_own = after.layout.is_own(slots.cell);
            self.exchange.links += usize::from(is_own);
            let f = if other == NOWHERE {
                self.exchange.fallbacks += usize::from(is_own);
                g - push
            } else {
                s.own[l] * g + s.other[l] * after.field.get(other) - push
            };
            let f = after.field.set(result, f);
            // Others count the links of their cells.
            (s.sum[l], s.gain[l]) = if is_own { (g + f, f - g) } else { (0.0, 0.0) };
        }
    }

    /// Adds up what links through mirrors gave across them.
    fn add_images(&mut self, known: Known) {
        for (k, &mirrors) in known.mirrors.iter().enumerate().filter(|(_, mirrors)| **mirrors != 0)
        {
            let (s, l) = (&self.eights[k / LANES], k % LANES);
            let swept: [f64; 3] = std::array::from_fn(|a| s.gain[l] * s.u[a][l]);
            let across = |v: f64, a: usize| if mirrors >> a & 1 == 1 { 2.0 * v } else { 0.0 };
            let force = std::array::from_fn(|a| across(s.sum[l] * s.c[a][l] + swept[a], a));
            let swept = std::array::from_fn(|a| across(swept[a], a));
            add_vector(&mut self.exchange.image, force);
            add_vector(&mut self.exchange.image_swept, swept);
        }
    }
}

/// Asks memory for a list that is read soon.
#[inline(always)]
fn prefetch_all<T>(list: &[T]) {
    for byte in (0..size_of_val(list)).step_by(64) {
        prefetch(list.as_ptr().cast::<u8>().wrapping_add(byte));
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
