//! Parts that go through periodic faces: their ends beyond the domain are no walls, and along
//! themselves they slide as a wall of the domain does.

use crate::common::*;
use tremie_grains_dem::GrainsDem;
use tremie_messages::scene::{
    Course, Damping, Face, Geometry, Motion, Part, PartBoundary, Pose, Scene, TimedMotion,
};

const WALL: [Face; 2] = [Face::WALL, Face::WALL];
const AROUND: [Face; 2] = [Face::Periodic, Face::Periodic];

fn part(geometry: Geometry, position: [f64; 3], velocity: [f64; 3], spin: [f64; 3]) -> Part {
    let timed =
        TimedMotion { velocity, angular_velocity: spin, course: Course::Points(Vec::new()) };
    let moves = [velocity, spin] != [[0.0; 3]; 2];
    Part {
        name: "part".into(),
        geometry,
        pose: Pose { position, ..Pose::IDENTITY },
        cavity: false,
        material: "wall".into(),
        motion: if moves { Motion::Timed(Box::new(timed)) } else { Motion::Fixed },
        boundary: PartBoundary::Wall,
    }
}

fn run(scene: &Scene, dt: f64, steps: u32) -> GrainsDem {
    let mut dem = make(scene, dt);
    for _ in 0..steps / 100 {
        dem.advance(100, &[]).unwrap();
    }
    dem
}

/// A tube whose caps lie beyond the domain: wrapped into it, one of them would stand at 1.25 m.
#[test]
fn a_grain_flies_through_a_tube_for_several_periods() {
    let mut tube =
        scene([1.05, 1.05, 1.5], [WALL, WALL, AROUND], law(5e4, 0.0, coefficients(0.0, 0.0)));
    let cylinder = Geometry::Cylinder { radius: 0.5, length: 4.0 };
    tube.parts = vec![part(cylinder, [0.525, 0.525, 0.75], [0.0; 3], [0.0; 3])];
    tube.parts[0].cavity = true;
    // On the axis nothing is in its way; one that flies askew bounces off the side only.
    tube.bodies = vec![set(
        Motion::Free,
        vec![
            sphere([0.525, 0.525, 0.75], 0.2, [0.0, 0.0, 1.0]),
            sphere([0.525, 0.525, 0.25], 0.2, [0.4, 0.0, 1.0]),
        ],
    )];
    let mut dem = run(&tube, 1e-4, 80_000);
    let after = state(&dem);
    assert_eq!(after[0].velocity, [0.0, 0.0, 1.0]);
    let way = 0.75_f64 + 8.0;
    assert!((after[0].position[2] - (way - 1.5 * (way / 1.5).floor())).abs() < 1e-9);
    assert!((after[1].velocity[2] - 1.0).abs() < 1e-9, "{:?}", after[1].velocity);
    assert!((norm(after[1].velocity) - 1.16f64.sqrt()).abs() < 2e-3, "{:?}", after[1].velocity);
    assert!(dem.diagnostics().contacts < 2);
}

/// A floor of the domain that moves along itself, and an endless plate in its place: the same grain
/// rolls on both.
#[test]
fn an_endless_plate_drags_as_a_wall_does() {
    let friction = law(2e3, 0.3, Damping::Restitution(0.5));
    let (speed, d) = ([0.3, 0.1, 0.0], 0.01);
    let floor = Face::Wall { velocity: speed, course: Course::Points(Vec::new()) };
    let mut wall = scene([0.05, 0.04, 0.1], [AROUND, AROUND, [floor, Face::WALL]], friction);
    wall.gravity = [0.0, 0.0, -9.81];
    let rest = |z: f64| {
        vec![
            sphere([0.01, 0.01, z + 0.5 * d], d, [0.0; 3]),
            sphere([0.03, 0.03, z + 2.0 * d], d, [-0.2, 0.0, 0.0]),
        ]
    };
    wall.bodies = vec![set(Motion::Free, rest(0.0))];
    let mut plate = wall.clone();
    plate.domain.faces[2][0] = Face::WALL;
    // Longer than the domain along x, just as long along y.
    let size = [1.0, 0.04, 0.02];
    let above = 0.025;
    plate.parts = vec![part(Geometry::Box { size }, [0.02, 0.02, above - 0.01], speed, [0.0; 3])];
    plate.bodies = vec![set(Motion::Free, rest(above))];
    let (dt, steps) = (2e-5, 60_000);
    let (wall, plate) = (state(&run(&wall, dt, steps)), state(&run(&plate, dt, steps)));
    // The plate's own pose went round the domain, its surface did not.
    let its = plate[2].position;
    let round = |x: f64, size: f64| x - size * (x / size).floor();
    assert!((its[0] - round(0.02 + 1.2 * 0.3, 0.05)).abs() < 1e-9, "{its:?}");
    assert!((its[1] - round(0.02 + 1.2 * 0.1, 0.04)).abs() < 1e-9, "{its:?}");
    for (a, b) in wall.iter().zip(&plate).take(2) {
        let mut off = minus(a.position, b.position);
        off[2] += above;
        assert!(norm(off) < 1e-9, "{:?} {:?}", a.position, b.position);
        assert!(norm(minus(a.velocity, b.velocity)) < 1e-9, "{:?} {:?}", a.velocity, b.velocity);
    }
    // A sphere at rest that a plate drags ends up rolling, with 2/7 of its speed; here it goes
    // further than a period.
    let [x, y, _] = plate[0].velocity;
    assert!((x - 0.3 * 2.0 / 7.0).abs() < 1e-3 && (y - 0.1 * 2.0 / 7.0).abs() < 1e-3, "{x} {y}");
}

