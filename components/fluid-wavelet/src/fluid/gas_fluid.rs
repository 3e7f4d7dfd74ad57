//! The gas as its users see it: the world's axes and SI units, bodies by their ids.
//!
//! A window of the run is as many steps of the gas as it takes: they are as long as the gas at that
//! moment allows. Bodies move evenly through the window; the loads on them are means over it.

use crate::bodies::gas_body::BodyLoad;
use crate::domain::initial_gas::InitialGas;
use crate::domain::parameters::{LoadName, Parameters};
use crate::domain::world_axes::WorldAxes;
use crate::fluid::error::GasError;
use crate::fluid::gas_probes::GasProbes;
use crate::fluid::scene_bodies::{SceneBodies, SceneBody};
use crate::fluid::scene_faces::SceneFaces;
use crate::gas::gas_law::GasState;
use crate::solver::gas_sums::{GasExtreme, GasSums};
use crate::solver::observed_point::ObservedPoint;
use crate::solver::part_times::PartTimes;
use crate::solver::wavelet_solver::{TwoLoads, WaveletSettings, WaveletSolver};
use tremie_fluid_kit::bodies::body_registry::BodyRegistry;
use tremie_fluid_kit::bodies::part_way::part_way;
use tremie_fluid_kit::checks::no_threads::no_threads;
use tremie_messages::scene::Scene;
use tremie_messages::{BodyEvent, BodyState, Load, Problem};
use tremie_state::{KeepsState, StateError, StateExchange};

/// Most steps of the gas in a window.
const MOST_STEPS: u32 = 10_000;

/// A compressible gas in a box, with moving bodies in it.
pub struct GasFluid {
    solver: WaveletSolver,
    axes: WorldAxes,
    solids: SceneBodies,
    faces: SceneFaces,
    initial: InitialGas,
    registry: BodyRegistry<()>,
    /// Solids at rest, then the living bodies in the order of their ids.
    bodies: Vec<SceneBody>,
    /// Loads on them, means over the last window.
    loads: Vec<TwoLoads>,
    /// Step of the run's windows [s].
    dt: f64,
    time: f64,
    /// Depth of a plane scene [m], else 1.
    depth: f64,
    gravity: [f64; 3],
    which: LoadName,
    steps: u32,
    points: u64,
    first: GasSums,
    probes: GasProbes,
    /// Level of the points that observers see.
    observed_level: u8,
}

/// Sums and counts of the gas after a window.
#[derive(Clone, Copy, Debug)]
pub struct GasFluidState {
    /// Sums over the gas, along the grid's axes.
    pub sums: GasSums,
    /// The same at the start.
    pub first: GasSums,
    /// True if no gas comes or goes.
    pub is_closed: bool,
    /// Momentum along the world's axes [kg m/s].
    pub momentum: [f64; 3],
    /// Points, significant points, and points as a share of those of the finest grid.
    pub points: [f64; 3],
    /// Levels that have points.
    pub levels: usize,
    /// Steps of the gas in the last window.
    pub steps: u32,
    /// Force on all moving bodies by stress and by momentum [N].
    pub on_bodies: [[f64; 3]; 2],
    /// Depth of a plane scene [m], else 1.
    pub depth: f64,
    /// Number of energy among the fields of sums.
    pub energy_field: usize,
    /// Blocks, coarser ones included.
    pub blocks: usize,
}

impl GasFluidState {
    /// Energy of the gas; of a plane one for a metre of depth [J].
    pub fn energy(&self) -> f64 {
        self.sums.fields[self.energy_field]
    }
}

