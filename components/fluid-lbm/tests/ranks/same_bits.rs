//! Every bit of a lattice in shares is that of the lattice in one piece: populations, loads, balance, signals.

use crate::common::*;
use crate::story::Story;
use tremie_fluid_lbm::{Collision, Precision, Refill};
use tremie_messages::BodyState;
use tremie_messages::scene::{
    Course, Face, Geometry, Motion, OpenVelocity, Outflow, Probe, ProbeShape, Profile, Reservoir,
    Ring,
};

const CELLS: [usize; 3] = [40, 30, 60];

#[test]
fn a_fluid_that_wraps_around() {
    for (collision, precision) in [
        (Collision::Trt, Precision::F64),
        (Collision::Bgk, Precision::F32),
        (Collision::CentralMoments, Precision::F64),
    ] {
        let case = Case {
            collision,
            precision,
            smagorinsky: 0.1,
            ..Case::new(CELLS, [PERIODIC; 3], 0.52)
        };
        let story = Story::new(case);
        story.holds_for(&[3, 8]);
    }
}

#[test]
fn walls_mirrors_and_a_lid() {
    let case = Case {
        lid: (1, [0.03, 0.0, 0.01]),
        acceleration: [1e-5, 0.0, -2e-5],
        ..Case::new(CELLS, [SYMMETRY, WALL, WALL], 0.6)
    };
    let story = Story::new(case);
    story.holds_for(&[2, 4]);
}

#[test]
fn spheres_that_drift_across_the_cuts() {
    for refill in [Refill::Eqneq, Refill::Mass] {
        let case = Case { refill, average_force: true, ..Case::new(CELLS, [PERIODIC; 3], 0.53) };
        let story = Story::new(case)
            .with(4.3, [20.2, 15.1, 14.7], [0.01, 0.0, 0.07])
            .with(3.1, [22.4, 14.8, 21.9], [0.0, 0.01, -0.05])
            .with(5.2, [9.3, 9.9, 0.4], [0.02, 0.0, 0.06])
            .with(2.6, [30.5, 20.5, 44.2], [0.0, 0.03, 0.05])
            .with(2.2, [31.0, 20.0, 49.5], [0.0; 3]);
        story.holds_for(&[2, 4]);
    }
}

#[test]
fn spheres_beside_walls_and_mirrors() {
    let case = Case::new(CELLS, [WALL, SYMMETRY, WALL], 0.55);
    let story = Story::new(case)
        .with(3.3, [3.6, 15.1, 14.7], [-0.01, 0.0, 0.07])
        .with(4.1, [22.4, 1.8, 29.0], [0.0, 0.01, -0.05])
        .with(2.4, [36.9, 28.0, 44.5], [0.02, 0.0, 0.06]);
    story.holds_for(&[2, 4]);
}

/// Parts that stand still, curved, thin, and beside each other; probes of each kind; two threads in each rank.
#[test]
fn parts_that_stand_still_and_probes() {
    let case = Case {
        threads: 2,
        acceleration: [2e-5, 1e-5, 3e-5],
        ..Case::new(CELLS, [PERIODIC, WALL, PERIODIC], 0.54)
    };
    let mut scene = case.scene();
    scene.parts.push(part("ball", Geometry::Sphere { radius: 6.3 }, [20.1, 14.2, 29.6]));
    scene.parts.push(part(
        "rod",
        Geometry::Cylinder { radius: 2.4, length: 200.0 },
        [7.7, 21.3, 30.0],
    ));
    scene.parts.push(part("sheet", Geometry::Box { size: [12.0, 0.4, 21.0] }, [30.2, 8.1, 15.3]));
    let (min, max) = ([3.0, 2.0, 4.0], [38.0, 28.0, 57.0]);
    let ring = Ring { axis: 2, through: [20.0; 3], radii: [4.0, 9.0], heights: [-6.0, 12.0] };
    let shapes = [
        ProbeShape::Point([10.2, 10.4, 15.1]),
        ProbeShape::Region { min, max },
        ProbeShape::Section { axis: 0, position: 12.2, min, max },
        ProbeShape::Section { axis: 2, position: 30.3, min, max },
        ProbeShape::Profile { axis: 2, position: 44.0, min, max, along: 1, bins: 4 },
        ProbeShape::Ring(ring),
    ];
    for (number, shape) in shapes.into_iter().enumerate() {
        scene.probes.push(Probe { name: format!("probe{number}"), shape });
    }
    Story::of(scene, case).holds_for(&[2, 4]);
}

fn inlet(velocity: [f64; 3]) -> Face {
    let (profile, course) = (Profile::Parabolic, Course::default());
    Face::Velocity(OpenVelocity { velocity, profile, course })
}

fn outlet(outflow: Outflow) -> Face {
    Face::Pressure { pressure: 1e-3, course: Course::default(), outflow }
}

/// Fluid enters and leaves along each axis, through faces within a rank and through such as are cut.
#[test]
fn open_faces_along_each_axis() {
    for axis in 0..3 {
        for outflow in [Outflow::Fixed, Outflow::Absorbing, Outflow::Convective] {
            let mut faces = [WALL; 3];
            faces[(axis + 1) % 3] = PERIODIC;
            let case = Case { smagorinsky: 0.1, ..Case::new(CELLS, faces, 0.56) };
            let mut scene = case.scene();
            let mut velocity = [0.0; 3];
            velocity[axis] = 0.03;
            scene.domain.faces[axis] = [inlet(velocity), outlet(outflow)];
            let story = Story::of(scene, case).with(3.4, [20.0, 15.2, 29.7], [0.0, 0.0, 0.04]);
            story.holds_for(&[2, 4]);
        }
    }
}

