//! Context of every step of a component's loop: who it is, how far it may go, how long it waited.

use crate::line::ControlPipe;
use crate::roles::SolverError;
use crate::sent::{SentMessages, SharedSentMessages};
use crate::stop::Stop;
use std::time::{Duration, Instant, SystemTime};
use tremie_channels::{
    Attachment, Bell, ChannelMedium, ChannelSpec, Receiver, Sender, Wait, look, spin,
};
use tremie_messages::Stamp;
use tremie_messages::control::{Credit, Report};
use tremie_messages::schedule::{Content, Edge};
use tremie_messages::start::{
    Assignment, Fault, FaultKind, Injection, InjectionKind, Reply, Transport,
};
use tremie_messages::units;

/// A wait longer than this is told to the orchestrator, which sees when all wait for each other.
const LONG_WAIT: Duration = Duration::from_millis(60);

/// Wall time spent in one window [ns].
#[derive(Clone, Copy, Debug, Default)]
pub struct Spent {
    /// In the solver.
    pub compute: u64,
    /// Waiting for peers or credit.
    pub wait: u64,
}

/// A message that a component waits for.
pub struct Owed<'a> {
    /// The peer that owes it.
    pub from: &'a str,
    /// Its name, as `state of window 7`.
    pub what: &'a dyn Fn() -> String,
    /// The window that it belongs to.
    pub window: u64,
    /// Inside a window: its place in the exchange; else 0.
    pub turn: u64,
}

impl Owed<'_> {
    fn waiting(&self, since: u64, looked: u64, window: u64) -> Reply {
        let (from, what, owed) = (self.from.to_string(), (self.what)(), self.window);
        Reply::Waiting { from, what, owed, since, looked, window, turn: self.turn }
    }
}

/// A component's place in its run, while windows go by.
pub struct Context<S: ChannelMedium> {
    /// Id of the run.
    pub run: u64,
    /// Name of the component.
    pub component: String,
    /// Its assignment.
    pub assignment: Assignment,
    /// Window that is being worked on; 0 in the start exchange.
    pub window: u64,
    /// Substeps to make in this window.
    pub substeps: u32,
    /// Time spent in this window.
    pub spent: Spent,
    /// Messages that it has sent, for observers.
    pub sent: SharedSentMessages,
    /// Shared memory.
    pub attachment: Attachment<S>,
    bell: Bell<S>,
    credit: Receiver<S, Stamp, Credit>,
    report: Sender<S, Report, f64>,
    heard: Heard,
    line: ControlPipe,
}

/// What the orchestrator has said so far.
#[derive(Clone, Copy, Debug, Default)]
struct Heard {
    /// Last window that may be advanced through; nothing before the start exchange is allowed.
    granted: Option<u64>,
    finish: bool,
    checkpoint: u64,
    kept: u64,
}

impl<S: ChannelMedium> Context<S> {
    /// Attaches to the run's shared memory.
    pub fn open(
        run: u64,
        component: &str,
        assignment: Assignment,
        signals: usize,
        line: ControlPipe,
    ) -> Result<Self, Box<(Stop, ControlPipe)>> {
        match Self::ports(component, &assignment, signals) {
            Ok((attachment, bell, credit, report)) => Ok(Self {
                run,
                component: component.to_string(),
                window: 0,
                substeps: 0,
                spent: Spent::default(),
                sent: SentMessages::new(component, &assignment).into(),
                attachment,
                bell,
                credit,
                report,
                heard: Heard::default(),
                line,
                assignment,
            }),
            Err(stop) => Err(Box::new((stop, line))),
        }
    }

    #[allow(clippy::type_complexity)] // the four ports of a context, named where they are used
    fn ports(
        component: &str,
        assignment: &Assignment,
        signals: usize,
    ) -> Result<(Attachment<S>, Bell<S>, Receiver<S, Stamp, Credit>, Sender<S, Report, f64>), Stop>
    {
        let transport = &assignment.transport;
        let patience = units::wait(transport.deadline);
        let attachment = Attachment::open(&transport.root, &transport.prefix, component, patience)?;
        let bell = Bell::hang(&attachment, component, units::wait(transport.poll))?;
        let credit = attachment.receiver(credit_spec(&transport.credit_service))?;
        let report = attachment.sender(report_spec(transport, signals))?;
        Ok((attachment, bell, credit, report))
    }

    /// Speaks to the orchestrator.
    pub fn line(&mut self) -> &mut ControlPipe {
        &mut self.line
    }

