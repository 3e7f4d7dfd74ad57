//! The equations of the pressure by themselves, to compare solvers of them.

use crate::pressure::conjugate_gradients::PressureOutcome;
use crate::solver::pic_solver::PicSolver;

/// A sparse symmetric system, its cells numbered from 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PressureEquations {
    /// Row and column of each coefficient.
    pub places: Vec<[u32; 2]>,
    /// The coefficients.
    pub values: Vec<f64>,
    /// The right side.
    pub right: Vec<f64>,
}

impl<const D: usize> PicSolver<D> {
    /// The equations of the last step, without free bodies.
    pub fn pressure_equations(&self) -> PressureEquations {
        let stencil = &self.stencil;
        let mut number = vec![u32::MAX; self.grid.stored];
        let mut equations = PressureEquations::default();
        let spans = || stencil.rows.all_spans().flatten();
        for at in spans().filter(|&at| stencil.diagonal[at] > 0.0) {
            number[at] = equations.right.len() as u32;
            equations.right.push(self.right[at]);
        }
        for at in spans().filter(|&at| number[at] != u32::MAX) {
            let mut add = |column: u32, value: f64| {
                equations.places.push([number[at], column]);
                equations.values.push(value);
            };
            add(number[at], stencil.diagonal[at]);
            for (coupling, stride) in stencil.coupling.iter().zip(stencil.stride) {
                for (face, beyond) in [(at, at - stride), (at + stride, at + stride)] {
                    let column = number[self.grid.place_inside(beyond)];
                    if coupling[face] != 0.0 && column != u32::MAX {
                        add(column, -coupling[face]);
                    }
                }
            }
        }
        equations
    }

    /// Solves the equations of the last step again, beginning from zero.
    pub fn solve_pressure_anew(&mut self) -> PressureOutcome {
        self.q.fill(0.0);
        self.solve()
    }
}
