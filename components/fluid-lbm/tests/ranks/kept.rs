//! The state of a lattice in shares, put back by any number of ranks.

use crate::common::*;
use crate::story::{CountedBits, Story, compare_cells, counted};
use std::path::{Path, PathBuf};
use tremie_fluid_lbm::{Collision, LbmFluid, Precision, Refill};
use tremie_messages::BodyState;
use tremie_messages::scene::{
    Course, Face, Geometry, Motion, OpenVelocity, Outflow, Probe, ProbeShape, Profile, Reservoir,
};
use tremie_state::{
    KeepsState, SavedState, StateArchive, StateError, StateHeader, StatePart, StatePlace,
};

const CELLS: [usize; 3] = [40, 30, 60];

fn place(path: &Path) -> StatePlace {
    let header = StateHeader::whole("fluid", "lattice", LbmFluid::STATE_VERSION, 0);
    StatePlace { path: path.to_path_buf(), header, within: String::new() }
}

/// Keeps the part that one of so many ranks has.
fn keep(fluid: &mut LbmFluid, rank: usize, ranks: usize, path: &Path) {
    let state = SavedState::told(|state| {
        state.keep_part(StatePart { number: rank as u32, of: ranks as u32 });
        fluid.exchange_state(state)
    });
    let (state, place) = (state.unwrap(), place(path));
    match rank {
        0 => drop(state.write(&place.path, &place.header).unwrap()),
        _ => state.write_part(&place).unwrap(),
    }
}

fn restore(fluid: &mut LbmFluid, path: &Path) -> Result<(), StateError> {
    StateArchive::open(path).and_then(|mut archive| archive.restore("lattice", fluid))
}

impl Story {
    /// Checks that the story goes on with its bits wherever its state was kept and is put back: by one lattice in one
    /// piece, by as many ranks, by more and by fewer.
    pub fn goes_on(&self, middle: usize) {
        let mut whole = self.case.fluid_of(&self.scene);
        self.begin(&mut whole);
        self.go(&mut whole, 0..middle);
        let home = tempfile::tempdir().unwrap();
        let path = |ranks: usize| -> PathBuf { home.path().join(format!("of{ranks}.npz")) };
        keep(&mut whole, 0, 1, &path(1));
        let rest = self.go(&mut whole, middle..self.steps);
        let cells = counted(&whole);
        self.on_ranks(3, |rank, mut fluid| {
            self.begin(&mut fluid);
            self.go(&mut fluid, 0..middle);
            keep(&mut fluid, rank, 3, &path(3));
        });
        for (kept, ranks) in [(1, 2), (3, 3), (3, 2), (3, 4)] {
            let who = format!("kept by {kept}, put back by {ranks}");
            let shares = self.on_ranks(ranks, |_, mut fluid| {
                restore(&mut fluid, &path(kept)).unwrap();
                (self.go(&mut fluid, middle..self.steps), counted(&fluid))
            });
            let mut all = CountedBits::new();
            for (told, cells) in shares {
                self.compare(&who, &rest, &told);
                all.extend(cells);
            }
            compare_cells(&who, &cells, all);
        }
        let mut again = self.case.fluid_of(&self.scene);
        restore(&mut again, &path(3)).unwrap();
        self.compare("kept by 3, in one piece", &rest, &self.go(&mut again, middle..self.steps));
        compare_cells("kept by 3, in one piece", &cells, counted(&again));
    }
}

/// Spheres that move, one of which vanishes across a cut, in a wind; an odd and an even number of steps.
#[test]
fn spheres_that_move_and_vanish() {
    for (precision, middle) in [(Precision::F64, 21), (Precision::F32, 22)] {
        let case = Case {
            precision,
            smagorinsky: 0.1,
            refill: Refill::Mass,
            average_force: true,
            ..Case::new(CELLS, [PERIODIC; 3], 0.53)
        };
        let mut story = Story::new(case)
            .with(4.3, [20.2, 15.1, 14.7], [0.01, 0.0, 0.07])
            .with(3.1, [22.4, 14.8, 21.9], [0.0, 0.01, -0.05])
            .with(2.2, [26.0, 12.0, 30.0], [0.0, 0.02, 0.0])
            .with(2.2, [31.0, 20.0, 49.5], [0.0; 3]);
        story.swap = vec![removed(2), added(7, 2.9)];
        story.newcomers = vec![BodyState::at_rest(7, [30.0, 22.0, 44.6])];
        story.goes_on(middle);
    }
}

