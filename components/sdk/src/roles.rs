//! Traits of physics components: one trait a role, with as few methods as the physics allows.

use crate::setup::Setup;
use tremie_messages::frame::{ProfileBin, ProfileHeader, SliceHeader, SliceNode, VolumeHeader};
use tremie_messages::scene::{BodySet, Placement};
use tremie_messages::start::{Description, VolumeGrid};
use tremie_messages::{
    BodyEvent, BodyState, FacetLoad, Load, Place, PortState, Problem, SurfaceVertex,
};
use tremie_state::{StateError, StateExchange};

/// A solver failed: a sentence that says what, where, found, expected, what to do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct SolverError(pub String);

impl SolverError {
    /// From any error.
    pub fn from_error(error: impl std::error::Error) -> Self {
        Self(error.to_string())
    }

    /// Of a solver that has no ports, as it says itself, and is asked for them.
    fn no_ports(program: &str) -> Self {
        Self(format!("{program} has no velocities at open faces"))
    }

    /// Of a solver that takes no deformable surfaces, as it says itself, and is given some.
    fn no_surfaces(program: &str) -> Self {
        Self(format!("{program} takes no deformable surfaces"))
    }
}

/// Of a program that keeps no state, as it says itself, and is asked for one.
pub(crate) fn no_state(program: &str) -> StateError {
    StateError::Unfit(format!("{program} keeps no state"))
}

/// Refuses a scene with deformable surfaces for a program that does not take them.
pub(crate) fn check_surfaces(
    setup: &Setup,
    program: &str,
    takes_surfaces: bool,
) -> Result<(), Vec<Problem>> {
    if takes_surfaces || setup.hello.scene.surfaces.is_empty() {
        return Ok(());
    }
    let message = format!("{program} takes no deformable surfaces");
    let help = "take another program for its role, or leave out scene.surfaces and the rubber";
    Err(vec![Problem::new("scene.surfaces[0]", message).help(help)])
}

/// Refuses polyhedra where `program` does not take any.
pub(crate) fn check_polyhedra(
    setup: &Setup,
    program: &str,
    takes_polyhedra: bool,
) -> Result<(), Vec<Problem>> {
    let is_polyhedra = |set: &BodySet| matches!(set.placement, Placement::Polyhedra(_));
    let bodies = &setup.hello.scene.bodies;
    match bodies.iter().position(is_polyhedra).filter(|_| !takes_polyhedra) {
        None => Ok(()),
        Some(set) => {
            let message = format!("{program} takes no polyhedra");
            let help =
                "take spheres, another program for its role, or leave the role out: a dry run";
            Err(vec![Problem::new(format!("scene.bodies[{set}].placement"), message).help(help)])
        }
    }
}

/// A fluid: takes poses of bodies, gives loads on them.
///
/// All values in SI units, world frame. `bodies` and `loads` have equal lengths and the same order
/// (ascending ids).
pub trait Fluid: Sized {
    /// Name and version of the program.
    const PROGRAM: &'static str;

    /// Name and version as the program describes itself: another than `PROGRAM` only where one program
    /// serves whatever a user wrote.
    fn program() -> String {
        Self::PROGRAM.into()
    }

    /// True if it takes deformable surfaces: [`Fluid::surface`] and [`Fluid::surface_loads`]. A
    /// scene with some is refused otherwise.
    const TAKES_SURFACES: bool = false;

    /// True if it tells the velocities at open faces: [`Fluid::ports`]. A scene whose inlets take
    /// them is refused otherwise.
    const TELLS_PORTS: bool = false;

    /// True if bodies may be polyhedra: events of [`BodyEvent::POLYHEDRON`]. A scene with some is
    /// refused otherwise.
    fn takes_polyhedra() -> bool {
        false
    }

    /// Checks scene and parameters, and says what the fluid needs. Cheap; allocates no field.
    ///
    /// # Errors
    /// Every problem of the input.
    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>>;

    /// Builds the solver for the assigned step ([`Setup::assignment`] is there).
    ///
    /// # Errors
    /// Every problem of the input.
    fn create(setup: &Setup) -> Result<Self, Vec<Problem>>;

    /// Bodies that appear or disappear; effective with the next bodies.
    ///
    /// # Errors
    /// If a body cannot be taken.
    fn events(&mut self, events: &[BodyEvent]) -> Result<(), SolverError>;

    /// The start exchange: looks at the bodies, lets no time pass, gives the loads on them.
    ///
    /// # Errors
    /// If the solver fails.
    fn start(&mut self, bodies: &[BodyState], loads: &mut [Load]) -> Result<(), SolverError>;

    /// Advances through one window in `substeps` steps of the assigned length, and gives the loads
    /// that the bodies felt, buoyancy included.
    ///
    /// # Errors
    /// If the solver fails.
    fn advance(
        &mut self,
        substeps: u32,
        bodies: &[BodyState],
        loads: &mut [Load],
    ) -> Result<(), SolverError>;

