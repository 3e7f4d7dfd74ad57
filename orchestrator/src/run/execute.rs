//! Execution of a run, from the assignments to the summary.

use crate::manifest::{Manifest, ORCHESTRATOR};
use crate::outputs::{
    self, ComponentSummary, LaterCheckpoints, LogLevel, OutputError, RankTimes, RunFolder, RunLog,
    SignalTable, Statistics, Summary, Trace,
};
use crate::plan::{PlannedComponent, REPORT_DEPTH};
use crate::preflight;
use crate::run::ask_all::{Round, Unanswered};
use crate::run::control::Control;
use crate::run::handshake::cores;
use crate::run::launch::{ComponentEvent, Peer, PeerEvent, end_all};
use crate::run::monitor::{Monitor, WatchedComponent};
use crate::run::origin::Origin;
use crate::run::run_loop::{Change, CheckpointKeeping, LoopOutcome, RunLoop, Steering};
use crate::run::stop_conditions::StopConditions;
use crate::run::watchdogs::Watchdogs;
use crate::run::{EXIT_GRACE, Execution, Prepared, QUIT_GRACE, RunError, limits};
use crate::steering::SteeringSocket;
use crate::terminal::Terminal;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::sync::atomic::AtomicUsize;
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};
use tremie_channels::sweep::{self, RunPlaces};
use tremie_channels::{ChannelMedium, InProcess, SharedMemory, memory};
use tremie_messages::start::{Assignment, Reply, Request, Signal, Transport};
use tremie_messages::units;
use tremie_messages::{Problem, Role};
use tremie_state::PreparedFile;

/// Time that a component polls before it sleeps. Longer than a round trip between two processes
/// (some microseconds), shorter than the time that a wake-up is worth.
const POLL: Duration = Duration::from_micros(200);
/// What a run that was prepared is carried out with.
pub struct RunCall<'a> {
    /// Its manifest.
    pub manifest: &'a Manifest,
    /// The folder of its outputs.
    pub out: &'a mut RunFolder,
    /// Where and how its components run.
    pub execution: &'a Execution,
    /// The user's end.
    pub terminal: &'a mut Terminal,
    /// Times that the user asked the run to end.
    pub interrupts: &'a AtomicUsize,
    /// Folder from which the manifest's programs were found.
    pub programs: &'a Path,
    /// The checkpoint from which it goes on.
    pub from: Option<Origin<'a>>,
}

/// A run that has ended. Observers that go on serving do so until this is dropped.
pub struct Ended {
    /// Summary of the run.
    pub summary: Summary,
    /// A change of the manifest for which it ended, to go on with the changed one.
    pub change: Option<Change>,
    /// All components; observers among them may still be serving.
    peers: Vec<Peer>,
    news: Receiver<PeerEvent>,
    _places: Option<RunPlaces>,
}

impl Prepared {
    /// Ends the components in good order, before any assignment.
    pub fn dismiss(mut self) {
        end_all(&mut self.peers, EXIT_GRACE);
    }

    /// Checks that the machine has the shared memory and the open files that the run needs.
    ///
    /// # Errors
    /// The lack, with both numbers.
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
    /// Anything that keeps the run from beginning; all components have ended then. A fault of a
    /// component or a disk that takes no more is no error of this function: the run then has ended
    /// with that fault.
    pub fn execute(self, call: RunCall<'_>) -> Result<Ended, RunError> {
        if call.execution.in_process {
            self.execute_between::<InProcess>(call)
        } else {
            self.execute_between::<SharedMemory>(call)
        }
    }

