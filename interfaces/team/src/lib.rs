//! Team of threads that works through one list after another, and vector [instructions] of the
//! processor.
//!
//! The team belongs to one solver and lives as long. Items of a list are handed out in runs, so
//! chance decides which thread does which item. Results do not depend on it, because every item has
//! its own place for results.
//!
//! Other processes share the processor. A worker that is not running when a list begins is not
//! waited for. A thread that waits spins a little, then yields a little, then sleeps.

#![warn(clippy::print_stdout, clippy::print_stderr)]

mod choice;
mod gather;
pub mod instructions;
mod pieces;
pub mod simd;

pub use choice::{Choice, Found};
pub use gather::{Places, SimdGather};
pub use instructions::Variant;
pub use pieces::{Cut, Pieces};

use std::any::Any;
use std::cell::UnsafeCell;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering::*};
use std::sync::{Arc, Mutex};
use std::thread::{JoinHandle, Thread};

/// Rounds of waiting with a pause instruction, then with `sched_yield`, before a thread sleeps.
const SPINS: u32 = 200;
const YIELDS: u32 = 1000;

/// Bit of the state that says that workers may join the job.
const OPEN: u64 = 1 << 15;
/// Bits of the state that count workers inside the job.
const ACTIVE: u64 = OPEN - 1;
/// One job further: the upper bits of the state number the jobs.
const NEXT: u64 = 1 << 16;

/// State that leader and workers share.
struct Shared {
    /// Number of the job, whether it is open, and how many workers are in it.
    state: AtomicU64,
    /// The job. Written by the leader while it is closed and nobody is inside; read by workers
    /// inside.
    job: UnsafeCell<Option<*const (dyn Fn() + Sync)>>,
    /// The thread to wake when the last worker leaves.
    leader: Mutex<Option<Thread>>,
    /// Payload of the first worker's panic.
    panic: Mutex<Option<Box<dyn Any + Send>>>,
    stop: AtomicBool,
}

// SAFETY: `job` is the only field that is not `Sync` and `Send` by itself. The leader writes it
// while `state` is closed with no worker inside; workers read it only after they have joined, which
// the leader's release store of the open state orders after the write; and the leader does not
// return from `run`, so that the job stays alive, until the state is closed and the last worker has
// left.
unsafe impl Sync for Shared {}
// SAFETY: as above.
unsafe impl Send for Shared {}

/// A team of the calling thread and its workers.
pub struct Team {
    shared: Arc<Shared>,
    workers: Vec<JoinHandle<()>>,
    is_alone: bool,
}

/// Least number of runs of pieces for each thread, where there are enough pieces.
const SHARES: usize = 8;
/// Greatest number of pieces in a run.
const RUN: usize = 64;

/// The next run of pieces that no thread has taken; `None` if there are none left. Pieces that
/// follow each other in memory are best done one after the other, by one thread. Runs become
/// shorter towards the end, so that all threads end together.
fn next_run(next: &AtomicUsize, count: usize, shares: usize) -> Option<Range<usize>> {
    let length = |begin: usize| ((count - begin) / shares).clamp(1, RUN);
    // Relaxed order will do: the counter only hands out numbers. The job's state orders the data.
    let taken =
        next.fetch_update(Relaxed, Relaxed, |begin| (begin < count).then(|| begin + length(begin)));
    taken.ok().map(|begin| begin..begin + length(begin))
}

/// Waits a little; the longer it has waited already, the more gently.
fn pause(round: u32) {
    if round < SPINS {
        std::hint::spin_loop();
    } else if round < SPINS + YIELDS {
        std::thread::yield_now();
    } else {
        std::thread::park();
    }
}

