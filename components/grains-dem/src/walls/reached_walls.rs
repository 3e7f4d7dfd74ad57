//! Reach of a sphere into rigid walls and into surfaces that deform, each for the use of the other.
//!
//! Contacts with rigid walls are evaluated with [`crate::walls::part_contacts`], those with
//! surfaces that deform with [`crate::walls::surface_contacts`], at shapes that are only tried as
//! well. A wall is one wall also where rubber stands flush with metal: so where a sphere reaches
//! both, either side looks at the points of both together, finds which of these are contacts and
//! how much each counts, and evaluates its own.

use crate::bodies::mesh_contact::{MOST, ReachedPoints, WallPoint, WallPoints};
use crate::contact::contact_history::WallContactHistory;
use crate::contact::contact_law::Law;
use crate::contact::region_shares::shares;
use crate::contact::springs::Reduced;

/// Owners from this one on are surfaces that deform, by number; those before it are rigid.
const SOFT: u32 = 1 << 31;

/// A point of a wall within reach, and the law of a contact there.
#[derive(Clone, Copy, Debug)]
struct ReachedPoint {
    near: WallPoint,
    law: u16,
    reduced: Reduced,
}

/// The points that a sphere reaches, which is their origin; and what its contacts with their walls
/// remember.
#[derive(Clone, Debug)]
pub(crate) struct Reached {
    points: [ReachedPoint; MOST],
    count: usize,
    pub history: WallContactHistory,
}

/// A point of the surface that deforms of a number.
pub(crate) fn of_surface(near: WallPoint, surface: usize) -> WallPoint {
    WallPoint { owner: SOFT + surface as u32, rank: SOFT, ..near }
}

/// True if a point belongs to a surface that deforms.
pub(crate) fn is_soft(near: &WallPoint) -> bool {
    near.owner >= SOFT
}

impl Reached {
    pub const NONE: Self = Self {
        points: [ReachedPoint { near: WallPoint::NONE, law: 0, reduced: Reduced::NONE }; MOST],
        count: 0,
        history: WallContactHistory::NONE,
    };

    fn points(&self) -> &[ReachedPoint] {
        &self.points[..self.count]
    }

    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.count = 0;
        self.history.clear();
    }

    /// Adds a point with the law of its contact, as long as there is room: for so many as are ever
    /// found.
    pub fn add(&mut self, near: WallPoint, (law, reduced): (u16, Reduced)) {
        if let Some(place) = self.points.get_mut(self.count) {
            *place = ReachedPoint { near, law, reduced };
            self.count += 1;
        }
    }
}

/// Contacts of a sphere with rigid walls and surfaces that deform, and the share of each spring.
pub(crate) fn together(
    rigid: &Reached,
    soft: &Reached,
    radius: f64,
    laws: &[Law],
) -> (WallPoints, [f64; MOST]) {
    let points = || rigid.points().iter().chain(soft.points());
    let mut candidates = ReachedPoints::NONE;
    points().for_each(|point| candidates.take(point.near));
    let found = candidates.contacts(radius);
    let shares = shares(found.contacts(), |contact| {
        let overlap = radius - contact.distance;
        let point = points().find(|point| point.near.owner == contact.owner);
        point.map_or(0.0, |ReachedPoint { law, reduced, .. }| {
            laws[usize::from(*law)].normal_root(overlap, *reduced)
        })
    });
    (found, shares)
}
