//! Ranks that are threads of one process, so that shares of a lattice can be tried without MPI.

use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Barrier, Mutex};
use tremie_fluid_lbm::{Communicator, Parcel};

/// What all ranks see.
struct Common {
    barrier: Barrier,
    numbers: Mutex<Vec<Vec<i64>>>,
    bytes: Mutex<Vec<Vec<u8>>>,
}

/// One of several threads that compute a lattice together.
pub struct ThreadRank {
    rank: usize,
    common: Arc<Common>,
    /// By rank.
    to: Vec<Sender<Vec<u8>>>,
    from: Vec<Receiver<Vec<u8>>>,
}

impl ThreadRank {
    /// So many ranks.
    pub fn all(ranks: usize) -> Vec<Self> {
        let common = Arc::new(Common {
            barrier: Barrier::new(ranks),
            numbers: Mutex::new(vec![Vec::new(); ranks]),
            bytes: Mutex::new(vec![Vec::new(); ranks]),
        });
        let mut senders: Vec<Vec<Sender<Vec<u8>>>> = vec![Vec::new(); ranks];
        let mut receivers: Vec<Vec<Receiver<Vec<u8>>>> = (0..ranks).map(|_| Vec::new()).collect();
        for to in 0..ranks {
            for senders in &mut senders {
                let (sender, receiver) = channel();
                senders.push(sender);
                receivers[to].push(receiver);
            }
        }
        let ways = senders.into_iter().zip(receivers).enumerate();
        ways.map(|(rank, (to, from))| Self { rank, common: common.clone(), to, from }).collect()
    }

    /// Makes numbers of the numbers of all ranks.
    fn join(&mut self, numbers: &mut [i64], join: impl Fn(i64, i64) -> i64) {
        self.common.numbers.lock().unwrap()[self.rank] = numbers.to_vec();
        self.common.barrier.wait();
        {
            let all = self.common.numbers.lock().unwrap();
            assert!(all.iter().all(|own| own.len() == numbers.len()), "ranks make other calls");
            for (k, number) in numbers.iter_mut().enumerate() {
                *number = all.iter().map(|own| own[k]).reduce(&join).unwrap();
            }
        }
        self.common.barrier.wait();
    }
}

impl Communicator for ThreadRank {
    fn rank(&self) -> usize {
        self.rank
    }

    fn ranks(&self) -> usize {
        self.to.len()
    }

    fn add_up(&mut self, numbers: &mut [i64]) {
        self.join(numbers, i64::wrapping_add);
    }

    fn largest(&mut self, numbers: &mut [i64]) {
        self.join(numbers, i64::max);
    }

    fn begin_swap(&mut self, sends: &[Parcel], _receives: &mut [Parcel]) {
        for parcel in sends {
            self.to[parcel.rank].send(parcel.bytes.clone()).unwrap();
        }
    }

    fn end_swap(&mut self, receives: &mut [Parcel]) {
        for parcel in receives {
            let bytes = self.from[parcel.rank].recv().unwrap();
            assert_eq!(bytes.len(), parcel.bytes.len(), "from {} to {}", parcel.rank, self.rank);
            parcel.bytes = bytes;
        }
    }

    fn gather(&mut self, bytes: &[u8]) -> Vec<Vec<u8>> {
        self.common.bytes.lock().unwrap()[self.rank] = bytes.to_vec();
        self.common.barrier.wait();
        let all =
            if self.rank == 0 { self.common.bytes.lock().unwrap().clone() } else { Vec::new() };
        self.common.barrier.wait();
        all
    }

    fn broadcast(&mut self, bytes: &mut Vec<u8>) {
        if self.rank == 0 {
            self.common.bytes.lock().unwrap()[0] = bytes.clone();
        }
        self.common.barrier.wait();
        *bytes = self.common.bytes.lock().unwrap()[0].clone();
        self.common.barrier.wait();
    }
}
