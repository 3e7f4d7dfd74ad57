//! Shared memory that channels take, and the room that the machine has for it.
//!
//! The memory of a channel is a file in `/dev/shm`, made with its full length. The system sets its
//! pages aside only when they are touched. Where no page is left then, the system ends the process
//! by a signal (SIGBUS). So a run asks for room before it begins ([`provide`]), and has all pages
//! set aside before its first message ([`commit`]).

use rustix::fs::{FallocateFlags, fallocate, statvfs};
use rustix::io::Errno;
use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::Path;

/// Folder of POSIX shared memory on Linux.
pub const SHARED_MEMORY: &str = "/dev/shm";
/// Memory is given in pages [bytes].
const PAGE: u64 = 4096;

/// Head of iceoryx2 before each message, its place in the list of free ones included [bytes].
const MESSAGE: u64 = 56;
/// Head of iceoryx2 before the messages of a channel [bytes].
const SEGMENT: u64 = 256;
/// Connection between sender and receiver: fixed part, and part for each message that it has room
/// for [bytes].
const CONNECTION: [u64; 2] = [320, 17];
/// List of the members of a channel [bytes].
const MEMBERS: u64 = PAGE;
/// List of the members of a bell, and the bell itself [bytes].
const BELL: u64 = 4 * PAGE;

/// Memory of a channel, in whole pages [bytes]. `header` is the size of a message's header [bytes],
/// `value` that of one of its values [bytes].
///
/// Measured of iceoryx2 0.10; `spec` as for its ends.
pub fn of_channel(header: usize, value: usize, spec: crate::ChannelSpec<'_>) -> u64 {
    let [depth, borrowed] = [spec.depth, spec.borrowed].map(|count| count as u64);
    let message = MESSAGE + header as u64 + value as u64 * spec.capacity.max(1) as u64;
    // One more is being written.
    let messages = (depth + borrowed + 1).saturating_mul(message);
    let entries = CONNECTION[1].saturating_mul(depth + borrowed + 1);
    pages(SEGMENT.saturating_add(messages)) + pages(CONNECTION[0] + entries) + MEMBERS
}

/// Memory of a component's bell [bytes].
pub fn of_bell() -> u64 {
    BELL
}

fn pages(bytes: u64) -> u64 {
    bytes.div_ceil(PAGE).saturating_mul(PAGE)
}

/// Shared memory of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Room {
    /// All of it [bytes].
    pub total: u64,
    /// Free part of it [bytes].
    pub free: u64,
}

impl Room {
    /// Asks the system; `None` where it sets no limit or does not say.
    pub fn ask() -> Option<Self> {
        let room = statvfs(SHARED_MEMORY).ok().filter(|room| room.f_blocks > 0)?;
        let bytes = |blocks: u64| blocks.saturating_mul(room.f_frsize);
        Some(Self { total: bytes(room.f_blocks), free: bytes(room.f_bavail) })
    }
}

/// Reason why shared memory cannot hold the run.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoMemory {
    /// There is too little.
    #[error(
        "{SHARED_MEMORY} is full: {} of {} are free, and the run needs {}; make it larger (mount -o remount,size={}M \
         {SHARED_MEMORY}; in a container docker run --shm-size={}m), or send frames of fewer values, or use --in-process",
        size(.room.free), size(.room.total), size(*.need), .want, .want
    )]
    Full {
        /// Need of the run [bytes].
        need: u64,
        /// Size and free part.
        room: Room,
        /// Size that would do [MB].
        want: u64,
    },
    /// There is room, but not for another file.
    #[error(
        "{SHARED_MEMORY} holds as many files as it may: remove some, or allow more (mount -o remount,nr_inodes=.. {SHARED_MEMORY}), \
         or use --in-process"
    )]
    Files,
    /// It cannot be written.
    #[error(
        "{SHARED_MEMORY} cannot be written ({why}), and components share memory there; mount it writable (mount -t tmpfs \
         tmpfs {SHARED_MEMORY}), or use --in-process"
    )]
    Closed {
        /// The system's words.
        why: String,
    },
}

