//! Compression of the lattice's fluid by the pressures that a scene prescribes.

use tremie_messages::Finding;
use tremie_messages::finding::short;
use tremie_messages::scene::{Face, Scene};

/// Pressure over stiffness, which is the relative change of density, above which a flow that should
/// be incompressible is not, and above which the lattice fails.
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

/// Drop of pressure of the flow itself over the stiffness, above which the density, and with it the
/// velocity, differs by a per cent from one end of the domain to the other.
const FLOW: f64 = 0.01;

/// The pressure that a viscous flow needs from an open face to the opposite one at the expected
/// speed, over the stiffness [Pa]. None where nothing bounds it across, or no speed is expected.
///
/// Between walls at a distance `h` the drop is `12 mu u l/h^2` for a mean velocity `u`, in a
/// rectangle `h` by `b` over `1 - 0.63 h/b` times that; the largest velocity is 1.5 to 2.1 times
/// the mean.
pub fn of_flow(scene: &Scene, stiffness: f64, time_step: f64) -> Option<Finding> {
    let fluid = scene.fluid.as_ref()?;
    let speed = fluid.expected_speed.filter(|speed| *speed > 0.0)?;
    let (drop, axis) = (0..3)
        .filter(|&axis| scene.domain.faces[axis].iter().any(Face::is_open))
        .filter_map(|axis| Some((needed(scene, axis, speed, fluid.viscosity)?, axis)))
        .max_by(|a, b| a.0.total_cmp(&b.0))?;
    let part = drop / stiffness;
    let along = ["x", "y", "z"][axis];
    let why = format!(
        "at the expected speed the walls take {} Pa of the flow along {along}, the lattice's stiffness rho c_s^2 is {} Pa",
        short(drop),
        short(stiffness)
    );
    let more = format!(
        "{why}: density and velocity change by as much on the way, {} %, where a liquid's stay",
        short(100.0 * part)
    );
    let remedy = format!(
        "a time step of {} s (now {} s) makes it {}, so does a larger expected_speed; half of a time step makes it a quarter",
        short(time_step * (0.5 * FLOW / part).sqrt()),
        short(time_step),
        short(0.5 * FLOW)
    );
    let finding = Finding::new("pressure drop of the flow over lattice stiffness", part, "1");
    Some(finding.because(why).doubtful_if(part > FLOW, more, remedy))
}

/// The pressure that walls take of a flow along an axis with a largest speed.
fn needed(scene: &Scene, axis: usize, speed: f64, viscosity: f64) -> Option<f64> {
    let size = scene.domain.size();
    let width = |a: usize| match &scene.domain.faces[a] {
        [Face::Wall { .. }, Face::Wall { .. }] => Some(size[a]),
        [Face::Wall { .. }, Face::Symmetry] | [Face::Symmetry, Face::Wall { .. }] => {
            Some(2.0 * size[a])
        }
        _ => None,
    };
    let mut widths: Vec<f64> = (0..3).filter(|&a| a != axis).filter_map(width).collect();
    widths.sort_by(f64::total_cmp);
    let narrow = *widths.first()?;
    let ratio = widths.get(1).map_or(0.0, |wide| narrow / wide);
    let mean = speed * (2.0 / 3.0 - 0.19 * ratio);
    Some(12.0 * viscosity * mean * size[axis] / (narrow * narrow * (1.0 - 0.63 * ratio)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::scene::{Course, Domain, FluidMaterial, OpenVelocity, Outflow, Profile};

    /// A duct in which the pressure drops by 1.1 % of the stiffness is doubtful, and a wider or
    /// shorter one is not; a stream that no wall bounds has no such number.
    #[test]
    fn the_drop_of_the_flow_itself_is_judged() {
        let inflow = Face::Velocity(OpenVelocity {
            velocity: [0.1, 0.0, 0.0],
            profile: Profile::Uniform,
            course: Course::CONSTANT,
        });
        let judge = |size: [f64; 3], sides: [Face; 2], stiffness: f64| {
            let outflow =
                Face::Pressure { pressure: 0.0, course: Course::CONSTANT, outflow: Outflow::Fixed };
            let faces = [[inflow.clone(), outflow], sides.clone(), sides];
            let mut fluid = FluidMaterial::at_rest(1000.0, 0.1);
            fluid.expected_speed = Some(0.1);
            let scene =
                Scene { fluid: Some(fluid), ..Scene::empty(Domain::new([0.0; 3], size, faces)) };
            of_flow(&scene, stiffness, 1e-5)
        };
        let walls = [Face::WALL, Face::WALL];
        // 28.45 mu u l/h^2 of a square, u 0.477 of the largest: 136 Pa.
        let drop = 28.45 * 0.1 * 0.0477 * 0.1 / 1e-4;
        let duct = judge([0.1, 0.01, 0.01], walls.clone(), drop / 0.011).unwrap();
        assert!((duct.value / 0.011 - 1.0).abs() < 0.15, "{duct:?}");
        assert_eq!(duct.verdict, Verdict::Doubtful);
        assert!(duct.remedy.contains("time step"), "{duct:?}");
        let wide = judge([0.1, 0.02, 0.02], walls.clone(), drop / 0.011).unwrap();
        assert_eq!(wide.verdict, Verdict::Ok, "{wide:?}");
        // The whole of what a mirror halves.
        let half = judge([0.1, 0.005, 0.005], [Face::Symmetry, Face::WALL], drop / 0.011).unwrap();
        assert!((half.value / duct.value - 1.0).abs() < 1e-12);
        let free = [Face::Symmetry, Face::Symmetry];
        assert!(judge([0.1, 0.01, 0.01], free, drop).is_none());
        // Between plates: 8 mu u l/h^2 of the largest.
        let mut plates = judge([0.1, 0.01, 1e3], walls, 1e3).unwrap();
        plates.value *= 1e3;
        assert!((plates.value / (8.0 * 0.1 * 0.1 * 0.1 / 1e-4) - 1.0).abs() < 1e-3, "{plates:?}");
    }
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