impl GasFluid {
    /// A gas that [`GasFluid::start`] has yet to fill in, on `threads` threads (the caller's
    /// included). `time_step` [s] is what the plan assigned.
    ///
    /// # Errors
    /// Every problem of parameters and scene.
    pub fn new(
        scene: &Scene,
        parameters: &Parameters,
        time_step: f64,
        threads: usize,
    ) -> Result<Self, Vec<Problem>> {
        let resolution = parameters.resolve(scene)?;
        let axes = WorldAxes::of(scene);
        let initial =
            InitialGas::of(scene, parameters.inviscid).expect("a scene that was checked has a gas");
        let solids = SceneBodies::new(scene, axes)?;
        let faces = SceneFaces::new(scene, axes, &initial);
        let fluid = scene.fluid.as_ref().expect("a scene that was checked has a fluid");
        let settings = WaveletSettings {
            block_edge: parameters.block_edge(axes.dims),
            roots: resolution.roots,
            deepest: resolution.levels,
            coarsest: resolution.cell * f64::from(1_u32 << resolution.levels),
            origin: axes.along(scene.domain.min),
            faces: faces.at(0.0),
            tolerance: parameters.tolerance,
            roughness: parameters.roughness,
            adapt_every: parameters.adapt_every,
            courant: parameters.courant,
            sponge: faces.sponge(parameters),
            acceleration: axes.along(fluid.acceleration),
            rest_pressure: initial.rest.pressure,
            ..WaveletSettings::new(axes.dims, initial.law)
        };
        let solver = WaveletSolver::empty(settings, threads).map_err(no_threads)?;
        let probes = GasProbes::new(scene, axes, resolution.points, resolution.cell);
        Ok(Self {
            bodies: solids.at_rest().to_vec(),
            loads: vec![TwoLoads::default(); solids.at_rest().len()],
            solver,
            axes,
            solids,
            faces,
            initial,
            registry: BodyRegistry::default(),
            dt: time_step,
            time: 0.0,
            depth: scene.domain.depth().unwrap_or(1.0),
            gravity: scene.gravity,
            which: parameters.loads,
            steps: 0,
            points: 0,
            first: GasSums::default(),
            probes: probes.map_err(no_threads)?,
            observed_level: resolution.observed_level,
        })
    }

    /// Adds and removes bodies; effective with the next states.
    ///
    /// # Errors
    /// A body added twice or removed without being there, an unknown kind, no size. The list is then
    /// not applied at all.
    pub fn apply_events(&mut self, events: &[BodyEvent]) -> Result<(), GasError> {
        Ok(self.registry.apply(events)?)
    }

    /// The start exchange: the grid forms around the bodies, and the first loads are found.
    ///
    /// # Errors
    /// States that are not those of the living bodies, gas that is none.
    pub fn start(&mut self, states: &[BodyState], loads: &mut [Load]) -> Result<(), GasError> {
        self.registry.check(states)?;
        self.place(states, 1.0)?;
        let start = GasStart { axes: self.axes, initial: &self.initial };
        self.solver.begin(&self.bodies, |at| start.at(at));
        let found = self.solver.find_loads(&self.bodies);
        found.map_err(|error| GasError::NoGas { time: self.time, error })?;
        self.loads.clone_from(&self.solver.loads);
        self.first = self.solver.sums(&self.bodies);
        self.keep(states);
        self.give_loads(states, loads);
        Ok(())
    }

    /// Goes through a window of `substeps` of the run's steps. `states` are the bodies' at its end;
    /// `loads`, in the same order, are means over it.
    ///
    /// # Errors
    /// States that are not those of the living bodies, no gas somewhere, steps that become too short.
    pub fn advance(
        &mut self,
        substeps: u32,
        states: &[BodyState],
        loads: &mut [Load],
    ) -> Result<(), GasError> {
        self.registry.check(states)?;
        let window = f64::from(substeps) * self.dt;
        let (mut gone, mut steps, mut points) = (0.0, 0_u32, 0);
        let bodies = self.solids.at_rest().len() + states.len();
        self.loads.clear();
        self.loads.resize(bodies, TwoLoads::default());
        while gone < window {
            let left = window - gone;
            let longest = self.solver.longest_step();
            let count = (left / longest).ceil().max(1.0);
            if count > f64::from(MOST_STEPS - steps) {
                let (time, step, most) = (self.time, longest, MOST_STEPS);
                return Err(GasError::TooManySteps { time, window, step, most });
            }
            let dt = left / count;
            gone = if count > 1.0 { gone + dt } else { window };
            self.place(states, gone / window)?;
            self.solver.settings.faces = self.faces.at(self.time + gone);
            let stepped = self.solver.step(dt, &self.bodies);
            stepped.map_err(|error| GasError::NoGas { time: self.time + gone, error })?;
            for (mean, load) in self.loads.iter_mut().zip(&self.solver.loads) {
                mean.by_stress.add_share(load.by_stress, dt / window);
                mean.by_momentum.add_share(load.by_momentum, dt / window);
            }
            steps += 1;
            points += self.solver.points() as u64;
        }
        self.time += window;
        (self.steps, self.points) = (steps, points);
        self.keep(states);
        self.give_loads(states, loads);
        Ok(())
    }

