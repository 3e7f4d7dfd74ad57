//! Contacts of one linear law, several at once, on any processor.

use crate::contact::linear_contact::{Batch, LinearLaw, Outcome};
use crate::forces::pair_forces::Block;
use crate::math::simd::lanes::{LANES, Plain};
use crate::math::simd::prefetch::fetch;
use crate::math::tally::Other;
use crate::neighbours::neighbour_list::{ACTING, ContactState, TOUCHING};

impl Block<'_> {
    /// Evaluates the contacts of the entries `hits`.
    pub fn side_by_side(&mut self, law: LinearLaw, hits: &[u32]) {
        let steps = self.scenery.steps;
        let (mut batch, all) = (Batch::ZERO, hits);
        for (first, hits) in (0..).step_by(LANES).zip(hits.chunks(LANES)) {
            for (lane, &k) in hits.iter().enumerate() {
                if let Some(&next) = all.get(first + lane + LANES) {
                    let (_, j) = self.bodies(next as usize);
                    fetch(&self.scenery.bodies.predicted, j);
                }
                self.put(&mut batch, lane, k as usize);
            }
            // Lanes beyond the last hit hold what was there before, and nobody takes them.
            let outcome = law.forces(&batch, steps);
            for (lane, &k) in hits.iter().enumerate() {
                self.take(&outcome, lane, k as usize);
            }
        }
    }

    #[inline(always)]
    fn put(&self, batch: &mut Batch<Plain>, lane: usize, k: usize) {
        let (i, j, d) = self.pair(k);
        let bodies = self.scenery.bodies;
        let (a, b) = (&bodies.predicted[i], &bodies.predicted[j]);
        batch.d.set(lane, &d);
        batch.radius_i.0[lane] = bodies.balls[i].radius;
        batch.radius_j.0[lane] = bodies.balls[j].radius;
        batch.v.set(lane, &(a.v - b.v));
        batch.w_i.set(lane, &a.w);
        batch.w_j.set(lane, &b.w);
        batch.xi.set(lane, &self.xi[k]);
        batch.old.set(lane, &self.records[k].normal);
        batch.touching.0[lane] = f64::from(self.state[k] & TOUCHING);
        batch.root_mass.0[lane] = self.reduced[k].root_mass;
    }

    #[inline(always)]
    fn take(&mut self, outcome: &Outcome<Plain>, lane: usize, k: usize) {
        let (normal, overlap) = (outcome.normal.get(lane), outcome.overlap.0[lane]);
        self.state[k] = ACTING;
        if overlap <= 0.0 {
            // Rounding: the distance was a hair less than the reach.
            self.records[k] = ContactState { normal, overlap, ..ContactState::NONE };
            return;
        }
        self.state[k] |= TOUCHING;
        self.xi[k] = outcome.xi.get(lane);
        self.records[k] = ContactState {
            normal,
            tangential: outcome.tangential.get(lane),
            force: outcome.force.0[lane],
            overlap,
        };
        let (i, j) = self.bodies(k);
        self.tally.add(outcome.ratio.0[lane], i as u32, Other::Body(j as u32));
    }
}
