//! The step loop's view of a role.

use crate::context::Context;
use crate::frames::FrameSource;
use crate::setup::Setup;
use crate::stop::Stop;
use tremie_channels::ChannelMedium;
use tremie_messages::schedule::Content;
use tremie_messages::{Place, Problem};
use tremie_state::{StateError, StateExchange};

/// A solver that plays its role in the windows of a run.
pub trait RoleAdapter<S: ChannelMedium>: FrameSource + Sized {
    /// See [`crate::Fluid::create`].
    fn create(setup: &Setup) -> Result<Self, Vec<Problem>>;
    /// Opens the ends of all edges.
    fn open(&mut self, context: &Context<S>) -> Result<(), Stop>;
    /// Connects senders, once all components are ready.
    fn connect(&mut self) -> Result<(), Stop>;
    /// Takes the message of the window that is `lag` before the present one.
    fn receive(&mut self, context: &mut Context<S>, content: Content, lag: u64)
    -> Result<(), Stop>;
    /// Advances through the present window; only looks in the start exchange.
    fn advance(&mut self, context: &mut Context<S>) -> Result<(), Stop>;
    /// Sends the present window's message.
    fn send(&mut self, context: &mut Context<S>, content: Content) -> Result<(), Stop>;
    /// Sends the message of a content again that was under way at the checkpoint from which the run
    /// goes on.
    fn send_again(&mut self, context: &Context<S>, content: Content) -> Result<(), Stop>;
    /// False if it has none to put back where a run goes on from a checkpoint.
    fn keeps_state() -> bool {
        true
    }
    /// Keeps the state at a window's end, the solver's and the adapter's own, or puts it back.
    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError>;
    /// Puts the bodies of another run's state back, with which this run begins.
    fn take_bodies(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.unfit("only grains begin with the bodies of another run")
    }
    /// Pushes the values of the signals; unless `measure`, those that are sampled as they were when
    /// they were measured last.
    fn signals(&mut self, values: &mut Vec<f64>, measure: bool);
    /// A row of the signals was kept: means over time begin anew.
    fn row_kept(&mut self) {}
    /// Place at which a signal has its value now, if that is known.
    fn place(&self, signal: &str) -> Option<Place>;
    /// Work done in one substep.
    fn work(&self) -> u64;
    /// True if it commits faults that end its own process inside a window, not before one.
    fn ends_inside() -> bool {
        false
    }
}
