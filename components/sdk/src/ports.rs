//! Ends of the edges between components: checked where they are received, damaged on purpose where
//! a test asks for it.

use crate::context::{Context, Owed};
use crate::finite::{Finite, OfBody};
use crate::stop::Stop;
use std::cell::{Cell, RefCell};
use tremie_channels::{
    ChannelError, ChannelMedium, ChannelSpec, Loan, Received, Receiver, Ringer, Sender,
};
use tremie_messages::schedule::{Content, Edge, Op};
use tremie_messages::start::{FaultKind, InjectionKind};
use tremie_messages::{FacetLoad, Message, PortState, Stamp, bytes_of, values_of};
use tremie_state::{StateError, StateExchange};

/// The receiving end of an edge.
pub struct InPort<S: ChannelMedium, T: Message> {
    edge: Edge,
    receiver: Receiver<S, Stamp, T>,
    /// Event lists by which the next message lags behind its window: in the first window after a change of
    /// the schedule, still as many as before.
    list_lag: Cell<u64>,
}

/// The sending end of an edge.
pub struct OutPort<S: ChannelMedium, T: Message> {
    edge: Edge,
    sender: Sender<S, Stamp, T>,
    ringer: Ringer<S>,
    /// Its place among the channels whose messages an observer asks for.
    told: Option<usize>,
    /// The message of a checkpoint's window, where its receiver takes it in the next: it is sent again
    /// when the run goes on from there.
    under_way: Option<RefCell<Vec<T>>>,
    /// Event lists by which that message lags behind its window.
    list_lag: u64,
}

/// What was taken from an edge last, until the next is taken: in the sender's memory, or put back from a
/// checkpoint.
pub enum Taken<S: ChannelMedium, T: Message> {
    /// Nothing yet, or given back.
    Nothing,
    /// A message.
    Message(Received<S, Stamp, T>),
    /// The values of a message that was taken before the checkpoint from which the run goes on.
    PutBack(Vec<T>),
}

impl<S: ChannelMedium, T: Message> Taken<S, T> {
    /// The values, if there was a message.
    pub fn values(&self) -> Option<&[T]> {
        match self {
            Self::Nothing => None,
            Self::Message(message) => Some(message.values()),
            Self::PutBack(values) => Some(values),
        }
    }

    /// Keeps the values, or puts them back.
    ///
    /// # Errors
    /// A damaged state.
    pub fn exchange(
        &mut self,
        name: &str,
        state: &mut StateExchange<'_>,
    ) -> Result<(), StateError> {
        let mut values = self.values().map(<[T]>::to_vec);
        exchange_values(name, state, &mut values)?;
        if state.restores() {
            *self = values.map_or(Self::Nothing, Self::PutBack);
        }
        Ok(())
    }
}

/// Keeps by how many lists the message of an edge lags that is under way, or puts it back.
fn exchange_list_lag(
    edge: &Edge,
    state: &mut StateExchange<'_>,
    lag: &mut u64,
) -> Result<(), StateError> {
    state.value(&format!("{}_list_lag", edge.content.name()), lag)
}

/// Keeps the values of a message as they lie in memory, or puts them back.
fn exchange_values<T: Message>(
    name: &str,
    state: &mut StateExchange<'_>,
    values: &mut Option<Vec<T>>,
) -> Result<(), StateError> {
    let mut is_there = values.is_some();
    state.value(&format!("has_{name}"), &mut is_there)?;
    if !is_there {
        *values = None;
        return Ok(());
    }
    let mut bytes = bytes_of(values.as_deref().unwrap_or_default()).to_vec();
    state.list(name, &mut bytes)?;
    *values = values_of(&bytes);
    match values {
        Some(_) => Ok(()),
        None => state.unfit(format!("`{name}` of the state is no whole message")),
    }
}

/// The channel of an edge, as both ends must open it. A receiver keeps what it has until the next
/// has come.
pub fn edge_spec(edge: &Edge) -> ChannelSpec<'_> {
    ChannelSpec {
        service: &edge.service,
        capacity: edge.capacity as usize,
        depth: edge.depth as usize,
        borrowed: 2,
        lossless: true,
    }
}

impl<S: ChannelMedium, T: Message> InPort<S, T> {
    /// Opens the receiving end of `edge`.
    pub fn open(context: &Context<S>, edge: &Edge) -> Result<Self, Stop> {
        let receiver = context.attachment.receiver(edge_spec(edge))?;
        Ok(Self { receiver, edge: edge.clone(), list_lag: Cell::new(edge.events_lag) })
    }

    /// Opens the receiving end of the edge that carries `content`, if there is one.
    pub fn find(context: &Context<S>, content: Content) -> Result<Option<Self>, Stop> {
        context.edge(content).map(|edge| Self::open(context, edge)).transpose()
    }

