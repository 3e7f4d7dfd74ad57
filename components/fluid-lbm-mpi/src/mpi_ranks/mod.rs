//! Ranks of MPI that compute a lattice together.
//!
//! No wait is MPI's own, which has no end: all that ranks send is sent without waiting, and asked after until it is
//! there or the deadline has passed. Then rank 0 finds out who does not answer, says so, and ends all ranks.

mod collectives;
mod silent_ranks;

use self::collectives::TOLD;
use self::silent_ranks::ANSWER_TIME;
use crate::run_line::RunLine;
use mpi::collective::SystemOperation;
use mpi::environment::Universe;
use mpi::ffi::{self, MPI_Comm, MPI_Datatype, MPI_Request};
use mpi::traits::{AsRaw, Communicator as _, Equivalence};
use std::cell::{Cell, RefCell};
use std::ffi::{c_int, c_void};
use std::rc::Rc;
use std::time::{Duration, Instant};
use tremie_fluid_lbm::{Communicator, Parcel};

/// Tag of parcels of halos.
const PARCEL: c_int = 1;
/// Tag of what rank 0 gathers.
const GATHER: c_int = 4;

/// Beginnings of the names of Open MPI's shared memory, in version 4 and in version 5.
const SEGMENTS: [&str; 2] = ["/dev/shm/vader_segment.", "/dev/shm/sm_segment."];

/// The handle of one rank; copies of it speak for the same rank.
#[derive(Clone)]
pub struct MpiRanks {
    common: Rc<Common>,
    /// Parcels under way.
    swap: Rc<RefCell<Vec<MPI_Request>>>,
}

/// What all copies share.
struct Common {
    comm: MPI_Comm,
    rank: c_int,
    ranks: c_int,
    /// Host and process of each rank.
    names: Vec<String>,
    deadline: RefCell<Duration>,
    /// Time in waits for other ranks, and in sending to them, since it was last taken.
    among_ranks: Cell<Duration>,
    /// Rank 0's way to tell the run of a fault.
    line: RefCell<Option<RunLine>>,
}

// SAFETY: the handles are used by one thread at a time, the one that computes; MPI was asked to allow that thread to
// be any (`Threading::Serialized`).
unsafe impl Send for MpiRanks {}

/// Lets this process end with the one that launched it, so that no rank outlives its run.
pub fn end_with_launcher() {
    // SAFETY: asks the system for a signal; touches no memory.
    unsafe {
        libc::prctl(libc::PR_SET_PDEATHSIG, libc::SIGKILL);
    }
}

impl MpiRanks {
    /// All ranks that were launched together.
    pub fn join(universe: &Universe) -> Self {
        let world = universe.world();
        let host = mpi::environment::processor_name().unwrap_or_else(|_| "an unknown host".into());
        let common = Common {
            comm: world.as_raw(),
            rank: world.rank(),
            ranks: world.size(),
            names: Vec::new(),
            deadline: RefCell::new(Duration::from_secs(60)),
            among_ranks: Cell::default(),
            line: RefCell::new(None),
        };
        let mut ranks = Self { common: Rc::new(common), swap: Rc::default() };
        let own = format!("{host}\n{}", std::process::id());
        let mut names = ranks.gather(own.as_bytes()).join(&0);
        ranks.broadcast(&mut names);
        let names = names.split(|&byte| byte == 0);
        let names = names.map(|name| String::from_utf8_lossy(name).into_owned()).collect();
        if let Some(common) = Rc::get_mut(&mut ranks.common) {
            common.names = names;
        }
        ranks.take_names_off_memory();
        ranks
    }

    /// Takes the names off the shared memory of Open MPI on this host, once all ranks have opened it: so nothing of it
    /// stays where ranks are killed. (MPICH does so itself.)
    fn take_names_off_memory(&mut self) {
        let own = self.common.rank as usize;
        let others = (0..self.common.ranks as usize).filter(|&rank| rank != own);
        let mut parcels: Vec<_> = others.map(|rank| Parcel { rank, bytes: vec![0] }).collect();
        let sends = parcels.clone();
        self.begin_swap(&sends, &mut parcels);
        self.end_swap(&mut parcels);
        // Now all have opened what they will ever open.
        self.add_up(&mut [0]);
        let maps = std::fs::read_to_string("/proc/self/maps").unwrap_or_default();
        let files = maps.lines().filter_map(|line| line.split_ascii_whitespace().nth(5));
        for file in files.filter(|file| SEGMENTS.iter().any(|name| file.starts_with(name))) {
            // Another rank may have done it.
            let _ = std::fs::remove_file(file);
        }
    }

