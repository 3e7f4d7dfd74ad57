//! Fixed bodies, triangulated parts, and things that move as prescribed.

use crate::common::{PERIODIC, block, by, make, scene, set, sphere, unit};
use tremie_grains_hard_sphere::{Detection, HardSpheres, Parameters};
use tremie_messages::scene::{Face, Motion, MotionPoint, PairLaw, Scene};

/// A ball on a block of triangles does what one on the floor does, to rounding.
#[test]
fn triangles_are_a_floor() {
    let ball = |with_block: bool, detection: Detection| {
        let height = if with_block { 0.1 } else { 0.0 };
        let mut scene = scene([0.4, 0.4, 0.6], Face::WALLS, 0.8, 0.3);
        scene.gravity = [0.0, 0.0, -9.81];
        if with_block {
            scene.parts = vec![block([0.3, 0.3, 0.1], [0.2, 0.2, 0.05], Motion::Fixed)];
        }
        let mut ball = sphere([0.171, 0.153, height + 0.2], 0.02, [0.1, 0.05, 0.0]);
        ball.angular_velocity = [3.0, 20.0, -4.0];
        scene.bodies = vec![set(Motion::Free, 2500.0, vec![ball])];
        let mut spheres = make(&scene, &by(detection), 1e-3);
        spheres.advance(700, &[]).unwrap();
        let state = spheres.sphere(0);
        let place = state.position;
        ([place[0], place[1], place[2] - height], state.velocity, state.angular_velocity)
    };
    for detection in [Detection::Events, Detection::Steps] {
        let (on_floor, on_block) = (ball(false, detection), ball(true, detection));
        for (a, b) in [(on_floor.0, on_block.0), (on_floor.1, on_block.1), (on_floor.2, on_block.2)]
        {
            for k in 0..3 {
                assert!((a[k] - b[k]).abs() < 1e-9, "{detection:?}: {a:?} {b:?}");
            }
        }
    }
}

/// A gas around a block, elastic and smooth, keeps its energy and stays outside of it.
#[test]
fn a_gas_flows_around_a_block_and_fixed_balls_and_keeps_its_energy() {
    let mut scene = scene([1.0; 3], PERIODIC, 1.0, 0.0);
    scene.parts = vec![block([0.3, 0.4, 0.25], [0.5, 0.45, 0.5], Motion::Fixed)];
    let free = (0..64u64).filter_map(|k| {
        let place = [k % 4, k / 4 % 4, k / 16].map(|n| 0.125 + 0.25 * n as f64);
        let outside = (place[0] - 0.5).abs() > 0.21
            || (place[1] - 0.45).abs() > 0.26
            || (place[2] - 0.5).abs() > 0.19;
        let v = [0, 1, 2].map(|a| 2.0 * unit(9, 3 * k + a) - 1.0);
        outside.then(|| sphere(place, 0.1, v))
    });
    scene.bodies = vec![
        set(Motion::Free, 1000.0, free.collect()),
        set(Motion::Fixed, 1000.0, vec![sphere([0.02, 0.98, 0.03], 0.12, [0.0; 3])]),
    ];
    for (detection, step) in [(Detection::Events, 0.05), (Detection::Steps, 1e-3)] {
        let mut spheres = make(&scene, &by(detection), step);
        let before = spheres.diagnostics().kinetic_energy;
        for _ in 0..(10.0 / step / 10.0) as u32 {
            spheres.advance(10, &[]).unwrap();
            for k in 0..spheres.sphere_count() - 1 {
                let x = spheres.sphere(k).position;
                let away = [
                    (x[0] - 0.5).abs() - 0.15,
                    (x[1] - 0.45).abs() - 0.2,
                    (x[2] - 0.5).abs() - 0.125,
                ];
                let distance = away.iter().map(|d| d.max(0.0).powi(2)).sum::<f64>().sqrt();
                assert!(
                    distance > 0.05 * (1.0 - 1e-9),
                    "{detection:?}: {k} is in the block by {distance}"
                );
            }
        }
        let after = spheres.diagnostics();
        println!("{detection:?}: {} {} collisions", after.collisions, after.wall_collisions);
        assert!((after.kinetic_energy / before - 1.0).abs() < 1e-12);
        assert!(after.wall_collisions > 100 && after.collisions > 100);
    }
}

