//! The hard spheres of a scene that is checked.

use crate::Vec3;
use crate::bodies::hard_parts::{self, HardParts};
use crate::bodies::hard_walls::HardWalls;
use crate::impact::impact_laws::ImpactLaws;
use crate::setup::overlaps;
use crate::setup::parameters::Parameters;
use crate::setup::placement::{self, PlacedBody};
use crate::solver::diagnostics::{self, HardDiagnostics};
use crate::solver::event_driver::EventDriver;
use crate::solver::hard_system::HardSystem;
use crate::solver::step_driver::StepDriver;
use thiserror::Error;
use tremie_grains_kit::checks::loads::LoadError;
use tremie_grains_kit::motion::prescribed_motion::{Path, turn};
use tremie_grains_kit::space::periodic::PeriodicBox;
use tremie_grains_kit::space::rigid_body::Twist;
use tremie_messages::body::{BodyEvent, BodyState};
use tremie_messages::scene::{Domain, Motion, Scene};
use tremie_messages::{Load, Place, Problem};
use tremie_state::{KeepsState, StateError, StateExchange};
use tremie_team::Team;

/// Why an advance stopped.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum HardSphereError {
    /// Loads of the fluid do not match the bodies or are not finite.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// A body is not in the domain any more.
    #[error(
        "body {id} left the domain at ({x:.6e}, {y:.6e}, {z:.6e}) m: reduce the time step, or, for a prescribed body, \
         change its velocity"
    )]
    LeftDomain {
        /// Id of the body.
        id: u64,
        /// Coordinate [m].
        x: f64,
        /// Coordinate [m].
        y: f64,
        /// Coordinate [m].
        z: f64,
    },
}

/// The way in which collisions are found.
enum Driver {
    Events(EventDriver),
    Steps(Box<StepDriver>),
}

/// A body whose motion is prescribed.
struct Follower {
    body: usize,
    path: Path,
}

/// Spheres, or discs of a plane scene, that collide in no time.
pub struct HardSpheres {
    domain: Domain,
    system: HardSystem,
    driver: Driver,
    followers: Vec<Follower>,
    team: Team,
    events: Vec<BodyEvent>,
    /// Orientation of each sphere: a unit quaternion.
    orientations: Vec<[f64; 4]>,
    /// Parts that move, by their numbers.
    moving: Vec<usize>,
    /// Length of a step [s], and steps since the start.
    step: f64,
    steps: u64,
    /// Mean forces on walls, and mean loads on parts, of the last window.
    wall_forces: Vec<Vec3>,
    part_loads: Vec<Load>,
    /// Loads of the fluid on spheres in this window.
    fluid: Vec<Load>,
}

impl HardSpheres {
    /// Makes the bodies of `scene`, packings included, ready to advance by `time_step` [s] on
    /// `threads` threads, whose number has no effect on any result.
    ///
    /// # Errors
    /// Everything that is wrong with the scene or the parameters.
    pub fn new(
        scene: &Scene,
        parameters: &Parameters,
        time_step: f64,
        threads: usize,
    ) -> Result<Self, Vec<Problem>> {
        let resolution = parameters.resolve(scene)?;
        if !(time_step > 0.0 && time_step.is_finite()) {
            let message = format!("is {time_step} s, expected a positive time");
            return Err(vec![Problem::of_parameter("time_step", message)]);
        }
        let parts = hard_parts::load(scene)?;
        let mut placed = placement::place(scene, &parts)?;
        overlaps::separate(scene, &mut placed, &parts)?;
        let team = Team::new("grains", threads).map_err(|error| {
            let message = format!("the system does not give {threads} threads: {error}");
            vec![Problem::new("threads", message)]
        })?;
        let laws = ImpactLaws::of_scene(scene, parameters.tangential_restitution);
        let bounds = PeriodicBox::new(&scene.domain);
        let mut system = HardSystem {
            bodies: placed.iter().map(|body| body.body(scene, &laws)).collect(),
            cells: overlaps::cells_of(scene, &placed),
            walls: HardWalls::of_scene(scene, &laws),
            parts: HardParts::new(parts, scene, &laws, &bounds),
            laws,
            guards: resolution.guards(),
            kappa: if scene.domain.across.is_some() { OF_DISC } else { OF_SPHERE },
            gravity: scene.gravity.into(),
            count: Default::default(),
            virial: 0.0,
        };
        for body in &mut system.bodies {
            body.x = bounds.wrap(body.x);
            body.a = if body.is_free() { system.gravity } else { Vec3::zeros() };
        }
        system.fill_cells();
        let driver = if resolution.by_events {
            system.parts.list(&system.cells, 0.5 * resolution.diameters[1]);
            Driver::Events(EventDriver::new(&system))
        } else {
            let most = parameters.most_collisions;
            Driver::Steps(Box::new(StepDriver::new(&system, time_step, most)))
        };
        let all = system.parts.parts().iter().enumerate();
        let moving: Vec<usize> =
            all.filter(|(_, part)| part.moves()).map(|(number, _)| number).collect();
        Ok(Self {
            domain: scene.domain.clone(),
            events: initial_events(scene, &placed, &system, &moving),
            followers: followers(scene, &placed),
            orientations: vec![[0.0, 0.0, 0.0, 1.0]; placed.len()],
            wall_forces: vec![Vec3::zeros(); system.walls.walls.len()],
            part_loads: vec![Load::default(); system.parts.parts().len()],
            fluid: vec![Load::default(); placed.len()],
            step: time_step,
            steps: 0,
            system,
            driver,
            team,
            moving,
        })
    }

