//! Every bit of a lattice in shares is that of the lattice in one piece: populations, loads, balance, signals.

use crate::common::*;
use crate::thread_ranks::ThreadRank;
use tremie_fluid_lbm::{Collision, LbmFluid, Precision, Refill};
use tremie_messages::scene::{
    BodySet, Course, Face, Geometry, Motion, OpenVelocity, Outflow, Placement, Probe, ProbeShape,
    Profile, Reservoir, Ring, Scene, Sphere,
};
use tremie_messages::{BodyEvent, BodyState};

/// What happens in a scene.
#[derive(Clone)]
struct Story {
    case: Case,
    scene: Scene,
    events: Vec<BodyEvent>,
    bodies: Vec<BodyState>,
    /// Half-way through, events, and bodies that these add.
    swap: Vec<BodyEvent>,
    newcomers: Vec<BodyState>,
    steps: usize,
}

impl Story {
    fn new(case: Case) -> Self {
        Self::of(case.scene(), case)
    }

    fn of(scene: Scene, case: Case) -> Self {
        let (events, bodies, swap, newcomers) = Default::default();
        Self { scene, case, events, bodies, swap, newcomers, steps: 40 }
    }

    /// A sphere that moves evenly.
    fn with(mut self, radius: f64, position: [f64; 3], velocity: [f64; 3]) -> Self {
        // The scene says what can be in it: ranks hold copies as deep as that takes.
        let diameter = 2.0 * radius;
        let sphere = Sphere { position, diameter, velocity, angular_velocity: [0.0; 3] };
        self.scene.bodies.push(BodySet {
            name: format!("set{}", self.bodies.len()),
            density: 2.0,
            material: "wall".into(),
            motion: Motion::Free,
            clump: None,
            placement: Placement::Listed(vec![sphere]),
        });
        let id = self.bodies.len() as u64;
        self.events.push(added(id, radius));
        self.bodies.push(BodyState { velocity, ..BodyState::at_rest(id, position) });
        self
    }

    /// Plays the story in a fluid, which may be a share; bits of all that it tells, and of the cells that it counts.
    fn play(&self, mut fluid: LbmFluid) -> (Vec<u64>, Vec<(usize, u64)>) {
        let mut bits = Vec::new();
        let waves = |at: [f64; 3]| {
            let [x, y, z] = at.map(|x| 0.3 * x);
            ([0.02 * y.sin(), 0.01 * (x + z).cos(), 0.015 * (z - y).sin()], 1e-3 * (x * 0.7).cos())
        };
        fluid.set_state(waves);
        let mut bodies = self.bodies.clone();
        fluid.apply_events(&self.events).unwrap();
        let mut loads = loads_of(&bodies);
        fluid.start(&bodies, &mut loads).unwrap();
        for step in 0..self.steps {
            if step == self.steps / 2 && !self.swap.is_empty() {
                fluid.apply_events(&self.swap).unwrap();
                bodies.retain(|body| !self.swap.contains(&removed(body.id)));
                bodies.extend(&self.newcomers);
                loads = loads_of(&bodies);
            }
            advance(&mut bodies);
            fluid.step(&bodies, &mut loads).unwrap();
            note(&mut fluid, &loads, &mut bits);
        }
        let mut of_cells = Vec::new();
        for (number, cell) in cells(&fluid).enumerate().filter(|(_, cell)| fluid.counts(*cell)) {
            let populations = fluid.populations_at(cell);
            of_cells.extend(populations.map(|f| (number, f.to_bits())));
        }
        (bits, of_cells)
    }

    /// Checks that so many ranks, each of these, have the bits of one.
    fn holds_for(&self, all: &[usize]) {
        let (told, of_cells) = self.play(self.case.fluid_of(&self.scene));
        assert!(told.len() > 20 * self.steps && !of_cells.is_empty());
        all.iter().for_each(|&ranks| self.hold(ranks, &told, &of_cells));
    }

    fn hold(&self, ranks: usize, told: &[u64], of_cells: &[(usize, u64)]) {
        let play = |way: ThreadRank| {
            let parameters = self.case.parameters();
            let with = (self.case.threads, self.case.variant);
            let fluid =
                LbmFluid::with_ranks(&self.scene, &parameters, 1.0, with, Box::new(way)).unwrap();
            self.play(fluid)
        };
        let shares: Vec<_> = std::thread::scope(|scope| {
            let ranks = ThreadRank::all(ranks).into_iter();
            let threads: Vec<_> = ranks.map(|way| scope.spawn(|| play(way))).collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).collect()
        });
        let mut all = Vec::new();
        for (rank, (of_share, cells)) in shares.into_iter().enumerate() {
            let per_step = told.len() / self.steps;
            let other = (0..told.len()).find(|&k| told[k] != of_share[k]);
            let place = other.map(|k| (k / per_step, k % per_step));
            assert_eq!(place, None, "rank {rank} of {ranks}: step, and number in it");
            all.extend(cells);
        }
        all.sort_by_key(|(number, _)| *number);
        assert_eq!(all.len(), of_cells.len(), "each cell is counted once");
        let other = all.iter().zip(of_cells).find(|(a, b)| a != b);
        assert!(other.is_none(), "{ranks} ranks: {other:?}");
    }
}

/// Adds the bits of what a fluid tells at the end of a step.
fn note(fluid: &mut LbmFluid, loads: &[tremie_messages::Load], bits: &mut Vec<u64>) {
    let mut put = |x: f64| bits.push(x.to_bits());
    for load in loads {
        load.force.iter().chain(&load.torque).for_each(|&x| put(x));
    }
    let found = fluid.diagnostics();
    put(found.max_speed);
    put(found.min_density_deviation);
    put(found.max_density_deviation);
    put(found.max_tau);
    put(found.links as f64);
    put(found.fallback_links as f64);
    put(found.fluid_cells as f64);
    let ledger = fluid.ledger();
    put(ledger.mass);
    put(ledger.mass_owed);
    put(ledger.mass_lost);
    for term in [
        ledger.momentum,
        ledger.walls,
        ledger.parts,
        ledger.open,
        ledger.bodies,
        ledger.covered,
        ledger.uncovered,
        ledger.isolated,
        ledger.gaps,
    ] {
        term.iter().for_each(|&x| put(x));
    }
    let mut on_parts = Vec::new();
    fluid.loads_on_parts(&mut on_parts);
    on_parts.iter().for_each(|load| load.force.iter().chain(&load.torque).for_each(|&x| put(x)));
    fluid.wall_forces().iter().flatten().for_each(|force| force.iter().for_each(|&x| put(x)));
    let (mut probes, mut reservoirs) = (Vec::new(), Vec::new());
    fluid.probes(&mut probes);
    probes.iter().for_each(|&x| put(x));
    fluid.reservoirs(&mut reservoirs);
    reservoirs.iter().for_each(|state| state.values().iter().for_each(|&x| put(x)));
    fluid.ports().iter().for_each(|port| put(port.velocity));
}

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
        story.holds_for(&[2, 3, 4, 8]);
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
        story.holds_for(&[2, 3, 4]);
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
    Story::of(scene, case).holds_for(&[2, 3, 4]);
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
        story.with(2.3, [19.9, 20.4, 31.0], [0.0, -0.03, 0.05]).holds_for(&[2, 3, 4]);
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
    story.holds_for(&[2, 3, 4]);
}
