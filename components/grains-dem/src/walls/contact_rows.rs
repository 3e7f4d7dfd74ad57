//! Contacts by rows: the bodies near something, in the order of memory, and the entries of each.

use crate::bodies::body_arrays::BLOCK;
use crate::bodies::body_arrays::Wrench;
use serde::{Deserialize, Serialize};

/// Bodies near something, with the sum of its forces on each.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct LoadedBodies {
    /// Indices of the bodies, ascending.
    pub bodies: Vec<u32>,
    /// Sum of the forces on each.
    pub wrench: Vec<Wrench>,
    /// Bounds of each block of bodies in `bodies`.
    pub bounds: Vec<u32>,
}

impl LoadedBodies {
    /// The place of a body in this list, by its place in memory.
    pub fn place(&self, body: u32) -> Option<usize> {
        self.bodies.binary_search(&body).ok()
    }

    /// The force on a body, by its place in memory.
    pub fn force_on(&self, body: u32) -> Wrench {
        self.place(body).map_or(Wrench::zero(), |p| self.wrench[p])
    }

    /// Gives each body a force to begin with.
    pub fn set_forces(&mut self, force: impl FnMut(&u32) -> Wrench) {
        self.wrench.clear();
        self.wrench.extend(self.bodies.iter().map(force));
    }

    /// Says which bodies belong to which block, of as many as there are bounds.
    pub fn give_bounds(&mut self) {
        for (b, bound) in self.bounds.iter_mut().enumerate() {
            let first = (b * BLOCK) as u32;
            *bound = self.bodies.partition_point(|&body| body < first) as u32;
        }
    }
}

/// Rows of entries, one for each body.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct ContactRows<E> {
    /// The bodies.
    pub on: LoadedBodies,
    /// `start[p]..start[p + 1]` are the entries of the body of place p.
    pub start: Vec<u32>,
    /// The entries.
    pub entries: Vec<E>,
    /// Bounds of each block of bodies in the entries.
    pub entry_bounds: Vec<u32>,
}

impl<E> Default for ContactRows<E> {
    fn default() -> Self {
        let on = LoadedBodies::default();
        Self { on, start: Vec::new(), entries: Vec::new(), entry_bounds: Vec::new() }
    }
}

impl<E: Copy> ContactRows<E> {
    /// Forgets all rows.
    pub fn clear(&mut self) {
        self.on.bodies.clear();
        self.on.bounds.clear();
        self.start.clear();
        self.start.push(0);
        self.entries.clear();
        self.entry_bounds.clear();
        self.end_block();
    }

    /// Ends a block of bodies.
    pub fn end_block(&mut self) {
        self.on.bounds.push(self.on.bodies.len() as u32);
        self.entry_bounds.push(self.entries.len() as u32);
    }

    /// Adds the entries of a block of bodies, and ends the block.
    pub fn append(&mut self, found: &FoundRows<E>) {
        let first = self.entries.len() as u32;
        self.on.bodies.extend(&found.bodies);
        self.start.extend(found.ends.iter().map(|end| first + end));
        self.entries.extend(&found.entries);
        self.end_block();
    }

    /// Range of the entries of a body, by its place in this list.
    #[inline(always)]
    pub fn range(&self, p: usize) -> core::ops::Range<usize> {
        self.start[p] as usize..self.start[p + 1] as usize
    }

    /// The entries of a body, by its place in this list.
    pub fn row(&self, p: usize) -> &[E] {
        &self.entries[self.range(p)]
    }

    /// The entries of a body, by its place in memory.
    pub fn of(&self, body: u32) -> &[E] {
        self.on.place(body).map_or(&[], |p| self.row(p))
    }
}

/// Rows that one block of bodies found.
#[derive(Debug)]
pub(crate) struct FoundRows<E> {
    bodies: Vec<u32>,
    /// Number of entries at the end of each body's row.
    ends: Vec<u32>,
    pub entries: Vec<E>,
}

impl<E> Default for FoundRows<E> {
    fn default() -> Self {
        Self { bodies: Vec::new(), ends: Vec::new(), entries: Vec::new() }
    }
}

impl<E> FoundRows<E> {
    /// Forgets all rows.
    pub fn clear(&mut self) {
        self.bodies.clear();
        self.ends.clear();
        self.entries.clear();
    }

    /// Makes room for so many rows.
    pub fn reserve(&mut self, rows: usize) {
        self.bodies.reserve(rows);
        self.ends.reserve(rows);
        self.entries.reserve(rows);
    }

    /// Ends the row of a body, by its place in memory.
    pub fn end_row(&mut self, body: usize) {
        self.bodies.push(body as u32);
        self.ends.push(self.entries.len() as u32);
    }
}
