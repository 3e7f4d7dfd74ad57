//! What one evaluation of the forces saw.

/// Overlap over the smaller radius beyond which a contact is counted as too soft.
const DEEP: f64 = 0.05;

/// Numbers of contacts, and the deepest.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tally {
    /// Contacts.
    pub contacts: u64,
    /// Contacts with an overlap beyond 5 % of the smaller radius.
    pub deep: u64,
    /// The contact with the largest overlap in terms of its smaller radius.
    pub deepest: Deepest,
}

/// The deepest contact of an evaluation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Deepest {
    /// Overlap [m].
    pub overlap: f64,
    /// Smaller radius [m].
    pub radius: f64,
    /// Index of the body.
    pub body: u32,
    /// What it overlaps.
    pub other: Other,
}

/// The other side of a contact, by index.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Other {
    Body(u32),
    Wall(u32),
    Part(u32),
}

impl Default for Deepest {
    fn default() -> Self {
        Self { overlap: 0.0, radius: 1.0, body: 0, other: Other::Body(0) }
    }
}

impl Deepest {
    /// Overlap over the smaller radius.
    pub fn ratio(&self) -> f64 {
        self.overlap / self.radius
    }
}

impl Tally {
    #[inline(always)]
    pub fn add(&mut self, seen: Deepest) {
        self.contacts += 1;
        self.deep += u64::from(seen.overlap > DEEP * seen.radius);
        self.take_deeper(seen);
    }

    /// The sum of tallies, in their order.
    pub fn sum(tallies: &[Self]) -> Self {
        let mut sum = Self::default();
        for tally in tallies {
            sum.contacts += tally.contacts;
            sum.deep += tally.deep;
            sum.take_deeper(tally.deepest);
        }
        sum
    }

    #[inline(always)]
    fn take_deeper(&mut self, seen: Deepest) {
        // Compared without a division, because this runs for every contact.
        if seen.overlap * self.deepest.radius > self.deepest.overlap * seen.radius {
            self.deepest = seen;
        }
    }
}
