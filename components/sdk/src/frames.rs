//! Frames for observers: sent by physics at the rate that the plan sets, never at the physics'
//! cost.

use crate::context::Context;
use crate::sent::SentMessages;
use crate::stop::Stop;
use tremie_channels::{ChannelError, ChannelMedium, ChannelSpec, Ringer, Sender};
use tremie_messages::frame::{
    BodySample, LoadSample, MessagesHeader, ProfileBin, ProfileHeader, SliceHeader, SliceNode,
    SurfaceSample, VolumeHeader,
};
use tremie_messages::start::{FrameContent, FrameStream, Reply, VolumeGrid};
use tremie_messages::units::wait;
use tremie_messages::{BodyEvent, BodyState, Stamp};

/// A stream of frames to one observer.
enum Stream<S: ChannelMedium> {
    Bodies(Sender<S, Stamp, BodySample>),
    Surfaces(Sender<S, Stamp, SurfaceSample>),
    Loads(Sender<S, Stamp, LoadSample>),
    Slice(String, Sender<S, SliceHeader, SliceNode>),
    Volume(VolumeGrid, Sender<S, VolumeHeader, SliceNode>),
    Profile(String, Sender<S, ProfileHeader, ProfileBin>),
    Signals(Sender<S, Stamp, f64>),
    Hashes(Sender<S, Stamp, u64>),
    Messages(Sender<S, MessagesHeader, u8>),
}

struct Outlet<S: ChannelMedium> {
    plan: FrameStream,
    stream: Stream<S>,
    ringer: Ringer<S>,
    /// Window of the frame before.
    sent: Option<u64>,
    broken: bool,
}

/// All frames that a component sends.
pub struct Frames<S: ChannelMedium> {
    outlets: Vec<Outlet<S>>,
}

/// The channel of a stream, as both ends must open it.
/// An observer looks at one frame after the other.
pub fn frame_spec(plan: &FrameStream) -> ChannelSpec<'_> {
    ChannelSpec {
        service: &plan.service,
        capacity: plan.capacity as usize,
        depth: plan.depth as usize,
        borrowed: 1,
        lossless: plan.lossless,
    }
}

/// Frames that a component can show.
pub trait FrameSource {
    /// Bodies, as they are, and what is known of each.
    fn bodies(&self, _states: &mut Vec<BodyState>, _kinds: &mut Vec<BodyEvent>) {}
    /// All vertices of deformable surfaces, as they are.
    fn surfaces(&mut self, _samples: &mut [SurfaceSample]) {}
    /// Loads on all bodies, as they are.
    fn loads(&self, _samples: &mut Vec<LoadSample>) {}
    /// A cut through a field.
    fn slice(&mut self, _name: &str, _nodes: &mut [SliceNode]) -> SliceHeader {
        SliceHeader::default()
    }
    /// Nodes of a lattice.
    fn volume(&mut self, _grid: &VolumeGrid, _nodes: &mut [SliceNode]) -> VolumeHeader {
        VolumeHeader::default()
    }
    /// True if there is a table of a profile to send; with `is_last` also one that goes on.
    fn has_profile(&self, _name: &str, _is_last: bool) -> bool {
        false
    }
    /// That table.
    fn profile(&mut self, _name: &str, _bins: &mut [ProfileBin]) -> ProfileHeader {
        ProfileHeader::default()
    }
}

