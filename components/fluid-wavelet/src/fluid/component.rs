//! The gas as a component of a run.

use crate::domain::parameters::Parameters;
use crate::fluid::gas_fluid::GasFluid;
use crate::fluid::signals::{OF_GAS, OF_PARTS, OF_WALLS, signals};
use crate::report::findings::{findings, limits};
use crate::solver::gas_sums::GasExtreme;
use std::collections::BTreeMap;
use tremie_fluid_kit::observed::cut::Cut;
use tremie_fluid_kit::observed::observed_cells::ObservedCells;
use tremie_fluid_kit::observed::volume::{fill_volume, steps};
use tremie_fluid_kit::window::fluid_signals::walls;
use tremie_fluid_kit::window::part_loads::PartLoads;
use tremie_sdk::messages::frame::{SliceHeader, SliceNode, VolumeHeader};
use tremie_sdk::messages::start::signal_row::push;
use tremie_sdk::messages::start::{Description, VolumeGrid, VolumeSpec};
use tremie_sdk::messages::{BodyEvent, BodyState, Load, Place, Problem};
use tremie_sdk::state::{KeepsState, StateError, StateExchange};
use tremie_sdk::{AsFluid, ControlPipe, Fluid, Setup, SolverError};

/// The gas behind the sdk's interface.
pub struct GasComponent {
    fluid: GasFluid,
    cut: Cut,
    /// Spacing of the points that observers see [m].
    spacing: f64,
    /// Steps between them along each axis of the world [m].
    steps: [f64; 3],
    on_parts: Vec<Load>,
    parts: PartLoads,
    /// Faces whose forces are signals.
    walls: Vec<(usize, usize)>,
    substeps: u32,
}

/// Name of the cut.
const CUT: &str = "velocity";
/// Name of the volume.
const GRID: &str = "grid";

impl ObservedCells for GasFluid {
    fn cells(&self) -> [usize; 3] {
        self.observed_points()
    }

    fn centre(&self, cell: [usize; 3]) -> [f64; 3] {
        self.place_of(cell)
    }

    fn node(&self, cell: [usize; 3]) -> SliceNode {
        let seen = self.observed(cell);
        SliceNode {
            velocity: seen.state.velocity.map(|u| u as f32),
            pressure: (seen.state.pressure - self.initial().rest.pressure) as f32,
            fill: if seen.body.is_some() { 0.0 } else { 1.0 },
            solid: u32::from(seen.body.is_some()),
            density: seen.state.density as f32,
            level: u32::from(seen.level),
        }
    }
}

impl Fluid for GasComponent {
    const PROGRAM: &'static str = concat!("fluid-wavelet ", env!("CARGO_PKG_VERSION"));

    fn takes_polyhedra() -> bool {
        true
    }

    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>> {
        let parameters: Parameters = setup.parameters()?;
        let scene = &setup.hello.scene;
        let resolution = parameters.resolve(scene)?;
        let [nx, ny, nz] = resolution.points;
        let coarser = f64::from(1_u32 << (resolution.levels - resolution.observed_level));
        let spacing = resolution.cell * coarser;
        let seen = resolution.points.map(|n| (n as f64 / coarser).ceil() as usize);
        let levels = u32::from(resolution.levels) + 1;
        let megabytes = resolution.memory_bytes as f64 * 1e-6;
        let mut notes = vec![
            format!(
                "{levels} levels of points, the finest {nx} x {ny} x {nz} of {:.4e} m; about {:.2e} points at the start, {megabytes:.0} MB",
                resolution.cell, resolution.first_points
            ),
            format!(
                "the gas takes steps of its own inside a window; at the start {:.3e} s",
                resolution.time_step
            ),
        ];
        if spacing > resolution.cell {
            notes.push(format!("observers see points {spacing:.4e} m apart"));
        }
        let mut numbers = BTreeMap::from([
            ("finest points".to_string(), (nx * ny * nz) as f64),
            ("finest spacing [m]".to_string(), resolution.cell),
            ("levels".to_string(), f64::from(levels)),
        ]);
        if let Some(across) = resolution.across_smallest {
            notes.push(format!("{across:.1} points across the smallest body"));
            numbers.insert("points across the smallest body".into(), across);
        }
        Ok(Description {
            step: Some(resolution.time_step),
            step_limit: resolution.step_limit.clone(),
            signals: signals(scene),
            slices: vec![Cut::of(scene).spec(CUT, seen)],
            volumes: vec![VolumeSpec {
                name: GRID.into(),
                origin: scene.domain.min,
                step: steps(scene, spacing),
                count: seen.map(|n| n as u64),
            }],
            work: "points of gas".into(),
            work_per_step: resolution.first_points,
            notes,
            findings: findings(&parameters, scene, &resolution),
            limits: limits(scene),
            memory: resolution.memory_bytes,
            resolution: numbers,
            state: Some(GasFluid::STATE_VERSION),
            ..Description::default()
        })
    }

