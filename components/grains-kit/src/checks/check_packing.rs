//! Checks of a packing.

use crate::Vec3;
use crate::checks::check_sizes;
use crate::checks::numbers::AXES;
use crate::packing::random_packing::Sizes;
use tremie_messages::{
    Problem,
    scene::{Domain, Packing},
};

/// More spheres than memory holds: a slip in a unit.
const MOST_SPHERES: f64 = 1e8;

/// Checks region, fraction and diameters, of bodies whose spheres around them are so many times as
/// wide.
pub fn packing(
    key: &str,
    packing: &Packing,
    around: f64,
    domain: &Domain,
    problems: &mut Vec<Problem>,
) {
    let key = |name: &str| format!("{key}.{name}");
    if !(packing.fraction > 0.0 && packing.fraction < 0.74) {
        let message = format!("is {}, expected a solid fraction in (0, 0.74)", packing.fraction);
        problems.push(Problem::new(key("fraction"), message));
    }
    let Some(largest) = check_sizes::diameters(&key("diameters"), &packing.diameters, problems)
    else {
        return;
    };
    let largest = largest * around;
    let size = Vec3::from(packing.max) - Vec3::from(packing.min);
    let spheres =
        packing.fraction * size.x * size.y * size.z / Sizes::new(&packing.diameters).mean_volume();
    if spheres > MOST_SPHERES {
        let message = format!("asks for more than {spheres:.1e} spheres");
        problems.push(Problem::new(key("fraction"), message).help("use fewer or larger ones"));
    }
    for axis in 0..3 {
        let (low, high) = (packing.min[axis], packing.max[axis]);
        let name = AXES[axis];
        if high - low < largest || (high - low).is_nan() {
            let message = format!(
                "leaves {} m in {name}, where the largest body needs {largest} m",
                high - low
            );
            problems.push(Problem::new(key("max"), message));
        }
        // A region typed in another unit may differ from the domain by rounding.
        let tolerance = 1e-9 * (domain.max[axis] - domain.min[axis]);
        if low < domain.min[axis] - tolerance {
            problems.push(Problem::new(key("min"), format!("is outside the domain in {name}")));
        }
        if high > domain.max[axis] + tolerance {
            problems.push(Problem::new(key("max"), format!("is outside the domain in {name}")));
        }
    }
}
