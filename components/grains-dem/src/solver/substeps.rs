//! Substeps one by one, for whoever moves surfaces within them.
//!
//! ```text
//! begin_window(n, loads)
//!   n times:  begin_substep             bodies and sliders are at the end of the substep
//!             contact_on_surface ...    any number of trials, none of which leaves a trace
//!             finish_substep(accepted)  contact forces there, histories go on
//! end_window()                          velocities are those of the end
//! ```

use crate::bodies::deformable_surface::{FacetLoad, SurfaceState};
use crate::contact::contact_force::Steps;
use crate::math::error::GrainsError;
use crate::math::parameters::Integrator;
use crate::solver::dem_solver::GrainsDem;
use crate::solver::integrate::{self, AppliedForces};
use crate::walls::deformable_surfaces::RigidWalls;
use std::time::Instant;
use tremie_messages::body::{BodyState, Load};
use tremie_team::Choice;

/// Progress of a window.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Progress {
    open: bool,
    /// True if a substep was begun and not finished.
    inside: bool,
    /// Substeps that are finished.
    done: u32,
}

impl Progress {
    /// Checks that a call comes in its turn.
    pub(crate) fn expect(
        self,
        call: &'static str,
        open: bool,
        inside: bool,
    ) -> Result<(), GrainsError> {
        let first = match self {
            _ if (self.open, self.inside) == (open, inside) => return Ok(()),
            Self { inside: true, .. } => "finish_substep",
            Self { open: false, .. } => "begin_window",
            _ if inside => "begin_substep",
            _ => "end_window",
        };
        Err(GrainsError::OutOfOrder { call, first })
    }
}

impl GrainsDem {
    /// Begins a window of `substeps` steps under constant `loads`, as [`advance`](Self::advance)
    /// takes them.
    ///
    /// # Errors
    /// Loads that do not match the bodies; a window that was not ended.
    pub fn begin_window(&mut self, substeps: u32, loads: &[Load]) -> Result<(), GrainsError> {
        self.stepping.progress.expect("begin_window", false, false)?;
        self.take_loads(substeps, loads)?;
        self.stepping.window = substeps;
        self.stepping.progress = Progress { open: true, ..Progress::default() };
        Ok(())
    }

    /// Moves bodies and sliders to the end of the next substep, with the velocities that forces see
    /// there.
    ///
    /// # Errors
    /// Motions that have diverged; no window, or a substep that was not finished.
    pub fn begin_substep(&mut self) -> Result<(), GrainsError> {
        self.stepping.progress.expect("begin_substep", true, false)?;
        let is_alone = self
            .threads
            .choice
            .as_mut()
            .is_some_and(|choice| choice.begin(self.population.bodies.len()));
        self.threads.team.work_alone(is_alone);
        let begin = self.clock();
        self.drift(self.stepping.progress.done == 0)?;
        self.spend(begin);
        self.stepping.progress.inside = true;
        Ok(())
    }

    /// Loads on the facets of a surface of this shape: those of spheres and of its seat, as they
    /// would be if it were accepted. `loads` is cleared and gets one entry for each contact.
    /// Nothing that follows depends on it.
    ///
    /// # Errors
    /// Shapes that do not fit the surface; no substep that was begun.
    pub fn contact_on_surface(
        &mut self,
        surface: usize,
        vertices: &[[f64; 3]],
        velocities: &[[f64; 3]],
        loads: &mut Vec<FacetLoad>,
    ) -> Result<(), GrainsError> {
        self.stepping.progress.expect("contact_on_surface", true, true)?;
        let surfaces = self.search.surfaces.held.len();
        if surface >= surfaces {
            return Err(GrainsError::NoSurface { surface, surfaces });
        }
        let steps = Steps { before: self.stepping.dt, after: self.stepping.dt };
        let scenery = self.around.scenery(&self.population.bodies, self.record.crossed, steps);
        let search = &mut self.search;
        let around = self.around.near_surfaces(&self.population.bodies, search.cells.skins());
        let (contacts, parts) = (&mut search.parts, &self.around.parts[..]);
        let rigid = RigidWalls { contacts, parts, walls: &self.around.walls };
        let shape = (vertices, velocities);
        search.surfaces.try_shape(surface, shape, (&scenery, &around), rigid, loads)
    }

