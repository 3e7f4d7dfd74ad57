//! What follows from scene and parameters before a run: mode, time step, guards, how dense it is.

use crate::bodies::hard_body::HardBody;
use crate::bodies::hard_parts::{self, HardPart};
use crate::cells::body_cells::BodyCells;
use crate::impact::guards::Guards;
use crate::setup::check;
use crate::setup::overlaps;
use crate::setup::parameters::{Detection, Parameters};
use crate::setup::placement;
use serde::Serialize;
use tremie_grains_kit::packing::random_packing;
use tremie_messages::Problem;
use tremie_messages::scene::{BodySizes, Motion, Scene};

/// Results of scene and parameters, before any body is placed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HardResolution {
    /// True if collisions are found from event to event; else from step to step.
    pub by_events: bool,
    /// What acts between collisions, where steps were chosen because of it.
    pub because: Option<String>,
    /// Time step [s]; `None` without bodies that could collide.
    pub time_step: Option<f64>,
    /// Largest relative speed that is expected [m/s].
    pub expected_speed: f64,
    /// Guard of the TC model [s].
    pub contact_time: f64,
    /// Guard by the impact speed [m/s].
    pub elastic_speed: f64,
    /// Number of bodies: spheres, and parts that move.
    pub bodies: usize,
    /// Number of spheres.
    pub spheres: usize,
    /// Smallest and largest diameter [m]; 0 without bodies.
    pub diameters: [f64; 2],
    /// Volume of the bodies over that of the domain, or over that of the densest packing's region.
    pub solid_fraction: f64,
    /// True if grains under weight come to rest on each other.
    pub settles: bool,
    /// Memory [bytes].
    pub memory: u64,
}

/// Part of the smallest radius that a body goes in a step at the expected relative speed; a
/// twentieth at its own.
const STEP: f64 = 0.1;

/// Contact time over the time in which the expected speed passes the smallest diameter.
const CONTACT_TIME: f64 = 1e-5;

/// Height of a fall to the least impact speed, over the smallest diameter.
const FALL: f64 = 1e-7;

impl HardResolution {
    /// The guards against collapse.
    pub fn guards(&self) -> Guards {
        Guards { contact_time: self.contact_time, elastic_speed: self.elastic_speed }
    }
}

impl Parameters {
    /// Finds mode, time step and guards, and everything that is wrong with scene and parameters
    /// except overlaps within packings, which are not made here.
    ///
    /// # Errors
    /// All problems found, each with its key.
    pub fn resolve(&self, scene: &Scene) -> Result<HardResolution, Vec<Problem>> {
        let problems = check::scene(scene, self);
        if !problems.is_empty() {
            return Err(problems);
        }
        let parts = hard_parts::load(scene)?;
        overlaps::separate(scene, &mut placement::listed(scene), &parts)?;
        let diameters: Vec<f64> =
            scene.bodies.iter().flat_map(random_packing::diameters_of).collect();
        let largest = diameters.iter().copied().fold(0.0, f64::max);
        let smallest = diameters.iter().copied().fold(largest, f64::min);
        let weight = scene.gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
        let speed = self.speed(scene);
        let because = check::between_collisions(scene);
        let by_events = match self.detection {
            Detection::Auto => because.is_none(),
            Detection::Events => true,
            Detection::Steps => false,
        };
        let derived = 0.5 * STEP * smallest / speed;
        let spheres = diameters.len();
        Ok(HardResolution {
            by_events,
            because: because.filter(|_| !by_events).map(str::to_string),
            time_step: self
                .time_step
                .map(|step| step.0)
                .or((derived.is_finite() && derived > 0.0).then_some(derived)),
            expected_speed: speed,
            contact_time: self
                .contact_time
                .map_or(if speed > 0.0 { CONTACT_TIME * smallest / speed } else { 0.0 }, |time| {
                    time.0
                }),
            elastic_speed: self
                .elastic_speed
                .map_or((2.0 * weight * FALL * smallest).sqrt(), |speed| speed.0),
            bodies: spheres + parts.iter().filter(|part| part.moves()).count(),
            spheres,
            diameters: [smallest, largest],
            solid_fraction: solid_fraction(scene, &diameters, &parts),
            settles: weight > 0.0 && scene.bodies.iter().any(|set| set.motion == Motion::Free),
            memory: memory(spheres) + hard_parts::memory(&parts),
        })
    }

    /// The largest relative speed to be expected [m/s].
    fn speed(&self, scene: &Scene) -> f64 {
        if let Some(speed) = self.expected_speed {
            return speed.0;
        }
        let size = scene.domain.size();
        let fall: f64 = (0..3).map(|a| (scene.gravity[a] * size[a]).abs()).sum();
        let speed = 2.0 * placement::fastest(scene) + (2.0 * fall).sqrt();
        if speed > 0.0 { speed } else { SLOWEST }
    }
}

/// Relative speed for which a scene is resolved in which nothing moves yet [m/s].
const SLOWEST: f64 = 0.01;

/// Bytes of so many bodies.
fn memory(bodies: usize) -> u64 {
    let of_body = size_of::<HardBody>() + BESIDE_BODY;
    (bodies * of_body) as u64 + BodyCells::memory(bodies)
}

/// Bytes of a body besides its state: events, places, ends of ways, accelerations.
const BESIDE_BODY: usize = 300;

/// The largest of the fractions of packings, and of all bodies in the domain.
fn solid_fraction(scene: &Scene, diameters: &[f64], parts: &[HardPart]) -> f64 {
    let size = scene.domain.size();
    let solid = |part: &HardPart| {
        let (volume, _) = part.shape().surface().volume_and_centroid();
        if part.shape().is_cavity() { 0.0 } else { volume.abs() }
    };
    let whole: f64 = size.iter().product::<f64>() - parts.iter().map(solid).sum::<f64>();
    let bodies: f64 = diameters.iter().map(|&d| scene.domain.body_volume(d)).sum();
    let packings = scene.bodies.iter().map(|set| match set.placement.sizes() {
        BodySizes::Packed(packing) => packing.fraction,
        BodySizes::Listed(_) => 0.0,
    });
    packings.fold(if whole > 0.0 { bodies / whole } else { 0.0 }, f64::max)
}
