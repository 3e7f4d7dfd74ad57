//! Buoyancy of a part in a fluid at rest. It is the same for a part that is fixed or moves, and
//! that of the fluid displaced by as much of it as lies in the domain.

use crate::common::*;
use tremie_geometry::Surface;
use tremie_messages::scene::{Geometry, Motion, Part, Scene};
use tremie_messages::{BodyState, Load};

const GRAVITY: [f64; 3] = [1e-6, -2e-6, -1e-4];

/// A box with a part in it, gravity oblique.
fn scene(part: Part, faces: [tremie_messages::scene::Face; 3]) -> (Case, Scene) {
    let mut case = Case::new([20, 18, 16], faces, 0.8);
    case.gravity = GRAVITY;
    let scene = Scene { parts: vec![part], ..case.scene() };
    (case, scene)
}

/// Force and torque on the part as a fixed one, and as one that moves but is at rest.
fn loads(part: &Part, faces: &[tremie_messages::scene::Face; 3]) -> [Load; 2] {
    let (case, mut scene) = scene(part.clone(), faces.clone());
    let mut still = case.fluid_of(&scene);
    let mut on_parts = Vec::new();
    still.start(&[], &mut []).unwrap();
    still.step(&[], &mut []).unwrap();
    still.loads_on_parts(&mut on_parts);

    scene.parts[0].motion = Motion::Prescribed(Vec::new());
    let mut moving = case.fluid_of(&scene);
    let body = BodyState {
        orientation: part.pose.orientation,
        ..BodyState::at_rest(5, part.pose.position)
    };
    let mut load = [Load { id: 5, ..Load::default() }];
    moving.apply_events(&[added_part(5, 0)]).unwrap();
    moving.start(&[body], &mut load).unwrap();
    moving.step(&[body], &mut load).unwrap();
    [on_parts[0], load[0]]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Both feel a displaced volume at a place, to rounding.
fn feels(part: &Part, faces: [tremie_messages::scene::Face; 3], volume: f64, middle: [f64; 3]) {
    let arm = std::array::from_fn(|a| middle[a] - part.pose.position[a]);
    let force = GRAVITY.map(|g| -g * volume);
    let torque = cross(arm, force);
    for (load, how) in loads(part, &faces).iter().zip(["fixed", "moving"]) {
        for a in 0..3 {
            let error = [load.force[a] - force[a], load.torque[a] - torque[a]];
            assert!(
                error.iter().all(|e| e.abs() < 1e-12),
                "{how} {}: {load:?} {force:?} {torque:?}",
                part.name
            );
        }
    }
}

#[test]
fn a_fixed_part_feels_what_a_moving_one_does() {
    let sphere = Geometry::Sphere { radius: 4.6 };
    let volume = Surface::of(&sphere).unwrap().mesh().moments().volume;
    let ball = part("ball", sphere, [10.0, 9.2, 8.4]);
    feels(&ball, [WALL; 3], volume, ball.pose.position);
    // In a periodic box, across its face.
    let across = part("across", ball.geometry.clone(), [10.0, 9.2, 15.1]);
    feels(&across, [WALL, WALL, PERIODIC], volume, across.pose.position);
    // A cube that stands on the floor, as if fluid were below it.
    let cube = Geometry::Box { size: [6.0; 3] };
    let stands = part("cube", cube.clone(), [10.0, 9.0, 3.0]);
    feels(&stands, [WALL; 3], 216.0, [10.0, 9.0, 3.0]);
    // One that goes into the floor and through a side: what is inside counts.
    let cut = part("cut", cube.clone(), [1.0, 9.0, 1.5]);
    feels(&cut, [WALL; 3], 4.0 * 6.0 * 4.5, [2.0, 9.0, 2.25]);
    // One that a symmetry plane halves is whole; the weight along the plane is that of the whole.
    let half = part("half", cube, [0.0, 9.0, 1.5]);
    let [fixed, moving] = loads(&half, &[SYMMETRY, WALL, WALL]);
    assert!((fixed.force[2] - 1e-4 * 6.0 * 6.0 * 4.5).abs() < 1e-12, "{fixed:?}");
    assert!(
        (0..3).all(|a| (fixed.force[a] - moving.force[a]).abs() < 1e-12),
        "{fixed:?} {moving:?}"
    );
}

/// On a vessel its content weighs, on a body in it buoyancy acts: together the fluid's weight,
/// turned round.
#[test]
fn a_vessel_feels_the_weight_of_what_fills_it() {
    let mut vessel = part("vessel", Geometry::Box { size: [12.0, 12.0, 10.0] }, [10.0, 9.0, 8.0]);
    vessel.cavity = true;
    let (case, scene) = scene(vessel, [WALL; 3]);
    let mut fluid = case.fluid_of(&scene);
    fluid.start(&[], &mut []).unwrap();
    let mut on_parts = Vec::new();
    fluid.loads_on_parts(&mut on_parts);
    for a in 0..3 {
        assert!((on_parts[0].force[a] - GRAVITY[a] * 1440.0).abs() < 1e-12, "{on_parts:?}");
    }
    // A tube that goes on beyond the domain feels the weight across it, and nothing along it: it
    // has no ends here. Nor has a column from the floor to the ceiling.
    let mut tube = part("tube", Geometry::Box { size: [100.0, 12.0, 10.0] }, [10.0, 9.0, 8.0]);
    tube.cavity = true;
    let column = part("column", Geometry::Box { size: [3.0, 4.0, 16.0] }, [10.0, 9.0, 8.0]);
    for along in [WALL, PERIODIC] {
        let (case, mut scene) = self::scene(tube.clone(), [along, WALL, WALL]);
        let volumes = [[0.0, 2400.0, 2400.0], [-192.0, -192.0, 0.0]];
        for (part, volumes) in [tube.clone(), column.clone()].into_iter().zip(volumes) {
            scene.parts = vec![part];
            let mut fluid = case.fluid_of(&scene);
            fluid.start(&[], &mut []).unwrap();
            fluid.loads_on_parts(&mut on_parts);
            let force: [f64; 3] = std::array::from_fn(|a| GRAVITY[a] * volumes[a]);
            let error: [f64; 3] = std::array::from_fn(|a| on_parts[0].force[a] - force[a]);
            assert!(norm(error) < 1e-12, "{on_parts:?} {force:?}");
        }
    }
}

/// In a shear cell either wall feels its stress and the pressure, and their sum is nothing.
#[test]
fn each_wall_feels_its_own_force() {
    let mut case = Case::new([4, 5, 12], [PERIODIC, PERIODIC, WALL], 0.9);
    case.lid = (2, [0.01, 0.0, 0.0]);
    let mut scene = case.scene();
    scene.fluid.as_mut().unwrap().pressure = 1e-4;
    let mut fluid = case.fluid_of(&scene);
    for _ in 0..6000 {
        fluid.step(&[], &mut []).unwrap();
    }
    let forces = fluid.wall_forces();
    // The density at that pressure is 1 + 3 p.
    let stress = (1.0 + 3e-4) * case.viscosity() * 0.01 / 12.0 * 20.0;
    for (side, sign) in [(0, 1.0), (1, -1.0)] {
        let expected = [sign * stress, 0.0, -sign * 1e-4 * 20.0];
        let error: [f64; 3] = std::array::from_fn(|a| forces[2][side][a] - expected[a]);
        assert!(norm(error) < 1e-9, "{side}: {:?} {expected:?}", forces[2][side]);
    }
    assert_eq!((forces[0], forces[1]), ([[0.0; 3]; 2], [[0.0; 3]; 2]));
}

/// Mirrors feel the pressure, each on its side, whichever axes the lattice takes.
#[test]
fn each_mirror_feels_the_pressure() {
    for axis in 0..3 {
        let mut faces = [PERIODIC; 3];
        faces[axis] = SYMMETRY;
        let case = Case::new([20, 18, 16], faces, 0.8);
        let mut scene = case.scene();
        scene.fluid.as_mut().unwrap().pressure = 1e-4;
        let mut fluid = case.fluid_of(&scene);
        fluid.step(&[], &mut []).unwrap();
        let forces = fluid.wall_forces();
        let area = (20 * 18 * 16 / case.cells[axis]) as f64;
        for (side, sign) in [(0, -1.0), (1, 1.0)] {
            let mut expected = [0.0; 3];
            expected[axis] = sign * 1e-4 * area;
            let error: [f64; 3] = std::array::from_fn(|a| forces[axis][side][a] - expected[a]);
            assert!(norm(error) < 1e-12, "{axis} {side}: {:?} {expected:?}", forces[axis]);
        }
    }
}
