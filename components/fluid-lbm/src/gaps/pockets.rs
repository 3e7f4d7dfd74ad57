//! Pockets: fluid cells that freezing cut off. See `modelled`.

use crate::gaps::modelled::{ModelledGaps, POCKET};
use crate::lattice::cell_flags::{CellFlags, FLUID, FROZEN, VACATED, Vacated};
use crate::lattice::layout::Layout;
use crate::lattice::layout::faces;
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
    /// True if they are a pocket.
    is_closed: bool,
}

impl ModelledGaps {
    /// Freezes pockets and thaws those that got a way out, after [`CellFlags::settle`].
    pub fn close_pockets(&mut self, flags: &mut CellFlags, layout: &Layout, team: &mut Team) {
        // Cells that may have lost their way out: neighbours of cells that are fluid no more, and
        // new fluid cells.
        self.seeds.clear();
        let mut next = 0;
        self.pockets.retain(|&cell| flags.of(cell) == FROZEN);
        while next < flags.vacated.len() {
            let Vacated { cell, handle } = flags.vacated[next];
            for neighbour in faces(layout, cell) {
                if flags.of(neighbour) == FROZEN && self.is_pocket(neighbour) {
                    flags.thaw(Vacated { cell: neighbour, handle });
                }
            }
            self.seeds.push(cell);
            next += 1;
        }
        self.pockets.retain(|&cell| flags.of(cell) == FROZEN);
        let gone = flags.covered.iter().chain(&flags.enclosed);
        self.seeds.extend(gone.flat_map(|&cell| faces(layout, cell)));
        self.seeds.sort_unstable();
        self.seeds.dedup();
        self.find_closed(flags, layout, team);
        for (&seed, _) in self.seeds.iter().zip(&self.closed).filter(|(_, is_closed)| **is_closed) {
            // Those of a pocket all say so, and the first freezes it.
            if is_wet(flags, seed) {
                for &cell in Fill::from(flags, layout, seed, &Fill::EMPTY).reached() {
                    flags.freeze(cell);
                    self.pockets.push(cell);
                }
            }
        }
        self.pockets.sort_unstable();
        flags.forget_frozen_vacated();
    }

    /// True if a frozen cell is one of a pocket.
    pub fn is_pocket(&self, cell: u32) -> bool {
        self.pockets.binary_search(&cell).is_ok()
    }

    /// Finds the seeds that are in pockets. No way leads from the pocket of one to others, so that
    /// they may be tested at the same time.
    fn find_closed(&mut self, flags: &CellFlags, layout: &Layout, team: &mut Team) {
        self.closed.clear();
        self.closed.resize(self.seeds.len(), false);
        let seeds = &self.seeds;
        let pieces = Cut::every(&mut self.closed, SEEDS_PER_PIECE);
        team.for_pieces(pieces, |number, piece: &mut [bool]| {
            // Neighbours follow each other: mostly the next is where the last fill has been.
            let mut open = Fill::EMPTY;
            for (&seed, is_closed) in seeds[number * SEEDS_PER_PIECE..].iter().zip(piece) {
                if is_wet(flags, seed) && !open.reached().contains(&seed) {
                    let fill = Fill::from(flags, layout, seed, &open);
                    *is_closed = fill.is_closed;
                    if !fill.is_closed {
                        open = fill;
                    }
                }
            }
        });
    }
}

impl Fill {
    const EMPTY: Self = Self { cells: [0; ROOM], count: 0, is_closed: false };

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
            for neighbour in faces(layout, cell).filter(|&cell| is_wet(flags, cell)) {
                if open.reached().contains(&neighbour) {
                    return fill;
                }
                fill.add(neighbour);
            }
            next += 1;
        }
        fill.is_closed = true;
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
fn is_wet(flags: &CellFlags, cell: u32) -> bool {
    matches!(flags.of(cell), FLUID | VACATED)
}

/// True if a cell is at an open face.
fn is_at_open_face(layout: &Layout, cell: u32) -> bool {
    let (at, grid) = (layout.at(cell), &layout.grid);
    (0..3).any(|a| {
        (at[a] == 0 && grid.sides[a][0] == Side::Open)
            || (at[a] == grid.n[a] - 1 && grid.sides[a][1] == Side::Open)
    })
}
