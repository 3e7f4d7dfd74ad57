//! Pairs of bodies that may touch, with what each contact remembers and what force it last gave.
//!
//! Each pair stands once, in the row of one of its bodies; which of the two does not matter, because
//! the formulae of a contact give exactly opposite numbers to the other side. A body collects its
//! forces from a list of its own, in the order of the others' ids: so sums do not depend on where
//! bodies stand in memory, on when neighbours were listed, or on threads.

use crate::{
    Vec3,
    bodies::{Bodies, Wrench},
    cells::Cells,
    contact::{Contact, Memory},
    law::Reduced,
    laws::Laws,
    rows::near,
};
use tremie_team::{Cut, Team};

/// Bodies that are one item of work.
pub(crate) const BLOCK: usize = 512;

/// A possible contact of a row.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Entry {
    /// Index of the other body.
    pub other: u32,
    /// Image through which it is seen; see [`crate::periodic::image`].
    pub image: u16,
    /// Number of the law.
    pub law: u16,
}

/// What a contact gave at the last evaluation: 64 bytes, read as a whole.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Record {
    /// Unit normal, away from the body of the row.
    pub normal: Vec3,
    /// Tangential force on the body of the row [N].
    pub tangential: Vec3,
    /// Normal force, positive when pushing [N].
    pub force: f64,
    /// Overlap [m]; negative where bodies feel each other at a distance.
    pub overlap: f64,
}

impl Record {
    pub const NONE: Self = Self {
        normal: Vec3::new(0.0, 0.0, 0.0),
        tangential: Vec3::new(0.0, 0.0, 0.0),
        force: 0.0,
        overlap: 0.0,
    };

    /// Of bodies that do not touch: a normal force alone.
    #[inline(always)]
    pub fn at_a_distance(contact: &Contact, force: f64) -> Self {
        Self { normal: contact.normal, force, overlap: contact.overlap, ..Self::NONE }
    }

    /// What it does to a body of `radius`, of whose row it is or not (then `sign` is -1).
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
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rolling {
    /// Displacement that is remembered [m]; see [`Memory::rolling`].
    pub displacement: Vec3,
    /// Torque on the body of the row [N·m].
    pub torque: Vec3,
}

impl Rolling {
    pub const NONE: Self =
        Self { displacement: Vec3::new(0.0, 0.0, 0.0), torque: Vec3::new(0.0, 0.0, 0.0) };
}

/// A contact that acts: the body of the row, and the entry.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Hit {
    pub body: u32,
    pub entry: u32,
}

/// Bits of an entry's state.
pub(crate) const ACTING: u8 = 1;
pub(crate) const TOUCHING: u8 = 2;

/// The list.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pairs {
    /// `start[i]..start[i + 1]` are the entries of body i.
    pub start: Vec<u32>,
    /// Entries of the blocks of bodies.
    pub bounds: Vec<u32>,
    /// As `bounds` where there is rolling friction; else all zero.
    pub rolling_bounds: Vec<u32>,
    /// The possible contacts.
    pub entries: Vec<Entry>,
    /// Mass and radius of each pair.
    pub reduced: Vec<Reduced>,
    /// Which act, and which touch.
    pub state: Vec<u8>,
    /// Tangential displacement; see [`Memory::xi`].
    pub xi: Vec<Vec3>,
    /// Normal, forces, overlap.
    pub records: Vec<Record>,
    /// Rolling friction, where any law has it.
    pub rolling: Vec<Rolling>,
    /// Room to gather those that act.
    pub hits: Vec<Hit>,
    /// `collected[i]..collected[i + 1]` are body i's places in `places`.
    pub collected: Vec<u32>,
    /// Contacts of each body by the other's id: twice the entry, and one more where the body is the
    /// other of that entry.
    pub places: Vec<u32>,
}

/// What it takes to make a list: buffers that are kept.
#[derive(Debug, Default)]
pub(crate) struct PairsMaker {
    before: Pairs,
    blocks: Vec<Found>,
    keys: Vec<u64>,
    place_bounds: Vec<u32>,
}

