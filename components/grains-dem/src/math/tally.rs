//! Tally of the contacts of one evaluation of the forces.

use serde::{Deserialize, Serialize};

/// Overlap over the smaller radius beyond which a contact is counted as too soft.
pub(crate) const DEEP: f64 = 0.05;

/// Numbers of contacts, and the deepest.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Tally {
    /// Contacts.
    pub contacts: u64,
    /// Contacts with an overlap beyond 5 % of the smaller radius.
    pub deep: u64,
    /// The contact with the largest overlap in terms of its smaller radius.
    pub deepest: Deepest,
}

/// The deepest contact of an evaluation.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Deepest {
    /// Overlap over the smaller radius.
    pub ratio: f64,
    /// Index of the body.
    pub body: u32,
    /// The other side of the contact.
    pub other: Other,
}

/// The other side of a contact, by index.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) enum Other {
    Body(u32),
    Wall(u32),
    Part(u32),
    /// A surface that deforms, by the part that carries it.
    Surface(u32),
}

impl Default for Deepest {
    fn default() -> Self {
        Self { ratio: 0.0, body: 0, other: Other::Body(0) }
    }
}

impl Tally {
    /// Adds a contact of a body, with its overlap over the smaller radius.
    #[inline(always)]
    pub fn add(&mut self, ratio: f64, body: u32, other: Other) {
        self.count(1, u32::from(ratio > DEEP));
        self.deepen(ratio, body, other);
    }

    /// Adds numbers of contacts and of deep contacts.
    #[inline(always)]
    pub fn count(&mut self, contacts: u32, deep: u32) {
        self.contacts += u64::from(contacts);
        self.deep += u64::from(deep);
    }

    /// Notes a contact that was counted, if it is the deepest.
    #[inline(always)]
    pub fn deepen(&mut self, ratio: f64, body: u32, other: Other) {
        if ratio > self.deepest.ratio {
            self.deepest = Deepest { ratio, body, other };
        }
    }

    /// The sum of tallies.
    pub fn sum(tallies: &[Self]) -> Self {
        let mut sum = Self::default();
        for tally in tallies {
            sum.contacts += tally.contacts;
            sum.deep += tally.deep;
            if tally.deepest.ratio > sum.deepest.ratio {
                sum.deepest = tally.deepest;
            }
        }
        sum
    }
}
