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
//! `space` is the difference between the cells that the fluid has and the volume that it should have:
//! bounded, and without the last sum where the body is closed. As long as nothing is owed, a closed
//! box keeps its mean density, and a piston that shuts half of it the mass. In each step a
//! part of what is owed goes to the fluid cells at the body's links, in proportion to weight and
//! density: the surface breathes, and the momentum that a closed surface gives by that is zero.
//!
//! Where a body borders a declared gap that holds no fluid (see `modelled`), its surface has no links, but
//! the sum over its gap links counts in `space` as well: what such a gap draws in as it widens leaves the
//! fluid, so that the cells which thaw bring nothing new. It does so in the next step, for it moves with the body, and
//! paid late it would feed the sound around a shut valve, as a wall would that moves late; and where the gap's pressure
//! is measured, through *intakes* (see `declared::intake`). These then owe it and the body does not. What has no intake the body
//! pays along the rest of its surface. Gap links in contact count nothing: there is no fluid between.
//!
//! Taking the whole mass of an uncovered cell from its neighbours at once instead would lower their
//! density by a fifth, and count twice what the links have taken while the wall receded.

use crate::boundary::post_collision::Exchange;
use crate::lattice::collision_kernel::Collides;
use crate::lattice::d3q19::Q;
use crate::solver::lbm_solver::Solver;

/// Part of what is owed that a step pays. Between a body's surface and the last cells is volume whose
/// density follows the sound around: what is owed for that comes and goes by itself, and paid within a period
/// it would feed the sound.
const RATE: f64 = 0.002;

/// The mass that one body owes the fluid [cells at density 1].
#[derive(Clone, Copy, Debug, Default)]
pub struct Account {
    /// Whether the body was there in the last step: what it displaces when it appears is no debt.
    is_open: bool,
    took: f64,
    space: f64,
    /// What is owed.
    pub owed: f64,
    /// Of that, what gaps drew in since it could last be paid.
    of_gaps: f64,
    /// What the coming step pays to a link, for each unit of `6 w_i rho`.
    pub pay: f64,
}

impl Account {
    /// A cell that held `1 + drho` left the fluid.
    fn cover(&mut self, drho: f64) {
        self.took += 1.0 + drho;
        self.space -= 1.0;
    }

    /// A cell that holds `1 + drho` joined the fluid.
    fn uncover(&mut self, drho: f64) {
        self.took -= 1.0 + drho;
        self.space += 1.0;
    }

    /// Links gave what `exchange` says to the fluid, of which `drawn` is all that gaps drew in and `taken` the mass that
    /// intakes will take for it; `mean` is the fluid's mean density.
    fn settle(&mut self, exchange: &Exchange, mean: f64, taken: f64) {
        let Exchange { mass, receded, drawn, weight, .. } = *exchange;
        self.took += taken - mass;
        self.space -= receded + drawn;
        self.owed = self.took + mean * self.space;
        self.of_gaps += taken - mean * drawn;
        if weight > 0.0 {
            self.pay = (self.of_gaps + RATE * (self.owed - self.of_gaps)) / weight;
            self.of_gaps = 0.0;
        } else {
            self.pay = 0.0;
        }
    }
}

impl<T: Collides> Solver<T> {
    /// Handle of the body that covers a cell or cut it off from the fluid.
    pub(crate) fn holder_of(&self, cell: u32) -> Option<u32> {
        let (owners, layout) = (&self.owners, &self.layout);
        let of_neighbours = || (1..Q).find_map(|i| owners.holder(layout.neighbour(cell, i)?));
        let of_gaps = || self.declared.any_mover(&self.bodies);
        owners.holder(cell).or_else(of_neighbours).or_else(of_gaps)
    }

    /// Charges a body for a cell that it covered or cut off from the fluid.
    pub(crate) fn charge(&mut self, cell: u32, drho: f64) {
        if !self.keeps_mass {
            return;
        }
        if let Some(handle) = self.holder_of(cell)
            && let Some(body) = self.bodies.living_with_handle(handle)
            && body.account.is_open
        {
            body.account.cover(drho);
        }
    }

