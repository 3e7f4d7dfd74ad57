//! The exchange between grains and rubber inside a window, part of both sides' advance.
//!
//! In each substep:
//!
//! | grains | rubber |
//! | --- | --- |
//! | take all bodies to the substep's end | |
//! | send `carrier` | take it |
//! | take `trial` 1 | send it |
//! | find contacts, send `contact` 1 | take it: another trial, or settled |
//! | ... | ... |
//! | take the accepted surface and `resultant` | send them |
//! | finish the substep | |
//!
//! Each side waits for the other's answer before it sends anything that the other does not wait
//! for: hence at most one message is under way on each edge (two where the carriers of the start
//! exchange, which nobody answers, are followed by those of the first substep), and no order of the
//! two locks up: `tremie::schedule` tests it. Both sides poll here: an answer comes within
//! microseconds, and a long run has millions of trials.

use crate::context::Context;
use crate::ports::{InPort, OutPort};
use crate::roles::{Grains, Rubber, SolverError};
use crate::serve::end_here;
use crate::stop::Stop;
use tremie_channels::{ChannelMedium, Received};
use tremie_messages::scene::Scene;
use tremie_messages::schedule::{Content, MOST_TRIALS};
use tremie_messages::start::FaultKind;
use tremie_messages::{BodyState, FacetLoad, Load, Stamp, SurfaceVertex};

/// Numbers of the scene's deformable surfaces, their vertices and facets.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sizes {
    /// Number of surfaces.
    pub surfaces: usize,
    /// Number of vertices of all.
    pub vertices: usize,
    /// Number of facets of all.
    pub facets: usize,
}

impl Sizes {
    /// Of a scene.
    pub fn of(scene: &Scene) -> Self {
        let all = &scene.surfaces;
        Self {
            surfaces: all.len(),
            vertices: all.iter().map(|surface| surface.vertex_count()).sum(),
            facets: all.iter().map(|surface| surface.facet_count()).sum(),
        }
    }

    fn ids(self) -> impl ExactSizeIterator<Item = u64> {
        (0..self.surfaces).map(|surface| surface as u64)
    }

    /// Room for the loads on facets.
    pub fn room_for_loads(self) -> Vec<FacetLoad> {
        Vec::with_capacity(FacetLoad::MOST_PER_FACET * self.facets)
    }
}

/// Place of a message in the exchange of a window, never 0: what is owed first has the smallest.
pub fn turn(substep: u32, trial: u32, is_answer: bool) -> u64 {
    1 + (u64::from(substep) << 34) + 2 * u64::from(trial) + u64::from(is_answer)
}

/// True for the substep in which the fault is committed that is injected into a window: both sides are in
/// the exchange then.
fn is_middle<S: ChannelMedium>(context: &Context<S>, substep: u32) -> bool {
    substep == context.assignment.substeps.div_ceil(2)
}

/// The grains' side.
pub struct SubstepCoupling<S: ChannelMedium> {
    sizes: Sizes,
    carrier: OutPort<S, BodyState>,
    trial: InPort<S, SurfaceVertex>,
    contact: OutPort<S, FacetLoad>,
    resultant: InPort<S, Load>,
    carriers: Vec<BodyState>,
    loads: Vec<FacetLoad>,
}

/// The rubber's side.
pub struct RubberInside<S: ChannelMedium> {
    sizes: Sizes,
    carrier: InPort<S, BodyState>,
    trial: OutPort<S, SurfaceVertex>,
    contact: InPort<S, FacetLoad>,
    resultant: OutPort<S, Load>,
}

impl<S: ChannelMedium> SubstepCoupling<S> {
    /// Opens the grains' ends; `None` where no rubber sits opposite.
    pub fn open(context: &Context<S>, sizes: Sizes) -> Result<Option<Self>, Stop> {
        let ends = (
            OutPort::find(context, Content::Carrier)?,
            InPort::find(context, Content::Trial)?,
            OutPort::find(context, Content::Contact)?,
            InPort::find(context, Content::Resultant)?,
        );
        let (Some(carrier), Some(trial), Some(contact), Some(resultant)) = ends else {
            return Ok(None);
        };
        Ok(Some(Self {
            carrier,
            trial,
            contact,
            resultant,
            sizes,
            carriers: sizes.ids().map(|id| BodyState::at_rest(id, [0.0; 3])).collect(),
            loads: sizes.room_for_loads(),
        }))
    }

