//! Subject: the program under trial, and runs with it.

use super::ConformArgs;
use crate::manifest::{self, Manifest, START_WITHIN};
use crate::outputs::{RunFolder, Summary, WholeCheckpoint};
use crate::run::launch::{ComponentEvent, Launcher, Peer, PeerEvent, Program};
use crate::run::{Execution, Origin, RunCall, Takes, prepare};
use crate::terminal::{Style, Terminal};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicUsize;
use std::sync::mpsc::Receiver;
use std::time::Instant;
use tremie_messages::start::{Hello, Injection, InjectionKind, Reply, Request};
use tremie_messages::units;
use tremie_messages::{INTERFACE_VERSION, Role};

/// The program under trial.
pub struct Subject {
    program: Program,
    /// Role that it takes.
    pub role: Role,
    manifest: Option<PathBuf>,
    /// Its name in the trial's manifest.
    name: String,
}

/// A run with the subject: its summary, and its table of signals.
pub struct Trial {
    /// The run's summary.
    pub summary: Summary,
    /// The text of `signals.csv`.
    pub signals: String,
}

impl Subject {
    /// Finds the program and the role that it takes.
    pub fn find(arguments: &ConformArgs) -> Result<Self, String> {
        let here = std::env::current_dir().map_err(|e| e.to_string())?;
        let program = Program::find(&arguments.program, &here).map_err(|e| e.to_string())?;
        let name = match &program {
            Program::BuiltIn(name) => (*name).to_string(),
            Program::File(file) => file.to_string_lossy().into_owned(),
        };
        let subject = |role| Self {
            program: program.clone(),
            role,
            manifest: arguments.manifest.clone(),
            name: name.clone(),
        };
        // A program that takes several roles is tried as the first of these.
        let tried = || Role::PHYSICS.into_iter().filter(|role| role.rules().tried_beside.is_some());
        let roles: Vec<Role> = match arguments.role.as_deref() {
            None => tried().collect(),
            Some(name) => tried().filter(|role| role.name() == name).collect(),
        };
        if roles.is_empty() {
            let other = arguments.role.as_deref().unwrap_or_default();
            let names: Vec<_> = tried().map(Role::name).collect();
            let names = names.join(" or ");
            return Err(format!("role \"{other}\" cannot be tried; expected {names}"));
        }
        let mut refusals = Vec::new();
        for role in roles {
            let subject = subject(role);
            match subject.describe() {
                Ok(()) => return Ok(subject),
                Err(text) => refusals.push(format!("as {role}: {text}")),
            }
        }
        Err(format!("the program takes no role that can be tried\n  {}", refusals.join("\n  ")))
    }

