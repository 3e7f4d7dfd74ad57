//! Polyhedra that come to rest: on a face, in a tower, in a heap; and the same bits on any number
//! of threads.

use crate::common::solids::*;
use crate::common::*;
use tremie_grains_dem::{GrainsDem, Parameters};
use tremie_messages::body::BodyState;
use tremie_messages::scene::{
    Damping, Diameters, Geometry, Motion, MotionPoint, Packing, Part, PartBoundary, Placement,
    Polyhedra, PolyhedronPlacement, Pose, Scene,
};

const EDGE: f64 = 2e-3;

fn dropped(name: &str) -> Scene {
    let mut scene = scene([20e-3; 3], WALLS, law(2e4, 0.4, Damping::Restitution(0.4)));
    scene.gravity = [0.0, 0.0, -9.81];
    scene.shapes = vec![if name == "wedge" { wedge() } else { shape(name) }];
    let mut body = solid([10e-3, 10e-3, 6e-3], 2e-3, [0.02, 0.05, 0.0]);
    body.orientation = turned([1.0, 0.3, 0.6], 0.7);
    body.angular_velocity = [30.0, -20.0, 15.0];
    scene.bodies = vec![solids(name, vec![body])];
    scene
}

/// It tumbles, loses energy all the time, and in the end lies on a face: a normal points straight
/// down, and the centroid is as high as that face is deep.
#[test]
fn what_is_dropped_comes_to_rest_on_a_face() {
    for name in ["cube", "octahedron", "dodecahedron", "wedge", "tetrahedron"] {
        let scene = dropped(name);
        let dt = 1e-6;
        let mut dem = make(&scene, dt);
        let (mut before, first) = (whole_energy(&mut dem), whole_energy(&mut dem));
        for _ in 0..400 {
            dem.advance(1000, &[]).unwrap();
            let now = whole_energy(&mut dem);
            assert!(now < before + 1e-6 * first, "{name}: {now} {before}");
            before = now;
        }
        let body = state(&dem)[0];
        assert!(norm(body.velocity) < 1e-6, "{name}: {body:?}");
        assert!(norm(body.angular_velocity) < 1e-3, "{name}: {body:?}");
        let hull = tremie_geometry::Convex::hull(&scene.shapes[0].vertices).unwrap().unit();
        let down = |face: &&tremie_geometry::ConvexFace| {
            -to_world(body.orientation, face.normal.into())[2]
        };
        let lowest = hull.faces().iter().max_by(|a, b| down(a).total_cmp(&down(b))).unwrap();
        assert!(down(&lowest) > 1.0 - 1e-6, "{name}: {}", down(&lowest));
        let height = body.position[2] / (lowest.offset * 2e-3);
        assert!((height - 1.0).abs() < 1e-3, "{name}: {height}");
    }
}

#[test]
fn a_tower_of_three_cubes_stands() {
    let mut scene = scene([20e-3; 3], WALLS, law(1e5, 0.4, Damping::Restitution(0.3)));
    scene.gravity = [0.0, 0.0, -9.81];
    scene.shapes = vec![shape("cube")];
    // A little beside each other and turned, so that no face fits another.
    let at = |k: f64| {
        let mut body = solid(
            [10e-3 + 0.1e-3 * k, 10e-3 - 0.07e-3 * k, (k + 0.5) * 1.01 * EDGE],
            of_cube(EDGE),
            [0.0; 3],
        );
        body.orientation = turned([0.0, 0.0, 1.0], 0.2 * k);
        body
    };
    scene.bodies = vec![solids("cube", (0..3).map(|k| at(f64::from(k))).collect())];
    let mut dem = make(&scene, 1e-6);
    dem.advance(60_000, &[]).unwrap();
    let settled = state(&dem);
    dem.advance(60_000, &[]).unwrap();
    for (k, (then, now)) in settled.iter().zip(state(&dem)).enumerate() {
        let height = (k as f64 + 0.5) * EDGE;
        assert!((now.position[2] / height - 1.0).abs() < 1e-4, "{k}: {now:?}");
        assert!(norm(now.velocity) < 1e-7, "{k}: {now:?}");
        assert!(norm(minus(then.position, now.position)) < 1e-8, "{k} creeps: {then:?} {now:?}");
    }
}

