//! Numbers of hard spheres, judged before the run.

use crate::setup::hard_resolution::HardResolution;
use tremie_grains_kit::signals::soundness::{limit_of_energy, limit_of_way};
use tremie_messages::finding::short;
use tremie_messages::scene::Scene;
use tremie_messages::{Finding, Limit};

/// Solid fractions: of dense gases, above which lasting contacts form, and of packings in which
/// nothing can move; in space and in a plane (freezing at .49 and .69, jamming at .64 and .84).
const DENSE: [f64; 2] = [0.45, 0.65];
const PACKED: [f64; 2] = [0.6, 0.8];

/// Findings before the run: numbers, each with a verdict.
pub fn findings(scene: &Scene, resolution: &HardResolution) -> Vec<Finding> {
    if resolution.spheres == 0 {
        return Vec::new();
    }
    let mut findings = vec![density(scene, resolution)];
    if let Some(step) = resolution.time_step.filter(|_| !resolution.by_events) {
        findings.push(way(resolution, step));
    }
    findings
}

/// Hard spheres are for grains that fly, not for beds.
fn density(scene: &Scene, resolution: &HardResolution) -> Finding {
    let kind = usize::from(scene.domain.across.is_some());
    let (dense, packed, fraction) = (DENSE[kind], PACKED[kind], resolution.solid_fraction);
    let remedy = "grains-dem for the role grains, whose contacts last; or fewer grains";
    let why = if resolution.settles {
        "grains under weight come to rest on each other at a fraction near 0.6; for a bed take grains-dem"
    } else {
        "collisions take no time: two at a time, never three"
    };
    Finding::new("solid fraction for hard spheres", fraction, "1")
        .because(why)
        .doubtful_if(
            fraction > dense,
            format!("above {dense} grains touch many others at a time, but hard spheres collide two by two"),
            remedy,
        )
        .wrong_if(
            fraction > packed,
            format!("above {packed} all contacts last, but hard spheres have none that do: too dense for hard spheres"),
            remedy,
        )
}

/// Part of the radius that a body may go in a step: 2e-4 of the collisions are missed there.
const FAR: f64 = 0.1;
/// Part of the radius from which on bodies may pass through each other unseen.
const TOO_FAR: f64 = 0.5;

fn way(resolution: &HardResolution, step: f64) -> Finding {
    let radius = 0.5 * resolution.diameters[0];
    let way = 0.5 * resolution.expected_speed * step / radius;
    let remedy = format!(
        "time_step = \"{} s\" in settings.grains-hard-sphere, or leave it unset",
        short(FAR * radius / resolution.expected_speed)
    );
    let speed = short(0.5 * resolution.expected_speed);
    Finding::new("way in a step over the smallest radius", way, "1")
        .because(format!("at {speed} m/s, half of the relative speed to be expected"))
        .doubtful_if(
            way > FAR,
            format!(
                "beyond {FAR} a step misses collisions of bodies that touch and part within it"
            ),
            &remedy,
        )
        .wrong_if(
            way > TOO_FAR,
            format!("beyond {TOO_FAR} bodies pass through each other within a step"),
            &remedy,
        )
}

/// Ways in a step over the smallest radius, doubtful and wrong.
const WAYS: [f64; 2] = [TOO_FAR, 2.0];

/// Limits that signals must keep.
pub fn limits(scene: &Scene, resolution: &HardResolution) -> Vec<Limit> {
    let shorter = "a shorter time_step in settings.grains-hard-sphere";
    let mut all = vec![crowded()];
    // From event to event no step misses anything.
    all.extend((!resolution.by_events).then(|| limit_of_way(WAYS, shorter)));
    all.extend(limit_of_energy(scene, shorter));
    all
}

fn crowded() -> Limit {
    Limit {
        signal: "crowded".into(),
        quantity: "bodies that were held in a step".into(),
        unit: "1".into(),
        doubtful: 0.5,
        wrong: None,
        why: "they collided more often in a step than is resolved, and stood still for the rest of it: they rest on others, \
              or the step is too long"
            .into(),
        remedy: "a shorter time_step, more most_collisions, or grains-dem where grains lie in a bed".into(),
        watch: None,
    }
}
