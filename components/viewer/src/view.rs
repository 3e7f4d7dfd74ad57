//! Directions: which way is up, and from where the scene is looked at.

use crate::section::Mirror;
use rerun::components::ViewCoordinates;
use rerun::coordinates::{Axis3, Handedness, Sign, SignedAxis3};
use tremie_messages::scene::{Motion, Scene};

/// A vector, for the little geometry that a viewer needs.
pub type Vector = [f64; 3];

/// Combination `a + s b`.
pub fn along(a: Vector, s: f64, b: Vector) -> Vector {
    std::array::from_fn(|k| a[k] + s * b[k])
}

/// Cross product.
pub fn cross(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|k| a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3])
}

/// Scalar product.
pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Length.
pub fn norm(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// The vector at length one; zero stays zero.
pub fn unit(a: Vector) -> Vector {
    let length = norm(a);
    if length > 0.0 { a.map(|x| x / length) } else { a }
}

/// For Rerun, which computes in single precision.
pub fn single(a: Vector) -> [f32; 3] {
    a.map(|x| x as f32)
}

/// A name as one part of an entity path, whatever characters it has.
pub fn part(name: &str) -> String {
    rerun::EntityPathPart::new(name).escaped_string()
}

/// An eye: where it is and what it looks at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eye {
    /// Position [m].
    pub position: Vector,
    /// Point looked at [m].
    pub target: Vector,
    /// Which way is up in the picture.
    pub up: Vector,
}

/// Axis and sign of up: against gravity if that lies along an axis; without gravity along that of the
/// first part that slides, so that valves stand upright; else +z.
pub fn up(scene: &Scene) -> (usize, f64) {
    let lies_along = |v: Vector, a: usize| v[a] != 0.0 && (0..3).all(|b| a == b || v[b] == 0.0);
    let slider = scene.parts.iter().find_map(|part| match &part.motion {
        Motion::Slider(slider) => Some(slider.axis),
        _ => None,
    });
    let pull = scene.gravity.map(|g| -g);
    let direction = if pull == [0.0; 3] { slider.unwrap_or_default() } else { pull };
    match (0..3).find(|a| lies_along(direction, *a)) {
        Some(axis) => (axis, direction[axis].signum()),
        None => (2, 1.0),
    }
}

/// Up as a vector.
pub fn up_vector(scene: &Scene) -> Vector {
    let (axis, sign) = up(scene);
    std::array::from_fn(|a| if a == axis { sign } else { 0.0 })
}

/// Up as Rerun says it.
pub fn coordinates(scene: &Scene) -> ViewCoordinates {
    let (axis, sign) = up(scene);
    let sign = if sign > 0.0 { Sign::Positive } else { Sign::Negative };
    let up = SignedAxis3 { sign, axis: Axis3::from_dim(axis) };
    ViewCoordinates::from_up_and_handedness(up, Handedness::Right)
}

/// Centre of the domain [m].
pub fn centre(scene: &Scene) -> Vector {
    std::array::from_fn(|a| 0.5 * (scene.domain.min[a] + scene.domain.max[a]))
}

/// An eye that sees the whole domain: before a symmetry plane that stands upright, if there is one, else in
/// front of its widest side; a little to the right and above.
pub fn overview(scene: &Scene) -> Eye {
    let (axis, sign) = up(scene);
    let size = scene.domain.size();
    let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
    // The eye stands off along the shorter of the horizontal axes; of equal ones, along -y if up is z.
    let (across, depth) = if size[a] >= size[b] { (a, b) } else { (b, a) };
    let mirrors = Mirror::all(&scene.domain);
    let target = centre(scene);
    let mut direction = [0.0; 3];
    let distance = match mirrors.iter().map(Mirror::outward).find(|(normal, _)| *normal != axis) {
        // What is seen there is a section: nearly straight on, and near.
        Some((normal, outward)) => {
            direction[normal] = outward;
            direction[3 - normal - axis] = 0.3;
            direction[axis] = 0.25 * sign;
            0.92
        }
        None => {
            direction[depth] = -1.0;
            direction[across] = 0.55;
            direction[axis] = 0.45 * sign;
            1.05
        }
    };
    let position = along(target, distance * norm(size), unit(direction));
    Eye { position, target, up: up_vector(scene) }
}

/// An eye straight above a rectangle with the given corner and sides, at the height that fits it.
pub fn facing(corner: Vector, sides: [Vector; 2], up: Vector, towards: Vector) -> Eye {
    let target = along(along(corner, 0.5, sides[0]), 0.5, sides[1]);
    let mut normal = unit(cross(sides[0], sides[1]));
    // From the side of the overview, so that left and right agree in both views.
    if dot(normal, towards) < dot(normal, target) {
        normal = normal.map(|x| -x);
    }
    let up = if dot(up, normal).abs() > 0.9 { unit(sides[1]) } else { up };
    let (mut width, mut height) = (norm(sides[0]), norm(sides[1]));
    if dot(up, sides[0]).abs() > dot(up, sides[1]).abs() {
        std::mem::swap(&mut width, &mut height);
    }
    // Rerun's eye opens by 55 degrees from bottom to top; views of cuts are nearly twice as wide as high.
    let distance = 1.1 * height.max(width / 1.8) / (2.0 * 27.5_f64.to_radians().tan());
    Eye { position: along(target, distance, normal), target, up }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use tremie_messages::scene::{Domain, Face};

    pub(crate) fn empty_scene(gravity: Vector, max: Vector) -> Scene {
        Scene { gravity, ..Scene::empty(Domain::new([0.0; 3], max, Face::WALLS)) }
    }

    #[test]
    fn up_is_against_gravity() {
        assert_eq!(up(&empty_scene([0.0, -9.81, 0.0], [1.0; 3])), (1, 1.0));
        assert_eq!(up(&empty_scene([9.81, 0.0, 0.0], [1.0; 3])), (0, -1.0));
        assert_eq!(up(&empty_scene([1.0, 0.0, -9.0], [1.0; 3])), (2, 1.0));
        assert_eq!(up(&empty_scene([0.0; 3], [1.0; 3])), (2, 1.0));
    }

    #[test]
    fn the_overview_looks_at_the_widest_side_from_outside() {
        let scene = empty_scene([0.0, 0.0, -9.81], [4.0, 1.0, 2.0]);
        let eye = overview(&scene);
        assert_eq!(eye.target, [2.0, 0.5, 1.0]);
        assert!(eye.position[1] < 0.0);
        assert!(eye.position[2] > 1.0);
    }

    #[test]
    fn a_cut_is_faced_from_the_side_of_the_overview() {
        let eye =
            facing([0.0; 3], [[2.0, 0.0, 0.0], [0.0, 0.0, 1.0]], [0.0, 0.0, 1.0], [0.0, -5.0, 0.0]);
        assert!(eye.position[1] < 0.0);
        assert_eq!(eye.target, [1.0, 0.0, 0.5]);
    }
}