fn packed_solids(name: &str, region: [[f64; 3]; 2], fraction: f64, diameter: f64) -> Placement {
    Placement::Polyhedra(Polyhedra {
        shape: name.into(),
        placement: PolyhedronPlacement::Packed(Packing {
            min: region[0],
            max: region[1],
            fraction,
            diameters: Diameters::Uniform { min: 0.9 * diameter, max: diameter },
            seed: 3,
        }),
    })
}

/// Octahedra, cubes and spheres that fall into a heap around a turning paddle, through periodic
/// sides.
fn heap(prescribed: bool) -> Scene {
    let mut scene = scene([5e-3, 5e-3, 9e-3], FLOOR, law(1e4, 0.5, Damping::Restitution(0.3)));
    // Spheres would roll for ever.
    scene.contacts.iter_mut().for_each(|pair| pair.law.rolling_friction = 0.1);
    scene.gravity = [0.0, 0.0, -30.0];
    scene.shapes = vec![shape("octahedron"), shape("cube")];
    for (k, name) in ["octahedron", "cube"].into_iter().enumerate() {
        let low = 1.2e-3 + 2.4e-3 * k as f64;
        let region = [[0.0, 0.0, low], [5e-3, 5e-3, low + 2.4e-3]];
        let mut own = solids(name, Vec::new());
        own.placement = packed_solids(name, region, 0.12, 1.2e-3);
        scene.bodies.push(own);
    }
    scene.bodies.push(packed([0.0, 0.0, 6e-3], [5e-3, 5e-3, 7.5e-3], 0.15, (1e-3, 1.1e-3), 2));
    scene.parts = vec![Part {
        name: "paddle".into(),
        geometry: Geometry::Box { size: [2e-3, 0.6e-3, 1e-3] },
        pose: Pose { position: [2.5e-3, 2.5e-3, 0.6e-3], ..Pose::IDENTITY },
        cavity: false,
        material: "wall".into(),
        motion: if prescribed {
            Motion::Prescribed(vec![MotionPoint {
                time: 0.0,
                velocity: [0.1, 0.0, 0.0],
                angular_velocity: [0.0, 0.0, 30.0],
            }])
        } else {
            Motion::Fixed
        },
        boundary: PartBoundary::Wall,
    }];
    scene
}

fn run(skin: f64, threads: usize) -> (Vec<BodyState>, [f64; 3]) {
    let parameters = Parameters { skin: Some(skin), ..Parameters::default() };
    let mut dem = GrainsDem::new(&heap(true), &parameters, 8e-7, threads).unwrap();
    for _ in 0..4 {
        dem.advance(5000, &[]).unwrap();
    }
    let seen = dem.diagnostics();
    assert!(seen.contacts > 20 && seen.list_rebuilds > 3, "{seen:?}");
    let (force, _) = dem.part_loads().next().unwrap();
    assert!(force != [0.0; 3]);
    (state(&dem), force)
}

#[test]
fn threads_and_skin_do_not_enter_the_arithmetic() {
    let one = run(0.1, 1);
    for (skin, threads) in [(0.1, 3), (0.05, 1), (0.17, 2)] {
        assert_eq!(one, run(skin, threads), "{skin} {threads}");
    }
}

/// A heap around a post settles, its energy never grows, and nothing lies in anything else.
#[test]
fn a_heap_settles() {
    let mut dem = GrainsDem::new(&heap(false), &Parameters::default(), 8e-7, 2).unwrap();
    let first = whole_energy(&mut dem);
    let mut before = first;
    for _ in 0..8 {
        dem.advance(6_000, &[]).unwrap();
        let now = whole_energy(&mut dem);
        assert!(now < before + 1e-6 * first, "{now} {before}");
        before = now;
    }
    let seen = dem.diagnostics();
    assert!(seen.kinetic_energy + seen.rotational_energy < 1e-2 * first, "{seen:?}");
    assert!(seen.max_overlap_ratio < 0.2, "{seen:?}");
}