    fn execute_between<S: ChannelMedium>(mut self, call: RunCall<'_>) -> Result<Ended, RunError> {
        let RunCall { manifest, out, execution, terminal, interrupts, programs, from } = call;
        if let Some(from) = from {
            self.check_fit(from)?;
        }
        let own = from.and_then(Origin::own);
        // Also where the caller has checked: other programs may have taken memory meanwhile.
        self.fits(execution)?;
        if !execution.in_process {
            limits::explain_bus_errors();
        }
        // Files first: a full disk should not cost a started run.
        let spec = &manifest.spec;
        let names = self.signal_names();
        let (table, log, trace) = self.open_outputs(manifest, out, execution, (&names, from))?;
        // Before observers cut their files.
        let later = own.map(|from| LaterCheckpoints::set_aside(out.path(), from.record.window));
        let places = self.places.insert(RunPlaces::create(self.run).map_err(RunError::Places)?);
        // Commands of users wait here until the components are ready.
        let socket = steering_socket(places, out.path(), terminal);
        let control = self.start_components::<S>((manifest, &*out), execution, interrupts, from)?;
        if let Some(later) = later {
            // Only now: where the components refuse their states, the run has ended as it had.
            out.forget_end()?;
            later.remove();
        }
        let goes_on = from.and_then(Origin::window);
        let first = goes_on.unwrap_or(0);
        let physics: Vec<usize> =
            (0..self.peers.len()).filter(|i| self.peers[*i].role != Role::Observer).collect();
        let newest = own.map(|checkpoint| checkpoint.record.window);
        let checkpoints = self.checkpoints(manifest, programs, out.path(), (first, newest));
        let steering = self.steering(manifest, execution, socket, first);
        let watchdogs = self.watchdogs(&names);
        let monitor = self.monitor(&physics, goes_on);
        let drive = RunLoop {
            control,
            descriptions: &self.descriptions,
            news: &self.news,
            early: std::mem::take(&mut self.early),
            monitor,
            peers: &mut self.peers,
            physics,
            threads: spec.components.iter().map(|c| c.threads_of(cores())).collect(),
            schedule: self.plan.schedule,
            lossless: self.plan.lossless_observers(),
            clock: self.plan.clock,
            windows: self.plan.windows,
            report_depth: REPORT_DEPTH,
            deadline: spec.run.deadline,
            stop: StopConditions::new(&spec.stop_when, &names),
            watchdogs,
            table,
            log,
            trace,
            terminal,
            interrupts,
            checkpoints,
            steering,
            first,
            wall_before: Duration::ZERO,
        };
        match drive.run(own) {
            Ok(driven) => Ok(self.end(driven, out)),
            Err(error) => {
                self.quit(out.path());
                Err(error.into())
            }
        }
    }

    /// What users want of the run after window `first`, with the socket on which they say it.
    fn steering(
        &self,
        manifest: &Manifest,
        execution: &Execution,
        socket: Option<SteeringSocket>,
        first: u64,
    ) -> Steering {
        let file = Path::new(manifest.source.file());
        let file = std::path::absolute(file).unwrap_or_else(|_| file.to_path_buf());
        let planned = execution.changes.iter().filter(|it| it.window > first).cloned().collect();
        Steering::new(socket, self.run, file, execution.pause_at, planned)
    }

    /// Ends all components of a run that cannot end in order.
    fn quit(&mut self, out: &Path) {
        end_all(&mut self.peers, QUIT_GRACE);
        outputs::remove_unfinished_checkpoints(out);
    }

    /// Ends the physics, and writes the summary.
    fn end(mut self, mut driven: LoopOutcome, out: &mut RunFolder) -> Ended {
        // Physics only: a viewer goes on serving until `Ended` is dropped.
        end_all(self.peers.iter_mut().filter(|peer| peer.role != Role::Observer), EXIT_GRACE);
        // Of a checkpoint that was given up: only now nobody writes there any more.
        outputs::remove_unfinished_checkpoints(out.path());
        let change = driven.change.take();
        let mut summary = self.summarise(driven);
        // Last of all files: a folder with a summary holds a run that is over.
        if let Err(error) = out.finish(&summary) {
            summary.ending.spoil(error.into_fault(summary.windows));
        }
        Ended { summary, change, peers: self.peers, news: self.news, _places: self.places }
    }

