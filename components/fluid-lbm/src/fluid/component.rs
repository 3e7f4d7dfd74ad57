//! The lattice fluid as a component of a run.

use crate::boundary::virtual_piston::face::ReservoirState;
use crate::domain::parameters::Parameters;
use crate::fluid::lbm_fluid::LbmFluid;
use crate::fluid::signals::{FluidState, OF_FLUID, OF_PARTS, OF_WALLS, signals, walls};
use crate::report::findings::{findings, limits};
use crate::solver::diagnostics::SliceNode;
use std::collections::BTreeMap;
use tremie_sdk::messages::frame::{self, SliceHeader, VolumeHeader};
use tremie_sdk::messages::scene::{DeformableSurface, Motion, Placement, Scene};
use tremie_sdk::messages::start::{Description, SliceSpec, VolumeGrid, VolumeSpec};
use tremie_sdk::messages::{
    BodyEvent, BodyState, FacetLoad, Load, PortState, Problem, SurfaceVertex,
};
use tremie_sdk::{Fluid, Setup, SolverError};

/// The lattice fluid behind the sdk's interface.
pub struct LbmComponent {
    fluid: LbmFluid,
    cut: Cut,
    cells: u64,
    /// Edge of a cell [m].
    cell: f64,
    /// Gauge pressure of a relative density deviation of one [Pa].
    stiffness: f64,
    /// Loads of one substep, where a window has several.
    partial: Vec<Load>,
    nodes: Vec<SliceNode>,
    on_parts: Vec<Load>,
    /// Of each part of the scene whether it stands still, or else the body that it is, and the mean load over the window.
    parts: Vec<PartLoad>,
    /// Faces whose forces are signals.
    walls: Vec<(usize, usize)>,
    /// Loads on all facets of deformable surfaces, mean over the window, and of one substep.
    on_facets: Vec<FacetLoad>,
    partial_facets: Vec<FacetLoad>,
    reservoirs: Vec<ReservoirState>,
}

/// The load on a part that may move.
#[derive(Clone, Copy, Debug, Default)]
struct PartLoad {
    is_fixed: bool,
    body: Option<u64>,
    load: Load,
}

/// The plane that observers see.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cut {
    axis: usize,
    position: f64,
}

/// Name of the cut.
const CUT: &str = "velocity";
/// Name of the volume.
const LATTICE: &str = "lattice";

impl Cut {
    /// A plane through the first listed sphere, or the middle of the domain, that contains gravity
    /// and is normal to a horizontal axis.
    fn of(scene: &Scene) -> Self {
        let axis = if scene.gravity[1].abs() > scene.gravity[2].abs() { 2 } else { 1 };
        let first = scene.bodies.iter().find_map(|set| match &set.placement {
            Placement::Listed(spheres) => spheres.first().map(|sphere| sphere.position[axis]),
            Placement::Packed(_) | Placement::Polyhedra(_) => None,
        });
        let middle = 0.5 * (scene.domain.min[axis] + scene.domain.max[axis]);
        Self { axis, position: first.unwrap_or(middle) }
    }

    /// The two axes in the plane, the first of them running fastest.
    fn plane(self) -> [usize; 2] {
        [[1, 2], [0, 2], [0, 1]][self.axis]
    }
}