    /// Connects the senders.
    pub fn connect(&self) -> Result<(), Stop> {
        self.carrier.connect()?;
        self.contact.connect()
    }

    /// The start exchange: tells the rubber where its carriers are.
    pub fn start<G: Grains>(&mut self, context: &Context<S>, grains: &G) -> Result<(), Stop> {
        self.send_carriers(context, grains, 0)
    }

    /// A window, under `loads`.
    pub fn window<G: Grains>(
        &mut self,
        context: &mut Context<S>,
        grains: &mut G,
        loads: &[Load],
    ) -> Result<(), Stop> {
        context.compute(|context| {
            let substeps = context.substeps;
            grains.begin_window(substeps, loads).map_err(|error| context.solver_failed(&error))?;
            (1..=substeps).try_for_each(|substep| self.substep(context, grains, substep))?;
            grains.end_window().map_err(|error| context.solver_failed(&error))
        })
    }

    fn substep<G: Grains>(
        &mut self,
        context: &mut Context<S>,
        grains: &mut G,
        substep: u32,
    ) -> Result<(), Stop> {
        grains.begin_substep().map_err(|error| context.solver_failed(&error))?;
        self.send_carriers(context, grains, substep)?;
        let (accepted, trial) = self.answer(context, grains, substep)?;
        let stamp = context.inside(substep, trial | Stamp::FINAL);
        let port = &self.resultant;
        let resultants = port.take_inside(context, stamp, turn(substep, trial, true), false)?;
        port.check_bodies(context, resultants.values(), self.sizes.ids())?;
        grains
            .finish_substep(accepted.values(), resultants.values())
            .map_err(|error| context.solver_failed(&error))
    }

    /// Answers trials until the surface is accepted; returns it, with its number among the trials.
    fn answer<G: Grains>(
        &mut self,
        context: &mut Context<S>,
        grains: &mut G,
        substep: u32,
    ) -> Result<(Received<S, Stamp, SurfaceVertex>, u32), Stop> {
        for trial in 1..=MOST_TRIALS + 1 {
            let stamp = context.inside(substep, trial);
            let port = &self.trial;
            let surface = port.take_inside(context, stamp, turn(substep, trial, false), true)?;
            port.check_count(context, surface.values(), self.sizes.vertices)?;
            if surface.header().is_final() {
                port.check_finite(context, surface.values())?;
                return Ok((surface, trial));
            }
            self.loads.clear();
            if let Err(error) = grains.contacts(surface.values(), &mut self.loads) {
                // What is no surface is no fault of the grains.
                port.check_finite(context, surface.values())?;
                return Err(context.solver_failed(&error));
            }
            let loan = self.contact.loan_copy(&self.loads)?;
            self.contact.send_inside(context, loan, stamp, false)?;
        }
        Err(self.trial.unsettled(context, substep))
    }

    fn send_carriers<G: Grains>(
        &mut self,
        context: &Context<S>,
        grains: &G,
        substep: u32,
    ) -> Result<(), Stop> {
        grains.carriers(&mut self.carriers).map_err(|error| context.solver_failed(&error))?;
        for (id, carrier) in self.sizes.ids().zip(&mut self.carriers) {
            carrier.id = id;
        }
        let loan = self.carrier.loan_copy(&self.carriers)?;
        let stamp = context.inside(substep, 0);
        match context.injection().filter(|_| is_middle(context, substep)) {
            None => self.carrier.send_inside(context, loan, stamp, true),
            Some(kind) => {
                self.carrier.send_damaged(loan, stamp, kind)?;
                self.carrier.ring()
            }
        }
    }
}

impl<S: ChannelMedium> InPort<S, SurfaceVertex> {
    fn unsettled(&self, context: &Context<S>, substep: u32) -> Stop {
        let text = format!(
            "its surface did not settle in {MOST_TRIALS} trials of substep {substep}, the most that there can be"
        );
        context.fault(FaultKind::Solver, self.from(), text)
    }
}