/// A rod that turns about its axis and slides along it, between grains that rest on it in a trough:
/// they are dragged both ways, wherever along the rod they are, at its ends too.
#[test]
fn a_rod_turns_and_slides_alike_everywhere() {
    let along = |x: f64| {
        let mut scene = scene(
            [0.06, 0.06, 0.06],
            [AROUND, WALL, WALL],
            law(2e3, 0.3, Damping::Restitution(0.5)),
        );
        scene.gravity = [0.0, 0.0, -9.81];
        let cylinder = Geometry::Cylinder { radius: 0.01, length: 0.5 };
        let mut rod = part(cylinder, [0.05, 0.03, 0.03], [0.2, 0.0, 0.0], [5.0, 0.0, 0.0]);
        let half = 0.5f64.sqrt();
        rod.pose.orientation = [0.0, half, 0.0, half];
        scene.parts = vec![rod];
        let grain = sphere([x, 0.0301, 0.045], 0.01, [0.0; 3]);
        scene.bodies = vec![set(Motion::Free, vec![grain])];
        let after = state(&run(&scene, 2e-5, 4000))[0];
        ([after.position[0] - x, after.position[1], after.position[2]], after.velocity)
    };
    let (position, velocity) = along(0.02);
    assert!(velocity[0] > 0.01 && velocity[1].abs() > 1e-3, "{velocity:?}");
    for x in [0.001, 0.03, 0.04, 0.0595] {
        let (there, v) = along(x);
        let mut off = minus(there, position);
        off[0] -= 0.06 * (off[0] / 0.06).round();
        assert!(norm(off) < 1e-9 && norm(minus(v, velocity)) < 1e-8, "{x}: {off:?} {v:?}");
    }
}

/// A tube with something that moves inside, as a pump has: grains are pushed along by a disc
/// shorter than the domain, and go round with it.
#[test]
fn a_piston_in_a_tube_pushes_grains_round_and_round() {
    let mut pump =
        scene([0.1, 0.1, 0.12], [WALL, WALL, AROUND], law(2e3, 0.0, Damping::Restitution(0.3)));
    let tube = Geometry::Cylinder { radius: 0.03, length: 0.12 };
    pump.parts = vec![
        part(tube, [0.05, 0.05, 0.06], [0.0; 3], [0.0; 3]),
        part(
            Geometry::Cylinder { radius: 0.028, length: 0.02 },
            [0.05, 0.05, 0.03],
            [0.0, 0.0, 0.3],
            [0.0; 3],
        ),
    ];
    pump.parts[0].cavity = true;
    let grain = sphere([0.055, 0.05, 0.06], 0.02, [0.0; 3]);
    pump.bodies = vec![set(Motion::Free, vec![grain])];
    let dem = run(&pump, 2e-5, 100_000);
    let after = state(&dem);
    // Struck once, it flies ahead with 1.3 times the disc's speed, until it comes up to its back;
    // so it goes on for ever.
    assert!(after[0].velocity[2] > 0.2, "{:?}", after[0].velocity);
    let across = minus(after[0].position, [0.05, 0.05, after[0].position[2]]);
    assert!(norm(across) < 0.021, "{across:?}");
    let ahead = (after[0].position[2] - after[1].position[2]).rem_euclid(0.12);
    assert!(ahead > 0.0199 && ahead < 0.1001, "never in the disc: {ahead}");
}

#[test]
fn what_cannot_go_on_is_refused() {
    let mut scene = scene([0.1; 3], [AROUND, WALL, WALL], law(2e3, 0.3, Damping::Restitution(0.5)));
    scene.parts = vec![part(
        Geometry::Box { size: [0.5, 0.02, 0.02] },
        [0.05; 3],
        [0.1, 0.0, 0.0],
        [0.0, 0.0, 1.0],
    )];
    scene.bodies = vec![set(Motion::Free, vec![sphere([0.05, 0.02, 0.02], 0.01, [0.0; 3])])];
    let found = |scene: &Scene| {
        let refused = tremie_grains_dem::Parameters::default().resolve(scene).unwrap_err();
        refused.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
    };
    let text = found(&scene);
    assert!(
        text.contains("scene.parts[0].motion") && text.contains("turn about x alone"),
        "{text}"
    );
    scene.parts[0].motion = Motion::Fixed;
    scene.parts[0].pose.orientation = [0.0, 0.0, 0.1, 0.99f64.sqrt()];
    let text = found(&scene);
    assert!(text.contains("scene.parts[0].geometry") && text.contains("cross-sections"), "{text}");
}
