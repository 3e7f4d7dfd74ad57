//! Sound between a wall and a piston on a spring: the force that comes a step late feeds it, a
//! wall's velocity that is taken ahead does not (`velocity_lead`).

use crate::common::*;
use tremie_fluid_lbm::{Collision, LbmFluid, Parameters, Refill};
use tremie_messages::scene::{Geometry, Motion};
use tremie_messages::{BodyEvent, BodyState, Load};

/// Energy of the piston, kinetic and of its spring, at the start and as a mean over the last 500 of
/// 4000 steps. The piston, of 60 times the mass of a cell, swings on 30 layers of 9 cells of a
/// fluid whose viscosity is 2e-4, and `offset` above the end of a cell.
fn energies(velocity_lead: f64, average_force: bool, offset: f64, refill: Refill) -> [f64; 2] {
    let mut case = Case::new([3, 3, 40], [SYMMETRY, SYMMETRY, WALL], 0.5006);
    (case.collision, case.refill) = (Collision::Bgk, refill);
    let mut scene = case.scene();
    let (size, home) = ([9.0, 9.0, 20.0], 40.0 + offset);
    let mut piston = part("piston", Geometry::Box { size }, [1.5, 1.5, home]);
    piston.motion = Motion::Prescribed(Vec::new());
    scene.parts.push(piston);
    let parameters = Parameters { velocity_lead, average_force, ..case.parameters() };
    let mut fluid = LbmFluid::with_variant(&scene, &parameters, 1.0, 1, case.variant).unwrap();
    let mut body = [BodyState::at_rest(1, [1.5, 1.5, home])];
    fluid.apply_events(&[added_part(1, 0)]).unwrap();
    let mut loads = loads_of(&body);
    fluid.start(&body, &mut loads).unwrap();
    let (mass, stiffness) = (60.0, 0.01);
    body[0].velocity[2] = 1e-4;
    let energy = |body: &BodyState| {
        let (v, x) = (body.velocity[2], body.position[2] - home);
        0.5 * (mass * v * v + stiffness * x * x)
    };
    let first = energy(&body[0]);
    let mut last = 0.0;
    for k in 0..4000 {
        let force = loads[0].force[2] - stiffness * (body[0].position[2] - home);
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

/// With the mean of two steps' forces the energy grows a hundredfold, as the rate `rho cs^2 A lag /
/// (L M)` of a lag of one step says within a factor of three; with the wall's velocity taken a step
/// ahead it decays.
#[test]
fn a_lagging_force_feeds_sound() {
    let grows = |lead: f64| {
        let [first, last] = energies(lead, true, 0.0, Refill::Eqneq);
        println!("{lead}: the energy is {:.3e} times as large", last / first);
        last / first
    };
    let rate: f64 = 9.0 / (3.0 * 30.0 * 60.0);
    let (late, ahead) = (grows(0.0), grows(1.0));
    // From the start to the middle of the last 500 steps.
    assert!(late > 20.0 && late.ln() < 3.0 * 3750.0 * rate && late.ln() > 3750.0 * rate / 3.0);
    assert!(ahead < 0.5);
}

/// Wherever in a cell the piston stands: a wall whose velocity is that of half a step in all its
/// links, or which pays within tens of steps what the density between it and the last cells
/// borrows, feeds sound all but half-way.
#[test]
fn where_a_wall_stands_feeds_no_sound() {
    for refill in [Refill::Eqneq, Refill::Mass] {
        for offset in [-0.45, -0.2, 0.2, 0.45] {
            let [first, last] = energies(1.0, true, offset, refill);
            println!("{refill:?}, {offset}: the energy is {:.2e} times as large", last / first);
            assert!(last < 0.5 * first, "{refill:?} at {offset}: {}", last / first);
        }
    }
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

/// Energy of a sphere on a weak spring, knocked across a slit between mirrors that is half as wide
/// again, as a mean over the last 500 of 3000 steps, over that of the knock. The viscosity is next
/// to nothing.
fn energy_in_a_slit(velocity_lead: f64) -> f64 {
    let mut case = Case::new([14, 14, 4], [WALL, WALL, SYMMETRY], 0.500008);
    case.collision = Collision::Bgk;
    case.smagorinsky = 0.4;
    let parameters = Parameters { velocity_lead, average_force: true, ..case.parameters() };
    let mut fluid =
        LbmFluid::with_variant(&case.scene(), &parameters, 1.0, 1, case.variant).unwrap();
    let (mass, stiffness) = (23.0, 0.01);
    let home = [7.1, 6.8, 2.0];
    let mut body = [BodyState::at_rest(1, home)];
    fluid.apply_events(&[BodyEvent { mass, ..added(1, 1.3) }]).unwrap();
    let mut loads = loads_of(&body);
    fluid.start(&body, &mut loads).unwrap();
    body[0].velocity = [1e-5, 5e-6, 2e-5];
    let energy = |v: [f64; 3]| 0.5 * mass * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    let first = energy(body[0].velocity);
    let mut last = 0.0;
    for k in 0..3000 {
        for a in 0..3 {
            let force = loads[0].force[a] - stiffness * (body[0].position[a] - home[a]);
            body[0].velocity[a] += force / mass;
            body[0].position[a] += body[0].velocity[a];
        }
        if fluid.step(&body, &mut loads).is_err() {
            return f64::INFINITY;
        }
        last += if k >= 2500 { energy(body[0].velocity) / 500.0 } else { 0.0 };
    }
    last / first
}

/// Free spheres feed sound too, between walls hardly farther apart than they are wide: less than a
/// tenth of it where they are taken ahead.
#[test]
fn a_sphere_feeds_the_sound_in_a_slit() {
    let (late, ahead) = (energy_in_a_slit(0.0), energy_in_a_slit(1.0));
    println!("energy {late:.2e} and {ahead:.2e}");
    assert!(late > 100.0 && ahead < 0.1 * late);
}

/// Loads on a sphere that is given other velocities in each step.
fn loads_under_jolts(velocity_lead: f64, motion: u32, jolt: f64) -> Vec<Load> {
    let case = Case::new([12; 3], [WALL; 3], 0.8);
    let parameters = Parameters { velocity_lead, average_force: true, ..case.parameters() };
    let mut fluid =
        LbmFluid::with_variant(&case.scene(), &parameters, 1.0, 1, case.variant).unwrap();
    let mut body = [BodyState::at_rest(1, [6.0; 3])];
    fluid.apply_events(&[BodyEvent { motion, mass: 1e9, ..added(1, 2.0) }]).unwrap();
    let mut loads = loads_of(&body);
    fluid.start(&body, &mut loads).unwrap();
    for k in 0..20 {
        body[0].velocity[0] = jolt * f64::from(k % 7);
        body[0].angular_velocity[1] = 1e-4 * f64::from(k);
        body[0].position[0] += body[0].velocity[0];
        fluid.step(&body, &mut loads).unwrap();
    }
    loads
}

/// Jolts of contacts in the velocity of a sphere are not taken ahead by its wall: a heavy one,
/// which the fluid hardly moves, has the loads that it has without a lead. One whose motion is
/// prescribed has them to the bit.
#[test]
fn jolts_are_not_taken_ahead() {
    let given = loads_under_jolts(0.0, BodyEvent::FREE, 1e-3);
    let ahead = loads_under_jolts(1.0, BodyEvent::FREE, 1e-3);
    assert!(given[0].force[0].abs() > 1e-3);
    assert!((ahead[0].force[0] / given[0].force[0] - 1.0).abs() < 1e-6, "{ahead:?} {given:?}");
    let fixed = |lead| loads_under_jolts(lead, BodyEvent::PRESCRIBED, 1e-3);
    assert_eq!(fixed(0.0), fixed(1.0));
}
