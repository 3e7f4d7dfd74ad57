//! A wall is one wall, however it is cut: into triangles, parts, planes, faces of the domain, or
//! facets of a curve.

use crate::common::walls::*;
use crate::common::*;
use proptest::prelude::*;
use std::fmt::Write;
use tremie_grains_dem::GrainsDem;
use tremie_messages::{
    body::BodyState,
    scene::{
        Damping, Geometry, Motion, MotionPoint, PairLaw, Part, Plane, Scene, Slider, SliderSpring,
    },
};

/// Diameter, stiffness, and the step at 50 to a contact.
const D: f64 = 4e-3;
const K: f64 = 500.0;
const DT: f64 = 2.5e-5;

fn room(friction: f64, restitution: f64) -> Scene {
    scene([40e-3; 3], WALLS, law(K, friction, Damping::Restitution(restitution)))
}

/// A sphere above a wall at the height `TOP`, moving, after it has bounced.
fn bounce(mut scene: Scene, at: [f64; 2], velocity: [f64; 3]) -> (BodyState, f64, GrainsDem) {
    let mut ball = sphere([at[0], at[1], TOP + 0.51 * D], D, velocity);
    ball.angular_velocity = [40.0, -60.0, 30.0];
    scene.bodies = vec![set(Motion::Free, vec![ball])];
    let mut dem = make(&scene, DT);
    dem.advance(200, &[]).unwrap();
    let deepest = dem.diagnostics().max_overlap_ratio;
    (state(&dem)[0], deepest, dem)
}

/// The same above a plane.
fn reference(at: [f64; 2], velocity: [f64; 3], friction: f64) -> (BodyState, f64) {
    let mut scene = room(friction, 0.5);
    scene.planes = vec![floor(TOP)];
    let (state, deepest, _) = bounce(scene, at, velocity);
    assert!(state.velocity[2] > 0.45 * -velocity[2], "{state:?}");
    (state, deepest)
}

#[track_caller]
fn assert_same(found: (BodyState, f64), expected: (BodyState, f64), tolerance: f64, what: &str) {
    let ((a, deep), (b, expected)) = (found, expected);
    let speed = norm(minus(a.velocity, b.velocity));
    let spin = norm(minus(a.angular_velocity, b.angular_velocity)) * 0.5 * D;
    assert!(speed < tolerance && spin < tolerance, "{what}: {speed} {spin} {a:?} {b:?}");
    assert!((deep - expected).abs() < tolerance, "{what}: {deep} {expected}");
}

#[test]
fn parts_that_stand_flush_are_one_wall() {
    for (at, velocity, friction) in [
        ([20e-3, 20e-3], [0.0, 0.0, -1.0], 0.3),
        ([20.5e-3, 20e-3], [0.0, 0.0, -1.0], 0.3),
        ([19.9e-3, 20.3e-3], [0.4, -0.2, -0.7], 0.3),
        ([19.3e-3, 19.8e-3], [1.0, 0.3, -0.2], 0.0),
    ] {
        let expected = reference(at, velocity, friction);
        for (what, parts, planes) in cuts() {
            let mut scene = room(friction, 0.5);
            (scene.parts, scene.planes) = (parts, planes);
            let (state, deepest, mut dem) = bounce(scene, at, velocity);
            assert_same((state, deepest), expected, 1e-6, what);
            assert_eq!(dem.diagnostics().contacts, 0);
        }
    }
    // No more than 0.49 of 0.5, and straight up.
    let mut scene = room(0.3, 0.5);
    scene.parts = cuts()[3].1.clone();
    scene.bodies =
        vec![set(Motion::Free, vec![sphere([20e-3, 20e-3, 13e-3], D, [0.0, 0.0, -1.0])])];
    let mut dem = make(&scene, DT);
    dem.advance(200, &[]).unwrap();
    let v = state(&dem)[0].velocity;
    assert!((v[2] - 0.49).abs() < 0.01 && v[0] == 0.0 && v[1] == 0.0, "{v:?}");
}

