//! Wall time of a whole run, measured on its first windows: `tremie check --measure`.

use crate::manifest::Manifest;
use crate::outputs::{Ending, JudgedFinding, RankShares, RunFolder, Summary};
use crate::preflight::WEEK;
use crate::run::handshake::LAUNCH;
use crate::run::{Execution, RunCall, RunError, prepare};
use crate::terminal::{Style, Terminal};
use indicatif::HumanDuration;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};
use tremie_messages::Finding;
use tremie_messages::Role;
use tremie_messages::start::Fault;

/// Times of a measurement, tried in turn until one of them completes a window.
const TRIES: [Duration; 3] =
    [Duration::from_secs(2), Duration::from_secs(8), Duration::from_secs(60)];
/// Interval of looks at the user's interrupts.
const LOOK: Duration = Duration::from_millis(50);

/// Runs some windows of the manifest without observers, throws their outputs away, and returns the
/// wall time of all `windows` [s], and where the time of ranks went. Programs are looked for in `folder` first.
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
) -> Result<Vec<JudgedFinding>, RunError> {
    let mut manifest = manifest.clone();
    manifest.spec.components.retain(|component| component.role != Role::Observer);
    manifest.spec.stop_when.clear();
    manifest.spec.run.checkpoints.keep = 0;
    // Only ranks tell more in traced windows.
    let has_ranks = manifest.spec.components.iter().any(|c| c.settings.contains_key(LAUNCH));
    let execution =
        Execution { trace: has_ranks.then_some(1..=windows.max(1)), ..Execution::default() };
    let mut done = MeasuredWindows::default();
    for time in TRIES {
        done = some_windows(&manifest, folder, (time, &execution), interrupts)?;
        if let Some(fault) = &done.fault {
            let finding = Finding::new("windows before a fault", done.windows as f64, "1");
            return Ok(vec![JudgedFinding::of_whole(finding.wrong_if(
                true,
                format!("the run fails within its first windows: {fault}"),
                "look at the doubtful and wrong numbers above; a shorter time step or smaller speeds may help",
            ))]);
        }
        if done.windows > 0 {
            break;
        }
    }
    let of_ranks = done.ranks.iter().map(|(component, shares)| JudgedFinding {
        component: component.clone(),
        finding: shares.finding(),
    });
    let whole = JudgedFinding::of_whole(judged((done.windows, done.seconds), windows));
    Ok(of_ranks.chain([whole]).collect())
}

/// What came of some windows.
#[derive(Default)]
struct MeasuredWindows {
    fault: Option<Fault>,
    windows: u64,
    /// Their wall time [s].
    seconds: f64,
    /// Of each component that has ranks.
    ranks: Vec<(String, RankShares)>,
}

/// Runs windows for some wall time.
fn some_windows(
    manifest: &Manifest,
    folder: &Path,
    (time, execution): (Duration, &Execution),
    interrupts: &AtomicUsize,
) -> Result<MeasuredWindows, RunError> {
    let home = tempfile::tempdir().map_err(RunError::Places)?;
    let mut out = RunFolder::claim(home.path())?;
    let prepared = prepare(manifest, folder, out.path(), execution, interrupts)?;
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
            execution,
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
        Err(RunError::Interrupted) => {
            Ok(MeasuredWindows { seconds: time.as_secs_f64(), ..MeasuredWindows::default() })
        }
        ended => {
            let Summary { ending, windows, wall_time, components, .. } = ended?.close();
            let fault = match ending {
                Ending::Failed { fault, .. } => Some(fault),
                _ => None,
            };
            let shares = components.into_iter().filter_map(|(name, of)| Some((name, of.ranks?)));
            Ok(MeasuredWindows { fault, windows, seconds: wall_time, ranks: shares.collect() })
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
