//! Makes the list of pairs, block by block, on all threads.

use crate::Vec3;
use crate::bodies::body_arrays::BLOCK;
use crate::bodies::body_arrays::Bodies;
use crate::bodies::body_arrays::SPHERE;
use crate::contact::material_laws::Laws;
use crate::contact::springs::Reduced;
use crate::neighbours::neighbour_list::{ContactState, ListedPair, NeighbourList, Rolling};
use tremie_grains_kit::neighbours::cell_pairs::near;
use tremie_grains_kit::neighbours::linked_cells::LinkedCells;
use tremie_team::{Cut, Team};

/// Pairs with at least one polyhedron, as a block finds them: places in memory, and the image
/// through which the first sees the second.
pub(crate) type SolidPair = (u32, u32, u32);

/// Builder of a neighbour list, with buffers that are kept from list to list.
#[derive(Debug, Default)]
pub(crate) struct NeighbourListBuilder {
    before: NeighbourList,
    blocks: Vec<Found>,
    keys: Vec<u64>,
    /// Index at which the next place of each body is written.
    cursors: Vec<u32>,
    place_bounds: Vec<u32>,
}

/// Pairs found by one block of bodies.
#[derive(Debug, Default)]
struct Found {
    /// Pairs that touch, and then separate pairs by their gap.
    entries: Vec<ListedPair>,
    /// Number of pairs that touch.
    touching: usize,
    /// Pairs that do not touch, with the bits of their gaps. A gap is not negative, so its bits
    /// sort as the number does.
    apart: Vec<(u32, ListedPair)>,
    /// Entries whose other body belongs to another block.
    outside: Vec<(u32, u32)>,
    /// Pairs with polyhedra, which have a list of their own.
    solids: Vec<SolidPair>,
}

/// Input of the search, besides the bodies.
pub(crate) struct PairSearch<'a> {
    /// The bodies sorted by cell.
    pub cells: &'a LinkedCells,
    /// Displacements of images.
    pub shifts: &'a [Vec3; 27],
    /// Laws of materials.
    pub laws: &'a Laws,
    /// Place of each body in memory when the list before was made, or
    /// [`NEW`](crate::bodies::body_arrays::NEW).
    pub previous: &'a [u32],
}

impl NeighbourListBuilder {
    /// Makes the list anew. Contacts that it knew keep their history.
    pub fn make(
        &mut self,
        pairs: &mut NeighbourList,
        team: &mut Team,
        bodies: &Bodies,
        near: &PairSearch,
    ) {
        std::mem::swap(pairs, &mut self.before);
        // No contact remembers these: one copy will do.
        std::mem::swap(&mut pairs.gaps, &mut self.before.gaps);
        std::mem::swap(&mut pairs.reduced, &mut self.before.reduced);
        std::mem::swap(&mut pairs.acting, &mut self.before.acting);
        self.find(pairs, team, bodies, near);
        pairs.crossed.clear();
        pairs.crossed.resize(bodies.len(), 0);
        self.fill(pairs, team, bodies, near);
        self.collect(pairs, team, bodies);
    }

