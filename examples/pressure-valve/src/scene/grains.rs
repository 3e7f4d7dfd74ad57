//! Grains in the slurry that the piston pushes through the valve.

use super::dimensions::{Closure, Dimensions};
use super::text::mm;
use std::f64::consts::PI;
use tremie_messages::units::{Density, Length, Stiffness, Time};

/// Grains beneath the valve at the start, and grains that come with the fluid.
///
/// The defaults are from Mutabaruka and Kamrin's runs, which vary one after the other. In place of
/// a restitution they have a dashpot of 3 kg/s, and none on rubber. For grains of 0.8 mm this
/// amounts to a restitution of 0.15 to 0.26, and wants a shorter step than theirs.
#[derive(Clone, Debug, PartialEq)]
pub struct Grains {
    /// Mean of the smallest and the largest diameter; sizes are uniform between them.
    pub diameter: Length,
    /// Largest diameter over smallest.
    pub size_ratio: f64,
    /// Solid fraction of the grains that come, and of those beneath the valve at the start.
    pub fraction: f64,
    /// Density of the grains [kg/m³].
    pub density: Density,
    /// Length of the region in the conduit, from its inlet, that is kept filled.
    pub zone: Length,
    /// Normal stiffness of contacts with grains and with steel; the tangential one is 0.8 of it.
    pub stiffness: Stiffness,
    /// The same with rubber, where nothing damps a contact but the ring.
    pub on_rubber: Stiffness,
    /// Coefficient of friction of all contacts.
    pub friction: f64,
    /// Restitution of contacts with grains and with steel.
    pub restitution: f64,
    /// Longest step of the grains. The default resolves single contacts, as the paper's does; a
    /// dense packing of such grains wants a fifth of it.
    pub time_step: Time,
}

impl Default for Grains {
    fn default() -> Self {
        Self {
            diameter: Length(0.8e-3),
            size_ratio: 1.2,
            fraction: 0.053,
            density: Density(2500.0),
            zone: Length(4.25e-3),
            stiffness: Stiffness(1e7),
            on_rubber: Stiffness(1e5),
            friction: 0.4,
            restitution: 0.3,
            time_step: Time(4e-8),
        }
    }
}

impl Grains {
    /// Larger and softer grains, for the wide cells of the coarse forms: grains of 0.8 mm are too
    /// small for them.
    pub fn coarse(closure: Closure) -> Self {
        Self {
            diameter: Length(match closure {
                Closure::Pressure => 1.4e-3,
                // They pass the orifice, of 4 mm.
                Closure::Safety => 1.1e-3,
            }),
            stiffness: Stiffness(1e6),
            time_step: Time(4.8e-8),
            ..Self::default()
        }
    }

    /// Smallest and largest diameter [m].
    pub fn diameters(&self) -> [f64; 2] {
        let smallest = 2.0 * self.diameter.0 / (1.0 + self.size_ratio);
        [smallest, self.size_ratio * smallest]
    }
}

