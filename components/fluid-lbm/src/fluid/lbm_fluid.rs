//! The fluid as its users see it: SI units outside, one precision or the other inside.

use crate::bodies::body::UnionShare;
use crate::boundary::virtual_piston::reservoir_state::ReservoirState;
use crate::domain::lattice_orientation::LatticeOrientation;
use crate::domain::parameters::{Parameters, Precision};
use crate::lattice::d3q19::LINKS;
use crate::lattice::error::FluidError;
use crate::lattice::ledger::Ledger;
use crate::lattice::populations::Real;
use crate::ranks::communicator::Communicator;
use crate::ranks::rank_sums::Ranks;
use crate::report::resolution::Resolution;
use crate::solver::diagnostics::{Diagnostics, Extreme, SliceNode};
use crate::solver::lbm_solver::LbmSolver;
use std::borrow::Cow;
use tremie_fluid_kit::survey::static_geometry::StaticGeometry;
use tremie_geometry::clump;
use tremie_messages::scene::{ProbeShape, Scene};
use tremie_messages::{BodyEvent, BodyState, FacetLoad, Load, PortState, Problem, SurfaceVertex};
use tremie_state::{KeepsState, StateError, StateExchange};
use tremie_team::{Found, Variant};

/// A lattice-Boltzmann fluid in a box, with moving bodies in it.
///
/// Everything here is by the world's axes. The lattice inside may lie along others, so that the
/// rows of its cells are long: how fast it is does not depend on how the scene lies.
pub struct LbmFluid {
    solver: Either,
    /// Those of the lattice.
    axes: LatticeOrientation,
    /// Room for what is turned into the lattice's axes, or back.
    states: Vec<BodyState>,
    vertices: Vec<SurfaceVertex>,
    ports: Vec<PortState>,
    /// The scene's probes.
    probes: Vec<ProbeShape>,
}

/// Shares of unions that bodies of each set displace, for clumps that are unions; empty for other
/// sets.
fn union_shares(scene: &Scene, axes: LatticeOrientation, cell: f64) -> Vec<Vec<UnionShare>> {
    let mut all = vec![Vec::new(); scene.bodies.len()];
    for piece in scene.unions.iter().flat_map(|name| clump(scene, name)) {
        let share = piece.share;
        all[piece.set].push(UnionShare {
            volume: share.volume / (cell * cell * cell),
            middle: axes.to_lattice(&share.centroid.into()).map(|x| x / cell),
            first: None,
            orientation: [0.0, 0.0, 0.0, 1.0],
        });
    }
    all
}

/// The solver in the precision that was chosen.
enum Either {
    F64(Box<LbmSolver<f64>>),
    F32(Box<LbmSolver<f32>>),
}

/// Calls a method of whichever solver is inside.
macro_rules! solver {
    ($fluid:expr, $solver:ident => $call:expr) => {
        match $fluid {
            Either::F64($solver) => $call,
            Either::F32($solver) => $call,
        }
    };
}

impl LbmFluid {
    /// A fluid at the scene's initial velocity, without bodies, on `threads` threads (the caller's
    /// included).
    ///
    /// `time_step` [s] is what the plan assigned, at most what [`Parameters::resolve`] asked for.
    ///
    /// # Errors
    /// Every problem of parameters and scene.
    pub fn new(
        scene: &Scene,
        parameters: &Parameters,
        time_step: f64,
        threads: usize,
    ) -> Result<Self, Vec<Problem>> {
        Self::with_variant(scene, parameters, time_step, threads, Variant::widest())
    }

    /// As [`LbmFluid::new`], with the given vector instructions; every variant computes the same
    /// bits.
    ///
    /// # Errors
    /// Every problem of parameters and scene.
    ///
    /// # Panics
    /// If this machine lacks the instructions ([`Variant::available`]).
    pub fn with_variant(
        scene: &Scene,
        parameters: &Parameters,
        time_step: f64,
        threads: usize,
        variant: Variant,
    ) -> Result<Self, Vec<Problem>> {
        Self::of_ranks(scene, parameters, time_step, (threads, variant), Ranks::default())
    }

