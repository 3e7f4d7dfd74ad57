//! A state in memory.

use crate::error::StateError;
use crate::exchange::{EntryReader, EntrySource, KeepsState, StateExchange};
use crate::number::{StateNumber, shape_of};
use crate::parts::{StatePart, StatePlace};
use crate::reliances::Reliances;

/// A state that was taken out of a component. Taking it costs a copy in memory; a file of it may be written
/// while the component goes on.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SavedState {
    pub(crate) entries: Vec<SavedEntry>,
    pub(crate) part: StatePart,
}

/// A named piece of a state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct SavedEntry {
    pub name: String,
    pub content: Content,
    pub bytes: Vec<u8>,
    /// True if each part of the state has some of it; else the first has all.
    pub is_shared: bool,
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
        let mut bytes = room_for(&name, from.len())?;
        bytes.extend_from_slice(from);
        Ok(Self { name, content, bytes, is_shared: false })
    }
}

/// Room for a copy that is so long.
pub(crate) fn room_for(name: &str, length: usize) -> Result<Vec<u8>, StateError> {
    let mut bytes = Vec::new();
    match bytes.try_reserve_exact(length) {
        Ok(()) => Ok(bytes),
        Err(_) => Err(StateError::Memory { name: name.into(), bytes: length }),
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

    /// The state that `tell` names, which relies on no files.
    ///
    /// # Errors
    /// Those of `tell`, or two entries that are named alike.
    pub fn told(
        tell: impl FnOnce(&mut StateExchange<'_>) -> Result<(), StateError>,
    ) -> Result<Self, StateError> {
        let (state, reliances) = Self::told_for(None, tell)?;
        debug_assert!(reliances.is_empty(), "files would not be waited for");
        Ok(state)
    }

    /// The state that `tell` names, for a file, and the files that must be on the disk before.
    ///
    /// # Errors
    /// As [`SavedState::told`].
    pub fn told_for(
        place: Option<&StatePlace>,
        tell: impl FnOnce(&mut StateExchange<'_>) -> Result<(), StateError>,
    ) -> Result<(Self, Reliances), StateError> {
        let mut entries = Vec::new();
        let mut exchange = StateExchange::saving(&mut entries, place);
        tell(&mut exchange)?;
        let (part, reliances) = exchange.into_part_and_reliances();
        Ok((Self { entries, part }, reliances))
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
        let mut exchange = StateExchange::restoring(&mut source, None);
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
    fn open(&mut self, name: &str, _: usize) -> Result<Option<EntryReader<'_>>, StateError> {
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
