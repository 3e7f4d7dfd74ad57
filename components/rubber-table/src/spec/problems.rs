//! Problems of a specification, with their lines.

use crate::spec::document::SpecDocument;
use std::fmt::{Display, Formatter, Write};
use std::ops::Range;
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};
use tremie_messages::{Problem, nearest};

/// The text of a specification.
#[derive(Clone, Debug)]
pub(super) struct Text {
    file: String,
    text: String,
}

/// A problem and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Located {
    /// Key, what is wrong, what to do.
    pub problem: Problem,
    /// Line and column, from 1, and the line; `None` where the problem is of no line.
    pub place: Option<(usize, usize, String)>,
}

/// Everything that is wrong with a specification.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub struct SpecErrors {
    /// The file, as messages call it.
    pub file: String,
    /// At least one problem, in the order of the file.
    pub problems: Vec<Located>,
}

impl SpecErrors {
    pub(super) fn unreadable(path: &Path, error: &std::io::Error) -> Self {
        let file = path.display().to_string();
        let problem = Problem::new("", format!("cannot read {file}: {error}"));
        Self { file, problems: vec![Located { problem, place: None }] }
    }
}

/// As the problems of a manifest are shown: title, place, line, remedy.
impl Display for SpecErrors {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        for Located { problem, place } in &self.problems {
            match problem.key.as_str() {
                "" => writeln!(f, "error: {}", problem.message)?,
                key => writeln!(f, "error: {key}: {}", problem.message)?,
            }
            let margin = match place {
                Some((line, column, text)) => {
                    let margin = line.to_string().len();
                    writeln!(f, "{:margin$}--> {}:{line}:{column}", "", self.file)?;
                    writeln!(f, "{:margin$} |\n{line} | {text}", "")?;
                    margin
                }
                None => {
                    writeln!(f, " --> {}", self.file)?;
                    1
                }
            };
            if let Some(help) = &problem.help {
                writeln!(f, "{:margin$} = help: {help}", "")?;
            }
            f.write_char('\n')?;
        }
        let count = self.problems.len();
        write!(f, "{count} problem{}", if count == 1 { "" } else { "s" })
    }
}

impl Text {
    pub fn new(path: &Path, text: String) -> Self {
        Self { file: path.display().to_string(), text }
    }

    pub fn file(&self) -> &str {
        &self.file
    }

    pub fn text(&self) -> &str {
        &self.text
    }

    pub fn read(&self) -> Result<SpecDocument, SpecErrors> {
        toml::from_str(&self.text).map_err(|error| {
            let problem = explain(error.message());
            let place = error.span().map(|span| self.place(span));
            SpecErrors { file: self.file.clone(), problems: vec![Located { problem, place }] }
        })
    }

    /// The problems with the lines of their keys, or of the nearest table around.
    pub fn errors(&self, problems: Vec<Problem>) -> SpecErrors {
        let mut problems: Vec<Located> = problems
            .into_iter()
            .map(|problem| {
                let place = self.span(&problem.key).map(|span| self.place(span));
                Located { problem, place }
            })
            .collect();
        problems.sort_by_key(|located| located.place.as_ref().map_or(usize::MAX, |place| place.0));
        SpecErrors { file: self.file.clone(), problems }
    }

    fn span(&self, key: &str) -> Option<Range<usize>> {
        let table = DeTable::parse(&self.text).ok()?;
        let mut table = table.get_ref();
        let mut found = None;
        for step in key.split('.') {
            let Some((_, value)) = table.iter().find(|(name, _)| name.get_ref() == step) else {
                break;
            };
            found = Some(Spanned::span(value));
            match value.get_ref() {
                DeValue::Table(inner) => table = inner,
                _ => break,
            }
        }
        found
    }

    fn place(&self, span: Range<usize>) -> (usize, usize, String) {
        let before = self.text.get(..span.start).unwrap_or(&self.text);
        let start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let line = self.text[start..].lines().next().unwrap_or("");
        (before.matches('\n').count() + 1, before[start..].chars().count() + 1, line.to_string())
    }
}

/// Turns serde's sentence into one for users.
fn explain(message: &str) -> Problem {
    for (prefix, what) in [("unknown field `", "key"), ("unknown variant `", "section")] {
        if let Some((unknown, rest)) =
            message.strip_prefix(prefix).and_then(|rest| rest.split_once('`'))
        {
            let valid: Vec<&str> = rest.split('`').skip(1).step_by(2).collect();
            let problem = Problem::new(unknown, format!("unknown {what} \"{unknown}\""));
            return match nearest(unknown, &valid) {
                Some(near) => problem.help(format!("did you mean \"{near}\"?")),
                None => problem.help(format!("valid {what}s: {}", valid.join(", "))),
            };
        }
    }
    if let Some(key) =
        message.strip_prefix("missing field `").and_then(|rest| rest.split('`').next())
    {
        return Problem::new(key, format!("the key \"{key}\" is missing"));
    }
    if message.contains("wanted exactly 1 element") {
        return Problem::new("section", "found several sections or none, expected one")
            .help("give one of section.rectangle, section.o_ring, section.d_ring, section.mesh");
    }
    Problem::new("", message.replace('`', ""))
}
