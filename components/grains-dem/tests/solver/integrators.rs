//! Heun's method and the subcycles of Chen et al.

use crate::common::solids::*;
use crate::common::*;
use crate::order::is_second_order_across;
use tremie_grains_dem::{GrainsDem, Integrator, Parameters};
use tremie_messages::{
    body::{BodyState, Load},
    scene::{
        ContactLaw, Damping, Geometry, Motion, MotionPoint, Part, PartBoundary, Pose, Scene,
        Slider, SliderSpring, Spring, Tangential,
    },
};

const D: f64 = 1e-3;
const K: f64 = 1e3;
const G: f64 = 9.81;
const OTHERS: [Integrator; 2] = [Integrator::Heun, Integrator::Chen];

fn with(integrator: Integrator) -> Parameters {
    Parameters { integrator, ..Parameters::default() }
}

fn started(scene: &Scene, dt: f64, integrator: Integrator, threads: usize) -> GrainsDem {
    GrainsDem::new(scene, &with(integrator), dt, threads).unwrap()
}

/// Speed after over speed before of an undamped bounce off the floor, in windows of so many
/// substeps, of which a part has gone by when the contact begins. As they take it, a substep is
/// 1/75 of the contact.
fn bounce(integrator: Integrator, substeps: u32, phase: f64) -> f64 {
    let dt = std::f64::consts::TAU / 150.0 * (mass(D) / K).sqrt();
    let window = dt * f64::from(substeps);
    let law = law(K, 0.0, coefficients(0.0, 0.0));
    let mut scene = scene([0.1; 3], WALLS, law);
    let speed = 0.01;
    let windows = (75 / substeps + 3).max(4);
    let start = [0.05, 0.05, 0.5 * D + speed * window * (phase + 1e-9)];
    scene.bodies = vec![set(Motion::Free, vec![sphere(start, D, [0.0, 0.0, -speed])])];
    let mut dem = started(&scene, dt, integrator, 1);
    for _ in 0..windows {
        dem.advance(substeps, &[]).unwrap();
    }
    assert_eq!(dem.diagnostics().contacts, 0);
    state(&dem)[0].velocity[2] / speed
}

/// Mean and largest over the phase at which contact begins.
fn bounces(integrator: Integrator, substeps: u32) -> [f64; 2] {
    let phases = 40;
    let all: Vec<f64> = (0..phases)
        .map(|k| bounce(integrator, substeps, (f64::from(k) + 0.5) / f64::from(phases)))
        .collect();
    let mean = all.iter().sum::<f64>() / f64::from(phases);
    [mean, all.iter().fold(0.0, |most: f64, &one| most.max(one))]
}

#[test]
fn heun_gives_a_bounce_back_whatever_the_window_is() {
    for substeps in [1, 3, 16, 66, 300] {
        let [mean, largest] = bounces(Integrator::Heun, substeps);
        println!("{substeps} substeps: {mean} {largest}");
        assert!((mean - 1.0).abs() < 1e-3 && (largest - 1.0).abs() < 1e-3, "{mean} {largest}");
    }
}

/// The subcycles as printed gain energy, the more the longer the window is over the contact. With
/// one substep a window what is left is the gain of Euler's method.
#[test]
fn the_subcycles_of_the_paper_gain_energy() {
    let expected = [
        (1, [1.033, 1.033]),
        (3, [1.068, 1.068]),
        (16, [1.305, 1.306]),
        (66, [2.042, 2.401]),
        (334, [2.805, 3.000]),
    ];
    for (substeps, expected) in expected {
        let found = bounces(Integrator::Chen, substeps);
        println!("{substeps} substeps: mean {} largest {}", found[0], found[1]);
        for k in 0..2 {
            assert!((found[k] / expected[k] - 1.0).abs() < 2e-3, "{substeps}: {found:?}");
        }
    }
}

