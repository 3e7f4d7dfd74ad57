//! The fluid as its users see it: the world's axes and SI units, bodies by their ids.
//!
//! A window of the run is a step of the fluid, or some. The load of a window is that of the step
//! which begins at its end: [`PicFluid::advance`] first moves the particles of the step before, with
//! the bodies where that step ended, and then finds pressure and velocities of the next. So grains
//! get the load of the very step that they take, with their own masses in its solution.

use crate::domain::parameters::{ContactForces, Parameters};
use crate::fluid::contact_prediction::LastingForce;
use crate::fluid::error::FluidError;
use crate::fluid::scene_faces::SceneFaces;
use crate::fluid::scene_solids::{SceneSolids, solids_at_rest};
use crate::grid::staggered_grid::StaggeredGrid;
use crate::particles::seeding::seed;
use crate::pressure::body_coupling::Wrench;
use crate::pressure::conjugate_gradients::{PressureOutcome, Tolerance};
use crate::report::resolution::{FillRegions, Resolution};
use crate::solids::rigid_body::{Freedom, RigidBody};
use crate::solids::section::Section;
use crate::solver::loads::FluidSums;
use crate::solver::pic_settings::PicSettings;
use crate::solver::pic_solver::PicSolver;
use tremie_fluid_kit::bodies::body_registry::BodyRegistry;
use tremie_fluid_kit::bodies::part_way::part_way;
use tremie_fluid_kit::cells::flattened::flattened;
use tremie_fluid_kit::cells::grid::Grid;
use tremie_fluid_kit::checks::no_threads::no_threads;
use tremie_fluid_kit::probes::probe_plan::{ProbePlan, ProbeSum};
use tremie_fluid_kit::probes::probe_signals::{ProbeValues, append};
use tremie_fluid_kit::survey::static_geometry::StaticGeometry;
use tremie_messages::scene::{Domain, ProbeShape, Scene};
use tremie_messages::{BodyEvent, BodyState, Load, Problem};
use tremie_state::{KeepsState, StateError, StateExchange};
use tremie_team::Team;

/// A particle-in-cell fluid in a box, with moving bodies in it.
pub struct PicFluid<const D: usize> {
    solver: PicSolver<D>,
    section: Section<D>,
    solids: SceneSolids<D>,
    faces: SceneFaces<D>,
    registry: BodyRegistry<LastingForce>,
    bodies: Vec<RigidBody<D>>,
    loads: Vec<Wrench>,
    /// Step of the fluid [s].
    dt: f64,
    /// Steps of the last window.
    substeps: u32,
    time: f64,
    gravity: [f64; 3],
    contacts: ContactForces,
    depth: f64,
    outcome: Option<PressureOutcome>,
    first_volume: f64,
    probes: ProbePlan,
    /// Reads the probes.
    reader: Team,
}

/// Sums and counts of the fluid after a window.
#[derive(Clone, Copy, Debug)]
pub struct FluidState {
    /// Sums over particles and cells, along the world's axes.
    pub sums: FluidSums<3>,
    /// Volume at the start [m³].
    pub first_volume: f64,
    /// Volumes that entered through open faces, and that left [m³].
    pub passed: [f64; 2],
    /// Wet cells.
    pub wet_cells: usize,
    /// Particles.
    pub particles: usize,
    /// The pressure's solution.
    pub outcome: Option<PressureOutcome>,
    /// Largest imbalance of a cell's volume [1/s].
    pub divergence: f64,
    /// Cells that the fastest particle crosses in a step.
    pub courant: f64,
    /// Force by which the damping in gaps slowed the fluid in the last step [N].
    pub gap_damping: [f64; 3],
    /// Force of pressure and shear on all bodies, and of shear alone [N].
    pub on_bodies: [[f64; 3]; 2],
}

impl PicFluid<3> {
    /// A fluid in space, without bodies, on `threads` threads (the caller's included). `time_step`
    /// [s] is what the plan assigned.
    ///
    /// # Errors
    /// Every problem of parameters and scene.
    pub fn new(
        scene: &Scene,
        parameters: &Parameters,
        time_step: f64,
        threads: usize,
    ) -> Result<Self, Vec<Problem>> {
        let (resolution, ground) = parameters.survey(scene)?;
        Self::on(
            scene,
            parameters,
            &resolution,
            &ground,
            (Section::SPACE, 1.0),
            (time_step, threads),
        )
    }
}

