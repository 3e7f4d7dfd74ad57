//! Parts that go through periodic faces: plates that slide along themselves, beside Stokes and
//! Couette; what beyond the domain ends them is no wall; what reaches beyond one face comes in
//! again at the other.

use crate::common::*;
use std::f64::consts::PI;
use tremie_fluid_lbm::LbmFluid;
use tremie_messages::scene::{Course, Geometry, Motion, Pose, Scene, TimedMotion};
use tremie_messages::{BodyState, Load};

const SPEED: f64 = 0.01;

fn moving(mut scene: Scene, geometry: Geometry, position: [f64; 3]) -> Scene {
    let mut mover = part("mover", geometry, position);
    mover.motion = Motion::Timed(Box::new(TimedMotion {
        velocity: [1e-3; 3],
        angular_velocity: [0.0; 3],
        course: Course::CONSTANT,
    }));
    scene.parts.push(mover);
    scene
}

/// A fluid with the scene's moving parts as bodies 0, 1, .. at the places of the scene.
fn started(case: &Case, scene: &Scene) -> (LbmFluid, Vec<BodyState>, Vec<Load>) {
    let mut fluid = case.fluid_of(scene);
    let movers = scene.parts.iter().enumerate().filter(|(_, part)| part.motion != Motion::Fixed);
    let (events, bodies): (Vec<_>, Vec<_>) = (0..)
        .zip(movers)
        .map(|(id, (index, part))| {
            let orientation = part.pose.orientation;
            let state = BodyState { orientation, ..BodyState::at_rest(id, part.pose.position) };
            (added_part(id, index as u64), state)
        })
        .unzip();
    fluid.apply_events(&events).unwrap();
    let mut loads = loads_of(&bodies);
    fluid.start(&bodies, &mut loads).unwrap();
    (fluid, bodies, loads)
}

/// Stokes' second problem with a plate in place of the wall: `u = U exp(-y/d) sin(w t - y/d)`,
/// anywhere between cells, within 1.5 % of the plate's speed with a d of 4 cells; and the drag of
/// one period on its upper side, `-mu U sqrt(w/nu) sin(w t + pi/4)`, of its two sides twice that,
/// within 2 % of its amplitude.
#[test]
fn an_oscillating_plate_is_that_of_stokes() {
    for (shift, axis) in [(0.0, 0), (0.3, 0), (0.8, 2)] {
        let d = 4.0;
        let (tau, side) = (0.8, 3);
        let mut cells = [side; 3];
        cells[1] = 68;
        let case = Case::new(cells, [PERIODIC, WALL, PERIODIC], tau);
        let omega = 2.0 * case.viscosity() / (d * d);
        let surface = 36.0 + shift;
        let plate = Geometry::Box { size: [50.0, 4.0, 3.0] };
        let scene = moving(case.scene(), plate, [-3.0, surface - 2.0, 1.5]);
        let (mut fluid, mut bodies, mut loads) = started(&case, &scene);
        let (period, start) = (2.0 * PI / omega, bodies[0].position);
        let (mut worst, mut worst_force) = (0.0f64, 0.0f64);
        // The plate goes several times through the domain and back.
        let amplitude = SPEED / omega;
        assert!(2.0 * amplitude < 60.0 && period > 100.0);
        for step in 1..=(8.0 * period) as u32 {
            let t = f64::from(step);
            bodies[0].velocity[axis] = SPEED * (omega * t).sin();
            let away = amplitude * (1.0 - (omega * t).cos()) + 0.02 * t;
            bodies[0].position[axis] = (start[axis] + away).rem_euclid(side as f64);
            fluid.step(&bodies, &mut loads).unwrap();
            closes(&fluid, 1e-11);
            if t < 7.0 * period {
                continue;
            }
            for k in (surface.ceil() as usize)..62 {
                let y = (k as f64 + 0.5 - surface) / d;
                let exact = (-y).exp() * (omega * t - y).sin();
                let found = fluid.velocity_at([1, k, 1])[axis] / SPEED;
                worst = worst.max((found - exact).abs());
            }
            // Of what a step gives this is the mean, half a step earlier; of the solid's own
            // inertia there is none.
            let unit = case.viscosity() * SPEED * (omega / case.viscosity()).sqrt();
            let exact = -2.0 * 9.0 * unit * (omega * (t - 0.5) + 0.25 * PI).sin();
            worst_force = worst_force.max((loads[0].force[axis] - exact).abs() / (18.0 * unit));
        }
        println!("{shift} {axis}: velocity {worst:.2e}, force {worst_force:.2e}");
        assert!(worst < 0.015, "{shift} {axis}: {worst}");
        assert!(worst_force < 0.02, "{shift} {axis}: {worst_force}");
    }
}