    /// Bodies at the start: spheres by their order, then the parts that move. After that none comes
    /// or goes.
    pub fn events(&self) -> &[BodyEvent] {
        &self.events
    }

    /// Number of bodies: spheres, and parts that move.
    pub fn body_count(&self) -> usize {
        self.system.bodies.len() + self.moving.len()
    }

    /// Number of spheres.
    pub fn sphere_count(&self) -> usize {
        self.system.bodies.len()
    }

    /// Radii of the spheres, in the order of their ids [m].
    pub fn radii(&self) -> impl Iterator<Item = f64> + '_ {
        self.system.bodies.iter().map(|body| body.radius)
    }

    /// True if collisions are found from event to event.
    pub fn is_by_events(&self) -> bool {
        matches!(self.driver, Driver::Events(_))
    }

    /// Advances through one window in so many steps, each under the same loads; none (an empty
    /// slice) where no fluid sits opposite.
    ///
    /// # Errors
    /// Loads that do not match the bodies, and bodies that left the domain.
    pub fn advance(&mut self, steps: u32, loads: &[Load]) -> Result<(), HardSphereError> {
        self.take(loads)?;
        self.events.clear();
        let window = f64::from(steps) * self.step;
        match &mut self.driver {
            Driver::Events(driver) => {
                driver.advance(&mut self.system, window);
                self.turn(window);
                self.steps += u64::from(steps);
            }
            Driver::Steps(_) => (0..steps).for_each(|_| self.one_step()),
        }
        for (force, sum) in self.wall_forces.iter_mut().zip(&mut self.system.walls.impulses) {
            *force = *sum / window;
            *sum = Vec3::zeros();
        }
        self.system.parts.take_loads(window, &mut self.part_loads);
        self.check_places()
    }

    fn one_step(&mut self) {
        let Driver::Steps(driver) = &mut self.driver else { return };
        let [from, to] = [self.steps, self.steps + 1].map(|steps| steps as f64 * self.step);
        self.system.walls.set_time(0.5 * (from + to));
        self.system.parts.begin_step(from, to);
        for Follower { body, path } in &self.followers {
            let way = path.travelled(from, to);
            let body = &mut self.system.bodies[*body];
            (body.v, body.w) = (way.v / self.step, way.w / self.step);
        }
        driver.advance(&mut self.system, &mut self.team);
        for Follower { body, path } in &self.followers {
            let Twist { v, w } = path.twist(to);
            let body = &mut self.system.bodies[*body];
            (body.v, body.w) = (v, w);
        }
        self.system.parts.end_step(to, &self.system.cells.bounds);
        self.steps += 1;
        self.turn(self.step);
    }

    /// Turns the spheres for a time [s], each about its angular velocity. Nothing that they do
    /// depends on where they point.
    fn turn(&mut self, time: f64) {
        for (q, body) in self.orientations.iter_mut().zip(&self.system.bodies) {
            if body.w != Vec3::zeros() {
                *q = turn(*q, body.w * time);
            }
        }
    }

    /// Takes the loads of a window.
    fn take(&mut self, loads: &[Load]) -> Result<(), HardSphereError> {
        if loads.is_empty() {
            return Ok(());
        }
        LoadError::check_count(loads, self.body_count())?;
        for (index, load) in loads.iter().enumerate() {
            LoadError::check(index, load, index as u64)?;
        }
        self.fluid.copy_from_slice(&loads[..self.system.bodies.len()]);
        let Driver::Steps(driver) = &mut self.driver else { return Ok(()) };
        let of = driver.accelerations.iter_mut().zip(&self.system.bodies).zip(loads);
        for ((acceleration, body), load) in of.filter(|((_, body), _)| body.is_free()) {
            let inertia = self.system.kappa * body.radius * body.radius;
            let per_mass = body.inverse_mass;
            *acceleration = Twist {
                v: self.system.gravity + Vec3::from(load.force) * per_mass,
                w: Vec3::from(load.torque) * (per_mass / inertia),
            };
        }
        Ok(())
    }

    fn check_places(&self) -> Result<(), HardSphereError> {
        let bounds = &self.system.cells.bounds;
        let lost = |(_, x): &(usize, Vec3)| {
            (0..3).any(|a| {
                let slack = 1e-6 * bounds.size[a];
                let low = bounds.min[a] - slack;
                !(low..=bounds.min[a] + bounds.size[a] + slack).contains(&x[a])
            })
        };
        let mut places = self.system.bodies.iter().map(|body| body.x).enumerate();
        match places.find(lost) {
            None => Ok(()),
            Some((id, x)) => {
                Err(HardSphereError::LeftDomain { id: id as u64, x: x.x, y: x.y, z: x.z })
            }
        }
    }

    /// Writes the state of all bodies, in the order of ids.
    pub fn write_state(&self, out: &mut [BodyState]) {
        let (spheres, parts) = out.split_at_mut(self.system.bodies.len());
        for (id, state) in spheres.iter_mut().enumerate() {
            *state = self.sphere(id);
        }
        for (state, &part) in parts.iter_mut().zip(&self.moving) {
            let id = (self.system.bodies.len() as u64) + self.moving_rank(part);
            *state = self.system.parts.parts()[part].state(id);
        }
    }

    fn moving_rank(&self, part: usize) -> u64 {
        self.moving.partition_point(|&other| other < part) as u64
    }

    /// State of a sphere. The velocity of one that a lasting contact carries is its mean through the
    /// last step: at rest zero.
    pub fn sphere(&self, id: usize) -> BodyState {
        let body = &self.system.bodies[id];
        let position = self.system.cells.bounds.wrap(body.x);
        BodyState {
            id: id as u64,
            position: position.into(),
            orientation: self.orientations[id],
            velocity: self.velocity(id).into(),
            angular_velocity: body.w.into(),
        }
    }

    fn velocity(&self, id: usize) -> Vec3 {
        match &self.driver {
            Driver::Events(_) => self.system.bodies[id].v,
            Driver::Steps(driver) => driver.velocity(&self.system, id),
        }
    }

    /// Load of the fluid on a sphere in the last window.
    pub fn load(&self, id: usize) -> Load {
        Load { id: id as u64, ..self.fluid[id] }
    }

    /// A part as it is now.
    pub fn part(&self, part: usize) -> BodyState {
        self.system.parts.parts()[part].state(part as u64)
    }

    /// Loads on all parts, in the scene's order: the mean over the last window.
    pub fn part_loads(&self) -> &[Load] {
        &self.part_loads
    }

    /// Forces on the walls, the domain's faces first: the mean over the last window [N].
    pub fn wall_forces(&self) -> &[Vec3] {
        &self.wall_forces
    }

    /// The fastest free body, as others see it.
    pub fn fastest_place(&self) -> Option<Place> {
        let bodies = &self.system.bodies;
        let free = (0..bodies.len()).filter(|id| bodies[*id].is_free());
        let square = |id: usize| self.velocity(id).norm_squared();
        // The first of several.
        let fastest = free.reduce(|best, id| if square(id) > square(best) { id } else { best })?;
        let position = self.system.cells.bounds.wrap(bodies[fastest].x);
        Some(Place::of_body(fastest as u64, position.into()))
    }

    /// Sums over the free bodies, and collisions so far.
    pub fn diagnostics(&self) -> HardDiagnostics {
        let (system, count) = (&self.system, &self.system.count);
        let bodies = system.bodies.iter().enumerate().map(|(k, body)| (body, self.velocity(k)));
        HardDiagnostics {
            collisions: count.pairs,
            wall_collisions: count.walls,
            guarded_by_time: count.by_contact_time,
            guarded_by_speed: count.by_speed,
            crowded: count.crowded,
            ..diagnostics::sums(bodies, system.kappa, system.gravity, &self.domain)
        }
    }

    /// Sum over the collisions of bodies, since the start, of normal impulse times distance [J·s].
    pub fn virial(&self) -> f64 {
        self.system.virial
    }

    /// Events of any kind since the start: collisions, those that did not come true, and bodies
    /// that went from cell to cell; 0 from step to step.
    pub fn event_count(&self) -> u64 {
        match &self.driver {
            Driver::Events(driver) => driver.events,
            Driver::Steps(_) => 0,
        }
    }
}

