//! A particle fluid that goes on from the file of a state ends with the bits of one that was never
//! interrupted.

use tremie_fluid_pic::{GapDampingTable, Parameters, PicFluid, TransferName};
use tremie_messages::scene::{
    Course, Domain, Face, Fill, FluidMaterial, Geometry, Motion, OpenVelocity, Outflow, Part,
    PartBoundary, Pose, Probe, ProbeShape, Profile, Scene, Shape, Sine,
};
use tremie_messages::units::Time;
use tremie_messages::{BodyEvent, BodyState, Load};
use tremie_state::SavedState;
use tremie_test_support::through_a_file;

/// A body of a scene.
#[derive(Clone)]
struct Grain {
    event: BodyEvent,
    state: BodyState,
    /// Height at which it lies on the ground [m].
    lowest: f64,
    /// Window at whose end it comes.
    from: u64,
}

impl Grain {
    /// A free ball that is there all the time: a cylinder of a plane scene, or a sphere.
    fn ball(id: u64, shape: u32, position: [f64; 3], radius: f64, mass: f64) -> Self {
        let event = BodyEvent {
            id,
            kind: BodyEvent::ADDED,
            shape,
            motion: BodyEvent::FREE,
            set: 0,
            mass,
            size: [radius, 0.0, 0.0],
            table: 0,
        };
        let state = BodyState::at_rest(id, position);
        Self { event, state, lowest: radius, from: 0 }
    }

    /// The same, along a line whatever the fluid does.
    fn driven(mut self, velocity: [f64; 3]) -> Self {
        self.event.motion = BodyEvent::PRESCRIBED;
        self.state.velocity = velocity;
        self
    }

    /// Goes through a window, and lies on the ground if it comes there.
    fn advance(&mut self, load: &Load, gravity: f64, window: f64) {
        let BodyState { position, velocity, angular_velocity, .. } = &mut self.state;
        let (mass, radius) = (self.event.mass, self.event.size[0]);
        if self.event.motion == BodyEvent::FREE {
            for a in 0..3 {
                velocity[a] += window * load.force[a] / mass;
                angular_velocity[a] += window * load.torque[a] / (0.4 * mass * radius * radius);
            }
            velocity[2] -= window * gravity;
        }
        for a in 0..3 {
            position[a] += window * velocity[a];
        }
        if position[2] < self.lowest {
            (position[2], velocity[2]) = (self.lowest, 0.0);
        }
    }
}

/// A scene in windows of some steps.
struct Case {
    scene: Scene,
    parameters: Parameters,
    step: f64,
    substeps: u32,
    windows: u64,
    grains: Vec<Grain>,
}

/// A fluid in a window, and what moves in it.
struct Tank<const D: usize> {
    fluid: PicFluid<D>,
    window: u64,
    grains: Vec<Grain>,
    loads: Vec<Load>,
}

impl Case {
    fn space(&self, threads: usize) -> PicFluid<3> {
        PicFluid::new(&self.scene, &self.parameters, self.step, threads).unwrap()
    }

    fn plane(&self, threads: usize) -> PicFluid<2> {
        PicFluid::plane(&self.scene, &self.parameters, self.step, threads).unwrap()
    }

    fn begin<const D: usize>(&self, fluid: PicFluid<D>) -> Tank<D> {
        let mut tank = Tank { fluid, window: 0, grains: self.grains.clone(), loads: Vec::new() };
        let states = self.living(&mut tank);
        tank.fluid.start(&states, &mut tank.loads).unwrap();
        tank
    }

    /// The bodies that are there, once those have come that come now.
    fn living<const D: usize>(&self, tank: &mut Tank<D>) -> Vec<BodyState> {
        let now = tank.window;
        let come = tank.grains.iter().filter(|grain| grain.from == now);
        let events: Vec<BodyEvent> = come.map(|grain| grain.event).collect();
        tank.fluid.apply_events(&events).unwrap();
        let there = tank.grains.iter().filter(|grain| grain.from <= now);
        let states: Vec<BodyState> = there.map(|grain| grain.state).collect();
        tank.loads.resize(states.len(), Load::default());
        states
    }