impl Fluid for LbmComponent {
    const PROGRAM: &'static str = concat!("fluid-lbm ", env!("CARGO_PKG_VERSION"));
    const TAKES_SURFACES: bool = true;
    const TAKES_POLYHEDRA: bool = true;
    const TELLS_PORTS: bool = true;

    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>> {
        let parameters: Parameters = setup.parameters()?;
        let scene = &setup.hello.scene;
        let resolution = parameters.resolve(scene)?;
        let [nx, ny, nz] = resolution.cells;
        let plane = Cut::of(scene).plane().map(|axis| resolution.cells[axis] as u64);
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
            slices: vec![SliceSpec { name: CUT.into(), nodes: plane[0] * plane[1] }],
            volumes: vec![VolumeSpec {
                name: LATTICE.into(),
                origin: scene.domain.min.map(|x| x + 0.5 * resolution.cell),
                step: [resolution.cell; 3],
                count: resolution.cells.map(|n| n as u64),
            }],
            step_limit: scene
                .fluid
                .as_ref()
                .map_or(String::new(), |fluid| parameters.step_limit(fluid)),
            work: "cell updates".into(),
            work_per_step: resolution.fluid_cells as f64,
            notes,
            findings: findings(&parameters, scene, &resolution),
            limits: limits(),
            memory: resolution.memory_bytes,
            warnings: resolution.warnings,
            resolution: numbers,
            ..Description::default()
        })
    }

    fn create(setup: &Setup) -> Result<Self, Vec<Problem>> {
        let parameters: Parameters = setup.parameters()?;
        let scene = &setup.hello.scene;
        let step = setup.assigned()?.step;
        let threads = setup.hello.threads.max(1) as usize;
        let mut fluid = LbmFluid::new(scene, &parameters, step, threads)?;
        fluid.choose_threads();
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
            partial: Vec::new(),
            nodes: Vec::new(),
            on_parts: Vec::new(),
            parts: (scene.parts.iter())
                .map(|part| PartLoad {
                    is_fixed: part.motion == Motion::Fixed,
                    ..PartLoad::default()
                })
                .collect(),
            walls: walls(scene).collect(),
            on_facets: vec![FacetLoad::default(); facets],
            partial_facets: vec![FacetLoad::default(); facets],
            reservoirs: Vec::new(),
        })
    }

    fn events(&mut self, events: &[BodyEvent]) -> Result<(), SolverError> {
        self.fluid.apply_events(events).map_err(SolverError::from_error)?;
        for event in events.iter().filter(|event| event.shape == BodyEvent::PART) {
            if let Some(part) = self.parts.get_mut(event.table as usize) {
                part.body = (event.kind == BodyEvent::ADDED).then_some(event.id);
            }
        }
        Ok(())
    }

    fn start(&mut self, bodies: &[BodyState], loads: &mut [Load]) -> Result<(), SolverError> {
        self.fluid.start(bodies, loads).map_err(SolverError::from_error)?;
        self.note_loads(loads);
        self.fluid.surface_loads(&mut self.on_facets);
        Ok(())
    }

    fn advance(
        &mut self,
        substeps: u32,
        bodies: &[BodyState],
        loads: &mut [Load],
    ) -> Result<(), SolverError> {
        self.fluid.step(bodies, loads).map_err(SolverError::from_error)?;
        self.fluid.surface_loads(&mut self.on_facets);
        if substeps > 1 {
            self.advance_on(substeps, bodies, loads)?;
        }
        self.note_loads(loads);
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

    fn signals(&mut self, values: &mut Vec<f64>) {
        let state = FluidState {
            diagnostics: self.fluid.diagnostics(),
            ledger: self.fluid.ledger(),
            stiffness: self.stiffness,
        };
        values.extend(OF_FLUID.iter().map(|(_, _, _, value)| value(&state)));
        let forces = self.fluid.wall_forces();
        for &(axis, side) in &self.walls {
            values.extend(OF_WALLS.iter().map(|(_, _, _, value)| value(&forces[axis][side])));
        }
        self.fluid.loads_on_parts(&mut self.on_parts);
        let mut fixed = self.on_parts.iter();
        for part in &self.parts {
            let still = if part.is_fixed { fixed.next() } else { None };
            let load = still.unwrap_or(&part.load);
            values.extend(OF_PARTS.iter().map(|(_, _, _, value)| value(load)));
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

    fn work(&self) -> u64 {
        self.cells
    }

    fn slice(&mut self, _name: &str, nodes: &mut [frame::SliceNode]) -> SliceHeader {
        let Cut { axis, position } = self.cut;
        let count = self.fluid.slice(axis, position, &mut self.nodes);
        for (out, node) in nodes.iter_mut().zip(&self.nodes) {
            *out = shown(node);
        }
        let [fast, slow] = self.cut.plane();
        let mut corner = self.fluid.centre([0; 3]);
        let cell = self.cell;
        corner[axis] += ((position - corner[axis]) / cell).round() * cell;
        let mut step = [[0.0; 3]; 2];
        (step[0][fast], step[1][slow]) = (cell, cell);
        let count = count.map(|n| n as u64);
        SliceHeader { origin: corner, step, count, ..SliceHeader::default() }
    }

    fn volume(&mut self, grid: &VolumeGrid, nodes: &mut [frame::SliceNode]) -> VolumeHeader {
        let [across, deep, high] = grid.count;
        let all = (0..high)
            .flat_map(|k| (0..deep).flat_map(move |j| (0..across).map(move |i| [i, j, k])));
        for (out, at) in nodes.iter_mut().zip(all) {
            *out = shown(&self.fluid.node(grid.lattice_node(at).map(|n| n as usize)));
        }
        VolumeHeader {
            origin: self.fluid.centre(grid.first.map(|n| n as usize)),
            step: [self.cell * grid.stride as f64; 3],
            count: grid.count,
            ..VolumeHeader::default()
        }
    }
}

/// A node as observers see it, in single precision.
fn shown(node: &SliceNode) -> frame::SliceNode {
    frame::SliceNode {
        velocity: node.velocity.map(|v| v as f32),
        pressure: node.pressure as f32,
        solid: u32::from(node.solid),
    }
}

impl LbmComponent {
    /// Keeps the loads on parts that move, for the signals.
    fn note_loads(&mut self, loads: &[Load]) {
        for part in &mut self.parts {
            let place =
                part.body.and_then(|id| loads.binary_search_by_key(&id, |load| load.id).ok());
            part.load = place.map_or_else(Load::default, |place| loads[place]);
        }
    }

    /// The substeps after the first; `loads` become the mean over all, so that their impulse over
    /// the window is that of the substeps.
    fn advance_on(
        &mut self,
        substeps: u32,
        bodies: &[BodyState],
        loads: &mut [Load],
    ) -> Result<(), SolverError> {
        let share = 1.0 / f64::from(substeps);
        self.partial.clear();
        self.partial.extend_from_slice(loads);
        for load in loads.iter_mut() {
            load.force = load.force.map(|f| f * share);
            load.torque = load.torque.map(|t| t * share);
        }
        for load in &mut self.on_facets {
            load.force = load.force.map(|f| f * share);
        }
        for _ in 1..substeps {
            self.fluid.step(bodies, &mut self.partial).map_err(SolverError::from_error)?;
            self.fluid.surface_loads(&mut self.partial_facets);
            for (load, part) in self.on_facets.iter_mut().zip(&self.partial_facets) {
                join_facet(load, part, share);
            }
            for (load, part) in loads.iter_mut().zip(&self.partial) {
                for axis in 0..3 {
                    load.force[axis] += part.force[axis] * share;
                    load.torque[axis] += part.torque[axis] * share;
                }
            }
        }
        Ok(())
    }
}

/// Adds a share of another load on the same facet; the point is the mean, weighted by the forces.
fn join_facet(load: &mut FacetLoad, other: &FacetLoad, share: f64) {
    let size = |force: [f64; 3]| force.iter().map(|f| f * f).sum::<f64>().sqrt();
    let (own, more) = (size(load.force), share * size(other.force));
    if own + more > 0.0 {
        for a in 0..3 {
            load.point[a] += more / (own + more) * (other.point[a] - load.point[a]);
        }
    }
    for a in 0..3 {
        load.force[a] += share * other.force[a];
    }
}
