//! The machine: memory, shared memory and disk that it has for a run.

use std::path::Path;
use tremie_channels::memory::Room;

/// Memory and disk of the machine; `None` where the system does not say.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Machine {
    /// Memory of the machine [bytes].
    pub memory: Option<u64>,
    /// Memory that is free, or would be if caches gave way [bytes].
    pub available: Option<u64>,
    /// Room for shared memory [bytes].
    pub shared: Option<u64>,
    /// Room where outputs go [bytes].
    pub disk: Option<u64>,
}

impl Machine {
    /// Asks the system; `out` is the folder of outputs, which need not exist yet.
    pub fn ask(out: &Path) -> Self {
        let memory = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
        Self {
            memory: kilobytes(&memory, "MemTotal:"),
            available: kilobytes(&memory, "MemAvailable:"),
            shared: Room::ask().map(|room| room.free),
            disk: room(out),
        }
    }
}

/// Bytes of a line as `MemTotal:       24592424 kB`.
fn kilobytes(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let number: u64 = line.split_whitespace().next()?.parse().ok()?;
    number.checked_mul(1024)
}

/// Bytes that a user may still write where `path` is, or where its nearest folder is.
fn room(path: &Path) -> Option<u64> {
    // Nothing at all stands for the folder that the program runs in.
    let path = std::path::absolute(Path::new(".").join(path)).ok()?;
    let there = path.ancestors().find(|folder| folder.exists())?;
    let room = rustix::fs::statvfs(there).ok()?;
    room.f_bavail.checked_mul(room.f_frsize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_machine_answers() {
        let machine = Machine::ask(Path::new("no/such/folder/yet"));
        let (memory, available) = (machine.memory.unwrap(), machine.available.unwrap());
        assert!(memory >= available && available > 1 << 20);
        assert!(machine.disk.is_some());
        assert!(Machine::ask(Path::new("")).disk.is_some());
        assert_eq!(kilobytes("MemTotal:       3 kB\n", "MemTotal:"), Some(3072));
        assert_eq!(kilobytes("MemFree: x", "MemFree:"), None);
    }
}