impl<S: ChannelMedium> Frames<S> {
    /// Opens the sending ends of all streams of this component.
    pub fn open(context: &Context<S>) -> Result<Self, Stop> {
        // A share of the deadline: an observer that takes nothing is given up before the component
        // that waits for it counts as hung itself.
        let patience = wait(context.assignment.transport.deadline / 4.0);
        let open = &context.attachment;
        let mine = |plan: &&FrameStream| plan.from == context.component;
        let mut outlets = Vec::new();
        for plan in context.assignment.frames.iter().filter(mine) {
            let spec = frame_spec(plan);
            let stream = match &plan.content {
                FrameContent::Bodies => Stream::Bodies(open.sender_with_patience(spec, patience)?),
                FrameContent::Surfaces => {
                    Stream::Surfaces(open.sender_with_patience(spec, patience)?)
                }
                FrameContent::Loads => Stream::Loads(open.sender_with_patience(spec, patience)?),
                FrameContent::Slice(name) => {
                    Stream::Slice(name.clone(), open.sender_with_patience(spec, patience)?)
                }
                FrameContent::Volume(grid) => {
                    Stream::Volume(grid.clone(), open.sender_with_patience(spec, patience)?)
                }
                FrameContent::Profile(name) => {
                    Stream::Profile(name.clone(), open.sender_with_patience(spec, patience)?)
                }
                FrameContent::Signals(_) => {
                    Stream::Signals(open.sender_with_patience(spec, patience)?)
                }
                FrameContent::Hashes(_) => {
                    Stream::Hashes(open.sender_with_patience(spec, patience)?)
                }
                FrameContent::Messages(_) => {
                    Stream::Messages(open.sender_with_patience(spec, patience)?)
                }
                FrameContent::Timings(_) | FrameContent::Log => continue,
            };
            outlets.push(Outlet {
                plan: plan.clone(),
                stream,
                ringer: Ringer::of(&context.attachment, &plan.to)?,
                sent: None,
                broken: false,
            });
        }
        Ok(Self { outlets })
    }

    /// True if an observer is to see the signals of a window.
    pub fn show_signals(&self, window: u64) -> bool {
        self.outlets.iter().any(|outlet| {
            let shows = matches!(outlet.stream, Stream::Signals(_)) && !outlet.broken;
            shows && window.is_multiple_of(outlet.plan.every)
        })
    }

    /// Sends the frames that are due at the end of the present window. With it the window has ended for
    /// the messages that were sent.
    ///
    /// An observer that takes nothing is given up, and the orchestrator told so: observers never
    /// stop the physics.
    pub fn send(
        &mut self,
        context: &mut Context<S>,
        shown: &mut impl FrameSource,
        signals: &[f64],
    ) {
        // Taken out while frames take from it; nothing is sent between components meanwhile.
        let mut sent = context.sent.take();
        sent.end_window(context.window);
        let mut have_rows = false;
        for index in 0..self.outlets.len() {
            if self.outlets[index].is_due(context.window, shown) {
                have_rows |= matches!(self.outlets[index].stream, Stream::Hashes(_));
                self.send_one(index, context, shown, (signals, &sent));
            }
        }
        if have_rows {
            sent.forget_rows();
        }
        sent.forget_copies();
        context.sent.replace(sent);
    }

    /// Where a run goes on: sends a frame of each stream, so that observers' ends of the channels begin.
    /// Observers that go on, too, have seen the window. Signals have no values, and profiles no
    /// samples: to measure them again would change what comes next. No message is told again.
    pub fn send_again(
        &mut self,
        context: &mut Context<S>,
        shown: &mut impl FrameSource,
        signals: usize,
    ) {
        let values = vec![f64::NAN; signals];
        let more = (&values[..], &SentMessages::default());
        for index in 0..self.outlets.len() {
            match &self.outlets[index].stream {
                Stream::Profile(..) => self.send_one(index, context, &mut NoProfile, more),
                _ => self.send_one(index, context, shown, more),
            }
        }
    }

    /// Sends those frames of the present window that were not due: it turned out to be the last,
    /// and observers shall see how the run ended.
    pub fn send_last(
        &mut self,
        context: &mut Context<S>,
        shown: &mut impl FrameSource,
        signals: &[f64],
    ) {
        let sent = context.sent.take();
        for index in 0..self.outlets.len() {
            let outlet = &self.outlets[index];
            if outlet.sent != Some(context.window) && outlet.has_last(shown) {
                self.send_one(index, context, shown, (signals, &sent));
            }
        }
    }

    /// Sends a frame of outlet `index`; `more` is what a component shows besides its solver: values of
    /// signals, and the messages that it has sent.
    fn send_one(
        &mut self,
        index: usize,
        context: &mut Context<S>,
        shown: &mut impl FrameSource,
        more: (&[f64], &SentMessages),
    ) {
        let outlet = &mut self.outlets[index];
        if outlet.broken {
            return;
        }
        outlet.sent = Some(context.window);
        let sent = outlet.send(context.stamp(context.window), shown, more);
        if let Err(error) = sent.and_then(|()| outlet.ringer.ring()) {
            self.give_up(index, &error, context);
        }
    }

