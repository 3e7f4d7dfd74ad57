//! Who does not answer: rank 0 asks, names those that are silent, and all ranks end.

use super::{MpiRanks, no_request};
use crate::daemon::end_daemon;
use mpi::ffi;
use mpi::traits::{AsRaw, Equivalence};
use std::ffi::c_int;
use std::time::{Duration, Instant};

/// Tag of the question whether a rank is there, and of the answer.
const ASK: c_int = 2;
/// See `ASK`.
const ANSWER: c_int = 3;

/// Longest wait for the answer of a rank that is asked whether it is there.
pub(super) const ANSWER_TIME: Duration = Duration::from_secs(1);

impl MpiRanks {
    /// True if a message with a tag has come from a rank; takes it.
    fn take(&self, from: c_int, tag: c_int) -> Option<c_int> {
        let mut found = 0;
        // SAFETY: an all-zero status is one that MPI overwrites.
        let mut status: ffi::MPI_Status = unsafe { std::mem::zeroed() };
        // SAFETY: MPI writes to both, which live here.
        unsafe {
            ffi::MPI_Iprobe(from, tag, self.common.comm, &mut found, &mut status);
        }
        if found == 0 {
            return None;
        }
        let source = status.MPI_SOURCE;
        // SAFETY: an empty message needs no buffer; it is there, so that the call returns at once.
        unsafe {
            ffi::MPI_Recv(
                std::ptr::null_mut(),
                0,
                u8::equivalent_datatype().as_raw(),
                source,
                tag,
                self.common.comm,
                &mut status,
            );
        }
        Some(source)
    }

    /// Sends an empty message, which MPI keeps itself.
    fn knock(&self, to: c_int, tag: c_int) {
        let mut request = no_request();
        // SAFETY: an empty message needs no buffer.
        unsafe {
            ffi::MPI_Isend(
                std::ptr::null(),
                0,
                u8::equivalent_datatype().as_raw(),
                to,
                tag,
                self.common.comm,
                &mut request,
            );
            ffi::MPI_Request_free(&mut request);
        }
    }

    /// Answers rank 0 if it asks whether this rank is there.
    pub(super) fn answer(&self) {
        if !self.is_first() && self.take(0, ASK).is_some() {
            self.knock(0, ANSWER);
        }
    }

    /// Says who does not answer, and ends all ranks.
    pub(super) fn give_up(&self, waited: Duration) -> ! {
        let seconds = waited.as_secs_f64();
        let missing = if self.is_first() { self.missing() } else { vec![0] };
        let all: Vec<_> = missing.iter().map(|&rank| self.name(rank)).collect();
        let who = if all.is_empty() { "some rank".into() } else { all.join(", ") };
        let have = if all.len() > 1 { "have" } else { "has" };
        let text = format!(
            "{who} {have} not answered for {seconds:.0} s: a rank hangs, or its host is out of reach. \
             `deadline` in settings.fluid-lbm-mpi allows more time"
        );
        tracing_error(&text);
        self.on_line(|line| line.tell(&text));
        // The launcher passes these words on before it ends, or is ended.
        std::thread::sleep(Duration::from_millis(100));
        if !self.is_first() {
            // MPI would ask the daemon to end all, and it would ask a launcher that may be out of reach.
            end_daemon();
        }
        // Where MPI cannot end the others, the launcher does when this process ends; or the run ends the launcher.
        std::thread::spawn(|| {
            std::thread::sleep(Duration::from_secs(2));
            std::process::exit(3);
        });
        // SAFETY: ends all processes of the world, this one among them.
        unsafe {
            ffi::MPI_Abort(self.common.comm, 3);
        }
        std::process::exit(3)
    }

    /// Ranks that do not say that they are there.
    fn missing(&self) -> Vec<usize> {
        let others = 1..self.common.ranks;
        others.clone().for_each(|rank| self.knock(rank, ASK));
        let mut silent: Vec<c_int> = others.collect();
        let begin = Instant::now();
        while !silent.is_empty() && begin.elapsed() < ANSWER_TIME {
            silent.retain(|&rank| self.take(rank, ANSWER).is_none());
            std::thread::sleep(Duration::from_millis(5));
        }
        silent.into_iter().map(|rank| rank as usize).collect()
    }
}

/// Writes an error as the run's log takes it.
fn tracing_error(text: &str) {
    tremie_sdk::log_line(serde_json::json!({ "level": "ERROR", "message": text }));
}
