//! One telling of a state for both directions.

use crate::error::StateError;
use crate::number::{StateNumber, describe, shape_of};
use crate::parts::{SharedRows, StatePart, StatePlace};
use crate::reliances::Reliances;
use crate::saved::{Content, SavedEntry, room_for};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeSet;
use std::io::{self, Read};
use std::ops::Range;

/// Rows of an array in parts that are copied at a time.
const ROWS_AT_ONCE: usize = 4096;

/// A component, or a part of one, whose state can be kept and put back.
pub trait KeepsState {
    /// Version of the state: another one whenever what [`KeepsState::exchange_state`] names changes.
    const STATE_VERSION: u32;

    /// Names everything that what comes next depends on and that the scene does not give anew. After it has
    /// put a state back ([`StateExchange::restores`]), the rest follows from that.
    ///
    /// # Errors
    /// A state that is damaged, or another's.
    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError>;
}

/// A state on its way: out of a component, or back into it.
pub struct StateExchange<'a> {
    way: Way<'a>,
    /// Names so far.
    names: BTreeSet<String>,
    /// What stands before the names that follow, with its full stop.
    within: String,
    /// The file, where there is one.
    place: Option<&'a StatePlace>,
    part: StatePart,
    reliances: Reliances,
}

enum Way<'a> {
    Save(&'a mut Vec<SavedEntry>),
    Restore(&'a mut dyn EntrySource),
}

/// Where kept entries come from.
pub(crate) trait EntrySource {
    /// Number of parts.
    fn parts(&self) -> usize {
        1
    }

    /// The entry of that name in a part.
    fn open(&mut self, name: &str, part: usize) -> Result<Option<EntryReader<'_>>, StateError>;

    /// Names of all entries.
    fn names(&self) -> Vec<String>;
}

/// An entry that is being read.
pub(crate) struct EntryReader<'a> {
    pub content: Content,
    /// Length of what follows: what the source says, no more than it has.
    pub length: usize,
    pub bytes: Box<dyn Read + 'a>,
}

impl<'a> StateExchange<'a> {
    pub(crate) fn saving(entries: &'a mut Vec<SavedEntry>, place: Option<&'a StatePlace>) -> Self {
        Self::along(Way::Save(entries), place)
    }

    pub(crate) fn restoring(
        source: &'a mut dyn EntrySource,
        place: Option<&'a StatePlace>,
    ) -> Self {
        Self::along(Way::Restore(source), place)
    }

    fn along(way: Way<'a>, place: Option<&'a StatePlace>) -> Self {
        let (names, within, part, reliances) = Default::default();
        Self { way, names, within, place, part, reliances }
    }

    /// True if a state is put back.
    pub fn restores(&self) -> bool {
        matches!(self.way, Way::Restore(_))
    }

    /// The file that the state goes to or comes from, if there is one, with what stands before the names here: for
    /// a component of several processes, each of which keeps its part in a file beside this one.
    pub fn place(&self) -> Option<StatePlace> {
        let within = self.within.trim_end_matches('.').to_string();
        self.place.map(|place| StatePlace { within, ..place.clone() })
    }

    /// Says that what is kept is a part of the component's state. Whoever keeps the first waits for the others.
    pub fn keep_part(&mut self, part: StatePart) {
        self.part = part;
    }

    /// Says that a kept state goes on from files that the disk may not have yet: `wait` returns when it has. It is
    /// called before the state itself is written, while the component goes on. Where a state is put back it is not.
    pub fn relies_on(&mut self, wait: impl FnOnce() -> Result<(), StateError> + Send + 'static) {
        if !self.restores() {
            self.reliances.add(Box::new(wait));
        }
    }

    pub(crate) fn into_part_and_reliances(self) -> (StatePart, Reliances) {
        (self.part, self.reliances)
    }