    /// A share of the fluid as [`LbmFluid::with_variant`], whose other shares are where `way` leads. All ranks make
    /// the same calls in the same order, and each gets all of the results, the same bits as one rank alone.
    ///
    /// # Errors
    /// As [`LbmFluid::with_variant`], and more ranks than the lattice has blocks for.
    ///
    /// # Panics
    /// As [`LbmFluid::with_variant`].
    pub fn with_ranks(
        scene: &Scene,
        parameters: &Parameters,
        time_step: f64,
        (threads, variant): (usize, Variant),
        way: Box<dyn Communicator>,
    ) -> Result<Self, Vec<Problem>> {
        Self::of_ranks(scene, parameters, time_step, (threads, variant), Ranks::along(way))
    }

    fn of_ranks(
        scene: &Scene,
        parameters: &Parameters,
        time_step: f64,
        (threads, variant): (usize, Variant),
        ranks: Ranks,
    ) -> Result<Self, Vec<Problem>> {
        let (resolution, ground) = parameters.survey(scene)?;
        let line = line_of(parameters.precision);
        // The solver works by the lattice's axes: `own` is the scene turned to them.
        let (axes, own, ground) = turned(scene, &resolution, ground, line);
        let mut solver = match parameters.precision {
            Precision::F64 => Either::F64(Box::new(LbmSolver::on(
                ground,
                &own,
                parameters,
                time_step,
                (threads, variant),
                ranks,
            )?)),
            Precision::F32 => Either::F32(Box::new(LbmSolver::on(
                ground,
                &own,
                parameters,
                time_step,
                (threads, variant),
                ranks,
            )?)),
        };
        if !scene.unions.is_empty() {
            let shares = union_shares(scene, axes, parameters.cell.0);
            solver!(&mut solver, s => s.bodies.list.share_unions(shares));
        }
        Ok(Self {
            solver,
            axes,
            states: Vec::new(),
            vertices: Vec::new(),
            ports: Vec::new(),
            probes: scene.probes.iter().map(|probe| probe.shape.clone()).collect(),
        })
    }

    /// Finds out from now on whether a step is faster on all threads or on one, and goes on with
    /// that: either is tried for some steps, anew when there are half as many fluid cells again, or
    /// two thirds, and now and then. Results do not depend on it.
    pub fn choose_threads(&mut self) {
        solver!(&mut self.solver, s => s.exec.choose_threads());
    }

    /// Finding on the number of threads since this was asked last.
    pub fn take_found(&mut self) -> Option<Found> {
        solver!(&mut self.solver, s => s.exec.take_found())
    }

    /// Adds and removes bodies; effective with the next states.
    ///
    /// # Errors
    /// A body added twice or removed without being there, an unknown kind or shape, a radius that
    /// is not positive. The list is then not applied at all.
    pub fn apply_events(&mut self, events: &[BodyEvent]) -> Result<(), FluidError> {
        solver!(&mut self.solver, s => s.apply_events(events))
    }

    /// The start exchange: covers the cells inside the bodies and returns the loads at rest, which
    /// are buoyancy and the mean pressure gradient. No time passes.
    ///
    /// # Errors
    /// States that are not those of the living bodies, or not finite.
    pub fn start(&mut self, bodies: &[BodyState], loads: &mut [Load]) -> Result<(), FluidError> {
        let bodies = self.axes.bodies(bodies, &mut self.states);
        solver!(&mut self.solver, s => s.start(bodies, loads))
            .map_err(|error| self.axes.error(error))?;
        self.axes.turn_back_loads(loads);
        Ok(())
    }

