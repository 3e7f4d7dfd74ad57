//! Threads and vector instructions of a solver, and what each thread needs for itself.

use crate::boundary::link_batch::Batch;
use crate::ranks::rank_sums::Ranks;
use std::time::Instant;
use tremie_messages::Problem;
use tremie_team::{Choice, Found, Team, Variant};

/// Threads and vector instructions that do the work of a step. Results do not depend on them.
pub struct Execution {
    /// The threads.
    pub team: Team,
    /// Vector instructions that are used.
    pub variant: Variant,
    /// Room for the links of a body, for each thread.
    pub batches: Vec<Batch>,
    /// The ranks that compute the lattice together.
    pub ranks: Ranks,
    /// The search for the faster of the whole team and one thread, once that may be tried, and its
    /// last result.
    choice: Option<Choice>,
    found: Option<Found>,
}

impl Execution {
    /// On so many threads, the caller's included.
    ///
    /// # Errors
    /// Threads that the system does not give.
    pub fn new(threads: usize, variant: Variant, ranks: Ranks) -> Result<Self, Vec<Problem>> {
        let team = Team::new("fluid", threads).map_err(|error| {
            vec![Problem::new(
                "threads",
                format!("the system does not give {threads} threads: {error}"),
            )]
        })?;
        let batches = (0..team.threads()).map(|_| Batch::default()).collect();
        Ok(Self { team, variant, batches, ranks, choice: None, found: None })
    }

    /// See [`crate::LbmFluid::choose_threads`].
    pub fn choose_threads(&mut self) {
        self.choice = Some(Choice::new(self.team.threads()));
    }

    /// See [`crate::LbmFluid::take_found`].
    pub fn take_found(&mut self) -> Option<Found> {
        self.found.take()
    }

    /// Begins a step over so many cells; what it returns belongs to its end.
    pub fn begin_step(&mut self, cells: usize) -> Option<Instant> {
        let choice = self.choice.as_mut()?;
        self.team.work_alone(choice.begin(cells));
        choice.clock()
    }

    /// Ends a step that began then.
    pub fn end_step(&mut self, begin: Option<Instant>) {
        if let Some(choice) = &mut self.choice {
            choice.spend(begin);
            self.found = choice.end().or(self.found.take());
        }
    }
}