    /// Puts the bodies where they are at a part of the window.
    fn place(&mut self, states: &[BodyState], part: f64) -> Result<(), GasError> {
        self.bodies.clear();
        self.bodies.extend_from_slice(self.solids.at_rest());
        for (known, state) in self.registry.bodies.iter().zip(states) {
            let between = match &known.state {
                Some(before) if part < 1.0 => part_way(before, state, [part; 2]),
                _ => *state,
            };
            self.bodies.push(self.solids.body(&known.event, &between)?);
        }
        Ok(())
    }

    fn keep(&mut self, states: &[BodyState]) {
        for (known, state) in self.registry.bodies.iter_mut().zip(states) {
            known.state = Some(*state);
        }
    }

    /// Writes the loads in the world; bodies float in the gas at rest as in any fluid.
    fn give_loads(&self, states: &[BodyState], loads: &mut [Load]) {
        let first = self.solids.at_rest().len();
        let own = self.bodies[first..].iter().zip(&self.loads[first..]);
        for (((body, two), state), load) in own.zip(states).zip(loads) {
            *load = self.world_load(two);
            load.id = state.id;
            let displaced = self.initial.rest.density * body.volume;
            for a in 0..3 {
                load.force[a] -= displaced * self.gravity[a];
            }
        }
    }

    fn world_load(&self, two: &TwoLoads) -> Load {
        let BodyLoad { force, torque } = match self.which {
            LoadName::Stress => two.by_stress,
            LoadName::Momentum => two.by_momentum,
        };
        let per_depth = |x: f64| self.depth * x;
        Load {
            id: 0,
            force: self.axes.vector_to_world(force).map(per_depth),
            torque: self.axes.turn_to_world(torque).map(per_depth),
        }
    }

    /// Loads on the parts that never move, in the order of the scene's parts.
    pub fn loads_at_rest(&self, loads: &mut Vec<Load>) {
        loads.clear();
        let count = self.solids.at_rest().len();
        loads.extend(self.loads[..count].iter().map(|two| self.world_load(two)));
    }

    /// Force on a face of the domain across an axis of the world [N].
    pub fn wall_force(&self, axis: usize, side: usize) -> [f64; 3] {
        let own = self.axes.order[..self.axes.dims].iter().position(|&a| a == axis);
        let force = own.map_or([0.0; 3], |own| self.solver.wall_force(own, side));
        self.axes.vector_to_world(force).map(|f| f * self.depth)
    }

    /// Sums and counts.
    pub fn state(&self) -> GasFluidState {
        let sums = self.solver.sums(&self.bodies);
        let first = self.solids.at_rest().len();
        let mut on_bodies = [[0.0; 3]; 2];
        for two in &self.loads[first..] {
            for (sum, load) in on_bodies.iter_mut().zip([two.by_stress, two.by_momentum]) {
                (0..3).for_each(|a| sum[a] += self.depth * load.force[a]);
            }
        }
        let [_, x, y, z, _] = sums.fields;
        let momentum = if self.axes.dims == 2 { [x, y, 0.0] } else { [x, y, z] };
        GasFluidState {
            sums,
            first: self.first,
            is_closed: self.faces.are_closed(),
            momentum: self.axes.vector_to_world(momentum).map(|p| p * self.depth),
            points: [
                self.solver.points() as f64,
                self.solver.significant as f64,
                self.solver.share_of_full_grid(),
            ],
            levels: self.solver.tree.levels.len(),
            steps: self.steps,
            on_bodies: on_bodies.map(|force| self.axes.vector_to_world(force)),
            depth: self.depth,
            energy_field: 1 + self.axes.dims,
            blocks: self.solver.tree.blocks.len(),
        }
    }

