//! Stamps: the run, the window and the exchange to which a message belongs.

use crate::Message;
use serde::{Deserialize, Serialize};

/// Stamp of a message: the exchange that it belongs to. A receiver knows from its script which
/// stamp must come next; any other is a fault.
///
/// Exchange 0 is the start exchange at time zero; exchange `k` ends coupling window `k`
/// (windows are numbered from 1). Time is counted in ticks so that clocks cannot drift apart;
/// the length of a tick is in the start contract ([`crate::start::Clock`]).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stamp {
    /// Id of the run.
    pub run: u64,
    /// Coupling window that ends with this message; 0 for the start exchange.
    pub window: u64,
    /// Simulated time in ticks at which the content holds.
    pub ticks: u64,
    /// Number of the last event list that the content takes into account. Loads carry the number
    /// of the list that they answer, so that a changed set of bodies never meets old loads.
    pub events: u64,
    /// Substeps that the sender made in this window (0 in the start exchange); inside the window,
    /// the substep that is being made, from 1.
    pub substep: u32,
    /// Trial of a substep that the message belongs to, from 1; 0 outside the exchange inside a
    /// window. With [`Stamp::FINAL`] it belongs to the accepted surface, which follows the last
    /// trial.
    pub iteration: u32,
}

impl Stamp {
    /// The bit of [`Stamp::iteration`] that tells the accepted surface of a substep from a trial.
    pub const FINAL: u32 = 1 << 31;

    /// True if the message belongs to the accepted surface of a substep.
    pub fn is_final(&self) -> bool {
        self.iteration & Self::FINAL != 0
    }

    /// Number of the trial, without the bit that says final.
    pub fn trial(&self) -> u32 {
        self.iteration & !Self::FINAL
    }
}

// SAFETY: six integers, 40 bytes, no padding.
unsafe impl Message for Stamp {
    const TYPE_NAME: &'static str = "tremie.Stamp.1";
}

impl std::fmt::Display for Stamp {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "window {}, substep {}, tick {}, event list {}, run {:016x}",
            self.window, self.substep, self.ticks, self.events, self.run
        )?;
        match (self.trial(), self.is_final()) {
            (0, false) => Ok(()),
            (trial, false) => write!(f, ", trial {trial}"),
            (trial, true) => write!(f, ", trial {trial}, the accepted one"),
        }
    }
}
