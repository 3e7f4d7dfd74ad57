//! `tremie study`: many runs of manifests, and tables of their results.

use super::interrupts::count_interrupts;
use super::{INTERRUPTED, refuse_text};
use crate::program::cli::StudyArgs;
use crate::run::RunError;
use crate::run::handshake::cores;
use crate::terminal::standard::answer;
use crate::terminal::{Style, Terminal};
use crate::tools::shell::shell_word;
use crate::tools::study::{
    FolderUse, RunPlace, RunQueue, SharedRuns, SlurmQueue, Study, StudyEnd, StudyError, StudyRun,
    TABLE, draw_plots, value_text,
};
use serde_json::json;
use std::collections::BTreeSet;
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};
use tremie_results::text_columns;

/// `tremie study`.
pub fn study(arguments: &StudyArgs) -> ExitCode {
    let style = Style::asked(arguments.quiet, arguments.json);
    let mut terminal = match arguments.list {
        true => Terminal::answering(style),
        false => Terminal::new(style),
    };
    carry_out(arguments, &mut terminal)
        .unwrap_or_else(|error| tell_error(&error, arguments.json, &mut terminal))
}

fn carry_out(arguments: &StudyArgs, terminal: &mut Terminal) -> Result<ExitCode, StudyError> {
    let interrupts =
        count_interrupts().map_err(|error| StudyError::Run(RunError::Signals(error)))?;
    let studies = Study::read_all(&arguments.files, arguments.out.as_deref(), &interrupts)?;
    if arguments.list {
        list_all(&studies, terminal);
        return Ok(ExitCode::SUCCESS);
    }
    let jobs = arguments.jobs.map(usize::from);
    if arguments.print {
        print(&studies, jobs)?;
        return Ok(ExitCode::SUCCESS);
    }
    let locks: Result<Vec<_>, _> = studies.iter().map(|study| study.folder.lock()).collect();
    let _locks = locks?;
    studies.iter().for_each(|study| tell_begin(study, terminal));
    let ends = match arguments.slurm {
        true => SlurmQueue::new(&studies, jobs, terminal, &interrupts).make_all()?,
        false => make(&studies, jobs, terminal, &interrupts)?,
    };
    for (study, end) in studies.iter().zip(&ends) {
        tell_plots(study, end, terminal)?;
        if studies.len() > 1 {
            terminal.say(&outcome_of(study, end));
        }
    }
    let is_interrupted = interrupts.load(Ordering::Relaxed) > 0;
    Ok(tell_end(&studies, &ends, is_interrupted, arguments, terminal))
}

/// Reports the reason why a study did not come to its end.
fn tell_error(error: &StudyError, json: bool, terminal: &mut Terminal) -> ExitCode {
    match error {
        StudyError::Input(all) => {
            let mut code = ExitCode::FAILURE;
            for errors in all {
                code = refuse_text(errors, json, terminal);
            }
            code
        }
        StudyError::Interrupted => {
            terminal.end(&error.to_string(), json!(null));
            ExitCode::from(INTERRUPTED)
        }
        other => {
            terminal.fail(&other.to_string());
            ExitCode::FAILURE
        }
    }
}

/// `--list`: the runs, without making any.
fn list_all(studies: &[Study], terminal: &Terminal) {
    for study in studies {
        if studies.len() > 1 && !terminal.speaks_json() {
            tell_begin(study, terminal);
        }
        list(study, terminal);
    }
}

fn list(study: &Study, terminal: &Terminal) {
    let keys: Vec<&str> = study.contents.keys().collect();
    let status =
        |run: &StudyRun| study.folder.outcome(run).map_or(String::new(), |outcome| outcome.status);
    let row = |run: &StudyRun| {
        let seed = run.seed.map_or(String::new(), |seed| seed.to_string());
        let values = run.values.iter().map(value_text);
        let begin = [run.point.to_string(), seed].into_iter().chain(values);
        begin.chain([run.name.clone(), status(run)]).collect()
    };
    if !terminal.speaks_json() {
        let titles: Vec<&str> = ["point", "seed"]
            .into_iter()
            .chain(keys.iter().copied())
            .chain(["run", "status"])
            .collect();
        for line in text_columns(&titles, study.runs.iter().map(row).collect()) {
            terminal.say(&line);
        }
    }
    let document = |run: &StudyRun| {
        json!({
            "point": run.point, "seed": run.seed, "values": run.values, "run": run.name,
            "status": study.folder.outcome(run).map(|outcome| outcome.status),
        })
    };
    let runs: Vec<_> = study.runs.iter().map(document).collect();
    let out = study.folder.path();
    terminal.event(json!({"event": "runs", "out": out, "keys": keys, "runs": runs}));
}

/// `--print`: a line of a shell for each run that is neither done nor under way; one for a run of several
/// studies, which the others copy later.
fn print(studies: &[Study], jobs: Option<usize>) -> Result<(), StudyError> {
    let shared = SharedRuns::of(studies, &BTreeSet::new())?;
    for place in RunPlace::all(studies).filter(|place| !shared.is_copy(*place)) {
        let study = &studies[place.study];
        let run = &study.runs[place.run];
        let folder = study.folder.of_run(run);
        let folder = std::path::absolute(&folder).unwrap_or(folder);
        let share = run.threads.share(cores(), jobs);
        let line = study.command_line(run, &share)?;
        let anew = || format!("rm -r {} && {line}", shell_word(folder.as_os_str()));
        answer(match study.folder.use_of(run)? {
            FolderUse::Done | FolderUse::UnderWay => continue,
            FolderUse::BrokenOff => {
                format!("{} || {{ {}; }}", study.resuming_line(run, &share)?, anew())
            }
            FolderUse::Unfinished => anew(),
            FolderUse::Free => line,
        });
    }
    Ok(())
}

