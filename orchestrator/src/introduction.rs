//! The first half of a run: starting the components and asking each what it is.

use crate::launch::{Launcher, News, Peer, Post, Program};
use crate::manifest::Manifest;
use std::path::Path;
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};
use tremie_messages::start::{Description, Hello, Reply, Request};
use tremie_messages::{INTERFACE_VERSION, Problem};

/// Longest time that a component may take to describe itself, or to get ready.
pub const PATIENCE: Duration = Duration::from_secs(60);

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
                problems.push(match tremie_sdk::parameters::nearest(&missing.name, &known) {
                    Some(near) => problem.help(format!("did you mean \"{near}\"?")),
                    None => {
                        problem.help("build the program first, or give its path from the manifest")
                    }
                });
            }
        }
    }
    if problems.is_empty() { Ok(programs) } else { Err(problems) }
}

/// Starts all components, in the order of the manifest.
///
/// # Errors
/// A problem for the first that cannot be started.
pub fn start_all(
    manifest: &Manifest,
    programs: &[Program],
    launcher: &Launcher,
) -> Result<Vec<Peer>, Vec<Problem>> {
    let start = |(index, (spec, program)): (usize, (&crate::manifest::ComponentSpec, &Program))| {
        launcher
            .start(index, &spec.name, spec.role, program)
            .map_err(|text| vec![Problem::new(spec.key(), text)])
    };
    manifest.spec.components.iter().zip(programs).enumerate().map(start).collect()
}

/// Says hello to all components and collects their descriptions.
///
/// # Errors
/// Every problem of every component, with keys of the manifest.
pub fn introduce(
    manifest: &Manifest,
    peers: &mut [Peer],
    news: &Receiver<Post>,
    run: u64,
    output: &Path,
    early: &mut EarlyLog,
) -> Result<Vec<Description>, Vec<Problem>> {
    let cores = std::thread::available_parallelism().map_or(1, |n| n.get() as u32);
    for (peer, spec) in peers.iter_mut().zip(&manifest.spec.components) {
        peer.send(Request::Hello(Box::new(Hello {
            interface: INTERFACE_VERSION,
            run,
            component: spec.name.clone(),
            role: spec.role,
            scene: manifest.spec.scene.clone(),
            parameters: spec.settings.clone(),
            threads: spec.threads_of(cores),
            output: output.to_string_lossy().into_owned(),
        })));
    }
    let mut descriptions: Vec<Option<Description>> = vec![None; peers.len()];
    let mut problems = Vec::new();
    let answers = collect(peers, news, early, |index, reply| match reply {
        Reply::Description(description) if description.interface == INTERFACE_VERSION => {
            descriptions[index] = Some(*description);
            Ok(true)
        }
        Reply::Description(description) => Err(format!(
            "it speaks interface version {}, this orchestrator version {INTERFACE_VERSION}; build both from the same version of Tremie",
            description.interface
        )),
        Reply::Refusal { problems: found } => {
            problems.extend(manifest.absolute(&manifest.spec.components[index].name, found));
            Ok(true)
        }
        other => Err(format!("it answered the hello with {other:?}")),
    });
    for (index, text) in answers {
        problems.push(Problem::new(manifest.spec.components[index].key(), text));
    }
    let described: Vec<_> = descriptions.into_iter().flatten().collect();
    if problems.is_empty() && described.len() == peers.len() {
        Ok(described)
    } else {
        Err(problems)
    }
}

/// Lines that components wrote to standard error before windows go by: component, text.
pub type EarlyLog = Vec<(usize, String)>;

/// Waits until `take` has said `true` to a reply of each peer. Returns, for each that failed, why.
pub fn collect(
    peers: &mut [Peer],
    news: &Receiver<Post>,
    early: &mut EarlyLog,
    mut take: impl FnMut(usize, Reply) -> Result<bool, String>,
) -> Vec<(usize, String)> {
    let mut open: Vec<bool> = vec![true; peers.len()];
    let mut said: Vec<String> = vec![String::new(); peers.len()];
    let mut failed = Vec::new();
    let deadline = Instant::now() + PATIENCE;
    while open.iter().any(|open| *open) {
        let left = deadline.saturating_duration_since(Instant::now());
        let Ok((index, news)) = news.recv_timeout(left) else {
            let late =
                |(index, _)| (index, format!("it did not answer within {} s", PATIENCE.as_secs()));
            failed.extend(open.iter().enumerate().filter(|(_, open)| **open).map(late));
            return failed;
        };
        let outcome = match news {
            News::Reply(reply) => take(index, *reply),
            News::Log(text) => {
                said[index].clone_from(&text);
                early.push((index, text));
                Ok(false)
            }
            News::Garbage(text) => Err(format!(
                "it wrote a line on standard output that is no reply, which belongs on standard error: {text}"
            )),
            News::Closed => {
                peers[index].closed = true;
                let last = Some(&said[index]).filter(|text| !text.is_empty());
                let words = last.map_or(String::new(), |text| format!("; its last words: {text}"));
                let how = peers[index].end(Duration::from_secs(1));
                // One that has answered with a refusal leaves in good order.
                if !open[index] && (how == "exited with code 0" || how == "ended") {
                    continue;
                }
                Err(format!("it {how}{words}"))
            }
        };
        match outcome {
            Ok(answered) if open[index] => open[index] = !answered,
            // Also of one that had answered: it may end while others are still at it.
            Err(text) if !failed.iter().any(|(other, _)| *other == index) => {
                open[index] = false;
                failed.push((index, text));
            }
            _ => {}
        }
    }
    failed
}
