//! Pockets: fluid cells that freezing cut off. See `declared`.

use crate::declared::{DeclaredGaps, POCKET};
use crate::grid::Side;
use crate::lattice::{C, Q};
use crate::layout::Layout;
use crate::owners::{FLUID, FROZEN, Owners, VACATED, Vacated};

impl DeclaredGaps {
    /// Freezes pockets and thaws those that got a way out, after [`Owners::settle`].
    pub fn close_pockets(&mut self, owners: &mut Owners, layout: &Layout) {
        // Which cells may have lost their way: neighbours of those that are fluid no more, and new ones.
        self.seeds.clear();
        let mut next = 0;
        self.pockets.retain(|&cell| owners.of(cell) == FROZEN);
        while next < owners.vacated.len() {
            let Vacated { cell, handle } = owners.vacated[next];
            for neighbour in faces(layout, cell) {
                if owners.of(neighbour) == FROZEN && self.is_pocket(neighbour) {
                    owners.thaw(Vacated { cell: neighbour, handle });
                }
            }
            self.seeds.push(cell);
            next += 1;
        }
        self.pockets.retain(|&cell| owners.of(cell) == FROZEN);
        let gone = owners.covered.iter().chain(&owners.enclosed);
        self.seeds.extend(gone.flat_map(|&cell| faces(layout, cell)));
        self.seeds.sort_unstable();
        self.seeds.dedup();
        for k in 0..self.seeds.len() {
            let seed = self.seeds[k];
            if is_wet(owners, seed) && self.is_closed(owners, layout, seed) {
                for &cell in &self.fill {
                    owners.freeze(cell);
                    self.pockets.push(cell);
                }
            }
        }
        self.pockets.sort_unstable();
        owners.forget_frozen_vacated();
    }

    /// Whether a frozen cell is one of a pocket.
    pub fn is_pocket(&self, cell: u32) -> bool {
        self.pockets.binary_search(&cell).is_ok()
    }

    /// Whether fewer cells than a pocket's can be reached from a fluid cell; those are in `fill` then.
    fn is_closed(&mut self, owners: &Owners, layout: &Layout, seed: u32) -> bool {
        self.fill.clear();
        self.fill.push(seed);
        let mut next = 0;
        while next < self.fill.len() {
            if self.fill.len() >= POCKET || is_at_open_face(layout, self.fill[next]) {
                return false;
            }
            for neighbour in faces(layout, self.fill[next]) {
                if is_wet(owners, neighbour) && !self.fill.contains(&neighbour) {
                    self.fill.push(neighbour);
                }
            }
            next += 1;
        }
        true
    }
}

/// Whether a cell is fluid or becomes so.
fn is_wet(owners: &Owners, cell: u32) -> bool {
    matches!(owners.of(cell), FLUID | VACATED)
}

/// Stored cells that share a face with a cell.
pub fn faces(layout: &Layout, cell: u32) -> impl Iterator<Item = u32> {
    let straight = (1..Q).filter(|&i| C[i].iter().map(|c| c.abs()).sum::<i32>() == 1);
    straight.filter_map(move |i| layout.neighbour(cell, i)).filter(move |&n| n != cell)
}

/// Whether a cell is at an open face.
fn is_at_open_face(layout: &Layout, cell: u32) -> bool {
    let (at, grid) = (layout.at(cell), &layout.grid);
    (0..3).any(|a| {
        (at[a] == 0 && grid.sides[a][0] == Side::Open)
            || (at[a] == grid.n[a] - 1 && grid.sides[a][1] == Side::Open)
    })
}
