//! What was kept comes back to the bit, and what does not fit is refused with its name.

use proptest::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;
use tremie_state::{
    KeepsState, SavedState, SharedRows, StateArchive, StateError, StateExchange, StateHeader,
    StatePart, StatePlace, bytes_on_disk,
};

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Counters {
    steps: u64,
    last: Option<f64>,
    names: Vec<String>,
}

#[derive(Clone, Debug, Default)]
struct Grain {
    position: [f64; 3],
    stamp: u32,
}

#[derive(Clone, Debug, Default)]
struct Bed {
    grains: Vec<Grain>,
    cells: Vec<f32>,
    contacts: Vec<[u32; 2]>,
    counters: Counters,
}

impl KeepsState for Bed {
    const STATE_VERSION: u32 = 3;

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let Self { grains, cells, contacts, counters } = self;
        state.within("grains", |state| {
            state.column("position", grains, |g| g.position, |g, x| g.position = x)?;
            state.column("stamp", grains, |g| g.stamp, |g, k| g.stamp = k)
        })?;
        state.array("cells", cells)?;
        state.list("contacts", contacts)?;
        state.value("counters", counters)
    }
}

fn header() -> StateHeader {
    StateHeader::whole("grains", "bed", 3, 12)
}

fn bed(grains: usize, cells: usize) -> Bed {
    Bed { grains: vec![Grain::default(); grains], cells: vec![0.0; cells], ..Bed::default() }
}

/// Bits of a state, by which states with numbers that are none can be compared.
fn bits(of: &mut Bed) -> SavedState {
    SavedState::of(of).unwrap()
}

fn written(bed: &mut Bed, path: &Path) {
    bits(bed).write(path, &header()).unwrap();
}

fn restored(path: &Path, bed: &mut Bed) -> Result<(), StateError> {
    StateArchive::open(path)?.restore("bed", bed)
}

fn any_bed() -> impl Strategy<Value = Bed> {
    let any_f64 = || any::<u64>().prop_map(f64::from_bits);
    let grain = (prop::array::uniform3(any_f64()), any::<u32>())
        .prop_map(|(position, stamp)| Grain { position, stamp });
    let counters = (any::<u64>(), prop::option::of(any_f64()), prop::collection::vec(".*", 0..3))
        .prop_map(|(steps, last, names)| Counters { steps, last, names });
    let cells = prop::collection::vec(any::<u32>().prop_map(f32::from_bits), 0..40);
    let contacts = prop::collection::vec(prop::array::uniform2(any::<u32>()), 0..40);
    (prop::collection::vec(grain, 0..9), cells, contacts, counters)
        .prop_map(|(grains, cells, contacts, counters)| Bed { grains, cells, contacts, counters })
}

proptest! {
    #[test]
    fn every_bit_comes_back(mut before in any_bed()) {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("grains.npz");
        written(&mut before, &path);
        let archive = StateArchive::open(&path).unwrap();
        prop_assert_eq!(archive.header(), &header());
        let mut after = bed(before.grains.len(), before.cells.len());
        after.contacts = vec![[7, 7]; 3];
        restored(&path, &mut after).unwrap();
        prop_assert_eq!(bits(&mut after), bits(&mut before));
        let mut again = bed(before.grains.len(), before.cells.len());
        bits(&mut before).restore(&mut again).unwrap();
        prop_assert_eq!(bits(&mut again), bits(&mut before));
    }

    /// One byte of a file is another one: what comes back is right, or refused; never a panic.
    #[test]
    fn damage_is_noticed(mut before in any_bed(), place in any::<prop::sample::Index>(), to in any::<u8>()) {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("grains.npz");
        written(&mut before, &path);
        let mut bytes = std::fs::read(&path).unwrap();
        *place.get_mut(&mut bytes) = to;
        std::fs::write(&path, &bytes).unwrap();
        let mut after = bed(before.grains.len(), before.cells.len());
        if restored(&path, &mut after).is_ok() {
            prop_assert_eq!(bits(&mut after), bits(&mut before));
        }
    }

    #[test]
    fn half_a_file_is_refused(mut before in any_bed(), length in any::<prop::sample::Index>()) {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("grains.npz");
        written(&mut before, &path);
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..length.index(bytes.len())]).unwrap();
        let mut after = bed(before.grains.len(), before.cells.len());
        prop_assert!(restored(&path, &mut after).is_err());
    }
}

#[test]
fn what_does_not_fit_is_named() {
    let home = tempfile::tempdir().unwrap();
    let path = home.path().join("grains.npz");
    written(&mut bed(2, 5), &path);
    let said = |bed: &mut Bed| restored(&path, bed).unwrap_err().to_string();
    assert_eq!(
        said(&mut bed(2, 6)),
        "`cells` of the state holds <f4, 5, expected <f4, 6: is it the state of another scene?"
    );
    assert!(
        said(&mut bed(3, 5))
            .starts_with("`grains.position` of the state holds <f8, 2 x 3, expected <f8, 3 x 3")
    );
    let foreign = StateArchive::open(&path).unwrap().restore("heap", &mut bed(2, 5)).unwrap_err();
    assert_eq!(
        foreign.to_string(),
        "the state is that of bed (state version 3), expected heap (state version 3)"
    );
    let kept = bits(&mut bed(2, 5)).write(&path, &header());
    assert!(kept.unwrap_err().to_string().contains("grains.npz: "), "a state is never overwritten");
}

