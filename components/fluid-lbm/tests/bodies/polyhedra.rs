//! Convex polyhedra in the fluid: the forces of the same solid as a part, and the Stokes drag of a
//! cube.

use crate::common::*;
use std::f64::consts::PI;
use tremie_messages::scene::{Geometry, Motion, Scene, Shape};
use tremie_messages::{BodyEvent, BodyState, Load};

/// A cube as a shape, of an edge that does not matter.
fn cube() -> Shape {
    let corner = |k: usize| std::array::from_fn(|a| if k >> a & 1 == 1 { 3.0 } else { -3.0 });
    Shape { name: "cube".into(), vertices: (0..8).map(corner).collect() }
}

/// A polyhedron of the scene's first shape, as large as a sphere of a diameter.
fn added_cube(id: u64, diameter: f64) -> BodyEvent {
    let edge = diameter * (PI / 6.0).cbrt();
    let size = [0.5 * 3f64.sqrt() * edge, diameter, 0.0];
    BodyEvent { shape: BodyEvent::POLYHEDRON, size, ..added(id, 0.0) }
}

/// Loads on a body that moves and turns through a fluid, step by step.
fn dragged(case: &Case, scene: &Scene, event: BodyEvent) -> Vec<Load> {
    let mut fluid = case.fluid_of(scene);
    let mut body = [BodyState::at_rest(1, [9.3, 11.7, 12.1])];
    fluid.apply_events(&[event]).unwrap();
    let mut loads = loads_of(&body);
    fluid.start(&body, &mut loads).unwrap();
    (0..200)
        .map(|k| {
            let angle = 2e-3 * f64::from(k);
            body[0].position[0] += 0.03;
            body[0].velocity = [0.03, 0.0, 0.0];
            body[0].orientation = [0.0, 0.0, (0.5 * angle).sin(), (0.5 * angle).cos()];
            body[0].angular_velocity = [0.0, 0.0, 2e-3];
            fluid.step(&body, &mut loads).unwrap();
            closes(&fluid, 1e-11);
            loads[0]
        })
        .collect()
}

/// A cube that moves and turns feels what a box of the same size feels that is a part: to rounding,
/// for their surfaces are not cut into the same triangles.
#[test]
fn a_cube_is_a_box() {
    let (case, edge) = (Case::new([28, 24, 24], [PERIODIC; 3], 0.6), 6.4);
    let mut scene = case.scene();
    scene.shapes.push(cube());
    let mut as_part = part("box", Geometry::Box { size: [edge; 3] }, [0.0; 3]);
    as_part.motion = Motion::Prescribed(Vec::new());
    scene.parts.push(as_part);
    let diameter = edge / (PI / 6.0).cbrt();
    let (cube, part) =
        (dragged(&case, &scene, added_cube(1, diameter)), dragged(&case, &scene, added_part(1, 0)));
    let largest = part.iter().flat_map(|load| load.force).fold(0.0, |a: f64, f| a.max(f.abs()));
    for (a, b) in cube.iter().zip(&part) {
        for k in 0..3 {
            assert!((a.force[k] - b.force[k]).abs() < 1e-9 * largest, "{a:?} {b:?}");
            assert!((a.torque[k] - b.torque[k]).abs() < 1e-8 * largest, "{a:?} {b:?}");
        }
    }
    assert!(largest > 1e-2);
}

/// Stokes drag on a body in a periodic box over that of a sphere of equal volume in an infinite
/// fluid, with what its images take from its velocity put back (Hasimoto 1959).
fn drag(event: BodyEvent, diameter: f64) -> f64 {
    let n = 32;
    let (length, radius) = (f64::from(n), 0.5 * diameter);
    let mut case = Case::new([n as usize; 3], [PERIODIC; 3], 1.0);
    let a = 1e-7;
    case.acceleration = [a, 0.0, 0.0];
    case.threads = 2;
    let stokes = 6.0 * PI * case.viscosity() * radius;
    case.velocity = [0.6 * a * length.powi(3) / stokes, 0.0, 0.0];
    let mut scene = case.scene();
    scene.shapes.push(cube());
    let middle = 0.5 * length;
    let steady = steady_drag(&case, &scene, event, [middle + 0.1, middle + 0.2, middle]);
    let in_box = steady.force / (stokes * steady.superficial);
    let fraction = 4.0 / 3.0 * PI * (radius / length).powi(3);
    1.0 / (1.0 / in_box + 1.7601 * fraction.cbrt() - fraction + 1.5593 * fraction.powi(2))
}

/// A cube's friction is that of a sphere of 0.66 of its edge (its capacity; Hubbard & Douglas 1993,
/// to 1 %): 1.065 times that of a sphere of its volume. 7.3 cells an edge; within 3 %, as the
/// sphere is of its own.
#[test]
fn the_stokes_drag_of_a_cube() {
    let diameter = 9.0;
    let cube = drag(added_cube(1, diameter), diameter);
    let sphere = drag(added(1, 0.5 * diameter), diameter);
    println!("cube {cube:.4}, sphere {sphere:.4}");
    assert!((sphere - 1.0).abs() < 0.03, "{sphere}");
    assert!((cube / 1.065 - 1.0).abs() < 0.03, "{cube}");
}

#[test]
fn a_polyhedron_of_no_shape_is_refused() {
    let case = Case::new([20; 3], [PERIODIC; 3], 0.8);
    let mut scene = case.scene();
    let refused = |scene: &Scene, event: BodyEvent| {
        case.fluid_of(scene).apply_events(&[event]).unwrap_err().to_string()
    };
    assert!(refused(&scene, added_cube(7, 5.0)).contains("body 7 is a polyhedron of shape 0"));
    scene.shapes.push(cube());
    assert!(refused(&scene, added_cube(7, f64::NAN)).contains("radius"));
    assert!(refused(&scene, added_cube(7, 30.0)).contains("diameter"));
}
