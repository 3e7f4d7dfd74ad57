//! Sound between a wall and a piston on a spring: the force that comes a step late feeds it, a wall's
//! velocity that is taken ahead does not (`velocity_lead`).

mod common;

use common::*;
use tremie_fluid_lbm::{Collision, FluidLbm, Parameters};
use tremie_messages::BodyState;
use tremie_messages::scene::{Geometry, Motion};

/// Energy of the piston, kinetic and of its spring, at the start and as a mean over the last 500 of
/// 4000 steps. The piston, of 60 times the mass of a cell, swings on 30 layers of 9 cells of a fluid whose
/// viscosity is 2e-4.
fn energies(velocity_lead: f64, average_force: bool) -> [f64; 2] {
    let mut case = Case::new([3, 3, 40], [SYMMETRY, SYMMETRY, WALL], 0.5006);
    case.collision = Collision::Bgk;
    let mut scene = case.scene();
    let size = [9.0, 9.0, 20.0];
    let mut piston = part("piston", Geometry::Box { size }, [1.5, 1.5, 40.0]);
    piston.motion = Motion::Prescribed(Vec::new());
    scene.parts.push(piston);
    let parameters = Parameters { velocity_lead, average_force, ..case.parameters() };
    let mut fluid = FluidLbm::with_variant(&scene, &parameters, 1.0, 1, case.variant).unwrap();
    let mut body = [BodyState::at_rest(1, [1.5, 1.5, 40.0])];
    fluid.apply_events(&[added_part(1, 0)]).unwrap();
    let mut loads = loads_of(&body);
    fluid.start(&body, &mut loads).unwrap();
    let (mass, stiffness) = (60.0, 0.01);
    body[0].velocity[2] = 1e-4;
    let energy = |body: &BodyState| {
        let (v, x) = (body.velocity[2], body.position[2] - 40.0);
        0.5 * (mass * v * v + stiffness * x * x)
    };
    let first = energy(&body[0]);
    let mut last = 0.0;
    for k in 0..4000 {
        let force = loads[0].force[2] - stiffness * (body[0].position[2] - 40.0);
        body[0].velocity[2] += force / mass;
        body[0].position[2] += body[0].velocity[2];
        if energy(&body[0]) > 1e9 * first {
            return [first, f64::INFINITY];
        }
        fluid.step(&body, &mut loads).unwrap();
        last += if k >= 3500 { energy(&body[0]) / 500.0 } else { 0.0 };
    }
    [first, last]
}

/// With the mean of two steps' forces the energy grows a hundredfold, as the rate `rho cs^2 A lag / (L M)`
/// of a lag of one step says within a factor of three; with the wall's velocity taken a step ahead it
/// decays.
#[test]
fn a_lagging_force_feeds_sound() {
    let grows = |lead: f64| {
        let [first, last] = energies(lead, true);
        println!("{lead}: the energy is {:.3e} times as large", last / first);
        last / first
    };
    let rate: f64 = 9.0 / (3.0 * 30.0 * 60.0);
    let (late, ahead) = (grows(0.0), grows(1.0));
    // From the start to the middle of the last 500 steps.
    assert!(late > 20.0 && late.ln() < 3.0 * 3750.0 * rate && late.ln() > 3750.0 * rate / 3.0);
    assert!(ahead < 0.5);
}

/// Without that mean the lattice's two-step oscillation would be fed instead.
#[test]
fn a_lead_needs_the_mean_of_two_steps() {
    let case = Case::new([4; 3], [WALL; 3], 0.8);
    let lead = |velocity_lead, average_force| {
        let parameters = Parameters { velocity_lead, average_force, ..case.parameters() };
        parameters.resolve(&case.scene())
    };
    assert!(lead(1.0, true).is_ok() && lead(0.0, false).is_ok());
    for (velocity_lead, average_force) in [(1.0, false), (3.0, true), (-1.0, true)] {
        let problems = lead(velocity_lead, average_force).unwrap_err();
        assert!(problems[0].key.ends_with("velocity_lead"), "{problems:?}");
    }
}

/// Spheres are not taken ahead: a lead changes no bit of their loads.
#[test]
fn spheres_have_the_velocities_that_are_given() {
    let case = Case::new([12; 3], [WALL; 3], 0.8);
    let loads = |velocity_lead: f64| {
        let parameters = Parameters { velocity_lead, average_force: true, ..case.parameters() };
        let mut fluid =
            FluidLbm::with_variant(&case.scene(), &parameters, 1.0, 1, case.variant).unwrap();
        let mut body = [BodyState::at_rest(1, [6.0; 3])];
        fluid.apply_events(&[added(1, 2.0)]).unwrap();
        let mut loads = loads_of(&body);
        fluid.start(&body, &mut loads).unwrap();
        for k in 0..20 {
            body[0].velocity[0] = 1e-3 * f64::from(k % 7);
            body[0].angular_velocity[1] = 1e-4 * f64::from(k);
            body[0].position[0] += body[0].velocity[0];
            fluid.step(&body, &mut loads).unwrap();
        }
        loads
    };
    let given = loads(0.0);
    assert!(given[0].force[0] != 0.0);
    assert_eq!(given, loads(1.0));
}
