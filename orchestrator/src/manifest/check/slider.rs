//! Checks of parts that slide: what a table lacks. Numbers are the component's to judge that moves
//! them.

use super::super::document::{PreloadEntry, SliderSpringTable, SliderTable, StopsTable};
use super::super::path;
use super::super::read::Findings;
use tremie_messages::scene::{Slider, SliderSpring, Stops};

/// The slider of a table.
pub(super) fn slider(table: &SliderTable, at: &str, findings: &mut Findings) -> Option<Slider> {
    let axis = findings.required(&table.axis, at, "axis").filter(|axis| {
        let directed = axis.iter().map(|a| a * a).sum::<f64>().is_normal();
        if !directed {
            let message = format!("found {axis:?}, expected a direction, which has a length");
            findings.problem(&path::join(at, "axis"), message);
        }
        directed
    });
    let mass = findings.positive(&table.mass, at, "mass");
    let spring = match &table.spring {
        Some(spring) => self::spring(spring, &path::join(at, "spring"), findings),
        None => Some(SliderSpring::None),
    };
    let stops = match &table.stops {
        Some(stops) => self::stops(stops, &path::join(at, "stops"), findings).map(Some),
        None => Some(None),
    };
    Some(Slider {
        axis: axis?,
        mass: mass?,
        lift: table.lift?.0,
        velocity: table.velocity?.0,
        spring: spring?,
        force: table.force?.0,
        stops: stops?,
    })
}

fn spring(table: &SliderSpringTable, at: &str, findings: &mut Findings) -> Option<SliderSpring> {
    let kinds = [("rate", table.rate.is_some()), ("table", table.table.is_some())];
    let kind = findings.only_one(&kinds, "the spring's force", at)?;
    if kind == "table" {
        let others = [("preload", table.preload.is_some()), ("stroke", table.stroke.is_some())];
        if let Some((key, _)) = others.iter().find(|(_, given)| *given) {
            let message = "only a spring with a rate has it; a table says all";
            findings.problem(&path::join(at, key), message);
            return None;
        }
        let points = table.table.as_ref()?.iter().map(|(lift, force)| [lift.0, force.0]);
        return Some(SliderSpring::Table(points.collect()));
    }
    let rate = table.rate?.0;
    let preload = match table.preload {
        None => 0.0,
        Some(PreloadEntry::Force(force)) => force.0,
        Some(PreloadEntry::Length(length)) => rate * length.0,
    };
    Some(match table.stroke {
        None => SliderSpring::Linear { rate, preload },
        Some(stroke) => SliderSpring::Tangent { rate, preload, stroke: stroke.0 },
    })
}

fn stops(table: &StopsTable, at: &str, findings: &mut Findings) -> Option<Stops> {
    let stiffness = findings.positive(&table.stiffness, at, "stiffness");
    let restitution = findings.required(&table.restitution, at, "restitution");
    let (lower, upper) = (table.lower.map(|y| y.0), table.upper.map(|y| y.0));
    if lower.is_none() && upper.is_none() {
        let message = "found neither lower nor upper, expected one of them or both";
        findings.problem(at, message);
        return None;
    }
    Some(Stops { lower, upper, stiffness: stiffness?, restitution: restitution? })
}
