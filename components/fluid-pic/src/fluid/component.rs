//! The particle fluid as a component of a run.

use crate::domain::parameters::Parameters;
use crate::fluid::pic_fluid::PicFluid;
use crate::fluid::signals::{OF_FLUID, OF_PARTS, OF_WALLS, signals};
use crate::report::findings::{findings, limits};
use std::collections::BTreeMap;
use tremie_fluid_kit::observed::cut::Cut;
use tremie_fluid_kit::observed::observed_cells::ObservedCells;
use tremie_fluid_kit::observed::volume::{fill_volume, steps, volume_spec};
use tremie_fluid_kit::window::fluid_signals::walls;
use tremie_fluid_kit::window::part_loads::PartLoads;
use tremie_sdk::messages::frame::{self, SliceHeader, VolumeHeader};
use tremie_sdk::messages::start::signal_row::push;
use tremie_sdk::messages::start::{Description, VolumeGrid};
use tremie_sdk::messages::{BodyEvent, BodyState, Load, Place, Problem};
use tremie_sdk::state::{KeepsState, StateError, StateExchange};
use tremie_sdk::{AsFluid, ControlPipe, Fluid, Setup, SolverError};

/// The particle fluid behind the sdk's interface.
pub struct PicComponent {
    fluid: AnyFluid,
    cut: Cut,
    /// Steps from cell to cell along each axis [m].
    steps: [f64; 3],
    /// Edge of a cell [m].
    cell: f64,
    on_parts: Vec<Load>,
    parts: PartLoads,
    /// Faces whose forces are signals.
    walls: Vec<(usize, usize)>,
}

/// The fluid of a scene in space, or of a plane one.
enum AnyFluid {
    Space(Box<PicFluid<3>>),
    Plane(Box<PicFluid<2>>),
}

/// Calls a method of whichever fluid is inside.
macro_rules! fluid {
    ($component:expr, $fluid:ident => $call:expr) => {
        match &mut $component.fluid {
            AnyFluid::Space($fluid) => $call,
            AnyFluid::Plane($fluid) => $call,
        }
    };
}

/// Name of the cut.
const CUT: &str = "velocity";
/// Name of the volume.
const GRID: &str = "grid";

impl<const D: usize> ObservedCells for PicFluid<D> {
    fn cells(&self) -> [usize; 3] {
        self.cells()
    }

    fn centre(&self, cell: [usize; 3]) -> [f64; 3] {
        self.centre(cell)
    }

    fn node(&self, cell: [usize; 3]) -> frame::SliceNode {
        let (velocity, pressure, fill, is_solid) = self.node(cell);
        frame::SliceNode {
            velocity: velocity.map(|v| v as f32),
            pressure: pressure as f32,
            fill: fill as f32,
            solid: u32::from(is_solid),
            density: self.density() as f32,
            level: 0,
        }
    }
}

