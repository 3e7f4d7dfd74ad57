//! Preparation of a run: components started and asked, and a plan made.

use crate::manifest::Manifest;
use crate::outputs::JudgedFinding;
use crate::plan::{self, Plan};
use crate::preflight::{self, Machine};
use crate::run::ask_all::Round;
use crate::run::handshake::{find_programs, introduce, start_all};
use crate::run::launch::{Launcher, Peer, PeerEvent, end_all};
use crate::run::startup_log::EarlyLog;
use crate::run::{Execution, QUIT_GRACE, RunError};
use std::path::Path;
use std::sync::atomic::AtomicUsize;
use std::sync::mpsc::Receiver;
use tremie_channels::sweep::RunPlaces;
use tremie_messages::Problem;
use tremie_messages::start::{Description, InjectionKind, Signal};
use tremie_messages::units;

/// Components with their descriptions, and a plan that fits them.
pub struct Prepared {
    /// The components, in the order of the manifest.
    pub peers: Vec<Peer>,
    /// Descriptions of the components, in the same order.
    pub descriptions: Vec<Description>,
    /// Plan of the run.
    pub plan: Plan,
    /// Findings on the numbers of the run.
    pub findings: Vec<JudgedFinding>,
    pub(super) news: Receiver<PeerEvent>,
    pub(super) early: EarlyLog,
    pub(super) run: u64,
    /// Declared after the peers: it is dropped after them, when no process uses the places any
    /// more.
    pub(super) places: Option<RunPlaces>,
}

/// Starts the components of `manifest`, asks each for its description, and plans the run.
///
/// Programs are looked for in `folder` first; observers may write into `output`.
///
/// # Errors
/// [`RunError::Input`] with every problem found, or [`RunError::Interrupted`]; all components have
/// ended then.
pub fn prepare(
    manifest: &Manifest,
    folder: &Path,
    output: &Path,
    execution: &Execution,
    interrupts: &AtomicUsize,
) -> Result<Prepared, RunError> {
    check_injections(execution).map_err(RunError::Input)?;
    let programs = find_programs(manifest, folder).map_err(RunError::Input)?;
    let (launcher, news) = Launcher::new(execution.in_process);
    let peers = start_all(manifest, &programs, &launcher, execution.unlaunched);
    let mut peers = peers.map_err(RunError::Input)?;
    let run = random_id();
    let mut early = EarlyLog::default();
    let mut round = Round {
        peers: &mut peers,
        news: &news,
        early: &mut early,
        is_first: true,
        within: units::wait(manifest.spec.run.start_within),
        interrupts,
    };
    let planned = introduce(manifest, &mut round, run, output).map_err(RunError::from).and_then(
        |descriptions| Ok((make_plan(manifest, &peers, &descriptions, execution)?, descriptions)),
    );
    match planned {
        Ok((plan, descriptions)) => {
            let mut machine = Machine::ask(output);
            if execution.in_process {
                // Threads need no shared memory.
                machine.shared = None;
            }
            let findings = preflight::examine(&manifest.spec, &plan, &descriptions, &machine);
            Ok(Prepared { peers, descriptions, plan, findings, news, early, run, places: None })
        }
        // A fault of the plan, or of one component: the others are still up, and wait.
        Err(error) => {
            end_all(&mut peers, QUIT_GRACE);
            Err(error)
        }
    }
}

/// All signals that the components of `manifest` will report, each with its component's name.
///
/// # Errors
/// As [`prepare`].
pub fn signals_of(
    manifest: &Manifest,
    folder: &Path,
    interrupts: &AtomicUsize,
) -> Result<Vec<(String, Signal)>, RunError> {
    let prepared = prepare(manifest, folder, Path::new(""), &Execution::default(), interrupts)?;
    let of = |(peer, description): (&Peer, &Description)| {
        let named = |signal: &Signal| (peer.name.clone(), signal.clone());
        description.signals.iter().map(named).collect::<Vec<_>>()
    };
    let signals = prepared.peers.iter().zip(&prepared.descriptions).flat_map(of).collect();
    prepared.dismiss();
    Ok(signals)
}

fn make_plan(
    manifest: &Manifest,
    peers: &[Peer],
    descriptions: &[Description],
    execution: &Execution,
) -> Result<Plan, RunError> {
    let names = peers.iter().map(|peer| peer.name.clone());
    let named: Vec<_> = names.zip(descriptions.iter().cloned()).collect();
    let options = plan::Options { injections: execution.inject.clone() };
    plan::make(&manifest.spec, &named, &options).map_err(RunError::Input)
}

/// Faults of a process cannot be committed by a thread: they would end or hold up this program.
fn check_injections(execution: &Execution) -> Result<(), Vec<Problem>> {
    use InjectionKind::{Exit, Hang, Kill};
    let of_process = |kind| execution.in_process && matches!(kind, Exit | Hang | Kill);
    match execution.inject.iter().find(|(_, injection)| of_process(injection.kind)) {
        Some((name, _)) => {
            let text = format!("{name} is no process of its own in this run");
            Err(vec![Problem::new("--inject", text).help("leave out --in-process")])
        }
        None => Ok(()),
    }
}

/// A number that no other run on this machine has: the standard library keys its hashers at random.
fn random_id() -> u64 {
    use std::hash::{BuildHasher, Hasher};
    std::hash::RandomState::new().build_hasher().finish()
}
