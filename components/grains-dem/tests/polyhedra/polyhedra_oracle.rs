//! Hulls of polyhedra, and times of their collisions, against another library: parry3d.

use crate::common::{solids::*, *};
use parry3d_f64::{
    math::{Pose, Rotation, Vector},
    query::{ShapeCastOptions, cast_shapes},
    shape::{ConvexPolyhedron, Shape as _},
};
use proptest::prelude::*;
use tremie_geometry::Convex;
use tremie_messages::scene::{Damping, Scene, Shape};

const SIZE: f64 = 2e-3;

fn some_shape() -> impl Strategy<Value = Shape> {
    let names = ["tetrahedron", "cube", "octahedron", "dodecahedron", "icosahedron", "wedge"];
    prop::sample::select(names.to_vec())
        .prop_map(|name| if name == "wedge" { wedge() } else { shape(name) })
}

fn some_turn() -> impl Strategy<Value = [f64; 4]> {
    (prop::array::uniform3(-1.0..1.0f64), 0.1..3.0f64)
        .prop_filter("an axis", |(axis, _)| norm(*axis) > 0.1)
        .prop_map(|(axis, angle)| turned(axis, angle))
}

/// The corners at the size of a body, from its centroid.
fn corners(shape: &Shape) -> Vec<Vector> {
    let unit = Convex::hull(&shape.vertices).unwrap().unit();
    unit.vertices().iter().map(|v| Vector::from_array((v * SIZE).into())).collect()
}

fn pose(at: [f64; 3], q: [f64; 4]) -> Pose {
    Pose::from_parts(Vector::from_array(at), Rotation::from_array(q))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Mass and centroid are those of the hull.
    #[test]
    fn a_body_is_as_heavy_as_its_hull(own in some_shape()) {
        let hull = ConvexPolyhedron::from_convex_hull(&corners(&own)).unwrap();
        let properties = hull.mass_properties(DENSITY);
        prop_assert!((properties.mass() / mass(SIZE) - 1.0).abs() < 1e-12);
        prop_assert!(properties.local_com.length() < 1e-14);
        let convex = Convex::hull(&own.vertices).unwrap().unit();
        let (ours, _) = tremie_geometry::principal(&convex.moments().inertia);
        let mut ours = ours.map(|moment| moment * DENSITY * SIZE.powi(5));
        let mut theirs = properties.principal_inertia().to_array();
        ours.sort_by(f64::total_cmp);
        theirs.sort_by(f64::total_cmp);
        for (a, b) in ours.into_iter().zip(theirs) {
            prop_assert!((a / b - 1.0).abs() < 1e-9, "{} {}", a, b);
        }
    }

    /// One flies at another, not turning: the first contact is when a search says that they meet.
    #[test]
    fn bodies_meet_when_a_search_says_so(
        shapes in (some_shape(), some_shape()),
        turns in (some_turn(), some_turn()),
        way in prop::array::uniform3(-1.0..1.0f64),
        aside in prop::array::uniform2(-0.1..0.1f64),
    ) {
        prop_assume!(norm(way) > 0.3);
        let (speed, gap, step) = (1.0, 2.2 * SIZE, 1e-6);
        let along = way.map(|x| x / norm(way));
        let other = if along[0].abs() < 0.8 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        let (u, target) = (cross(along, other), [20e-3; 3]);
        let v = cross(along, u);
        let from: [f64; 3] = std::array::from_fn(|a| {
            target[a] - gap * along[a] + SIZE * (aside[0] * u[a] + aside[1] * v[a])
        });
        let velocity = along.map(|x| x * speed);

        let hulls = [&shapes.0, &shapes.1].map(|s| ConvexPolyhedron::from_convex_hull(&corners(s)).unwrap());
        let hit = cast_shapes(
            &pose(from, turns.0), Vector::from_array(velocity), &hulls[0],
            &pose(target, turns.1), Vector::ZERO, &hulls[1],
            ShapeCastOptions::with_max_time_of_impact(1.0),
        );
        let expected = hit.unwrap().expect("they are aimed at each other").time_of_impact;

        let mut scene: Scene = scene([40e-3; 3], WALLS, law(1e4, 0.0, Damping::Restitution(1.0)));
        let first = Shape { name: "first".into(), ..shapes.0 };
        let second = Shape { name: "second".into(), ..shapes.1 };
        scene.shapes = vec![first, second];
        let mut bodies = [solid(from, SIZE, velocity), solid(target, SIZE, [0.0; 3])];
        (bodies[0].orientation, bodies[1].orientation) = turns;
        let [a, b] = bodies;
        scene.bodies = vec![solids("first", vec![a]), solids("second", vec![b])];
        let mut dem = make(&scene, step);
        let mut steps = 0;
        while dem.diagnostics().contacts == 0 {
            dem.advance(1, &[]).unwrap();
            steps += 1;
            prop_assert!(steps < 10_000, "they never met, expected at {expected}");
        }
        let found = f64::from(steps) * step;
        prop_assert!((-0.01 * step..1.01 * step).contains(&(found - expected)), "{} {}", found, expected);
    }
}
