//! Balancing of light bodies.
//!
//! The lighter a body, the stiffer the equations become: to a body of no mass any wrench is too
//! much. So before and after the smoothing of a level the wrench on each such body is balanced by
//! `q` in the cells beside it: exactly, among the columns `W = J^T` of that body,
//!
//! ```text
//! q += W (W^T A W)^-1 W^T (b - A q)
//! ```
//!
//! one body after the other, and back in the opposite order.

use crate::pressure::body_coupling::{BodyCoupling, Wrench};
use crate::pressure::stencil::Stencil;
use nalgebra::{Matrix6, RealField, Vector6};

/// Stiffness from which a body is balanced, relative to the coupling of an open face. Below, the
/// diagonal bears it. Found by trial: from 0.1 to 5 the iterations are the same, from 20 on they
/// double.
pub const LIGHT: f64 = 3.0;

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
    /// Bodies that share cells with it, itself included.
    sharers: Vec<u32>,
}

impl LightBodies {
    /// Finds the light bodies, and prepares their balance. `full` is the coupling of an open face.
    pub fn prepare<T: RealField + Copy, const D: usize>(
        &mut self,
        stencil: &Stencil<T, D>,
        coupling: &BodyCoupling,
        full: f64,
    ) {
        self.bodies.clear();
        self.held.clear();
        self.held.resize(coupling.count(), None);
        self.scratch.resize(stencil.diagonal.len(), 0.0);
        let by_cell = bodies_by_cell(coupling);
        for body in 0..coupling.count() {
            if coupling.stiffness(body) > LIGHT * full {
                let sharers = sharers(coupling, &by_cell, body);
                let inverse = balance(stencil, coupling, body, &sharers, &mut self.scratch);
                self.bodies.push(LightBody { body, inverse, sharers });
            }
        }
    }

    /// True if no body is balanced.
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// Holds the motions of light bodies by `q`, until smoothing has ended.
    pub fn hold<T: RealField + Copy>(&mut self, coupling: &BodyCoupling, q: &[T]) {
        for light in &self.bodies {
            self.held[light.body] = Some(coupling.motion(light.body, q));
        }
    }

    /// Motion of a body by `q`; of a light one, the motion that is held.
    #[inline]
    pub fn motion_while_smoothing<T: RealField + Copy>(
        &self,
        coupling: &BodyCoupling,
        body: usize,
        q: &[T],
    ) -> Wrench {
        self.held[body].unwrap_or_else(|| coupling.motion(body, q))
    }

    /// Number of light bodies.
    pub fn count(&self) -> usize {
        self.bodies.len()
    }

    /// Balances one of the light bodies. `rest` is room to work in.
    pub fn balance<T: RealField + Copy, const D: usize>(
        &self,
        number: usize,
        stencil: &Stencil<T, D>,
        coupling: &BodyCoupling,
        b: &[T],
        q: &mut [T],
        rest: &mut [T],
    ) {
        let LightBody { body, inverse, sharers } = &self.bodies[number];
        for &cell in &coupling.cells[coupling.entries(*body)] {
            let at = cell as usize;
            rest[at] = b[at] - stencil.applied_at(q, at);
        }
        for &other in sharers {
            let motion = coupling.motion(other as usize, q);
            coupling.add_flux(other as usize, &motion, rest, |_| -1.0);
        }
        let wrench = Vector6::from(coupling.wrench(*body, rest));
        let amount: Wrench = (inverse * wrench).into();
        coupling.add_flux(*body, &amount, q, |_| 1.0);
    }
}

/// Pairs of a cell and a body beside it, sorted.
fn bodies_by_cell(coupling: &BodyCoupling) -> Vec<(u32, u32)> {
    let of =
        |body: usize| coupling.cells[coupling.entries(body)].iter().map(move |&c| (c, body as u32));
    let mut pairs: Vec<_> = (0..coupling.count()).flat_map(of).collect();
    pairs.sort_unstable();
    pairs
}

/// Bodies that share cells with a body, itself included.
fn sharers(coupling: &BodyCoupling, by_cell: &[(u32, u32)], body: usize) -> Vec<u32> {
    let mut all = vec![body as u32];
    for &cell in &coupling.cells[coupling.entries(body)] {
        let first = by_cell.partition_point(|pair| pair.0 < cell);
        let here = by_cell[first..].iter().take_while(|pair| pair.0 == cell);
        all.extend(here.map(|pair| pair.1));
    }
    all.sort_unstable();
    all.dedup();
    all
}

/// Inverse of `W^T A W` for one body.
fn balance<T: RealField + Copy, const D: usize>(
    stencil: &Stencil<T, D>,
    coupling: &BodyCoupling,
    body: usize,
    sharers: &[u32],
    scratch: &mut [f64],
) -> Matrix6<f64> {
    let entries = coupling.entries(body);
    let mut whole = Matrix6::<f64>::zeros();
    // J of each sharer times W.
    let mut felt = vec![Matrix6::<f64>::zeros(); sharers.len()];
    for column in 0..6 {
        for entry in entries.clone() {
            scratch[coupling.cells[entry] as usize] += coupling.wrenches[entry][column];
        }
        stencil.ghosts.fill(scratch);
        for entry in entries.clone() {
            let applied = stencil.applied_double(scratch, coupling.cells[entry] as usize);
            for row in 0..6 {
                whole[(row, column)] += coupling.wrenches[entry][row] * applied;
            }
        }
        for (felt, &other) in felt.iter_mut().zip(sharers) {
            felt.set_column(column, &Vector6::from(coupling.wrench(other as usize, scratch)));
        }
        for entry in entries.clone() {
            scratch[coupling.cells[entry] as usize] = 0.0;
        }
        stencil.ghosts.clear(scratch);
    }
    for (felt, &other) in felt.iter().zip(sharers) {
        let mobility = &coupling.mobility[other as usize];
        let mobility = Matrix6::<f64>::from_fn(|row, column| mobility[row][column]);
        whole += felt.transpose() * mobility * felt;
    }
    // Motions that press no cell have no stiffness.
    let eigen = (0.5 * (whole + whole.transpose())).symmetric_eigen();
    let most = eigen.eigenvalues.amax();
    let inverse = eigen.eigenvalues.map(|x| if x > 1e-9 * most { 1.0 / x } else { 0.0 });
    eigen.eigenvectors * Matrix6::from_diagonal(&inverse) * eigen.eigenvectors.transpose()
}
