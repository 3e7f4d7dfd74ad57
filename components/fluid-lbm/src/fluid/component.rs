//! The lattice fluid as a component of a run.

use crate::boundary::virtual_piston::reservoir_state::ReservoirState;
use crate::domain::parameters::Parameters;
use crate::fluid::lbm_fluid::LbmFluid;
use crate::fluid::rank_shares::shares_of_ranks;
use crate::fluid::signals::{FluidState, OF_FLUID, signals};
use crate::ranks::communicator::Communicator;
use crate::report::findings::{findings, limits};
use crate::solver::diagnostics::Extreme;
use std::collections::BTreeMap;
use tremie_fluid_kit::observed::cut::Cut;
use tremie_fluid_kit::observed::observed_cells::ObservedCells;
use tremie_fluid_kit::observed::volume::{fill_volume, volume_spec};
use tremie_fluid_kit::window::fluid_signals::{OF_PARTS, OF_WALLS, walls};
use tremie_fluid_kit::window::part_loads::PartLoads;
use tremie_fluid_kit::window::substep_means::SubstepMeans;
use tremie_sdk::messages::frame::{self, SliceHeader, VolumeHeader};
use tremie_sdk::messages::scene::DeformableSurface;
use tremie_sdk::messages::start::signal_row::push;
use tremie_sdk::messages::start::{Description, VolumeGrid};
use tremie_sdk::messages::{
    BodyEvent, BodyState, FacetLoad, Load, Place, PortState, Problem, SurfaceVertex, bytes_of,
    values_of,
};
use tremie_sdk::state::{KeepsState, StateError, StateExchange};
use tremie_sdk::{AsFluid, ControlPipe, Fluid, Setup, SolverError};
use tremie_team::Variant;

/// The lattice fluid behind the sdk's interface.
pub struct LbmComponent {
    fluid: LbmFluid,
    cut: Cut,
    cells: u64,
    /// Edge of a cell [m].
    cell: f64,
    /// Gauge pressure of a relative density deviation of one [Pa].
    stiffness: f64,
    means: SubstepMeans,
    on_parts: Vec<Load>,
    parts: PartLoads,
    /// Faces whose forces are signals.
    walls: Vec<(usize, usize)>,
    /// Loads on all facets of deformable surfaces, mean over the window.
    on_facets: Vec<FacetLoad>,
    reservoirs: Vec<ReservoirState>,
}

/// Name of the cut.
const CUT: &str = "velocity";
/// Name of the volume.
const LATTICE: &str = "lattice";

impl LbmComponent {
    /// The fluid of a run; where there is a `way`, the share of it that this rank computes.
    ///
    /// # Errors
    /// Every problem of the input.
    pub fn along(setup: &Setup, way: Option<Box<dyn Communicator>>) -> Result<Self, Vec<Problem>> {
        let parameters: Parameters = setup.parameters()?;
        let scene = &setup.hello.scene;
        let step = setup.assigned()?.step;
        let threads = setup.hello.threads.max(1) as usize;
        let mut fluid = match way {
            None => LbmFluid::new(scene, &parameters, step, threads)?,
            Some(way) => {
                let with = (threads, Variant::widest());
                LbmFluid::with_ranks(scene, &parameters, step, with, way)?
            }
        };
        fluid.choose_threads();
        // The run watches it: `max_mach`.
        fluid.allow_any_speed();
        let facets = scene.surfaces.iter().map(DeformableSurface::facet_count).sum();
        let cells = fluid.diagnostics().fluid_cells as u64;
        let cell = parameters.cell.0;
        let density = scene.fluid.as_ref().map_or(0.0, |fluid| fluid.density);
        // Square of the lattice's speed of sound, a third of (dx/dt)^2.
        let sound = (cell / step) * (cell / step) / 3.0;
        Ok(Self {
            fluid,
            cut: Cut::of(scene),
            cells,
            cell,
            stiffness: density * sound,
            means: SubstepMeans::new(facets),
            on_parts: Vec::new(),
            parts: PartLoads::new(scene),
            walls: walls(scene).collect(),
            on_facets: vec![FacetLoad::default(); facets],
            reservoirs: Vec::new(),
        })
    }

    /// See [`LbmFluid::fail_exchange`].
    ///
    /// # Errors
    /// See there.
    pub fn fail_exchange(&mut self, error: StateError) -> Result<(), StateError> {
        self.fluid.fail_exchange(error)
    }

    /// What so many ranks have each of the lattice: sentences for the user.
    ///
    /// # Errors
    /// What ranks cannot do, and more of them than there are blocks for.
    pub fn shares(setup: &Setup, ranks: usize) -> Result<Vec<String>, Vec<Problem>> {
        let parameters: Parameters = setup.parameters()?;
        shares_of_ranks(&parameters, &setup.hello.scene, ranks)
    }
}

