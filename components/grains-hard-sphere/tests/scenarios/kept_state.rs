//! A run that goes on from the file of a state ends with the bits of one that was never interrupted.

use crate::common::{block, by, gas, scene, set, sphere, unit};
use tremie_grains_hard_sphere::{Detection, HardSpheres, Parameters};
use tremie_messages::Load;
use tremie_messages::scene::{Face, Motion, MotionPoint, Scene};
use tremie_state::SavedState;
use tremie_test_support::through_a_file;

/// A run in windows of some steps, with the loads that a body at such a place would feel.
struct Case {
    scene: Scene,
    parameters: Parameters,
    step: f64,
    substeps: u32,
    has_fluid: bool,
}

impl Case {
    fn begin(&self, threads: usize) -> HardSpheres {
        HardSpheres::new(&self.scene, &self.parameters, self.step, threads).unwrap()
    }

    fn go_on(&self, spheres: &mut HardSpheres, windows: usize) {
        for _ in 0..windows {
            let load = |id: usize| {
                let [x, y, z] = if id < spheres.sphere_count() {
                    spheres.sphere(id).position
                } else {
                    [0.0; 3]
                };
                Load { id: id as u64, force: [0.3 - y, 0.2 - z, 0.1 - x], torque: [1e-3 * x; 3] }
            };
            let bodies = if self.has_fluid { spheres.body_count() } else { 0 };
            let loads: Vec<Load> = (0..bodies).map(load).collect();
            spheres.advance(self.substeps, &loads).unwrap();
        }
    }

    /// Goes on from a file after each of `stops` windows, on another number of threads.
    fn is_the_same_after(&self, stops: &[usize]) {
        let most = stops.iter().max().unwrap() + 20;
        let mut whole = self.begin(1);
        self.go_on(&mut whole, most);
        let expected = SavedState::of(&mut whole).unwrap();
        for &stop in stops {
            let mut first = self.begin(1);
            self.go_on(&mut first, stop);
            let mut second = self.begin(2);
            through_a_file(&mut first, &mut second);
            assert_eq!(second.events(), first.events());
            assert_eq!(second.diagnostics(), first.diagnostics());
            self.go_on(&mut second, most - stop);
            let ended = SavedState::of(&mut second).unwrap();
            assert_eq!(ended.first_difference(&expected), None, "from window {stop}");
            assert_eq!(second.diagnostics(), whole.diagnostics());
            assert_eq!(second.part_loads(), whole.part_loads());
        }
    }
}

#[test]
fn a_gas_goes_on_from_event_to_event() {
    let case = Case {
        scene: gas(3, 4, 0.3, (0.9, 0.3), 4),
        parameters: by(Detection::Events),
        step: 0.02,
        substeps: 1,
        has_fluid: false,
    };
    case.is_the_same_after(&[0, 1, 30]);
}

/// Grains that fall on a floor, on a fixed block and on each other come to rest.
#[test]
fn grains_on_a_block_go_on() {
    let mut scene = scene([1.0; 3], Face::WALLS, 0.6, 0.3);
    scene.gravity = [0.0, 0.0, -9.81];
    scene.parts = vec![block([0.4, 0.3, 0.2], [0.5, 0.5, 0.2], Motion::Fixed)];
    let grains = (0..48u64).map(|k| {
        let place = [k % 4, k / 4 % 4, k / 16].map(|n| 0.125 + 0.25 * n as f64);
        let place = [place[0], place[1], 0.45 + 0.5 * place[2]];
        sphere(place, 0.08, [0, 1, 2].map(|a| unit(3, 3 * k + a) - 0.5))
    });
    scene.bodies = vec![set(Motion::Free, 1000.0, grains.collect())];
    for (detection, substeps) in [(Detection::Events, 5), (Detection::Steps, 5)] {
        let case = Case {
            scene: scene.clone(),
            parameters: by(detection),
            step: 1e-3,
            substeps,
            has_fluid: false,
        };
        case.is_the_same_after(&[1, 60, 150]);
    }
}

/// A fluid's loads, a block that turns, and a sphere that is led.
#[test]
fn grains_in_a_fluid_go_on_beside_what_is_led() {
    let point = |time: f64, speed: f64| MotionPoint {
        time,
        velocity: [speed, 0.0, 0.0],
        angular_velocity: [0.0, 2.0 * speed, 1.0],
    };
    let led = Motion::Prescribed(vec![point(0.0, 0.5), point(0.1, -0.5), point(0.3, 0.4)]);
    let mut scene = scene([1.0; 3], Face::WALLS, 0.7, 0.2);
    scene.domain.faces[0] = [Face::Periodic, Face::Periodic];
    scene.parts = vec![block([0.2; 3], [0.5, 0.5, 0.3], led.clone())];
    let grains = (0..32u64).map(|k| {
        let place = [k % 4, k / 4 % 4, k / 16].map(|n| 0.125 + 0.25 * n as f64);
        sphere([place[0], place[1], place[2] + 0.4], 0.1, [0.0; 3])
    });
    scene.bodies = vec![
        set(Motion::Free, 1000.0, grains.collect()),
        set(led, 1000.0, vec![sphere([0.5, 0.5, 0.9], 0.15, [0.0; 3])]),
    ];
    let case =
        Case { scene, parameters: by(Detection::Steps), step: 1e-3, substeps: 4, has_fluid: true };
    case.is_the_same_after(&[0, 25, 70]);
}
