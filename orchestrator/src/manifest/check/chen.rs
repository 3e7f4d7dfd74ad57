//! Checks of the law of Chen et al. in `[[scene.contacts]]`.

use super::super::document::{ChenTable, ContactTable, SceneTable};
use super::super::path;
use super::super::read::Findings;
use super::contacts::none_of;
use tremie_messages::scene::{ContactLaw, Damping, Spring};

/// The law, with the stiffness for each mass that follows from gravity.
pub(super) fn law(
    scene: &SceneTable,
    table: &ContactTable,
    chen: &ChenTable,
    at: &str,
    findings: &mut Findings,
) -> Option<ContactLaw> {
    let alone = is_alone(table, at, findings);
    let own = path::join(at, "chen");
    let cell = findings.positive(&chen.cell, &own, "cell");
    let theta = findings.positive(&chen.theta, &own, "theta");
    let gap = findings
        .required(&chen.gap, &own, "gap")
        .filter(|gap| findings.not_negative(*gap, &path::join(&own, "gap")));
    let mut number = |value: Option<f64>, key: &str| {
        value.filter(|value| findings.not_negative(*value, &path::join(&own, key)))
    };
    let (alpha, psi) = (number(chen.alpha, "alpha"), number(chen.psi, "psi"));
    let friction = table.friction;
    let friction = friction.filter(|mu| findings.not_negative(*mu, &path::join(at, "friction")));
    let gravity = gravity(scene, &own, findings);
    let spring = Spring::Chen {
        stiffness_per_mass: gravity? / (theta? * cell?),
        gap: gap?.0,
        psi: psi?,
        tangential: chen.tangential?,
    };
    let (damping, tension) = (Damping::Ratio(alpha?), table.tension?);
    alone.then_some(ContactLaw {
        spring,
        friction: friction?,
        rolling_friction: 0.0,
        damping,
        tension,
    })
}

/// True if the table has no key of another law; a problem for each.
fn is_alone(table: &ContactTable, at: &str, findings: &mut Findings) -> bool {
    let others = [
        ("normal_stiffness", table.normal_stiffness.is_some()),
        ("tangential_stiffness", table.tangential_stiffness.is_some()),
        ("hertz", table.hertz == Some(true)),
        ("work_of_adhesion", table.work_of_adhesion.is_some()),
        ("friction_history", table.friction_history == Some(false)),
        ("restitution", table.restitution.is_some()),
        ("normal_damping", table.normal_damping.is_some()),
        ("tangential_damping", table.tangential_damping.is_some()),
    ];
    let message = "found chen too, which has springs and damping of its own";
    let is_alone = none_of(&others, at, (message, "leave out one of them"), findings);
    let rolls = table.rolling_friction != Some(0.0);
    if rolls && let Some(rolling) = table.rolling_friction {
        let message = format!("found {rolling}, but chen has no form with rolling friction");
        findings.problem_with_help(&path::join(at, "rolling_friction"), message, "leave it out");
    }
    is_alone && !rolls
}

/// The strength of gravity [m/s2].
fn gravity(scene: &SceneTable, own: &str, findings: &mut Findings) -> Option<f64> {
    let gravity = scene.gravity?.map(|g| g.0);
    let strength = gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
    if strength > 0.0 {
        return Some(strength);
    }
    if !findings.is_unreadable("scene.gravity") {
        let message = "takes its stiffness from gravity, and there is none";
        let help = "give scene.gravity, or the pair stiffnesses in place of chen";
        findings.problem_with_help(own, message, help);
    }
    None
}