/// A shear cell: two plates that slide against each other, the one shorter than the domain at first
/// sight only. Couette's flow between them, within 0.1 % of their speed, and the same stress on
/// both.
#[test]
fn two_plates_make_a_shear_cell() {
    let case = Case::new([4, 30, 4], [PERIODIC, WALL, PERIODIC], 0.9);
    let (low, high) = (7.3, 22.9);
    let plate = |length: f64| Geometry::Box { size: [length, 3.0, 11.0] };
    let scene = moving(case.scene(), plate(4.0), [2.0, low - 1.5, 2.0]);
    let scene = moving(scene, plate(400.0), [70.0, high + 1.5, 2.0]);
    let (mut fluid, mut bodies, mut loads) = started(&case, &scene);
    (bodies[0].velocity, bodies[1].velocity) = ([-SPEED, 0.0, 0.0], [SPEED, 0.0, 0.5 * SPEED]);
    for _ in 0..6000 {
        advance(&mut bodies);
        fluid.step(&bodies, &mut loads).unwrap();
    }
    closes(&fluid, 1e-12);
    for k in 8..22 {
        let part = (k as f64 + 0.5 - low) / (high - low);
        let u = fluid.velocity_at([1, k, 2]);
        assert!((u[0] / SPEED - (2.0 * part - 1.0)).abs() < 1e-3, "{k}: {u:?}");
        assert!((u[2] / SPEED - 0.5 * part).abs() < 1e-3, "{k}: {u:?}");
    }
    // Above and below, fluid between each plate and a wall at rest.
    let stress = |speed: f64, gap: f64| case.viscosity() * speed / gap * 16.0;
    let between = stress(2.0 * SPEED, high - low);
    let below = between + stress(SPEED, low - 3.0);
    let above = -between - stress(SPEED, 30.0 - high - 3.0);
    assert!((loads[0].force[0] / below - 1.0).abs() < 2e-3, "{} {below}", loads[0].force[0]);
    assert!((loads[1].force[0] / above - 1.0).abs() < 2e-3, "{} {above}", loads[1].force[0]);
}

/// Fluid through a pipe that is longer than the domain, just as long, or ends a hair beyond it:
/// Poiseuille's flow, the same to the last bits, and the same force on the pipe. Its ends are
/// nowhere.
#[test]
fn a_pipe_has_no_ends() {
    let flow = |length: f64, middle: f64| {
        let mut case = Case::new([20, 20, 6], [WALL, WALL, PERIODIC], 0.8);
        case.acceleration[2] = 1e-5;
        let mut scene = case.scene();
        let cylinder = Geometry::Cylinder { radius: 8.3, length };
        scene.parts.push(part("pipe", cylinder, [10.1, 10.0, middle]));
        scene.parts[0].cavity = true;
        let mut fluid = case.fluid_of(&scene);
        for _ in 0..1500 {
            fluid.step(&[], &mut []).unwrap();
        }
        let mut loads = Vec::new();
        fluid.loads_on_parts(&mut loads);
        let along: Vec<f64> = (0..6).map(|z| fluid.velocity_at([10, 10, z])[2]).collect();
        (along, loads[0].force[2])
    };
    let (long, drag) = flow(60.0, 3.0);
    assert!(long.iter().all(|u| (u / long[0] - 1.0).abs() < 1e-9), "{long:?}");
    let peak = 1e-5 * 8.3 * 8.3 / (4.0 * 0.1);
    assert!((long[0] / peak - 1.0).abs() < 0.03, "{} {peak}", long[0]);
    assert!((drag / (1e-5 * PI * 8.3 * 8.3 * 6.0) - 1.0).abs() < 0.03, "{drag}");
    for (length, middle) in [(6.0, 3.0), (6.02, 3.0), (6.6, 3.2), (30.0, -8.0)] {
        let (found, force) = flow(length, middle);
        for (a, b) in found.iter().zip(&long) {
            assert!((a / b - 1.0).abs() < 1e-9, "{length} {middle}: {found:?} {long:?}");
        }
        assert!((force / drag - 1.0).abs() < 1e-9, "{length} {middle}: {force} {drag}");
    }
}

