//! Fluid squeezed out of a gap slows an approach as its equation says.

use crate::common::*;
use std::f64::consts::PI;
use tremie_grains_dem::{GrainsDem, Lubrication, Parameters};
use tremie_messages::{
    scene::{Damping, FluidMaterial, Motion, Scene, Sphere},
    units::Length,
};

const D: f64 = 1e-3;
const ETA: f64 = 0.05;
const CUTOFF: f64 = 1e-4;
const ROUGHNESS: f64 = 1e-6;

fn parameters() -> Parameters {
    let lubrication = Lubrication { cutoff: Length(CUTOFF), roughness: Length(ROUGHNESS) };
    Parameters { lubrication: Some(lubrication), ..Parameters::default() }
}

fn wet(spheres: Vec<Sphere>) -> Scene {
    let mut scene = scene([10e-3; 3], WALLS, law(1e4, 0.0, Damping::Restitution(1.0)));
    scene.fluid = Some(FluidMaterial::at_rest(1000.0, ETA));
    scene.bodies = vec![set(Motion::Free, spheres)];
    scene
}

/// `m* dv/dt = -c v (1/h - 1/h_c)` with `c = 6 pi eta R*^2` gives
/// `v = v_0 - c/m* (ln(h_0/h) - (h_0 - h)/h_c)`.
fn exact(v0: f64, h: f64, reduced_mass: f64, reduced_radius: f64) -> f64 {
    let c = 6.0 * PI * ETA * reduced_radius * reduced_radius;
    v0 - c / reduced_mass * ((CUTOFF / h).ln() - (CUTOFF - h) / CUTOFF)
}

/// Advances until the gap is less than `h`; gap and speed of approach then.
fn approach(scene: &Scene, h: f64, gap: impl Fn(&GrainsDem) -> (f64, f64)) -> (f64, f64) {
    let mut dem = GrainsDem::new(scene, &parameters(), 2e-7, 1).unwrap();
    for _ in 0..200_000 {
        dem.advance(1, &[]).unwrap();
        if gap(&dem).0 < h {
            return gap(&dem);
        }
    }
    panic!("stopped at a gap of {:?}", gap(&dem));
}

#[test]
fn a_sphere_approaches_a_wall() {
    let scene = wet(vec![sphere([5e-3, 5e-3, 0.7e-3], D, [0.0, 0.0, -0.6])]);
    let gap = |dem: &GrainsDem| (state(dem)[0].position[2] - 0.5 * D, -state(dem)[0].velocity[2]);
    for h in [5e-5, 1e-5, 2e-6] {
        let (h, v) = approach(&scene, h, gap);
        let expected = exact(0.6, h, mass(D), 0.5 * D);
        assert!((v - expected).abs() < 1e-4 * 0.6, "{h}: {v} {expected}");
    }
}

#[test]
fn two_spheres_approach_each_other() {
    let scene = wet(vec![
        sphere([4.4e-3, 5e-3, 5e-3], D, [0.4, 0.0, 0.0]),
        sphere([5.6e-3, 5e-3, 5e-3], D, [-0.4, 0.0, 0.0]),
    ]);
    let gap = |dem: &GrainsDem| {
        let [a, b] = state(dem)[..] else { panic!("two bodies") };
        (b.position[0] - a.position[0] - D, a.velocity[0] - b.velocity[0])
    };
    for h in [5e-5, 1e-5, 2e-6] {
        let (h, v) = approach(&scene, h, gap);
        let expected = exact(0.8, h, 0.5 * mass(D), 0.25 * D);
        assert!((v - expected).abs() < 1e-4 * 0.8, "{h}: {v} {expected}");
    }
}

/// Too slow to reach the roughness: it comes to rest at the gap where the equation has used up its
/// speed.
#[test]
fn a_slow_sphere_never_touches() {
    let v0 = 0.05;
    let scene = wet(vec![sphere([5e-3, 5e-3, 0.62e-3], D, [0.0, 0.0, -v0])]);
    let mut dem = GrainsDem::new(&scene, &parameters(), 2e-7, 1).unwrap();
    dem.advance(300_000, &[]).unwrap();
    let h = state(&dem)[0].position[2] - 0.5 * D;
    assert!(h > 2.0 * ROUGHNESS && h < CUTOFF);
    assert!(exact(v0, h, mass(D), 0.5 * D).abs() < 1e-3 * v0, "{h}");
    assert_eq!(dem.diagnostics().contacts, 0);
}

/// Elastic bodies lose `ln(h_c/h_r)` of the Stokes number each way: `e = 1 - 2 ln(h_c/h_r)/St`;
/// 1e-3. Below twice the loss nothing leaves the gap.
#[test]
fn a_wet_rebound_loses_speed() {
    let c = 6.0 * PI * ETA * 0.25 * D * D;
    let loss = (CUTOFF / ROUGHNESS).ln();
    let rebound = |stokes: f64| {
        let v0 = stokes * c / mass(D);
        let scene = wet(vec![sphere([5e-3, 5e-3, 0.62e-3], D, [0.0, 0.0, -v0])]);
        let mut dem = GrainsDem::new(&scene, &parameters(), 1e-8, 1).unwrap();
        for _ in 0..4_000 {
            dem.advance(100, &[]).unwrap();
            let state = state(&dem)[0];
            if state.velocity[2] > 0.0 && state.position[2] > 0.5 * D + CUTOFF {
                return state.velocity[2] / v0;
            }
        }
        0.0
    };
    for stokes in [12.0, 27.0, 40.0] {
        let (e, expected) = (rebound(stokes), 1.0 - 2.0 * loss / stokes);
        println!("{stokes}: {e} {expected}");
        assert!((e - expected).abs() < 1e-3, "{stokes}: {e} {expected}");
    }
    assert_eq!(rebound(8.0), 0.0);
}

#[test]
fn lubrication_needs_a_fluid_and_a_roughness_below_the_cutoff() {
    let mut dry = wet(vec![sphere([5e-3; 3], D, [0.0; 3])]);
    dry.fluid = None;
    let key = |scene: &Scene, p: Parameters| p.resolve(scene).unwrap_err()[0].key.clone();
    assert_eq!(key(&dry, parameters()), "@lubrication");
    let scene = wet(vec![sphere([5e-3; 3], D, [0.0; 3])]);
    let lubrication = Lubrication { cutoff: Length(1e-6), roughness: Length(2e-6) };
    let wrong = Parameters { lubrication: Some(lubrication), ..Parameters::default() };
    assert_eq!(key(&scene, wrong), "@lubrication.roughness");
}