impl Fluid for PicComponent {
    const PROGRAM: &'static str = concat!("fluid-pic ", env!("CARGO_PKG_VERSION"));

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
            "{nx} x {ny} x {nz} cells of {:.4e} m, {} wet at the start, {} particles, {megabytes:.0} MB",
            resolution.cell, resolution.wet_cells, resolution.particles
        )];
        notes.extend(resolution.notes.iter().cloned());
        let mut numbers = BTreeMap::from([
            ("cells".to_string(), (nx * ny * nz) as f64),
            ("wet cells".to_string(), resolution.wet_cells as f64),
            ("particles".to_string(), resolution.particles as f64),
            ("cell size [m]".to_string(), resolution.cell),
        ]);
        if let Some(cells) = resolution.cells_per_smallest_sphere {
            notes.push(format!("{cells:.1} cells across the smallest sphere"));
            numbers.insert("cells across the smallest sphere".into(), cells);
        }
        let step_limit = if parameters.time_step.is_some() {
            "time_step".into()
        } else {
            let speed = resolution.expected_speed;
            format!("{} cells at {speed:.3} m/s", parameters.courant)
        };
        Ok(Description {
            step: Some(resolution.time_step),
            step_limit,
            signals: signals(scene),
            slices: vec![Cut::of(scene).spec(CUT, resolution.cells)],
            volumes: vec![volume_spec(GRID, scene, resolution.cell, resolution.cells)],
            work: "wet cells".into(),
            work_per_step: resolution.wet_cells as f64,
            notes,
            findings: findings(&parameters, scene, &resolution),
            limits: limits(),
            memory: resolution.memory_bytes,
            resolution: numbers,
            state: Some(PicFluid::<3>::STATE_VERSION),
            ..Description::default()
        })
    }

    fn create(setup: &Setup) -> Result<Self, Vec<Problem>> {
        let parameters: Parameters = setup.parameters()?;
        let scene = &setup.hello.scene;
        let step = setup.assigned()?.step;
        let threads = setup.hello.threads.max(1) as usize;
        let is_plane = scene.domain.across.is_some();
        let fluid = if is_plane {
            AnyFluid::Plane(Box::new(PicFluid::plane(scene, &parameters, step, threads)?))
        } else {
            AnyFluid::Space(Box::new(PicFluid::new(scene, &parameters, step, threads)?))
        };
        Ok(Self {
            fluid,
            cut: Cut::of(scene),
            steps: steps(scene, parameters.cell.0),
            cell: parameters.cell.0,
            on_parts: Vec::new(),
            parts: PartLoads::new(scene),
            walls: walls(scene).collect(),
        })
    }

    fn events(&mut self, events: &[BodyEvent]) -> Result<(), SolverError> {
        fluid!(self, fluid => fluid.apply_events(events)).map_err(SolverError::from_error)?;
        self.parts.apply(events);
        Ok(())
    }

    fn start(&mut self, bodies: &[BodyState], loads: &mut [Load]) -> Result<(), SolverError> {
        fluid!(self, fluid => fluid.start(bodies, loads)).map_err(SolverError::from_error)?;
        self.parts.note(loads);
        Ok(())
    }

    fn advance(
        &mut self,
        substeps: u32,
        bodies: &[BodyState],
        loads: &mut [Load],
    ) -> Result<(), SolverError> {
        fluid!(self, fluid => fluid.advance(substeps, bodies, loads))
            .map_err(SolverError::from_error)?;
        self.parts.note(loads);
        Ok(())
    }

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        fluid!(self, fluid => fluid.exchange_state(state))?;
        state.value("part_loads", &mut self.parts)
    }

    fn signals(&mut self, values: &mut Vec<f64>) {
        push(&OF_FLUID, &fluid!(self, fluid => fluid.state()), values);
        let forces = fluid!(self, fluid => fluid.wall_forces());
        for &(axis, side) in &self.walls {
            push(&OF_WALLS, &forces[axis][side], values);
        }
        fluid!(self, fluid => fluid.loads_at_rest(&mut self.on_parts));
        for load in self.parts.loads(&self.on_parts) {
            push(&OF_PARTS, load, values);
        }
    }

    fn sampled(&mut self, values: &mut Vec<f64>) {
        fluid!(self, fluid => fluid.probes(values));
    }

    fn place(&self, signal: &str) -> Option<Place> {
        let fastest = match &self.fluid {
            _ if signal != "courant" => None,
            AnyFluid::Space(fluid) => fluid.place_of_fastest(),
            AnyFluid::Plane(fluid) => fluid.place_of_fastest(),
        };
        fastest.map(Place::at)
    }

    fn work(&self) -> u64 {
        match &self.fluid {
            AnyFluid::Space(fluid) => fluid.wet_cells() as u64,
            AnyFluid::Plane(fluid) => fluid.wet_cells() as u64,
        }
    }

    fn slice(&mut self, _name: &str, nodes: &mut [frame::SliceNode]) -> SliceHeader {
        fluid!(self, fluid => self.cut.fill(&**fluid, self.cell, nodes))
    }

    fn volume(&mut self, grid: &VolumeGrid, nodes: &mut [frame::SliceNode]) -> VolumeHeader {
        fluid!(self, fluid => fill_volume(&**fluid, self.steps, grid, nodes))
    }
}

/// Takes part in a run, over `line`.
///
/// # Errors
/// A sentence for standard error.
pub fn run(line: ControlPipe) -> Result<(), String> {
    tremie_sdk::run::<AsFluid<PicComponent>>(line)
}