    /// The component on the other side.
    pub fn opposite(&self) -> &'static str {
        self.role.rules().tried_beside.map_or("", Role::name)
    }

    /// The manifest of a trial, with `sets` laid over it.
    pub fn manifest(&self, sets: &[(&str, &str)]) -> Result<Manifest, String> {
        let mut all = vec![(format!("components.{}", self.role), format!("{:?}", self.name))];
        all.extend(sets.iter().map(|(key, value)| ((*key).to_string(), (*value).to_string())));
        match &self.manifest {
            Some(path) => manifest::load(path, &all),
            None => {
                manifest::parse(Path::new("scene.toml"), include_str!("scene.toml").into(), &all)
            }
        }
        .map_err(|errors| errors.render(false))
    }

    /// Starts the program alone.
    pub fn start(&self) -> Result<(Peer, Receiver<PeerEvent>), String> {
        let (launcher, news) = Launcher::new(false);
        let peer = launcher.start(0, self.role.name(), self.role, (&[], &self.program))?;
        Ok((peer, news))
    }

    /// A hello that the program should accept.
    pub fn hello(&self) -> Result<Hello, String> {
        let manifest = self.manifest(&[])?;
        let component =
            manifest.spec.component(self.role.name()).ok_or("the manifest lacks the role")?;
        Ok(Hello {
            interface: INTERFACE_VERSION,
            run: 1,
            component: component.name.clone(),
            role: self.role,
            scene: manifest.spec.scene.clone(),
            parameters: component.settings.clone(),
            threads: 1,
            output: String::new(),
        })
    }

    /// Starts the program, says `hello`, and returns it with its answer.
    pub fn greet(&self, hello: Hello) -> Result<(Peer, Receiver<PeerEvent>, Reply), String> {
        let (mut peer, news) = self.start()?;
        peer.send(Request::Hello(Box::new(hello)));
        let reply = next_reply(&news)?;
        Ok((peer, news, reply))
    }

    fn describe(&self) -> Result<(), String> {
        match self.greet(self.hello()?)?.2 {
            Reply::Description(_) => Ok(()),
            Reply::Refusal { problems } => {
                Err(problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))
            }
            other => Err(format!("it answered the hello with {other:?}")),
        }
    }

    /// True if the program has a state that checkpoints can keep.
    pub fn keeps_state(&self) -> Result<bool, String> {
        match self.greet(self.hello()?)?.2 {
            Reply::Description(description) => Ok(description.state.is_some()),
            other => Err(format!("it answered the hello with {other:?}")),
        }
    }

    /// Runs the trial's manifest with `sets`, and with `fault` committed by the other side.
    pub fn run(
        &self,
        sets: &[(&str, &str)],
        fault: Option<(InjectionKind, u64)>,
    ) -> Result<Trial, String> {
        let home = tempfile::tempdir().map_err(|e| e.to_string())?;
        let mut out = RunFolder::claim(home.path()).map_err(|e| e.to_string())?;
        self.run_in(&mut out, sets, fault, None)
    }

    /// Runs the trial's manifest until `fault` ends it, and goes on from the newest checkpoint.
    pub fn run_broken(
        &self,
        sets: &[(&str, &str)],
        fault: (InjectionKind, u64),
    ) -> Result<Trial, String> {
        let home = tempfile::tempdir().map_err(|e| e.to_string())?;
        let mut out = RunFolder::claim(home.path()).map_err(|e| e.to_string())?;
        self.run_in(&mut out, sets, Some(fault), None)?;
        let from = WholeCheckpoint::find(out.path(), None).map_err(|e| e.to_string())?;
        let mut out = RunFolder::reclaim(out.path()).map_err(|e| e.to_string())?;
        self.run_in(&mut out, sets, None, Some(&from))
    }

    fn run_in(
        &self,
        out: &mut RunFolder,
        sets: &[(&str, &str)],
        fault: Option<(InjectionKind, u64)>,
        from: Option<&WholeCheckpoint>,
    ) -> Result<Trial, String> {
        let manifest = self.manifest(sets)?;
        let inject = fault
            .map(|(kind, window)| (self.opposite().to_string(), Injection { kind, window }))
            .into_iter()
            .collect();
        let execution = Execution { inject, ..Execution::default() };
        let programs = self.manifest.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
        let text = |error: crate::run::RunError| match error {
            crate::run::RunError::Input(problems) => manifest.source.render(&problems, false),
            other => other.to_string(),
        };
        let nobody = AtomicUsize::new(0);
        let path = out.path().to_path_buf();
        let ended = prepare(&manifest, programs, &path, &execution, &nobody)
            .and_then(|prepared| {
                let mut terminal = Terminal::new(Style::Silent);
                prepared.execute(RunCall {
                    manifest: &manifest,
                    out,
                    execution: &execution,
                    terminal: &mut terminal,
                    interrupts: &nobody,
                    programs,
                    from: from.map(|checkpoint| Origin { checkpoint, takes: Takes::Outputs }),
                })
            })
            .map_err(text)?;
        let signals = std::fs::read_to_string(path.join(crate::outputs::SIGNALS))
            .map_err(|e| e.to_string())?;
        Ok(Trial { summary: ended.close(), signals })
    }
}

/// The next reply of the program.
pub fn next_reply(news: &Receiver<PeerEvent>) -> Result<Reply, String> {
    let deadline = Instant::now() + units::wait(START_WITHIN);
    let mut words = String::new();
    while Instant::now() < deadline {
        // One deadline for all lines: a program that only writes logs must not stop the clock.
        let left = deadline.saturating_duration_since(Instant::now());
        match news.recv_timeout(left) {
            Ok((_, ComponentEvent::Reply(reply))) => return Ok(*reply),
            Ok((_, ComponentEvent::Log(text))) => words = text,
            Ok((_, ComponentEvent::Garbage(text))) => {
                return Err(format!("it wrote a line on standard output that is no reply: {text}"));
            }
            Ok((_, ComponentEvent::Closed)) => {
                return Err(format!("it ended without an answer; {words}"));
            }
            Err(_) => break,
        }
    }
    Err(format!("it did not answer within {START_WITHIN} s"))
}
