//! Findings of scenes, known and made up.

use super::*;
use core::f64::consts::PI;
use tremie_messages::Verdict;
use tremie_messages::scene::{
    BodySet, Domain, Geometry, Part, PartBoundary, Placement, Polyhedra, Polyhedron,
    PolyhedronPlacement, Pose, Shape, Sphere,
};
use tremie_messages::units::Time;

fn scene(diameter: f64, gravity: f64) -> Scene {
    let domain = Domain::new([0.0; 3], [0.012; 3], Face::WALLS);
    let sphere =
        Sphere { position: [0.006; 3], diameter, velocity: [0.0; 3], angular_velocity: [0.0; 3] };
    Scene {
        gravity: [0.0, 0.0, -gravity],
        fluid: Some(FluidMaterial::at_rest(1000.0, 1e-3)),
        bodies: vec![BodySet {
            name: "grains".into(),
            density: 2500.0,
            material: "grains".into(),
            motion: Motion::Free,
            clump: None,
            placement: Placement::Listed(vec![sphere]),
        }],
        ..Scene::empty(domain)
    }
}

fn judge(scene: &Scene, cell: f64, step: f64, quantity: &str) -> Finding {
    let own = Parameters { smagorinsky: 0.1, ..Parameters::with_cell(cell) };
    let parameters = Parameters { time_step: Some(Time(step)), ..own };
    let resolution = parameters.resolve(scene).unwrap();
    let all = findings(&parameters, scene, &resolution);
    all.into_iter().find(|finding| finding.quantity == quantity).unwrap()
}

#[test]
fn the_numbers_of_a_published_valve_are_doubted() {
    let scene = scene(0.8e-3, 9.81);
    let judge = |quantity: &str| judge(&scene, 3e-4, 1.2e-7, quantity);
    let tau = judge("relaxation time");
    assert_eq!(tau.verdict, Verdict::Doubtful);
    assert!((tau.value - 0.500004).abs() < 1e-9);
    assert!(tau.why.contains("only the turbulence model"), "{}", tau.why);
    let cells = judge("cells across the smallest sphere");
    assert_eq!(cells.verdict, Verdict::Doubtful);
    assert!((cells.value - 8.0 / 3.0).abs() < 1e-9);
    assert!(cells.remedy.contains("1e-4 m"), "{}", cells.remedy);
    assert!((judge("lattice speed").value - 2500.0).abs() < 1e-9);
}

#[test]
fn a_polyhedron_counts_as_the_sphere_of_its_volume() {
    let cube = Polyhedron {
        position: [0.006; 3],
        orientation: [0.0, 0.0, 0.0, 1.0],
        diameter: 0.6e-3,
        velocity: [0.0; 3],
        angular_velocity: [0.0; 3],
    };
    let placement = PolyhedronPlacement::Listed(vec![cube]);
    let mut scene = scene(0.8e-3, 9.81);
    scene.bodies[0].placement = Placement::Polyhedra(Polyhedra { shape: "cube".into(), placement });
    let cells = judge(&scene, 3e-4, 1.2e-7, "cells across the smallest sphere");
    assert!((cells.value - 2.0).abs() < 1e-9, "{}", cells.value);
}

/// A plate of 4 by 4 by 0.4 as large as a sphere of 2.3 cells' diameter, and a cube at the bounds.
#[test]
fn the_least_width_of_a_polyhedron_counts() {
    let width = |scale: [f64; 3], diameter: f64| {
        let mut scene = scene(0.8e-3, 9.81);
        let corners = [-1.0, 1.0].map(|x| [-1.0, 1.0].map(|y| [-1.0, 1.0].map(|z| [x, y, z])));
        let corners = corners.as_flattened().as_flattened().iter();
        let vertices = corners.map(|v| std::array::from_fn(|a| v[a] * scale[a])).collect();
        scene.shapes = vec![Shape { name: "own".into(), vertices }];
        let own = Polyhedron {
            position: [0.006; 3],
            orientation: [0.0, 0.0, 0.0, 1.0],
            diameter,
            velocity: [0.0; 3],
            angular_velocity: [0.0; 3],
        };
        let placement = PolyhedronPlacement::Listed(vec![own]);
        scene.bodies[0].placement =
            Placement::Polyhedra(Polyhedra { shape: "own".into(), placement });
        judge(&scene, 3e-4, 1.2e-7, "cells across the thinnest polyhedron")
    };
    // The diameter of the sphere of a cube's volume.
    let ball = (6.0 / PI).cbrt();
    let flake = width([1.0, 1.0, 0.1], ball * 8.0 * 3e-4 * 0.1f64.cbrt());
    assert!((flake.value - 0.8).abs() < 1e-6, "{flake:?}");
    assert_eq!(flake.verdict, Verdict::Wrong);
    for (edge, verdict) in [
        (8.0, Verdict::Ok),
        (7.9, Verdict::Doubtful),
        (2.0, Verdict::Doubtful),
        (1.9, Verdict::Wrong),
    ] {
        let cube = width([1.0; 3], ball * edge * 3e-4);
        assert!((cube.value - edge).abs() < 1e-6 && cube.verdict == verdict, "{cube:?}");
    }
}

