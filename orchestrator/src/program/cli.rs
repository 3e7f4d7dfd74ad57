//! The command line of `tremie`.

use super::completion::{CompletionShell, complete_key, complete_setting};
use super::slurm_args::SlurmArgs;
use super::steer_args::SteerCommand;
use crate::registry::{OnArguments, OnRuns, PackageCommand, READERS, SCENES, TOOLS};
use crate::tools::conform::ConformArgs;
use crate::tools::new_scene::NewArgs;
use clap::{ArgMatches, Args, CommandFactory, FromArgMatches, Parser, Subcommand};
use clap_complete::ArgValueCompleter;
use std::ffi::OsString;
use std::num::NonZeroUsize;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use tremie_messages::schedule::Schedule;
use tremie_messages::start::{Injection, InjectionKind};
use tremie_messages::units::Time;
use tremie_results::key_value;

/// Co-simulation of slurries: fluid and grains as programs that share memory.
#[derive(Debug, Parser)]
#[command(name = "tremie", version, about, arg_required_else_help = true)]
pub struct Cli {
    /// The command, with its arguments.
    #[command(subcommand)]
    pub command: Command,
}

/// Commands of the program itself.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Make a folder with a scene that runs as it is, to begin with.
    New(NewArgs),
    /// Run a manifest.
    Run(RunArgs),
    /// Go on with a run that was ended or interrupted, from its newest checkpoint.
    Resume(ResumeArgs),
    /// Check a manifest completely and print the plan, without running it.
    Check(CheckArgs),
    /// List the signals of a manifest's components: names, units, meanings.
    Signals(ManifestArgs),
    /// List the built-in components and the roles they can take.
    Components,
    /// Open a finished run in the Rerun viewer.
    View(ViewArgs),
    /// Compare two runs: the first window and channel in which they differ, and by how much.
    Diff(DiffArgs),
    /// Run one component of a recorded run against the recorded messages of the others.
    Replay(ReplayArgs),
    /// Draw the curves of a finished run, or of several to compare them.
    Report(ReportArgs),
    /// Check that a program keeps the contract of a component.
    Conform(ConformArgs),
    /// Run manifests with many combinations of values, and make tables of the results.
    Study(StudyArgs),
    /// Run scenes whose result is known, and compare.
    Validate(ValidateArgs),
    /// Measure how fast the parts are on this machine.
    Bench(BenchArgs),
    /// A command to a run in progress.
    #[command(flatten)]
    Steer(SteerCommand),
    /// Remove shared memory that killed runs left behind.
    Clean,
    /// Print the JSON schema of the manifest, for editors, or its reference page.
    Schema {
        /// Print the reference page, in Markdown
        #[arg(long)]
        markdown: bool,
    },
    /// Explain a key of the manifest: its value, unit, default and meaning.
    Explain {
        /// The key, as scene.fluid.viscosity, or its last name alone [default: the first keys of all]
        #[arg(value_name = "KEY", default_value = "", hide_default_value = true, add = ArgValueCompleter::new(complete_key))]
        key: String,
    },
    /// Print a script that lets a shell complete commands, files and keys of manifests: source <(tremie completions bash).
    Completions {
        /// The shell
        shell: CompletionShell,
    },
    /// Take part in a run (the orchestrator calls this).
    #[command(hide = true)]
    Component {
        /// Name of the built-in component.
        name: String,
    },
}

/// Command that a command line asks for.
pub enum Asked {
    /// A command of the program itself.
    Own(Box<Command>),
    /// A command of a package.
    OfPackage(OnArguments, ArgMatches),
    /// A reader of finished runs, in these folders.
    Reader(OnRuns, Vec<PathBuf>, ArgMatches),
}

/// The whole command line, with the commands of packages.
pub(super) fn whole() -> clap::Command {
    let scene = clap::Command::new("scene")
        .about("Build a scene from numbers: its parts as STL files, and a manifest to start from")
        .subcommand_required(true)
        .arg_required_else_help(true)
        .subcommands(SCENES.iter().map(|scene| added(scene, clap::Command::new(scene.name))));
    let out = clap::Arg::new("OUT")
        .required(true)
        .num_args(1..)
        .value_parser(clap::value_parser!(PathBuf))
        .help("Folder of a finished run, or of a study");
    let reader = |reader| added(reader, clap::Command::new(reader.name).arg(out.clone()));
    Cli::command()
        .subcommand(scene)
        .subcommands(READERS.iter().map(reader))
        .subcommands(TOOLS.iter().map(|tool| added(tool, clap::Command::new(tool.name))))
}

