//! A player: stands for a component of a run, sends what that sent in a recorded run, and compares what
//! comes with what came then.
//!
//! It follows the script of the component for which it stands. Inside a window, where no script says what
//! comes next, the recorded stamps do: substep by substep, trial by trial.

use crate::context::Context;
use crate::frames::FrameSource;
use crate::line::ControlPipe;
use crate::ports::{InPort, OutPort};
use crate::role_adapter::RoleAdapter;
use crate::serve::serve;
use crate::setup::Setup;
use crate::stop::Stop;
use crate::substep_coupling::turn;
use tremie_channels::{ChannelMedium, InProcess, SharedMemory};
use tremie_messages::schedule::{Content, Edge};
use tremie_messages::start::{Description, FaultKind, Reply, Request};
use tremie_messages::{
    BodyEvent, BodyState, FacetLoad, Load, Message, Place, PortState, Problem, Stamp,
    SurfaceVertex, bytes_of, values_of,
};
use tremie_state::{StateError, StateExchange};

/// A message of a recorded run.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedMessage {
    /// Its stamp; the run's id is 0.
    pub stamp: Stamp,
    /// Its values as they lie in memory.
    pub values: Vec<u8>,
}

/// Recorded messages of the component for which a player stands.
pub trait RecordedMessages: Sized {
    /// Name of the player's program.
    const PROGRAM: &'static str;

    /// Description of the component.
    ///
    /// # Errors
    /// Problems of the parameters.
    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>>;

    /// Opens the recording.
    ///
    /// # Errors
    /// Problems of the parameters, or of the recording.
    fn open(setup: &Setup) -> Result<Self, Vec<Problem>>;

    /// The messages of a window on an edge of the component, in the order of sending. Windows are asked
    /// for in order, or some windows late.
    ///
    /// # Errors
    /// A sentence: the recording cannot be read, or ends before.
    fn messages(&mut self, window: u64, edge: &Edge) -> Result<Vec<RecordedMessage>, String>;

    /// The last window that is compared. In those after it, the recorded run had another manifest.
    fn last_compared(&self) -> u64;

    /// What differs between the values of a recorded message and of the one that came, in a sentence;
    /// `None` if nothing does. Asked only where their bytes differ.
    fn difference(content: Content, recorded: &[u8], found: &[u8]) -> Option<String>;
}

/// Plays a component of a recorded run, over `line`.
///
/// # Errors
/// A sentence for standard error.
pub fn play_recorded<M: RecordedMessages>(mut line: ControlPipe) -> Result<(), String> {
    let hello = match line.next_request()? {
        Request::Hello(hello) => *hello,
        Request::Quit {} => return Ok(()),
        Request::Assignment(_) => return Err("an assignment came before the hello".into()),
    };
    let description = match M::describe(&Setup { hello: hello.clone(), assignment: None }) {
        Ok(description) => description,
        Err(problems) => {
            return line.reply(&Reply::Refusal { problems }).map_err(|e| e.to_string());
        }
    };
    line.reply(&Reply::Description(Box::new(description.clone()))).map_err(|e| e.to_string())?;
    let assignment = match line.next_request()? {
        Request::Assignment(assignment) => *assignment,
        Request::Quit {} => return Ok(()),
        Request::Hello(_) => return Err("a second hello came instead of an assignment".into()),
    };
    let is_between_processes = assignment.transport.between_processes;
    let assigned = (hello, assignment, description);
    if is_between_processes {
        serve::<SharedMemory, Player<SharedMemory, M>>(line, assigned)
    } else {
        serve::<InProcess, Player<InProcess, M>>(line, assigned)
    }
}

/// What differs between the values of a recorded message and of the one that came.
type Difference<'a> = dyn Fn(&[u8], &[u8]) -> Option<String> + 'a;

/// A sending end of any content.
trait Outgoing<S: ChannelMedium> {
    fn connect(&self) -> Result<(), Stop>;
    /// Sends a recorded message; rings only where the receiver may sleep.
    fn send(&self, context: &Context<S>, message: &RecordedMessage, ring: bool)
    -> Result<(), Stop>;
}

/// A receiving end of any content.
trait Incoming<S: ChannelMedium> {
    /// Waits for the message that the recording foretells, whose place inside the window is `turn`:
    /// the stamp that came, and what differs.
    fn take(
        &self,
        context: &mut Context<S>,
        expected: &RecordedMessage,
        turn: u64,
        difference: &Difference<'_>,
    ) -> Result<(Stamp, Option<String>), Stop>;
}