impl KeepsState for HardSpheres {
    const STATE_VERSION: u32 = 2;

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let Self { system, driver, .. } = self;
        system.exchange(state)?;
        // A state of the other way has other entries.
        match driver {
            Driver::Events(driver) => state.within("by_events", |state| driver.exchange(state))?,
            Driver::Steps(driver) => state.within("by_steps", |state| driver.exchange(state))?,
        }
        state.array("orientation", &mut self.orientations)?;
        state.value("steps", &mut self.steps)?;
        if state.restores() && self.steps > 0 {
            // Bodies came before the first step.
            self.events.clear();
        }
        let walls = &mut self.wall_forces;
        state.column(
            "wall_force",
            walls,
            |f| (*f).into(),
            |f, force: [f64; 3]| *f = force.into(),
        )?;
        state.value("part_loads", &mut self.part_loads)?;
        state.value("fluid_loads", &mut self.fluid)
    }
}

/// Moment of inertia over `m r²`.
const OF_SPHERE: f64 = 0.4;
const OF_DISC: f64 = 0.5;

/// Bodies that follow a path.
fn followers(scene: &Scene, placed: &[PlacedBody]) -> Vec<Follower> {
    let of = |(body, placed): (usize, &PlacedBody)| {
        let path = match &scene.bodies[placed.set].motion {
            // Without points a body keeps the velocity that it was placed with.
            Motion::Prescribed(points) => Path::new(points, placed.twist),
            Motion::Timed(timed) => Path::of_factor(placed.twist, &timed.course),
            Motion::Free | Motion::Fixed | Motion::Slider(_) => return None,
        };
        Some(Follower { body, path })
    };
    placed.iter().enumerate().filter_map(of).collect()
}

