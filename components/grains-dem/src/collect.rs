//! The sum of contact forces on a body.

use crate::{
    bodies::Wrench,
    fetch::fetch,
    pairs::{BLOCK, Pairs},
    search::Contacts,
};

/// So many bodies ahead records are fetched: few enough to stay close.
const AHEAD: usize = 8;

/// Where the bodies of one block collect their forces, one body after the other.
pub(crate) struct Collector<'a> {
    pairs: &'a Pairs,
    surfaces: [Few<'a>; 4],
    /// Index of the block's last body, and one more.
    end: usize,
}

/// Forces of surfaces on few of the bodies of a block.
struct Few<'a> {
    bodies: &'a [u32],
    wrench: &'a [Wrench],
}

impl<'a> Few<'a> {
    fn of_block(bodies: &'a [u32], wrench: &'a [Wrench], bounds: &[u32], b: usize) -> Self {
        let own = bounds[b] as usize..bounds[b + 1] as usize;
        Self { bodies: &bodies[own.clone()], wrench: &wrench[own] }
    }

    /// Leaves out bodies before `i`.
    fn skip_to(&mut self, i: usize) {
        let before = self.bodies.partition_point(|&body| (body as usize) < i);
        (self.bodies, self.wrench) = (&self.bodies[before..], &self.wrench[before..]);
    }

    /// The force on body `i`, later than all asked for before.
    #[inline(always)]
    fn on(&mut self, i: usize) -> Option<&'a Wrench> {
        let (&first, bodies) = self.bodies.split_first()?;
        if first as usize != i {
            return None;
        }
        let (wrench, rest) = self.wrench.split_first()?;
        (self.bodies, self.wrench) = (bodies, rest);
        Some(wrench)
    }
}

impl<'a> Collector<'a> {
    /// The forces of block `b`, whose bodies are `range`.
    pub fn new(contacts: Contacts<'a>, b: usize, range: std::ops::Range<usize>) -> Self {
        let Contacts { walls, parts, surfaces: soft, solids, .. } = contacts;
        let surfaces = [
            Few::of_block(&walls.bodies, &walls.wrench, &walls.bounds, b),
            Few::of_block(&parts.bodies, &parts.wrench, &parts.bounds, b),
            Few::of_block(&soft.bodies, &soft.wrench, &soft.bounds, b),
            Few::of_block(&solids.bodies, &solids.wrench, &solids.bounds, b),
        ];
        Self { pairs: contacts.pairs, surfaces, end: range.end }
    }

    /// Contact force and torque on one body, as [`on`](Self::on) sums them up.
    pub fn alone(contacts: Contacts<'a>, i: usize, radius: f64) -> Wrench {
        let mut own = Self::new(contacts, i / BLOCK, i..i + 1);
        own.surfaces.iter_mut().for_each(|few| few.skip_to(i));
        own.on(i, radius)
    }

    /// Contact force and torque on body `i` of the block, each in its turn: first those of
    /// bodies, in the order of their ids, then those of walls, of parts, of surfaces that deform, and all of
    /// polyhedra.
    #[inline(always)]
    pub fn on(&mut self, i: usize, radius: f64) -> Wrench {
        let mut sum = Wrench::zero();
        if i + AHEAD < self.end {
            for &place in self.pairs.acting_on(i + AHEAD) {
                fetch(&self.pairs.records, (place / 2) as usize);
            }
        }
        for &place in self.pairs.acting_on(i) {
            add(&mut sum, self.pairs, place, radius);
        }
        for few in &mut self.surfaces {
            if let Some(wrench) = few.on(i) {
                sum.force += wrench.force;
                sum.torque += wrench.torque;
            }
        }
        sum
    }
}

#[inline(always)]
fn add(sum: &mut Wrench, pairs: &Pairs, place: u32, radius: f64) {
    let k = (place / 2) as usize;
    let sign = 1.0 - 2.0 * f64::from(place % 2);
    let wrench = pairs.records[k].on(sign, radius);
    sum.force += wrench.force;
    sum.torque += wrench.torque;
    if let Some(rolling) = pairs.rolling.get(k) {
        sum.torque += rolling.torque * sign;
    }
}
