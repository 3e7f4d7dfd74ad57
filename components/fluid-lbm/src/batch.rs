//! A batch of links of one body: geometry, populations, forces, each in one loop.
//!
//! See `links` for the formulae. A link costs the numbers below, some 200 bytes that stay in the
//! first-level cache, three places of the field, and the density, which the collision left.

use crate::bodies::Body;
use crate::field::Real;
use crate::gaps::Gaps;
use crate::lattice::{C_F64, OPPOSITE, Q, W};
use crate::ledger::add_scaled;
use crate::links::{After, CHUNK, Exchange};

/// Links of a full batch.
const LINKS: usize = 512;
/// Links of a chunk of cells at most.
const MOST: usize = CHUNK as usize * (Q - 1);
/// Cells of a batch: those of the chunks that it holds.
const CELLS: usize = 1024;
/// Sums run in so many lanes.
const LANES: usize = 8;

/// A link of a body.
#[derive(Clone, Copy, Debug)]
pub struct Link {
    /// The batch's slot of the cell where it begins.
    pub slot: u16,
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

type Column = [f64; LINKS];

/// What is known of each link, in columns.
#[repr(align(64))]
struct Columns {
    arm: [Column; 3],
    c: [Column; 3],
    /// Squared length of `c`.
    cc: Column,
    /// Where the link meets the surface.
    q: Column,
    /// Weight of the direction, times 6.
    weight: Column,
    /// Factors of `g_i` and of the other population, and what the wall's motion adds for density 1.
    own: Column,
    other: Column,
    push: Column,
    /// Velocity of the wall.
    u: [Column; 3],
    /// `g_i + f_i'` and `f_i' - g_i`.
    sum: Column,
    gain: Column,
}

/// Links that wait to be reflected.
pub struct Batch {
    columns: Box<Columns>,
    dirs: [u8; LINKS],
    mirrors: [u8; LINKS],
    slots: [u16; LINKS],
    /// Whether the other population is that of the cell behind.
    behind: [bool; LINKS],
    /// Places of `g_i`, of the other population, and of the result.
    places: [[u32; 3]; LINKS],
    links: usize,
    cells: [u32; CELLS],
    used: usize,
    sums: [[f64; LANES]; 10],
    exchange: Exchange,
    /// Gaps that the item found.
    pub gaps: Gaps,
}

impl Default for Batch {
    fn default() -> Self {
        let zero = [0.0; LINKS];
        let columns = Columns {
            arm: [zero; 3],
            c: [zero; 3],
            cc: [1.0; LINKS],
            q: zero,
            weight: zero,
            own: zero,
            other: zero,
            push: zero,
            u: [zero; 3],
            sum: zero,
            gain: zero,
        };
        Self {
            columns: Box::new(columns),
            dirs: [0; LINKS],
            mirrors: [0; LINKS],
            slots: [0; LINKS],
            behind: [false; LINKS],
            places: [[0; 3]; LINKS],
            links: 0,
            cells: [0; CELLS],
            used: 0,
            sums: [[0.0; LANES]; 10],
            exchange: Exchange::default(),
            gaps: Gaps::with_room(),
        }
    }
}

impl Batch {
    /// Begins an item of a body.
    pub fn begin(&mut self, _: &Body) {
        (self.links, self.used) = (0, 0);
        self.sums = [[0.0; LANES]; 10];
        self.exchange = Exchange::default();
        self.gaps.clear();
    }

    /// What the item exchanged.
    pub fn exchange(&self) -> Exchange {
        let sum = |k: usize| self.sums[k].iter().fold(0.0, |sum, x| sum + x);
        let vector = |k: usize| [sum(k), sum(k + 1), sum(k + 2)];
        Exchange {
            force: vector(0),
            torque: vector(3),
            swept: vector(6),
            mass: sum(9),
            ..self.exchange
        }
    }

    /// Makes room for a chunk of cells, if there is not enough.
    #[inline]
    pub fn make_room<T: Real>(&mut self, after: &After<T>, body: &Body) {
        if self.links + MOST > LINKS || self.used + CHUNK as usize > CELLS {
            self.flush(after, body);
        }
    }

