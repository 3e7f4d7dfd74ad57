//! Parts are walls: flat ones of many triangles as planes, moving ones carry and push.

use crate::common::*;
use tremie_grains_dem::GrainsDem;
use tremie_messages::{
    body::{BodyEvent, Load},
    scene::{Damping, Geometry, Motion, MotionPoint, Part, Plane, Scene, Sphere},
};

const D: f64 = 1e-3;
const G: f64 = 9.81;
const DT: f64 = 2e-6;

fn part(geometry: Geometry, position: [f64; 3], motion: Motion) -> Part {
    Part { name: "part".into(), motion, ..walls::part(geometry, position) }
}

fn cuboid(size: [f64; 3]) -> Geometry {
    Geometry::Box { size }
}

fn with(gravity: [f64; 3], spheres: Vec<Sphere>) -> Scene {
    let mut scene = scene([20e-3; 3], WALLS, law(2e3, 0.5, Damping::Restitution(0.5)));
    scene.gravity = gravity;
    scene.bodies = vec![set(Motion::Free, spheres)];
    scene
}

/// A slab with its top at z = 0, of `n` x `n` squares of uneven triangles, as a file of text.
fn slab(n: usize, size: f64, thickness: f64) -> tempfile::NamedTempFile {
    walls::relief(n, size, 0.25, -thickness, |_, _| 0.0)
}

/// A spinning sphere that slides, then rolls, across many seams.
fn roller() -> Scene {
    let mut sphere = sphere([5e-3, 6e-3, 10e-3 + 0.5 * D], D, [0.6, 0.37, 0.0]);
    sphere.angular_velocity = [30.0, -50.0, 20.0];
    with([0.0, 0.0, -G], vec![sphere])
}

#[test]
fn a_sphere_rolls_over_triangles_as_over_a_plane() {
    let mut flat = roller();
    let point = [0.0, 0.0, 10e-3];
    flat.planes = vec![Plane { point, normal: [0.0, 0.0, 1.0], material: "wall".into() }];
    let file = slab(24, 16e-3, 2e-3);
    let path = file.path().to_string_lossy().into_owned();
    let mut seams = roller();
    let place = [10e-3, 10e-3, 10e-3];
    seams.parts = vec![part(Geometry::File { path, unit: 1.0 }, place, Motion::Fixed)];
    let (mut a, mut b) = (make(&flat, DT), make(&seams, DT));
    for _ in 0..10 {
        a.advance(700, &[]).unwrap();
        b.advance(700, &[]).unwrap();
        let (a, b) = (state(&a)[0], state(&b)[0]);
        assert!(norm(minus(a.position, b.position)) < 1e-10 * D, "{a:?} {b:?}");
        assert!(norm(minus(a.velocity, b.velocity)) < 1e-10);
        assert!(norm(minus(a.angular_velocity, b.angular_velocity)) < 1e-7);
    }
    assert!(state(&b)[0].position[0] > 10e-3, "it crossed many seams");
}

#[test]
fn a_sphere_in_the_corner_of_a_cavity_leans_on_three_faces() {
    let mut scene = with([2.0, -3.0, -G], vec![sphere([10e-3; 3], D, [0.0; 3])]);
    // Friction would carry a part of the weight.
    for pair in &mut scene.contacts {
        pair.law = law(2e3, 0.0, Damping::Restitution(0.5));
    }
    let mut hollow = part(cuboid([4e-3, 5e-3, 6e-3]), [10e-3; 3], Motion::Fixed);
    hollow.cavity = true;
    scene.parts = vec![hollow];
    let mut dem = make(&scene, DT);
    dem.advance(100_000, &[]).unwrap();
    let rest = state(&dem)[0];
    let weight = |g: f64| mass(D) * g / 2e3;
    let expected =
        [12e-3 - 0.5 * D + weight(2.0), 7.5e-3 + 0.5 * D - weight(3.0), 7e-3 + 0.5 * D - weight(G)];
    let error = norm(minus(rest.position, expected));
    assert!(error < 1e-5 * weight(2.0), "{error} {:?}", rest.position);
    assert_eq!(dem.diagnostics().contacts, 3);
    let (force, _) = dem.part_loads().next().unwrap();
    let total = norm(minus(force, [2.0 * mass(D), -3.0 * mass(D), -G * mass(D)]));
    assert!(total < 1e-5 * mass(D) * G, "{force:?}");
}

