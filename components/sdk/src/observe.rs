//! An observer's life: hello, assignment, frames, end.

use crate::context::Context;
use crate::frames::frame_spec;
use crate::keep::StateKeeper;
use crate::line::{ControlPipe, Replier};
use crate::observer::{Moment, Observer, ObserverError};
use crate::program::Participant;
use crate::sent::CopiedMessage;
use crate::serve::{Assigned, panic_text};
use crate::setup::Setup;
use crate::stop::Stop;
use std::marker::PhantomData;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;
use tremie_channels::{Attachment, ChannelError, ChannelMedium, Received, Receiver};
use tremie_messages::frame::{
    BodySample, ComponentTiming, LoadSample, LogHeader, MessagesHeader, ProfileBin, ProfileHeader,
    SliceHeader, SliceNode, SurfaceSample, TimingHeader, VolumeHeader,
};
use tremie_messages::start::{
    Clock, Description, Fault, FaultKind, FrameContent, FrameStream, Reply,
};
use tremie_messages::{Message, Problem, Role, Stamp};
use tremie_state::StateError;

/// Longest sleep of an observer when there is nothing to see. A lossy one always sleeps so long: it
/// looks often enough for the eye, and sees no more frames than the physics has cores to spare for.
const NAP: Duration = Duration::from_millis(50);
/// Time between the signs of an observer that it has not hung.
const PULSE: Duration = Duration::from_millis(500);

enum FrameReceiver<S: ChannelMedium> {
    Bodies(Ahead<S, Stamp, BodySample>),
    Surfaces(Ahead<S, Stamp, SurfaceSample>),
    Loads(Ahead<S, Stamp, LoadSample>),
    Timings(Ahead<S, TimingHeader, ComponentTiming>),
    Slice(Ahead<S, SliceHeader, SliceNode>),
    Volume(Ahead<S, VolumeHeader, SliceNode>),
    Profile(Ahead<S, ProfileHeader, ProfileBin>),
    Signals(Ahead<S, Stamp, f64>),
    Hashes(Ahead<S, Stamp, u64>),
    Messages(Pieces<S>),
    Log(Ahead<S, LogHeader, u8>),
}

/// A receiver whose next frame may be held back.
struct Ahead<S: ChannelMedium, H: Message + Default, T: Message> {
    receiver: Receiver<S, H, T>,
    held: Option<Received<S, H, T>>,
}

impl<S: ChannelMedium, H: Message + Default, T: Message> Ahead<S, H, T> {
    fn open(attachment: &Attachment<S>, plan: &FrameStream) -> Result<Self, ChannelError> {
        Ok(Self { receiver: attachment.receiver(frame_spec(plan))?, held: None })
    }

    /// The next frame, if one has arrived and `may` allows it; `window` reads its window.
    fn next(
        &mut self,
        window: impl Fn(&H) -> u64,
        may: &mut May<'_>,
    ) -> Result<Option<Received<S, H, T>>, Stop> {
        if self.held.is_none() {
            self.held = self.receiver.take()?;
        }
        match &self.held {
            // Asked only now: a checkpoint is named before any frame of a later window can be sent.
            Some(frame) if may(window(frame.header()))? => Ok(self.held.take()),
            _ => Ok(None),
        }
    }
}

/// Messages of a window, which come in pieces.
struct Pieces<S: ChannelMedium> {
    ahead: Ahead<S, MessagesHeader, u8>,
    /// Those of the window that have come.
    begun: Vec<u8>,
}

impl<S: ChannelMedium> Pieces<S> {
    /// Takes the next piece, if one has arrived and `may` allows it: its header. The window is whole
    /// after the last.
    fn next(&mut self, may: &mut May<'_>) -> Result<Option<MessagesHeader>, Stop> {
        let Some(piece) = self.ahead.next(|header| header.stamp.window, may)? else {
            return Ok(None);
        };
        self.begun.extend_from_slice(piece.values());
        Ok(Some(*piece.header()))
    }