/// A fluid of which a rank tells only the cells that it counts; the others have the level [`ELSEWHERE`].
struct CountedCells<'f>(&'f LbmFluid);

/// Level of a cell that another rank counts, or none.
const ELSEWHERE: u32 = u32::MAX;

impl ObservedCells for CountedCells<'_> {
    fn cells(&self) -> [usize; 3] {
        self.0.cells()
    }

    fn centre(&self, cell: [usize; 3]) -> [f64; 3] {
        self.0.centre(cell)
    }

    fn node(&self, cell: [usize; 3]) -> frame::SliceNode {
        if self.0.is_whole() || self.0.counts(cell) {
            return ObservedCells::node(self.0, cell);
        }
        // What nobody counts is solid.
        frame::SliceNode { solid: 1, level: ELSEWHERE, ..frame::SliceNode::default() }
    }
}

/// Puts the nodes that this rank tells together with those of all ranks, on rank 0.
fn join_nodes(fluid: &LbmFluid, nodes: &mut [frame::SliceNode]) {
    if fluid.is_whole() {
        return;
    }
    let own = (0_u64..).zip(&*nodes).filter(|(_, node)| node.level != ELSEWHERE);
    let bytes: Vec<u8> =
        own.flat_map(|(number, node)| [bytes_of(&[number]), bytes_of(&[*node])].concat()).collect();
    for node in nodes.iter_mut().filter(|node| node.level == ELSEWHERE) {
        node.level = 0;
    }
    let length = size_of::<u64>() + size_of::<frame::SliceNode>();
    for told in fluid.gather(&bytes).iter().flat_map(|bytes| bytes.chunks_exact(length)) {
        let (number, node) = told.split_at(size_of::<u64>());
        let numbers: Option<Vec<u64>> = values_of(number);
        let told = numbers.zip(values_of(node));
        if let Some((numbers, told)) = told
            && let Some(node) = nodes.get_mut(numbers[0] as usize)
        {
            *node = told[0];
        }
    }
}

impl ObservedCells for LbmFluid {
    fn cells(&self) -> [usize; 3] {
        self.cells()
    }

    fn centre(&self, cell: [usize; 3]) -> [f64; 3] {
        self.centre(cell)
    }

    fn node(&self, cell: [usize; 3]) -> frame::SliceNode {
        let node = self.node(cell);
        frame::SliceNode {
            velocity: node.velocity.map(|v| v as f32),
            pressure: node.pressure as f32,
            fill: if node.solid { 0.0 } else { 1.0 },
            solid: u32::from(node.solid),
            density: node.density as f32,
            level: 0,
        }
    }
}

impl Fluid for LbmComponent {
    const PROGRAM: &'static str = concat!("fluid-lbm ", env!("CARGO_PKG_VERSION"));
    const TAKES_SURFACES: bool = true;
    const TELLS_PORTS: bool = true;

    fn takes_polyhedra() -> bool {
        true
    }

    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>> {
        let parameters: Parameters = setup.parameters()?;
        let scene = &setup.hello.scene;
        let resolution = parameters.resolve(scene)?;
        let [nx, ny, nz] = resolution.cells;
        let megabytes = resolution.memory_bytes as f64 * 1e-6;
        let mut notes = vec![format!(
            "{nx} x {ny} x {nz} cells of {:.4e} m, tau {:.4}, {megabytes:.0} MB",
            resolution.cell, resolution.tau
        )];
        notes.extend(resolution.notes.iter().cloned());
        let mut numbers = BTreeMap::from([
            ("cells".to_string(), (nx * ny * nz) as f64),
            ("fluid cells".to_string(), resolution.fluid_cells as f64),
            ("cell size [m]".to_string(), resolution.cell),
            ("relaxation time".to_string(), resolution.tau),
        ]);
        if let Some(cells) = resolution.cells_per_smallest_sphere {
            notes.push(format!("{cells:.1} cells across the smallest sphere"));
            numbers.insert("cells across the smallest sphere".into(), cells);
        }
        if let Some(mach) = resolution.expected_mach {
            notes.push(format!("Mach number {mach:.3} at the expected speed"));
            numbers.insert("expected Mach number".into(), mach);
        }
        Ok(Description {
            step: Some(resolution.time_step),
            signals: signals(scene),
            slices: vec![Cut::of(scene).spec(CUT, resolution.cells)],
            volumes: vec![volume_spec(LATTICE, scene, resolution.cell, resolution.cells)],
            step_limit: scene
                .fluid
                .as_ref()
                .map_or(String::new(), |fluid| parameters.step_limit(fluid)),
            work: "cell updates".into(),
            work_per_step: resolution.fluid_cells as f64,
            notes,
            findings: findings(&parameters, scene, &resolution),
            limits: limits(&parameters, &resolution),
            memory: resolution.memory_bytes,
            warnings: resolution.warnings,
            resolution: numbers,
            state: Some(LbmFluid::STATE_VERSION),
            ..Description::default()
        })
    }

