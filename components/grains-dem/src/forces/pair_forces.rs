//! Contact forces of all bodies: blocks of bodies at once, each contact once.

use crate::Vec3;
use crate::bodies::body_arrays::BLOCK;
use crate::bodies::body_arrays::Bodies;
use crate::contact::contact_force::touch_of_balls;
use crate::contact::contact_force::{self, Contact, Steps};
use crate::contact::contact_law::Law;
use crate::contact::linear_contact::LinearLaw;
use crate::contact::lubrication::Squeeze;
use crate::contact::springs::Reduced;
use crate::math::simd::lanes::LANES;
use crate::math::simd::prefetch::fetch;
use crate::math::tally::{Other, Tally};
use crate::neighbours::active_contacts::Changed;
use crate::neighbours::displacement::MaxDisplacement;
use crate::neighbours::neighbour_list::{
    ACTING, ContactState, ListedPair, NeighbourList, Rolling, TOUCHING,
};
use core::ops::Range;
use tremie_team::{Cut, Team, Variant};

/// Input of the forces between bodies, besides the list.
#[derive(Clone, Copy)]
pub(crate) struct ContactContext<'a> {
    /// Laws by number.
    pub laws: &'a [Law],
    /// Displacements of images.
    pub shifts: &'a [Vec3; 27],
    /// The bodies.
    pub bodies: &'a Bodies,
    /// True if any body crossed a periodic face since neighbours were listed.
    pub crossed: bool,
    /// Lengths of steps.
    pub steps: Steps,
    /// The law of all contacts between bodies, where it is one and linear.
    pub one_law: Option<LinearLaw>,
    /// Lubrication, if there is any.
    pub squeeze: Option<Squeeze>,
    /// Reach of forces: largest gap of surfaces at which they act [m].
    pub reach: f64,
}

impl ContactContext<'_> {
    /// Normal force of lubrication [N].
    #[inline(always)]
    pub fn lubrication(&self, contact: &Contact, pair: Reduced) -> f64 {
        let Some(squeeze) = self.squeeze else { return 0.0 };
        squeeze.resistance(-contact.overlap, pair.radius) * contact.velocity.dot(&contact.normal)
    }

    /// Vector from centre to centre of a pair, seen through an image.
    #[inline(always)]
    pub fn through(&self, i: usize, j: usize, image: usize) -> Vec3 {
        // The difference first: the other way round it is then exactly the opposite.
        (self.bodies.balls[j].x - self.bodies.balls[i].x) + self.shifts[image]
    }

    /// Vector from centre to centre where the image is that of the time when neighbours were
    /// listed.
    #[inline(always)]
    pub fn between(&self, i: usize, j: usize, image: u32) -> Vec3 {
        let crossed = &self.bodies.crossed;
        let moved = if self.crossed { crossed[j] - crossed[i] } else { 0 };
        self.through(i, j, (image as i32 + moved) as usize)
    }
}

/// Evaluates the contacts between bodies; the results stand in the records of `pairs`. Adds what
/// each block saw to `tallies`; `wandered` tells how far the bodies of each have gone since
/// neighbours were listed.
pub(crate) fn between_bodies(
    team: &mut Team,
    pairs: &mut NeighbourList,
    scenery: ContactContext<'_>,
    wandered: &MaxDisplacement,
    tallies: &mut [Tally],
) {
    let bounds = &pairs.bounds;
    let pieces = (
        Cut::at(&mut pairs.state, bounds),
        Cut::at(&mut pairs.xi, bounds),
        Cut::at(&mut pairs.records, bounds),
        Cut::at(&mut pairs.rolling, &pairs.rolling_bounds),
        Cut::every(&mut pairs.near, 1),
        Cut::every(tallies, 1),
    );
    let changed = pairs.acting.changed();
    let (entries, gaps, reduced) = (&pairs.entries, &pairs.gaps, &pairs.reduced);
    team.for_pieces(pieces, |b, (state, xi, records, rolling, near, tally)| {
        let own = bounds[b] as usize..bounds[b + 1] as usize;
        let limit = wandered.limit(b);
        let may_have_met = |gap: &&f32| f64::from(**gap) <= limit;
        // The limit only grows, so that the search goes on where it ended.
        let rest = &gaps[own.clone()][near[0] as usize..];
        near[0] += rest.iter().take_while(may_have_met).count() as u32;
        let mut block = Block {
            scenery: &scenery,
            first: b * BLOCK,
            entries: &entries[own.clone()][..near[0] as usize],
            reduced: &reduced[own],
            state,
            xi,
            records,
            rolling,
            changed,
            tally: &mut tally[0],
        };
        block.evaluate();
    });
    pairs.acting.follow(team, (&pairs.collected, &pairs.places), &pairs.state);
}