    /// True for the rank that the run knows.
    pub fn is_first(&self) -> bool {
        self.common.rank == 0
    }

    /// Number of ranks on the host of this rank.
    pub fn on_this_host(&self) -> usize {
        let host = |name: &String| name.split('\n').next().map(str::to_string);
        let own = host(&self.common.names[self.common.rank as usize]);
        self.common.names.iter().filter(|name| host(name) == own).count()
    }

    /// Sets how long the others may take to answer.
    pub fn set_deadline(&self, deadline: Duration) {
        // Rank 0 speaks first: it can say who is missing, once it has asked all.
        let later = deadline.mul_f64(1.5) + 5 * ANSWER_TIME;
        let patience = if self.is_first() { deadline } else { later };
        *self.common.deadline.borrow_mut() = patience;
    }

    /// Sets the line on which rank 0 tells the run that it gives up.
    pub fn set_line(&self, line: RunLine) {
        *self.common.line.borrow_mut() = Some(line);
    }

    /// Does something with that line, where there is one.
    pub fn on_line<T>(&self, change: impl FnOnce(&mut RunLine) -> T) -> Option<T> {
        self.common.line.borrow_mut().as_mut().map(change)
    }

    /// Time for which this rank waited for others, or sent to them, since this was last asked.
    pub fn take_time_among_ranks(&self) -> Duration {
        self.common.among_ranks.take()
    }

    fn count_among_ranks(&self, since: Instant) {
        let time = &self.common.among_ranks;
        time.set(time.get() + since.elapsed());
    }

    /// The next broadcast of rank 0, however long that takes: it is waiting for the run.
    pub fn wait_for_call(&self) -> Vec<u8> {
        self.hear(None)
    }

    /// A rank as a user finds it.
    fn name(&self, rank: usize) -> String {
        match self.common.names.get(rank).and_then(|name| name.split_once('\n')) {
            Some((host, process)) => format!("rank {rank} on {host} (process {process})"),
            None => format!("rank {rank}"),
        }
    }

    /// Waits until all requests are done; `None` waits for ever.
    fn wait(&self, requests: &mut [MPI_Request], deadline: Option<Duration>) {
        let begin = Instant::now();
        let mut rounds = 0_u32;
        loop {
            let mut done = 0;
            // SAFETY: the requests are this rank's own, and so many; MPI writes `done` and may null requests; no
            // status is asked for. The buffers of the requests live until they are done (callers).
            unsafe {
                ffi::MPI_Testall(
                    requests.len() as c_int,
                    requests.as_mut_ptr(),
                    &mut done,
                    ffi::RSMPI_STATUSES_IGNORE,
                );
            }
            if done != 0 {
                return self.count_among_ranks(begin);
            }
            rounds += 1;
            if rounds.is_multiple_of(64) {
                self.answer();
                let waited = begin.elapsed();
                if deadline.is_some_and(|deadline| waited > deadline) {
                    self.give_up(waited);
                }
                // A long wait costs others no time.
                if waited > Duration::from_millis(2) {
                    std::thread::sleep(Duration::from_micros(50));
                }
            }
            std::thread::yield_now();
        }
    }

    fn patience(&self) -> Option<Duration> {
        Some(*self.common.deadline.borrow())
    }
}

/// A request that is yet to be made.
fn no_request() -> MPI_Request {
    // SAFETY: a number or an address, which MPI overwrites; zero is either.
    unsafe { std::mem::zeroed() }
}

fn bytes_type() -> MPI_Datatype {
    u8::equivalent_datatype().as_raw()
}

impl Communicator for MpiRanks {
    fn rank(&self) -> usize {
        self.common.rank as usize
    }

    fn ranks(&self) -> usize {
        self.common.ranks as usize
    }

    fn add_up(&mut self, numbers: &mut [i64]) {
        self.combine(numbers, SystemOperation::sum().as_raw());
    }

    fn largest(&mut self, numbers: &mut [i64]) {
        self.combine(numbers, SystemOperation::max().as_raw());
    }