/// A sphere pushed over the convex edge of a block falls past it, and turns about the edge without
/// a jump of energy: the sum of all energies never grows by more than rounding and integration do.
#[test]
fn a_convex_edge_gives_no_energy() {
    let mut scene =
        with([0.0, 0.0, -G], vec![sphere([9.6e-3, 9.9e-3, 10.5e-3], D, [0.05, 0.0, 0.0])]);
    for pair in &mut scene.contacts {
        pair.law = law(2e3, 0.0, Damping::Restitution(1.0));
    }
    scene.parts = vec![part(cuboid([10e-3, 10e-3, 4e-3]), [5e-3, 10e-3, 8e-3], Motion::Fixed)];
    let mut dem = make(&scene, DT);
    let energy = |dem: &mut GrainsDem| {
        let d = dem.diagnostics();
        d.kinetic_energy + d.rotational_energy + d.potential_energy + d.elastic_energy
    };
    let start = energy(&mut dem);
    for _ in 0..300 {
        dem.advance(50, &[]).unwrap();
        let change = (energy(&mut dem) - start) / (mass(D) * G * D);
        assert!(change.abs() < 2e-3, "{change}");
    }
    let end = state(&dem)[0];
    assert!(end.position[0] > 10.2e-3 && end.position[2] < 10e-3, "{end:?}");
}

#[test]
fn a_belt_carries_a_sphere_until_it_rolls() {
    let speed = 0.2;
    let belt = Motion::Prescribed(vec![MotionPoint {
        time: 0.0,
        velocity: [speed, 0.0, 0.0],
        angular_velocity: [0.0; 3],
    }]);
    let overlap = mass(D) * G / 2e3;
    let mut scene =
        with([0.0, 0.0, -G], vec![sphere([13e-3, 10e-3, 4.5e-3 - overlap], D, [0.0; 3])]);
    scene.parts = vec![part(cuboid([12e-3, 12e-3, 2e-3]), [10e-3, 10e-3, 3e-3], belt)];
    let mut dem = make(&scene, DT);
    let events = dem.events();
    assert_eq!((events[1].shape, events[1].motion), (BodyEvent::PART, BodyEvent::PRESCRIBED));
    assert_eq!((events[1].id, events[1].table), (1, 0));
    // Loads on the part are taken and move nothing.
    let loads = [Load::default(), Load { id: 1, force: [1.0; 3], torque: [1.0; 3] }];
    let steps = 15_000;
    dem.advance(steps, &loads).unwrap();
    let [ball, belt] = state(&dem)[..] else { panic!("two bodies") };
    let travelled = speed * f64::from(steps) * DT;
    assert!((belt.position[0] - 10e-3 - travelled).abs() < 1e-12, "{belt:?}");
    assert_eq!(belt.velocity, [speed, 0.0, 0.0]);
    // Friction acts at one point: m v R = I w, and the point ends at the speed of the belt.
    assert!((ball.velocity[0] / (2.0 / 7.0 * speed) - 1.0).abs() < 1e-3, "{ball:?}");
    let surface = ball.velocity[0] - ball.angular_velocity[1] * 0.5 * D;
    assert!((surface / speed - 1.0).abs() < 1e-3, "{surface}");
    let (force, _) = dem.part_loads().next().unwrap();
    assert!((force[2] / (-mass(D) * G) - 1.0).abs() < 1e-3, "{force:?}");
}