impl<S: ChannelMedium, T: Message> Outgoing<S> for OutPort<S, T> {
    fn connect(&self) -> Result<(), Stop> {
        OutPort::connect(self)
    }

    fn send(
        &self,
        context: &Context<S>,
        message: &RecordedMessage,
        ring: bool,
    ) -> Result<(), Stop> {
        let values = values_of::<T>(&message.values).unwrap_or_default();
        let stamp = Stamp { run: context.run, ..message.stamp };
        self.send_recorded(context, &values, stamp, ring)
    }
}

impl<S: ChannelMedium, T: Message> Incoming<S> for InPort<S, T> {
    fn take(
        &self,
        context: &mut Context<S>,
        expected: &RecordedMessage,
        turn: u64,
        difference: &Difference<'_>,
    ) -> Result<(Stamp, Option<String>), Stop> {
        let stamp = Stamp { run: context.run, ..expected.stamp };
        let message = self.next(context, stamp, turn)?;
        let found = bytes_of(message.values());
        let differs = found != expected.values;
        let what = || {
            difference(&expected.values, found).unwrap_or_else(|| "some of its bits differ".into())
        };
        Ok((*message.header(), differs.then(what)))
    }
}

/// The ends of one edge: this component sends, or receives.
enum End<S: ChannelMedium> {
    Out(Box<dyn Outgoing<S>>),
    In(Box<dyn Incoming<S>>),
}

impl<S: ChannelMedium> End<S> {
    fn open(context: &Context<S>, edge: &Edge) -> Result<Self, Stop> {
        match edge.content {
            Content::Events => Self::of::<BodyEvent>(context, edge),
            Content::State | Content::Carrier => Self::of::<BodyState>(context, edge),
            Content::Load | Content::Resultant => Self::of::<Load>(context, edge),
            Content::Ports => Self::of::<PortState>(context, edge),
            Content::Surface | Content::Trial => Self::of::<SurfaceVertex>(context, edge),
            Content::SurfaceLoad | Content::Contact => Self::of::<FacetLoad>(context, edge),
        }
    }

    fn of<T: Message>(context: &Context<S>, edge: &Edge) -> Result<Self, Stop> {
        Ok(if edge.from == context.component {
            Self::Out(Box::new(OutPort::<S, T>::open(context, edge)?))
        } else {
            Self::In(Box::new(InPort::<S, T>::open(context, edge)?))
        })
    }
}

/// A player with its edges.
struct Player<S: ChannelMedium, M: RecordedMessages> {
    recorded: M,
    edges: Vec<(Edge, End<S>)>,
    signals: usize,
}

impl<S: ChannelMedium, M: RecordedMessages> FrameSource for Player<S, M> {}

impl<S: ChannelMedium, M: RecordedMessages> RoleAdapter<S> for Player<S, M> {
    fn create(setup: &Setup) -> Result<Self, Vec<Problem>> {
        let signals = M::describe(setup)?.signals.len();
        Ok(Self { recorded: M::open(setup)?, edges: Vec::new(), signals })
    }

    fn open(&mut self, context: &Context<S>) -> Result<(), Stop> {
        let edges = context.assignment.edges.iter();
        let opened = edges.map(|edge| Ok((edge.clone(), End::open(context, edge)?)));
        self.edges = opened.collect::<Result<_, Stop>>()?;
        Ok(())
    }

    fn connect(&mut self) -> Result<(), Stop> {
        self.edges.iter().try_for_each(|(_, end)| match end {
            End::Out(port) => port.connect(),
            End::In(_) => Ok(()),
        })
    }

    fn receive(
        &mut self,
        context: &mut Context<S>,
        content: Content,
        lag: u64,
    ) -> Result<(), Stop> {
        let window = context.window - lag;
        let Some(place) = self.edge_of(content) else { return Ok(()) };
        let message = self.only(context, place, window)?;
        self.take(context, place, &message, 0)
    }