impl PicFluid<2> {
    /// As [`PicFluid::new`], for a plane scene.
    ///
    /// # Errors
    /// Every problem of parameters and scene.
    pub fn plane(
        scene: &Scene,
        parameters: &Parameters,
        time_step: f64,
        threads: usize,
    ) -> Result<Self, Vec<Problem>> {
        let Domain { min, max, across, .. } = &scene.domain;
        let (Some(across), Some(depth)) = (*across, scene.domain.depth()) else {
            return Err(vec![Problem::new(
                "scene.domain.across",
                "is missing: this is no plane scene",
            )]);
        };
        let axes = [[1, 2], [0, 2], [0, 1]][across];
        let through = std::array::from_fn(|a| 0.5 * (min[a] + max[a]));
        let (resolution, ground) = parameters.survey(scene)?;
        let flat = flattened(scene, resolution.cell);
        let section = (Section { axes, through }, depth);
        Self::on(&flat, parameters, &resolution, &ground, section, (time_step, threads))
    }
}

impl<const D: usize> PicFluid<D> {
    /// On a section of the world, of a depth [m].
    fn on(
        scene: &Scene,
        parameters: &Parameters,
        resolution: &Resolution,
        ground: &StaticGeometry,
        (section, depth): (Section<D>, f64),
        (dt, threads): (f64, usize),
    ) -> Result<Self, Vec<Problem>> {
        let fluid = scene.fluid.as_ref().expect("a scene that was checked has a fluid");
        let cells = section.axes.map(|axis| resolution.cells[axis]);
        let origin = section.along(scene.domain.min);
        let periodic = section.axes.map(|axis| scene.domain.is_periodic(axis));
        let grid = StaggeredGrid::new(cells, resolution.cell, origin, periodic);
        let faces = SceneFaces::new(scene, &section, resolution.sticks);
        let settings = PicSettings {
            density: fluid.density,
            viscosity: fluid.viscosity / fluid.density,
            gravity: section.along(scene.gravity),
            drive: section.along(fluid.acceleration),
            transfer: parameters.transfer(),
            surface: parameters.surface_order(),
            tolerance: Tolerance {
                relative: parameters.tolerance,
                absolute: 1e-14,
                iterations: parameters.iterations,
            },
            particles_per_axis: parameters.particles_per_axis,
            fills_all: resolution.fills_all,
            walls: faces.walls(0.0),
            bodies_stick: resolution.sticks,
            relaxation: parameters.relaxation,
            gap_damping: parameters.gap_damping(),
        };
        let at_rest = solids_at_rest(scene, ground, section);
        let mut solver = PicSolver::new(grid, settings, threads, faces.open.clone(), at_rest)
            .map_err(no_threads)?;
        let reader = Team::new("fluid-pic-probes", 1).map_err(no_threads)?;
        seed_scene(&mut solver, &section, scene, parameters, ground);
        let stored = |at: [i32; 3]| Some(ground.grid.index(at) as u32);
        Ok(Self {
            solids: SceneSolids::new(scene, ground, section, depth),
            faces,
            section,
            registry: BodyRegistry::default(),
            bodies: Vec::new(),
            loads: Vec::new(),
            dt,
            substeps: 1,
            time: 0.0,
            gravity: scene.gravity,
            contacts: parameters.contacts,
            depth,
            outcome: None,
            first_volume: 0.0,
            probes: ProbePlan::new(&scene.probes, &ground.grid, &ground.centres(), stored),
            reader,
            solver,
        })
    }

    /// Adds and removes bodies; effective with the next states.
    ///
    /// # Errors
    /// A body added twice or removed without being there, an unknown kind, no size. The list is then
    /// not applied at all.
    pub fn apply_events(&mut self, events: &[BodyEvent]) -> Result<(), FluidError> {
        Ok(self.registry.apply(events)?)
    }

