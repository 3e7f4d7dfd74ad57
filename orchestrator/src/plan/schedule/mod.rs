//! The schedule: edges between components, and the script of each component in a window.
//!
//! Exchange 0 is the start exchange; windows count from 1. [`wire`] is a pure function of the
//! roles that are present; [`check`] proves of its result that it neither locks up nor overruns a
//! channel.
//!
//! | | start exchange | window k |
//! | --- | --- | --- |
//! | grains | send events, send state | take loads of k-1, advance, send events, send state |
//! | rubber | look, send surface | take surface loads of k-1, advance, send surface |
//! | fluid, serial | take events, state, surface; look, send loads | take events, state, surface; advance, send loads |
//! | fluid, parallel | as serial | advance, send loads; take events, state, surface |
//!
//! In a parallel schedule the fluid of window k advances with the bodies at the window's start, and
//! takes the bodies at its end only afterwards; its loads of window k answer event list k-1. The
//! surface is treated as a body is, and its loads as those on bodies. Inlets of grains may take
//! velocities of the fluid at open faces. These velocities go along with the loads, before them
//! ([`Wiring::with_ports`]).
//!
//! # Inside a window
//!
//! Grains and rubber advance together, in an exchange of their own that has as many messages as the
//! rubber needs trials (`tremie_sdk`, `substep_coupling.rs`). Its edges are in no script, and
//! outside the marked graph. In the graph both advances are one event, because neither begins
//! alone: [`check`] merges them. A schedule in which one of them had to wait for the other's next
//! window locks up.
//!
//! Inside, each side sends only the message that the other waits for, and nothing more until the
//! answer comes. So at most one message is under way on each edge, whatever the number of trials.
//! There are two at the start: the carriers of the start exchange, which have no answer, and those
//! of the first substep. The tests carry the exchange out in any order of turns and count.

mod check;
mod graph;
#[cfg(test)]
mod tests;

pub use check::{ScheduleError, check};

use tremie_messages::Role;
use tremie_messages::schedule::{Content, Op, Schedule, Script};

/// Edges and scripts of all components.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wiring {
    /// The components, in the order given to [`wire`].
    pub members: Vec<Member>,
    /// All edges.
    pub links: Vec<Link>,
}

/// A component in the wiring.
#[derive(Clone, Debug, PartialEq)]
pub struct Member {
    /// Its name.
    pub name: String,
    /// Indices of its edges in [`Wiring::links`]; its script's operations index this list.
    pub links: Vec<usize>,
    /// Its operations.
    pub script: Script,
}

/// An edge between two members.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Link {
    /// Index of the sending member.
    pub from: usize,
    /// Index of the receiving member.
    pub to: usize,
    /// Content of its messages.
    pub content: Content,
    /// Most messages that the channel holds.
    pub depth: u64,
    /// Number of event lists by which the content lags behind its own window.
    pub events_lag: u64,
}

/// Wires up components of the given names and roles. One fluid, one grains and one rubber exchange
/// messages; any alone just advances; observers do nothing here (they follow their frames).
pub fn wire(schedule: Schedule, components: &[(&str, Role)]) -> Wiring {
    let members = components.iter().map(|(name, role)| Member {
        name: (*name).to_string(),
        links: Vec::new(),
        script: if *role == Role::Observer { Script::default() } else { alone() },
    });
    let mut wiring = Wiring { members: members.collect(), links: Vec::new() };
    let find = |wanted| components.iter().position(|(_, role)| *role == wanted);
    let (grains, fluid, rubber) = (find(Role::Grains), find(Role::Fluid), find(Role::Rubber));
    if let (Some(grains), Some(fluid)) = (grains, fluid) {
        couple(&mut wiring, schedule, grains, fluid);
    }
    // A surface has no carrier without grains.
    if let (Some(grains), Some(rubber)) = (grains, rubber) {
        join(&mut wiring, grains, rubber);
        if let Some(fluid) = fluid {
            immerse(&mut wiring, schedule, rubber, fluid, grains);
        }
    }
    wiring
}

/// A component without peers: it looks at the start, and advances.
fn alone() -> Script {
    Script { start: vec![Op::Advance], window: vec![Op::Advance], resume: Vec::new() }
}

// Places of the first three edges in the lists of grains and fluid.
const EVENTS: usize = 0;
const STATE: usize = 1;
const LOAD: usize = 2;

fn couple(wiring: &mut Wiring, schedule: Schedule, grains: usize, fluid: usize) {
    let lag = u64::from(schedule == Schedule::Parallel);
    let depth = depth(schedule);
    wiring.link(Link { from: grains, to: fluid, content: Content::Events, depth, events_lag: 0 });
    wiring.link(Link { from: grains, to: fluid, content: Content::State, depth, events_lag: 0 });
    wiring.link(Link { from: fluid, to: grains, content: Content::Load, depth, events_lag: lag });
    wiring.members[grains].script = grains_script();
    let hear = [Op::Receive { edge: EVENTS, lag: 0 }, Op::Receive { edge: STATE, lag: 0 }];
    let work = [Op::Advance, Op::Send { edge: LOAD }];
    wiring.members[fluid].script = fluid_script(schedule, &hear, &work);
}

/// The exchange of grains and rubber inside a window.
fn join(wiring: &mut Wiring, grains: usize, rubber: usize) {
    for (from, to, content) in [
        (grains, rubber, Content::Carrier),
        (rubber, grains, Content::Trial),
        (grains, rubber, Content::Contact),
        (rubber, grains, Content::Resultant),
    ] {
        wiring.link(Link { from, to, content, depth: INSIDE_BOUND + 1, events_lag: 0 });
    }
}

