//! A run carried out as its user ordered it: to its end, and on after faults and changes.

use super::check::show_plan;
use super::interrupts::count_interrupts;
use crate::manifest::Manifest;
use crate::outputs::ChangeRecord;
use crate::outputs::{self, Ending, OutputError, RunFolder, Summary, WholeCheckpoint};
use crate::preflight;
use crate::program::cli::View;
use crate::registry::LOGS_SHOWN;
use crate::run::changes::NotChanged;
use crate::run::{Change, Ended, Execution, Origin, RunCall, RunError, Takes, changes, prepare};
use crate::terminal::Terminal;
use serde_json::Value;
use std::borrow::Cow;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;
use tremie_messages::Verdict;
use tremie_messages::start::{Fault, FaultKind};

/// The checkpoint from which a run begins that does not begin with its scene alone.
pub(super) struct Begin {
    pub checkpoint: WholeCheckpoint,
    pub takes: Takes,
}

impl Begin {
    /// The run of the checkpoint goes on, with its outputs.
    pub fn goes_on(checkpoint: WholeCheckpoint) -> Self {
        Self { checkpoint, takes: Takes::Outputs }
    }

    fn origin(&self) -> Origin<'_> {
        Origin { checkpoint: &self.checkpoint, takes: self.takes }
    }
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
    /// Changes of the manifest at windows to come.
    pub changes: &'a [ChangeRecord],
}

/// Carries out a run from its begin, or `from` a checkpoint on, with its outputs in the folder that
/// `claim` gives; goes on after faults as often as its user wants it.
pub(super) fn carry_out(
    order: &RunOrder<'_>,
    mut execution: Execution,
    mut from: Option<Begin>,
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
    if let Some(Begin { checkpoint, takes: Takes::Outputs }) = &from {
        outputs::forget_changes(out.path(), checkpoint.record.window)?;
    }
    let mut restarts = Restarts { left: order.restarts, failed_at: None };
    let mut manifest = Cow::Borrowed(order.manifest);
    // The manifest before a change, until a run with the changed one has begun.
    let mut before = None;
    // The end of the leg before a change, which is told only if the change is not made.
    let mut untold = None;
    loop {
        let leg = RunOrder { manifest: &manifest, ..*order };
        let places = (&mut out, &*interrupts);
        let once = carry_out_once(&leg, &execution, from.as_ref(), terminal, places);
        let (mut ended, known) = match once {
            Ok(ended) => ended,
            Err(error) if before.is_some() && !matches!(error, RunError::Interrupted) => {
                terminal.warn(&format!("the change is taken back: {error}"));
                let window = from.as_ref().map_or(0, |from| from.checkpoint.record.window);
                outputs::forget_changes(out.path(), window.saturating_sub(1))?;
                manifest = before.take().map_or(manifest, Cow::Owned);
                continue;
            }
            Err(error) => return broken_off(error, untold, out.path(), terminal),
        };
        let may_go_on = interrupts.load(Ordering::Relaxed) == 0;
        // A run that goes on with a change has not ended, whatever its summary says meanwhile.
        let is_changed = may_go_on && changed(&ended).is_some();
        if !is_changed {
            tell_end(&ended.summary, known, out.path(), terminal);
        }
        let next = || next_leg(&leg, out.path(), &ended, &mut restarts, terminal);
        let Some(next) = may_go_on.then(next).flatten() else {
            if is_changed {
                tell_end(&ended.summary, known, out.path(), terminal);
            }
            linger(order.view, &mut ended, terminal, &interrupts);
            return Ok(ExitCode::from(ended.close().ending.exit_code()));
        };
        let summary = ended.close();
        untold = is_changed.then_some((summary, known));
        // A fault that was committed on purpose belongs to the first try.
        execution.inject.clear();
        execution.pause_at = next.pause_at;
        let window = next.from.record.window;
        execution.changes = order.changes.iter().filter(|it| it.window > window).cloned().collect();
        out = RunFolder::reclaim(out.path())?;
        from = Some(Begin::goes_on(next.from));
        manifest = Cow::Owned(next.manifest);
        before = next.before;
    }
}

/// Ends a run that could not begin, or not go on: what was made before a change is told, and stays.
fn broken_off(
    error: RunError,
    untold: Option<(Summary, usize)>,
    out: &Path,
    terminal: &mut Terminal,
) -> Result<ExitCode, RunError> {
    let Some((summary, known)) = untold else { return Err(error) };
    tell_end(&summary, known, out, terminal);
    match error {
        RunError::Interrupted => Ok(ExitCode::from(summary.ending.exit_code())),
        other => Err(other),
    }
}

/// How a run goes on by itself, in the same command.
struct NextLeg {
    from: WholeCheckpoint,
    /// The manifest of the checkpoint, whose files are the copies in the run's folder, with the change if there is one.
    manifest: Manifest,
    /// The same without the change.
    before: Option<Manifest>,
    pause_at: Option<u64>,
}

/// How a run that ended goes on: with a change that its user made, or after a fault; `None` if it is over.
fn next_leg(
    order: &RunOrder<'_>,
    out: &Path,
    ended: &Ended,
    restarts: &mut Restarts,
    terminal: &Terminal,
) -> Option<NextLeg> {
    if let Some(change) = changed(ended) {
        return with_change(order, out, change, terminal);
    }
    let Ending::Failed { fault, .. } = &ended.summary.ending else { return None };
    let from = restarts.after(fault, &ended.summary, out, terminal)?;
    let manifest = kept_manifest(&from, &[], order.view);
    let manifest = manifest.map_err(|error| terminal.warn(&error.to_string())).ok()?;
    Some(NextLeg { from, manifest, before: None, pause_at: None })
}

