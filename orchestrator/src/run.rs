//! A whole run, from a checked manifest to closed outputs.

use crate::ask_all::{Round, Unanswered};
use crate::control::{Control, REPORT_DEPTH};
use crate::handshake::{NotIntroduced, cores, find_programs, introduce, start_all};
use crate::launch::{Launcher, News, Peer, Post, end_all};
use crate::limits;
use crate::manifest::Manifest;
use crate::monitor::{Monitor, Watched};
use crate::outputs::{
    self, ComponentSummary, Ending, OutputError, RunFolder, RunLog, SignalTable, Statistics,
    Summary, Trace,
};
use crate::plan::{self, Plan};
use crate::preflight::{self, Judged, Machine};
use crate::run_loop::{Drive, Driven};
use crate::startup_log::EarlyLog;
use crate::stop_conditions::StopConditions;
use crate::terminal::Terminal;
use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicUsize;
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};
use tremie_channels::memory::{self, NoMemory};
use tremie_channels::sweep::{self, RunPlaces};
use tremie_channels::{ChannelError, ChannelMedium, InProcess, SharedMemory};
use tremie_messages::start::{
    Assignment, Description, Injection, InjectionKind, Reply, Request, Signal, Transport,
};
use tremie_messages::units;
use tremie_messages::{Problem, Role};

/// How long a component polls before it sleeps. Longer than a round trip between two processes
/// (some microseconds), shorter than the time that a wake-up is worth.
const POLL: Duration = Duration::from_micros(200);
/// Longest time that a component which is done may take to close its channels and exit.
const EXIT_GRACE: Duration = Duration::from_secs(2);
/// The same, of components that have not begun.
const QUIT_GRACE: Duration = Duration::from_millis(300);

/// How a run is carried out; nothing of it changes results.
#[derive(Clone, Debug, Default)]
pub struct Execution {
    /// Components as threads of this process.
    pub in_process: bool,
    /// Faults that components shall commit: component and fault.
    pub inject: Vec<(String, Injection)>,
    /// Time that components poll before they sleep, if not the usual one.
    pub poll: Option<Duration>,
    /// Windows of which a trace is written.
    pub trace: Option<RangeInclusive<u64>>,
}

