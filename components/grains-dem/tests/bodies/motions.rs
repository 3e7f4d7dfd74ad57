//! Fixed bodies stay, prescribed bodies keep their velocities, both push free ones.

use crate::common::*;
use tremie_messages::{
    body::{BodyEvent, Load},
    scene::{Course, Damping, Face, Motion, MotionPoint, Placement, Sine, TimedMotion},
};

#[test]
fn given_motions_are_kept_and_felt() {
    let d = 1e-3;
    let mut scene = scene([10e-3; 3], PERIODIC, law(1e4, 0.5, Damping::Restitution(1.0)));
    scene.gravity = [0.0, 0.0, -1.0];
    let mut pusher = sphere([2e-3, 5e-3, 5e-3], d, [0.5, 0.0, 0.0]);
    pusher.angular_velocity = [0.0, 0.0, 40.0];
    let target = sphere([4e-3, 5e-3, 5e-3], d, [0.0; 3]);
    let post = sphere([8e-3, 5e-3, 5e-3], d, [0.0; 3]);
    scene.bodies = vec![
        set(Motion::Prescribed(vec![]), vec![pusher]),
        set(Motion::Free, vec![target]),
        set(Motion::Fixed, vec![post]),
    ];
    let dt = 5e-7;
    let mut dem = make(&scene, dt);
    let motions: Vec<u32> = dem.events().iter().map(|e| e.motion).collect();
    assert_eq!(motions, [BodyEvent::PRESCRIBED, BodyEvent::FREE, BodyEvent::FIXED]);
    let push = |id| Load { id, force: [0.0, 1e-6, 0.0], torque: [1e-9; 3] };
    let mut loads = [push(0), push(1), push(2)];
    loads[1] = Load { id: 1, ..Load::default() };
    let steps = 8_000;
    dem.advance(steps, &loads).unwrap();
    let after = state(&dem);
    let travelled = 2e-3 + 0.5 * dt * f64::from(steps);
    assert!((after[0].position[0] - travelled).abs() < 1e-12);
    assert_eq!(after[0].velocity, [0.5, 0.0, 0.0]);
    assert_eq!(after[0].angular_velocity, [0.0, 0.0, 40.0]);
    let turned = 40.0 * dt * f64::from(steps);
    assert!((after[0].orientation[2] - (0.5 * turned).sin()).abs() < 1e-9);
    // Struck by a body of infinite mass, the target leaves at twice its speed.
    assert!((after[1].velocity[0] - 1.0).abs() < 1e-2, "{:?}", after[1]);
    assert_eq!(after[2].position, [8e-3, 5e-3, 5e-3]);
    assert_eq!(after[2].velocity, [0.0; 3]);
    assert_eq!(dem.diagnostics().fluid_impulse, [0.0; 3], "only free bodies take impulse");
}

#[test]
fn fixed_bodies_may_overlap_each_other() {
    let mut scene = scene([10e-3; 3], WALLS, law(1e4, 0.5, Damping::Restitution(1.0)));
    let post = |x| sphere([x, 5e-3, 0.1e-3], 1e-3, [0.0; 3]);
    scene.bodies = vec![set(Motion::Fixed, vec![post(5e-3), post(5.5e-3)])];
    let mut dem = make(&scene, 1e-6);
    dem.advance(10, &[]).unwrap();
    assert_eq!(dem.diagnostics().contacts, 0);
    assert!(matches!(&scene.bodies[0].placement, Placement::Listed(list) if list.len() == 2));
}

