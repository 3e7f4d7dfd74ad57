//! Time step and contact properties that follow from a scene and parameters.

use crate::bodies::placed_parts::{self, PlacedPart};
use crate::contact::contact_law::Law;
use crate::contact::lubrication::Squeeze;
use crate::contact::springs::Reduced;
use crate::contact::stability::Stability;
use crate::math::damping::restitution;
use crate::math::parameters::Parameters;
use crate::setup::check::MIN_STEPS_PER_CONTACT;
use crate::setup::check_clumps::{self, ClumpOverlap};
use crate::setup::material_pairs::{BodyStatistics, MaterialPair};
use crate::setup::memory_need::Need;
use crate::setup::slider_times::{self, Grains, SliderTimes};
use crate::setup::softness::Softness;
use crate::setup::step_limit::{self, Tightest};
use crate::setup::{check, check_ports};
use crate::solver::ports::{self, Room};
use crate::solver::{overlaps, placement};
use serde::Serialize;
use tremie_grains_kit::profiles::ProfileSampler;
use tremie_messages::{Problem, scene::Scene};
use tremie_team::Team;

/// Results of scene and parameters, before any body is placed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Resolution {
    /// The largest time step that a run may use [s]: the parameter's, or else what the wanted
    /// steps per contact and stability allow. `None` when nothing can touch.
    pub time_step: Option<f64>,
    /// The largest time step that is stable in the densest packing [s]; a settled bed of spheres
    /// bears about twice as much, and shakes for ever at four times.
    pub stable_time_step: Option<f64>,
    /// Duration of the shortest collision without damping [s], those of sliders with their stops
    /// and half a period on their springs included; under Hertz's law at the expected speed.
    pub contact_time: Option<f64>,
    /// Relative speed for which collisions under Hertz's law are resolved [m/s].
    pub expected_speed: f64,
    /// True if any collision is under Hertz's law.
    pub hertz: bool,
    /// Most bodies that may live at once: spheres and parts that move.
    pub bodies: usize,
    /// Number of spheres at the start.
    pub spheres: usize,
    /// Room for spheres, where inlets feed any.
    pub room: Option<Room>,
    /// Memory that the bodies take [bytes]: the geometric mean of the next two.
    pub memory: u64,
    /// Memory as they lie at the start, and once all that may come lie as close as in a bed
    /// [bytes].
    pub memory_from_to: [u64; 2],
    /// Number of spheres that move under forces.
    pub free_bodies: usize,
    /// Smallest diameter [m]; 0 without bodies.
    pub smallest_diameter: f64,
    /// Largest diameter [m]; 0 without bodies.
    pub largest_diameter: f64,
    /// The lightest and the heaviest pair under each contact law.
    pub pairs: Vec<PairDamping>,
    /// Depth of a corner of the heaviest polyhedron in a wall at the expected speed, over the
    /// radius of the sphere inside; 0 without polyhedra.
    pub corner_depth: f64,
    /// Excess volume of the bodies of clumps where they overlap each other; `None` where none do.
    pub clump_overlap: Option<ClumpOverlap>,
    /// Expected overlaps of spheres.
    pub softness: Softness,
    /// Limit of the time step, in words.
    pub step_limit: String,
    /// Parts that move along an axis under forces.
    pub sliders: Vec<SliderTimes>,
    /// Warnings to the user; sentences.
    pub warnings: Vec<String>,
    limits: Limits,
}

/// Damping of one pair of bodies, or of a body and a wall.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PairDamping {
    /// Name of the pair, as "lightest glass with steel".
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

/// Steps per contact below which accuracy suffers visibly.
const ACCURATE_STEPS: f64 = 15.0;

/// Memory of parts and profiles, of which so many bodies may be samples [bytes].
fn beside_bodies(scene: &Scene, parts: &[PlacedPart], capacity: usize) -> u64 {
    let triangles: u64 = parts.iter().map(|part| part.shape.triangles()).sum();
    triangles * OF_TRIANGLE + ProfileSampler::memory(&scene.profiles, capacity)
}