    /// The deformable surfaces as they are with the bodies of the next [`Fluid::start`] or
    /// [`Fluid::advance`]: all vertices, numbered as `tremie_geometry::Turned` does it. Called only
    /// in runs that have some.
    ///
    /// # Errors
    /// If the solver fails, or has no such surfaces.
    fn surface(&mut self, _vertices: &[SurfaceVertex]) -> Result<(), SolverError> {
        Err(SolverError::no_surfaces(Self::PROGRAM))
    }

    /// Pushes the loads on the facets of the deformable surfaces that the last [`Fluid::start`] or
    /// [`Fluid::advance`] found; there is room for [`FacetLoad::MOST_PER_FACET`] times the facets.
    /// Loads on the parts that carry them do not count them.
    ///
    /// # Errors
    /// If the solver fails, or has no such surfaces.
    fn surface_loads(&mut self, _loads: &mut Vec<FacetLoad>) -> Result<(), SolverError> {
        Err(SolverError::no_surfaces(Self::PROGRAM))
    }

    /// Sets the velocities of `ports`, whose faces are given, as they are after the last
    /// [`Fluid::start`] or [`Fluid::advance`]. Called only in runs in which inlets of grains take
    /// them.
    ///
    /// # Errors
    /// If the solver fails, or does not know them.
    fn ports(&mut self, _ports: &mut [PortState]) -> Result<(), SolverError> {
        Err(SolverError::no_ports(Self::PROGRAM))
    }

    /// Names the state at a window's end once for both ways, to keep it and to put it back into a fluid
    /// made anew from the same scene. Called only where the description has a version of the
    /// state ([`Description::state`]).
    ///
    /// # Errors
    /// A state that is damaged or another's; a solver that keeps none.
    fn exchange_state(&mut self, _state: &mut StateExchange<'_>) -> Result<(), StateError> {
        Err(no_state(Self::PROGRAM))
    }

    /// Pushes the values of the signals, in the order of the description; without those that are
    /// sampled.
    fn signals(&mut self, values: &mut Vec<f64>);

    /// Pushes the values of the signals that the description calls sampled; there they follow all
    /// others. Called in windows whose row is kept, and where an observer looks.
    fn sampled(&mut self, _values: &mut Vec<f64>) {}

    /// A row of the signals was kept: means over time from row to row begin anew.
    fn row_kept(&mut self) {}

    /// Place at which the signal of that name, one that the run watches ([`Limit::watch`]), has its
    /// value now; `None` where the fluid does not know. It may take time: it is asked when a limit is
    /// passed.
    ///
    /// [`Limit::watch`]: tremie_messages::Limit::watch
    fn place(&self, _signal: &str) -> Option<Place> {
        None
    }

    /// Work done in one substep, in the description's unit.
    fn work(&self) -> u64 {
        0
    }

    /// Fills the cut `name` of the description.
    fn slice(&mut self, _name: &str, _nodes: &mut [SliceNode]) -> SliceHeader {
        SliceHeader::default()
    }

    /// Fills the nodes of `grid`, a part of a volume of the description.
    fn volume(&mut self, _grid: &VolumeGrid, _nodes: &mut [SliceNode]) -> VolumeHeader {
        VolumeHeader::default()
    }
}

/// Grains: take loads on bodies, give their poses and the events of their lives.
///
/// All values in SI units, world frame; bodies in ascending order of their ids.
pub trait Grains: Sized {
    /// Name and version of the program.
    const PROGRAM: &'static str;

    /// Name and version as the program describes itself: another than `PROGRAM` only where one program
    /// serves whatever a user wrote.
    fn program() -> String {
        Self::PROGRAM.into()
    }

    /// True if they take deformable surfaces: all methods from [`Grains::carriers`] on. A scene
    /// with some is refused otherwise.
    const TAKES_SURFACES: bool = false;

    /// True if they take velocities at open faces for the bodies that come there:
    /// [`Grains::ports`]. A scene whose inlets take them is refused otherwise.
    const TAKES_PORTS: bool = false;

    /// True if bodies may be polyhedra. A scene with some is refused otherwise.
    fn takes_polyhedra() -> bool {
        false
    }

    /// Checks scene and parameters, and says what the grains need.
    ///
    /// # Errors
    /// Every problem of the input.
    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>>;

    /// Builds the solver for the assigned step ([`Setup::assignment`] is there).
    ///
    /// # Errors
    /// Every problem of the input.
    fn create(setup: &Setup) -> Result<Self, Vec<Problem>>;

    /// Bodies that appeared or disappeared at the end of the last window; before the first, the
    /// initial bodies.
    fn events(&self) -> &[BodyEvent];

