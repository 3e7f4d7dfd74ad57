//! Numbers of the contacts, judged before the run.

use crate::math::parameters::{Lubrication, Parameters};
use crate::setup::check::MIN_STEPS_PER_CONTACT;
use crate::setup::check_clumps::ClumpOverlap;
use crate::setup::resolution::Resolution;
use crate::setup::slider_times::SliderTimes;
use crate::setup::softness::SMALL;
use crate::solver::ports::Room;
use tremie_grains_kit::signals::soundness::{limit_of_energy, limit_of_way};
use tremie_messages::finding::short;
use tremie_messages::scene::{Damping, Scene};
use tremie_messages::{Finding, Limit, WatchedQuantity};

/// Steps in a collision from which flows are accurate to a few per cent.
const ACCURATE_STEPS: f64 = 15.0;
/// Damping ratio above which less than a tenth of the speed is left after a collision, and how much
/// depends strongly on the masses.
const STRONG: f64 = 0.6;

/// Findings about the contacts before the run: numbers, each with a verdict.
pub fn findings(scene: &Scene, parameters: &Parameters, resolution: &Resolution) -> Vec<Finding> {
    let mut findings = Vec::new();
    findings.extend(memory_of_sphere(resolution));
    findings.extend(resolution.room.map(|room| room_for_spheres(scene, parameters, room)));
    findings.extend(parameters.lubrication.and_then(|law| cutoff(law, resolution)));
    if let (Some(contact), Some(step)) = (resolution.contact_time, resolution.time_step) {
        findings.push(steps_per_contact(contact, step));
    }
    findings.extend(resolution.clump_overlap.as_ref().map(overlap_of_clumps));
    findings.extend(corners(resolution));
    findings.extend(resolution.softness.findings());
    if let Some(step) = resolution.time_step {
        findings.extend(resolution.sliders.iter().flat_map(|slider| of_slider(slider, step)));
    }
    // A damping ratio that follows from a restitution is what the user asked for.
    let by_dashpot =
        scene.contacts.iter().any(|pair| matches!(pair.law.damping, Damping::Coefficients { .. }));
    let mut last = f64::NAN;
    for pair in &resolution.pairs {
        // The heaviest pair follows the lightest, and by a restitution is damped alike.
        if pair.pair.starts_with("heaviest") && pair.damping_ratio == last {
            continue;
        }
        last = pair.damping_ratio;
        let why = format!(
            "restitution {:.3} at a reduced mass of {} kg: the dashpot's coefficient is fixed, so that lighter grains \
             lose more, and this pair nearly all of its speed",
            pair.restitution,
            short(pair.reduced_mass)
        );
        findings.push(
            Finding::new(format!("damping ratio, {}", pair.pair), pair.damping_ratio, "1")
                .because(format!("restitution {:.3}", pair.restitution))
                .doubtful_if(
                    by_dashpot && pair.damping_ratio > STRONG,
                    why,
                    "give the coefficient of restitution instead, which is then the same for all masses",
                ),
        );
    }
    findings
}

/// Part of a clump's mass that may count twice before a user should know.
const TWICE: f64 = 0.01;

/// Overlaps inside clumps count twice, unless the clump is a union.
fn overlap_of_clumps(overlap: &ClumpOverlap) -> Finding {
    let ClumpOverlap { clump, excess, united, count, of } = overlap;
    let others = if *of > 1 {
        format!(" ({count} of {of} clumps that were looked at are so)")
    } else {
        String::new()
    };
    let percent = short((1000.0 * excess).round() / 10.0);
    let finding = Finding::new("volume of overlaps in a clump, over its union", *excess, "1");
    if *united {
        return finding.because(format!(
            "the pieces of \"{clump}\" are {percent} % more than their union, which its mass and buoyancy are of{others}"
        ));
    }
    let why = format!(
        "pieces of \"{clump}\" overlap, and what they share counts twice: mass and buoyancy are {percent} % more than those of \
         their union{others}"
    );
    finding.because(&why).doubtful_if(
        *excess > TWICE,
        why,
        "mass = \"union\" beside the clump's name in one of its sets, if that is what it weighs; else a smaller density",
    )
}

/// Finding about inlets that may feed more spheres than there is room for. Where spheres leave, a
/// user may know that they are fewer.
fn room_for_spheres(scene: &Scene, parameters: &Parameters, room: Room) -> Finding {
    let Room { capacity, fits, fraction } = room;
    let (fits, fraction) = (fits.ceil(), short((fraction * 100.0).round() / 100.0));
    let knows = parameters.capacity.is_some() && !scene.outlets.is_empty();
    let why = format!("{fits} fit into the domain, packed to {fraction}");
    Finding::new("room for spheres", capacity as f64, "1").because(&why).doubtful_if(
        (capacity as f64) < fits && !knows,
        format!(
            "{why}: inlets may feed so many, and a run ends in an error where they feed more than {capacity}"
        ),
        format!(
            "capacity = {fits} in settings.grains-dem, if the memory is there; or outlets, inlets that end (`until`), larger \
             grains"
        ),
    )
}

/// Overlap over the smaller radius beyond which bodies are about to pass through each other.
const TOO_DEEP: f64 = 0.5;
/// Name of the signal with the deepest overlap.
pub(crate) const MAX_OVERLAP: &str = "max_overlap_ratio";
/// Ways in a step over the smallest radius, doubtful and wrong.
const WAYS: [f64; 2] = [0.1, 1.0];