    /// The start exchange: particles leave the bodies, and the loads of the first step are found.
    ///
    /// # Errors
    /// States that are not those of the living bodies, a pressure that is not found.
    pub fn start(&mut self, states: &[BodyState], loads: &mut [Load]) -> Result<(), FluidError> {
        self.registry.check(states)?;
        self.place(states, [1.0; 2], self.dt, true)?;
        self.solver.remove_inside(&self.bodies);
        self.find_loads()?;
        self.first_volume = self.solver.sums().volume;
        self.give_loads(states, loads, self.dt);
        Ok(())
    }

    /// Takes the steps of a window. `states` are the bodies' at its end; `loads`, in the same
    /// order, are those of the step that follows.
    ///
    /// # Errors
    /// States that are not those of the living bodies, a pressure that is not found, velocities
    /// that are not finite.
    pub fn advance(
        &mut self,
        substeps: u32,
        states: &[BodyState],
        loads: &mut [Load],
    ) -> Result<(), FluidError> {
        self.registry.check(states)?;
        let window = f64::from(substeps) * self.dt;
        self.substeps = substeps;
        for step in 1..=substeps {
            let is_last = step == substeps;
            let parts = [step, step + 1].map(|step| f64::from(step) / f64::from(substeps));
            self.place(states, parts, window, is_last)?;
            self.solver.move_particles(self.dt, &self.bodies);
            self.time += self.dt;
            self.find_loads()?;
        }
        self.give_loads(states, loads, window);
        Ok(())
    }

    /// Puts the bodies where they are at the first of two parts of the window, with the velocities
    /// that they have at the second; only at the window's end forces move them.
    fn place(
        &mut self,
        states: &[BodyState],
        parts: [f64; 2],
        window: f64,
        is_last: bool,
    ) -> Result<(), FluidError> {
        self.bodies.clear();
        for (known, state) in self.registry.bodies.iter_mut().zip(states) {
            if is_last {
                known.own.see(state.velocity, window);
                known.state = Some(*state);
                self.bodies.push(self.solids.body_at_end(known, state, self.contacts)?);
                continue;
            }
            let between = known.state.map_or(*state, |before| part_way(&before, state, parts));
            let mut body = self.solids.body(known, &between)?;
            body.freedom = Freedom::Prescribed;
            self.bodies.push(body);
        }
        Ok(())
    }

    /// Puts known bodies where the last window ended.
    fn put_bodies_back(&mut self) -> Result<(), FluidError> {
        let Self { registry, solids, bodies, contacts, .. } = self;
        let events: Vec<BodyEvent> = registry.bodies.iter().map(|known| known.event).collect();
        let states: Vec<BodyState> =
            registry.bodies.iter().filter_map(|known| known.state).collect();
        registry.check(&states)?;
        // Of bodies that could not have been added, nothing can be relied on.
        let mut added = BodyRegistry::<()>::default();
        added.apply(&events)?;
        added.check(&states)?;
        bodies.clear();
        for (known, state) in registry.bodies.iter().zip(&states) {
            bodies.push(solids.body_at_end(known, state, *contacts)?);
        }
        Ok(())
    }

    /// Sets what holds at the faces of the domain where the step that begins now ends.
    fn set_faces(&mut self) {
        let end = self.time + self.dt;
        self.solver.set_open_factors(self.faces.factors(end));
        self.solver.set_walls(self.faces.walls(end));
    }

    fn find_loads(&mut self) -> Result<(), FluidError> {
        self.set_faces();
        let outcome = self.solver.find_loads(self.dt, &self.bodies, &mut self.loads);
        self.outcome = Some(outcome);
        if !outcome.residual.is_finite() {
            return Err(FluidError::BlewUp { time: self.time });
        }
        if !outcome.converged {
            let PressureOutcome { iterations, residual, .. } = outcome;
            return Err(FluidError::Pressure { time: self.time, iterations, residual });
        }
        Ok(())
    }

    /// Writes the loads in the world, and notes what they will do in a window.
    fn give_loads(&mut self, states: &[BodyState], loads: &mut [Load], window: f64) {
        let own = self.registry.bodies.iter_mut().zip(states).zip(&self.loads);
        for (((known, state), wrench), load) in own.zip(loads) {
            *load = world_load(&self.section, self.depth, wrench);
            load.id = state.id;
            let mass = known.event.mass;
            if mass > 0.0 {
                known.own.expect(std::array::from_fn(|a| {
                    window * (load.force[a] / mass + self.gravity[a])
                }));
            }
        }
    }

