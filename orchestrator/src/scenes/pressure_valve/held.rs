//! A manifest to start from: steady flow through the valve, held at a lift.

use super::dimensions::{Closure, Dimensions};
use super::moving;
use super::text::{Room, mm, written};
use tremie_messages::units::{Length, Velocity, Viscosity};

/// A steady flow through a valve that is held.
#[derive(Clone, Debug, PartialEq)]
pub struct Steady {
    /// How far the metal is lifted off the metal.
    pub lift: Length,
    /// Mean velocity in the conduit.
    pub velocity: Velocity,
    /// Dynamic viscosity of the fluid.
    pub viscosity: Viscosity,
    /// Edge of a cell.
    pub cell: Length,
}

impl Default for Steady {
    fn default() -> Self {
        Self {
            lift: Length(3.08e-3),
            velocity: Velocity(6.0),
            viscosity: Viscosity(31.6),
            cell: Length(3e-4),
        }
    }
}

/// The manifest, with the frame's surface in the file `frame`, whose unit is the millimetre. Half the
/// valve is in the domain, on one side of its mirror.
pub fn manifest(valve: &Dimensions, run: &Steady, frame: &str) -> String {
    let cell = run.cell.0;
    let room = Room::around(valve, cell);
    let second = match valve.closure {
        Closure::Pressure => "\"wall\"",
        Closure::Safety => "{ pressure = \"0 Pa\" }",
    };
    let (inner, outer) = (valve.rubber_inner_radius.0, valve.rubber_outer_radius.0);
    let middle = 0.5 * (run.lift.0 - valve.lip.0);
    let [near, far] = [0.2, 0.8].map(|s| inner + s * (outer - inner));
    format!(
        r#"# Steady flow through a valve beside a conduit, held at a lift of {lift} mm. Half of it: x = 0 is a mirror.

[run]
until = "2 ms"

[scene.domain]
origin = {origin}
size = {size}
x = {{ lower = "symmetry", upper = "wall" }}
y = {{ lower = "wall", upper = {{ pressure = "0 Pa" }} }}
z = {{ lower = {{ velocity = ["0 m/s", "0 m/s", "{velocity} m/s"], ramp = "0.3 ms" }}, upper = {second} }}

[scene.fluid]
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

# Plug, hub, disc and rubber ring, turned about z, which stands upright here.
[[scene.parts]]
name = "valve"
revolved = {{ profile = [{profile}] }}
position = ["0 mm", "{lift} mm", "0 mm"]
rotation = {{ axis = [1, 0, 0], angle = "-90 deg" }}

[[scene.probes]]
name = "beneath"
point = ["{half_cell} mm", "{axis} mm", "0 mm"]

[[scene.probes]]
name = "gap_inner"
point = ["{half_cell} mm", "{middle} mm", "{near} mm"]

[[scene.probes]]
name = "gap_outer"
point = ["{half_cell} mm", "{middle} mm", "{far} mm"]

[[scene.probes]]
name = "outflow"
section = {{ axis = "y", at = "{above} mm" }}

[components]
fluid = "fluid-lbm"

[settings.fluid-lbm]
cell = "{cell} mm"

[outputs]
signals = "5 us"
"#,
        lift = mm(run.lift.0),
        origin = Room::listed(room.origin),
        size = Room::listed(room.size),
        velocity = run.velocity.0,
        viscosity = run.viscosity.0,
        // A rough guess that covers the jet in the cone; the user knows better.
        fastest = 8.0 * run.velocity.0,
        half_cell = mm(0.5 * cell),
        axis = mm(valve.conduit_axis.0),
        inside = mm(valve.inlet.0 + 5.0 * cell),
        profile = written(&moving::steel_and_ring(valve)),
        middle = mm(middle),
        near = mm(near),
        far = mm(far),
        above = mm(valve.chamber_height.0 - 3.5 * cell),
        cell = mm(cell),
    )
}
