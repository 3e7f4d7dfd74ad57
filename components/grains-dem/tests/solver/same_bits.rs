//! Equal runs give equal bits, however substeps are grouped and neighbours listed.

use crate::common::{walls::paddle, *};
use tremie_grains_dem::{GrainsDem, Parameters};
use tremie_messages::{
    body::BodyState,
    scene::{ContactLaw, Damping, Motion, PairLaw, Scene, Spring},
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
fn the_skin_does_not_enter_the_arithmetic() {
    assert_eq!(run(0.02, 1, 12_000), run(0.2, 1, 12_000));
}

/// Grains that fall through periodic sides onto a floor with a turning part, several blocks of
/// them.
fn crowd() -> Scene {
    let mut scene = scene([14e-3, 14e-3, 30e-3], FLOOR, law(1e3, 0.5, Damping::Restitution(0.6)));
    scene.gravity = [10.0, 3.0, -100.0];
    scene.bodies = vec![packed([0.0; 3], [14e-3, 14e-3, 6e-3], 0.4, (0.7e-3, 0.9e-3), 2)];
    scene.parts = vec![paddle([7e-3, 7e-3, 3e-3])];
    scene
}

fn run_crowd(scene: &Scene, skin: f64, threads: usize) -> (Vec<BodyState>, usize) {
    let parameters = Parameters { skin: Some(skin), ..Parameters::default() };
    let mut dem = GrainsDem::new(scene, &parameters, 4e-6, threads).unwrap();
    for _ in 0..10 {
        dem.advance(120, &[]).unwrap();
    }
    let seen = dem.diagnostics();
    assert!(seen.list_rebuilds > 2 && seen.contacts > 500, "{seen:?}");
    let (force, _) = dem.part_loads().next().unwrap();
    assert!(force[0] != 0.0);
    let spheres = dem.radii().len();
    (state(&dem), spheres)
}

#[test]
fn threads_and_skin_do_not_enter_the_arithmetic_across_periodic_faces() {
    let one = run_crowd(&crowd(), 0.1, 1);
    assert!(one.1 > 1024, "more than two blocks");
    for (skin, threads) in [(0.1, 2), (0.1, 3), (0.03, 1), (0.17, 2)] {
        assert_eq!(one, run_crowd(&crowd(), skin, threads), "{skin} {threads}");
    }
}

/// Fast enough to have lists made anew by itself, in a place that no other grain comes near.
#[test]
fn a_body_far_away_changes_no_bit() {
    let mut more = crowd();
    let far = sphere([7e-3, 7e-3, 28e-3], 0.8e-3, [3.0, 2.0, 0.0]);
    more.bodies.push(set(Motion::Free, vec![far]));
    let (alone, spheres) = run_crowd(&crowd(), 0.1, 2);
    let (with, _) = run_crowd(&more, 0.1, 2);
    assert_eq!(alone[..spheres], with[..spheres]);
}

/// One linear law is computed for several contacts at once; a body of another law, far away, has
/// all contacts computed one by one.
#[test]
fn contacts_side_by_side_give_the_bits_of_contacts_one_by_one() {
    let mut more = crowd();
    let mut far = set(Motion::Free, vec![sphere([7e-3, 7e-3, 28e-3], 0.8e-3, [0.0; 3])]);
    far.material = "glass".into();
    more.bodies.push(far);
    for other in ["glass", "grains", "wall"] {
        let between = ["glass".to_string(), other.to_string()];
        let spring = Spring::Hertz { effective_modulus: 1e6, effective_shear_modulus: 3e5 };
        let law = ContactLaw { spring, ..law(1e3, 0.5, Damping::Restitution(0.6)) };
        more.contacts.push(PairLaw { between, law });
    }
    let (side_by_side, spheres) = run_crowd(&crowd(), 0.1, 1);
    let (one_by_one, _) = run_crowd(&more, 0.1, 1);
    assert_eq!(side_by_side[..spheres], one_by_one[..spheres]);
}
