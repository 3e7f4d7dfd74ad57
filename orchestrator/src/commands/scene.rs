//! `tremie scene`: parts and a manifest from numbers.

use super::WRONG_INPUT;
use crate::cli::{SceneArgs, SceneName};
use crate::scenes::pressure_valve::{
    self as valve, Closure, Dimensions, Grains, Resting, Ring, Steady, Working,
};
use crate::standard::{answer, complain};
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use tremie_geometry::{GeometryError, Mesh};
use tremie_messages::scene::Geometry;
use tremie_rubber_table::make::make;
use tremie_rubber_table::spec::Spec;

/// `tremie scene NAME FOLDER`.
pub fn scene(arguments: &SceneArgs) -> ExitCode {
    let SceneName::PressureValve = arguments.name;
    match write_valve(arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(SceneError::Numbers(lines)) => {
            for line in lines {
                complain(format_args!("error: {line}"));
            }
            ExitCode::from(WRONG_INPUT)
        }
        Err(error) => {
            complain(format_args!("error: {error}"));
            ExitCode::FAILURE
        }
    }
}

/// Why no scene was written.
#[derive(Debug, thiserror::Error)]
enum SceneError {
    #[error("{}", .0.join("; "))]
    Numbers(Vec<String>),
    #[error("cannot write {}: {why}", path.display())]
    Write { path: PathBuf, why: String },
}

fn write_valve(arguments: &SceneArgs) -> Result<(), SceneError> {
    let numbers = numbers(&arguments.set)?;
    let misfits = numbers.misfits();
    if !misfits.is_empty() {
        return Err(SceneError::Numbers(misfits.iter().map(ToString::to_string).collect()));
    }
    let defaults = Steady::default();
    let works = working(arguments, numbers.closure);
    let run =
        Steady { lift: arguments.lift.unwrap_or(defaults.lift), cell: works.cell, ..defaults };
    if run.lift < numbers.lip {
        let (lift, lip) = (run.lift, numbers.lip);
        let line =
            format!("the lift is {lift}, but the rigid ring touches the seat below {lip}, its lip");
        return Err(SceneError::Numbers(vec![line]));
    }
    let specification = valve::specification(&numbers);
    let wrong = |error: &dyn std::error::Error| SceneError::Numbers(vec![error.to_string()]);
    let spec = Spec::parse(Path::new("ring.toml"), specification.clone());
    let table = make(&spec.map_err(|error| wrong(&error))?).map_err(|error| wrong(&error))?;
    let rest = Resting::of(&numbers, &works, &table).ok_or_else(|| {
        let pressing = works.closing_force(&numbers);
        let line = format!(
            "the ring does not hold {pressing:.1} N, spring and outlet, before it is compressed by its lip, {}, or by three tenths of its height",
            numbers.lip
        );
        SceneError::Numbers(vec![line])
    })?;
    let folder = &arguments.folder;
    fs::create_dir_all(folder).map_err(|error| cannot_write(folder, &error))?;
    let numbers_text = toml::to_string(&numbers).expect("plain quantities have a form in TOML");
    write(&folder.join("dimensions.toml"), numbers_text.as_bytes())?;
    // Past the openings by more than a cell, so that the domain's faces cut the space.
    let bad = |error: GeometryError| SceneError::Numbers(vec![error.to_string()]);
    let frame = valve::frame(&numbers, 4.0 * run.cell.0).map_err(bad)?;
    let turned = |profile| Mesh::of(&Geometry::Revolved { profile }).map_err(bad);
    let meshes = [
        ("frame.stl", frame),
        ("valve.stl", turned(valve::steel(&numbers))?),
        ("ring.stl", turned(valve::ring(&numbers))?),
    ];
    for (name, mesh) in &meshes {
        write_stl(&folder.join(name), mesh)?;
    }
    let held = valve::held(&numbers, &run, "frame.stl");
    write(&folder.join("held.toml"), held.as_bytes())?;
    write(&folder.join("ring.toml"), specification.as_bytes())?;
    table.write(&folder.join("ring.json")).map_err(|error| wrong(&error))?;
    let slurry = if arguments.coarse { Grains::coarse() } else { Grains::default() };
    for (name, grains, ring) in [
        ("manifest.toml", None, Ring::Rubber("ring.json", rest)),
        ("rigid.toml", None, Ring::Rigid),
        ("grains.toml", Some(&slurry), Ring::Rubber("ring.json", rest)),
    ] {
        let working = valve::working(&numbers, &works, grains, "frame.stl", ring);
        write(&folder.join(name), working.as_bytes())?;
    }
    tell(&numbers, folder);
    Ok(())
}

/// The run in which the valve works, with the cells of the command line.
fn working(arguments: &SceneArgs, closure: Closure) -> Working {
    let usual = if arguments.coarse { Working::coarse() } else { Working::default() };
    Working { cell: arguments.cell.unwrap_or(usual.cell), ..usual }.closed_by(closure)
}

/// The usual numbers with those of the command line in place of some.
fn numbers(sets: &[(String, String)]) -> Result<Dimensions, SceneError> {
    let mut table = toml::Table::new();
    for (key, value) in sets {
        let read = format!("value = {value}").parse::<toml::Table>();
        let read = read.ok().and_then(|mut table| table.remove("value"));
        // Quotes around a quantity may be left out.
        table.insert(key.clone(), read.unwrap_or_else(|| toml::Value::String(value.clone())));
    }
    table.try_into().map_err(|error: toml::de::Error| {
        SceneError::Numbers(vec![error.message().trim().to_string()])
    })
}

fn tell(numbers: &Dimensions, folder: &Path) {
    answer(format_args!(
        "frame.stl, valve.stl, ring.stl (in millimetres), dimensions.toml, ring.toml and ring.json (the ring's table) are in {}, \
         and manifest.toml, rigid.toml (with a rigid ring), grains.toml (with grains) and held.toml (steady flow, the valve held)",
        folder.display()
    ));
    answer(format_args!(
        "depth of the cone {:.3} mm, disc {:.3} mm thick, rubber {:.1} mm3, steel {:.1} mm3",
        1e3 * numbers.cone_depth(),
        1e3 * numbers.disc_thickness(),
        1e9 * numbers.rubber_volume(),
        1e9 * (numbers.moving_mass.0 - numbers.rubber.0 * numbers.rubber_volume())
            / numbers.steel.0,
    ));
    answer(format_args!("check it with: tremie check {}", folder.display()));
}

fn write_stl(path: &Path, mesh: &Mesh) -> Result<(), SceneError> {
    let file = File::create(path).map_err(|error| cannot_write(path, &error))?;
    let mut file = BufWriter::new(file);
    mesh.write_stl(&mut file, 1e-3).map_err(|error| cannot_write(path, &error))?;
    file.flush().map_err(|error| cannot_write(path, &error))
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), SceneError> {
    fs::write(path, bytes).map_err(|error| cannot_write(path, &error))
}

fn cannot_write(path: &Path, why: &impl ToString) -> SceneError {
    SceneError::Write { path: path.into(), why: why.to_string() }
}
