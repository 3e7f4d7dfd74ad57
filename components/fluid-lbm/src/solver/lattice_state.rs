//! The lattice between two steps: its cells, what they hold, and which of them are fluid.

use crate::bodies::change_blocks::ChangeBlocks;
use crate::boundary::refill::PreCollision;
use crate::lattice::aa_pattern::Parity;
use crate::lattice::cell_flags::CellFlags;
use crate::lattice::collision::Relaxation;
use crate::lattice::d3q19::{CS2, Q, equilibria};
use crate::lattice::layout::Layout;
use crate::lattice::populations::{Field, Real};
use crate::lattice::reductions::CellStatistics;
use crate::lattice::units::Units;
use crate::lattice::whole_numbers::WholeNumbers;
use crate::ranks::halo::Halo;
use crate::ranks::rank_sums::Ranks;
use tremie_state::{StateError, StateExchange};

/// Cells, populations and flags of a lattice.
pub struct LatticeState<T: Real> {
    /// Cell, time step and density in SI units.
    pub units: Units,
    /// Cells, and where their populations are.
    pub layout: Layout,
    /// The populations.
    pub field: Field<T>,
    /// Fluid cells, and who holds the others.
    pub flags: CellFlags,
    /// Places and times at which cells joined the fluid or left it.
    pub changes: ChangeBlocks,
    /// Relaxation times and acceleration of the collision.
    pub relaxation: Relaxation,
    /// Relaxation time of the viscosity, without a turbulence model [steps].
    pub tau: f64,
    /// Parity of the next collision.
    pub parity: Parity,
    /// Steps done.
    pub steps: u64,
    /// Sums and extremes over the fluid cells that the last collision found, of all ranks.
    pub statistics: CellStatistics,
    /// Their number.
    pub fluid_cells: usize,
    /// Cells that bodies covered and uncovered in the last step, that are cut off, and that are frozen; of all
    /// ranks.
    pub counts: [i64; 4],
    /// The copies of other ranks' cells.
    pub halo: Halo,
    /// Numbers of the cells in the lattice of all ranks.
    pub numbers: WholeNumbers,
}

impl<T: Real> LatticeState<T> {
    /// On cells that are all fluid, with populations zero.
    pub fn new(layout: Layout, units: Units, relaxation: Relaxation, tau: f64) -> Self {
        Self {
            units,
            field: Field::new(layout.places.stride()),
            halo: Halo::default(),
            numbers: WholeNumbers::new(&layout, None),
            counts: [0; 4],
            flags: CellFlags::new(layout.cells.len(), layout.own.clone()),
            fluid_cells: layout.own.len(),
            changes: ChangeBlocks::new(&layout.grid),
            layout,
            relaxation,
            tau,
            parity: Parity::Even,
            steps: 0,
            statistics: CellStatistics { min_drho: 0.0, max_drho: 0.0, ..CellStatistics::NONE },
        }
    }

