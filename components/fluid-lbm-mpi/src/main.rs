//! The lattice fluid on several ranks of MPI: `fluid = "fluid-lbm-mpi"` in a manifest, with
//! `launch = ["mpiexec", "-n", "4"]` in its settings.
//!
//! Rank 0 is the component that the run knows: it has the line to the orchestrator and the channels in shared
//! memory. The other ranks make the calls that it makes, in the same order (`calls`). Each computes a share of the
//! lattice, with the same bits as `fluid-lbm` alone.

use std::process::ExitCode;

#[cfg(feature = "mpi")]
mod calls;
#[cfg(feature = "mpi")]
mod daemon;
#[cfg(feature = "mpi")]
mod first_rank;
#[cfg(feature = "mpi")]
mod kept_memory;
#[cfg(feature = "mpi")]
mod mpi_ranks;
#[cfg(feature = "mpi")]
mod other_ranks;
#[cfg(feature = "mpi")]
mod run_line;
#[cfg(feature = "mpi")]
mod timed_window;

#[cfg(feature = "mpi")]
fn main() -> ExitCode {
    mpi_ranks::end_with_launcher();
    kept_memory::keep_memory();
    // The component computes on the thread that speaks with the other ranks; only writers of lines have their own.
    let Some((universe, _)) = mpi::initialize_with_threading(mpi::Threading::Serialized) else {
        tremie_sdk::log_line("MPI does not start");
        return ExitCode::FAILURE;
    };
    let code = match mpi_ranks::MpiRanks::join(&universe) {
        ranks if ranks.is_first() => first_rank::main(ranks),
        ranks => other_ranks::serve(ranks),
    };
    drop(universe);
    code
}

#[cfg(not(feature = "mpi"))]
fn main() -> ExitCode {
    tremie_sdk::log_line(
        "fluid-lbm-mpi was built without MPI. Install an MPI and libclang (Debian: libopenmpi-dev openmpi-bin \
         libclang-dev, or libmpich-dev mpich), then: cargo build --release -p tremie-fluid-lbm-mpi --features mpi",
    );
    ExitCode::from(2)
}