    /// Gives the components their assignments; returns the orchestrator's ends of the channels when all
    /// are ready.
    fn start_components<S: ChannelMedium>(
        &mut self,
        (manifest, out): (&Manifest, &RunFolder),
        execution: &Execution,
        interrupts: &AtomicUsize,
        from: Option<Origin<'_>>,
    ) -> Result<Control<S>, RunError> {
        let prefix = sweep::prefix_of(self.run);
        let transport = Transport {
            between_processes: !execution.in_process,
            root: self.places.as_ref().map(RunPlaces::root).unwrap_or_default(),
            prefix: prefix.clone(),
            deadline: manifest.spec.run.deadline,
            poll: execution.poll.unwrap_or(POLL).as_secs_f64(),
            report_depth: REPORT_DEPTH,
            ..Transport::default()
        };
        let timed = execution.trace.as_ref().map(|windows| (*windows.start(), *windows.end()));
        let assignments = self.assignments(&transport, from, timed);
        let values = self.plan.components.iter().map(|c| c.signals + c.values_of_places());
        let signals: Vec<_> = values.collect();
        // Before the assignments: the orchestrator creates its ends before components open theirs.
        let control = Control::<S>::open(self.run, &self.peers, &assignments, &signals)?;
        let assigned = self.assign(&assignments, manifest, interrupts, from);
        // What the components have read is what was copied.
        let is_copied = || Ok(outputs::copy_inputs(out.path(), &manifest.input_files())?);
        if let Err(error) = assigned.and_then(|()| is_copied()) {
            end_all(&mut self.peers, QUIT_GRACE);
            return Err(error);
        }
        if !execution.in_process {
            // All channels are there, and nothing was sent yet: no page has been touched.
            memory::commit(&prefix)?;
        }
        Ok(control)
    }

