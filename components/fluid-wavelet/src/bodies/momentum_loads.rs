//! Loads of the gas on bodies, by the momentum that goes through the faces between points in the gas
//! and points inside.

use crate::bodies::gas_body::BodyLoad;
use crate::gas::block_rates::FaceWatch;
use crate::grid::block_shape::BlockShape;

/// Momentum that goes into bodies in one block.
pub struct MomentumIntoBodies<'a> {
    /// Shape of the block.
    pub shape: &'a BlockShape,
    /// Spacing of its points [m].
    pub spacing: f64,
    /// For each point, ghosts included, 0 in gas, or the body's number and one inside it.
    pub marks: &'a [u16],
    /// Place of the block's first ghost [m].
    pub low: [f64; 3],
    /// A point seen from what the torque on a body is about, by the body's number [m].
    pub arm: &'a dyn Fn(usize, [f64; 3]) -> [f64; 3],
    /// The bodies that come near the block, ascending.
    pub near: &'a [u16],
    /// Their loads, to which is added.
    pub loads: &'a mut [BodyLoad],
}

impl FaceWatch for MomentumIntoBodies<'_> {
    fn see(&mut self, axis: usize, flux: &dyn Fn(usize, usize) -> f64) {
        let (from, to) = self.shape.own();
        let stride = self.shape.stride[axis];
        for row in self.shape.rows(from, to) {
            for p in row..row + self.shape.edge[0] {
                let [below, above] = [self.marks[p], self.marks[p + stride]];
                if below != above {
                    self.add(axis, p, above, 1.0, flux);
                    self.add(axis, p, below, -1.0, flux);
                }
            }
        }
    }
}

impl MomentumIntoBodies<'_> {
    /// Adds what goes through the face above a point to the body of a mark, if it is one.
    fn add(
        &mut self,
        axis: usize,
        p: usize,
        mark: u16,
        sign: f64,
        flux: &dyn Fn(usize, usize) -> f64,
    ) {
        let Some(body) = usize::from(mark).checked_sub(1) else { return };
        let dims = self.shape.dims;
        let area = self.spacing.powi(dims as i32 - 1);
        let mut at = self.shape.at(p).map(|k| k as f64);
        at[axis] += 0.5;
        let (mut force, mut place) = ([0.0; 3], [0.0; 3]);
        for a in 0..dims {
            force[a] = sign * area * flux(1 + a, p);
            place[a] = self.low[a] + self.spacing * at[a];
        }
        if let Ok(near) = self.near.binary_search(&(body as u16)) {
            self.loads[near].add(force, (self.arm)(body, place));
        }
    }
}