    fn advance<const D: usize>(&self, tank: &mut Tank<D>) {
        let length = f64::from(self.substeps) * self.step;
        for grain in tank.grains.iter_mut().filter(|grain| grain.from <= tank.window) {
            let load = tank.loads.iter().find(|load| load.id == grain.event.id).unwrap();
            grain.advance(load, -self.scene.gravity[2], length);
        }
        tank.window += 1;
        let states = self.living(tank);
        tank.fluid.advance(self.substeps, &states, &mut tank.loads).unwrap();
    }

    /// Keeps the state after some windows, puts it into a fluid of two threads, and compares with
    /// what goes on without a stop: all that is told of each window, and the state at the end.
    fn is_the_same_after<const D: usize>(
        &self,
        stops: &[u64],
        make: impl Fn(usize) -> PicFluid<D>,
    ) -> Tank<D> {
        let mut whole = self.begin(make(1));
        let mut told = vec![seen(&mut whole)];
        for _ in 0..self.windows {
            self.advance(&mut whole);
            told.push(seen(&mut whole));
        }
        let expected = SavedState::of(&mut whole.fluid).unwrap();
        for &stop in stops {
            let mut first = self.begin(make(1));
            (0..stop).for_each(|_| self.advance(&mut first));
            let mut fluid = make(2);
            through_a_file(&mut first.fluid, &mut fluid);
            let kept = SavedState::of(&mut first.fluid).unwrap();
            let put_back = SavedState::of(&mut fluid).unwrap();
            assert_eq!(put_back.first_difference(&kept), None, "after window {stop}");
            let mut second = Tank { fluid, ..first };
            assert!(seen(&mut second) == told[stop as usize], "put back after window {stop}");
            while second.window < self.windows {
                self.advance(&mut second);
                let window = second.window;
                let expected = &told[window as usize];
                assert!(seen(&mut second) == *expected, "window {window} from window {stop}");
            }
            let ended = SavedState::of(&mut second.fluid).unwrap();
            assert_eq!(ended.first_difference(&expected), None, "from window {stop}");
        }
        whole
    }
}

/// Everything that a fluid tells: sums, loads, probes, and what is in each cell.
fn seen<const D: usize>(tank: &mut Tank<D>) -> (String, Vec<u64>) {
    let fluid = &mut tank.fluid;
    let (mut at_rest, mut numbers) = (Vec::new(), Vec::new());
    fluid.loads_at_rest(&mut at_rest);
    for load in tank.loads.iter().chain(&at_rest) {
        numbers.extend([load.force, load.torque].concat());
    }
    numbers.extend(fluid.wall_forces().as_flattened().as_flattened());
    fluid.probes(&mut numbers);
    let [x, y, z] = fluid.cells();
    for cell in 0..x * y * z {
        let (velocity, pressure, fill, is_solid) =
            fluid.node([cell % x, cell / x % y, cell / x / y]);
        numbers.extend(velocity);
        numbers.extend([pressure, fill, f64::from(u8::from(is_solid))]);
    }
    (format!("{:?}", fluid.state()), numbers.into_iter().map(f64::to_bits).collect())
}

/// A box of `cells` of an edge [m] with a fluid up to a place in it, or everywhere.
fn scene(cells: [u32; 3], edge: f64, fluid: FluidMaterial, wet: Option<[f64; 3]>) -> Scene {
    let mut domain = Domain::new([0.0; 3], cells.map(|n| f64::from(n) * edge), Face::WALLS);
    domain.across = (cells[1] == 1).then_some(1);
    let fill = wet.map(|max| Fill { min: [0.0; 3], max, part: None, velocity: None });
    let fluid = FluidMaterial { fill: fill.into_iter().collect(), ..fluid };
    Scene { fluid: Some(fluid), gravity: [0.0, 0.0, -9.81], ..Scene::empty(domain) }
}