/// Height over the position at rest after about four periods, less the exact one, over the
/// amplitude.
fn damped(dt: f64, steps: u32) -> f64 {
    let zeta = 0.1;
    let omega = (K / mass(D)).sqrt();
    let gamma = 2.0 * zeta * (K * mass(D)).sqrt();
    let mut scene = scene([4e-3; 3], WALLS, law(K, 0.0, coefficients(gamma, 0.0)));
    scene.gravity = [0.0, 0.0, -G];
    let rest = 0.5 * D - mass(D) * G / K;
    let amplitude = -0.5 * mass(D) * G / K;
    let start = [2e-3, 2e-3, rest + amplitude];
    scene.bodies = vec![set(Motion::Free, vec![sphere(start, D, [0.0; 3])])];
    let mut dem = started(&scene, dt, Integrator::Heun, 1);
    dem.advance(steps, &[]).unwrap();
    let t = dt * f64::from(steps);
    let w = omega * (1.0 - zeta * zeta).sqrt();
    let decay = (-zeta * omega * t).exp();
    let exact = amplitude * decay * ((w * t).cos() + zeta * omega / w * (w * t).sin());
    ((state(&dem)[0].position[2] - rest) - exact) / amplitude
}

#[test]
fn heun_is_second_order_along_the_normal() {
    let period = std::f64::consts::TAU * (mass(D) / K).sqrt();
    let errors = [80, 160, 320].map(|n| damped(period / f64::from(n), 4 * n).abs());
    println!("errors {errors:?}");
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((1.8..2.3).contains(&order), "{errors:?}: {order}");
    }
}

#[test]
fn heun_is_second_order_across_the_normal() {
    is_second_order_across(Integrator::Heun);
}

/// Acceleration along an incline of a sphere that a torque keeps from rolling: a block.
fn block(integrator: Integrator, tan: f64, substeps: u32) -> (f64, f64) {
    let dt = 2e-6;
    let angle = tan.atan();
    let mut scene = scene([1.0, 4e-3, 4e-3], FLOOR, law(2e3, 0.5, Damping::Restitution(0.3)));
    scene.gravity = [G * angle.sin(), 0.0, -G * angle.cos()];
    let overlap = mass(D) * G * angle.cos() / 2e3;
    let start = [0.1, 2e-3, 0.5 * D - overlap];
    scene.bodies = vec![set(Motion::Free, vec![sphere(start, D, [0.0; 3])])];
    let torque = [0.0, -mass(D) * G * angle.sin() * 0.5 * D, 0.0];
    let load = Load { id: 0, force: [0.0; 3], torque };
    let mut dem = started(&scene, dt, integrator, 1);
    let mut run = |steps: u32| {
        for _ in 0..steps / substeps {
            dem.advance(substeps, &[load]).unwrap();
        }
        state(&dem)[0].velocity[0]
    };
    let (early, late) = (run(5_000), run(10_000));
    ((late - early) / (10_000.0 * dt), late)
}

#[test]
fn friction_holds_a_block_and_lets_it_slide() {
    for (integrator, substeps) in [(Integrator::Heun, 10), (Integrator::Chen, 1)] {
        let (a, last) = block(integrator, 0.499, substeps);
        assert!(a.abs() < 1e-5 * G && last.abs() < 1e-6, "{integrator:?}: {a} {last}");
        let (a, _) = block(integrator, 0.6, substeps);
        let angle = 0.6f64.atan();
        let expected = G * (angle.sin() - 0.5 * angle.cos());
        assert!((a - expected).abs() < 1e-5 * G, "{integrator:?}: {a} {expected}");
    }
}

/// Under constant loads all end where a fall ends, but for rounding; a turning body as well.
#[test]
fn a_fall_is_exact() {
    let mut scene = scene([0.1; 3], PERIODIC, law(K, 0.0, coefficients(0.0, 0.0)));
    scene.gravity = [0.0, 0.0, -G];
    let mut body = sphere([0.05; 3], D, [1.0, 0.0, 0.0]);
    body.angular_velocity = [0.0, 0.0, 10.0];
    scene.bodies = vec![set(Motion::Free, vec![body, sphere([0.02; 3], D, [0.0; 3])])];
    let push = Load { id: 0, force: [0.0, mass(D), 0.0], torque: [0.0, 0.0, inertia(D)] };
    let loads = [push, Load { id: 1, ..Load::default() }];
    for integrator in OTHERS {
        let mut dem = started(&scene, 1e-5, integrator, 1);
        for _ in 0..100 {
            dem.advance(10, &loads).unwrap();
        }
        let (now, t) = (state(&dem)[0], 0.01);
        let expected = [0.05 + t, 0.05 + 0.5 * t * t, 0.05 - 0.5 * G * t * t];
        assert!(norm(minus(now.position, expected)) < 1e-14, "{integrator:?} {now:?}");
        let angle: f64 = 10.0 * t + 0.5 * t * t;
        let q = now.orientation;
        assert!((2.0 * q[2].atan2(q[3]) - angle).abs() < 1e-8, "{integrator:?} {q:?}");
        assert!((now.angular_velocity[2] - 10.0 - t).abs() < 1e-12);
    }
}