    /// One time step. `bodies` are at its end; `loads`, in the same order, are the forces [N] and
    /// torques [N m] of the fluid on them, buoyancy included.
    ///
    /// # Errors
    /// States that are not those of the living bodies, or not finite; a reservoir that is spent, or
    /// whose flow is too fast for the lattice.
    pub fn step(&mut self, bodies: &[BodyState], loads: &mut [Load]) -> Result<(), FluidError> {
        let bodies = self.axes.bodies(bodies, &mut self.states);
        solver!(&mut self.solver, s => s.step(bodies, loads))
            .map_err(|error| self.axes.error(error))?;
        self.axes.turn_back_loads(loads);
        Ok(())
    }

    /// The deformable surfaces as they are at the end of the next step: all vertices of all
    /// surfaces of the scene, in their order, numbered as [`tremie_geometry::Turned`] does it.
    /// Needed before [`LbmFluid::start`] in a scene that has some; what was said last holds on.
    ///
    /// # Errors
    /// As many vertices as there are not, numbers that are not finite, and first vertices between
    /// which the surface is not closed or inside out.
    pub fn set_surfaces(&mut self, vertices: &[SurfaceVertex]) -> Result<(), FluidError> {
        let vertices = self.axes.vertices(vertices, &mut self.vertices);
        solver!(&mut self.solver, s => s.set_surfaces(vertices))
    }

    /// Forces [N] of the fluid in the last step on the facets of deformable surfaces, all of them
    /// in order, buoyancy included, each with a point of its line of action [m]: the nearest to the
    /// facet's middle, no farther away than its corners.
    ///
    /// On a surface whose reference (the origin of its section in the scene) lies on a symmetry
    /// plane, facets beyond the plane get nothing but what links through the mirror meet there, and
    /// all others twice what they feel: sums over facets that lie alike on both sides are then
    /// those of the whole, along the plane; the work of motions that are symmetric too. Across the
    /// plane, the whole feels nothing, whatever the sum.
    pub fn surface_loads(&mut self, loads: &mut [FacetLoad]) {
        solver!(&mut self.solver, s => s.surface_loads(loads));
        self.axes.turn_back_facets(loads);
    }

    /// Balance of momentum and mass of the last step.
    pub fn ledger(&self) -> Ledger {
        self.axes.ledger(solver!(&self.solver, s => &s.budget.ledger))
    }

    /// Force [N] and torque [N m] of the fluid in the last step on each part that stands still, as
    /// on bodies and parts that move: gauge pressure, shear, the pressure in gaps, and buoyancy of
    /// what of it lies in the domain, whatever it rests on; the torque is about the origin of the
    /// part's frame. A part whose origin lies on a symmetry plane is cut by it: the load is that on
    /// the whole. The id of a load is the part's index in the scene. `loads` is cleared before.
    pub fn loads_on_parts(&self, loads: &mut Vec<Load>) {
        solver!(&self.solver, s => s.loads_on_parts(loads));
        self.axes.turn_back_loads(loads);
    }

    /// Force [N] of the fluid in the last step on each wall and symmetry plane of the domain, by
    /// axis, lower before upper: gauge pressure without its hydrostatic part, shear, and the
    /// pressure in gaps. Zero at other faces. A link through an edge of the box counts to one of
    /// the two faces: a sixth of the pressure on each cell of an edge.
    pub fn wall_forces(&self) -> [[[f64; 3]; 2]; 3] {
        let forces = solver!(&self.solver, s => s.walls.wall_forces(s.lattice.units.force()));
        self.axes.to_world(&forces).map(|sides| sides.map(|force| self.axes.to_world(&force)))
    }

    /// Appends what the scene's probes measure to `values`, in the order of
    /// [`crate::probe_signals`], SI units. A probe whose cells are all covered by bodies reads 0.
    pub fn probes(&mut self, values: &mut Vec<f64>) {
        let first = values.len();
        solver!(&mut self.solver, s => s.probes(values));
        self.axes.turn_back_probes(&self.probes, &mut values[first..]);
    }

