//! Gaps without a second fluid cell, isolated cells, bodies pressed into walls, bodies that come
//! and go: all stay finite, and bodies at rest feel nothing.

use crate::common::*;
use tremie_fluid_lbm::LbmFluid;
use tremie_messages::BodyState;
use tremie_messages::scene::{Geometry, Motion};

/// Two spheres one cell apart approach, touch, overlap slightly, and part again.
#[test]
fn two_spheres_one_cell_apart_stay_finite() {
    for gap in [1.0, 0.3] {
        let mut fluid = Case::new([32, 20, 20], [PERIODIC, WALL, WALL], 0.6).fluid();
        let mut bodies = [
            BodyState::at_rest(1, [10.4, 10.1, 9.8]),
            BodyState::at_rest(2, [18.4 + gap, 10.1, 9.8]),
        ];
        bodies[0].velocity = [0.02, 0.0, 0.0];
        bodies[1].velocity = [-0.02, 0.0, 0.0];
        fluid.apply_events(&[added(1, 4.0), added(2, 4.0)]).unwrap();
        let mut loads = loads_of(&bodies);
        fluid.start(&bodies, &mut loads).unwrap();
        let mut fallbacks = 0;
        for step in 0..200 {
            if step == 30 {
                bodies[0].velocity[0] = -0.02;
                bodies[1].velocity[0] = 0.02;
            }
            advance(&mut bodies);
            fluid.step(&bodies, &mut loads).unwrap();
            fluid.check().unwrap();
            assert!(loads.iter().all(|l| l.is_finite()));
            fallbacks += fluid.diagnostics().fallback_links;
        }
        assert!(fallbacks > 0);
        assert!(fluid.diagnostics().max_density_deviation < 0.1);
    }
}

/// Cells of a plate that moves by less than `part_step`, and so is where its links were found but
/// for a shift, are held by spheres too: each link there is one body's, neither of two nor of none.
#[test]
fn each_link_belongs_to_one_body() {
    let mut dice = Dice(11);
    let case = Case::new([24, 24, 20], [PERIODIC, SYMMETRY, WALL], 0.6);
    let mut scene = case.scene();
    let position = [2.0, 12.0, 10.3];
    let mut plate = part("plate", Geometry::Box { size: [14.0, 16.0, 5.0] }, position);
    plate.motion = Motion::Prescribed(Vec::new());
    scene.parts.push(plate);
    let parameters = tremie_fluid_lbm::Parameters { part_step: 0.2, ..case.parameters() };
    let mut fluid =
        LbmFluid::with_variant(&scene, &parameters, 1.0, case.threads, case.variant).unwrap();
    let mut bodies: Vec<BodyState> = (0..40)
        .map(|id| {
            let height = [7.8, 12.8][id as usize % 2] + dice.between(-1.0, 1.0);
            let x = dice.between(0.0, 24.0);
            BodyState::at_rest(id, [x, dice.between(0.0, 24.0), height])
        })
        .collect();
    let mut events: Vec<_> = bodies.iter().map(|body| added(body.id, 1.4)).collect();
    bodies.push(BodyState::at_rest(100, position));
    events.push(added_part(100, 0));
    fluid.apply_events(&events).unwrap();
    let mut loads = loads_of(&bodies);
    fluid.start(&bodies, &mut loads).unwrap();
    for _ in 0..60 {
        bodies[40].velocity = [0.0, 0.0, 0.01];
        advance(&mut bodies);
        fluid.step(&bodies, &mut loads).unwrap();
        assert_eq!(fluid.diagnostics().links, links_into_bodies(&fluid));
    }
}

/// Links from fluid cells into others, in a box that is periodic along x, mirrored along y and
/// walled along z.
fn links_into_bodies(fluid: &LbmFluid) -> usize {
    let n = fluid.cells().map(|n| n as i32);
    let is_solid = |at: [usize; 3]| fluid.node(at).solid;
    let mut links = 0;
    for at in cells(fluid).filter(|at| !is_solid(*at)) {
        for k in 0..27 {
            let c = [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1];
            let reach = c.iter().map(|c: &i32| c.abs()).sum::<i32>();
            let to: [i32; 3] = std::array::from_fn(|a| at[a] as i32 + c[a]);
            if (1..=2).contains(&reach) && (0..n[2]).contains(&to[2]) {
                let to = [to[0].rem_euclid(n[0]), to[1].clamp(0, n[1] - 1), to[2]];
                links += usize::from(is_solid(to.map(|k| k as usize)));
            }
        }
    }
    links
}

