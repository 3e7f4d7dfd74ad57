//! The sum of contact forces on a body.

use crate::{
    bodies::Wrench,
    pairs::{ACTING, Pairs},
    wall_contacts::WallContacts,
};

/// So many contacts of a body are looked at together.
const TOGETHER: usize = 32;

/// Where the bodies of one block collect their forces, one body after the other.
pub(crate) struct Collector<'a> {
    pairs: &'a Pairs,
    walls: &'a WallContacts,
    at_walls: std::ops::Range<usize>,
}

impl<'a> Collector<'a> {
    /// The forces of block `b`.
    pub fn new(pairs: &'a Pairs, walls: &'a WallContacts, b: usize) -> Self {
        let at_walls = walls.bounds[b] as usize..walls.bounds[b + 1] as usize;
        Self { pairs, walls, at_walls }
    }

    /// Contact force and torque on body `i` of the block, later than all asked for before: first
    /// those of bodies, in the order of their ids, then those of walls.
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
        while self.at_walls.start < self.at_walls.end
            && self.walls.bodies[self.at_walls.start] as usize <= i
        {
            let wrench = &self.walls.wrench[self.at_walls.start];
            if self.walls.bodies[self.at_walls.start] as usize == i {
                sum.force += wrench.force;
                sum.torque += wrench.torque;
            }
            self.at_walls.start += 1;
        }
        sum
    }
}
