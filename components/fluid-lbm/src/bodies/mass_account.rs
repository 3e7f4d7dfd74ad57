//! The mass that a body owes the fluid.

use crate::lattice::exact_sum::{ExactSum, values};
use crate::lattice::momentum_exchange::MomentumExchange;
use serde::{Deserialize, Serialize};

/// Part of what is owed that a step pays. Between a body's surface and the last cells is volume
/// whose density follows the sound around: what is owed for that comes and goes by itself, and paid
/// within a period it would feed the sound.
const RATE: f64 = 0.002;

/// The mass that one body owes the fluid [cells at density 1].
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct MassAccount {
    /// True if the body was there in the last step: what it displaces when it appears is no debt.
    pub is_open: bool,
    took: f64,
    space: f64,
    /// Of both, what cells changed in this step.
    #[serde(skip)]
    pub changed: [ExactSum; 2],
    /// Mass owed.
    pub owed: f64,
    /// Of that, what gaps drew in since it could last be paid.
    of_gaps: f64,
    /// Mass that the coming step pays to a link, for each unit of `6 w_i rho`.
    pub pay: f64,
}

impl MassAccount {
    /// A cell that held `1 + drho` left the fluid.
    pub fn cover(&mut self, drho: f64) {
        self.changed[0].add(1.0 + drho);
        self.changed[1].add(-1.0);
    }

    /// A cell that holds `1 + drho` joined the fluid.
    pub fn uncover(&mut self, drho: f64) {
        self.changed[0].add(-1.0 - drho);
        self.changed[1].add(1.0);
    }

    /// Links gave what `exchange` says to the fluid, of which `drawn` is all that gaps drew in and
    /// `taken` the mass that intakes will take for it; `mean` is the fluid's mean density.
    pub fn settle(&mut self, exchange: &MomentumExchange, mean: f64, taken: f64) {
        let MomentumExchange { mass, receded, drawn, weight, .. } = *exchange;
        let [took, space] = values(&std::mem::take(&mut self.changed));
        self.took += took + (taken - mass);
        self.space += space - (receded + drawn);
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A wall that recedes by a cell in ten steps owes nothing, whatever the density, if its links
    /// take what they should and the new cell holds the same; less in the new cell is owed.
    #[test]
    fn a_piston_owes_nothing() {
        let mut account = MassAccount::default();
        let links = |mass: f64, receded: f64, weight: f64| MomentumExchange {
            mass,
            receded,
            weight,
            ..MomentumExchange::default()
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

    /// The mass that a gap draws in is paid in the next step, once there are links to pay at.
    #[test]
    fn a_gap_is_paid_at_once() {
        let mut account = MassAccount::default();
        let mut step = |drawn: f64, weight: f64| {
            let mass = account.pay * weight;
            account.settle(
                &MomentumExchange { drawn, mass, weight, ..MomentumExchange::default() },
                1.0,
                0.0,
            );
            (mass, account.owed)
        };
        assert_eq!(step(0.5, 4.0), (0.0, -0.5));
        assert_eq!(step(0.25, 4.0), (-0.5, -0.25));
        assert_eq!(step(0.5, 0.0), (0.0, -0.75), "no links");
        step(0.0, 4.0);
        // Mass that was due when there were none is like any other debt.
        let (paid, owed) = step(0.0, 4.0);
        assert!((paid + 0.5).abs() < 1e-3 && (owed + 0.25).abs() < 1e-3, "{paid} {owed}");
    }
}
