//! The solver: bodies, lists and laws, advanced substep by substep.

use crate::{
    Diagnostics, GrainsError, Parameters, Vec3,
    bodies::{Bodies, PlacedSphere, Wrench},
    diagnostics,
    forces::{self, Steps, Tally},
    integrate,
    law::{self, Law},
    overlaps,
    periodic::PeriodicBox,
    placement,
    search::Search,
    walls::{self, Wall},
};
use tremie_messages::{
    Problem,
    body::{BodyEvent, BodyState, Load},
    scene::{Domain, Motion, Scene},
};

/// Overlap over the smaller radius that ends a run.
const TOO_DEEP: f64 = 0.5;

/// Spheres in a box, in contact with each other and with walls.
pub struct GrainsDem {
    domain: Domain,
    bounds: PeriodicBox,
    gravity: Vec3,
    dt: f64,
    body_law: Law,
    wall_law: Law,
    walls: Vec<Wall>,
    bodies: Bodies,
    events: Vec<BodyEvent>,
    search: Search,
    tally: Tally,
    max_overlap_ratio: f64,
    deep_overlaps: u64,
    fluid_impulse: Vec3,
}

impl GrainsDem {
    /// Makes the bodies of `scene`, packings included, ready to advance by `time_step` [s].
    ///
    /// # Errors
    /// Everything that is wrong with the scene, the parameters or the time step.
    pub fn new(
        scene: &Scene,
        parameters: &Parameters,
        time_step: f64,
    ) -> Result<Self, Vec<Problem>> {
        let resolution = parameters.resolve(scene)?;
        resolution.check_time_step(time_step).map_err(|problem| vec![problem])?;
        let spheres = placement::place(scene)?;
        overlaps::check(scene, &spheres)?;
        let mut solver = Self::of_spheres(scene, parameters, time_step, &spheres);
        solver.rebuild_lists();
        solver.evaluate_forces(0.0);
        Ok(solver)
    }

    fn of_spheres(
        scene: &Scene,
        parameters: &Parameters,
        dt: f64,
        spheres: &[PlacedSphere],
    ) -> Self {
        let bounds = PeriodicBox::new(&scene.domain);
        let bodies = Bodies::new(spheres);
        let largest = 2.0 * spheres.iter().fold(0.0, |r: f64, s| r.max(s.ball.radius));
        let laws = law::of_scene(scene);
        let of = |i: usize| laws.map_or_else(Law::none, |laws| Law::new(laws[i]));
        Self {
            domain: scene.domain.clone(),
            gravity: scene.gravity.into(),
            dt,
            body_law: of(0),
            wall_law: of(1),
            walls: walls::of_scene(scene),
            events: (0..).zip(spheres).map(|(id, s)| added(id, s)).collect(),
            search: Search::new(bounds.clone(), largest, parameters, spheres.len()),
            bounds,
            bodies,
            tally: Tally::default(),
            max_overlap_ratio: 0.0,
            deep_overlaps: 0,
            fluid_impulse: Vec3::zeros(),
        }
    }

    /// The bodies at the start, by ascending id.
    pub fn initial_events(&self) -> &[BodyEvent] {
        &self.events
    }

    /// Number of bodies.
    pub fn body_count(&self) -> usize {
        self.bodies.len()
    }

