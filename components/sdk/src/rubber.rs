//! The rubber's side of a window.

use crate::context::Context;
use crate::frames::FrameSource;
use crate::line::ControlPipe;
use crate::ports::{InPort, OutPort};
use crate::program::Participant;
use crate::role_adapter::RoleAdapter;
use crate::roles::Rubber;
use crate::serve::{Assigned, serve};
use crate::setup::Setup;
use crate::stop::Stop;
use crate::substep_coupling::{RubberInside, Sizes};
use std::marker::PhantomData;
use tremie_channels::{ChannelMedium, Received};
use tremie_messages::frame::SurfaceSample;
use tremie_messages::schedule::Content;
use tremie_messages::start::Description;
use tremie_messages::{FacetLoad, Place, Problem, Role, Stamp, SurfaceVertex};
use tremie_state::{StateError, StateExchange};

/// Rubber as a component of a run.
pub struct AsRubber<T>(PhantomData<T>);

impl<T: Rubber> Participant for AsRubber<T> {
    const ROLE: Role = Role::Rubber;
    const PROGRAM: &'static str = T::PROGRAM;

    fn program() -> String {
        T::program()
    }

    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>> {
        Ok(Description { tells_places: true, ..T::describe(setup)? })
    }

    fn serve<S: ChannelMedium>(line: ControlPipe, assigned: Assigned) -> Result<(), String> {
        serve::<S, RubberPlayer<S, T>>(line, assigned)
    }
}

/// Rubber with its edges.
struct RubberPlayer<S: ChannelMedium, R: Rubber> {
    rubber: R,
    sizes: Sizes,
    inside: Option<RubberInside<S>>,
    surface: Option<OutPort<S, SurfaceVertex>>,
    load: Option<InPort<S, FacetLoad>>,
    loads: Option<Received<S, Stamp, FacetLoad>>,
    /// Room for what observers see; empty until one looks.
    seen: (Vec<SurfaceVertex>, Vec<f64>),
}

impl<S: ChannelMedium, R: Rubber> FrameSource for RubberPlayer<S, R> {
    fn surfaces(&mut self, samples: &mut [SurfaceSample]) {
        let (vertices, strains) = &mut self.seen;
        vertices.resize(self.sizes.vertices, SurfaceVertex::default());
        strains.resize(self.sizes.vertices, 0.0);
        self.rubber.surface(vertices);
        self.rubber.strains(strains);
        for ((sample, vertex), strain) in samples.iter_mut().zip(vertices).zip(strains) {
            *sample = SurfaceSample { vertex: *vertex, strain: *strain };
        }
    }
}

impl<S: ChannelMedium, R: Rubber> RoleAdapter<S> for RubberPlayer<S, R> {
    fn create(setup: &Setup) -> Result<Self, Vec<Problem>> {
        Ok(Self {
            rubber: R::create(setup)?,
            sizes: Sizes::of(&setup.hello.scene),
            inside: None,
            surface: None,
            load: None,
            loads: None,
            seen: Default::default(),
        })
    }

    fn open(&mut self, context: &Context<S>) -> Result<(), Stop> {
        self.inside = RubberInside::open(context, self.sizes)?;
        self.surface = OutPort::find(context, Content::Surface)?;
        self.load = InPort::find(context, Content::SurfaceLoad)?;
        Ok(())
    }

    fn connect(&mut self) -> Result<(), Stop> {
        self.surface.as_ref().map_or(Ok(()), OutPort::connect)?;
        self.inside.as_ref().map_or(Ok(()), RubberInside::connect)
    }

    fn receive(
        &mut self,
        context: &mut Context<S>,
        content: Content,
        lag: u64,
    ) -> Result<(), Stop> {
        let (Content::SurfaceLoad, Some(port)) = (content, &self.load) else {
            return Ok(());
        };
        // Given back before the next is taken: the channel lends only a few at a time.
        self.loads = None;
        let loads = port.take(context, lag)?;
        port.check_facets(context, loads.values(), self.sizes.facets)?;
        self.loads = Some(loads);
        Ok(())
    }

    fn advance(&mut self, context: &mut Context<S>) -> Result<(), Stop> {
        let Some(inside) = &self.inside else { return Ok(()) };
        match context.window {
            0 => inside.start(context, &mut self.rubber),
            _ => {
                let loads = self.loads.as_ref().map_or(&[][..], |message| message.values());
                inside.window(context, &mut self.rubber, loads)
            }
        }
    }

    fn send(&mut self, context: &mut Context<S>, content: Content) -> Result<(), Stop> {
        let (Content::Surface, Some(port)) = (content, &self.surface) else {
            return Ok(());
        };
        let mut loan = port.loan(self.sizes.vertices)?;
        self.rubber.surface(loan.values());
        // Faults on purpose are committed inside the window.
        port.send(context, loan)
    }

    fn send_again(&mut self, context: &Context<S>, _: Content) -> Result<(), Stop> {
        self.surface.as_ref().map_or(Ok(()), |port| port.send_again(context))
    }

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.within("rubber", |state| self.rubber.exchange_state(state))?;
        self.load.as_mut().map_or(Ok(()), |port| port.exchange(state))?;
        self.surface.as_mut().map_or(Ok(()), |port| port.exchange(state))
    }

    fn signals(&mut self, values: &mut Vec<f64>, _: bool) {
        self.rubber.signals(values);
    }

    fn place(&self, signal: &str) -> Option<Place> {
        self.rubber.place(signal)
    }

    fn work(&self) -> u64 {
        self.rubber.work()
    }

    fn ends_inside() -> bool {
        true
    }
}
