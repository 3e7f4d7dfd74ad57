//! Packings have the wanted fraction, no overlap, and the same bits for the same seed.

use crate::common::*;
use tremie_grains_dem::{GrainsDem, Parameters};
use tremie_messages::scene::{BodySet, Damping, Motion, Plane, Scene};

const SIDE: f64 = 10e-3;
const SIZES: (f64, f64) = (0.9e-3, 1.1e-3);

fn scene_with(sets: Vec<BodySet>) -> Scene {
    let mut scene = scene([SIDE; 3], WALLS, law(1e4, 0.5, Damping::Restitution(0.7)));
    scene.bodies = sets;
    scene
}

fn pack(fraction: f64, seed: u64) -> GrainsDem {
    make(&scene_with(vec![packed([0.0; 3], [SIDE; 3], fraction, SIZES, seed)]), 1e-8)
}

/// The deepest overlap of any two spheres, and of a sphere with the box, in mean diameters.
fn deepest(dem: &GrainsDem) -> f64 {
    let balls: Vec<_> = state(dem).iter().map(|s| s.position).zip(dem.radii()).collect();
    let mut worst = f64::NEG_INFINITY;
    for (i, (x, r)) in balls.iter().enumerate() {
        for (y, s) in &balls[i + 1..] {
            worst = worst.max(r + s - norm(minus(*x, *y)));
        }
        for a in 0..3 {
            worst = worst.max(r - x[a]).max(x[a] + r - SIDE);
        }
    }
    worst / 1e-3
}

#[test]
fn honours_the_fraction_without_overlap() {
    for fraction in [0.05, 0.2, 0.3, 0.45, 0.55] {
        let dem = pack(fraction, 1);
        let volume: f64 = dem.radii().map(|r| 4.0 / 3.0 * std::f64::consts::PI * r.powi(3)).sum();
        let grain = std::f64::consts::PI / 6.0 * SIZES.1.powi(3);
        let wanted = fraction * SIDE.powi(3);
        assert!((volume - wanted).abs() <= (0.01 * wanted).max(grain), "{fraction}");
        let overlap = deepest(&dem);
        assert!(overlap < 1e-11, "{fraction}: {overlap}");
    }
}

#[test]
fn equal_seeds_give_equal_bits() {
    for fraction in [0.2, 0.5] {
        assert_eq!(state(&pack(fraction, 5)), state(&pack(fraction, 5)));
        assert_ne!(state(&pack(fraction, 5)), state(&pack(fraction, 6)));
    }
}

#[test]
fn says_what_was_reached_when_a_fraction_is_out_of_reach() {
    let scene = scene_with(vec![packed([0.0; 3], [5e-3; 3], 0.7, SIZES, 1)]);
    let problems = GrainsDem::new(&scene, &Parameters::default(), 1e-8, 1).err().unwrap();
    println!("{}", problems[0]);
    assert_eq!(problems[0].key, "scene.bodies[0].placement.packed.fraction");
    // Random packings reach 0.64, less between walls five diameters apart.
    let reached = problems[0].message.split(' ').find_map(|word| word.parse::<f64>().ok());
    assert!(problems[0].message.contains("was reached"));
    assert!((0.45..0.64).contains(&reached.unwrap()), "{}", problems[0]);
}

#[test]
fn keeps_clear_of_planes_listed_bodies_and_other_packings() {
    for fraction in [0.15, 0.4] {
        let big = sphere([5e-3; 3], 3e-3, [0.0; 3]);
        let low = packed([0.0; 3], [SIDE, SIDE, 6e-3], 0.8 * fraction, SIZES, 1);
        let mut high = packed([0.0, 0.0, 4e-3], [SIDE; 3], 0.5 * fraction, SIZES, 2);
        high.name = "high".into();
        let mut scene = scene_with(vec![low, high, set(Motion::Fixed, vec![big])]);
        scene.planes = vec![Plane {
            point: [2e-3, 0.0, 0.0],
            normal: [0.8, 0.6, 0.0],
            material: "wall".into(),
        }];
        let dem = make(&scene, 1e-8);
        assert!(deepest(&dem) < 1e-11);
        for (s, r) in state(&dem).iter().zip(dem.radii()) {
            let height = 0.8 * (s.position[0] - 2e-3) + 0.6 * s.position[1];
            assert!(height > r - 1e-14);
        }
    }
}

#[test]
fn fills_a_periodic_box_across_its_faces() {
    for (fraction, faces) in [
        (0.2, PERIODIC),
        (0.45, PERIODIC),
        (0.45, [PERIODIC[0].clone(), WALLS[1].clone(), WALLS[2].clone()]),
    ] {
        let mut scene = scene([SIDE; 3], faces.clone(), law(1e4, 0.5, Damping::Restitution(0.7)));
        let held = sphere([0.3e-3, 5e-3, 5e-3], 1.5e-3, [0.0; 3]);
        scene.bodies =
            vec![packed([0.0; 3], [SIDE; 3], fraction, SIZES, 3), set(Motion::Fixed, vec![held])];
        let dem = make(&scene, 1e-8);
        let wraps: [bool; 3] = std::array::from_fn(|a| scene.domain.is_periodic(a));
        let balls: Vec<_> = state(&dem).iter().map(|s| s.position).zip(dem.radii()).collect();
        for (i, (x, r)) in balls.iter().enumerate() {
            for (y, s) in &balls[i + 1..] {
                let way: [f64; 3] = std::array::from_fn(|a| {
                    let d = y[a] - x[a];
                    if wraps[a] { d - SIDE * (d / SIDE).round() } else { d }
                });
                assert!(norm(way) > (r + s) * (1.0 - 1e-11), "{x:?} {y:?}");
            }
        }
        for a in 0..3 {
            // Centres are as likely within a radius of a face as anywhere else, or never there.
            let near = balls.iter().filter(|(x, _)| x[a] < 0.45e-3 || x[a] > SIDE - 0.45e-3);
            let share = near.count() as f64 / balls.len() as f64;
            let expected = if wraps[a] { 0.06..0.12 } else { 0.0..1e-9 };
            assert!(expected.contains(&share), "{share} along {a}");
        }
    }
}

/// Mean structure factor of a periodic packing over the longest waves that fit its box.
fn evenness(dem: &GrainsDem) -> f64 {
    let balls = state(dem);
    let waves = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let factor = |wave: &[f64; 3]| {
        let phase = |x: [f64; 3]| {
            2.0 * std::f64::consts::PI / SIDE * (0..3).map(|a| wave[a] * x[a]).sum::<f64>()
        };
        let re: f64 = balls.iter().map(|s| phase(s.position).cos()).sum();
        let im: f64 = balls.iter().map(|s| phase(s.position).sin()).sum();
        (re * re + im * im) / balls.len() as f64
    };
    waves.iter().map(factor).sum::<f64>() / 3.0
}

#[test]
fn dense_packings_are_even_over_long_distances() {
    // Points thrown at random have 1; hard spheres in equilibrium at 0.3 and 0.45 have 0.10 and
    // 0.03.
    for (fraction, bound) in [(0.3, 0.2), (0.45, 0.15)] {
        let mean = (1..=8).map(|seed| {
            let mut scene = scene([SIDE; 3], PERIODIC, law(1e4, 0.5, Damping::Restitution(0.7)));
            scene.bodies = vec![packed([0.0; 3], [SIDE; 3], fraction, (1e-3, 1e-3), seed)];
            evenness(&make(&scene, 1e-8))
        });
        let mean = mean.sum::<f64>() / 8.0;
        println!("{fraction}: {mean:.3}");
        assert!(mean < bound, "{fraction}: {mean}");
    }
}
