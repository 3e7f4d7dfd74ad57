//! List of the possible contacts of polyhedra, with their histories and loads.
//!
//! Entries stand in the order of ids, so that sums do not depend on where bodies stand in memory,
//! on when the list was made, or on threads.

use super::{
    Polyhedra,
    contact_pair::{Around, SolidPairEntry, SolidPairKind},
    overlap_response::OverlapHistory,
    surfaces::{Bench, Owner},
};
use crate::Vec3;
use crate::bodies::body_arrays::BLOCK;
use crate::bodies::body_arrays::SPHERE;
use crate::bodies::body_arrays::{Bodies, Mobility, Wrench};
use crate::bodies::placed_parts::PlacedPart;
use crate::bodies::slider::Along;
use crate::contact::material_laws::Laws;
use crate::contact::plane_walls::WallLaws;
use crate::forces::pair_forces::ContactContext;
use crate::math::tally::Tally;
use crate::neighbours::neighbour_list_build::SolidPair;
use crate::walls::contact_rows::ContactRows;
use crate::walls::part_contacts::WallId;
use serde::{Deserialize, Serialize};
use tremie_grains_kit::neighbours::size_classes::Skins;
use tremie_grains_kit::space::periodic::PeriodicBox;
use tremie_grains_kit::space::plane_walls::Wall;
use tremie_grains_kit::space::solid_part::SolidPart;
use tremie_grains_kit::space::wall_triangle::distance;
use tremie_team::{Cut, Team};

/// Entries that are one item of work.
const TOGETHER: usize = 8;

/// Memory of a pair with at least one polyhedron, in the list before and in that which is used
/// [bytes].
pub(crate) const OF_PAIR: usize = 2 * (size_of::<SolidPairEntry>() + size_of::<OverlapHistory>())
    + 2 * size_of::<SolidPair>()
    + 4 * size_of::<u32>();

/// The list.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(crate) struct PolyContacts {
    entries: Vec<SolidPairEntry>,
    memories: Vec<OverlapHistory>,
    /// Bounds of each item of work in the histories.
    memory_bounds: Vec<u32>,
    /// Walls and parts near polyhedra, in the order of entries, and where those of each item of
    /// work begin.
    owners: Vec<Owner>,
    owner_bounds: Vec<u32>,
    triangles: Vec<(u32, u32)>,
    /// Most walls and parts, and most triangles, near one.
    most: (usize, usize),
    /// The entries of each body: twice the entry, and one more where the body is the other.
    pub rows: ContactRows<u32>,
    tallies: Vec<Tally>,
    #[serde(skip)]
    benches: Vec<Bench>,
    #[serde(skip)]
    before: Vec<SolidPairEntry>,
    #[serde(skip)]
    memories_before: Vec<OverlapHistory>,
    near: Vec<u32>,
}

/// Input of the search for contacts of polyhedra.
pub(crate) struct SolidSearch<'a> {
    pub walls: &'a [Wall],
    pub wall_laws: &'a WallLaws,
    pub parts: &'a [PlacedPart],
    pub part_materials: &'a [u16],
    pub laws: &'a Laws,
    pub bounds: &'a PeriodicBox,
    /// Skins of the classes of sizes: contacts are listed within these gaps.
    pub skins: &'a Skins,
}

impl PolyContacts {
    /// Makes the list anew; contacts that it knew keep their history and their loads.
    pub fn make(
        &mut self,
        pairs: impl Iterator<Item = SolidPair>,
        polyhedra: &mut Polyhedra,
        bodies: &Bodies,
        at: &SolidSearch<'_>,
    ) {
        self.rows.on.bounds.clear();
        self.rows.on.bounds.resize(bodies.len().div_ceil(BLOCK) + 1, 0);
        if polyhedra.is_empty() {
            return;
        }
        polyhedra.find_slots(bodies);
        std::mem::swap(&mut self.entries, &mut self.before);
        std::mem::swap(&mut self.memories, &mut self.memories_before);
        self.entries.clear();
        self.owners.clear();
        self.triangles.clear();
        self.most = (0, 0);
        self.entries.extend(pairs.map(|found| of_pair(found, polyhedra, bodies, at.laws)));
        for grain in 0..polyhedra.len() {
            self.surfaces(grain, polyhedra, bodies, at);
        }
        self.entries.sort_unstable_by_key(|entry| entry.key);
        self.inherit();
        self.distribute();
        self.gather(polyhedra, bodies);
    }

