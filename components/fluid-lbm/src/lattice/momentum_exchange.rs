//! Momentum exchange at links: what populations that ran into a wall or a body gave to it (Ladd
//! 1994; Wen et al. 2014).

use crate::lattice::d3q19::cross;
use crate::lattice::ledger::add_scaled;
use serde::{Deserialize, Serialize};
use std::iter::Sum;

/// Momentum, torque and mass that links exchanged in a step [lattice units].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MomentumExchange {
    /// Force on the body.
    pub force: [f64; 3],
    /// Torque on the body about its centre.
    pub torque: [f64; 3],
    /// Momentum that went to the fluid besides: `(f_i' - g_i) u_w`.
    pub swept: [f64; 3],
    /// Of the force, what the mirrored half of the fluid gave: links through a mirror are reckoned
    /// as those of the mirrored cell, whose force is the mirrored one.
    pub image: [f64; 3],
    /// The same for `swept`.
    pub image_swept: [f64; 3],
    /// Momentum that mirrors are reckoned to have given to populations of links that are cut on
    /// their way through them.
    pub unmirrored: [f64; 3],
    /// Mass that went to the fluid.
    pub mass: f64,
    /// Volume by which the wall receded, the sum of `6 w_i (c_i.u_w)`, and the sum of `6 w_i`; of
    /// parts, and where bodies keep accounts of mass.
    pub receded: f64,
    /// See `receded`.
    pub weight: f64,
    /// Volume by which it receded from gaps that hold no fluid.
    pub drawn: f64,
    /// Number of links.
    pub links: usize,
    /// Those without a second fluid cell where it was needed.
    pub fallbacks: usize,
}

/// Exchange of one link.
#[derive(Clone, Copy, Debug)]
pub struct LinkExchange {
    /// Force on the wall.
    pub force: [f64; 3],
    /// Torque about the point from which the arm is.
    pub torque: [f64; 3],
    /// Momentum that went to the fluid besides.
    pub swept: [f64; 3],
}

impl LinkExchange {
    /// Of a link along `c`, on which `g_i` ran into a wall of velocity `u` at an `arm` and `f_i'`
    /// came back, `sum` being `g_i + f_i'` and `gain` `f_i' - g_i`: the Galilean-invariant exchange
    /// of Wen et al. 2014, `g_i (c_i - u) - f_i' (c_i' - u)`.
    #[inline(always)]
    pub fn of(c: [f64; 3], sum: f64, gain: f64, u: [f64; 3], arm: [f64; 3]) -> Self {
        let swept = [gain * u[0], gain * u[1], gain * u[2]];
        let force = [sum * c[0] + swept[0], sum * c[1] + swept[1], sum * c[2] + swept[2]];
        Self { force, torque: cross(arm, force), swept }
    }
}

impl MomentumExchange {
    /// Adds a link; see [`LinkExchange::of`]. Returns the force.
    #[inline(always)]
    pub fn add_link(
        &mut self,
        c: [f64; 3],
        [sum, gain]: [f64; 2],
        u: [f64; 3],
        arm: [f64; 3],
    ) -> [f64; 3] {
        let LinkExchange { force, torque, swept } = LinkExchange::of(c, sum, gain, u, arm);
        add_scaled(&mut self.force, force, 1.0);
        add_scaled(&mut self.torque, torque, 1.0);
        add_scaled(&mut self.swept, swept, 1.0);
        self.mass += gain;
        force
    }

    /// Adds a force that acts at an arm, of links that share it.
    #[inline(always)]
    pub fn add_force(&mut self, force: [f64; 3], arm: [f64; 3]) {
        add_scaled(&mut self.force, force, 1.0);
        add_scaled(&mut self.torque, cross(arm, force), 1.0);
    }

    /// Adds another.
    pub fn join(&mut self, other: &Self) {
        add_scaled(&mut self.force, other.force, 1.0);
        add_scaled(&mut self.torque, other.torque, 1.0);
        add_scaled(&mut self.swept, other.swept, 1.0);
        add_scaled(&mut self.image, other.image, 1.0);
        add_scaled(&mut self.image_swept, other.image_swept, 1.0);
        add_scaled(&mut self.unmirrored, other.unmirrored, 1.0);
        self.mass += other.mass;
        self.receded += other.receded;
        self.weight += other.weight;
        self.drawn += other.drawn;
        self.links += other.links;
        self.fallbacks += other.fallbacks;
    }
}

impl<'a> Sum<&'a Self> for MomentumExchange {
    fn sum<I: Iterator<Item = &'a Self>>(all: I) -> Self {
        all.fold(Self::default(), |mut sum, one| {
            sum.join(one);
            sum
        })
    }
}
