//! The mass that a moving body owes the fluid, and how it is paid: `refill = "mass"`.
//!
//! A body's surface moves mass all the time: each link takes `6 w_i rho (c_i.u_w)` where the wall
//! recedes, a covered cell takes its density from the fluid, an uncovered one brings some. These
//! balance each other on average only, because the densities are not the same ones and because
//! interpolated links do not keep the mass; so the fluid's mean density drifts. For each body
//!
//! ```text
//! took  = mass that cells it covered held - mass given to cells it uncovered - sum over links (f_i' - g_i)
//! space = cells it uncovered - cells it covered - sum over links 6 w_i (c_i.u_w)
//! owed  = took + rho_m space                                       rho_m: the fluid's mean density
//! ```
//!
//! `space` is the difference between the cells that the fluid has and the volume that it should
//! have: bounded, and without the last sum where the body is closed. As long as nothing is owed, a
//! closed box keeps its mean density, and a piston that shuts half of it the mass. In each step a
//! part of what is owed goes to the fluid cells at the body's links, in proportion to weight and
//! density: the surface breathes, and the momentum that a closed surface gives by that is zero.
//!
//! If a body borders a declared gap that holds no fluid (see `modelled`), its surface has no links
//! there, but the sum over its gap links counts in `space` as well. The fluid that such a gap draws
//! in as it widens leaves the rest, so that the cells which thaw bring nothing new. It does so in
//! the next step, for it moves with the body; paid late, it would feed the sound around a shut
//! valve, as a wall does that moves late. It leaves where the gap's pressure is measured, through
//! *intakes* (see `gap_sinks`). These then owe it and the body does not. For a gap without intakes
//! the body pays along the rest of its surface. Gap links in contact count nothing: there is no
//! fluid between.
//!
//! Taking the whole mass of an uncovered cell from its neighbours at once instead would lower their
//! density by a fifth, and count twice what the links have taken while the wall receded.

use crate::lattice::populations::Real;
use crate::solver::gap_model::GapModel;
use crate::solver::lattice_state::LatticeState;
use crate::solver::moving_bodies::MovingBodies;

/// Charges a body for a cell that it covered or cut off from the fluid.
pub fn charge<T: Real>(
    bodies: &mut MovingBodies,
    gaps: &GapModel,
    lattice: &LatticeState<T>,
    cell: u32,
    drho: f64,
) {
    if !bodies.keeps_mass {
        return;
    }
    if let Some(handle) = gaps.holder_of(lattice, &bodies.list, cell)
        && let Some(body) = bodies.list.living_with_handle(handle)
        && body.account.is_open
    {
        body.account.cover(drho);
    }
}

/// Credits the body that uncovered a cell.
pub fn credit(bodies: &mut MovingBodies, handle: u32, drho: f64) {
    if bodies.keeps_mass
        && let Some(body) = bodies.list.living_with_handle(handle)
        && body.account.is_open
    {
        body.account.uncover(drho);
    }
}

/// Settles the accounts of bodies at the end of a step in a fluid of a mean density; returns what
/// they owe.
pub fn settle_bodies(bodies: &mut MovingBodies, gaps: &mut GapModel, mean: f64) -> f64 {
    let MovingBodies { list, gap_flows, of_bodies, keeps_mass, .. } = bodies;
    if !*keeps_mass {
        return 0.0;
    }
    let (mut owed, mut parts) = (0.0, 0..);
    let mut left = gaps.tables.sinks.receive(gap_flows.given());
    for (body, exchange) in list.living.iter_mut().zip(of_bodies) {
        let (mut all, mut taken) = (*exchange, 0.0);
        // Grains draw nothing in, and give nothing.
        if let Some(part) = body.is_part().then(|| parts.next()).flatten() {
            // The body does not owe the mass that links gave to intakes.
            all.mass += gap_flows.given_by(part);
            for (gap, drawn) in (0..).zip(gap_flows.drawn(part)) {
                all.drawn += drawn;
                taken += gaps.tables.sinks.draw(gap, mean * drawn);
            }
            // A body has to give the mass that intakes cannot give any more.
            taken -= std::mem::take(&mut left);
            all.mass += gaps.slip_on_body(body.handle).map_or(0.0, |slip| slip.mass);
        }
        body.account.is_open = true;
        body.account.settle(&all, mean, taken);
        owed += body.account.owed;
    }
    gaps.tables.sinks.decide();
    owed - gaps.tables.sinks.due()
}
