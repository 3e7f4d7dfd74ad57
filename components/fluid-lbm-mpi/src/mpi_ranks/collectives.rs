//! What all ranks do together, without waiting in MPI: sums, broadcasts, and what all tell all.

use super::{MpiRanks, bytes_type, no_request};
use mpi::ffi::{self, MPI_Op};
use mpi::traits::{AsRaw, Equivalence};
use std::ffi::{c_int, c_void};
use std::mem::MaybeUninit;
use std::time::Duration;

/// Bytes of what all ranks tell all that need no second message, their number included.
pub(super) const TOLD: usize = 256;

/// Bytes of a broadcast that need no second message.
const SHORT: usize = 504;

impl MpiRanks {
    /// Heads of all ranks.
    pub(super) fn gather_heads(&self, head: &[u8; TOLD]) -> Vec<u8> {
        let mut heads = vec![0_u8; TOLD * self.common.ranks as usize];
        let mut request = no_request();
        // SAFETY: there is room for as many bytes of each rank; both buffers live until the request is done, below.
        unsafe {
            ffi::MPI_Iallgather(
                head.as_ptr().cast(),
                TOLD as c_int,
                bytes_type(),
                heads.as_mut_ptr().cast(),
                TOLD as c_int,
                bytes_type(),
                self.common.comm,
                &mut request,
            );
        }
        self.wait(std::slice::from_mut(&mut request), self.patience());
        heads
    }

    /// Writes what heads had no room for where it stays: of each rank so many bytes, from a place in `room` on.
    pub(super) fn gather_rests(
        &self,
        own: &[u8],
        rests: &[(usize, usize)],
        room: &mut [MaybeUninit<u8>],
    ) {
        if rests.iter().all(|&(_, count)| count == 0) {
            return;
        }
        let places: Vec<c_int> = rests.iter().map(|&(place, _)| place as c_int).collect();
        let counts: Vec<c_int> = rests.iter().map(|&(_, count)| count as c_int).collect();
        assert!(rests.iter().all(|&(place, count)| place + count <= room.len()));
        // Never without an address: that of an empty list may be one which means something else to MPI.
        let own_bytes = if own.is_empty() { &[0] } else { own };
        let mut request = no_request();
        // SAFETY: places and counts lie in the room; all live until the request is done, below.
        unsafe {
            ffi::MPI_Iallgatherv(
                own_bytes.as_ptr().cast(),
                own.len() as c_int,
                bytes_type(),
                room.as_mut_ptr().cast(),
                counts.as_ptr(),
                places.as_ptr(),
                bytes_type(),
                self.common.comm,
                &mut request,
            );
        }
        self.wait(std::slice::from_mut(&mut request), self.patience());
    }

    /// Combines numbers over all ranks.
    pub(super) fn combine(&self, numbers: &mut [i64], operation: MPI_Op) {
        if numbers.is_empty() {
            return;
        }
        let own = numbers.to_vec();
        let mut request = no_request();
        // SAFETY: both buffers hold as many numbers, and live until the request is done, below.
        unsafe {
            ffi::MPI_Iallreduce(
                own.as_ptr().cast(),
                numbers.as_mut_ptr().cast(),
                numbers.len() as c_int,
                i64::equivalent_datatype().as_raw(),
                operation,
                self.common.comm,
                &mut request,
            );
        }
        self.wait(std::slice::from_mut(&mut request), self.patience());
    }

    /// Broadcasts so many bytes of rank 0, which it reads from there; others write them there.
    ///
    /// # Safety
    /// Rank 0 has as many values there; others have room for as many.
    unsafe fn broadcast_bytes(&self, bytes: *mut u8, count: usize, deadline: Option<Duration>) {
        let mut request = no_request();
        // SAFETY: the buffer lives until the request is done, below (callers).
        unsafe {
            let (bytes, count) = (bytes.cast::<c_void>(), count as c_int);
            ffi::MPI_Ibcast(bytes, count, bytes_type(), 0, self.common.comm, &mut request);
        }
        self.wait(std::slice::from_mut(&mut request), deadline);
    }

    /// Rank 0 broadcasts few bytes and those behind them, which are copied nowhere.
    pub fn tell(&self, few: &[u8], behind: &[u8]) {
        if few.len() > SHORT {
            return self.tell(&[], &[few, behind].concat());
        }
        let length = few.len() + behind.len();
        let inside = behind.len().min(SHORT - few.len());
        let mut head = [0_u8; SHORT + 8];
        head[..8].copy_from_slice(&(length as u64).to_le_bytes());
        head[8..8 + few.len()].copy_from_slice(few);
        head[8 + few.len()..8 + few.len() + inside].copy_from_slice(&behind[..inside]);
        let rest = &behind[inside..];
        // SAFETY: so many values are there, which MPI reads only on rank 0.
        unsafe {
            self.broadcast_bytes(head.as_mut_ptr(), head.len(), self.patience());
            if !rest.is_empty() {
                self.broadcast_bytes(rest.as_ptr().cast_mut(), rest.len(), self.patience());
            }
        }
    }

    /// What rank 0 broadcasts, on another rank. The wait for its beginning has a deadline of its own.
    pub(super) fn hear(&self, deadline: Option<Duration>) -> Vec<u8> {
        let mut head = [0_u8; SHORT + 8];
        // SAFETY: there is room for as many.
        unsafe { self.broadcast_bytes(head.as_mut_ptr(), head.len(), deadline) };
        let (length, inside) = head.split_at(8);
        let length = u64::from_le_bytes(std::array::from_fn(|k| length[k])) as usize;
        let short = length.min(SHORT);
        let mut bytes = Vec::with_capacity(length);
        bytes.extend_from_slice(&inside[..short]);
        if length > SHORT {
            let rest = &mut bytes.spare_capacity_mut()[..length - short];
            // SAFETY: there is room for as many, and all have values then.
            unsafe {
                self.broadcast_bytes(rest.as_mut_ptr().cast(), rest.len(), self.patience());
                bytes.set_len(length);
            }
        }
        bytes
    }
}
