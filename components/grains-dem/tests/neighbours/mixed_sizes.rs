//! Bodies of very different sizes: nobody that is near is missed, whenever lists are made.

use crate::common::solids::*;
use crate::common::*;
use proptest::prelude::*;
use tremie_grains_dem::{GrainsDem, Parameters};
use tremie_messages::{
    body::BodyState,
    scene::{Damping, Motion, MotionPoint, Scene},
};

/// A heap of three sizes, 1 : 5 : 20, that falls through periodic sides onto a floor; the largest
/// sphere is driven through it.
fn heap(seed: u64) -> Scene {
    let mut scene = scene([11e-3, 11e-3, 20e-3], FLOOR, law(1e3, 0.5, Damping::Restitution(0.6)));
    scene.gravity = [10.0, 3.0, -60.0];
    let course = vec![MotionPoint {
        time: 0.0,
        velocity: [1.0, 0.4, -1.0],
        angular_velocity: [0.0, 0.0, 100.0],
    }];
    let plunger = sphere([4e-3, 8e-3, 3.2e-3], 4e-3, [0.0; 3]);
    scene.bodies = vec![
        set(Motion::Prescribed(course), vec![plunger]),
        packed([0.0, 0.0, 6e-3], [11e-3, 11e-3, 9e-3], 0.1, (0.9e-3, 1.0e-3), seed),
        packed([0.0, 0.0, 0.0], [11e-3, 11e-3, 1.2e-3], 0.35, (0.2e-3, 0.24e-3), seed),
    ];
    scene.bodies[0].name = "plunger".into();
    scene
}

/// States of all bodies after so many steps, and the number of lists made.
fn run(scene: &Scene, skin: f64, threads: usize, steps: u32) -> (Vec<BodyState>, u64) {
    let parameters = Parameters { skin: Some(skin), ..Parameters::default() };
    let mut dem = GrainsDem::new(scene, &parameters, 5e-7, threads).unwrap();
    for _ in 0..10 {
        dem.advance(steps / 10, &[]).unwrap();
    }
    let seen = dem.diagnostics();
    assert!(seen.list_rebuilds > 5 && seen.contacts > 100, "{seen:?}");
    (state(&dem), seen.list_rebuilds)
}

/// Another skin lists other pairs at other times. Had a pair that touches ever been missing, or a
/// contact lost what it remembers, some bit would differ; and so it would if sums went by the order
/// in which threads find pairs.
#[test]
fn neither_skin_nor_threads_enter_the_arithmetic() {
    let scene = heap(1);
    let (once, lists) = run(&scene, 0.1, 1, 1_500);
    assert!(once.len() > 5_000, "{} bodies", once.len());
    for (skin, threads) in [(0.1, 2), (0.1, 3), (0.03, 2), (0.25, 1)] {
        let (again, others) = run(&scene, skin, threads, 1_500);
        assert!(once == again, "{skin} {threads}");
        assert!(skin == 0.1 || others != lists, "{others} lists");
    }
}

/// The same with large cubes that fall into the small spheres, and a clump of two sizes.
#[test]
fn neither_do_they_with_polyhedra_and_clumps() {
    let mut scene = heap(3);
    scene.gravity = [10.0, 3.0, -2e3];
    scene.shapes = vec![shape("cube")];
    let die = |x: f64, y: f64| solid([x, y, 2.2e-3], of_cube(1e-3), [0.0; 3]);
    let mut large = set(Motion::Free, vec![sphere([8e-3, 8e-3, 3e-3], 2e-3, [0.0; 3])]);
    let mut small = set(Motion::Free, vec![sphere([8e-3, 9.4e-3, 2e-3], 0.4e-3, [0.0; 3])]);
    for (set, name) in [(&mut large, "large"), (&mut small, "small")] {
        set.name = name.into();
        set.clump = Some("both".into());
    }
    let fine = packed([0.0; 3], [11e-3, 11e-3, 1.2e-3], 0.1, (0.2e-3, 0.24e-3), 3);
    let dice = solids("cube", vec![die(2e-3, 2e-3), die(4.5e-3, 10.8e-3), die(5e-3, 5e-3)]);
    scene.bodies = vec![dice, large, small, fine];
    let (once, _) = run(&scene, 0.1, 1, 2_000);
    for (skin, threads) in [(0.1, 3), (0.04, 2), (0.25, 1)] {
        let (again, _) = run(&scene, skin, threads, 2_000);
        assert!(once == again, "{skin} {threads}");
    }
}

