//! What a physics component implements: one trait a role, with as few methods as the physics allows.

use crate::setup::Setup;
use tremie_messages::frame::{SliceHeader, SliceNode, VolumeHeader};
use tremie_messages::start::{Description, VolumeGrid};
use tremie_messages::{BodyEvent, BodyState, Load, Problem};

/// A solver failed: a sentence that says what, where, found, expected, what to do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct SolverError(pub String);

impl SolverError {
    /// From any error.
    pub fn from_error(error: impl std::error::Error) -> Self {
        Self(error.to_string())
    }
}

/// A fluid: takes poses of bodies, gives loads on them.
///
/// All values in SI units, world frame. `bodies` and `loads` have equal lengths and the same order
/// (ascending ids).
pub trait Fluid: Sized {
    /// Name and version of the program.
    const PROGRAM: &'static str;

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

    /// Pushes the values of the signals, in the order of the description.
    fn signals(&mut self, values: &mut Vec<f64>);

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

    /// Pushes the values of the signals, in the order of the description.
    fn signals(&mut self, values: &mut Vec<f64>);

    /// Work done in one substep, in the description's unit.
    fn work(&self) -> u64 {
        self.count() as u64
    }
}
