//! `tremie rubber`: tables of seals.

use crate::import::{csv, frd};
use crate::make::make;
use crate::picture;
use crate::spec::Spec;
use crate::table::Table;
use clap::{ArgMatches, Args, FromArgMatches, Subcommand};
use std::fs;
use std::path::{Path, PathBuf};
use tremie_messages::units::Length;
use tremie_results::CommandError;

/// Tables of rubber seals.
#[derive(Debug, Subcommand)]
pub enum RubberCommand {
    /// Compress a seal by finite elements, and keep its force and shapes.
    MakeTable(MakeTableArgs),
    /// Make a table of another program's results.
    Import(ImportArgs),
}

/// Arguments of `tremie rubber make-table`.
#[derive(Debug, Args)]
pub struct MakeTableArgs {
    /// What the seal is: section, rubber, seat (a TOML file)
    pub spec: PathBuf,
    /// Where to write the table; its pictures go beside it [default: SPEC with .json]
    #[arg(short, long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}

/// Arguments of `tremie rubber import`.
#[derive(Debug, Args)]
pub struct ImportArgs {
    /// A CalculiX .frd file, or a folder with frames.csv, vertices.csv and facets.csv
    pub results: PathBuf,
    /// Where to write the table; its pictures go beside it [default: RESULTS with .json]
    #[arg(short, long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Unit of length of the .frd file
    #[arg(long, value_name = "LENGTH", default_value = "1 mm")]
    pub length: Length,
    /// Unit of force of the .frd file, in newtons
    #[arg(long, value_name = "NEWTONS", default_value_t = 1.0)]
    pub force: f64,
}

/// Makes or imports a table, and says what it holds.
///
/// # Errors
/// A specification or results that make no table; a disk that refuses.
pub fn rubber(matches: &ArgMatches) -> Result<String, CommandError> {
    match RubberCommand::from_arg_matches(matches).map_err(CommandError::input)? {
        RubberCommand::MakeTable(arguments) => make_table(&arguments),
        RubberCommand::Import(arguments) => import(&arguments),
    }
}

fn make_table(arguments: &MakeTableArgs) -> Result<String, CommandError> {
    let spec = Spec::read(&arguments.spec)
        .map_err(|errors| CommandError::Explained(errors.to_string()))?;
    let table = make(&spec).map_err(CommandError::failed)?;
    let out = arguments.out.clone().unwrap_or_else(|| arguments.spec.with_extension("json"));
    keep(&table, &out)
}

fn import(arguments: &ImportArgs) -> Result<String, CommandError> {
    let from = &arguments.results;
    let table = if from.is_dir() {
        csv::read(from).map_err(CommandError::input)?
    } else {
        let name = from.display();
        let text = fs::read_to_string(from)
            .map_err(|error| CommandError::input(format!("{name}: {error}")))?;
        let options = frd::Options {
            length: arguments.length.0,
            force: arguments.force,
            seat: None,
            reach: None,
        };
        frd::read(&text, &options)
            .map_err(|error| CommandError::input(format!("{name}: {error}")))?
    };
    let out = arguments.out.clone().unwrap_or_else(|| from.with_extension("json"));
    keep(&table, &out)
}

/// Writes a table and its pictures, and says what it holds.
fn keep(table: &Table, out: &Path) -> Result<String, CommandError> {
    let (force, shapes) = (out.with_extension("force.svg"), out.with_extension("shapes.svg"));
    table.write(out).map_err(CommandError::failed)?;
    picture::draw_force(table, &force).map_err(CommandError::failed)?;
    picture::draw_shapes(table, &shapes).map_err(CommandError::failed)?;
    let last = table.frames() - 1;
    Ok(format!(
        "{}: {} frames up to {:.4} mm, where the seal presses with {:.4} N\npictures: {}, {}\n",
        out.display(),
        table.frames(),
        1e3 * table.last_compression(),
        table.contents().forces[last],
        force.display(),
        shapes.display(),
    ))
}