    /// The fluid before the next collision.
    pub fn before(&self) -> PreCollision<'_, T> {
        PreCollision {
            field: &self.field,
            layout: &self.layout,
            parity: self.parity,
            acceleration: self.relaxation.acceleration,
        }
    }

    /// Begins to bring the copies of other ranks' cells up to date. Until [`LatticeState::end_refresh`] nothing may look
    /// at copies; own cells may collide.
    pub fn begin_refresh(&mut self, ranks: &mut Ranks) {
        let Some(way) = ranks.way() else { return };
        let Self { layout, field, flags, parity, halo, .. } = self;
        halo.begin(layout, (field, flags), *parity, way);
    }

    /// Ends it, if it is under way.
    pub fn end_refresh(&mut self, ranks: &mut Ranks) {
        let Some(way) = ranks.way() else { return };
        let Self { layout, field, flags, parity, halo, .. } = self;
        halo.end(layout, (field, flags), *parity, way);
    }

    /// Counts cells at the end of a step.
    pub fn count_cells(&mut self, ranks: &mut Ranks) {
        let (flags, layout) = (&self.flags, &self.layout);
        let covered = flags.covered.iter().filter(|&&cell| layout.is_own(cell)).count();
        let vacated = flags.vacated.iter().filter(|vacated| layout.is_own(vacated.cell)).count();
        self.counts = [covered, vacated, flags.isolated, flags.frozen].map(|count| count as i64);
        ranks.count(&mut self.counts);
    }

    /// Time that has passed [s].
    pub fn time(&self) -> f64 {
        self.steps as f64 * self.units.time_step
    }

    /// Mean density of the fluid in the last collision.
    pub fn mean_density(&self) -> f64 {
        1.0 + self.statistics.excess / (self.fluid_cells as f64).max(1.0)
    }

    /// Notes where cells joined the fluid or left it in this step.
    pub fn note_changes(&mut self) {
        let CellFlags { covered, enclosed, vacated, .. } = &self.flags;
        let changed = covered.iter().chain(enclosed).copied();
        let changed = changed.chain(vacated.iter().map(|vacated| vacated.cell));
        self.changes.begin(&self.layout, changed);
    }

    /// Keeps populations and cells, or puts them back; `is_alive` says of a handle whether its body
    /// lives.
    ///
    /// # Errors
    /// A state of another lattice, or of one in the other precision.
    pub fn exchange(
        &mut self,
        state: &mut StateExchange<'_>,
        is_alive: impl Fn(u32) -> bool,
    ) -> Result<(), StateError> {
        state.value("steps", &mut self.steps)?;
        // It says where the populations are.
        self.parity = Parity::after(self.steps);
        self.exchange_populations(state)?;
        self.flags.exchange(state, &self.numbers, is_alive)?;
        state.value("statistics", &mut self.statistics)
    }

    /// The populations that the next collision finds, cell by cell.
    fn exchange_populations(&self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let (restores, rows) = (state.restores(), self.numbers.rows_of(1));
        let Self { layout, field, parity, numbers, .. } = self;
        state.shared_array("populations", &rows, |first, mut rows: &mut [T::Row]| {
            let Some(mut cell) = numbers.here(first as u32) else { return };
            while !rows.is_empty() {
                // Up to the end of a line at a time.
                let count = (T::LINE - cell as usize % T::LINE).min(rows.len());
                let (run, rest) = rows.split_at_mut(count);
                for i in 0..Q {
                    match layout.places.of_line(*parity, cell as usize / T::LINE, i) {
                        Some(place) => {
                            let place = place + cell as usize % T::LINE;
                            field.exchange_column(place, i, run, restores);
                        }
                        None => {
                            for (cell, row) in (cell..).zip(run.chunks_mut(1)) {
                                let place = layout.places.of(*parity, cell, i);
                                field.exchange_column(place, i, row, restores);
                            }
                        }
                    }
                }
                (cell, rows) = (cell + count as u32, rest);
            }
        })
    }

    /// Finds numbers that follow from a state that was put back.
    pub fn recount(&mut self, ranks: &mut Ranks) {
        let mut cells = [self.flags.fluid_cells as i64];
        ranks.count(&mut cells);
        self.fluid_cells = cells[0] as usize;
        self.count_cells(ranks);
    }

    /// Puts all cells into local equilibrium; see [`crate::LbmFluid::set_state`].
    pub fn set_state(&mut self, state: impl Fn([f64; 3]) -> ([f64; 3], f64)) {
        let a = self.relaxation.acceleration;
        for cell in 0..self.layout.cells.len() as u32 {
            let (u, pressure) = state(self.units.centre(self.layout.at(cell)));
            let drho = pressure / self.units.pressure() / CS2;
            // Without half the force, which outputs and the collision add: see
            // `Content::velocity`.
            let u = std::array::from_fn(|k| u[k] / self.units.velocity() - 0.5 * a[k]);
            self.before().put(cell, &equilibria(drho, u));
        }
    }

    /// Memory that populations and tables take [bytes].
    pub fn bytes(&self) -> usize {
        Field::<T>::bytes(self.layout.places.stride() as u64) as usize
            + self.layout.cells.bytes()
            + self.layout.places.bytes()
            + self.flags.bytes()
            + self.changes.bytes()
    }
}