/// Limits that signals must keep.
pub fn limits(scene: &Scene) -> Vec<Limit> {
    let shorter = "a shorter time_step in settings.grains-dem";
    let mut all = vec![overlap(), limit_of_way(WAYS, format!("{shorter}, or lower speeds"))];
    all.extend(limit_of_energy(
        scene,
        format!("{shorter}; the integrator \"verlet\", if it is another"),
    ));
    all
}

fn overlap() -> Limit {
    Limit {
        signal: MAX_OVERLAP.into(),
        quantity: "greatest overlap over the smaller radius".into(),
        unit: "1".into(),
        doubtful: SMALL,
        wrong: Some(TOO_DEEP),
        why: format!(
            "beyond {SMALL} an overlap is not small: grains take less room than they have, and the contact law means little"
        ),
        remedy: "a larger normal_stiffness (an impact sinks in by its inverse root, a load by its inverse), with a shorter \
                 time step; or lower speeds and lighter loads"
            .into(),
        watch: Some(WatchedQuantity::Overlap),
    }
}

/// Depth of a corner over the radius of the sphere inside beyond which a hit is no small overlap.
const SUNK_CORNER: f64 = 0.3;

/// Depth of corners, which are softer than faces.
fn corners(resolution: &Resolution) -> Option<Finding> {
    let (depth, speed) = (resolution.corner_depth, short(resolution.expected_speed));
    (depth > 0.0).then(|| {
        Finding::new("depth of a corner that hits a wall, over the inner radius", depth, "1")
            .because(format!("at {speed} m/s, the speed to be expected"))
            .doubtful_if(
                depth > SUNK_CORNER,
                format!(
                    "beyond {SUNK_CORNER} a contact is no small overlap, and a run ends where one reaches 0.5"
                ),
                "a larger normal stiffness (it falls with the fourth root), or `expected_speed` if bodies are slower",
            )
    })
}

/// Part of a stroke to which a slider may sink into its stops.
const SUNK: f64 = 0.01;

fn of_slider(slider: &SliderTimes, step: f64) -> Vec<Finding> {
    let (part, depth) = (&slider.part, slider.rest_depth);
    let steps = |what: &str, time: f64| {
        Finding::new(format!("steps in {what}, {part}"), time / step, "1")
            .because(format!("of {} s", short(time)))
            .doubtful_if(
                time < ACCURATE_STEPS * step * (1.0 - 1e-9),
                format!("it takes {ACCURATE_STEPS} or more to be accurate to a few per cent"),
                format!("a time step of {} s or less", short(time / ACCURATE_STEPS)),
            )
    };
    let stop = slider.stop_time.map(|time| steps("a collision with a stop", time));
    let spring = slider.spring_time.map(|time| steps("half a period of the spring", time));
    let sunk = slider.stop_time.map(|_| {
        Finding::new(format!("depth in a stop at rest over the stroke, {part}"), depth, "1")
            .because("under spring, weight and constant force")
            .doubtful_if(
                depth > SUNK,
                format!(
                    "the stops are so soft that more than {SUNK} of the stroke is lost in them"
                ),
                "stiffer stops",
            )
    });
    stop.into_iter().chain(spring).chain(sunk).collect()
}

fn memory_of_sphere(resolution: &Resolution) -> Option<Finding> {
    let [start, dense] = resolution.memory_from_to.map(|bytes| bytes as f64);
    let (spheres, memory) = (resolution.spheres as f64, (start * dense).sqrt());
    let [from, to] = [start, dense].map(|bytes| short(bytes * 1e-6));
    let why = if from == to {
        format!("{from} MB in all")
    } else {
        format!(
            "{from} MB in all at the start, {to} MB once all that may come lie as close as in a bed"
        )
    };
    (spheres > 0.0).then(|| Finding::new("memory of a sphere", memory / spheres, "B").because(why))
}

/// Gap over the radius beyond which the leading term of lubrication theory is not the force.
const NARROW: f64 = 0.5;

/// The fluid's cells are not known here; what they must be is.
fn cutoff(law: Lubrication, resolution: &Resolution) -> Option<Finding> {
    let (gap, radius) = (law.cutoff.0, 0.5 * resolution.smallest_diameter);
    let cells = format!(
        "for a fluid with cells of {} m or more: finer ones resolve such gaps, and the force would count twice",
        short(gap)
    );
    let finding = Finding::new("lubrication cut-off over the smallest radius", gap / radius, "1");
    (radius > 0.0).then(|| {
        finding.because(cells).doubtful_if(
            gap > NARROW * radius,
            format!("the leading term of lubrication theory is for gaps much smaller than a radius, at most {NARROW} of it"),
            format!("a cut-off of {} m or less, and cells of a fluid no larger than that", short(NARROW * radius)),
        )
    })
}

fn steps_per_contact(contact: f64, step: f64) -> Finding {
    let steps = contact / step;
    let time = short(contact);
    Finding::new("steps in the shortest collision", steps, "1")
        .because(format!("of {time} s"))
        .wrong_if(
            steps < MIN_STEPS_PER_CONTACT,
            format!("below {MIN_STEPS_PER_CONTACT} a collision of {time} s is not resolved"),
            format!("a time step of {} s", short(contact / ACCURATE_STEPS)),
        )
        .doubtful_if(
            steps < ACCURATE_STEPS * (1.0 - 1e-9),
            format!("a collision of {time} s takes {ACCURATE_STEPS} or more to be accurate to a few per cent"),
            format!("a time step of {} s or less", short(contact / ACCURATE_STEPS)),
        )
}
