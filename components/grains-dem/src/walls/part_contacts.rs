//! Bodies near parts, and near walls beside these, with the history of each contact and the sum of
//! the parts' forces.
//!
//! All that a body meets here is looked at together, so that walls that are cut into several parts,
//! or into parts and faces of the domain, are one. Bodies that meet nothing but walls in corners,
//! and mirrors, are with [`WallContacts`].

use crate::Vec3;
use crate::bodies::body_arrays::BLOCK;
use crate::bodies::body_arrays::{Bodies, Wrench};
use crate::bodies::mesh_contact::{LookedFrom, SAME};
use crate::bodies::placed_parts::PlacedPart;
use crate::bodies::slider::Along;
use crate::contact::contact_force::ContactHistory;
use crate::contact::contact_history::WallContactHistory;
use crate::contact::contact_law::Law;
use crate::contact::springs::Reduced;
use crate::forces::pair_forces::ContactContext;
use crate::math::tally::Tally;
use crate::walls::contact_rows::ContactRows;
use crate::walls::deformable_surfaces::Surfaces;
use crate::walls::part_finder::{FoundParts, PartSearch, SOME};
use crate::walls::part_forces::{NearWalls, SphereAtWalls};
use crate::walls::reached_walls::Reached;
use crate::walls::wall_contacts::WallContacts;
use serde::{Deserialize, Serialize};
use tremie_grains_kit::space::plane_walls::Wall;
use tremie_team::{Cut, Team};

/// Part or wall near a body, by number.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum WallId {
    Part(u32),
    Wall(u32),
}

/// A body near a part or a wall.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct ListedWall {
    pub met: WallId,
    pub law: u16,
    /// Reduced mass, that of a head-on collision along the axis of a slider; the body's radius.
    pub reduced: Reduced,
    /// State of the body, in the frame of the part, at its last search of all triangles near it.
    pub looked: LookedFrom,
    /// Force on a wall at the last evaluation [N].
    pub on_wall: Vec3,
}

/// Rows of entries, one for each body here, in the order of memory.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct PartContacts {
    pub rows: ContactRows<ListedWall>,
    histories: Vec<WallContactHistory>,
    /// `near[e]..near[e + 1]` are the triangles of entry e, with the images that see them.
    near: Vec<u32>,
    triangles: Vec<(u32, u32)>,
    /// Distance of each triangle at the body's last full search [m].
    distances: Vec<f32>,
    triangle_bounds: Vec<u32>,
    /// Forces on the parts and torques about their reference points, at the last evaluation.
    pub on_parts: Vec<Wrench>,
    /// Forces along the axes of sliders, by part; others have none.
    pub pushes: Vec<Along>,
    /// Both block by block.
    loads: Vec<PartLoad>,
    /// True if virials are ever asked for.
    is_measurable: bool,
    /// True if the next evaluation is to find the virials.
    pub is_measured: bool,
    /// Contacts of each body here and their virial at the last evaluation that was measured, where
    /// any is.
    pub virials: Vec<WallVirial>,
    /// Bounds of no virials.
    unmeasured: Vec<u32>,
}

/// Contacts of a body with parts and walls.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct WallVirial {
    /// Number of contacts, those of one region counted once.
    pub contacts: u32,
    /// See [`GrainSample::virial`](tremie_grains_kit::profiles::GrainSample::virial) [J].
    pub virial: [f64; 6],
}

/// Load on a part, and along its axis, if it is a slider.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct PartLoad {
    pub wrench: Wrench,
    pub push: Along,
}

