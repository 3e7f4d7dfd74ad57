//! Contacts of each body that act. Few begin or end in a step, so they are noted and not searched.

use crate::bodies::body_arrays::BLOCK;
use crate::neighbours::neighbour_list::ACTING;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use tremie_team::{Cut, Team};

/// The contacts of each body that act, in the order in which it sums them.
#[derive(Debug, Default)]
pub(crate) struct Acting {
    /// From where a body's places begin in
    /// [`Pairs::places`](crate::neighbours::neighbour_list::NeighbourList::places): those that act,
    /// and after them what means nothing.
    places: Vec<u32>,
    /// Number of contacts of each body that act.
    counts: Vec<u32>,
    /// Bounds of the places of each block of bodies, with the end of the last block.
    bounds: Vec<u32>,
    /// Bodies that a contact of began or ended since. Both sides of a contact are noted, by
    /// whichever thread sees it; all write the same.
    changed: Changed,
}

/// Bodies some of whose contacts began or ended.
#[derive(Debug, Default)]
pub(crate) struct Changed(Vec<AtomicBool>);

impl Changed {
    /// Notes two bodies.
    #[inline(always)]
    pub fn note(&self, i: usize, j: usize) {
        self.0[i].store(true, Relaxed);
        self.0[j].store(true, Relaxed);
    }
}

impl Acting {
    /// Makes the lists of all bodies, from their places and the entries' states.
    pub fn make(&mut self, team: &mut Team, (collected, places): (&[u32], &[u32]), state: &[u8]) {
        let bodies = collected.len() - 1;
        self.places.resize(places.len(), 0);
        self.counts.resize(bodies, 0);
        self.bounds.clear();
        self.bounds.extend(collected[..bodies].iter().step_by(BLOCK));
        self.bounds.push(places.len() as u32);
        self.changed.0.clear();
        self.changed.0.resize_with(bodies, || AtomicBool::new(true));
        self.follow(team, (collected, places), state);
    }

    /// Flags of the bodies with contacts that begin or end.
    pub fn changed(&self) -> &Changed {
        &self.changed
    }

    /// Updates the lists of bodies with contacts that began or ended.
    pub fn follow(&mut self, team: &mut Team, (collected, places): (&[u32], &[u32]), state: &[u8]) {
        let pieces = (
            Cut::every(&mut self.counts, BLOCK),
            Cut::every(&mut self.changed.0, BLOCK),
            Cut::at(&mut self.places, &self.bounds),
        );
        team.for_pieces(pieces, |b, (counts, changed, acting)| {
            let first = b * BLOCK;
            let begin = collected[first] as usize;
            for (i, (count, changed)) in (first..).zip(counts.iter_mut().zip(changed)) {
                if !std::mem::take(changed.get_mut()) {
                    continue;
                }
                let own = collected[i] as usize..collected[i + 1] as usize;
                let acting = &mut acting[own.start - begin..own.end - begin];
                let mut found = 0;
                for &place in &places[own] {
                    // Without a branch: which pairs of a list touch cannot be foretold.
                    acting[found] = place;
                    found += usize::from(state[(place / 2) as usize] & ACTING);
                }
                *count = found as u32;
            }
        });
    }

    /// Acting contacts of body i, whose places begin at `begin`.
    #[inline(always)]
    pub fn of(&self, i: usize, begin: u32) -> &[u32] {
        let begin = begin as usize;
        &self.places[begin..begin + self.counts[i] as usize]
    }
}
