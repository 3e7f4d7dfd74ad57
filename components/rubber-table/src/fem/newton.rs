//! Newton's method for one increment of compression.

use crate::fem::assembly::{Model, State};
use crate::fem::boundary_conditions::HELD;

/// Why an increment found no equilibrium.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Failure {
    /// An element was turned inside out.
    #[error("quadrilateral {0} turned inside out")]
    Inverted(usize),
    /// Something can move without resistance.
    #[error("the stiffness is singular: a part of the section is held by nothing")]
    Singular,
    /// Newton's method did not settle.
    #[error(
        "forces were still out of balance by {residual:.1e} of their size after {passes} passes"
    )]
    NotSettled {
        /// Forces left out of balance, over their size.
        residual: f64,
        /// Number of passes made.
        passes: u32,
    },
}

/// Passes and residual of an equilibrium.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Equilibrium {
    /// Passes of Newton's method, the last of which only found that nothing was left to do.
    pub passes: u32,
    /// Forces out of balance, over their size.
    pub residual: f64,
    /// Negative pivots of the last stiffness factored: 0 where the equilibrium is stable.
    pub negative_pivots: usize,
}

/// Most passes for an increment.
const MOST_PASSES: u32 = 25;

/// Increases the compression by `by` [m] and finds the equilibrium. `state` must be assembled;
/// after an error it is not.
pub(super) fn settle(
    model: &Model,
    state: &mut State,
    by: f64,
    tolerance: f64,
) -> Result<Equilibrium, Failure> {
    let mut step: Vec<f64> = vec![0.0; model.unknown_count];
    let mut settled = Equilibrium::default();
    // The predictor: along the tangent, with the held displacements where they shall be.
    gather(model, state, &mut step);
    for (step, pull) in step.iter_mut().zip(&state.pull) {
        *step += pull * by;
    }
    for (u, rate) in state.displacements.iter_mut().zip(&model.rates) {
        *u += rate * by;
    }
    loop {
        settled.negative_pivots = state.stiffness.factor().map_err(|_| Failure::Singular)?;
        state.stiffness.solve(&mut step);
        for (u, unknown) in state.displacements.iter_mut().zip(&model.unknowns) {
            if *unknown != HELD {
                *u -= step[*unknown];
            }
        }
        model.assemble(state).map_err(Failure::Inverted)?;
        settled.passes += 1;
        gather(model, state, &mut step);
        settled.residual = norm(&step) / state.scale.max(f64::MIN_POSITIVE);
        if settled.residual <= tolerance {
            return Ok(settled);
        }
        if settled.passes == MOST_PASSES || !settled.residual.is_finite() {
            return Err(Failure::NotSettled { residual: settled.residual, passes: settled.passes });
        }
    }
}

/// Forces on the unknowns.
fn gather(model: &Model, state: &State, out: &mut [f64]) {
    for (force, unknown) in state.forces.iter().zip(&model.unknowns) {
        if *unknown != HELD {
            out[*unknown] = *force;
        }
    }
}

fn norm(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum::<f64>().sqrt()
}
