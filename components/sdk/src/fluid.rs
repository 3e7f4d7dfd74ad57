//! The fluid's side of a window.

use crate::context::Context;
use crate::frames::FrameSource;
use crate::impulse::Impulse;
use crate::line::ControlPipe;
use crate::ports::{InPort, OutPort, Taken};
use crate::program::Participant;
use crate::role_adapter::RoleAdapter;
use crate::roles::{Fluid, check_polyhedra, check_surfaces};
use crate::serve::{Assigned, serve};
use crate::setup::Setup;
use crate::stop::Stop;
use crate::substep_coupling::Sizes;
use std::marker::PhantomData;
use tremie_channels::{ChannelMedium, Loan};
use tremie_messages::frame::{SliceHeader, SliceNode, VolumeHeader};
use tremie_messages::schedule::Content;
use tremie_messages::start::{Description, FaultKind, VolumeGrid};
use tremie_messages::{
    BodyEvent, BodyState, FacetLoad, Load, Place, PortState, Problem, Role, Stamp, SurfaceVertex,
};
use tremie_state::{StateError, StateExchange};

/// A fluid as a component of a run.
pub struct AsFluid<T>(PhantomData<T>);

impl<T: Fluid> Participant for AsFluid<T> {
    const ROLE: Role = Role::Fluid;
    const PROGRAM: &'static str = T::PROGRAM;

    fn program() -> String {
        T::program()
    }

    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>> {
        check_surfaces(setup, &T::program(), T::TAKES_SURFACES)?;
        check_polyhedra(setup, &T::program(), T::takes_polyhedra())?;
        let own = T::describe(setup)?;
        let described = Description { ports: T::TELLS_PORTS, tells_places: true, ..own };
        Ok(Impulse::announce(described, "impulse_delivered"))
    }

    fn serve<S: ChannelMedium>(line: ControlPipe, assigned: Assigned) -> Result<(), String> {
        serve::<S, FluidPlayer<S, T>>(line, assigned)
    }
}

/// A fluid with its edges.
struct FluidPlayer<S: ChannelMedium, F: Fluid> {
    fluid: F,
    ids: Vec<u64>,
    events: Option<InPort<S, BodyEvent>>,
    state: Option<InPort<S, BodyState>>,
    bodies: Taken<S, BodyState>,
    load: Option<OutPort<S, Load>>,
    /// The loads of the present window, in the memory that the receiver will read.
    loads: Option<Loan<S, Stamp, Load>>,
    impulse: Impulse,
    sizes: Sizes,
    surface: Option<InPort<S, SurfaceVertex>>,
    vertices: Taken<S, SurfaceVertex>,
    surface_load: Option<OutPort<S, FacetLoad>>,
    /// Loads on deformable surfaces in the present window.
    facets: Vec<FacetLoad>,
    port: Option<OutPort<S, PortState>>,
    /// Faces whose velocities the grains are told.
    ports: Vec<PortState>,
    /// The signals that are sampled, as they were when they were measured last.
    sampled: Vec<f64>,
}

impl<S: ChannelMedium, F: Fluid> FrameSource for FluidPlayer<S, F> {
    fn slice(&mut self, name: &str, nodes: &mut [SliceNode]) -> SliceHeader {
        self.fluid.slice(name, nodes)
    }

    fn volume(&mut self, grid: &VolumeGrid, nodes: &mut [SliceNode]) -> VolumeHeader {
        self.fluid.volume(grid, nodes)
    }
}

impl<S: ChannelMedium, F: Fluid> RoleAdapter<S> for FluidPlayer<S, F> {
    fn create(setup: &Setup) -> Result<Self, Vec<Problem>> {
        let sizes = Sizes::of(&setup.hello.scene);
        Ok(Self {
            fluid: F::create(setup)?,
            ids: Vec::new(),
            events: None,
            state: None,
            bodies: Taken::Nothing,
            load: None,
            loads: None,
            impulse: Impulse::default(),
            sizes,
            surface: None,
            vertices: Taken::Nothing,
            surface_load: None,
            facets: sizes.room_for_loads(),
            port: None,
            ports: PortState::all(&setup.hello.scene),
            sampled: Vec::new(),
        })
    }

    fn open(&mut self, context: &Context<S>) -> Result<(), Stop> {
        self.events = InPort::find(context, Content::Events)?;
        self.state = InPort::find(context, Content::State)?;
        self.load = OutPort::find(context, Content::Load)?;
        self.port = OutPort::find(context, Content::Ports)?;
        self.surface = InPort::find(context, Content::Surface)?;
        self.surface_load = OutPort::find(context, Content::SurfaceLoad)?;
        Ok(())
    }

