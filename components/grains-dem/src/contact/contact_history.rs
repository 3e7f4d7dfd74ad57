//! History of a body's contacts with walls.

use crate::Vec3;
use crate::bodies::mesh_contact::MOST;
use crate::contact::contact_force::ContactHistory;
use crate::contact::contact_law::Law;
use crate::contact::region_shares::of_one_region;
use crate::contact::springs::Reduced;
use serde::{Deserialize, Serialize};

/// A contact at the last evaluation.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Remembered {
    pub memory: ContactHistory,
    /// Share of the contact that counts, see [`crate::contact::region_shares`].
    pub share: f64,
    pub law: u16,
    pub reduced: Reduced,
}

/// The contacts of a body at the last evaluation.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct WallContactHistory {
    list: [Remembered; MOST],
    count: usize,
}

impl WallContactHistory {
    pub const NONE: Self = Self {
        list: [Remembered {
            memory: ContactHistory {
                xi: Vec3::new(0.0, 0.0, 0.0),
                rolling: Vec3::new(0.0, 0.0, 0.0),
                normal: Vec3::new(0.0, 0.0, 0.0),
                overlap: 0.0,
            },
            share: 0.0,
            law: 0,
            reduced: Reduced::NONE,
        }; MOST],
        count: 0,
    };

    pub fn held(&self) -> &[Remembered] {
        &self.list[..self.count]
    }

    /// True if it holds no more than there is room for, under laws of which there are so many.
    pub fn is_sound(&self, laws: usize) -> bool {
        let held = self.list.get(..self.count);
        held.is_some_and(|held| held.iter().all(|one| usize::from(one.law) < laws))
    }

    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Adds a contact, as long as there is room: for so many as are ever found.
    pub fn add(&mut self, held: Remembered) {
        if let Some(place) = self.list.get_mut(self.count) {
            *place = held;
            self.count += 1;
        }
    }

    /// History that a contact with the normal `n` continues: that of the contact whose normal
    /// turned least, if both are of one region. Each of several faces of a region continues the
    /// history of all.
    pub fn heir(&self, n: Vec3) -> Option<ContactHistory> {
        let along = |held: &&Remembered| held.memory.normal.dot(&n);
        let best = self.held().iter().max_by(|a, b| along(a).total_cmp(&along(b)))?;
        of_one_region(best.memory.normal, n).then_some(best.memory)
    }

    /// Energy in the springs [J], tangential ones at the displacement that they will have half a
    /// step later.
    pub fn elastic_energy(&self, laws: &[Law]) -> f64 {
        let of = |held: &Remembered| {
            held.share * laws[held.law as usize].remembered_energy(&held.memory, held.reduced)
        };
        self.held().iter().map(of).sum()
    }
}
