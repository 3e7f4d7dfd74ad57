//! A face with a given velocity delivers what it is told to, whatever stands beside or in it.

use crate::common::*;
use std::f64::consts::PI;
use tremie_fluid_lbm::{LbmFluid, OpenFaces, Walls};
use tremie_messages::scene::{
    Course, Face, Geometry, OpenVelocity, Outflow, Probe, ProbeShape, Profile, Scene, Sine,
};

const SPEED: f64 = 1e-3;
const LENGTH: usize = 14;

fn inflow(velocity: [f64; 3], profile: Profile) -> Face {
    Face::Velocity(OpenVelocity { velocity, profile, course: Course::default() })
}

const OUTLET: Face =
    Face::Pressure { pressure: 0.0, course: Course::Points(Vec::new()), outflow: Outflow::Fixed };

/// Volume that passes the middle of the channel in a step.
fn rate(fluid: &LbmFluid, axis: usize) -> f64 {
    let middle = cells(fluid).filter(|cell| cell[axis] == LENGTH / 2);
    middle.map(|cell| fluid.velocity_at(cell)[axis]).sum()
}

/// A duct along x, `across` cells wide and high, with what stands in it.
fn duct(across: [usize; 2], scheme: OpenFaces, profile: Profile) -> (Case, Scene) {
    let mut case = Case::new([LENGTH, across[0], across[1]], [WALL; 3], 0.9);
    case.open_faces = scheme;
    let mut scene = case.scene();
    scene.domain.faces[0] = [inflow([SPEED, 0.0, 0.0], profile), OUTLET];
    (case, scene)
}

fn delivered(case: &Case, scene: &Scene, steps: usize) -> f64 {
    let mut fluid = case.fluid_of(scene);
    for _ in 0..steps {
        fluid.step(&[], &mut []).unwrap();
    }
    rate(&fluid, 0)
}

/// A uniform velocity and a parabola, which is worth 4/9 of it over a square: within 0.05 %. Half a
/// per cent to five were lost beside the walls.
#[test]
fn a_face_between_walls_delivers_what_it_is_told() {
    for scheme in [OpenFaces::Nee, OpenFaces::Nebb] {
        for (profile, worth) in [(Profile::Uniform, 1.0), (Profile::Parabolic, 4.0 / 9.0)] {
            for across in [[9, 9], [12, 8]] {
                let (case, scene) = duct(across, scheme, profile);
                let asked = SPEED * worth * (across[0] * across[1]) as f64;
                let error = delivered(&case, &scene, 2500) / asked - 1.0;
                assert!(error.abs() < 5e-4, "{scheme:?} {profile:?} {across:?}: {error}");
            }
        }
    }
}

/// Walls of parts that stand where they like between the centres of cells: the area counts up to
/// them, or up to half-way where walls are taken so. The flow through the middle is the prescribed
/// one within 1 %, or 0.05 % half-way.
#[test]
fn walls_of_parts_in_the_face_bound_its_area() {
    for (walls, scheme) in [
        (Walls::Bouzidi, OpenFaces::Nee),
        (Walls::Bouzidi, OpenFaces::Nebb),
        (Walls::Halfway, OpenFaces::Nee),
    ] {
        for shift in [0.1, 0.35, 0.6, 0.9] {
            let (mut case, mut scene) = duct([12, 3], scheme, Profile::Uniform);
            case.walls = walls;
            scene.domain.faces[2] = [PERIODIC, PERIODIC];
            // A slab from below y = 0 to 1 + shift.
            let slab = Geometry::Box { size: [100.0, 4.0, 100.0] };
            scene.parts = vec![part("slab", slab, [7.0, shift - 1.0, 1.5])];
            let (height, bound) = match walls {
                Walls::Bouzidi => (11.0 - shift, 1e-2),
                Walls::Halfway => (11.0 - shift.round(), 5e-4),
            };
            let mut fluid = case.fluid_of(&scene);
            for _ in 0..3000 {
                fluid.step(&[], &mut []).unwrap();
            }
            let error = rate(&fluid, 0) / (SPEED * 3.0 * height) - 1.0;
            println!("{walls:?} {scheme:?} {shift}: {error:.1e}");
            assert!(error.abs() < bound, "{walls:?} {scheme:?} {shift}: {error}");
        }
    }
}