    /// Place at which a quantity is greatest now [m]. Looks at all points.
    pub fn extreme_place(&self, extreme: GasExtreme) -> Option<[f64; 3]> {
        let place = self.solver.place_of(&self.bodies, &self.first, extreme)?;
        Some(self.axes.to_world(place))
    }

    /// Appends the values of the scene's probes.
    pub fn probes(&mut self, out: &mut Vec<f64>) {
        self.probes.measure(&self.solver, out);
    }

    /// Points times steps of the gas in the last window.
    pub fn work(&self) -> u64 {
        self.points
    }

    /// Where the time of its steps went.
    pub fn times(&self) -> PartTimes {
        self.solver.times
    }

    /// Points along the world's axes that observers see.
    pub fn observed_points(&self) -> [usize; 3] {
        let own = self.solver.points_of_level(self.observed_level);
        let mut points = [1; 3];
        (0..self.axes.dims).for_each(|a| points[self.axes.order[a]] = own[a]);
        points
    }

    /// Their spacing [m].
    pub fn observed_spacing(&self) -> f64 {
        self.solver.settings.spacing(self.observed_level)
    }

    /// Place of one of them [m].
    pub fn place_of(&self, point: [usize; 3]) -> [f64; 3] {
        let (origin, spacing) = (self.solver.settings.origin, self.observed_spacing());
        let own = self.own(point);
        self.axes.to_world(std::array::from_fn(|a| origin[a] + spacing * own[a] as f64))
    }

    fn own(&self, point: [usize; 3]) -> [usize; 3] {
        std::array::from_fn(|a| if a < self.axes.dims { point[self.axes.order[a]] } else { 0 })
    }

    /// The gas at one of them; the velocity along the world's axes.
    pub fn observed(&self, point: [usize; 3]) -> ObservedPoint {
        let mut seen = self.solver.observed(self.observed_level, self.own(point));
        seen.state.velocity = self.axes.vector_to_world(seen.state.velocity);
        seen
    }

    /// The gas at rest.
    pub fn initial(&self) -> &InitialGas {
        &self.initial
    }
}

impl KeepsState for GasFluid {
    const STATE_VERSION: u32 = 1;

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.within("grid", |state| self.solver.exchange(state))?;
        state.value("bodies", &mut self.registry.bodies)?;
        state.value("loads", &mut self.loads)?;
        state.value("time", &mut self.time)?;
        state.value("steps", &mut self.steps)?;
        state.value("points", &mut self.points)?;
        state.value("first_sums", &mut self.first)?;
        if state.restores() {
            let states = self.registry.bodies.iter().map(|body| body.state);
            let Some(states) = states.collect::<Option<Vec<_>>>() else {
                return state.unfit("the state has a body that is nowhere yet");
            };
            if let Err(error) = self.place(&states, 1.0) {
                return state.unfit(error.to_string());
            }
            self.solver.settings.faces = self.faces.at(self.time);
            self.solver.resume(&self.bodies);
        }
        Ok(())
    }
}

/// The start along the grid's axes.
struct GasStart<'a> {
    axes: WorldAxes,
    initial: &'a InitialGas,
}

impl GasStart<'_> {
    fn at(&self, point: [f64; 3]) -> GasState {
        let state = self.initial.at(self.axes.to_world(point));
        GasState { velocity: self.axes.along(state.velocity), ..state }
    }
}
