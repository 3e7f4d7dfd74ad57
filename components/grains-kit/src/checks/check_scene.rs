//! Checks of what a scene says of domain, planes, motions and listed spheres.

use crate::Vec3;
use crate::checks::numbers::{AXES, all_finite, not_positive};
use crate::math::numbers::is_positive;
use crate::space::periodic::PeriodicBox;
use crate::space::plane_walls;
use crate::space::rigid_body::BoundingSphere;
use tremie_messages::Problem;
use tremie_messages::scene::{
    BodySet, Domain, Motion, MotionPoint, Plane, Scene, Sphere, TimedMotion,
};

/// Overlap at the start, over the smaller radius, that passes as touching.
pub const TOUCHING: f64 = 0.01;

/// Checks the points of a prescribed motion: finite, one after the other.
pub fn points(key: &str, points: &[MotionPoint], problems: &mut Vec<Problem>) {
    for (i, point) in points.iter().enumerate() {
        let finite = all_finite(&point.velocity) && all_finite(&point.angular_velocity);
        if !(finite && point.time.is_finite()) {
            let problem = Problem::new(format!("{key}.prescribed[{i}]"), "is not finite");
            problems.push(problem);
        }
        if i > 0 && point.time <= points[i - 1].time {
            let (before, found) = (points[i - 1].time, point.time);
            let message = format!("is {found} s, not later than the point before, {before} s");
            problems.push(Problem::new(format!("{key}.prescribed[{i}].time"), message));
        }
    }
}

/// Checks velocities that go with a factor over time.
pub fn timed(key: &str, timed: &TimedMotion, problems: &mut Vec<Problem>) {
    if !(all_finite(&timed.velocity) && all_finite(&timed.angular_velocity)) {
        problems.push(Problem::new(format!("{key}.timed"), "is not finite"));
    } else if let Some(flaw) = timed.course.flaw() {
        problems.push(Problem::new(format!("{key}.timed.course"), flaw));
    }
}

/// Checks that the domain has an extent along each axis.
pub fn domain(domain: &Domain, problems: &mut Vec<Problem>) {
    let extent = domain.size();
    for axis in 0..3 {
        let name = AXES[axis];
        if !is_positive(extent[axis]) || !domain.min[axis].is_finite() {
            let message = format!("has no extent in {name}: its size there is {} m", extent[axis]);
            problems.push(Problem::new("scene.domain", message));
        }
    }
}

/// Checks the point and the normal of a plane.
pub fn plane(key: &str, plane: &Plane, domain: &Domain, problems: &mut Vec<Problem>) {
    let square = Vec3::from(plane.normal).norm_squared();
    if !all_finite(&plane.point) {
        problems.push(Problem::new(format!("{key}.point"), "is not finite"));
    }
    if !is_positive(square) {
        problems.push(Problem::new(format!("{key}.normal"), "has no direction"));
    }
    for axis in 0..3 {
        if domain.is_periodic(axis) && plane.normal[axis] != 0.0 {
            let name = AXES[axis];
            let message =
                format!("has a component along {name}, which wraps around: the plane would not");
            let help =
                format!("make {name} of the normal 0, or the domain's faces in {name} walls");
            problems.push(Problem::new(format!("{key}.normal"), message).help(help));
        }
    }
}

/// Checks the numbers of a listed sphere.
pub fn listed(key: &str, set: &BodySet, sphere: &Sphere, problems: &mut Vec<Problem>) {
    if !is_positive(sphere.diameter) {
        problems.push(not_positive(format!("{key}.diameter"), sphere.diameter));
    }
    for (name, vector) in [
        ("position", &sphere.position),
        ("velocity", &sphere.velocity),
        ("angular_velocity", &sphere.angular_velocity),
    ] {
        if !all_finite(vector) {
            problems.push(Problem::new(format!("{key}.{name}"), "is not finite"));
        }
    }
    let moves = sphere.velocity != [0.0; 3] || sphere.angular_velocity != [0.0; 3];
    if set.motion == Motion::Fixed && moves {
        let help = "use the motion \"prescribed\" to keep a velocity";
        let problem = Problem::new(format!("{key}.velocity"), "is that of a fixed body");
        problems.push(problem.help(help));
    }
}

/// The centre must lie in the domain; a free sphere as a whole on the right side of walls.
pub fn inside(
    key: &str,
    set: &BodySet,
    sphere: &Sphere,
    scene: &Scene,
    problems: &mut Vec<Problem>,
) {
    let key = format!("{key}.position");
    let ball = BoundingSphere { x: sphere.position.into(), radius: 0.5 * sphere.diameter };
    if !PeriodicBox::new(&scene.domain).contains(ball.x) {
        problems.push(Problem::new(key, "lies outside the domain"));
        return;
    }
    if set.motion != Motion::Free {
        return;
    }
    for (wall, name) in plane_walls::of_scene(scene).iter().zip(plane_walls::names(scene)) {
        let overlap = wall.overlap(&ball);
        if overlap > TOUCHING * ball.radius {
            let message = format!("puts the sphere {overlap:.3e} m into {name}");
            problems.push(Problem::new(key.as_str(), message));
        }
    }
}
