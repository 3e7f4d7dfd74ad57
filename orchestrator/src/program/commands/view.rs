//! `tremie view OUT`: opens a finished run.

use super::INTERRUPTED;
use super::carry_out::viewer_settings;
use super::interrupts::count_interrupts;
use crate::outputs::RECORDING;
use crate::program::cli::{View, ViewArgs};
use crate::registry::{Recording, Viewer};
use crate::run::RunError;
use crate::terminal::standard::complain;
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use std::time::Duration;
use tremie_sdk::Observer;

/// `tremie view OUT`: plays the run's recording to the very viewer that watches runs live.
pub fn view(arguments: &ViewArgs) -> ExitCode {
    match show(arguments) {
        Ok(code) => code,
        Err(text) => {
            complain(format_args!("error: {text}"));
            ExitCode::FAILURE
        }
    }
}

fn show(arguments: &ViewArgs) -> Result<ExitCode, String> {
    let text = |error: &dyn std::fmt::Display| error.to_string();
    let Some(settings) = viewer_settings(&arguments.view) else {
        return Err("nothing to do with --view none".into());
    };
    let file = arguments.out.join(RECORDING);
    let recording = Recording::open(&file).map_err(|error| {
        format!(
            "{}: {error}\nOUT is the folder of a run that was recorded (outputs.record)",
            file.display()
        )
    })?;
    let setup = recording.setup("viewer", &arguments.out, settings);
    let interrupts = count_interrupts().map_err(|error| text(&RunError::Signals(error)))?;
    let wanted = || interrupts.load(Ordering::Relaxed) == 0;
    let mut viewer = Viewer::open(&setup).map_err(|error| text(&error))?;
    let end = recording.replay_while(&mut viewer, wanted).map_err(|error| text(&error))?;
    let note = viewer.close(end.last_common_window).map_err(|error| text(&error))?;
    if !wanted() {
        complain(format_args!("interrupted before the end of the recording; {note}"));
        return Ok(ExitCode::from(INTERRUPTED));
    }
    if !end.complete {
        let (window, time) = (end.last_common_window, end.time);
        complain(format_args!(
            "warning: {} is cut off or damaged: shown up to window {window}, {time} s",
            file.display()
        ));
    }
    complain(note);
    // This process serves the page.
    if arguments.view == View::Web {
        complain("the viewer stays up; Ctrl-C ends it");
        while wanted() {
            std::thread::sleep(Duration::from_millis(50));
        }
    }
    Ok(ExitCode::SUCCESS)
}