    fn advance(&mut self, context: &mut Context<S>) -> Result<(), Stop> {
        let is_inside = |(edge, _): &(Edge, End<S>)| edge.content.is_inside_window();
        if context.window > self.recorded.last_compared() && self.edges.iter().any(is_inside) {
            // The recorded trials answer another manifest: there may be fewer than are waited for.
            let why = format!("the run was changed after window {}", self.recorded.last_compared());
            return Err(context.fault(FaultKind::Replay, &context.component, why));
        }
        let mut all = Vec::new();
        for place in 0..self.edges.len() {
            let content = self.edges[place].0.content;
            if content.is_inside_window() {
                let messages = self.of_window(context, place, context.window)?;
                all.extend(messages.into_iter().map(|message| (place, content, message)));
            }
        }
        all.sort_by_key(|(_, content, message)| inside_order(*content, &message.stamp));
        for (place, content, message) in &all {
            match &self.edges[*place].1 {
                End::Out(port) => port.send(context, message, *content == Content::Carrier)?,
                End::In(_) => {
                    let Stamp { substep, .. } = message.stamp;
                    let is_answer = matches!(content, Content::Contact | Content::Resultant);
                    let turn = turn(substep, message.stamp.trial(), is_answer);
                    self.take(context, *place, message, turn)?;
                }
            }
        }
        Ok(())
    }

    fn send(&mut self, context: &mut Context<S>, content: Content) -> Result<(), Stop> {
        self.send_again(context, content)
    }

    fn send_again(&mut self, context: &Context<S>, content: Content) -> Result<(), Stop> {
        let Some(place) = self.edge_of(content) else { return Ok(()) };
        let message = self.only(context, place, context.window)?;
        match &self.edges[place].1 {
            End::Out(port) => port.send(context, &message, true),
            End::In(_) => Ok(()),
        }
    }

    fn keeps_state() -> bool {
        false
    }

    /// Nothing: the next messages follow from the window, and the state of the component for which it stands
    /// is passed over.
    fn exchange_state(&mut self, _: &mut StateExchange<'_>) -> Result<(), StateError> {
        Ok(())
    }

    fn signals(&mut self, values: &mut Vec<f64>, _: bool) {
        values.resize(self.signals, f64::NAN);
    }

    fn place(&self, _: &str) -> Option<Place> {
        None
    }

    fn work(&self) -> u64 {
        0
    }
}

/// Place of a message in the exchange inside a window.
fn inside_order(content: Content, stamp: &Stamp) -> (u32, u32, u8) {
    let rank = match content {
        Content::Carrier => 0,
        Content::Trial => 1,
        Content::Contact => 2,
        _ => 3,
    };
    (stamp.substep, stamp.trial(), rank)
}

impl<S: ChannelMedium, M: RecordedMessages> Player<S, M> {
    /// Place of the edge that carries a content.
    fn edge_of(&self, content: Content) -> Option<usize> {
        self.edges.iter().position(|(edge, _)| edge.content == content)
    }

    /// The recorded messages of a window on an edge.
    fn of_window(
        &mut self,
        context: &Context<S>,
        place: usize,
        window: u64,
    ) -> Result<Vec<RecordedMessage>, Stop> {
        let found = self.recorded.messages(window, &self.edges[place].0);
        found.map_err(|why| context.fault(FaultKind::Solver, &context.component, why))
    }

    /// The one recorded message of a window on an edge.
    fn only(
        &mut self,
        context: &Context<S>,
        place: usize,
        window: u64,
    ) -> Result<RecordedMessage, Stop> {
        let mut found = self.of_window(context, place, window)?;
        let count = found.len();
        found.pop().filter(|_| count == 1).ok_or_else(|| {
            let label = self.edges[place].0.label();
            let why = format!(
                "the recording has {count} messages of {label}, window {window}, expected one"
            );
            context.fault(FaultKind::Solver, &context.component, why)
        })
    }

    /// Takes a message, and compares it with the recorded one.
    fn take(
        &self,
        context: &mut Context<S>,
        place: usize,
        recorded: &RecordedMessage,
        turn: u64,
    ) -> Result<(), Stop> {
        let (edge, End::In(port)) = &self.edges[place] else { return Ok(()) };
        let difference =
            |recorded: &[u8], found: &[u8]| M::difference(edge.content, recorded, found);
        let (stamp, differs) = port.take(context, recorded, turn, &difference)?;
        if recorded.stamp.window > self.recorded.last_compared() {
            return Ok(());
        }
        let expected = Stamp { run: context.run, ..recorded.stamp };
        let what = match differs {
            _ if stamp != expected => format!("it was recorded as {expected}, and came as {stamp}"),
            Some(what) => what,
            None => return Ok(()),
        };
        let inside = match turn {
            0 => String::new(),
            _ => format!(", substep {}, trial {}", recorded.stamp.substep, recorded.stamp.trial()),
        };
        let (label, window) = (edge.label(), recorded.stamp.window);
        let text = format!("{label}, window {window}{inside}: {what}");
        Err(context.fault(FaultKind::Replay, &edge.from, text))
    }
}
