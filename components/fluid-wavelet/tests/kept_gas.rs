//! A gas that goes on from the file of a state ends with the bits of one that was never interrupted.

use std::collections::BTreeMap;
use tremie_fluid_wavelet::{GasFluid, Parameters};
use tremie_messages::scene::{Domain, Face, FluidMaterial, GasMaterial, Scene, Shock};
use tremie_messages::{BodyEvent, BodyState, Load};
use tremie_state::SavedState;
use tremie_test_support::through_a_file;

const CELL: f64 = 0.01;
const STEP: f64 = 2e-5;

/// Gas in a box of 64 by 32 points, or 32 by 32 by 32, and a shock that runs up it.
fn scene(dimensions: usize) -> Scene {
    let size =
        if dimensions == 2 { [64, 1, 32] } else { [32, 32, 32] }.map(|n| CELL * f64::from(n));
    let mut domain = Domain::new([0.0; 3], size, Face::WALLS);
    domain.across = (dimensions == 2).then_some(1);
    let gas = GasMaterial {
        pressure: 1e5,
        temperature: 293.15,
        heat_ratio: 1.4,
        prandtl: 0.72,
        sutherland: 110.4,
        surface_temperatures: BTreeMap::new(),
        regions: Vec::new(),
        shock: Some(Shock { axis: 0, position: 0.08, direction: 1.0, mach: 1.5 }),
        vortex: None,
    };
    let fluid = FluidMaterial { gas: Some(gas), ..FluidMaterial::at_rest(1.2, 1.8e-5) };
    Scene { fluid: Some(fluid), ..Scene::empty(domain) }
}

/// A body that the run has from its start: a disc of a plane scene, a sphere in space.
fn added(dimensions: usize) -> BodyEvent {
    let is_plane = dimensions == 2;
    BodyEvent {
        id: 3,
        kind: BodyEvent::ADDED,
        shape: if is_plane { BodyEvent::CYLINDER } else { BodyEvent::SPHERE },
        motion: BodyEvent::FREE,
        set: 0,
        mass: 1.0,
        size: [0.04, if is_plane { CELL } else { 0.0 }, 0.0],
        table: 0,
    }
}

/// Where the body is at the end of a window: it goes along on a curve, and turns.
fn place(dimensions: usize, window: u64) -> BodyState {
    let time = window as f64 * STEP;
    let y = if dimensions == 2 { 0.5 * CELL } else { 0.16 };
    BodyState {
        velocity: [40.0, 0.0, 9.0 - 1e4 * time],
        angular_velocity: [0.0, 300.0, 0.0],
        ..BodyState::at_rest(3, [0.17 + 40.0 * time, y, 0.16 + 9.0 * time - 5e3 * time * time])
    }
}

fn begin(dimensions: usize, threads: usize) -> GasFluid {
    let parameters = Parameters::with_cell(CELL);
    GasFluid::new(&scene(dimensions), &parameters, STEP, threads).unwrap()
}

fn advance(
    fluid: &mut GasFluid,
    dimensions: usize,
    windows: std::ops::RangeInclusive<u64>,
) -> Vec<Load> {
    let mut loads = [Load::default()];
    for window in windows {
        let states = [place(dimensions, window)];
        if window == 0 {
            fluid.apply_events(&[added(dimensions)]).unwrap();
            fluid.start(&states, &mut loads).unwrap();
        } else {
            fluid.advance(1, &states, &mut loads).unwrap();
        }
    }
    loads.to_vec()
}

#[test]
fn a_shock_goes_on_past_a_body_that_moves() {
    for (dimensions, last) in [(2, 12), (3, 4)] {
        let mut whole = begin(dimensions, 1);
        let expected_loads = advance(&mut whole, dimensions, 0..=last);
        let expected = SavedState::of(&mut whole).unwrap();
        for stop in [0, 1, last / 2] {
            let mut first = begin(dimensions, 1);
            advance(&mut first, dimensions, 0..=stop);
            let mut second = begin(dimensions, 2);
            through_a_file(&mut first, &mut second);
            assert_eq!(second.state().sums, first.state().sums);
            let loads = advance(&mut second, dimensions, stop + 1..=last);
            assert_eq!(loads, expected_loads, "in {dimensions} dimensions from window {stop}");
            let ended = SavedState::of(&mut second).unwrap();
            assert_eq!(ended.first_difference(&expected), None, "from window {stop}");
        }
    }
}
