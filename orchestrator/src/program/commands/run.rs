//! `tremie run` and `tremie check`.

use super::interrupts::count_interrupts;
use super::{refuse, refuse_text};
use crate::manifest::{self, Manifest};
use crate::outputs::JudgedFinding;
use crate::outputs::{Ending, OutputError, RunFolder, Summary, WholeCheckpoint};
use crate::preflight;
use crate::program::cli::{CheckArgs, ManifestArgs, RunArgs, View};
use crate::registry::LOGS_SHOWN;
use crate::run::{Ended, Execution, Prepared, RunCall, RunError, measured_time, prepare};
use crate::terminal::{Style, Terminal};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;
use tremie_messages::Verdict;
use tremie_messages::start::FaultKind;

/// `tremie check`: everything up to the plan, and the findings on its numbers.
pub fn check(arguments: &CheckArgs) -> ExitCode {
    let mut terminal = Terminal::answering(style(&arguments.manifest));
    let json = arguments.manifest.json;
    let mut manifest =
        match manifest::load(&arguments.manifest.manifest, &arguments.manifest.sets()) {
            Ok(manifest) => manifest,
            Err(errors) => return refuse_text(&errors, json, &terminal),
        };
    add_observers(&mut manifest, &View::None);
    match check_components(&manifest, arguments, &terminal) {
        Ok(wrong) => ExitCode::from(u8::from(wrong > 0)),
        Err(error) => refuse(&error, &manifest, json, &mut terminal),
    }
}

/// The number of findings that are wrong.
fn check_components(
    manifest: &Manifest,
    arguments: &CheckArgs,
    terminal: &Terminal,
) -> Result<usize, RunError> {
    let interrupts = count_interrupts().map_err(RunError::Signals)?;
    let folder = folder_of(&arguments.manifest.manifest);
    let execution = Execution::default();
    let mut prepared = prepare(manifest, &folder, Path::new(""), &execution, &interrupts)?;
    if arguments.measure {
        let windows = prepared.plan.windows;
        let time = measured_time::wall_time(manifest, &folder, windows, &interrupts)?;
        prepared.findings.push(time);
    }
    show_plan(manifest, &prepared, terminal);
    let wrong = preflight::count(&prepared.findings, Verdict::Wrong);
    // The components wait for an assignment: they are ended in good order.
    prepared.dismiss();
    Ok(wrong)
}

/// `tremie run`.
pub fn run(arguments: &RunArgs) -> ExitCode {
    let mut terminal = Terminal::new(style(&arguments.manifest));
    let json = arguments.manifest.json;
    let mut manifest =
        match manifest::load(&arguments.manifest.manifest, &arguments.manifest.sets()) {
            Ok(manifest) => manifest,
            Err(errors) => return refuse_text(&errors, json, &terminal),
        };
    add_observers(&mut manifest, &arguments.view);
    match run_checked(&manifest, arguments, &mut terminal) {
        Ok(code) => code,
        Err(error) => refuse(&error, &manifest, json, &mut terminal),
    }
}

fn run_checked(
    manifest: &Manifest,
    arguments: &RunArgs,
    terminal: &mut Terminal,
) -> Result<ExitCode, RunError> {
    let execution = Execution {
        in_process: arguments.in_process,
        inject: arguments.inject.clone(),
        trace: arguments.trace.clone(),
        ..Execution::default()
    };
    let folder = folder_of(&arguments.manifest.manifest);
    let order = RunOrder {
        manifest,
        programs: &folder,
        view: &arguments.view,
        is_quiet: arguments.manifest.quiet,
        restarts: arguments.restart_on_fault,
    };
    let claim = || RunFolder::choose(arguments.out.as_deref(), &arguments.manifest.manifest);
    carry_out(&order, execution, None, terminal, claim)
}

/// A run as its user orders it.
pub(super) struct RunOrder<'a> {
    pub manifest: &'a Manifest,
    /// Folder in which programs are looked for first.
    pub programs: &'a Path,
    pub view: &'a View,
    pub is_quiet: bool,
    /// Most times that it goes on by itself after a fault.
    pub restarts: u32,
}

