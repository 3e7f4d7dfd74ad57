//! Momenta and energy over many collisions.

use crate::common::{angular_momentum, bare, gas, make, set, sphere, unit};
use tremie_grains_hard_sphere::Detection;
use tremie_messages::scene::{Face, Motion, Scene};

/// A cloud in a box so large that nothing reaches its walls: rough spheres that fall into each
/// other again and again do not exist without walls, so many clouds collapse one after the other.
fn cloud(seed: u64, restitution: f64) -> Scene {
    let mut scene = crate::common::scene([4000.0; 3], Face::WALLS, restitution, 0.4);
    let spheres = (0..512u64).map(|k| {
        let site = [k % 8, k / 8 % 8, k / 64].map(|n| n as f64 - 3.5);
        let jitter = |a: u64| 0.1 * (unit(seed, 3 * k + a) - 0.5);
        let place = [0, 1, 2].map(|a| 1.3 * site[a] + jitter(a as u64));
        let mut body = sphere(
            place.map(|x| 2000.0 + x),
            1.0,
            [0, 1, 2].map(|a| -place[a] + 5.0 * jitter(a as u64)),
        );
        body.angular_velocity = [0, 1, 2].map(|a| 20.0 * jitter(a));
        body
    });
    scene.bodies = vec![set(Motion::Free, crate::common::density(3), spheres.collect())];
    scene
}

fn largest(v: [f64; 3]) -> f64 {
    v.iter().fold(0.0, |most: f64, x| most.max(x.abs()))
}

/// Without walls: linear and angular momentum about the cloud, after its implosion.
#[test]
fn a_cloud_keeps_its_momenta() {
    for detection in [Detection::Events, Detection::Steps] {
        let (mut collisions, mut worst, mut seed) = (0, 0.0f64, 0);
        let wanted = if detection == Detection::Events { 100_000 } else { 10_000 };
        while collisions < wanted {
            seed += 1;
            let mut spheres = make(&cloud(seed, 0.7), &bare(detection), 0.02);
            let sums = |spheres: &tremie_grains_hard_sphere::HardSpheres| {
                let p = spheres.diagnostics().momentum;
                let about = [2000.0; 3];
                let l = angular_momentum(spheres, 0.4);
                let of = |a: usize| {
                    let (b, c) = ((a + 1) % 3, (a + 2) % 3);
                    l[a] - (about[b] * p[c] - about[c] * p[b])
                };
                (p, [0, 1, 2].map(of))
            };
            let (p, l) = sums(&spheres);
            // What is there to be kept: the sums of the absolute values.
            let scale = (0..512).map(|k| largest(spheres.sphere(k).velocity)).sum::<f64>();
            spheres.advance(100, &[]).unwrap();
            let (q, m) = sums(&spheres);
            for a in 0..3 {
                worst = worst.max((q[a] - p[a]).abs() / scale);
                worst = worst.max((m[a] - l[a]).abs() / (2000.0 * scale));
            }
            collisions += spheres.diagnostics().collisions;
            assert_eq!(spheres.diagnostics().wall_collisions, 0);
        }
        println!(
            "{detection:?}: {collisions} collisions in {seed} clouds, worst change {worst:.1e}"
        );
        assert!(worst < 1e-12, "{worst}");
    }
}

/// A periodic gas keeps its momentum, an elastic one its energy.
#[test]
fn a_gas_keeps_momentum_and_an_elastic_one_energy() {
    for (detection, dt) in [(Detection::Events, 0.5), (Detection::Steps, 0.02)] {
        for (e, friction) in [(1.0, 0.0), (0.95, 0.3)] {
            let mut spheres = make(&gas(3, 5, 0.2, (e, friction), 1), &bare(detection), dt);
            let before = spheres.diagnostics();
            let is_long = detection == Detection::Events && e == 1.0;
            let wanted = if is_long { 100_000 } else { 8_000 };
            while spheres.diagnostics().collisions < wanted {
                spheres.advance(10, &[]).unwrap();
            }
            let after = spheres.diagnostics();
            let change = (0..3).map(|a| (after.momentum[a] - before.momentum[a]).abs());
            let worst = change.fold(0.0, f64::max) / spheres.sphere_count() as f64;
            assert!(worst < 1e-12, "{worst}");
            let energy = after.kinetic_energy / before.kinetic_energy;
            println!("{detection:?} e {e}: momentum {worst:.1e}, energy {energy}");
            if e == 1.0 {
                assert!((energy - 1.0).abs() < 1e-12, "{energy}");
            } else {
                assert!(energy < 0.3);
            }
        }
    }
}

/// Goetsch (2015), App. A: ten spheres in a periodic box, unit edge, radius 0.08, speeds about 1,
/// for 10 s. Angular momentum jumps only where a sphere goes through a face.
#[test]
fn ten_spheres_in_a_periodic_box_keep_what_they_should() {
    for detection in [Detection::Events, Detection::Steps] {
        let spheres = (0..10u64).map(|k| {
            let place = [k % 3, k / 3 % 3, k / 9].map(|n| 0.15 + 0.33 * n as f64);
            sphere(place, 0.16, [0, 1, 2].map(|a| 1.2 * (2.0 * unit(5, 3 * k + a) - 1.0)))
        });
        let mut scene = crate::common::scene([1.0; 3], crate::common::PERIODIC, 1.0, 0.0);
        scene.bodies = vec![set(Motion::Free, 1000.0, spheres.collect())];
        let step = 1e-3;
        let mut ten = make(&scene, &bare(detection), step);
        let before = ten.diagnostics();
        let angular = |ten: &tremie_grains_hard_sphere::HardSpheres| angular_momentum(ten, 0.0);
        let (mut last, mut jumps, mut quiet) = (angular(&ten), 0, 0);
        let mut places: Vec<[f64; 3]> = (0..10).map(|k| ten.sphere(k).position).collect();
        for _ in 0..10_000 {
            ten.advance(1, &[]).unwrap();
            let now = angular(&ten);
            let collided_across = (0..3).any(|a| (now[a] - last[a]).abs() > 1e-11);
            let crossed = (0..10).any(|k| {
                let (old, new) = (places[k], ten.sphere(k).position);
                (0..3).any(|a| (new[a] - old[a]).abs() > 0.5)
            });
            // A pair that meets through a face has its levers on both sides: that is a jump too.
            let at_face = (0..10).any(|k| {
                let x = ten.sphere(k).position;
                x.iter().any(|x| !(0.09..0.91).contains(x))
            });
            if collided_across {
                jumps += 1;
                assert!(crossed || at_face, "the angular momentum changed in the middle");
            } else {
                quiet += 1;
            }
            last = now;
            places.iter_mut().enumerate().for_each(|(k, place)| *place = ten.sphere(k).position);
        }
        let after = ten.diagnostics();
        println!(
            "{detection:?}: {} collisions, {jumps} jumps, {quiet} quiet steps",
            after.collisions
        );
        assert!(jumps > 10 && after.collisions > 50);
        assert!((after.kinetic_energy / before.kinetic_energy - 1.0).abs() < 1e-12);
        let scale = 10.0 * 1000.0 * 0.002145;
        let change = (0..3).map(|a| (after.momentum[a] - before.momentum[a]).abs() / scale);
        assert!(change.fold(0.0, f64::max) < 1e-12);
    }
}
