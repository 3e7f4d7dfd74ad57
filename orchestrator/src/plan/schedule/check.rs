//! Proof that scripts neither lock up nor overrun a channel.

use super::graph::{Graph, Place};
use super::{INSIDE_BOUND, Link, Member, Wiring};
use tremie_messages::schedule::Op;

/// Fault of scripts that cannot be carried out for ever.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ScheduleError {
    /// Operations wait for each other in a circle that holds no message.
    #[error("the schedule locks up: {}", .cycle.join(", which waits for "))]
    Deadlock {
        /// The operations, each of which waits for the next.
        cycle: Vec<String>,
    },
    /// An edge is not sent, or not received, exactly once where it must be.
    #[error("{edge}: {message}")]
    Unbalanced {
        /// The edge.
        edge: String,
        /// Description of the fault.
        message: String,
    },
    /// A channel can be asked to hold more messages than it can.
    #[error("{edge}: {bound} messages can be under way, its channel holds {depth}")]
    Overflow {
        /// The edge.
        edge: String,
        /// Most messages under way.
        bound: u64,
        /// Messages that the channel holds.
        depth: u64,
    },
    /// An operation names an edge that its component does not have.
    #[error("{component}: its script names edge {edge}, which it does not have")]
    NoSuchEdge {
        /// The component.
        component: String,
        /// The index.
        edge: usize,
    },
}

/// Part of the scripts: start exchange or window.
#[derive(Clone, Copy, PartialEq)]
enum Phase {
    Start,
    Window,
}

/// A sending or receiving operation of an edge.
#[derive(Clone, Copy)]
struct Hit {
    event: usize,
    lag: u64,
}

/// Checks that every edge is sent and received once a window, and that every receive finds the
/// message of its window. Checks that no operations wait for each other in a circle, and that no
/// channel has to hold more than its depth.
///
/// Each operation of the scripts is an event of a marked graph; the order inside a script and the
/// edges are its places; a message that is received `lag` windows after it was sent makes `lag`
/// tokens. The advances of two components with an exchange inside the window are one event.
///
/// # Errors
/// The first of these that does not hold.
pub fn check(wiring: &Wiring) -> Result<(), ScheduleError> {
    // Messages that the start exchange leaves under way are the lag that windows must have.
    let mut left = vec![0; wiring.links.len()];
    for phase in [Phase::Start, Phase::Window] {
        let events = events(wiring, phase)?;
        let (mut graph, labels) = scripts_as_graph(wiring, phase, &events)?;
        let mut channels = Vec::new();
        for (index, link) in wiring.links.iter().enumerate() {
            let sends = hits(wiring, index, phase, &events, true);
            let receives = hits(wiring, index, phase, &events, false);
            if link.content.is_inside_window() {
                inside(wiring, link, sends.len() + receives.len())?;
                continue;
            }
            if let Some(place) =
                channel(link, &label(wiring, link), phase, &sends, &receives, &mut left[index])?
            {
                graph.places.push(place);
                channels.push((link, place));
            }
        }
        if let Some(cycle) = graph.dead_cycle() {
            // The graph runs from cause to effect; waiting runs the other way.
            let cycle = cycle.iter().rev().map(|event| labels[*event].clone()).collect();
            return Err(ScheduleError::Deadlock { cycle });
        }
        // Bounds need cycles: only windows repeat, the start exchange happens once.
        if phase == Phase::Window {
            channels.iter().try_for_each(|(link, place)| holds(wiring, &graph, link, *place))?;
        }
    }
    Ok(())
}

/// Events of all operations, counted through the members: a number of its own for each, but one for
/// the advances of two members with an exchange inside the window.
fn events(wiring: &Wiring, phase: Phase) -> Result<Vec<usize>, ScheduleError> {
    let firsts: Vec<usize> = (wiring.members.iter())
        .scan(0, |next, member| {
            let first = *next;
            *next += script(member, phase).len();
            Some(first)
        })
        .collect();
    let count = wiring.members.iter().map(|member| script(member, phase).len()).sum();
    let mut events: Vec<usize> = (0..count).collect();
    for link in wiring.links.iter().filter(|link| link.content.is_inside_window()) {
        let advance = |member: usize| {
            let ops = script(&wiring.members[member], phase);
            let mut all = (0..ops.len()).filter(|op| ops[*op] == Op::Advance);
            match (all.next(), all.next()) {
                (Some(op), None) => Ok(firsts[member] + op),
                (found, _) => Err(ScheduleError::Unbalanced {
                    edge: label(wiring, link),
                    message: format!(
                        "{} advances {} in a round of its script, expected once: the exchange is part of it",
                        wiring.members[member].name,
                        if found.is_some() { "more than once" } else { "never" }
                    ),
                }),
            }
        };
        let (one, other) = (advance(link.from)?, advance(link.to)?);
        // The lower number stays. All places into and out of either advance now meet in one event.
        let (keep, gone) = (events[one].min(events[other]), events[one].max(events[other]));
        events.iter_mut().filter(|event| **event == gone).for_each(|event| *event = keep);
    }
    Ok(events)
}