#[test]
fn a_part_flush_with_a_face_of_the_domain_is_one_wall_with_it() {
    let velocity = [0.3, 0.1, -1.0];
    let down = |parts: Vec<Part>, at: f64| {
        let mut scene = room(0.3, 0.5);
        scene.parts = parts;
        let ball = sphere([at, 20e-3, 0.51 * D], D, velocity);
        scene.bodies = vec![set(Motion::Free, vec![ball])];
        let mut dem = make(&scene, DT);
        dem.advance(200, &[]).unwrap();
        (state(&dem)[0], dem.diagnostics().max_overlap_ratio)
    };
    for at in [20e-3, 20.4e-3, 20.5e-3, 19.5e-3, 19e-3] {
        let expected = down(vec![], at);
        let beside = block([-2.0, -2.0, -10.0], [20.0, 42.0, 0.0]);
        assert_same(down(vec![beside], at), expected, 1e-6, "flush");
        let below = block([-2.0, -2.0, -10.0], [20.0, 42.0, -1e-4]);
        assert_same(down(vec![below], at), expected, 1e-6, "a little below");
    }
}

/// A plate that moves along itself between fixed ones, and one that is free to slide but heavy.
#[test]
fn moving_parts_flush_with_fixed_ones_are_one_wall() {
    let sides = [
        block([-2.0, -2.0, 0.0], [20.0, 42.0, 10.0]),
        block([20.0, -2.0, 0.0], [42.0, 42.0, 10.0]),
    ];
    for at in [[20e-3, 20e-3], [20.3e-3, 20e-3], [19.5e-3, 20e-3]] {
        let velocity = [0.0, 0.2, -1.0];
        let expected = reference(at, velocity, 0.0);
        let mut belt = sides.to_vec();
        belt[1].motion = Motion::Prescribed(vec![MotionPoint {
            time: 0.0,
            velocity: [0.0, 0.7, 0.0],
            angular_velocity: [0.0; 3],
        }]);
        let mut held = sides.to_vec();
        held[0].motion = Motion::Slider(Box::new(Slider {
            axis: [0.0, 0.0, 1.0],
            mass: 1e3,
            lift: 0.0,
            velocity: 0.0,
            spring: SliderSpring::Linear { rate: 0.0, preload: 0.0 },
            force: 0.0,
            stops: None,
        }));
        for (parts, tolerance) in [(belt, 1e-6), (held, 1e-5)] {
            let mut scene = room(0.0, 0.5);
            scene.parts = parts;
            let (state, deepest, _) = bounce(scene, at, velocity);
            assert_same((state, deepest), expected, tolerance, "moving");
        }
    }
}