impl PartContacts {
    /// Makes the list anew from those before; `found` is room to work in.
    pub fn make(
        &mut self,
        (before, walls): (&Self, &WallContacts),
        found: &mut Vec<FoundParts>,
        team: &mut Team,
        bodies: &Bodies,
        at: &PartSearch,
    ) {
        self.clear();
        found.resize_with(bodies.len().div_ceil(BLOCK), FoundParts::default);
        if at.is_any() {
            self.rows.on.bodies.reserve(SOME);
            self.rows.on.wrench.reserve(SOME);
            self.rows.start.reserve(SOME);
            self.rows.entries.reserve(SOME);
            self.histories.reserve(SOME);
            self.near.reserve(SOME);
            self.triangles.reserve(8 * SOME);
            team.for_each(found, |b, found| found.find(b, (before, walls), bodies, at));
            for found in found {
                let triangles = self.triangles.len() as u32;
                self.histories.extend(&found.histories);
                self.near.extend(found.near.iter().map(|end| triangles + end));
                self.triangles.extend(&found.triangles);
                self.triangle_bounds.push(self.triangles.len() as u32);
                self.rows.append(&found.rows);
            }
        } else {
            for _ in found {
                self.triangle_bounds.push(0);
                self.rows.end_block();
            }
        }
        self.distances.clear();
        self.distances.resize(self.triangles.len(), 0.0);
        // A body may have been in the list of parts before, in that of walls, or in both.
        self.rows.on.set_forces(|&body| {
            let place = at.previous[body as usize];
            let (parts, walls) = (before.rows.on.force_on(place), walls.rows.on.force_on(place));
            Wrench { force: parts.force + walls.force, torque: parts.torque + walls.torque }
        });
        self.on_parts.clear();
        self.on_parts.extend(&before.on_parts);
        self.pushes.clear();
        self.pushes.extend(&before.pushes);
        self.on_parts.resize(at.parts.len(), Wrench::zero());
        self.pushes.resize(at.parts.len(), Along::default());
        self.measure(self.is_measurable);
        let blocks = self.rows.on.bounds.len() - 1;
        self.loads.resize(blocks * loads_of(at.parts), PartLoad::NONE);
    }

    fn clear(&mut self) {
        self.rows.clear();
        self.histories.clear();
        self.near.clear();
        self.near.push(0);
        self.triangles.clear();
        self.triangle_bounds.clear();
        self.triangle_bounds.push(0);
    }

    /// Says whether virials are ever asked for, and makes room for those of the bodies listed.
    pub fn measure(&mut self, is_measurable: bool) {
        self.is_measurable = is_measurable;
        self.virials.clear();
        if is_measurable {
            self.virials.reserve(SOME);
            self.virials.resize(self.rows.on.bodies.len(), WallVirial::default());
        }
        self.unmeasured.resize(self.rows.on.bounds.len(), 0);
    }

    /// True if a body, by its place in memory, is in this list.
    pub fn has(&self, body: u32) -> bool {
        self.rows.on.place(body).is_some()
    }

    /// The contacts of a body, by its place in memory.
    pub fn history(&self, body: u32) -> Option<&WallContactHistory> {
        self.rows.on.place(body).map(|p| &self.histories[p])
    }

    /// History of the contact of a body, by its place in memory, with a wall; `None` if they did
    /// not touch.
    pub fn of_wall(&self, body: u32, wall: &Wall) -> Option<ContactHistory> {
        let memory = self.history(body)?.heir(-wall.normal)?;
        (memory.normal.dot(&-wall.normal) > SAME).then_some(memory)
    }

    /// Finds the reach of a body, by its place in memory, into parts and walls.
    pub fn reach(
        &mut self,
        body: u32,
        (parts, walls): (&[PlacedPart], &[Wall]),
        scenery: &ContactContext<'_>,
        reached: &mut Reached,
    ) {
        reached.clear();
        let Some(p) = self.rows.on.place(body) else { return };
        let own = self.rows.range(p);
        let of_row = self.near[own.start] as usize..self.near[own.end] as usize;
        let mut near = NearWalls {
            ends: &self.near[own.start..=own.end],
            entries: &mut self.rows.entries[own],
            distances: &mut self.distances[of_row.clone()],
            triangles: &self.triangles[of_row],
        };
        SphereAtWalls { body: body as usize, parts, walls, scenery }.reach(&mut near, reached);
        reached.history = self.histories[p];
    }

