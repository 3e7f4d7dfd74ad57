//! Equal runs give equal bits, however substeps are grouped and neighbours listed.

mod common;
use common::*;
use tremie_grains_dem::{GrainsDem, Parameters};
use tremie_messages::{
    body::BodyState,
    scene::{Damping, Scene},
};

fn falling() -> Scene {
    let mut scene = scene([6e-3, 6e-3, 12e-3], WALLS, law(1e4, 0.5, Damping::Restitution(0.6)));
    scene.gravity = [1.0, 0.0, -9.81];
    scene.bodies = vec![packed([0.0; 3], [6e-3; 3], 0.35, (0.8e-3, 1.2e-3), 2)];
    scene
}

fn run(skin: f64, windows: u32, substeps: u32) -> Vec<BodyState> {
    let parameters = Parameters { skin: Some(skin), ..Parameters::default() };
    let mut dem = GrainsDem::new(&falling(), &parameters, 1e-6, 1).unwrap();
    for _ in 0..windows {
        dem.advance(substeps, &[]).unwrap();
    }
    assert!(dem.diagnostics().list_rebuilds > 2);
    state(&dem)
}

#[test]
fn equal_runs_give_equal_bits() {
    assert_eq!(run(0.1, 1, 12_000), run(0.1, 1, 12_000));
}

#[test]
fn windows_do_not_enter_the_arithmetic() {
    assert_eq!(run(0.1, 1, 12_000), run(0.1, 4_000, 3));
}

#[test]
fn the_skin_does_not_enter_the_arithmetic_without_periodic_faces() {
    assert_eq!(run(0.02, 1, 12_000), run(0.2, 1, 12_000));
}