impl Shared {
    /// Loop of a worker: joins each job that is open, until the team stops.
    fn work(&self) {
        let mut done = u64::MAX;
        let mut round = 0;
        while !self.stop.load(Acquire) {
            let state = self.state.load(Acquire);
            let number = state / NEXT;
            if state & OPEN == 0 || number == done {
                pause(round);
                round += 1;
                continue;
            }
            // Joins by counting itself in. It fails if the state has changed meanwhile, and looks
            // again. The job's number in the upper bits guards against a job that closed and
            // another that opened.
            if self.state.compare_exchange(state, state + 1, AcqRel, Relaxed).is_err() {
                continue;
            }
            // SAFETY: this worker is inside the job (see `Sync for Shared`).
            let job = unsafe { &*(*self.job.get()).expect("an open job") };
            // A panic must not skip the count below: the leader would wait for ever.
            if let Err(panic) = catch_unwind(AssertUnwindSafe(job)) {
                self.panic.lock().unwrap_or_else(|e| e.into_inner()).get_or_insert(panic);
            }
            let before = self.state.fetch_sub(1, AcqRel);
            // The last one out of a closed job wakes the leader, which may have parked.
            if before & (ACTIVE | OPEN) == 1
                && let Some(leader) = &*self.leader.lock().unwrap_or_else(|e| e.into_inner())
            {
                leader.unpark();
            }
            // A worker joins a job once: the count of joins numbers the rooms.
            done = number;
            round = 0;
        }
    }
}

impl Team {
    /// A team of `threads` threads, the caller's included (at least one); the others are called
    /// `name 1` and so on.
    ///
    /// # Errors
    /// If the system gives no more threads.
    pub fn new(name: &str, threads: usize) -> std::io::Result<Self> {
        let shared = Arc::new(Shared {
            state: AtomicU64::new(0),
            job: UnsafeCell::new(None),
            leader: Mutex::new(None),
            panic: Mutex::new(None),
            stop: AtomicBool::new(false),
        });
        let mut team = Self { shared, workers: Vec::new(), is_alone: false };
        for k in 1..threads.min(ACTIVE as usize) {
            let shared = team.shared.clone();
            let worker = std::thread::Builder::new().name(format!("{name} {k}"));
            team.workers.push(worker.spawn(move || shared.work())?);
        }
        Ok(team)
    }

    /// Threads of the team, the caller's included.
    pub fn threads(&self) -> usize {
        1 + self.workers.len()
    }

    /// From now on the caller does everything, and the others sleep.
    pub fn work_alone(&mut self, is_alone: bool) {
        self.is_alone = is_alone;
    }

    /// Calls `work` once for each item, on any thread, in any order; returns when all are done.
    ///
    /// # Panics
    /// If `work` panicked on any thread.
    pub fn for_each<T: Send>(&mut self, items: &mut [T], work: impl Fn(usize, &mut T) + Sync) {
        self.for_pieces(Cut::every(items, 1), |k, item: &mut [T]| work(k, &mut item[0]));
    }

    /// As [`Team::for_each`], with room for each thread to work in, one for each of
    /// [`Team::threads`]. What stands in a room depends on chance.
    ///
    /// # Panics
    /// If `work` panicked on any thread, or there are fewer rooms than threads.
    pub fn for_each_with<T: Send, R: Send>(
        &mut self,
        items: &mut [T],
        rooms: &mut [R],
        work: impl Fn(&mut R, usize, &mut T) + Sync,
    ) {
        let items = Cut::every(items, 1);
        self.for_pieces_with(items, rooms, |room, k, item: &mut [T]| work(room, k, &mut item[0]));
    }

    /// Calls `work` once for each piece, on any thread, in any order; returns when all are done.
    ///
    /// # Panics
    /// If `work` panicked on any thread.
    pub fn for_pieces<P: Pieces>(&mut self, pieces: P, work: impl Fn(usize, P::Piece) + Sync) {
        // Rooms of no size: an array of them takes no memory.
        let mut rooms = [(); ACTIVE as usize];
        self.for_pieces_with(pieces, &mut rooms, |(), k, piece| work(k, piece));
    }

    /// As [`Team::for_pieces`], with room for each thread as [`Team::for_each_with`] has it.
    ///
    /// # Panics
    /// If `work` panicked on any thread, or there are fewer rooms than threads.
    pub fn for_pieces_with<P: Pieces, R: Send>(
        &mut self,
        pieces: P,
        rooms: &mut [R],
        work: impl Fn(&mut R, usize, P::Piece) + Sync,
    ) {
        assert!(rooms.len() >= self.threads());
        let next = AtomicUsize::new(0);
        let count = pieces.count();
        let shares = SHARES * self.threads();
        let thread = AtomicUsize::new(0);
        let rooms = Cut::every(rooms, 1);
        let take = || {
            // SAFETY: each thread of the team calls this once a job, so that the number is one of
            // the rooms and no other thread has it; the rooms are borrowed for the whole call.
            let room = &mut unsafe { rooms.piece(thread.fetch_add(1, Relaxed)) }[0];
            while let Some(run) = next_run(&next, count, shares) {
                for k in run {
                    // SAFETY: `k` is one of the pieces and handed out once; what the pieces are of
                    // is borrowed for the whole call, which outlives the job.
                    work(room, k, unsafe { pieces.piece(k) });
                }
            }
        };
        if self.workers.is_empty() || self.is_alone || count < 2 { take() } else { self.run(&take) }
    }

