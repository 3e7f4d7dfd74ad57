//! The wall time of a window on each rank, split into computing and what is among ranks.

use crate::mpi_ranks::MpiRanks;
use std::time::Instant;
use tremie_fluid_lbm::Communicator;
use tremie_sdk::messages::start::RankTime;

/// A window that has begun on this rank.
pub struct TimedWindow {
    begin: Instant,
}

impl TimedWindow {
    /// The window begins now.
    pub fn begin(ranks: &mut MpiRanks) -> Self {
        ranks.take_time_among_ranks();
        Self { begin: Instant::now() }
    }

    /// The window has ended: the times of all ranks, in their order. All ranks ask for them.
    pub fn end(self, ranks: &mut MpiRanks) -> Vec<RankTime> {
        let all = self.begin.elapsed().as_nanos() as u64;
        let wait = ranks.take_time_among_ranks().as_nanos() as u64;
        let own = [all.saturating_sub(wait), wait];
        let told = ranks.gather_to_all(&own.map(u64::to_le_bytes).concat());
        let (numbers, _) = told.as_chunks::<8>();
        let numbers: Vec<u64> = numbers.iter().map(|bytes| u64::from_le_bytes(*bytes)).collect();
        let (ranks, _) = numbers.as_chunks::<2>();
        ranks.iter().map(|&[compute, wait]| RankTime { compute, wait }).collect()
    }
}
