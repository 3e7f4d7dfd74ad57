//! The order of work: which messages go where, and what each component does in a window.
//!
//! Exchange 0 is the start exchange; windows count from 1. [`wire`] is a pure function of the
//! roles that are present; [`check`] proves of its result that it neither locks up nor overruns a
//! channel.
//!
//! | | start exchange | window k |
//! | --- | --- | --- |
//! | grains | send events, send state | take loads of k-1, advance, send events, send state |
//! | fluid, serial | take events, take state, look, send loads | take events, take state, advance, send loads |
//! | fluid, parallel | as serial | advance, send loads, take events, take state |
//!
//! In a parallel schedule the fluid of window k advances with the bodies at the window's start, and
//! takes the bodies at its end only afterwards; its loads of window k answer event list k-1.

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
    /// What it does.
    pub script: Script,
}

/// An edge between two members.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Link {
    /// Index of the sending member.
    pub from: usize,
    /// Index of the receiving member.
    pub to: usize,
    /// What travels.
    pub content: Content,
    /// Most messages that the channel holds.
    pub depth: u64,
    /// How many event lists the content lags behind its own window.
    pub events_lag: u64,
}

/// Wires up components of the given names and roles. One fluid and one grains exchange messages;
/// either alone just advances; observers do nothing here (they follow their frames).
pub fn wire(schedule: Schedule, components: &[(&str, Role)]) -> Wiring {
    let members = components.iter().map(|(name, role)| Member {
        name: (*name).to_string(),
        links: Vec::new(),
        script: if *role == Role::Observer { Script::default() } else { alone() },
    });
    let mut wiring = Wiring { members: members.collect(), links: Vec::new() };
    let find = |wanted| components.iter().position(|(_, role)| *role == wanted);
    if let (Some(grains), Some(fluid)) = (find(Role::Grains), find(Role::Fluid)) {
        couple(&mut wiring, schedule, grains, fluid);
    }
    wiring
}

/// A component without peers: it looks at the start, and advances.
fn alone() -> Script {
    Script { start: vec![Op::Advance], window: vec![Op::Advance] }
}

// Places of the three edges in the lists of both components.
const EVENTS: usize = 0;
const STATE: usize = 1;
const LOAD: usize = 2;

fn couple(wiring: &mut Wiring, schedule: Schedule, grains: usize, fluid: usize) {
    let link = |from, to, content, events_lag| Link {
        from,
        to,
        content,
        depth: depth(schedule),
        events_lag,
    };
    let lag = u64::from(schedule == Schedule::Parallel);
    wiring.links = vec![
        link(grains, fluid, Content::Events, 0),
        link(grains, fluid, Content::State, 0),
        link(fluid, grains, Content::Load, lag),
    ];
    for member in [grains, fluid] {
        wiring.members[member].links = vec![EVENTS, STATE, LOAD];
    }
    wiring.members[grains].script = grains_script();
    wiring.members[fluid].script = fluid_script(schedule);
}

/// Most messages that a channel holds: those that the schedule has under way at once (1 serial,
/// 2 parallel; [`check`] proves it) and one more. The one more keeps a sender that breaks the
/// protocol from waiting: its message arrives, and the receiver's look at the stamp names the fault.
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
    Script { start: tell.to_vec(), window }
}

fn fluid_script(schedule: Schedule) -> Script {
    let hear = [Op::Receive { edge: EVENTS, lag: 0 }, Op::Receive { edge: STATE, lag: 0 }];
    let work = [Op::Advance, Op::Send { edge: LOAD }];
    let serial = [hear, work].concat();
    let window = match schedule {
        Schedule::Serial => serial.clone(),
        Schedule::Parallel => [work, hear].concat(),
    };
    Script { start: serial, window }
}
