//! Balancing of light bodies.
//!
//! The lighter a body, the stiffer the equations become: to a body of no mass any wrench is too
//! much. So before and after the smoothing of a level the wrench on each such body is balanced by
//! `q` in the cells beside it: exactly, among the columns `W = J^T` of that body,
//!
//! ```text
//! q += C (b - A q),   C = W (W^T A W)^-1 W^T
//! ```

use crate::pressure::body_coupling::{BodyCoupling, Wrench};
use crate::pressure::scalar::Scalar;
use crate::pressure::stencil::Stencil;
use nalgebra::{Matrix6, Vector6};

/// Stiffness from which a body is balanced. Below, the diagonal bears it.
pub const LIGHT: f64 = 20.0;

/// Bodies that are balanced.
#[derive(Default)]
pub struct LightBodies {
    bodies: Vec<LightBody>,
    /// Motion of each light body by the `q` at which smoothing began, else none.
    held: Vec<Option<Wrench>>,
    scratch: Vec<f64>,
}

struct LightBody {
    body: usize,
    /// Inverse of `W^T A W`, on the motions that the body has.
    inverse: Matrix6<f64>,
}

impl LightBodies {
    /// Finds the light bodies, and prepares their balance.
    pub fn prepare<T: Scalar, const D: usize>(
        &mut self,
        stencil: &Stencil<T, D>,
        coupling: &BodyCoupling,
    ) {
        self.bodies.clear();
        self.held.clear();
        self.held.resize(coupling.count(), None);
        self.scratch.resize(stencil.diagonal.len(), 0.0);
        for body in 0..coupling.count() {
            if coupling.stiffness(body) > LIGHT {
                let inverse = balance(stencil, coupling, body, &mut self.scratch);
                self.bodies.push(LightBody { body, inverse });
            }
        }
    }

    /// True if no body is balanced.
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// Holds the motions of light bodies by `q`, until smoothing has ended.
    pub fn hold<T: Scalar>(&mut self, coupling: &BodyCoupling, q: &[T]) {
        for light in &self.bodies {
            self.held[light.body] = Some(coupling.motion(light.body, q));
        }
    }

    /// Motion of a body by `q`; of a light one, the motion that is held.
    #[inline]
    pub fn motion_while_smoothing<T: Scalar>(
        &self,
        coupling: &BodyCoupling,
        body: usize,
        q: &[T],
    ) -> Wrench {
        self.held[body].unwrap_or_else(|| coupling.motion(body, q))
    }

    /// Adds `C r` to `out`.
    pub fn add_balance<T: Scalar>(&self, coupling: &BodyCoupling, r: &[T], out: &mut [T]) {
        for light in &self.bodies {
            let wrench = Vector6::from(coupling.wrench(light.body, r));
            let amount: Wrench = (light.inverse * wrench).into();
            coupling.add_flux(light.body, &amount, out, |_| 1.0);
        }
    }
}

/// Inverse of `J L J^T + J J^T S J J^T` for one body.
fn balance<T: Scalar, const D: usize>(
    stencil: &Stencil<T, D>,
    coupling: &BodyCoupling,
    body: usize,
    scratch: &mut [f64],
) -> Matrix6<f64> {
    let entries = coupling.entries(body);
    let mut stiffness = Matrix6::<f64>::zeros();
    let mut square = Matrix6::<f64>::zeros();
    for column in 0..6 {
        for entry in entries.clone() {
            let at = coupling.cells[entry] as usize;
            scratch[at] += coupling.wrenches[entry][column];
        }
        for entry in entries.clone() {
            let at = coupling.cells[entry] as usize;
            let applied = stencil.applied_double(scratch, at);
            for row in 0..6 {
                stiffness[(row, column)] += coupling.wrenches[entry][row] * applied;
                square[(row, column)] += coupling.wrenches[entry][row] * scratch[at];
            }
        }
        for entry in entries.clone() {
            scratch[coupling.cells[entry] as usize] = 0.0;
        }
    }
    let mobility = Matrix6::<f64>::from_fn(|row, column| coupling.mobility[body][row][column]);
    let whole: Matrix6<f64> = stiffness + square * mobility * square;
    // Motions that press no cell have no stiffness.
    let eigen = (0.5 * (whole + whole.transpose())).symmetric_eigen();
    let most = eigen.eigenvalues.amax();
    let inverse = eigen.eigenvalues.map(|x| if x > 1e-9 * most { 1.0 / x } else { 0.0 });
    eigen.eigenvectors * Matrix6::from_diagonal(&inverse) * eigen.eigenvectors.transpose()
}