    /// Pairs with at least one polyhedron, of the last list.
    pub fn solids(&self) -> impl Iterator<Item = SolidPair> + '_ {
        self.blocks.iter().flat_map(|block| block.solids.iter().copied())
    }

    /// Finds the entries, block by block, and says where each block begins.
    fn find(
        &mut self,
        pairs: &mut NeighbourList,
        team: &mut Team,
        bodies: &Bodies,
        at: &PairSearch,
    ) {
        self.blocks.resize_with(bodies.len().div_ceil(BLOCK), Found::default);
        team.for_each(&mut self.blocks, |b, block| block.find(b, bodies, at));
        pairs.bounds.clear();
        pairs.bounds.push(0);
        let mut end = 0;
        for block in &self.blocks {
            end += block.entries.len() as u32;
            pairs.bounds.push(end);
        }
        pairs.near.clear();
        pairs.near.resize(self.blocks.len(), 0);
        pairs.rolling_bounds.clear();
        if at.laws.resist_rolling() {
            pairs.rolling_bounds.extend(&pairs.bounds);
        } else {
            pairs.rolling_bounds.resize(pairs.bounds.len(), 0);
        }
    }

    /// Copies the entries into the list and gives them their history.
    fn fill(
        &mut self,
        pairs: &mut NeighbourList,
        team: &mut Team,
        bodies: &Bodies,
        at: &PairSearch,
    ) {
        let count = pairs.bounds[self.blocks.len()] as usize;
        pairs.entries.resize(count, ListedPair::default());
        pairs.gaps.resize(count, 0.0);
        pairs.reduced.resize(count, Reduced::NONE);
        pairs.state.resize(count, 0);
        pairs.xi.resize(count, Vec3::zeros());
        pairs.records.resize(count, ContactState::NONE);
        let rolls = pairs.rolling_bounds.last().is_some_and(|&end| end > 0);
        pairs.rolling.resize(if rolls { count } else { 0 }, Rolling::NONE);
        let bounds = &pairs.bounds;
        let pieces = (
            Cut::at(&mut pairs.entries, bounds),
            Cut::at(&mut pairs.gaps, bounds),
            Cut::at(&mut pairs.reduced, bounds),
            Cut::at(&mut pairs.state, bounds),
            Cut::at(&mut pairs.xi, bounds),
            Cut::at(&mut pairs.records, bounds),
            Cut::at(&mut pairs.rolling, &pairs.rolling_bounds),
        );
        let (blocks, before) = (&self.blocks, &self.before);
        let known = !before.bounds.is_empty();
        team.for_pieces(pieces, |b, (entries, gaps, reduced, state, xi, records, rolling)| {
            let found = &blocks[b];
            entries.copy_from_slice(&found.entries);
            gaps[..found.touching].fill(0.0);
            for (gap, apart) in gaps[found.touching..].iter_mut().zip(&found.apart) {
                *gap = f32::from_bits(apart.0);
            }
            state.fill(0);
            for (k, entry) in entries.iter().enumerate() {
                let (i, j) = (entry.body(b * BLOCK), entry.other as usize);
                reduced[k] = reduced_of(bodies, i, j);
                if k >= found.touching {
                    // What does not touch now has nothing to remember.
                    continue;
                }
                let (i, j) = (at.previous[i], at.previous[j]);
                let Some((known, sign)) = known.then(|| before.find(i, j)).flatten() else {
                    continue;
                };
                // Forces too: where bodies come or go between two substeps they still act.
                state[k] = before.state[known];
                xi[k] = before.xi[known] * sign;
                records[k] = before.records[known].seen(sign);
                if let (Some(rolling), Some(old)) = (rolling.get_mut(k), before.rolling.get(known))
                {
                    rolling.displacement = old.displacement * sign;
                    rolling.torque = old.torque * sign;
                }
            }
        });
    }

    /// Counts the contacts of each of `n` bodies, and makes room for them.
    fn count_contacts(&mut self, pairs: &mut NeighbourList, team: &mut Team, n: usize) {
        self.cursors.resize(n, 0);
        let (entries, bounds) = (&pairs.entries, &pairs.bounds);
        let pieces = (Cut::every(&mut self.cursors, BLOCK), Cut::every(&mut self.blocks, 1));
        team.for_pieces(pieces, |b, (count, block)| {
            let own = bounds[b] as usize..bounds[b + 1] as usize;
            block[0].count(b * BLOCK, &entries[own.clone()], own.start, count);
        });
        // By one thread: these bodies belong to other blocks.
        for block in &self.blocks {
            block.outside.iter().for_each(|&(j, _)| self.cursors[j as usize] += 1);
        }
        pairs.collected.clear();
        let mut end = 0;
        for count in &mut self.cursors {
            pairs.collected.push(end);
            // From here on the counts are cursors: the first free place of each body.
            end += std::mem::replace(count, end);
        }
        pairs.collected.push(end);
        self.keys.resize(end as usize, 0);
        pairs.places.resize(end as usize, 0);
        self.place_bounds.clear();
        self.place_bounds.extend((0..n).step_by(BLOCK).map(|i| pairs.collected[i]));
        self.place_bounds.push(end);
    }

    /// Lists for each body its contacts by the other's id.
    fn collect(&mut self, pairs: &mut NeighbourList, team: &mut Team, bodies: &Bodies) {
        self.count_contacts(pairs, team, bodies.len());
        let n = bodies.len();
        let (entries, bounds) = (&pairs.entries, &pairs.bounds);
        let rank = &bodies.rank;
        let pieces =
            (Cut::at(&mut self.keys, &self.place_bounds), Cut::every(&mut self.cursors, BLOCK));
        let place_bounds = &self.place_bounds;
        team.for_pieces(pieces, |b, (keys, cursors)| {
            let (first, place) = (b * BLOCK, place_bounds[b]);
            let mut put = |body: usize, other: usize, k: u32, side: u32| {
                let cursor = &mut cursors[body - first];
                keys[(*cursor - place) as usize] = key(rank[other], k, side);
                *cursor += 1;
            };
            for k in bounds[b]..bounds[b + 1] {
                let entry = entries[k as usize];
                let (i, j) = (entry.body(first), entry.other as usize);
                put(i, j, k, 0);
                if j / BLOCK == b {
                    put(j, i, k, 1);
                }
            }
        });
        // Again by one thread. The order of writing does not matter, as keys are sorted next.
        for (b, block) in self.blocks.iter().enumerate() {
            for &(j, k) in &block.outside {
                let cursor = &mut self.cursors[j as usize];
                let i = entries[k as usize].body(b * BLOCK);
                self.keys[*cursor as usize] = key(rank[i], k, 1);
                *cursor += 1;
            }
        }
        let pieces =
            (Cut::at(&mut self.keys, place_bounds), Cut::at(&mut pairs.places, place_bounds));
        let collected = &pairs.collected;
        team.for_pieces(pieces, |b, (keys, places)| {
            let first = place_bounds[b];
            for i in b * BLOCK..n.min((b + 1) * BLOCK) {
                let own = (collected[i] - first) as usize..(collected[i + 1] - first) as usize;
                keys[own].sort_unstable();
            }
            for (place, key) in places.iter_mut().zip(keys) {
                // The lower half of a key holds entry and side; the other's rank is needed no more.
                *place = *key as u32;
            }
        });
        pairs.find_acting(team);
    }
}

