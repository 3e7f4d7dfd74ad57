//! From a scene and parameters to a time step and what the contacts will be like.

use crate::{
    Parameters, check, check::MIN_STEPS_PER_CONTACT, damping::restitution, law, law::Law, overlaps,
    packing, placement, stability::Stability, walls,
};
use core::f64::consts::PI;
use serde::Serialize;
use tremie_messages::{
    Problem,
    scene::{ContactLaw, Motion, Scene},
};

/// What scene and parameters lead to, before any body is placed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Resolution {
    /// The largest time step that a run may use [s]: the parameter's, or else what the wanted
    /// steps per contact and stability allow. `None` when nothing can touch.
    pub time_step: Option<f64>,
    /// The largest time step that is stable in the densest packing [s]; a settled bed of spheres
    /// bears about twice as much, and shakes for ever at four times.
    pub stable_time_step: Option<f64>,
    /// Duration of the shortest collision without damping, `pi sqrt(m*/k_n)` [s].
    pub contact_time: Option<f64>,
    /// Number of bodies.
    pub bodies: usize,
    /// Number of bodies that move under forces.
    pub free_bodies: usize,
    /// Smallest diameter [m]; 0 without bodies.
    pub smallest_diameter: f64,
    /// Largest diameter [m]; 0 without bodies.
    pub largest_diameter: f64,
    /// The lightest and the heaviest pair under each contact law.
    pub pairs: Vec<PairDamping>,
    /// What a user should know; sentences.
    pub warnings: Vec<String>,
    limits: Limits,
}

/// Damping of one pair of bodies, or of a body and a wall.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PairDamping {
    /// Which pair, as "lightest body-body".
    pub pair: String,
    /// Reduced mass [kg].
    pub reduced_mass: f64,
    /// Damping ratio of the normal dashpot.
    pub damping_ratio: f64,
    /// Coefficient of restitution of a head-on collision.
    pub restitution: f64,
    /// Duration of a collision without damping [s].
    pub contact_time: f64,
}

/// Bounds on the time step [s]; infinite where nothing can touch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
struct Limits {
    /// Shortest collision.
    contact: f64,
    /// Stability of the worst single contact.
    pair: f64,
    /// Stability in a dense packing.
    dense: f64,
}

/// Neighbours of a sphere in the densest packing of equal ones, and walls in a corner.
const MOST_NEIGHBOURS: f64 = 12.0;
const MOST_WALLS: f64 = 3.0;

/// Steps per contact below which accuracy suffers visibly.
const ACCURATE_STEPS: f64 = 15.0;

impl Parameters {
    /// Finds the time step, and everything that is wrong with scene and parameters except overlaps
    /// within packings, which are not made here.
    ///
    /// # Errors
    /// All problems found, each with its key.
    pub fn resolve(&self, scene: &Scene) -> Result<Resolution, Vec<Problem>> {
        let problems = check::scene(scene, self);
        if !problems.is_empty() {
            return Err(problems);
        }
        overlaps::check(scene, &placement::listed(scene))?;
        let population = Population::of(scene);
        let pairs = population.pairs(scene);
        let limits = population.limits(scene, &pairs);
        let finite = |dt: f64| dt.is_finite().then_some(dt);
        let derived = (limits.contact / self.steps_per_contact).min(limits.dense);
        let given = self.time_step.map(|step| step.0);
        let resolution = Resolution {
            time_step: given.or(finite(derived)),
            stable_time_step: finite(limits.dense),
            contact_time: finite(limits.contact),
            bodies: population.bodies,
            free_bodies: population.free,
            smallest_diameter: population.smallest,
            largest_diameter: population.largest,
            warnings: warnings(given, derived, &limits),
            pairs,
            limits,
        };
        if let Some(step) = given {
            resolution.check_time_step(step).map_err(|problem| vec![problem])?;
        }
        Ok(resolution)
    }
}

impl Resolution {
    /// Checks that a run with this time step [s] resolves and survives collisions.
    ///
    /// # Errors
    /// A problem of the parameter `time_step` that says which step would do.
    pub fn check_time_step(&self, step: f64) -> Result<(), Problem> {
        if !(step > 0.0 && step.is_finite()) {
            let message = format!("is {step} s, expected a positive time");
            return Err(Problem::of_parameter("time_step", message));
        }
        let coarsest = self.limits.contact / MIN_STEPS_PER_CONTACT;
        let largest = coarsest.min(self.limits.pair);
        if step <= largest {
            return Ok(());
        }
        let why = if coarsest < self.limits.pair {
            format!("{MIN_STEPS_PER_CONTACT} steps in the shortest collision")
        } else {
            "stability of a single contact".into()
        };
        let message = format!("is {step:.4e} s, but {why} allow at most {largest:.4e} s");
        let good = (self.limits.contact / ACCURATE_STEPS).min(self.limits.dense);
        let help = format!("use {good:.3e} s, leave it unset, or lower the stiffness");
        Err(Problem::of_parameter("time_step", message).help(help))
    }
}

