//! Numbers of the contacts, judged before the run.

use crate::check::MIN_STEPS_PER_CONTACT;
use crate::resolve::Resolution;
use tremie_messages::Finding;
use tremie_messages::scene::{Damping, Scene};

/// Steps in a collision from which flows are accurate to a few per cent.
const ACCURATE_STEPS: f64 = 15.0;
/// Damping ratio above which less than a tenth of the speed is left after a collision, and how much
/// depends strongly on the masses.
const STRONG: f64 = 0.6;

/// What is known of the contacts before the run, each number with a verdict.
pub fn findings(scene: &Scene, resolution: &Resolution) -> Vec<Finding> {
    let mut findings = Vec::new();
    if let (Some(contact), Some(step)) = (resolution.contact_time, resolution.time_step) {
        findings.push(steps_per_contact(contact, step));
    }
    // A damping ratio that follows from a restitution is what the user asked for.
    let by_dashpot =
        scene.contacts.iter().any(|pair| matches!(pair.law.damping, Damping::Coefficients { .. }));
    for pair in &resolution.pairs {
        let why = format!(
            "restitution {:.3} at a reduced mass of {:.3e} kg: the dashpot's coefficient is fixed, so that lighter grains \
             lose more, and this pair nearly all of its speed",
            pair.restitution, pair.reduced_mass
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

fn steps_per_contact(contact: f64, step: f64) -> Finding {
    let steps = contact / step;
    Finding::new("steps in the shortest collision", steps, "1")
        .because(format!("of {contact:.3e} s"))
        .wrong_if(
            steps < MIN_STEPS_PER_CONTACT,
            format!("below {MIN_STEPS_PER_CONTACT} a collision of {contact:.3e} s is not resolved"),
            format!("a time step of {:.3e} s", contact / ACCURATE_STEPS),
        )
        .doubtful_if(
            steps < ACCURATE_STEPS * (1.0 - 1e-9),
            format!("a collision of {contact:.3e} s takes {ACCURATE_STEPS} or more to be accurate to a few per cent"),
            format!("a time step of {:.3e} s or less", contact / ACCURATE_STEPS),
        )
}
