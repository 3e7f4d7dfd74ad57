//! An observer's life: hello, assignment, frames, end.

use crate::context::Context;
use crate::frames::frame_spec;
use crate::line::ControlPipe;
use crate::observer::{Moment, Observer, ObserverError};
use crate::program::Participant;
use crate::serve::{Assigned, panic_text};
use crate::setup::Setup;
use crate::stop::Stop;
use std::marker::PhantomData;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};
use tremie_channels::{ChannelError, ChannelMedium, Receiver};
use tremie_messages::frame::{
    BodySample, LogHeader, ProfileBin, ProfileHeader, SliceHeader, SliceNode, SurfaceSample,
    VolumeHeader,
};
use tremie_messages::start::{
    Clock, Description, Fault, FaultKind, FrameContent, FrameStream, Reply,
};
use tremie_messages::{Problem, Role, Stamp};

/// Sleep of an observer when there is nothing to see and nobody rings.
const NAP: Duration = Duration::from_millis(50);
/// Time between the signs of an observer at the run's end that it is still taking frames.
const PULSE: Duration = Duration::from_millis(500);

enum FrameReceiver<S: ChannelMedium> {
    Bodies(Receiver<S, Stamp, BodySample>),
    Surfaces(Receiver<S, Stamp, SurfaceSample>),
    Slice(Receiver<S, SliceHeader, SliceNode>),
    Volume(Receiver<S, VolumeHeader, SliceNode>),
    Profile(Receiver<S, ProfileHeader, ProfileBin>),
    Signals(Receiver<S, Stamp, f64>),
    Log(Receiver<S, LogHeader, u8>),
}

struct Inlet<S: ChannelMedium> {
    plan: FrameStream,
    input: FrameReceiver<S>,
    /// Window of the frame before, to count those that were lost.
    before: Option<u64>,
    lost: u64,
}

/// Stamp of a frame, and what the observer said of it.
type Shown = (Stamp, Result<(), ObserverError>);

/// An observer as a component of a run.
pub struct AsObserver<T>(PhantomData<T>);