/// Numbers about all bodies of a scene.
struct Population {
    bodies: usize,
    free: usize,
    smallest: f64,
    largest: f64,
    /// Masses of the two lightest and the two heaviest free bodies [kg].
    lightest: [f64; 2],
    heaviest: [f64; 2],
}

impl Population {
    fn of(scene: &Scene) -> Self {
        let mut all = Self {
            bodies: 0,
            free: 0,
            smallest: f64::INFINITY,
            largest: 0.0,
            lightest: [f64::INFINITY; 2],
            heaviest: [0.0; 2],
        };
        for set in &scene.bodies {
            for d in packing::diameters_of(set) {
                all.bodies += 1;
                all.smallest = all.smallest.min(d);
                all.largest = all.largest.max(d);
                if set.motion == Motion::Free {
                    all.add_free(placement::mass(set.density, d));
                }
            }
        }
        if all.bodies == 0 {
            all.smallest = 0.0;
        }
        all
    }

    fn add_free(&mut self, mass: f64) {
        self.free += 1;
        let [first, second] = self.lightest;
        self.lightest = [first.min(mass), second.min(first.max(mass))];
        let [first, second] = self.heaviest;
        self.heaviest = [first.max(mass), second.max(first.min(mass))];
    }

    /// Extreme pairs under each law that can act.
    fn pairs(&self, scene: &Scene) -> Vec<PairDamping> {
        let Some([body, wall]) = law::of_scene(scene) else {
            return Vec::new();
        };
        let reduced = |[a, b]: [f64; 2]| 1.0 / (1.0 / a + 1.0 / b);
        let mut pairs = Vec::new();
        let mut add = |name: &str, law: &ContactLaw, light: f64, heavy: f64| {
            pairs.push(pair_damping(format!("lightest {name}"), law, light));
            pairs.push(pair_damping(format!("heaviest {name}"), law, heavy));
        };
        let law = body;
        if self.free >= 2 {
            add("body-body", law, reduced(self.lightest), reduced(self.heaviest));
        }
        if self.free >= 1 && self.free < self.bodies {
            add("body and body of given motion", law, self.lightest[0], self.heaviest[0]);
        }
        if self.free >= 1 && !walls::of_scene(scene).is_empty() {
            add("body-wall", wall, self.lightest[0], self.heaviest[0]);
        }
        pairs
    }

    fn limits(&self, scene: &Scene, pairs: &[PairDamping]) -> Limits {
        let contact = pairs.iter().fold(f64::INFINITY, |t, p| t.min(p.contact_time));
        let mut single = Stability::default();
        let mut dense = Stability::default();
        let (walls, neighbours) = (walls::of_scene(scene).len(), self.bodies.saturating_sub(1));
        if let (Some([body, wall]), true) = (law::of_scene(scene), self.free > 0) {
            let light = self.lightest[0];
            let (body, wall) = (Law::new(body), Law::new(wall));
            if neighbours > 0 {
                // Between two free bodies both move: twice the rate. Masses as in `pairs`.
                let both = self.lightest.iter().map(|m| 1.0 / m).sum();
                let inverse = if self.free >= 2 { both } else { 1.0 / light };
                single.at_least(&body, inverse, 1.0);
                dense.add(&body, inverse, MOST_NEIGHBOURS.min(neighbours as f64));
            }
            if walls > 0 {
                single.at_least(&wall, 1.0 / light, 1.0);
                dense.add(&wall, 1.0 / light, MOST_WALLS.min(walls as f64));
            }
        }
        Limits { contact, pair: single.largest_step(), dense: dense.largest_step() }
    }
}

fn pair_damping(pair: String, law: &ContactLaw, reduced_mass: f64) -> PairDamping {
    let resolved = Law::new(law);
    let (k, _) = law::stiffnesses(law);
    let root_mass = reduced_mass.sqrt();
    let zeta = resolved.gamma_n(root_mass) / (2.0 * root_mass * k.sqrt());
    PairDamping {
        pair,
        reduced_mass,
        damping_ratio: zeta,
        restitution: restitution(zeta, law.tension),
        contact_time: PI * (reduced_mass / k).sqrt(),
    }
}

fn warnings(given: Option<f64>, derived: f64, limits: &Limits) -> Vec<String> {
    let mut warnings = Vec::new();
    if let Some(step) = given {
        if step > limits.dense {
            warnings.push(format!(
                "the time step is stable for isolated contacts only; a dense packing needs \
                 {:.3e} s or less",
                limits.dense
            ));
        }
    } else if derived == limits.dense && derived.is_finite() {
        warnings.push(format!(
            "stability in a dense packing, not the steps per contact, sets the time step \
             {derived:.3e} s"
        ));
    }
    warnings
}