/// The arguments of a package's command.
fn added<W>(package: &PackageCommand<W>, command: clap::Command) -> clap::Command {
    let command = (package.arguments)(command).about(package.about).long_about(None);
    let divided = command.has_subcommands();
    command.subcommand_required(divided).arg_required_else_help(divided)
}

/// Reads a command line; its first word is the program's name.
///
/// # Errors
/// clap's error, or the help that the command line asks for.
pub fn read(words: impl IntoIterator<Item = OsString>) -> Result<Asked, clap::Error> {
    of_matches(whole().try_get_matches_from(words)?)
}

fn of_matches(mut matches: ArgMatches) -> Result<Asked, clap::Error> {
    let (name, inner) = matches.subcommand().expect("clap demands a command");
    if name == "scene" {
        let (name, inner) = inner.subcommand().expect("clap demands a scene");
        return Ok(Asked::OfPackage(named(SCENES, name).expect("clap knows").work, inner.clone()));
    }
    // Packages before the program's own commands: `Cli` knows nothing of them.
    if let Some(tool) = named(TOOLS, name) {
        return Ok(Asked::OfPackage(tool.work, inner.clone()));
    }
    if let Some(reader) = named(READERS, name) {
        let out = inner.get_many::<PathBuf>("OUT").expect("clap demands it").cloned().collect();
        return Ok(Asked::Reader(reader.work, out, inner.clone()));
    }
    Ok(Asked::Own(Box::new(Cli::from_arg_matches_mut(&mut matches)?.command)))
}

fn named<W>(
    commands: &'static [PackageCommand<W>],
    name: &str,
) -> Option<&'static PackageCommand<W>> {
    commands.iter().find(|command| command.name == name)
}

/// Arguments that choose a manifest, and change values in it.
#[derive(Debug, Args)]
pub struct ManifestArgs {
    /// Manifest, or a folder that holds a manifest.toml
    pub manifest: PathBuf,
    /// Simulated time at which to end, as "0.5 s"
    #[arg(long, value_name = "TIME")]
    pub until: Option<String>,
    /// Order in which fluid and grains advance
    #[arg(long, value_name = "serial|parallel", value_parser = parse_schedule)]
    pub schedule: Option<Schedule>,
    /// Change a value of the manifest, as scene.fluid.viscosity="0.1 Pa s"
    #[arg(long, value_name = "KEY=VALUE", value_parser = key_value, add = ArgValueCompleter::new(complete_setting))]
    pub set: Vec<(String, String)>,
    /// Say nothing but errors and the last line
    #[arg(long, conflicts_with = "json")]
    pub quiet: bool,
    /// Speak JSON, one document a line, on standard output
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `tremie check`.
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// The manifest.
    #[command(flatten)]
    pub manifest: ManifestArgs,
    /// Run some windows, throw them away, and give the wall time of the whole run
    #[arg(long)]
    pub measure: bool,
}