/// A sphere rests on thousands of small ones that stand still, each of which bears a part of it:
/// their forces on it add up to its weight, to 1 %, and the sum does not depend on threads.
#[test]
fn one_large_sphere_touches_thousands() {
    let mut scene = scene([8e-3, 8e-3, 8e-3], WALLS, law(100.0, 0.0, Damping::Restitution(0.97)));
    let weight = 1e3;
    scene.gravity = [0.0, 0.0, -weight];
    let (radius, small) = (3e-3, 0.05e-3);
    // On a spiral of equal areas over the lower half of a sphere.
    let count = 4_000;
    let place = |k: i32| {
        let down = (f64::from(k) + 0.5) / f64::from(count);
        let (across, angle) = ((1.0 - down * down).sqrt(), f64::from(k) * 2.399_963);
        let reach = radius + 0.5 * small;
        let [x, y, z] = [across * angle.cos(), across * angle.sin(), -down].map(|n| reach * n);
        sphere([4e-3 + x, 4e-3 + y, 4e-3 + z], small, [0.0; 3])
    };
    let held = set(Motion::Fixed, (0..count).map(place).collect());
    let large = set(Motion::Free, vec![sphere([4e-3; 3], 2.0 * radius, [0.0; 3])]);
    scene.bodies = vec![large, held];
    let rest = |threads: usize| {
        let mut dem = GrainsDem::new(&scene, &Parameters::default(), 4e-6, threads).unwrap();
        dem.advance(2_500, &[]).unwrap();
        let seen = dem.diagnostics();
        assert!(seen.contacts >= 3_900, "{seen:?}");
        (state(&dem)[0], seen.contacts)
    };
    let (one, _) = rest(1);
    assert_eq!(one, rest(2).0);
    assert!(norm(one.velocity) < 1e-5, "{one:?}");
    // Springs of 100 N/m all over the lower half: stiffness k sum(cos^2) = k N/3 along the axis.
    let sunk = mass(2.0 * radius) * weight / (100.0 * f64::from(count) / 3.0);
    let down = 4e-3 - one.position[2];
    assert!((down / sunk - 1.0).abs() < 0.01, "{one:?} {sunk}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    /// Momentum of a gas of mixed sizes without walls is kept, and energy is none too much,
    /// whatever is listed: of random sizes, with contacts across periodic faces.
    #[test]
    fn a_gas_of_any_sizes_keeps_its_momentum(
        widths in prop::collection::vec(0.05f64..1.0, 40..80),
        seed in any::<u64>(),
    ) {
        let mut scene = scene([3e-3; 3], PERIODIC, law(1e3, 0.3, Damping::Restitution(1.0)));
        scene.contacts[0].law.tension = true;
        let unit = |k: u64| {
            let x = (seed ^ k.wrapping_mul(0x9E37_79B9_7F4A_7C15)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64
        };
        // Places on a lattice keep them apart; the widest in the midst.
        let edge = 3e-3 / 5.0;
        let spheres = (0..).zip(&widths).map(|(k, width)| {
            let at = |n: u64| (n as f64 + 0.5) * edge;
            let v = |a: u64| 2.0 * unit(3 * k + a) - 1.0;
            sphere([at(k % 5), at(k / 5 % 5), at(k / 25)], 0.95 * edge * width, [v(0), v(1), v(2)])
        });
        scene.bodies = vec![set(Motion::Free, spheres.collect())];
        let momentum = |dem: &mut GrainsDem| dem.diagnostics().momentum;
        let mut dem = GrainsDem::new(&scene, &Parameters::default(), 4e-8, 2).unwrap();
        let before = momentum(&mut dem);
        dem.advance(20_000, &[]).unwrap();
        let after = momentum(&mut dem);
        let scale: f64 = widths.iter().map(|width| mass(0.95 * edge * width)).sum();
        prop_assert!(norm(minus(after, before)) < 1e-11 * scale, "{before:?} {after:?}");
        prop_assert!(dem.diagnostics().list_rebuilds > 2);
    }
}
