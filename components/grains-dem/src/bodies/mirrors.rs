//! Parts that symmetry planes cut.
//!
//! To spheres a mirror is a wall without friction: what is behind it is not simulated. A part that
//! is its own image belongs to both halves, and what the mirrored grains do to it counts besides.
//! It is its own image if the origin of its frame lies on the plane; so a fluid tells them, too.

use crate::Vec3;
use crate::bodies::body_arrays::Wrench;
use tremie_messages::scene::{Domain, Face};

/// Distance from a plane, over the size of the domain, within which an origin lies on it.
const ON: f64 = 1e-9;

/// Axes across which symmetry planes cut a part, by the origin of its frame.
pub(crate) fn of_part(domain: &Domain, origin: [f64; 3]) -> [bool; 3] {
    let planes = [domain.min, domain.max];
    std::array::from_fn(|axis| {
        (0..2).any(|side| {
            domain.faces[axis][side] == Face::Symmetry
                && (origin[axis] - planes[side][axis]).abs() <= ON * domain.size()[axis]
        })
    })
}

/// Ratio of a whole part to its simulated part: 2 for each axis across which a symmetry plane cuts
/// it.
pub(crate) fn whole(mirrors: [bool; 3]) -> f64 {
    mirrors.iter().fold(1.0, |whole, &cut| if cut { 2.0 * whole } else { whole })
}

/// The load on the whole part, from that on the part in the domain: what is symmetric counts twice,
/// what is not cancels.
pub(crate) fn with_images(mirrors: [bool; 3], part: &Wrench) -> Wrench {
    let factor = |a: usize, along: f64, across: f64| {
        (0..3)
            .filter(|&axis| mirrors[axis])
            .fold(1.0, |factor, axis| factor * if axis == a { along } else { across })
    };
    Wrench {
        force: Vec3::from_fn(|a, _| part.force[a] * factor(a, 0.0, 2.0)),
        torque: Vec3::from_fn(|a, _| part.torque[a] * factor(a, 2.0, 0.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_symmetric_counts_twice_and_the_rest_not_at_all() {
        let half = Wrench { force: Vec3::new(1.0, 2.0, 3.0), torque: Vec3::new(4.0, 5.0, 6.0) };
        let whole = with_images([true, false, false], &half);
        assert_eq!(whole.force, Vec3::new(0.0, 4.0, 6.0));
        assert_eq!(whole.torque, Vec3::new(8.0, 0.0, 0.0));
        assert_eq!(with_images([true, false, true], &half).force, Vec3::new(0.0, 8.0, 0.0));
        assert_eq!(with_images([false; 3], &half), half);
    }
}
