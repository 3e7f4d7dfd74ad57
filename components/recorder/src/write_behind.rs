//! A file that a thread of its own writes: a disk that stands still for some seconds, as shared ones do, then
//! stops neither the recorder nor the physics that waits for it.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{self, Write};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

/// Most bytes that wait for the disk. With more, whoever writes waits, too.
const MOST_BYTES: u64 = 64 << 20;

/// A file to whose end pieces are written, in their order. Dropped, it first writes what it was given.
#[derive(Debug)]
pub struct WriteBehind {
    pieces: Pieces,
    thread: Option<JoinHandle<()>>,
}

/// Pieces on their way to the disk; clones are of the same file.
#[derive(Clone, Debug)]
pub struct Pieces(Arc<(Mutex<Waiting>, Condvar)>);

#[derive(Debug, Default)]
struct Waiting {
    pieces: VecDeque<Vec<u8>>,
    /// Bytes that were given to it, since the begin.
    given: u64,
    /// Bytes of these that the file has.
    written: u64,
    /// No more will be given.
    is_over: bool,
    failed: Option<Failure>,
}

/// What is left of an error, to be told as often as somebody asks.
#[derive(Clone, Debug)]
struct Failure {
    code: Option<i32>,
    text: String,
}

impl Failure {
    fn of(error: &io::Error) -> Self {
        Self { code: error.raw_os_error(), text: error.to_string() }
    }

    fn error(&self) -> io::Error {
        self.code.map_or_else(|| io::Error::other(&*self.text), io::Error::from_raw_os_error)
    }
}

impl Waiting {
    fn check(&self) -> io::Result<()> {
        self.failed.as_ref().map_or(Ok(()), |failure| Err(failure.error()))
    }
}

impl Pieces {
    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.0.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for a change, as long as `waits` says that there is nothing to do.
    fn wait_while(&self, waits: impl Fn(&Waiting) -> bool) -> MutexGuard<'_, Waiting> {
        let (_, changed) = &*self.0;
        let guard = changed.wait_while(self.lock(), |waiting| waits(waiting));
        guard.unwrap_or_else(PoisonError::into_inner)
    }

    fn change(&self, make: impl FnOnce(&mut Waiting)) {
        make(&mut self.lock());
        self.0.1.notify_all();
    }

    /// Waits until the file has all that was given so far. The disk may still not: see `File::sync_all`.
    ///
    /// # Errors
    /// If it could not be written.
    pub fn settle(&self) -> io::Result<()> {
        let given = self.lock().given;
        self.wait_while(|waiting| waiting.written < given && waiting.failed.is_none()).check()
    }

    /// Writes pieces until there will be no more, or the disk refuses.
    fn write_to(&self, file: &mut File) {
        loop {
            let mut waiting = self.wait_while(|all| all.pieces.is_empty() && !all.is_over);
            let Some(piece) = waiting.pieces.pop_front() else { return };
            drop(waiting);
            let written = file.write_all(&piece);
            self.change(|waiting| match &written {
                Ok(()) => waiting.written += piece.len() as u64,
                Err(error) => waiting.failed = Some(Failure::of(error)),
            });
            if written.is_err() {
                return;
            }
        }
    }
}

impl WriteBehind {
    /// Writes to `file` from where it stands.
    ///
    /// # Errors
    /// If the system has no thread left.
    pub fn new(mut file: File) -> io::Result<Self> {
        let pieces = Pieces(Arc::default());
        let own = pieces.clone();
        let thread = std::thread::Builder::new()
            .name("write-behind".into())
            .spawn(move || own.write_to(&mut file))?;
        Ok(Self { pieces, thread: Some(thread) })
    }

    /// The pieces on their way.
    pub fn pieces(&self) -> Pieces {
        self.pieces.clone()
    }
}

impl Write for WriteBehind {
    /// Takes all of it; waits only where [`MOST_BYTES`] wait already.
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let is_full = |all: &Waiting| all.given - all.written > MOST_BYTES && all.failed.is_none();
        self.pieces.wait_while(is_full).check()?;
        self.pieces.change(|waiting| {
            waiting.given += bytes.len() as u64;
            waiting.pieces.push_back(bytes.to_vec());
        });
        Ok(bytes.len())
    }

    /// Does not wait for the file: [`Pieces::settle`] does.
    fn flush(&mut self) -> io::Result<()> {
        self.pieces.lock().check()
    }
}

impl Drop for WriteBehind {
    fn drop(&mut self) {
        self.pieces.change(|waiting| waiting.is_over = true);
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;
    use std::os::fd::OwnedFd;

    /// A pipe takes 64 KiB until somebody reads it: a disk that stands still.
    fn pipe() -> (io::PipeReader, File) {
        let (reader, writer) = io::pipe().unwrap();
        (reader, File::from(OwnedFd::from(writer)))
    }

    #[test]
    fn a_disk_that_stands_still_holds_nobody_up() {
        let (mut reader, writer) = pipe();
        let mut file = WriteBehind::new(writer).unwrap();
        let bytes: Vec<u8> = (0..1 << 20).map(|k| (k % 251) as u8).collect();
        // Comes back although nobody reads.
        bytes.chunks(1000).for_each(|piece| file.write_all(piece).unwrap());
        let pieces = file.pieces();
        assert!(pieces.lock().written < 100_000);
        let read = std::thread::spawn(move || {
            let mut found = Vec::new();
            reader.read_to_end(&mut found).unwrap();
            found
        });
        pieces.settle().unwrap();
        assert_eq!(pieces.lock().written, 1 << 20);
        file.write_all(b"and the end").unwrap();
        drop(file);
        assert_eq!(read.join().unwrap(), [&bytes[..], b"and the end"].concat());
    }

    #[test]
    fn a_disk_that_refuses_is_told_as_often_as_somebody_asks() {
        let (reader, writer) = pipe();
        drop(reader);
        let mut file = WriteBehind::new(writer).unwrap();
        file.write_all(b"nobody").unwrap();
        let pieces = file.pieces();
        for _ in 0..2 {
            assert_eq!(pieces.settle().unwrap_err().kind(), io::ErrorKind::BrokenPipe);
            assert_eq!(file.flush().unwrap_err().kind(), io::ErrorKind::BrokenPipe);
            assert!(file.write_all(b"again").is_err());
        }
    }

    #[test]
    fn what_waits_for_the_disk_is_bounded() {
        let (mut reader, writer) = pipe();
        let mut file = WriteBehind::new(writer).unwrap();
        let pieces = file.pieces();
        let piece = vec![7; 1 << 20];
        let sender = std::thread::spawn(move || {
            (0..80).for_each(|_| file.write_all(&piece).unwrap());
        });
        // It gets no further than the bound, however long nobody reads.
        drop(pieces.wait_while(|waiting| waiting.given <= MOST_BYTES));
        std::thread::sleep(std::time::Duration::from_millis(50));
        assert!(pieces.lock().given <= MOST_BYTES + (2 << 20));
        let mut found = Vec::new();
        reader.read_to_end(&mut found).unwrap();
        sender.join().unwrap();
        assert_eq!(found.len(), 80 << 20);
    }
}
