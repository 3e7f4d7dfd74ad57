//! Bands that brake grains.

use crate::common::solids::*;
use crate::common::*;
use tremie_grains_dem::{GrainsDem, Integrator, Parameters};
use tremie_messages::{
    body::BodyState,
    scene::{Damping, DragBand, Motion, Scene},
};

const D: f64 = 1e-3;
const G: f64 = 9.81;
const TERMINAL: f64 = 0.4;

fn band(min: [f64; 3], max: [f64; 3], terminal_speed: f64) -> DragBand {
    DragBand { name: "band".into(), min, max, terminal_speed }
}

fn with(scene: &Scene, integrator: Integrator, dt: f64, threads: usize) -> GrainsDem {
    let parameters = Parameters { integrator, ..Parameters::default() };
    GrainsDem::new(scene, &parameters, dt, threads).unwrap()
}

/// A sphere that falls in a band that is everywhere.
fn falling() -> Scene {
    // It meets nothing: a soft law lets steps be long.
    let mut scene = scene([0.1; 3], PERIODIC, law(1e-2, 0.0, coefficients(0.0, 0.0)));
    scene.gravity = [0.0, 0.0, -G];
    scene.drag_bands = vec![band([0.0; 3], [0.1; 3], TERMINAL)];
    scene.bodies = vec![set(Motion::Free, vec![sphere([0.05; 3], D, [0.0; 3])])];
    scene
}

/// Error of the speed after half the time scale `v_T / g`, over `v_T`, in so many steps.
fn error_of_fall(integrator: Integrator, steps: u32) -> f64 {
    let time = 0.5 * TERMINAL / G;
    let mut dem = with(&falling(), integrator, time / f64::from(steps), 1);
    for _ in 0..steps / 4 {
        dem.advance(4, &[]).unwrap();
    }
    let speed = -state(&dem)[0].velocity[2];
    (speed / TERMINAL - 0.5_f64.tanh()).abs()
}

#[test]
fn a_fall_tends_to_the_terminal_speed_as_the_exact_one_does() {
    for (integrator, order) in
        [(Integrator::Verlet, 2), (Integrator::Heun, 2), (Integrator::Chen, 1)]
    {
        let [coarse, fine] = [error_of_fall(integrator, 40), error_of_fall(integrator, 80)];
        let ratio = coarse / fine;
        let expected = f64::from(1 << order);
        assert!((ratio / expected - 1.0).abs() < 0.1, "{integrator:?}: {coarse:.3e} {fine:.3e}");
        assert!(fine < 0.01, "{fine}");
    }
    let mut dem = make(&falling(), 1e-5);
    dem.advance(40_000, &[]).unwrap();
    let speed = -state(&dem)[0].velocity[2];
    assert!((speed / TERMINAL - 1.0).abs() < 1e-6, "{speed}");
}

/// What the band took is what the weight did, less what the sphere has.
#[test]
fn the_energy_that_a_band_removes_is_the_work_of_weight_that_does_not_show() {
    let error = |steps: u32| {
        let time = TERMINAL / G;
        let mut dem = make(&falling(), time / f64::from(steps));
        let before = dem.diagnostics();
        dem.advance(steps, &[]).unwrap();
        let after = dem.diagnostics();
        let lost = before.potential_energy - after.potential_energy - after.kinetic_energy;
        let removed = dem.drag_bands().next().unwrap().energy_removed;
        assert!(removed > 0.1 * after.kinetic_energy);
        (removed / lost - 1.0).abs()
    };
    let [coarse, fine] = [error(1000), error(2000)];
    assert!(coarse < 1e-5 && fine < 0.3 * coarse, "{coarse:.3e} {fine:.3e}");
}

/// A gas of spheres under weight, of which a band brakes what is in it.
fn braked_gas() -> Scene {
    let size = 6e-3;
    let mut scene = scene([size; 3], PERIODIC, law(1e3, 0.3, Damping::Restitution(0.7)));
    gas(&mut scene, 0.3, 7);
    scene.gravity = [3.0, 0.0, -G];
    let (low, high) = ([0.0, 0.0, 0.3 * size], [size, size, 0.8 * size]);
    // They overlap.
    let near = ([0.0, 0.0, 0.5 * size], [0.5 * size, size, 0.9 * size]);
    scene.drag_bands = vec![band(low, high, 0.2), band(near.0, near.1, 0.5)];
    scene.drag_bands[1].name = "other".into();
    scene
}

/// Momentum at the end less that at the start, what weight gave, and what bands took.
fn closes(scene: &Scene, mass: f64, integrator: Integrator) {
    let dt = 2e-6;
    let mut dem = with(scene, integrator, dt, 2);
    let bodies = dem.body_count();
    let start = dem.diagnostics().momentum;
    let steps = 6_000;
    for _ in 0..steps / 3 {
        dem.advance(3, &[]).unwrap();
    }
    assert_eq!(dem.body_count(), bodies);
    let end = dem.diagnostics();
    assert!(end.contacts > 0 || scene.bodies[0].clump.is_some());
    let taken: Vec<_> = dem.drag_bands().map(|band| band.momentum_removed).collect();
    assert!(taken.iter().all(|taken| norm(*taken) > 0.0));
    let time = f64::from(steps) * dt;
    let scale = mass * G * time;
    for a in 0..3 {
        let removed: f64 = taken.iter().map(|taken| taken[a]).sum();
        let given = mass * scene.gravity[a] * time;
        let gap = end.momentum[a] - start[a] - given + removed;
        assert!(gap.abs() < 1e-11 * scale, "{integrator:?} {a}: {gap:.3e} of {scale:.3e}");
    }
    assert!(taken[0][2] < 0.0, "falling bodies lose momentum downwards: {taken:?}");
}

