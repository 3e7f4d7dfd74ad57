//! Checks of the law of a contact.

use crate::contact::springs::{Bound, RegisteredSpring};
use tremie_grains_kit::checks::numbers::not_positive;
use tremie_grains_kit::math::numbers::is_positive;
use tremie_messages::{
    Problem,
    scene::{ContactLaw, Damping, Scene},
};

/// Checks the laws of a scene.
pub(crate) fn laws(scene: &Scene, problems: &mut Vec<Problem>) {
    for (i, pair) in scene.contacts.iter().enumerate() {
        law(&format!("scene.contacts[{i}].law"), &pair.law, problems);
    }
    with_surfaces(scene, problems);
}

/// Checks the numbers of a law.
fn law(key: &str, law: &ContactLaw, problems: &mut Vec<Problem>) {
    let mut not_negative = |name: &str, value: f64| {
        if !(value >= 0.0 && value.is_finite()) {
            let message = format!("is {value}, expected 0 or more");
            problems.push(Problem::new(format!("{key}.{name}"), message));
        }
    };
    let spring = RegisteredSpring::of(&law.spring);
    let numbers = spring.law().numbers();
    for &(name, value, _) in numbers.iter().filter(|(.., bound)| *bound == Bound::NotNegative) {
        not_negative(name, value);
    }
    not_negative("friction", law.friction);
    not_negative("rolling_friction", law.rolling_friction);
    match law.damping {
        Damping::Coefficients { normal, tangential } => {
            not_negative("damping.coefficients.normal", normal);
            not_negative("damping.coefficients.tangential", tangential);
        }
        Damping::Ratio(ratio) => not_negative("damping.ratio", ratio),
        Damping::Restitution(e) => {
            if !(e > 0.0 && e <= 1.0) {
                let message = format!("is {e}, expected a coefficient of restitution in (0, 1]");
                problems.push(Problem::new(format!("{key}.damping.restitution"), message));
            }
        }
    }
    let positive = numbers.iter().filter(|(.., bound)| *bound == Bound::Positive);
    for &(name, value, _) in positive.filter(|(_, value, _)| !is_positive(*value)) {
        problems.push(not_positive(format!("{key}.{name}"), value));
    }
    let (name, restitution) = (spring.law().name(), spring.law().takes_restitution());
    let mismatch = match law.damping {
        Damping::Coefficients { .. } if !spring.law().takes_coefficients() => {
            Some("gives dashpots by coefficients")
        }
        Damping::Restitution(_) if !restitution => Some("gives the restitution"),
        _ => None,
    };
    if let Some(gives) = mismatch {
        let message = format!("{gives}, but the spring is {name}");
        let help = if restitution { "give the restitution" } else { "give the ratio" };
        problems.push(Problem::new(format!("{key}.damping"), message).help(help));
    }
    if spring.law().is_for_rigid_spheres() && law.rolling_friction > 0.0 {
        let found = law.rolling_friction;
        let message = format!("is {found}, but {name} has no form with rolling friction");
        let help = "make it 0, or give the pair another law";
        problems.push(Problem::new(format!("{key}.rolling_friction"), message).help(help));
    }
}

/// Checks that surfaces of the scene that deform are met under laws that have a form for them.
fn with_surfaces(scene: &Scene, problems: &mut Vec<Problem>) {
    for (i, pair) in scene.contacts.iter().enumerate() {
        let spring = RegisteredSpring::of(&pair.law.spring);
        let mut surfaces = scene.surfaces.iter();
        let met = surfaces.any(|surface| pair.between.contains(&surface.material));
        if met && spring.law().is_for_rigid_spheres() {
            let name = spring.law().name();
            let message = format!("is {name}, which has no form for surfaces that deform");
            let problem = Problem::new(format!("scene.contacts[{i}].law.spring"), message);
            problems.push(problem.help(LINEAR));
        }
    }
}

/// Remedy where surfaces that deform meet a law without a form for them.
pub(crate) const LINEAR: &str = "give the pair linear springs";
