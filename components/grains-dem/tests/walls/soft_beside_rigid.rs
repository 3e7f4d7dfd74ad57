//! A wall is one wall also where a surface that deforms stands flush with a part, a plane or a face
//! of the domain.

use crate::common::walls::*;
use crate::common::*;
use tremie_grains_dem::{DeformableSurface, FacetLoad, GrainsDem, Parameters, SurfaceState};
use tremie_messages::{
    body::BodyState,
    scene::{Damping, Motion, Part, Plane, Scene, Slider, SliderSpring},
};

/// Diameter, stiffness, and the step at 50 to a contact.
const D: f64 = 4e-3;
const K: f64 = 500.0;
const DT: f64 = 2.5e-5;

/// Carrier of the surfaces, far above; weight does not move it.
fn carrier() -> Part {
    let mut part = block([15.0, 15.0, 30.0], [25.0, 25.0, 35.0]);
    part.motion = Motion::Slider(Box::new(Slider {
        axis: [1.0, 0.0, 0.0],
        mass: 1.0,
        lift: 0.0,
        velocity: 0.0,
        spring: SliderSpring::None,
        force: 0.0,
        stops: None,
    }));
    part
}

/// Result of a run: the sphere, the deepest overlap over the radius, and the impulse on all
/// surfaces [N s].
struct Bounced {
    ball: BodyState,
    deepest: f64,
    impulse: [f64; 3],
}

/// Moves a sphere beside surfaces that stay as they are; trials of other shapes come between.
fn run(mut scene: Scene, ball: BodyState, surfaces: &[DeformableSurface], steps: u32) -> Bounced {
    let mut sphere = sphere(ball.position, D, ball.velocity);
    sphere.angular_velocity = ball.angular_velocity;
    scene.bodies = vec![set(Motion::Free, vec![sphere])];
    if surfaces.is_empty() {
        let mut dem = make(&scene, DT);
        dem.advance(steps, &[]).unwrap();
        let deepest = dem.diagnostics().max_overlap_ratio;
        return Bounced { ball: state(&dem)[0], deepest, impulse: [0.0; 3] };
    }
    scene.parts.insert(0, carrier());
    let parameters = Parameters::default();
    let mut dem = GrainsDem::with_surfaces(&scene, &parameters, DT, 1, surfaces).unwrap();
    let mut loads: Vec<FacetLoad> = Vec::new();
    let mut impulse = [0.0; 3];
    let rest: Vec<_> = surfaces.iter().map(|s| vec![[0.0; 3]; s.vertices.len()]).collect();
    dem.begin_window(steps, &[]).unwrap();
    for step in 0..steps {
        dem.begin_substep().unwrap();
        for (number, surface) in surfaces.iter().enumerate() {
            if step % 3 == 0 {
                let off = surface.vertices.iter().map(|&[x, y, z]| [x, y, z - 2e-5]);
                let off: Vec<_> = off.collect();
                dem.contact_on_surface(number, &off, &rest[number], &mut loads).unwrap();
            }
            let vertices = &surface.vertices;
            dem.contact_on_surface(number, vertices, &rest[number], &mut loads).unwrap();
            for (sum, force) in impulse.iter_mut().zip(sum(&loads)) {
                *sum += DT * force;
            }
        }
        let states: Vec<_> = surfaces
            .iter()
            .zip(&rest)
            .map(|(surface, velocities)| SurfaceState {
                vertices: &surface.vertices,
                velocities,
                carrier_force: [0.0; 3],
            })
            .collect();
        dem.finish_substep(&states).unwrap();
    }
    dem.end_window().unwrap();
    Bounced { ball: state(&dem)[0], deepest: dem.diagnostics().max_overlap_ratio, impulse }
}

fn sum(loads: &[FacetLoad]) -> [f64; 3] {
    loads.iter().fold([0.0; 3], |all, load| std::array::from_fn(|a| all[a] + load.force[a]))
}

