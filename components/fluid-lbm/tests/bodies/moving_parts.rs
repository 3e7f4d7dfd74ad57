//! Parts that move: bodies with triangulated surfaces.

use crate::common::*;
use std::f64::consts::PI;
use tremie_fluid_lbm::{FluidError, LbmFluid};
use tremie_messages::scene::{Geometry, Motion, Scene};
use tremie_messages::{BodyState, Load};

/// A scene with a part that moves.
fn with_part(case: &Case, geometry: Geometry) -> Scene {
    let mut scene = case.scene();
    let mut moving = part("mover", geometry, [0.0; 3]);
    moving.motion = Motion::Prescribed(Vec::new());
    scene.parts.push(moving);
    scene
}

/// Turns a body by its angular velocity for one second.
fn turn(body: &mut BodyState) {
    let [x, y, z, w] = body.orientation;
    let [a, b, c] = body.angular_velocity.map(|w| 0.5 * w);
    let next = [
        x + a * w + b * z - c * y,
        y + b * w + c * x - a * z,
        z + c * w + a * y - b * x,
        w - a * x - b * y - c * z,
    ];
    let length = next.iter().map(|q| q * q).sum::<f64>().sqrt();
    body.orientation = next.map(|q| q / length);
}

/// Runs a body across cells, turning, through a periodic face; forces of each step.
fn run(mut fluid: LbmFluid, event: tremie_messages::BodyEvent) -> (Vec<Load>, LbmFluid) {
    let mut bodies = [BodyState::at_rest(7, [4.1, 9.9, 10.3])];
    bodies[0].velocity = [-0.03, 0.004, 0.002];
    bodies[0].angular_velocity = [0.002, 0.0, -0.003];
    fluid.apply_events(&[event]).unwrap();
    let mut loads = loads_of(&bodies);
    fluid.start(&bodies, &mut loads).unwrap();
    let mut all = Vec::new();
    for _ in 0..200 {
        advance(&mut bodies);
        turn(&mut bodies[0]);
        fluid.step(&bodies, &mut loads).unwrap();
        closes(&fluid, 1e-11);
        fluid.check().unwrap();
        all.push(loads[0]);
    }
    (all, fluid)
}

/// A ball of triangles feels what a sphere feels: the mean over 200 steps in which it crosses 6
/// cells and a face, to 1 %; facets move the moments at which cells are covered.
#[test]
fn a_ball_is_a_sphere() {
    let mut case = Case::new([24, 20, 20], [PERIODIC, WALL, WALL], 0.8);
    case.average_force = true;
    case.gravity = [0.0, 0.0, -1e-4];
    let radius = 4.2;
    let (ball, fluid) =
        run(case.fluid_of(&with_part(&case, Geometry::Sphere { radius })), added_part(7, 0));
    assert!(fluid.diagnostics().links > 500);
    let (sphere, _) = run(case.fluid(), added(7, radius));
    let mean = |loads: &[Load]| {
        let mut mean = [0.0; 6];
        for load in &loads[50..] {
            for a in 0..3 {
                mean[a] += load.force[a] / 150.0;
                mean[3 + a] += load.torque[a] / 150.0;
            }
        }
        mean
    };
    let (ball, sphere) = (mean(&ball), mean(&sphere));
    println!("{ball:?}\n{sphere:?}");
    let (force, torque) =
        (norm([sphere[0], sphere[1], sphere[2]]), norm([sphere[3], sphere[4], sphere[5]]));
    for a in 0..3 {
        assert!((ball[a] - sphere[a]).abs() < 0.01 * force);
        assert!((ball[3 + a] - sphere[3 + a]).abs() < 0.03 * torque);
    }
}

