//! Validation: scenes whose result is known from theory, experiment or other people's computations.
//!
//! A case is a folder with a manifest and a `case.toml` ([`case`]) that says where the reference
//! comes from, the runs to make, and the tolerances of their results. Runs are made as a user makes
//! them, by the program itself ([`execute`]). Their tables of signals
//! ([`Signals`](tremie_results::Signals)) give numbers ([`measure`]) that are compared with the
//! reference ([`judge`]). Results are kept in the case's folder ([`record`]), and all cases
//! together make `VALIDATION.md` ([`report`], [`picture`]).

pub mod case;
pub mod execute;
pub mod judge;
pub mod measure;
pub mod picture;
pub mod record;
pub mod report;

use case::Case;
use record::Record;
use std::path::{Path, PathBuf};
use tremie_results::UnreadableSignals;

/// Reason why a case could not be tried.
#[derive(Debug, thiserror::Error)]
pub enum ValidationError {
    /// A file could not be read or written.
    #[error("{}: {error}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The system's error.
        error: std::io::Error,
    },
    /// A file does not hold what it should.
    #[error("{}: {message}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// Fault of its content.
        message: String,
    },
    /// A run ended otherwise than well.
    #[error("{run}: the run failed:\n{said}")]
    Run {
        /// Names of the case and the run.
        run: String,
        /// Text on the program's standard error.
        said: String,
    },
    /// A picture could not be drawn.
    #[error("{}: cannot draw: {message}", path.display())]
    Picture {
        /// File of the picture.
        path: PathBuf,
        /// The error of the drawing.
        message: String,
    },
}

impl ValidationError {
    fn io(path: &Path) -> impl Fn(std::io::Error) -> Self + '_ {
        |error| Self::Io { path: path.to_path_buf(), error }
    }

    fn content(path: &Path, message: impl ToString) -> Self {
        Self::Content { path: path.to_path_buf(), message: message.to_string() }
    }
}

impl From<UnreadableSignals> for ValidationError {
    fn from(UnreadableSignals { path, why }: UnreadableSignals) -> Self {
        Self::Content { path, message: why }
    }
}

/// The cases in a folder, by name; all, or those named.
///
/// # Errors
/// A folder or case that cannot be read, or a name that no case has.
pub fn cases(folder: &Path, names: &[String]) -> Result<Vec<Case>, ValidationError> {
    let mut found = Vec::new();
    let entries = std::fs::read_dir(folder).map_err(ValidationError::io(folder))?;
    for entry in entries {
        let path = entry.map_err(ValidationError::io(folder))?.path();
        if path.join(case::FILE).is_file() {
            found.push(path);
        }
    }
    found.sort();
    let name_of = |path: &PathBuf| path.file_name().map(|name| name.to_string_lossy().into_owned());
    let known: Vec<String> = found.iter().filter_map(name_of).collect();
    if let Some(unknown) = names.iter().find(|name| !known.contains(name)) {
        let message = format!("no case \"{unknown}\"; there are {}", known.join(", "));
        return Err(ValidationError::content(folder, message));
    }
    found
        .retain(|path| names.is_empty() || name_of(path).is_some_and(|name| names.contains(&name)));
    found.iter().map(|path| Case::read(path)).collect()
}

/// Makes the runs of a case in `scratch` and judges them; `say` gets a line for each finding.
///
/// # Errors
/// See [`ValidationError`]. A result outside its tolerance is none, nor is a run that fails: the
/// record says so, and the other runs are made.
pub fn try_case(
    case: &Case,
    short: bool,
    scratch: &Path,
    say: &mut dyn FnMut(&str),
) -> Result<Record, ValidationError> {
    let mut record = Record::new(short);
    let mut before = Vec::new();
    for run in case.runs.iter().filter(|run| !short || run.short.is_some()) {
        let judged = execute::run(case, run, short, scratch).and_then(|outcome| {
            let findings = judge::all(case, run, short, &outcome.signals, &before)?;
            Ok((outcome, findings))
        });
        let (outcome, findings) = match judged {
            Ok(judged) => judged,
            // The run may be compared with an earlier one that failed.
            Err(error) if record.any_failed() || matches!(error, ValidationError::Run { .. }) => {
                say(&error.to_string());
                record.fail(run, &error.to_string());
                continue;
            }
            Err(error) => return Err(error),
        };
        if let Some(cut) = &outcome.signals.cut {
            say(&format!("warning: {cut}"));
        }
        before.push((run.name.clone(), outcome.signals.clone()));
        for finding in &findings {
            say(&format!("{}, {}: {finding}", case.name, run.name));
        }
        record.add(run, outcome, findings);
    }
    Ok(record)
}