    /// Waits for the message that the schedule foretells, and checks its stamp.
    pub fn take(&self, context: &mut Context<S>, lag: u64) -> Result<Received<S, Stamp, T>, Stop> {
        let mut expected = context.expected(&self.edge, lag);
        let list_lag = self.list_lag.replace(self.edge.events_lag);
        expected.events = expected.window.saturating_sub(list_lag);
        let message = self.next(context, expected, 0)?;
        self.check(context, message, expected, |found| *found == expected)
    }

    /// Keeps which list of bodies the message answers that is under way at the end of a checkpoint's window,
    /// or puts it back: a run may go on with another schedule.
    ///
    /// # Errors
    /// A damaged state.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        exchange_list_lag(&self.edge, state, self.list_lag.get_mut())
    }

    /// Waits for a message inside the present window, whose place in the exchange is `turn`. Its
    /// stamp is `expected`, or that of an accepted surface where `or_final`.
    pub fn take_inside(
        &self,
        context: &mut Context<S>,
        expected: Stamp,
        turn: u64,
        or_final: bool,
    ) -> Result<Received<S, Stamp, T>, Stop> {
        let message = self.next(context, expected, turn)?;
        let accepted = Stamp { iteration: expected.iteration | Stamp::FINAL, ..expected };
        let is_right = |found: &Stamp| *found == expected || (or_final && *found == accepted);
        self.check(context, message, expected, is_right)
    }

    /// Number of event lists that the content lags behind its own window.
    pub fn events_lag(&self) -> u64 {
        self.edge.events_lag
    }

    /// Name of the sending component.
    pub fn from(&self) -> &str {
        &self.edge.from
    }

    /// Waits for the next message, whatever its stamp; `expected` and `turn` are for words.
    pub fn next(
        &self,
        context: &mut Context<S>,
        expected: Stamp,
        turn: u64,
    ) -> Result<Received<S, Stamp, T>, Stop> {
        let what = || {
            let name = self.edge.content.name();
            match turn {
                0 => format!("{name} of window {}", expected.window),
                _ => format!("{name} of window {}, substep {}", expected.window, expected.substep),
            }
        };
        let window = context.window;
        let look = || {
            let broken = |error| Stop::on_edge(error, &self.edge, &self.edge.to, window);
            self.receiver.take().map_err(broken)
        };
        let owed = Owed { from: &self.edge.from, what: &what, window: expected.window, turn };
        context.wait(&owed, look)
    }

    fn check(
        &self,
        context: &Context<S>,
        message: Received<S, Stamp, T>,
        expected: Stamp,
        is_right: impl Fn(&Stamp) -> bool,
    ) -> Result<Received<S, Stamp, T>, Stop> {
        let found = message.header();
        if is_right(found) {
            return Ok(message);
        }
        let kind = if found.window == expected.window && found.substep != expected.substep {
            FaultKind::Substeps
        } else {
            FaultKind::Stamp
        };
        let text = format!("on {}, expected {expected}; found {found}", self.edge.label());
        Err(context.fault(kind, &self.edge.from, text))
    }

    /// A fault of the sender: a message of another number of values than expected, or with values
    /// that do not fit.
    pub fn miscounted(&self, context: &Context<S>, found: &str) -> Stop {
        let text = format!("on {}, {found}", self.edge.label());
        context.fault(FaultKind::Count, &self.edge.from, text)
    }
}

impl<S: ChannelMedium, T: Finite> InPort<S, T> {
    /// Checks that there are `count` values.
    pub fn check_count(
        &self,
        context: &Context<S>,
        values: &[T],
        count: usize,
    ) -> Result<(), Stop> {
        if values.len() == count {
            return Ok(());
        }
        let text = format!("expected {count} values, found {}", values.len());
        Err(self.miscounted(context, &text))
    }

    /// Checks that all values are finite.
    pub fn check_finite(&self, context: &Context<S>, values: &[T]) -> Result<(), Stop> {
        let Some(place) = T::first_wrong(values) else { return Ok(()) };
        let value = &values[place];
        let (label, owner) = (self.edge.label(), value.owner(place));
        let text = format!("on {label}, the values of {owner} are not finite: {value:?}");
        Err(context.fault(FaultKind::NotFinite, &self.edge.from, text))
    }
}

impl<S: ChannelMedium, T: OfBody> InPort<S, T> {
    /// As [`InPort::take`], and checks that values are finite and belong to the bodies `ids`.
    pub fn take_checked(
        &self,
        context: &mut Context<S>,
        lag: u64,
        ids: impl ExactSizeIterator<Item = u64>,
    ) -> Result<Received<S, Stamp, T>, Stop> {
        let message = self.take(context, lag)?;
        self.check_bodies(context, message.values(), ids)?;
        Ok(message)
    }

