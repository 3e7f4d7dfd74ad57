//! Pockets: fluid cells that freezing cut off. See `modelled`.

use crate::gaps::far_fills::FarFills;
use crate::gaps::modelled::{ModelledGaps, POCKET};
use crate::lattice::cell_flags::{CellFlags, FLUID, FROZEN, VACATED, Vacated};
use crate::lattice::layout::Layout;
use crate::lattice::layout::faces;
use crate::lattice::whole_numbers::WholeNumbers;
use crate::ranks::rank_sums::Ranks;
use std::collections::BTreeMap;
use tremie_fluid_kit::cells::grid::Side;
use tremie_team::{Cut, Team};

/// Cells that are asked together whether they are in a pocket.
const SEEDS_PER_PIECE: usize = 8;

/// Room for a pocket: the last cell that it may have brings its neighbours.
const ROOM: usize = POCKET + 6;

/// Cells that a fill reached, in their order.
#[derive(Clone, Copy)]
struct Fill {
    cells: [u32; ROOM],
    count: usize,
    end: FillEnd,
}

/// What is known at the end of a fill.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FillEnd {
    /// It is in no pocket.
    #[default]
    Open,
    /// It is a pocket.
    Closed,
    /// It came to cells that another rank counts.
    Beyond,
}

impl ModelledGaps {
    /// Freezes pockets and thaws those that got a way out, after [`CellFlags::settle`].
    pub fn close_pockets(
        &mut self,
        flags: &mut CellFlags,
        layout: &Layout,
        numbers: &WholeNumbers,
        (team, ranks): (&mut Team, &mut Ranks),
    ) {
        self.pockets.retain(|&cell| flags.of(cell) == FROZEN);
        self.thaw_pockets(flags, layout, numbers, ranks);
        self.pockets.retain(|&cell| flags.of(cell) == FROZEN);
        // Cells that may have lost their way out: neighbours of cells that are fluid no more, and
        // new fluid cells.
        self.seeds.clear();
        self.seeds.extend(flags.vacated.iter().map(|vacated| vacated.cell));
        let gone = flags.covered.iter().chain(&flags.enclosed);
        self.seeds.extend(gone.flat_map(|&cell| faces(layout, cell)));
        self.seeds.retain(|&cell| layout.is_own(cell));
        self.seeds.sort_unstable();
        self.seeds.dedup();
        self.find_closed(flags, layout, team);
        for cell in self.all_closed(flags, layout, numbers, ranks) {
            if is_wet(flags, cell) {
                flags.freeze(cell);
                self.pockets.push(cell);
            }
        }
        self.pockets.sort_unstable();
        flags.forget_frozen_vacated();
    }

    /// Thaws pockets beside cells that a body left: of several bodies that with the least handle has them.
    fn thaw_pockets(
        &self,
        flags: &mut CellFlags,
        layout: &Layout,
        numbers: &WholeNumbers,
        ranks: &mut Ranks,
    ) {
        let mut thawed: BTreeMap<u32, u32> = BTreeMap::new();
        let pockets = |flags: &CellFlags, cell: u32| {
            let is_shut = |next: &u32| flags.of(*next) == FROZEN && self.is_pocket(*next);
            faces(layout, cell).filter(is_shut).collect::<Vec<_>>()
        };
        let beside = flags.vacated.iter().filter(|left| !pockets(flags, left.cell).is_empty());
        let mut reached: Vec<(u32, u32)> = beside.map(|left| (left.cell, left.handle)).collect();
        loop {
            let mut changed: Vec<i64> = Vec::new();
            while let Some((cell, handle)) = reached.pop() {
                for next in pockets(flags, cell) {
                    let least = thawed.entry(next).or_insert(u32::MAX);
                    if handle < *least {
                        *least = handle;
                        reached.push((next, handle));
                        changed.extend([numbers.in_whole(next), handle].map(i64::from));
                    }
                }
            }
            let mut count = [changed.len() as i64];
            ranks.count(&mut count);
            if ranks.is_alone() || count == [0] {
                break;
            }
            for told in ranks.collect(&changed).chunks_exact(2) {
                let (cell, handle) = (numbers.here(told[0] as u32), told[1] as u32);
                let Some(cell) = cell.filter(|&cell| flags.of(cell) == FROZEN) else { continue };
                let least = thawed.entry(cell).or_insert(u32::MAX);
                if handle < *least {
                    *least = handle;
                    reached.push((cell, handle));
                }
            }
        }
        for (cell, handle) in thawed {
            flags.thaw(Vacated { cell, handle });
        }
    }