    fn connect(&mut self) -> Result<(), Stop> {
        self.load.as_ref().map_or(Ok(()), OutPort::connect)?;
        self.port.as_ref().map_or(Ok(()), OutPort::connect)?;
        self.surface_load.as_ref().map_or(Ok(()), OutPort::connect)
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
                self.bodies = Taken::Nothing;
                let ids = self.ids.iter().copied();
                self.bodies = Taken::Message(port.take_checked(context, lag, ids)?);
                Ok(())
            }
            (Content::Surface, ..) => self.take_surface(context, lag),
            _ => Ok(()),
        }
    }

    fn advance(&mut self, context: &mut Context<S>) -> Result<(), Stop> {
        let bodies = self.bodies.values().unwrap_or_default();
        let mut loan = self.load.as_ref().map(|port| port.loan(bodies.len())).transpose()?;
        let loads = loan.as_mut().map_or(&mut [][..], |loan| loan.values());
        for (load, body) in loads.iter_mut().zip(bodies) {
            *load = Load { id: body.id, ..Load::default() };
        }
        let vertices = self.vertices.values();
        let window = context.window;
        let (fluid, substeps, facets) = (&mut self.fluid, context.substeps, &mut self.facets);
        facets.clear();
        let done = context.compute(|_| {
            vertices.map_or(Ok(()), |vertices| fluid.surface(vertices))?;
            match window {
                0 => fluid.start(bodies, loads)?,
                _ => fluid.advance(substeps, bodies, loads)?,
            }
            vertices.map_or(Ok(()), |_| fluid.surface_loads(facets))
        });
        self.impulse.add(loads, context.assignment.clock.window());
        self.loads = loan;
        done.map_err(|error| context.solver_failed(&error))
    }

    fn send(&mut self, context: &mut Context<S>, content: Content) -> Result<(), Stop> {
        match (content, &self.load, &self.surface_load) {
            (Content::Ports, ..) => self.send_ports(context),
            (Content::Load, Some(port), _) => match self.loads.take() {
                Some(loads) => port.send_checked(context, loads),
                None => Ok(()),
            },
            (Content::SurfaceLoad, _, Some(port)) => {
                port.send_checked(context, port.loan_copy(&self.facets)?)
            }
            _ => Ok(()),
        }
    }

    fn send_again(&mut self, context: &Context<S>, content: Content) -> Result<(), Stop> {
        match content {
            Content::Ports => self.port.as_ref().map_or(Ok(()), |port| port.send_again(context)),
            Content::Load => self.load.as_ref().map_or(Ok(()), |port| port.send_again(context)),
            _ => self.surface_load.as_ref().map_or(Ok(()), |port| port.send_again(context)),
        }
    }

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.within("fluid", |state| self.fluid.exchange_state(state))?;
        state.list("ids", &mut self.ids)?;
        state.list("sampled", &mut self.sampled)?;
        // In any schedule: the run may go on with another, in which the fluid advances first.
        self.bodies.exchange("bodies", state)?;
        self.vertices.exchange("vertices", state)?;
        state.value("impulse", &mut self.impulse)?;
        self.load.as_mut().map_or(Ok(()), |port| port.exchange(state))?;
        self.port.as_mut().map_or(Ok(()), |port| port.exchange(state))?;
        self.surface_load.as_mut().map_or(Ok(()), |port| port.exchange(state))
    }

    fn signals(&mut self, values: &mut Vec<f64>, measure: bool) {
        self.fluid.signals(values);
        if measure {
            self.sampled.clear();
            self.fluid.sampled(&mut self.sampled);
        }
        values.extend(&self.sampled);
        self.impulse.push(values);
    }

    fn row_kept(&mut self) {
        self.fluid.row_kept();
    }

    fn place(&self, signal: &str) -> Option<Place> {
        self.fluid.place(signal)
    }

    fn work(&self) -> u64 {
        self.fluid.work()
    }
}

impl<S: ChannelMedium, F: Fluid> FluidPlayer<S, F> {
    fn take_surface(&mut self, context: &mut Context<S>, lag: u64) -> Result<(), Stop> {
        let Some(port) = &self.surface else { return Ok(()) };
        self.vertices = Taken::Nothing;
        let message = port.take(context, lag)?;
        port.check_count(context, message.values(), self.sizes.vertices)?;
        port.check_finite(context, message.values())?;
        self.vertices = Taken::Message(message);
        Ok(())
    }

    fn send_ports(&mut self, context: &Context<S>) -> Result<(), Stop> {
        let Some(port) = &self.port else { return Ok(()) };
        let told = self.fluid.ports(&mut self.ports);
        told.map_err(|error| context.solver_failed(&error))?;
        port.send_checked(context, port.loan_copy(&self.ports)?)
    }

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