#[test]
fn the_account_of_momentum_closes_to_rounding() {
    let scene = braked_gas();
    let radii: Vec<f64> = make(&scene, 1e-6).radii().collect();
    let mass: f64 = radii.iter().map(|radius| mass(2.0 * radius)).sum();
    for integrator in [Integrator::Verlet, Integrator::Heun, Integrator::Chen] {
        closes(&scene, mass, integrator);
    }
}

/// Polyhedra and clumps are braked by their centroids.
#[test]
fn polyhedra_and_clumps_are_braked_too() {
    let size = 20e-3;
    let mut scene = scene([size; 3], PERIODIC, law(1e3, 0.3, Damping::Restitution(0.7)));
    scene.gravity = [0.0, 0.0, -G];
    scene.drag_bands = vec![band([0.0; 3], [size, size, 0.5 * size], 0.1)];
    let pair = |z: f64| [4e-3, 4.8e-3].map(|x| sphere([x, 10e-3, z], D, [0.0, 0.0, -0.5])).to_vec();
    let mut joined = set(Motion::Free, pair(6e-3));
    joined.clump = Some("pair".into());
    scene.bodies = vec![joined];
    closes(&scene, 2.0 * mass(D), Integrator::Verlet);
    let mut dem = make(&scene, 2e-6);
    dem.advance(1000, &[]).unwrap();
    let [a, b] = &state(&dem)[..] else { panic!() };
    assert!(a.velocity[2] > -0.5 && (a.velocity[2] - b.velocity[2]).abs() < 1e-12);

    let cube = solid([10e-3, 10e-3, 6e-3], of_cube(2e-3), [0.0, 0.0, -0.5]);
    (scene.shapes, scene.bodies) = (vec![shape("cube")], vec![solids("cube", vec![cube])]);
    let mut dem = make(&scene, 2e-6);
    dem.advance(1000, &[]).unwrap();
    let found = -state(&dem)[0].velocity[2];
    // v' = g (1 - v^2/v_T^2) from above: v = v_T coth(g t/v_T + c).
    let c = (0.1_f64 / 0.5).atanh();
    let exact = 0.1 / (G * 2e-3 / 0.1 + c).tanh();
    assert!((found / exact - 1.0).abs() < 1e-5, "{found} {exact}");
}

#[test]
fn a_band_brakes_in_its_box_alone() {
    let mut scene = falling();
    let free = {
        let mut scene = scene.clone();
        scene.drag_bands.clear();
        let mut dem = make(&scene, 1e-5);
        dem.advance(500, &[]).unwrap();
        state(&dem)
    };
    scene.drag_bands[0].max[2] = 0.04;
    let mut dem = make(&scene, 1e-5);
    dem.advance(500, &[]).unwrap();
    assert_eq!(state(&dem), free);
    let taken = dem.drag_bands().next().unwrap();
    assert_eq!((taken.momentum_removed, taken.energy_removed), ([0.0; 3], 0.0));
}

/// The end of a run and what the bands took.
fn run(
    threads: usize,
    skin: f64,
    (windows, substeps): (u32, u32),
) -> (Vec<BodyState>, Vec<[f64; 4]>) {
    let parameters = Parameters { skin: Some(skin), ..Parameters::default() };
    let size = 16e-3;
    let mut scene = scene([size; 3], PERIODIC, law(1e3, 0.3, Damping::Restitution(0.7)));
    gas(&mut scene, 0.3, 7);
    scene.gravity = [0.0, 0.0, -G];
    scene.drag_bands = vec![band([0.0; 3], [size, size, 0.5 * size], 0.2)];
    let mut dem = GrainsDem::new(&scene, &parameters, 2e-6, threads).unwrap();
    assert!(dem.body_count() > 1024, "several blocks");
    for _ in 0..windows {
        dem.advance(substeps, &[]).unwrap();
    }
    let flat = |band: tremie_grains_dem::DragBandState| {
        let [x, y, z] = band.momentum_removed;
        [x, y, z, band.energy_removed]
    };
    (state(&dem), dem.drag_bands().map(flat).collect())
}

#[test]
fn bands_give_the_same_bits_on_any_threads_and_with_any_skin() {
    let one = run(1, 0.1, (100, 6));
    assert_eq!(run(3, 0.1, (100, 6)), one);
    assert_eq!(run(2, 0.25, (100, 6)), one);
    // Half kicks are summed up in another grouping, and bodies go the same way.
    assert_eq!(run(1, 0.1, (300, 2)).0, one.0);
}

#[test]
fn bands_that_are_none_are_problems() {
    let refused = |change: &dyn Fn(&mut Scene), words: &[&str]| {
        let mut scene = falling();
        change(&mut scene);
        let problems = GrainsDem::new(&scene, &Parameters::default(), 1e-6, 1).err().unwrap();
        let said: Vec<String> =
            problems.iter().map(|p| format!("{} {}", p.key, p.message)).collect();
        assert_eq!(said.len(), 1, "{said:?}");
        words.iter().for_each(|word| assert!(said[0].contains(word), "{said:?} {word}"));
    };
    refused(&|scene| scene.gravity = [0.0; 3], &["drag_bands[0]", "no gravity"]);
    refused(&|scene| scene.drag_bands[0].terminal_speed = 0.0, &["terminal_speed", "positive"]);
    refused(&|scene| scene.drag_bands[0].max[1] = 0.0, &["drag_bands[0].max", "no extent in y"]);
    refused(&|scene| scene.drag_bands[0].min[1] = f64::NAN, &["drag_bands[0]", "not finite"]);
}
