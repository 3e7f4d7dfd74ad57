//! Damaged archives of states: each is put back or refused, soon and in little memory.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use tremie_state::{KeepsState, SavedState, StateArchive, StateError, StateExchange, StateHeader};
use tremie_test_support::{Counting, DamagedInput};

#[global_allocator]
static COUNTING: Counting = Counting;

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Sums {
    steps: u64,
    last: Option<f64>,
    names: Vec<String>,
    of: BTreeMap<String, (f64, Vec<u8>)>,
}

/// A component with entries of all kinds.
#[derive(Clone, Debug)]
struct Bed {
    cells: Vec<f64>,
    contacts: Vec<[u32; 2]>,
    flags: Vec<u8>,
    sums: Sums,
}

impl Bed {
    fn new() -> Self {
        let of = BTreeMap::from([("grains".to_string(), (1.5, vec![1, 2, 3]))]);
        let names = vec!["one".to_string(), "two".to_string()];
        let sums = Sums { steps: 7, last: Some(0.25), names, of };
        Self { cells: vec![1.0; 9], contacts: vec![[1, 2]; 5], flags: vec![3; 7], sums }
    }
}

impl KeepsState for Bed {
    const STATE_VERSION: u32 = 3;

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.array("cells", &mut self.cells)?;
        state.within("bed", |state| {
            state.list("contacts", &mut self.contacts)?;
            state.list("flags", &mut self.flags)
        })?;
        state.value("sums", &mut self.sums)
    }
}

/// An archive as a component writes it.
fn whole(bed: &mut Bed) -> Vec<u8> {
    let home = tempfile::tempdir().unwrap();
    let path = home.path().join("grains.npz");
    let header = StateHeader::whole("grains", "bed", 3, 12);
    SavedState::of(bed).unwrap().write(&path, &header).unwrap();
    std::fs::read(path).unwrap()
}

/// The sum over the bytes of a zip entry that its header holds (ISO 3309), so that damage inside an
/// entry is seen by more than that sum.
fn checksum(bytes: &[u8]) -> u32 {
    let step = |sum: u32, byte: &u8| {
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| {
            (sum >> 1) ^ (0xedb8_8320 & (sum & 1).wrapping_neg())
        })
    };
    !bytes.iter().fold(!0, step)
}

/// Makes the sums of all entries right again that still lie where they lay.
fn mend(archive: &mut [u8]) {
    let number = |bytes: &[u8], at: usize, width: usize| -> Option<usize> {
        let part = bytes.get(at..at + width)?;
        Some(part.iter().rev().fold(0, |sum, byte| sum << 8 | usize::from(*byte)))
    };
    let places = |archive: &[u8], mark: &[u8]| -> Vec<usize> {
        (0..archive.len().saturating_sub(4)).filter(|at| archive[*at..].starts_with(mark)).collect()
    };
    let mut sums = Vec::new();
    for at in places(archive, b"PK\x03\x04") {
        let field = |offset: usize, width: usize| number(archive, at + offset, width);
        let (Some(size), Some(name), Some(extra)) = (field(18, 4), field(26, 2), field(28, 2))
        else {
            continue;
        };
        let begin = at + 30 + name + extra;
        if let Some(content) = begin.checked_add(size).and_then(|end| archive.get(begin..end)) {
            sums.push((at, checksum(content)));
        }
    }
    let directory = places(archive, b"PK\x01\x02");
    for (at, sum) in sums {
        archive[at + 14..at + 18].copy_from_slice(&sum.to_le_bytes());
        for entry in &directory {
            if number(archive, entry + 42, 4) == Some(at) && archive.len() >= entry + 20 {
                archive[entry + 16..entry + 20].copy_from_slice(&sum.to_le_bytes());
            }
        }
    }
}

/// Tries so many damaged archives, half of them with sums that are right.
fn try_archives(count: u64) {
    let home = tempfile::tempdir().unwrap();
    let path = home.path().join("grains.npz");
    let read = |bytes: &[u8]| {
        let mut bytes = bytes.to_vec();
        if bytes.len().is_multiple_of(2) {
            mend(&mut bytes);
        }
        std::fs::write(&path, &bytes).unwrap();
        let mut bed = Bed::new();
        match StateArchive::open(&path).and_then(|mut archive| archive.restore("bed", &mut bed)) {
            Ok(()) => format!("put back, {} {}", bed.contacts.len(), bed.sums.names.len()),
            Err(error) => error.to_string(),
        }
    };
    let mut empty =
        Bed { contacts: Vec::new(), flags: Vec::new(), sums: Sums::default(), ..Bed::new() };
    let inputs = vec![whole(&mut Bed::new()), whole(&mut empty)];
    let words = [
        "PK\u{3}\u{4}",
        "PK\u{1}\u{2}",
        "PK\u{5}\u{6}",
        "PK\u{6}\u{6}",
        "about.json",
        "cells.npy",
        "bed.contacts.npy",
        "sums.postcard",
        "'descr': '<f8'",
        "'descr': '|u1'",
        "'shape': (9,)",
        "'shape': (99999999999999999999,)",
        "'shape': (4294967296, 4294967296)",
        "\u{93}NUMPY",
        "'fortran_order': True",
        "\"version\": 4294967296",
    ];
    // Two buffers of the archive's reader, a megabyte each, and the directory: its library takes memory
    // for as many entries as the file says, which are 65535 at most.
    let memory = [32 << 20, 50];
    DamagedInput { name: "archives of states", inputs, words: &words, read: &read, memory }
        .try_many(count);
}

#[test]
fn damaged_archives_are_put_back_or_refused() {
    try_archives(800);
}

#[test]
#[ignore = "minutes; CONTRIBUTING.md has the command"]
fn a_million_damaged_archives_are_put_back_or_refused() {
    try_archives(1_000_000);
}