/// The tables of a manifest for grains, with the probes that count them beneath the valve and in
/// its seat.
pub(super) fn tables(valve: &Dimensions, grains: &Grains, is_rubber: bool) -> String {
    let (bore, axis) = (valve.bore_radius.0, valve.conduit_axis.0);
    let (inlet, end, top) = (valve.inlet.0, end(valve), -valve.cone_depth());
    let [smallest, largest] = grains.diameters().map(mm);
    // Packings and probes are boxes: this one holds half of conduit and bore, and solid around
    // them.
    let whole = bore * (top - (axis - bore)) * (end - inlet);
    let share = 0.5 * beneath(valve) / whole;
    let floor = mm(axis - bore);
    let (bore_, inlet_, top_) = (mm(bore), mm(inlet), mm(top));
    format!(
        r#"[scene.materials.grains]
density = "{density} kg/m3"

# Beneath the valve at the start. {percent} % of this box are conduit and bore; the rest is solid, and counts in
# its fraction.
[[scene.bodies]]
name = "grains"
material = "grains"
packing = {{ min = ["0 mm", "{floor} mm", "{inlet_} mm"], max = ["{bore_} mm", "{top_} mm", "{end} mm"], fraction = {begin}, diameter = ["{smallest} mm", "{largest} mm"] }}

# They come with the fluid, as fast as it.
[[scene.inlets]]
name = "feed"
bodies = "grains"
min = ["0 mm", "{floor} mm", "{inlet_} mm"]
max = ["{bore_} mm", "{crown} mm", "{zone} mm"]
fraction = {fraction}
diameter = ["{smallest} mm", "{largest} mm"]
velocity = {{ face = "z_lower" }}

[[scene.outlets]]
name = "drain"
beyond = {{ axis = "y", at = "{drain} mm", side = "upper" }}
{overflow}
[[scene.contacts]]
normal_stiffness = "{stiffness} N/m"
tangential_stiffness = "{tangential} N/m"
friction = {friction}
restitution = {restitution}
{on_rubber}
# Of the same box as above: the fraction in conduit and bore is this over {part}.
[[scene.probes]]
name = "packing"
region = {{ min = ["0 mm", "{floor} mm", "{inlet_} mm"], max = ["{bore_} mm", "{top_} mm", "{end} mm"] }}

# Between cone and seat below, plug and rubber ring above.
[[scene.probes]]
name = "stuck"
ring = {{ axis = "y", through = ["0 mm", "0 mm", "0 mm"], radii = ["{bore_} mm", "{outer} mm"], heights = ["{top_} mm", "{disc} mm"] }}

"#,
        density = grains.density.0,
        on_rubber = if is_rubber { on_rubber(grains) } else { String::new() },
        percent = (100.0 * share).round(),
        end = mm(end),
        begin = short(share * grains.fraction),
        crown = mm(axis + bore),
        zone = mm(inlet + grains.zone.0),
        fraction = grains.fraction,
        drain = mm(valve.chamber_height.0 - grains.diameters()[1]),
        overflow = overflow(valve, grains),
        stiffness = grains.stiffness.0,
        tangential = 0.8 * grains.stiffness.0,
        friction = grains.friction,
        restitution = grains.restitution,
        part = short(share),
        outer = mm(valve.rubber_outer_radius.0),
        // The disc's upper side at lift 0.
        disc = mm(valve.hub_height() + valve.disc_thickness()),
    )
}

/// The law of their contacts with rubber.
fn on_rubber(grains: &Grains) -> String {
    format!(
        r#"
[[scene.contacts]]
between = ["rubber", "grains"]
normal_stiffness = "{normal} N/m"
tangential_stiffness = "{tangential} N/m"
friction = {friction}
restitution = 1.0
"#,
        normal = grains.on_rubber.0,
        tangential = 0.8 * grains.on_rubber.0,
        friction = grains.friction,
    )
}

/// The outlet behind the orifice of a safety valve.
fn overflow(valve: &Dimensions, grains: &Grains) -> String {
    if valve.closure == Closure::Pressure {
        return String::new();
    }
    let at = mm(valve.second_outlet.0 - grains.diameters()[1]);
    format!(
        r#"
[[scene.outlets]]
name = "overflow"
beyond = {{ axis = "z", at = "{at} mm", side = "upper" }}
"#
    )
}

/// End of the conduit beneath the valve, along z [m].
fn end(valve: &Dimensions) -> f64 {
    match valve.closure {
        Closure::Pressure => valve.blind_end.0,
        Closure::Safety => valve.orifice[0].0,
    }
}

/// Volume of conduit and bore [m³]. What they share is half of Steinmetz's solid, 8/3 R³.
fn beneath(valve: &Dimensions) -> f64 {
    let r = valve.bore_radius.0;
    let along = end(valve) - valve.inlet.0;
    let up = -valve.cone_depth() - valve.conduit_axis.0;
    PI * r * r * (along + up) - 8.0 / 3.0 * r * r * r
}

/// Four digits.
fn short(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn diameters_are_those_of_mean_and_ratio() {
        let [smallest, largest] = Grains::default().diameters();
        assert!((smallest - 0.727e-3).abs() < 1e-6 && (largest - 0.873e-3).abs() < 1e-6);
    }

    /// A lattice of 0.3 mm counts 31,500 cells, 851 mm³, beneath half the valve if its conduit
    /// begins at -15 mm.
    #[test]
    fn the_volume_beneath_the_valve_is_the_known_one() {
        let valve = Dimensions { inlet: Length(-15e-3), ..Dimensions::default() };
        let half = 0.5e9 * beneath(&valve);
        assert!((half / 851.0 - 1.0).abs() < 0.015, "{half}");
    }
}