/// Circular Couette flow: a cylinder that turns in another, torque `4 pi mu w R1^2 R2^2/(R2^2 -
/// R1^2)` for each unit of length, on either: 2 %, at 9 and 18 cells.
#[test]
fn a_cylinder_turns_in_another() {
    let (inner, outer, length) = (9.0, 18.0, 3.0);
    let mut case = Case::new([40, 40, 3], [WALL, WALL, SYMMETRY], 0.9);
    case.threads = 2;
    let geometry = |radius| Geometry::Cylinder { radius, length: 8.0 };
    let mut scene = with_part(&case, geometry(inner));
    let middle = [20.13, 19.94, 1.5];
    scene.parts.push(part("outer", geometry(outer), middle));
    scene.parts[1].cavity = true;
    let mut fluid = case.fluid_of(&scene);
    let omega = 1e-3;
    let mut body = [BodyState::at_rest(1, middle)];
    body[0].angular_velocity = [0.0, 0.0, omega];
    fluid.apply_events(&[added_part(1, 0)]).unwrap();
    let mut loads = loads_of(&body);
    fluid.start(&body, &mut loads).unwrap();
    for _ in 0..4000 {
        // The pose stays: the cylinder's triangles would turn with it, which changes next to
        // nothing and costs much.
        fluid.step(&body, &mut loads).unwrap();
    }
    closes(&fluid, 1e-11);
    let (r1, r2) = (inner * inner, outer * outer);
    let expected = 4.0 * PI * case.viscosity() * omega * r1 * r2 / (r2 - r1) * length;
    let mut on_parts = Vec::new();
    fluid.loads_on_parts(&mut on_parts);
    let (on_inner, on_outer) = (-loads[0].torque[2] / expected, on_parts[0].torque[2] / expected);
    println!("torques over the exact one: {on_inner} {on_outer}");
    assert!((on_inner - 1.0).abs() < 0.02 && (on_outer - 1.0).abs() < 0.02);
    // Half way, at y = 0 and along x: u = w R1^2 (R2^2/r - r)/(R2^2 - R1^2).
    let u = fluid.velocity_at([33, 19, 1]);
    let r = 13.37;
    let exact = omega * r1 / (r2 - r1) * (r2 / r - r);
    assert!((u[1] / exact - 1.0).abs() < 0.02, "{u:?} {exact}");
}

/// A half of a box on a mirror feels what the box does, buoyancy and its torque about the frame's
/// origin included: 1e-11. So do halves of a rod and of plates that lie on the mirror or across it
/// and are thinner than a cell.
#[test]
fn a_part_on_a_mirror_is_whole() {
    let run = |size: [f64; 3], half: bool| {
        let mut case = Case::new([24, 16, 20], [PERIODIC, SYMMETRY, WALL], 0.7);
        case.gravity = [0.0, 0.0, -1e-4];
        let mut scene = with_part(&case, Geometry::Box { size });
        if half {
            scene.domain.max[1] = 8.0;
        }
        let mut fluid = case.fluid_of(&scene);
        fluid.apply_events(&[added_part(1, 0)]).unwrap();
        let mut body = [BodyState::at_rest(1, [12.2, 8.0, 9.7])];
        body[0].velocity = [0.02, 0.0, -0.01];
        body[0].angular_velocity = [0.0, 0.004, 0.0];
        let mut loads = loads_of(&body);
        fluid.start(&body, &mut loads).unwrap();
        for _ in 0..60 {
            advance(&mut body);
            turn(&mut body[0]);
            fluid.step(&body, &mut loads).unwrap();
            closes(&fluid, 1e-11);
        }
        loads[0]
    };
    for size in [[5.3, 6.1, 4.7], [5.3, 0.4, 4.7], [5.3, 6.1, 0.4], [0.6, 6.1, 0.5]] {
        let (whole, half) = (run(size, false), run(size, true));
        assert!(norm(whole.force) > 0.01, "{size:?}: {whole:?}");
        for a in 0..3 {
            assert!((whole.force[a] - half.force[a]).abs() < 1e-11, "{size:?}: {whole:?} {half:?}");
            let off = whole.torque[a] - half.torque[a];
            assert!(off.abs() < 1e-11, "{size:?}: {whole:?} {half:?}");
        }
    }
}

#[test]
fn parts_that_are_not_there_are_refused() {
    let case = Case::new([16; 3], [PERIODIC; 3], 0.8);
    let mut scene = with_part(&case, Geometry::Sphere { radius: 3.0 });
    scene.parts.push(part("still", Geometry::Sphere { radius: 2.0 }, [8.0; 3]));
    let mut fluid = case.fluid_of(&scene);
    for number in [1, 2] {
        let error = fluid.apply_events(&[added_part(4, number)]).unwrap_err();
        assert!(matches!(error, FluidError::UnknownPart { id: 4, .. }), "{error}");
    }
    fluid.apply_events(&[added_part(4, 0)]).unwrap();
    scene.parts[0].cavity = true;
    let problems = case.parameters().resolve(&scene).unwrap_err();
    assert!(problems[0].key == "scene.parts[0].cavity", "{problems:?}");
}
