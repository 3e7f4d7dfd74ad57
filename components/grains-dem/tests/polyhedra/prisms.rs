//! Prisms across plane scenes.

use crate::common::solids::*;
use crate::common::*;
use tremie_grains_dem::{GrainsDem, Parameters};
use tremie_messages::scene::{Damping, PairLaw, Plane, Polyhedron, Scene, Shape};

const DEPTH: f64 = 8e-3;
const EDGE: f64 = 4e-3;
const STIFF: f64 = 1e5;

/// A prism over an outline in x and z.
fn prism(name: &str, outline: &[[f64; 2]]) -> (Shape, f64) {
    let convex = tremie_geometry::Convex::prism(outline, 1, DEPTH).unwrap();
    let vertices = convex.vertices().iter().map(|&corner| corner.into()).collect();
    let volume = convex.moments().volume;
    (Shape { name: name.into(), vertices }, (6.0 / std::f64::consts::PI * volume).cbrt())
}

/// A plane of x and z with bars of square section.
fn plane(friction: f64, damping: Damping, bars: Vec<Polyhedron>) -> Scene {
    let mut scene = scene([40e-3, DEPTH, 40e-3], WALLS, law(STIFF, friction, damping));
    scene.domain.across = Some(1);
    let half = 0.5 * EDGE;
    scene.shapes =
        vec![prism("bar", &[[-half, -half], [half, -half], [half, half], [-half, half]]).0];
    scene.bodies = vec![solids("bar", bars)];
    scene
}

/// A bar at a place of the plane, turned about y.
fn bar(x: f64, z: f64, angle: f64, velocity: [f64; 2]) -> Polyhedron {
    let diameter = (6.0 / std::f64::consts::PI * EDGE * EDGE * DEPTH).cbrt();
    Polyhedron {
        orientation: turned([0.0, 1.0, 0.0], angle),
        ..solid([x, 0.5 * DEPTH, z], diameter, [velocity[0], 0.0, velocity[1]])
    }
}

/// A bar weighs what its section times the depth does, and lies on the floor as the law says.
#[test]
fn a_bar_lies_on_the_floor() {
    let mut scene =
        plane(0.5, Damping::Restitution(0.1), vec![bar(20e-3, 0.5 * EDGE, 0.0, [0.0; 2])]);
    scene.gravity = [0.0, 0.0, -9.81];
    let mut dem = make(&scene, 1e-6);
    dem.advance(40_000, &[]).unwrap();
    let weight = DENSITY * EDGE * EDGE * DEPTH * 9.81;
    let force = dem.face_forces()[2][0][2];
    assert!((force / -weight - 1.0).abs() < 1e-6, "{force} {weight}");
    assert_eq!(dem.face_forces()[1], [[0.0; 3]; 2], "nothing presses on the faces across");
}

/// Bars that fall on each other in all orientations, with friction: none leaves the plane, or turns
/// out of it, by anything at all, and momentum in the plane is kept.
#[test]
fn nothing_leaves_the_plane() {
    let bars = vec![
        bar(16e-3, 20e-3, 0.3, [0.5, 0.02]),
        bar(22e-3, 21e-3, 1.0, [-0.5, 0.0]),
        bar(19e-3, 26e-3, 2.0, [0.1, -0.6]),
    ];
    let scene = plane(0.4, Damping::Restitution(0.6), bars);
    let mut dem = make(&scene, 5e-7);
    let momentum = |dem: &GrainsDem| {
        state(dem)
            .iter()
            .fold([0.0; 3], |sum, body| std::array::from_fn(|a| sum[a] + body.velocity[a]))
    };
    let before = momentum(&dem);
    dem.advance(16_000, &[]).unwrap();
    let after = momentum(&dem);
    for a in [0, 2] {
        assert!((after[a] - before[a]).abs() < 1e-9, "{before:?} {after:?}");
    }
    assert!(state(&dem).iter().any(|body| body.angular_velocity[1].abs() > 10.0));
    for body in state(&dem) {
        assert_eq!((body.position[1], body.velocity[1]), (0.5 * DEPTH, 0.0));
        let (w, q) = (body.angular_velocity, body.orientation);
        assert_eq!([q[0], q[2]], [0.0; 2]);
        // The principal axes are those of the plane up to rounding.
        assert!(w[0].abs() + w[2].abs() < 1e-12 * w[1].abs().max(1.0), "{w:?}");
    }
}

