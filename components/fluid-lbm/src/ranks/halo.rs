//! The copies that ranks hold of each other's cells, brought up to date at the end of a step.

use crate::lattice::aa_pattern::Parity;
use crate::lattice::d3q19::Q;
use crate::lattice::layout::{CELLS_PER_BLOCK, Layout};
use crate::lattice::populations::{Field, Real};
use crate::ranks::cell_shares::CellShares;
use crate::ranks::communicator::{Communicator, Parcel};
use std::ops::Range;

/// Cells that go to another rank, or come from it.
#[derive(Clone, Debug)]
struct Route {
    /// Runs of cells, by their numbers on this rank.
    cells: Vec<Range<u32>>,
}

/// What a rank sends to others and takes from them in each step.
#[derive(Clone, Debug, Default)]
pub struct Halo {
    sends: Vec<Route>,
    receives: Vec<Route>,
    sent: Vec<Parcel>,
    received: Vec<Parcel>,
    is_under_way: bool,
}

impl Halo {
    /// Of a rank, for numbers of so many bytes.
    pub fn new(shares: &CellShares, rank: usize, layout: &Layout, bytes: usize) -> Self {
        let window = shares.window(rank);
        let runs = |blocks: &mut dyn Iterator<Item = u32>| {
            let mut cells: Vec<Range<u32>> = Vec::new();
            for place in blocks.filter_map(|block| window.place(block)) {
                let first = place * CELLS_PER_BLOCK;
                let end = (first + CELLS_PER_BLOCK).min(layout.cells.len() as u32);
                match cells.last_mut() {
                    Some(last) if last.end == first => last.end = end,
                    _ => cells.push(first..end),
                }
            }
            Route { cells }
        };
        let mut own = Self::default();
        for other in (0..shares.ranks()).filter(|&other| other != rank) {
            let parcel = |way: &Route| {
                let cells: usize = way.cells.iter().map(Range::len).sum();
                Parcel { rank: other, bytes: vec![0; cells * Q * bytes] }
            };
            let sends = runs(&mut shares.copies(other, rank));
            let receives = runs(&mut shares.copies(rank, other));
            if !sends.cells.is_empty() {
                own.sent.push(parcel(&sends));
                own.sends.push(sends);
            }
            if !receives.cells.is_empty() {
                own.received.push(parcel(&receives));
                own.receives.push(receives);
            }
        }
        own
    }

    /// Begins to bring the copies up to date: sends what the next collision, of a parity, finds in own cells.
    pub fn begin<T: Real>(
        &mut self,
        layout: &Layout,
        field: &Field<T>,
        parity: Parity,
        way: &mut dyn Communicator,
    ) {
        for (send, parcel) in self.sends.iter().zip(&mut self.sent) {
            let mut bytes = parcel.bytes.chunks_exact_mut(size_of::<T>());
            send.each_place(layout, parity, |place| {
                if let Some(bytes) = bytes.next() {
                    T::from_f64(field.get(place)).put(bytes);
                }
            });
        }
        way.begin_swap(&self.sent, &mut self.received);
        self.is_under_way = true;
    }

    /// Ends it: writes what came.
    pub fn end<T: Real>(
        &mut self,
        layout: &Layout,
        field: &Field<T>,
        parity: Parity,
        way: &mut dyn Communicator,
    ) {
        if !std::mem::take(&mut self.is_under_way) {
            return;
        }
        way.end_swap(&mut self.received);
        for (receive, parcel) in self.receives.iter().zip(&self.received) {
            let mut bytes = parcel.bytes.chunks_exact(size_of::<T>());
            receive.each_place(layout, parity, |place| {
                if let Some(bytes) = bytes.next() {
                    field.set(place, T::get(bytes).to_f64());
                }
            });
        }
    }

    /// Bytes that are sent in a step.
    pub fn bytes(&self) -> usize {
        self.sent.iter().map(|parcel| parcel.bytes.len()).sum()
    }
}

impl Route {
    /// Visits the places in which the collision of a parity finds the populations of all cells, in an order that
    /// does not depend on the rank.
    fn each_place(&self, layout: &Layout, parity: Parity, mut visit: impl FnMut(usize)) {
        for cell in self.cells.iter().cloned().flatten() {
            layout.places.of_cell(parity, cell).into_iter().for_each(&mut visit);
        }
    }
}