/// A reservoir with a piston behind a face, with a sphere that lies across it.
#[test]
fn reservoirs_behind_faces() {
    for axis in 0..3 {
        let case = Case::new(CELLS, [WALL; 3], 0.53);
        let mut scene = case.scene();
        let area = CELLS.iter().product::<usize>() as f64 / CELLS[axis] as f64;
        let reservoir = Reservoir::new(area, 30.0 * area, 0.02);
        scene.domain.faces[axis] = [Face::Reservoir(reservoir), outlet(Outflow::Fixed)];
        let mut place = [20.0, 15.2, 29.7];
        place[axis] = 1.7;
        let mut velocity = [0.0; 3];
        velocity[axis] = 0.05;
        Story::of(scene, case).with(2.7, place, velocity).holds_for(&[2, 4]);
    }
}

/// Parts that move and turn across the cuts, with grains beside them.
#[test]
fn parts_that_move() {
    for refill in [Refill::Eqneq, Refill::Mass] {
        let case = Case { refill, ..Case::new(CELLS, [WALL, PERIODIC, PERIODIC], 0.55) };
        let mut scene = case.scene();
        for (name, geometry) in [
            ("paddle", Geometry::Box { size: [13.0, 3.2, 17.0] }),
            ("ball", Geometry::Sphere { radius: 4.2 }),
        ] {
            let mut moving = part(name, geometry, [0.0; 3]);
            moving.motion = Motion::Prescribed(Vec::new());
            scene.parts.push(moving);
        }
        let mut story = Story::of(scene, case);
        for (id, position) in [(0, [19.4, 15.3, 30.2]), (1, [8.2, 8.3, 14.6])] {
            story.events.push(added_part(id, id));
            let (velocity, angular_velocity) = ([0.0, 0.01, 0.06], [0.01, 0.004, 0.0]);
            let still = BodyState::at_rest(id, position);
            story.bodies.push(BodyState { velocity, angular_velocity, ..still });
        }
        story.with(2.3, [19.9, 20.4, 31.0], [0.0, -0.03, 0.05]).holds_for(&[2, 4]);
    }
}

/// Bodies come and go, one of them across a cut.
#[test]
fn bodies_come_and_go() {
    let case = Case { refill: Refill::Mass, ..Case::new(CELLS, [PERIODIC; 3], 0.55) };
    let mut story = Story::new(case).with(3.3, [12.0, 15.1, 14.7], [0.0, 0.0, 0.05]).with(
        2.2,
        [26.0, 12.0, 30.0],
        [0.0, 0.02, 0.0],
    );
    story.swap = vec![removed(1), added(7, 2.9)];
    story.newcomers = vec![BodyState::at_rest(7, [30.0, 22.0, 44.6])];
    story.holds_for(&[2, 4]);
}

/// Grains in a heap, closer than their cells, which shut fluid in and let it out on both sides of the cuts.
#[test]
fn grains_that_shut_cells_in() {
    let case = Case { refill: Refill::Mass, ..Case::new([24, 20, 60], [PERIODIC; 3], 0.6) };
    let mut story = Story::new(case);
    // Numbers that look random, of the golden ratio's powers.
    let part = |k: usize, which: f64| (k as f64 * which).fract();
    for k in 0..110 {
        let at = [24.0 * part(k, 0.8191725), 20.0 * part(k, 0.6710436), 60.0 * part(k, 0.5497005)];
        let velocity = [part(k, 0.331), part(k, 0.717), part(k, 0.453)].map(|v| 0.04 * (v - 0.5));
        story = story.with(2.4 + 1.9 * part(k, 0.1379), at, velocity);
    }
    story.steps = 120;
    story.holds_for(&[2, 4]);
}

/// A grain that shuts a bore as wide as a cell, and moves in it across the cut: what is behind it is fluid, though the
/// last copies do not see by what way.
#[test]
fn a_grain_in_a_bore() {
    // A layer is a block.
    let case = Case::new([64, 64, 20], [WALL, WALL, WALL], 0.55);
    let mut scene = case.scene();
    for name in ["left", "right", "front", "back"] {
        let size = match name {
            "left" | "right" => [60.0, 140.0, 16.2],
            _ => [1.0, 60.0, 16.2],
        };
        let mut block = part(name, Geometry::Box { size }, [0.0; 3]);
        block.motion = Motion::Prescribed(Vec::new());
        scene.parts.push(block);
    }
    let mut story = Story::of(scene, case);
    for (id, [x, y]) in [[1.0, 32.0], [62.0, 32.0], [31.5, 1.0], [31.5, 62.0]].iter().enumerate() {
        story.events.push(added_part(id as u64, id as u64));
        story.bodies.push(BodyState::at_rest(id as u64, [*x, *y, 10.0]));
    }
    story.steps = 90;
    story.with(0.9, [31.5, 31.5, 15.4], [0.0, 0.0, -0.1]).holds_for(&[2, 4]);
}
