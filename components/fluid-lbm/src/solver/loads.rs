//! Loads on the bodies: what their links exchanged, what gaps press, images in symmetry planes,
//! buoyancy.

use crate::bodies::body::Body;
use crate::lattice::ledger::add_scaled;
use crate::lattice::populations::Real;
use crate::solver::budget::Budget;
use crate::solver::gap_model::GapModel;
use crate::solver::lattice_state::LatticeState;
use crate::solver::moving_bodies::MovingBodies;
use tremie_fluid_kit::cells::grid::Grid;
use tremie_fluid_kit::survey::mirrors::{mirrors_of_part, near_mirrors, with_image};
use tremie_messages::Load;

/// Gives the bodies their loads, once gaps press on them and facets have theirs, and balances them.
pub fn assemble<T: Real>(
    lattice: &LatticeState<T>,
    bodies: &mut MovingBodies,
    gaps: &GapModel,
    budget: &mut Budget,
    loads: &mut [Load],
) {
    let units = &lattice.units;
    let (force_unit, torque_unit) = (units.force(), units.force() * units.cell);
    let (balance, grid) = (&mut budget.balance, &lattice.layout.grid);
    let MovingBodies { list, of_bodies, total, average_force, lift, .. } = bodies;
    for ((body, load), exchange) in list.living.iter_mut().zip(loads).zip(of_bodies) {
        let mut exchange = *exchange;
        if body.is_part()
            && let Some(slip) = gaps.slip_on_body(body.handle)
        {
            exchange.join(&slip);
        }
        total.join(&exchange);
        let mut own = [exchange.force, exchange.torque];
        for k in 0..2 {
            add_scaled(&mut own[k], body.pressed[k], 1.0);
        }
        let mirrors = mirrors_of(grid, body);
        let mut given = with_image(mirrors, own);
        add_scaled(&mut balance.gaps, body.pressed[0], 1.0);
        add_scaled(&mut balance.images, given[0], 1.0);
        add_scaled(&mut balance.images, own[0], -1.0);
        add_scaled(&mut balance.images, exchange.image, 1.0);
        if *average_force {
            // The mean of two steps: reflection at cells that come and go makes loads alternate
            // (Ladd 1994).
            let half = given.map(|v| v.map(|x| 0.5 * x));
            given =
                std::array::from_fn(|k| std::array::from_fn(|a| half[k][a] + body.carried[k][a]));
            body.carried = half;
            add_scaled(&mut balance.carried, half[0], 1.0);
        }
        let [buoyancy, turn] = match *lift {
            [0.0, 0.0, 0.0] => [[0.0; 3]; 2],
            lift => body.displaced(grid, mirrors).load(lift),
        };
        add_scaled(&mut balance.delivered, given[0], 1.0);
        add_scaled(&mut balance.buoyancy, buoyancy, 1.0);
        let force = std::array::from_fn(|a| given[0][a] + buoyancy[a]);
        body.urge(force);
        *load = Load {
            id: body.id,
            force: force.map(|f| f * force_unit),
            torque: std::array::from_fn(|a| (given[1][a] + turn[a]) * torque_unit),
        };
    }
}

/// Axes across which a symmetry plane cuts a body.
fn mirrors_of(grid: &Grid, body: &Body) -> [bool; 3] {
    match body.part {
        Some(_) => mirrors_of_part(grid, body.position),
        None => near_mirrors(grid, body.position, body.radius),
    }
}