    /// Number of living bodies.
    fn count(&self) -> usize;

    /// Writes the state of all living bodies.
    fn state(&self, bodies: &mut [BodyState]);

    /// Advances through one window in `substeps` steps of the assigned length, each under the same
    /// loads. No loads (an empty slice) where no fluid sits opposite.
    ///
    /// # Errors
    /// If the solver fails.
    fn advance(&mut self, substeps: u32, loads: &[Load]) -> Result<(), SolverError>;

    /// The fluid's velocities at the faces that the scene's inlets name, for the window that comes
    /// next: as the fluid found them in the window before it.
    ///
    /// # Errors
    /// If the solver fails, or does not take them.
    fn ports(&mut self, _ports: &[PortState]) -> Result<(), SolverError> {
        Err(SolverError::no_ports(Self::PROGRAM))
    }

    /// Names the state at a window's end once for both ways, to keep it and to put it back into grains
    /// made anew from the same scene. Called only where the description has a version of the
    /// state ([`Description::state`]).
    ///
    /// # Errors
    /// A state that is damaged or another's; a solver that keeps none.
    fn exchange_state(&mut self, _state: &mut StateExchange<'_>) -> Result<(), StateError> {
        Err(no_state(Self::PROGRAM))
    }

    /// Puts bodies and contacts of a state back, which [`Grains::exchange_state`] of another run named:
    /// one of the same bodies, parts and laws of contact, with or without a fluid. Time begins with
    /// them, and so do sums and means. The sdk announces all bodies that there are then.
    ///
    /// # Errors
    /// A state that is damaged or does not fit; grains that cannot begin so.
    fn take_bodies(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.unfit(format!("{} takes no bodies of another run", Self::PROGRAM))
    }

    /// Pushes the values of the signals, in the order of the description. Those that the
    /// description calls sampled are reported only in windows whose row is kept.
    fn signals(&mut self, values: &mut Vec<f64>);

    /// A row of the signals was kept: means over time from row to row begin anew.
    fn row_kept(&mut self) {}

    /// Place at which the signal of that name, one that the run watches ([`Limit::watch`]), has its
    /// value now; `None` where the grains do not know. It may take time: it is asked when a limit is
    /// passed.
    ///
    /// [`Limit::watch`]: tremie_messages::Limit::watch
    fn place(&self, _signal: &str) -> Option<Place> {
        None
    }

    /// Writes the force of contacts on each living body as it is at the window's end, in the order of
    /// [`Grains::state`] [N]; `false` where the grains do not know it. Called only when an observer
    /// looks; nothing that follows may depend on it.
    fn contact_forces(&self, _forces: &mut [[f64; 3]]) -> bool {
        false
    }

    /// Work done in one substep, in the description's unit.
    fn work(&self) -> u64 {
        self.count() as u64
    }

    /// True if a table of the scene's profile of that name, one of the description's, has ended with
    /// the last window; with `is_last` the run has ended with it, and a table that was begun counts.
    fn has_profile(&self, _name: &str, _is_last: bool) -> bool {
        false
    }

    /// Fills the bins of that table, and tells its times and samples; the sdk sets the stamp.
    /// Before the first window it has no samples.
    fn profile(&mut self, _name: &str, _bins: &mut [ProfileBin]) -> ProfileHeader {
        ProfileHeader::default()
    }

    /// States of the parts that carry the scene's deformable surfaces, as they are now, one for
    /// each surface. Their ids are set by the sdk.
    ///
    /// # Errors
    /// If the solver has no such surfaces.
    fn carriers(&self, _carriers: &mut [BodyState]) -> Result<(), SolverError> {
        Err(SolverError::no_surfaces(Self::PROGRAM))
    }

    /// In runs with deformable surfaces: begins a window, in place of [`Grains::advance`]. Then
    /// each substep is [`Grains::begin_substep`], [`Grains::contacts`] for each trial and
    /// [`Grains::finish_substep`]; after the last comes [`Grains::end_window`].
    ///
    /// # Errors
    /// If the solver fails, or has no such surfaces.
    fn begin_window(&mut self, _substeps: u32, _loads: &[Load]) -> Result<(), SolverError> {
        Err(SolverError::no_surfaces(Self::PROGRAM))
    }

    /// Takes all bodies to where they are at the end of the next substep, before the forces there
    /// are known.
    ///
    /// # Errors
    /// If the solver fails, or has no such surfaces.
    fn begin_substep(&mut self) -> Result<(), SolverError> {
        Err(SolverError::no_surfaces(Self::PROGRAM))
    }

