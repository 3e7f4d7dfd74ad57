//! States that go through a file.

use tremie_state::{KeepsState, SavedState, StateArchive, StateHeader};

/// Keeps the state of a component in a file, and puts it back into another one.
///
/// # Panics
/// If the state cannot be kept, or does not fit.
pub fn through_a_file<T: KeepsState>(before: &mut T, after: &mut T) {
    let home = tempfile::tempdir().expect("a folder");
    let path = home.path().join("state.npz");
    let program = "tried";
    let header = StateHeader::whole("tried", program, T::STATE_VERSION, 0);
    SavedState::of(before).and_then(|state| state.write(&path, &header)).expect("a file");
    let restored = StateArchive::open(&path).and_then(|mut file| file.restore(program, after));
    restored.expect("the state fits");
}
