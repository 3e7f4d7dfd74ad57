//! Which bodies are near which triangles of parts.

use crate::{
    Vec3,
    bodies::Bodies,
    law::Reduced,
    laws::Laws,
    mesh_contact::{Looked, distance},
    pairs::BLOCK,
    part_contacts::{Entry, PartContacts},
    parts::PlacedPart,
    periodic::PeriodicBox,
    polyhedra::SPHERE,
    skins::Skins,
};

/// Room for so many of what a block finds is there from the beginning.
pub(crate) const SOME: usize = 128;

/// What one block of bodies found.
#[derive(Debug, Default)]
pub(crate) struct Found {
    pub bodies: Vec<u32>,
    /// Number of entries at the end of each body's row.
    pub ends: Vec<u32>,
    pub entries: Vec<Entry>,
    /// Number of triangles at the end of each entry.
    pub near: Vec<u32>,
    pub triangles: Vec<(u32, u32)>,
    room: Vec<u32>,
}

/// What bodies may meet, as a list is made from it.
pub(crate) struct Nearness<'a> {
    pub parts: &'a [PlacedPart],
    pub laws: &'a Laws,
    /// Numbers of the parts' materials.
    pub materials: &'a [u16],
    pub bounds: &'a PeriodicBox,
    /// How far beyond touching contacts are listed.
    pub skins: &'a Skins,
    /// Where in memory each body stood when the list before was made.
    pub previous: &'a [u32],
}

impl Found {
    /// Finds the parts near the bodies of block `b`.
    pub fn find(&mut self, b: usize, before: &PartContacts, bodies: &Bodies, at: &Nearness) {
        self.bodies.clear();
        self.ends.clear();
        self.entries.clear();
        self.near.clear();
        self.triangles.clear();
        if !at.parts.is_empty() {
            // Short lists vary by large factors: what they may come to is there from the beginning.
            self.bodies.reserve(SOME);
            self.ends.reserve(SOME);
            self.entries.reserve(SOME);
            self.near.reserve(SOME);
            self.triangles.reserve(8 * SOME);
        }
        for i in b * BLOCK..bodies.len().min((b + 1) * BLOCK) {
            if !bodies.mobility[i].is_free() || bodies.poly[i] != SPHERE {
                continue;
            }
            let known = self.entries.len();
            for (part, placed) in at.parts.iter().enumerate() {
                let found = self.triangles.len();
                let ball = &bodies.balls[i];
                self.look(placed, ball.x, ball.radius + at.skins.gap(ball.radius), at.bounds);
                if self.triangles.len() == found {
                    continue;
                }
                let (touching, memories) =
                    before.remembered(at.previous[i], part as u32).unwrap_or_default();
                self.near.push(self.triangles.len() as u32);
                self.entries.push(Entry {
                    part: part as u32,
                    law: at.laws.between(at.materials[part], bodies.material[i]),
                    touching,
                    reduced: Reduced {
                        root_mass: bodies.mobility[i].root_reduced_mass(placed.mobility()),
                        radius: ball.radius,
                    },
                    memories,
                    looked: Looked::NEVER,
                });
            }
            if self.entries.len() > known {
                self.bodies.push(i as u32);
                self.ends.push(self.entries.len() as u32);
            }
        }
    }

    /// Adds the triangles of a part near a place, through all images.
    fn look(&mut self, part: &PlacedPart, x: Vec3, reach: f64, bounds: &PeriodicBox) {
        for (image, shift) in bounds.numbered_images() {
            let x = part.to_part(x + shift);
            part.triangles_near(x, reach, &mut self.room);
            // Long triangles have boxes that are near much that they are not.
            let near = |triangle: &&u32| distance(x, part.triangle(**triangle).corners) < reach;
            let near = self.room.iter().filter(near);
            self.triangles.extend(near.map(|&triangle| (triangle, image)));
        }
    }
}
