//! Signals of probes: name, unit, meaning and value of each.

use tremie_messages::finding::short;
use tremie_messages::scene::{Probe, ProbeShape, Scene};
use tremie_messages::start::Signal;
use tremie_messages::start::signal_row::{SignalRow, push};

/// Values of a probe, SI units; of a profile only the velocity counts.
#[derive(Clone, Copy, Debug, Default)]
pub struct ProbeValues {
    /// Mean over the fluid [Pa].
    pub pressure: f64,
    /// Mean over the fluid [m/s].
    pub velocity: [f64; 3],
    /// Share of the place that no fluid fills.
    pub solid_fraction: f64,
    /// Of a section, volume [m³/s].
    pub flow_rate: f64,
    /// Of a section, mass [kg/s].
    pub mass_flow_rate: f64,
}

/// Of points, lines, regions and rings; points and lines have no share of solid.
const OF_PLACES: [SignalRow<ProbeValues>; 5] = [
    ("pressure", "Pa", "gauge pressure there, a mean over the fluid", |m| m.pressure),
    ("velocity_x", "m/s", "mean velocity of the fluid there", |m| m.velocity[0]),
    ("velocity_y", "m/s", "mean velocity of the fluid there", |m| m.velocity[1]),
    ("velocity_z", "m/s", "mean velocity of the fluid there", |m| m.velocity[2]),
    ("solid_fraction", "1", "share of the place that no fluid fills", |m| m.solid_fraction),
];

/// Of sections.
const OF_SECTIONS: [SignalRow<ProbeValues>; 3] = [
    (
        "flow_rate",
        "m³/s",
        "volume of fluid that passes in a second at the row's time, positive along the axis",
        |m| m.flow_rate,
    ),
    OF_PLACES[0],
    (
        "mass_flow_rate",
        "kg/s",
        "mass of fluid that crosses from cell to cell in a second, positive along the axis; mean over the time since the row before",
        |m| m.mass_flow_rate,
    ),
];

/// The signals of a probe of a shape; of a profile, whose strips have one each, none.
pub fn rows(shape: &ProbeShape) -> &'static [SignalRow<ProbeValues>] {
    match shape {
        ProbeShape::Point(_) | ProbeShape::Line { .. } => &OF_PLACES[..4],
        ProbeShape::Section { .. } => &OF_SECTIONS,
        ProbeShape::Profile { .. } => &[],
        ProbeShape::Region { .. } | ProbeShape::Ring(_) => &OF_PLACES,
    }
}

/// Name, unit and meaning of the values of a scene's probes, in their order: `probe.value`.
pub fn probe_signals(scene: &Scene) -> Vec<(String, &'static str, String)> {
    scene.probes.iter().flat_map(of_probe).collect()
}

/// Describes the signals of a scene's probes, which are measured where a row is kept.
pub fn describe_probes(scene: &Scene) -> impl Iterator<Item = Signal> {
    probe_signals(scene).into_iter().map(|(name, unit, meaning)| Signal {
        name,
        unit: unit.into(),
        meaning,
        sampled: true,
    })
}

fn of_probe(probe: &Probe) -> Vec<(String, &'static str, String)> {
    let Probe { name, shape } = probe;
    let ProbeShape::Profile { axis, min, max, along, bins, .. } = shape else {
        let named = rows(shape).iter();
        let own =
            named.map(|&(value, unit, text, _)| (format!("{name}.{value}"), unit, text.into()));
        return own.collect();
    };
    let width = (max[*along] - min[*along]) / *bins as f64;
    let axes = ["x", "y", "z"];
    let at = |k: usize| short(min[*along] + width * k as f64);
    let strip = |k: usize| {
        let (of, over) = (axes[*axis], axes[*along]);
        let meaning = format!(
            "mean velocity of the fluid along {of} where {over} is {} to {} m",
            at(k),
            at(k + 1)
        );
        (format!("{name}.u{k}"), "m/s", meaning)
    };
    (0..*bins).map(strip).collect()
}

/// Number of values of a probe of a shape.
pub fn count(shape: &ProbeShape) -> usize {
    if let ProbeShape::Profile { bins, .. } = shape { *bins } else { rows(shape).len() }
}

/// Index of the first of the three values of a velocity among the values of a probe of a shape, if
/// it has one.
pub fn first_velocity(shape: &ProbeShape) -> Option<usize> {
    rows(shape).iter().position(|(name, ..)| *name == OF_PLACES[1].0)
}

/// Appends the values of a probe of a shape, or of a strip of a profile, in the order of its
/// signals.
pub fn append(shape: &ProbeShape, measured: &ProbeValues, out: &mut Vec<f64>) {
    if let ProbeShape::Profile { axis, .. } = shape {
        return out.push(measured.velocity[*axis]);
    }
    push(rows(shape), measured, out);
}
