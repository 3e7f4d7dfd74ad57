//! The grains' side of a window.

use crate::context::Context;
use crate::frames::FrameSource;
use crate::impulse::Impulse;
use crate::lagged_loads::Answers;
use crate::line::ControlPipe;
use crate::ports::{InPort, OutPort};
use crate::program::Participant;
use crate::role_adapter::RoleAdapter;
use crate::roles::{Grains, check_polyhedra, check_surfaces};
use crate::serve::{Assigned, serve};
use crate::setup::Setup;
use crate::stop::Stop;
use crate::substep_coupling::{Sizes, SubstepCoupling};
use std::marker::PhantomData;
use tremie_channels::{ChannelMedium, Received};
use tremie_messages::frame::{LoadSample, ProfileBin, ProfileHeader};
use tremie_messages::schedule::Content;
use tremie_messages::start::Description;
use tremie_messages::{BodyEvent, BodyState, Load, Place, PortState, Problem, Role, Stamp};
use tremie_state::{StateError, StateExchange};

/// Grains as a component of a run.
pub struct AsGrains<T>(PhantomData<T>);

impl<T: Grains> Participant for AsGrains<T> {
    const ROLE: Role = Role::Grains;
    const PROGRAM: &'static str = T::PROGRAM;

    fn program() -> String {
        T::program()
    }

    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>> {
        check_surfaces(setup, &T::program(), T::TAKES_SURFACES)?;
        check_polyhedra(setup, &T::program(), T::takes_polyhedra())?;
        let own = T::describe(setup)?;
        let described =
            Description { ports: T::TAKES_PORTS, tells_places: true, tells_loads: true, ..own };
        Ok(Impulse::announce(described, "impulse_received"))
    }

    fn serve<S: ChannelMedium>(line: ControlPipe, assigned: Assigned) -> Result<(), String> {
        serve::<S, GrainsPlayer<S, T>>(line, assigned)
    }
}

/// Grains with their edges.
struct GrainsPlayer<S: ChannelMedium, G: Grains> {
    grains: G,
    /// Living bodies in ascending order of ids, as they were announced.
    kinds: Vec<BodyEvent>,
    events: Option<OutPort<S, BodyEvent>>,
    state: Option<OutPort<S, BodyState>>,
    load: Option<InPort<S, Load>>,
    loads: Option<Received<S, Stamp, Load>>,
    answers: Answers,
    port: Option<InPort<S, PortState>>,
    /// Faces whose velocities the fluid tells.
    ports: Vec<PortState>,
    impulse: Impulse,
    sizes: Sizes,
    /// The run begins with bodies of another: all are announced in the start exchange, not those that came
    /// or went in that run's last window.
    has_taken_bodies: bool,
    /// Opposite a rubber: the exchange with it inside a window.
    inside: Option<SubstepCoupling<S>>,
}

impl<S: ChannelMedium, G: Grains> FrameSource for GrainsPlayer<S, G> {
    fn bodies(&self, states: &mut Vec<BodyState>, kinds: &mut Vec<BodyEvent>) {
        states.resize(self.grains.count(), BodyState::at_rest(0, [0.0; 3]));
        self.grains.state(states);
        kinds.extend_from_slice(&self.kinds);
    }

    fn loads(&self, samples: &mut Vec<LoadSample>) {
        const UNKNOWN: [f64; 3] = [f64::NAN; 3];
        let (mut states, mut kinds) = (Vec::new(), Vec::new());
        self.bodies(&mut states, &mut kinds);
        let mut contacts = vec![UNKNOWN; states.len()];
        if !self.grains.contact_forces(&mut contacts) {
            contacts.fill(UNKNOWN);
        }
        let mut loads = self.loads.as_ref().map_or(&[][..], |message| message.values()).iter();
        let mut next = loads.next();
        for ((state, kind), contact) in states.iter().zip(&kinds).zip(contacts) {
            // Both ascend. Who came at the window's end has none yet.
            while next.is_some_and(|load| load.id < state.id) {
                next = loads.next();
            }
            let own = next.filter(|load| load.id == state.id);
            samples.push(LoadSample {
                id: state.id,
                position: state.position,
                fluid: own.map_or(UNKNOWN, |load| load.force),
                contact,
                shape: kind.shape,
                set: kind.set,
            });
        }
    }

    fn has_profile(&self, name: &str, is_last: bool) -> bool {
        self.grains.has_profile(name, is_last)
    }

    fn profile(&mut self, name: &str, bins: &mut [ProfileBin]) -> ProfileHeader {
        self.grains.profile(name, bins)
    }
}

impl<S: ChannelMedium, G: Grains> RoleAdapter<S> for GrainsPlayer<S, G> {
    fn create(setup: &Setup) -> Result<Self, Vec<Problem>> {
        let grains = G::create(setup)?;
        let mut player = Self {
            grains,
            kinds: Vec::new(),
            events: None,
            state: None,
            load: None,
            loads: None,
            answers: Answers::default(),
            port: None,
            ports: PortState::all(&setup.hello.scene),
            impulse: Impulse::default(),
            sizes: Sizes::of(&setup.hello.scene),
            has_taken_bodies: false,
            inside: None,
        };
        player.note_events();
        player.answers.note(player.kinds.iter().map(|kind| kind.id));
        Ok(player)
    }

    fn open(&mut self, context: &Context<S>) -> Result<(), Stop> {
        self.events = OutPort::find(context, Content::Events)?;
        self.state = OutPort::find(context, Content::State)?;
        self.load = InPort::find(context, Content::Load)?;
        self.port = InPort::find(context, Content::Ports)?;
        self.inside = SubstepCoupling::open(context, self.sizes)?;
        Ok(())
    }

