//! Coulomb's friction without history: collisions are those of rough hard spheres, and slopes those
//! of the textbook.

use crate::common::*;
use tremie_messages::scene::{ContactLaw, Damping, Motion, Spring};

const D: f64 = 1e-3;
const K: f64 = 5e3;
/// Stiff, so that a collision does not turn the pair.
const STIFF: f64 = 1e8;
const G: f64 = 9.81;

fn without_history(stiffness: f64, friction: f64, e: f64) -> ContactLaw {
    let spring = Spring::LinearNoHistory { normal_stiffness: stiffness };
    ContactLaw { spring, ..law(stiffness, friction, Damping::Restitution(e)) }
}

/// Two spheres of different sizes meet askew. Impulses are those of rough hard spheres (Crowe et al.
/// 2012): `J_n = (1 + e) m* G_n` and `J_t = min(mu J_n, 2/7 m* |G_t|)`.
#[test]
fn an_oblique_collision_is_that_of_hard_spheres() {
    let e = 0.9;
    for (mu, sideways) in [(0.05, 0.3), (0.1, 2.0), (0.3, 0.5), (0.6, 1.0)] {
        let (one, two) = (D, 1.5 * D);
        let (m1, m2) = (mass(one), mass(two));
        let mut scene = scene([10e-3; 3], WALLS, without_history(STIFF, mu, e));
        let gap = 1e-9;
        let spheres = vec![
            sphere([4e-3, 5e-3, 5e-3], one, [1.0, sideways, 0.0]),
            sphere([4e-3 + 0.5 * (one + two) + gap, 5e-3, 5e-3], two, [0.0; 3]),
        ];
        scene.bodies = vec![set(Motion::Free, spheres)];
        let reduced = m1 * m2 / (m1 + m2);
        let dt = std::f64::consts::PI * (reduced / STIFF).sqrt() / 4000.0;
        let mut dem = make(&scene, dt);
        dem.advance(6000, &[]).unwrap();
        let after = state(&dem);
        let normal = (1.0 + e) * reduced;
        let across = (mu * normal).min(2.0 / 7.0 * reduced * sideways);
        let expected = [1.0 - normal / m1, sideways - across / m1];
        for axis in 0..2 {
            let found = after[0].velocity[axis];
            assert!(
                (found - expected[axis]).abs() < 5e-3,
                "{mu}, {sideways}: {found} {expected:?}"
            );
        }
        let spin = -across * 0.5 * one / inertia(one);
        let found = after[0].angular_velocity[2];
        assert!((found / spin - 1.0).abs() < 1e-2, "{mu}, {sideways}: {found} {spin}");
    }
}

/// On a slope a sphere rolls with 5/7 of the slope's pull where `tan < 7/2 mu`, else it slides.
#[test]
fn a_sphere_rolls_or_slides_down_a_slope() {
    for (tan, mu) in [(0.3f64, 0.2), (0.6, 0.2), (1.0, 0.2), (1.0, 0.1)] {
        let angle = tan.atan();
        let mut scene = scene([1.0, 4e-3, 4e-3], FLOOR, without_history(K, mu, 0.3));
        scene.gravity = [G * angle.sin(), 0.0, -G * angle.cos()];
        let overlap = mass(D) * G * angle.cos() / K;
        let start = [0.1, 2e-3, 0.5 * D - overlap];
        scene.bodies = vec![set(Motion::Free, vec![sphere(start, D, [0.0; 3])])];
        let dt = 2e-6;
        let mut dem = make(&scene, dt);
        dem.advance(5_000, &[]).unwrap();
        let early = state(&dem)[0].velocity[0];
        dem.advance(10_000, &[]).unwrap();
        let found = (state(&dem)[0].velocity[0] - early) / (10_000.0 * dt);
        let rolling = 5.0 / 7.0 * G * angle.sin();
        let sliding = G * (angle.sin() - mu * angle.cos());
        let expected = if tan < 3.5 * mu { rolling } else { sliding };
        assert!((found / expected - 1.0).abs() < 1e-3, "{tan}, {mu}: {found} {expected}");
    }
}

/// Grains that are let fall come to rest but for their creep: contacts at rest are not thrown to and
/// fro. A dashpot of `m*/(14 dt)` carries a sphere's weight at the speed `28 g dt`.
#[test]
fn a_bed_comes_to_rest() {
    let size = [5e-3, 5e-3, 12e-3];
    let mut scene = scene(size, WALLS, without_history(K, 0.5, 0.7));
    scene.gravity = [0.0, 0.0, -G];
    scene.bodies = vec![packed([0.0; 3], size, 0.3, (0.9e-3, 1.1e-3), 7)];
    let dt = 4e-6;
    let mut dem = make(&scene, dt);
    dem.advance(50_000, &[]).unwrap();
    let kinetic = dem.diagnostics().kinetic_energy / dem.body_count() as f64;
    let creep = 28.0 * G * dt;
    assert!(
        kinetic < 0.5 * mass(D) * creep * creep,
        "{}",
        (2.0 * kinetic / mass(D)).sqrt() / creep
    );
}