fn post(size: [f64; 3], position: [f64; 3]) -> Part {
    Part {
        name: "post".into(),
        geometry: Geometry::Box { size },
        pose: Pose { position, ..Pose::IDENTITY },
        cavity: false,
        material: "wall".into(),
        motion: Motion::Fixed,
        boundary: PartBoundary::Wall,
    }
}

/// A wave runs against a post and over cylinders: one floats, one lies on the ground, one falls
/// into the water later. The fluid is damped where they are near each other.
#[test]
fn a_dam_break_with_cylinders_goes_on() {
    let water = FluidMaterial::at_rest(1000.0, 1e-3);
    let mut scene = scene([48, 1, 24], 5e-3, water, Some([0.08, 5e-3, 0.09]));
    scene.parts = vec![post([0.02, 0.1, 0.06], [0.18, 0.0, 0.0])];
    let point = ProbeShape::Point([0.05, 2.5e-3, 0.02]);
    let section = ProbeShape::Section { axis: 0, position: 0.1, min: [0.0; 3], max: [1.0; 3] };
    let probe = |name: &str, shape| Probe { name: name.into(), shape };
    scene.probes = vec![probe("point", point), probe("section", section)];
    let disc = |id, x: f64, z: f64, density: f64| {
        let (radius, depth) = (0.012, 5e-3);
        let mass = density * std::f64::consts::PI * radius * radius * depth;
        Grain::ball(id, BodyEvent::CYLINDER, [x, 2.5e-3, z], radius, mass)
    };
    let late = Grain { from: 7, ..disc(4, 0.03, 0.07, 300.0) };
    let case = Case {
        scene,
        parameters: Parameters {
            jitter: 0.4,
            gap_damping: Some(GapDampingTable { beta: 0.6, gap: None }),
            ..Parameters::with_cell(5e-3)
        },
        step: 1e-3,
        substeps: 2,
        windows: 140,
        grains: vec![disc(1, 0.055, 0.05, 600.0), disc(3, 0.105, 0.012, 2000.0), late],
    };
    let whole = case.is_the_same_after(&[0, 1, 10, 90], |threads| case.plane(threads));
    let state = whole.fluid.state();
    assert!(state.sums.farthest[0] > 0.15 && state.gap_damping[0] != 0.0, "{state:?}");
}

/// A sphere and a cube sink in syrup past a sphere that is drawn through it, between walls that
/// move. Particles carry gradients.
#[test]
fn bodies_in_syrup_go_on() {
    let syrup = FluidMaterial::at_rest(1200.0, 3.0);
    let mut scene = scene([14, 12, 14], 0.01, syrup, Some([0.14, 0.12, 0.105]));
    let swing = Face::Wall { velocity: [0.0, 0.0, 0.3], course: Course::Sine(Sine::new(30.0)) };
    scene.domain.faces[0] = [Face::moving([0.0, 0.2, 0.0]), swing];
    let vertices = tremie_geometry::solid("cube").unwrap();
    scene.shapes = vec![Shape { name: "cube".into(), vertices }];
    scene.parts = vec![post([0.03, 0.03, 0.04], [0.04, 0.04, 0.0])];
    let ball = |id, position, mass| Grain::ball(id, BodyEvent::SPHERE, position, 0.02, mass);
    let mut cube = ball(5, [0.09, 0.06, 0.05], 0.05);
    cube.event.shape = BodyEvent::POLYHEDRON;
    cube.event.size[1] = 0.025;
    let grains = vec![
        ball(1, [0.04, 0.06, 0.075], 0.07),
        ball(2, [0.05, 0.095, 0.06], 0.0).driven([0.3, 0.0, 0.1]),
        cube,
    ];
    let transfer = TransferName::Apic;
    let parameters = Parameters { transfer, ..Parameters::with_cell(0.01) };
    let case = Case { scene, parameters, step: 2e-3, substeps: 1, windows: 24, grains };
    let whole = case.is_the_same_after(&[0, 1, 7], |threads| case.space(threads));
    let state = whole.fluid.state();
    assert!(state.on_bodies[1][0].abs() > 1e-3, "{state:?}");
}