/// A round rod through the face leaves the area beside it: what crosses the middle is that within
/// 0.2 %, and the sum of the cells' velocities within 1 %; and a face through which fluid is drawn
/// out takes as much as the other gives: the mass stays.
#[test]
fn a_rod_in_the_face_and_a_face_that_draws() {
    let radius = 2.3;
    let (case, mut scene) = duct([11, 11], OpenFaces::Nee, Profile::Uniform);
    let rod = Geometry::Cylinder { radius, length: 100.0 };
    let mut rod = part("rod", rod, [7.0, 5.4, 5.6]);
    rod.pose.orientation = [0.0, 0.5f64.sqrt(), 0.0, 0.5f64.sqrt()];
    scene.parts = vec![rod];
    let (min, max) = ([0.0; 3], [LENGTH as f64, 11.0, 11.0]);
    let position = 0.5 * LENGTH as f64 + 0.5;
    let shape = ProbeShape::Section { axis: 0, position, min, max };
    scene.probes.push(Probe { name: "middle".into(), shape });
    let mut fluid = case.fluid_of(&scene);
    (0..2500).for_each(|_| fluid.step(&[], &mut []).unwrap());
    fluid.restart_means();
    fluid.step(&[], &mut []).unwrap();
    let mut found = Vec::new();
    fluid.probes(&mut found);
    let [_, pressure, crossing] = found[..] else { panic!("{found:?}") };
    let asked = SPEED * (121.0 - PI * radius * radius);
    let errors =
        [crossing / (1.0 + 3.0 * pressure), rate(&fluid, 0)].map(|rate| rate / asked - 1.0);
    println!("rod: {errors:?}");
    assert!(errors[0].abs() < 2e-3 && errors[1].abs() < 1e-2, "{errors:?}");

    let (case, mut scene) = duct([9, 9], OpenFaces::Nee, Profile::Uniform);
    scene.domain.faces[0][1] = inflow([SPEED, 0.0, 0.0], Profile::Uniform);
    let mut fluid = case.fluid_of(&scene);
    let mut masses = Vec::new();
    for step in 0..4000 {
        fluid.step(&[], &mut []).unwrap();
        if step % 1000 == 999 {
            masses.push(fluid.ledger().mass);
        }
    }
    let error = rate(&fluid, 0) / (81.0 * SPEED) - 1.0;
    assert!(error.abs() < 5e-4, "{error}");
    let drift = (masses[3] - masses[2]) / (1000.0 * 81.0 * SPEED);
    assert!(drift.abs() < 1e-6, "{masses:?}");
}

/// The factor follows from what enters, whichever way it goes: a face whose flow turns round
/// delivers both ways.
#[test]
fn a_face_that_breathes_delivers_both_ways() {
    let (case, mut scene) = duct([9, 9], OpenFaces::Nee, Profile::Uniform);
    let period = 2000.0;
    let sine = Sine::new(1.0 / period);
    let Face::Velocity(open) = &mut scene.domain.faces[0][0] else { panic!() };
    open.course = Course::Sine(sine);
    let mut fluid = case.fluid_of(&scene);
    let mut squares = [0.0f64; 2];
    for step in 0..8000 {
        fluid.step(&[], &mut []).unwrap();
        if step >= 4000 {
            let asked = SPEED * 81.0 * (2.0 * PI * f64::from(step + 1) / period).sin();
            squares[0] += asked * asked;
            squares[1] += rate(&fluid, 0).powi(2);
        }
    }
    // A column that swings before an open end: its velocity grows towards that as the cosine of the
    // distance.
    let wave = 2.0 * PI / period * 3f64.sqrt();
    let grows = (wave * 0.5 * LENGTH as f64).cos() / (wave * LENGTH as f64).cos();
    let error = (squares[1] / squares[0]).sqrt() / grows - 1.0;
    assert!(error.abs() < 5e-4, "{error}");
}
