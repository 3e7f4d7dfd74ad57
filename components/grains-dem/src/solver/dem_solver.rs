//! The solver: bodies, lists and laws, advanced substep by substep.

use crate::Vec3;
use crate::bodies::body_arrays::BLOCK;
use crate::bodies::body_arrays::{Bodies, PlacedSphere, SphereSet};
use crate::bodies::deformable_surface::{DeformableSurface, SurfaceState};
use crate::bodies::drag_bands::{DragBandState, DragBands};
use crate::bodies::message_order::MessageOrder;
use crate::bodies::placed_parts::{PlacedPart, Step};
use crate::bodies::prescribed_spheres::Driven;
use crate::bodies::slider::SliderState;
use crate::bodies::{events, loads};
use crate::contact::contact_force::Steps;
use crate::contact::material_laws::longest_neck;
use crate::forces::pair_forces;
use crate::math::error::GrainsError;
use crate::math::parameters::{Integrator, Parameters};
use crate::math::tally::{Deepest, Other, Tally};
use crate::neighbours::displacement::MaxDisplacement;
use crate::polyhedra::Polyhedra;
use crate::solver::clumps::Clumps;
use crate::solver::diagnostics::Diagnostics;
use crate::solver::diagnostics::{Seen, Survey};
use crate::solver::force_sum::ForceSum;
use crate::solver::integrate::{self, AppliedForces, StepDisplacement};
use crate::solver::interaction_context::InteractionContext;
use crate::solver::neighbour_search::Search;
use crate::solver::ports::Ports;
use crate::solver::probes::Probes;
use crate::solver::profiles::{Profiles, SampledGrains};
use crate::solver::substeps::Progress;
use crate::walls::deformable_surfaces::{RigidWalls, Surfaces};
use crate::walls::wall_forces;
use tremie_grains_kit::neighbours::size_classes::Skins;
use tremie_messages::{
    Place,
    body::{BodyEvent, BodyState, Load},
    frame::{ProfileBin, ProfileHeader},
    scene::{Domain, Scene},
};
use tremie_team::{Choice, Found, Team};

/// Overlap over the smaller radius that ends a run.
const TOO_DEEP: f64 = 0.5;

/// Bodies that live, and properties of bodies that may come.
pub(crate) struct Population {
    pub bodies: Bodies,
    pub polyhedra: Polyhedra,
    pub clumps: Clumps,
    pub driven: Driven,
    /// Properties of the spheres of each set of the scene.
    pub sets: Vec<SphereSet>,
    pub roll: MessageOrder,
    /// The id of the next body that comes.
    pub next_id: u64,
    /// Diameter of the largest sphere that lists are made for [m].
    pub largest: f64,
    /// Bodies that came or went at the end of the last window.
    pub events: Vec<BodyEvent>,
}

/// Threads that share the work.
pub(crate) struct Threads {
    pub team: Team,
    /// Trial of a substep on one thread against all, if the solver is to choose; with its result.
    pub choice: Option<Choice>,
    pub found: Option<Found>,
}

/// Progress of the run.
pub(crate) struct Stepping {
    /// Length of a substep [s].
    pub dt: f64,
    /// How bodies go through one.
    pub integrator: Integrator,
    /// Substeps of the window.
    pub window: u32,
    /// Substeps since the start.
    pub steps: u64,
    /// Progress of the window.
    pub progress: Progress,
}

impl Stepping {
    fn new(dt: f64, integrator: Integrator) -> Self {
        Self { dt, integrator, window: 0, steps: 0, progress: Progress::default() }
    }
}

/// Records of evaluations of forces, and displacements of bodies.
pub(crate) struct StepRecord {
    /// Tally of each block of bodies at the last evaluation, and its displacement.
    pub tallies: Vec<Tally>,
    pub reaches: Vec<StepDisplacement>,
    /// Displacements of blocks since neighbours were listed, and true if any body crossed a
    /// periodic face.
    pub(super) wandered: MaxDisplacement,
    pub crossed: bool,
    /// Sum of the tallies of the last evaluation.
    pub(super) tally: Tally,
    pub(super) max_overlap_ratio: f64,
    /// Bodies that had it, and where.
    pub(super) deepest_place: Option<Place>,
    /// Largest that a window goes on with, where the run watches overlaps; else the default, which
    /// is a fault.
    pub(super) watched_overlap: Option<f64>,
    pub(super) deep_overlaps: u64,
}

