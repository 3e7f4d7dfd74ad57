//! The mass that the scheme lost since the start, which nothing let out.
//!
//! Links to walls that stand still make or take some where they are interpolated and owe it (see
//! `wall_mass`), links to bodies and cells that bodies cover and uncover as they move too (see
//! `mass_correction`):
//!
//! ```text
//! lost  = took + rho_m space                                            rho_m: the fluid's mean density
//! took  = what came through open faces and parts - change of the fluid's mass
//! space = cells that the fluid gained - volume by which moving walls receded
//! ```
//!
//! If nothing moves, `space` is zero; else it is the volume between the surfaces of bodies and the
//! last cells, by which the cells that the fluid has come and go (see `mass_correction`). Walls of
//! spheres are closed and recede by nothing, but where bodies keep accounts: those count it. A part
//! that prescribes velocity or pressure lets fluid through, and what its links brought is no loss,
//! interpolated or not. A step in which bodies appear, vanish or cross a reservoir's face counts
//! nothing: what they displace is no loss.

use serde::{Deserialize, Serialize};

/// Account of that mass [cells at density 1].
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Lost {
    took: f64,
    space: f64,
    /// Lost before bodies came or went for the last time.
    before: f64,
    /// The fluid's cells at the end of the last step.
    cells: usize,
    /// True if bodies come or go in this step.
    is_other: bool,
}

impl Lost {
    /// Begins anew, in a fluid of so many cells: nothing is lost.
    pub fn restart(&mut self, cells: usize) {
        *self = Self { cells, ..Self::default() };
    }

    /// Takes note that bodies come or go.
    pub fn change(&mut self) {
        self.is_other = true;
    }

    /// Counts a step at whose end the fluid has so many cells; see above for `took`, `receded` and
    /// `mean`. Returns what was lost since the start.
    pub fn count(&mut self, cells: usize, took: f64, receded: f64, mean: f64) -> f64 {
        if std::mem::take(&mut self.is_other) {
            *self = Self { before: self.total(mean), ..Self::default() };
        } else {
            self.took += took;
            self.space += cells as f64 - self.cells as f64 - receded;
        }
        self.cells = cells;
        self.total(mean)
    }

    fn total(&self, mean: f64) -> f64 {
        self.before + self.took + mean * self.space
    }
}