    /// Lists walls and parts near a polyhedron.
    fn surfaces(
        &mut self,
        grain: usize,
        polyhedra: &Polyhedra,
        bodies: &Bodies,
        at: &SolidSearch<'_>,
    ) {
        let (id, slot) = (polyhedra.grains()[grain].id, polyhedra.grains()[grain].slot);
        let (i, ball) = (slot as usize, bodies.balls[slot as usize]);
        let mobility = bodies.mobility[i];
        if !mobility.is_free() {
            return;
        }
        let gap = at.skins.gap(ball.radius);
        let shape = polyhedra.shape_of(grain);
        let size = polyhedra.grains()[grain].size;
        let begin = (self.owners.len(), self.triangles.len());
        for (number, wall) in (0..).zip(at.walls) {
            if wall.overlap(&ball) > -gap {
                self.owners.push(Owner {
                    met: WallId::Wall(number),
                    // Parts come before walls.
                    rank: at.parts.len() as u32 + number,
                    law: at.wall_laws[number as usize][bodies.material[i] as usize],
                    root_mass: mobility.root_reduced_mass(Mobility::NONE),
                    near: [0; 2],
                    load: Wrench::zero(),
                });
            }
        }
        for (number, part) in (0..).zip(at.parts) {
            let first = self.triangles.len() as u32;
            let reach = ball.radius + gap;
            for (image, shift) in at.bounds.numbered_images().filter(|(_, s)| part.is_seen(*s)) {
                let x = part.shape.to_part(ball.x + shift);
                part.shape.triangles_near(x, reach, &mut self.near);
                let near = |t: &&u32| distance(x, part.shape.triangle(**t).corners) < reach;
                let near = self.near.iter().filter(near);
                self.triangles.extend(near.map(|&triangle| (triangle, image)));
            }
            let near = [first, self.triangles.len() as u32];
            if near[0] < near[1] {
                self.owners.push(Owner {
                    met: WallId::Part(number),
                    rank: part.rank,
                    law: at.laws.between(at.part_materials[number as usize], bodies.material[i]),
                    root_mass: mobility.root_reduced_mass(part.mobility()),
                    near,
                    load: Wrench::zero(),
                });
            }
        }
        let (owners, triangles) = (self.owners.len() - begin.0, self.triangles.len() - begin.1);
        self.most = (self.most.0.max(owners), self.most.1.max(triangles));
        if owners > 0 {
            self.entries.push(SolidPairEntry {
                key: (id, SolidPairKind::Surfaces, 0),
                places: [slot, 0],
                image: 0,
                law: 0,
                root_mass: 0.0,
                area: shape.largest_face * size * size,
                owners: owners as u32,
                touching: 0,
                loads: [Wrench::zero(); 2],
            });
        }
    }

    /// Gives entries the histories of the list before.
    fn inherit(&mut self) {
        self.memories.clear();
        self.memory_bounds.clear();
        self.owner_bounds.clear();
        let (mut from, mut owners) = (0, 0);
        let mut old = self.before.iter().peekable();
        for (number, entry) in self.entries.iter_mut().enumerate() {
            if number.is_multiple_of(TOGETHER) {
                self.memory_bounds.push(self.memories.len() as u32);
                self.owner_bounds.push(owners);
            }
            owners += entry.owners;
            while let Some(before) = old.next_if(|before| before.key < entry.key) {
                from += before.memories();
            }
            let count = entry.memories();
            match old.peek() {
                Some(before) if before.key == entry.key => {
                    entry.touching = before.touching;
                    entry.loads = before.loads;
                    self.memories.extend(&self.memories_before[from..from + count]);
                }
                _ => self.memories.resize(self.memories.len() + count, OverlapHistory::NONE),
            }
        }
        self.memory_bounds.push(self.memories.len() as u32);
        self.owner_bounds.push(owners);
    }

    /// Tells which entries belong to which body.
    fn distribute(&mut self) {
        let of_both =
            |entry: &SolidPairEntry| if entry.key.1 == SolidPairKind::Body { 2 } else { 1 };
        let ContactRows { on, start, entries: places, .. } = &mut self.rows;
        on.bodies.clear();
        for entry in &self.entries {
            on.bodies.extend(&entry.places[..of_both(entry)]);
        }
        on.bodies.sort_unstable();
        on.bodies.dedup();
        let place = |slot: u32| on.bodies.partition_point(|&b| b < slot);
        start.clear();
        start.resize(on.bodies.len() + 1, 0);
        for entry in &self.entries {
            for &slot in &entry.places[..of_both(entry)] {
                start[place(slot) + 1] += 1;
            }
        }
        for p in 0..on.bodies.len() {
            start[p + 1] += start[p];
        }
        places.clear();
        places.resize(start[on.bodies.len()] as usize, 0);
        for (number, entry) in (0..).zip(&self.entries) {
            for (side, &slot) in (0..).zip(&entry.places[..of_both(entry)]) {
                let p = place(slot);
                places[start[p] as usize] = 2 * number + side;
                start[p] += 1;
            }
        }
        // Each start has moved on to the next one's.
        start.rotate_right(1);
        start[0] = 0;
        on.set_forces(|_| Wrench::zero());
        on.give_bounds();
    }

    /// Adds up the loads on each body, in the order of the others' ids.
    fn gather(&mut self, polyhedra: &mut Polyhedra, bodies: &Bodies) {
        for p in 0..self.rows.on.bodies.len() {
            let (slot, mut sum) = (self.rows.on.bodies[p], Wrench::zero());
            for &place in self.rows.row(p) {
                let load = &self.entries[place as usize / 2].loads[place as usize % 2];
                sum.force += load.force;
                sum.torque += load.torque;
            }
            let sum = polyhedra.felt(sum);
            self.rows.on.wrench[p] = sum;
            let grain = bodies.poly[slot as usize];
            if grain != SPHERE {
                polyhedra.grains[grain as usize].torque = sum.torque;
            }
        }
    }

