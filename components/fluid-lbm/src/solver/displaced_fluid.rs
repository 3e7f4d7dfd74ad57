//! The fluid that bodies displace when they appear in the middle of a run.
//!
//! It goes back to the reservoir whose face is nearest: so what enters there in the mean, bodies and
//! fluid together, is what the piston displaces. Without a reservoir it is lost, as the ledger says.

use crate::lattice::collision_kernel::CollisionKernel;
use crate::solver::lbm_solver::LbmSolver;

impl<T: CollisionKernel> LbmSolver<T> {
    /// Gives reservoirs the mass of the cells that newcomers have covered or cut off in this step.
    pub(crate) fn give_back(&mut self) {
        if !self.reservoirs.is_empty() && !self.bodies.newcomers.is_empty() {
            let cells = self.owners.covered.len() + self.owners.enclosed.len();
            for k in 0..cells {
                let enclosed = k.checked_sub(self.owners.covered.len());
                let cell = enclosed.map_or_else(
                    || self.owners.covered[k],
                    |enclosed| self.owners.enclosed[enclosed],
                );
                self.give_back_cell(cell);
            }
        }
        self.bodies.newcomers.clear();
    }

    fn give_back_cell(&mut self, cell: u32) {
        let Some(handle) = self.holder_of(cell) else { return };
        let Some(body) = self.bodies.living_with_handle(handle) else { return };
        let (position, handle) = (body.position, body.handle);
        if !self.bodies.newcomers.contains(&handle) {
            return;
        }
        let mass = 1.0 + self.before().content(cell).drho;
        let grid = &self.layout.grid;
        let nearest = self
            .reservoirs
            .iter_mut()
            .min_by(|a, b| a.distance(position, grid).total_cmp(&b.distance(position, grid)));
        if let Some(reservoir) = nearest {
            reservoir.take_back(mass);
        }
    }
}
