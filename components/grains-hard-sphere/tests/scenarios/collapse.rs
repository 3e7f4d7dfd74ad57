//! Where collisions accumulate: balls that come to rest, lines that collapse, stacks.

use crate::common::{PERIODIC, bare, make, scene, set, sphere};
use tremie_grains_hard_sphere::{Detection, HardSpheres, Parameters};
use tremie_messages::scene::{Face, Motion, Scene};
use tremie_messages::units::Time;

/// Balls of 2 cm on a floor.
fn on_floor(places: &[f64], restitution: f64, height: f64) -> Scene {
    let faces = [PERIODIC[0].clone(), PERIODIC[1].clone(), Face::WALLS[2].clone()];
    let mut scene = scene([0.1, 0.1, height], faces, restitution, 0.0);
    scene.gravity = [0.0, 0.0, -9.81];
    let balls = places.iter().map(|&z| sphere([0.05, 0.05, z], 0.02, [0.0; 3])).collect();
    scene.bodies = vec![set(Motion::Free, 2500.0, balls)];
    scene
}

fn steps_or_events(detection: Detection) -> Parameters {
    Parameters { detection, ..Parameters::default() }
}

/// `sqrt(2 h/g) (1 + e)/(1 - e)`: 8.579 s of a fall of a metre at `e = 0.9`.
#[test]
fn a_dropped_ball_passes_the_moment_at_which_it_comes_to_rest() {
    for (detection, step) in [(Detection::Events, 1e-2), (Detection::Steps, 5e-4)] {
        let mut ball = make(&on_floor(&[1.01], 0.9, 1.2), &steps_or_events(detection), step);
        let steps = |time: f64| (time / step).round() as u32;
        let peak = |ball: &mut HardSpheres, time: f64| {
            let mut top = 0.0f64;
            for _ in 0..steps(time) {
                ball.advance(1, &[]).unwrap();
                top = top.max(ball.sphere(0).position[2] - 0.01);
            }
            top
        };
        peak(&mut ball, 8.2);
        // Shortly before it still bounces: in 0.379 s more it comes to rest, by flights that sum up
        // to that; the highest of them takes about a tenth of it.
        let before = peak(&mut ball, 0.3);
        peak(&mut ball, 0.2);
        let after = peak(&mut ball, 3.0);
        let speed = ball.diagnostics().max_speed;
        println!(
            "{detection:?}: {before:.2e} m high before, {after:.2e} m after, then {speed:.1e} m/s"
        );
        assert!(before > 1e-4 && after < 1e-6 * 0.02, "{before} {after}");
        assert!(speed < 1e-3, "{speed}");
    }
}

/// Three on a line collapse for `e < 7 - 4 sqrt 3 = 0.0718`, and not above.
#[test]
fn a_line_of_three_passes_its_collapse_and_the_guard_is_counted() {
    let line = |e: f64| {
        let mut scene = scene([100.0; 3], Face::WALLS, e, 0.0);
        let at = |x: f64, v: f64| sphere([50.0 + x, 50.0, 50.0], 1.0, [v, 0.0, 0.0]);
        scene.bodies = vec![set(
            Motion::Free,
            crate::common::density(3),
            vec![at(-2.0, 1.0), at(0.0, 0.0), at(2.0, -0.9)],
        )];
        scene
    };
    let collide = |e: f64, contact_time: f64| {
        let parameters =
            Parameters { contact_time: Some(Time(contact_time)), ..bare(Detection::Events) };
        let mut three = make(&line(e), &parameters, 0.1);
        three.advance(100, &[]).unwrap();
        (three.diagnostics(), three.sphere(2).velocity[0] - three.sphere(0).velocity[0])
    };
    let (free, _) = collide(0.3, 1e-6);
    assert_eq!(free.guarded_by_time, 0, "{free:?}");
    let (held, opening) = collide(0.05, 1e-6);
    println!(
        "e 0.05: {} collisions, {} guarded, opening {opening:.2e}",
        held.collisions, held.guarded_by_time
    );
    assert!(held.guarded_by_time > 0 && held.collisions < 1000, "{held:?}");
    // Halving the guard changes nothing that one could see.
    let (_, halved) = collide(0.05, 5e-7);
    assert!((opening - halved).abs() < 1e-4, "{opening} {halved}");
}

/// Drift of the positions of balls through 10,000 steps, in diameters, once they have settled.
fn drift(places: &[f64], detection: Detection, step: f64, settle: f64) -> (f64, HardSpheres) {
    let mut balls = make(&on_floor(places, 0.8, 0.3), &steps_or_events(detection), step);
    balls.advance((settle / step).round() as u32, &[]).unwrap();
    let heights = |balls: &HardSpheres| -> Vec<f64> {
        (0..places.len()).map(|k| balls.sphere(k).position[2]).collect()
    };
    let before = heights(&balls);
    let mut most = 0.0f64;
    for _ in 0..100 {
        balls.advance(100, &[]).unwrap();
        let way =
            heights(&balls).iter().zip(&before).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        most = most.max(way / 0.02);
    }
    (most, balls)
}

#[test]
fn two_at_rest_stay_and_a_stack_of_five_settles() {
    let touching: Vec<f64> = (0..2).map(|k| 0.01 + 0.02 * f64::from(k)).collect();
    let falling: Vec<f64> = (0..5).map(|k| 0.011 + 0.0205 * f64::from(k)).collect();
    let cases = [("two at rest", touching, 0.0), ("a stack of five", falling, 0.6)];
    for (name, places, settle) in cases {
        for (detection, step) in [(Detection::Steps, 1e-4), (Detection::Events, 2e-5)] {
            let (most, balls) = drift(&places, detection, step, settle);
            let found = balls.diagnostics();
            println!(
                "{name}, {detection:?}: drift {most:.1e} d, {} collisions, {} crowded, {:.1e} m/s",
                found.collisions + found.wall_collisions,
                found.crowded,
                found.max_speed
            );
            assert!(most < 1e-6, "{name}, {detection:?}: {most}");
            assert_eq!(found.crowded, 0, "{name}");
        }
    }
}

/// The floor carries the weight.
#[test]
fn the_floor_feels_the_weight_of_what_rests() {
    for detection in [Detection::Steps, Detection::Events] {
        let mut ball = make(&on_floor(&[0.01], 0.8, 0.3), &steps_or_events(detection), 1e-3);
        ball.advance(1000, &[]).unwrap();
        let weight = 2500.0 * std::f64::consts::PI / 6.0 * 8e-6 * 9.81;
        let force = -ball.wall_forces()[0].z;
        assert!((force / weight - 1.0).abs() < 1e-3, "{detection:?}: {force} {weight}");
    }
}

/// Weight without the guard would never end.
#[test]
fn weight_needs_the_guard_by_speed() {
    let problems = HardSpheres::new(&on_floor(&[0.5], 0.9, 1.0), &bare(Detection::Events), 1e-3, 1);
    let text = format!("{:?}", problems.err().unwrap());
    assert!(text.contains("elastic_speed") && text.contains("collide for ever"), "{text}");
}