/// Sorts by the other's rank, which is the order of ids.
fn key(other: u32, entry: u32, side: u32) -> u64 {
    u64::from(other) << 32 | u64::from(2 * entry + side)
}

impl Found {
    /// Finds the pairs of block `b`.
    fn find(&mut self, b: usize, bodies: &Bodies, at: &PairSearch) {
        let (balls, mobility, material) = (&bodies.balls, &bodies.mobility, &bodies.material);
        self.entries.clear();
        self.apart.clear();
        self.solids.clear();
        let (poly, any) = (&bodies.poly, !bodies.equal_radii.is_empty());
        let felt = at.cells.skins().reach;
        for i in b * BLOCK..balls.len().min((b + 1) * BLOCK) {
            near(at.cells, at.shifts, balls, mobility, i, |seen, j, square| {
                if any && (poly[i] != SPHERE || poly[j] != SPHERE) {
                    self.solids.push((i as u32, seen.other, seen.image));
                    return;
                }
                let law = at.laws.between(material[i], material[j]);
                let entry = ListedPair::new(i, seen.other, seen.image, law);
                let reach = balls[i].radius + balls[j].radius + felt;
                if square < reach * reach {
                    self.entries.push(entry);
                } else {
                    let apart = (square.sqrt() - reach).max(0.0) as f32;
                    self.apart.push((apart.to_bits(), entry));
                }
            });
        }
        self.touching = self.entries.len();
        self.apart.sort_unstable_by_key(|&(gap, _)| gap);
        self.entries.extend(self.apart.iter().map(|&(_, entry)| entry));
    }

    /// Counts the contacts of each body of a block that begins at `first`, as far as its own
    /// entries tell, and notes those of bodies outside. The entries begin at `start` of the list.
    fn count(&mut self, first: usize, entries: &[ListedPair], start: usize, count: &mut [u32]) {
        count.fill(0);
        self.outside.clear();
        for (k, entry) in (start as u32..).zip(entries) {
            count[entry.body(first) - first] += 1;
            match (entry.other as usize).checked_sub(first).and_then(|j| count.get_mut(j)) {
                Some(count) => *count += 1,
                None => self.outside.push((entry.other, k)),
            }
        }
    }
}

fn reduced_of(bodies: &Bodies, i: usize, j: usize) -> Reduced {
    let (a, b) = (bodies.balls[i].radius, bodies.balls[j].radius);
    Reduced {
        root_mass: bodies.mobility[i].root_reduced_mass(bodies.mobility[j]),
        radius: a * b / (a + b),
        mean_mass: bodies.mobility[i].mean_mass(bodies.mobility[j]),
    }
}