impl<T: Observer> Participant for AsObserver<T> {
    const ROLE: Role = Role::Observer;
    const PROGRAM: &'static str = T::PROGRAM;

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
    (hello, assignment, _): Assigned,
) -> Result<(), String> {
    let setup = Setup { hello: hello.clone(), assignment: Some(assignment.clone()) };
    let opened = catch_unwind(AssertUnwindSafe(|| O::open(&setup)))
        .unwrap_or_else(|panic| Err(ObserverError::Other(panic_text(&*panic))));
    let mut observer = match opened {
        Ok(observer) => observer,
        Err(error) => {
            let problem =
                Problem::new(format!("components.{}", hello.component), error.to_string());
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
    let ended = catch_unwind(AssertUnwindSafe(|| watch(&mut observer, &mut context)))
        .unwrap_or_else(|panic| {
            Err(context.fault(FaultKind::Solver, &context.component, panic_text(&*panic)))
        });
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
) -> Result<(u64, String), Stop> {
    let mut inlets = open_inlets(context)?;
    let gone = |_| Stop::Aborted;
    context.line().reply(&Reply::Ready {}).map_err(gone)?;
    let mut watching = false;
    let mut told = Instant::now();
    loop {
        // Asked before the last look: what was sent before the request is then surely seen.
        let finishing = context.finish_requested()?;
        let mut seen = false;
        // One frame of each stream after the other, so that no stream runs far ahead.
        for inlet in &mut inlets {
            seen |= inlet.show_next(observer, context)?;
            if finishing && seen && told.elapsed() > PULSE {
                told = Instant::now();
                context.line().reply(&Reply::Busy {}).map_err(gone)?;
            }
        }
        if !watching && inlets.iter().all(Inlet::has_begun) {
            watching = true;
            context.line().reply(&Reply::Watching {}).map_err(gone)?;
        }
        if finishing && !seen {
            context.line().reply(&Reply::Busy {}).map_err(gone)?;
            return close(observer, context, &inlets);
        }
        if !seen {
            context.rest(NAP)?;
        }
    }
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
        let spec = frame_spec(plan);
        let attachment = &context.attachment;
        let input = match &plan.content {
            FrameContent::Bodies => FrameReceiver::Bodies(attachment.receiver(spec)?),
            FrameContent::Surfaces => FrameReceiver::Surfaces(attachment.receiver(spec)?),
            FrameContent::Slice(_) => FrameReceiver::Slice(attachment.receiver(spec)?),
            FrameContent::Volume(_) => FrameReceiver::Volume(attachment.receiver(spec)?),
            FrameContent::Profile(_) => FrameReceiver::Profile(attachment.receiver(spec)?),
            FrameContent::Signals(_) => FrameReceiver::Signals(attachment.receiver(spec)?),
            FrameContent::Log => FrameReceiver::Log(attachment.receiver(spec)?),
        };
        inlets.push(Inlet { plan: plan.clone(), input, before: None, lost: 0 });
    }
    Ok(inlets)
}

impl<S: ChannelMedium> Inlet<S> {
    /// True if a first frame has come. Lines of the log come when they come.
    fn has_begun(&self) -> bool {
        self.before.is_some() || self.plan.content == FrameContent::Log
    }

    /// Shows the observer the next frame, if one has arrived; returns whether.
    fn show_next<O: Observer>(
        &mut self,
        observer: &mut O,
        context: &mut Context<S>,
    ) -> Result<bool, Stop> {
        let Some(stamp) = self.show_one(observer, context)? else {
            return Ok(false);
        };
        context.window = stamp.window;
        if self.plan.content != FrameContent::Log {
            let is_profile = matches!(self.plan.content, FrameContent::Profile(_));
            let step = self.before.map_or(0, |before| stamp.window.saturating_sub(before));
            // Tables end when they do.
            let skipped = (step / self.plan.every.max(1)).saturating_sub(1);
            self.lost += if is_profile { 0 } else { skipped };
            self.before = Some(stamp.window);
        }
        Ok(true)
    }

    fn show_one<O: Observer>(
        &self,
        observer: &mut O,
        context: &Context<S>,
    ) -> Result<Option<Stamp>, Stop> {
        match self.take(observer, &context.assignment.clock)? {
            None => Ok(None),
            Some((stamp, Ok(()))) => Ok(Some(stamp)),
            Some((_, Err(error))) => Err(wrong(context, error)),
        }
    }

    /// Shows the observer the next frame, if one has arrived: its stamp, and what the observer said.
    fn take<O: Observer>(
        &self,
        observer: &mut O,
        clock: &Clock,
    ) -> Result<Option<Shown>, ChannelError> {
        let from = &self.plan.from;
        Ok(match (&self.input, &self.plan.content) {
            (FrameReceiver::Bodies(receiver), _) => receiver.take()?.map(|message| {
                let at = moment(clock, *message.header());
                (at.stamp, observer.bodies(from, at, message.values()))
            }),
            (FrameReceiver::Surfaces(receiver), _) => receiver.take()?.map(|message| {
                let at = moment(clock, *message.header());
                (at.stamp, observer.surfaces(from, at, message.values()))
            }),
            (FrameReceiver::Slice(receiver), FrameContent::Slice(name)) => {
                receiver.take()?.map(|message| {
                    let at = moment(clock, message.header().stamp);
                    (at.stamp, observer.slice(from, name, at, message.header(), message.values()))
                })
            }
            (FrameReceiver::Volume(receiver), FrameContent::Volume(grid)) => {
                receiver.take()?.map(|message| {
                    let (header, name) = (message.header(), &grid.name);
                    let at = moment(clock, header.stamp);
                    (at.stamp, observer.volume(from, name, at, header, message.values()))
                })
            }
            (FrameReceiver::Profile(receiver), FrameContent::Profile(name)) => {
                receiver.take()?.map(|message| {
                    let (header, at) = (message.header(), moment(clock, message.header().stamp));
                    let shown = match header.samples {
                        0 => Ok(()),
                        _ => observer.profile(from, name, at, header, message.values()),
                    };
                    (at.stamp, shown)
                })
            }
            (FrameReceiver::Signals(receiver), FrameContent::Signals(names)) => {
                receiver.take()?.map(|message| {
                    let at = moment(clock, *message.header());
                    (at.stamp, observer.signals(from, at, names, message.values()))
                })
            }
            (FrameReceiver::Log(receiver), _) => receiver.take()?.map(|message| {
                let at = moment(clock, message.header().stamp);
                let text = String::from_utf8_lossy(message.values());
                (at.stamp, observer.log(at, message.header(), &text))
            }),
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