/// A prism of thirty sides hits a plane head on as a cylinder does: it returns with the speed that
/// the restitution gives, and does not turn.
#[test]
fn a_prism_of_many_sides_bounces() {
    let outline: Vec<[f64; 2]> = (0..30)
        .map(|k| {
            let (s, c) = (std::f64::consts::TAU * (f64::from(k) + 0.5) / 30.0).sin_cos();
            [2e-3 * s, 2e-3 * c]
        })
        .collect();
    let (shape, diameter) = prism("bar", &outline);
    let mut scene = plane(0.4, Damping::Restitution(0.999), Vec::new());
    scene.shapes = vec![shape];
    let body = solid([20e-3, 0.5 * DEPTH, 3e-3], diameter, [0.0, 0.0, -0.2]);
    scene.bodies = vec![solids("bar", vec![body])];
    let mut dem = make(&scene, 2e-7);
    dem.advance(50_000, &[]).unwrap();
    let body = state(&dem)[0];
    assert!((body.velocity[2] / 0.2 - 1.0).abs() < 0.01, "{:?}", body.velocity);
    assert!(body.angular_velocity[1].abs() < 1e-6 && body.velocity[0].abs() < 1e-9);
}

/// Planes of a plane scene have the laws of their own material: on the slippery one a bar slides
/// away, on the rough one it stays.
#[test]
fn a_plane_has_the_law_of_its_material() {
    let slid = |friction: f64| {
        let mut scene = plane(
            0.0,
            Damping::Restitution(0.1),
            vec![bar(20e-3, 10e-3 + 0.5 * EDGE, 0.0, [0.0; 2])],
        );
        scene.planes.push(Plane {
            point: [0.0, 0.0, 10e-3],
            normal: [0.0, 0.0, 1.0],
            material: "ledge".into(),
        });
        scene.contacts.push(PairLaw {
            between: ["grains".into(), "ledge".into()],
            law: law(STIFF, friction, Damping::Restitution(0.1)),
        });
        scene.gravity = [2.0, 0.0, -9.81];
        let mut dem = make(&scene, 1e-6);
        dem.advance(30_000, &[]).unwrap();
        state(&dem)[0].position[0] - 20e-3
    };
    assert!((slid(0.0) / (0.5 * 2.0 * 0.03 * 0.03) - 1.0).abs() < 0.01, "{}", slid(0.0));
    assert!(slid(0.4).abs() < 1e-6, "{}", slid(0.4));
}

/// What is no prism across the plane is refused, with the key.
#[test]
fn only_prisms_across_the_plane_are_taken() {
    let problems = |change: &dyn Fn(&mut Scene)| {
        let mut scene =
            plane(0.4, Damping::Restitution(0.5), vec![bar(20e-3, 20e-3, 0.0, [0.0; 2])]);
        change(&mut scene);
        let all = GrainsDem::new(&scene, &Parameters::default(), 1e-6, 1).err().unwrap();
        all.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
    };
    let list = |scene: &mut Scene, change: &dyn Fn(&mut Polyhedron)| {
        let mut body = bar(20e-3, 20e-3, 0.0, [0.0; 2]);
        change(&mut body);
        scene.bodies = vec![solids("bar", vec![body])];
    };
    type Change<'a> = &'a dyn Fn(&mut Scene);
    let cases: [(Change<'_>, &str); 4] = [
        (
            &|scene| scene.shapes[0] = Shape { name: "bar".into(), ..shape("octahedron") },
            "no prism",
        ),
        (&|scene| list(scene, &|body| body.diameter *= 1.1), "deep"),
        (&|scene| list(scene, &|body| body.position[1] += 1e-3), "middle"),
        (
            &|scene| list(scene, &|body| body.orientation = turned([1.0, 0.0, 0.0], 0.1)),
            "turns about",
        ),
    ];
    for (change, words) in cases {
        let text = problems(change);
        assert!(text.contains(words), "{text}");
    }
}
