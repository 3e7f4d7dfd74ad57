//! A state in memory.

use crate::error::StateError;
use crate::exchange::{EntryReader, EntrySource, KeepsState, StateExchange};
use crate::number::{StateNumber, shape_of};

/// A state that was taken out of a component. Taking it costs a copy in memory; a file of it may be written
/// while the component goes on.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SavedState {
    pub(crate) entries: Vec<SavedEntry>,
}

/// A named piece of a state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct SavedEntry {
    pub name: String,
    pub content: Content,
    pub bytes: Vec<u8>,
}

/// What an entry holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Content {
    /// Numbers of a type, and lengths.
    Array { number: String, shape: Vec<usize> },
    /// A value by its fields.
    Value,
}

impl SavedEntry {
    /// An array of numbers.
    ///
    /// # Errors
    /// If memory runs out: a copy that cannot be made shall not end the program.
    pub fn array<T: StateNumber>(name: String, values: &[T]) -> Result<Self, StateError> {
        let content = Content::Array { number: T::NAME.into(), shape: shape_of::<T>(values.len()) };
        let from: &[u8] = bytemuck::cast_slice(values);
        let mut bytes = Vec::new();
        if bytes.try_reserve_exact(from.len()).is_err() {
            return Err(StateError::Memory { name, bytes: from.len() });
        }
        bytes.extend_from_slice(from);
        Ok(Self { name, content, bytes })
    }
}

impl SavedState {
    /// The state of a component as it is now, which it keeps.
    ///
    /// # Errors
    /// If the component names two entries alike, or cannot be kept now.
    pub fn of<T: KeepsState>(component: &mut T) -> Result<Self, StateError> {
        Self::told(|state| component.exchange_state(state))
    }

    /// The state that `tell` names.
    ///
    /// # Errors
    /// Those of `tell`, or two entries that are named alike.
    pub fn told(
        tell: impl FnOnce(&mut StateExchange<'_>) -> Result<(), StateError>,
    ) -> Result<Self, StateError> {
        let mut entries = Vec::new();
        tell(&mut StateExchange::saving(&mut entries))?;
        Ok(Self { entries })
    }

    /// Puts the state back into a component that was made anew from the same scene.
    ///
    /// # Errors
    /// A state of another scene or version; the component is of no use then.
    pub fn restore<T: KeepsState>(&self, component: &mut T) -> Result<(), StateError> {
        self.put_back(|state| component.exchange_state(state))
    }

    /// Puts the state back where `tell` names it.
    ///
    /// # Errors
    /// Those of `tell`; a state that has more or less than it names.
    pub fn put_back(
        &self,
        tell: impl FnOnce(&mut StateExchange<'_>) -> Result<(), StateError>,
    ) -> Result<(), StateError> {
        let mut source = self;
        let mut exchange = StateExchange::restoring(&mut source);
        tell(&mut exchange)?;
        exchange.end()
    }

    /// The name of the first entry that another state has not, or not with the same bits.
    pub fn first_difference<'a>(&'a self, other: &'a Self) -> Option<&'a str> {
        let all = self.entries.iter().map(Some).chain(std::iter::repeat(None));
        let others = other.entries.iter().map(Some).chain(std::iter::repeat(None));
        let most = self.entries.len().max(other.entries.len());
        let pair = all.zip(others).take(most).find(|(own, other)| own != other)?;
        pair.0.or(pair.1).map(|entry| entry.name.as_str())
    }
}

impl EntrySource for &SavedState {
    fn open(&mut self, name: &str) -> Result<Option<EntryReader<'_>>, StateError> {
        let entry = self.entries.iter().find(|entry| entry.name == name);
        Ok(entry.map(|entry| EntryReader {
            content: entry.content.clone(),
            length: entry.bytes.len(),
            bytes: Box::new(entry.bytes.as_slice()),
        }))
    }

    fn names(&self) -> Vec<String> {
        self.entries.iter().map(|entry| entry.name.clone()).collect()
    }
}
