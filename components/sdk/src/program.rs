//! From a solver to a program: what a component's `main` calls.

use crate::fluid::FluidPlayer;
use crate::grains::GrainsPlayer;
use crate::impulse::Impulse;
use crate::line::ControlPipe;
use crate::observe::serve_observer;
use crate::observer::Observer;
use crate::roles::{Fluid, Grains, Rubber, check_polyhedra, check_surfaces};
use crate::rubber::RubberPlayer;
use crate::serve::{Introduction, introduce, serve};
use crate::setup::Setup;
use std::fmt::Display;
use std::io::Write;
use std::process::ExitCode;
use tremie_channels::{InProcess, SharedMemory};
use tremie_messages::Role;
use tremie_messages::start::{Description, INTERFACE_VARIABLE};

/// Takes part in a run as its fluid, over `line`.
///
/// # Errors
/// A sentence for standard error.
pub fn run_fluid<F: Fluid>(mut line: ControlPipe) -> Result<(), String> {
    let describe = |setup: &Setup| {
        check_surfaces(setup, F::PROGRAM, F::TAKES_SURFACES)?;
        check_polyhedra(setup, F::PROGRAM, F::TAKES_POLYHEDRA)?;
        let described = Description { ports: F::TELLS_PORTS, ..F::describe(setup)? };
        Ok(Impulse::announce(described, "impulse_delivered"))
    };
    match introduce(&mut line, Role::Fluid, F::PROGRAM, describe)? {
        Introduction::Dismissed => Ok(()),
        Introduction::Assigned(all) if all.1.transport.between_processes => {
            serve::<SharedMemory, FluidPlayer<SharedMemory, F>>(line, *all)
        }
        Introduction::Assigned(all) => serve::<InProcess, FluidPlayer<InProcess, F>>(line, *all),
    }
}

/// Takes part in a run as its grains, over `line`.
///
/// # Errors
/// A sentence for standard error.
pub fn run_grains<G: Grains>(mut line: ControlPipe) -> Result<(), String> {
    let describe = |setup: &Setup| {
        check_surfaces(setup, G::PROGRAM, G::TAKES_SURFACES)?;
        check_polyhedra(setup, G::PROGRAM, G::TAKES_POLYHEDRA)?;
        let described = Description { ports: G::TAKES_PORTS, ..G::describe(setup)? };
        Ok(Impulse::announce(described, "impulse_received"))
    };
    match introduce(&mut line, Role::Grains, G::PROGRAM, describe)? {
        Introduction::Dismissed => Ok(()),
        Introduction::Assigned(all) if all.1.transport.between_processes => {
            serve::<SharedMemory, GrainsPlayer<SharedMemory, G>>(line, *all)
        }
        Introduction::Assigned(all) => serve::<InProcess, GrainsPlayer<InProcess, G>>(line, *all),
    }
}

/// Takes part in a run as its rubber, over `line`.
///
/// # Errors
/// A sentence for standard error.
pub fn run_rubber<R: Rubber>(mut line: ControlPipe) -> Result<(), String> {
    match introduce(&mut line, Role::Rubber, R::PROGRAM, R::describe)? {
        Introduction::Dismissed => Ok(()),
        Introduction::Assigned(all) if all.1.transport.between_processes => {
            serve::<SharedMemory, RubberPlayer<SharedMemory, R>>(line, *all)
        }
        Introduction::Assigned(all) => serve::<InProcess, RubberPlayer<InProcess, R>>(line, *all),
    }
}

/// Watches a run, over `line`.
///
/// # Errors
/// A sentence for standard error.
pub fn run_observer<O: Observer>(mut line: ControlPipe) -> Result<(), String> {
    match introduce(&mut line, Role::Observer, O::PROGRAM, O::describe)? {
        Introduction::Dismissed => Ok(()),
        Introduction::Assigned(all) if all.1.transport.between_processes => {
            serve_observer::<SharedMemory, O>(line, *all)
        }
        Introduction::Assigned(all) => serve_observer::<InProcess, O>(line, *all),
    }
}

/// The whole `main` of a program that is a fluid.
pub fn main_fluid<F: Fluid>() -> ExitCode {
    main_of(F::PROGRAM, "fluid", run_fluid::<F>)
}

/// The whole `main` of a program that is grains.
pub fn main_grains<G: Grains>() -> ExitCode {
    main_of(G::PROGRAM, "grains", run_grains::<G>)
}

/// The whole `main` of a program that is rubber.
pub fn main_rubber<R: Rubber>() -> ExitCode {
    main_of(R::PROGRAM, "rubber", run_rubber::<R>)
}

/// The whole `main` of a program that is an observer.
pub fn main_observer<O: Observer>() -> ExitCode {
    main_of(O::PROGRAM, "observer", run_observer::<O>)
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

/// Writes a line to standard error, which is the run's log. Where nobody reads it any longer, it is lost.
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