/// Curved walls, which owe mass, through an inlet and out of faces that remember; probes.
#[test]
fn walls_and_open_faces() {
    for axis in [0, 2] {
        for outflow in [Outflow::Absorbing, Outflow::Convective] {
            let mut faces = [WALL; 3];
            faces[(axis + 1) % 3] = PERIODIC;
            let case = Case { collision: Collision::Bgk, ..Case::new(CELLS, faces, 0.56) };
            let mut scene = case.scene();
            let mut velocity = [0.0; 3];
            velocity[axis] = 0.03;
            let (profile, course) = (Profile::Parabolic, Course::default());
            let inlet = Face::Velocity(OpenVelocity { velocity, profile, course });
            let outlet = Face::Pressure { pressure: 1e-3, course: Course::default(), outflow };
            scene.domain.faces[axis] = [inlet, outlet];
            let ball = Geometry::Sphere { radius: 6.3 };
            scene.parts.push(part("ball", ball, [20.1, 14.2, 29.6]));
            let (min, max) = ([3.0, 2.0, 4.0], [38.0, 28.0, 57.0]);
            let shape = ProbeShape::Section { axis: 2, position: 30.3, min, max };
            scene.probes.push(Probe { name: "section".into(), shape });
            Story::of(scene, case).goes_on(17);
        }
    }
}

/// A part that turns across the cuts beside a grain that is pinched between it and a wall, and a reservoir. The
/// momentum of pinched cells is kept, too: it is taken in step 64 and used in step 65.
#[test]
fn parts_that_move_and_a_reservoir() {
    let case = Case { refill: Refill::Mass, ..Case::new(CELLS, [WALL, PERIODIC, WALL], 0.55) };
    let mut scene = case.scene();
    let area = (CELLS[0] * CELLS[1]) as f64;
    let outlet =
        Face::Pressure { pressure: 0.0, course: Course::default(), outflow: Outflow::Fixed };
    scene.domain.faces[2] = [Face::Reservoir(Reservoir::new(area, 30.0 * area, 0.01)), outlet];
    let mut paddle = part("paddle", Geometry::Box { size: [13.0, 3.2, 17.0] }, [0.0; 3]);
    paddle.motion = Motion::Prescribed(Vec::new());
    scene.parts.push(paddle);
    let mut story = Story::of(scene, case);
    story.events.push(added_part(0, 0));
    let (velocity, angular_velocity) = ([0.0, 0.002, 0.004], [0.01, 0.004, 0.0]);
    let still = BodyState::at_rest(0, [10.4, 15.3, 30.2]);
    story.bodies.push(BodyState { velocity, angular_velocity, ..still });
    story.steps = 80;
    story = story.with(2.3, [2.31, 20.4, 31.0], [0.0, -0.01, 0.01]).with(
        2.6,
        [2.62, 16.2, 28.9],
        [0.0, 0.0, 0.01],
    );
    story.goes_on(64);
}

/// A part that is lost on one rank's way is told by all, and no rank waits for another.
#[test]
fn a_rank_that_cannot_put_back_is_named_by_all() {
    let story = Story::new(Case::new(CELLS, [PERIODIC; 3], 0.53));
    let home = tempfile::tempdir().unwrap();
    let path = home.path().join("fluid.npz");
    story.on_ranks(3, |rank, mut fluid| {
        story.begin(&mut fluid);
        keep(&mut fluid, rank, 3, &path);
    });
    let told = story.on_ranks(3, |rank, mut fluid| match rank {
        2 => {
            let why = StateError::Unfit("fluid.part-2.npz is not there".into());
            fluid.fail_exchange(why).unwrap_err().to_string()
        }
        _ => restore(&mut fluid, &path).unwrap_err().to_string(),
    });
    assert_eq!(told, ["rank 2: fluid.part-2.npz is not there"; 3]);
}