    /// Loads on the parts that never move, in the order of the scene's parts.
    pub fn loads_at_rest(&self, loads: &mut Vec<Load>) {
        let mut wrenches = Vec::new();
        self.solver.loads_at_rest(self.dt, &mut wrenches);
        loads.clear();
        loads.extend(wrenches.iter().map(|wrench| world_load(&self.section, self.depth, wrench)));
    }

    /// Forces on the faces of the domain [N], lower and upper along each axis.
    pub fn wall_forces(&self) -> [[[f64; 3]; 2]; 3] {
        let own = self.solver.wall_forces(self.dt);
        let mut forces = [[[0.0; 3]; 2]; 3];
        for a in 0..D {
            forces[self.section.axes[a]] =
                own[a].map(|force| self.section.vector_to_world(force).map(|f| f * self.depth));
        }
        forces
    }

    /// Sums and counts.
    pub fn state(&self) -> FluidState {
        let sums = self.solver.sums();
        let (section, depth) = (&self.section, self.depth);
        let mut on_bodies = [[0.0; 3]; 2];
        let at_rest = self.solver.shear_loads().len() - self.loads.len();
        let shear = &self.solver.shear_loads()[at_rest..];
        for (sum, wrenches) in on_bodies.iter_mut().zip([&self.loads[..], shear]) {
            for wrench in wrenches {
                let load = world_load(section, depth, wrench);
                (0..3).for_each(|a| sum[a] += load.force[a]);
            }
        }
        FluidState {
            sums: FluidSums {
                volume: sums.volume * depth,
                momentum: section.vector_to_world(sums.momentum).map(|p| p * depth),
                kinetic: sums.kinetic * depth,
                potential: sums.potential * depth,
                max_speed: sums.max_speed,
                farthest: section.to_world(sums.farthest).into(),
            },
            first_volume: self.first_volume * depth,
            passed: self.solver.passed_volumes().map(|volume| volume * depth),
            wet_cells: self.solver.wet_cells(),
            particles: self.solver.particles.len(),
            outcome: self.outcome,
            divergence: self.solver.divergence(),
            courant: sums.max_speed * self.dt / self.solver.grid.spacing,
            gap_damping: section
                .vector_to_world(self.solver.gap_damping_taken())
                .map(|p| p * depth / self.dt),
            on_bodies,
        }
    }

    /// Position of the fastest particle [m].
    pub fn place_of_fastest(&self) -> Option<[f64; 3]> {
        let place = self.solver.place_of_fastest()?;
        Some(self.section.to_world(place).into())
    }

    /// Density of the fluid [kg/m³].
    pub fn density(&self) -> f64 {
        self.solver.density()
    }

    /// Number of wet cells.
    pub fn wet_cells(&self) -> usize {
        self.solver.wet_cells()
    }

    /// Appends the values of the scene's probes.
    pub fn probes(&mut self, out: &mut Vec<f64>) {
        let Self { solver, section, probes, reader, dt, depth, .. } = self;
        let cells = solver.grid.cells;
        let count = |axis: usize| {
            section.axes.iter().position(|&own| own == axis).map_or(1, |a| cells[a] as i32)
        };
        let grid = Grid::walled([0, 1, 2].map(|axis| count(axis) as usize), [false; 3]);
        let place = |cell: u32| -> [isize; D] {
            let at = grid.at(cell as usize);
            section.axes.map(|axis| at[axis] as isize)
        };
        probes.measure(reader, |samples, sum| {
            for &(cell, weight) in samples {
                let at = place(cell);
                if solver.is_fluid(at) {
                    let velocity = section.vector_to_world(solver.velocity_in(at));
                    sum.add(weight, solver.pressure(at, *dt), velocity);
                } else {
                    sum.covered += weight;
                }
            }
        });
        // Of the face of a cell across a section.
        let h = solver.grid.spacing;
        let area = if D == 2 { h * *depth } else { h * h };
        let density = solver.density();
        probes.tell(|_, shape, sum| append(shape, &values(shape, sum, area, density), out));
    }

    /// Cells of the box along the world's axes.
    pub fn cells(&self) -> [usize; 3] {
        let mut cells = [1; 3];
        (0..D).for_each(|a| cells[self.section.axes[a]] = self.solver.grid.cells[a]);
        cells
    }