    fn open_outputs(
        &self,
        manifest: &Manifest,
        out: &RunFolder,
        execution: &Execution,
        (names, from): (&[(String, Signal)], Option<Origin<'_>>),
    ) -> Result<(SignalTable, RunLog, Option<Trace>), OutputError> {
        let at = |name: &str| out.file(name);
        out.reserve(names.len())?;
        outputs::copy_inputs(out.path(), &manifest.input_files())?;
        let (every, clock, table) =
            (self.plan.signal_rows_every, self.plan.clock, at(outputs::SIGNALS));
        let (table, mut log) = if from.and_then(Origin::own).is_some() {
            (SignalTable::reopen(&table, clock, every, names)?, RunLog::reopen(&at(outputs::LOG))?)
        } else {
            (SignalTable::create(&table, clock, every, names)?, RunLog::create(&at(outputs::LOG))?)
        };
        if let Some(from) = from.filter(|from| from.own().is_none()) {
            let window = from.window().unwrap_or(0);
            let time = clock.seconds(window * clock.ticks_per_window);
            log.write(LogLevel::Info, ORCHESTRATOR, window, time, &from.to_string())?;
        }
        let prepare = |name: &str, fill: &dyn Fn(&mut BufWriter<File>) -> std::io::Result<()>| {
            PreparedFile::fill(&at(name), fill).map_err(OutputError::at(&at(name)))
        };
        let files = [
            prepare(outputs::MANIFEST, &|file| file.write_all(manifest.with_copies().as_bytes()))?,
            // Without a second copy in memory: it may list a million bodies.
            prepare(outputs::SCENE, &|file| {
                Ok(serde_json::to_writer(file, &manifest.spec.scene)?)
            })?,
        ];
        for file in files {
            file.place().map_err(OutputError::at(out.path()))?;
        }
        let trace = execution.trace.as_ref().map(|windows| {
            let physics = self.peers.iter().filter(|peer| peer.role != Role::Observer);
            let names = physics.map(|peer| peer.name.as_str());
            Trace::create(&at(outputs::TRACE), windows.clone(), names)
        });
        Ok((table, log, trace.transpose()?))
    }

    /// Checkpoints of a run from window `first` on; the newest that is there already.
    fn checkpoints(
        &self,
        manifest: &Manifest,
        programs: &Path,
        out: &Path,
        (first, newest): (u64, Option<u64>),
    ) -> CheckpointKeeping {
        CheckpointKeeping::new(
            manifest.spec.run.checkpoints,
            self.plan.can_be_kept(&self.descriptions),
            self.checkpoint_record(programs),
            manifest.with_copies(),
            out.to_path_buf(),
            (first, newest),
        )
    }

    /// Monitor of the physics, whose deadlines count from now on; the windows up to `done` were made
    /// before.
    fn monitor(&self, physics: &[usize], done: Option<u64>) -> Monitor {
        let watched = physics.iter().map(|&index| WatchedComponent {
            name: self.peers[index].name.clone(),
            substeps: self.plan.components[index].substeps,
            signals: self.descriptions[index].signals.len(),
            places: self.plan.components[index].values_of_places(),
        });
        Monitor::new(self.run, self.plan.clock, watched.collect(), done, Instant::now())
    }

    /// Watchdogs of the physics, whose signals have these full names.
    fn watchdogs(&self, names: &[(String, Signal)]) -> Watchdogs {
        let physics = self.plan.components.iter().filter(|c| c.role != Role::Observer);
        let places: Vec<_> = physics.map(|c| (c.name.clone(), c.values_of_places())).collect();
        Watchdogs::new(&self.plan.watches, names, &places)
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
        transport: &Transport,
        from: Option<Origin<'_>>,
        timed: Option<(u64, u64)>,
    ) -> Vec<Assignment> {
        let of = |name: &str| Transport {
            credit_service: format!("credit/{name}"),
            report_service: format!("report/{name}"),
            ..transport.clone()
        };
        let components = self.plan.components.iter();
        let resume = |role| from.and_then(|from| from.resume(role));
        let assign = |c: &PlannedComponent| Assignment {
            timed,
            ..c.assignment(of(&c.name), resume(c.role))
        };
        components.map(assign).collect()
    }

    /// Hands out the assignments, and waits until all components are ready.
    fn assign(
        &mut self,
        assignments: &[Assignment],
        manifest: &Manifest,
        interrupts: &AtomicUsize,
        from: Option<Origin<'_>>,
    ) -> Result<(), RunError> {
        for (peer, assignment) in self.peers.iter_mut().zip(assignments) {
            peer.send(Request::Assignment(Box::new(assignment.clone())));
        }
        let mut round = Round {
            peers: &mut self.peers,
            news: &self.news,
            early: &mut self.early,
            is_first: false,
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
        // Refusals name keys of the manifest, which a user can mend: they go before other failures.
        let hint = from.map_or(String::new(), |from| from.checkpoint.hint());
        ready.map_err(|unanswered| match unanswered {
            Unanswered::Interrupted => RunError::Interrupted,
            Unanswered::Failed(failed) if refused.is_empty() => self.not_ready(&failed, &hint),
            Unanswered::Failed(_) => RunError::Input(refused),
        })
    }

    fn not_ready(&self, failed: &[(usize, String)], hint: &str) -> RunError {
        let say = |(index, why): &(usize, String)| format!("{}: {why}", self.peers[*index].name);
        let all = failed.iter().map(say).collect::<Vec<_>>().join("\n");
        RunError::NotReady(all + hint)
    }

    fn summarise(&self, driven: LoopOutcome) -> Summary {
        let LoopOutcome {
            ending,
            window,
            totals,
            ranks,
            turns,
            observers,
            wall,
            table,
            checkpoint,
            ..
        } = driven;
        let components = totals
            .into_iter()
            .map(|(index, totals)| {
                let shares = ranks.get(&index).and_then(RankTimes::shares);
                let summary = ComponentSummary::new(&self.descriptions[index], totals, shares);
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
            checkpoint,
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

/// Where users' commands to the run arrive. A run that cannot be steered is a run all the same.
fn steering_socket(places: &RunPlaces, out: &Path, terminal: &Terminal) -> Option<SteeringSocket> {
    let warn = |error| {
        terminal.warn(&format!("the run cannot be steered by other commands: {error}"));
    };
    SteeringSocket::open(places.folder(), out).map_err(warn).ok()
}

impl Ended {
    /// True if the observer of that name is still there, serving what it shows.
    pub fn is_serving(&mut self, name: &str) -> bool {
        // Not all that ever comes: an observer that never stops talking must not hold up its user.
        for (index, news) in self.news.try_iter().take(1000) {
            self.peers[index].closed |= matches!(news, ComponentEvent::Closed);
        }
        self.peers.iter().any(|peer| peer.name == name && !peer.closed)
    }

    /// Ends observers that are still there.
    pub fn close(mut self) -> Summary {
        end_all(&mut self.peers, EXIT_GRACE);
        self.summary
    }
}
