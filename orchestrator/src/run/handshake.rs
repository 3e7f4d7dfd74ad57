//! Handshake: the components are started, and each is asked for its description.

use crate::manifest::{ComponentSpec, Manifest};
use crate::run::ask_all::{Round, Unanswered};
use crate::run::launch::{Launcher, Peer, Program};
use serde_json::{Map, Value};
use std::path::Path;
use tremie_messages::start::{Description, Hello, Reply, Request};
use tremie_messages::{INTERFACE_VERSION, Problem};

/// Reason why there are no descriptions.
#[derive(Debug)]
pub enum NotIntroduced {
    /// The user asked for the end.
    Interrupted,
    /// Every problem of every component, with keys of the manifest.
    Problems(Vec<Problem>),
}

/// Finds the programs of all components of the manifest.
///
/// # Errors
/// A problem for each that is missing.
pub fn find_programs(manifest: &Manifest, folder: &Path) -> Result<Vec<Program>, Vec<Problem>> {
    let mut programs = Vec::new();
    let mut problems = Vec::new();
    for component in &manifest.spec.components {
        match Program::find(&component.program, folder) {
            Ok(program) => programs.push(program),
            Err(missing) => {
                let known: Vec<_> = crate::registry::BUILT_IN.iter().map(|b| b.name).collect();
                let problem = Problem::new(component.key(), missing.to_string());
                let how = crate::registry::how_to_build(&missing.name);
                let near = tremie_sdk::parameters::nearest(&missing.name, &known);
                problems.push(match near {
                    _ if let Some(how) = how => problem.help(how),
                    Some(near) => problem.help(format!("did you mean \"{near}\"?")),
                    None if Path::new(&missing.name).is_file() => {
                        let here = std::path::absolute(&missing.name).unwrap_or_default();
                        problem.help(format!(
                            "paths count from the manifest's folder; here it is {:?}",
                            here.display().to_string()
                        ))
                    }
                    None => {
                        problem.help("build the program first, or give its path from the manifest")
                    }
                });
            }
        }
    }
    if problems.is_empty() { Ok(programs) } else { Err(problems) }
}

/// Starts all components, in the order of the manifest; with `is_unlaunched` each as one process, without its
/// launcher.
///
/// # Errors
/// A problem for the first that cannot be started.
pub fn start_all(
    manifest: &Manifest,
    programs: &[Program],
    launcher: &Launcher,
    is_unlaunched: bool,
) -> Result<Vec<Peer>, Vec<Problem>> {
    let start = |(index, (spec, program)): (usize, (&ComponentSpec, &Program))| {
        let mut launch = launch_of(spec, program)?;
        if is_unlaunched {
            launch.clear();
        }
        launcher
            .start(index, &spec.name, spec.role, (&launch, program))
            .map_err(|text| vec![Problem::new(spec.key(), text)])
    };
    manifest.spec.components.iter().zip(programs).enumerate().map(start).collect()
}

/// Setting of a program that says how it is launched, and is not the program's own.
pub const LAUNCH: &str = "launch";

/// The words before the program of a component, by which it is launched: none for most.
fn launch_of(spec: &ComponentSpec, program: &Program) -> Result<Vec<String>, Vec<Problem>> {
    if let (Program::BuiltIn(name), true) = (program, spec.settings.contains_key(LAUNCH)) {
        let text = format!("{name} is one process, expected no launcher of many");
        return Err(vec![Problem::new(key_of_launch(spec), text)]);
    }
    launch_words(spec)
}

fn key_of_launch(spec: &ComponentSpec) -> String {
    format!("settings.{}.{LAUNCH}", spec.stem())
}

/// The words before the program of a component, whatever program that is.
///
/// # Errors
/// If the setting is none.
pub fn launch_words(spec: &ComponentSpec) -> Result<Vec<String>, Vec<Problem>> {
    let Some(value) = spec.settings.get(LAUNCH) else { return Ok(Vec::new()) };
    let problem = |text: &str| vec![Problem::new(key_of_launch(spec), text)];
    let words: Result<Vec<String>, _> = serde_json::from_value(value.clone());
    match words {
        Ok(words) if !words.is_empty() => Ok(words),
        _ => {
            Err(problem(&format!("found {value}, expected words as [\"mpiexec\", \"-n\", \"4\"]")))
        }
    }
}

/// Says hello to all components and collects their descriptions.
///
/// # Errors
/// See [`NotIntroduced`].
pub fn introduce(
    manifest: &Manifest,
    round: &mut Round,
    run: u64,
    output: &Path,
) -> Result<Vec<Description>, NotIntroduced> {
    for (peer, hello) in round.peers.iter_mut().zip(hellos(manifest, run, output)) {
        peer.send(Request::Hello(Box::new(hello)));
    }
    let mut descriptions: Vec<Option<Description>> = vec![None; round.peers.len()];
    let mut problems = Vec::new();
    let answered = round.collect(|index, reply| match reply {
        Reply::Description(description) if description.interface == INTERFACE_VERSION => {
            descriptions[index] = Some(*description);
            Ok(())
        }
        Reply::Description(description) => Err(format!(
            "it speaks interface version {}, this orchestrator version {INTERFACE_VERSION}; build both from the same version of Tremie",
            description.interface
        )),
        Reply::Refusal { problems: found } => {
            // Fluid and grains find the same fault of a part: it is reported once.
            for problem in manifest.absolute(&manifest.spec.components[index].name, found) {
                if !problems.contains(&problem) {
                    problems.push(problem);
                }
            }
            Ok(())
        }
        other => Err(format!("it answered the hello with {other:?}")),
    });
    match answered {
        Ok(()) => {}
        Err(Unanswered::Interrupted) => return Err(NotIntroduced::Interrupted),
        Err(Unanswered::Failed(failed)) => problems.extend(
            failed.into_iter().map(|(i, why)| Problem::new(manifest.spec.components[i].key(), why)),
        ),
    }
    let described: Vec<_> = descriptions.into_iter().flatten().collect();
    if problems.is_empty() && described.len() == round.peers.len() {
        Ok(described)
    } else {
        Err(NotIntroduced::Problems(problems))
    }
}

/// Cores that this program may use.
pub fn cores() -> u32 {
    std::thread::available_parallelism().map_or(1, |n| n.get() as u32)
}

/// The settings that are the program's own.
fn own_settings(spec: &ComponentSpec) -> Map<String, Value> {
    let mut settings = spec.settings.clone();
    settings.remove(LAUNCH);
    settings
}

/// A hello for each component of the manifest, in its order.
fn hellos(manifest: &Manifest, run: u64, output: &Path) -> impl Iterator<Item = Hello> {
    let cores = cores();
    manifest.spec.components.iter().map(move |spec| Hello {
        interface: INTERFACE_VERSION,
        run,
        component: spec.name.clone(),
        role: spec.role,
        scene: manifest.spec.scene.clone(),
        parameters: own_settings(spec),
        threads: spec.threads_of(cores),
        output: output.to_string_lossy().into_owned(),
    })
}
