//! Checkpoints of a run: where the states of its components lie.
//!
//! Every component with a state ([`super::Description::state`]) writes it into a folder that is still
//! called unfinished. When all have written, the orchestrator adds its own part and gives the folder
//! its name: a folder of that name holds a whole checkpoint. Both folders lie in the folder of the
//! run's outputs ([`super::Hello::output`]).

use std::path::{Path, PathBuf};

/// Folder of all checkpoints, in that of the outputs.
pub const CHECKPOINTS: &str = "checkpoints";

/// What stands before the window in the name of a checkpoint.
const WINDOW: &str = "window-";
/// What stands before the name of a folder that is not whole.
const UNFINISHED: &str = ".unfinished-";

/// Folder of the checkpoint at the end of `window`.
pub fn folder(output: &Path, window: u64) -> PathBuf {
    output.join(CHECKPOINTS).join(format!("{WINDOW}{window:012}"))
}

/// The same while it is not whole.
pub fn unfinished(output: &Path, window: u64) -> PathBuf {
    output.join(CHECKPOINTS).join(format!("{UNFINISHED}{WINDOW}{window:012}"))
}

/// File of a component's state in the folder of a checkpoint.
pub fn state_file(folder: &Path, component: &str) -> PathBuf {
    folder.join(format!("{component}.npz"))
}

/// The window of a whole checkpoint, by the name of its folder.
pub fn window_of(name: &str) -> Option<u64> {
    name.strip_prefix(WINDOW)?.parse().ok()
}

/// True if the name is that of a folder that is not whole.
pub fn is_unfinished(name: &str) -> bool {
    name.starts_with(UNFINISHED)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_says_its_window_only_when_it_is_whole() {
        let output = Path::new("/run");
        let name = |path: PathBuf| path.file_name().unwrap().to_str().unwrap().to_string();
        for window in [1, 37, 1_000_000_000_000_000] {
            assert_eq!(window_of(&name(folder(output, window))), Some(window));
            let part = name(unfinished(output, window));
            assert!(window_of(&part).is_none() && is_unfinished(&part));
        }
        assert_eq!(window_of("window-"), None);
        assert_eq!(window_of("notes"), None);
    }
}