/// Arguments of `tremie run`.
#[derive(Debug, Args)]
pub struct RunArgs {
    /// The manifest.
    #[command(flatten)]
    pub manifest: ManifestArgs,
    /// Folder for the outputs [default: runs/NAME-001 and so on]
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Watch the run in the Rerun viewer: in a browser, in its own window, in a file for later
    #[arg(long, value_name = "web|native|FILE.rrd|none", default_value = "none", value_parser = parse_view)]
    pub view: View,
    /// Run the components as threads of one process
    #[arg(long)]
    pub in_process: bool,
    /// Write the times at which components waited and computed in some windows to OUT/trace.json,
    /// for ui.perfetto.dev
    #[arg(long, value_name = "FROM-TO", num_args = 0..=1, require_equals = true, default_missing_value = "0-5000", value_parser = parse_windows)]
    pub trace: Option<RangeInclusive<u64>>,
    /// After a fault go on from the newest checkpoint by itself, so many times at most; a window that fails
    /// twice ends the run
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub restart_on_fault: u32,
    /// Begin from a checkpoint of another run: its folder of outputs, and the window if it is not the newest. The
    /// manifest may differ in what `tremie resume --set` can change. With other components the run begins at
    /// time zero, with the bodies of the grains
    #[arg(long, value_name = "OUT[@WINDOW]", value_parser = parse_from)]
    pub from: Option<(PathBuf, Option<u64>)>,
    /// Make the changes of another run at the same windows: its steering.jsonl, beside its begun.toml
    #[arg(long, value_name = "FILE")]
    pub changes: Option<PathBuf>,
    /// Pause at the end of this window, 0 for the start; `tremie step` and `tremie continue` go on
    #[arg(long, value_name = "WINDOW")]
    pub pause_at: Option<u64>,
    /// Make a component commit a fault, to see it caught: grains:drop@17
    #[arg(long, value_name = "COMPONENT:FAULT@WINDOW", value_parser = parse_injection)]
    pub inject: Vec<(String, Injection)>,
    /// Whether it is given to Slurm.
    #[command(flatten)]
    pub at_slurm: SlurmArgs,
    /// Make the run in its job (the script of --slurm calls this).
    #[arg(long, hide = true, requires = "out", conflicts_with = "slurm")]
    pub in_job: bool,
    /// Refuse a manifest, or files that it names, of another content than this hash (a study gives it to its runs).
    #[arg(long, hide = true, value_name = "HASH")]
    pub content: Option<String>,
}

