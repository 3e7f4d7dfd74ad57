//! Ends of the edges between components: checked where they are received, damaged on purpose where
//! a test asks for it.

use crate::context::Context;
use crate::stop::Stop;
use tremie_channels::{
    Between, ChannelError, ChannelSpec, Loan, Received, Receiver, Ringer, Sender,
};
use tremie_messages::schedule::Edge;
use tremie_messages::start::{FaultKind, InjectionKind};
use tremie_messages::{BodyState, Load, Message, Stamp};

/// A value that says whether all its numbers are finite.
pub trait Finite {
    /// Whether every number is finite.
    fn is_finite(&self) -> bool;
    /// Spoils the value, for tests of the guards.
    fn spoil(&mut self);
    /// Id of the body it belongs to.
    fn id(&self) -> u64;
}

impl Finite for BodyState {
    fn is_finite(&self) -> bool {
        self.is_finite()
    }
    fn spoil(&mut self) {
        self.velocity[0] = f64::NAN;
    }
    fn id(&self) -> u64 {
        self.id
    }
}

impl Finite for Load {
    fn is_finite(&self) -> bool {
        self.is_finite()
    }
    fn spoil(&mut self) {
        self.force[0] = f64::NAN;
    }
    fn id(&self) -> u64 {
        self.id
    }
}

/// The receiving end of an edge.
pub struct InPort<S: Between, T: Message> {
    edge: Edge,
    receiver: Receiver<S, Stamp, T>,
}

/// The sending end of an edge.
pub struct OutPort<S: Between, T: Message> {
    edge: Edge,
    sender: Sender<S, Stamp, T>,
    ringer: Ringer<S>,
}

fn spec(edge: &Edge) -> ChannelSpec<'_> {
    ChannelSpec {
        service: &edge.service,
        capacity: edge.capacity as usize,
        depth: edge.depth as usize,
        lossless: true,
    }
}

impl<S: Between, T: Message> InPort<S, T> {
    /// Opens the receiving end of `edge`.
    pub fn open(context: &Context<S>, edge: &Edge) -> Result<Self, Stop> {
        Ok(Self { receiver: context.attachment.receiver(spec(edge))?, edge: edge.clone() })
    }

    /// Waits for the message that the schedule foretells, and checks its stamp.
    pub fn take(&self, context: &mut Context<S>, lag: u64) -> Result<Received<S, Stamp, T>, Stop> {
        let expected = context.expected(&self.edge, lag);
        let what = || format!("{} of window {}", self.edge.content.name(), expected.window);
        let window = context.window;
        let look = || {
            let broken = |error| Stop::on_edge(error, &self.edge, &self.edge.to, window);
            self.receiver.take().map_err(broken)
        };
        let message = context.wait(&self.edge.from, &what, expected.window, look)?;
        if *message.header() == expected {
            return Ok(message);
        }
        let found = message.header();
        let kind = if found.window == expected.window && found.substep != expected.substep {
            FaultKind::Substeps
        } else {
            FaultKind::Stamp
        };
        Err(context.fault(
            kind,
            &self.edge.from,
            format!("on {}, expected {expected}; found {found}", self.edge.label()),
        ))
    }
}

impl<S: Between, T: Message + Finite> InPort<S, T> {
    /// As [`InPort::take`], and checks that values are finite and belong to the bodies `ids`.
    pub fn take_checked(
        &self,
        context: &mut Context<S>,
        lag: u64,
        ids: impl ExactSizeIterator<Item = u64>,
    ) -> Result<Received<S, Stamp, T>, Stop> {
        let message = self.take(context, lag)?;
        let values = message.values();
        let label = || self.edge.label();
        if values.len() != ids.len() {
            let text =
                format!("on {}, expected {} values, found {}", label(), ids.len(), values.len());
            return Err(context.fault(FaultKind::Count, &self.edge.from, text));
        }
        for (value, id) in values.iter().zip(ids) {
            if value.id() != id {
                let text = format!("on {}, expected body {id}, found body {}", label(), value.id());
                return Err(context.fault(FaultKind::Count, &self.edge.from, text));
            }
            if !value.is_finite() {
                let text =
                    format!("on {}, the values of body {id} are not finite: {value:?}", label());
                return Err(context.fault(FaultKind::NotFinite, &self.edge.from, text));
            }
        }
        Ok(message)
    }
}

impl<S: Between, T: Message> OutPort<S, T> {
    /// Opens the sending end of `edge`.
    pub fn open(context: &Context<S>, edge: &Edge) -> Result<Self, Stop> {
        Ok(Self {
            sender: context.attachment.sender(spec(edge))?,
            ringer: Ringer::of(&context.attachment, &edge.to)?,
            edge: edge.clone(),
        })
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
    pub fn send(&self, context: &Context<S>, loan: Loan<S, Stamp, T>) -> Result<(), Stop> {
        let sent = loan.send(self.stamp(context)).and_then(|()| self.ringer.ring());
        sent.map_err(|error| self.broken(error, context.window))
    }

    fn broken(&self, error: ChannelError, window: u64) -> Stop {
        Stop::on_edge(error, &self.edge, &self.edge.from, window)
    }

    fn stamp(&self, context: &Context<S>) -> Stamp {
        context.stamp(context.window.saturating_sub(self.edge.events_lag))
    }
}

impl<S: Between, T: Message + Finite> OutPort<S, T> {
    /// As [`OutPort::send`], after a check that the solver's values are finite, and with the fault
    /// that is injected into this window, if any.
    pub fn send_checked(
        &self,
        context: &Context<S>,
        mut loan: Loan<S, Stamp, T>,
    ) -> Result<(), Stop> {
        if let Some(value) = loan.values().iter().find(|value| !value.is_finite()) {
            let text = format!(
                "its {} of body {} is not finite: {value:?}",
                self.edge.content.name(),
                value.id()
            );
            return Err(context.fault(FaultKind::NotFinite, &context.component, text));
        }
        match context.injection() {
            None => self.send(context, loan),
            Some(kind) => self.send_damaged(context, loan, kind),
        }
    }

    fn send_damaged(
        &self,
        context: &Context<S>,
        mut loan: Loan<S, Stamp, T>,
        kind: InjectionKind,
    ) -> Result<(), Stop> {
        match kind {
            InjectionKind::Drop => return Ok(()),
            InjectionKind::Duplicate => {
                let copy = loan.values().to_vec();
                self.send(context, loan)?;
                self.sender.send_copy(self.stamp(context), &copy)?;
            }
            InjectionKind::Stale => {
                let mut stamp = self.stamp(context);
                stamp.window = stamp.window.saturating_sub(1);
                loan.send(stamp)?;
            }
            InjectionKind::Count => {
                let short = loan.values().len().saturating_sub(1);
                let copy = loan.values()[..short].to_vec();
                drop(loan);
                self.sender.send_copy(self.stamp(context), &copy)?;
            }
            InjectionKind::Nan => {
                if let Some(first) = loan.values().first_mut() {
                    first.spoil();
                }
                return self.send(context, loan);
            }
            _ => return self.send(context, loan),
        }
        Ok(self.ringer.ring()?)
    }
}
