//! Bodies that come and go in the middle of a run.

use crate::common::*;
use tremie_fluid_lbm::{LbmFluid, Refill};
use tremie_messages::BodyState;
use tremie_messages::scene::{Course, Face, Outflow, Reservoir};

fn reservoirs_mass(fluid: &LbmFluid) -> Vec<f64> {
    let mut states = Vec::new();
    fluid.reservoirs(&mut states);
    states.iter().map(|state| state.mass).collect()
}

fn reservoir_pressure(fluid: &LbmFluid) -> f64 {
    let mut states = Vec::new();
    fluid.reservoirs(&mut states);
    states[0].pressure
}

/// A tube of 36 x 14 x 14 cells, with reservoirs of these lengths at its ends, whose pistons stand
/// still.
fn tube(refill: Refill, lengths: [Option<f64>; 2]) -> LbmFluid {
    let mut case = Case::new([36, 14, 14], [WALL, WALL, WALL], 0.6);
    case.refill = refill;
    let mut scene = case.scene();
    let area = 14.0 * 14.0;
    scene.fluid.as_mut().unwrap().pressure = 4e-3;
    for (face, length) in scene.domain.faces[0].iter_mut().zip(lengths) {
        if let Some(length) = length {
            *face = Face::Reservoir(Reservoir::new(area, area * length, 0.0));
        }
    }
    case.fluid_of(&scene)
}

/// A piston feeds a tube of 36 x 14 x 14 cells, which is open at the far end. Spheres appear near the
/// piston, float along and vanish, a twelfth of what the piston displaces: the flow through the face is
/// the piston's all the same, within 0.3 %, for a sphere takes the place of as much fluid.
#[test]
fn spheres_that_appear_take_the_place_of_fluid() {
    for refill in [Refill::Eqneq, Refill::Mass] {
        let mut case = Case::new([36, 14, 14], [WALL, SYMMETRY, SYMMETRY], 0.6);
        case.refill = refill;
        let mut scene = case.scene();
        let (area, speed, radius) = (14.0 * 14.0, 0.01, 3.4_f64);
        let mut reservoir = Reservoir::new(area, area * 600.0, speed);
        reservoir.course = Course::Points(vec![[0.0, 0.0], [400.0, 1.0]]);
        scene.domain.faces[0] = [
            Face::Reservoir(reservoir),
            Face::Pressure { pressure: 0.0, course: Course::CONSTANT, outflow: Outflow::Fixed },
        ];
        let mut fluid = case.fluid_of(&scene);
        let mut bodies: Vec<BodyState> = Vec::new();
        fluid.start(&bodies, &mut []).unwrap();
        // 165 cells of a sphere in 1000 steps of 1.96 cells.
        let (mut mean, mut steps) = (0.0, 0.0);
        for step in 0..12_000_u64 {
            if step % 1000 == 0 {
                let place = BodyState::at_rest(step, [5.2, 7.3, 6.6]);
                bodies.push(BodyState { velocity: [speed, 0.0, 0.0], ..place });
                fluid.apply_events(&[added(step, radius)]).unwrap();
            }
            if bodies.first().is_some_and(|body| body.position[0] > 26.0) {
                fluid.apply_events(&[removed(bodies.remove(0).id)]).unwrap();
            }
            advance(&mut bodies);
            fluid.step(&bodies, &mut loads_of(&bodies)).unwrap();
            closes(&fluid, 1e-9);
            if step >= 4000 {
                let mut states = Vec::new();
                fluid.reservoirs(&mut states);
                (mean, steps) = (mean + states[0].velocity, steps + 1.0);
            }
        }
        let error = mean / steps / speed - 1.0;
        println!("{refill:?}: flow through the face {error:+.2e}");
        assert!(error.abs() < 0.003, "{refill:?}: {error}");
    }
}

/// A sphere moves out of a reservoir through its face into a tube that is closed, and back. What leaves
/// the reservoir as a sphere comes back as fluid, so neither pressure nor mass changes for good: by less
/// than 3 % of what its volume would make, or 5 % where links and cells of bodies keep no account of the
/// mass that they take.
#[test]
fn a_sphere_that_crosses_a_reservoirs_face_changes_no_pressure() {
    for (refill, most) in [(Refill::Eqneq, 0.05), (Refill::Mass, 0.03)] {
        let mut fluid = tube(refill, [Some(30.0), None]);
        let radius = 3.4_f64;
        let volume = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
        let before = fluid.ledger().mass + reservoirs_mass(&fluid)[0];
        let pressure = reservoir_pressure(&fluid);
        // Of the sphere's volume among that of tube and reservoir.
        let unit = volume / (14.0 * 14.0 * 66.0) / 3.0;
        let mut bodies = vec![BodyState::at_rest(7, [-4.0, 7.3, 6.6])];
        fluid.apply_events(&[added(7, radius)]).unwrap();
        fluid.start(&bodies, &mut loads_of(&bodies)).unwrap();
        for (way, speed) in [("in", 0.01), ("out", -0.01)] {
            bodies[0].velocity[0] = speed;
            for _ in 0..1400 {
                advance(&mut bodies);
                fluid.step(&bodies, &mut loads_of(&bodies)).unwrap();
                closes(&fluid, 1e-10);
            }
            bodies[0].velocity[0] = 0.0;
            for _ in 0..6000 {
                fluid.step(&bodies, &mut loads_of(&bodies)).unwrap();
            }
            let change = (reservoir_pressure(&fluid) - pressure) / unit;
            println!("{refill:?} {way}: {change:+.3} of what its volume makes");
            assert!(change.abs() < most, "{refill:?} {way}: {change}");
        }
        let after = fluid.ledger().mass + reservoirs_mass(&fluid)[0];
        println!("{refill:?}: mass {:+.3} of the sphere's", (after - before) / volume);
        assert!((after - before).abs() < most * volume);
    }
}

/// Cells of a body that goes are fluid again, at the density and velocity around, and the balance
/// closes.
#[test]
fn cells_of_a_body_that_goes_are_filled_with_the_fluid_around() {
    for refill in [Refill::Eqneq, Refill::Mass] {
        let mut case = Case::new([24, 20, 22], [PERIODIC, WALL, WALL], 0.7);
        case.refill = refill;
        let mut scene = case.scene();
        scene.fluid.as_mut().unwrap().pressure = 4e-3;
        let mut fluid = case.fluid_of(&scene);
        fluid.start(&[], &mut []).unwrap();
        let cells = fluid.diagnostics().fluid_cells;
        let density = fluid.ledger().mass / cells as f64;
        let bodies = [BodyState::at_rest(3, [11.7, 10.2, 9.9])];
        for round in 0..3 {
            fluid.apply_events(&[added(round, 4.2)]).unwrap();
            let bodies = bodies.map(|body| BodyState { id: round, ..body });
            let mut loads = loads_of(&bodies);
            for _ in 0..10 {
                fluid.step(&bodies, &mut loads).unwrap();
                closes(&fluid, 1e-10);
            }
            assert!(fluid.diagnostics().fluid_cells < cells - 280);
            fluid.apply_events(&[removed(round)]).unwrap();
            for _ in 0..10 {
                fluid.step(&[], &mut []).unwrap();
                closes(&fluid, 1e-10);
            }
            assert_eq!(fluid.diagnostics().fluid_cells, cells);
            let now = fluid.ledger().mass / cells as f64;
            assert!((now / density - 1.0).abs() < 1e-12, "{now} {density}");
        }
    }
}
