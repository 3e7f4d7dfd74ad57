//! Predicted overlaps against those of a run.

use crate::common::*;
use tremie_grains_dem::{Parameters, Resolution};
use tremie_messages::scene::{ContactLaw, Damping, FluidMaterial, Motion, Scene, Spring};

const D: f64 = 2e-3;

fn resolve(scene: &Scene) -> Resolution {
    Parameters::default().resolve(scene).unwrap()
}

/// The greatest overlap of a run over so many steps.
fn greatest(scene: &Scene, dt: f64, steps: u32) -> f64 {
    let mut dem = make(scene, dt);
    dem.advance(steps, &[]).unwrap();
    dem.diagnostics().max_overlap_ratio
}

fn hertz(modulus: f64, damping: Damping) -> ContactLaw {
    let spring =
        Spring::Hertz { effective_modulus: modulus, effective_shear_modulus: 0.3 * modulus };
    ContactLaw { spring, ..law(1.0, 0.0, damping) }
}

/// A ball on a wall, two balls against each other, one that falls: within 2 % under springs that
/// are linear with any dashpot, within 4 % under Hertz's law with one.
#[test]
fn impacts_are_as_deep_as_foretold() {
    let linear = |e: f64| law(400.0, 0.0, Damping::Restitution(e));
    for (law, tolerance) in [
        (linear(1.0), 0.02),
        (linear(0.5), 0.02),
        (linear(0.1), 0.02),
        (hertz(2e5, Damping::Restitution(1.0)), 0.02),
        (hertz(2e5, Damping::Restitution(0.6)), 0.04),
    ] {
        for case in 0..3 {
            let mut scene = scene([20e-3; 3], WALLS, law.clone());
            let ball = |z: f64, v: f64| sphere([10e-3, 10e-3, z], D, [0.0, 0.0, v]);
            let balls = match case {
                0 => vec![ball(1.5e-3, -1.0)],
                1 => vec![ball(8e-3, 0.7), ball(11e-3, -0.7)],
                _ => vec![ball(19e-3, 0.0)],
            };
            if case == 2 {
                scene.gravity = [0.0, 0.0, -30.0];
            }
            scene.bodies = vec![set(Motion::Free, balls)];
            let expected = resolve(&scene).softness.impact.unwrap();
            let found = greatest(&scene, 1e-6, if case == 2 { 40_000 } else { 6_000 });
            // Weight counts at the impact of one that falls.
            let bound = if case == 2 { tolerance + 0.02 } else { tolerance };
            assert!((found / expected.ratio - 1.0).abs() < bound, "{case} {found} {expected:?}");
        }
    }
}

/// A column in a shaft as wide as its grains: the lowest bears all of it, under both laws, within
/// what it swings.
#[test]
fn a_column_presses_as_foretold() {
    for law in [law(500.0, 0.0, Damping::Restitution(0.05)), hertz(5e5, Damping::Restitution(0.05))]
    {
        let count = 8;
        let mut scene = scene([D, D, 2.0 * f64::from(count) * D], WALLS, law);
        scene.gravity = [0.0, 0.0, -9.81];
        let at = |k: i32| sphere([0.5 * D, 0.5 * D, (f64::from(k) + 0.5) * D], D, [0.0; 3]);
        scene.bodies = vec![set(Motion::Free, (0..count).map(at).collect())];
        let expected = resolve(&scene).softness.rest.unwrap();
        let found = greatest(&scene, 2e-6, 40_000);
        let ratio = found / expected.ratio;
        // The softest contact may be that above it, which bears one grain less.
        assert!(ratio > 0.85 && ratio < 1.6, "{ratio} {found} {expected:?}");
    }
}

/// In a fluid nothing falls faster than its terminal velocity: of Stokes where that holds.
#[test]
fn a_fluid_slows_falls() {
    let mut scene = scene([0.2; 3], WALLS, law(1e3, 0.0, Damping::Restitution(1.0)));
    scene.gravity = [0.0, 0.0, -9.81];
    scene.bodies = vec![set(Motion::Free, vec![sphere([0.1; 3], D, [0.0; 3])])];
    let dry = resolve(&scene).softness.impact.unwrap();
    scene.fluid = Some(FluidMaterial::at_rest(1000.0, 10.0));
    let wet = resolve(&scene).softness.impact.unwrap();
    let (fall, stokes) = ((2.0 * 9.81 * 0.099f64).sqrt(), 1500.0 * 9.81 * D * D / (18.0 * 10.0));
    assert!((dry.ratio / wet.ratio / (fall / stokes) - 1.0).abs() < 2e-3, "{dry:?} {wet:?}");
    assert!(wet.why.contains("sinking"), "{wet:?}");
}