    /// Takes a cell into the batch and returns its slot.
    #[inline(always)]
    pub fn cell(&mut self, number: u32) -> u16 {
        self.cells[self.used] = number;
        self.used += 1;
        (self.used - 1) as u16
    }

    /// The cell in a slot.
    #[inline(always)]
    pub fn number(&self, slot: u16) -> u32 {
        self.cells[slot as usize]
    }

    /// Takes a link into the batch.
    #[inline(always)]
    pub fn push(&mut self, link: Link) {
        let (k, c) = (self.links, C_F64[link.seen as usize]);
        let columns = &mut *self.columns;
        for a in 0..3 {
            columns.arm[a][k] = link.arm[a];
            columns.c[a][k] = c[a];
        }
        columns.q[k] = link.q;
        columns.cc[k] = SQUARE[link.seen as usize];
        columns.weight[k] = 6.0 * W[link.seen as usize];
        self.dirs[k] = link.dir;
        self.mirrors[k] = link.mirrors;
        self.slots[k] = link.slot;
        self.links += 1;
    }

    /// Reflects all links of the batch and empties it.
    pub fn flush<T: Real>(&mut self, after: &After<T>, body: &Body) {
        self.locate(body);
        if after.keeps_mass {
            self.pay(body);
        }
        self.ask(after);
        self.reflect(after);
        self.add_up(body);
        self.exchange.links += self.links;
        (self.links, self.used) = (0, 0);
    }

    /// Where each link meets the sphere.
    fn meet_sphere(&mut self, r2: f64) {
        let s = &mut *self.columns;
        let ([ax, ay, az], [cx, cy, cz]) = (&s.arm, &s.c);
        for k in 0..self.links {
            let d = [ax[k], ay[k], az[k]];
            let c = [cx[k], cy[k], cz[k]];
            // As `sphere::wall_distance`, in the same order of operations.
            let b = d[0] * c[0] + d[1] * c[1] + d[2] * c[2];
            let gap = (d[0] * d[0] + (d[1] * d[1] + d[2] * d[2])) - r2;
            let root = (b * b - s.cc[k] * gap).max(0.0).sqrt();
            s.q[k] = (gap / (root - b)).clamp(f64::MIN_POSITIVE, 1.0);
        }
    }

    /// What follows from where each link meets the body.
    fn locate(&mut self, body: &Body) {
        if body.part.is_none() {
            self.meet_sphere(body.r2());
        }
        let (v, w) = (body.velocity, body.spin);
        let s = &mut *self.columns;
        let [ax, ay, az] = &mut s.arm;
        let [cx, cy, cz] = &s.c;
        let [ux, uy, uz] = &mut s.u;
        for k in 0..self.links {
            let d = [ax[k], ay[k], az[k]];
            let c = [cx[k], cy[k], cz[k]];
            let q = s.q[k];
            let wall = [d[0] + q * c[0], d[1] + q * c[1], d[2] + q * c[2]];
            let u = [
                v[0] + (w[1] * wall[2] - w[2] * wall[1]),
                v[1] + (w[2] * wall[0] - w[0] * wall[2]),
                v[2] + (w[0] * wall[1] - w[1] * wall[0]),
            ];
            let push = s.weight[k] * (c[0] * u[0] + c[1] * u[1] + c[2] * u[2]);
            let part = 0.5 / q;
            let far = q >= 0.5;
            s.own[k] = if far { part } else { 2.0 * q };
            s.other[k] = if far { 1.0 - part } else { 1.0 - 2.0 * q };
            s.push[k] = if far { part * push } else { push };
            self.behind[k] = !far;
            (ax[k], ay[k], az[k]) = (wall[0], wall[1], wall[2]);
            (ux[k], uy[k], uz[k]) = (u[0], u[1], u[2]);
        }
    }

    /// Adds up by how much the wall recedes, and adds what the body pays to what its motion pushes;
    /// see `mass`.
    fn pay(&mut self, body: &Body) {
        let s = &mut *self.columns;
        for k in 0..self.links {
            let along = s.c[0][k] * s.u[0][k] + s.c[1][k] * s.u[1][k] + s.c[2][k] * s.u[2][k];
            self.exchange.receded += s.weight[k] * along;
            self.exchange.weight += s.weight[k];
            s.push[k] -= body.account.pay * s.weight[k];
        }
    }

