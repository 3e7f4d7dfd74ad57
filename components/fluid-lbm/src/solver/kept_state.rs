//! The state of the fluid, kept and put back.
//!
//! Links, mouths of gaps, thickness and the cells around bodies follow from where bodies are and
//! whose the cells are: they are found anew, and are the same.

use crate::bodies::body_list::BodySite;
use crate::lattice::collision_kernel::CollisionKernel;
use crate::solver::lbm_solver::LbmSolver;
use crate::solver::moving_bodies::MovingBodies;
use tremie_state::{StateError, StateExchange};

impl<T: CollisionKernel> LbmSolver<T> {
    /// Keeps all that the next steps depend on and the last one tells, or puts it back.
    ///
    /// # Errors
    /// A state of another scene, or what cannot be kept: bodies between their event and the step
    /// after.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let exchanged = self.exchange_all(state);
        // No rank may go on to what all do together while another could not follow.
        self.exec.ranks.agree(exchanged)?;
        if state.restores() {
            self.resume();
        }
        Ok(())
    }

    /// The part of an exchange of a rank on which it could not begin.
    ///
    /// # Errors
    /// This one, or that of the first rank that has one.
    pub fn fail_exchange(&mut self, error: StateError) -> Result<(), StateError> {
        self.exec.ranks.agree(Err(error))
    }

    fn exchange_all(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        if self.bodies.list.come_or_go() {
            return state.unfit("bodies come or go: the fluid is kept at the end of a step");
        }
        self.exchange_cells(state)?;
        let Self { lattice, collision, bodies, walls, faces, gaps, .. } = self;
        let numbers = &lattice.numbers;
        collision.exchange(state, &lattice.layout, numbers)?;
        state.value("on_bodies", &mut bodies.total)?;
        state.within("walls", |state| walls.exchange(state))?;
        state.within("faces", |state| faces.exchange(state, numbers))?;
        let cells = lattice.layout.cells.len();
        state.within("gaps", |state| gaps.exchange(state, numbers, cells))?;
        state.within("pinched", |state| self.pinched.exchange(state, numbers))?;
        state.within("budget", |state| self.budget.exchange(state, &lattice.units))?;
        state.within("probes", |state| self.probes.exchange(state))
    }

    /// The bodies, and whose the cells are.
    fn exchange_cells(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let Self { lattice, bodies: MovingBodies { list, awaited, .. }, exec, .. } = self;
        let mut site = BodySite {
            units: &lattice.units,
            layout: &lattice.layout,
            line: T::LINE,
            team: &mut exec.team,
        };
        let mut handles = Vec::new();
        state.within("bodies", |state| {
            handles = list.exchange(state, &mut site)?;
            Ok(())
        })?;
        state.within("surfaces", |state| {
            awaited.exchange(state, (&mut *list, &handles), &mut site)
        })?;
        state.within("cells", |state| lattice.exchange(state, |handle| list.is_alive(handle)))
    }

    /// Finds what follows from a state that was put back.
    fn resume(&mut self) {
        if self.bodies.list.had_any() {
            self.list_items();
        }
        let Self { lattice, collision, bodies, walls, faces, gaps, exec, .. } = self;
        lattice.recount(&mut exec.ranks);
        faces.count_entering(&mut exec.ranks);
        bodies.list.note_sharing(lattice.flags.sharing());
        let obstacles = &walls.conditions.ground().voxels.obstacles;
        gaps.resume(lattice, obstacles, &bodies.list, exec);
        bodies.find_links(lattice, gaps, &collision.requests, false, exec);
    }
}