    /// Evaluates all contact forces, with those on the accepted surfaces, one for each of the run,
    /// and gives sliders what their surfaces carry.
    ///
    /// # Errors
    /// Shapes that do not fit the surfaces, contacts that are too deep; no substep that was begun.
    pub fn finish_substep(&mut self, accepted: &[SurfaceState<'_>]) -> Result<(), GrainsError> {
        self.stepping.progress.expect("finish_substep", true, true)?;
        let begin = self.clock();
        let dt = self.stepping.dt;
        let is_last = self.stepping.progress.done + 1 == self.stepping.window;
        self.search.parts.is_measured = is_last && self.profiles.are_due();
        match self.stepping.integrator {
            Integrator::Heun => self.correct_and_evaluate(accepted)?,
            _ => self.evaluate_forces(Steps { before: dt, after: dt }, accepted)?,
        }
        self.spend(begin);
        self.threads.found =
            self.threads.choice.as_mut().and_then(Choice::end).or(self.threads.found.take());
        self.stepping.progress.inside = false;
        self.stepping.progress.done += 1;
        self.check_overlap()
    }

    /// The time, while threads are being chosen.
    fn clock(&self) -> Option<Instant> {
        self.threads.choice.as_ref().and_then(Choice::clock)
    }

    /// Counts the time of a part of a substep that began then.
    fn spend(&mut self, begin: Option<Instant>) {
        if let Some(choice) = &mut self.threads.choice {
            choice.spend(begin);
        }
    }

    /// Ends a window: velocities are those of its end, and spheres come and go at inlets and
    /// outlets.
    ///
    /// # Errors
    /// More spheres than there is room for; no window, or a substep that was not finished.
    pub fn end_window(&mut self) -> Result<(), GrainsError> {
        self.stepping.progress.expect("end_window", true, false)?;
        let substeps = std::mem::take(&mut self.stepping.progress).done;
        match self.stepping.integrator {
            Integrator::Verlet if substeps > 0 => self.finish_half_kicks(),
            Integrator::Chen if substeps > 0 => self.end_subcycles(),
            _ => {}
        }
        let duration = f64::from(substeps) * self.stepping.dt;
        // Before spheres come and go: the probes know positions by the ranks of this window.
        self.probes.pass(
            &mut self.threads.team,
            &self.population.bodies,
            &self.around.bounds,
            duration,
        );
        self.profiles.end_window();
        self.sample_profiles();
        self.population.events.clear();
        self.pass_ports()
    }

    /// The half kick that ends a window under Verlet's method.
    fn finish_half_kicks(&mut self) {
        self.account_of_bands(0.5 * self.stepping.dt);
        let forces = AppliedForces::of(&self.search, &self.fluid, (self.gravity, &self.bands));
        integrate::second_half(
            &mut self.threads.team,
            &mut self.population.bodies,
            forces,
            self.stepping.dt,
        );
        self.population.clumps.second_half(&mut self.population.bodies, forces, self.stepping.dt);
        self.population.polyhedra.second_half(
            &mut self.population.bodies,
            self.fluid.loaded,
            self.stepping.dt,
        );
        self.around.parts.iter_mut().for_each(|part| part.finish(self.stepping.dt));
    }

    /// Pose and velocity of the slider that carries a surface: within a substep those that forces
    /// see. None where there is no such surface.
    pub fn carrier_state(&self, surface: usize) -> Option<BodyState> {
        let held = self.search.surfaces.held.get(surface)?;
        let before = self.around.parts[..held.carrier].iter().filter(|part| part.moves()).count();
        let id = self.population.roll.first_part + before as u64;
        Some(self.around.parts[held.carrier].state(id))
    }
}