    /// Centre of a cell [m].
    pub fn centre(&self, cell: [usize; 3]) -> [f64; 3] {
        self.section.to_world(self.solver.grid.centre(self.own(cell))).into()
    }

    fn own(&self, cell: [usize; 3]) -> [isize; D] {
        self.section.axes.map(|axis| cell[axis] as isize)
    }

    /// Velocity [m/s] and gauge pressure [Pa] in a cell, the share of it that fluid fills, and
    /// whether it is solid.
    pub fn node(&self, cell: [usize; 3]) -> ([f64; 3], f64, f64, bool) {
        let at = self.own(cell);
        let is_solid = self.solver.open_volume(at) < 0.5;
        if !self.solver.is_fluid(at) {
            return ([0.0; 3], 0.0, self.solver.fill(at), is_solid);
        }
        let velocity = self.section.vector_to_world(self.solver.velocity_in(at));
        (velocity, self.solver.pressure(at, self.dt), self.solver.fill(at), is_solid)
    }
}

impl<const D: usize> KeepsState for PicFluid<D> {
    const STATE_VERSION: u32 = 1;

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.value("bodies", &mut self.registry.bodies)?;
        state.list("loads", &mut self.loads)?;
        state.value("time", &mut self.time)?;
        state.value("first_volume", &mut self.first_volume)?;
        state.value("outcome", &mut self.outcome)?;
        if self.outcome.is_none() {
            return state.unfit("a fluid that has not started has no state");
        }
        if state.restores() {
            if let Err(error) = self.put_bodies_back() {
                return state.unfit(error.to_string());
            }
            if self.loads.len() != self.bodies.len() {
                return state.unfit("the state has other loads than bodies");
            }
            self.set_faces();
        }
        let Self { solver, bodies, .. } = self;
        state.within("fluid", |state| solver.exchange(state, bodies))
    }
}

/// A load of the grid in the world.
fn world_load<const D: usize>(section: &Section<D>, depth: f64, wrench: &Wrench) -> Load {
    let force: [f64; D] = std::array::from_fn(|a| depth * wrench[a]);
    let torque = section.turn_to_world([wrench[3], wrench[4], wrench[5]]);
    Load { id: 0, force: section.vector_to_world(force), torque: torque.map(|t| depth * t) }
}

/// Values of a probe.
fn values(shape: &ProbeShape, sum: &ProbeSum, area: f64, density: f64) -> ProbeValues {
    let across = if let ProbeShape::Section { axis, .. } = shape { *axis } else { 0 };
    let flow_rate = sum.velocity[across] * area;
    ProbeValues {
        pressure: sum.mean(sum.pressure),
        velocity: sum.velocity.map(|u| sum.mean(u)),
        solid_fraction: sum.solid_fraction(),
        flow_rate,
        mass_flow_rate: density * flow_rate,
    }
}

/// Seeds the regions that hold fluid at the start.
fn seed_scene<const D: usize>(
    solver: &mut PicSolver<D>,
    section: &Section<D>,
    scene: &Scene,
    parameters: &Parameters,
    ground: &StaticGeometry,
) {
    let regions = FillRegions::new(scene, ground);
    let fluid = scene.fluid.as_ref().expect("a scene that was checked has a fluid");
    let h = solver.grid.spacing;
    // Of a cell whose centre is solid a part may be open: then a neighbour's centre is fluid.
    let is_reached = |world: [f64; 3]| {
        ground.is_fluid_at(world)
            || (0..3).any(|a| {
                [-h, h].into_iter().any(|step| {
                    let mut beside = world;
                    beside[a] += step;
                    ground.is_fluid_at(beside)
                })
            })
    };
    let is_wet = |at: [f64; D]| {
        let world = section.to_world(at).into();
        regions.region_of(world).is_some() && is_reached(world)
    };
    let velocity = |at: [f64; D]| {
        let own = regions.region_of(section.to_world(at).into()).flatten();
        section.along(own.unwrap_or(fluid.velocity))
    };
    let Parameters { particles_per_axis, jitter, seed: key, .. } = *parameters;
    let PicSolver { grid, particles, .. } = solver;
    seed(grid, particles, particles_per_axis, jitter, key, is_wet, velocity);
    solver.remove_inside(&[]);
}