    /// The stamp of this component's messages in the present window.
    pub fn stamp(&self, events: u64) -> Stamp {
        Stamp {
            run: self.run,
            window: self.window,
            ticks: self.window * self.assignment.clock.ticks_per_window,
            events,
            substep: self.substeps,
            iteration: 0,
        }
    }

    /// The stamp that the message of `edge`, `lag` windows before the present one, must carry.
    pub fn expected(&self, edge: &Edge, lag: u64) -> Stamp {
        let window = self.window - lag;
        Stamp {
            run: self.run,
            window,
            ticks: window * self.assignment.clock.ticks_per_window,
            events: window.saturating_sub(edge.events_lag),
            substep: if window == 0 { 0 } else { edge.sender_substeps },
            iteration: 0,
        }
    }

    /// The fault to commit in this window, if there is one.
    pub fn injection(&self) -> Option<InjectionKind> {
        let now = |i: &&Injection| i.window == self.window;
        self.assignment.injections.iter().find(now).map(|i| i.kind)
    }

    /// A fault that this component noticed in the present window.
    pub fn fault(&self, kind: FaultKind, blamed: &str, message: String) -> Stop {
        Stop::Fault(Fault {
            kind,
            noticed_by: self.component.clone(),
            blamed: blamed.to_string(),
            window: self.window,
            message,
        })
    }

    /// This component's own solver failed in the present window.
    pub fn solver_failed(&self, error: &SolverError) -> Stop {
        self.fault(FaultKind::Solver, &self.component, error.to_string())
    }

    /// The stamp of a message inside the present window, of the trial `iteration` of `substep`.
    pub fn inside(&self, substep: u32, iteration: u32) -> Stamp {
        let clock = &self.assignment.clock;
        let (begin, made) = (self.window.saturating_sub(1), u64::from(substep));
        let ticks = clock.ticks_per_window * made / u64::from(self.assignment.substeps.max(1));
        Stamp {
            run: self.run,
            window: self.window,
            ticks: begin * clock.ticks_per_window + ticks,
            events: begin,
            substep,
            iteration,
        }
    }

    /// The edge of this component that carries `content`, if it has one.
    pub fn edge(&self, content: Content) -> Option<&Edge> {
        self.assignment.edges.iter().find(|edge| edge.content == content)
    }

    /// Does `work` and counts its time as computing, less what it waits.
    pub fn compute<T>(&mut self, work: impl FnOnce(&mut Self) -> T) -> T {
        let (begin, waited) = (Instant::now(), self.spent.wait);
        let done = work(self);
        let waited = self.spent.wait - waited;
        self.spent.compute += (begin.elapsed().as_nanos() as u64).saturating_sub(waited);
        done
    }

    /// Waits until `check` gives something; ends at the deadline, or at once when aborted.
    pub fn wait<T>(
        &mut self,
        owed: &Owed<'_>,
        mut check: impl FnMut() -> Result<Option<T>, Stop>,
    ) -> Result<T, Stop> {
        if let Some(found) = check()? {
            return Ok(found);
        }
        let begin = Instant::now();
        // Inside a window the answer may be there at once: no bookkeeping at first.
        if owed.turn > 0
            && let Some(found) = look(&mut check)?
        {
            self.spent.wait += begin.elapsed().as_nanos() as u64;
            return Ok(found);
        }
        let deadline = begin + units::wait(self.assignment.transport.deadline);
        let Self { bell, credit, heard, line, window, .. } = self;
        let mut told: Option<Instant> = None;
        let since = clock();
        let watch = || {
            let looked = clock();
            if let Some(found) = check()? {
                return Ok(Some(found));
            }
            heed_credit(credit, heard)?;
            if told.unwrap_or(begin).elapsed() > LONG_WAIT {
                told = Some(Instant::now());
                let _ = line.reply(&owed.waiting(since, looked, *window));
            }
            Ok::<_, Stop>(None)
        };
        // Inside a window nobody rings.
        let ended = if owed.turn > 0 { spin(deadline, watch) } else { bell.wait(deadline, watch) };
        if told.is_some() {
            let _ = line.reply(&Reply::Resumed {});
        }
        self.spent.wait += begin.elapsed().as_nanos() as u64;
        match ended? {
            Wait::Ready(found) => Ok(found),
            Wait::TimedOut => {
                let text = format!(
                    "{} did not come within the deadline of {} s (run.deadline)",
                    (owed.what)(),
                    self.assignment.transport.deadline
                );
                Err(self.fault(FaultKind::Deadline, owed.from, text))
            }
        }
    }

