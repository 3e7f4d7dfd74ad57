//! Bodies near walls, with the history of each contact and the sum of the walls' forces. Bodies
//! near parts as well meet walls there, see [`PartContacts`], and here nothing but mirrors.

use crate::Vec3;
use crate::bodies::body_arrays::BLOCK;
use crate::bodies::body_arrays::SPHERE;
use crate::bodies::body_arrays::{Bodies, Mobility, Wrench};
use crate::contact::contact_force::ContactHistory;
use crate::contact::plane_walls::WallLaws;
use crate::contact::springs::Reduced;
use crate::walls::contact_rows::{ContactRows, FoundRows};
use crate::walls::part_contacts::PartContacts;
use serde::{Deserialize, Serialize};
use tremie_grains_kit::neighbours::size_classes::Skins;
use tremie_grains_kit::space::plane_walls::Wall;
use tremie_team::Team;

/// A possible contact with a wall.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct WallEntry {
    /// Index of the wall.
    pub wall: u32,
    /// Number of the law.
    pub law: u16,
    /// True if the body touched at the last evaluation.
    pub touching: bool,
    /// Mass and radius: the body's.
    pub reduced: Reduced,
    /// History, meaningful while touching.
    pub memory: ContactHistory,
    /// Force on the wall at the last evaluation [N].
    pub force: Vec3,
}

/// The possible contacts of bodies near walls, by body and wall.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct WallContacts {
    pub rows: ContactRows<WallEntry>,
}

/// Walls found by one block of bodies.
pub(crate) type FoundWalls = FoundRows<WallEntry>;

/// Input of the search for walls near bodies.
pub(crate) struct WallSearch<'a> {
    pub walls: &'a [Wall],
    pub laws: &'a WallLaws,
    /// Skins of the classes of sizes: contacts are listed within these gaps.
    pub skins: &'a Skins,
    /// Place of each body in memory when the list before was made.
    pub previous: &'a [u32],
}

impl WallContacts {
    /// Makes the list anew. `before` are the list and that of parts before, `parts` is the new one
    /// of these; `found` is room to work in.
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
        team.for_each(found, |b, found| find(found, b, lists, bodies, at));
        self.rows.clear();
        found.iter().for_each(|found| self.rows.append(found));
        self.rows.on.set_forces(|&body| {
            if parts.has(body) {
                // There its forces are.
                return Wrench::zero();
            }
            let place = at.previous[body as usize];
            let walls = before.rows.on.force_on(place);
            let parts = parts_before.rows.on.force_on(place);
            Wrench { force: walls.force + parts.force, torque: walls.torque + parts.torque }
        });
    }

    /// Adds the forces on walls, by their numbers.
    pub fn add_forces(&self, sums: &mut [Vec3]) {
        for entry in &self.rows.entries {
            sums[entry.wall as usize] += entry.force;
        }
    }

    /// History of the contact of a body, by its place in memory, with a wall; `None` if they did
    /// not touch.
    fn remembered(&self, body: u32, wall: u32) -> Option<ContactHistory> {
        self.rows
            .of(body)
            .iter()
            .find(|entry| entry.wall == wall && entry.touching)
            .map(|entry| entry.memory)
    }
}

/// Finds the walls near the bodies of block `b`.
fn find(
    found: &mut FoundWalls,
    b: usize,
    (before, parts_before, parts): (&WallContacts, &PartContacts, &PartContacts),
    bodies: &Bodies,
    at: &WallSearch,
) {
    found.clear();
    for i in b * BLOCK..bodies.len().min((b + 1) * BLOCK) {
        let (ball, mobility) = (&bodies.balls[i], bodies.mobility[i]);
        if !mobility.is_free() || bodies.poly[i] != SPHERE {
            continue;
        }
        let (known, place) = (found.entries.len(), at.previous[i]);
        let gap = at.skins.gap(ball.radius);
        // A body near a part meets its walls in the list of parts. Mirrors are never in that list.
        let elsewhere = parts.has(i as u32);
        for (wall, plane) in at.walls.iter().enumerate() {
            if plane.overlap(ball) <= -gap || (elsewhere && !plane.mirror) {
                continue;
            }
            let remembered = before.remembered(place, wall as u32);
            // The body may have been in the list of parts before.
            let of_parts = || parts_before.of_wall(place, plane).filter(|_| !plane.mirror);
            let remembered = remembered.or_else(of_parts);
            found.entries.push(WallEntry {
                wall: wall as u32,
                law: at.laws[wall][bodies.material[i] as usize],
                touching: remembered.is_some(),
                reduced: Reduced {
                    root_mass: mobility.root_reduced_mass(Mobility::NONE),
                    radius: ball.radius,
                    mean_mass: mobility.mean_mass(Mobility::NONE),
                },
                memory: remembered.unwrap_or_default(),
                force: Vec3::zeros(),
            });
        }
        if found.entries.len() > known {
            found.end_row(i);
        }
    }
}
