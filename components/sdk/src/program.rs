//! From a solver to a program: what a component's `main` calls.

use crate::line::ControlPipe;
use crate::serve::{Assigned, Introduction, introduce};
use crate::setup::Setup;
use std::fmt::Display;
use std::io::Write;
use std::process::ExitCode;
use tremie_channels::{ChannelMedium, InProcess, SharedMemory};
use tremie_messages::start::{Description, INTERFACE_VARIABLE};
use tremie_messages::{Problem, Role};

/// A way to take part in a run: [`AsFluid`](crate::AsFluid), [`AsGrains`](crate::AsGrains),
/// [`AsRubber`](crate::AsRubber) or [`AsObserver`](crate::AsObserver) of what an author implements.
pub trait Participant {
    /// The role that a manifest names it for.
    const ROLE: Role;
    /// Name and version of the program.
    const PROGRAM: &'static str;

    /// Name and version as the program describes itself: another than [`Participant::PROGRAM`] only
    /// where one program serves whatever a user wrote.
    fn program() -> String {
        Self::PROGRAM.into()
    }

    /// Its description.
    ///
    /// # Errors
    /// Problems of scene and parameters.
    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>>;

    /// Goes through the run that it was assigned to, over one kind of channels.
    ///
    /// # Errors
    /// A sentence for standard error.
    fn serve<S: ChannelMedium>(line: ControlPipe, assigned: Assigned) -> Result<(), String>;
}

/// Takes part in a run, over `line`.
///
/// # Errors
/// A sentence for standard error.
pub fn run<P: Participant>(mut line: ControlPipe) -> Result<(), String> {
    match introduce(&mut line, P::ROLE, &P::program(), P::describe)? {
        Introduction::Dismissed => Ok(()),
        Introduction::Assigned(all) if all.1.transport.between_processes => {
            P::serve::<SharedMemory>(line, *all)
        }
        Introduction::Assigned(all) => P::serve::<InProcess>(line, *all),
    }
}

/// The whole `main` of a program that is a component.
pub fn main<P: Participant>() -> ExitCode {
    main_of(&P::program(), P::ROLE.name(), run::<P>)
}

/// Runs `component` over standard input and output, or says how the program is meant to be started.
pub fn main_of(
    program: &str,
    role: &str,
    component: impl FnOnce(ControlPipe) -> Result<(), String>,
) -> ExitCode {
    if std::env::var_os(INTERFACE_VARIABLE).is_none() {
        log_line(format_args!(
            "{program} is a component of Tremie runs and cannot run by itself.\n\
             Name this program as `{role}` in the [components] table of a manifest, then:\n\n    \
             tremie run MANIFEST\n"
        ));
        return ExitCode::from(2);
    }
    log_to_standard_error();
    match component(ControlPipe::of_process()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            tracing::error!("{message}");
            ExitCode::FAILURE
        }
    }
}

/// The number of an exit code, for a caller in another language; the standard library keeps it to
/// itself.
pub fn number_of(code: ExitCode) -> u8 {
    (0..=u8::MAX).find(|number| ExitCode::from(*number) == code).unwrap_or(1)
}

/// Writes a line to standard error, which is the run's log. Where nobody reads it any longer, it is
/// lost.
pub fn log_line(text: impl Display) {
    let _ = std::io::stderr().write_all(format!("{text}\n").as_bytes());
}

/// One JSON document a line on standard error, which the orchestrator puts into the run's log.
fn log_to_standard_error() {
    let _ = tracing_subscriber::fmt()
        .json()
        .flatten_event(true)
        .without_time()
        .with_target(false)
        .with_writer(std::io::stderr)
        // It would say so on standard error, and panic there.
        .log_internal_errors(false)
        .try_init();
}
