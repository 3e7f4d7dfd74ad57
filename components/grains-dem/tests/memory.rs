//! The memory that is announced is what a dense bed takes.

mod common;
use common::*;
use tremie_grains_dem::{GrainsDem, Parameters};
use tremie_messages::scene::Damping;
use tremie_test_support::{Counting, live_bytes};

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn a_bed_takes_what_is_announced() {
    let mut scene = scene([16e-3, 16e-3, 10e-3], FLOOR, law(300.0, 0.5, Damping::Restitution(0.3)));
    scene.gravity = [0.0, 0.0, -9.81];
    scene.bodies = vec![packed([0.0; 3], [16e-3, 16e-3, 10e-3], 0.58, (0.95e-3, 1.05e-3), 4)];
    let parameters = Parameters::default();
    let announced = parameters.resolve(&scene).unwrap().memory as f64;
    let before = live_bytes();
    let mut dem = GrainsDem::new(&scene, &parameters, 4e-6, 1).unwrap();
    while dem.diagnostics().list_rebuilds < 3 {
        dem.advance(200, &[]).unwrap();
    }
    let taken = (live_bytes() - before) as f64;
    let spheres = dem.body_count() as f64;
    println!("{} bytes a sphere, announced {}", taken / spheres, announced / spheres);
    // Buffers that grow by doubling have some room to spare.
    assert!((taken / announced - 1.0).abs() < 0.25, "{taken} {announced}");
}
