//! The order in which bodies stand in messages: by ids, which parts have between the spheres of the
//! start and spheres that came later.

use crate::bodies::body_arrays::Bodies;
use core::ops::Range;
use serde::{Deserialize, Serialize};

/// Place of moving parts in the order of bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct MessageOrder {
    /// Id of the first of them: the number of spheres at the start.
    pub first_part: u64,
    /// Number of moving parts.
    pub parts: usize,
    /// Living spheres with smaller ids.
    pub before: usize,
}

impl MessageOrder {
    /// At the start.
    pub fn new(spheres: usize, parts: usize) -> Self {
        Self { first_part: spheres as u64, parts, before: spheres }
    }

    /// Bodies came or went.
    pub fn count(&mut self, bodies: &Bodies) {
        self.before = bodies.ids.partition_point(|&id| id < self.first_part);
    }

    /// The first id that no body of the start has.
    pub fn first_free(&self) -> u64 {
        self.first_part + self.parts as u64
    }

    /// Number of bodies.
    pub fn bodies(&self, spheres: &Bodies) -> usize {
        spheres.len() + self.parts
    }

    /// Places of the parts.
    pub fn places_of_parts(&self) -> Range<usize> {
        self.before..self.before + self.parts
    }

    /// Place of a sphere by its rank.
    pub fn place(&self, rank: usize) -> usize {
        if rank < self.before { rank } else { rank + self.parts }
    }

    /// Rank of the sphere at a place; none of a part.
    pub fn rank(&self, place: usize) -> Option<usize> {
        if place < self.before {
            Some(place)
        } else {
            place.checked_sub(self.parts).filter(|&rank| rank >= self.before)
        }
    }

    /// Id of the body at a place.
    pub fn id(&self, place: usize, spheres: &Bodies) -> u64 {
        self.rank(place).map_or(self.first_part + (place - self.before.min(place)) as u64, |rank| {
            spheres.ids[rank]
        })
    }
}