    /// Puts a name before the names that `tell` gives.
    ///
    /// # Errors
    /// Those of `tell`.
    pub fn within(
        &mut self,
        name: &str,
        tell: impl FnOnce(&mut Self) -> Result<(), StateError>,
    ) -> Result<(), StateError> {
        let before = self.within.len();
        self.within.push_str(name);
        if !name.is_empty() {
            self.within.push('.');
        }
        let told = tell(self);
        self.within.truncate(before);
        told
    }

    /// An array whose length the scene gives.
    ///
    /// # Errors
    /// A state with another length, or a damaged one.
    pub fn array<T: StateNumber>(
        &mut self,
        name: &str,
        values: &mut [T],
    ) -> Result<(), StateError> {
        self.numbers(name, values, |values, rows| values.len() == rows)
    }

    /// An array that may have another length each time.
    ///
    /// # Errors
    /// A damaged state.
    pub fn list<T: StateNumber>(
        &mut self,
        name: &str,
        values: &mut Vec<T>,
    ) -> Result<(), StateError> {
        self.numbers(name, values, |values, rows| {
            values.clear();
            values.resize(rows, T::zeroed());
            true
        })
    }

    /// Numbers that are given so many rows when they are put back, or have as many; `fit` says false
    /// where they have others.
    fn numbers<T: StateNumber, V: AsMut<[T]> + ?Sized>(
        &mut self,
        name: &str,
        values: &mut V,
        fit: impl FnOnce(&mut V, usize) -> bool,
    ) -> Result<(), StateError> {
        let name = self.name(name)?;
        match &mut self.way {
            Way::Save(entries) => {
                entries.push(SavedEntry::array(name, values.as_mut())?);
                Ok(())
            }
            Way::Restore(source) => {
                let mut entry = find(*source, &name, 0)?;
                let rows = rows::<T>(&name, &entry)?;
                if !fit(values, rows) {
                    return Err(other_shape::<T>(name, &entry.content, values.as_mut().len()));
                }
                fill(&name, &mut entry, bytemuck::cast_slice_mut(values.as_mut()))
            }
        }
    }

    /// An array of which this process has some rows, and the other parts of the state have the rest. `visit` gets
    /// some rows that follow each other, with the number of the first in the whole array: it fills them when they are
    /// kept, and takes them when they are put back.
    ///
    /// # Errors
    /// A state with another number of rows, or a damaged one.
    pub fn shared_array<T: StateNumber>(
        &mut self,
        name: &str,
        rows: &SharedRows,
        mut visit: impl FnMut(usize, &mut [T]),
    ) -> Result<(), StateError> {
        let name = self.name(name)?;
        let mut some = vec![T::zeroed(); ROWS_AT_ONCE];
        match &mut self.way {
            Way::Save(entries) => {
                let shape = shape_of::<T>(rows.own.len());
                let content = Content::Array { number: T::NAME.into(), shape };
                let mut bytes = room_for(&name, rows.own.len() * size_of::<T>())?;
                for first in rows.own.clone().step_by(ROWS_AT_ONCE) {
                    let some = &mut some[..ROWS_AT_ONCE.min(rows.own.end - first)];
                    visit(first, some);
                    bytes.extend_from_slice(bytemuck::cast_slice(some));
                }
                entries.push(SavedEntry { name, content, bytes, is_shared: true });
                Ok(())
            }
            Way::Restore(source) => {
                let mut before = 0;
                for part in 0..source.parts() {
                    let mut entry = find(*source, &name, part)?;
                    let span = before..before + self::rows::<T>(&name, &entry)?;
                    before = span.end;
                    // A part of which nothing is wanted is not read.
                    let mut wanted = rows.held_in(&span).peekable();
                    if wanted.peek().is_none() {
                        continue;
                    }
                    let mut reader = RowReader { name: &name, entry: &mut entry, at: span.start };
                    for wanted in wanted {
                        reader.visit(wanted, &mut some, &mut visit)?;
                    }
                    reader.skip::<T>(span.end)?;
                    end_of(&name, &mut entry)?;
                }
                let found = Content::Array { number: T::NAME.into(), shape: shape_of::<T>(before) };
                match before == rows.all {
                    true => Ok(()),
                    false => Err(other_shape::<T>(name, &found, rows.all)),
                }
            }
        }
    }