    /// Evaluates the contacts, and adds the loads on parts to those that spheres brought.
    pub fn evaluate(
        &mut self,
        team: &mut Team,
        polyhedra: &mut Polyhedra,
        scenery: ContactContext<'_>,
        (walls, parts): (&[Wall], &[PlacedPart]),
        (on_parts, pushes): (&mut [Wrench], &mut [Along]),
    ) -> Tally {
        if polyhedra.is_empty() {
            return Tally::default();
        }
        self.benches.resize_with(team.threads(), Bench::default);
        // Room for the largest entry, so that no thread allocates in a step.
        self.benches.iter_mut().for_each(|bench| bench.reserve(self.most.0, self.most.1));
        self.tallies.clear();
        self.tallies.resize(self.entries.len().div_ceil(TOGETHER), Tally::default());
        let around = Around { scenery, polyhedra, walls, parts, triangles: &self.triangles };
        let pieces = (
            Cut::every(&mut self.entries, TOGETHER),
            Cut::at(&mut self.memories, &self.memory_bounds),
            Cut::at(&mut self.owners, &self.owner_bounds),
            Cut::every(&mut self.tallies, 1),
        );
        type Arrays<'a> =
            (&'a mut [SolidPairEntry], &'a mut [OverlapHistory], &'a mut [Owner], &'a mut [Tally]);
        let work = |bench: &mut Bench, _, arrays: Arrays<'_>| {
            let (entries, mut memories, mut owners, tally) = arrays;
            for entry in entries {
                let (own, rest) = memories.split_at_mut(entry.memories());
                let (near, others) = owners.split_at_mut(entry.owners as usize);
                (memories, owners) = (rest, others);
                entry.evaluate(&around, (near, own), bench, &mut tally[0]);
            }
        };
        team.for_pieces_with(pieces, &mut self.benches, work);
        // In the order of entries: equal bits on any number of threads.
        for owner in &self.owners {
            let (WallId::Part(part), load) = (owner.met, &owner.load) else { continue };
            let part = part as usize;
            on_parts[part].force += load.force;
            on_parts[part].torque += load.torque;
            if let Some(slider) = parts[part].slider() {
                pushes[part].add(Along::of(load.force.dot(&slider.axis)));
            }
        }
        self.gather(polyhedra, scenery.bodies);
        Tally::sum(&self.tallies)
    }

    /// Adds the forces on walls, by their numbers.
    pub fn add_wall_forces(&self, sums: &mut [Vec3]) {
        for owner in &self.owners {
            if let WallId::Wall(wall) = owner.met {
                sums[wall as usize] += owner.load.force;
            }
        }
    }

    /// Energy in the springs of all contacts [J]: of parts as if each triangle had solid straight
    /// below it, which is exact away from edges.
    pub fn elastic_energy(
        &self,
        polyhedra: &Polyhedra,
        scenery: ContactContext<'_>,
        (walls, parts): (&[Wall], &[PlacedPart]),
    ) -> f64 {
        let around = Around { scenery, polyhedra, walls, parts, triangles: &self.triangles };
        let (mut energy, mut first, mut bench) = (0.0, (0, 0), Bench::default());
        for entry in &self.entries {
            let memories = &self.memories[first.0..first.0 + entry.memories()];
            let owners = &self.owners[first.1..first.1 + entry.owners as usize];
            first = (first.0 + memories.len(), first.1 + owners.len());
            if entry.touching > 0 {
                energy += entry.energy(&around, owners, &mut bench);
                let touching = &memories[..entry.touching as usize];
                energy += touching.iter().map(|memory| memory.energy).sum::<f64>();
            }
        }
        energy
    }
}

/// The entry of a pair of bodies, the smaller id first.
fn of_pair(
    (i, j, image): SolidPair,
    polyhedra: &Polyhedra,
    bodies: &Bodies,
    laws: &Laws,
) -> SolidPairEntry {
    let id = |slot: u32| bodies.id_at(slot as usize);
    // What is one image up for the one is one image down for the other.
    let (i, j, image) = if id(i) < id(j) { (i, j, image) } else { (j, i, 26 - image) };
    let area = |slot: u32| match bodies.poly[slot as usize] {
        SPHERE => f64::INFINITY,
        grain => {
            let size = polyhedra.grains()[grain as usize].size;
            polyhedra.shape_of(grain as usize).largest_face * size * size
        }
    };
    let (a, b) = (i as usize, j as usize);
    SolidPairEntry {
        key: (id(i), SolidPairKind::Body, id(j)),
        places: [i, j],
        image,
        law: laws.between(bodies.material[a], bodies.material[b]),
        root_mass: bodies.mobility[a].root_reduced_mass(bodies.mobility[b]),
        area: area(i).min(area(j)),
        owners: 0,
        touching: 0,
        loads: [Wrench::zero(); 2],
    }
}