    fn connect(&mut self) -> Result<(), Stop> {
        self.events.as_ref().map_or(Ok(()), OutPort::connect)?;
        self.state.as_ref().map_or(Ok(()), OutPort::connect)?;
        self.inside.as_ref().map_or(Ok(()), SubstepCoupling::connect)
    }

    fn receive(
        &mut self,
        context: &mut Context<S>,
        content: Content,
        lag: u64,
    ) -> Result<(), Stop> {
        match content {
            Content::Load => self.take_loads(context, lag),
            Content::Ports => self.take_ports(context, lag),
            _ => Ok(()),
        }
    }

    fn advance(&mut self, context: &mut Context<S>) -> Result<(), Stop> {
        if context.window == 0 {
            let Self { inside, grains, .. } = self;
            return inside.as_mut().map_or(Ok(()), |inside| inside.start(context, grains));
        }
        let loads = self.loads.as_ref().map_or(&[][..], |message| message.values());
        self.impulse.add(loads, context.assignment.clock.window());
        let loads = self.answers.fit(loads, self.kinds.iter().map(|kind| kind.id));
        match &mut self.inside {
            Some(inside) => inside.window(context, &mut self.grains, loads)?,
            None => {
                let substeps = context.substeps;
                let done = context.compute(|_| self.grains.advance(substeps, loads));
                done.map_err(|error| context.solver_failed(&error))?;
            }
        }
        self.note_events_and_answers();
        Ok(())
    }

    fn send(&mut self, context: &mut Context<S>, content: Content) -> Result<(), Stop> {
        match (content, &self.events, &self.state) {
            (Content::Events, Some(port), _) => {
                let begins = self.has_taken_bodies && context.window == 0;
                let events = if begins { &self.kinds } else { self.grains.events() };
                let mut loan = port.loan(events.len())?;
                loan.values().copy_from_slice(events);
                port.send(context, loan)
            }
            (Content::State, _, Some(port)) => {
                let mut loan = port.loan(self.grains.count())?;
                self.grains.state(loan.values());
                port.send_checked(context, loan)
            }
            _ => Ok(()),
        }
    }

    fn send_again(&mut self, context: &Context<S>, content: Content) -> Result<(), Stop> {
        match content {
            Content::Events => self.events.as_ref().map_or(Ok(()), |port| port.send_again(context)),
            _ => self.state.as_ref().map_or(Ok(()), |port| port.send_again(context)),
        }
    }

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.within("grains", |state| self.grains.exchange_state(state))?;
        state.value("kinds", &mut self.kinds)?;
        state.list("answered", &mut self.answers.ids)?;
        state.value("impulse", &mut self.impulse)?;
        self.load.as_mut().map_or(Ok(()), |port| port.exchange(state))?;
        self.port.as_mut().map_or(Ok(()), |port| port.exchange(state))?;
        self.events.as_mut().map_or(Ok(()), |port| port.exchange(state))?;
        self.state.as_mut().map_or(Ok(()), |port| port.exchange(state))
    }

    fn take_bodies(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.within("grains", |state| self.grains.take_bodies(state))?;
        state.value("kinds", &mut self.kinds)?;
        state.leave_rest();
        self.answers.note(self.kinds.iter().map(|kind| kind.id));
        self.has_taken_bodies = true;
        Ok(())
    }

    fn signals(&mut self, values: &mut Vec<f64>, _: bool) {
        self.grains.signals(values);
        self.impulse.push(values);
    }

    fn row_kept(&mut self) {
        self.grains.row_kept();
    }

    fn place(&self, signal: &str) -> Option<Place> {
        self.grains.place(signal)
    }

    fn work(&self) -> u64 {
        self.grains.work()
    }
}

impl<S: ChannelMedium, G: Grains> GrainsPlayer<S, G> {
    /// True if loads answer the bodies of a list before the present one.
    fn is_late(&self) -> bool {
        self.load.as_ref().is_some_and(|port| port.events_lag() > 0)
    }

    fn take_loads(&mut self, context: &mut Context<S>, lag: u64) -> Result<(), Stop> {
        let Some(port) = &self.load else { return Ok(()) };
        // Given back before the next is taken: the channel lends only a few at a time.
        self.loads = None;
        self.loads = Some(port.take_checked(context, lag, self.answers.ids.iter().copied())?);
        Ok(())
    }

    fn take_ports(&mut self, context: &mut Context<S>, lag: u64) -> Result<(), Stop> {
        let Some(port) = &self.port else { return Ok(()) };
        let message = port.take_faces(context, lag, &self.ports)?;
        let told = self.grains.ports(message.values());
        told.map_err(|error| context.solver_failed(&error))
    }

    /// Notes who came and went in a window, and which bodies the fluid's loads of that window answer.
    fn note_events_and_answers(&mut self) {
        if self.is_late() {
            self.answers.note(self.kinds.iter().map(|kind| kind.id));
            self.note_events();
        } else {
            self.note_events();
            self.answers.note(self.kinds.iter().map(|kind| kind.id));
        }
    }

    fn note_events(&mut self) {
        for event in self.grains.events() {
            match (event.kind, self.kinds.binary_search_by_key(&event.id, |kind| kind.id)) {
                (BodyEvent::REMOVED, Ok(place)) => {
                    self.kinds.remove(place);
                }
                (BodyEvent::ADDED, Err(place)) => self.kinds.insert(place, *event),
                _ => {}
            }
        }
    }
}
