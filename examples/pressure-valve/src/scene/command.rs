//! `tremie scene pressure-valve FOLDER` and `safety-valve`: parts and manifests from numbers.

use super::{Closure, Dimensions, Grains, Resting, Ring, Steady, Working};
use clap::{ArgMatches, Args, FromArgMatches};
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use tremie_geometry::{GeometryError, Mesh};
use tremie_messages::scene::Geometry;
use tremie_messages::units::Length;
use tremie_results::{CommandError, key_value};
use tremie_rubber_table::make::make;
use tremie_rubber_table::spec::Spec;
use tremie_rubber_table::table::Table;

/// Arguments of `tremie scene pressure-valve` and `safety-valve`.
#[derive(Debug, Args)]
pub struct SceneArgs {
    /// Folder for the parts and manifests
    pub folder: PathBuf,
    /// Change a dimension, as bore_radius="4.75 mm"; dimensions.toml lists them
    #[arg(long, value_name = "KEY=VALUE", value_parser = key_value)]
    pub set: Vec<(String, String)>,
    /// In the run in which the valve works: wider cells, a slower sound, minutes instead of hours
    #[arg(long)]
    pub coarse: bool,
    /// Lift at which the valve is held in held.toml [default: 3.08 mm]
    #[arg(long, value_name = "LENGTH")]
    pub lift: Option<Length>,
    /// Edge of a cell [default: 0.3 mm]
    #[arg(long, value_name = "LENGTH")]
    pub cell: Option<Length>,
}

/// Writes the parts and manifests of a pressure valve; returns a list of the files and some derived
/// numbers.
///
/// # Errors
/// [`CommandError::Input`], if the numbers do not make a valve.
pub fn build_pressure_valve(matches: &ArgMatches) -> Result<String, CommandError> {
    build(matches, Closure::Pressure)
}

/// The same for a safety valve.
///
/// # Errors
/// See [`build_pressure_valve`].
pub fn build_safety_valve(matches: &ArgMatches) -> Result<String, CommandError> {
    build(matches, Closure::Safety)
}

fn build(matches: &ArgMatches, closure: Closure) -> Result<String, CommandError> {
    let arguments = SceneArgs::from_arg_matches(matches).map_err(CommandError::input)?;
    let numbers = numbers(&arguments.set, closure)?;
    let works = working(&arguments, numbers.closure);
    let defaults = Steady::default();
    // The valve is held at a lift of its own, in cells as wide as those of the run in which it
    // works.
    let held =
        Steady { lift: arguments.lift.unwrap_or(defaults.lift), cell: works.cell, ..defaults };
    if held.lift < numbers.lip {
        let (lift, lip) = (held.lift, numbers.lip);
        return Err(CommandError::input(format!(
            "the lift is {lift}, but the rigid ring touches the seat below {lip}, its lip"
        )));
    }
    let specification = super::specification(&numbers);
    // The table before any file: a ring that cannot hold the valve leaves no folder behind.
    let spec = Spec::parse(Path::new("ring.toml"), specification.clone());
    let table = make(&spec.map_err(CommandError::input)?).map_err(CommandError::input)?;
    let rest = rest(&numbers, &works, &table)?;
    let folder = &arguments.folder;
    fs::create_dir_all(folder).map_err(|error| cannot_write(folder, &error))?;
    let numbers_text = toml::to_string(&numbers).expect("plain quantities have a form in TOML");
    write(&folder.join("dimensions.toml"), numbers_text.as_bytes())?;
    write_parts(&numbers, held.cell.0, folder)?;
    let steady = super::held(&numbers, &held, "frame.stl");
    write(&folder.join("held.toml"), steady.as_bytes())?;
    write(&folder.join("ring.toml"), specification.as_bytes())?;
    table.write(&folder.join("ring.json")).map_err(CommandError::input)?;
    let slurry = if arguments.coarse { Grains::coarse(numbers.closure) } else { Grains::default() };
    for (name, grains, ring) in [
        ("manifest.toml", None, Ring::Rubber("ring.json", rest)),
        ("rigid.toml", None, Ring::Rigid),
        ("grains.toml", Some(&slurry), Ring::Rubber("ring.json", rest)),
    ] {
        let working = super::working(&numbers, &works, grains, "frame.stl", ring);
        write(&folder.join(name), working.as_bytes())?;
    }
    Ok(answer(&numbers, folder))
}

