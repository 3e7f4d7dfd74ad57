//! How far the pressures that a scene prescribes would compress the lattice's fluid.

use tremie_messages::Finding;
use tremie_messages::finding::short;

/// Pressure over stiffness, which is the relative change of density, above which a flow that should be
/// incompressible is not, and above which the lattice fails.
const COMPRESSED: [f64; 2] = [0.02, 0.1];
/// The one that a remedy aims at.
const AIM: f64 = 0.01;

/// The largest prescribed pressure [Pa] over the stiffness `rho c_s^2` [Pa] that a time step [s]
/// gives a lattice, for a fluid of a density [kg/m³].
pub fn finding(pressure: f64, stiffness: f64, time_step: f64, density: f64) -> Option<Finding> {
    if pressure == 0.0 {
        return None;
    }
    let compression = pressure / stiffness;
    let speed = (2.0 * pressure / density).sqrt();
    let [doubtful, wrong] = COMPRESSED;
    let why = format!(
        "{} Pa are prescribed and the lattice's stiffness rho c_s^2 is {} Pa: above {doubtful} the fluid is compressed as a \
         gas would be",
        short(pressure),
        short(stiffness)
    );
    let remedy = format!(
        "a time step of {} s (now {} s) makes it {AIM}, so does a larger expected_speed; held back by inertia alone \
         the fluid would reach {} m/s",
        short(time_step * (AIM / compression).sqrt()),
        short(time_step),
        short(speed)
    );
    let finding = Finding::new("pressure over lattice stiffness", compression, "1");
    Some(finding.wrong_if(compression > wrong, &why, &remedy).doubtful_if(
        compression > doubtful,
        why,
        remedy,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::Verdict;

    #[test]
    fn pressures_beyond_the_stiffness_are_wrong() {
        let of = |pressure| finding(pressure, 1e4, 1e-5, 1000.0).unwrap();
        assert_eq!(of(150.0).verdict, Verdict::Ok);
        assert_eq!(of(500.0).verdict, Verdict::Doubtful);
        let wrong = of(1e6);
        assert_eq!(wrong.verdict, Verdict::Wrong);
        // A hundredth of the compression needs a tenth of the step.
        assert!(wrong.remedy.contains("1e-7 s (now 1e-5 s)"), "{}", wrong.remedy);
        assert!(finding(0.0, 1e4, 1e-5, 1000.0).is_none());
    }
}