    /// Checks that values are finite and belong to the bodies `ids`.
    pub fn check_bodies(
        &self,
        context: &Context<S>,
        values: &[T],
        ids: impl ExactSizeIterator<Item = u64>,
    ) -> Result<(), Stop> {
        self.check_count(context, values, ids.len())?;
        for (value, id) in values.iter().zip(ids) {
            if value.id() != id {
                let text = format!("expected body {id}, found body {}", value.id());
                return Err(self.miscounted(context, &text));
            }
        }
        self.check_finite(context, values)
    }
}

impl<S: ChannelMedium> InPort<S, FacetLoad> {
    /// Checks that loads are finite, and of facets that there are.
    pub fn check_facets(
        &self,
        context: &Context<S>,
        loads: &[FacetLoad],
        facets: usize,
    ) -> Result<(), Stop> {
        if let Some(wrong) = loads.iter().find(|load| load.facet >= facets as u64) {
            let text = format!("expected facets below {facets}, found {}", wrong.facet);
            return Err(self.miscounted(context, &text));
        }
        self.check_finite(context, loads)
    }
}

impl<S: ChannelMedium> InPort<S, PortState> {
    /// As [`InPort::take`], and checks that values are finite and those of the faces `faces`.
    pub fn take_faces(
        &self,
        context: &mut Context<S>,
        lag: u64,
        faces: &[PortState],
    ) -> Result<Received<S, Stamp, PortState>, Stop> {
        let message = self.take(context, lag)?;
        let values = message.values();
        self.check_count(context, values, faces.len())?;
        for (found, expected) in values.iter().zip(faces) {
            if !found.is_of(expected) {
                let text = format!("expected face {expected}, found face {found}");
                return Err(self.miscounted(context, &text));
            }
        }
        self.check_finite(context, values)?;
        Ok(message)
    }
}

impl<S: ChannelMedium, T: Message> OutPort<S, T> {
    /// Opens the sending end of `edge`.
    pub fn open(context: &Context<S>, edge: &Edge) -> Result<Self, Stop> {
        let assignment = &context.assignment;
        let is_own =
            |op: &Op| matches!(op, Op::Send { edge: own } if assignment.edges[*own] == *edge);
        let is_under_way = assignment.script.resume.iter().any(is_own);
        Ok(Self {
            sender: context.attachment.sender(edge_spec(edge))?,
            ringer: Ringer::of(&context.attachment, &edge.to)?,
            told: context.sent.borrow().channel(edge),
            edge: edge.clone(),
            under_way: is_under_way.then(RefCell::default),
            list_lag: edge.events_lag,
        })
    }

    /// Opens the sending end of the edge that carries `content`, if there is one.
    pub fn find(context: &Context<S>, content: Content) -> Result<Option<Self>, Stop> {
        context.edge(content).map(|edge| Self::open(context, edge)).transpose()
    }

    /// Connects to the receiver, once all components are ready.
    pub fn connect(&self) -> Result<(), Stop> {
        self.sender.connect().map_err(|error| self.broken(error, 0))
    }

    /// Loans a message of `count` values.
    pub fn loan(&self, count: usize) -> Result<Loan<S, Stamp, T>, Stop> {
        Ok(self.sender.loan(count)?)
    }

    /// Sends `loan` with the stamp of the present window.
    pub fn send(&self, context: &Context<S>, mut loan: Loan<S, Stamp, T>) -> Result<(), Stop> {
        self.keep_under_way(context, loan.values());
        self.send_and_tell(context, loan, self.stamp(context), true)
    }

    /// Sends a message, and then lets observers know of it: hashing takes time, in which the receiver can
    /// work already.
    fn send_and_tell(
        &self,
        context: &Context<S>,
        loan: Loan<S, Stamp, T>,
        stamp: Stamp,
        ring: bool,
    ) -> Result<(), Stop> {
        let sent = self.sender.send_then(loan, stamp, |values| {
            let rung = if ring { self.ringer.ring() } else { Ok(()) };
            self.tell(context, stamp, values);
            rung
        });
        sent.flatten().map_err(|error| self.broken(error, context.window))
    }

    /// Lets observers that ask know of a message.
    fn tell(&self, context: &Context<S>, stamp: Stamp, values: &[T]) {
        if let Some(channel) = self.told {
            context.sent.borrow_mut().note(channel, &stamp, values);
        }
    }

    /// Remembers the message of a checkpoint's window, if it is under way at the window's end.
    fn keep_under_way(&self, context: &Context<S>, values: &[T]) {
        if context.keeps_state()
            && let Some(kept) = &self.under_way
        {
            kept.replace(values.to_vec());
        }
    }

