//! The compression at the end of a step (Mutabaruka and Kamrin, Eq. 27 and 28).
//!
//! The ring obeys F(d) = h(d) + ν d'/dt, with F the effective force, which falls as the ring
//! retreats. F is stiff: so the step is implicit, and the equation is solved by repetition,
//!
//! d ← { [F(d) - h(d)] dt/η + d0 ν/η + d } / (1 + ν/η),
//!
//! whose fixed point F = h + ν (d - d0)/dt does not depend on η, a number of the method alone. Each
//! pass shrinks the error by [η - (k + h') dt] / (η + ν), where k = -dF/dd: it converges while 2η >
//! (k + h') dt - ν, fastest at η = (k + h') dt.
//!
//! An η that adapts takes the slope from the passes, and keeps between trials on either side
//! (`search`): a contact that opens makes F jump, and a repetition with one η goes to and fro
//! across the jump for ever.

use crate::runtime::search::{Search, Slopes};
use crate::table::{BeyondTable, Bracket, Table};
use serde::{Deserialize, Serialize};

/// The method's number η [N·s/m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Eta {
    /// Always this one.
    Fixed(f64),
    /// (k + h') dt of the step, but at least this, then what the passes measure: settles on any
    /// force that falls as the ring retreats, jumps and all.
    AtLeast(f64),
}

/// The ring's law, and how it is solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    /// Damping ν [N·s/m].
    pub damping: f64,
    /// The method's number.
    pub eta: Eta,
    /// A step is settled when a pass changes the compression by less than this times the first
    /// change.
    pub tolerance: f64,
    /// Most passes of a step.
    pub most_passes: u32,
}

impl Default for Law {
    /// Damping and η of Mutabaruka and Kamrin.
    fn default() -> Self {
        Self { damping: 80.0, eta: Eta::AtLeast(10.0), tolerance: 1e-8, most_passes: 100 }
    }
}

/// Resistance that a fluid adds to a surface without mass, where its load is known only from
/// the last exchange: without it, such a surface is unstable.
///
/// The law becomes (ν + Z) (d - d0)/dt - Z d'old = F - h: a force on changes of the velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Impedance(
    /// Z [N·s/m].
    pub f64,
);

impl Impedance {
    /// Z = ρ c A + m/dt: acoustic impedance of a face of `area` [m²] in a fluid of `density`
    /// [kg/m³] and `sound_speed` [m/s], and the `added_mass` [kg] that it must move within
    /// `exchange` [s].
    pub fn of_fluid(
        density: f64,
        sound_speed: f64,
        area: f64,
        added_mass: f64,
        exchange: f64,
    ) -> Self {
        Self(density * sound_speed * area + added_mass / exchange)
    }
}

/// A ring at the start of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Start {
    /// Compression [m].
    pub compression: f64,
    /// Its rate when the fluid's load was found: its mean over the exchange before [m/s].
    pub rate: f64,
    /// Length of the step [s].
    pub dt: f64,
    /// Rate at which the force of all contacts on the foot falls as it retreats, k [N/m]: springs,
    /// and dashpots over the step.
    pub contact_stiffness: f64,
    /// Resistance that the fluid adds.
    pub impedance: Impedance,
}

/// Parts of the table's largest compression that are no change: what round-off could make; and,
/// where trials on either side of a jump close in, what it does to vertices in the world.
const ROUND_OFF: f64 = 8.0 * f64::EPSILON;
const AT_A_JUMP: f64 = 1e-12;

/// A step on its way.
#[derive(Clone, Debug)]
pub struct Step {
    law: Law,
    start: Start,
    eta: f64,
    trial: f64,
    at: Bracket,
    first_change: f64,
    passes: u32,
    search: Search,
    /// Compression and force of the last two passes.
    known: [Option<(f64, f64)>; 2],
}

/// Outcome of a pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// Another pass is needed, with the force at the new trial.
    Again,
    /// The step is done.
    Settled(Settled),
}

/// The end of a step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settled {
    /// Compression [m].
    pub compression: f64,
    /// Its rate over the step [m/s].
    pub rate: f64,
    /// Number of passes.
    pub passes: u32,
}

/// Why a step did not settle.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum StepError {
    /// Compressed beyond the table.
    #[error(transparent)]
    Beyond(#[from] BeyondTable),
    /// A force that is no number.
    #[error(
        "the force on the ring at a compression of {compression} m is {force}; a load is not finite"
    )]
    NotFinite {
        /// The compression [m].
        compression: f64,
        /// The force given [N].
        force: f64,
    },
    /// A force that grows as the ring retreats, in a step that fails.
    #[error(
        "the force on the ring grows by {slope:.3e} N/m as the ring retreats, where contacts of {stiffness:.3e} N/m should let go; \
             its direction is wrong: it must point from the seat to the carrier"
    )]
    WrongSign {
        /// Measured slope of the force [N/m].
        slope: f64,
        /// Stiffness of the contacts [N/m].
        stiffness: f64,
    },
    /// Too many passes.
    #[error(
        "the ring's compression did not settle in {passes} passes: the last changed it by {change:.1e} m; eta is {eta:.3e} N s/m and must exceed \
             {least:.3e} N s/m, half of contact stiffness times step less damping; use an eta that adapts, or a smaller step"
    )]
    NotSettled {
        /// Number of passes made.
        passes: u32,
        /// Change by the last one [m].
        change: f64,
        /// The method's number [N·s/m].
        eta: f64,
        /// Bound that it must exceed [N·s/m].
        least: f64,
    },
}

