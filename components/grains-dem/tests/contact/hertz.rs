//! Elastic and oblique impacts under Hertz and Mindlin: the tests of Chung & Ooi, *Granular Matter*
//! 13 (2011) 643, with their materials and analytic values.

use crate::common::*;
use tremie_grains_dem::GrainsDem;
use tremie_messages::scene::{ContactLaw, Damping, Motion, Scene, Spring};

/// Young's modulus [Pa], Poisson's ratio, density [kg/m³].
type Material = (f64, f64, f64);

const GLASS: Material = (48e9, 0.20, 2800.0);
const LIMESTONE: Material = (20e9, 0.25, 2500.0);
const ALUMINIUM: Material = (70e9, 0.30, 2699.0);
const MAGNESIUM: Material = (40e9, 0.35, 1800.0);
const OXIDE: Material = (380e9, 0.23, 4000.0);

/// Between two bodies of the material, or between one and a rigid wall.
fn law_of((young, poisson, _): Material, rigid: bool, friction: f64, e: f64) -> ContactLaw {
    let shear = young / (2.0 * (1.0 + poisson));
    let share = if rigid { 1.0 } else { 0.5 };
    ContactLaw {
        spring: Spring::Hertz {
            effective_modulus: share * young / (1.0 - poisson * poisson),
            effective_shear_modulus: share * shear / (2.0 - poisson),
        },
        friction,
        rolling_friction: 0.0,
        damping: Damping::Restitution(e),
        tension: false,
    }
}

fn scene_of(
    law: ContactLaw,
    material: Material,
    spheres: Vec<([f64; 3], [f64; 3])>,
    d: f64,
) -> Scene {
    let mut scene = scene([1.0; 3], WALLS, law);
    let spheres = spheres.into_iter().map(|(x, v)| sphere(x, d, v)).collect();
    let mut bodies = set(Motion::Free, spheres);
    bodies.density = material.2;
    scene.bodies = vec![bodies];
    scene
}

/// Largest force on body 0, largest overlap by `overlap_of` its position, and the time that
/// velocity changes.
fn impact(
    dem: &mut GrainsDem,
    mass: f64,
    steps: u32,
    overlap_of: impl Fn(f64) -> f64,
) -> (f64, f64, f64) {
    let dt = dem.time_step();
    let (mut force, mut overlap, mut duration) = (0.0f64, 0.0f64, 0.0);
    let mut before = state(dem)[0].velocity[0];
    for _ in 0..steps {
        dem.advance(1, &[]).unwrap();
        let now = state(dem)[0];
        force = force.max((now.velocity[0] - before).abs() / dt * mass);
        overlap = overlap.max(overlap_of(now.position[0]));
        duration += if now.velocity[0] == before { 0.0 } else { dt };
        before = now.velocity[0];
    }
    (force, overlap, duration)
}

fn close(found: (f64, f64, f64), published: (f64, f64, f64)) {
    let ratios = [found.0 / published.0, found.1 / published.1, found.2 / published.2];
    assert!(ratios.iter().all(|ratio| (ratio - 1.0).abs() < 2e-3), "{found:?} {published:?}");
}

fn volume(radius: f64) -> f64 {
    4.0 / 3.0 * std::f64::consts::PI * radius.powi(3)
}

/// Test 1: two equal spheres of 10 mm at 10 m/s each; force, overlap and duration within 0.2 %.
#[test]
fn two_spheres_head_on() {
    for (material, published) in
        [(GLASS, (10697.0, 274.1e-6, 40.34e-6)), (LIMESTONE, (7108.0, 368.3e-6, 54.20e-6))]
    {
        let r = 10e-3;
        let spheres = vec![
            ([0.5 - r - 1e-7, 0.5, 0.5], [10.0, 0.0, 0.0]),
            ([0.5 + r + 1e-7, 0.5, 0.5], [-10.0, 0.0, 0.0]),
        ];
        let law = law_of(material, false, 0.0, 1.0);
        let mut dem = make(&scene_of(law, material, spheres, 2.0 * r), 2e-8);
        let overlap = |x: f64| 2.0 * (x + r - 0.5);
        let found = impact(&mut dem, material.2 * volume(r), 3000, overlap);
        close(found, published);
        let v = state(&dem)[0].velocity[0];
        assert!((v / -10.0 - 1.0).abs() < 1e-3, "{v}");
    }
}

