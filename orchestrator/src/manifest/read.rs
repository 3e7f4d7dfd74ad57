//! A tree of plain values to typed tables, without stopping at the first problem.

use super::explain::explain;
use super::path;
use serde::de::DeserializeOwned;
use serde_json::Value;
use serde_path_to_error::Segment;
use tremie_messages::Problem;

/// Problems found so far, and which keys could not be read.
///
/// A key that could not be read is left out of the tables; that it is then missing there, or that
/// something else misses it, is no problem of its own.
#[derive(Debug, Default)]
pub(super) struct Findings {
    problems: Vec<Problem>,
    unreadable: Vec<String>,
}

impl Findings {
    /// Notes a problem.
    pub fn add(&mut self, problem: Problem) {
        self.problems.push(problem);
    }

    /// Notes that the value of `key` is wrong: others that need it shall not tell so again.
    pub fn spoil(&mut self, key: String) {
        self.unreadable.push(key);
    }

    /// True if something at, above or below `key` could not be read.
    pub fn is_unreadable(&self, key: &str) -> bool {
        let touches = |other: &String| path::is_within(other, key) || path::is_within(key, other);
        self.unreadable.iter().any(touches)
    }

    pub fn into_problems(self) -> Vec<Problem> {
        self.problems
    }
}

/// Reads `tree`. A key that cannot be read is noted and taken out, and the rest is read again.
pub(super) fn read<T: DeserializeOwned + Default>(mut tree: Value) -> (T, Findings) {
    let mut findings = Findings::default();
    loop {
        let error = match serde_path_to_error::deserialize(&tree) {
            Ok(document) => return (document, findings),
            Err(error) => error,
        };
        let (problem, meant) = explain(&path_of(error.path()), &error.inner().to_string());
        let removed = remove(&mut tree, error.path(), &problem.key);
        findings.add(problem);
        findings.unreadable.extend(meant);
        match removed {
            Some(key) => findings.unreadable.push(key),
            None => return (T::default(), findings.all_unreadable()),
        }
    }
}

impl Findings {
    fn all_unreadable(mut self) -> Self {
        self.unreadable.push(String::new());
        self
    }
}

fn path_of(path: &serde_path_to_error::Path) -> String {
    path.iter().fold(String::new(), |at, segment| match segment {
        Segment::Seq { index } => path::item(&at, *index),
        Segment::Map { key } => path::join(&at, key),
        Segment::Enum { .. } | Segment::Unknown => at,
    })
}

/// Takes out the innermost key on the way to the problem (not an entry of a list: the others would
/// change their numbers) and returns its path.
fn remove(tree: &mut Value, path: &serde_path_to_error::Path, problem_key: &str) -> Option<String> {
    let mut steps: Vec<Segment> = path.iter().cloned().collect();
    let named = path_of(path);
    if let Some(unknown) = problem_key.strip_prefix(&named).map(|rest| rest.trim_start_matches('.'))
        && !unknown.is_empty()
    {
        steps.push(Segment::Map { key: unknown.to_string() });
    }
    let last = steps.iter().rposition(|step| matches!(step, Segment::Map { .. }))?;
    let mut slot = tree;
    let mut at = String::new();
    for step in &steps[..last] {
        match step {
            Segment::Map { key } => {
                slot = slot.get_mut(key)?;
                at = path::join(&at, key);
            }
            Segment::Seq { index } => {
                slot = slot.get_mut(index)?;
                at = path::item(&at, *index);
            }
            Segment::Enum { .. } | Segment::Unknown => {}
        }
    }
    let Segment::Map { key } = &steps[last] else {
        return None;
    };
    slot.as_object_mut()?.remove(key)?;
    Some(path::join(&at, key))
}