impl Step {
    /// Begins a step; the first trial is the compression at its start.
    ///
    /// # Errors
    /// If that lies beyond the table.
    pub fn begin(table: &Table, law: Law, start: Start) -> Result<Self, StepError> {
        let at = table.bracket(start.compression)?;
        let newton = (start.contact_stiffness + table.slope(at)) * start.dt;
        let eta = match law.eta {
            Eta::Fixed(eta) => eta,
            Eta::AtLeast(least) => least.max(newton),
        };
        let trial = start.compression.max(0.0);
        let damping = law.damping + start.impedance.0;
        let slopes = Slopes {
            least: table.slope(at) + damping / start.dt,
            first: (eta + damping) / start.dt,
        };
        let search = Search::new(slopes);
        Ok(Self {
            law,
            start,
            eta,
            trial,
            at,
            first_change: 0.0,
            passes: 0,
            search,
            known: [None; 2],
        })
    }

    /// The compression for which the force is wanted [m].
    pub fn trial(&self) -> f64 {
        self.trial
    }

    /// Place of the trial in the table: gives its shape.
    pub fn bracket(&self) -> Bracket {
        self.at
    }

    /// One pass, with the effective `force` [N] at the trial; `table` is the one that it began
    /// with.
    ///
    /// # Errors
    /// If the trial leaves the table, the force is no number, or passes run out; with the reason,
    /// if the force grows as the ring retreats.
    pub fn pass(&mut self, table: &Table, force: f64) -> Result<Outcome, StepError> {
        if !force.is_finite() {
            return Err(StepError::NotFinite { compression: self.trial, force });
        }
        self.known = [self.known[1], Some((self.trial, force))];
        let (next, change) = self.next(table, force);
        self.passes += 1;
        if self.passes == 1 {
            self.first_change = change;
        }
        let is_searched = matches!(self.law.eta, Eta::AtLeast(_));
        let least = if is_searched { AT_A_JUMP } else { ROUND_OFF } * table.last_compression();
        let is_settled = change <= self.law.tolerance * self.first_change + least;
        // What was searched for is found where the force is known; a repetition goes on to where it
        // leads.
        let is_found = is_settled && is_searched;
        self.trial = if is_found { self.trial } else { next };
        self.at = table.bracket(self.trial).map_err(|error| self.blame(error.into()))?;
        if is_settled {
            let (compression, passes) = (self.trial, self.passes);
            let rate = (compression - self.start.compression) / self.start.dt;
            return Ok(Outcome::Settled(Settled { compression, rate, passes }));
        }
        if self.passes >= self.law.most_passes {
            let newton = (self.start.contact_stiffness + table.slope(self.at)) * self.start.dt;
            let least = (0.5 * (newton - self.law.damping - self.start.impedance.0)).max(0.0);
            let (passes, eta) = (self.passes, self.eta);
            let error = StepError::NotSettled { passes, change, eta, least };
            return Err(self.blame(error));
        }
        Ok(Outcome::Again)
    }

    /// The next trial, and what the pass changes [m].
    fn next(&mut self, table: &Table, force: f64) -> (f64, f64) {
        let (trial, excess) = (self.trial, self.excess(table, force));
        match self.law.eta {
            Eta::Fixed(eta) => {
                let damping = self.law.damping + self.start.impedance.0;
                let next = (trial + excess * self.start.dt / (eta + damping)).max(0.0);
                (next, (next - trial).abs())
            }
            // What rests on nothing and is not pushed stays.
            Eta::AtLeast(_) if trial == 0.0 && excess <= 0.0 => (0.0, 0.0),
            Eta::AtLeast(_) => {
                let (next, change) = self.search.next(trial, excess);
                let end = table.last_compression();
                // Beyond the table only from its end.
                (if trial < end { next.clamp(0.0, end) } else { next.max(0.0) }, change)
            }
        }
    }

    /// Excess of the effective `force` over table and resistance at the trial [N].
    fn excess(&self, table: &Table, force: f64) -> f64 {
        let Start { compression, rate, dt, impedance: Impedance(z), .. } = self.start;
        let damping = self.law.damping + z;
        force + z * rate - table.force(self.at) - damping * (self.trial - compression) / dt
    }

    /// Says of a step that fails that its force has the wrong direction, if that grew at last as
    /// the ring retreated, as much as its contacts are stiff: a little it may, because its surface
    /// turns.
    fn blame(&self, error: StepError) -> StepError {
        let [Some((then, was)), Some((trial, force))] = self.known else { return error };
        let (slope, stiffness) = ((force - was) / (trial - then), self.start.contact_stiffness);
        // Changes that round-off could make say nothing.
        let is_clear = (force - was).abs() > 1e-6 * force.abs().max(was.abs());
        match stiffness > 0.0 && is_clear && slope > 0.5 * stiffness {
            true => StepError::WrongSign { slope, stiffness },
            false => error,
        }
    }
}

/// A whole step: asks `force` for the effective force [N] at each trial.
///
/// # Errors
/// As [`Step::pass`].
pub fn relax(
    table: &Table,
    law: Law,
    start: Start,
    mut force: impl FnMut(Bracket) -> f64,
) -> Result<Settled, StepError> {
    let mut step = Step::begin(table, law, start)?;
    loop {
        if let Outcome::Settled(settled) = step.pass(table, force(step.bracket()))? {
            return Ok(settled);
        }
    }
}