    /// Finds the places of each link and asks memory for them.
    fn ask<T: Real>(&mut self, after: &After<T>) {
        let (parity, next) = (after.parity, after.parity.flipped());
        for k in 0..self.links {
            let (cell, i) = (self.number(self.slots[k]), self.dirs[k] as usize);
            let of = |parity, i| after.layout.place(parity, cell, i);
            let other = of(if self.behind[k] { next } else { parity }, i);
            let places = [of(parity, OPPOSITE[i]), other, of(next, OPPOSITE[i])];
            for place in places {
                after.field.prefetch(place);
            }
            after.drho.prefetch(cell as usize);
            self.places[k] = places.map(|place| place as u32);
        }
    }

    /// Reads, interpolates and writes populations.
    fn reflect<T: Real>(&mut self, after: &After<T>) {
        let s = &mut *self.columns;
        for k in 0..self.links {
            let [own, other, result] = self.places[k].map(|place| place as usize);
            let cell = self.cells[self.slots[k] as usize];
            let g = after.field.get(own);
            let push = s.push[k] * (1.0 + after.drho.get(cell as usize));
            let f = if !self.behind[k] || after.has_behind(cell, self.dirs[k] as usize) {
                s.own[k] * g + s.other[k] * after.field.get(other) - push
            } else {
                self.exchange.fallbacks += 1;
                g - push
            };
            let f = after.field.set(result, f);
            (s.sum[k], s.gain[k]) = (g + f, f - g);
        }
    }

    /// Adds up force, torque, and what goes to the fluid.
    fn add_up(&mut self, _: &Body) {
        let s = &mut *self.columns;
        let full = self.links.next_multiple_of(LANES);
        for k in self.links..full {
            (s.sum[k], s.gain[k]) = (0.0, 0.0);
        }
        for first in (0..full).step_by(LANES) {
            for lane in 0..LANES {
                let k = first + lane;
                let (sum, gain) = (s.sum[k], s.gain[k]);
                let [wx, wy, wz] = [s.arm[0][k], s.arm[1][k], s.arm[2][k]];
                let swept = [gain * s.u[0][k], gain * s.u[1][k], gain * s.u[2][k]];
                let fx = sum * s.c[0][k] + swept[0];
                let fy = sum * s.c[1][k] + swept[1];
                let fz = sum * s.c[2][k] + swept[2];
                let terms = [
                    fx,
                    fy,
                    fz,
                    wy * fz - wz * fy,
                    wz * fx - wx * fz,
                    wx * fy - wy * fx,
                    swept[0],
                    swept[1],
                    swept[2],
                    gain,
                ];
                for t in 0..10 {
                    self.sums[t][lane] += terms[t];
                }
            }
        }
        for k in (0..self.links).filter(|&k| self.mirrors[k] != 0) {
            let swept: [f64; 3] = std::array::from_fn(|a| s.gain[k] * s.u[a][k]);
            let across =
                |v: f64, a: usize| if self.mirrors[k] >> a & 1 == 1 { 2.0 * v } else { 0.0 };
            let force = std::array::from_fn(|a| across(s.sum[k] * s.c[a][k] + swept[a], a));
            add_scaled(&mut self.exchange.image, force, 1.0);
            add_scaled(
                &mut self.exchange.image_swept,
                std::array::from_fn(|a| across(swept[a], a)),
                1.0,
            );
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
        // The place from which the next odd step of this cell reads `f_i` lies in the cell behind.
        let stride = self.layout.places.stride();
        let place = self.layout.places.odd(cell, i);
        if place == i * stride + cell as usize {
            return self.layout.sees_itself(cell, OPPOSITE[i]);
        }
        let plain = OPPOSITE[i] * stride;
        let behind =
            if place >= plain && place < plain + stride { place - plain } else { place % stride };
        self.owners.is_fluid(behind as u32)
    }
}
