//! Checks of conformity, in the order in which a component is used.

use super::subject::Subject;
use crate::outputs::Ending;
use crate::run::launch::ComponentEvent;
use std::time::{Duration, Instant};
use tremie_messages::start::{Fault, FaultKind, Hello, InjectionKind, Reply};
use tremie_messages::{INTERFACE_VERSION, Role};

/// Something that a component must do.
pub struct ConformCheck {
    /// Name, as a user reads it.
    pub name: &'static str,
    /// The trial: `Ok` if the program does it, else a sentence.
    pub holds: fn(&Subject) -> Result<(), String>,
}

/// Every check.
pub const ALL: &[ConformCheck] = &[
    ConformCheck {
        name: "describes itself, and exits with code 0 when dismissed",
        holds: is_dismissed,
    },
    ConformCheck { name: "refuses another interface version", holds: refuses_version },
    ConformCheck { name: "refuses a role that it cannot take", holds: refuses_role },
    ConformCheck { name: "ends when the orchestrator is gone", holds: ends_alone },
    ConformCheck { name: "runs in the serial schedule", holds: runs_serial },
    ConformCheck { name: "runs in the parallel schedule", holds: runs_parallel },
    ConformCheck { name: "gives the same bits twice", holds: repeats },
    ConformCheck { name: "notices a peer that hangs, at the deadline", holds: notices_hang },
    ConformCheck { name: "notices a wrong stamp", holds: notices_stamp },
    ConformCheck { name: "notices a wrong number of values", holds: notices_count },
    ConformCheck { name: "notices values that are not numbers", holds: notices_nan },
    ConformCheck {
        name: "goes on from a checkpoint to the same bits, if it keeps a state",
        holds: goes_on,
    },
];

/// Longest time that an idle component may take to exit.
const EXIT: Duration = Duration::from_secs(2);

fn is_dismissed(subject: &Subject) -> Result<(), String> {
    let (mut peer, _news, reply) = subject.greet(subject.hello()?)?;
    match reply {
        Reply::Description(d) if d.interface == INTERFACE_VERSION => {}
        Reply::Description(d) => return Err(format!("it says interface version {}", d.interface)),
        other => return Err(format!("it answered the hello with {other:?}")),
    }
    let how = peer.end(EXIT);
    if how == "exited with code 0" { Ok(()) } else { Err(format!("after quit it {how}")) }
}

fn refuses_version(subject: &Subject) -> Result<(), String> {
    let foreign = Hello { interface: INTERFACE_VERSION + 1, ..subject.hello()? };
    is_refused(subject, foreign)
}

fn refuses_role(subject: &Subject) -> Result<(), String> {
    is_refused(subject, Hello { role: Role::Observer, ..subject.hello()? })
}

fn is_refused(subject: &Subject, hello: Hello) -> Result<(), String> {
    match subject.greet(hello)?.2 {
        Reply::Refusal { problems } if !problems.is_empty() => Ok(()),
        other => Err(format!("it answered with {other:?}")),
    }
}

fn ends_alone(subject: &Subject) -> Result<(), String> {
    let (mut peer, news, _) = subject.greet(subject.hello()?)?;
    peer.hang_up();
    let deadline = Instant::now() + EXIT;
    loop {
        match news.recv_timeout(deadline.saturating_duration_since(Instant::now())) {
            Ok((_, ComponentEvent::Closed)) => return Ok(()),
            Ok(_) => {}
            Err(_) => {
                let text = "it still ran after its standard input was closed";
                return Err(format!("{text} {} s before", EXIT.as_secs()));
            }
        }
    }
}

fn runs(subject: &Subject, schedule: &str) -> Result<(), String> {
    match subject.run(&[("run.schedule", schedule)], None)?.summary.ending {
        Ending::Completed => Ok(()),
        Ending::Failed { fault, .. } => Err(fault.to_string()),
        other => Err(format!("the run ended with {other:?}")),
    }
}

fn runs_serial(subject: &Subject) -> Result<(), String> {
    runs(subject, "serial")
}

fn runs_parallel(subject: &Subject) -> Result<(), String> {
    runs(subject, "parallel")
}

fn repeats(subject: &Subject) -> Result<(), String> {
    let [first, second] = [subject.run(&[], None)?.signals, subject.run(&[], None)?.signals];
    same_tables(&first, &second)
}

fn same_tables(first: &str, second: &str) -> Result<(), String> {
    match first.lines().zip(second.lines()).position(|(a, b)| a != b) {
        None if first == second => Ok(()),
        None => Err("the second run has another number of windows".into()),
        Some(line) => Err(format!("the tables of signals differ from line {} on", line + 1)),
    }
}

/// A run whose other side is killed, and which goes on from a checkpoint before that.
fn goes_on(subject: &Subject) -> Result<(), String> {
    if !subject.keeps_state()? {
        return Ok(());
    }
    for schedule in ["serial", "parallel"] {
        let sets = [("run.schedule", schedule), ("run.checkpoints.windows", "3")];
        let whole = subject.run(&sets, None)?;
        let resumed = subject.run_broken(&sets, (InjectionKind::Kill, 8))?;
        if resumed.summary.ending != Ending::Completed {
            return Err(format!("the run that went on ended with {:?}", resumed.summary.ending));
        }
        same_tables(&whole.signals, &resumed.signals)
            .map_err(|why| format!("{why} (schedule {schedule})"))?;
    }
    Ok(())
}

/// Runs with a fault of the other side, which the subject must notice and blame on it.
fn notices(subject: &Subject, kind: InjectionKind, expected: FaultKind) -> Result<(), String> {
    let sets = [("run.deadline", "0.5 s")];
    match subject.run(&sets, Some((kind, 3)))?.summary.ending {
        Ending::Failed { fault, .. } if is_noticed(subject, &fault, expected) => Ok(()),
        Ending::Failed { fault, .. } => {
            Err(format!("expected a fault of kind {expected:?}, found {fault}"))
        }
        other => Err(format!("the run ended with {other:?}")),
    }
}

fn is_noticed(subject: &Subject, fault: &Fault, expected: FaultKind) -> bool {
    fault.kind == expected
        && fault.noticed_by == subject.role.name()
        && fault.blamed == subject.opposite()
}

fn notices_hang(subject: &Subject) -> Result<(), String> {
    notices(subject, InjectionKind::Hang, FaultKind::Deadline)
}

fn notices_stamp(subject: &Subject) -> Result<(), String> {
    notices(subject, InjectionKind::Stale, FaultKind::Stamp)
}

fn notices_count(subject: &Subject) -> Result<(), String> {
    notices(subject, InjectionKind::Count, FaultKind::Count)
}

fn notices_nan(subject: &Subject) -> Result<(), String> {
    notices(subject, InjectionKind::Nan, FaultKind::NotFinite)
}
