//! Bodies that are pieces of a union displace their shares of it.

use std::f64::consts::PI;
use tremie_fluid_lbm::{LbmFluid, Parameters};
use tremie_geometry::clump;
use tremie_messages::scene::{
    BodySet, Domain, Face, FluidMaterial, Motion, Placement, Scene, Sphere,
};
use tremie_messages::{BodyEvent, BodyState, Load};

const R: f64 = 3e-3;
const S: f64 = 2e-3;
const APART: f64 = 2.5e-3;

/// Two spheres of a clump along x, in a box whose longest side is along an axis.
fn scene(long: usize, unions: &[&str]) -> Scene {
    let mut max = [16e-3; 3];
    max[long] = 32e-3;
    let ball = |x: f64, radius: f64| Sphere {
        position: [x, 8e-3, 8e-3],
        diameter: 2.0 * radius,
        velocity: [0.0; 3],
        angular_velocity: [0.0; 3],
    };
    let set = BodySet {
        name: "pair".into(),
        density: 2500.0,
        material: "pair".into(),
        motion: Motion::Free,
        clump: Some("pair".into()),
        placement: Placement::Listed(vec![ball(8e-3, R), ball(8e-3 + APART, S)]),
    };
    Scene {
        gravity: [0.0, 0.0, -10.0],
        fluid: Some(FluidMaterial::at_rest(1000.0, 0.1)),
        bodies: vec![set],
        unions: unions.iter().map(|name| name.to_string()).collect(),
        ..Scene::empty(Domain::new([0.0; 3], max, Face::WALLS))
    }
}

/// Loads at rest on both, turned by an angle about z.
fn loads(scene: &Scene, angle: f64) -> (Vec<BodyState>, Vec<Load>) {
    let mut fluid = LbmFluid::new(scene, &Parameters::with_cell(1e-3), 1e-4, 1).unwrap();
    let event = |id: u64, radius: f64| BodyEvent {
        id,
        kind: BodyEvent::ADDED,
        shape: BodyEvent::SPHERE,
        motion: BodyEvent::FREE,
        set: 0,
        mass: 1e-3,
        size: [radius, 0.0, 0.0],
        table: 0,
    };
    fluid.apply_events(&[event(0, R), event(1, S)]).unwrap();
    let upright = [8e-3, 8e-3 + APART].map(|x| [x, 8e-3, 8e-3]);
    let mut states: Vec<_> = (0..).zip(upright).map(|(id, x)| BodyState::at_rest(id, x)).collect();
    let mut loads = vec![Load::default(); 2];
    for (load, state) in loads.iter_mut().zip(&states) {
        load.id = state.id;
    }
    fluid.start(&states, &mut loads).unwrap();
    if angle != 0.0 {
        let (s, c) = (0.5 * angle).sin_cos();
        states[1].position = [8e-3 + APART * angle.cos(), 8e-3 + APART * angle.sin(), 8e-3];
        states.iter_mut().for_each(|state| state.orientation = [0.0, 0.0, s, c]);
        // Enough steps for what the turn stirs to die down beside buoyancy.
        for _ in 0..400 {
            fluid.step(&states, &mut loads).unwrap();
        }
    }
    (states, loads)
}

/// The volume of the union by its lens, and where its centroid is from the first sphere, by
/// symmetric caps.
fn union() -> (f64, f64) {
    let ball = |r: f64| 4.0 / 3.0 * PI * r * r * r;
    let plane = (APART * APART + R * R - S * S) / (2.0 * APART);
    let cap = |r: f64, at: f64| {
        let h = r - at;
        let volume = PI / 3.0 * h * h * (3.0 * r - h);
        (volume, 0.25 * PI * (r * r - at * at).powi(2))
    };
    let (one, other) = (cap(R, plane), cap(S, APART - plane));
    let lens = one.0 + other.0;
    let moment = one.1 + other.0 * APART - other.1;
    let volume = ball(R) + ball(S) - lens;
    (volume, (ball(S) * APART - moment) / volume)
}

/// Buoyancy is that of the union, and acts where its centroid is, however the lattice lies and the
/// pair is turned; else it is that of both spheres, where they are.
#[test]
fn a_union_is_lifted_by_what_it_displaces() {
    let (volume, middle) = union();
    for long in 0..3 {
        for (angle, tolerance) in [(0.0, 1e-9), (0.7, 2e-3)] {
            let (states, loads) = loads(&scene(long, &["pair"]), angle);
            let lift: f64 = loads.iter().map(|load| load.force[2]).sum();
            assert!((lift / (1e4 * volume) - 1.0).abs() < tolerance, "{long} {angle}: {lift}");
            // About the first centre: x along the pair.
            let mut torque = [0.0; 2];
            for (state, load) in states.iter().zip(&loads) {
                let arm = [state.position[0] - 8e-3, state.position[1] - 8e-3];
                torque[0] += load.torque[0] + arm[1] * load.force[2];
                torque[1] += load.torque[1] - arm[0] * load.force[2];
            }
            let expected = [middle * angle.sin() * lift, -middle * angle.cos() * lift];
            let error = (torque[0] - expected[0]).hypot(torque[1] - expected[1]);
            assert!(
                error < (tolerance + 1e-9) * middle * lift,
                "{long} {angle}: {torque:?} {expected:?}"
            );
        }
    }
    let (_, loads) = loads(&scene(0, &[]), 0.0);
    let both = 4.0 / 3.0 * PI * (R * R * R + S * S * S);
    let lift: f64 = loads.iter().map(|load| load.force[2]).sum();
    assert!((lift / (1e4 * both) - 1.0).abs() < 1e-12, "{lift}");
    let shares: f64 = clump(&scene(0, &["pair"]), "pair").iter().map(|p| p.share.volume).sum();
    assert!((shares / volume - 1.0).abs() < 1e-12);
}