/// A wave maker drives waves, later past a float; they leave at the other end of the flume.
#[test]
fn waves_in_a_flume_go_on() {
    let water = FluidMaterial::at_rest(1000.0, 1e-3);
    let mut scene = scene([64, 1, 20], 0.01, water, Some([0.64, 0.01, 0.1]));
    let maker = OpenVelocity {
        velocity: [0.3, 0.0, 0.0],
        profile: Profile::Uniform,
        course: Course::Sine(Sine::new(2.0)),
    };
    let outlet =
        Face::Pressure { pressure: 0.0, course: Course::default(), outflow: Outflow::Absorbing };
    scene.domain.faces[0] = [Face::Velocity(maker), outlet];
    scene.domain.levels[0] = [Some(0.1); 2];
    let float = Grain::ball(1, BodyEvent::CYLINDER, [0.25, 5e-3, 0.12], 0.03, 0.014);
    let float = Grain { from: 20, ..float };
    let parameters = Parameters::with_cell(0.01);
    let case =
        Case { scene, parameters, step: 2.5e-3, substeps: 2, windows: 160, grains: vec![float] };
    let whole = case.is_the_same_after(&[0, 1, 70], |threads| case.plane(threads));
    let state = whole.fluid.state();
    assert!(state.passed.iter().all(|volume| *volume > 1e-6), "{state:?}");
}

/// A disc turns in a fluid without a surface, between a wall that moves and one that does not; the
/// flow comes in again where it goes out.
#[test]
fn a_disc_in_a_shear_flow_goes_on() {
    let oil =
        FluidMaterial { acceleration: [0.5, 0.0, 0.0], ..FluidMaterial::at_rest(900.0, 0.05) };
    let mut scene = scene([30, 1, 20], 1e-3, oil, None);
    scene.gravity = [0.0; 3];
    scene.domain.faces[0] = [Face::Periodic, Face::Periodic];
    scene.domain.faces[2][1] = Face::moving([0.05, 0.0, 0.0]);
    let disc = Grain::ball(9, BodyEvent::CYLINDER, [0.027, 5e-4, 0.011], 4e-3, 5e-5);
    let parameters = Parameters { time_step: Some(Time(2e-3)), ..Parameters::with_cell(1e-3) };
    let case = Case { scene, parameters, step: 2e-3, substeps: 3, windows: 20, grains: vec![disc] };
    let whole = case.is_the_same_after(&[0, 1, 11], |threads| case.plane(threads));
    assert!(whole.fluid.state().sums.max_speed > 0.02);
}

/// Before its start a fluid has no state, and that of another scene does not fit.
#[test]
fn states_of_other_fluids_are_refused() {
    let tank = |height: u32| {
        let water = FluidMaterial::at_rest(1000.0, 1e-3);
        let scene = scene([12, 1, height], 0.01, water, Some([0.12, 0.01, 0.06]));
        let parameters = Parameters::with_cell(0.01);
        Case { scene, parameters, step: 1e-3, substeps: 1, windows: 1, grains: Vec::new() }
    };
    let mut before = tank(12).plane(1);
    assert!(SavedState::of(&mut before).unwrap_err().to_string().contains("not started"));
    let case = tank(12);
    let saved = SavedState::of(&mut case.begin(case.plane(1)).fluid).unwrap();
    assert!(saved.restore(&mut tank(16).plane(1)).is_err());
    saved.restore(&mut tank(12).plane(1)).unwrap();
}
