//! Hazards: what breaks a run off, and when.

use super::scenes::{Disturbable, SCENES};
use std::fmt::{Display, Formatter};
use tremie_test_support::Random;

/// A run, and what breaks it off.
#[derive(Clone, Debug)]
pub struct Hazard {
    /// The scene.
    pub scene: Disturbable,
    /// The order of work.
    pub schedule: &'static str,
    /// What happens.
    pub what: What,
    /// Options with which the run goes on.
    pub resume: Vec<String>,
}

/// What happens to a run.
#[derive(Clone, Debug)]
pub enum What {
    /// A component commits a fault in a window.
    Fault { component: &'static str, kind: &'static str, window: u64 },
    /// A signal comes so long after a checkpoint.
    Signal { to: Target, signal: &'static str, moment: Moment },
    /// The orchestrator is killed, and again when the run has gone on.
    /// The second time it may have gone on from its first checkpoint, not from its newest.
    KilledTwice { moments: [Moment; 2], goes_back: bool },
}

/// Who gets a signal.
#[derive(Clone, Copy, Debug)]
pub enum Target {
    /// The program that the user started.
    Orchestrator,
    /// A component: its name, and its program.
    Component(&'static str, &'static str),
}

/// A moment of a run.
#[derive(Clone, Copy, Debug)]
pub enum Moment {
    /// So many milliseconds after so many checkpoints are whole.
    After { checkpoints: u64, milliseconds: u64 },
    /// While the next checkpoint after so many is being written.
    WhileWriting { checkpoints: u64 },
}

/// Names of all that happens, in the order in which the cases go round.
const KINDS: [&str; 18] = [
    "drop",
    "duplicate",
    "stale",
    "count",
    "nan",
    "hang",
    "exit",
    "kill",
    "substep-more",
    "substep-less",
    "SIGKILL of a component",
    "SIGSTOP of a component",
    "SIGKILL of the orchestrator",
    "SIGTERM of the orchestrator",
    "orchestrator killed while a checkpoint is written",
    "component killed while a checkpoint is written",
    "orchestrator killed twice",
    "SIGKILL of the recorder",
];

impl Hazard {
    /// The hazard of a case.
    pub fn draw(seed: u64, case: u64) -> Self {
        let mut draw = Random::of_case(seed, case);
        let kind = KINDS[case as usize % KINDS.len()];
        let needs_messages = ["drop", "duplicate", "stale", "count", "nan"].contains(&kind);
        let needs_substeps = kind.starts_with("substep");
        let fits = |scene: &&Disturbable| {
            (!needs_messages || scene.physics.len() > 1)
                && (!needs_substeps || scene.makes_substeps.is_some())
        };
        let scenes: Vec<_> = SCENES.iter().filter(fits).copied().collect();
        let scene = *draw.one(&scenes);
        let schedule =
            if scene.has_schedules { *draw.one(&["serial", "parallel"]) } else { "serial" };
        let what = What::draw(kind, &scene, &mut draw);
        let threads = format!("components.{}.threads={}", scene.physics[0].0, draw.between(1, 2));
        let resume = match draw.between(0, 3) {
            0 => vec!["--in-process".into()],
            1 => vec!["--set".into(), threads],
            _ => Vec::new(),
        };
        Self { scene, schedule, what, resume }
    }
}

impl What {
    fn draw(kind: &'static str, scene: &Disturbable, draw: &mut Random) -> Self {
        let (name, program) = *draw.one(scene.physics);
        let component = Target::Component(name, program);
        let last = scene.windows / scene.every;
        let writing =
            |draw: &mut Random| Moment::WhileWriting { checkpoints: draw.between(0, last / 2) };
        let signal = |to, signal, moment| Self::Signal { to, signal, moment };
        match kind {
            "SIGKILL of a component" => signal(component, "KILL", after(last, draw)),
            // Not before the first window: a start may take as long as `run.start_within`.
            "SIGSTOP of a component" => {
                let checkpoints = draw.between(1, last / 2);
                let milliseconds = draw.between(0, 60);
                signal(component, "STOP", Moment::After { checkpoints, milliseconds })
            }
            "SIGKILL of the orchestrator" => {
                signal(Target::Orchestrator, "KILL", after(last, draw))
            }
            "SIGTERM of the orchestrator" => {
                signal(Target::Orchestrator, "TERM", after(last, draw))
            }
            "SIGKILL of the recorder" => {
                let recorder = Target::Component("recorder", "recorder");
                signal(recorder, "KILL", after(last, draw))
            }
            "orchestrator killed while a checkpoint is written" => {
                signal(Target::Orchestrator, "KILL", writing(draw))
            }
            "component killed while a checkpoint is written" => {
                signal(component, "KILL", writing(draw))
            }
            "orchestrator killed twice" => {
                let first = draw.between(1, last / 3);
                let moment = |checkpoints, draw: &mut Random| Moment::After {
                    checkpoints,
                    milliseconds: draw.between(0, 30),
                };
                let goes_back = draw.between(0, 1) == 1;
                let again = if goes_back {
                    Moment::After { checkpoints: 1, milliseconds: draw.between(0, 500) }
                } else {
                    moment(first + 1, draw)
                };
                Self::KilledTwice { moments: [moment(first, draw), again], goes_back }
            }
            kind => {
                let substeps = scene.makes_substeps.filter(|_| kind.starts_with("substep"));
                // Some before the first checkpoint, which leave nothing to go on from.
                let window = draw.between(scene.every / 2, scene.windows);
                Self::Fault { component: substeps.unwrap_or(name), kind, window }
            }
        }
    }