/// Memory of a triangle of a part, with the structures to find it [bytes]; measured on x86-64.
const OF_TRIANGLE: u64 = 360;

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
        let (listed, parts) = (placement::listed(scene), placed_parts::load(scene)?);
        let mut alone = Team::new("check", 1)
            .map_err(|error| vec![Problem::new("threads", error.to_string())])?;
        overlaps::check(scene, &listed, &parts, &mut alone)?;
        check_ports::room(scene, &parts)?;
        let population = BodyStatistics::of(scene);
        let encounters = population.encounters();
        let speed = self.speed(scene, &population);
        let pairs = encounters.iter().flat_map(|e| extremes(e, speed)).collect::<Vec<_>>();
        let sliders = slider_times::of(scene, &parts);
        let [smallest_diameter, largest_diameter] = population.diameters();
        let grains = Grains {
            free: population.free(),
            diameter: smallest_diameter,
            stiffness: stiffest_at_surfaces(&encounters, speed),
        };
        let (own, tightest) =
            limits(&encounters, speed, Squeeze::of(scene, self), placement::lever(scene));
        let limits = own.and(&sliders, slider_times::stability(&parts, grains));
        let finite = |dt: f64| dt.is_finite().then_some(dt);
        let derived = (limits.contact / self.steps_per_contact).min(limits.dense);
        let given = self.time_step.map(|step| step.0);
        let room = ports::room(scene, self, population.bodies(), &parts);
        let capacity = room.capacity;
        let need = Need::of(scene, self, capacity);
        let resolution = Resolution {
            time_step: given.or(finite(derived)),
            stable_time_step: finite(limits.dense),
            contact_time: finite(limits.contact),
            expected_speed: speed,
            hertz: encounters.iter().any(|e| e.law.spring.law().exponent() > 1.0),
            bodies: capacity + parts.iter().filter(|part| part.moves()).count(),
            spheres: population.bodies(),
            room: (!scene.inlets.is_empty()).then_some(room),
            memory: need.middle() as u64 + beside_bodies(scene, &parts, capacity),
            memory_from_to: [need.start as u64, need.dense as u64],
            free_bodies: population.free(),
            smallest_diameter,
            largest_diameter,
            corner_depth: placement::corner_depth(scene, speed),
            clump_overlap: check_clumps::overlap(scene),
            softness: Softness::of(
                scene,
                &parts,
                &encounters,
                self.expected_speed.map(|speed| speed.0),
            ),
            step_limit: step_limit::reason(
                scene,
                self,
                &encounters,
                &sliders,
                (tightest, limits.contact, limits.dense),
            ),
            warnings: warnings(given, &limits),
            pairs,
            sliders,
            limits,
        };
        if let Some(step) = given {
            resolution.check_time_step(step).map_err(|problem| vec![problem])?;
        }
        Ok(resolution)
    }

    /// The relative speed at which collisions under Hertz's law must be resolved [m/s]: the
    /// parameter's; or else twice the fastest at the start and what a fall through the domain adds.
    fn speed(&self, scene: &Scene, population: &BodyStatistics<'_>) -> f64 {
        if let Some(speed) = self.expected_speed {
            return speed.0;
        }
        let size = scene.domain.size();
        let fall: f64 = (0..3).map(|a| (scene.gravity[a] * size[a]).abs()).sum();
        let speed = 2.0 * population.speed + (2.0 * fall).sqrt();
        if speed > 0.0 { speed } else { SLOWEST }
    }
}

/// Relative speed for which a scene is resolved in which nothing moves yet [m/s].
const SLOWEST: f64 = 0.01;

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

/// The lightest and the heaviest pair of an encounter.
fn extremes(encounter: &MaterialPair<'_>, speed: f64) -> [PairDamping; 2] {
    let MaterialPair { name, law, light, heavy, .. } = encounter;
    [
        pair_damping(format!("lightest {name}"), law, *light, speed),
        pair_damping(format!("heaviest {name}"), law, *heavy, speed),
    ]
}

fn pair_damping(pair: String, law: &Law, reduced: Reduced, speed: f64) -> PairDamping {
    let zeta = law.damping_ratio(reduced);
    PairDamping {
        pair,
        reduced_mass: reduced.root_mass * reduced.root_mass,
        damping_ratio: zeta,
        restitution: restitution(zeta, law.tension),
        contact_time: law.contact_time(reduced, speed),
    }
}

/// Bounds on the time step. The dense bound takes the worst law between bodies and that with
/// surfaces together; tangent stiffnesses of Hertz's law are those of the deepest overlap in a
/// collision at `speed`. With them, which encounters are the tightest.
/// `lever` is how much more than spheres bodies move under a push beside their centroid.
fn limits(
    encounters: &[MaterialPair<'_>],
    speed: f64,
    squeeze: Option<Squeeze>,
    lever: f64,
) -> (Limits, Tightest) {
    let (mut single, mut between, mut at_walls) =
        (Stability::default(), Stability::default(), Stability::default());
    let (mut contact, mut tightest) = (f64::INFINITY, Tightest::default());
    for (index, encounter) in encounters.iter().enumerate() {
        let &MaterialPair { law, light: pair, inverse_mass, .. } = encounter;
        let felt = Reduced { root_mass: (1.0 / inverse_mass).sqrt(), ..pair };
        let time = law.contact_time(felt, speed);
        contact = contact.min(time);
        let overlap = law.largest_overlap(pair, speed);
        let lubrication = squeeze.map_or(0.0, |squeeze| squeeze.largest(pair.radius));
        let of = |contacts| {
            Stability::of(&law, pair, inverse_mass * lever, overlap, contacts)
                .and(Stability::of_dashpot(lubrication * inverse_mass, contacts))
        };
        single = single.or(of(1.0));
        let dense = of(encounter.contacts);
        tightest.add(index, time, dense.largest_step());
        if encounter.with_surface {
            at_walls = at_walls.or(dense);
        } else {
            between = between.or(dense);
        }
    }
    let dense = between.and(at_walls);
    let limits = Limits { contact, pair: single.largest_step(), dense: dense.largest_step() };
    (limits, tightest)
}

/// Largest normal stiffness of a contact with a surface [N/m].
fn stiffest_at_surfaces(encounters: &[MaterialPair<'_>], speed: f64) -> f64 {
    let at_surfaces = encounters.iter().filter(|encounter| encounter.with_surface);
    let slope =
        |e: &MaterialPair<'_>| e.law.normal_slope(e.law.largest_overlap(e.heavy, speed), e.heavy);
    at_surfaces.map(slope).fold(0.0, f64::max)
}

impl Limits {
    /// With those of sliders: alone, and covered with grains.
    fn and(self, sliders: &[SliderTimes], [alone, covered]: [Stability; 2]) -> Self {
        Self {
            contact: self.contact.min(slider_times::shortest(sliders)),
            pair: self.pair.min(alone.largest_step()),
            dense: self.dense.min(covered.largest_step()),
        }
    }
}

fn warnings(given: Option<f64>, limits: &Limits) -> Vec<String> {
    let unstable = given.is_some_and(|step| step > limits.dense);
    let sentence = || {
        format!(
            "the time step is stable for isolated contacts only; a dense packing needs \
             {:.3e} s or less",
            limits.dense
        )
    };
    unstable.then(sentence).into_iter().collect()
}
