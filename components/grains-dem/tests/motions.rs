//! Fixed bodies stay, prescribed bodies keep their velocities, both push free ones.

mod common;
use common::*;
use tremie_messages::{
    body::{BodyEvent, Load},
    scene::{Damping, Motion, MotionPoint, Placement},
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