impl<S: ChannelMedium> RubberInside<S> {
    /// Opens the rubber's ends; `None` where no grains sit opposite.
    pub fn open(context: &Context<S>, sizes: Sizes) -> Result<Option<Self>, Stop> {
        let ends = (
            InPort::find(context, Content::Carrier)?,
            OutPort::find(context, Content::Trial)?,
            InPort::find(context, Content::Contact)?,
            OutPort::find(context, Content::Resultant)?,
        );
        let (Some(carrier), Some(trial), Some(contact), Some(resultant)) = ends else {
            return Ok(None);
        };
        Ok(Some(Self { carrier, trial, contact, resultant, sizes }))
    }

    /// Connects the senders.
    pub fn connect(&self) -> Result<(), Stop> {
        self.trial.connect()?;
        self.resultant.connect()
    }

    /// The start exchange: hears where the carriers are.
    pub fn start<R: Rubber>(&self, context: &mut Context<S>, rubber: &mut R) -> Result<(), Stop> {
        let carriers = self.take_carriers(context, 0)?;
        rubber.start(carriers.values()).map_err(|error| context.solver_failed(&error))
    }

    /// A window, under the fluid's `loads`.
    pub fn window<R: Rubber>(
        &self,
        context: &mut Context<S>,
        rubber: &mut R,
        loads: &[FacetLoad],
    ) -> Result<(), Stop> {
        context.compute(|context| {
            rubber.begin_window(loads).map_err(|error| context.solver_failed(&error))?;
            (1..=context.substeps).try_for_each(|substep| self.substep(context, rubber, substep))
        })
    }

    fn substep<R: Rubber>(
        &self,
        context: &mut Context<S>,
        rubber: &mut R,
        substep: u32,
    ) -> Result<(), Stop> {
        let failed = |context: &Context<S>, error: SolverError| context.solver_failed(&error);
        let carriers = self.take_carriers(context, substep)?;
        rubber.begin_substep(carriers.values()).map_err(|error| failed(context, error))?;
        drop(carriers);
        for trial in 1..=MOST_TRIALS {
            let stamp = context.inside(substep, trial);
            self.send_trial(context, rubber, stamp)?;
            let port = &self.contact;
            let contacts = port.take_inside(context, stamp, turn(substep, trial, true), false)?;
            port.check_facets(context, contacts.values(), self.sizes.facets)?;
            if rubber.pass(contacts.values()).map_err(|error| failed(context, error))? {
                return self.accept(context, rubber, substep, trial + 1);
            }
        }
        let text = format!("it did not settle in {MOST_TRIALS} trials of substep {substep}");
        Err(failed(context, SolverError(text)))
    }

    /// Sends a trial; commits the fault that is injected into this window in the first of its
    /// middle substep.
    fn send_trial<R: Rubber>(
        &self,
        context: &Context<S>,
        rubber: &R,
        stamp: Stamp,
    ) -> Result<(), Stop> {
        let mut loan = self.trial.loan(self.sizes.vertices)?;
        rubber.surface(loan.values());
        let is_due = stamp.iteration == 1 && is_middle(context, stamp.substep);
        match context.injection().filter(|_| is_due) {
            None => self.trial.send_inside(context, loan, stamp, false),
            Some(kind) => {
                self.trial.send_damaged(loan, stamp, kind)?;
                end_here(kind)
            }
        }
    }

    fn accept<R: Rubber>(
        &self,
        context: &Context<S>,
        rubber: &R,
        substep: u32,
        trial: u32,
    ) -> Result<(), Stop> {
        let stamp = context.inside(substep, trial | Stamp::FINAL);
        let mut loan = self.trial.loan(self.sizes.vertices)?;
        rubber.surface(loan.values());
        self.trial.send_inside(context, loan, stamp, false)?;
        let mut loan = self.resultant.loan(self.sizes.surfaces)?;
        rubber.resultants(loan.values());
        for (id, load) in self.sizes.ids().zip(loan.values()) {
            load.id = id;
        }
        self.resultant.send_inside(context, loan, stamp, false)
    }

    fn take_carriers(
        &self,
        context: &mut Context<S>,
        substep: u32,
    ) -> Result<Received<S, Stamp, BodyState>, Stop> {
        let stamp = context.inside(substep, 0);
        let carriers = self.carrier.take_inside(context, stamp, turn(substep, 0, false), false)?;
        self.carrier.check_bodies(context, carriers.values(), self.sizes.ids())?;
        Ok(carriers)
    }
}
