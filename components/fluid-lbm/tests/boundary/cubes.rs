//! Links that sharp edges and thin walls cut between two cells of the fluid: the same solid is the
//! same to the fluid as a body, a part that moves and a part that stands still, and a cube's Stokes
//! drag is right wherever it is and however it is turned.

use crate::common::*;
use std::f64::consts::PI;
use tremie_fluid_lbm::{LbmFluid, Ledger, Parameters};
use tremie_messages::scene::{Course, Geometry, Motion, Part, PartBoundary, Scene, Shape};
use tremie_messages::{BodyEvent, BodyState};

/// A solid in a periodic box, whose fluid is accelerated.
struct Held {
    case: Case,
    part: Part,
    part_step: f64,
    /// Velocity and angular velocity; both are set back each step.
    velocity: [f64; 3],
    angular_velocity: [f64; 3],
}

/// Kind of the cube in the fluid.
#[derive(Clone, Copy, Debug, PartialEq)]
enum As {
    Fixed,
    Moving,
    Body,
}

impl Held {
    fn new(n: [usize; 3], size: [f64; 3], position: [f64; 3], turn: [f64; 4]) -> Self {
        let mut case = Case::new(n, [PERIODIC; 3], 0.8);
        case.acceleration = [1e-7, 2e-8, -1e-8];
        let mut part = part("solid", Geometry::Box { size }, position);
        let length = turn.iter().map(|x| x * x).sum::<f64>().sqrt();
        part.pose.orientation = turn.map(|x| x / length);
        let part_step = case.parameters().part_step;
        let [velocity, angular_velocity] = [[0.0; 3]; 2];
        Self { case, part, part_step, velocity, angular_velocity }
    }

    fn scene(&self, kind: As) -> Scene {
        let mut scene = self.case.scene();
        let mut part = self.part.clone();
        match kind {
            // Whose links pay nothing back, as those of bodies do not with this refill.
            As::Fixed => {
                part.boundary =
                    PartBoundary::Velocity { velocity: [0.0; 3], course: Course::default() }
            }
            As::Moving => part.motion = Motion::Prescribed(Vec::new()),
            As::Body => {
                let corner =
                    |k: usize| std::array::from_fn(|a| if k >> a & 1 == 1 { 1.0 } else { -1.0 });
                let vertices = (0..8).map(corner).collect();
                scene.shapes.push(Shape { name: "cube".into(), vertices });
                return scene;
            }
        }
        scene.parts.push(part);
        scene
    }

    /// Momentum of the fluid and force on the solid, every `every` steps, as long as `goes_on` with
    /// the ledger.
    fn run(
        &self,
        kind: As,
        every: usize,
        mut goes_on: impl FnMut(&Ledger) -> bool,
    ) -> [[f64; 3]; 2] {
        let parameters = Parameters { part_step: self.part_step, ..self.case.parameters() };
        let (threads, variant) = (self.case.threads, self.case.variant);
        let scene = self.scene(kind);
        let mut fluid = LbmFluid::with_variant(&scene, &parameters, 1.0, threads, variant).unwrap();
        let Part { pose, geometry, .. } = &self.part;
        let mut bodies = Vec::new();
        if kind != As::Fixed {
            bodies.push(BodyState {
                id: 1,
                position: pose.position,
                orientation: pose.orientation,
                velocity: self.velocity,
                angular_velocity: self.angular_velocity,
            });
            let Geometry::Box { size } = geometry else { panic!("{geometry:?}") };
            let size = [0.5 * 3f64.sqrt() * size[0], size[0] / (PI / 6.0).cbrt(), 0.0];
            let event = match kind {
                As::Body => BodyEvent { shape: BodyEvent::POLYHEDRON, size, ..added(1, 0.0) },
                _ => added_part(1, 0),
            };
            fluid.apply_events(&[event]).unwrap();
        }
        let mut loads = loads_of(&bodies);
        fluid.start(&bodies, &mut loads).unwrap();
        loop {
            for _ in 0..every {
                fluid.step(&bodies, &mut loads).unwrap();
            }
            closes(&fluid, 1e-12);
            let ledger = fluid.ledger();
            if !goes_on(&ledger) {
                // A body's load holds what the pressure would give that drives the fluid.
                let Geometry::Box { size } = geometry else { panic!("{geometry:?}") };
                let volume: f64 = size.iter().product();
                let force = match kind {
                    As::Fixed => ledger.parts.map(|f| -f),
                    _ => std::array::from_fn(|a| {
                        loads[0].force[a] - volume * self.case.acceleration[a]
                    }),
                };
                return [ledger.momentum, force];
            }
        }
    }
}