type Floor = (&'static str, Vec<Part>, Vec<Plane>, Vec<DeformableSurface>);

/// Ways to make a floor at the height `TOP` of rubber and rigid walls, with seams through the
/// middle.
fn floors() -> Vec<Floor> {
    let left = block([-2.0, -2.0, 0.0], [20.0, 42.0, 10.0]);
    let front = block([20.0, -2.0, 0.0], [42.0, 20.0, 10.0]);
    let right = |cuts| rubber([20.0, -2.0, 0.0], [42.0, 42.0, 10.0], cuts);
    let back = rubber([20.0, 20.0, 0.0], [42.0, 42.0, 10.0], 5);
    let sunk = |cuts| rubber([20.0, -2.0, 3.0], [42.0, 42.0, 10.0], cuts);
    let proud = block([-2.0, -2.0, 0.0], [20.0, 42.0, 10.0 - 1e-5]);
    vec![
        ("a part and rubber", vec![left.clone()], vec![], vec![right(1)]),
        ("a part and rubber of many facets", vec![left.clone()], vec![], vec![right(9)]),
        ("two parts and rubber", vec![left, front], vec![], vec![back]),
        ("a plane and rubber", vec![], vec![floor(TOP)], vec![sunk(3)]),
        ("a part that is 1e-8 m lower", vec![proud], vec![], vec![right(2)]),
        (
            "two of rubber and a plane",
            vec![],
            vec![floor(TOP)],
            vec![rubber([-2.0, -2.0, 3.0], [20.0, 42.0, 10.0], 2), sunk(4)],
        ),
    ]
}

fn room(friction: f64) -> Scene {
    scene([40e-3; 3], WALLS, law(K, friction, Damping::Restitution(0.5)))
}

fn ball(at: [f64; 2], velocity: [f64; 3]) -> BodyState {
    let angular_velocity = [40.0, -60.0, 30.0];
    let position = [at[0], at[1], TOP + 0.51 * D];
    BodyState { velocity, angular_velocity, ..BodyState::at_rest(0, position) }
}

/// On the seam and beside it, straight down and aslant: as on one plane.
#[test]
fn rubber_flush_with_rigid_walls_is_one_wall_with_them() {
    for (at, velocity, friction) in [
        ([20e-3, 20e-3], [0.0, 0.0, -1.0], 0.3),
        ([20.5e-3, 20e-3], [0.0, 0.0, -1.0], 0.3),
        ([19.5e-3, 20.2e-3], [0.0, 0.0, -1.0], 0.3),
        ([19.9e-3, 20.3e-3], [0.4, -0.2, -0.7], 0.3),
        ([19.3e-3, 19.8e-3], [1.0, 0.3, -0.2], 0.0),
    ] {
        let start = ball(at, velocity);
        let mut plain = room(friction);
        plain.planes = vec![floor(TOP)];
        let expected = run(plain, start, &[], 200);
        assert!(expected.ball.velocity[2] > 0.45 * -velocity[2]);
        for (what, parts, planes, surfaces) in floors() {
            let mut scene = room(friction);
            (scene.parts, scene.planes) = (parts, planes);
            let found = run(scene, start, &surfaces, 200);
            let speed = norm(minus(found.ball.velocity, expected.ball.velocity));
            let spin = norm(minus(found.ball.angular_velocity, expected.ball.angular_velocity));
            let bound = if what.contains("lower") { 1e-4 } else { 1e-6 };
            assert!(speed < bound && 0.5 * D * spin < bound, "{what} {at:?}: {speed} {spin}");
            let deeper = found.deepest - expected.deepest;
            assert!(deeper.abs() < 0.1 * bound, "{what} {at:?}: {deeper}");
        }
    }
}

/// Half a millimetre beside the seam, above the rubber, it goes straight back up, and the rubber
/// gets all that it loses.
#[test]
fn above_the_rubber_all_the_force_is_on_it() {
    for (what, parts, planes, surfaces) in floors() {
        let mut scene = room(0.3);
        (scene.parts, scene.planes) = (parts, planes);
        let start = BodyState {
            velocity: [0.0, 0.0, -1.0],
            ..BodyState::at_rest(0, [20.5e-3, 20.5e-3, TOP + 0.51 * D])
        };
        let found = run(scene, start, &surfaces, 200);
        let v = found.ball.velocity;
        assert!((v[2] - 0.49).abs() < 0.01, "{what}: {v:?}");
        assert!(v[0].abs() + v[1].abs() < 1e-9, "{what}: {v:?}");
        // With a plane that is as high either may have it.
        if !what.contains("plane") {
            let lost = mass(D) * (v[2] + 1.0);
            assert!((found.impulse[2] / -lost - 1.0).abs() < 1e-9, "{what}: {:?}", found.impulse);
        }
    }
}

/// Friction and rolling friction go on from metal to rubber and back: a sphere rolls, spins and
/// comes to rest as on a plane.
#[test]
fn a_sphere_rolls_from_metal_to_rubber_as_over_one() {
    let room = || {
        let mut scene = room(0.5);
        scene.gravity = [0.0, 0.0, -9.81];
        for pair in &mut scene.contacts {
            pair.law.rolling_friction = 0.02;
        }
        scene
    };
    for (from, along) in [(15e-3, 0.12), (25e-3, -0.12)] {
        let mut start = ball([from, 18e-3], [along, 0.03, 0.0]);
        start.position[2] = TOP + 0.5 * D;
        start.angular_velocity = [0.0, 80.0 * along.signum(), 30.0];
        let mut plain = room();
        plain.planes = vec![floor(TOP)];
        let expected = run(plain, start, &[], 7_000).ball;
        let past = (expected.position[0] - 20e-3) / (from - 20e-3);
        assert!(past < -1.0, "it rolls across: {expected:?}");
        for (what, parts, planes, surfaces) in floors() {
            let mut scene = room();
            (scene.parts, scene.planes) = (parts, planes);
            let found = run(scene, start, &surfaces, 7_000).ball;
            let error = norm(minus(found.position, expected.position));
            let bound = if what.contains("lower") { 1e-3 } else { 1e-6 };
            assert!(error < bound * D, "{what}: {error} {found:?} {expected:?}");
        }
    }
}