/// A paddle that moves at `u` throws a ball at `(1 + e) u`; steps are chosen by themselves.
#[test]
fn a_prescribed_part_and_a_prescribed_ball_hit_what_is_in_their_way() {
    let u = 0.5;
    let points =
        vec![MotionPoint { time: 0.0, velocity: [u, 0.0, 0.0], angular_velocity: [0.0; 3] }];
    let thrown = |scene: Scene| {
        let mut spheres: HardSpheres = make(&scene, &Parameters::default(), 1e-3);
        assert!(!spheres.is_by_events());
        spheres.advance(600, &[]).unwrap();
        let load: f64 = spheres.part_loads().iter().map(|load| load.force[0].abs()).sum();
        (spheres.sphere(0).velocity[0], load)
    };
    let mut by_part = scene([1.0, 0.4, 0.4], Face::WALLS, 0.8, 0.3);
    by_part.bodies = vec![set(Motion::Free, 1000.0, vec![sphere([0.3, 0.2, 0.2], 0.1, [0.0; 3])])];
    let mut by_ball = by_part.clone();
    by_part.parts = vec![block([0.1, 0.2, 0.2], [0.1, 0.2, 0.2], Motion::Prescribed(points))];
    by_ball.bodies.push(set(
        Motion::Prescribed(Vec::new()),
        1000.0,
        vec![sphere([0.1, 0.2, 0.2], 0.1, [u, 0.0, 0.0])],
    ));
    let (by_part, load) = thrown(by_part);
    let (by_ball, _) = thrown(by_ball);
    assert!((by_part / (1.8 * u) - 1.0).abs() < 1e-12, "{by_part}");
    assert!((by_ball / (1.8 * u) - 1.0).abs() < 1e-12, "{by_ball}");
    // The mean over the window of the impulse on the paddle.
    let impulse = 1000.0 * std::f64::consts::PI / 6.0 * 1e-3 * 1.8 * u;
    assert!((load * 0.6 / impulse - 1.0).abs() < 1e-9, "{load}");
}

/// A blade that turns throws a ball at `(1 + e)` times the speed of the place that hits.
#[test]
fn a_blade_that_turns_throws_a_ball() {
    let w = 2.0;
    let points =
        vec![MotionPoint { time: 0.0, velocity: [0.0; 3], angular_velocity: [0.0, 0.0, w] }];
    let mut scene = scene([2.0, 2.0, 0.4], Face::WALLS, 1.0, 0.0);
    scene.parts = vec![block([1.0, 0.02, 0.2], [1.0, 1.0, 0.2], Motion::Prescribed(points))];
    let angle = 0.5f64;
    let at = [1.0 + 0.3 * angle.cos(), 1.0 + 0.3 * angle.sin(), 0.2];
    scene.bodies = vec![set(Motion::Free, 1000.0, vec![sphere(at, 0.1, [0.0; 3])])];
    let mut spheres = make(&scene, &Parameters::default(), 1e-3);
    spheres.advance(300, &[]).unwrap();
    let v = spheres.sphere(0).velocity;
    let speed = v.iter().map(|v| v * v).sum::<f64>().sqrt();
    // The face is 0.06 m ahead of its middle line: it hits at the foot of the ball's centre.
    let foot = (0.3f64.powi(2) - 0.06f64.powi(2)).sqrt();
    assert!((speed / (2.0 * w * foot) - 1.0).abs() < 1e-3, "{speed} {}", 2.0 * w * foot);
}

/// A scene may give its materials laws of their own.
#[test]
fn each_pair_of_materials_has_its_law() {
    let mut scene = scene([1.0; 3], Face::WALLS, 0.9, 0.0);
    scene.contacts.push(PairLaw {
        between: ["grains".into(), "rubber".into()],
        law: crate::common::law(0.2, 0.0),
    });
    scene.parts = vec![block([0.2, 0.5, 0.5], [0.85, 0.5, 0.5], Motion::Fixed)];
    scene.parts[0].material = "rubber".into();
    scene.bodies =
        vec![set(Motion::Free, 1000.0, vec![sphere([0.5, 0.5, 0.5], 0.1, [1.0, 0.0, 0.0])])];
    let mut ball = make(&scene, &Parameters::default(), 0.1);
    ball.advance(5, &[]).unwrap();
    assert!((ball.sphere(0).velocity[0] + 0.2).abs() < 1e-12);
    ball.advance(35, &[]).unwrap();
    assert!((ball.sphere(0).velocity[0] - 0.18).abs() < 1e-12);
}