fn tell_begin(study: &Study, terminal: &Terminal) {
    let folder = study.folder.path().display();
    let runs = study.runs.len();
    let points = study.runs.last().map_or(0, |run| run.point);
    terminal.say(&format!("{points} points, {runs} runs; outputs in {folder}"));
}

/// Makes the runs that are not done, on this machine.
fn make(
    studies: &[Study],
    jobs: Option<usize>,
    terminal: &mut Terminal,
    interrupts: &AtomicUsize,
) -> Result<Vec<StudyEnd>, StudyError> {
    let cores = cores();
    let runs = || studies.iter().flat_map(|study| &study.runs);
    let most = runs().map(|run| run.threads.share(cores, jobs).threads).max();
    let most = most.unwrap_or(1).min(cores);
    terminal.say(&format!("a run takes up to {most} threads of {cores} cores"));
    if most == cores && cores > 1 && jobs.is_none() && runs().count() > 1 {
        terminal
            .say("runs are made one after the other; --jobs N divides the cores among N of them");
    }
    RunQueue::new(studies, jobs, terminal, interrupts).make_all()
}

fn tell_plots(study: &Study, end: &StudyEnd, terminal: &Terminal) -> Result<(), StudyError> {
    let Study { folder, contents, columns, runs, .. } = study;
    for path in draw_plots(folder, contents, columns, runs, &end.results)? {
        terminal.say(&format!("a plot is in {}", path.display()));
    }
    Ok(())
}

/// Numbers of runs.
#[derive(Clone, Copy, Default)]
struct Tally {
    runs: usize,
    done: usize,
    /// Made by this command.
    made: usize,
    failed: usize,
}

impl Tally {
    fn of(study: &Study, end: &StudyEnd) -> Self {
        let StudyEnd { made, failed, .. } = *end;
        let done = end.ended().saturating_sub(failed);
        Self { runs: study.runs.len(), done, made, failed }
    }

    fn and(self, other: Self) -> Self {
        Self {
            runs: self.runs + other.runs,
            done: self.done + other.done,
            made: self.made + other.made,
            failed: self.failed + other.failed,
        }
    }

    /// In words; `what` is run.
    fn words(self, what: &str) -> String {
        let Self { runs, done, made, failed } = self;
        let failed = if failed > 0 { format!(", {failed} failed") } else { String::new() };
        format!("{done} of {runs} {what} are done, {made} made now{failed}")
    }
}

/// What became of a study, in words.
fn outcome_of(study: &Study, end: &StudyEnd) -> String {
    let table = study.folder.path().join(TABLE);
    format!("{}; the table is {}", Tally::of(study, end).words("runs"), table.display())
}

/// The last line; returns the exit code.
fn tell_end(
    studies: &[Study],
    ends: &[StudyEnd],
    has_interrupt: bool,
    arguments: &StudyArgs,
    terminal: &mut Terminal,
) -> ExitCode {
    let tallies = || studies.iter().zip(ends).map(|(study, end)| Tally::of(study, end));
    let all = tallies().fold(Tally::default(), Tally::and);
    let are_left = all.done + all.failed < all.runs;
    // An interrupt after the last run ended none.
    let is_interrupted = has_interrupt && are_left;
    let mut text = match (studies, ends) {
        ([study], [end]) => outcome_of(study, end),
        _ => all.words(&format!("runs of {} studies", studies.len())),
    };
    if are_left || all.failed > 0 {
        let why = if is_interrupted { "interrupted: " } else { "" };
        let next = if are_left { "goes on" } else { "makes the failed ones again" };
        text = format!("{why}{text}\n`{}` {next}", same_command(arguments));
    }
    let of_study = |(study, tally): (&Study, Tally)| {
        let table = study.folder.path().join(TABLE);
        let Tally { runs, done, made, failed } = tally;
        json!({"table": table, "runs": runs, "done": done, "made": made, "failed": failed})
    };
    let each: Vec<_> = studies.iter().zip(tallies()).map(of_study).collect();
    let details = json!({
        "runs": all.runs, "done": all.done, "made": all.made, "failed": all.failed,
        "studies": each,
    });
    terminal.end(&text, details);
    match (is_interrupted, are_left || all.failed > 0) {
        (true, _) => ExitCode::from(INTERRUPTED),
        (false, false) => ExitCode::SUCCESS,
        (false, true) => ExitCode::FAILURE,
    }
}

/// The command, as a shell takes it.
fn same_command(arguments: &StudyArgs) -> String {
    let mut words = vec!["tremie study".to_string()];
    words.extend(arguments.files.iter().map(|file| shell_word(file.as_os_str())));
    words.extend(arguments.out.iter().map(|out| format!("--out {}", shell_word(out.as_os_str()))));
    words.extend(arguments.jobs.map(|jobs| format!("--jobs {jobs}")));
    words.extend(arguments.slurm.then(|| "--slurm".into()));
    words.join(" ")
}
