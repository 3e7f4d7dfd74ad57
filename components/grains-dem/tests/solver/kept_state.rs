//! Grains that go on from the file of a state end with the bits of those that were never
//! interrupted.

use crate::common::{solids::*, walls::*, *};
use tremie_grains_dem::{GrainsDem, Parameters};
use tremie_messages::body::Load;
use tremie_messages::scene::{
    BinnedAxis, BodySet, Course, Damping, Diameters, Face, Geometry, GrainProfile, Inlet,
    InletVelocity, Motion, Outflow, Outlet, Part, Probe, ProbeShape, ProfileVelocity, Scene,
    Slider, SliderSpring,
};
use tremie_state::SavedState;
use tremie_test_support::through_a_file;

/// A scene in windows of some steps.
struct Case {
    scene: Scene,
    step: f64,
    substeps: u32,
    windows: usize,
    /// With a fluid that draws all bodies to the middle.
    has_fluid: bool,
}

impl Case {
    fn begin(&self, threads: usize) -> GrainsDem {
        let parameters = Parameters { skin: Some(0.1), ..Parameters::default() };
        let mut dem = GrainsDem::new(&self.scene, &parameters, self.step, threads).unwrap();
        dem.measure_profiles(&self.scene, f64::from(self.substeps) * self.step);
        dem
    }

    fn go_on(&self, dem: &mut GrainsDem, windows: usize) {
        let middle = [0, 1, 2].map(|a| 0.5 * self.scene.domain.max[a]);
        for _ in 0..windows {
            let draw = |body: &tremie_messages::body::BodyState| Load {
                id: body.id,
                force: [0, 1, 2].map(|a| 1e-2 * (middle[a] - body.position[a])),
                torque: [1e-9, 0.0, -1e-9],
            };
            let bodies = if self.has_fluid { state(dem) } else { Vec::new() };
            let loads: Vec<Load> = bodies.iter().map(draw).collect();
            dem.advance(self.substeps, &loads).unwrap();
        }
    }

    fn is_the_same_after(&self, stops: &[usize]) -> GrainsDem {
        let mut whole = self.begin(1);
        self.go_on(&mut whole, self.windows);
        let expected = SavedState::of(&mut whole).unwrap();
        for &stop in stops {
            let mut first = self.begin(1);
            self.go_on(&mut first, stop);
            let mut second = self.begin(2);
            through_a_file(&mut first, &mut second);
            assert!(second.events() == first.events());
            assert_eq!(second.diagnostics(), first.diagnostics());
            assert_eq!(second.face_forces(), first.face_forces());
            self.go_on(&mut second, self.windows - stop);
            // Keeping a state changes nothing of what follows.
            self.go_on(&mut first, self.windows - stop);
            assert!(state(&first) == state(&whole), "after window {stop}");
            assert!(state(&second) == state(&whole), "from window {stop}");
            assert_eq!(second.diagnostics(), whole.diagnostics(), "from window {stop}");
            assert_eq!(values(&mut second), values(&mut whole), "from window {stop}");
            let ended = SavedState::of(&mut second).unwrap();
            assert_eq!(ended.first_difference(&expected), None, "from window {stop}");
        }
        whole
    }
}

fn values(dem: &mut GrainsDem) -> Vec<f64> {
    let mut values = Vec::new();
    dem.read_probes(&mut values);
    values.extend(dem.part_loads().flat_map(|(force, torque)| [force, torque].concat()));
    values
}

/// Spheres on a floor with friction that slides and rolls, and a part that turns.
fn floor() -> Scene {
    let mut law = law(1e3, 0.5, Damping::Restitution(0.6));
    law.rolling_friction = 0.1;
    let mut scene = scene([8e-3, 8e-3, 20e-3], FLOOR, law);
    scene.gravity = [10.0, 3.0, -100.0];
    scene.bodies = vec![packed([0.0; 3], [8e-3, 8e-3, 10e-3], 0.4, (0.7e-3, 0.9e-3), 2)];
    scene.parts = vec![paddle([4e-3, 4e-3, 2e-3])];
    scene
}

/// Spheres fall through periodic sides onto a floor with a part that turns, with friction that
/// slides and rolls, past a section, into a profile.
#[test]
fn spheres_on_a_floor_go_on() {
    let mut scene = floor();
    let section = ProbeShape::Section { axis: 2, position: 4e-3, min: [0.0; 3], max: [8e-3; 3] };
    scene.probes = vec![Probe { name: "section".into(), shape: section }];
    scene.profiles = vec![GrainProfile {
        name: "height".into(),
        axes: vec![BinnedAxis { axis: 2, bins: 8 }],
        min: [0.0; 3],
        max: [8e-3, 8e-3, 16e-3],
        from: 0.0,
        every: None,
        average: None,
        velocity: ProfileVelocity::Displacement,
    }];
    for has_fluid in [false, true] {
        let scene = scene.clone();
        let case = Case { scene, step: 4e-6, substeps: 40, windows: 40, has_fluid };
        let mut whole = case.is_the_same_after(&[0, 1, 17]);
        let seen = whole.diagnostics();
        assert!(seen.list_rebuilds > 2 && seen.contacts > 500, "{seen:?}");
    }
}