    /// Evaluates the contacts, each body's together with what `surfaces` found that it reaches of
    /// them; adds the contacts of each block to `tallies`, and sums the forces on the parts.
    pub fn evaluate(
        &mut self,
        team: &mut Team,
        (parts, walls): (&[PlacedPart], &[Wall]),
        surfaces: &Surfaces,
        scenery: ContactContext<'_>,
        tallies: &mut [Tally],
    ) {
        if tallies.is_empty() || (parts.is_empty() && self.rows.on.bodies.is_empty()) {
            return;
        }
        let pieces = (
            Cut::at(&mut self.rows.entries, &self.rows.entry_bounds),
            Cut::at(&mut self.distances, &self.triangle_bounds),
            Cut::at(&mut self.histories, &self.rows.on.bounds),
            Cut::at(&mut self.rows.on.wrench, &self.rows.on.bounds),
            Cut::every(&mut self.loads, loads_of(parts)),
            Cut::every(tallies, 1),
            match self.is_measured {
                true => Cut::at(&mut self.virials, &self.rows.on.bounds),
                false => Cut::at(&mut self.virials, &self.unmeasured),
            },
        );
        let (bodies, bounds) = (&self.rows.on.bodies, &self.rows.on.bounds);
        let (start, first) = (&self.rows.start, &self.rows.entry_bounds);
        let (near, triangles) = (&self.near, &self.triangles);
        let of_block = &self.triangle_bounds;
        team.for_pieces(pieces, |b, piece| {
            let (entries, distances, histories, wrench, loads, tally, virials) = piece;
            let mut virials = virials.iter_mut();
            loads.fill(PartLoad::NONE);
            let rows = (bounds[b] as usize..).zip(wrench).zip(histories);
            for ((p, wrench), history) in rows {
                let own = start[p] as usize..start[p + 1] as usize;
                let of_row = near[own.start] as usize..near[own.end] as usize;
                let (entry, begin) = (first[b] as usize, of_block[b] as usize);
                let near = NearWalls {
                    entries: &mut entries[own.start - entry..own.end - entry],
                    ends: &near[own.start..=own.end],
                    distances: &mut distances[of_row.start - begin..of_row.end - begin],
                    triangles: &triangles[of_row],
                };
                let body = bodies[p] as usize;
                let place = SphereAtWalls { body, parts, walls, scenery: &scenery };
                let soft = surfaces.reached_by(bodies[p]);
                let sums = (&mut *loads, &mut tally[0], virials.next());
                *wrench = place.evaluate(near, soft, history, sums);
            }
        });
        self.sum_blocks(loads_of(parts));
    }

    fn sum_blocks(&mut self, parts: usize) {
        self.on_parts.fill(Wrench::zero());
        self.pushes.fill(Along::default());
        for block in self.loads.chunks(parts) {
            for ((sum, push), load) in self.on_parts.iter_mut().zip(&mut self.pushes).zip(block) {
                sum.force += load.wrench.force;
                sum.torque += load.wrench.torque;
                push.add(load.push);
            }
        }
    }

    /// Adds the forces on walls, by their numbers.
    pub fn add_wall_forces(&self, sums: &mut [Vec3]) {
        for entry in &self.rows.entries {
            if let WallId::Wall(wall) = entry.met {
                sums[wall as usize] += entry.on_wall;
            }
        }
    }

    /// Energy in the springs of the contacts of a body, by its place in this list [J].
    pub fn elastic_energy(&self, p: usize, laws: &[Law]) -> f64 {
        self.histories[p].elastic_energy(laws)
    }
}

impl PartLoad {
    const NONE: Self = Self {
        wrench: Wrench { force: Vec3::new(0.0, 0.0, 0.0), torque: Vec3::new(0.0, 0.0, 0.0) },
        push: Along::NONE,
    };
}

/// Loads of a block: one for each part, and one where there is none.
fn loads_of(parts: &[PlacedPart]) -> usize {
    parts.len().max(1)
}
