//! Contacts that adhere, against the theory of Johnson, Kendall and Roberts (1971).

use crate::common::{solids::*, walls::*, *};
use std::f64::consts::PI;
use tremie_grains_dem::{GrainsDem, Parameters};
use tremie_messages::scene::{ContactLaw, Damping, Face, Motion, Scene, Spring};

/// Effective modulus [Pa], work of adhesion [J/m²], diameter of spheres [m]: soft, so that necks
/// are long.
const E: f64 = 1e6;
const W: f64 = 0.1;
const D: f64 = 1e-3;

fn sticky(friction: f64, damping: Damping) -> ContactLaw {
    let spring =
        Spring::Jkr { effective_modulus: E, effective_shear_modulus: 0.3 * E, work_of_adhesion: W };
    ContactLaw { spring, ..law(1.0, friction, damping) }
}

/// Radius of a contact as it parts [m].
fn last_radius(r: f64) -> f64 {
    libm::cbrt(PI * W * r * r / (8.0 * E))
}

/// Overlap at rest under a load [m], which may pull.
fn overlap_under(load: f64, r: f64) -> f64 {
    let pull = 3.0 * PI * W * r;
    let a = libm::cbrt(0.75 * r / E * (load + pull + (2.0 * load * pull + pull * pull).sqrt()));
    a * a / r - (2.0 * PI * W * a / E).sqrt()
}

/// Two spheres at a distance of surfaces, the second with a velocity.
fn pair(gap: f64, speed: f64, damping: Damping) -> Scene {
    let mut scene = scene([20e-3; 3], WALLS, sticky(0.3, damping));
    let middle = 10e-3;
    let (a, b) = ([middle - 0.5 * D, middle, middle], [middle + 0.5 * D + gap, middle, middle]);
    let spheres = vec![sphere(a, D, [0.0; 3]), sphere(b, D, [speed, 0.0, 0.0])];
    scene.bodies = vec![set(Motion::Free, spheres)];
    scene
}

/// Relative speed of two spheres [m/s] and the gap between them [m].
fn apart(dem: &GrainsDem) -> [f64; 2] {
    let s = state(dem);
    [s[1].velocity[0] - s[0].velocity[0], s[1].position[0] - s[0].position[0] - D]
}

/// Speed up to which two spheres stick (Thornton and Ning 1998): the loss is `7.09 (w^5
/// R^4/E^2)^(1/3)`.
fn sticking_speed() -> f64 {
    let r = 0.25 * D;
    let lost = 7.0913 * libm::cbrt(W.powi(5) * r.powi(4) / (E * E));
    (2.0 * lost / (0.5 * mass(D))).sqrt()
}

#[test]
fn elastic_spheres_rebound_less_the_work_of_adhesion_or_stick() {
    let slowest = sticking_speed();
    for (factor, steps) in [(1.05, 60_000), (1.5, 30_000), (4.0, 20_000)] {
        let speed = factor * slowest;
        let mut dem = make(&pair(2e-7, -speed, Damping::Restitution(1.0)), 5e-8);
        dem.advance(steps, &[]).unwrap();
        let [found, gap] = apart(&dem);
        assert!(gap > 5e-6, "{factor}: {gap}");
        let expected = (1.0 - 1.0 / (factor * factor)).sqrt();
        assert!((found / speed - expected).abs() < 4e-3, "{factor}: {} {expected}", found / speed);
    }
    let mut dem = make(&pair(2e-7, -0.95 * slowest, Damping::Restitution(1.0)), 5e-8);
    for _ in 0..40 {
        dem.advance(4000, &[]).unwrap();
        let gap = apart(&dem)[1];
        assert!(gap < 3.0 * last_radius(0.25 * D).powi(2) / (0.25 * D), "{gap}");
    }
}

/// The work of parting bodies at rest does not depend on the speed of the pull.
#[test]
fn parting_takes_the_same_work_at_any_speed() {
    let r = 0.25 * D;
    let a = last_radius(r);
    // Over (a/a_c)^(1/2) = x the work is E a_c^5/R^2 x^4 (8/15 x^6 - 16/3 x^3 + 8), at rest x^3 =
    // 6.
    let work = E * a.powi(5) / (r * r) * (3.2 + 4.8 * 6f64.powf(4.0 / 3.0));
    let m = 0.5 * mass(D);
    for factor in [1.1, 2.0, 6.0] {
        let speed = factor * (2.0 * work / m).sqrt();
        let scene = pair(-overlap_under(0.0, r), speed, Damping::Restitution(1.0));
        let mut dem = make(&scene, 5e-8);
        let before = dem.diagnostics().elastic_energy;
        dem.advance(30_000, &[]).unwrap();
        let found = 0.5 * m * (speed * speed - apart(&dem)[0].powi(2));
        assert!((found / work - 1.0).abs() < 5e-3, "{factor}: {found} {work}");
        assert_eq!(dem.diagnostics().elastic_energy, 0.0, "{before}");
    }
}