/// Test 2: a sphere of 0.1 m on a rigid wall at 0.2 m/s, within 0.2 %.
#[test]
fn a_sphere_on_a_wall() {
    for (material, published) in
        [(ALUMINIUM, (11370.0, 49.72e-6, 731.7e-6)), (MAGNESIUM, (7233.0, 52.12e-6, 767.1e-6))]
    {
        let r = 0.1;
        let spheres = vec![([r + 1e-7, 0.5, 0.5], [-0.2, 0.0, 0.0])];
        let law = law_of(material, true, 0.0, 1.0);
        let mut dem = make(&scene_of(law, material, spheres, 2.0 * r), 4e-7);
        close(impact(&mut dem, material.2 * volume(r), 3000, |x| r - x), published);
    }
}

/// Test 3: the rebound ratio is the given restitution, whatever the speed; within 0.3 %.
#[test]
fn restitution_is_the_rebound_ratio() {
    for e in [0.2, 0.5, 0.9] {
        for speed in [0.01, 3.9] {
            let r = 2.5e-3;
            let spheres = vec![([r + 1e-9, 0.5, 0.5], [-speed, 0.0, 0.0])];
            let law = law_of(OXIDE, true, 0.092, e);
            let dt = if speed > 1.0 { 5e-9 } else { 1.5e-8 };
            let mut dem = make(&scene_of(law, OXIDE, spheres, 2.0 * r), dt);
            dem.advance(6000, &[]).unwrap();
            let v = state(&dem)[0].velocity[0] / speed;
            assert!((v / e - 1.0).abs() < 3e-3, "{e} {speed}: {v}");
        }
    }
}

/// Test 4: oblique impacts at 3.9 m/s that slide throughout: tangential rebound ratio
/// `1 - mu (1 + e)/tan(theta)` and spin `5/2 mu (1 + e) v_n/R`, within 0.1 %.
#[test]
fn oblique_impacts_that_slide() {
    let (mu, e, speed, r) = (0.092f64, 0.98, 3.9f64, 2.5e-3);
    for (degrees, published) in [(45.0f64, 0.818), (60.0, 0.895)] {
        let theta = degrees.to_radians();
        let (normal, tangential) = (speed * theta.cos(), speed * theta.sin());
        let spheres = vec![([r + 1e-9, 0.5, 0.5], [-normal, tangential, 0.0])];
        let law = law_of(OXIDE, true, mu, e);
        let mut dem = make(&scene_of(law, OXIDE, spheres, 2.0 * r), 5e-9);
        dem.advance(6000, &[]).unwrap();
        let end = state(&dem)[0];
        let ratio = end.velocity[1] / tangential;
        assert!((ratio - published).abs() < 1e-3, "{degrees}: {ratio}");
        let spin = 2.5 * mu * (1.0 + e) * normal / r;
        assert!((end.angular_velocity[2].abs() / spin - 1.0).abs() < 2e-3, "{end:?}");
    }
}

/// Steep impacts stick: friction turns the spring around, so that less is lost than by sliding, and
/// nothing is won. No energy comes from a stiffness that follows the overlap.
#[test]
fn a_sticking_contact_makes_no_energy() {
    let r = 2.5e-3;
    let mass = OXIDE.2 * volume(r);
    for degrees in [2.0f64, 5.0, 10.0, 15.0, 20.0] {
        let theta = degrees.to_radians();
        let v = [-3.9 * theta.cos(), 3.9 * theta.sin(), 0.0];
        let law = law_of(OXIDE, true, 0.5, 1.0);
        let spheres = vec![([r + 1e-9, 0.5, 0.5], v)];
        let mut dem = make(&scene_of(law, OXIDE, spheres, 2.0 * r), 2e-9);
        let before = dem.diagnostics().kinetic_energy;
        dem.advance(10_000, &[]).unwrap();
        let d = dem.diagnostics();
        let after = d.kinetic_energy + d.rotational_energy;
        assert!(after <= before * (1.0 + 1e-6), "{degrees}: {}", after / before);
        assert!(after > 0.9 * before && before > 7.0 * mass);
    }
}

#[test]
fn the_time_step_resolves_the_expected_collision() {
    let r = 10e-3;
    let spheres =
        vec![([0.5 - r, 0.5, 0.5], [10.0, 0.0, 0.0]), ([0.5 + r, 0.5, 0.5], [-10.0, 0.0, 0.0])];
    let scene = scene_of(law_of(GLASS, false, 0.3, 0.9), GLASS, spheres, 2.0 * r);
    let resolution = tremie_grains_dem::Parameters::default().resolve(&scene).unwrap();
    assert_eq!(resolution.expected_speed, 20.0);
    let contact = resolution.contact_time.unwrap();
    assert!((contact / 40.34e-6 - 1.0).abs() < 1e-3, "{contact}");
    assert!((resolution.time_step.unwrap() * 20.0 / contact - 1.0).abs() < 1e-12);
    assert!((resolution.pairs[0].restitution - 0.9).abs() < 1e-9, "{:?}", resolution.pairs);
}