    /// Credits the body that uncovered a cell.
    pub(crate) fn credit(&mut self, handle: u32, drho: f64) {
        if self.keeps_mass
            && let Some(body) = self.bodies.living_with_handle(handle)
            && body.account.is_open
        {
            body.account.uncover(drho);
        }
    }

    /// Settles the accounts of walls and bodies at the end of a step, once its balance is known.
    pub(crate) fn settle_accounts(&mut self) {
        let owed = self.patches.settle(&mut self.fixed_items) + self.settle_bodies();
        self.balance.mass_owed = owed;
        self.ledger.mass_owed = owed * self.units.mass();
    }

    /// Settles the accounts of bodies; returns what they owe.
    fn settle_bodies(&mut self) -> f64 {
        if !self.keeps_mass {
            return 0.0;
        }
        let mean = self.balance.mass / self.owners.fluid_cells.max(1) as f64;
        let mut owed = 0.0;
        let parts = self.bodies.living.iter().filter(|body| body.is_part());
        let of_parts = parts.flat_map(|body| &self.link_items[body.items.clone()]);
        let mut left = self.intakes.receive(of_parts);
        for body in &mut self.bodies.living {
            let (mut all, mut taken) = (Exchange::default(), 0.0);
            for number in body.items.clone() {
                all.join(&self.exchanges[number]);
                // Grains draw nothing in, and give nothing.
                let Some(item) = body.is_part().then(|| &self.link_items[number]) else { continue };
                // What links gave to intakes the body does not owe.
                all.mass += item.gaps.given.iter().map(|given| given.mass).sum::<f64>();
                for (gap, drawn) in (0..).zip(&item.gaps.drawn) {
                    all.drawn += drawn;
                    taken += self.intakes.draw(gap, mean * drawn);
                }
            }
            // What intakes cannot give any more, a body has to.
            if body.is_part() {
                taken -= std::mem::take(&mut left);
            }
            if self.slips && body.is_part() {
                all.mass += self.slip.on_body(body.handle).mass;
            }
            body.account.is_open = true;
            body.account.settle(&all, mean, taken);
            owed += body.account.owed;
        }
        self.intakes.decide();
        owed - self.intakes.due()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wall that recedes by a cell in ten steps owes nothing, whatever the density, if its links
    /// take what they should and the new cell holds the same; less in the new cell is owed.
    #[test]
    fn a_piston_owes_nothing() {
        let mut account = Account::default();
        let links = |mass: f64, receded: f64, weight: f64| Exchange {
            mass,
            receded,
            weight,
            ..Exchange::default()
        };
        for _ in 0..10 {
            account.settle(&links(-0.11, 0.1, 1.0), 1.1, 0.0);
            assert!(account.owed.abs() < 1e-15);
        }
        account.uncover(0.1);
        account.settle(&links(0.0, 0.0, 2.0), 1.1, 0.0);
        assert!(account.owed.abs() < 1e-15 && account.pay.abs() < 1e-15);
        account.uncover(0.0);
        account.settle(&links(0.0, 0.0, 2.0), 1.1, 0.0);
        assert!((account.owed - 0.1).abs() < 1e-15 && (account.pay - 0.05 * RATE).abs() < 1e-16);
    }

    /// What a gap draws in is paid in the next step, once there are links to pay at.
    #[test]
    fn a_gap_is_paid_at_once() {
        let mut account = Account::default();
        let mut step = |drawn: f64, weight: f64| {
            let mass = account.pay * weight;
            account.settle(&Exchange { drawn, mass, weight, ..Exchange::default() }, 1.0, 0.0);
            (mass, account.owed)
        };
        assert_eq!(step(0.5, 4.0), (0.0, -0.5));
        assert_eq!(step(0.25, 4.0), (-0.5, -0.25));
        assert_eq!(step(0.5, 0.0), (0.0, -0.75), "no links");
        step(0.0, 4.0);
        // What was due when there were none is like any other debt.
        let (paid, owed) = step(0.0, 4.0);
        assert!((paid + 0.5).abs() < 1e-3 && (owed + 0.25).abs() < 1e-3, "{paid} {owed}");
    }
}