/// The ring at rest on its seat.
fn rest(numbers: &Dimensions, works: &Working, table: &Table) -> Result<Resting, CommandError> {
    Resting::of(numbers, works, table).ok_or_else(|| {
        let pressing = works.closing_force(numbers);
        CommandError::input(format!(
            "the ring does not hold {pressing:.1} N, spring and outlet, before it is compressed by its lip, {}, or by three tenths of its height",
            numbers.lip
        ))
    })
}

/// The surfaces of frame, valve and rigid ring.
fn write_parts(numbers: &Dimensions, cell: f64, folder: &Path) -> Result<(), CommandError> {
    let bad = |error: GeometryError| CommandError::input(error);
    // The frame reaches past the openings by more than a cell, so that the domain's faces cut it
    // and are open.
    let frame = super::frame(numbers, 4.0 * cell).map_err(bad)?;
    let turned = |profile| Mesh::of(&Geometry::Revolved { profile }).map_err(bad);
    let meshes = [
        ("frame.stl", frame),
        ("valve.stl", turned(super::steel(numbers))?),
        ("ring.stl", turned(super::ring(numbers))?),
    ];
    for (name, mesh) in &meshes {
        write_stl(&folder.join(name), mesh)?;
    }
    Ok(())
}

/// The run in which the valve works, with the cells of the command line.
fn working(arguments: &SceneArgs, closure: Closure) -> Working {
    let usual = if arguments.coarse { Working::coarse(closure) } else { Working::default() };
    Working { cell: arguments.cell.unwrap_or(usual.cell), ..usual }.closed_by(closure)
}

/// The usual numbers of a closure with those of the command line in place of some.
fn numbers(sets: &[(String, String)], closure: Closure) -> Result<Dimensions, CommandError> {
    let mut table = toml::Table::new();
    let value = toml::Value::try_from(closure).expect("a plain enum has a form in TOML");
    table.insert("closure".into(), value);
    for (key, value) in sets {
        let read = format!("value = {value}").parse::<toml::Table>();
        let read = read.ok().and_then(|mut table| table.remove("value"));
        // Quotes around a quantity may be left out.
        table.insert(key.clone(), read.unwrap_or_else(|| toml::Value::String(value.clone())));
    }
    let numbers: Dimensions = table
        .try_into()
        .map_err(|error: toml::de::Error| CommandError::input(error.message().trim()))?;
    match numbers.misfits() {
        misfits if misfits.is_empty() => Ok(numbers),
        misfits => Err(CommandError::Input(misfits.iter().map(ToString::to_string).collect())),
    }
}

/// Answer: the files written, and numbers derived from the dimensions.
fn answer(numbers: &Dimensions, folder: &Path) -> String {
    format!(
        "frame.stl, valve.stl, ring.stl (in millimetres), dimensions.toml, ring.toml and ring.json (the ring's table) are in {folder}, \
         and manifest.toml, rigid.toml (with a rigid ring), grains.toml (with grains) and held.toml (steady flow, the valve held)\n\
         depth of the cone {:.3} mm, disc {:.3} mm thick, rubber {:.1} mm3, steel {:.1} mm3\n\
         check it with: tremie check {folder}\n",
        1e3 * numbers.cone_depth(),
        1e3 * numbers.disc_thickness(),
        1e9 * numbers.rubber_volume(),
        1e9 * (numbers.moving_mass.0 - numbers.rubber.0 * numbers.rubber_volume())
            / numbers.steel.0,
        folder = folder.display(),
    )
}

fn write_stl(path: &Path, mesh: &Mesh) -> Result<(), CommandError> {
    let file = File::create(path).map_err(|error| cannot_write(path, &error))?;
    let mut file = BufWriter::new(file);
    mesh.write_stl(&mut file, 1e-3).map_err(|error| cannot_write(path, &error))?;
    file.flush().map_err(|error| cannot_write(path, &error))
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), CommandError> {
    fs::write(path, bytes).map_err(|error| cannot_write(path, &error))
}

fn cannot_write(path: &Path, why: &impl std::fmt::Display) -> CommandError {
    CommandError::failed(format!("cannot write {}: {why}", path.display()))
}