/// Velocities linear between points: positions are their exact integral, whatever the step.
#[test]
fn prescribed_points_are_followed_exactly() {
    let point = |time, v: f64, w| MotionPoint {
        time,
        velocity: [v, -v, 0.0],
        angular_velocity: [0.0, w, 0.0],
    };
    let points = vec![point(1e-3, 0.0, 0.0), point(3e-3, 1.0, 100.0), point(4e-3, 0.4, 0.0)];
    let mut scene = scene([10e-3; 3], PERIODIC, law(1e4, 0.5, Damping::Restitution(1.0)));
    scene.gravity = [0.0, 0.0, -9.81];
    let driven = sphere([9.5e-3, 1e-3, 5e-3], 1e-3, [0.0; 3]);
    scene.bodies = vec![set(Motion::Prescribed(points), vec![driven])];
    let dt = 1e-3 / 1024.5;
    let mut dem = make(&scene, dt);
    let steps = 6000;
    dem.advance(steps, &[]).unwrap();
    let time = f64::from(steps) * dt;
    // Half of 1 m/s for 2 ms, the mean of 1 and 0.4 for 1 ms, then 0.4 to the end.
    let way = 1e-3 + 0.7e-3 + 0.4 * (time - 4e-3);
    let end = state(&dem)[0];
    assert!((end.position[0] - (9.5e-3 + way - 10e-3)).abs() < 1e-14, "{end:?} {way}");
    assert!((end.position[1] - (1e-3 - way + 10e-3)).abs() < 1e-14);
    assert_eq!(end.velocity, [0.4, -0.4, 0.0]);
    let angle: f64 = 0.1 + 0.05;
    assert!((end.orientation[1] - (0.5 * angle).sin()).abs() < 1e-6, "{end:?}");
}

/// Velocities times a sine: positions are the exact integral, each body of the set at the
/// velocities it was placed with.
#[test]
fn a_formula_is_followed_exactly() {
    let mut scene = scene([10e-3; 3], PERIODIC, law(1e4, 0.5, Damping::Restitution(1.0)));
    let course = Course::Sine(Sine { mean: 0.5, ..Sine::new(700.0) });
    let mut one = sphere([2e-3, 5e-3, 5e-3], 1e-3, [0.3, 0.0, 0.0]);
    one.angular_velocity = [0.0, 0.0, 20.0];
    let other = sphere([5e-3, 5e-3, 2e-3], 1e-3, [0.0, -0.2, 0.1]);
    let still =
        TimedMotion { velocity: [0.0; 3], angular_velocity: [0.0; 3], course: course.clone() };
    scene.bodies = vec![set(Motion::Timed(Box::new(still)), vec![one.clone(), other.clone()])];
    let dt = 1e-6;
    let mut dem = make(&scene, dt);
    assert_eq!(dem.events()[0].motion, BodyEvent::PRESCRIBED);
    assert_eq!(state(&dem)[0].velocity, [0.15, 0.0, 0.0]);
    let steps = 3_333;
    dem.advance(steps, &[]).unwrap();
    let time = f64::from(steps) * dt;
    let (factor, way) = (course.at(time), course.integral(time));
    for (body, placed) in state(&dem).iter().zip([&one, &other]) {
        for a in 0..3 {
            let to = placed.position[a] + way * placed.velocity[a];
            assert!((body.position[a] - to).abs() < 1e-14, "{body:?} {to}");
            assert!((body.velocity[a] - factor * placed.velocity[a]).abs() < 1e-15, "{body:?}");
        }
        assert!(
            (body.orientation[2] - (0.5 * way * placed.angular_velocity[2]).sin()).abs() < 1e-9
        );
    }
}

/// A ball that rolls on a plate which swings along itself goes with 2/7 of its velocity: within 1 %
/// of the largest.
#[test]
fn a_ball_rolls_on_a_swinging_floor() {
    let (d, speed) = (1e-3, 0.02);
    let mut floor = WALLS;
    let course = Course::Sine(Sine::new(20.0));
    floor[2][0] = Face::Wall { velocity: [speed, 0.0, 0.0], course: course.clone() };
    let mut scene = scene([10e-3; 3], floor, law(1e3, 2.0, Damping::Restitution(0.3)));
    scene.gravity = [0.0, 0.0, -9.81];
    let sag = mass(d) * 9.81 / 1e3;
    scene.bodies = vec![set(Motion::Free, vec![sphere([5e-3, 5e-3, 0.5 * d - sag], d, [0.0; 3])])];
    let dt = 2e-6;
    let mut dem = make(&scene, dt);
    let mut worst = 0.0f64;
    for window in 1..=50 {
        dem.advance(500, &[]).unwrap();
        let expected = 2.0 / 7.0 * speed * course.at(f64::from(500 * window) * dt);
        worst = worst.max((state(&dem)[0].velocity[0] - expected).abs());
    }
    assert!(worst < 0.01 * speed, "{}", worst / speed);
}
