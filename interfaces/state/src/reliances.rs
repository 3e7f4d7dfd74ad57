//! Files that a state goes on from.

use crate::error::StateError;
use std::fmt;

/// What must be on the disk before a state is: the files that it goes on from. Waiting for a disk may take seconds,
/// in which the component itself goes on.
#[derive(Default)]
pub struct Reliances(Vec<Wait>);

type Wait = Box<dyn FnOnce() -> Result<(), StateError> + Send>;

impl Reliances {
    pub(crate) fn add(&mut self, wait: Wait) {
        self.0.push(wait);
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Waits until the disk has all.
    ///
    /// # Errors
    /// That of the first that the disk refuses.
    pub fn settle(self) -> Result<(), StateError> {
        self.0.into_iter().try_for_each(|wait| wait())
    }
}

impl fmt::Debug for Reliances {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} waits for the disk", self.0.len())
    }
}

#[cfg(test)]
mod tests {
    use crate::{SavedState, StateError};
    use std::sync::mpsc;

    #[test]
    fn what_a_state_relies_on_is_waited_for_in_order_after_the_copy() {
        let (told, said) = mpsc::channel();
        let (_, reliances) = SavedState::told_for(None, |state| {
            for name in ["table", "folder"] {
                let told = told.clone();
                state.relies_on(move || {
                    told.send(name).unwrap();
                    if name == "folder" { Err(StateError::Unfit("no room".into())) } else { Ok(()) }
                });
            }
            state.value("steps", &mut 7)
        })
        .unwrap();
        assert_eq!(said.try_iter().count(), 0);
        assert_eq!(reliances.settle().unwrap_err().to_string(), "no room");
        assert_eq!(said.try_iter().collect::<Vec<_>>(), ["table", "folder"]);
    }
}
