//! Checks of a slider.

use tremie_grains_kit::math::numbers::is_positive;
use tremie_messages::{
    Problem,
    scene::{Slider, SliderSpring, Stops},
};

/// Checks the numbers of a slider at `key`, that of the part's motion.
pub(crate) fn slider(key: &str, slider: &Slider, problems: &mut Vec<Problem>) {
    let key = format!("{key}.slider");
    let mut add = |name: &str, message: String| {
        problems.push(Problem::new(format!("{key}.{name}"), message));
    };
    let square: f64 = slider.axis.iter().map(|x| x * x).sum();
    if !(square.is_normal() && square.is_finite()) {
        add("axis", format!("is {:?}, expected a direction, which has a length", slider.axis));
    }
    if !is_positive(slider.mass) {
        add("mass", format!("is {} kg, expected a positive mass", slider.mass));
    }
    for (name, value) in
        [("lift", slider.lift), ("velocity", slider.velocity), ("force", slider.force)]
    {
        if !value.is_finite() {
            add(name, "is not finite".into());
        }
    }
    let before = problems.len();
    if let Some(stops) = &slider.stops {
        stops_of(&key, stops, slider, problems);
    }
    if problems.len() == before {
        spring(&key, slider, problems);
    }
}

fn stops_of(key: &str, stops: &Stops, slider: &Slider, problems: &mut Vec<Problem>) {
    let mut add = |name: &str, message: String, help: &str| {
        problems.push(Problem::new(format!("{key}.{name}"), message).help(help));
    };
    if !is_positive(stops.stiffness) {
        let message = format!("is {} N/m, expected a positive stiffness", stops.stiffness);
        add("stops.stiffness", message, "1e7 N/m is that of a contact of steel with small grains");
    }
    let e = stops.restitution;
    if !(e > 0.0 && e <= 1.0) {
        let message = format!("is {e}, expected a coefficient of restitution in (0, 1]");
        add("stops.restitution", message, "0.2 is a dull stop, 1 loses no energy");
    }
    let ends = [("stops.lower", stops.lower), ("stops.upper", stops.upper)];
    for (name, end) in ends {
        if end.is_some_and(|end| !end.is_finite()) {
            add(name, "is not finite".into(), "leave the stop out where there is none");
            return;
        }
    }
    if let (Some(lower), Some(upper)) = (stops.lower, stops.upper)
        && lower >= upper
    {
        let message = format!("is at {upper} m, not above the lower stop at {lower} m");
        add("stops.upper", message, "lifts grow along the axis");
        return;
    }
    let (lift, give) = (slider.lift, give(slider, stops.stiffness));
    let beyond = [
        stops.lower.filter(|&low| lift < low - give),
        stops.upper.filter(|&high| lift > high + give),
    ];
    for (which, end) in ["lower", "upper"].into_iter().zip(beyond) {
        if let Some(end) = end {
            let message = format!(
                "is {lift} m, beyond the {which} stop at {end} m, which gives way by {give:.1e} m at most"
            );
            add("lift", message, "start between the stops, or as deep in one as forces press it");
        }
    }
}

/// Largest depth at which a stop may hold the slider at rest [m]: twice as deep as spring and
/// constant force press it.
fn give(slider: &Slider, stiffness: f64) -> f64 {
    let pressed = match &slider.spring {
        SliderSpring::None => 0.0,
        SliderSpring::Linear { preload, .. } | SliderSpring::Tangent { preload, .. } => {
            preload.abs()
        }
        SliderSpring::Table(points) => points.iter().fold(0.0, |a: f64, p| a.max(p[1].abs())),
    };
    2.0 * (pressed + slider.force.abs()) / stiffness
}

fn spring(key: &str, slider: &Slider, problems: &mut Vec<Problem>) {
    let key = format!("{key}.spring");
    let mut add = |name: &str, message: String, help: &str| {
        problems.push(Problem::new(format!("{key}{name}"), message).help(help));
    };
    let ends = slider.stops.and_then(|stops| stops.lower.zip(stops.upper));
    match &slider.spring {
        SliderSpring::None => {}
        SliderSpring::Linear { rate, preload } => {
            if !(*rate >= 0.0 && rate.is_finite()) {
                add(".rate", format!("is {rate} N/m, expected 0 or more"), "give a stiffness");
            }
            if !preload.is_finite() {
                add(".preload", "is not finite".into(), "give the force at lift 0");
            }
        }
        SliderSpring::Tangent { rate, preload, stroke } => {
            if !is_positive(*rate) {
                add(".rate", format!("is {rate} N/m, expected a positive one"), "give a stiffness");
            } else if slider.stops.is_some_and(|stops| stops.stiffness <= *rate) {
                let message = format!("is {rate} N/m, not softer than the stops");
                add(".rate", message, "make the stops stiffer");
            }
            if !preload.is_finite() {
                add(".preload", "is not finite".into(), "give the force at lift 0");
            }
            if !is_positive(*stroke) {
                let help = "it is the lift at which no travel is left";
                add(".stroke", format!("is {stroke} m, expected a positive one"), help);
            } else if ends.is_none_or(|(lower, upper)| lower <= -stroke || upper > *stroke) {
                let message = format!(
                    "is {stroke} m, but no stops keep the lift between minus and plus that"
                );
                add(".stroke", message, "give a lower and an upper stop");
            } else if slider.lift.abs() > *stroke {
                let message =
                    format!("is {stroke} m, but the lift begins at {} m, beyond it", slider.lift);
                add(".stroke", message, "start where the spring has travel left");
            }
        }
        SliderSpring::Table(points) => table(points, ends, &mut |message, help| {
            add(".table", message, help);
        }),
    }
}

fn table(points: &[[f64; 2]], ends: Option<(f64, f64)>, add: &mut dyn FnMut(String, &str)) {
    let (Some([first, _]), Some([last, _])) = (points.first(), points.last()) else {
        return add("is empty".into(), "give two points of lift and force or more");
    };
    if points.iter().flatten().any(|x| !x.is_finite()) {
        return add("holds a number that is not finite".into(), "give lifts and forces");
    }
    if points.len() < 2 {
        return add("has one point".into(), "give two points of lift and force or more");
    }
    if let Some(k) = (1..points.len()).find(|&k| points[k][0] <= points[k - 1][0]) {
        let (found, before) = (points[k][0], points[k - 1][0]);
        return add(format!("has {found} m after {before} m"), "give lifts that ascend");
    }
    match ends {
        None => add(
            format!("reaches from {first} m to {last} m, and no stops keep the lift there"),
            "give a lower and an upper stop within it",
        ),
        Some((lower, upper)) if lower < *first || upper > *last => add(
            format!(
                "reaches from {first} m to {last} m and does not cover the stroke, {lower} m to {upper} m"
            ),
            "add points, or move the stops",
        ),
        Some(_) => {}
    }
}
