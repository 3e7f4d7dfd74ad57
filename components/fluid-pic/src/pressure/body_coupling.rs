//! Bodies that move under the pressure: what each cell exerts on them.

use nalgebra::{RealField, convert, convert_unchecked};
use std::collections::BTreeMap;

/// Force and torque, padded to three dimensions: in two, the force has the first two entries and
/// the torque the last.
pub type Wrench = [f64; 6];

/// Sum of products.
#[inline(always)]
pub fn dot6(a: &Wrench, b: &Wrench) -> f64 {
    (0..6).map(|k| a[k] * b[k]).sum()
}

/// Cells that border on free bodies, and what they exert: `J` of the equations.
#[derive(Clone, Debug, Default)]
pub struct BodyCoupling {
    /// Body k has the entries from number k to number k + 1.
    pub first: Vec<u32>,
    /// Cell of each entry.
    pub cells: Vec<u32>,
    /// Wrench on the body of a unit of `q` in the cell.
    pub wrenches: Vec<Wrench>,
    /// Of each body, `rho h^D` over its mass and moments of inertia: what a wrench of `q` changes
    /// its velocities by. Symmetric.
    pub mobility: Vec<[[f64; 6]; 6]>,
    /// Volume of each body, in cells of this level.
    pub volume: Vec<f64>,
    /// Volume of each body, in cells of the finest level.
    pub displaced: Vec<f64>,
}

impl BodyCoupling {
    /// Number of bodies.
    pub fn count(&self) -> usize {
        self.mobility.len()
    }

    /// Removes all bodies.
    pub fn clear(&mut self) {
        self.first.clear();
        self.first.push(0);
        self.cells.clear();
        self.wrenches.clear();
        self.mobility.clear();
        self.volume.clear();
        self.displaced.clear();
    }

    /// Removes all bodies from number `bodies` on.
    pub fn truncate(&mut self, bodies: usize) {
        self.first.truncate(bodies + 1);
        let entries = self.first.last().map_or(0, |&entry| entry as usize);
        self.cells.truncate(entries);
        self.wrenches.truncate(entries);
        self.mobility.truncate(bodies);
        self.volume.truncate(bodies);
        self.displaced.truncate(bodies);
    }

    /// Ends the entries of a body of a volume in cells.
    pub fn close_body(&mut self, mobility: [[f64; 6]; 6], volume: f64) {
        self.first.push(self.cells.len() as u32);
        self.mobility.push(mobility);
        self.volume.push(volume);
        self.displaced.push(volume);
    }

    /// Entries of a body.
    #[inline]
    pub fn entries(&self, body: usize) -> std::ops::Range<usize> {
        self.first[body] as usize..self.first[body + 1] as usize
    }

    /// Wrench of `q` on a body.
    #[inline]
    pub fn wrench<T: RealField + Copy>(&self, body: usize, q: &[T]) -> Wrench {
        let mut sum = [0.0; 6];
        for entry in self.entries(body) {
            let q: f64 = convert_unchecked(q[self.cells[entry] as usize]);
            for k in 0..6 {
                sum[k] += self.wrenches[entry][k] * q;
            }
        }
        sum
    }

    /// Change of a body's velocities by a wrench of `q`.
    #[inline]
    pub fn moved(&self, body: usize, wrench: &Wrench) -> Wrench {
        std::array::from_fn(|k| dot6(&self.mobility[body][k], wrench))
    }

    /// Change of a body's velocities by `q`: `S J q`.
    #[inline]
    pub fn motion<T: RealField + Copy>(&self, body: usize, q: &[T]) -> Wrench {
        self.moved(body, &self.wrench(body, q))
    }

    /// Adds the flux that velocities of a body push into the cells, `J^T U`, times a factor that
    /// may depend on the cell.
    #[inline]
    pub fn add_flux<T: RealField + Copy>(
        &self,
        body: usize,
        velocity: &Wrench,
        out: &mut [T],
        factor: impl Fn(usize) -> f64,
    ) {
        for entry in self.entries(body) {
            let at = self.cells[entry] as usize;
            out[at] += convert(factor(at) * dot6(&self.wrenches[entry], velocity));
        }
    }

    /// Adds `J^T S J q`, times a factor that may depend on the cell.
    pub fn apply<T: RealField + Copy>(
        &self,
        q: &[T],
        out: &mut [T],
        factor: impl Fn(usize) -> f64,
    ) {
        for body in 0..self.count() {
            let motion = self.motion(body, q);
            self.add_flux(body, &motion, out, &factor);
        }
    }

    /// The entries of coarser cells: sums over their children, which `parent` names; a coarse cell
    /// has `children`. A grid whose cells are larger than a body's volume over `resolved` does not
    /// show how fluid yields to the body; there the body carries half of the fluid that it
    /// displaces.
    pub fn coarsen(
        &self,
        parent: impl Fn(usize) -> usize,
        children: usize,
        resolved: f64,
        coarse: &mut Self,
    ) {
        coarse.clear();
        let mut sums = BTreeMap::<u32, Wrench>::new();
        for body in 0..self.count() {
            for entry in self.entries(body) {
                let sum = sums.entry(parent(self.cells[entry] as usize) as u32).or_default();
                for k in 0..6 {
                    sum[k] += self.wrenches[entry][k];
                }
            }
            for (&cell, &wrench) in &sums {
                coarse.cells.push(cell);
                coarse.wrenches.push(wrench);
            }
            sums.clear();
            let volume = self.volume[body] / children as f64;
            let mut mobility = self.mobility[body];
            if self.volume[body] >= resolved && volume < resolved {
                for k in 0..3 {
                    mobility[k][k] /= 1.0 + 0.5 * self.displaced[body] * mobility[k][k];
                }
            }
            coarse.close_body(mobility, volume);
            coarse.displaced[body] = self.displaced[body];
        }
    }

    /// Size of `S J J^T` of a body, its trace: how stiff it makes the equations of the cells beside
    /// it.
    pub fn stiffness(&self, body: usize) -> f64 {
        let mobility = &self.mobility[body];
        let of = |wrench: &Wrench| -> f64 {
            (0..6).map(|k| wrench[k] * dot6(&mobility[k], wrench)).sum()
        };
        self.entries(body).map(|entry| of(&self.wrenches[entry])).sum()
    }
}