/// A component that names fewer or other entries than were kept.
struct Other(fn(&mut StateExchange<'_>) -> Result<(), StateError>);

impl KeepsState for Other {
    const STATE_VERSION: u32 = 3;

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        (self.0)(state)
    }
}

#[test]
fn entries_that_are_missing_unknown_or_twice_are_named() {
    let kept = bits(&mut bed(1, 1));
    let said = |tell| kept.restore(&mut Other(tell)).unwrap_err().to_string();
    assert!(said(|state| state.value("steps", &mut 0u64)).starts_with("the state has no `steps`"));
    assert!(said(|_| Ok(())).starts_with("the state holds `grains.position`, which"));
    assert!(
        said(|state| state.value("cells", &mut 0u64))
            .contains("`cells` of the state is damaged: it is an array")
    );
    assert!(
        said(|state| state.array("cells", &mut [0.0f64])).contains("holds <f4, 1, expected <f8, 0")
    );
    let twice = |state: &mut StateExchange<'_>| {
        state.value("steps", &mut 0u64)?;
        state.value("steps", &mut 1u64)
    };
    let error = SavedState::of(&mut Other(twice)).unwrap_err();
    assert_eq!(error.to_string(), "the state has two entries `steps`");
}

/// Some rows of a table that several processes have together, and what all of them have alike.
#[derive(Debug, PartialEq)]
struct Share {
    rows: SharedRows,
    /// By row of the whole table.
    values: BTreeMap<usize, [f32; 2]>,
    /// Rows that it wants noted; of all processes, once they are put back.
    noted: Vec<u32>,
    steps: u64,
    part: StatePart,
}

impl Share {
    fn of(part: StatePart, all: usize, own: Range<usize>, held: Vec<Range<usize>>) -> Self {
        let rows = SharedRows { all, own: own.clone(), held };
        let values = own.clone().map(|row| (row, [row as f32, -(row as f32)])).collect();
        let noted = own.filter(|row| row % 1000 == 7).map(|row| row as u32).collect();
        Self { rows, values, noted, steps: 41, part }
    }

    /// So many rows of so many shares, cut evenly, each of which holds some more.
    fn all(rows: usize, shares: usize) -> impl Iterator<Item = Self> {
        let cut = move |share: usize| rows * share / shares;
        (0..shares).map(move |share| {
            let own = cut(share)..cut(share + 1);
            let held = own.start.saturating_sub(5)..(own.end + 5).min(rows);
            // The table goes on from its end to its beginning.
            let wraps = [0..3, held.start.max(3)..held.end];
            let held = if held.start > 3 { wraps.to_vec() } else { Vec::from([held]) };
            let part = StatePart { number: share as u32, of: shares as u32 };
            Self::of(part, rows, own, held)
        })
    }
}

impl KeepsState for Share {
    const STATE_VERSION: u32 = 1;

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.keep_part(self.part);
        let (restores, values) = (state.restores(), &mut self.values);
        state.value("steps", &mut self.steps)?;
        state.shared_array("table", &self.rows, |first, rows: &mut [[f32; 2]]| {
            for (row, value) in (first..).zip(rows) {
                match restores {
                    true => drop(values.insert(row, *value)),
                    false => *value = values[&row],
                }
            }
        })?;
        state.shared_list("noted", &mut self.noted)
    }
}

/// A state of three processes is put back by one, two and five, each of which gets the rows that it holds.
#[test]
fn parts_are_put_back_by_any_number_of_processes() {
    const ROWS: usize = 23_456;
    let home = tempfile::tempdir().unwrap();
    let path = home.path().join("fluid.npz");
    let header = StateHeader::whole("fluid", "share", 1, 8);
    let place = StatePlace { path: path.clone(), header: header.clone(), within: String::new() };
    let mut states = Share::all(ROWS, 3).map(|mut share| SavedState::of(&mut share).unwrap());
    let first = states.next().unwrap();
    std::thread::scope(|scope| {
        let waiting = scope.spawn(|| first.write(&path, &header));
        states.for_each(|state| state.write_part(&place).unwrap());
        assert_eq!(waiting.join().unwrap().unwrap(), bytes_on_disk(&path));
    });
    for shares in [1, 2, 5] {
        for mut share in Share::all(ROWS, shares) {
            let held = share.rows.held.clone();
            share.values.clear();
            share.steps = 0;
            StateArchive::open(&path).unwrap().restore("share", &mut share).unwrap();
            assert!(share.values.keys().copied().eq(held.into_iter().flatten()));
            assert!(share.values.iter().all(|(&row, value)| *value == [row as f32, -(row as f32)]));
            assert_eq!((share.steps, share.noted.len()), (41, 24));
        }
    }
    let restore = |mut share: Share| {
        let restored = StateArchive::open(&path).unwrap().restore("share", &mut share);
        restored.unwrap_err().to_string()
    };
    let text = restore(Share::all(ROWS + 1, 1).next().unwrap());
    assert!(text.starts_with("`table` of the state holds <f4, 23456 x 2, expected"), "{text}");
    // A part of another checkpoint, and one that is lost.
    let other = StatePlace { header: StateHeader { window: 9, ..header }, ..place };
    let part = home.path().join("fluid.part-2.npz");
    std::fs::remove_file(&part).unwrap();
    let mut last = Share::all(ROWS, 3).last().unwrap();
    SavedState::of(&mut last).unwrap().write_part(&other).unwrap();
    let text = restore(Share::all(ROWS, 1).next().unwrap());
    assert!(text.contains("fluid.part-2.npz") && text.contains("no part"), "{text}");
    std::fs::remove_file(&part).unwrap();
    let text = restore(Share::all(ROWS, 1).next().unwrap());
    assert!(text.contains("fluid.part-2.npz"), "{text}");
}