    /// The cells of all pockets that were found, on all ranks, as far as they are stored here.
    fn all_closed(
        &self,
        flags: &CellFlags,
        layout: &Layout,
        numbers: &WholeNumbers,
        ranks: &mut Ranks,
    ) -> Vec<u32> {
        let with = |end: FillEnd| {
            let seeds = self.seeds.iter().zip(&self.closed);
            seeds.filter(move |(_, found)| **found == end).map(|(&seed, _)| seed)
        };
        let mut counts = [FillEnd::Closed, FillEnd::Beyond].map(|end| with(end).count() as i64);
        ranks.count(&mut counts);
        let [closed, beyond] = counts;
        if closed + beyond == 0 {
            return Vec::new();
        }
        let fill = |seed: u32| Fill::from(flags, layout, seed, &Fill::EMPTY);
        let mut cells: Vec<u32> =
            with(FillEnd::Closed).flat_map(|seed| fill(seed).reached().to_vec()).collect();
        if ranks.is_alone() {
            cells.sort_unstable();
            cells.dedup();
            return cells;
        }
        let mut whole: Vec<i64> = cells.iter().map(|&cell| numbers.in_whole(cell).into()).collect();
        if beyond > 0 {
            let seeds: Vec<u32> = with(FillEnd::Beyond).collect();
            whole.extend(FarFills::new(flags, layout, numbers).closed(&seeds, ranks));
        }
        let mut all = ranks.collect(&whole);
        all.sort_unstable();
        all.dedup();
        all.into_iter().filter_map(|cell| numbers.here(cell as u32)).collect()
    }

    /// True if a frozen cell is one of a pocket.
    pub fn is_pocket(&self, cell: u32) -> bool {
        self.pockets.binary_search(&cell).is_ok()
    }

    /// Finds the seeds that are in pockets. No way leads from the pocket of one to others, so that
    /// they may be tested at the same time.
    fn find_closed(&mut self, flags: &CellFlags, layout: &Layout, team: &mut Team) {
        self.closed.clear();
        self.closed.resize(self.seeds.len(), FillEnd::Open);
        let seeds = &self.seeds;
        let pieces = Cut::every(&mut self.closed, SEEDS_PER_PIECE);
        team.for_pieces(pieces, |number, piece: &mut [FillEnd]| {
            // Neighbours follow each other: mostly the next is where the last fill has been.
            let mut open = Fill::EMPTY;
            for (&seed, end) in seeds[number * SEEDS_PER_PIECE..].iter().zip(piece) {
                if is_wet(flags, seed) && !open.reached().contains(&seed) {
                    let fill = Fill::from(flags, layout, seed, &open);
                    *end = fill.end;
                    if fill.end == FillEnd::Open {
                        open = fill;
                    }
                }
            }
        });
    }
}

impl Fill {
    const EMPTY: Self = Self { cells: [0; ROOM], count: 0, end: FillEnd::Open };

    /// Goes from a fluid cell until it has been everywhere, or knows that it is in no pocket: at an
    /// open face, next to a cell of `open`, all of which are in none, or when there are too many.
    fn from(flags: &CellFlags, layout: &Layout, seed: u32, open: &Self) -> Self {
        let mut fill = Self::EMPTY;
        fill.add(seed);
        let mut next = 0;
        while next < fill.count {
            let cell = fill.cells[next];
            if fill.count >= POCKET || is_at_open_face(layout, cell) {
                return fill;
            }
            if !layout.is_own(cell) {
                fill.end = FillEnd::Beyond;
                return fill;
            }
            for neighbour in faces(layout, cell).filter(|&cell| is_wet(flags, cell)) {
                if open.reached().contains(&neighbour) {
                    return fill;
                }
                fill.add(neighbour);
            }
            next += 1;
        }
        fill.end = FillEnd::Closed;
        fill
    }

    fn reached(&self) -> &[u32] {
        &self.cells[..self.count]
    }

    fn add(&mut self, cell: u32) {
        if !self.reached().contains(&cell) {
            self.cells[self.count] = cell;
            self.count += 1;
        }
    }
}

/// True if a cell is fluid or becomes so.
pub fn is_wet(flags: &CellFlags, cell: u32) -> bool {
    matches!(flags.of(cell), FLUID | VACATED)
}

/// True if a cell is at an open face.
pub fn is_at_open_face(layout: &Layout, cell: u32) -> bool {
    let (at, grid) = (layout.at(cell), &layout.grid);
    (0..3).any(|a| {
        (at[a] == 0 && grid.sides[a][0] == Side::Open)
            || (at[a] == grid.n[a] - 1 && grid.sides[a][1] == Side::Open)
    })
}