/// No operation names an edge inside a window, whose channel holds the messages that the exchange
/// has under way.
fn inside(wiring: &Wiring, link: &Link, hits: usize) -> Result<(), ScheduleError> {
    let edge = label(wiring, link);
    if hits > 0 {
        let message = "it belongs to an exchange inside the window, but a script names it".into();
        return Err(ScheduleError::Unbalanced { edge, message });
    }
    if link.depth < INSIDE_BOUND {
        return Err(ScheduleError::Overflow { edge, bound: INSIDE_BOUND, depth: link.depth });
    }
    Ok(())
}

/// The scripts alone: each operation after the one before; in windows, the first after the last of
/// the window before.
fn scripts_as_graph(
    wiring: &Wiring,
    phase: Phase,
    events: &[usize],
) -> Result<(Graph, Vec<String>), ScheduleError> {
    let mut graph = Graph { events: events.len(), places: Vec::new() };
    let mut labels: Vec<String> = Vec::new();
    for member in &wiring.members {
        let first = labels.len();
        for op in script(member, phase) {
            let number = labels.len();
            labels.push(format!("{} {}", member.name, words(wiring, member, *op)?));
            if number > first {
                graph.place(events[number - 1], events[number], 0);
            }
        }
        if phase == Phase::Window && labels.len() > first {
            // The token lets the first window begin; the last operation gives it back to the next
            // one.
            graph.place(events[labels.len() - 1], events[first], 1);
        }
    }
    Ok((graph, labels))
}

/// The place that an edge makes. `left`: messages that the start exchange leaves under way.
fn channel(
    link: &Link,
    edge: &str,
    phase: Phase,
    sends: &[(usize, Hit)],
    receives: &[(usize, Hit)],
    left: &mut u64,
) -> Result<Option<Place>, ScheduleError> {
    let wrong =
        |message: String| Err(ScheduleError::Unbalanced { edge: edge.to_string(), message });
    let stranger = sends.iter().any(|(member, _)| *member != link.from)
        || receives.iter().any(|(member, _)| *member != link.to);
    if stranger {
        return wrong("it is used against its direction".into());
    }
    let counts = (sends.len(), receives.len());
    match (phase, counts) {
        (_, (1, 1)) => {}
        // An edge may stay unused in the start exchange.
        (Phase::Start, (0, 0)) => return Ok(None),
        // Sent, and taken by the first window: from then on one message is always under way.
        (Phase::Start, (1, 0)) => {
            *left = 1;
            return Ok(None);
        }
        (Phase::Start, (sent, received)) => {
            return wrong(format!(
                "sent {sent} times and received {received} times in the start exchange"
            ));
        }
        (Phase::Window, (sent, received)) => {
            return wrong(format!(
                "sent {sent} times and received {received} times in a window, expected once each"
            ));
        }
    }
    let (send, receive) = (sends[0].1, receives[0].1);
    let expected = if phase == Phase::Start { 0 } else { *left };
    if receive.lag != expected {
        return wrong(format!(
            "received with a lag of {} windows, but the message that comes is {expected} windows old",
            receive.lag
        ));
    }
    Ok(Some(Place { from: send.event, to: receive.event, tokens: receive.lag }))
}

fn holds(wiring: &Wiring, graph: &Graph, link: &Link, place: Place) -> Result<(), ScheduleError> {
    match graph.bound(place) {
        Some(bound) if bound <= link.depth => Ok(()),
        bound => Err(ScheduleError::Overflow {
            edge: label(wiring, link),
            bound: bound.unwrap_or(u64::MAX),
            depth: link.depth,
        }),
    }
}

/// Operations of the link, with the member that carries them out.
fn hits(
    wiring: &Wiring,
    link: usize,
    phase: Phase,
    events: &[usize],
    sending: bool,
) -> Vec<(usize, Hit)> {
    let mut hits = Vec::new();
    let mut number = 0;
    for (index, member) in wiring.members.iter().enumerate() {
        for op in script(member, phase) {
            let lag = match *op {
                Op::Send { edge } if sending && member.links.get(edge) == Some(&link) => Some(0),
                Op::Receive { edge, lag } if !sending && member.links.get(edge) == Some(&link) => {
                    Some(lag)
                }
                _ => None,
            };
            hits.extend(lag.map(|lag| (index, Hit { event: events[number], lag })));
            number += 1;
        }
    }
    hits
}

fn script(member: &Member, phase: Phase) -> &[Op] {
    match phase {
        Phase::Start => &member.script.start,
        Phase::Window => &member.script.window,
    }
}

fn label(wiring: &Wiring, link: &Link) -> String {
    let name = |index: usize| wiring.members[index].name.as_str();
    format!("{} -> {}, {}", name(link.from), name(link.to), link.content.name())
}

/// An operation in words; an error if it names an edge that is not there.
fn words(wiring: &Wiring, member: &Member, op: Op) -> Result<String, ScheduleError> {
    let (verb, edge) = match op {
        Op::Advance => return Ok("advances".into()),
        Op::Send { edge } => ("sends", edge),
        Op::Receive { edge, .. } => ("receives", edge),
    };
    match member.links.get(edge).and_then(|link| wiring.links.get(*link)) {
        Some(link) => Ok(format!("{verb} {}", link.content.name())),
        None => Err(ScheduleError::NoSuchEdge { component: member.name.clone(), edge }),
    }
}