impl NoMemory {
    fn full(need: u64, room: Room) -> Self {
        let used = room.total.saturating_sub(room.free);
        // A quarter more than is needed, in round numbers.
        let want = (used + need + need / 4).div_ceil(1_000_000).div_ceil(16) * 16;
        Self::Full { need, room, want }
    }

    fn of(error: Errno, need: u64) -> Self {
        match (error, Room::ask()) {
            // Bytes are free, so the system lacks inodes: it reports both by one error.
            (Errno::NOSPC, Some(room)) if room.free >= need.max(PAGE) => Self::Files,
            (Errno::NOSPC | Errno::DQUOT | Errno::NOMEM, Some(room)) => Self::full(need, room),
            _ => Self::Closed { why: io::Error::from(error).to_string() },
        }
    }
}

/// A number of bytes as a person would write it.
fn size(bytes: u64) -> String {
    match bytes {
        0..10_000_000 => format!("{:.0} kB", bytes as f64 / 1e3),
        _ => format!("{:.0} MB", bytes as f64 / 1e6),
    }
}

/// Checks that a run that names its memory with `prefix` can have `need` bytes of it.
///
/// # Errors
/// See [`NoMemory`].
pub fn provide(prefix: &str, need: u64) -> Result<(), NoMemory> {
    let path = Path::new(SHARED_MEMORY).join(format!("{prefix}trial"));
    // One page shows whether files can be made and pages set aside; the size is asked below.
    let tried = File::create_new(&path)
        .and_then(|file| Ok(fallocate(&file, FallocateFlags::empty(), 0, PAGE)?));
    let _ = fs::remove_file(&path);
    match tried.as_ref().err().map(|error| Errno::from_io_error(error).unwrap_or(Errno::IO)) {
        // Some systems cannot set pages aside.
        None | Some(Errno::OPNOTSUPP) => {}
        Some(error) => return Err(NoMemory::of(error, need)),
    }
    match Room::ask() {
        Some(room) if need > room.free => Err(NoMemory::full(need, room)),
        _ => Ok(()),
    }
}

/// Has the system set aside all pages of the memory that a run made, so that none is missing when
/// it is touched.
///
/// # Errors
/// If there are too few: another program has taken them since [`provide`].
pub fn commit(prefix: &str) -> Result<(), NoMemory> {
    let entries = fs::read_dir(SHARED_MEMORY).into_iter().flatten().flatten();
    for entry in entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(prefix)) {
        // Gone meanwhile, or not ours: not to be set aside.
        let Ok(file) = OpenOptions::new().read(true).write(true).open(entry.path()) else {
            continue;
        };
        let length = file.metadata().map_or(0, |metadata| metadata.len());
        if length == 0 {
            continue;
        }
        // What the system cannot set aside, it may have when it is touched.
        let set_aside = fallocate(&file, FallocateFlags::empty(), 0, length);
        if let Err(error @ (Errno::NOSPC | Errno::DQUOT | Errno::NOMEM)) = set_aside {
            return Err(NoMemory::of(error, length));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn too_little_is_told_with_both_numbers_and_the_remedy() {
        let room = Room { total: 64_000_000, free: 60_000_000 };
        let said = NoMemory::full(170_000_000, room).to_string();
        for part in ["60 MB of 64 MB are free", "needs 170 MB", "size=224M", "--shm-size=224m"] {
            assert!(said.contains(part), "{said}");
        }
        let said = NoMemory::full(2_000_000, Room { total: 4096, free: 0 }).to_string();
        assert!(said.contains("0 kB of 4 kB are free, and the run needs 2000 kB"), "{said}");
        assert!(provide("tremie_test_", 1 << 60).is_err());
        assert_eq!(provide("tremie_test_", 0), Ok(()));
    }
}