    fn create(setup: &Setup) -> Result<Self, Vec<Problem>> {
        let parameters: Parameters = setup.parameters()?;
        let scene = &setup.hello.scene;
        let step = setup.assigned()?.step;
        let threads = setup.hello.threads.max(1) as usize;
        let fluid = GasFluid::new(scene, &parameters, step, threads)?;
        let spacing = fluid.observed_spacing();
        Ok(Self {
            fluid,
            cut: Cut::of(scene),
            spacing,
            steps: steps(scene, spacing),
            on_parts: Vec::new(),
            parts: PartLoads::new(scene),
            walls: walls(scene).collect(),
            substeps: 1,
        })
    }

    fn events(&mut self, events: &[BodyEvent]) -> Result<(), SolverError> {
        self.fluid.apply_events(events).map_err(SolverError::from_error)?;
        self.parts.apply(events);
        Ok(())
    }

    fn start(&mut self, bodies: &[BodyState], loads: &mut [Load]) -> Result<(), SolverError> {
        self.fluid.start(bodies, loads).map_err(SolverError::from_error)?;
        self.parts.note(loads);
        Ok(())
    }

    fn advance(
        &mut self,
        substeps: u32,
        bodies: &[BodyState],
        loads: &mut [Load],
    ) -> Result<(), SolverError> {
        self.substeps = substeps;
        self.fluid.advance(substeps, bodies, loads).map_err(SolverError::from_error)?;
        self.parts.note(loads);
        Ok(())
    }

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        self.fluid.exchange_state(state)?;
        state.value("part_loads", &mut self.parts)
    }

    fn signals(&mut self, values: &mut Vec<f64>) {
        push(&OF_GAS, &self.fluid.state(), values);
        for &(axis, side) in &self.walls {
            push(&OF_WALLS, &self.fluid.wall_force(axis, side), values);
        }
        self.fluid.loads_at_rest(&mut self.on_parts);
        for load in self.parts.loads(&self.on_parts) {
            push(&OF_PARTS, load, values);
        }
    }

    fn sampled(&mut self, values: &mut Vec<f64>) {
        self.fluid.probes(values);
    }

    fn place(&self, signal: &str) -> Option<Place> {
        let extreme = match signal {
            "max_mach" => GasExtreme::Mach,
            "density_deviation" => GasExtreme::DensityDeviation,
            _ => return None,
        };
        self.fluid.extreme_place(extreme).map(Place::at)
    }

    fn work(&self) -> u64 {
        self.fluid.work() / u64::from(self.substeps)
    }

    fn slice(&mut self, _name: &str, nodes: &mut [SliceNode]) -> SliceHeader {
        self.cut.fill(&self.fluid, self.spacing, nodes)
    }

    fn volume(&mut self, grid: &VolumeGrid, nodes: &mut [SliceNode]) -> VolumeHeader {
        fill_volume(&self.fluid, self.steps, grid, nodes)
    }
}

/// Takes part in a run, over `line`.
///
/// # Errors
/// A sentence for standard error.
pub fn run(line: ControlPipe) -> Result<(), String> {
    tremie_sdk::run::<AsFluid<GasComponent>>(line)
}
