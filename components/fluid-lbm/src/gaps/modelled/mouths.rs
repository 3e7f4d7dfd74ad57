//! The links from fluid cells into frozen ones: they are reflected half-way, and their cells are
//! around the gap.

use super::ModelledGaps;
use crate::boundary::gap_sinks::NO_GAP;
use crate::boundary::post_collision::{PostCollision, density};
use crate::lattice::cell_flags::{CellFlags, FROZEN};
use crate::lattice::d3q19::{C, C_F64, OPPOSITE, Q, mirrored};
use crate::lattice::exact_sum::{ExactSum, add_vector, values};
use crate::lattice::layout::Layout;
use crate::lattice::populations::Real;
use crate::ranks::rank_sums::Ranks;
use tremie_messages::scene::GapRule;

/// A link from a fluid cell to a frozen one.
#[derive(Clone, Copy, Debug)]
struct Mouth {
    cell: u32,
    dir: u8,
    gap: u16,
}

/// The links from fluid cells into frozen ones.
#[derive(Clone, Debug, Default)]
pub(super) struct Mouths {
    list: Vec<Mouth>,
    /// By stored cell, whether it was frozen or adjoined a frozen one when they were listed, and
    /// which cells those are.
    matters: Vec<bool>,
    around: Vec<u32>,
    /// True if they were listed at all.
    are_listed: bool,
}

impl Mouths {
    /// None yet, of so many cells.
    pub fn with_room(cells: usize) -> Self {
        Self {
            list: Vec::with_capacity(cells / 4),
            matters: vec![false; cells],
            around: Vec::with_capacity(cells),
            are_listed: false,
        }
    }

    /// Begins to list them anew.
    fn begin(&mut self) {
        self.are_listed = true;
        self.list.clear();
        for cell in self.around.drain(..) {
            self.matters[cell as usize] = false;
        }
    }

    /// Adds those into a frozen cell.
    fn add(&mut self, flags: &CellFlags, layout: &Layout, cell: u32, gap: u16) {
        self.note(cell);
        let at = layout.at(cell);
        for i in 1..Q {
            let Some((from, mirrors)) = layout.near(at, C[i]) else { continue };
            self.note(from);
            let dir = mirrored(OPPOSITE[i], mirrors);
            if flags.is_fluid(from) && layout.neighbour(from, dir) == Some(cell) {
                self.list.push(Mouth { cell: from, dir: dir as u8, gap });
            }
        }
    }

    /// Notes that the list depends on whose a cell is.
    fn note(&mut self, cell: u32) {
        if !std::mem::replace(&mut self.matters[cell as usize], true) {
            self.around.push(cell);
        }
    }
}

impl ModelledGaps {
    /// Lists the links from fluid cells into frozen ones, if cells changed hands on which these
    /// depend.
    pub fn find_mouths(&mut self, flags: &CellFlags, layout: &Layout) {
        let mouths = &self.mouths;
        let changed = flags.changed().iter();
        let depends = |&cell: &u32| mouths.matters[cell as usize] || flags.of(cell) == FROZEN;
        if mouths.are_listed && !changed.copied().any(|cell| depends(&cell)) {
            return;
        }
        let mut mouths = std::mem::take(&mut self.mouths);
        mouths.begin();
        let of_gaps = self.candidates.iter().map(|candidate| candidate.cell);
        for cell in of_gaps.chain(self.pockets.iter().copied()) {
            if flags.of(cell) == FROZEN {
                let gap = if self.is_pocket(cell) { NO_GAP } else { self.of[cell as usize] };
                mouths.add(flags, layout, cell, gap);
            }
        }
        // A pocket's cell that is also a gap's candidate was seen twice.
        mouths.list.sort_unstable_by_key(|mouth| (mouth.cell, mouth.dir));
        mouths.list.dedup_by_key(|mouth| (mouth.cell, mouth.dir));
        self.mouths = mouths;
    }

    /// Reflects them.
    pub(super) fn reflect_mouths<T: Real>(&mut self, after: &PostCollision<T>, ranks: &mut Ranks) {
        let mut impulse = [ExactSum::default(); 3];
        self.gaps.iter_mut().for_each(|gap| gap.around = Default::default());
        for mouth in &self.mouths.list {
            let (i, is_own) = (usize::from(mouth.dir), after.layout.is_own(mouth.cell));
            let gap = self.gaps.get_mut(usize::from(mouth.gap));
            if let Some(gap) = gap.filter(|gap| is_own && gap.rule == GapRule::Nearest) {
                gap.around[0].add(density(&after.post(mouth.cell)) - 1.0);
                gap.around[1].add(1.0);
            }
            let g = after.post_one(mouth.cell, i);
            let f = after.field.set(after.next_place(mouth.cell, OPPOSITE[i]), g);
            if is_own {
                add_vector(&mut impulse, C_F64[i].map(|c| c * (g + f)));
            }
        }
        let around = self.gaps.iter_mut().flat_map(|gap| &mut gap.around);
        ranks.add_up(around.chain(&mut impulse));
        self.impulse = values(&impulse);
    }
}
