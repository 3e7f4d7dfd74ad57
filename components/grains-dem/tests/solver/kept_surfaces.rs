//! Grains beside surfaces that deform go on from the file of a state to the bits of those that were
//! never interrupted.

use crate::common::{walls::*, *};
use tremie_grains_dem::{AddedSphere, DeformableSurface, GrainsDem, Parameters, SurfaceState};
use tremie_messages::body::{BodyState, Load};
use tremie_messages::scene::{Damping, Geometry, Motion, Part, Scene, Slider, SliderSpring};
use tremie_state::SavedState;
use tremie_test_support::through_a_file;

const DT: f64 = 2e-6;
const SUBSTEPS: u32 = 25;
const WINDOWS: u32 = 40;
/// A sphere goes and another comes after this window.
const EXCHANGE: u32 = 20;

/// Spheres on the floor below a slider, and in a row on a beam; another beam and a cylinder rise out
/// of them.
fn trough() -> Scene {
    let mut law = law(2e3, 0.4, Damping::Restitution(0.5));
    law.rolling_friction = 0.05;
    let mut scene = scene([12e-3, 12e-3, 12e-3], WALLS, law);
    scene.gravity = [1.0, 0.5, -9.81];
    let row = |k: u32| sphere([6e-3, 3.5e-3 + 1.2e-3 * f64::from(k), 2.1e-3], 1e-3, [0.0; 3]);
    scene.bodies = vec![
        packed([0.0; 3], [4.4e-3, 12e-3, 2.4e-3], 0.35, (0.8e-3, 1e-3), 5),
        set(Motion::Free, (0..5).map(row).collect()),
    ];
    let slider = Slider {
        axis: [0.0, 0.0, 1.0],
        mass: 5e-3,
        lift: 0.0,
        velocity: -0.1,
        spring: SliderSpring::Linear { rate: 500.0, preload: 0.1 },
        force: 0.0,
        stops: None,
    };
    let carrier = Part {
        motion: Motion::Slider(Box::new(slider)),
        ..block([2.0, 2.0, 8.0], [10.0, 10.0, 9.0])
    };
    let mut post =
        part(Geometry::Cylinder { radius: 1.5e-3, length: 2e-3 }, [9.5e-3, 6e-3, 1.4e-3]);
    post.pose.orientation = [0.0, 0.6, 0.0, 0.8];
    scene.parts = vec![
        carrier,
        block([1.0, 5.5, -1.0], [4.0, 6.5, 2.6]),
        block([4.6, 1.0, -1.0], [7.4, 11.0, 1.6]),
        post,
    ];
    scene
}

/// Two blocks of rubber that stand flush.
fn seals() -> [DeformableSurface; 2] {
    let seal = |from: f64| DeformableSurface {
        seat_stiffness: 1e9,
        ..rubber([from, 3.0, 2.7], [from + 4.0, 9.0, 4.7], 6)
    };
    [seal(2.0), seal(6.0)]
}

fn begin(threads: usize) -> GrainsDem {
    let parameters = Parameters::default();
    GrainsDem::with_surfaces(&trough(), &parameters, DT, threads, &seals()).unwrap()
}

/// Places and velocities of a seal's vertices at a time [s], on a carrier at `z`: they go with it,
/// swell, and sway.
fn deformed(
    seal: &DeformableSurface,
    (time, z, vz): (f64, f64, f64),
) -> (Vec<[f64; 3]>, Vec<[f64; 3]>) {
    let (swell, turns) = (0.25e-3, 6e3);
    let at = |&[x, y, h]: &[f64; 3]| {
        let phase = turns * time + 400.0 * x + 300.0 * h;
        let (s, c) = phase.sin_cos();
        let place = [x + 0.4 * swell * s, y + 0.6 * swell * (c - 1.0), h + z + swell * (s - 0.5)];
        let rate = swell * turns;
        (place, [0.4 * rate * c, -0.6 * rate * s, vz + rate * c])
    };
    seal.vertices.iter().map(at).unzip()
}

/// Goes on from the end of window `from` to that of window `to`; gives the sums of the loads on
/// facets in all trials.
fn go_on(dem: &mut GrainsDem, (from, to): (u32, u32)) -> Vec<[f64; 4]> {
    let (seals, start) = (seals(), 8.5e-3);
    let (mut all, mut loads) = (Vec::new(), Vec::new());
    for window in from..to {
        let draw = |body: BodyState| Load {
            id: body.id,
            force: [1e-6, -1e-6, 0.0],
            torque: [0.0, 1e-10, 0.0],
        };
        let drawn: Vec<Load> = state(dem).into_iter().map(draw).collect();
        dem.begin_window(SUBSTEPS, &drawn).unwrap();
        for substep in 1..=SUBSTEPS {
            dem.begin_substep().unwrap();
            let time = f64::from(window * SUBSTEPS + substep) * DT;
            let carrier = dem.carrier_state(0).unwrap();
            let (z, vz) = (carrier.position[2] - start, carrier.velocity[2]);
            let shape = |off: f64| seals.iter().map(move |s| deformed(s, (time, z + off, vz)));
            for off in [-3e-5, 1e-5] {
                for (number, (x, v)) in shape(off).enumerate() {
                    dem.contact_on_surface(number, &x, &v, &mut loads).unwrap();
                    all.push(loads.iter().fold([0.0; 4], |sum, load| {
                        let [x, y, z] = load.force;
                        let one = [x, y, z, load.stiffness];
                        std::array::from_fn(|a| sum[a] + one[a])
                    }));
                }
            }
            let accepted: Vec<_> = shape(0.0).collect();
            let carrier_force = [0.0, 0.0, 1e-3 * f64::from(substep)];
            let state =
                |(vertices, velocities)| SurfaceState { vertices, velocities, carrier_force };
            let states: Vec<_> = accepted.iter().map(|(x, v)| state((&x[..], &v[..]))).collect();
            dem.finish_substep(&states).unwrap();
        }
        dem.end_window().unwrap();
        if window + 1 == EXCHANGE {
            let added = AddedSphere {
                set: 0,
                position: [6e-3, 1e-3, 6e-3],
                diameter: 0.9e-3,
                velocity: [0.0; 3],
            };
            dem.exchange(&[3], &[added]).unwrap();
        }
    }
    all
}

#[test]
fn grains_between_seals_and_their_seats_go_on() {
    let mut whole = begin(1);
    let loads = go_on(&mut whole, (0, WINDOWS));
    let expected = SavedState::of(&mut whole).unwrap();
    for stop in [1, EXCHANGE, 24] {
        let mut first = begin(1);
        let before = go_on(&mut first, (0, stop));
        let mut second = begin(2);
        through_a_file(&mut first, &mut second);
        assert_eq!(second.diagnostics(), first.diagnostics());
        // Keeping a state changes nothing of what follows.
        for dem in [&mut first, &mut second] {
            let after = go_on(dem, (stop, WINDOWS));
            assert!(before[..] == loads[..before.len()] && after[..] == loads[before.len()..]);
            assert!(state(dem) == state(&whole), "from window {stop}");
            assert_eq!(dem.diagnostics(), whole.diagnostics(), "from window {stop}");
            assert!(dem.sliders().eq(whole.sliders()));
            let ended = SavedState::of(dem).unwrap();
            assert_eq!(ended.first_difference(&expected), None, "from window {stop}");
        }
    }
    let seen = whole.diagnostics();
    let pressed = loads.iter().filter(|sum| sum[2] > 0.0).count();
    assert!(seen.contacts > 10 && pressed > loads.len() / 2, "{seen:?}, {pressed} trials");
}
