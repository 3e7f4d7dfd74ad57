//! What can be wrong with the law of a contact.

use crate::math::numbers::is_positive;
use crate::setup::check::not_positive;
use tremie_messages::{
    Problem,
    scene::{ContactLaw, Damping, Spring},
};

/// Checks the numbers of a law.
pub(crate) fn law(key: &str, law: &ContactLaw, problems: &mut Vec<Problem>) {
    let mut not_negative = |name: &str, value: f64| {
        if !(value >= 0.0 && value.is_finite()) {
            let message = format!("is {value}, expected 0 or more");
            problems.push(Problem::new(format!("{key}.{name}"), message));
        }
    };
    let stiffest = match law.spring {
        Spring::Linear { normal_stiffness, tangential_stiffness } => {
            not_negative("tangential_stiffness", tangential_stiffness);
            ("normal_stiffness", normal_stiffness)
        }
        Spring::Hertz { effective_modulus, effective_shear_modulus } => {
            not_negative("effective_shear_modulus", effective_shear_modulus);
            ("effective_modulus", effective_modulus)
        }
    };
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
    let (name, value) = stiffest;
    if !is_positive(value) {
        problems.push(not_positive(format!("{key}.{name}"), value));
    }
    let hertz = matches!(law.spring, Spring::Hertz { .. });
    if hertz && matches!(law.damping, Damping::Coefficients { .. }) {
        let message = "gives dashpots by coefficients, which goes with linear springs only";
        let help = "give the restitution of Hertz's springs";
        problems.push(Problem::new(format!("{key}.damping"), message).help(help));
    }
}