    /// Waits for leave to work on `window`; `false` if the run ends before it.
    pub fn may_start(&mut self, window: u64) -> Result<bool, Stop> {
        let begin = Instant::now();
        // The orchestrator may pause a run as long as its user likes: no deadline here. If it dies,
        // the kernel ends this process with it.
        let never = begin + Duration::from_secs(10 * 365 * 24 * 3600);
        let Self { bell, credit, heard, .. } = self;
        let may = |heard: &Heard| heard.granted.is_some_and(|last| last >= window);
        bell.wait(never, || {
            heed_credit(credit, heard)?;
            Ok::<_, Stop>((may(heard) || heard.finish).then_some(()))
        })?;
        self.spent.wait += begin.elapsed().as_nanos() as u64;
        Ok(may(&self.heard))
    }

    /// True if the state at the end of the present window is kept for a checkpoint.
    pub fn keeps_state(&self) -> bool {
        self.window > 0 && self.heard.checkpoint == self.window
    }

    /// For observers: the window of the newest checkpoint, and whether all physics has kept its state
    /// for it, so that no frame of that window or an earlier one is still to be sent.
    pub fn checkpoint(&mut self) -> Result<(u64, bool), Stop> {
        heed_credit(&self.credit, &mut self.heard)?;
        Ok((self.heard.checkpoint, self.heard.kept == self.heard.checkpoint))
    }

    /// True if a row of the signals of the present window is kept: by the plan, or because it is
    /// known to be the last.
    pub fn keeps_row(&self) -> bool {
        let Assignment { windows, rows_every, .. } = self.assignment;
        let is_last =
            self.window == windows || self.heard.finish && self.heard.granted == Some(self.window);
        is_last || self.window.is_multiple_of(rows_every.max(1))
    }

    /// True if the orchestrator said that the run is over.
    pub fn finish_requested(&mut self) -> Result<bool, Stop> {
        heed_credit(&self.credit, &mut self.heard)?;
        Ok(self.heard.finish)
    }

    /// Last window that may be advanced through; the run's last one once finishing was requested.
    pub fn granted(&self) -> Option<u64> {
        self.heard.granted
    }

    /// Sleeps for `nap`, whoever rings.
    pub fn sleep(&mut self, nap: Duration) -> Result<(), Stop> {
        self.bell.wait(Instant::now() + nap, || Ok::<Option<()>, Stop>(None))?;
        Ok(())
    }

    /// Sleeps until somebody rings, at most `nap`.
    pub fn rest(&mut self, nap: Duration) -> Result<(), Stop> {
        Ok(self.bell.rest(nap)?)
    }

    /// Accounts for the present window.
    pub fn send_report(&mut self, begin: Instant, work: u64, signals: &[f64]) -> Result<(), Stop> {
        let total = begin.elapsed().as_nanos() as u64;
        let Spent { compute, wait } = std::mem::take(&mut self.spent);
        let report = Report {
            stamp: self.stamp(self.window),
            begin: clock().saturating_sub(total),
            compute,
            wait,
            exchange: total.saturating_sub(compute + wait),
            work: work * u64::from(self.substeps),
        };
        Ok(self.report.send_copy(report, signals)?)
    }
}

/// Nanoseconds of the machine's clock, comparable between its processes.
fn clock() -> u64 {
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    now.map_or(0, |time| time.as_nanos() as u64)
}

/// The credit channel keeps the newest word only: words grow, and the last one counts.
pub fn credit_spec(service: &str) -> ChannelSpec<'_> {
    ChannelSpec { service, capacity: 1, depth: 1, borrowed: 1, lossless: false }
}

/// The channel of a component's reports, with its signals.
pub fn report_spec(transport: &Transport, signals: usize) -> ChannelSpec<'_> {
    ChannelSpec {
        service: &transport.report_service,
        capacity: signals,
        depth: transport.report_depth as usize,
        borrowed: 1,
        lossless: true,
    }
}

fn heed_credit<S: ChannelMedium>(
    credit: &Receiver<S, Stamp, Credit>,
    heard: &mut Heard,
) -> Result<(), Stop> {
    while let Some(message) = credit.take()? {
        for word in message.values() {
            match word.command {
                Credit::ABORT => return Err(Stop::Aborted),
                Credit::FINISH => heard.finish = true,
                _ => {}
            }
            heard.granted = heard.granted.max(Some(word.window));
            heard.checkpoint = heard.checkpoint.max(word.checkpoint);
            heard.kept = heard.kept.max(word.kept);
        }
    }
    Ok(())
}
