//! Non-equilibrium extrapolation at open faces, of eight cells at a time; see `open_boundary` for
//! the formulae.
//!
//! Written once for plain arrays and compiled for each set of vector instructions, as
//! `link_kernels` is, with the operations of [`equilibria`] and [`moments`] in their order: every
//! variant yields the same bits.

use crate::boundary::face_scheme::gained;
use crate::boundary::link_kernels::{LANES, Lane};
use crate::lattice::d3q19::{Q, each, equilibria, moments};
use tremie_team::instructions::Work;

/// Eight cells at open faces.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub struct InnerCells {
    /// Populations as they are.
    pub old: [Lane; Q],
    /// Those that are extrapolated, their density minus 1, and the velocity.
    pub from: [Lane; Q],
    /// See there.
    pub drho: Lane,
    /// See there.
    pub velocity: [Lane; 3],
    /// Prescribed density minus 1, and prescribed velocity.
    pub given: (Lane, [Lane; 3]),
    /// Populations as they are to be; then what they gained.
    pub new: [Lane; Q],
    /// Bits of the directions that come from beyond an open face.
    pub unknown: [u32; LANES],
    /// Mass that the fluid gained.
    pub mass: Lane,
    /// Momentum that the fluid gained.
    pub impulse: [Lane; 3],
}

impl InnerCells {
    /// Cells at rest.
    pub const NONE: Self = Self {
        old: [[0.0; LANES]; Q],
        from: [[0.0; LANES]; Q],
        drho: [0.0; LANES],
        velocity: [[0.0; LANES]; 3],
        given: ([0.0; LANES], [[0.0; LANES]; 3]),
        new: [[0.0; LANES]; Q],
        unknown: [0; LANES],
        mass: [0.0; LANES],
        impulse: [[0.0; LANES]; 3],
    };
}

/// Finds density and velocity of what is extrapolated, given the fluid's acceleration.
pub struct LookInside<'a>(pub &'a mut InnerCells, pub [f64; 3]);

impl Work for LookInside<'_> {
    #[inline(always)]
    fn run(self) {
        let Self(cells, acceleration) = self;
        for k in 0..LANES {
            let (drho, j) = moments(&each(|i| cells.from[i][k]));
            cells.drho[k] = drho;
            for a in 0..3 {
                cells.velocity[a][k] = j[a] / (1.0 + drho) + 0.5 * acceleration[a];
            }
        }
    }
}

/// Finds what the cells are to hold.
pub struct Extrapolate<'a>(pub &'a mut InnerCells);

impl Work for Extrapolate<'_> {
    #[inline(always)]
    fn run(self) {
        let cells = self.0;
        for k in 0..LANES {
            let (given, velocity) = (&cells.given.1, &cells.velocity);
            let here = equilibria(cells.given.0[k], [given[0][k], given[1][k], given[2][k]]);
            let there = equilibria(cells.drho[k], [velocity[0][k], velocity[1][k], velocity[2][k]]);
            for i in 0..Q {
                cells.new[i][k] = here[i] + (cells.from[i][k] - there[i]);
            }
        }
    }
}

/// Adds up what the fluid gained.
pub struct AddUp<'a>(pub &'a mut InnerCells);

impl Work for AddUp<'_> {
    #[inline(always)]
    fn run(self) {
        let cells = self.0;
        for k in 0..LANES {
            let gain = each(|i| cells.new[i][k]);
            let old = each(|i| cells.old[i][k]);
            let (mass, impulse) = gained(gain, &old, cells.unknown[k]);
            cells.mass[k] = mass;
            for a in 0..3 {
                cells.impulse[a][k] = impulse[a];
            }
        }
    }
}
