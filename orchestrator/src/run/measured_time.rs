//! Wall time of a whole run, measured on its first windows: `tremie check --measure`.

use crate::manifest::Manifest;
use crate::outputs::{Ending, JudgedFinding, RunFolder};
use crate::preflight::WEEK;
use crate::run::{Execution, RunCall, RunError, prepare};
use crate::terminal::{Style, Terminal};
use indicatif::HumanDuration;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};
use tremie_messages::Finding;
use tremie_messages::Role;

/// Trial times, tried in turn until one of them completes a window.
const TRIES: [Duration; 3] =
    [Duration::from_secs(2), Duration::from_secs(8), Duration::from_secs(60)];
/// Interval of looks at the user's interrupts.
const LOOK: Duration = Duration::from_millis(50);

/// Runs some windows of the manifest without observers, throws their outputs away, and returns the
/// wall time of all `windows` [s]. Programs are looked for in `folder` first.
///
/// The first windows may be cheaper than later ones, where grains have not yet met. So the time is
/// a lower bound.
///
/// # Errors
/// As of a run; a fault of a component in these windows is a finding.
pub fn wall_time(
    manifest: &Manifest,
    folder: &Path,
    windows: u64,
    interrupts: &AtomicUsize,
) -> Result<JudgedFinding, RunError> {
    let mut manifest = manifest.clone();
    manifest.spec.components.retain(|component| component.role != Role::Observer);
    manifest.spec.stop_when.clear();
    manifest.spec.run.checkpoints.keep = 0;
    let mut done = (0, 0.0);
    for time in TRIES {
        let (ending, count, seconds) = some_windows(&manifest, folder, time, interrupts)?;
        if let Ending::Failed { fault, .. } = ending {
            let finding = Finding::new("windows before a fault", count as f64, "1");
            return Ok(JudgedFinding::of_whole(finding.wrong_if(
                true,
                format!("the run fails within its first windows: {fault}"),
                "look at the doubtful and wrong numbers above; a shorter time step or smaller speeds may help",
            )));
        }
        done = (count, seconds);
        if count > 0 {
            break;
        }
    }
    Ok(JudgedFinding::of_whole(judged(done, windows)))
}

/// Runs windows for some wall time; returns the ending, the number of windows, and their wall time
/// [s].
fn some_windows(
    manifest: &Manifest,
    folder: &Path,
    time: Duration,
    interrupts: &AtomicUsize,
) -> Result<(Ending, u64, f64), RunError> {
    let home = tempfile::tempdir().map_err(RunError::Places)?;
    let execution = Execution::default();
    let mut out = RunFolder::claim(home.path())?;
    let prepared = prepare(manifest, folder, out.path(), &execution, interrupts)?;
    // Stands for the user's interrupts: after the trial time the run ends as by Ctrl-C.
    let end = AtomicUsize::new(0);
    let mut terminal = Terminal::new(Style::Silent);
    let (over, wait) = channel::<()>();
    let ended = std::thread::scope(|scope| {
        let end = &end;
        scope.spawn(move || {
            let begin = Instant::now();
            // The channel closes when the run ends by itself, so that the thread ends at once.
            let waits = || wait.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout);
            while waits() && begin.elapsed() < time && interrupts.load(Ordering::Relaxed) == 0 {}
            end.store(1, Ordering::Relaxed);
        });
        let ended = prepared.execute(RunCall {
            manifest,
            out: &mut out,
            execution: &execution,
            terminal: &mut terminal,
            interrupts: end,
            programs: folder,
            from: None,
        });
        drop(over);
        ended
    });
    if interrupts.load(Ordering::Relaxed) > 0 {
        return Err(RunError::Interrupted);
    }
    match ended {
        // The time was over while the components were still getting ready.
        Err(RunError::Interrupted) => Ok((Ending::Interrupted, 0, time.as_secs_f64())),
        ended => {
            let summary = ended?.close();
            Ok((summary.ending, summary.windows, summary.wall_time))
        }
    }
}

fn judged((count, seconds): (u64, f64), windows: u64) -> Finding {
    if count == 0 {
        let finding = Finding::new("wall time, more than", TRIES[2].as_secs_f64(), "s");
        return finding.doubtful_if(
            true,
            format!("not one of {windows} windows was over by then"),
            "a larger cell or fewer grains",
        );
    }
    let total = windows as f64 * seconds / count as f64;
    let human = HumanDuration(Duration::from_secs_f64(total.min(1e15)));
    let rate = count as f64 / seconds;
    let why = format!("about {human}: {windows} windows at {rate:.1} a second");
    let remedy = "a coarser grid: half as many cells along each axis take a sixteenth of the time, a tenth less a third less";
    Finding::new("wall time", total, "s").because(&why).doubtful_if(total > WEEK, why, remedy)
}