/// A run of other components begins with the bodies of another: where they are, and with the springs of
/// their friction. What was counted before is not theirs.
#[test]
fn bodies_and_contacts_begin_a_run_of_their_own() {
    // What moves along a path goes from time to time, and these are rounded.
    let scene = Scene { parts: Vec::new(), ..floor() };
    let case = Case { scene, step: 4e-6, substeps: 40, windows: 0, has_fluid: false };
    let mut first = case.begin(1);
    case.go_on(&mut first, 30);
    let kept = SavedState::of(&mut first).unwrap();
    let take = |dem: &mut GrainsDem| {
        kept.put_back(|state| dem.take_bodies(state).map(|()| state.leave_rest()))
    };
    let mut second = case.begin(2);
    take(&mut second).unwrap();
    let (before, after) = (first.diagnostics(), second.diagnostics());
    assert!(before.contacts > 500 && after.contacts == before.contacts);
    assert!(before.max_overlap_ratio > 0.0 && after.max_overlap_ratio == 0.0);
    case.go_on(&mut first, 10);
    case.go_on(&mut second, 10);
    assert!(state(&second) == state(&first));
    assert!(second.diagnostics().contacts > 500);

    let mut fewer = case.scene.clone();
    fewer.bodies = vec![packed([0.0; 3], [8e-3, 8e-3, 10e-3], 0.2, (0.7e-3, 0.9e-3), 2)];
    let why = take(&mut Case { scene: fewer, ..case }.begin(1)).unwrap_err().to_string();
    assert!(why.contains("bodies, expected at most"), "{why}");
}

/// Polyhedra, clumps and spheres fall on a plate on a spring.
#[test]
fn polyhedra_and_clumps_on_a_plate_go_on() {
    let mut scene = scene([20e-3; 3], WALLS, law(2e3, 0.5, Damping::Restitution(0.5)));
    scene.gravity = [0.5, 0.0, -9.81];
    scene.shapes = vec![shape("cube"), wedge()];
    let spring = SliderSpring::Linear { rate: 625.0, preload: 0.05 };
    let slider = Slider {
        axis: [0.0, 0.0, 1.0],
        mass: 9.2e-3,
        lift: 0.0,
        velocity: 0.1,
        spring,
        force: 0.0,
        stops: None,
    };
    scene.parts = vec![Part {
        name: "plate".into(),
        motion: Motion::Slider(Box::new(slider)),
        ..part(Geometry::Box { size: [16e-3, 16e-3, 2e-3] }, [10e-3, 10e-3, 5e-3])
    }];
    let places = |k: u32| [0, 1].map(|a| 5e-3 + 5e-3 * f64::from(k / 3u32.pow(a) % 3));
    let at = |k: u32, z: f64| [places(k)[0], places(k)[1], z];
    let some = |z: f64| (0..9).map(move |k| solid(at(k, z), 2.5e-3, [0.1, 0.0, -0.3])).collect();
    let bar = |k: u32| {
        let [x, y, z] = at(k, 14e-3);
        let spheres = [-1e-3, 1e-3].map(|d| sphere([x + d, y, z], 2e-3, [0.0; 3])).to_vec();
        let set = set(Motion::Free, spheres);
        BodySet { name: format!("bar{k}"), clump: Some(format!("bar{k}")), ..set }
    };
    scene.bodies = vec![solids("cube", some(8.5e-3)), solids("wedge", some(11.2e-3))];
    scene.bodies.extend((0..3).map(bar));
    let case = Case { scene, step: 2e-6, substeps: 50, windows: 120, has_fluid: false };
    let mut whole = case.is_the_same_after(&[1, 60]);
    let seen = whole.diagnostics();
    assert!(seen.list_rebuilds > 2 && seen.contacts > 3, "{seen:?}");
}

/// Spheres come at an inlet and go at an outlet.
#[test]
fn a_stream_goes_on() {
    let open =
        || Face::Pressure { pressure: 0.0, course: Course::default(), outflow: Outflow::Fixed };
    let mut faces = FLOOR;
    faces[2] = [open(), open()];
    let mut scene = scene([6e-3, 6e-3, 10e-3], faces, law(1e3, 0.3, Damping::Restitution(0.6)));
    scene.bodies = vec![set(Motion::Free, vec![])];
    scene.inlets = vec![Inlet {
        name: "feed".into(),
        bodies: "free".into(),
        min: [0.0; 3],
        max: [6e-3, 6e-3, 4e-3],
        fraction: 0.2,
        diameters: Diameters::Uniform { min: 0.7e-3, max: 0.9e-3 },
        every: None,
        velocity: InletVelocity::Given([0.0, 0.0, 1.0]),
        until: None,
        seed: 7,
        tries: Inlet::TRIES,
    }];
    scene.outlets = vec![Outlet { name: "drain".into(), axis: 2, at: 10e-3, side: 1 }];
    let case = Case { scene, step: 5e-6, substeps: 25, windows: 120, has_fluid: false };
    let whole = case.is_the_same_after(&[1, 50, 100]);
    assert!(whole.outlets().next().unwrap().removed > 10);
}