    /// A list of which this process has some, and the other parts of the state have the rest; put back are all.
    ///
    /// # Errors
    /// A damaged state.
    pub fn shared_list<T: StateNumber>(
        &mut self,
        name: &str,
        values: &mut Vec<T>,
    ) -> Result<(), StateError> {
        let name = self.name(name)?;
        match &mut self.way {
            Way::Save(entries) => {
                entries.push(SavedEntry { is_shared: true, ..SavedEntry::array(name, values)? });
            }
            Way::Restore(source) => {
                values.clear();
                for part in 0..source.parts() {
                    let mut entry = find(*source, &name, part)?;
                    let before = values.len();
                    values.resize(before + rows::<T>(&name, &entry)?, T::zeroed());
                    fill(&name, &mut entry, bytemuck::cast_slice_mut(&mut values[before..]))?;
                }
            }
        }
        Ok(())
    }

    /// A number, or a row of numbers, of each record, as an array.
    ///
    /// # Errors
    /// A state of another number of records, or a damaged one.
    pub fn column<R, T: StateNumber>(
        &mut self,
        name: &str,
        records: &mut [R],
        get: impl Fn(&R) -> T,
        set: impl Fn(&mut R, T),
    ) -> Result<(), StateError> {
        let mut values: Vec<T> = records.iter().map(get).collect();
        self.array(name, &mut values)?;
        if self.restores() {
            records.iter_mut().zip(values).for_each(|(record, value)| set(record, value));
        }
        Ok(())
    }

    /// Anything else, by its fields.
    ///
    /// # Errors
    /// A damaged state.
    pub fn value<T: Serialize + DeserializeOwned>(
        &mut self,
        name: &str,
        value: &mut T,
    ) -> Result<(), StateError> {
        let name = self.name(name)?;
        match &mut self.way {
            Way::Save(entries) => {
                let bytes = postcard::to_allocvec(value).map_err(|error| {
                    StateError::Unfit(format!("`{name}` cannot be kept: {error}"))
                })?;
                entries.push(SavedEntry { name, content: Content::Value, bytes, is_shared: false });
                Ok(())
            }
            Way::Restore(source) => {
                let mut entry = find(*source, &name, 0)?;
                if entry.content != Content::Value {
                    return Err(damaged(&name, "it is an array"));
                }
                let mut bytes = vec![0; entry.length];
                fill(&name, &mut entry, &mut bytes)?;
                let (read, rest) =
                    postcard::take_from_bytes(&bytes).map_err(|error| damaged(&name, error))?;
                if !rest.is_empty() {
                    return Err(damaged(&name, format!("{} bytes are left over", rest.len())));
                }
                *value = read;
                Ok(())
            }
        }
    }

    /// Refuses what was put back, or what is to be kept.
    ///
    /// # Errors
    /// Always: a sentence that says what does not fit.
    pub fn unfit(&self, why: impl Into<String>) -> Result<(), StateError> {
        Err(StateError::Unfit(why.into()))
    }

    /// Leaves the rest of a state that is put back where it is, for a component that wants only a part of it.
    /// Without this every entry must be asked for; after it none can be.
    pub fn leave_rest(&mut self) {
        if let Way::Restore(source) = &self.way {
            self.names.extend(source.names());
        }
    }

    /// Ends an exchange: every entry has been asked for.
    pub(crate) fn end(self) -> Result<(), StateError> {
        let Way::Restore(source) = self.way else { return Ok(()) };
        match source.names().into_iter().find(|name| !self.names.contains(name)) {
            Some(name) => Err(StateError::Unknown { name }),
            None => Ok(()),
        }
    }