    fn create(setup: &Setup) -> Result<Self, Vec<Problem>> {
        Self::along(setup, None)
    }

    fn events(&mut self, events: &[BodyEvent]) -> Result<(), SolverError> {
        self.fluid.apply_events(events).map_err(SolverError::from_error)?;
        self.parts.apply(events);
        Ok(())
    }

    fn start(&mut self, bodies: &[BodyState], loads: &mut [Load]) -> Result<(), SolverError> {
        self.fluid.start(bodies, loads).map_err(SolverError::from_error)?;
        self.parts.note(loads);
        self.fluid.surface_loads(&mut self.on_facets);
        Ok(())
    }

    fn advance(
        &mut self,
        substeps: u32,
        bodies: &[BodyState],
        loads: &mut [Load],
    ) -> Result<(), SolverError> {
        let Self { fluid, means, on_facets, .. } = self;
        means.advance(substeps, loads, on_facets, |loads, facets| {
            fluid.step(bodies, loads).map_err(SolverError::from_error)?;
            fluid.surface_loads(facets);
            Ok(())
        })?;
        self.parts.note(loads);
        if let Some(found) = self.fluid.take_found() {
            tremie_sdk::log_line(format_args!("a step {found}"));
        }
        self.fluid.check().map_err(SolverError::from_error)
    }

    fn surface(&mut self, vertices: &[SurfaceVertex]) -> Result<(), SolverError> {
        self.fluid.set_surfaces(vertices).map_err(SolverError::from_error)
    }

    fn surface_loads(&mut self, loads: &mut Vec<FacetLoad>) -> Result<(), SolverError> {
        loads.extend(self.on_facets.iter().filter(|load| load.force != [0.0; 3]));
        Ok(())
    }

    fn ports(&mut self, ports: &mut [PortState]) -> Result<(), SolverError> {
        ports.copy_from_slice(self.fluid.ports());
        Ok(())
    }

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        self.fluid.exchange_state(state)?;
        state.value("part_loads", &mut self.parts)
    }

    fn signals(&mut self, values: &mut Vec<f64>) {
        let state = FluidState {
            diagnostics: self.fluid.diagnostics(),
            ledger: self.fluid.ledger(),
            stiffness: self.stiffness,
        };
        push(&OF_FLUID, &state, values);
        let forces = self.fluid.wall_forces();
        for &(axis, side) in &self.walls {
            push(&OF_WALLS, &forces[axis][side], values);
        }
        self.fluid.loads_on_parts(&mut self.on_parts);
        for load in self.parts.loads(&self.on_parts) {
            push(&OF_PARTS, load, values);
        }
        self.fluid.reservoirs(&mut self.reservoirs);
        values.extend(self.reservoirs.iter().flat_map(ReservoirState::values));
    }

    fn sampled(&mut self, values: &mut Vec<f64>) {
        self.fluid.probes(values);
    }

    fn row_kept(&mut self) {
        self.fluid.restart_means();
    }

    fn place(&self, signal: &str) -> Option<Place> {
        let extreme = match signal {
            "max_mach" => Extreme::Speed,
            "max_density_deviation" => Extreme::DensityDeviation,
            _ => return None,
        };
        self.fluid.place_of(extreme).map(Place::at)
    }

    fn work(&self) -> u64 {
        self.cells
    }

    fn slice(&mut self, _name: &str, nodes: &mut [frame::SliceNode]) -> SliceHeader {
        let header = self.cut.fill(&CountedCells(&self.fluid), self.cell, nodes);
        join_nodes(&self.fluid, nodes);
        header
    }

    fn volume(&mut self, grid: &VolumeGrid, nodes: &mut [frame::SliceNode]) -> VolumeHeader {
        let header = fill_volume(&CountedCells(&self.fluid), [self.cell; 3], grid, nodes);
        join_nodes(&self.fluid, nodes);
        header
    }
}

/// Takes part in a run, over `line`.
///
/// # Errors
/// A sentence for standard error.
pub fn run(line: ControlPipe) -> Result<(), String> {
    tremie_sdk::run::<AsFluid<LbmComponent>>(line)
}