    /// Begins what probes tell as means over time anew: the rates of mass through sections.
    pub fn restart_means(&mut self) {
        solver!(&mut self.solver, s => s.probes.restart_means());
    }

    /// Mean velocities through the open faces whose velocity inlets of grains take, in the order of
    /// [`PortState::all`].
    pub fn ports(&mut self) -> &[PortState] {
        let ports = solver!(&mut self.solver, s => s.ports());
        self.axes.turn_back_ports(ports, &mut self.ports);
        &self.ports
    }

    /// States of the reservoirs beyond the domain's faces, in the order of the faces: lower before
    /// upper, x before y before z. `states` is cleared before.
    pub fn reservoirs(&self, states: &mut Vec<ReservoirState>) {
        states.clear();
        solver!(&self.solver, s => states.extend(s.faces.states(&s.lattice)));
        self.axes.turn_back_reservoirs(states);
    }

    /// Memory that populations and tables take [bytes].
    pub fn memory_bytes(&self) -> usize {
        solver!(&self.solver, s => s.memory_bytes())
    }

    /// Diagnostics of the flow. They cost nothing, because the collision measures them in passing.
    pub fn diagnostics(&self) -> Diagnostics {
        solver!(&self.solver, s => s.diagnostics())
    }

    /// Lets the fluid be as fast as it becomes: what runs it watches its Mach number.
    pub fn allow_any_speed(&mut self) {
        solver!(&mut self.solver, s => s.mach_limit = f64::INFINITY);
    }

    /// Centre of the cell in which a quantity is greatest now [m]. Looks at all cells.
    pub fn place_of(&self, extreme: Extreme) -> Option<[f64; 3]> {
        let place = solver!(&self.solver, s => s.place_of(extreme));
        place.map(|place| self.axes.to_world(&place))
    }

    /// Check that the fluid is finite and slower than the Mach limit. Costs nothing while it is.
    ///
    /// # Errors
    /// The cell where it is not.
    pub fn check(&self) -> Result<(), FluidError> {
        solver!(&self.solver, s => s.check()).map_err(|error| self.axes.error(error))
    }

    /// The layer of cells nearest to `position` [m] along `axis` (0, 1, 2 for x, y, z), written to
    /// `out`, which is cleared before. The other two axes follow in their order, the first of them
    /// running fastest. Returns how many cells lie along those two.
    pub fn slice(&self, axis: usize, position: f64, out: &mut Vec<SliceNode>) -> [usize; 2] {
        let others = [[1, 2], [0, 2], [0, 1]][axis].map(|axis| self.axes.axis_to_lattice(axis));
        let axis = self.axes.axis_to_lattice(axis);
        let count = solver!(&self.solver, s => s.lattice.slice(axis, position, others, out));
        out.iter_mut().for_each(|node| *node = self.axes.node(*node));
        count
    }

    /// Cells along each axis.
    pub fn cells(&self) -> [usize; 3] {
        self.axes.to_world(&solver!(&self.solver, s => s.lattice.cells()))
    }

    /// True if this rank counts a cell: what it says of others may be out of date. One that is alone counts all.
    pub fn counts(&self, cell: [usize; 3]) -> bool {
        let cell = self.axes.to_lattice(&cell).map(|k| k as i32);
        solver!(&self.solver, s => {
            let layout = &s.lattice.layout;
            layout.cell(cell).is_some_and(|cell| layout.is_own(cell))
        })
    }

    /// True if no other rank computes a share of the fluid.
    pub fn is_whole(&self) -> bool {
        solver!(&self.solver, s => s.exec.ranks.is_alone())
    }

    /// Bytes of all ranks, in their order, on rank 0; nothing on others. All ranks ask at the same time.
    pub fn gather(&self, bytes: &[u8]) -> Vec<Vec<u8>> {
        solver!(&self.solver, s => s.exec.ranks.gather(bytes))
    }

