//! Checks of the law of a contact.

use crate::contact::springs::{Bound, RegisteredSpring};
use crate::math::numbers::is_positive;
use crate::setup::check::not_positive;
use tremie_messages::{
    Problem,
    scene::{ContactLaw, Damping},
};

/// Checks the numbers of a law.
pub(crate) fn law(key: &str, law: &ContactLaw, problems: &mut Vec<Problem>) {
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
    let coefficients = matches!(law.damping, Damping::Coefficients { .. });
    if coefficients && !spring.law().takes_coefficients() {
        let name = spring.law().name();
        let message = format!("gives dashpots by coefficients, but the spring is {name}");
        let help = "give the restitution";
        problems.push(Problem::new(format!("{key}.damping"), message).help(help));
    }
}