/// Cubes of any placement and turn, plates and rods thinner than a cell, along the axes and
/// slanted: a part that stands still, one that moves and a body agree to rounding, in the fluid's
/// momentum and in the force.
#[test]
fn a_solid_is_the_same_whatever_it_is() {
    let upright = [0.0, 0.0, 0.0, 1.0];
    let cases = [
        ([6.45; 3], [10.0; 3], upright),
        ([6.45; 3], [10.21, 10.37, 9.94], upright),
        ([6.9; 3], [10.02, 10.0, 9.98], [0.0, 0.0, 0.38, 0.92]),
        ([5.3; 3], [10.3, 9.7, 10.1], [0.3, -0.5, 0.2, 0.8]),
        ([6.2, 5.8, 0.4], [10.0, 10.1, 10.0], upright),
        ([6.2, 5.8, 0.5], [10.0, 10.1, 10.3], [0.2, 0.1, 0.3, 0.9]),
        ([0.6, 0.7, 9.0], [10.02, 9.98, 10.0], upright),
        ([0.3, 0.3, 8.0], [10.02, 9.98, 10.0], [0.4, 0.1, 0.0, 0.9]),
    ];
    for (size, position, turn) in cases {
        let mut held = Held::new([20; 3], size, position, turn);
        // The pose of what stands still is not rounded.
        held.part_step = 0.0;
        let still = held.run(As::Fixed, 120, |_| false);
        let moving = held.run(As::Moving, 120, |_| false);
        assert!(norm(moving[1]) > 0.0);
        agree(still, moving, [1e-6, 1e-5], &held.part);
        if size[0] == size[2] {
            let body = held.run(As::Body, 120, |_| false);
            agree(body, moving, [1e-6, 1e-5], &held.part);
        }
    }
}

/// True if momentum and force are those expected.
fn agree(found: [[f64; 3]; 2], expected: [[f64; 3]; 2], bounds: [f64; 2], part: &Part) {
    for ((found, expected), bound) in found.into_iter().zip(expected).zip(bounds) {
        for a in 0..3 {
            let off = (found[a] - expected[a]).abs() / norm(expected);
            assert!(off < bound, "{part:?}: {found:?} {expected:?}");
        }
    }
}

/// A plate that covers no cell takes no mass and makes none, however it moves, and its links do not
/// have to pay any back: 1e-13 of the fluid's in each step. (With each end interpolated by itself
/// it would be 3e-6.)
#[test]
fn links_that_are_cut_keep_the_mass() {
    let turned = [0.02, -0.01, 0.03, 1.0];
    let mut held = Held::new([20; 3], [6.2, 5.8, 0.3], [10.13, 10.22, 10.0], turned);
    held.velocity = [0.02, -0.03, 0.01];
    held.angular_velocity = [3e-3, 2e-3, -5e-3];
    let mut steps = 0;
    held.run(As::Moving, 1, |ledger| {
        steps += 1;
        assert_eq!([ledger.mass_covered, ledger.mass_uncovered], [0.0; 2]);
        assert!(norm(ledger.bodies) > 0.0);
        let made = ledger.mass_bodies.abs() / ledger.mass;
        assert!(made < 1e-13, "{made} in step {steps}");
        steps < 100
    });
}

/// Stokes drag over that of a sphere of equal volume, images in a periodic box put back (Hasimoto
/// 1959): 1.065 of a cube (the estimate of `polyhedra`, from its capacity, itself to 1 %). 12 cells
/// a diameter, any place and turn; within 2 %.
///
/// Not among these: upright cubes whose opposite faces both lie less than 0.3 of a cell from a
/// layer of cells outside. They come out 3.7 % low (1.026), at 24 cells a diameter 0.6 % low. It is
/// not the way of interpolation: the central linear one of Ginzburg, Verhaeghe and d'Humieres gives
/// 1.031 there. Along an upright edge all distances are the same, and in the cells next to it the
/// velocity grows as a root of the distance, which no line follows; with edges aslant this averages
/// out.
#[test]
fn the_drag_of_a_cube_does_not_depend_on_where_it_is() {
    let (n, diameter) = (30_usize, 12.0);
    let (length, radius) = (n as f64, 0.5 * diameter);
    let edge = diameter * (PI / 6.0).cbrt();
    let mut dice = Dice(11);
    for k in 0..4 {
        let position = std::array::from_fn(|_| 0.5 * length + dice.roll());
        let turn: [f64; 4] = std::array::from_fn(|_| dice.between(-1.0, 1.0));
        let turn = if k % 2 == 0 { turn } else { [0.0, 0.0, 0.0, 1.0] };
        let mut held = Held::new([n; 3], [edge; 3], position, turn);
        let a = 1e-7;
        held.case.acceleration = [a, 0.0, 0.0];
        held.case.threads = 2;
        let stokes = 6.0 * PI * held.case.viscosity() * radius;
        held.case.velocity = [0.46 * a * length.powi(3) / stokes, 0.0, 0.0];
        let mut before = 0.0;
        let [momentum, _] = held.run(As::Body, 100, |ledger| {
            let now = ledger.momentum[0];
            let goes_on = (now - before).abs() > 2e-4 * now;
            before = now;
            goes_on
        });
        let in_box = a * length.powi(6) / (stokes * momentum[0]);
        let fraction = 4.0 / 3.0 * PI * (radius / length).powi(3);
        let images = 1.7601 * fraction.cbrt() - fraction + 1.5593 * fraction.powi(2);
        let alone = 1.0 / (1.0 / in_box + images);
        println!("{position:?} {turn:?}: {alone:.4}");
        assert!((alone / 1.065 - 1.0).abs() < 0.02, "{position:?} {turn:?}: {alone}");
    }
}