    /// What happens, without where and when.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Fault { kind, .. } => kind,
            Self::KilledTwice { .. } => "KILL twice",
            Self::Signal { signal, to: Target::Orchestrator, .. } => signal,
            Self::Signal { signal: "STOP", .. } => "STOP of a component",
            Self::Signal { .. } => "KILL of a component",
        }
    }

    /// True if a component stops to work, but lives.
    pub fn hangs(&self) -> bool {
        matches!(self, Self::Fault { kind: "hang", .. } | Self::Signal { signal: "STOP", .. })
    }

    /// The component to blame, if any is.
    pub fn blamed(&self) -> Option<&'static str> {
        match self {
            Self::Fault { component, .. } => Some(component),
            Self::Signal { to: Target::Component(name, _), .. } => Some(name),
            _ => None,
        }
    }
}

fn after(last: u64, draw: &mut Random) -> Moment {
    Moment::After { checkpoints: draw.between(0, last / 2), milliseconds: draw.between(0, 60) }
}

impl Display for Hazard {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let Self { scene, schedule, what, resume } = self;
        write!(f, "{} ({schedule}), ", scene.name)?;
        match what {
            What::Fault { component, kind, window } => write!(f, "{component}:{kind}@{window}")?,
            What::Signal { to, signal, moment } => write!(f, "{signal} to {to:?} {moment:?}")?,
            What::KilledTwice { moments, goes_back } => {
                write!(f, "KILL twice, {moments:?}, back to the first checkpoint: {goes_back}")?
            }
        }
        write!(f, ", resumed with {resume:?}")
    }
}

#[test]
fn the_hundred_cases_hold_all_kinds_scenes_and_schedules() {
    let all: Vec<_> = (0..super::CASES).map(|case| Hazard::draw(super::SEED, case)).collect();
    for scene in SCENES {
        assert!(all.iter().filter(|hazard| hazard.scene.name == scene.name).count() >= 5);
    }
    for schedule in ["serial", "parallel"] {
        assert!(all.iter().filter(|hazard| hazard.schedule == schedule).count() >= 20);
    }
    assert!(all.iter().filter(|hazard| !hazard.resume.is_empty()).count() >= 20);
}