fn initial_events(
    scene: &Scene,
    placed: &[PlacedBody],
    system: &HardSystem,
    moving: &[usize],
) -> Vec<BodyEvent> {
    let of_sphere = |(id, body): (u64, &PlacedBody)| BodyEvent {
        id,
        kind: BodyEvent::ADDED,
        shape: match scene.domain.across {
            Some(_) => BodyEvent::CYLINDER,
            None => BodyEvent::SPHERE,
        },
        motion: match scene.bodies[body.set].motion {
            Motion::Free => BodyEvent::FREE,
            Motion::Fixed => BodyEvent::FIXED,
            Motion::Prescribed(_) | Motion::Timed(_) | Motion::Slider(_) => BodyEvent::PRESCRIBED,
        },
        set: body.set as u32,
        mass: body.mass(scene),
        size: [body.ball.radius, scene.domain.depth().unwrap_or(0.0), 0.0],
        table: 0,
    };
    let mut events: Vec<BodyEvent> = (0..).zip(placed).map(of_sphere).collect();
    for &part in moving {
        events.push(BodyEvent {
            id: events.len() as u64,
            kind: BodyEvent::ADDED,
            shape: BodyEvent::PART,
            motion: BodyEvent::PRESCRIBED,
            set: 0,
            mass: 0.0,
            size: [system.parts.parts()[part].shape().bounding_radius(), 0.0, 0.0],
            table: part as u64,
        });
    }
    events
}