    fn begin_swap(&mut self, sends: &[Parcel], receives: &mut [Parcel]) {
        let begin = Instant::now();
        let comm = self.common.comm;
        let mut requests = self.swap.borrow_mut();
        for parcel in receives {
            let mut request = no_request();
            let (bytes, count) = (parcel.bytes.as_mut_ptr(), parcel.bytes.len() as c_int);
            let from = parcel.rank as c_int;
            // SAFETY: parcels keep their place and length until `end_swap` has seen the requests done, which is what
            // callers of the trait promise.
            unsafe {
                let bytes = bytes.cast::<c_void>();
                ffi::MPI_Irecv(bytes, count, bytes_type(), from, PARCEL, comm, &mut request);
            }
            requests.push(request);
        }
        for parcel in sends {
            let mut request = no_request();
            let (bytes, count) = (parcel.bytes.as_ptr(), parcel.bytes.len() as c_int);
            let to = parcel.rank as c_int;
            // SAFETY: as above.
            unsafe {
                let bytes = bytes.cast::<c_void>();
                ffi::MPI_Isend(bytes, count, bytes_type(), to, PARCEL, comm, &mut request);
            }
            requests.push(request);
        }
        self.count_among_ranks(begin);
    }

    fn end_swap(&mut self, _receives: &mut [Parcel]) {
        let mut requests = std::mem::take(&mut *self.swap.borrow_mut());
        self.wait(&mut requests, self.patience());
        requests.clear();
        *self.swap.borrow_mut() = requests;
    }

    fn gather(&mut self, bytes: &[u8]) -> Vec<Vec<u8>> {
        let Common { comm, rank, ranks, .. } = *self.common;
        let mut counts = vec![0_i64; ranks as usize];
        counts[rank as usize] = bytes.len() as i64;
        self.add_up(&mut counts);
        let mut requests = Vec::new();
        if rank != 0 {
            let count = bytes.len() as c_int;
            let mut request = no_request();
            // SAFETY: the bytes live until the request is done, below.
            unsafe {
                let bytes = bytes.as_ptr().cast::<c_void>();
                ffi::MPI_Isend(bytes, count, bytes_type(), 0, GATHER, comm, &mut request);
            }
            self.wait(std::slice::from_mut(&mut request), self.patience());
            return Vec::new();
        }
        // What comes is written where it stays.
        let mut all: Vec<Vec<u8>> =
            counts.iter().map(|&count| Vec::with_capacity(count as usize)).collect();
        for (from, room) in (0..).zip(&mut all).skip(1) {
            let count = counts[from as usize] as c_int;
            let mut request = no_request();
            // SAFETY: there is room for as many bytes; it keeps its place until the requests are done, below.
            unsafe {
                let room = room.as_mut_ptr().cast::<c_void>();
                ffi::MPI_Irecv(room, count, bytes_type(), from, GATHER, comm, &mut request);
            }
            requests.push(request);
        }
        all[0].extend_from_slice(bytes);
        self.wait(&mut requests, self.patience());
        for (room, &count) in all.iter_mut().zip(&counts).skip(1) {
            // SAFETY: so many bytes have come, and there was room for them.
            unsafe {
                room.set_len(count as usize);
            }
        }
        all
    }

    fn gather_to_all(&mut self, bytes: &[u8]) -> Vec<u8> {
        if self.common.ranks == 1 {
            // MPICH 4.0 gathers of one rank to the begin of the room, whatever the place is.
            return bytes.to_vec();
        }
        let mut head = [0_u8; TOLD];
        let short = bytes.len().min(TOLD - 8);
        head[..8].copy_from_slice(&(bytes.len() as u64).to_le_bytes());
        head[8..8 + short].copy_from_slice(&bytes[..short]);
        let heads = self.gather_heads(&head);
        let told = heads.chunks_exact(TOLD).map(|head| {
            let (length, inside) = head.split_at(8);
            let length = u64::from_le_bytes(std::array::from_fn(|k| length[k])) as usize;
            (length, &inside[..length.min(TOLD - 8)])
        });
        let mut whole = 0;
        let rests: Vec<(usize, usize)> = told
            .clone()
            .map(|(length, inside)| {
                let place = whole + inside.len();
                whole += length;
                (place, length - inside.len())
            })
            .collect();
        let mut all = Vec::with_capacity(whole);
        let room = &mut all.spare_capacity_mut()[..whole];
        self.gather_rests(&bytes[short..], &rests, room);
        for ((_, inside), (place, _)) in told.zip(&rests) {
            room[place - inside.len()..*place].write_copy_of_slice(inside);
        }
        // SAFETY: there was room for as many, and all have values: those of the heads, and the rests.
        unsafe {
            all.set_len(whole);
        }
        all
    }

    fn broadcast(&mut self, bytes: &mut Vec<u8>) {
        match self.is_first() {
            true => self.tell(&[], bytes),
            false => *bytes = self.hear(self.patience()),
        }
    }
}