    /// Keeps the message that is under way at the end of a checkpoint's window, or puts it back.
    ///
    /// # Errors
    /// A damaged state.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let Some(kept) = &mut self.under_way else { return Ok(()) };
        let mut values = Some(kept.take());
        exchange_values(self.edge.content.name(), state, &mut values)?;
        kept.replace(values.unwrap_or_default());
        exchange_list_lag(&self.edge, state, &mut self.list_lag)
    }

    /// Sends the message again that was under way at the end of the checkpoint's window.
    pub fn send_again(&self, context: &Context<S>) -> Result<(), Stop> {
        let Some(kept) = &self.under_way else { return Ok(()) };
        let stamp = context.stamp(context.window.saturating_sub(self.list_lag));
        let sent = self.sender.send_copy(stamp, &kept.borrow());
        let rung = sent.and_then(|()| self.ringer.ring());
        rung.map_err(|error| self.broken(error, context.window))
    }

    /// Sends a message of a recorded run, which observers need not be told again.
    pub fn send_recorded(
        &self,
        context: &Context<S>,
        values: &[T],
        stamp: Stamp,
        ring: bool,
    ) -> Result<(), Stop> {
        let sent = self.sender.send_copy(stamp, values);
        let rung = sent.and_then(|()| if ring { self.ringer.ring() } else { Ok(()) });
        rung.map_err(|error| self.broken(error, context.window))
    }

    fn broken(&self, error: ChannelError, window: u64) -> Stop {
        Stop::on_edge(error, &self.edge, &self.edge.from, window)
    }

    fn stamp(&self, context: &Context<S>) -> Stamp {
        context.stamp(context.window.saturating_sub(self.edge.events_lag))
    }
}

impl<S: ChannelMedium, T: Finite> OutPort<S, T> {
    /// As [`OutPort::send`], after a check that the solver's values are finite, and with the fault
    /// that is injected into this window, if any.
    pub fn send_checked(
        &self,
        context: &Context<S>,
        mut loan: Loan<S, Stamp, T>,
    ) -> Result<(), Stop> {
        self.check_finite(context, loan.values())?;
        match context.injection() {
            None => self.send(context, loan),
            Some(kind) => {
                // Damaged on its way: the state and observers have it as it was.
                self.keep_under_way(context, loan.values());
                self.tell(context, self.stamp(context), loan.values());
                self.send_damaged(loan, self.stamp(context), kind)?;
                Ok(self.ringer.ring()?)
            }
        }
    }

    /// Sends `loan` inside the present window, after a check that its values are finite. Rings only
    /// where the receiver may sleep by now.
    pub fn send_inside(
        &self,
        context: &Context<S>,
        mut loan: Loan<S, Stamp, T>,
        stamp: Stamp,
        ring: bool,
    ) -> Result<(), Stop> {
        self.check_finite(context, loan.values())?;
        self.send_and_tell(context, loan, stamp, ring)
    }

    /// Rings the receiver's bell.
    pub fn ring(&self) -> Result<(), Stop> {
        Ok(self.ringer.ring()?)
    }

    /// Loans a message with these values.
    pub fn loan_copy(&self, values: &[T]) -> Result<Loan<S, Stamp, T>, Stop> {
        let mut loan = self.loan(values.len())?;
        loan.values().copy_from_slice(values);
        Ok(loan)
    }

    fn check_finite(&self, context: &Context<S>, values: &[T]) -> Result<(), Stop> {
        let Some(place) = T::first_wrong(values) else { return Ok(()) };
        let value = &values[place];
        let (name, owner) = (self.edge.content.name(), value.owner(place));
        let text = format!("its {name} of {owner} is not finite: {value:?}");
        Err(context.fault(FaultKind::NotFinite, &context.component, text))
    }

    /// Sends `loan` with a fault of that kind; as it is, where the kind is none of a message.
    pub fn send_damaged(
        &self,
        mut loan: Loan<S, Stamp, T>,
        stamp: Stamp,
        kind: InjectionKind,
    ) -> Result<(), Stop> {
        match kind {
            InjectionKind::Drop => {}
            InjectionKind::Duplicate => {
                let copy = loan.values().to_vec();
                loan.send(stamp)?;
                self.sender.send_copy(stamp, &copy)?;
            }
            InjectionKind::Stale => {
                loan.send(Stamp { window: stamp.window.saturating_sub(1), ..stamp })?;
            }
            InjectionKind::Count => {
                let short = loan.values().len().saturating_sub(1);
                let copy = loan.values()[..short].to_vec();
                drop(loan);
                self.sender.send_copy(stamp, &copy)?;
            }
            InjectionKind::Nan => {
                if let Some(first) = loan.values().first_mut() {
                    first.spoil();
                }
                loan.send(stamp)?;
            }
            _ => loan.send(stamp)?,
        }
        Ok(())
    }
}