/// Grains of the law of Chen et al. that fall through periodic sides onto a floor with a turning
/// part, beside a sphere that moves as given.
fn crowd(integrator: Integrator, threads: usize) -> Vec<BodyState> {
    let law = ContactLaw {
        spring: Spring::Chen {
            stiffness_per_mass: 2e7,
            gap: 0.02e-3,
            psi: 0.3,
            tangential: Tangential::Spring,
        },
        friction: 0.3,
        rolling_friction: 0.0,
        damping: Damping::Ratio(0.4),
        tension: true,
    };
    let mut scene = scene([14e-3, 14e-3, 30e-3], FLOOR, law);
    scene.gravity = [2.0, 1.0, -20.0];
    scene.bodies = vec![packed([0.0; 3], [14e-3, 14e-3, 6e-3], 0.3, (0.7e-3, 0.9e-3), 2)];
    let path = |spin: f64| {
        let (velocity, angular_velocity) = ([0.1, 0.0, 0.0], [0.0, 0.0, spin]);
        Motion::Prescribed(vec![MotionPoint { time: 0.0, velocity, angular_velocity }])
    };
    scene.parts = vec![part(path(20.0))];
    let paddle = sphere([2e-3, 2e-3, 8e-3], 2e-3, [0.0; 3]);
    scene.bodies.push(set(path(5.0), vec![paddle]));
    let mut dem = started(&scene, 1e-5, integrator, threads);
    for _ in 0..100 {
        dem.advance(15, &[]).unwrap();
    }
    let seen = dem.diagnostics();
    assert!(seen.list_rebuilds > 2 && seen.contacts > 500, "{seen:?}");
    let states = state(&dem);
    let moved = states.iter().filter(|s| s.velocity == [0.1, 0.0, 0.0]).count();
    assert_eq!(moved, 2, "the part and the sphere that move as given");
    let driven = states[dem.radii().len() - 1];
    assert!((driven.position[0] - 2e-3 - 0.1 * 0.015).abs() < 1e-14, "{driven:?}");
    states
}

fn part(motion: Motion) -> Part {
    Part {
        name: "paddle".into(),
        geometry: Geometry::Box { size: [4e-3, 1e-3, 3e-3] },
        pose: Pose { position: [7e-3, 7e-3, 3e-3], ..Pose::IDENTITY },
        cavity: false,
        material: "wall".into(),
        motion,
        boundary: PartBoundary::Wall,
    }
}

#[test]
fn the_same_bits_on_any_number_of_threads() {
    for integrator in OTHERS {
        let one = crowd(integrator, 1);
        assert!(one.len() > 1024);
        assert_eq!(one, crowd(integrator, 2));
    }
}

#[test]
fn what_they_do_not_move_is_refused() {
    let refused = |words: &str, change: &dyn Fn(&mut Scene)| {
        let mut scene = scene([14e-3, 14e-3, 30e-3], WALLS, law(K, 0.3, Damping::Restitution(0.5)));
        scene.bodies = vec![set(Motion::Free, vec![sphere([2e-3; 3], D, [0.0; 3])])];
        change(&mut scene);
        for integrator in OTHERS {
            let problems = with(integrator).resolve(&scene).expect_err(words);
            let found = problems.iter().map(ToString::to_string).collect::<Vec<_>>();
            assert!(found.len() == 1 && found[0].contains(words), "{words}: {found:?}");
            assert!(problems[0].key.contains("integrator"), "{found:?}");
        }
        with(Integrator::Verlet).resolve(&scene).unwrap();
    };
    refused("is a slider", &|scene| {
        let slider = Slider {
            axis: [0.0, 0.0, 1.0],
            mass: 1e-3,
            lift: 0.0,
            velocity: 0.0,
            spring: SliderSpring::None,
            force: 0.0,
            stops: None,
        };
        scene.parts = vec![part(Motion::Slider(Box::new(slider)))];
    });
    refused("are clumps", &|scene| scene.bodies[0].clump = Some("pair".into()));
    refused("polyhedra", &|scene| {
        scene.shapes = vec![shape("cube")];
        scene.bodies = vec![solids("cube", vec![solid([4e-3; 3], D, [0.0; 3])])];
    });
}
