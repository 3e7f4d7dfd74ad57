//! Bodies near walls, with what each contact remembers and the sum of the walls' forces. Bodies near parts as well meet
//! walls there, see [`PartContacts`], and here nothing but mirrors.

use crate::Vec3;
use crate::bodies::body_arrays::BLOCK;
use crate::bodies::body_arrays::SPHERE;
use crate::bodies::body_arrays::{Bodies, Mobility, Wrench};
use crate::contact::contact_force::ContactHistory;
use crate::contact::plane_walls::{Wall, WallLaws};
use crate::contact::springs::Reduced;
use crate::neighbours::size_classes::Skins;
use crate::walls::part_contacts::PartContacts;
use tremie_team::Team;

/// A possible contact with a wall.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WallEntry {
    /// Index of the wall.
    pub wall: u32,
    /// Number of the law.
    pub law: u16,
    /// Whether it touched at the last evaluation.
    pub touching: bool,
    /// Mass and radius: the body's.
    pub reduced: Reduced,
    /// History, meaningful while touching.
    pub memory: ContactHistory,
    /// Force on the wall at the last evaluation [N].
    pub force: Vec3,
}

/// Rows of entries, one for each body near a wall, in the order of memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct WallContacts {
    /// Indices of the bodies.
    pub bodies: Vec<u32>,
    /// `start[p]..start[p + 1]` are the entries of `bodies[p]`.
    pub start: Vec<u32>,
    /// The possible contacts, by body and wall.
    pub entries: Vec<WallEntry>,
    /// Sum of the walls' forces on each of `bodies`.
    pub wrench: Vec<Wrench>,
    /// Which of `bodies` belong to each block of bodies.
    pub bounds: Vec<u32>,
    /// Which entries do.
    pub entry_bounds: Vec<u32>,
}

/// What one block of bodies found.
#[derive(Debug, Default)]
pub(crate) struct FoundWalls {
    bodies: Vec<u32>,
    /// Number of entries at the end of each body's row.
    ends: Vec<u32>,
    entries: Vec<WallEntry>,
}

/// What bodies may meet, as a list is made from it.
pub(crate) struct WallSearch<'a> {
    pub walls: &'a [Wall],
    pub laws: &'a WallLaws,
    /// How far beyond touching contacts are listed.
    pub skins: &'a Skins,
    /// Where in memory each body stood when the list before was made.
    pub previous: &'a [u32],
}

impl WallContacts {
    /// Makes the list anew. `before` are the list and that of parts before, `parts` is the new one of these; `found` is
    /// room to work in.
    pub fn make(
        &mut self,
        (before, parts_before): (&Self, &PartContacts),
        parts: &PartContacts,
        found: &mut Vec<FoundWalls>,
        team: &mut Team,
        bodies: &Bodies,
        at: &WallSearch,
    ) {
        found.resize_with(bodies.len().div_ceil(BLOCK), FoundWalls::default);
        let lists = (before, parts_before, parts);
        team.for_each(found, |b, found| found.find(b, lists, bodies, at));
        self.clear();
        for found in found {
            let first = self.entries.len() as u32;
            self.bodies.extend(&found.bodies);
            self.start.extend(found.ends.iter().map(|end| first + end));
            self.entries.extend(&found.entries);
            self.end_block();
        }
        let previous = |&body: &u32| {
            if parts.has(body) {
                // There its forces are.
                return Wrench::zero();
            }
            let place = at.previous[body as usize];
            let (walls, parts) = (before.force_on(place), parts_before.force_on(place));
            Wrench { force: walls.force + parts.force, torque: walls.torque + parts.torque }
        };
        self.wrench.clear();
        self.wrench.extend(self.bodies.iter().map(previous));
    }

    /// The walls' force on a body, by its place in memory.
    pub fn force_on(&self, body: u32) -> Wrench {
        self.bodies.binary_search(&body).map_or(Wrench::zero(), |p| self.wrench[p])
    }

    /// Adds the forces on walls, by their numbers.
    pub fn add_forces(&self, sums: &mut [Vec3]) {
        for entry in &self.entries {
            sums[entry.wall as usize] += entry.force;
        }
    }

    fn clear(&mut self) {
        self.bodies.clear();
        self.start.clear();
        self.start.push(0);
        self.entries.clear();
        self.bounds.clear();
        self.entry_bounds.clear();
        self.end_block();
    }

    fn end_block(&mut self) {
        self.bounds.push(self.bodies.len() as u32);
        self.entry_bounds.push(self.entries.len() as u32);
    }

    /// The entries of a body, by its place in this list.
    pub fn row(&self, p: usize) -> &[WallEntry] {
        &self.entries[self.start[p] as usize..self.start[p + 1] as usize]
    }

    /// The entries of a body, by its place in memory.
    pub fn of(&self, body: u32) -> &[WallEntry] {
        self.bodies.binary_search(&body).map_or(&[], |p| self.row(p))
    }

    /// What the contact of a body, by its place in memory, with a wall remembers, if it touched.
    fn remembered(&self, body: u32, wall: u32) -> Option<ContactHistory> {
        self.of(body)
            .iter()
            .find(|entry| entry.wall == wall && entry.touching)
            .map(|entry| entry.memory)
    }
}

impl FoundWalls {
    /// Finds the walls near the bodies of block `b`.
    fn find(
        &mut self,
        b: usize,
        (before, parts_before, parts): (&WallContacts, &PartContacts, &PartContacts),
        bodies: &Bodies,
        at: &WallSearch,
    ) {
        self.bodies.clear();
        self.ends.clear();
        self.entries.clear();
        for i in b * BLOCK..bodies.len().min((b + 1) * BLOCK) {
            let (ball, mobility) = (&bodies.balls[i], bodies.mobility[i]);
            if !mobility.is_free() || bodies.poly[i] != SPHERE {
                continue;
            }
            let (known, place) = (self.entries.len(), at.previous[i]);
            let gap = at.skins.gap(ball.radius);
            let elsewhere = parts.has(i as u32);
            for (wall, plane) in at.walls.iter().enumerate() {
                if plane.overlap(ball) <= -gap || (elsewhere && !plane.mirror) {
                    continue;
                }
                let remembered = before.remembered(place, wall as u32);
                let of_parts = || parts_before.of_wall(place, plane).filter(|_| !plane.mirror);
                let remembered = remembered.or_else(of_parts);
                self.entries.push(WallEntry {
                    wall: wall as u32,
                    law: at.laws[wall][bodies.material[i] as usize],
                    touching: remembered.is_some(),
                    reduced: Reduced {
                        root_mass: mobility.root_reduced_mass(Mobility::NONE),
                        radius: ball.radius,
                    },
                    memory: remembered.unwrap_or_default(),
                    force: Vec3::zeros(),
                });
            }
            if self.entries.len() > known {
                self.bodies.push(i as u32);
                self.ends.push(self.entries.len() as u32);
            }
        }
    }
}
