//! Forces of grains on the faces of the domain.

use crate::common::solids::*;
use crate::common::walls::*;
use crate::common::*;
use tremie_grains_dem::{AddedSphere, GrainsDem, Parameters};
use tremie_messages::scene::{BodySet, Damping, Motion, Scene};

const D: f64 = 4e-3;
const G: f64 = 9.81;

/// A room with weight.
fn room(bodies: Vec<BodySet>) -> Scene {
    let mut scene = scene([40e-3; 3], WALLS, law(2e3, 0.3, Damping::Restitution(0.3)));
    scene.gravity = [0.0, 0.0, -G];
    (scene.bodies, scene.shapes) = (bodies, vec![shape("cube")]);
    scene
}

fn at_rest(scene: &Scene) -> GrainsDem {
    let mut dem = make(scene, 1e-5);
    dem.advance(30_000, &[]).unwrap();
    dem
}

fn one_sphere(x: f64) -> Vec<BodySet> {
    vec![set(Motion::Free, vec![sphere([x, 20e-3, 0.5 * D], D, [0.0; 3])])]
}

fn one_cube(x: f64) -> Vec<BodySet> {
    vec![solids("cube", vec![solid([x, 20e-3, 0.5 * D], of_cube(D), [0.0; 3])])]
}

/// The force of a grain at rest is its weight, whatever else is there.
#[test]
fn a_grain_at_rest_on_the_floor_puts_its_weight_on_it() {
    let beside = block([-2.0, -2.0, -5.0], [20.0, 42.0, 0.0]);
    let away = block([-2.0, -2.0, -5.0], [17.9, 42.0, 5.0]);
    let cube = DENSITY * D.powi(3) * G;
    let ball = mass(D) * G;
    for (bodies, parts, on_face, on_parts) in [
        (one_sphere(20e-3), vec![], ball, 0.0),
        (one_cube(20e-3), vec![], cube, 0.0),
        // Near a part all is looked at together.
        (one_sphere(20e-3), vec![away.clone()], ball, 0.0),
        (one_cube(20e-3), vec![away], cube, 0.0),
        // Where both coincide the part bears it.
        (one_sphere(21e-3), vec![beside.clone()], ball, 0.0),
        (one_sphere(15e-3), vec![beside.clone()], 0.0, ball),
        (one_cube(21e-3), vec![beside.clone()], 0.75 * cube, 0.25 * cube),
        (one_cube(15e-3), vec![beside], 0.0, cube),
    ] {
        let mut scene = room(bodies);
        scene.parts = parts;
        let dem = at_rest(&scene);
        let forces = dem.face_forces();
        let of_parts: f64 = dem.part_loads().map(|(force, _)| force[2]).sum();
        let errors = [forces[2][0][2] + on_face, of_parts + on_parts];
        assert!(errors.iter().all(|e| e.abs() < 1e-3 * cube), "{forces:?} {of_parts} {errors:?}");
        let [x, y, _] = forces[2][0];
        assert!(x.abs() + y.abs() < 1e-6 * cube, "{forces:?}");
        let others = [forces[0], forces[1], [forces[2][1]; 2]];
        assert!(others.iter().flatten().flatten().all(|&f| f == 0.0), "{forces:?}");
    }
}

/// The faces receive the momentum that a gas of spheres and cubes loses.
#[test]
fn faces_get_the_momentum_that_grains_lose() {
    let run = |threads: usize| {
        let mut scene = room(vec![]);
        scene.gravity = [0.0; 3];
        scene.domain.max = [12e-3; 3];
        scene.shapes = vec![shape("cube")];
        gas(&mut scene, 0.5, 3);
        let cube = |k: f64| {
            let mut cube =
                solid([(2.0 + 4.0 * k) * 1e-3, 6e-3, 6e-3], of_cube(1e-3), [0.4, 0.3, k]);
            cube.orientation = turned([1.0, k, 0.5], 0.7);
            cube
        };
        let list = (0..3).map(|k| cube(f64::from(k))).collect();
        let BodySet { placement, .. } = &mut scene.bodies[0];
        if let tremie_messages::scene::Placement::Listed(spheres) = placement {
            let is_free =
                |x: [f64; 3]| (x[1] - 6e-3).abs() > 1.6e-3 || (x[2] - 6e-3).abs() > 1.6e-3;
            spheres.retain(|sphere| is_free(sphere.position));
        }
        scene.bodies.push(solids("cube", list));
        let mut dem = GrainsDem::new(&scene, &Parameters::default(), 2e-6, threads).unwrap();
        let sum = |dem: &GrainsDem| {
            let forces = dem.face_forces();
            [0, 1, 2].map(|a| forces.iter().flatten().map(|force| force[a]).sum::<f64>())
        };
        let (mut before, mut momentum) = (sum(&dem), dem.diagnostics().momentum);
        let (mut worst, mut got) = (0.0f64, 0.0);
        for _ in 0..3_000 {
            dem.advance(1, &[]).unwrap();
            let (after, now) = (sum(&dem), dem.diagnostics().momentum);
            for a in 0..3 {
                let impulse = 0.5 * dem.time_step() * (before[a] + after[a]);
                worst = worst.max((now[a] - momentum[a] + impulse).abs());
                got += impulse.abs();
            }
            (before, momentum) = (after, now);
        }
        (worst, got, dem.face_forces())
    };
    let (worst, got, expected) = run(1);
    assert!(got > 1e-6 && worst < 1e-12 * got, "{worst} {got}");
    assert_eq!(run(3).2, expected);
}

/// Spheres that come or go between windows change no force of the last window's end.
#[test]
fn forces_are_those_of_the_end_of_the_window() {
    let mut dem = at_rest(&room(one_sphere(20e-3)));
    let before = dem.face_forces();
    assert!(before[2][0][2] < 0.0);
    let added = AddedSphere {
        set: 0,
        position: [10e-3, 10e-3, 20e-3],
        diameter: 0.9 * D,
        velocity: [0.0; 3],
    };
    dem.exchange(&[0], &[added]).unwrap();
    assert_eq!(dem.face_forces(), before);
    dem.advance(1, &[]).unwrap();
    assert_eq!(dem.face_forces(), [[[0.0; 3]; 2]; 3]);
}

/// Grains lean on each other through a mirror.
#[test]
fn mirrors_bear_and_periodic_faces_do_not() {
    use tremie_messages::scene::Face;
    let mut scene = room(one_sphere(0.5 * D));
    scene.domain.faces[0] = [Face::Symmetry, Face::WALL];
    scene.domain.faces[1] = [Face::Periodic, Face::Periodic];
    scene.gravity = [-G, 0.0, -G];
    let forces = at_rest(&scene).face_forces();
    let weight = mass(D) * G;
    assert!((forces[0][0][0] / -weight - 1.0).abs() < 1e-3, "{forces:?}");
    assert!((forces[2][0][2] / -weight - 1.0).abs() < 1e-3, "{forces:?}");
    assert_eq!(forces[1], [[0.0; 3]; 2]);
}
