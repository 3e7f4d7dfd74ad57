//! `tremie study`: many runs of one manifest, with other values, and a table of their results.
//!
//! A study file (`file`, `contents`) names a manifest, axes of values and columns. All
//! combinations of the axes are its points (`axes`, `points`); each point is one run, or several
//! with other seeds (`runs`, `run_name`). Runs are processes of this program (`queue`, `threads`), or tasks of a
//! cluster (`slurm`), in the study's folder (`folder`). Their signals become columns (`columns`) of a
//! table (`results`, `table`, `parquet_table`) and plots (`plots`). Several studies share one queue, and
//! runs that more than one of them has (`shared_runs`).

mod axes;
mod columns;
mod contents;
mod file;
mod folder;
mod parquet_table;
mod plots;
mod points;
mod queue;
mod results;
mod run_name;
mod runs;
mod shared_runs;
mod slurm;
mod table;
mod threads;

pub use axes::value_text;
pub use columns::StudyColumn;
pub use contents::StudyContents;
pub use folder::{FolderUse, StudyFolder, StudyLock, done_runs};
pub use plots::draw_plots;
pub use queue::RunQueue;
pub use results::StudyEnd;
pub use run_name::RunNames;
pub use runs::StudyRun;
pub use shared_runs::{RunPlace, SharedRuns};
pub use slurm::SlurmQueue;
pub use table::{RunResults, TABLE};
pub use threads::ThreadShare;

use crate::manifest::{Manifest, ManifestErrors};
use crate::outputs::OutputError;
use crate::run::{RunError, signals_of};
use crate::tools::shell::shell_line;
use crate::tools::slurm::SlurmError;
use std::collections::BTreeSet;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicUsize;

/// Reason why a study did not come to its end.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The study file or the manifest is wrong.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Input(Vec<ManifestErrors>),
    /// The components of the first point do not begin.
    #[error("the components of the first point: {0}")]
    Run(RunError),
    /// One of several studies has the error.
    #[error("{}: {error}", file.display())]
    Within {
        /// The study's file.
        file: PathBuf,
        /// The error.
        error: Box<Self>,
    },
    /// Two study files would have one folder.
    #[error("two study files would have the folder {}; give each a command and an --out of its own", .0.display())]
    SameFolder(PathBuf),
    /// Another study has the folder.
    #[error("{} belongs to a study that is under way; choose another --out", .0.display())]
    Claimed(PathBuf),
    /// A run's folder cannot be used.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The operating system refuses.
    #[error("{}: {error}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The system's error.
        error: std::io::Error,
    },
    /// A plot cannot be drawn.
    #[error("{}: cannot draw: {message}", path.display())]
    Plot {
        /// File of the plot.
        path: PathBuf,
        /// The error of the drawing.
        message: String,
    },
    /// One of Slurm's commands did not do its work.
    #[error(
        "{0}\n--slurm needs the commands of a Slurm cluster, and a study whose folder all nodes share; --print gives the command lines to any other scheduler"
    )]
    Slurm(#[from] SlurmError),
    /// The user asked for the end before the first run.
    #[error("interrupted before the first run")]
    Interrupted,
}

impl StudyError {
    /// The same with the file of its study, where there are several.
    fn within(self, file: &Path, studies: usize) -> Self {
        match self {
            Self::Run(error) if studies > 1 => {
                Self::Within { file: file.to_path_buf(), error: Box::new(Self::Run(error)) }
            }
            other => other,
        }
    }

    /// For `map_err` at `path`.
    fn io(path: &Path) -> impl Fn(std::io::Error) -> Self + '_ {
        |error| Self::Io { path: path.to_path_buf(), error }
    }
}

/// A study, checked completely.
#[derive(Debug)]
pub struct Study {
    /// What its file says.
    pub contents: StudyContents,
    /// The columns, with their units.
    pub columns: Vec<StudyColumn>,
    /// All runs, in the order of the points.
    pub runs: Vec<StudyRun>,
    /// Its folder.
    pub folder: StudyFolder,
}

