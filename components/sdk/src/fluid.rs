//! The fluid's side of a window.

use crate::context::Context;
use crate::frames::Shows;
use crate::impulse::Impulse;
use crate::physics::Fluid;
use crate::ports::{InPort, OutPort};
use crate::role::Player;
use crate::setup::Setup;
use crate::stop::Stop;
use std::time::Instant;
use tremie_channels::{Between, Loan, Received};
use tremie_messages::frame::{SliceHeader, SliceNode, VolumeHeader};
use tremie_messages::schedule::Content;
use tremie_messages::start::{FaultKind, VolumeGrid};
use tremie_messages::{BodyEvent, BodyState, Load, Problem, Stamp};

/// A fluid with its edges.
pub struct FluidPlayer<S: Between, F: Fluid> {
    fluid: F,
    ids: Vec<u64>,
    events: Option<InPort<S, BodyEvent>>,
    state: Option<InPort<S, BodyState>>,
    bodies: Option<Received<S, Stamp, BodyState>>,
    load: Option<OutPort<S, Load>>,
    /// The loads of the present window, in the memory that the receiver will read.
    loads: Option<Loan<S, Stamp, Load>>,
    impulse: Impulse,
}

impl<S: Between, F: Fluid> Shows for FluidPlayer<S, F> {
    fn slice(&mut self, name: &str, nodes: &mut [SliceNode]) -> SliceHeader {
        self.fluid.slice(name, nodes)
    }

    fn volume(&mut self, grid: &VolumeGrid, nodes: &mut [SliceNode]) -> VolumeHeader {
        self.fluid.volume(grid, nodes)
    }
}

impl<S: Between, F: Fluid> Player<S> for FluidPlayer<S, F> {
    fn create(setup: &Setup) -> Result<Self, Vec<Problem>> {
        Ok(Self {
            fluid: F::create(setup)?,
            ids: Vec::new(),
            events: None,
            state: None,
            bodies: None,
            load: None,
            loads: None,
            impulse: Impulse::default(),
        })
    }

    fn open(&mut self, context: &Context<S>) -> Result<(), Stop> {
        for edge in &context.assignment.edges {
            match edge.content {
                Content::Events => self.events = Some(InPort::open(context, edge)?),
                Content::State => self.state = Some(InPort::open(context, edge)?),
                Content::Load => self.load = Some(OutPort::open(context, edge)?),
            }
        }
        Ok(())
    }

    fn connect(&mut self) -> Result<(), Stop> {
        self.load.as_ref().map_or(Ok(()), OutPort::connect)
    }

    fn receive(
        &mut self,
        context: &mut Context<S>,
        content: Content,
        lag: u64,
    ) -> Result<(), Stop> {
        match (content, &self.events, &self.state) {
            (Content::Events, Some(port), _) => {
                let message = port.take(context, lag)?;
                self.take_events(context, message.values())
            }
            (Content::State, _, Some(port)) => {
                // Given back before the next is taken: the channel lends only a few at a time.
                self.bodies = None;
                let ids = self.ids.iter().copied();
                self.bodies = Some(port.take_checked(context, lag, ids)?);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn advance(&mut self, context: &mut Context<S>) -> Result<(), Stop> {
        let bodies = self.bodies.as_ref().map_or(&[][..], |message| message.values());
        let mut loan = self.load.as_ref().map(|port| port.loan(bodies.len())).transpose()?;
        let loads = loan.as_mut().map_or(&mut [][..], |loan| loan.values());
        for (load, body) in loads.iter_mut().zip(bodies) {
            *load = Load { id: body.id, ..Load::default() };
        }
        let begin = Instant::now();
        let done = match context.window {
            0 => self.fluid.start(bodies, loads),
            _ => self.fluid.advance(context.substeps, bodies, loads),
        };
        context.spent.compute += begin.elapsed().as_nanos() as u64;
        self.impulse.add(loads, context.assignment.clock.window());
        self.loads = loan;
        done.map_err(|error| context.solver_failed(&error))
    }

    fn send(&mut self, context: &mut Context<S>, content: Content) -> Result<(), Stop> {
        match (content, &self.load, self.loads.take()) {
            (Content::Load, Some(port), Some(loads)) => port.send_checked(context, loads),
            _ => Ok(()),
        }
    }

    fn signals(&mut self, values: &mut Vec<f64>) {
        self.fluid.signals(values);
        self.impulse.push(values);
    }

    fn work(&self) -> u64 {
        self.fluid.work()
    }
}

impl<S: Between, F: Fluid> FluidPlayer<S, F> {
    fn take_events(&mut self, context: &Context<S>, events: &[BodyEvent]) -> Result<(), Stop> {
        for event in events {
            match (event.kind, self.ids.binary_search(&event.id)) {
                (BodyEvent::ADDED, Err(place)) => self.ids.insert(place, event.id),
                (BodyEvent::REMOVED, Ok(place)) => {
                    self.ids.remove(place);
                }
                _ => {
                    let text = format!("an event that does not fit its body: {event:?}");
                    return Err(context.fault(FaultKind::Count, &context.component, text));
                }
            }
        }
        self.fluid.events(events).map_err(|error| context.solver_failed(&error))
    }
}
