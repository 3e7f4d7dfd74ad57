//! Symmetry planes that cut a body, and loads on the whole of it.

use crate::cells::grid::{Grid, Side};

/// Axes across which a symmetry plane cuts a part: it is its own image if its origin is on the
/// plane; one whose origin is not just passes near.
pub fn mirrors_of_part(grid: &Grid, origin: [f64; 3]) -> [bool; 3] {
    near_mirrors(grid, origin, 1e-6)
}

/// Axes across which a symmetry plane passes within a reach of a place.
pub fn near_mirrors(grid: &Grid, position: [f64; 3], reach: f64) -> [bool; 3] {
    std::array::from_fn(|axis| {
        let planes = [0.0, f64::from(grid.n[axis])];
        (0..2).any(|side| {
            grid.sides[axis][side] == Side::Symmetry
                && (position[axis] - planes[side]).abs() < reach
        })
    })
}

/// Force and torque on a whole body, from those that the fluid of the box gives. A body that a
/// symmetry plane cuts is its own mirror image: what is symmetric counts twice, what is not
/// cancels.
pub fn with_image(mirrors: [bool; 3], given: [[f64; 3]; 2]) -> [[f64; 3]; 2] {
    let [mut force, mut torque] = given;
    for axis in (0..3).filter(|&axis| mirrors[axis]) {
        for a in 0..3 {
            (force[a], torque[a]) =
                if a == axis { (0.0, 2.0 * torque[a]) } else { (2.0 * force[a], 0.0) };
        }
    }
    [force, torque]
}