    /// Pushes the loads of contacts on the facets of a trial of the deformable surfaces; there is
    /// room for [`FacetLoad::MOST_PER_FACET`] times the facets. Changes nothing that a later call
    /// could tell.
    ///
    /// # Errors
    /// If the solver fails, or has no such surfaces.
    fn contacts(
        &mut self,
        _vertices: &[SurfaceVertex],
        _loads: &mut Vec<FacetLoad>,
    ) -> Result<(), SolverError> {
        Err(SolverError::no_surfaces(Self::PROGRAM))
    }

    /// Ends the substep with the accepted surfaces: finds all forces, those of contacts with the
    /// surfaces among them, and hands each surface's carrier the surface's contacts and, of
    /// `resultants`, what besides acts on the surface.
    ///
    /// # Errors
    /// If the solver fails, or has no such surfaces.
    fn finish_substep(
        &mut self,
        _vertices: &[SurfaceVertex],
        _resultants: &[Load],
    ) -> Result<(), SolverError> {
        Err(SolverError::no_surfaces(Self::PROGRAM))
    }

    /// Ends the window, after its last substep.
    ///
    /// # Errors
    /// If the solver fails, or has no such surfaces.
    fn end_window(&mut self) -> Result<(), SolverError> {
        Err(SolverError::no_surfaces(Self::PROGRAM))
    }
}

/// Rubber: shapes deformable surfaces under the loads on them, in substeps of the grains.
///
/// All values in SI units, world frame. `carriers` has the state of the part that carries each
/// surface, in the scene's order; its `id` is the surface's number.
pub trait Rubber: Sized {
    /// Name and version of the program.
    const PROGRAM: &'static str;

    /// Name and version as the program describes itself: another than `PROGRAM` only where one program
    /// serves whatever a user wrote.
    fn program() -> String {
        Self::PROGRAM.into()
    }

    /// Checks scene and parameters, and says what the rubber needs. A `step` is the longest that it
    /// can take; it makes the grains' substeps.
    ///
    /// # Errors
    /// Every problem of the input.
    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>>;

    /// Builds the solver for the assigned step ([`Setup::assignment`] is there).
    ///
    /// # Errors
    /// Every problem of the input.
    fn create(setup: &Setup) -> Result<Self, Vec<Problem>>;

    /// The start exchange: takes the surfaces to where their carriers are; lets no time pass.
    ///
    /// # Errors
    /// If the solver fails.
    fn start(&mut self, carriers: &[BodyState]) -> Result<(), SolverError>;

    /// Begins a window, with the fluid's loads on the facets, constant through it; none where no
    /// fluid sits opposite.
    ///
    /// # Errors
    /// If the solver fails.
    fn begin_window(&mut self, loads: &[FacetLoad]) -> Result<(), SolverError>;

    /// Begins a substep, at whose end the carriers will be where `carriers` says.
    ///
    /// # Errors
    /// If the solver fails.
    fn begin_substep(&mut self, carriers: &[BodyState]) -> Result<(), SolverError>;

    /// Writes all vertices as they are now: the start, a trial, or what was accepted.
    fn surface(&self, vertices: &mut [SurfaceVertex]);

    /// Writes the equivalent shear strain at each vertex as it is now, as
    /// [`SurfaceSample::strain`](tremie_messages::frame::SurfaceSample::strain) has it. Called only
    /// when an observer looks; nothing that follows may depend on it.
    fn strains(&self, strains: &mut [f64]) {
        strains.fill(f64::NAN);
    }

    /// Takes the loads of contacts on the trial; `true` if the surfaces are settled by it, else
    /// there is another trial now.
    ///
    /// # Errors
    /// If the solver fails.
    fn pass(&mut self, contacts: &[FacetLoad]) -> Result<bool, SolverError>;

    /// Writes what the surfaces pass on to their carriers besides the contacts: force, and torque
    /// about the carrier's reference point, one for each surface. Ids are set by the sdk.
    fn resultants(&self, loads: &mut [Load]);

    /// Names the state at a window's end once for both ways, to keep it and to put it back into a rubber
    /// made anew from the same scene. Called only where the description has a version of the
    /// state ([`Description::state`]).
    ///
    /// # Errors
    /// A state that is damaged or another's; a solver that keeps none.
    fn exchange_state(&mut self, _state: &mut StateExchange<'_>) -> Result<(), StateError> {
        Err(no_state(Self::PROGRAM))
    }

    /// Pushes the values of the signals, in the order of the description.
    fn signals(&mut self, values: &mut Vec<f64>);

    /// Place at which the signal of that name, one that the run watches ([`Limit::watch`]), has its
    /// value now; `None` where the rubber does not know. It may take time: it is asked when a limit is
    /// passed.
    ///
    /// [`Limit::watch`]: tremie_messages::Limit::watch
    fn place(&self, _signal: &str) -> Option<Place> {
        None
    }

    /// Work done in one substep, in the description's unit.
    fn work(&self) -> u64 {
        0
    }
}