impl StepRecord {
    fn new(blocks: usize) -> Self {
        Self {
            tallies: vec![Tally::default(); blocks],
            reaches: vec![StepDisplacement::default(); blocks],
            wandered: MaxDisplacement::none(blocks),
            crossed: false,
            tally: Tally::default(),
            max_overlap_ratio: 0.0,
            deepest_place: None,
            watched_overlap: None,
            deep_overlaps: 0,
        }
    }
}

/// Loads of a fluid.
pub(crate) struct FluidLoads {
    /// True if there are any in this window.
    pub loaded: bool,
    /// Their impulse since the start [N·s].
    pub(super) fluid_impulse: Vec3,
    load_sums: Vec<Result<Vec3, GrainsError>>,
}

/// Spheres, convex polyhedra and clumps of them in a box, in contact with each other and with
/// walls.
pub struct GrainsDem {
    domain: Domain,
    pub(crate) around: InteractionContext,
    pub(crate) gravity: Vec3,
    /// Boxes in which bodies are braked.
    pub(crate) bands: DragBands,
    pub(crate) population: Population,
    pub(crate) search: Search,
    pub(crate) threads: Threads,
    pub(crate) stepping: Stepping,
    pub(crate) record: StepRecord,
    pub(crate) fluid: FluidLoads,
    survey: Survey,
    pub(crate) probes: Probes,
    pub(crate) profiles: Profiles,
    /// Inlets and outlets.
    pub(crate) ports: Ports,
}

impl GrainsDem {
    /// Solver of bodies that were placed and checked.
    pub(crate) fn of_bodies(
        scene: &Scene,
        parameters: &Parameters,
        dt: f64,
        (spheres, parts, surfaces): (&[PlacedSphere], Vec<PlacedPart>, &[DeformableSurface]),
        mut team: Team,
    ) -> Self {
        let largest = largest(scene, spheres);
        let mut around = InteractionContext::of_scene(scene, parameters, parts, surfaces, largest);
        around.laws.set_steps(dt);
        let laws = &around.laws;
        let mut bodies = Bodies::new(spheres, |set| laws.material(&scene.bodies[set].material));
        let polyhedra = Polyhedra::new(scene, spheres, &mut team);
        for ball in &mut bodies.balls {
            ball.x = around.bounds.wrap(ball.x);
        }
        let skins = skins_of(scene, parameters, spheres);
        let clumps = Clumps::of_placed(scene, spheres);
        // Bodies of clumps begin with the velocities of the rigid motion.
        clumps.end(&mut bodies);
        let ports = Ports::of_scene(scene, &around, parameters, dt, spheres.len());
        bodies.reserve(ports.capacity);
        let sets = SphereSet::of_scene(scene, |material| laws.material(material));
        let probes = Probes::new(&scene.probes, &scene.domain, spheres, &bodies);
        let blocks = spheres.len().div_ceil(BLOCK);
        let events = events::initial(spheres, &around.parts);
        let bodies_of_run = events.len();
        let roll = MessageOrder::new(spheres.len(), bodies_of_run - spheres.len());
        let surfaces = Surfaces::new(surfaces, &around.laws, &around.parts, spheres.len());
        let bounds = around.bounds.clone();
        let driven = Driven::of_scene(scene, spheres);
        driven.end(&mut bodies, 0.0);
        let record = StepRecord::new(blocks);
        let load_sums = Vec::with_capacity(bodies_of_run.div_ceil(BLOCK));
        let next_id = roll.first_free();
        Self {
            domain: scene.domain.clone(),
            gravity: scene.gravity.into(),
            bands: DragBands::of_scene(scene, &bounds, ports.capacity.max(spheres.len())),
            search: Search::new(bounds, skins, ports.capacity, surfaces),
            around,
            population: Population {
                bodies,
                polyhedra,
                clumps,
                driven,
                sets,
                roll,
                next_id,
                largest,
                events,
            },
            threads: Threads { team, choice: None, found: None },
            stepping: Stepping::new(dt, parameters.integrator),
            record,
            fluid: FluidLoads { loaded: false, fluid_impulse: Vec3::zeros(), load_sums },
            survey: Survey::default(),
            probes,
            profiles: Profiles::default(),
            ports,
        }
    }

