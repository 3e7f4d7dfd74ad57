//! Bodies are taken away from a fluid of particles, wherever they stand in the list, and others come.

use tremie_fluid_pic::{GapDampingTable, Parameters, PicFluid};
use tremie_messages::scene::{Domain, Face, Fill, FluidMaterial, Scene};
use tremie_messages::{BodyEvent, BodyState, Load};

const CELL: f64 = 5e-3;
const STEP: f64 = 1e-3;
const RADIUS: f64 = 0.012;

/// Water in a plane tank.
fn tank() -> PicFluid<2> {
    let mut domain = Domain::new([0.0; 3], [0.2, CELL, 0.12], Face::WALLS);
    domain.across = Some(1);
    let water = FluidMaterial::at_rest(1000.0, 1e-3);
    let pool = Fill { min: [0.0; 3], max: [0.2, CELL, 0.09], part: None, velocity: None };
    let fluid = Some(FluidMaterial { fill: vec![pool], ..water });
    let scene = Scene { fluid, gravity: [0.0, 0.0, -9.81], ..Scene::empty(domain) };
    let damping = Some(GapDampingTable { beta: 0.6, gap: None });
    let parameters = Parameters { gap_damping: damping, ..Parameters::with_cell(CELL) };
    PicFluid::plane(&scene, &parameters, STEP, 1).unwrap()
}

fn added(id: u64) -> BodyEvent {
    BodyEvent {
        id,
        kind: BodyEvent::ADDED,
        shape: BodyEvent::CYLINDER,
        motion: BodyEvent::PRESCRIBED,
        set: 0,
        mass: 0.0,
        size: [RADIUS, 0.0, 0.0],
        table: 0,
    }
}

fn removed(id: u64) -> BodyEvent {
    BodyEvent { kind: BodyEvent::REMOVED, ..added(id) }
}

/// A cylinder that is drawn through the water from a place.
#[derive(Clone, Copy)]
struct Drawn {
    id: u64,
    from: [f64; 2],
    velocity: [f64; 2],
}

impl Drawn {
    fn at(&self, time: f64) -> BodyState {
        let [x, z] = [0, 1].map(|a| self.from[a] + time * self.velocity[a]);
        let velocity = [self.velocity[0], 0.0, self.velocity[1]];
        BodyState { velocity, ..BodyState::at_rest(self.id, [x, 0.5 * CELL, z]) }
    }
}

/// The fluid with the cylinders that are in it.
struct Pool {
    fluid: PicFluid<2>,
    drawn: Vec<Drawn>,
    loads: Vec<Load>,
    time: f64,
}

impl Pool {
    fn new(mut drawn: Vec<Drawn>) -> Self {
        drawn.sort_by_key(|one| one.id);
        let mut own = Self { fluid: tank(), loads: Vec::new(), drawn, time: 0.0 };
        let events: Vec<_> = own.drawn.iter().map(|one| added(one.id)).collect();
        own.fluid.apply_events(&events).unwrap();
        let states = own.states();
        own.fluid.start(&states, &mut own.loads).unwrap();
        own
    }

    fn states(&mut self) -> Vec<BodyState> {
        self.loads.resize(self.drawn.len(), Load::default());
        self.drawn.iter().map(|one| one.at(self.time)).collect()
    }

    fn advance(&mut self, windows: u32) {
        for _ in 0..windows {
            self.time += 2.0 * STEP;
            let states = self.states();
            self.fluid.advance(2, &states, &mut self.loads).unwrap();
            let same = |(load, one): (&Load, &Drawn)| load.id == one.id;
            assert!(self.loads.iter().zip(&self.drawn).all(same));
        }
    }

    /// One goes, another may come, and the fluid goes on.
    fn exchange(&mut self, gone: u64, new: Option<Drawn>) {
        let events: Vec<_> =
            std::iter::once(removed(gone)).chain(new.map(|one| added(one.id))).collect();
        self.fluid.apply_events(&events).unwrap();
        self.drawn.retain(|one| one.id != gone);
        self.drawn.extend(new);
        self.drawn.sort_by_key(|one| one.id);
        self.advance(4);
    }

    fn load(&self, id: u64) -> [f64; 3] {
        self.loads.iter().find(|load| load.id == id).unwrap().force
    }
}

fn drawn(id: u64, from: [f64; 2], velocity: [f64; 2]) -> Drawn {
    Drawn { id, from, velocity }
}

/// Three that are drawn, under these ids.
fn three(ids: [u64; 3]) -> Vec<Drawn> {
    vec![
        drawn(ids[0], [0.04, 0.03], [0.3, 0.0]),
        drawn(ids[1], [0.10, 0.05], [0.0, -0.2]),
        drawn(ids[2], [0.16, 0.04], [-0.3, 0.1]),
    ]
}

const FOURTH: ([f64; 2], [f64; 2]) = ([0.10, 0.08], [0.1, -0.1]);

#[test]
fn bodies_go_and_others_come() {
    let mut pool = Pool::new(three([3, 5, 8]));
    let particles = pool.fluid.state().particles;
    pool.advance(4);
    pool.exchange(5, None);
    pool.exchange(8, None);
    pool.exchange(3, None);
    assert!(pool.loads.is_empty());
    let (from, velocity) = FOURTH;
    pool.fluid.apply_events(&[added(9)]).unwrap();
    pool.drawn = vec![drawn(9, from, velocity)];
    pool.advance(4);
    let state = pool.fluid.state();
    assert_eq!(state.particles, particles);
    assert!(state.sums.max_speed < 3.0 && pool.load(9) != [0.0; 3], "{state:?}");
}

/// Whether a body stood last or in the middle does not matter once it is gone: the others push the
/// fluid as before.
#[test]
fn fluid_meets_the_bodies_that_are_there() {
    let (from, velocity) = FOURTH;
    let fourth = |id| Some(drawn(id, from, velocity));
    let after = |ids: [u64; 3], new: u64| {
        let mut pool = Pool::new(three(ids));
        pool.advance(4);
        pool.exchange(ids[1], fourth(new));
        [ids[0], ids[2], new].map(|id| pool.load(id))
    };
    let last = after([1, 3, 2], 4);
    for (ids, new) in [([1, 2, 3], 4), ([3, 1, 4], 2), ([2, 5, 4], 1)] {
        let other = after(ids, new);
        for (a, b) in last.as_flattened().iter().zip(other.as_flattened()) {
            assert!((a - b).abs() < 1e-6, "{ids:?}: {last:?} {other:?}");
        }
    }
}
