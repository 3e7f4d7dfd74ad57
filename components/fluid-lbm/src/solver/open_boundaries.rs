//! Open faces with what they prescribe, and reservoirs behind faces.

use crate::boundary::boundaries::Built;
use crate::boundary::face_scheme::{FaceScheme, PostStreaming, StepBegin};
use crate::boundary::virtual_piston::face::{ReservoirFace, ReservoirState};
use crate::lattice::error::FluidError;
use crate::lattice::populations::Real;
use crate::solver::execution::Execution;
use crate::solver::lattice_state::LatticeState;
use crate::solver::static_boundaries::StaticBoundaries;
use tremie_fluid_kit::cells::grid::Grid;
use tremie_state::{StateError, StateExchange};

/// The faces through which fluid enters and leaves.
pub struct OpenBoundaries<T: Real> {
    /// Faces that prescribe velocity or pressure.
    faces: Vec<Box<dyn FaceScheme<T>>>,
    /// Faces with a reservoir.
    pub reservoirs: Vec<ReservoirFace>,
}

impl<T: Real> OpenBoundaries<T> {
    /// Of the faces that were found.
    pub fn new(built: &mut Built<T>) -> Self {
        Self {
            faces: std::mem::take(&mut built.faces),
            reservoirs: std::mem::take(&mut built.reservoirs),
        }
    }

    /// All schemes; reservoirs first, because other faces read the cells inside.
    fn schemes(&mut self) -> impl Iterator<Item = &mut dyn FaceScheme<T>> {
        let reservoirs = self.reservoirs.iter_mut().map(|face| face as &mut dyn FaceScheme<T>);
        reservoirs.chain(self.faces.iter_mut().map(|face| &mut **face as &mut dyn FaceScheme<T>))
    }

    /// Keeps what the faces know from earlier steps, or puts it back.
    ///
    /// # Errors
    /// A state of other faces.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let mut all = self.schemes().enumerate();
        all.try_for_each(|(k, scheme)| {
            state.within(&format!("{k}"), |state| scheme.exchange(state))
        })
    }

    /// Begins a step: moves the pistons of reservoirs.
    ///
    /// # Errors
    /// A reservoir that is spent.
    pub fn begin(
        &mut self,
        lattice: &LatticeState<T>,
        exec: &mut Execution,
    ) -> Result<(), FluidError> {
        let begin = StepBegin {
            before: lattice.before(),
            flags: &lattice.flags,
            time: lattice.time(),
            units: &lattice.units,
        };
        self.schemes().try_for_each(|scheme| scheme.begin(&begin, &mut exec.team))
    }

    /// Gives the cells at open faces their populations.
    ///
    /// # Errors
    /// A flow from a reservoir that is too fast for the lattice.
    pub fn apply(
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
            density: lattice.mean_density(),
            now: &walls.now,
            brought: &walls.brought,
            units: &lattice.units,
            variant: exec.variant,
        };
        self.schemes().try_for_each(|scheme| scheme.apply(&next, &mut exec.team))
    }

    /// Calls `add` with momentum and mass that the fluid gained in the last step, piece by piece.
    pub fn each_gain(&self, mut add: impl FnMut([f64; 3], f64)) {
        self.faces.iter().for_each(|face| face.each_gain(&mut add));
        let reservoirs = self.reservoirs.iter().map(|face| face as &dyn FaceScheme<T>);
        reservoirs.for_each(|face| face.each_gain(&mut add));
    }

    /// Gives the reservoirs the mean density and velocity of the cells at their faces.
    pub fn fill_reservoirs(&mut self, lattice: &LatticeState<T>) {
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
    pub fn states(&self, lattice: &LatticeState<T>) -> impl Iterator<Item = ReservoirState> {
        let (acceleration, units) = (lattice.relaxation.acceleration, &lattice.units);
        self.reservoirs.iter().map(move |reservoir| reservoir.state(acceleration, units))
    }

    /// Cells at pressure faces through which fluid enters.
    pub fn entering(&self) -> usize {
        self.faces.iter().map(|face| face.entering()).sum()
    }

    /// Memory that the tables take [bytes].
    pub fn bytes(&self) -> usize {
        let reservoirs = self.reservoirs.iter().map(|face| face as &dyn FaceScheme<T>);
        let faces = self.faces.iter().map(|face| &**face as &dyn FaceScheme<T>);
        faces.chain(reservoirs).map(FaceScheme::bytes).sum()
    }
}