/// Whoever is first in the manifest: the same bits, also where a sphere lands on the point that
/// four parts share, and these are of different materials.
#[test]
fn the_order_of_parts_changes_nothing() {
    let mut four = cuts()[3].1.clone();
    for (k, part) in four.iter_mut().enumerate() {
        part.material = format!("material {k}");
        part.name = format!("{k}");
    }
    let run = |order: [usize; 4], at: [f64; 2]| {
        let mut scene = room(0.3, 0.5);
        scene.parts = order.map(|k| four[k].clone()).to_vec();
        for k in 0..4 {
            let law = law(K * f64::from(k + 1), 0.1 * f64::from(k), Damping::Restitution(0.5));
            scene
                .contacts
                .push(PairLaw { between: ["grains".into(), format!("material {k}")], law });
        }
        let (state, deepest, dem) = bounce(scene, at, [0.1, 0.05, -0.8]);
        let loads: Vec<_> = dem.part_loads().collect();
        let mut by_name = [([0.0; 3], [0.0; 3]); 4];
        for (k, load) in order.into_iter().zip(loads) {
            by_name[k] = load;
        }
        (state, deepest.to_bits(), by_name)
    };
    for at in [[20e-3, 20e-3], [19.99e-3, 20.01e-3]] {
        let expected = run([0, 1, 2, 3], at);
        for order in [[3, 2, 1, 0], [1, 3, 0, 2], [2, 0, 3, 1]] {
            assert_eq!(run(order, at), expected, "{order:?}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn any_cut_of_a_floor_is_one_wall(
        seam in 18.0f64..22.0,
        other in 18.0f64..22.0,
        at in [19e-3f64..21e-3, 19e-3f64..21e-3],
        velocity in [-1.0f64..1.0, -1.0f64..1.0, -1.0f64..-0.1],
        n in 1usize..40,
        uneven in 0.0f64..0.3,
        friction in 0.0f64..0.5,
    ) {
        let expected = reference(at, velocity, friction);
        let file = relief(n, 16e-3, uneven, -2e-3, |_, _| 0.0);
        let z = [0.0, 10.0];
        let parts = vec![
            of_file(&file, [20e-3, 1e-3 * seam - 8e-3, TOP]),
            block([-2.0, seam, z[0]], [other, 42.0, z[1]]),
            block([other, seam, z[0]], [42.0, 42.0, z[1]]),
        ];
        let mut scene = room(friction, 0.5);
        scene.parts = parts;
        let (state, deepest, _) = bounce(scene, at, velocity);
        assert_same((state, deepest), expected, 1e-6, "cut");
    }
}

/// Friction and rolling friction go on across seams: a sphere rolls, spins and comes to rest as on
/// a plane.
#[test]
fn a_sphere_rolls_across_seams_of_parts_as_over_one() {
    let run = |parts: Vec<Part>, planes: Vec<Plane>| {
        let mut scene = room(0.5, 0.5);
        (scene.parts, scene.planes) = (parts, planes);
        scene.gravity = [0.0, 0.0, -9.81];
        for pair in &mut scene.contacts {
            pair.law.rolling_friction = 0.02;
        }
        let mut ball = sphere([15e-3, 18e-3, TOP + 0.5 * D], D, [0.12, 0.03, 0.0]);
        ball.angular_velocity = [0.0, 80.0, 30.0];
        scene.bodies = vec![set(Motion::Free, vec![ball])];
        let mut dem = make(&scene, DT);
        dem.advance(7_000, &[]).unwrap();
        state(&dem)[0]
    };
    let expected = run(vec![], vec![floor(TOP)]);
    assert!((25e-3..37e-3).contains(&expected.position[0]), "{expected:?}");
    for (what, parts, planes) in cuts() {
        let found = run(parts, planes);
        let error = norm(minus(found.position, expected.position));
        assert!(error < 1e-7 * D, "{what}: {error} {found:?} {expected:?}");
    }
}

/// Half a millimetre beside the seam of a part with a face of the domain a sphere goes straight
/// back up.
#[test]
fn a_sphere_beside_the_seam_of_a_part_and_a_face_is_not_pushed_sideways() {
    for at in [19.5e-3, 20.5e-3] {
        for top in [0.0, -1e-7, -0.1] {
            let mut scene = room(0.3, 0.5);
            scene.parts = vec![block([-2.0, -2.0, -10.0], [20.0, 42.0, top])];
            let ball = sphere([at, 20e-3, 0.51 * D], D, [0.0, 0.0, -1.0]);
            scene.bodies = vec![set(Motion::Free, vec![ball])];
            let mut dem = make(&scene, DT);
            dem.advance(200, &[]).unwrap();
            let v = state(&dem)[0].velocity;
            assert!((v[2] - 0.49).abs() < 0.01, "{at} {top}: {v:?}");
            assert!(v[0].abs() + v[1].abs() < 1e-9, "{at} {top}: {v:?}");
        }
    }
}

/// A bore of four times the radius, its facets 1.4 to 6 degrees from each other, is as stiff as one
/// wall at any overlap: a force F goes with the energy `F^2/(2 k)`.
#[test]
fn a_bore_of_many_facets_is_as_stiff_as_one_wall() {
    let (r, big) = (0.5 * D, 2.0 * D);
    let trough = move |x: f64, _: f64| big - (big * big - x * x).sqrt();
    let axis = [20e-3, 20e-3, 20e-3];
    let mut bore = part(Geometry::Cylinder { radius: big, length: 30e-3 }, axis);
    // Along y, as the troughs are.
    bore.pose.orientation = [0.5f64.sqrt(), 0.0, 0.0, 0.5f64.sqrt()];
    bore.cavity = true;
    let mut walls = vec![("bore".to_string(), bore)];
    let files = [16, 31, 60].map(|n| (n, relief(n, 12e-3, 0.0, -2e-3, trough)));
    for (n, file) in &files {
        walls.push((format!("trough of {n}"), of_file(file, [20e-3, 20e-3, 20e-3 - big])));
    }
    for (what, wall) in walls {
        for share in [0.01, 0.03, 0.05] {
            let (mut ends, mut deepest, mut asked) = ([f64::INFINITY, 0.0f64], 0.0f64, 0);
            for k in 0..9 {
                // Let go where it touches, it bobs twice as deep as it rests, and slides over
                // facets.
                let angle = 0.07 * f64::from(k);
                let down = [angle.sin(), 0.0, -angle.cos()];
                let mut scene = room(0.0, 1.0);
                scene.parts = vec![wall.clone()];
                scene.gravity = down.map(|d| d * K * share * r / mass(D));
                let place = [0, 1, 2].map(|a| axis[a] + down[a] * (big - r));
                scene.bodies = vec![set(Motion::Free, vec![sphere(place, D, [0.0; 3])])];
                let mut dem = make(&scene, DT);
                for _ in 0..400 {
                    dem.advance(5, &[]).unwrap();
                    let (seen, (force, _)) = (dem.diagnostics(), dem.part_loads().next().unwrap());
                    let force = norm(force);
                    if force > 0.1 * K * share * r {
                        let stiffness = force * force / (2.0 * K * seen.elastic_energy);
                        ends = [ends[0].min(stiffness), ends[1].max(stiffness)];
                        asked += 1;
                    }
                    deepest = deepest.max(seen.max_overlap_ratio);
                }
            }
            assert!(asked > 1_000 && deepest > 1.8 * share, "{what} {share}: {asked} {deepest}");
            assert!(ends[0] > 0.97 && ends[1] < 1.03, "{what} {share}: {ends:?}");
        }
    }
}

/// Rebound and overlap in a hollow as on a plane, the step as in proportion.
#[test]
fn a_hollow_resists_as_one_wall() {
    let radius = 0.5 * D;
    let cone = |r: f64| Geometry::Revolved {
        profile: vec![[0.0, -4.0 * r], [3.0 * r, -4.0 * r], [5.0 * r, 4.0 * r], [0.0, 4.0 * r]],
    };
    for times in [2.5, 4.0, 10.0] {
        let big = times * radius;
        let mut ring = vec![];
        for k in 0..64 {
            let angle = std::f64::consts::TAU * (f64::from(k) + 0.5) / 64.0;
            let normal = [-libm::cos(angle), -libm::sin(angle), 0.0];
            let point = [20e-3 - big * normal[0], 20e-3 - big * normal[1], 20e-3];
            ring.push(Plane { point, normal, material: "wall".into() });
        }
        let shapes: [(&str, Option<Geometry>, f64); 4] = [
            ("bore", Some(Geometry::Cylinder { radius: big, length: 30e-3 }), big),
            ("bowl", Some(Geometry::Sphere { radius: big }), big),
            ("cone", Some(cone(big / 4.0)), big),
            ("planes", None, big),
        ];
        for (what, geometry, wall) in shapes {
            for (angle, share) in
                [(0.0, 0.01), (0.1, 0.03), (2.03, 0.1), (0.049, 0.05), (4.0, 0.02)]
            {
                // Overlap in terms of the radius: v sqrt(m/k) without a dashpot.
                let speed = share * radius * (K / mass(D)).sqrt();
                let mut scene = room(0.3, 1.0);
                scene.domain.max = [60e-3; 3];
                match geometry.clone() {
                    Some(geometry) => {
                        scene.parts = vec![part(geometry, [20e-3; 3])];
                        scene.parts[0].cavity = true;
                    }
                    None => scene.planes = ring.clone(),
                }
                let way = [libm::cos(angle), libm::sin(angle)];
                let from = wall - 1.02 * radius - if what == "cone" { 0.05 * radius } else { 0.0 };
                let velocity = [way[0] * speed, way[1] * speed, 0.0];
                let position = [20e-3 + from * way[0], 20e-3 + from * way[1], 20e-3];
                scene.bodies = vec![set(Motion::Free, vec![sphere(position, D, velocity)])];
                let mut dem = make(&scene, DT);
                let (mut most, mut pushed) = (0, 0.0f64);
                for _ in 0..(0.1 * radius / speed / DT) as u32 + 60 {
                    dem.advance(1, &[]).unwrap();
                    most = most.max(dem.diagnostics().contacts);
                    let load = dem.part_loads().next().map_or(0.0, |(force, _)| norm(force));
                    pushed = pushed.max(load);
                }
                let deepest = dem.diagnostics().max_overlap_ratio;
                let expected = if what == "cone" { share * 0.97 } else { share };
                assert!(
                    (deepest / expected - 1.0).abs() < 0.035,
                    "{what} {times} {share}: {deepest}"
                );
                if geometry.is_some() {
                    let slope = pushed / (K * deepest * radius);
                    assert!((slope - 1.0).abs() < 0.03, "{what} {times} {share}: {slope}");
                }
                assert_eq!(most, 1, "{what} {times} {share}");
            }
        }
    }
}

/// Kinetic, elastic and potential energy.
fn energy(dem: &mut GrainsDem) -> f64 {
    let d = dem.diagnostics();
    d.kinetic_energy + d.rotational_energy + d.potential_energy + d.elastic_energy
}

/// The most by which energy is ever above that of the start, over it, and the same below.
fn drift(mut scene: Scene, ball: ([f64; 3], [f64; 3]), restitution: f64, windows: u32) -> [f64; 2] {
    let speed = norm(ball.1);
    for pair in &mut scene.contacts {
        pair.law = law(K, 0.0, Damping::Restitution(restitution));
    }
    scene.bodies = vec![set(Motion::Free, vec![sphere(ball.0, D, ball.1)])];
    let mut dem = make(&scene, DT);
    let start = energy(&mut dem);
    let scale = 0.5 * mass(D) * speed * speed;
    let mut ends = [0.0f64; 2];
    for _ in 0..windows {
        dem.advance(5, &[]).unwrap();
        let change = (energy(&mut dem) - start) / scale;
        ends = [ends[0].max(change), ends[1].min(change)];
    }
    ends
}

/// Undamped and without friction, a sphere that is thrown into valleys, over edges and along curves
/// keeps its energy to what a step of a fiftieth of a contact does to it; damped it never has more
/// than at the start.
#[test]
fn no_way_along_a_wall_makes_energy() {
    let valley = |degrees: f64| {
        let slope = (0.5 * (180.0 - degrees)).to_radians().tan();
        relief(8, 24e-3, 0.0, -2e-3, move |x, _| slope * x.abs())
    };
    let bumps =
        relief(24, 24e-3, 0.2, -4e-3, |x, y| 0.4e-3 * ((900.0 * x).sin() + (700.0 * y).cos()));
    let mut scenes: Vec<(String, Vec<Part>)> = vec![];
    let mut files = vec![];
    for degrees in [90.0, 105.0, 120.0, 130.0, 140.0, 150.0, 160.0, 165.0, 170.0, 175.0, 179.0] {
        let file = valley(degrees);
        scenes.push((format!("valley {degrees}"), vec![of_file(&file, [20e-3, 20e-3, TOP])]));
        files.push(file);
    }
    scenes.push(("bumps".into(), vec![of_file(&bumps, [20e-3, 20e-3, TOP])]));
    for step in [1e-6, 1e-3, 1e-2, 0.1, 0.3, 0.6] {
        let low = 10.0 - step * 0.5e3 * D;
        let parts = vec![
            block([-2.0, -2.0, -10.0], [20.0, 42.0, low]),
            block([20.0, -2.0, -10.0], [42.0, 42.0, 10.0]),
        ];
        scenes.push((format!("step {step}"), parts));
    }
    let mut bore = part(Geometry::Cylinder { radius: 12e-3, length: 60e-3 }, [20e-3, 20e-3, 22e-3]);
    bore.pose.orientation = [0.5f64.sqrt(), 0.0, 0.0, 0.5f64.sqrt()];
    bore.cavity = true;
    scenes.push(("bore".into(), vec![bore]));
    let mut all = String::new();
    let mut worst = [0.0f64; 3];
    for (what, parts) in &scenes {
        let mut ends = [0.0f64; 3];
        for k in 0..6 {
            let k = f64::from(k);
            let angle = 0.3 + 0.8 * k;
            let mut scene = room(0.0, 1.0);
            scene.gravity = [0.0, 0.0, -9.81];
            scene.parts.clone_from(parts);
            let height = if what.starts_with("valley") { 16e-3 } else { 13.5e-3 };
            let at = [20e-3 + 1e-3 * angle.sin(), 20e-3 + 0.3e-3 * k, height];
            let speed = 0.3 + 0.1 * k;
            let velocity = [speed * angle.cos(), 0.1 * speed * angle.sin(), -0.15];
            let free = drift(scene.clone(), (at, velocity), 1.0, 400);
            let damped = drift(scene, (at, velocity), 0.6, 400);
            ends = [ends[0].max(free[0]), ends[1].min(free[1]), ends[2].max(damped[0])];
        }
        writeln!(all, "{what}: {ends:?}").unwrap();
        worst = [worst[0].max(ends[0]), worst[1].min(ends[1]), worst[2].max(ends[2])];
    }
    assert!(worst[0] < 4e-3 && worst[1] > -8e-3 && worst[2] < 1e-3, "{worst:?}\n{all}");
}

/// Walls in corners stay as many as they are, and so do those of a slot and a thin bore.
#[test]
fn real_walls_stay_two() {
    let lean = |degrees: f64, parts: bool| {
        let half = (0.5 * degrees).to_radians();
        let mut scene = room(0.0, 0.5);
        scene.gravity = [0.0, 0.0, -9.81];
        let middle = [20e-3, 20e-3, TOP];
        let file = relief(2, 24e-3, 0.0, -2e-3, move |x, _| x.abs() / half.tan());
        if parts {
            scene.parts = vec![of_file(&file, middle)];
        } else {
            scene.planes = [1.0, -1.0]
                .map(|side| Plane {
                    point: middle,
                    normal: [side * half.cos(), 0.0, half.sin()],
                    material: "wall".into(),
                })
                .to_vec();
        }
        let at = [20e-3, 20e-3, TOP + 0.5 * D / half.sin()];
        scene.bodies = vec![set(Motion::Free, vec![sphere(at, D, [0.0; 3])])];
        let mut dem = make(&scene, DT);
        dem.advance(40_000, &[]).unwrap();
        let contacts = dem.diagnostics().contacts;
        (contacts, at[2] - state(&dem)[0].position[2])
    };
    for degrees in [60.0f64, 90.0, 110.0, 120.0] {
        for parts in [false, true] {
            let (contacts, sunk) = lean(degrees, parts);
            assert_eq!(contacts, 2, "{degrees} {parts}");
            let side = (0.5 * degrees).to_radians().sin();
            let expected = mass(D) * 9.81 / (2.0 * K * side * side);
            assert!((sunk / expected - 1.0).abs() < 0.01, "{degrees} {parts}: {sunk} {expected}");
        }
    }
    // A slot a little narrower than the sphere, of two parts, and of one hollow.
    let mut slot = room(0.0, 0.5);
    slot.parts = vec![
        block([5.0, 5.0, 5.0], [18.05, 35.0, 35.0]),
        block([21.95, 5.0, 5.0], [35.0, 35.0, 35.0]),
    ];
    let mut dem = {
        let ball = sphere([20e-3, 20e-3, 37.5e-3], D, [0.0, 0.0, -2.0]);
        slot.bodies = vec![set(Motion::Free, vec![ball])];
        make(&slot, DT)
    };
    let mut most = 0;
    for _ in 0..400 {
        dem.advance(1, &[]).unwrap();
        if state(&dem)[0].position[2] < 34e-3 {
            most = most.max(dem.diagnostics().contacts);
            let x = state(&dem)[0].position[0];
            assert!((x - 20e-3).abs() < 1e-7, "{x}");
        }
    }
    assert_eq!(most, 2);
}