    /// Radii [m], by ascending id.
    pub fn radii(&self) -> impl ExactSizeIterator<Item = f64> + '_ {
        self.bodies.balls.iter().map(|ball| ball.radius)
    }

    /// Length of a substep [s].
    pub fn time_step(&self) -> f64 {
        self.dt
    }

    /// Writes pose and velocity of each body, by ascending id; positions lie in the domain.
    ///
    /// # Panics
    /// If `out` does not have [`body_count`](Self::body_count) entries.
    pub fn write_state(&self, out: &mut [BodyState]) {
        assert_eq!(out.len(), self.body_count(), "one state for each body");
        for (i, state) in out.iter_mut().enumerate() {
            let twist = &self.bodies.twists[i];
            *state = BodyState {
                id: i as u64,
                position: self.bounds.wrap(self.bodies.balls[i].x).into(),
                orientation: self.bodies.orientation[i],
                velocity: twist.v.into(),
                angular_velocity: twist.w.into(),
            };
        }
    }

    /// Advances by `substeps` steps under constant `loads`, one for each body in the order of the
    /// state; none at all for a dry run. Weight is applied besides, in full.
    ///
    /// # Errors
    /// Loads that do not match the bodies, and motions that the contact law cannot describe.
    pub fn advance(&mut self, substeps: u32, loads: &[Load]) -> Result<(), GrainsError> {
        self.take_loads(substeps, loads)?;
        for substep in 0..substeps {
            self.drift(substep > 0)?;
            self.evaluate_forces(self.dt);
            self.check_overlap()?;
        }
        if substeps > 0 {
            integrate::second_half(&mut self.bodies, self.gravity, self.dt);
        }
        Ok(())
    }

    /// Energies, momentum, contacts.
    pub fn diagnostics(&self) -> Diagnostics {
        let mut out = Diagnostics {
            contacts: self.tally.contacts,
            max_overlap_ratio: self.max_overlap_ratio,
            deep_overlaps: self.deep_overlaps,
            list_rebuilds: self.search.rebuilds,
            fluid_impulse: self.fluid_impulse.into(),
            ..Diagnostics::default()
        };
        let (search, bodies) = (&self.search, &self.bodies);
        let shifts = &self.bounds.shifts;
        diagnostics::add_bodies(&mut out, bodies, &self.domain, self.gravity);
        diagnostics::add_pairs(&mut out, &search.pairs, &self.body_law, shifts, bodies, self.dt);
        let (list, law) = (&search.wall_contacts, &self.wall_law);
        diagnostics::add_walls(&mut out, list, law, &self.walls, bodies, self.dt);
        out
    }

    fn take_loads(&mut self, substeps: u32, loads: &[Load]) -> Result<(), GrainsError> {
        if loads.is_empty() {
            self.bodies.load.fill(Wrench::zero());
            return Ok(());
        }
        check_loads(loads, self.body_count())?;
        let duration = f64::from(substeps) * self.dt;
        for (i, load) in loads.iter().enumerate() {
            let wrench = Wrench { force: load.force.into(), torque: load.torque.into() };
            if self.bodies.mobility[i].is_free() {
                self.fluid_impulse += wrench.force * duration;
            }
            self.bodies.load[i] = wrench;
        }
        Ok(())
    }

    /// Moves the bodies to the end of a substep, and lists neighbours anew where they moved far.
    fn drift(&mut self, finish: bool) -> Result<(), GrainsError> {
        let Self { bodies, search, dt, .. } = self;
        let farthest = integrate::first_half(bodies, self.gravity, *dt, finish, &search.reference);
        let limit = 0.5 * search.skin;
        if farthest >= limit * limit || farthest.is_nan() {
            self.check_inside()?;
            self.rebuild_lists();
        }
        Ok(())
    }

    /// Contact forces at the predicted velocities, `before` after the last evaluation.
    fn evaluate_forces(&mut self, before: f64) {
        let steps = Steps { before, after: self.dt };
        let Bodies { balls, predicted, contact, .. } = &mut self.bodies;
        let (pairs, law, shifts) = (&mut self.search.pairs, &self.body_law, &self.bounds.shifts);
        let mut tally =
            forces::between_bodies(pairs, law, shifts, balls, predicted, steps, contact);
        let (list, law, walls) = (&mut self.search.wall_contacts, &self.wall_law, &self.walls);
        forces::of_walls(list, law, walls, balls, predicted, steps, contact, &mut tally);
        self.tally = tally;
        self.deep_overlaps += tally.deep;
        self.max_overlap_ratio = self.max_overlap_ratio.max(tally.deepest.ratio());
    }

    fn rebuild_lists(&mut self) {
        let bounds = &self.bounds;
        for ball in &mut self.bodies.balls {
            ball.x = bounds.wrap(ball.x);
        }
        self.search.rebuild(&self.bodies, &self.walls, bounds);
    }

    fn check_overlap(&self) -> Result<(), GrainsError> {
        let deepest = self.tally.deepest;
        if deepest.ratio() <= TOO_DEEP {
            return Ok(());
        }
        Err(GrainsError::Overlap {
            id: deepest.body as u64,
            other: if deepest.wall {
                walls::name(&self.domain, deepest.other)
            } else {
                format!("body {}", deepest.other)
            },
            percent: 100.0 * deepest.ratio(),
        })
    }

    /// Every centre must lie inside the domain, up to wrapping.
    fn check_inside(&self) -> Result<(), GrainsError> {
        for (i, ball) in self.bodies.balls.iter().enumerate() {
            let [x, y, z]: [f64; 3] = ball.x.into();
            if !self.bounds.contains(self.bounds.wrap(ball.x)) {
                return Err(GrainsError::LeftDomain { id: i as u64, x, y, z });
            }
        }
        Ok(())
    }
}

fn check_loads(loads: &[Load], bodies: usize) -> Result<(), GrainsError> {
    if loads.len() != bodies {
        return Err(GrainsError::LoadCount { found: loads.len(), expected: bodies });
    }
    for (index, load) in loads.iter().enumerate() {
        let (found, expected) = (load.id, index as u64);
        if found != expected {
            return Err(GrainsError::LoadOrder { index, found, expected });
        }
        if !load.is_finite() {
            return Err(GrainsError::LoadNotFinite { id: found });
        }
    }
    Ok(())
}

fn added(id: u64, sphere: &PlacedSphere) -> BodyEvent {
    BodyEvent {
        id,
        kind: BodyEvent::ADDED,
        shape: BodyEvent::SPHERE,
        motion: match sphere.motion {
            Motion::Free => BodyEvent::FREE,
            Motion::Fixed => BodyEvent::FIXED,
            Motion::Prescribed(_) => BodyEvent::PRESCRIBED,
        },
        set: sphere.set as u32,
        mass: sphere.mass,
        size: [sphere.ball.radius, 0.0, 0.0],
        table: 0,
    }
}