/// What one block of bodies found.
#[derive(Debug, Default)]
struct Found {
    entries: Vec<Entry>,
    ends: Vec<u32>,
}

/// What the list is made from.
pub(crate) struct Nearness<'a> {
    /// The bodies sorted by cell.
    pub cells: &'a Cells,
    /// Displacements of images.
    pub shifts: &'a [Vec3; 27],
    /// How far beyond touching pairs are listed [m].
    pub gap: f64,
    /// Laws of materials.
    pub laws: &'a Laws,
    /// Where in memory each body stood when the list before was made.
    pub previous: &'a [u32],
}

impl Pairs {
    /// Entries of body i.
    #[inline(always)]
    pub fn row(&self, i: usize) -> std::ops::Range<usize> {
        self.start[i] as usize..self.start[i + 1] as usize
    }

    /// What entry k remembers.
    #[inline(always)]
    pub fn memory(&self, k: usize) -> Memory {
        Memory {
            xi: self.xi[k],
            rolling: self.rolling.get(k).map_or(Vec3::zeros(), |r| r.displacement),
            normal: self.records[k].normal,
            overlap: self.records[k].overlap,
        }
    }

    /// What the pair of bodies i and j, by their places in this list, remembers, if it touched.
    fn remembered(&self, i: u32, j: u32) -> Option<Memory> {
        let find = |i: u32, j: u32| {
            self.row(i as usize)
                .find(|&k| self.state[k] & TOUCHING != 0 && self.entries[k].other == j)
        };
        match find(i, j) {
            Some(k) => Some(self.memory(k)),
            None => find(j, i).map(|k| self.memory(k).of_other_side()),
        }
    }
}

impl PairsMaker {
    /// Makes the list anew. Contacts that it knew keep their history.
    pub fn make(&mut self, pairs: &mut Pairs, team: &mut Team, bodies: &Bodies, near: &Nearness) {
        std::mem::swap(pairs, &mut self.before);
        self.find(pairs, team, bodies, near);
        self.fill(pairs, team, bodies, near);
        self.collect(pairs, team, bodies);
    }

    /// Finds the entries, block by block, and says where each row begins.
    fn find(&mut self, pairs: &mut Pairs, team: &mut Team, bodies: &Bodies, at: &Nearness) {
        let n = bodies.len();
        self.blocks.resize_with(n.div_ceil(BLOCK), Found::default);
        let (balls, mobility, material) = (&bodies.balls, &bodies.mobility, &bodies.material);
        team.for_each(&mut self.blocks, |b, block| {
            block.entries.clear();
            block.ends.clear();
            for i in b * BLOCK..n.min((b + 1) * BLOCK) {
                near(at.cells, at.shifts, balls, mobility, at.gap, i, |seen, j| {
                    block.entries.push(Entry {
                        other: seen.other,
                        image: seen.image as u16,
                        law: at.laws.between(material[i], material[j]),
                    });
                });
                block.ends.push(block.entries.len() as u32);
            }
        });
        pairs.start.clear();
        pairs.bounds.clear();
        pairs.start.push(0);
        pairs.bounds.push(0);
        let mut offset = 0;
        for block in &self.blocks {
            pairs.start.extend(block.ends.iter().map(|end| offset + end));
            offset += block.entries.len() as u32;
            pairs.bounds.push(offset);
        }
        pairs.rolling_bounds.clear();
        if at.laws.resist_rolling() {
            pairs.rolling_bounds.extend(&pairs.bounds);
        } else {
            pairs.rolling_bounds.resize(pairs.bounds.len(), 0);
        }
    }