/// The rubber's surface in the fluid.
fn immerse(wiring: &mut Wiring, schedule: Schedule, rubber: usize, fluid: usize, grains: usize) {
    let lag = u64::from(schedule == Schedule::Parallel);
    let depth = depth(schedule);
    let link = |from, to, content, events_lag| Link { from, to, content, depth, events_lag };
    let [sent, heard] = wiring.link(link(rubber, fluid, Content::Surface, 0));
    let [told, taken] = wiring.link(link(fluid, rubber, Content::SurfaceLoad, lag));
    let tell = [Op::Advance, Op::Send { edge: sent }];
    let window = [&[Op::Receive { edge: taken, lag: 1 }][..], &tell].concat();
    wiring.members[rubber].script = Script { start: tell.to_vec(), window, resume: Vec::new() };
    // In the start exchange grains send where the carriers are, which the rubber needs first.
    wiring.members[grains].script.start.insert(0, Op::Advance);
    let hear = [EVENTS, STATE, heard].map(|edge| Op::Receive { edge, lag: 0 });
    let work = [Op::Advance, Op::Send { edge: LOAD }, Op::Send { edge: told }];
    wiring.members[fluid].script = fluid_script(schedule, &hear, &work);
}

impl Wiring {
    /// Adds an edge for the velocities at open faces from fluid to grains: each message just before
    /// the loads of the same window.
    pub fn with_ports(mut self) -> Self {
        let Some(load) = self.links.iter().find(|link| link.content == Content::Load) else {
            return self;
        };
        let link = Link { content: Content::Ports, ..load.clone() };
        let [fluid, grains] = [link.from, link.to];
        let [told, heard] = self.link(link);
        before(&mut self.members[fluid].script, |op| match op {
            Op::Send { edge: LOAD } => Some(Op::Send { edge: told }),
            _ => None,
        });
        before(&mut self.members[grains].script, |op| match op {
            Op::Receive { edge: LOAD, lag } => Some(Op::Receive { edge: heard, lag }),
            _ => None,
        });
        self
    }

    /// What a member sends again where a run goes on from a checkpoint: of the checkpoint's window, the
    /// messages that their receivers take in the next. [`check`] proves that no message is under way for
    /// longer.
    pub fn resume(&self, member: usize) -> Vec<Op> {
        let is_under_way = |op: &&Op| match op {
            Op::Send { edge } => self.lag_of(self.members[member].links[*edge]) > 0,
            _ => false,
        };
        self.members[member].script.window.iter().filter(is_under_way).copied().collect()
    }

    /// Windows between the sending of an edge's message and its receipt.
    fn lag_of(&self, link: usize) -> u64 {
        let receiver = &self.members[self.links[link].to];
        let of_link = |op: &Op| match *op {
            Op::Receive { edge, lag } if receiver.links[edge] == link => Some(lag),
            _ => None,
        };
        receiver.script.window.iter().find_map(of_link).unwrap_or(0)
    }

    /// Windows between the advance that an edge's message is of and the first advance of the receiver
    /// that uses it: a receiver that takes it only after its own advance uses it a window later.
    pub fn delay_of(&self, link: usize) -> u64 {
        let receiver = &self.members[self.links[link].to];
        let is_receipt =
            |op: &Op| matches!(*op, Op::Receive { edge, .. } if receiver.links[edge] == link);
        let ops = &receiver.script.window;
        let advance = ops.iter().position(|op| *op == Op::Advance);
        let is_late = ops.iter().position(is_receipt).is_some_and(|at| Some(at) > advance);
        self.lag_of(link) + u64::from(is_late)
    }

    /// Adds an edge; returns its places in the lists of sender and receiver.
    fn link(&mut self, link: Link) -> [usize; 2] {
        let ends = [link.from, link.to];
        self.links.push(link);
        ends.map(|member| {
            let links = &mut self.members[member].links;
            links.push(self.links.len() - 1);
            links.len() - 1
        })
    }
}

/// Puts operations before those to which `belongs` finds one.
fn before(script: &mut Script, belongs: impl Fn(Op) -> Option<Op>) {
    for ops in [&mut script.start, &mut script.window] {
        *ops = ops.iter().flat_map(|op| belongs(*op).into_iter().chain([*op])).collect();
    }
}

/// Most messages under way on an edge inside a window.
const INSIDE_BOUND: u64 = 2;

/// Most messages that a channel holds: the messages that the schedule has under way at once (1
/// serial, 2 parallel; [`check`] proves it), and one more. This one keeps a sender that breaks the
/// protocol from waiting: its message arrives, and the receiver's look at the stamp names the
/// fault.
fn depth(schedule: Schedule) -> u64 {
    match schedule {
        Schedule::Serial => 2,
        Schedule::Parallel => 3,
    }
}

fn grains_script() -> Script {
    let tell = [Op::Send { edge: EVENTS }, Op::Send { edge: STATE }];
    let mut window = vec![Op::Receive { edge: LOAD, lag: 1 }, Op::Advance];
    window.extend(tell);
    Script { start: tell.to_vec(), window, resume: Vec::new() }
}

fn fluid_script(schedule: Schedule, hear: &[Op], work: &[Op]) -> Script {
    let serial = [hear, work].concat();
    let window = match schedule {
        Schedule::Serial => serial.clone(),
        // The fluid advances with the bodies of the window's start, then takes those of its end.
        Schedule::Parallel => [work, hear].concat(),
    };
    Script { start: serial, window, resume: Vec::new() }
}
