//! Pairs of bodies that may touch, with the history and the last force of each contact.
//!
//! Each pair stands once, in the block of one of its bodies; which of the two does not matter,
//! because the formulae of a contact give exactly opposite numbers to the other side. A body
//! collects its forces from a list of its own, in the order of the others' ids: so sums do not
//! depend on where bodies stand in memory, on when neighbours were listed, or on threads.
//!
//! A block lists first the pairs that touched when the list was made, then the others by their gap.
//! Two bodies that have not come as far as their gap cannot touch, so a step looks at the head of
//! the list only, and what contacts remember lies close together.

use crate::Vec3;
use crate::bodies::body_arrays::BLOCK;
use crate::bodies::body_arrays::{NEW, Wrench};
use crate::contact::contact_force::{Contact, ContactHistory};
use crate::contact::springs::Reduced;
use crate::neighbours::active_contacts::Acting;
use serde::{Deserialize, Serialize};
use tremie_team::Team;

/// A possible contact.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
#[repr(C)]
pub(crate) struct ListedPair {
    /// Index of the other body.
    pub other: u32,
    /// From the lowest bit on: 9 bits for the body's place in its block, 5 for the image through
    /// which the other is seen (see [`tremie_grains_kit::space::periodic::image`]), 16 for the number of the
    /// law.
    tags: u32,
}

impl ListedPair {
    /// A contact of `body` under a law with another, seen through an image.
    pub fn new(body: usize, other: u32, image: u32, law: u16) -> Self {
        Self { other, tags: (body % BLOCK) as u32 | image << 9 | u32::from(law) << 14 }
    }

    /// Index of the body whose contact it is, in a block that begins at `first`.
    #[inline(always)]
    pub fn body(self, first: usize) -> usize {
        first + self.tags as usize % BLOCK
    }

    /// Image through which the other is seen.
    #[inline(always)]
    pub fn image(self) -> u32 {
        self.tags >> 9 & 31
    }

    /// Sees the other through another image, whose number differs by that of a crossing.
    fn look_across(&mut self, by: i32) {
        let image = (self.image() as i32 + by) as u32 % 32;
        self.tags = self.tags & !(31 << 9) | image << 9;
    }

    /// Number of the law.
    #[inline(always)]
    pub fn law(self) -> usize {
        (self.tags >> 14) as usize
    }
}

/// Result of a contact at the last evaluation: 64 bytes, read as a whole.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[repr(C, align(64))]
pub(crate) struct ContactState {
    /// Unit normal, away from the body of the entry.
    pub normal: Vec3,
    /// Tangential force on the body of the entry [N].
    pub tangential: Vec3,
    /// Normal force, positive when pushing [N].
    pub force: f64,
    /// Overlap [m]; negative where forces act at a distance.
    pub overlap: f64,
}

impl ContactState {
    pub const NONE: Self = Self {
        normal: Vec3::new(0.0, 0.0, 0.0),
        tangential: Vec3::new(0.0, 0.0, 0.0),
        force: 0.0,
        overlap: 0.0,
    };

    /// State of bodies that do not touch: a normal force alone.
    #[inline(always)]
    pub fn at_a_distance(contact: &Contact, force: f64) -> Self {
        Self { normal: contact.normal, force, overlap: contact.overlap, ..Self::NONE }
    }

    /// The state from the side of the other body, where `sign` is -1.
    #[inline(always)]
    pub fn seen(&self, sign: f64) -> Self {
        Self { normal: self.normal * sign, tangential: self.tangential * sign, ..*self }
    }

    /// Wrench on a body of `radius`; `sign` is 1 for the body of the entry and -1 for the other.
    #[inline(always)]
    pub fn on(&self, sign: f64, radius: f64) -> Wrench {
        Wrench {
            force: (self.tangential - self.normal * self.force) * sign,
            // The point lies half way between the two surfaces, so that both torques refer to it.
            torque: self.normal.cross(&self.tangential) * (radius - 0.5 * self.overlap),
        }
    }
}

/// Rolling friction of a contact.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Rolling {
    /// Displacement that is remembered [m]; see [`ContactHistory::rolling`].
    pub displacement: Vec3,
    /// Torque on the body of the entry [N·m].
    pub torque: Vec3,
}

impl Rolling {
    pub const NONE: Self =
        Self { displacement: Vec3::new(0.0, 0.0, 0.0), torque: Vec3::new(0.0, 0.0, 0.0) };
}

/// Bits of an entry's state.
pub(crate) const ACTING: u8 = 1;
pub(crate) const TOUCHING: u8 = 2;