    /// Shows the messages of a whole window, on so many channels, and forgets them.
    fn show(
        &mut self,
        channels: usize,
        show: impl FnOnce(&[CopiedMessage<'_>]) -> Result<(), ObserverError>,
    ) -> Result<(), ObserverError> {
        let damaged = || ObserverError::Other("messages came that are cut off".into());
        let said = show(&CopiedMessage::all(&self.begun, channels).ok_or_else(damaged)?);
        self.begun.clear();
        said
    }
}

/// Says whether frames of a window may be shown by now.
type May<'a> = dyn FnMut(u64) -> Result<bool, Stop> + 'a;

struct Inlet<S: ChannelMedium> {
    plan: FrameStream,
    input: FrameReceiver<S>,
    /// Window of the frame before, to count those that were lost.
    before: Option<u64>,
    lost: u64,
}

/// Checkpoints of an observer.
struct Checkpoints {
    keeper: StateKeeper,
    /// Window of the last one that it has kept its state for, or has given up.
    kept: u64,
    /// Last window whose frames it has seen, where the run goes on.
    seen: Option<u64>,
}

/// Shows the observer a frame by a function that tells it, unless it has seen the window.
type Show<'a> =
    dyn Fn(Stamp, &mut dyn FnMut(Moment) -> Result<(), ObserverError>) -> Option<Shown> + 'a;

/// Stamp of a frame, and what the observer said of it.
type Shown = (Stamp, Result<(), ObserverError>);

/// An observer as a component of a run.
pub struct AsObserver<T>(PhantomData<T>);

impl<T: Observer> Participant for AsObserver<T> {
    const ROLE: Role = Role::Observer;
    const PROGRAM: &'static str = T::PROGRAM;

    fn program() -> String {
        T::program()
    }

    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>> {
        T::describe(setup)
    }

    fn serve<S: ChannelMedium>(line: ControlPipe, assigned: Assigned) -> Result<(), String> {
        serve_observer::<S, T>(line, assigned)
    }
}

/// # Errors
/// A sentence for standard error.
fn serve_observer<S: ChannelMedium, O: Observer>(
    mut line: ControlPipe,
    (hello, assignment, description): Assigned,
) -> Result<(), String> {
    let keeper = StateKeeper::new(&hello, &description);
    let mut checkpoints = Checkpoints { keeper, kept: 0, seen: None };
    let setup = Setup { hello: hello.clone(), assignment: Some(assignment.clone()) };
    let opened = catch_unwind(AssertUnwindSafe(|| O::open(&setup)))
        .unwrap_or_else(|panic| Err(ObserverError::Other(panic_text(&*panic))));
    let opened = opened.map_err(|error| error.to_string()).and_then(|mut observer| {
        let put_back = checkpoints.put_back(&setup, &mut observer);
        put_back.map(|()| observer).map_err(|error| error.to_string())
    });
    let mut observer = match opened {
        Ok(observer) => observer,
        Err(error) => {
            let problem = Problem::new(format!("components.{}", hello.component), error);
            return line
                .reply(&Reply::Refusal { problems: vec![problem] })
                .map_err(|e| e.to_string());
        }
    };
    let mut context = match Context::<S>::open(hello.run, &hello.component, assignment, 0, line) {
        Ok(context) => context,
        Err(failed) => {
            let (stop, mut line) = *failed;
            let fault = stop.into_fault(&hello.component, 0);
            let told = fault.map_or(Ok(()), |fault| line.reply(&Reply::Fault(fault)));
            return told.map_err(|e| e.to_string());
        }
    };
    let ended =
        catch_unwind(AssertUnwindSafe(|| watch(&mut observer, &mut context, &mut checkpoints)))
            .unwrap_or_else(|panic| {
                Err(context.fault(FaultKind::Solver, &context.component, panic_text(&*panic)))
            });
    busy_while(&context.line().replier(), &AtomicBool::new(true), || checkpoints.keeper.wait());
    let reply = match ended {
        Ok((window, note)) => Reply::Finished { window, note },
        Err(stop) => match stop.into_fault(&hello.component, context.window) {
            Some(fault) => Reply::Fault(fault),
            None => return Ok(()),
        },
    };
    context.line().reply(&reply).map_err(|e| e.to_string())?;
    // What the observer serves (a viewer's web page) stays up until the orchestrator says quit.
    let _ = context.line().next_request();
    drop(observer);
    Ok(())
}

fn watch<S: ChannelMedium, O: Observer>(
    observer: &mut O,
    context: &mut Context<S>,
    checkpoints: &mut Checkpoints,
) -> Result<(u64, String), Stop> {
    let mut inlets = open_inlets(context)?;
    let gone = |_| Stop::Aborted;
    context.line().reply(&Reply::Ready {}).map_err(gone)?;
    // A frame, too, may have to wait for a slow disk. Before the first one others are still getting ready, and the
    // orchestrator takes what is said for an answer.
    let (line, has_begun) = (context.line().replier(), AtomicBool::new(false));
    busy_while(&line, &has_begun, || {
        show_all(observer, context, checkpoints, (&mut inlets, &has_begun))
    })
}

/// Shows the observer all frames, until the run is over; says when that has begun.
fn show_all<S: ChannelMedium, O: Observer>(
    observer: &mut O,
    context: &mut Context<S>,
    checkpoints: &mut Checkpoints,
    (inlets, has_begun): (&mut [Inlet<S>], &AtomicBool),
) -> Result<(u64, String), Stop> {
    let gone = |_| Stop::Aborted;
    let is_lossless = inlets.iter().any(|inlet| inlet.plan.lossless);
    let mut watching = false;
    loop {
        // Asked before the last look: what was sent before the request is then surely seen.
        let finishing = context.finish_requested()?;
        let (asked, all_kept) = context.checkpoint()?;
        if finishing && !all_kept {
            checkpoints.give_up(asked);
        }
        let mut seen = false;
        // One frame of each stream after the other, so that no stream runs far ahead.
        for inlet in &mut *inlets {
            seen |= inlet.show_next(observer, context, checkpoints)?;
        }
        if seen {
            has_begun.store(true, Ordering::Relaxed);
        }
        if !watching && inlets.iter().all(Inlet::has_begun) {
            watching = true;
            context.line().reply(&Reply::Watching {}).map_err(gone)?;
        }
        if !seen && all_kept && checkpoints.are_due(asked) {
            // Nothing is left of the checkpoint's window: what has come since is held back.
            let replier = context.line().replier();
            checkpoints.keeper.keep(asked, replier, |state| observer.exchange_state(state));
            checkpoints.kept = asked;
            continue;
        }
        if finishing && !seen {
            return close(observer, context, inlets);
        }
        if !seen && is_lossless {
            // Senders wait for room.
            context.rest(NAP)?;
        } else if !seen {
            context.sleep(NAP)?;
        }
    }
}

impl Checkpoints {
    /// Puts the observer's state back, where it goes on with its outputs.
    fn put_back<O: Observer>(&mut self, setup: &Setup, observer: &mut O) -> Result<(), StateError> {
        let resume = setup.assignment.as_ref().and_then(|assignment| assignment.resume.as_ref());
        let Some(resume) = resume.filter(|_| setup.goes_on() && self.keeper.has_state()) else {
            return Ok(());
        };
        self.keeper.put_back(resume, |state| observer.exchange_state(state))?;
        (self.kept, self.seen) = (resume.window, Some(resume.window));
        Ok(())
    }

    /// True if the observer has yet to keep its state for the checkpoint of window `asked`.
    fn are_due(&self, asked: u64) -> bool {
        self.keeper.has_state() && asked > self.kept
    }

    /// The run ends before all physics has kept its state for the checkpoint of window `asked`. From now
    /// on the observer is shown what came after that window, so it must keep no state for it.
    fn give_up(&mut self, asked: u64) {
        self.kept = self.kept.max(asked);
    }
}

/// Does what may take long on a slow disk. Once it has begun, tells the orchestrator that this process is not stopped.
fn busy_while<T>(replier: &Replier, has_begun: &AtomicBool, work: impl FnOnce() -> T) -> T {
    let (ended, is_ended) = mpsc::channel::<()>();
    std::thread::scope(|scope| {
        scope.spawn(move || {
            while is_ended.recv_timeout(PULSE) == Err(RecvTimeoutError::Timeout) {
                if has_begun.load(Ordering::Relaxed) {
                    // A closed line ends the observer elsewhere.
                    let _ = replier.reply(&Reply::Busy {});
                }
            }
        });
        let done = work();
        drop(ended);
        done
    })
}

/// Closes the observer's outputs; returns the run's last window and a note for the summary.
fn close<S: ChannelMedium, O: Observer>(
    observer: &mut O,
    context: &Context<S>,
    inlets: &[Inlet<S>],
) -> Result<(u64, String), Stop> {
    let last = context.granted().unwrap_or(0);
    let note = observer.close(last).map_err(|error| wrong(context, error))?;
    let lost: u64 = inlets.iter().map(|inlet| inlet.lost).sum();
    let skipped = if lost > 0 { format!(" ({lost} frames skipped)") } else { String::new() };
    Ok((last, note + &skipped))
}

fn open_inlets<S: ChannelMedium>(context: &Context<S>) -> Result<Vec<Inlet<S>>, Stop> {
    let mine = |plan: &&FrameStream| plan.to == context.component;
    let mut inlets = Vec::new();
    for plan in context.assignment.frames.iter().filter(mine) {
        let attachment = &context.attachment;
        let input = match &plan.content {
            FrameContent::Bodies => FrameReceiver::Bodies(Ahead::open(attachment, plan)?),
            FrameContent::Surfaces => FrameReceiver::Surfaces(Ahead::open(attachment, plan)?),
            FrameContent::Loads => FrameReceiver::Loads(Ahead::open(attachment, plan)?),
            FrameContent::Timings(_) => FrameReceiver::Timings(Ahead::open(attachment, plan)?),
            FrameContent::Slice(_) => FrameReceiver::Slice(Ahead::open(attachment, plan)?),
            FrameContent::Volume(_) => FrameReceiver::Volume(Ahead::open(attachment, plan)?),
            FrameContent::Profile(_) => FrameReceiver::Profile(Ahead::open(attachment, plan)?),
            FrameContent::Signals(_) => FrameReceiver::Signals(Ahead::open(attachment, plan)?),
            FrameContent::Hashes(_) => FrameReceiver::Hashes(Ahead::open(attachment, plan)?),
            FrameContent::Messages(_) => {
                let ahead = Ahead::open(attachment, plan)?;
                FrameReceiver::Messages(Pieces { ahead, begun: Vec::new() })
            }
            FrameContent::Log => FrameReceiver::Log(Ahead::open(attachment, plan)?),
        };
        inlets.push(Inlet { plan: plan.clone(), input, before: None, lost: 0 });
    }
    Ok(inlets)
}

impl<S: ChannelMedium> Inlet<S> {
    /// True if a first frame has come. What the orchestrator sends comes when it comes.
    fn has_begun(&self) -> bool {
        self.before.is_some() || self.plan.content.is_of_orchestrator()
    }

    /// Shows the observer the next frame, if one has arrived that it may see by now; returns whether.
    fn show_next<O: Observer>(
        &mut self,
        observer: &mut O,
        context: &mut Context<S>,
        checkpoints: &Checkpoints,
    ) -> Result<bool, Stop> {
        let clock = context.assignment.clock;
        let mut may = |window: u64| {
            let (asked, _) = context.checkpoint()?;
            Ok(!checkpoints.are_due(asked) || window <= asked)
        };
        let seen = checkpoints.seen.filter(|_| self.plan.content != FrameContent::Log);
        let shown = match self.take(observer, &clock, seen, &mut may)? {
            None => return Ok(false),
            Some(shown) => shown,
        };
        let (stamp, said) = shown;
        said.map_err(|error| wrong(context, error))?;
        context.window = stamp.window;
        if !self.plan.content.is_of_orchestrator() {
            let is_profile = matches!(self.plan.content, FrameContent::Profile(_));
            let step = self.before.map_or(0, |before| stamp.window.saturating_sub(before));
            // Tables end when they do.
            let skipped = (step / self.plan.every.max(1)).saturating_sub(1);
            self.lost += if is_profile { 0 } else { skipped };
            self.before = Some(stamp.window);
        }
        Ok(true)
    }

    /// Takes the next frame, if one has arrived and `may` allows it: its stamp, and what the observer
    /// said. Frames of windows up to `seen` are not shown.
    fn take<O: Observer>(
        &mut self,
        observer: &mut O,
        clock: &Clock,
        seen: Option<u64>,
        may: &mut May<'_>,
    ) -> Result<Option<Shown>, Stop> {
        let from = &self.plan.from;
        let show = |stamp: Stamp, show: &mut dyn FnMut(Moment) -> Result<(), ObserverError>| {
            let is_new = seen.is_none_or(|seen| stamp.window > seen);
            let said = if is_new { show(moment(clock, stamp)) } else { Ok(()) };
            Some((stamp, said))
        };
        Ok(match (&mut self.input, &self.plan.content) {
            (FrameReceiver::Bodies(ahead), _) => {
                ahead.next(|stamp| stamp.window, may)?.and_then(|frame| {
                    show(*frame.header(), &mut |at| observer.bodies(from, at, frame.values()))
                })
            }
            (FrameReceiver::Surfaces(ahead), _) => {
                ahead.next(|stamp| stamp.window, may)?.and_then(|frame| {
                    show(*frame.header(), &mut |at| observer.surfaces(from, at, frame.values()))
                })
            }
            (FrameReceiver::Slice(ahead), FrameContent::Slice(name)) => {
                ahead.next(|header| header.stamp.window, may)?.and_then(|frame| {
                    let (header, nodes) = (frame.header(), frame.values());
                    show(header.stamp, &mut |at| observer.slice(from, name, at, header, nodes))
                })
            }
            (FrameReceiver::Volume(ahead), FrameContent::Volume(grid)) => {
                ahead.next(|header| header.stamp.window, may)?.and_then(|frame| {
                    let (header, nodes) = (frame.header(), frame.values());
                    let name = &grid.name;
                    show(header.stamp, &mut |at| observer.volume(from, name, at, header, nodes))
                })
            }
            (FrameReceiver::Profile(ahead), FrameContent::Profile(name)) => {
                ahead.next(|header| header.stamp.window, may)?.and_then(|frame| {
                    let (header, bins) = (frame.header(), frame.values());
                    show(header.stamp, &mut |at| match header.samples {
                        0 => Ok(()),
                        _ => observer.profile(from, name, at, header, bins),
                    })
                })
            }
            (FrameReceiver::Signals(ahead), FrameContent::Signals(names)) => {
                ahead.next(|stamp| stamp.window, may)?.and_then(|frame| {
                    let values = frame.values();
                    show(*frame.header(), &mut |at| observer.signals(from, at, names, values))
                })
            }
            (FrameReceiver::Hashes(_) | FrameReceiver::Messages(_), _) => {
                return self.take_of_messages(observer, &show, may);
            }
            (FrameReceiver::Loads(_) | FrameReceiver::Timings(_), _) => {
                return self.take_of_coupling(observer, &show, may);
            }
            (FrameReceiver::Log(ahead), _) => {
                ahead.next(|header| header.stamp.window, may)?.and_then(|frame| {
                    let text = String::from_utf8_lossy(frame.values());
                    show(frame.header().stamp, &mut |at| observer.log(at, frame.header(), &text))
                })
            }
            _ => None,
        })
    }
}

impl<S: ChannelMedium> Inlet<S> {
    /// As [`Inlet::take`], of loads and timings.
    fn take_of_coupling<O: Observer>(
        &mut self,
        observer: &mut O,
        show: &Show<'_>,
        may: &mut May<'_>,
    ) -> Result<Option<Shown>, Stop> {
        let from = &self.plan.from;
        Ok(match (&mut self.input, &self.plan.content) {
            (FrameReceiver::Loads(ahead), _) => {
                ahead.next(|stamp| stamp.window, may)?.and_then(|frame| {
                    show(*frame.header(), &mut |at| observer.loads(from, at, frame.values()))
                })
            }
            (FrameReceiver::Timings(ahead), FrameContent::Timings(coupling)) => {
                ahead.next(|header| header.stamp.window, may)?.and_then(|frame| {
                    let (header, timings) = (frame.header(), frame.values());
                    show(header.stamp, &mut |at| observer.timings(at, coupling, header, timings))
                })
            }
            _ => None,
        })
    }

    /// As [`Inlet::take`], of hashes and copies of messages.
    fn take_of_messages<O: Observer>(
        &mut self,
        observer: &mut O,
        show: &Show<'_>,
        may: &mut May<'_>,
    ) -> Result<Option<Shown>, Stop> {
        let from = &self.plan.from;
        Ok(match (&mut self.input, &self.plan.content) {
            (FrameReceiver::Hashes(ahead), FrameContent::Hashes(channels)) => {
                ahead.next(|stamp| stamp.window, may)?.and_then(|frame| {
                    let rows = frame.values();
                    show(*frame.header(), &mut |at| observer.hashes(from, at, channels, rows))
                })
            }
            (FrameReceiver::Messages(pieces), FrameContent::Messages(channels)) => {
                pieces.next(may)?.and_then(|MessagesHeader { stamp, more }| match more {
                    0 => show(stamp, &mut |at| {
                        let count = channels.len();
                        pieces.show(count, |all| observer.messages(from, at, channels, all))
                    }),
                    _ => Some((stamp, Ok(()))),
                })
            }
            _ => None,
        })
    }
}

fn moment(clock: &Clock, stamp: Stamp) -> Moment {
    Moment { stamp, time: clock.seconds(stamp.ticks) }
}

fn wrong<S: ChannelMedium>(context: &Context<S>, error: ObserverError) -> Stop {
    Stop::Fault(Fault {
        kind: match error {
            ObserverError::Output(_) => FaultKind::Output,
            ObserverError::Other(_) => FaultKind::Solver,
        },
        noticed_by: context.component.clone(),
        blamed: context.component.clone(),
        window: context.window,
        message: error.to_string(),
    })
}
