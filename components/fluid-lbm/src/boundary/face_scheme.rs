//! The seam of open faces: a scheme gives the cells at a face the populations that come from beyond
//! it.
//!
//! A scheme is asked once a step for a whole face, never for a cell. `face_schemes` says which face
//! has which.

use crate::boundary::refill::PreCollision;
use crate::boundary::wall_mass::Brought;
use crate::domain::boundary_condition::BoundaryValue;
use crate::lattice::aa_pattern::{Blocked, Parity};
use crate::lattice::cell_flags::CellFlags;
use crate::lattice::cell_list::NONE;
use crate::lattice::d3q19::{C, OPPOSITE, Q, each, moments};
use crate::lattice::error::FluidError;
use crate::lattice::layout::{Layout, items_in_blocks};
use crate::lattice::ledger::add_scaled;
use crate::lattice::populations::{Field, Real};
use crate::lattice::units::Units;
use crate::lattice::whole_numbers::WholeNumbers;
use crate::ranks::rank_sums::Ranks;
use std::ops::Range;
use tremie_state::{StateError, StateExchange};
use tremie_team::{Team, Variant};

/// Cells that are one item of work at most.
pub const CELLS_PER_ITEM: usize = 512;

/// A scheme for the cells of one open face.
pub trait FaceScheme<T: Real>: Send {
    /// Begins a step, before cells change hands and collide. Most schemes need nothing of it.
    ///
    /// # Errors
    /// A state that ends the run.
    fn begin(&mut self, _begin: &StepBegin<T>, _team: &mut Team) -> Result<(), FluidError> {
        Ok(())
    }

    /// Gives the cells that are fluid all populations that the next collision finds in them, by
    /// [`PostStreaming::replace`] or as that does, and keeps what the fluid gained by it. What a scheme adds up over
    /// the face, it adds up over all ranks.
    ///
    /// # Errors
    /// A state that ends the run.
    fn apply(
        &mut self,
        next: &PostStreaming<T>,
        team: &mut Team,
        ranks: &mut Ranks,
    ) -> Result<(), FluidError>;

    /// Calls `add` with momentum and mass that the fluid gained in the last step, piece by piece, in the cells that
    /// this part of the lattice counts.
    fn each_gain(&self, add: &mut dyn FnMut([f64; 3], f64));

    /// Cells of a face that prescribes a pressure through which fluid entered in the last step.
    fn entering(&self) -> usize {
        0
    }

    /// Memory that the scheme's tables take [bytes].
    fn bytes(&self) -> usize;

    /// Keeps what the scheme knows from earlier steps, or puts it back.
    ///
    /// # Errors
    /// A state of another face.
    fn exchange(
        &mut self,
        state: &mut StateExchange<'_>,
        numbers: &WholeNumbers,
    ) -> Result<(), StateError>;
}

/// The fluid at the beginning of a step.
#[derive(Clone, Copy)]
pub struct StepBegin<'a, T: Real> {
    /// Populations that the last step left.
    pub before: PreCollision<'a, T>,
    /// Cells that were fluid in it.
    pub flags: &'a CellFlags,
    /// Time that has passed [s].
    pub time: f64,
    /// Units of the lattice.
    pub units: &'a Units,
}

/// The fluid as the next collision will find it.
#[derive(Clone, Copy)]
pub struct PostStreaming<'a, T: Real> {
    /// Populations.
    pub field: &'a Field<T>,
    /// Layout of the cells, with the places of their populations.
    pub layout: &'a Layout,
    /// Flags that tell fluid cells.
    pub flags: &'a CellFlags,
    /// Parity of the next collision.
    pub parity: Parity,
    /// Acceleration of the fluid.
    pub acceleration: [f64; 3],
    /// Mean density of the fluid.
    pub density: f64,
    /// Values that the faces prescribe at the end of the step, `2 axis + side`.
    pub now: &'a [BoundaryValue],
    /// Mass that links to walls brought to the cells of each face: it came through the face, which
    /// replaces it.
    pub brought: &'a [Brought; 6],
    /// Units of the lattice.
    pub units: &'a Units,
    /// Vector instructions that are used.
    pub variant: Variant,
}