/// The contacts of a block of bodies.
pub(crate) struct Block<'a> {
    pub scenery: &'a ContactContext<'a>,
    /// Index of the first body.
    pub first: usize,
    /// The entries whose bodies may have met.
    pub entries: &'a [ListedPair],
    pub reduced: &'a [Reduced],
    pub state: &'a mut [u8],
    pub xi: &'a mut [Vec3],
    pub records: &'a mut [ContactState],
    rolling: &'a mut [Rolling],
    /// Flags of the bodies with contacts that begin or end.
    pub changed: &'a Changed,
    pub tally: &'a mut Tally,
}

/// Number of entries scanned before the acting ones are evaluated: few enough to stay in the cache.
const TOGETHER: usize = 256;

/// Number of entries by which bodies are fetched ahead.
const AHEAD: usize = 16;

impl Block<'_> {
    fn evaluate(&mut self) {
        #[cfg(target_arch = "x86_64")]
        if let Some(law) = self.scenery.one_law {
            match law.variant {
                Variant::Avx512 => return self.in_registers(law),
                Variant::Avx2 => return self.in_quads(law),
                Variant::Portable => {}
            }
        }
        let mut hits = [0; TOGETHER + LANES];
        let mut waiting = 0;
        for begin in (0..self.entries.len()).step_by(TOGETHER) {
            let end = self.entries.len().min(begin + TOGETHER);
            let found = waiting + self.find(begin..end, &mut hits[waiting..]);
            let Some(law) = self.scenery.one_law else {
                hits[..found].iter().for_each(|&k| self.one_by_one(k as usize));
                continue;
            };
            // Whole batches at once; the rest waits for company.
            let last = end == self.entries.len();
            let whole = if last { found } else { found / LANES * LANES };
            self.side_by_side(law, &hits[..whole]);
            hits.copy_within(whole..found, 0);
            waiting = found - whole;
        }
    }

    /// Writes to `hits` the entries within reach of forces, and returns their number; the others
    /// forget that they touched.
    #[inline(always)]
    fn find(&mut self, range: Range<usize>, hits: &mut [u32]) -> usize {
        let scenery = self.scenery;
        let (balls, gap) = (&scenery.bodies.balls, scenery.reach);
        let mut found = 0;
        for k in range {
            if let Some(entry) = self.entries.get(k + AHEAD) {
                fetch(balls, entry.other as usize);
                fetch(self.records, k + AHEAD);
            }
            let (i, j, d) = self.pair(k);
            let reach = balls[i].radius + balls[j].radius + gap;
            let touches = d.norm_squared() < reach * reach;
            // Without a branch: which pairs of a list touch cannot be foretold.
            hits[found] = k as u32;
            found += usize::from(touches);
            let acted = self.state[k] & ACTING != 0;
            self.state[k] &= u8::from(touches).wrapping_neg();
            if acted != touches {
                self.changed.note(i, j);
            }
        }
        found
    }

    /// Bodies of an entry.
    #[inline(always)]
    pub fn bodies(&self, k: usize) -> (usize, usize) {
        (self.entries[k].body(self.first), self.entries[k].other as usize)
    }

    /// Bodies of an entry, from centre to centre.
    #[inline(always)]
    pub fn pair(&self, k: usize) -> (usize, usize, Vec3) {
        let (i, j) = self.bodies(k);
        (i, j, self.scenery.through(i, j, self.entries[k].image() as usize))
    }

    fn one_by_one(&mut self, k: usize) {
        let scenery = self.scenery;
        let (i, j, d) = self.pair(k);
        let (a, b) = (&scenery.bodies.balls[i], &scenery.bodies.balls[j]);
        let predicted = &scenery.bodies.predicted;
        let contact = touch_of_balls(d, a.radius, b.radius, &predicted[i], &predicted[j]);
        let (record, pair) = (&mut self.records[k], self.reduced[k]);
        let squeezed = scenery.lubrication(&contact, pair);
        // A listed pair within reach acts, in contact or not; contact adds its bit below.
        let touching = std::mem::replace(&mut self.state[k], ACTING) & TOUCHING != 0;
        let law = &scenery.laws[self.entries[k].law()];
        if !law.holds(contact.overlap, pair, touching) {
            *record = ContactState::at_a_distance(&contact, squeezed);
            // Else the torque of the contact that ended would be summed on.
            if let Some(rolling) = self.rolling.get_mut(k) {
                *rolling = Rolling::NONE;
            }
            return;
        }
        self.state[k] = ACTING | TOUCHING;
        let mut memory = contact_force::ContactHistory {
            xi: self.xi[k],
            rolling: self.rolling.get(k).map_or(Vec3::zeros(), |r| r.displacement),
            normal: record.normal,
            overlap: record.overlap,
        };
        let force = contact_force::force(law, pair, &contact, &mut memory, touching, scenery.steps);
        self.xi[k] = memory.xi;
        *record = ContactState {
            normal: contact.normal,
            tangential: force.tangential,
            force: force.normal + squeezed,
            overlap: contact.overlap,
        };
        if let Some(rolling) = self.rolling.get_mut(k) {
            *rolling = Rolling { displacement: memory.rolling, torque: force.rolling };
        }
        let ratio = contact.overlap / a.radius.min(b.radius);
        self.tally.add(ratio, i as u32, Other::Body(j as u32));
    }
}