    /// Centre of a cell [m].
    pub fn centre(&self, cell: [usize; 3]) -> [f64; 3] {
        let cell = self.axes.to_lattice(&cell);
        self.axes.to_world(&solver!(&self.solver, s => s.lattice.centre(cell)))
    }

    /// Values of a cell, SI units.
    pub fn node(&self, cell: [usize; 3]) -> SliceNode {
        let cell = self.axes.to_lattice(&cell);
        self.axes.node(solver!(&self.solver, s => s.lattice.node(cell)))
    }

    /// Velocity in a cell [m/s]; zero inside a solid.
    pub fn velocity_at(&self, cell: [usize; 3]) -> [f64; 3] {
        self.node(cell).velocity
    }

    /// Gauge pressure in a cell [Pa]; zero inside a solid.
    pub fn pressure_at(&self, cell: [usize; 3]) -> f64 {
        self.node(cell).pressure
    }

    /// The 19 populations that the next collision finds in a cell, as deviations from rest, in the
    /// order of [`crate::lattice::d3q19::C`]; zeros in a static solid.
    pub fn populations_at(&self, cell: [usize; 3]) -> [f64; crate::lattice::d3q19::Q] {
        let cell = self.axes.to_lattice(&cell);
        self.axes.populations(solver!(&self.solver, s => s.lattice.populations_at(cell)))
    }

    /// Puts the fluid into local equilibrium with the velocity [m/s] and gauge pressure [Pa] that
    /// `state` says at a position [m].
    pub fn set_state(&mut self, state: impl Fn([f64; 3]) -> ([f64; 3], f64)) {
        let axes = self.axes;
        let turned = |position: [f64; 3]| {
            let (velocity, pressure) = state(axes.to_world(&position));
            (axes.to_lattice(&velocity), pressure)
        };
        solver!(&mut self.solver, s => s.set_state(turned));
    }

    /// The part of an exchange of the state of a rank on which it could not begin: all ranks exchange it together.
    ///
    /// # Errors
    /// This one, or that of the first rank that has one.
    pub fn fail_exchange(&mut self, error: StateError) -> Result<(), StateError> {
        solver!(&mut self.solver, s => s.fail_exchange(error))
    }

    /// Time step [s].
    pub fn time_step(&self) -> f64 {
        solver!(&self.solver, s => s.lattice.units.time_step)
    }

    /// Relaxation time [time steps].
    pub fn tau(&self) -> f64 {
        solver!(&self.solver, s => s.lattice.tau)
    }
}

impl KeepsState for LbmFluid {
    const STATE_VERSION: u32 = 2;

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        solver!(&mut self.solver, s => s.exchange(state))
    }
}

/// Cells of a line of memory.
pub fn line_of(precision: Precision) -> usize {
    match precision {
        Precision::F64 => f64::LINE,
        Precision::F32 => f32::LINE,
    }
}

/// Axes with which the lattice is fast, the scene by them, and its geometry in lines of `line`
/// cells, given that by the world's axes.
pub fn turned<'a>(
    scene: &'a Scene,
    resolution: &Resolution,
    ground: StaticGeometry,
    line: usize,
) -> (LatticeOrientation, Cow<'a, Scene>, StaticGeometry) {
    let axes = LatticeOrientation::with_whole_lines(&ground, line);
    if axes != LatticeOrientation::WORLD {
        let turned = axes.scene(scene);
        let cells = axes.to_lattice(&resolution.cells);
        // Where a surface passes through the centres of cells, rounding may have them be others,
        // and then what was found fit may not be.
        let of_turned =
            StaticGeometry::new(&turned, axes.grid_axes(), LINKS, cells, resolution.cell);
        if let Ok(ground) = of_turned {
            return (axes, Cow::Owned(turned), ground);
        }
    }
    (LatticeOrientation::WORLD, Cow::Borrowed(scene), ground)
}