#[test]
fn a_bound_pair_keeps_its_energy_and_comes_to_rest_where_the_theory_has_it() {
    let rest = overlap_under(0.0, 0.25 * D);
    let depth = sticking_speed().powi(2) * 0.25 * mass(D);
    let mut dem = make(&pair(-0.5 * rest, 0.0, Damping::Restitution(1.0)), 1e-7);
    dem.advance(1, &[]).unwrap();
    let energy = |dem: &mut GrainsDem| {
        let seen = dem.diagnostics();
        seen.kinetic_energy + seen.elastic_energy
    };
    let first = energy(&mut dem);
    let mut fastest = 0.0f64;
    for _ in 0..200 {
        dem.advance(100, &[]).unwrap();
        fastest = fastest.max(dem.diagnostics().kinetic_energy);
        let now = energy(&mut dem);
        assert!((now - first).abs() < 1e-4 * depth, "{now} {first}");
    }
    assert!(fastest > 1e-2 * depth, "{fastest} {depth}");
    let mut dem = make(&pair(-0.5 * rest, 0.0, Damping::Restitution(0.3)), 5e-7);
    dem.advance(100_000, &[]).unwrap();
    let gap = apart(&dem)[1];
    assert!((gap / -rest - 1.0).abs() < 1e-6, "{gap} {rest}");
}

/// A sphere under a ceiling, with a weight over the largest pull; whether it hangs there after a
/// while.
fn hangs(mut scene: Scene, ceiling: f64, weight: f64) -> bool {
    let r = 0.5 * D;
    let pull = 1.5 * PI * W * r;
    scene.gravity = [0.0, 0.0, -weight * pull / mass(D)];
    // Bodies that touch, and go on to where they hang, their contact drawn out to a neck.
    let z = ceiling - r + 1e-9;
    scene.bodies = vec![set(Motion::Free, vec![sphere([20e-3, 20.3e-3, z], D, [0.0; 3])])];
    let mut dem = make(&scene, 1e-6);
    dem.advance(20_000, &[]).unwrap();
    let neck = 3.0 * last_radius(r).powi(2) / r;
    state(&dem)[0].position[2] > z - neck
}

#[test]
fn walls_and_parts_hold_up_to_the_largest_pull() {
    let room = || scene([40e-3; 3], WALLS, sticky(0.3, Damping::Restitution(0.01)));
    let plate = block([-2.0, -2.0, 30.0], [42.0, 42.0, 42.0]);
    for (parts, ceiling) in [(vec![], 40e-3), (vec![plate], 30e-3)] {
        let scene = || Scene { parts: parts.clone(), ..room() };
        assert!(hangs(scene(), ceiling, 0.98), "{ceiling}");
        assert!(!hangs(scene(), ceiling, 1.02), "{ceiling}");
    }
}

/// Contacts begin and end, and lists are made anew, without a difference between numbers of
/// threads.
#[test]
fn threads_change_nothing() {
    let mut scene = scene([8e-3; 3], PERIODIC, sticky(0.4, Damping::Restitution(0.7)));
    gas_of(&mut scene);
    let run = |threads: usize| {
        let mut dem = GrainsDem::new(&scene, &Parameters::default(), 2e-6, threads).unwrap();
        dem.advance(5000, &[]).unwrap();
        let seen = dem.diagnostics();
        assert!(seen.contacts > 20 && seen.list_rebuilds > 2, "{seen:?}");
        state(&dem)
    };
    assert_eq!(run(1), run(3));
}

/// A gas whose spheres stick; the law of the gas's own placement is a stiffer one.
fn gas_of(scene: &mut Scene) {
    let contacts = std::mem::replace(
        &mut scene.contacts,
        crate::common::scene([8e-3; 3], PERIODIC, law(1e3, 0.0, Damping::Restitution(1.0)))
            .contacts,
    );
    gas(scene, 0.2, 5);
    scene.contacts = contacts;
}

#[test]
fn polyhedra_are_refused_by_the_name_of_the_law() {
    let mut scene = scene([40e-3; 3], WALLS, sticky(0.3, Damping::Restitution(0.5)));
    scene.shapes = vec![shape("cube")];
    scene.bodies = vec![solids("cube", vec![solid([20e-3; 3], of_cube(4e-3), [0.0; 3])])];
    let found = Parameters::default().resolve(&scene).unwrap_err();
    let refused = found.iter().find(|p| p.key == "scene.contacts[0].law.spring").unwrap();
    assert!(refused.message.contains("Kendall") && refused.message.contains("polyhedra"));
}

#[test]
fn adhesion_must_be_positive() {
    let mut scene = scene(
        [40e-3; 3],
        [const { [Face::WALL, Face::WALL] }; 3],
        sticky(0.3, Damping::Restitution(0.5)),
    );
    let Spring::Jkr { work_of_adhesion, .. } = &mut scene.contacts[1].law.spring else { panic!() };
    *work_of_adhesion = 0.0;
    let found = Parameters::default().resolve(&scene).unwrap_err();
    assert_eq!(found[0].key, "scene.contacts[1].law.work_of_adhesion");
}