#[test]
fn thin_parts_are_told_with_a_remedy() {
    let about = |geometry: Geometry, position: [f64; 3], motion: Motion| {
        let mut scene = scene(4e-3, 0.0);
        scene.bodies.clear();
        scene.parts = vec![Part {
            name: "own".into(),
            geometry,
            pose: Pose { position, ..Pose::IDENTITY },
            cavity: false,
            material: "wall".into(),
            motion,
            boundary: PartBoundary::Wall,
        }];
        let parameters = Parameters::with_cell(5e-4);
        let resolution = parameters.resolve(&scene).unwrap();
        let all = findings(&parameters, &scene, &resolution).into_iter();
        all.filter(|f| f.quantity.ends_with(" own")).collect::<Vec<_>>()
    };
    let middle = [6e-3, 6.1e-3, 6.2e-3];
    let wire = Geometry::Box { size: [0.4e-3, 0.4e-3, 8e-3] };
    for motion in [Motion::Fixed, Motion::Prescribed(Vec::new())] {
        let found = about(wire.clone(), middle, motion);
        let said: Vec<_> = found.iter().map(|f| (f.quantity.as_str(), f.verdict)).collect();
        assert_eq!(said, [("cells across own", Verdict::Wrong)]);
        assert!((found[0].value - 0.8).abs() < 1e-9, "{found:?}");
        assert!(found[0].remedy.contains("a cell of 5e-5 m makes it 8"), "{found:?}");
    }
    let ball = about(Geometry::Sphere { radius: 1.5e-3 }, middle, Motion::Fixed);
    assert_eq!(ball.iter().map(|f| f.verdict).collect::<Vec<_>>(), [Verdict::Doubtful]);
    let plate = Geometry::Box { size: [9e-3, 0.4e-3, 9e-3] };
    let found = about(plate, middle, Motion::Fixed);
    assert_eq!(found.iter().map(|f| f.verdict).collect::<Vec<_>>(), [Verdict::Doubtful]);
    assert_eq!(found[0].quantity, "cells through own");
    assert!(found[0].remedy.contains("a cell of 4e-4 m makes it 1"), "{found:?}");
    // A cell is enough for a wall; a sheet on the floor is the floor.
    let wall = Geometry::Box { size: [9e-3, 0.5e-3, 9e-3] };
    assert_eq!(about(wall, middle, Motion::Fixed), []);
    let floor = Geometry::Box { size: [12e-3, 12e-3, 0.4e-3] };
    assert_eq!(about(floor, [6e-3, 6e-3, 0.2e-3], Motion::Fixed), []);
}

#[test]
fn a_lattice_too_soft_for_its_grains_is_wrong() {
    // The sphere's excess weight over the floor's area, over rho c_s^2, by hand.
    let softness = 1500.0 * 9.81 * PI / 6.0 * 4e-3_f64.powi(3) / 1.44e-4;
    let at = |speed: f64| {
        let cell = 0.5e-3;
        judge(&scene(4e-3, 9.81), cell, cell / speed, "weight of the grains over lattice stiffness")
    };
    let stiff = at(1.0);
    assert!((stiff.value / (softness / (1000.0 / 3.0)) - 1.0).abs() < 1e-12);
    assert_eq!(stiff.verdict, Verdict::Ok);
    assert_eq!(at(0.25).verdict, Verdict::Wrong);
}
