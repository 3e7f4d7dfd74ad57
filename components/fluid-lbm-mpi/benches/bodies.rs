//! Times of what ranks tell each other of bodies in a window: poses from rank 0 to all, and the sums of loads of each
//! from those that have its links to all. It is started as ranks are; without MPI it says nothing:
//!
//! ```sh
//! cargo bench -p tremie-fluid-lbm-mpi --features mpi --bench bodies --no-run
//! mpiexec -n 2 target/release/deps/bodies-*
//! ```

#[cfg(feature = "mpi")]
#[path = "../src/daemon.rs"]
mod daemon;
#[cfg(feature = "mpi")]
#[path = "../src/kept_memory.rs"]
mod kept_memory;
#[cfg(feature = "mpi")]
#[allow(dead_code, reason = "the program uses the rest")]
#[path = "../src/mpi_ranks/mod.rs"]
mod mpi_ranks;
#[cfg(feature = "mpi")]
#[allow(dead_code, reason = "the program uses the rest")]
#[path = "../src/run_line.rs"]
mod run_line;

#[cfg(feature = "mpi")]
mod timed {
    use crate::mpi_ranks::MpiRanks;
    use std::time::Instant;
    use tremie_fluid_lbm::Communicator;
    use tremie_sdk::messages::{BodyState, bytes_of, values_of};

    /// Bytes of the sums of a body that moves: place, flags and links, then force, torque and momentum of swept cells.
    const SUMS: usize = 20 + 9 * 16;
    /// Times that each exchange is timed.
    const ROUNDS: usize = 60;

    /// Milliseconds since a moment.
    fn since(begin: Instant) -> f64 {
        1e3 * begin.elapsed().as_secs_f64()
    }

    /// The poses of all bodies, as a call takes them to all ranks.
    fn poses(ranks: &mut MpiRanks, count: usize) -> f64 {
        let bodies: Vec<_> = (0..count as u64).map(|id| BodyState::at_rest(id, [0.0; 3])).collect();
        ranks.add_up(&mut [0]);
        let begin = Instant::now();
        let got: Vec<BodyState> = if ranks.is_first() {
            ranks.tell(&[0; 8], bytes_of(&bodies));
            bodies
        } else {
            values_of(&ranks.wait_for_call()[8..]).unwrap_or_default()
        };
        // Until the last rank has them.
        ranks.add_up(&mut [0]);
        let took = since(begin);
        assert_eq!(got.len(), count);
        took
    }

    /// The sums of all bodies, of which each rank has as many as any other.
    fn loads(ranks: &mut MpiRanks, count: usize) -> f64 {
        let (rank, of) = (ranks.rank(), ranks.ranks());
        let of_rank = |rank: usize| {
            let own = count * (rank + 1) / of - count * rank / of;
            vec![rank as u8 + 1; own * SUMS]
        };
        let bytes = of_rank(rank);
        ranks.add_up(&mut [0]);
        let begin = Instant::now();
        let all = ranks.gather_to_all(&bytes);
        ranks.add_up(&mut [0]);
        let took = since(begin);
        assert!(all == (0..of).flat_map(of_rank).collect::<Vec<u8>>(), "{} bytes", all.len());
        took
    }

    /// Median and greatest.
    fn told(mut times: Vec<f64>) -> String {
        times.sort_by(f64::total_cmp);
        format!("{:.2} ms (worst {:.2})", times[times.len() / 2], times[times.len() - 1])
    }

    /// Times both, for some numbers of bodies.
    pub fn all(ranks: &mut MpiRanks) {
        for count in [1_000, 10_000, 100_000] {
            let (mut first, mut second) = (Vec::new(), Vec::new());
            for _ in 0..ROUNDS {
                first.push(poses(ranks, count));
                second.push(loads(ranks, count));
            }
            let both: Vec<f64> = first.iter().zip(&second).map(|(a, b)| a + b).collect();
            if ranks.is_first() {
                let (ranks, both) = (ranks.ranks(), told(both));
                let (poses, loads) = (told(first), told(second));
                tremie_sdk::log_line(format_args!(
                    "{count} bodies, {ranks} ranks: poses {poses}, loads {loads}, both {both}"
                ));
            }
        }
    }
}

fn main() {
    #[cfg(feature = "mpi")]
    kept_memory::keep_memory();
    #[cfg(feature = "mpi")]
    if let Some((universe, _)) = mpi::initialize_with_threading(mpi::Threading::Serialized) {
        timed::all(&mut mpi_ranks::MpiRanks::join(&universe));
    }
}
