//! Bodies near walls, with what each contact remembers and the sum of the walls' forces.

use crate::{
    bodies::{Bodies, Mobility, Wrench},
    contact::Memory,
    law::Reduced,
    pairs::BLOCK,
    walls::{Wall, WallLaws},
};

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
    pub memory: Memory,
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

impl WallContacts {
    /// Makes the list anew from bodies closer than `gap` to a wall. `before` is the list before, with
    /// bodies by their `previous` places.
    pub fn make(
        &mut self,
        before: &Self,
        previous: &[u32],
        bodies: &Bodies,
        walls: &[Wall],
        laws: &WallLaws,
        gap: f64,
    ) {
        self.clear();
        for i in 0..bodies.len() {
            if i.is_multiple_of(BLOCK) {
                self.end_block();
            }
            let (ball, mobility) = (&bodies.balls[i], bodies.mobility[i]);
            if !mobility.is_free() {
                continue;
            }
            for (wall, plane) in walls.iter().enumerate() {
                if plane.overlap(ball) > -gap {
                    let remembered = before.remembered(previous[i], wall as u32);
                    self.entries.push(WallEntry {
                        wall: wall as u32,
                        law: laws[wall][bodies.material[i] as usize],
                        touching: remembered.is_some(),
                        reduced: Reduced {
                            root_mass: mobility.root_reduced_mass(Mobility::NONE),
                            radius: ball.radius,
                        },
                        memory: remembered.unwrap_or_default(),
                    });
                }
            }
            if self.entries.len() > self.start[self.bodies.len()] as usize {
                self.bodies.push(i as u32);
                self.start.push(self.entries.len() as u32);
            }
        }
        self.end_block();
        self.wrench.resize(self.bodies.len(), Wrench::zero());
    }

    fn clear(&mut self) {
        self.bodies.clear();
        self.start.clear();
        self.start.push(0);
        self.entries.clear();
        self.bounds.clear();
        self.entry_bounds.clear();
    }

    fn end_block(&mut self) {
        self.bounds.push(self.bodies.len() as u32);
        self.entry_bounds.push(self.entries.len() as u32);
    }

    /// What the contact of a body, by its place in this list, with a wall remembers, if it touched.
    fn remembered(&self, body: u32, wall: u32) -> Option<Memory> {
        let p = self.bodies.binary_search(&body).ok()?;
        let row = &self.entries[self.start[p] as usize..self.start[p + 1] as usize];
        row.iter().find(|entry| entry.wall == wall && entry.touching).map(|entry| entry.memory)
    }
}