    /// Sends nothing more to the observer of outlet `index`, on any of its streams.
    fn give_up(&mut self, index: usize, error: &ChannelError, context: &mut Context<S>) {
        let observer = self.outlets[index].plan.to.clone();
        for outlet in self.outlets.iter_mut().filter(|outlet| outlet.plan.to == observer) {
            outlet.broken = true;
        }
        let _ = context.line().reply(&Reply::GaveUp { observer, why: error.to_string() });
    }
}

/// A component whose profiles have no samples.
struct NoProfile;

impl FrameSource for NoProfile {}

impl<S: ChannelMedium> Outlet<S> {
    /// True if a frame is due at the end of a window. A table of a profile is when it has ended; one
    /// without samples, of the start exchange, lets the observer's end of the channel begin.
    fn is_due(&self, window: u64, shown: &impl FrameSource) -> bool {
        match &self.stream {
            Stream::Profile(name, _) => window == 0 || shown.has_profile(name, false),
            _ => window.is_multiple_of(self.plan.every),
        }
    }

    /// True if the run's last window has a frame, though none was due.
    fn has_last(&self, shown: &impl FrameSource) -> bool {
        match &self.stream {
            Stream::Profile(name, _) => shown.has_profile(name, true),
            _ => true,
        }
    }

    fn send(
        &self,
        stamp: Stamp,
        shown: &mut impl FrameSource,
        (signals, sent): (&[f64], &SentMessages),
    ) -> Result<(), ChannelError> {
        match &self.stream {
            Stream::Signals(sender) => sender.send_copy(stamp, signals),
            Stream::Hashes(sender) => sender.send_copy(stamp, sent.rows()),
            Stream::Messages(sender) => {
                let mut rest = sent.copies();
                loop {
                    let piece;
                    (piece, rest) = rest.split_at(rest.len().min(self.plan.capacity as usize));
                    let more = u64::from(!rest.is_empty());
                    sender.send_copy(MessagesHeader { stamp, more }, piece)?;
                    if rest.is_empty() {
                        return Ok(());
                    }
                    // The next may find the channel full while the observer sleeps.
                    self.ringer.ring()?;
                }
            }
            Stream::Surfaces(sender) => {
                let mut loan = sender.loan(self.plan.capacity as usize)?;
                shown.surfaces(loan.values());
                loan.send(stamp)
            }
            Stream::Loads(sender) => {
                let mut samples = Vec::new();
                shown.loads(&mut samples);
                sender.send_copy(stamp, &samples)
            }
            Stream::Slice(name, sender) => {
                let mut loan = sender.loan(self.plan.capacity as usize)?;
                let header = shown.slice(name, loan.values());
                loan.send(SliceHeader { stamp, ..header })
            }
            Stream::Volume(grid, sender) => {
                let mut loan = sender.loan(self.plan.capacity as usize)?;
                let header = shown.volume(grid, loan.values());
                loan.send(VolumeHeader { stamp, ..header })
            }
            Stream::Profile(name, sender) => {
                let mut loan = sender.loan(self.plan.capacity as usize)?;
                let header = shown.profile(name, loan.values());
                loan.send(ProfileHeader { stamp, ..header })
            }
            Stream::Bodies(sender) => {
                let (mut states, mut kinds) = (Vec::new(), Vec::new());
                shown.bodies(&mut states, &mut kinds);
                let mut loan = sender.loan(states.len())?;
                for ((sample, state), kind) in loan.values().iter_mut().zip(&states).zip(&kinds) {
                    *sample = BodySample {
                        state: *state,
                        radius: kind.size[0],
                        mass: kind.mass,
                        set: kind.set,
                        shape: kind.shape,
                        motion: kind.motion,
                        part: kind.table as u32,
                    };
                }
                loan.send(stamp)
            }
        }
    }
}