/// Arguments of `tremie resume`.
#[derive(Debug, Args)]
pub struct ResumeArgs {
    /// Folder of the run's outputs
    pub out: PathBuf,
    /// Go on from the checkpoint of this window [default: the newest]
    #[arg(long, value_name = "WINDOW")]
    pub at: Option<u64>,
    /// Simulated time at which to end, as "0.5 s"
    #[arg(long, value_name = "TIME")]
    pub until: Option<String>,
    /// Change a value that may change from here on, as outputs.frames="1 ms"
    #[arg(long, value_name = "KEY=VALUE", value_parser = key_value, add = ArgValueCompleter::new(complete_setting))]
    pub set: Vec<(String, String)>,
    /// Watch the run in the Rerun viewer: in a browser, in its own window, in a file for later
    #[arg(long, value_name = "web|native|FILE.rrd|none", default_value = "none", value_parser = parse_view)]
    pub view: View,
    /// Run the components as threads of one process
    #[arg(long)]
    pub in_process: bool,
    /// After a fault go on from the newest checkpoint by itself, so many times at most; a window that fails
    /// twice ends the run
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub restart_on_fault: u32,
    /// Whether it is given to Slurm.
    #[command(flatten)]
    pub at_slurm: SlurmArgs,
    /// Say nothing but errors and the last line
    #[arg(long, conflicts_with = "json")]
    pub quiet: bool,
    /// Speak JSON, one document a line, on standard output
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `tremie view`.
#[derive(Debug, Args)]
pub struct ViewArgs {
    /// Folder of a finished run
    pub out: PathBuf,
    /// Viewer: in a browser, in its own window, in a file
    #[arg(long, value_name = "web|native|FILE.rrd", default_value = "web", value_parser = parse_view)]
    pub view: View,
}

/// Arguments of `tremie diff`.
#[derive(Debug, Args)]
pub struct DiffArgs {
    /// Folder of a run
    #[arg(value_name = "OUT1")]
    pub one: PathBuf,
    /// Folder of another
    #[arg(value_name = "OUT2")]
    pub other: PathBuf,
    /// Speak JSON, one document a line, on standard output
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `tremie replay`.
#[derive(Debug, Args)]
pub struct ReplayArgs {
    /// Folder of a run that was recorded with outputs.messages = true
    #[arg(value_name = "OUT")]
    pub run: PathBuf,
    /// The component that runs; players stand for the others
    #[arg(long, value_name = "COMPONENT")]
    pub only: String,
    /// Go on from the checkpoint of this window of the run [default: from the start]
    #[arg(long, value_name = "WINDOW")]
    pub at: Option<u64>,
    /// Change a value of the manifest, to see where its effect begins
    #[arg(long, value_name = "KEY=VALUE", value_parser = key_value, add = ArgValueCompleter::new(complete_setting))]
    pub set: Vec<(String, String)>,
    /// Folder in which programs are looked for first [default: that of the run's checkpoints]
    #[arg(long, value_name = "FOLDER")]
    pub programs: Option<PathBuf>,
    /// Folder for the outputs of the replay [default: none are kept]
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Run the components as threads of one process
    #[arg(long)]
    pub in_process: bool,
    /// Say nothing but errors and the last line
    #[arg(long, conflicts_with = "json")]
    pub quiet: bool,
    /// Speak JSON, one document a line, on standard output
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `tremie report`.
#[derive(Debug, Args)]
pub struct ReportArgs {
    /// Folders of finished runs; their curves share the panels
    #[arg(required = true, value_name = "OUT")]
    pub outs: Vec<PathBuf>,
    /// Only these signals, or all signals of a group, as fluid.beneath [default: all]
    #[arg(long = "signal", value_name = "NAME")]
    pub signals: Vec<String>,
    /// Draw spectra: at which frequencies the signals swing, and how much
    #[arg(long)]
    pub spectrum: bool,
    /// Time from which on spectra are taken, as "5 ms" [default: the first row]
    #[arg(long, value_name = "TIME", requires = "spectrum")]
    pub from: Option<Time>,
    /// Time up to which spectra are taken [default: the last row]
    #[arg(long, value_name = "TIME", requires = "spectrum")]
    pub until: Option<Time>,
    /// File of the picture; the levels go beside it, into FILE.levels.csv [default: report.svg in
    /// the first folder, with report.csv]
    #[arg(long, value_name = "FILE.svg")]
    pub to: Option<PathBuf>,
}

/// Arguments of `tremie study`.
#[derive(Debug, Args)]
pub struct StudyArgs {
    /// Study files: a manifest, axes of values, columns of the table
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Folder for runs, table and plots; a study goes on there. With several files, the folder of
    /// their folders [default: studies/NAME]
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Most runs at once (with --slurm, of each study); components whose threads the manifest leaves
    /// open share the cores then [default: as many as the cores are enough for]
    #[arg(long, value_name = "N")]
    pub jobs: Option<NonZeroUsize>,
    /// Give the runs to a Slurm cluster, as an array of jobs for each study, and collect their
    /// results
    #[arg(long, conflicts_with_all = ["list", "print"])]
    pub slurm: bool,
    /// Only check all, and list the runs
    #[arg(long)]
    pub list: bool,
    /// Only check all, and print a command line for each run that is not done
    #[arg(long, conflicts_with = "list")]
    pub print: bool,
    /// Say nothing but errors, failures and the last line
    #[arg(long, conflicts_with = "json")]
    pub quiet: bool,
    /// Speak JSON, one document a line, on standard output
    #[arg(long, conflicts_with = "print")]
    pub json: bool,
}

/// Arguments of `tremie validate`.
#[derive(Debug, Args)]
pub struct ValidateArgs {
    /// Names of cases [default: all]
    pub names: Vec<String>,
    /// Folder of the cases
    #[arg(long, value_name = "FOLDER", default_value = "tests/validation")]
    pub cases: PathBuf,
    /// Only the forms that end within seconds; keeps no results
    #[arg(long)]
    pub short: bool,
    /// File of the report on all cases [default: VALIDATION.md in their folder]
    #[arg(long, value_name = "FILE")]
    pub report: Option<PathBuf>,
    /// Cases at a time, each on its share of the cores; wall times mean less then
    #[arg(long, value_name = "N", default_value = "1")]
    pub jobs: NonZeroUsize,
}

/// Arguments of `tremie bench`.
#[derive(Debug, Args)]
pub struct BenchArgs {
    /// Only cases whose names have all these words, as: lattice f64 "2 threads" [default: all]
    pub words: Vec<String>,
    /// Numbers of threads [default: 1 and the number of cores]
    #[arg(long, value_name = "N", value_delimiter = ',')]
    pub threads: Vec<usize>,
    /// Cells along an edge of the lattices
    #[arg(long, value_name = "CELLS", default_value_t = 128)]
    pub edge: usize,
    /// Measurements of each case
    #[arg(long, value_name = "N", default_value_t = 7)]
    pub repeats: usize,
    /// Length of a measurement, about, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 0.5)]
    pub seconds: f64,
    /// Only list the cases
    #[arg(long)]
    pub list: bool,
    /// Print JSON, one document for each number
    #[arg(long)]
    pub json: bool,
}

/// Viewer of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum View {
    /// No viewer.
    None,
    /// In a browser; this program serves the page.
    Web,
    /// In Rerun's own window.
    Native,
    /// In a file.
    File(PathBuf),
}

fn parse_view(text: &str) -> Result<View, String> {
    match text {
        "none" => Ok(View::None),
        "web" => Ok(View::Web),
        "native" => Ok(View::Native),
        // Absolute: the viewer is another process, and may have another working folder.
        file if file.ends_with(".rrd") => match std::path::absolute(file) {
            Ok(path) if path.to_str().is_some() => Ok(View::File(path)),
            Ok(path) => Err(format!("{path:?} is no UTF-8 text, which the viewer must be told")),
            Err(error) => Err(error.to_string()),
        },
        _ => Err("expected web, native, none, or a file that ends in .rrd".into()),
    }
}

fn parse_windows(text: &str) -> Result<RangeInclusive<u64>, String> {
    let wrong = "expected two windows, the first not after the second, as 0-5000";
    let (from, to) = text.split_once('-').ok_or(wrong)?;
    let number = |text: &str| text.trim().parse::<u64>().map_err(|_| wrong.to_string());
    let (from, to) = (number(from)?, number(to)?);
    if from <= to { Ok(from..=to) } else { Err(wrong.into()) }
}

fn parse_schedule(text: &str) -> Result<Schedule, String> {
    match text {
        "serial" => Ok(Schedule::Serial),
        "parallel" => Ok(Schedule::Parallel),
        _ => Err("expected serial or parallel".into()),
    }
}

fn parse_from(text: &str) -> Result<(PathBuf, Option<u64>), String> {
    match text.rsplit_once('@') {
        // A folder may have the sign in its name.
        Some((out, window)) if !Path::new(text).exists() => match window.parse() {
            Ok(window) => Ok((out.into(), Some(window))),
            Err(_) => {
                Err(format!("\"{window}\" is no window: expected OUT@WINDOW, as runs/bed-001@2000"))
            }
        },
        _ => Ok((text.into(), None)),
    }
}

fn parse_injection(text: &str) -> Result<(String, Injection), String> {
    let names: Vec<_> = InjectionKind::ALL.iter().map(|(_, name)| *name).collect();
    let form = || format!("expected COMPONENT:FAULT@WINDOW with a fault of {}", names.join(", "));
    let (component, rest) = text.split_once(':').ok_or_else(form)?;
    let (fault, window) = rest.split_once('@').ok_or_else(form)?;
    let kind = InjectionKind::ALL.iter().find(|(_, name)| *name == fault).ok_or_else(form)?.0;
    let window = window.parse().map_err(|_| form())?;
    Ok((component.to_string(), Injection { kind, window }))
}

impl ManifestArgs {
    /// All changes to the manifest's values, those of the short options first. A later change
    /// overrides an earlier one.
    pub fn sets(&self) -> Vec<(String, String)> {
        let mut sets = Vec::new();
        if let Some(until) = &self.until {
            sets.push(("run.until".into(), until.clone()));
        }
        match self.schedule {
            Some(Schedule::Serial) => sets.push(("run.schedule".into(), "serial".into())),
            Some(Schedule::Parallel) => sets.push(("run.schedule".into(), "parallel".into())),
            None => {}
        }
        sets.extend(self.set.iter().cloned());
        sets
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        whole().debug_assert();
    }

    #[test]
    fn an_injection_is_read() {
        let (component, injection) = parse_injection("grains:substep-more@17").unwrap();
        assert_eq!(component, "grains");
        assert_eq!(injection, Injection { kind: InjectionKind::SubstepMore, window: 17 });
        assert!(parse_injection("grains:fall@3").unwrap_err().contains("duplicate"));
        assert!(parse_injection("drop@3").is_err());
    }
}
