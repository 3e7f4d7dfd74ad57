//! The state of all bodies and contacts, kept and put back.

use crate::solver::dem_solver::{GrainsDem, StepRecord};
use tremie_state::{KeepsState, StateError, StateExchange};

impl KeepsState for GrainsDem {
    const STATE_VERSION: u32 = 2;

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        self.exchange_bodies(state)?;
        self.exchange_contacts(state)?;
        let Self { fluid, stepping, .. } = self;
        state.value("loaded", &mut fluid.loaded)?;
        state.value("fluid_impulse", &mut fluid.fluid_impulse)?;
        state.value("window", &mut stepping.window)?;
        state.value("steps", &mut stepping.steps)?;
        let bodies = self.population.bodies.len();
        state.within("bands", |state| self.bands.exchange(state))?;
        state.within("probes", |state| self.probes.keep(state, bodies))?;
        state.within("profiles", |state| self.profiles.exchange(state))?;
        state.within("ports", |state| self.ports.exchange(state))
    }
}

impl GrainsDem {
    /// Puts bodies, parts and contacts back from a state of other grains, of the same scene but for its
    /// fluid. Time begins with them, and so do all that inlets, outlets, probes and profiles count.
    ///
    /// # Errors
    /// A state that is damaged or does not fit.
    pub fn take_bodies(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let room = self.population.bodies.len().max(self.ports.capacity);
        self.exchange_bodies(state)?;
        let found = self.population.bodies.len();
        if found > room {
            return state.unfit(format!("found {found} bodies, expected at most {room}"));
        }
        self.exchange_contacts(state)?;
        // Extremes since the start, which is now.
        (self.record.max_overlap_ratio, self.record.deep_overlaps) = Default::default();
        Ok(())
    }

    fn exchange_contacts(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        for (k, part) in self.around.parts.iter_mut().enumerate() {
            state.within(&format!("part{k}"), |state| part.exchange(state))?;
        }
        let Self { search, around, threads, population, record, .. } = self;
        let seen = (&population.bodies, &*around);
        state.within("contacts", |state| search.exchange(state, &mut threads.team, seen))?;
        state.within("record", |state| record.exchange(state))
    }

    fn exchange_bodies(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let population = &mut self.population;
        state.value("bodies", &mut population.bodies)?;
        state.within("polyhedra", |state| population.polyhedra.exchange(state))?;
        population.clumps.exchange(state)?;
        population.driven.exchange(state)?;
        state.value("order", &mut population.roll)?;
        state.value("next_id", &mut population.next_id)?;
        state.value("largest", &mut population.largest)?;
        state.value("came_and_went", &mut population.events)?;
        if state.restores() {
            // No step allocates.
            population.bodies.reserve(self.ports.capacity);
        }
        Ok(())
    }
}

impl StepRecord {
    fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.value("tallies", &mut self.tallies)?;
        state.value("reaches", &mut self.reaches)?;
        state.value("wandered", &mut self.wandered)?;
        state.value("crossed", &mut self.crossed)?;
        state.value("tally", &mut self.tally)?;
        state.value("max_overlap_ratio", &mut self.max_overlap_ratio)?;
        state.value("deep_overlaps", &mut self.deep_overlaps)
    }
}