/// Many spheres of 2.4 cells, dropped anywhere (overlapping, cut by walls), moving at random.
#[test]
fn a_crowd_of_small_spheres_stays_finite() {
    let mut dice = Dice(7);
    let mut fluid = Case::new([24, 24, 24], [PERIODIC, WALL, PERIODIC], 0.6).fluid();
    let mut bodies: Vec<BodyState> = (0..700)
        .map(|id| BodyState::at_rest(id, std::array::from_fn(|_| dice.between(0.0, 24.0))))
        .collect();
    let events: Vec<_> = bodies.iter().map(|b| added(b.id, 1.2)).collect();
    fluid.apply_events(&events).unwrap();
    let mut loads = loads_of(&bodies);
    fluid.start(&bodies, &mut loads).unwrap();
    let mut isolated = 0;
    for step in 0..200 {
        if step % 20 == 0 {
            for body in &mut bodies {
                body.velocity = std::array::from_fn(|_| dice.between(-0.01, 0.01));
            }
        }
        advance(&mut bodies);
        fluid.step(&bodies, &mut loads).unwrap();
        fluid.check().unwrap();
        assert!(loads.iter().all(|l| l.is_finite()));
        isolated += fluid.diagnostics().isolated;
        let ledger = fluid.ledger();
        assert!((ledger.mass_change - ledger.mass_terms()).abs() < 1e-9);
    }
    assert!(isolated > 0);
}

/// At rest, in a fluid at rest, nothing acts: also not on bodies that touch, overlap or stick out
/// of a wall.
#[test]
fn bodies_at_rest_feel_only_buoyancy() {
    let mut case = Case::new([20, 20, 20], [PERIODIC, WALL, WALL], 0.8);
    case.gravity = [0.0, 0.0, -1e-3];
    let mut fluid = case.fluid();
    let bodies = [
        BodyState::at_rest(1, [0.5, 10.0, 3.0]),
        BodyState::at_rest(2, [6.4, 10.0, 3.0]),
        BodyState::at_rest(3, [13.0, 19.0, 10.0]),
    ];
    fluid.apply_events(&[added(1, 3.0), added(2, 3.0), added(3, 2.0)]).unwrap();
    let mut loads = loads_of(&bodies);
    fluid.start(&bodies, &mut loads).unwrap();
    for _ in 0..20 {
        for (load, radius) in loads.iter().zip([3.0_f64, 3.0, 2.0]) {
            let buoyancy = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3) * 1e-3;
            assert!((load.force[2] - buoyancy).abs() < 1e-15);
            assert_eq!((load.force[0], load.force[1], load.torque), (0.0, 0.0, [0.0; 3]));
        }
        fluid.step(&bodies, &mut loads).unwrap();
    }
}

/// A body that appears and disappears leaves a fluid at rest at rest.
#[test]
fn a_body_may_come_and_go() {
    let mut fluid = Case::new([16, 16, 16], [PERIODIC; 3], 0.8).fluid();
    fluid.step(&[], &mut []).unwrap();
    let mass = fluid.ledger().mass;
    for round in 0..5 {
        let body = [BodyState::at_rest(round, [8.0 + round as f64, 8.0, 15.5])];
        fluid.apply_events(&[added(round, 4.0)]).unwrap();
        let mut loads = loads_of(&body);
        fluid.step(&body, &mut loads).unwrap();
        assert!(fluid.diagnostics().covered > 200);
        fluid.apply_events(&[removed(round)]).unwrap();
        fluid.step(&[], &mut []).unwrap();
        assert!(fluid.diagnostics().uncovered > 200);
        assert_eq!(fluid.ledger().mass, mass);
        assert_eq!(fluid.diagnostics().max_speed, 0.0);
    }
}
