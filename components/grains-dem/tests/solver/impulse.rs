//! The fluid's impulse arrives in full, window by window.

use crate::common::*;
use tremie_grains_dem::GrainsError;
use tremie_grains_kit::checks::loads::LoadError;
use tremie_messages::{
    body::Load,
    scene::{Damping, Motion},
};

#[test]
fn each_window_gives_force_times_its_length() {
    let d = 1e-3;
    let mut scene = scene([10e-3; 3], PERIODIC, law(1e4, 0.5, Damping::Restitution(0.8)));
    let place = |x| sphere([x, 5e-3, 5e-3], d, [0.0; 3]);
    scene.bodies = vec![set(Motion::Free, vec![place(3e-3), place(7e-3)])];
    let (dt, substeps) = (1e-6, 3);
    let mut dem = make(&scene, dt);
    let (mut expected, mut turn) = ([0.0; 3], 0.0);
    for window in 0..200 {
        let force = [1e-6 * f64::from(window), -2e-6, 3e-7];
        let loads = [0, 1].map(|id| Load { id, force, torque: [0.0, 0.0, 1e-12] });
        dem.advance(substeps, &loads).unwrap();
        let length = dt * f64::from(substeps);
        for a in 0..3 {
            expected[a] += 2.0 * force[a] * length;
        }
        turn += 1e-12 * length / inertia(d);
        let diagnostics = dem.diagnostics();
        assert!(norm(minus(diagnostics.momentum, expected)) < 1e-14 * norm(expected));
        assert!(norm(minus(diagnostics.fluid_impulse, expected)) < 1e-14 * norm(expected));
    }
    assert!((state(&dem)[0].angular_velocity[2] / turn - 1.0).abs() < 1e-12);
}

#[test]
fn weight_is_applied_in_full_beside_the_loads() {
    let mut scene = scene([10e-3; 3], WALLS, law(1e4, 0.5, Damping::Restitution(0.8)));
    scene.gravity = [0.0, 0.0, -9.81];
    scene.bodies = vec![set(Motion::Free, vec![sphere([5e-3; 3], 1e-3, [0.0; 3])])];
    let mut dem = make(&scene, 1e-6);
    let buoyancy = Load { id: 0, force: [0.0, 0.0, 0.4 * mass(1e-3) * 9.81], torque: [0.0; 3] };
    dem.advance(1000, &[buoyancy]).unwrap();
    let v = state(&dem)[0].velocity[2];
    assert!((v / (-0.6 * 9.81 * 1e-3) - 1.0).abs() < 1e-12, "{v}");
}

/// A stack of two at rest: contacts carry the weight of each that the fluid does not.
#[test]
fn contact_forces_are_what_keeps_bodies_at_rest() {
    let d = 1e-3;
    let mut scene = scene([10e-3; 3], WALLS, law(1e4, 0.5, Damping::Restitution(0.1)));
    scene.gravity = [0.0, 0.0, -9.81];
    let place = |z| sphere([5e-3, 5e-3, z], d, [0.0; 3]);
    scene.bodies = vec![set(Motion::Free, vec![place(0.5 * d), place(1.5 * d)])];
    let mut dem = make(&scene, 1e-6);
    let loads = [0, 1].map(|id| {
        let force = [0.0, 0.0, 0.4 * mass(d) * 9.81];
        Load { id, force, torque: [0.0; 3] }
    });
    dem.advance(40_000, &loads).unwrap();
    let mut forces = [[f64::NAN; 3]; 2];
    assert!(dem.write_contact_forces(&mut forces));
    for force in forces {
        assert!((force[2] / (0.6 * mass(d) * 9.81) - 1.0).abs() < 1e-6, "{forces:?}");
    }
}

#[test]
fn loads_that_do_not_fit_are_refused() {
    let mut scene = scene([10e-3; 3], WALLS, law(1e4, 0.5, Damping::Restitution(0.8)));
    scene.bodies = vec![set(Motion::Free, vec![sphere([5e-3; 3], 1e-3, [0.0; 3])])];
    let mut dem = make(&scene, 1e-6);
    let load = |id, x| Load { id, force: [x, 0.0, 0.0], torque: [0.0; 3] };
    let mut answer = |loads: &[Load]| dem.advance(1, loads).unwrap_err();
    assert!(matches!(answer(&[load(0, 0.0); 2]), GrainsError::Load(LoadError::Count { .. })));
    assert!(matches!(answer(&[load(4, 0.0)]), GrainsError::Load(LoadError::Order { .. })));
    assert!(matches!(
        answer(&[load(0, f64::NAN)]),
        GrainsError::Load(LoadError::NotFinite { id: 0 })
    ));
}