/// The list.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(crate) struct NeighbourList {
    /// Entries of the blocks of bodies: from `bounds[b]` to `bounds[b + 1]`.
    pub bounds: Vec<u32>,
    /// As `bounds` where there is rolling friction; else all zero.
    pub rolling_bounds: Vec<u32>,
    /// The possible contacts.
    pub entries: Vec<ListedPair>,
    /// Gap of each pair, less the reach of forces, when the list was made [m]: ascending in a
    /// block.
    pub gaps: Vec<f32>,
    /// Number of entries of each block that may have met since.
    pub near: Vec<u32>,
    /// Mass and radius of each pair.
    pub reduced: Vec<Reduced>,
    /// State bits of each entry: acts, touches.
    pub state: Vec<u8>,
    /// Tangential displacement; see [`ContactHistory::xi`].
    pub xi: Vec<Vec3>,
    /// Normal, forces, overlap.
    pub records: Vec<ContactState>,
    /// Rolling friction, where any law has it.
    pub rolling: Vec<Rolling>,
    /// `collected[i]..collected[i + 1]` are body i's places in `places`.
    pub collected: Vec<u32>,
    /// Contacts of each body by the other's id: twice the entry, and one more where the body is the
    /// other of that entry.
    pub places: Vec<u32>,
    /// Contacts that act.
    #[serde(skip)]
    pub acting: Acting,
    /// Across which periodic faces each body went since the list was made, as far as entries know;
    /// see [`Bodies::crossed`](crate::bodies::body_arrays::Bodies::crossed).
    pub crossed: Vec<i32>,
}

impl NeighbourList {
    /// Places of the contacts of body i; see [`NeighbourList::places`].
    #[inline(always)]
    pub fn places_of(&self, i: usize) -> &[u32] {
        &self.places[self.collected[i] as usize..self.collected[i + 1] as usize]
    }

    /// Forgets what buffers still hold of contacts that were: of pairs that do not feel each other.
    pub fn forget_ended(&mut self) {
        for k in (0..self.state.len()).filter(|&k| self.state[k] == 0) {
            self.xi[k] = Vec3::zeros();
            self.records[k] = ContactState::NONE;
            if let Some(rolling) = self.rolling.get_mut(k) {
                *rolling = Rolling::NONE;
            }
        }
    }

    /// Finds which contacts act, once the list is there.
    pub fn find_acting(&mut self, team: &mut Team) {
        if !self.collected.is_empty() {
            self.acting.make(team, (&self.collected, &self.places), &self.state);
        }
    }

    /// Contacts of body i that act.
    #[inline(always)]
    pub fn acting_on(&self, i: usize) -> &[u32] {
        self.acting.of(i, self.collected[i])
    }

    /// Looks for bodies that went across periodic faces, among those of the blocks that say that
    /// some did: their entries see others through other images from here on. Few do in a step, so
    /// that contacts need not ask.
    pub fn follow(&mut self, crossed: &[i32], blocks: impl Iterator<Item = usize>) {
        for b in blocks {
            for i in b * BLOCK..crossed.len().min((b + 1) * BLOCK) {
                let by = crossed[i] - self.crossed[i];
                if by == 0 {
                    continue;
                }
                self.crossed[i] = crossed[i];
                for place in self.collected[i]..self.collected[i + 1] {
                    let place = self.places[place as usize];
                    let sign = if place.is_multiple_of(2) { -1 } else { 1 };
                    self.entries[(place / 2) as usize].look_across(sign * by);
                }
            }
        }
    }

    /// Index of the body whose contact entry k is.
    pub fn body_of(&self, k: usize) -> usize {
        let block = self.bounds.partition_point(|&bound| bound as usize <= k) - 1;
        self.entries[k].body(block * BLOCK)
    }

    /// History of the contact of entry k.
    #[inline(always)]
    pub fn memory(&self, k: usize) -> ContactHistory {
        ContactHistory {
            xi: self.xi[k],
            rolling: self.rolling.get(k).map_or(Vec3::zeros(), |r| r.displacement),
            normal: self.records[k].normal,
            overlap: self.records[k].overlap,
        }
    }

    /// The entry of the pair of bodies i and j, by their places in this list, if they felt each
    /// other; and -1 where it is that of body j.
    pub fn find(&self, i: u32, j: u32) -> Option<(usize, f64)> {
        if i == NEW || j == NEW {
            return None;
        }
        let block = j as usize / BLOCK;
        let of_j = self.bounds[block] as usize..self.bounds[block + 1] as usize;
        for &place in self.places_of(i as usize) {
            let k = (place / 2) as usize;
            if self.state[k] == 0 {
                continue;
            }
            let entry = self.entries[k];
            if place.is_multiple_of(2) && entry.other == j {
                return Some((k, 1.0));
            }
            if place % 2 == 1 && of_j.contains(&k) && entry.body(block * BLOCK) == j as usize {
                return Some((k, -1.0));
            }
        }
        None
    }
}
