//! The sum of contact forces on a body.

use crate::{
    bodies::Wrench,
    pairs::{ACTING, Pairs},
    search::Contacts,
};

/// So many contacts of a body are looked at together.
const TOGETHER: usize = 32;

/// Where the bodies of one block collect their forces, one body after the other.
pub(crate) struct Collector<'a> {
    pairs: &'a Pairs,
    surfaces: [Few<'a>; 2],
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
    /// The forces of block `b`.
    pub fn new(contacts: Contacts<'a>, b: usize) -> Self {
        let (walls, parts) = (contacts.walls, contacts.parts);
        let surfaces = [
            Few::of_block(&walls.bodies, &walls.wrench, &walls.bounds, b),
            Few::of_block(&parts.bodies, &parts.wrench, &parts.bounds, b),
        ];
        Self { pairs: contacts.pairs, surfaces }
    }

    /// Contact force and torque on body `i` of the block, each in its turn: first those of
    /// bodies, in the order of their ids, then those of walls, then those of parts.
    #[inline(always)]
    pub fn on(&mut self, i: usize, radius: f64) -> Wrench {
        let mut sum = Wrench::zero();
        let pairs = self.pairs;
        let places = &pairs.places[pairs.collected[i] as usize..pairs.collected[i + 1] as usize];
        for places in places.chunks(TOGETHER) {
            // Without a branch: which pairs of a list touch cannot be foretold.
            let mut acting = [0; TOGETHER];
            let mut count = 0;
            for &place in places {
                acting[count] = place;
                count += usize::from(pairs.state[(place / 2) as usize] & ACTING);
            }
            for &place in &acting[..count] {
                let k = (place / 2) as usize;
                let sign = 1.0 - 2.0 * f64::from(place % 2);
                let wrench = pairs.records[k].on(sign, radius);
                sum.force += wrench.force;
                sum.torque += wrench.torque;
                if let Some(rolling) = pairs.rolling.get(k) {
                    sum.torque += rolling.torque * sign;
                }
            }
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
