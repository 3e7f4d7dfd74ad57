//! The copies that ranks hold of each other's cells, brought up to date at the end of a step.
//!
//! Where a step looks no farther than to the next cell (a depth of 1), the copies keep themselves up to date but for what
//! streams to them from cells that the rank does not hold: some five populations of a cell in the outermost layer. Those
//! are sent, and all of the copies at walls. Else all populations of all copies are, and which of the cells are cut off
//! from the fluid: from the last copies their ranks do not see all ways.

use crate::lattice::aa_pattern::Parity;
use crate::lattice::cell_flags::{CellFlags, ISOLATED};
use crate::lattice::cell_list::LinkEnd;
use crate::lattice::d3q19::{OPPOSITE, Q};
use crate::lattice::layout::{CELLS_PER_BLOCK, Layout};
use crate::lattice::populations::{Field, Real};
use crate::ranks::cell_shares::CellShares;
use crate::ranks::communicator::{Communicator, Parcel};
use std::ops::Range;
use tremie_fluid_kit::cells::obstacles::Obstacles;

/// Cells that go to another rank, or come from it.
#[derive(Clone, Debug)]
struct Route {
    /// Runs of cells all of whose populations go, by their numbers on this rank.
    cells: Vec<Range<u32>>,
    /// Places of populations that go without the others of their cells, as runs of places that follow each other: when
    /// the next collision is even and when it is odd.
    single: [Vec<Range<usize>>; 2],
    /// Number of these populations.
    singles: usize,
    /// True if it is told which of the cells are cut off.
    tells_isolated: bool,
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
    pub fn new(
        shares: &CellShares,
        rank: usize,
        (layout, obstacles): (&Layout, &Obstacles),
        bytes: usize,
    ) -> Self {
        let window = shares.window(rank);
        let runs = |blocks: &mut dyn Iterator<Item = u32>| {
            let mut cells: Vec<Range<u32>> = Vec::new();
            for place in blocks.filter_map(|block| window.place(block)) {
                let first = place * CELLS_PER_BLOCK;
                let end = (first + CELLS_PER_BLOCK).min(layout.cells.len() as u32);
                add_run(&mut cells, first..end);
            }
            let tells_isolated = shares.depth() > 1;
            Route { cells, single: Default::default(), singles: 0, tells_isolated }
        };
        let mut own = Self::default();
        for other in (0..shares.ranks()).filter(|&other| other != rank) {
            let parcel = |route: &Route| Parcel {
                rank: other,
                bytes: vec![0; route.numbers() * bytes + route.isolated_bytes()],
            };
            let mut sends = runs(&mut shares.copies(other, rank));
            let mut receives = runs(&mut shares.copies(rank, other));
            if shares.depth() == 1 {
                let held = shares.window(other);
                let is_held = |cell: u32| held.holds(window.in_whole(cell));
                sends.select(layout, obstacles, is_held);
                receives.select(layout, obstacles, |_| true);
            }
            if sends.numbers() > 0 {
                own.sent.push(parcel(&sends));
                own.sends.push(sends);
            }
            if receives.numbers() > 0 {
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
        (field, flags): (&Field<T>, &CellFlags),
        parity: Parity,
        way: &mut dyn Communicator,
    ) {
        for (send, parcel) in self.sends.iter().zip(&mut self.sent) {
            let mut rest = &mut parcel.bytes[..];
            send.each_run(layout, T::LINE, parity, |place, count| {
                let (own, others) = std::mem::take(&mut rest).split_at_mut(count * size_of::<T>());
                field.read_run(place, own);
                rest = others;
            });
            for (cells, byte) in send.eights().zip(rest) {
                let isolated = cells.map(|cell| u8::from(flags.of(cell) == ISOLATED));
                *byte = isolated.rev().fold(0, |bits, is_isolated| bits << 1 | is_isolated);
            }
        }
        way.begin_swap(&self.sent, &mut self.received);
        self.is_under_way = true;
    }

    /// Ends it: writes what came.
    pub fn end<T: Real>(
        &mut self,
        layout: &Layout,
        (field, flags): (&Field<T>, &mut CellFlags),
        parity: Parity,
        way: &mut dyn Communicator,
    ) {
        if !std::mem::take(&mut self.is_under_way) {
            return;
        }
        way.end_swap(&mut self.received);
        for (receive, parcel) in self.receives.iter().zip(&self.received) {
            let mut rest = &parcel.bytes[..];
            receive.each_run(layout, T::LINE, parity, |place, count| {
                let (own, others) = rest.split_at(count * size_of::<T>());
                field.write_run(place, own);
                rest = others;
            });
            for (cells, byte) in receive.eights().zip(rest) {
                for (k, cell) in cells.enumerate() {
                    flags.correct(cell, byte >> k & 1 == 1);
                }
            }
        }
    }

    /// Bytes that are sent in a step.
    pub fn bytes(&self) -> usize {
        self.sent.iter().map(|parcel| parcel.bytes.len()).sum()
    }
}

impl Route {
    /// Numbers that go.
    fn numbers(&self) -> usize {
        self.cells.iter().map(Range::len).sum::<usize>() * Q + self.singles
    }

    /// Its cells, eight at a time.
    fn eights(&self) -> impl Iterator<Item = Range<u32>> {
        let cells = self.cells.iter().filter(|_| self.tells_isolated);
        cells.flat_map(|cells| {
            let end = cells.end;
            cells.clone().step_by(8).map(move |first| first..(first + 8).min(end))
        })
    }

    /// Bytes that say which of them are cut off.
    fn isolated_bytes(&self) -> usize {
        self.eights().count()
    }

    /// Leaves of the cells those at walls, and of others the populations that come from cells which are not held by
    /// whom they go to.
    fn select(&mut self, layout: &Layout, obstacles: &Obstacles, is_held: impl Fn(u32) -> bool) {
        let mut at_walls: Vec<Range<u32>> = Vec::new();
        // Cells by the population: those of cells that follow each other mostly lie so, too.
        let mut missing: [Vec<u32>; Q] = Default::default();
        for cell in std::mem::take(&mut self.cells).into_iter().flatten() {
            let ends =
                (1..Q).map(|i| layout.cells.end(&layout.grid, obstacles, layout.at(cell), i));
            let ends: Vec<LinkEnd> = ends.collect();
            let is_wall = |end: &LinkEnd| match end {
                LinkEnd::Cell { mirrors, .. } => *mirrors != 0,
                LinkEnd::BoundaryId(fixture) => !layout.cells.is_beyond(*fixture),
            };
            if ends.iter().any(is_wall) {
                add_run(&mut at_walls, cell..cell + 1);
                continue;
            }
            // A population comes against the link of the opposite direction.
            for i in 1..Q {
                let is_missing = match ends[OPPOSITE[i] - 1] {
                    LinkEnd::Cell { cell, .. } => !is_held(cell),
                    LinkEnd::BoundaryId(_) => true,
                };
                if is_missing {
                    missing[i].push(cell);
                }
            }
        }
        self.cells = at_walls;
        self.singles = missing.iter().map(Vec::len).sum();
        for parity in [Parity::Even, Parity::Odd] {
            let places = missing.iter().enumerate().flat_map(|(i, cells)| {
                cells.iter().map(move |&cell| layout.place(parity, cell, i))
            });
            self.single[parity as usize] = runs_of(places);
        }
    }

    /// Visits the places in which the collision of a parity finds what goes, as runs of places that follow each other,
    /// in an order that does not depend on the rank.
    fn each_run(
        &self,
        layout: &Layout,
        line: usize,
        parity: Parity,
        mut visit: impl FnMut(usize, usize),
    ) {
        for run in &self.single[parity as usize] {
            visit(run.start, run.len());
        }
        let lines = self.cells.iter().flat_map(|cells| {
            let (first, end) = (cells.start as usize, cells.end as usize);
            // Up to the end of a line at a time.
            let begins =
                std::iter::successors(Some(first), move |&at| Some((at / line + 1) * line));
            let begins = begins.take_while(move |&at| at < end);
            begins.map(move |at| (at, ((at / line + 1) * line).min(end) - at))
        });
        for (first, count) in lines {
            for i in 0..Q {
                match layout.places.of_line(parity, first / line, i) {
                    Some(place) => visit(place + first % line, count),
                    None => {
                        for cell in first..first + count {
                            visit(layout.places.of(parity, cell as u32, i), 1);
                        }
                    }
                }
            }
        }
    }
}

/// Places, in their order, as runs of those that follow each other.
fn runs_of(places: impl Iterator<Item = usize>) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    places.for_each(|place| add_run(&mut runs, place..place + 1));
    runs
}

/// Adds a run, to the last one if it follows that.
fn add_run<T: PartialEq>(runs: &mut Vec<Range<T>>, next: Range<T>) {
    match runs.last_mut() {
        Some(last) if last.end == next.start => last.end = next.end,
        _ => runs.push(next),
    }
}
