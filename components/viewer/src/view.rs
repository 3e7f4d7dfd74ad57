//! Directions: which way is up, and from where the scene is looked at.

use crate::section::Mirror;
use rerun::components::ViewCoordinates;
use rerun::coordinates::{Axis3, Handedness, Sign, SignedAxis3};
use tremie_geometry::Vec3;
use tremie_messages::scene::{Motion, Scene};

/// The vector at length one; zero stays zero.
pub fn unit(a: Vec3) -> Vec3 {
    a.try_normalize(0.0).unwrap_or_default()
}

/// For Rerun, which computes in single precision.
pub fn single(a: impl Into<Vec3>) -> [f32; 3] {
    a.into().map(|x| x as f32).into()
}

/// A name as one part of an entity path, whatever characters it has.
pub fn part(name: &str) -> String {
    rerun::EntityPathPart::new(name).escaped_string()
}

/// An eye: where it is and what it looks at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eye {
    /// Position [m].
    pub position: Vec3,
    /// Point looked at [m].
    pub target: Vec3,
    /// Direction of up in the picture.
    pub up: Vec3,
}

/// Axis and sign of up: against gravity if that lies along an axis; without gravity along that of
/// the first part that slides, so that valves stand upright; else +z.
pub fn up(scene: &Scene) -> (usize, f64) {
    let lies_along = |v: [f64; 3], a: usize| v[a] != 0.0 && (0..3).all(|b| a == b || v[b] == 0.0);
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
pub fn up_vector(scene: &Scene) -> Vec3 {
    let (axis, sign) = up(scene);
    Vec3::ith(axis, sign)
}

/// Up as Rerun says it.
pub fn coordinates(scene: &Scene) -> ViewCoordinates {
    let (axis, sign) = up(scene);
    let sign = if sign > 0.0 { Sign::Positive } else { Sign::Negative };
    let up = SignedAxis3 { sign, axis: Axis3::from_dim(axis) };
    ViewCoordinates::from_up_and_handedness(up, Handedness::Right)
}

/// Centre of the domain [m].
pub fn centre(scene: &Scene) -> Vec3 {
    Vec3::from(scene.domain.min).lerp(&scene.domain.max.into(), 0.5)
}

/// An eye that sees the whole domain: before a symmetry plane that stands upright, if there is one,
/// else in front of its widest side; a little to the right and above.
pub fn overview(scene: &Scene) -> Eye {
    let (axis, sign) = up(scene);
    let size = Vec3::from(scene.domain.size());
    let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
    // The eye stands off along the shorter of the horizontal axes; of equal ones, along -y if up is
    // z.
    let (across, depth) = if size[a] >= size[b] { (a, b) } else { (b, a) };
    let mirrors = Mirror::all(&scene.domain);
    let target = centre(scene);
    let mut direction = Vec3::zeros();
    let near = match mirrors.iter().map(Mirror::outward).find(|(normal, _)| *normal != axis) {
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
    let (direction, up) = (unit(direction), up_vector(scene));
    let distance = (near * size.norm()).max(fitting_distance(size, direction, up));
    Eye { position: target + direction * distance, target, up }
}

/// Tangent of half the angle by which Rerun's eye opens from bottom to top: 55 degrees.
fn half_opening() -> f64 {
    27.5_f64.to_radians().tan()
}

/// Least width over height of the view of the scene; and room that stays free around the domain.
const ASPECT: f64 = 1.25;
const ROOM: f64 = 1.06;

/// Distance from the middle of a box, in a direction, from which all its corners are in the view.
fn fitting_distance(size: Vec3, direction: Vec3, up: Vec3) -> f64 {
    let right = unit(up.cross(&direction));
    let upwards = direction.cross(&right);
    let least = |k: usize| {
        let half = |axis: usize| if k >> axis & 1 == 1 { 0.5 } else { -0.5 };
        let corner = Vec3::new(half(0) * size[0], half(1) * size[1], half(2) * size[2]);
        let aside = corner.dot(&upwards).abs().max(corner.dot(&right).abs() / ASPECT);
        corner.dot(&direction) + ROOM * aside / half_opening()
    };
    (0..8).map(least).fold(0.0, f64::max)
}

/// An eye straight above a rectangle with the given corner and sides, at the height that fits it.
pub fn facing(corner: Vec3, sides: [Vec3; 2], up: Vec3, towards: Vec3) -> Eye {
    let target = corner + sides[0] * 0.5 + sides[1] * 0.5;
    let mut normal = unit(sides[0].cross(&sides[1]));
    // From the side of the overview, so that left and right agree in both views.
    if normal.dot(&towards) < normal.dot(&target) {
        normal = -normal;
    }
    let up = if up.dot(&normal).abs() > 0.9 { unit(sides[1]) } else { up };
    let (mut width, mut height) = (sides[0].norm(), sides[1].norm());
    if up.dot(&sides[0]).abs() > up.dot(&sides[1]).abs() {
        std::mem::swap(&mut width, &mut height);
    }
    // Views of cuts are nearly twice as wide as high.
    let distance = 1.1 * height.max(width / 1.8) / (2.0 * half_opening());
    Eye { position: target + normal * distance, target, up }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use tremie_messages::scene::{Domain, Face};

    pub(crate) fn empty_scene(gravity: [f64; 3], max: [f64; 3]) -> Scene {
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
        assert_eq!(eye.target, Vec3::new(2.0, 0.5, 1.0));
        assert!(eye.position[1] < 0.0);
        assert!(eye.position[2] > 1.0);
    }

    #[test]
    fn the_overview_sees_every_corner_of_the_domain() {
        let sizes = [
            [0.05, 0.205, 0.009],
            [0.01, 0.4, 0.02],
            [4.0, 0.2, 0.2],
            [1.0, 1.0, 1.0],
            [0.286, 0.24, 0.099],
        ];
        for size in sizes {
            let mut scene = empty_scene([0.0, -9.81, 0.0], size);
            for is_section in [false, true] {
                if is_section {
                    scene.domain.faces[2][0] = Face::Symmetry;
                }
                let eye = overview(&scene);
                let ahead = unit(eye.target - eye.position);
                let right = unit(ahead.cross(&eye.up));
                let upwards = right.cross(&ahead);
                for k in 0..8 {
                    let side = |axis: usize| size[axis] * f64::from(k >> axis & 1);
                    let to = Vec3::new(side(0), side(1), side(2)) - eye.position;
                    // Half the height of a view of 840 x 650 there.
                    let half = to.dot(&ahead) * 27.5_f64.to_radians().tan();
                    assert!(to.dot(&upwards).abs() < half, "{size:?} {k}");
                    assert!(to.dot(&right).abs() < half * 840.0 / 650.0, "{size:?} {k}");
                }
            }
        }
    }

    #[test]
    fn a_cut_is_faced_from_the_side_of_the_overview() {
        let eye = facing(Vec3::zeros(), [Vec3::x() * 2.0, Vec3::z()], Vec3::z(), Vec3::y() * -5.0);
        assert!(eye.position[1] < 0.0);
        assert_eq!(eye.target, Vec3::new(1.0, 0.0, 0.5));
    }
}
