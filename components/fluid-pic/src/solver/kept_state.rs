//! The fluid between the two parts of a step, kept and put back.

use crate::solids::rigid_body::RigidBody;
use crate::solver::pic_solver::PicSolver;
use tremie_state::{StateError, StateExchange};

impl<const D: usize> PicSolver<D> {
    /// Keeps what [`PicSolver::find_loads`] left, or puts it back. `bodies` are where they were then;
    /// walls and factors of open faces are those of that step.
    ///
    /// # Errors
    /// A state of another grid or of other solids, or a damaged one.
    pub fn exchange(
        &mut self,
        state: &mut StateExchange<'_>,
        bodies: &[RigidBody<D>],
    ) -> Result<(), StateError> {
        state.within("particles", |state| self.particles.exchange(state))?;
        state.within("shear", |state| self.viscosity.loads.exchange(state))?;
        state.within("open_faces", |state| self.open_faces.keep(state))?;
        state.list("separated", &mut self.separation.cells)?;
        state.value("pressed", &mut self.pressed)?;
        state.value("last_step", &mut self.last_step)?;
        state.value("damped_in_gaps", &mut self.gap_bands.taken)?;
        if state.restores() {
            self.check_kept(state, bodies)?;
            self.resume(bodies);
        }
        for a in 0..D {
            state.array(&format!("velocity{a}"), &mut self.velocity[a])?;
            state.array(&format!("displacement{a}"), &mut self.correction.displacement[a])?;
        }
        state.array("pressure", &mut self.q)?;
        state.array("right_side", &mut self.right)
    }

    /// Refuses numbers of cells and solids that are not there.
    fn check_kept(
        &self,
        state: &StateExchange<'_>,
        bodies: &[RigidBody<D>],
    ) -> Result<(), StateError> {
        let separated = &self.separation.cells;
        if let Some(cell) = separated.iter().find(|&&cell| !self.grid.is_inside(cell as usize)) {
            return state
                .unfit(format!("the state has air in cell {cell}, which is not in the box"));
        }
        let [found, expected] =
            [self.viscosity.loads.solids.len(), self.fractions.at_rest.len() + bodies.len()];
        if found != expected {
            return state
                .unfit(format!("the state has shear on {found} solids, expected {expected}"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::staggered_grid::StaggeredGrid;
    use crate::particles::seeding::seed;
    use crate::solver::pic_settings::PicSettings;
    use tremie_state::{KeepsState, SavedState};

    /// A tank, and the bodies in it.
    struct Tank(PicSolver<2>, Vec<RigidBody<2>>);

    impl KeepsState for Tank {
        const STATE_VERSION: u32 = 1;

        fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
            self.0.exchange(state, &self.1)
        }
    }

    fn tank(cells: [usize; 2], bodies: Vec<RigidBody<2>>) -> Tank {
        let grid = StaggeredGrid::new(cells, 0.1, [0.0; 2], [false; 2]);
        let settings = PicSettings::water([0.0, -9.81]);
        let mut solver = PicSolver::new(grid, settings, 1, Vec::new(), Vec::new()).unwrap();
        let is_wet = |x: [f64; 2]| x[1] < 0.5;
        seed(&solver.grid, &mut solver.particles, 2, 0.0, 1, is_wet, |_| [0.0; 2]);
        solver.remove_inside(&bodies);
        assert!(solver.find_loads(1e-3, &bodies, &mut Vec::new()).converged);
        Tank(solver, bodies)
    }

    #[test]
    fn a_state_that_does_not_fit_is_refused() {
        let disc = RigidBody::ball([0.4, 0.3], 0.15).with_mass(50.0);
        let saved = SavedState::of(&mut tank([8, 10], vec![disc.clone()])).unwrap();
        let refused = |mut by: Tank| saved.restore(&mut by).unwrap_err().to_string();
        assert!(saved.restore(&mut tank([8, 10], vec![disc.clone()])).is_ok());
        assert!(refused(tank([8, 10], Vec::new())).contains("shear on 1 solids"));
        assert!(refused(tank([8, 12], vec![disc.clone()])).contains("velocity0"));

        let mut other = tank([8, 10], vec![disc.clone()]);
        other.0.separation.cells.push(3);
        let saved = SavedState::of(&mut other).unwrap();
        let error = saved.restore(&mut tank([8, 10], vec![disc.clone()])).unwrap_err();
        assert!(error.to_string().contains("cell 3"), "{error}");

        other.0.particles.velocity[1].pop();
        let error = SavedState::of(&mut other).unwrap_err();
        assert!(error.to_string().contains("without all of their numbers"), "{error}");
    }
}