/// The change for which a run ended, to go on with the changed manifest.
fn changed(ended: &Ended) -> Option<&Change> {
    ended.change.as_ref().filter(|_| matches!(ended.summary.ending, Ending::Interrupted))
}

/// How a run goes on with a change of its manifest.
fn with_change(
    order: &RunOrder<'_>,
    out: &Path,
    change: &Change,
    terminal: &Terminal,
) -> Option<NextLeg> {
    let given_up = |why: String| terminal.warn(&format!("the change was not made: {why}"));
    let from = WholeCheckpoint::find(out, Some(change.record.window));
    let from = from.map_err(|error| given_up(error.to_string())).ok()?;
    let kept = |sets: &[(String, String)]| {
        let manifest = kept_manifest(&from, sets, order.view);
        manifest.map_err(|error| given_up(error.to_string())).ok()
    };
    let (manifest, before) = (kept(&change.record.set)?, kept(&[])?);
    let recorded = outputs::record_change(out, &from.manifest, &change.record);
    recorded.map_err(|error| given_up(error.to_string())).ok()?;
    let set = change.record.set.iter().map(|(key, value)| format!("{key} = {value}"));
    terminal.say(&format!("changed: {}", set.collect::<Vec<_>>().join(", ")));
    let pause_at = change.is_paused.then_some(change.record.window);
    Some(NextLeg { from, manifest, before: Some(before), pause_at })
}

/// The manifest of a checkpoint with changes: its files are the copies in the run's folder, whatever became of those
/// that its user named.
fn kept_manifest(
    from: &WholeCheckpoint,
    sets: &[(String, String)],
    view: &View,
) -> Result<Manifest, NotChanged> {
    let mut manifest = changes::changed(&from.manifest_file(), &from.manifest, sets)?;
    add_observers(&mut manifest, view);
    Ok(manifest)
}

/// Restarts of a run after faults.
struct Restarts {
    left: u32,
    /// Window of the last fault.
    failed_at: Option<u64>,
}

impl Restarts {
    /// The checkpoint from which a run that failed may go on by itself; `None` if it would fail again: at
    /// the window of the fault before, because its physics went wrong, or because an output cannot be
    /// written.
    fn after(
        &mut self,
        fault: &Fault,
        summary: &Summary,
        out: &Path,
        terminal: &Terminal,
    ) -> Option<WholeCheckpoint> {
        let fails_again = [FaultKind::Output, FaultKind::Physics].contains(&fault.kind);
        if fails_again || summary.checkpoint.is_none() {
            return None;
        }
        if self.failed_at.replace(fault.window) == Some(fault.window) {
            terminal.warn(&format!("window {} failed twice: the run is given up", fault.window));
            return None;
        }
        self.left = self.left.checked_sub(1)?;
        let from = WholeCheckpoint::find(out, None);
        let from = from.map_err(|error| terminal.warn(&error.to_string())).ok()?;
        terminal.say(&format!("goes on by itself from window {}", from.record.window));
        Some(from)
    }
}

/// Carries out a run once, to its end. Gives also the number of findings that are known from before it.
fn carry_out_once(
    order: &RunOrder<'_>,
    execution: &Execution,
    from: Option<&Begin>,
    terminal: &mut Terminal,
    (out, interrupts): (&mut RunFolder, &AtomicUsize),
) -> Result<(Ended, usize), RunError> {
    let RunOrder { manifest, programs, .. } = *order;
    let prepared = prepare(manifest, programs, out.path(), execution, interrupts)?;
    // Before the plan is shown: a machine that is too small ends the run here.
    if let Err(error) = prepared.fits(execution) {
        prepared.dismiss();
        return Err(error);
    }
    // Its user has seen the plan of a run that goes on.
    if from.is_none_or(|from| from.takes != Takes::Outputs) || terminal.speaks_json() {
        show_plan(manifest, &prepared, terminal);
    }
    // Findings beyond these come from the run's signals, and are shown at its end.
    let known = prepared.findings.len();
    terminal.say(&match from {
        None => format!("outputs in {}", out.path().display()),
        Some(Begin { checkpoint, takes }) => format!(
            "{} window {}, {:.6} s; outputs in {}",
            match takes {
                Takes::Outputs => "goes on from",
                Takes::States => "begins from another run's",
                Takes::Bodies => "begins at time zero with the bodies of another run's",
            },
            checkpoint.record.window,
            checkpoint.record.time,
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
        from: from.map(Begin::origin),
    });
    // An error, unlike a fault, means that no window was made: its files are of no use.
    if executed.is_err() && from.is_none_or(|from| from.takes != Takes::Outputs) {
        out.clear();
    }
    Ok((executed?, known))
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
fn linger(view: &View, ended: &mut Ended, terminal: &Terminal, interrupts: &AtomicUsize) {
    let wanted = || interrupts.load(Ordering::Relaxed) == 0;
    if *view != View::Web || !wanted() || !ended.is_serving("viewer") {
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

/// Adds the recorder, the fields and the viewer that the user asked for.
pub(super) fn add_observers(manifest: &mut Manifest, view: &View) {
    manifest.spec.add_output_observers();
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
        Ending::Failed { fault, breach } => {
            let before = breach.as_ref().map(|breach| match breach.resumption() {
                Some([options, effect]) => format!("\n`tremie resume {name}{options}` {effect}"),
                None => "\nno checkpoint is from before that; `--set run.checkpoints.windows=N` makes one every N windows".into(),
            });
            format!("outputs up to {went}\nfailed: {fault}{}", before.unwrap_or(resume))
        }
    }
}
