//! Text of lengths, profiles and tables in a manifest.

use super::dimensions::{Closure, Dimensions};

/// Millimetres, without the digits that rounding adds.
pub(super) fn mm(metres: f64) -> f64 {
    (metres * 1e12).round() / 1e9
}

/// Corners `[r, y]` as a manifest has them.
pub(super) fn written(profile: &[[f64; 2]]) -> String {
    let corners = profile.iter().map(|[r, y]| format!("[\"{} mm\", \"{} mm\"]", mm(*r), mm(*y)));
    corners.collect::<Vec<_>>().join(", ")
}

/// The domain's box around half the valve [m]: whole numbers of cells, and beyond its walls at
/// least half a cell.
pub(super) struct Room {
    /// Lower corner.
    pub origin: [f64; 3],
    /// Edges.
    pub size: [f64; 3],
}

impl Room {
    pub fn around(valve: &Dimensions, cell: f64) -> Self {
        // Rounded up; the slack keeps a length that is whole already from gaining a cell.
        let whole = |length: f64| (length / cell - 1e-9).ceil() * cell;
        let floor = valve.conduit_axis.0 - valve.bore_radius.0;
        let height = whole(valve.chamber_height.0 - floor + 0.5 * cell);
        // A blind end closes the conduit inside the domain, but the chamber above reaches further.
        let end = match valve.closure {
            Closure::Pressure => valve.chamber_radius.0 + 0.5 * cell,
            Closure::Safety => valve.second_outlet.0,
        };
        let width = whole(valve.chamber_radius.0 + 0.5 * cell);
        Self {
            origin: [0.0, valve.chamber_height.0 - height, valve.inlet.0],
            size: [width, height, whole(end - valve.inlet.0)],
        }
    }

    /// Three lengths as a manifest has them.
    pub fn listed(lengths: [f64; 3]) -> String {
        let [x, y, z] = lengths.map(mm);
        format!("[\"{x} mm\", \"{y} mm\", \"{z} mm\"]")
    }
}

/// Face at the conduit's far end, as a manifest has it.
pub(super) fn second_end(valve: &Dimensions) -> &'static str {
    match valve.closure {
        Closure::Pressure => "\"wall\"",
        Closure::Safety => "{ pressure = \"0 Pa\" }",
    }
}

/// The tables of a fluid of `viscosity` [Pa s] that enters at `velocity` [m/s], and of the frame
/// around it, whose surface is in the file `frame`.
pub(super) fn fluid_and_frame(
    valve: &Dimensions,
    cell: f64,
    (viscosity, velocity): (f64, f64),
    frame: &str,
) -> String {
    format!(
        r#"[scene.fluid]
density = "1000 kg/m3"
viscosity = "{viscosity} Pa s"
expected_speed = "{fastest} m/s"
inside = [["{half_cell} mm", "{axis} mm", "{inside} mm"]]

# Conduit, bore, seat and chamber.
[[scene.parts]]
name = "frame"
file = "{frame}"
unit = "mm"
cavity = true
"#,
        // A rough bound that covers the jet in the cone; the user may know better.
        fastest = 8.0 * velocity,
        half_cell = mm(0.5 * cell),
        axis = mm(valve.conduit_axis.0),
        inside = mm(valve.inlet.0 + 5.0 * cell),
    )
}

/// The probe in the conduit, beneath the valve.
pub(super) fn beneath(valve: &Dimensions, cell: f64) -> String {
    let (half_cell, axis) = (mm(0.5 * cell), mm(valve.conduit_axis.0));
    format!(
        r#"[[scene.probes]]
name = "beneath"
point = ["{half_cell} mm", "{axis} mm", "0 mm"]
"#
    )
}

/// The probe of the flow that leaves.
pub(super) fn outflow(valve: &Dimensions, cell: f64) -> String {
    let above = mm(valve.chamber_height.0 - 3.5 * cell);
    format!(
        r#"[[scene.probes]]
name = "outflow"
section = {{ axis = "y", at = "{above} mm" }}
"#
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn millimetres_are_short() {
        assert_eq!(mm(4.75e-3), 4.75);
        assert_eq!(mm(0.1 * 3.0 * 1e-3), 0.3);
    }
}