    /// Calls `job` on this thread and on every worker that comes in time.
    fn run(&mut self, job: &(dyn Fn() + Sync)) {
        let shared = &*self.shared;
        // Set before the job opens: a worker that leaves early must find whom to wake.
        *shared.leader.lock().unwrap_or_else(|e| e.into_inner()) = Some(std::thread::current());
        // SAFETY: the lifetime is erased; `run` ends only when no worker can reach the job any
        // more.
        let job_for_all = unsafe {
            std::mem::transmute::<*const (dyn Fn() + Sync + '_), *const (dyn Fn() + Sync + 'static)>(
                job,
            )
        };
        // SAFETY: the state is closed and nobody is inside (`&mut self`: there is one leader).
        unsafe { *shared.job.get() = Some(job_for_all) };
        // The release makes the job visible to every worker that sees the open state.
        let closed = shared.state.load(Relaxed) + NEXT;
        shared.state.store(closed | OPEN, Release);
        for worker in &self.workers {
            worker.thread().unpark();
        }
        // A panic here must wait too: workers still use the job, which lives on this stack.
        let outcome = catch_unwind(AssertUnwindSafe(job));
        // Closes the job to late workers, then waits for those inside.
        shared.state.fetch_and(!OPEN, AcqRel);
        let mut round = 0;
        while shared.state.load(Acquire) & ACTIVE != 0 {
            pause(round);
            round += 1;
        }
        let of_worker = shared.panic.lock().unwrap_or_else(|e| e.into_inner()).take();
        if let Some(panic) = outcome.err().or(of_worker) {
            resume_unwind(panic);
        }
    }
}

impl Drop for Team {
    fn drop(&mut self) {
        self.shared.stop.store(true, Release);
        for worker in self.workers.drain(..) {
            // A parked worker sees `stop` only when it is woken.
            worker.thread().unpark();
            // A worker's panic was passed on by the job in which it happened.
            let _ = worker.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_item_is_done_once() {
        for threads in [1, 2, 3, 5] {
            let mut team = Team::new("test", threads).unwrap();
            let mut items = vec![0_u32; 1000];
            for _ in 0..200 {
                team.for_each(&mut items, |_, item| *item += 1);
            }
            assert!(items.iter().all(|&n| n == 200));
        }
    }

    #[test]
    fn runs_cover_all_pieces_and_become_shorter() {
        for (count, shares) in [(0, 8), (1, 16), (57, 16), (1728, 16), (10_000, 8)] {
            let next = AtomicUsize::new(0);
            let runs: Vec<_> = std::iter::from_fn(|| next_run(&next, count, shares)).collect();
            assert!(runs.iter().cloned().flatten().eq(0..count));
            assert!(runs.is_sorted_by_key(|run| std::cmp::Reverse(run.len())), "{runs:?}");
            assert!(runs.iter().all(|run| run.len() <= RUN.min(1 + count / shares)), "{runs:?}");
        }
    }

    #[test]
    fn each_thread_has_a_room_of_its_own() {
        let mut team = Team::new("test", 3).unwrap();
        let mut items = vec![0_u32; 1000];
        let mut rooms = vec![0_u32; team.threads()];
        for _ in 0..50 {
            team.for_each_with(&mut items, &mut rooms, |room, _, item| {
                *room += 1;
                *item += 1;
            });
        }
        assert_eq!(rooms.iter().sum::<u32>(), 50_000);
    }

    #[test]
    fn a_panic_of_a_worker_reaches_the_caller_and_the_team_lives_on() {
        let mut team = Team::new("test", 3).unwrap();
        let mut items = vec![0_usize; 100];
        let outcome = catch_unwind(AssertUnwindSafe(|| {
            team.for_each(&mut items, |k, _| assert_ne!(k, 57));
        }));
        assert!(outcome.is_err());
        team.for_each(&mut items, |k, item| *item = k);
        assert_eq!(items[99], 99);
    }
}
