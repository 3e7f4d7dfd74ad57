//! Search for bodies near triangles of parts, and near walls that they may touch together with
//! these.

use crate::Vec3;
use crate::bodies::body_arrays::BLOCK;
use crate::bodies::body_arrays::SPHERE;
use crate::bodies::body_arrays::{Bodies, Mobility};
use crate::bodies::mesh_contact::LookedFrom;
use crate::bodies::placed_parts::PlacedPart;
use crate::contact::contact_history::{Remembered, WallContactHistory};
use crate::contact::material_laws::Laws;
use crate::contact::plane_walls::WallLaws;
use crate::contact::springs::Reduced;
use crate::walls::contact_rows::FoundRows;
use crate::walls::deformable_surfaces::Surfaces;
use crate::walls::part_contacts::{ListedWall, PartContacts, WallId};
use crate::walls::wall_contacts::{WallContacts, WallEntry};
use tremie_grains_kit::neighbours::size_classes::Skins;
use tremie_grains_kit::space::periodic::PeriodicBox;
use tremie_grains_kit::space::plane_walls::Wall;
use tremie_grains_kit::space::solid_part::SolidPart;
use tremie_grains_kit::space::wall_triangle::distance;

/// Room for so many of what a block finds is there from the beginning.
pub(crate) const SOME: usize = 128;

/// Entries found by one block of bodies.
#[derive(Debug, Default)]
pub(crate) struct FoundParts {
    pub rows: FoundRows<ListedWall>,
    pub histories: Vec<WallContactHistory>,
    /// Number of triangles at the end of each entry.
    pub near: Vec<u32>,
    pub triangles: Vec<(u32, u32)>,
    room: Vec<u32>,
}

/// Input of the search for parts and walls near bodies.
pub(crate) struct PartSearch<'a> {
    pub parts: &'a [PlacedPart],
    pub walls: &'a [Wall],
    pub wall_laws: &'a WallLaws,
    /// True if bodies near several walls are listed without a part too.
    pub walls_lean: bool,
    /// Surfaces that deform: bodies near them and near walls are listed also without a part.
    pub surfaces: &'a Surfaces,
    pub laws: &'a Laws,
    /// Numbers of the parts' materials.
    pub materials: &'a [u16],
    pub bounds: &'a PeriodicBox,
    /// Skins of the classes of sizes: contacts are listed within these gaps.
    pub skins: &'a Skins,
    /// Place of each body in memory when the list before was made.
    pub previous: &'a [u32],
}

impl PartSearch<'_> {
    /// True if any body may be listed.
    pub fn is_any(&self) -> bool {
        !self.parts.is_empty() || self.walls_lean || !self.surfaces.held.is_empty()
    }

    /// True if a body is near a surface that deforms, or may come near before the next list.
    fn is_near_surface(&self, body: usize, bodies: &Bodies) -> bool {
        let ball = &bodies.balls[body];
        // Surfaces have lists of their own, which may be newer.
        let reach = 2.0 * ball.radius + self.skins.gap(ball.radius);
        self.surfaces.held.iter().any(|held| held.is_near(ball.x, reach))
    }
}

impl FoundParts {
    /// Finds parts and walls near the bodies of block `b`.
    pub fn find(
        &mut self,
        b: usize,
        before: (&PartContacts, &WallContacts),
        bodies: &Bodies,
        at: &PartSearch,
    ) {
        self.clear();
        for i in b * BLOCK..bodies.len().min((b + 1) * BLOCK) {
            if !bodies.mobility[i].is_free() || bodies.poly[i] != SPHERE {
                continue;
            }
            let known = self.rows.entries.len();
            self.find_parts(i, bodies, at);
            let beside_parts = self.rows.entries.len() > known || at.is_near_surface(i, bodies);
            if beside_parts || at.walls_lean {
                self.find_walls(i, bodies, at);
            }
            // In corners of walls these do not share anything.
            let least = if beside_parts { 1 } else { 2 };
            if self.rows.entries.len() >= known + least {
                self.rows.end_row(i);
                self.histories.push(history(before, at.previous[i], at));
            } else {
                self.rows.entries.truncate(known);
                self.near.truncate(known);
            }
        }
    }

    fn clear(&mut self) {
        self.rows.clear();
        self.histories.clear();
        self.near.clear();
        self.triangles.clear();
        // Short lists vary by large factors: what they may come to is there from the beginning.
        self.rows.reserve(SOME);
        self.histories.reserve(SOME);
        self.near.reserve(SOME);
        self.triangles.reserve(8 * SOME);
    }

    fn find_parts(&mut self, i: usize, bodies: &Bodies, at: &PartSearch) {
        for (part, placed) in at.parts.iter().enumerate() {
            let found = self.triangles.len();
            let ball = &bodies.balls[i];
            self.look(placed, ball.x, ball.radius + at.skins.gap(ball.radius), at.bounds);
            if self.triangles.len() > found {
                let law = at.laws.between(at.materials[part], bodies.material[i]);
                let reduced = reduced(bodies, i, placed.mobility());
                self.enter(WallId::Part(part as u32), law, reduced);
            }
        }
    }

    fn find_walls(&mut self, i: usize, bodies: &Bodies, at: &PartSearch) {
        let ball = &bodies.balls[i];
        for (wall, plane) in at.walls.iter().enumerate() {
            if !plane.mirror && plane.overlap(ball) > -at.skins.gap(ball.radius) {
                let law = at.wall_laws[wall][bodies.material[i] as usize];
                self.enter(WallId::Wall(wall as u32), law, reduced(bodies, i, Mobility::NONE));
            }
        }
    }

    fn enter(&mut self, met: WallId, law: u16, reduced: Reduced) {
        self.near.push(self.triangles.len() as u32);
        self.rows.entries.push(ListedWall {
            met,
            law,
            reduced,
            looked: LookedFrom::NEVER,
            on_wall: Vec3::zeros(),
        });
    }

    /// Adds the triangles of a part near a place, through all images.
    fn look(&mut self, part: &PlacedPart, x: Vec3, reach: f64, bounds: &PeriodicBox) {
        for (image, shift) in bounds.numbered_images().filter(|(_, shift)| part.is_seen(*shift)) {
            let x = part.shape.to_part(x + shift);
            part.shape.triangles_near(x, reach, &mut self.room);
            // Long triangles have boxes that are near much that they are not.
            let near =
                |triangle: &&u32| distance(x, part.shape.triangle(**triangle).corners) < reach;
            let near = self.room.iter().filter(near);
            self.triangles.extend(near.map(|&triangle| (triangle, image)));
        }
    }
}

/// A body with a wall or a part of a mobility. Also with a slider it is the body's mass that counts
/// as the mean one.
fn reduced(bodies: &Bodies, i: usize, other: Mobility) -> Reduced {
    let own = bodies.mobility[i];
    Reduced {
        root_mass: own.root_reduced_mass(other),
        radius: bodies.balls[i].radius,
        mean_mass: own.mean_mass(Mobility::NONE),
    }
}

/// History of the contacts of a body, by its place in memory, at their last evaluation.
fn history(
    (parts, walls): (&PartContacts, &WallContacts),
    body: u32,
    at: &PartSearch<'_>,
) -> WallContactHistory {
    let mut history = parts.history(body).copied().unwrap_or(WallContactHistory::NONE);
    for entry in walls.rows.of(body).iter().filter(|entry| entry.touching) {
        if !at.walls[entry.wall as usize].mirror {
            let WallEntry { memory, law, reduced, .. } = *entry;
            history.add(Remembered { memory, share: 1.0, law, reduced });
        }
    }
    history
}
