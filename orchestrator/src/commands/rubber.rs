//! `tremie rubber`: tables of seals.

use super::WRONG_INPUT;
use crate::cli::{ImportArgs, MakeTableArgs, RubberCommand};
use crate::standard::{answer, complain};
use std::fmt::Display;
use std::fs;
use std::path::Path;
use std::process::ExitCode;
use tremie_rubber_table::make::make;
use tremie_rubber_table::picture;
use tremie_rubber_table::spec::Spec;
use tremie_rubber_table::table::{Table, import_csv, import_frd};

/// `tremie rubber ...`.
pub fn rubber(command: &RubberCommand) -> ExitCode {
    let done = match command {
        RubberCommand::MakeTable(arguments) => make_table(arguments),
        RubberCommand::Import(arguments) => import(arguments),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err((code, text)) => {
            complain(text.trim_end());
            ExitCode::from(code)
        }
    }
}

/// An exit code and what to say.
type Failed = (u8, String);

fn wrong(error: impl Display) -> Failed {
    (WRONG_INPUT, format!("error: {error}"))
}

fn failed(error: impl Display) -> Failed {
    (1, format!("error: {error}"))
}

fn make_table(arguments: &MakeTableArgs) -> Result<(), Failed> {
    let spec = Spec::read(&arguments.spec).map_err(|errors| (WRONG_INPUT, errors.to_string()))?;
    let table = make(&spec).map_err(failed)?;
    let out = arguments.out.clone().unwrap_or_else(|| arguments.spec.with_extension("json"));
    keep(&table, &out)
}

fn import(arguments: &ImportArgs) -> Result<(), Failed> {
    let from = &arguments.results;
    let table = if from.is_dir() {
        import_csv::read(from).map_err(wrong)?
    } else {
        let name = from.display();
        let text = fs::read_to_string(from).map_err(|error| wrong(format!("{name}: {error}")))?;
        let options = import_frd::Options {
            length: arguments.length.0,
            force: arguments.force,
            seat: None,
            reach: None,
        };
        import_frd::read(&text, &options).map_err(|error| wrong(format!("{name}: {error}")))?
    };
    let out = arguments.out.clone().unwrap_or_else(|| from.with_extension("json"));
    keep(&table, &out)
}

/// Writes a table and its pictures, and says what it holds.
fn keep(table: &Table, out: &Path) -> Result<(), Failed> {
    let (force, shapes) = (out.with_extension("force.svg"), out.with_extension("shapes.svg"));
    table.write(out).map_err(failed)?;
    picture::draw_force(table, &force).map_err(failed)?;
    picture::draw_shapes(table, &shapes).map_err(failed)?;
    let last = table.frames() - 1;
    answer(format_args!(
        "{}: {} frames up to {:.4} mm, where the seal presses with {:.4} N",
        out.display(),
        table.frames(),
        1e3 * table.last_compression(),
        table.contents().forces[last]
    ));
    answer(format_args!("pictures: {}, {}", force.display(), shapes.display()));
    Ok(())
}