/// A cell at an open face.
#[derive(Clone, Copy, Debug)]
pub struct FaceCell {
    /// The cell.
    pub cell: u32,
    /// The next cell inside, along the normals of all open faces at which the cell lies; [`NONE`]
    /// if that is solid.
    pub inner: u32,
    /// Bits of the directions that come from beyond an open face.
    pub unknown: u32,
    /// True if all of these come through this face, and no other wall is near.
    pub plain: bool,
}

impl FaceCell {
    /// The cells that belong to a face, of the links of all cells that open faces block.
    pub fn of_face(layout: &Layout, face: usize, blocked: &[Blocked]) -> Vec<Self> {
        let (axis, sign, grid) = (face / 2, [1, -1][face % 2], &layout.grid);
        let across: u32 = (0..Q).filter(|&i| C[i][axis] == sign).fold(0, |bits, i| bits | 1 << i);
        let own = |links: &[Blocked]| {
            let (cell, at) = (links[0].cell, layout.at(links[0].cell));
            if grid.open_faces(at).next() != Some((axis, face % 2)) {
                return None;
            }
            let mut normal = [0; 3];
            for (axis, side) in grid.open_faces(at) {
                normal[axis] = [1, -1][side];
            }
            let unknown = links.iter().fold(0, |bits, l| bits | 1 << OPPOSITE[l.dir as usize]);
            Some(Self {
                cell,
                inner: layout.near(at, normal).map_or(NONE, |(cell, _)| cell),
                unknown,
                plain: unknown == across && grid.open_faces(at).count() == 1,
            })
        };
        blocked.chunk_by(|a, b| a.cell == b.cell).filter_map(own).collect()
    }
}

/// Cells of a face that are one item of work, all of one block.
#[derive(Clone, Debug)]
pub struct FaceItem {
    /// Their numbers among the cells of the face.
    pub cells: Range<usize>,
    /// True if this part of the lattice counts them.
    pub is_own: bool,
}

/// The items of work of a face's cells.
pub fn items_of(layout: &Layout, cells: &[FaceCell]) -> Vec<FaceItem> {
    let numbers: Vec<u32> = cells.iter().map(|open| open.cell).collect();
    let items = items_in_blocks(&numbers, CELLS_PER_ITEM);
    items.map(|cells| FaceItem { is_own: layout.is_own(numbers[cells.start]), cells }).collect()
}

/// Momentum and mass that the fluid gained through cells of a face.
#[derive(Clone, Copy, Debug, Default)]
pub struct Gain {
    /// Momentum.
    pub impulse: [f64; 3],
    /// Mass.
    pub mass: f64,
}

impl<T: Real> PostStreaming<'_, T> {
    /// Populations that the next collision finds in a cell.
    #[inline]
    pub fn populations(&self, cell: u32) -> [f64; Q] {
        self.layout.populations(self.field, self.parity, cell)
    }

    /// The next cell inside, if there is fluid.
    pub fn inner(&self, open: &FaceCell) -> Option<u32> {
        (open.inner != NONE && self.flags.is_fluid(open.inner)).then_some(open.inner)
    }

    /// Replaces the old populations of a cell by new ones and adds up what the fluid gained.
    pub fn replace(&self, open: &FaceCell, old: &[f64; Q], new: &[f64; Q], all: &mut Gain) {
        let places = self.layout.places.of_cell(self.parity, open.cell);
        let gain = each(|i| self.field.set(places[i], new[i]) - old[i]);
        let (mass, impulse) = gained(gain, old, open.unknown);
        all.mass += mass;
        add_scaled(&mut all.impulse, impulse, 1.0);
    }
}

/// Mass and momentum that fluid gains in a cell whose populations grow by `gain` from `old`, the
/// `unknown` ones coming through an open face.
#[inline(always)]
pub fn gained(mut gain: [f64; Q], old: &[f64; Q], unknown: u32) -> (f64, [f64; 3]) {
    let (mass, _) = moments(&gain);
    for i in 0..Q {
        // The population that was there had left through the face in the opposite direction.
        let left = gain[i] + 2.0 * old[i];
        gain[i] = if unknown >> i & 1 == 1 { left } else { gain[i] };
    }
    (mass, moments(&gain).1)
}