    /// Copies the entries into the list and gives them their history.
    fn fill(&mut self, pairs: &mut Pairs, team: &mut Team, bodies: &Bodies, at: &Nearness) {
        let count = pairs.start[bodies.len()] as usize;
        pairs.entries.resize(count, Entry::default());
        pairs.reduced.resize(count, Reduced { root_mass: 0.0, radius: 0.0 });
        pairs.state.resize(count, 0);
        pairs.xi.resize(count, Vec3::zeros());
        pairs.records.resize(count, Record::NONE);
        pairs.hits.resize(count, Hit::default());
        let rolls = pairs.rolling_bounds.last().is_some_and(|&end| end > 0);
        pairs.rolling.resize(if rolls { count } else { 0 }, Rolling::NONE);
        let bounds = &pairs.bounds;
        let pieces = (
            Cut::at(&mut pairs.entries, bounds),
            Cut::at(&mut pairs.reduced, bounds),
            Cut::at(&mut pairs.state, bounds),
            Cut::at(&mut pairs.xi, bounds),
            Cut::at(&mut pairs.records, bounds),
            Cut::at(&mut pairs.rolling, &pairs.rolling_bounds),
        );
        let (blocks, before, start) = (&self.blocks, &self.before, &pairs.start);
        let known = before.start.len() == start.len();
        team.for_pieces(pieces, |b, (entries, reduced, state, xi, records, rolling)| {
            entries.copy_from_slice(&blocks[b].entries);
            let mut k = 0;
            for (i, &end) in (b * BLOCK..).zip(&blocks[b].ends) {
                for k in std::mem::replace(&mut k, end as usize)..end as usize {
                    let j = entries[k].other as usize;
                    reduced[k] = reduced_of(bodies, i, j);
                    state[k] = 0;
                    let (i, j) = (at.previous[i], at.previous[j]);
                    let Some(memory) = known.then(|| before.remembered(i, j)).flatten() else {
                        continue;
                    };
                    state[k] = TOUCHING;
                    xi[k] = memory.xi;
                    records[k].normal = memory.normal;
                    records[k].overlap = memory.overlap;
                    if let Some(rolling) = rolling.get_mut(k) {
                        rolling.displacement = memory.rolling;
                    }
                }
            }
        });
    }

    /// Lists for each body its contacts by the other's id.
    fn collect(&mut self, pairs: &mut Pairs, team: &mut Team, bodies: &Bodies) {
        let n = bodies.len();
        let collected = &mut pairs.collected;
        collected.clear();
        collected.resize(n + 2, 0);
        // Counted two places further up, so that the places below serve as cursors.
        for i in 0..n {
            collected[i + 2] += pairs.start[i + 1] - pairs.start[i];
        }
        for entry in &pairs.entries {
            collected[entry.other as usize + 2] += 1;
        }
        for i in 2..n + 2 {
            collected[i] += collected[i - 1];
        }
        self.keys.resize(2 * pairs.entries.len(), 0);
        let id = &bodies.id;
        for i in 0..n {
            for k in pairs.start[i]..pairs.start[i + 1] {
                let j = pairs.entries[k as usize].other as usize;
                for (body, other, side) in [(i, j, 0), (j, i, 1)] {
                    let place = &mut collected[body + 1];
                    self.keys[*place as usize] =
                        u64::from(id[other]) << 32 | u64::from(2 * k + side);
                    *place += 1;
                }
            }
        }
        collected.pop();
        pairs.places.resize(self.keys.len(), 0);
        self.place_bounds.clear();
        self.place_bounds.extend((0..n).step_by(BLOCK).map(|i| pairs.collected[i]));
        self.place_bounds.push(pairs.collected[n]);
        let pieces = (
            Cut::at(&mut self.keys, &self.place_bounds),
            Cut::at(&mut pairs.places, &self.place_bounds),
        );
        let collected = &pairs.collected;
        team.for_pieces(pieces, |b, (keys, places)| {
            let first = collected[b * BLOCK] as usize;
            for i in b * BLOCK..n.min((b + 1) * BLOCK) {
                let own = collected[i] as usize - first..collected[i + 1] as usize - first;
                keys[own].sort_unstable();
            }
            for (place, key) in places.iter_mut().zip(keys) {
                *place = *key as u32;
            }
        });
    }
}

fn reduced_of(bodies: &Bodies, i: usize, j: usize) -> Reduced {
    let (a, b) = (bodies.balls[i].radius, bodies.balls[j].radius);
    Reduced {
        root_mass: bodies.mobility[i].root_reduced_mass(bodies.mobility[j]),
        radius: a * b / (a + b),
    }
}