impl Study {
    /// Reads study files. The folder `out` is that of a single study; of several it holds all folders.
    ///
    /// # Errors
    /// Everything that is wrong with any of them.
    pub fn read_all(
        files: &[PathBuf],
        out: Option<&Path>,
        interrupts: &AtomicUsize,
    ) -> Result<Vec<Self>, StudyError> {
        let folder = |file: &PathBuf| match files.len() {
            1 => StudyFolder::of(out, file),
            _ => StudyFolder::among(out, file),
        };
        let mut paths = BTreeSet::new();
        for folder in files.iter().map(folder) {
            if !paths.insert(folder.path().to_path_buf()) {
                return Err(StudyError::SameFolder(folder.path().into()));
            }
        }
        let (mut studies, mut wrong) = (Vec::new(), Vec::new());
        for (file, folder) in files.iter().map(|file| (file, folder(file))) {
            match Self::read(file, folder, interrupts) {
                Ok(study) => studies.push(study),
                Err(StudyError::Input(errors)) => {
                    // What is wrong with a manifest is told once.
                    let is_new = |new: &ManifestErrors| {
                        !wrong.iter().any(|old: &ManifestErrors| old.to_string() == new.to_string())
                    };
                    let new: Vec<_> = errors.into_iter().filter(is_new).collect();
                    wrong.extend(new);
                }
                Err(other) if wrong.is_empty() => return Err(other.within(file, files.len())),
                Err(_) => break,
            }
        }
        if wrong.is_empty() { Ok(studies) } else { Err(StudyError::Input(wrong)) }
    }

    /// Reads a study file, and checks the manifests of all runs and the signals of the first.
    fn read(
        file: &Path,
        folder: StudyFolder,
        interrupts: &AtomicUsize,
    ) -> Result<Self, StudyError> {
        let contents =
            StudyContents::read(file).map_err(|errors| StudyError::Input(vec![errors]))?;
        let (runs, first) = runs::checked_runs(&contents, interrupts)?;
        let columns = columns_with_units(&contents, &first, interrupts)?;
        Ok(Self { contents, columns, runs, folder })
    }

    /// Name of its folder.
    pub fn name(&self) -> String {
        let path = std::path::absolute(self.folder.path());
        let name = path.ok().and_then(|path| path.file_name().map(OsStr::to_os_string));
        name.map_or_else(|| "study".into(), |name| name.to_string_lossy().into_owned())
    }

    /// The command of a run, as a shell takes it.
    ///
    /// # Errors
    /// If the system does not tell where this program lies.
    pub fn command_line(&self, run: &StudyRun, share: &ThreadShare) -> Result<String, StudyError> {
        Self::line(self.arguments(run, share))
    }

    /// The command that goes on with a run that was broken off.
    ///
    /// # Errors
    /// See [`Self::command_line`].
    pub fn resuming_line(&self, run: &StudyRun, share: &ThreadShare) -> Result<String, StudyError> {
        Self::line(self.resuming_arguments(run, &share.sets))
    }

    fn line(arguments: Vec<OsString>) -> Result<String, StudyError> {
        shell_line(arguments).map_err(StudyError::io(Path::new("/proc/self/exe")))
    }

    /// Arguments of this program to go on with a run.
    fn resuming_arguments(&self, run: &StudyRun, sets: &[(String, String)]) -> Vec<OsString> {
        let out = self.folder.of_run(run);
        let out = std::path::absolute(&out).unwrap_or(out);
        let begin = ["resume".into(), out.into(), "--quiet".into()];
        begin.into_iter().chain(as_options(sets)).collect()
    }

    /// Arguments of this program for a run.
    fn arguments(&self, run: &StudyRun, share: &ThreadShare) -> Vec<OsString> {
        let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.into());
        let (base, out) = (absolute(&self.contents.base), absolute(&self.folder.of_run(run)));
        let begin = ["run".into(), base.into(), "--out".into(), out.into(), "--quiet".into()];
        // A study may wait for days: the run must be that of its name still.
        let content = ["--content".into(), run.content.clone().into()];
        let sets = as_options(run.sets.iter().chain(&share.sets));
        begin.into_iter().chain(content).chain(sets).collect()
    }
}

/// Changes of a manifest as options of a command.
fn as_options<'a>(
    sets: impl IntoIterator<Item = &'a (String, String)>,
) -> impl Iterator<Item = OsString> {
    let option =
        |(key, value): &(String, String)| ["--set".into(), format!("{key}={value}").into()];
    sets.into_iter().flat_map(option)
}

/// The columns with the units of their signals, as the components of the first point tell them.
fn columns_with_units(
    contents: &StudyContents,
    first: &Manifest,
    interrupts: &AtomicUsize,
) -> Result<Vec<StudyColumn>, StudyError> {
    let programs = contents.base.parent().unwrap_or(Path::new(""));
    let signals = signals_of(first, programs, interrupts).map_err(|error| match error {
        RunError::Input(problems) => {
            let source_text = first.source.clone();
            StudyError::Input(vec![ManifestErrors { source_text, problems }])
        }
        RunError::Interrupted => StudyError::Interrupted,
        other => StudyError::Run(other),
    })?;
    let mut columns = contents.columns.clone();
    let found = columns.iter_mut().filter_map(|column| column.find_signal(&signals).err());
    let problems: Vec<_> = found.collect();
    if problems.is_empty() {
        return Ok(columns);
    }
    let source_text = contents.source.clone();
    Err(StudyError::Input(vec![ManifestErrors { source_text, problems }]))
}