/// A turning plate strikes a sphere of infinite lightness, as it were: the point that meets it
/// moves at w x r, and restitution 1 doubles that.
#[test]
fn a_turning_part_strikes_with_the_speed_of_its_surface() {
    let spin = Motion::Prescribed(vec![MotionPoint {
        time: 0.0,
        velocity: [0.0; 3],
        angular_velocity: [0.0, 0.0, 40.0],
    }]);
    let mut scene = with([0.0; 3], vec![sphere([13e-3, 11.2e-3, 10e-3], D, [0.0; 3])]);
    for pair in &mut scene.contacts {
        pair.law = law(2e3, 0.0, Damping::Restitution(1.0));
    }
    scene.parts = vec![part(cuboid([9e-3, 1e-3, 9e-3]), [10e-3; 3], spin)];
    let mut dem = make(&scene, DT);
    // Half the thickness, half the diameter: the plate has 0.2 mm to go 3 mm from its axis.
    dem.advance(3_000, &[]).unwrap();
    let [ball, plate] = state(&dem)[..] else { panic!("two bodies") };
    let angle = 40.0 * 3_000.0 * DT;
    assert!((plate.orientation[2] - (0.5 * angle).sin()).abs() < 1e-12);
    let speed = norm(ball.velocity);
    assert!((speed / (2.0 * 40.0 * 3e-3) - 1.0).abs() < 0.05, "{speed}");
}

#[test]
fn parts_reach_across_periodic_faces_without_seams() {
    let mut sphere = sphere([1e-3, 10e-3, 10.5e-3], D, [0.8, 0.1, 0.0]);
    sphere.angular_velocity = [0.0, 20.0, 0.0];
    let of = |part_too: bool| {
        let mut scene = scene([20e-3; 3], FLOOR, law(2e3, 0.5, Damping::Restitution(0.5)));
        scene.gravity = [0.0, 0.0, -G];
        scene.bodies = vec![set(Motion::Free, vec![sphere.clone()])];
        let normal = [0.0, 0.0, 1.0];
        if part_too {
            let size = [20e-3, 24e-3, 2e-3];
            scene.parts = vec![part(cuboid(size), [10e-3, 10e-3, 9e-3], Motion::Fixed)];
        } else {
            let point = [0.0, 0.0, 10e-3];
            scene.planes = vec![Plane { point, normal, material: "wall".into() }];
        }
        let mut dem = make(&scene, DT);
        dem.advance(40_000, &[]).unwrap();
        state(&dem)[0]
    };
    let (plane, part) = (of(false), of(true));
    let error = norm(minus(plane.position, part.position));
    assert!(error < 1e-9 * D, "{error}: {plane:?} {part:?}");
}

#[test]
fn packings_keep_clear_of_parts_and_inside_cavities() {
    // By insertion and by relaxation; the cavity is two fifths of the region.
    for cavity in [false, true] {
        for fraction in if cavity { [0.09, 0.15] } else { [0.15, 0.3] } {
            let mut scene = scene([10e-3; 3], WALLS, law(1e4, 0.5, Damping::Restitution(0.7)));
            let region = packed([0.0; 3], [10e-3; 3], fraction, (0.7e-3, 0.9e-3), 3);
            scene.bodies = vec![region];
            let radius = if cavity { 4.6e-3 } else { 2.5e-3 };
            let mut ball = part(Geometry::Sphere { radius }, [5e-3; 3], Motion::Fixed);
            ball.cavity = cavity;
            scene.parts = vec![ball];
            let dem = make(&scene, 1e-8);
            assert!(dem.body_count() > 100);
            for (s, r) in state(&dem).iter().zip(dem.radii()) {
                let distance = norm(minus(s.position, [5e-3; 3]));
                // The triangles of the sphere lie within 2e-4 of its radius.
                let clear = if cavity { radius - distance } else { distance - radius };
                let clear = clear + 2e-4 * radius;
                assert!(clear > r - 1e-12, "{fraction} {cavity} body {}: {clear} {r}", s.id);
            }
        }
    }
}
