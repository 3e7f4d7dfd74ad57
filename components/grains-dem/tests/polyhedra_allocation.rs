//! Polyhedra that touch advance without a single allocation.

mod common;
use common::solids::*;
use common::walls::block;
use common::*;
use tremie_grains_dem::{GrainsDem, Parameters};
use tremie_messages::scene::{Damping, Motion};
use tremie_test_support::{Counting, allocations};

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn a_substep_of_polyhedra_allocates_nothing() {
    let mut scene = scene([20e-3; 3], WALLS, law(1e4, 0.4, Damping::Restitution(0.3)));
    scene.gravity = [0.0, 0.0, -9.81];
    scene.shapes = vec![shape("cube"), shape("dodecahedron")];
    let edge = 2e-3;
    // A tower on a plate, a dodecahedron on the floor, and a sphere on the tower.
    let at = |k: f64| solid([10e-3, 10e-3, 1e-3 + (k + 0.5) * edge], of_cube(edge), [0.0; 3]);
    scene.bodies = vec![
        solids("cube", (0..3).map(|k| at(f64::from(k))).collect()),
        solids("dodecahedron", vec![solid([4e-3, 4e-3, 1.1e-3], 2e-3, [0.0; 3])]),
        set(Motion::Free, vec![sphere([10e-3, 10e-3, 7.5e-3], 1e-3, [0.0; 3])]),
    ];
    // The plate is two halves, in a larger one.
    let half = |x: f64| block([7.5 + x, 7.5, 0.0], [10.0 + x, 12.5, 1.0]);
    scene.parts = vec![half(0.0), half(2.5), block([7.0, 7.0, 0.0], [13.0, 13.0, 1.0])];
    let mut dem = GrainsDem::new(&scene, &Parameters::default(), 8e-7, 2).unwrap();
    dem.advance(2_000, &[]).unwrap();
    assert!(dem.diagnostics().contacts >= 4, "{:?}", dem.diagnostics());
    let before = allocations();
    dem.advance(300, &[]).unwrap();
    assert_eq!(allocations() - before, 0);
}