    /// Bodies that came or went at the end of the last window: those that went first, by ascending
    /// id. Before the first window all bodies.
    pub fn events(&self) -> &[BodyEvent] {
        &self.population.events
    }

    /// Number of living bodies: spheres, and parts that move.
    pub fn body_count(&self) -> usize {
        self.population.roll.bodies(&self.population.bodies)
    }

    /// Force of the grains on each part and torque about its reference point [N, N·m], at the end
    /// of the last substep. A part whose origin lies on a symmetry plane is cut by it: the load is
    /// that on the whole.
    pub fn part_loads(&self) -> impl ExactSizeIterator<Item = ([f64; 3], [f64; 3])> + '_ {
        let parts = self.around.parts.iter().zip(&self.search.parts.on_parts);
        parts.map(|(part, wrench)| {
            let whole = part.whole(wrench);
            (whole.force.into(), whole.torque.into())
        })
    }

    /// Force of the grains on each face of the domain that holds them, mirrors too, at the end of
    /// the last substep [N]: by axis, lower before upper, contacts and lubrication; no fluid, no
    /// surfaces that deform. Zero at other faces. Of grains on a face and a part at once, where
    /// these make up one wall, a face has what is due to it.
    pub fn face_forces(&self) -> [[[f64; 3]; 2]; 3] {
        let mut sums = Vec::new();
        self.search.wall_forces(self.around.walls.len(), &mut sums);
        let mut forces = [[[0.0; 3]; 2]; 3];
        for (&(axis, side), force) in self.around.faces.iter().zip(sums) {
            forces[axis][side] = force.into();
        }
        forces
    }

    /// The sliders, in the order of the scene's parts, at the end of the last substep.
    pub fn sliders(&self) -> impl Iterator<Item = SliderState> + '_ {
        let parts = self.around.parts.iter().enumerate();
        parts.filter_map(|(part, placed)| Some(SliderState::of(part, placed.slider()?)))
    }

    /// Radii of the spheres, and of those around polyhedra [m], by ascending id.
    pub fn radii(&self) -> impl ExactSizeIterator<Item = f64> + '_ {
        self.population
            .bodies
            .slot
            .iter()
            .map(|&slot| self.population.bodies.balls[slot as usize].radius)
    }

    /// Finds out from now on whether substeps are faster on all threads or on one, and goes on with
    /// that: either is tried for some substeps, anew when there are half as many bodies again, or
    /// two thirds. Results do not depend on it.
    pub fn choose_threads(&mut self) {
        self.threads.choice = Some(Choice::new(self.threads.team.threads()));
    }

    /// Result of the trial of threads, if one ended since the last call.
    pub fn take_found(&mut self) -> Option<Found> {
        self.threads.found.take()
    }

    /// Length of a substep [s].
    pub fn time_step(&self) -> f64 {
        self.stepping.dt
    }

    pub(crate) fn time(&self) -> f64 {
        self.time_after(0)
    }

    fn time_after(&self, steps: u64) -> f64 {
        (self.stepping.steps + steps) as f64 * self.stepping.dt
    }

    /// Writes pose and velocity of each body, by ascending id; positions lie in the domain.
    ///
    /// # Panics
    /// If `out` does not have [`body_count`](Self::body_count) entries.
    pub fn write_state(&self, out: &mut [BodyState]) {
        assert_eq!(out.len(), self.body_count(), "one state for each body");
        let places = self.population.roll.places_of_parts();
        let moving = self.around.parts.iter().filter(|part| part.moves());
        for ((id, state), part) in
            (self.population.roll.first_part..).zip(&mut out[places.clone()]).zip(moving)
        {
            *state = part.state(id);
        }
        let (early, late) = out.split_at_mut(places.start);
        let spheres = early.iter_mut().chain(&mut late[places.len()..]);
        for ((&id, state), &slot) in
            self.population.bodies.ids.iter().zip(spheres).zip(&self.population.bodies.slot)
        {
            let slot = slot as usize;
            let twist = &self.population.bodies.twists[slot];
            *state = BodyState {
                id,
                position: self.population.bodies.balls[slot].x.into(),
                orientation: self.population.bodies.orientation[slot],
                velocity: twist.v.into(),
                angular_velocity: twist.w.into(),
            };
        }
    }

    /// Writes the force of contacts on each body, in the order of the state, at the end of the last
    /// substep [N]: of a part the force of the grains on the whole of it. `false` where bodies have come
    /// or gone since, so that they are not known.
    pub fn write_contact_forces(&self, out: &mut [[f64; 3]]) -> bool {
        if !self.search.evaluated {
            return false;
        }
        let Population { bodies, roll, .. } = &self.population;
        let contacts = self.search.contacts();
        for (rank, &slot) in bodies.slot.iter().enumerate() {
            let slot = slot as usize;
            if let Some(force) = out.get_mut(roll.place(rank)) {
                *force = ForceSum::alone(contacts, slot, bodies.balls[slot].radius).force.into();
            }
        }
        let moving = self.around.parts.iter().zip(self.part_loads());
        let moving = moving.filter(|(part, _)| part.moves());
        for (place, (_, (force, _))) in roll.places_of_parts().zip(moving) {
            out[place] = force;
        }
        true
    }

    /// Advances by `substeps` steps under constant `loads`, one for each body in the order of the
    /// state; none at all for a dry run. Weight is applied besides, in full. A run with surfaces
    /// that deform goes [substep by substep](Self::begin_substep).
    ///
    /// # Errors
    /// Loads that do not match the bodies, and motions that the contact law cannot describe.
    pub fn advance(&mut self, substeps: u32, loads: &[Load]) -> Result<(), GrainsError> {
        self.begin_window(substeps, loads)?;
        for _ in 0..substeps {
            self.begin_substep()?;
            self.finish_substep(&[])?;
            if self.is_too_deep() {
                // The run ends with this window: what would follow means nothing.
                break;
            }
        }
        self.end_window()
    }

    /// Takes part in a run that watches overlaps: one deeper than `limit`, over the smaller radius,
    /// is no fault of the grains, and ends the substeps of its window.
    pub fn watch_overlaps(&mut self, limit: f64) {
        self.record.watched_overlap = Some(limit);
    }

    fn is_too_deep(&self) -> bool {
        self.record.watched_overlap.is_some_and(|limit| self.record.max_overlap_ratio > limit)
    }

    /// Bodies with the largest overlap since the start, or since the run went on, and where it was.
    pub fn deepest_place(&self) -> Option<Place> {
        self.record.deepest_place
    }

    /// The fastest free body.
    pub fn fastest_place(&self) -> Option<Place> {
        let bodies = &self.population.bodies;
        let square = |slot: &u32| match bodies.mobility[*slot as usize].is_free() {
            true => bodies.twists[*slot as usize].v.norm_squared(),
            false => -1.0,
        };
        // By rank, the order of ids: the first of several.
        let fastest = bodies
            .slot
            .iter()
            .copied()
            .reduce(|best, slot| if square(&slot) > square(&best) { slot } else { best })?;
        let position = bodies.balls[fastest as usize].x.into();
        (square(&fastest) >= 0.0).then(|| Place::of_body(bodies.id_at(fastest as usize), position))
    }

    /// Energies, momentum, contacts.
    pub fn diagnostics(&mut self) -> Diagnostics {
        let steps = Steps { before: self.stepping.dt, after: self.stepping.dt };
        let seen = Seen {
            scenery: self.around.scenery(&self.population.bodies, self.record.crossed, steps),
            contacts: self.search.contacts(),
            walls: &self.around.walls,
            domain: &self.domain,
            gravity: self.gravity,
            parts: &self.around.parts,
            polyhedra: &self.population.polyhedra,
            clumps: &self.population.clumps,
        };
        let sums = self.survey.sums(&mut self.threads.team, &seen);
        Diagnostics {
            contacts: self.record.tally.contacts,
            max_overlap_ratio: self.record.max_overlap_ratio,
            deep_overlaps: self.record.deep_overlaps,
            list_rebuilds: self.search.rebuilds,
            fluid_impulse: self.fluid.fluid_impulse.into(),
            ..sums
        }
    }

    /// Appends the values of the scene's probes, in the order of
    /// [`probe_signals`](crate::probe_signals): flow rates are means since
    /// [`restart_means`](Self::restart_means), or since the start, crossings and masses that passed
    /// are sums since the start, all else is of the end of the last [`advance`](Self::advance).
    pub fn read_probes(&mut self, out: &mut Vec<f64>) {
        self.probes.read(&mut self.threads.team, &self.population.bodies, &self.around.bounds, out);
    }

    /// Samples the scene's profiles from now on, in a run whose windows have a length [s].
    pub fn measure_profiles(&mut self, scene: &Scene, window: f64) {
        let room = self.ports.capacity.max(self.population.bodies.len());
        self.profiles = Profiles::new(scene, window, room);
        self.search.measure_parts(!scene.profiles.is_empty());
        self.sample_profiles();
    }

    /// True if a table of the profile of a name has ended with the last window; with `is_last` the
    /// run has, and a table that was begun counts, too.
    pub fn has_profile(&self, name: &str, is_last: bool) -> bool {
        self.profiles.has_table(name, is_last)
    }

    /// Writes the table of the profile of a name as it is, one entry for each bin, and tells its
    /// times and samples; none where there is no such profile.
    pub fn profile(&self, name: &str, bins: &mut [ProfileBin]) -> ProfileHeader {
        self.profiles.table(name, bins)
    }

    /// Gives the grains to the profiles that want them now.
    pub(crate) fn sample_profiles(&mut self) {
        let seen = SampledGrains {
            bodies: &self.population.bodies,
            contacts: self.search.contacts(),
            walls: &self.around.walls,
            domain: &self.domain,
        };
        self.profiles.take(&mut self.threads.team, &seen);
    }

    /// Begins the means over time that probes tell anew.
    pub fn restart_means(&mut self) {
        self.probes.restart_means();
    }

    /// What each drag band took from the bodies since the start, in the order of the scene.
    pub fn drag_bands(&self) -> impl ExactSizeIterator<Item = DragBandState> + '_ {
        self.bands.states()
    }

    /// Notes what drag bands take in a kick of this duration [s], before it.
    pub(super) fn account_of_bands(&mut self, duration: f64) {
        let Population { bodies, clumps, .. } = &self.population;
        self.bands.account(&mut self.threads.team, bodies, clumps.braked(), duration);
    }

    pub(crate) fn take_loads(&mut self, substeps: u32, loads: &[Load]) -> Result<(), GrainsError> {
        self.fluid.loaded = !loads.is_empty();
        if self.fluid.loaded {
            let (bodies, sums) = (&mut self.population.bodies, &mut self.fluid.load_sums);
            let force =
                loads::take(&mut self.threads.team, bodies, loads, self.population.roll, sums)?;
            self.fluid.fluid_impulse += force * (f64::from(substeps) * self.stepping.dt);
        }
        let of_parts = loads.get(self.population.roll.places_of_parts()).unwrap_or_default();
        let mut of_parts = of_parts.iter();
        for part in self.around.parts.iter_mut().filter(|part| part.moves()) {
            let load = of_parts.next();
            if let Some(slider) = part.slider_mut() {
                slider.take(load);
                let force = slider.axis * slider.pushes.fluid;
                self.fluid.fluid_impulse += force * (f64::from(substeps) * self.stepping.dt);
            }
        }
        Ok(())
    }

    /// Moves the bodies to the end of a substep, which may be the `first` of a window, and lists
    /// neighbours anew where they moved far.
    pub(crate) fn drift(&mut self, first: bool) -> Result<(), GrainsError> {
        let (from, to) = (self.time(), self.time_after(1));
        self.population.driven.begin(&mut self.population.bodies, from, to);
        let finish = !first && self.stepping.integrator == Integrator::Verlet;
        if self.stepping.integrator == Integrator::Chen {
            self.move_in_window(first);
        } else {
            self.move_by_half_kicks(finish);
        }
        let due = self.follow_bodies();
        self.population.driven.end(&mut self.population.bodies, to);
        self.around.slide(to);
        self.population.clumps.end(&mut self.population.bodies);
        let (bodies, team) = (&mut self.population.bodies, &mut self.threads.team);
        self.population.polyhedra.first_half(
            team,
            bodies,
            self.fluid.loaded,
            (self.stepping.dt, finish),
        );
        let mut wrapped = false;
        let step = Step { from, to, dt: self.stepping.dt, finish };
        for part in &mut self.around.parts {
            wrapped |= part.advance(&step, &self.around.bounds);
        }
        self.stepping.steps += 1;
        self.search.surfaces.follow_bodies();
        self.check_sliders()?;
        let limit = self.search.skins().least_slack();
        let far = wrapped || self.around.parts.iter().any(|part| part.moved >= limit);
        if far || due {
            self.check_inside()?;
            self.rebuild_lists();
        }
        Ok(())
    }

    /// Half kicks, drift and prediction of Verlet's method.
    fn move_by_half_kicks(&mut self, finish: bool) {
        let dt = self.stepping.dt;
        self.account_of_bands(if finish { dt } else { 0.5 * dt });
        let forces = AppliedForces::of(&self.search, &self.fluid, (self.gravity, &self.bands));
        let (team, bodies) = (&mut self.threads.team, &mut self.population.bodies);
        let bounds = &self.around.bounds;
        let step = (self.stepping.dt, finish);
        self.population.clumps.begin(bodies, forces, step);
        let leash = self.search.leash();
        integrate::first_half(
            team,
            bodies,
            (bounds, leash),
            forces,
            step,
            &mut self.record.reaches,
        );
    }

    /// Notes how far bodies have gone, and which images they see since; true if neighbours are to
    /// be listed anew.
    pub(super) fn follow_bodies(&mut self) -> bool {
        let reach =
            self.record.reaches.iter().fold(StepDisplacement::default(), |all, &one| all.and(one));
        if reach.crossed {
            self.record.crossed = true;
            let blocks = (0..).zip(&self.record.reaches).filter(|(_, reach)| reach.crossed);
            // Entries name the image of the other body, and a crossing changes it.
            self.search.pairs.follow(&self.population.bodies.crossed, blocks.map(|(b, _)| b));
        }
        self.record.wandered.extend(self.record.reaches.iter().map(|reach| reach.farthest.sqrt()));
        reach.due
    }

    /// Contact forces at the predicted velocities, with those on `surfaces` as they are accepted.
    pub(crate) fn evaluate_forces(
        &mut self,
        steps: Steps,
        surfaces: &[SurfaceState<'_>],
    ) -> Result<(), GrainsError> {
        self.record.tallies.fill(Tally::default());
        self.search.evaluated = true;
        let scenery = self.around.scenery(&self.population.bodies, self.record.crossed, steps);
        let (team, search) = (&mut self.threads.team, &mut self.search);
        let (wandered, tallies) = (&self.record.wandered, &mut self.record.tallies[..]);
        pair_forces::between_bodies(team, &mut search.pairs, scenery, wandered, tallies);
        let walls = &self.around.walls;
        wall_forces::evaluate(team, &mut search.walls, walls, scenery, &mut self.record.tallies);
        let parts = &self.around.parts;
        let near = self.around.near_surfaces(&self.population.bodies, search.cells.skins());
        let rigid = RigidWalls { contacts: &mut search.parts, parts, walls };
        // Before the rigid walls, which share contacts with what spheres reach of the surfaces.
        search.surfaces.look(surfaces, (&scenery, &near), rigid)?;
        let (rigid, soft) = (&mut search.parts, &search.surfaces);
        rigid.evaluate(team, (parts, walls), soft, scenery, &mut self.record.tallies);
        let on_solids = search.solids.evaluate(
            team,
            &mut self.population.polyhedra,
            scenery,
            (walls, parts),
            (&mut search.parts.on_parts, &mut search.parts.pushes),
        );
        let mut on_surfaces = Tally::default();
        search.surfaces.accept(surfaces, &scenery, &mut on_surfaces);
        self.push_sliders(surfaces);
        let forces = AppliedForces::of(&self.search, &self.fluid, (self.gravity, &self.bands));
        self.population.clumps.evaluate(&self.population.bodies, forces);
        self.record.tally = Tally::sum(&[Tally::sum(&self.record.tallies), on_surfaces, on_solids]);
        self.record.deep_overlaps += self.record.tally.deep;
        let deepest = self.record.tally.deepest;
        if deepest.ratio > self.record.max_overlap_ratio {
            self.record.max_overlap_ratio = deepest.ratio;
            self.record.deepest_place = Some(self.place_of(deepest));
        }
        Ok(())
    }

    /// The place of a contact: the body of the smaller id.
    fn place_of(&self, deepest: Deepest) -> Place {
        let bodies = &self.population.bodies;
        let id = |slot: u32| (bodies.id_at(slot as usize), slot);
        let (one, other) = (
            id(deepest.body),
            match deepest.other {
                Other::Body(other) => Some(id(other)),
                Other::Wall(_) | Other::Part(_) | Other::Surface(_) => None,
            },
        );
        let first = other.map_or(one, |other| one.min(other));
        let second = other.map(|other| one.max(other).0);
        Place::of_body(first.0, bodies.balls[first.1 as usize].x.into()).with(second)
    }

    /// Gives the sliders the forces of this evaluation.
    fn push_sliders(&mut self, surfaces: &[SurfaceState<'_>]) {
        let parts = &mut self.around.parts;
        for (part, push) in parts.iter_mut().zip(&self.search.parts.pushes) {
            if let Some(slider) = part.slider_mut() {
                slider.evaluate(push.force());
            }
        }
        for (held, state) in self.search.surfaces.held.iter().zip(surfaces) {
            if let Some(slider) = parts[held.carrier].slider_mut() {
                slider.carry(held.on_carrier, state.carrier_force.into());
            }
        }
    }

    pub(crate) fn rebuild_lists(&mut self) {
        let Population { bodies, polyhedra, .. } = &mut self.population;
        self.search.rebuild(&mut self.threads.team, bodies, polyhedra, &mut self.around);
        self.record.crossed = false;
        self.record.wandered.begin(self.population.bodies.len().div_ceil(BLOCK));
    }

    pub(crate) fn check_overlap(&self) -> Result<(), GrainsError> {
        let deepest = self.record.tally.deepest;
        if deepest.ratio <= TOO_DEEP || self.record.watched_overlap.is_some() {
            return Ok(());
        }
        let id = |slot: u32| self.population.bodies.id_at(slot as usize);
        let (id, other) = self.around.name(id(deepest.body), deepest.other, id);
        let percent = 100.0 * deepest.ratio;
        Err(GrainsError::Overlap { id, other, percent })
    }

    /// A slider must be somewhere.
    fn check_sliders(&self) -> Result<(), GrainsError> {
        let lost = |slider: &SliderState| !slider.lift.is_finite();
        match self.sliders().find(lost) {
            None => Ok(()),
            Some(slider) => Err(GrainsError::SliderLost { part: slider.part }),
        }
    }

    /// Every centre must lie inside the domain, or beyond a face through which spheres leave.
    pub(super) fn check_inside(&self) -> Result<(), GrainsError> {
        let outside = |&&slot: &&u32| {
            let x = self.population.bodies.balls[slot as usize].x;
            !self.around.bounds.contains_but_for(self.around.ways_out, x)
        };
        match self.population.bodies.slot.iter().find(outside) {
            None => Ok(()),
            Some(&slot) => {
                let [x, y, z] = self.population.bodies.balls[slot as usize].x.into();
                let id = self.population.bodies.id_at(slot as usize);
                Err(GrainsError::LeftDomain { id, x, y, z })
            }
        }
    }
}

/// Diameter of the largest body that may come up, in a run that starts with these [m].
fn largest(scene: &Scene, spheres: &[PlacedSphere]) -> f64 {
    spans(scene, spheres).fold(0.0, |largest, [_, most]| largest.max(most))
}

/// The classes of sizes of a run that starts with these bodies.
fn skins_of(scene: &Scene, parameters: &Parameters, spheres: &[PlacedSphere]) -> Skins {
    let film = parameters.lubrication.map_or(0.0, |lubrication| lubrication.cutoff.0);
    let reach = film.max(longest_neck(scene, largest(scene, spheres)));
    Skins::new(spans(scene, spheres), parameters.skin_fraction(), reach)
}

/// Diameters of the bodies at the start and of those that inlets feed, as smallest and largest [m].
fn spans<'a>(
    scene: &'a Scene,
    spheres: &'a [PlacedSphere],
) -> impl Iterator<Item = [f64; 2]> + Clone + 'a {
    let of_body = |sphere: &PlacedSphere| [2.0 * sphere.ball.radius; 2];
    spheres.iter().map(of_body).chain(scene.inlets.iter().map(|inlet| inlet.diameters.extremes()))
}