/// A part that reaches beyond one periodic face, still or as a body at rest, is what it is in the
/// middle of the domain.
#[test]
fn what_leaves_at_one_face_comes_in_at_the_other() {
    let drag = |position: [f64; 3], moves: bool| {
        let mut case = Case::new([16; 3], [PERIODIC; 3], 0.8);
        case.acceleration[0] = 1e-6;
        let bar = Geometry::Box { size: [5.2, 3.6, 4.4] };
        let mut scene = case.scene();
        if moves {
            scene = moving(scene, bar, position);
        } else {
            scene.parts.push(part("bar", bar, position));
        }
        let (mut fluid, bodies, mut loads) = started(&case, &scene);
        for _ in 0..600 {
            fluid.step(&bodies, &mut loads).unwrap();
        }
        let mut fixed = Vec::new();
        fluid.loads_on_parts(&mut fixed);
        if moves { loads[0].force } else { fixed[0].force }
    };
    for moves in [false, true] {
        let inside = drag([8.13, 8.3, 8.0], moves);
        assert!(inside[0] > 1e-5, "{inside:?}");
        for away in [[8.0, 0.0, 0.0], [-8.0, 0.0, 8.0], [7.0, -7.0, -8.0]] {
            let place: [f64; 3] = std::array::from_fn(|a| [8.13, 8.3, 8.0][a] + away[a]);
            let there = drag(place, moves);
            for a in 0..3 {
                let off = (there[a] - inside[a]).abs() / inside[0];
                assert!(off < 1e-9, "{moves} {away:?}: {there:?} {inside:?}");
            }
        }
    }
}

/// A rod along a periodic axis that turns, slides and comes across cells: the torque of one period
/// is `4 pi mu R1^2 R2^2 w / (R2^2 - R1^2)` in a tube, within 3 %, and the push along it `2 pi mu U
/// / ln(R2/R1)`.
#[test]
fn a_rod_turns_in_a_tube() {
    let case = Case::new([4, 40, 40], [PERIODIC, WALL, WALL], 0.9);
    let (inner, outer) = (6.3, 17.4);
    let half = 0.5f64.sqrt();
    let lying = |radius: f64, position: [f64; 3]| {
        let mut rod = part("rod", Geometry::Cylinder { radius, length: 77.0 }, position);
        rod.pose = Pose { position, orientation: [0.0, half, 0.0, half] };
        rod
    };
    let mut scene = case.scene();
    scene.parts.push(lying(outer, [2.0, 20.0, 20.0]));
    scene.parts[0].cavity = true;
    let mut scene = moving(scene, Geometry::Sphere { radius: 1.0 }, [0.0; 3]);
    let motion = scene.parts[1].motion.clone();
    scene.parts[1] = lying(inner, [9.0, 20.0, 20.0]);
    scene.parts[1].motion = motion;
    let (mut fluid, mut bodies, mut loads) = started(&case, &scene);
    let spin = 1e-3;
    bodies[0].velocity = [SPEED, 0.0, 0.0];
    bodies[0].angular_velocity = [spin, 0.0, 0.0];
    let turned = |angle: f64| {
        let (s, c) = (0.5 * angle).sin_cos();
        // First as the scene has it, then about x.
        [s * half, c * half, s * half, c * half]
    };
    let mut mean = [0.0; 2];
    for step in 1..=4000 {
        advance(&mut bodies);
        bodies[0].orientation = turned(spin * f64::from(step));
        fluid.step(&bodies, &mut loads).unwrap();
        closes(&fluid, 1e-11);
        if step > 3000 {
            mean[0] += loads[0].force[0] / 1000.0;
            mean[1] += loads[0].torque[0] / 1000.0;
        }
    }
    let mu = case.viscosity();
    let drag = -2.0 * PI * mu * SPEED / (outer / inner).ln() * 4.0;
    let (a, b) = (inner * inner, outer * outer);
    let torque = -4.0 * PI * mu * spin * a * b / (b - a) * 4.0;
    println!("drag {} torque {}", mean[0] / drag, mean[1] / torque);
    assert!((mean[0] / drag - 1.0).abs() < 0.02, "{} {drag}", mean[0]);
    assert!((mean[1] / torque - 1.0).abs() < 0.03, "{} {torque}", mean[1]);
}

/// A plate across cells, up and down: what it displaces closes, and its buoyancy is that of one
/// period.
#[test]
fn a_plate_moves_across_itself() {
    let mut case = Case::new([5, 30, 4], [PERIODIC, WALL, PERIODIC], 0.8);
    case.gravity = [0.0, -1e-5, 0.0];
    let bar = Geometry::Box { size: [50.0, 4.2, 2.0] };
    let scene = moving(case.scene(), bar, [1.0, 12.0, 1.7]);
    let (mut fluid, mut bodies, mut loads) = started(&case, &scene);
    let mut lift = 0.0;
    for step in 0..6000 {
        let speed = if step % 800 < 400 { 0.01 } else { -0.01 };
        bodies[0].velocity = if step < 1600 { [0.07, speed, 0.0] } else { [0.0; 3] };
        advance(&mut bodies);
        fluid.step(&bodies, &mut loads).unwrap();
        closes(&fluid, 1e-11);
        fluid.check().unwrap();
        if step >= 5900 {
            lift += loads[0].force[1] / 100.0;
        }
    }
    let wanted = 1e-5 * 5.0 * 4.2 * 2.0;
    assert!((lift / wanted - 1.0).abs() < 0.02, "{lift} {wanted}");
}
