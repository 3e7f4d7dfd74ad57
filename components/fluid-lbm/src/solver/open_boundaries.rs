//! Open faces with what they prescribe, and reservoirs behind faces.

use crate::boundary::boundaries::Built;
use crate::boundary::open_boundary::{OpenCells, OpenItem, PostStreaming};
use crate::boundary::virtual_piston::face::{ReservoirFace, ReservoirState};
use crate::domain::parameters::OpenFaces;
use crate::lattice::error::FluidError;
use crate::lattice::grid::Grid;
use crate::lattice::populations::Real;
use crate::lattice::units::Units;
use crate::solver::execution::Execution;
use crate::solver::lattice_state::LatticeState;
use crate::solver::static_boundaries::StaticBoundaries;

/// The faces through which fluid enters and leaves.
pub struct OpenBoundaries {
    /// Which scheme velocity and pressure faces use.
    scheme: OpenFaces,
    /// Cells at such faces.
    cells: OpenCells,
    /// Their items of work.
    pub items: Vec<OpenItem>,
    /// Faces with a reservoir.
    pub reservoirs: Vec<ReservoirFace>,
}

impl OpenBoundaries {
    /// Of the faces that were found.
    pub fn new(scheme: OpenFaces, built: &mut Built) -> Self {
        Self {
            scheme,
            cells: std::mem::take(&mut built.open),
            items: std::mem::take(&mut built.open_items),
            reservoirs: std::mem::take(&mut built.reservoirs),
        }
    }

    /// Moves the pistons of reservoirs through the step that begins at a time [s].
    ///
    /// # Errors
    /// A reservoir that is spent.
    pub fn advance_pistons(&mut self, begin: f64, units: &Units) -> Result<(), FluidError> {
        self.reservoirs.iter_mut().try_for_each(|reservoir| reservoir.advance(begin, units))
    }

    /// Gives the cells at open faces their populations; those at reservoirs first, because other faces
    /// read the cells inside.
    ///
    /// # Errors
    /// A flow from a reservoir that is too fast for the lattice.
    pub fn apply<T: Real>(
        &mut self,
        lattice: &LatticeState<T>,
        walls: &StaticBoundaries,
        exec: &mut Execution,
    ) -> Result<(), FluidError> {
        let next = PostStreaming {
            field: &lattice.field,
            layout: &lattice.layout,
            flags: &lattice.flags,
            parity: lattice.parity,
            acceleration: lattice.relaxation.acceleration,
            now: &walls.now,
            scheme: self.scheme,
            variant: exec.variant,
        };
        for reservoir in &mut self.reservoirs {
            reservoir.apply(&next, &mut exec.team, &lattice.units, &walls.brought)?;
        }
        let cells = &self.cells;
        exec.team.for_each(&mut self.items, |_, item| next.open(cells, item));
        if !self.items.is_empty() {
            let density = lattice.mean_density();
            self.cells.steer(&self.items, &walls.now, density, &walls.brought);
        }
        Ok(())
    }

    /// Calls `add` with momentum and mass that the fluid gained in the last step, piece by piece.
    pub fn each_gain(&self, mut add: impl FnMut([f64; 3], f64)) {
        self.items.iter().for_each(|item| add(item.impulse, item.mass));
        let gained = self.reservoirs.iter().flat_map(ReservoirFace::gained);
        gained.for_each(|(impulse, mass)| add(impulse, mass));
    }

    /// Gives the reservoirs the mean density and velocity of the cells at their faces.
    pub fn fill_reservoirs<T: Real>(&mut self, lattice: &LatticeState<T>) {
        let before = lattice.before();
        for reservoir in &mut self.reservoirs {
            let (axis, inward) = (reservoir.axis(), reservoir.inward());
            let (mut count, mut drho, mut velocity) = (0.0, 0.0, 0.0);
            for cell in reservoir.cells().filter(|&cell| lattice.flags.is_fluid(cell)) {
                let content = before.content(cell);
                count += 1.0;
                drho += content.drho;
                velocity += inward * content.j[axis] / (1.0 + content.drho);
            }
            reservoir.fill(drho / f64::max(count, 1.0), velocity / f64::max(count, 1.0));
        }
    }

    /// Gives a mass from a place in the domain back to the reservoir whose face is nearest [cells].
    pub fn take_back(&mut self, from: [f64; 3], mass: f64, grid: &Grid) {
        let distance = |reservoir: &ReservoirFace| reservoir.distance(from, grid);
        let nearest = self.reservoirs.iter_mut().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        if let Some(reservoir) = nearest {
            reservoir.take_back(mass);
        }
    }

    /// See [`crate::LbmFluid::reservoirs`].
    pub fn states<T: Real>(
        &self,
        lattice: &LatticeState<T>,
    ) -> impl Iterator<Item = ReservoirState> {
        let (acceleration, units) = (lattice.relaxation.acceleration, &lattice.units);
        self.reservoirs.iter().map(move |reservoir| reservoir.state(acceleration, units))
    }

    /// Cells at pressure faces through which fluid enters.
    pub fn entering(&self) -> usize {
        self.items.iter().map(|item| item.entering).sum()
    }

    /// Memory that the tables take [bytes].
    pub fn bytes(&self) -> usize {
        self.cells.bytes() + self.reservoirs.iter().map(ReservoirFace::bytes).sum::<usize>()
    }
}