/// Carries out a run from its begin, or `from` a checkpoint on, with its outputs in the folder that
/// `claim` gives; goes on after faults as often as its user wants it.
pub(super) fn carry_out(
    order: &RunOrder<'_>,
    mut execution: Execution,
    mut from: Option<WholeCheckpoint>,
    terminal: &mut Terminal,
    claim: impl FnOnce() -> Result<RunFolder, OutputError>,
) -> Result<ExitCode, RunError> {
    // Before the run needs shared memory: killed runs may hold most of it.
    if let Ok(swept @ 1..) = tremie_channels::sweep::sweep_dead_runs() {
        terminal.say(&format!("swept what {swept} killed runs had left in shared memory"));
    }
    if execution.in_process && !order.is_quiet {
        show_logs_of_threads();
    }
    let interrupts = count_interrupts().map_err(RunError::Signals)?;
    let mut out = claim()?;
    let mut failed_at = None;
    for restarts_left in (0..=order.restarts).rev() {
        let mut ended =
            carry_out_once(order, &execution, from.as_ref(), terminal, (&mut out, &interrupts))?;
        let restart = restart(&ended.summary, &mut failed_at, out.path(), terminal);
        let wanted = restarts_left > 0 && interrupts.load(Ordering::Relaxed) == 0;
        if let Some(checkpoint) = restart.filter(|_| wanted) {
            ended.close();
            let window = checkpoint.record.window;
            terminal.say(&format!("goes on by itself from window {window}"));
            // A fault that was committed on purpose belongs to the first try.
            execution.inject.clear();
            out = RunFolder::reclaim(out.path())?;
            from = Some(checkpoint);
            continue;
        }
        if *order.view == View::Web {
            linger(&mut ended, terminal, &interrupts);
        }
        return Ok(ExitCode::from(ended.close().ending.exit_code()));
    }
    unreachable!("the last round returns")
}

/// The checkpoint from which a run that failed may go on by itself; `None` if it did not fail, or would
/// fail again: at the window of the fault before, or because an output cannot be written.
fn restart(
    summary: &Summary,
    failed_at: &mut Option<u64>,
    out: &Path,
    terminal: &Terminal,
) -> Option<WholeCheckpoint> {
    let Ending::Failed { fault } = &summary.ending else { return None };
    if fault.kind == FaultKind::Output || summary.checkpoint.is_none() {
        return None;
    }
    if failed_at.replace(fault.window) == Some(fault.window) {
        terminal.warn(&format!("window {} failed twice: the run is given up", fault.window));
        return None;
    }
    WholeCheckpoint::find(out, None).map_err(|error| terminal.warn(&error.to_string())).ok()
}

/// Carries out a run once, to its end.
fn carry_out_once(
    order: &RunOrder<'_>,
    execution: &Execution,
    from: Option<&WholeCheckpoint>,
    terminal: &mut Terminal,
    (out, interrupts): (&mut RunFolder, &AtomicUsize),
) -> Result<Ended, RunError> {
    let RunOrder { manifest, programs, .. } = *order;
    let prepared = prepare(manifest, programs, out.path(), execution, interrupts)?;
    // Before the plan is shown: a machine that is too small ends the run here.
    if let Err(error) = prepared.fits(execution) {
        prepared.dismiss();
        return Err(error);
    }
    // Its user has seen the plan of a run that goes on.
    if from.is_none() || terminal.speaks_json() {
        show_plan(manifest, &prepared, terminal);
    }
    // Findings beyond these come from the run's signals, and are shown at its end.
    let known = prepared.findings.len();
    terminal.say(&match from {
        None => format!("outputs in {}", out.path().display()),
        Some(from) => format!(
            "goes on from window {}, {:.6} s; outputs in {}",
            from.record.window,
            from.record.time,
            out.path().display()
        ),
    });
    let executed = prepared.execute(RunCall {
        manifest,
        out,
        execution,
        terminal,
        interrupts,
        programs,
        from,
    });
    // An error, unlike a fault, means that no window was made: its files are of no use.
    if executed.is_err() && from.is_none() {
        out.clear();
    }
    let ended = executed?;
    tell_end(&ended.summary, known, out.path(), terminal);
    Ok(ended)
}

/// Tells what the observers wrote, findings beyond the `known` ones, and how the run ended.
fn tell_end(summary: &Summary, known: usize, out: &Path, terminal: &mut Terminal) {
    for (name, note) in summary.observers.iter().filter(|(_, note)| !note.is_empty()) {
        terminal.say(&format!("{name}: {note}"));
    }
    let after = summary.findings.get(known..).unwrap_or_default();
    for verdict in [Verdict::Doubtful, Verdict::Wrong] {
        preflight::sentences(after, verdict).iter().for_each(|text| terminal.point_out(text));
    }
    terminal.end(&last_line(summary, out), details(summary));
}