    fn name(&mut self, name: &str) -> Result<String, StateError> {
        let name = format!("{}{name}", self.within);
        if self.names.insert(name.clone()) { Ok(name) } else { Err(StateError::Twice { name }) }
    }
}

fn find<'s>(
    source: &'s mut dyn EntrySource,
    name: &str,
    part: usize,
) -> Result<EntryReader<'s>, StateError> {
    source.open(name, part)?.ok_or_else(|| StateError::Missing { name: name.to_string() })
}

/// Reads rows of an array in their order.
struct RowReader<'e, 's> {
    name: &'e str,
    entry: &'e mut EntryReader<'s>,
    /// Number of the next row in the whole array.
    at: usize,
}

impl RowReader<'_, '_> {
    /// Gives some rows that follow, `some` at a time at most.
    fn visit<T: StateNumber>(
        &mut self,
        wanted: Range<usize>,
        some: &mut [T],
        mut visit: impl FnMut(usize, &mut [T]),
    ) -> Result<(), StateError> {
        self.skip::<T>(wanted.start)?;
        let most = some.len();
        for first in wanted.clone().step_by(most) {
            let some = &mut some[..most.min(wanted.end - first)];
            let read = self.entry.bytes.read_exact(bytemuck::cast_slice_mut(some));
            read.map_err(|error| damaged(self.name, error))?;
            visit(first, some);
        }
        self.at = wanted.end;
        Ok(())
    }

    /// Goes on to a row.
    fn skip<T>(&mut self, to: usize) -> Result<(), StateError> {
        let bytes = ((to - self.at) * size_of::<T>()) as u64;
        self.at = to;
        match io::copy(&mut (&mut self.entry.bytes).take(bytes), &mut io::sink()) {
            Ok(read) if read == bytes => Ok(()),
            Ok(_) => Err(damaged(self.name, "it is shorter than it says")),
            Err(error) => Err(damaged(self.name, error)),
        }
    }
}

/// Number of rows of an array, whose type must be `T` and whose length that of the entry.
fn rows<T: StateNumber>(name: &str, entry: &EntryReader<'_>) -> Result<usize, StateError> {
    let Content::Array { number, shape } = &entry.content else {
        return Err(damaged(name, "it is no array"));
    };
    let Some((&rows, row)) =
        shape.split_first().filter(|(_, row)| number == T::NAME && *row == T::ROW)
    else {
        return Err(other_shape::<T>(name.to_string(), &entry.content, 0));
    };
    match rows.checked_mul(size_of::<T>()) {
        Some(bytes) if bytes == entry.length => Ok(rows),
        _ => Err(damaged(name, format!("{rows} rows of {row:?} in {} bytes", entry.length))),
    }
}

fn other_shape<T: StateNumber>(name: String, content: &Content, rows: usize) -> StateError {
    let found = match content {
        Content::Array { number, shape } => describe(number, shape),
        Content::Value => "no array".into(),
    };
    StateError::Shape { name, found, expected: describe(T::NAME, &shape_of::<T>(rows)) }
}

fn fill(name: &str, entry: &mut EntryReader<'_>, bytes: &mut [u8]) -> Result<(), StateError> {
    entry.bytes.read_exact(bytes).map_err(|error| damaged(name, error))?;
    end_of(name, entry)
}

/// Nothing follows in an entry, and its checksum is right.
fn end_of(name: &str, entry: &mut EntryReader<'_>) -> Result<(), StateError> {
    // The checksum is compared where the entry ends.
    match entry.bytes.read(&mut [0]) {
        Ok(0) => Ok(()),
        Ok(_) => Err(damaged(name, "it is longer than it says")),
        Err(error) => Err(damaged(name, error)),
    }
}

pub(crate) fn damaged(name: &str, why: impl ToString) -> StateError {
    StateError::Damaged { name: name.to_string(), why: why.to_string() }
}
