//! Open faces with what they prescribe, and reservoirs behind faces.

use crate::boundary::boundaries::Built;
use crate::boundary::face_scheme::{FaceScheme, PostStreaming, StepBegin};
use crate::boundary::post_collision::PostCollision;
use crate::boundary::virtual_piston::face::ReservoirFace;
use crate::boundary::virtual_piston::part_surface::ReservoirSurface;
use crate::boundary::virtual_piston::reservoir_state::ReservoirState;
use crate::lattice::error::FluidError;
use crate::lattice::exact_sum::{ExactSum, values};
use crate::lattice::populations::Real;
use crate::lattice::units::Units;
use crate::lattice::whole_numbers::WholeNumbers;
use crate::ranks::rank_sums::Ranks;
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
    /// Parts with a reservoir.
    pub surfaces: Vec<ReservoirSurface>,
    /// Cells at pressure faces through which fluid entered in the last step.
    pub entering: usize,
}

impl<T: Real> OpenBoundaries<T> {
    /// Of the faces that were found.
    pub fn new(built: &mut Built<T>) -> Self {
        Self {
            faces: std::mem::take(&mut built.faces),
            reservoirs: std::mem::take(&mut built.reservoirs),
            surfaces: std::mem::take(&mut built.surfaces),
            entering: 0,
        }
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.faces.is_empty() && self.reservoirs.is_empty() && self.surfaces.is_empty()
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
    pub fn exchange(
        &mut self,
        state: &mut StateExchange<'_>,
        numbers: &WholeNumbers,
    ) -> Result<(), StateError> {
        let mut all = self.schemes().enumerate();
        all.try_for_each(|(k, scheme)| {
            state.within(&format!("{k}"), |state| scheme.exchange(state, numbers))
        })?;
        drop(all);
        self.surfaces.iter_mut().enumerate().try_for_each(|(k, surface)| {
            state.within(&format!("surface_{k}"), |state| surface.exchange(state))
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
        self.surfaces.iter_mut().try_for_each(|surface| surface.begin(begin.time, begin.units))?;
        self.schemes().try_for_each(|scheme| scheme.begin(&begin, &mut exec.team))
    }

    /// Finds what comes back from reservoirs behind parts, before any link is reflected.
    pub fn read_surfaces(&mut self, after: &PostCollision<T>, exec: &mut Execution) {
        let Execution { team, ranks, .. } = exec;
        self.surfaces.iter_mut().for_each(|surface| surface.read(after, team, ranks));
    }

    /// Lets it come back, after all other links are reflected. `references` are the points about which
    /// torques count, by fixture.
    ///
    /// # Errors
    /// A flow from a reservoir that is too fast for the lattice.
    pub fn write_surfaces(
        &mut self,
        after: &PostCollision<T>,
        references: &[[f64; 3]],
        units: &Units,
        exec: &mut Execution,
    ) -> Result<(), FluidError> {
        self.surfaces.iter_mut().try_for_each(|surface| {
            let reference = references[usize::from(surface.fixture.0)];
            surface.write(after, reference, units, (&mut exec.team, &mut exec.ranks))
        })
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
        self.schemes().try_for_each(|scheme| scheme.apply(&next, &mut exec.team, &mut exec.ranks))
    }

    /// Momentum along each axis, and mass, that the fluid gained in the last step.
    pub fn gained(&self, ranks: &mut Ranks) -> [f64; 4] {
        let mut sums = [ExactSum::default(); 4];
        let mut add = |impulse: [f64; 3], mass: f64| {
            let gain = impulse.into_iter().chain([mass]);
            sums.iter_mut().zip(gain).for_each(|(sum, gain)| sum.add(gain));
        };
        self.faces.iter().for_each(|face| face.each_gain(&mut add));
        let reservoirs = self.reservoirs.iter().map(|face| face as &dyn FaceScheme<T>);
        reservoirs.for_each(|face| face.each_gain(&mut add));
        ranks.add_up(&mut sums);
        values(&sums)
    }

    /// Gives the reservoirs the mean density and velocity of the cells at their faces.
    pub fn fill_reservoirs(&mut self, lattice: &LatticeState<T>, ranks: &mut Ranks) {
        let (before, layout) = (lattice.before(), &lattice.layout);
        let surfaces = self.surfaces.iter_mut();
        surfaces.for_each(|surface| surface.fill(&before, &lattice.flags, ranks));
        for reservoir in &mut self.reservoirs {
            let (axis, inward) = (reservoir.axis(), reservoir.inward());
            let mut sums = [ExactSum::default(); 3];
            let counts = |&cell: &u32| layout.is_own(cell) && lattice.flags.is_fluid(cell);
            for cell in reservoir.cells().filter(counts) {
                let content = before.content(cell);
                sums[0].add(1.0);
                sums[1].add(content.drho);
                sums[2].add(inward * content.j[axis] / (1.0 + content.drho));
            }
            ranks.add_up(&mut sums);
            let [count, drho, velocity] = values(&sums);
            reservoir.fill(drho / f64::max(count, 1.0), velocity / f64::max(count, 1.0));
        }
    }

    /// Number of the reservoir's face that a sphere lies across.
    pub fn crossed_by(&self, x: [f64; 3], radius: f64, grid: &Grid) -> Option<usize> {
        self.reservoirs.iter().position(|face| face.distance(x, grid) < radius)
    }

    /// See [`crate::LbmFluid::reservoirs`].
    pub fn states(&self, lattice: &LatticeState<T>) -> impl Iterator<Item = ReservoirState> {
        let (acceleration, units) = (lattice.relaxation.acceleration, &lattice.units);
        let of_faces =
            self.reservoirs.iter().map(move |reservoir| reservoir.state(acceleration, units));
        of_faces.chain(self.surfaces.iter().map(move |surface| surface.state(units)))
    }

    /// Counts the cells at pressure faces through which fluid enters.
    pub fn count_entering(&mut self, ranks: &mut Ranks) {
        if !self.faces.is_empty() {
            let mut count = [self.faces.iter().map(|face| face.entering()).sum::<usize>() as i64];
            ranks.count(&mut count);
            self.entering = count[0] as usize;
        }
    }

    /// Memory that the tables take [bytes].
    pub fn bytes(&self) -> usize {
        let reservoirs = self.reservoirs.iter().map(|face| face as &dyn FaceScheme<T>);
        let faces = self.faces.iter().map(|face| &**face as &dyn FaceScheme<T>);
        let of_surfaces: usize = self.surfaces.iter().map(ReservoirSurface::bytes).sum();
        faces.chain(reservoirs).map(FaceScheme::bytes).sum::<usize>() + of_surfaces
    }
}