/// Lets the viewer serve the run until the user has seen enough, or the viewer is gone.
fn linger(ended: &mut Ended, terminal: &Terminal, interrupts: &AtomicUsize) {
    let wanted = || interrupts.load(Ordering::Relaxed) == 0;
    if !wanted() || !ended.is_serving("viewer") {
        return;
    }
    terminal.say("the viewer stays up; Ctrl-C ends it");
    while wanted() {
        if !ended.is_serving("viewer") {
            terminal.warn("the viewer has ended by itself: nothing is shown any longer");
            return;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
}

pub(super) fn style(arguments: &ManifestArgs) -> Style {
    Style::asked(arguments.quiet, arguments.json)
}

/// The folder from which a manifest's programs are found.
pub(super) fn folder_of(manifest: &Path) -> PathBuf {
    if manifest.is_dir() {
        manifest.to_path_buf()
    } else {
        manifest.parent().map(Path::to_path_buf).unwrap_or_default()
    }
}

/// Adds the recorder, the fields and the viewer that the user asked for.
pub(super) fn add_observers(manifest: &mut Manifest, view: &View) {
    if manifest.spec.outputs.record {
        manifest.spec.add_observer("recorder");
    }
    if manifest.spec.outputs.messages {
        for component in manifest.spec.components.iter_mut().filter(|c| c.stem() == "recorder") {
            component.settings.insert("messages".into(), true.into());
        }
    }
    if manifest.spec.outputs.fields.is_some() {
        manifest.spec.add_observer("fields");
    }
    if !manifest.spec.scene.profiles.is_empty() {
        manifest.spec.add_observer("profiles");
    }
    let Some(settings) = viewer_settings(view) else { return };
    manifest.spec.add_observer("viewer");
    for component in manifest.spec.components.iter_mut().filter(|c| c.stem() == "viewer") {
        component.settings.extend(settings.clone());
    }
}

/// Settings of the viewer for a place to show a run; `None` for no viewer.
pub(super) fn viewer_settings(view: &View) -> Option<serde_json::Map<String, Value>> {
    let mut settings = serde_json::Map::new();
    let mode = match view {
        View::None => return None,
        View::Web => "web",
        View::Native => "native",
        View::File(file) => {
            let file = std::path::absolute(file).unwrap_or_else(|_| file.clone());
            settings.insert("file".into(), file.to_string_lossy().into());
            "file"
        }
    };
    settings.insert("mode".into(), mode.into());
    Some(settings)
}

/// Shows log lines of components that are threads: they log through this process, not on lines of
/// their own.
fn show_logs_of_threads() {
    let filter = tracing_subscriber::EnvFilter::new(LOGS_SHOWN);
    let _ = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .without_time()
        .with_target(false)
        .with_writer(std::io::stderr)
        // It would report them on standard error, and panic there.
        .log_internal_errors(false)
        .try_init();
}

fn show_plan(manifest: &Manifest, prepared: &Prepared, terminal: &Terminal) {
    let lines = prepared.plan.lines();
    for line in lines.iter().chain(&manifest.notes) {
        terminal.say(line);
    }
    for warning in &prepared.plan.warnings {
        terminal.warn(warning);
    }
    if !terminal.speaks_json() {
        show_findings(&prepared.findings, terminal);
    }
    terminal.event(json!({
        "event": "plan",
        "plan": prepared.plan.document(),
        "lines": lines,
        "notes": manifest.notes,
        "warnings": prepared.plan.warnings,
        "findings": prepared.findings,
    }));
}

/// Shows a table of all findings, and sentences about doubtful and wrong ones.
fn show_findings(findings: &[JudgedFinding], terminal: &Terminal) {
    for line in preflight::table(findings) {
        terminal.say(&line);
    }
    for sentence in preflight::sentences(findings, Verdict::Doubtful) {
        terminal.say(&sentence);
    }
    for sentence in preflight::sentences(findings, Verdict::Wrong) {
        terminal.point_out(&sentence);
    }
    terminal.say(&preflight::total(findings));
}

fn details(summary: &Summary) -> Value {
    serde_json::to_value(summary).unwrap_or(Value::Null)
}

/// Last line of a run: its ending, its windows and times, its folder, and how to go on with it.
fn last_line(summary: &Summary, out: &Path) -> String {
    let Summary { windows, planned_windows, simulated_time, wall_time, .. } = summary;
    let went = format!(
        "{windows} of {planned_windows} windows, {simulated_time:.6} s simulated in {wall_time:.1} s; outputs in {}",
        out.display()
    );
    // Text that a shell takes as one word.
    let name = out.display().to_string();
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "/._-+".contains(c);
    let name = if name.chars().all(is_plain) { name } else { format!("{name:?}") };
    let resume = summary.checkpoint.map_or(String::new(), |window| {
        format!("\n`tremie resume {name}` goes on from window {window}")
    });
    match &summary.ending {
        Ending::Completed => format!("completed: {went}"),
        Ending::Stopped { reason } => format!("stopped: {reason}; {went}"),
        Ending::Interrupted => format!("interrupted: {went}{resume}"),
        Ending::Failed { fault } => format!("outputs up to {went}\nfailed: {fault}{resume}"),
    }
}
