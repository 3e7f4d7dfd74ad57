//! A wall is one wall to polyhedra too, however it is cut: into triangles, parts, planes or faces
//! of the domain.

use crate::common::solids::*;
use crate::common::walls::*;
use crate::common::*;
use proptest::prelude::*;
use tremie_grains_dem::{GrainsDem, Parameters};
use tremie_messages::{
    body::BodyState,
    scene::{Damping, Motion, MotionPoint, Part, Plane, Scene},
};

/// Edge of a cube, stiffness for each of its faces, and the step.
const EDGE: f64 = 4e-3;
const K: f64 = 2e4;
const DT: f64 = 4e-6;

fn room(friction: f64) -> Scene {
    let mut scene = scene([40e-3; 3], WALLS, law(K, friction, Damping::Restitution(0.5)));
    scene.shapes = vec![shape("cube")];
    scene
}

/// Attitudes of a cube as it comes down: name, orientation, and height of its centre at contact
/// [m].
fn attitudes() -> [(&'static str, [f64; 4], f64); 4] {
    let tilt = libm::atan(2.0f64.sqrt());
    [
        ("flat", [0.0, 0.0, 0.0, 1.0], 0.5 * EDGE),
        ("flat, turned", turned([0.0, 0.0, 1.0], 0.3), 0.5 * EDGE),
        ("edge", turned([0.0, 1.0, 0.0], std::f64::consts::FRAC_PI_4), 0.5f64.sqrt() * EDGE),
        ("corner", turned([1.0, -1.0, 0.0], tilt), 0.75f64.sqrt() * EDGE),
    ]
}

/// A cube that comes down on `height`, once it has bounced.
fn bounce(
    scene: Scene,
    attitude: ([f64; 4], f64),
    at: [f64; 3],
    velocity: [f64; 3],
    spin: [f64; 3],
) -> (BodyState, GrainsDem) {
    bounce_if_it_does(scene, attitude, at, velocity, spin).unwrap()
}

/// The same; none of a cube that rocks on where it fell.
fn bounce_if_it_does(
    mut scene: Scene,
    (orientation, reach): ([f64; 4], f64),
    at: [f64; 3],
    velocity: [f64; 3],
    spin: [f64; 3],
) -> Option<(BodyState, GrainsDem)> {
    let place = [at[0], at[1], at[2] + reach + 5e-6];
    let mut cube = solid(place, of_cube(EDGE), velocity);
    (cube.orientation, cube.angular_velocity) = (orientation, spin);
    scene.bodies = vec![solids("cube", vec![cube])];
    let mut dem = make(&scene, DT);
    for _ in 0..400 {
        dem.advance(20, &[]).unwrap();
        if state(&dem)[0].velocity[2] > 0.0 && dem.diagnostics().contacts == 0 {
            return Some((state(&dem)[0], dem));
        }
    }
    None
}

fn with(parts: Vec<Part>, planes: Vec<Plane>, friction: f64) -> Scene {
    Scene { parts, planes, ..room(friction) }
}

/// Speeds that differ by more than a share of the rebound [m/s].
#[track_caller]
fn assert_same(found: BodyState, expected: BodyState, share: f64, what: &str) {
    let speed = norm(minus(found.velocity, expected.velocity));
    let spin = EDGE * norm(minus(found.angular_velocity, expected.angular_velocity));
    let most = share * expected.velocity[2];
    assert!(speed < most && spin < most, "{what}: {speed} {spin} {found:?} {expected:?}");
}

#[test]
fn cubes_rebound_from_flush_parts_as_from_one() {
    let at = [20e-3, 20e-3, TOP];
    for (attitude, q, reach) in attitudes() {
        let run = |parts, planes| {
            let scene = with(parts, planes, 0.3);
            bounce(scene, (q, reach), at, [0.0, 0.0, -0.1], [0.0; 3])
        };
        let expected = run(vec![], vec![floor(TOP)]).0;
        assert!(expected.velocity[2] > 0.02, "{attitude}: {expected:?}");
        for (what, parts, planes) in cuts() {
            let (found, mut dem) = run(parts, planes);
            assert_same(found, expected, 1e-6, &format!("{attitude}, {what}"));
            let [x, y, _] = found.velocity;
            assert!(x.abs() + y.abs() < 1e-9, "{attitude}, {what}: {found:?}");
            assert_eq!(dem.diagnostics().contacts, 0);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 16, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn any_cut_of_a_floor_is_one_wall(
        seam in 18.0f64..22.0,
        other in 18.0f64..22.0,
        at in [19e-3f64..21e-3, 19e-3f64..21e-3],
        velocity in [-0.2f64..0.2, -0.2f64..0.2, -0.2f64..-0.1],
        axis in [-1.0f64..1.0, -1.0f64..1.0, -1.0f64..1.0],
        angle in 0.0f64..3.0,
        n in 1usize..24,
        uneven in 0.0f64..0.3,
        friction in 0.0f64..0.5,
    ) {
        prop_assume!(norm(axis) > 0.1);
        let q = turned(axis, angle);
        let lowest = (0..8).map(|k| {
            let corner = [0, 1, 2].map(|a| if k >> a & 1 == 0 { 0.5 * EDGE } else { -0.5 * EDGE });
            to_world(q, corner)[2]
        });
        let reach = -lowest.fold(0.0, f64::min);
        let run = |parts, planes| {
            let at = [at[0], at[1], TOP];
            bounce_if_it_does(with(parts, planes, friction), (q, reach), at, velocity, [0.0; 3])
        };
        let expected = run(vec![], vec![floor(TOP)]);
        // One that hardly leaves has no speed to compare with.
        prop_assume!(expected.as_ref().is_some_and(|(state, _)| state.velocity[2] > 0.02));
        let file = relief(n, 16e-3, uneven, -2e-3, |_, _| 0.0);
        let parts = vec![
            of_file(&file, [20e-3, 1e-3 * seam - 8e-3, TOP]),
            block([-2.0, seam, 0.0], [other, 42.0, 10.0]),
            block([other, seam, 0.0], [42.0, 42.0, 10.0]),
        ];
        assert_same(run(parts, vec![]).unwrap().0, expected.unwrap().0, 1e-3, "cut");
    }
}

/// Whoever is first in the manifest.
#[test]
fn the_order_of_parts_changes_nothing_but_rounding() {
    let four = cuts()[3].1.clone();
    for (attitude, q, reach) in attitudes() {
        let run = |order: [usize; 4]| {
            let mut scene = with(order.map(|k| four[k].clone()).to_vec(), vec![floor(TOP)], 0.3);
            scene.parts.push(block([17.0, 17.0, 0.0], [21.0, 21.0, 10.0]));
            let at = [20.1e-3, 19.8e-3, TOP];
            bounce(scene, (q, reach), at, [0.1, 0.05, -0.1], [1.0, 2.0, 3.0]).0
        };
        let expected = run([0, 1, 2, 3]);
        for order in [[3, 2, 1, 0], [1, 3, 0, 2], [2, 0, 3, 1]] {
            assert_same(run(order), expected, 1e-6, attitude);
        }
    }
}

/// Beside the seam, spinning and with friction.
#[test]
fn cubes_that_slide_and_spin_rebound_as_from_one() {
    for (attitude, q, reach) in attitudes() {
        for (at, velocity, spin) in [
            ([20.7e-3, 19.1e-3, TOP], [0.0, 0.0, -0.1], [0.0; 3]),
            ([19.6e-3, 20.3e-3, TOP], [0.2, -0.1, -0.1], [3.0, 2.0, 20.0]),
        ] {
            let run =
                |parts, planes| bounce(with(parts, planes, 0.3), (q, reach), at, velocity, spin).0;
            let expected = run(vec![], vec![floor(TOP)]);
            for (what, parts, planes) in cuts() {
                assert_same(run(parts, planes), expected, 1e-4, &format!("{attitude}, {what}"));
            }
        }
    }
}

#[test]
fn cubes_rebound_from_a_part_flush_with_a_face_of_the_domain_as_from_the_face() {
    for (attitude, q, reach) in attitudes() {
        for x in [20e-3, 20.6e-3, 18.5e-3] {
            let run = |parts| {
                let at = [x, 20e-3, 0.0];
                bounce(with(parts, vec![], 0.3), (q, reach), at, [0.1, 0.05, -0.1], [0.0; 3]).0
            };
            let expected = run(vec![]);
            for top in [0.0, -1e-7, -0.1] {
                let beside = block([-2.0, -2.0, -10.0], [20.0, 42.0, top]);
                assert_same(run(vec![beside]), expected, 1e-4, &format!("{attitude} {x} {top}"));
            }
        }
    }
}

/// A belt moves along itself beside a plate that stands still: two kinds in one region damp as one.
#[test]
fn a_belt_beside_a_plate_damps_as_one_wall() {
    let sides = [
        block([-2.0, -2.0, 0.0], [20.0, 42.0, 10.0]),
        block([20.0, -2.0, 0.0], [42.0, 42.0, 10.0]),
    ];
    let mut belt = sides.to_vec();
    belt[1].motion = Motion::Prescribed(vec![MotionPoint {
        time: 0.0,
        velocity: [0.0, 0.7, 0.0],
        angular_velocity: [0.0; 3],
    }]);
    for (attitude, q, reach) in attitudes() {
        let run = |parts, planes| {
            let at = [20e-3, 20e-3, TOP];
            bounce(with(parts, planes, 0.0), (q, reach), at, [0.0, 0.0, -0.1], [0.0; 3]).0
        };
        let expected = run(vec![], vec![floor(TOP)]);
        assert_same(run(belt.clone(), vec![]), expected, 0.01, attitude);
    }
}

/// Friction goes on across seams.
#[test]
fn a_cube_slides_over_seams_as_over_one_wall() {
    let run = |parts: Vec<Part>, planes: Vec<Plane>| {
        let mut scene = with(parts, planes, 0.2);
        scene.gravity = [0.0, 0.0, -9.81];
        let place = [17e-3, 18.3e-3, TOP + 0.5 * EDGE];
        let mut cube = solid(place, of_cube(EDGE), [0.15, 0.04, 0.0]);
        cube.orientation = turned([0.0, 0.0, 1.0], 0.4);
        cube.angular_velocity = [0.0, 0.0, 20.0];
        scene.bodies = vec![solids("cube", vec![cube])];
        let mut dem = make(&scene, 2.0 * DT);
        dem.advance(10_000, &[]).unwrap();
        state(&dem)[0]
    };
    let expected = run(vec![], vec![floor(TOP)]);
    assert!(expected.position[0] > 21e-3 && norm(expected.velocity) < 1e-3, "{expected:?}");
    for (what, parts, planes) in cuts() {
        let found = run(parts, planes);
        let error = norm(minus(found.position, expected.position));
        assert!(error < 1e-4 * EDGE, "{what}: {error} {found:?} {expected:?}");
    }
}

/// Width of a cube along x [m].
fn widest(q: [f64; 4]) -> f64 {
    (0..3)
        .map(|a| 0.5 * EDGE * to_world(q, [0, 1, 2].map(|b| f64::from(u8::from(a == b))))[0].abs())
        .sum()
}

/// Neither seams nor steps nor inner corners make or take energy.
#[test]
fn energy_is_kept_on_cut_walls() {
    let step = vec![
        block([-2.0, -2.0, -10.0], [20.0, 42.0, 10.0]),
        block([20.0, -2.0, -10.0], [42.0, 42.0, 10.02]),
    ];
    let corner = vec![
        block([-2.0, -2.0, -10.0], [42.0, 42.0, 10.0]),
        block([23.3, -2.0, -10.0], [42.0, 42.0, 20.0]),
    ];
    let mut all = cuts();
    all.push(("a step", step, vec![]));
    all.push(("a corner", corner.clone(), vec![]));
    all.push(("a block and a plane", corner[1..].to_vec(), vec![floor(TOP)]));
    for (what, parts, planes) in all {
        for (attitude, q, reach) in attitudes() {
            let mut scene = with(parts.clone(), planes.clone(), 0.0);
            for pair in &mut scene.contacts {
                pair.law = law(K, 0.0, Damping::Restitution(1.0));
            }
            // Beside an upright wall it touches both at once.
            let beside = what.contains("corner") || what.contains("block and");
            let x = if beside { 23.3e-3 - widest(q) - 1e-5 } else { 20e-3 };
            let mut cube =
                solid([x, 20.3e-3, TOP + reach + 3e-5], of_cube(EDGE), [0.03, 0.01, -0.1]);
            (cube.orientation, cube.angular_velocity) = (q, [1.0, 2.0, 3.0]);
            scene.bodies = vec![solids("cube", vec![cube])];
            let mut dem = make(&scene, DT);
            let first = energy(&mut dem);
            let (mut worst, mut touched, mut left) = (0.0f64, 0, false);
            for _ in 0..400 {
                dem.advance(10, &[]).unwrap();
                let contacts = dem.diagnostics().contacts;
                touched += contacts;
                let error = (energy(&mut dem) / first - 1.0).abs();
                left |= touched > 5 && contacts == 0;
                // The energy in springs is not exact at edges.
                if what != "a step" || contacts == 0 {
                    worst = worst.max(error);
                }
            }
            assert!(left && worst < 1e-3, "{what}, {attitude}: {worst} {touched}");
        }
    }
}

/// The force of a cube at rest on two parts is its weight, with its moment. Each part bears the
/// weight that stands on it.
#[test]
fn parts_bear_what_stands_on_them() {
    let weight = DENSITY * EDGE.powi(3) * 9.81;
    let (left, right) =
        (block([0.0, 0.0, 0.0], [20.0, 40.0, 10.0]), block([20.0, 0.0, 0.0], [40.0, 40.0, 10.0]));
    let mut scene = with(vec![left, right], vec![], 0.3);
    scene.gravity = [0.0, 0.0, -9.81];
    scene.bodies = vec![solids(
        "cube",
        vec![solid([21e-3, 20e-3, TOP + 0.5 * EDGE], of_cube(EDGE), [0.0; 3])],
    )];
    let mut dem = make(&scene, 2.0 * DT);
    dem.advance(10_000, &[]).unwrap();
    let loads: Vec<_> = dem.part_loads().collect();
    // A quarter of the face stands on the left part.
    for ((force, torque), (share, lever)) in
        loads.into_iter().zip([(0.25, 9.5e-3), (0.75, -8.5e-3)])
    {
        assert!((force[2] / (-share * weight) - 1.0).abs() < 1e-3, "{force:?}");
        assert!((torque[1] / (lever * share * weight) - 1.0).abs() < 1e-3, "{torque:?}");
    }
    assert_eq!(dem.diagnostics().contacts, 1);
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let run = |threads: usize| {
        let mut scene = with(cuts()[3].1.clone(), vec![floor(TOP)], 0.3);
        scene.gravity = [0.0, 0.0, -9.81];
        let at = |k: usize| {
            let (x, y) = ((k % 5) as f64, (k / 5) as f64);
            let place = [(12.0 + 4.1 * x) * 1e-3, (12.0 + 4.1 * y) * 1e-3, TOP + 2.2e-3];
            solid(place, of_cube(EDGE), [0.05, 0.02 * x, -0.1])
        };
        scene.bodies = vec![solids("cube", (0..25).map(at).collect())];
        let mut dem = GrainsDem::new(&scene, &Parameters::default(), DT, threads).unwrap();
        dem.advance(1_500, &[]).unwrap();
        let loads: Vec<_> = dem.part_loads().collect();
        (state(&dem), loads)
    };
    let expected = run(1);
    for threads in [2, 3] {
        assert_eq!(run(threads), expected, "{threads}");
    }
}