/// Why a run did not begin.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The input is wrong.
    #[error("{} problems in the manifest", .0.len())]
    Input(Vec<Problem>),
    /// An output could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Shared memory could not be set up.
    #[error("cannot set up shared memory: {0}")]
    Channel(#[from] ChannelError),
    /// Shared memory does not do.
    #[error(transparent)]
    Memory(#[from] NoMemory),
    /// The system lets the program have too little of something.
    #[error("{0}")]
    Limit(String),
    /// The operating system refuses a place for the run's bookkeeping.
    #[error("cannot make the run's private folder below /tmp: {0}")]
    Places(std::io::Error),
    /// The operating system refuses word of Ctrl-C.
    #[error("cannot watch for Ctrl-C: {0}")]
    Signals(std::io::Error),
    /// A component did not get ready.
    #[error("{0}")]
    NotReady(String),
    /// The user asked for the end before the first window.
    #[error("interrupted before the first window; no outputs are kept")]
    Interrupted,
}

impl From<NotIntroduced> for RunError {
    fn from(not: NotIntroduced) -> Self {
        match not {
            NotIntroduced::Interrupted => Self::Interrupted,
            NotIntroduced::Problems(problems) => Self::Input(problems),
        }
    }
}

/// A run that has ended. Observers that go on serving do so until this is dropped.
pub struct Ended {
    /// What the summary says.
    pub summary: Summary,
    /// All components; those that were ended are ended.
    peers: Vec<Peer>,
    news: Receiver<Post>,
    _places: Option<RunPlaces>,
}

/// Components that were asked and a plan that fits them.
pub struct Prepared {
    /// The components, in the order of the manifest.
    pub peers: Vec<Peer>,
    /// What they said.
    pub descriptions: Vec<Description>,
    /// What they shall do.
    pub plan: Plan,
    /// What the numbers of the run mean for its results.
    pub findings: Vec<Judged>,
    news: Receiver<Post>,
    early: EarlyLog,
    run: u64,
    /// After the peers: what they use is removed when they have ended.
    places: Option<RunPlaces>,
}

/// Starts the components of `manifest`, asks each what it is, and plans the run.
///
/// `folder` is where programs are looked for first; `output` where observers may write.
///
/// # Errors
/// [`RunError::Input`] with every problem found, or [`RunError::Interrupted`]; all components have
/// ended then.
pub fn prepare(
    manifest: &Manifest,
    folder: &Path,
    output: &Path,
    execution: &Execution,
    interrupts: &AtomicUsize,
) -> Result<Prepared, RunError> {
    check_injections(execution).map_err(RunError::Input)?;
    let programs = find_programs(manifest, folder).map_err(RunError::Input)?;
    let (launcher, news) = Launcher::new(execution.in_process);
    let mut peers = start_all(manifest, &programs, &launcher).map_err(RunError::Input)?;
    let run = random_id();
    let mut early = EarlyLog::default();
    let mut round = Round {
        peers: &mut peers,
        news: &news,
        early: &mut early,
        within: units::wait(manifest.spec.run.start_within),
        interrupts,
    };
    let planned = introduce(manifest, &mut round, run, output).map_err(RunError::from).and_then(
        |descriptions| Ok((make_plan(manifest, &peers, &descriptions, execution)?, descriptions)),
    );
    match planned {
        Ok((plan, descriptions)) => {
            let mut machine = Machine::ask(output);
            if execution.in_process {
                // Threads share what they have anyway.
                machine.shared = None;
            }
            let findings = preflight::examine(&manifest.spec, &plan, &descriptions, &machine);
            Ok(Prepared { peers, descriptions, plan, findings, news, early, run, places: None })
        }
        Err(error) => {
            end_all(&mut peers, QUIT_GRACE);
            Err(error)
        }
    }
}

fn make_plan(
    manifest: &Manifest,
    peers: &[Peer],
    descriptions: &[Description],
    execution: &Execution,
) -> Result<Plan, RunError> {
    let names = peers.iter().map(|peer| peer.name.clone());
    let named: Vec<_> = names.zip(descriptions.iter().cloned()).collect();
    let options = plan::Options { injections: execution.inject.clone() };
    plan::make(&manifest.spec, &named, &options).map_err(RunError::Input)
}

/// Faults of a process cannot be committed by a thread: they would end or hold up this program.
fn check_injections(execution: &Execution) -> Result<(), Vec<Problem>> {
    use InjectionKind::{Exit, Hang, Kill};
    let of_process = |kind| execution.in_process && matches!(kind, Exit | Hang | Kill);
    match execution.inject.iter().find(|(_, injection)| of_process(injection.kind)) {
        Some((name, _)) => {
            let text = format!("{name} is no process of its own in this run");
            Err(vec![Problem::new("--inject", text).help("leave out --in-process")])
        }
        None => Ok(()),
    }
}

/// A number that no other run on this machine has: the standard library keys its hashers at random.
fn random_id() -> u64 {
    use std::hash::{BuildHasher, Hasher};
    std::hash::RandomState::new().build_hasher().finish()
}

impl Prepared {
    /// Tells the components that nothing more is wanted.
    pub fn dismiss(mut self) {
        end_all(&mut self.peers, EXIT_GRACE);
    }

    /// Whether the machine has what the run needs of it: shared memory, open files.
    ///
    /// # Errors
    /// What it lacks, with both numbers.
    pub fn fits(&self, execution: &Execution) -> Result<(), RunError> {
        if !execution.in_process {
            memory::provide(&sweep::prefix_of(self.run), self.plan.shared_memory())?;
            limits::check_file_size(&self.plan).map_err(RunError::Limit)?;
        }
        limits::check_open_files(&self.plan, execution.in_process).map_err(RunError::Limit)
    }

    /// Carries the run out and writes its outputs into `out`.
    ///
    /// # Errors
    /// Anything that keeps the run from beginning; all components have ended then. A fault of a component or a disk
    /// that takes no more is no error of this function: the run then has ended with that fault.
    pub fn execute(
        self,
        manifest: &Manifest,
        out: &mut RunFolder,
        execution: &Execution,
        terminal: &mut Terminal,
        interrupts: &AtomicUsize,
    ) -> Result<Ended, RunError> {
        if execution.in_process {
            self.execute_between::<InProcess>(manifest, out, execution, terminal, interrupts)
        } else {
            self.execute_between::<SharedMemory>(manifest, out, execution, terminal, interrupts)
        }
    }

    fn execute_between<S: ChannelMedium>(
        mut self,
        manifest: &Manifest,
        out: &mut RunFolder,
        execution: &Execution,
        terminal: &mut Terminal,
        interrupts: &AtomicUsize,
    ) -> Result<Ended, RunError> {
        self.fits(execution)?;
        let prefix = sweep::prefix_of(self.run);
        if !execution.in_process {
            limits::explain_bus_errors();
        }
        // Files first: a disk that refuses should not cost a started run.
        let at = |name: &str| out.file(name);
        let spec = &manifest.spec;
        let names = self.signal_names();
        out.reserve(names.len())?;
        let every = self.plan.signal_rows_every;
        let table = SignalTable::create(&at(outputs::SIGNALS), self.plan.clock, every, &names)?;
        let log = RunLog::create(&at(outputs::LOG))?;
        write_file(&at(outputs::MANIFEST), &manifest.resolved())?;
        let trace = execution.trace.as_ref().map(|windows| {
            let physics = self.peers.iter().filter(|peer| peer.role != Role::Observer);
            let names = physics.map(|peer| peer.name.as_str());
            Trace::create(&at(outputs::TRACE), windows.clone(), names)
        });
        let trace = trace.transpose()?;

        let places = self.places.insert(RunPlaces::create(self.run).map_err(RunError::Places)?);
        let root = places.root();
        let poll = execution.poll.unwrap_or(POLL);
        let assignments =
            self.assignments(&root, &prefix, execution.in_process, spec.run.deadline, poll);
        let signals: Vec<_> = self.descriptions.iter().map(|d| d.signals.len()).collect();
        let control = Control::<S>::open(self.run, &self.peers, &assignments, &signals)?;
        if let Err(error) = self.assign(&assignments, manifest, interrupts) {
            end_all(&mut self.peers, QUIT_GRACE);
            return Err(error);
        }
        if !execution.in_process {
            // All channels are there, and nothing was sent yet.
            memory::commit(&prefix)?;
        }

        let physics: Vec<usize> =
            (0..self.peers.len()).filter(|i| self.peers[*i].role != Role::Observer).collect();
        let watched = physics.iter().map(|&index| Watched {
            name: self.peers[index].name.clone(),
            substeps: self.plan.components[index].substeps,
            signals: signals[index],
        });
        let drive = Drive {
            control,
            descriptions: &self.descriptions,
            news: &self.news,
            early: std::mem::take(&mut self.early),
            monitor: Monitor::new(self.run, self.plan.clock, watched.collect(), Instant::now()),
            peers: &mut self.peers,
            physics,
            threads: spec.components.iter().map(|c| c.threads_of(cores())).collect(),
            schedule: self.plan.schedule,
            lossless: self.plan.lossless_observers(),
            clock: self.plan.clock,
            windows: self.plan.windows,
            report_depth: assignments[0].transport.report_depth,
            deadline: spec.run.deadline,
            stop: StopConditions::new(&spec.stop_when, &names),
            table,
            log,
            trace,
            terminal,
            interrupts,
        };
        let driven = drive.run();
        end_all(self.peers.iter_mut().filter(|peer| peer.role != Role::Observer), EXIT_GRACE);
        let mut summary = self.summarise(driven);
        if let Err(error) = out.finish(&summary) {
            summary.ending.spoil(error.into_fault(summary.windows));
        }
        Ok(Ended { summary, peers: self.peers, news: self.news, _places: self.places })
    }

    /// Names and units of all signals of the physics, in the order of the monitor's rows.
    fn signal_names(&self) -> Vec<(String, Signal)> {
        let physics = self.peers.iter().zip(&self.descriptions);
        physics
            .filter(|(peer, _)| peer.role != Role::Observer)
            .flat_map(|(peer, description)| {
                let name = &peer.name;
                description.signals.iter().map(move |s| (format!("{name}.{}", s.name), s.clone()))
            })
            .collect()
    }

    fn assignments(
        &self,
        root: &str,
        prefix: &str,
        in_process: bool,
        deadline: f64,
        poll: Duration,
    ) -> Vec<Assignment> {
        let transport = |name: &str| Transport {
            between_processes: !in_process,
            root: root.to_string(),
            prefix: prefix.to_string(),
            credit_service: format!("credit/{name}"),
            report_service: format!("report/{name}"),
            report_depth: REPORT_DEPTH,
            deadline,
            poll: poll.as_secs_f64(),
        };
        self.plan.components.iter().map(|c| c.assignment(transport(&c.name))).collect()
    }

    /// Hands out the assignments, and waits until all components are ready.
    fn assign(
        &mut self,
        assignments: &[Assignment],
        manifest: &Manifest,
        interrupts: &AtomicUsize,
    ) -> Result<(), RunError> {
        for (peer, assignment) in self.peers.iter_mut().zip(assignments) {
            peer.send(Request::Assignment(Box::new(assignment.clone())));
        }
        let mut round = Round {
            peers: &mut self.peers,
            news: &self.news,
            early: &mut self.early,
            within: units::wait(manifest.spec.run.start_within),
            interrupts,
        };
        let mut refused = Vec::new();
        let components = &manifest.spec.components;
        let ready = round.collect(|index, reply| match reply {
            Reply::Ready {} => Ok(()),
            Reply::Refusal { problems } => {
                let why = problems.iter().map(Problem::to_string).collect::<Vec<_>>().join("; ");
                refused.extend(manifest.absolute(&components[index].name, problems));
                Err(why)
            }
            Reply::Fault(fault) => Err(fault.to_string()),
            other => Err(format!("it answered the assignment with {other:?}")),
        });
        ready.map_err(|unanswered| match unanswered {
            Unanswered::Interrupted => RunError::Interrupted,
            Unanswered::Failed(failed) if refused.is_empty() => self.not_ready(&failed),
            Unanswered::Failed(_) => RunError::Input(refused),
        })
    }

    fn not_ready(&self, failed: &[(usize, String)]) -> RunError {
        let say = |(index, why): &(usize, String)| format!("{}: {why}", self.peers[*index].name);
        RunError::NotReady(failed.iter().map(say).collect::<Vec<_>>().join("\n"))
    }

    fn summarise(&self, driven: Driven) -> Summary {
        let Driven { ending, window, totals, turns, observers, wall, table, .. } = driven;
        let components = totals
            .into_iter()
            .map(|(index, totals)| {
                let summary = ComponentSummary::new(&self.descriptions[index], totals);
                (self.peers[index].name.clone(), summary)
            })
            .collect();
        let signals: BTreeMap<String, Statistics> = table.into_statistics().into_iter().collect();
        let components_said =
            self.peers.iter().map(|peer| peer.name.as_str()).zip(&self.descriptions);
        let mut findings = self.findings.clone();
        findings.extend(preflight::look_back(components_said, &signals));
        Summary {
            ending,
            run: format!("{:016x}", self.run),
            processes: self
                .peers
                .iter()
                .filter_map(|peer| Some((peer.name.clone(), peer.process_id()?)))
                .collect(),
            windows: window,
            planned_windows: self.plan.windows,
            simulated_time: self.plan.clock.seconds(window * self.plan.clock.ticks_per_window),
            wall_time: wall.as_secs_f64(),
            turns,
            components,
            observers,
            signals,
            warnings: self.plan.warnings.clone(),
            findings,
        }
    }
}

fn write_file(path: &Path, text: &str) -> Result<(), OutputError> {
    std::fs::write(path, text).map_err(|error| OutputError::Io { path: PathBuf::from(path), error })
}

impl Ended {
    /// Whether the observer of that name is still there, serving what it shows.
    pub fn is_serving(&mut self, name: &str) -> bool {
        // Not all that ever comes: one that never stops talking must not hold up its user.
        for (index, news) in self.news.try_iter().take(1000) {
            self.peers[index].closed |= matches!(news, News::Closed);
        }
        self.peers.iter().any(|peer| peer.name == name && !peer.closed)
    }

    /// How the run ended.
    pub fn ending(&self) -> &Ending {
        &self.summary.ending
    }

    /// Ends observers that are still there.
    pub fn close(mut self) -> Summary {
        end_all(&mut self.peers, EXIT_GRACE);
        self.summary
    }
}
