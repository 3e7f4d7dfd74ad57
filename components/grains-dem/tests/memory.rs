//! The announced memory is the memory that bodies take, whatever their sizes and shapes are.

mod common;
use common::solids::*;
use common::*;
use tremie_grains_dem::{GrainsDem, Parameters};
use tremie_messages::scene::{
    BodySet, Damping, Diameters, Face, Motion, Packing, Placement, PolyhedronPlacement, Scene,
};
use tremie_test_support::{Counting, live_bytes};

#[global_allocator]
static COUNTING: Counting = Counting;

/// A box in which things fall.
fn tank(size: [f64; 3], bodies: Vec<BodySet>) -> Scene {
    within(size, WALLS, bodies)
}

fn within(size: [f64; 3], faces: [[Face; 2]; 3], bodies: Vec<BodySet>) -> Scene {
    let mut scene = scene(size, faces, law(300.0, 0.5, Damping::Restitution(0.3)));
    // So much that lists are due soon.
    scene.gravity = [0.0, 0.0, -500.0];
    scene.bodies = bodies;
    scene
}

/// Memory announced for a scene, and memory taken after lists were made twice [bytes], with the
/// number of bodies.
fn of(scene: &Scene) -> (f64, f64, f64) {
    let parameters = Parameters::default();
    let resolution = parameters.resolve(scene).unwrap();
    let before = live_bytes();
    let mut dem = GrainsDem::new(scene, &parameters, resolution.time_step.unwrap(), 1).unwrap();
    while dem.diagnostics().list_rebuilds < 2 {
        dem.advance(50, &[]).unwrap();
    }
    (resolution.memory as f64, (live_bytes() - before) as f64, dem.body_count() as f64)
}

const D: f64 = 1e-3;

fn one_large(width: f64) -> BodySet {
    set(Motion::Free, vec![sphere([8e-3, 8e-3, 8e-3], width, [0.0; 3])])
}

fn cubes(fraction: f64, d: f64) -> BodySet {
    let mut set = packed([0.0; 3], [16e-3, 16e-3, 10e-3], fraction, (d, d), 2);
    let Placement::Packed(packing) = set.placement else { unreachable!() };
    let mut own = solids("cube", Vec::new());
    if let Placement::Polyhedra(polyhedra) = &mut own.placement {
        polyhedra.placement = PolyhedronPlacement::Packed(packing);
    }
    set.placement = own.placement;
    set
}

fn wide(fraction: f64, z: f64) -> BodySet {
    let diameters =
        Diameters::LogNormal { median: 0.5 * D, spread: 1.8, min: 0.2 * D, max: 6.0 * D };
    let (min, max) = ([0.0; 3], [16e-3, 16e-3, z]);
    let packing = Packing { min, max, fraction, diameters, seed: 5 };
    BodySet { placement: Placement::Packed(packing), ..packed(min, max, 0.1, (D, D), 1) }
}

/// One after the other, because they would count with each other.
#[test]
fn memory() {
    bodies_take_what_is_announced();
    what_each_takes_does_not_grow_with_their_number();
}

fn bodies_take_what_is_announced() {
    let full = |fraction: f64, d: f64| {
        packed([0.0; 3], [16e-3, 16e-3, 10e-3], fraction, (0.95 * d, 1.05 * d), 4)
    };
    let above = |fraction: f64, d: f64| {
        packed([0.0, 0.0, 16e-3], [16e-3, 16e-3, 19e-3], fraction, (d, d), 4)
    };
    let (low, high) = ([16e-3, 16e-3, 10e-3], [16e-3, 16e-3, 30e-3]);
    let mut dice = tank(low, vec![cubes(0.12, D)]);
    dice.shapes = vec![shape("cube")];
    let mut mixed = tank(high, vec![cubes(0.05, 3.0 * D), above(0.1, 0.3 * D)]);
    mixed.shapes = vec![shape("cube")];
    let cases = [
        ("bed of one size", within(low, FLOOR, vec![full(0.58, D)]), 1.25),
        ("cloud of one size", tank(low, vec![full(0.1, 0.5 * D)]), 2.0),
        (
            "1 : 60, the small ones a cloud",
            tank(high, vec![one_large(12e-3), above(0.1, 0.2 * D)]),
            2.0,
        ),
        (
            "1 : 20 : 60",
            tank(high, vec![one_large(12e-3), full(0.05, 0.6 * D), above(0.15, 0.2 * D)]),
            2.0,
        ),
        ("log-normal cloud", tank(high, vec![wide(0.2, 30e-3)]), 2.0),
        ("log-normal bed", tank(high, vec![wide(0.5, 10e-3)]), 2.0),
        ("dice", dice, 2.0),
        ("large dice, small spheres", mixed, 2.0),
    ];
    for (name, scene, factor) in cases {
        let (announced, taken, bodies) = of(&scene);
        println!(
            "{name}: {bodies} bodies, {:.0} B each, announced {:.0}",
            taken / bodies,
            announced / bodies
        );
        let ratio = taken / announced;
        assert!(ratio < factor && ratio > 1.0 / factor, "{name}: {taken} of {announced}");
    }
}

/// Twice as many bodies in twice the space: the memory of each does not grow, however wide one
/// among them is.
fn what_each_takes_does_not_grow_with_their_number() {
    let per_body = |height: f64| {
        let small =
            packed([0.0, 0.0, 16e-3], [16e-3, 16e-3, 16e-3 + height], 0.1, (0.2e-3, 0.2e-3), 4);
        let (_, taken, bodies) = of(&tank([16e-3, 16e-3, 40e-3], vec![one_large(12e-3), small]));
        taken / bodies
    };
    let (few, many) = (per_body(4e-3), per_body(8e-3));
    println!("{few:.0} B, {many:.0} B");
    assert!((many / few - 1.0).abs() < 0.3, "{few} {many}");
}
