//! A manifest to start from: steady flow through the valve, held at a lift.

use super::dimensions::Dimensions;
use super::moving;
use super::text::{Room, beneath, fluid_and_frame, mm, outflow, second_end, written};
use tremie_messages::units::{Length, Velocity, Viscosity};

/// A steady flow through a valve that is held.
#[derive(Clone, Debug, PartialEq)]
pub struct Steady {
    /// Lift of the valve: height of metal above metal [m].
    pub lift: Length,
    /// Mean velocity in the conduit [m/s].
    pub velocity: Velocity,
    /// Dynamic viscosity of the fluid [Pa·s].
    pub viscosity: Viscosity,
    /// Edge of a cell [m].
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

/// The manifest, with the frame's surface in the file `frame`, whose unit is the millimetre. Half
/// the valve is in the domain, on one side of its mirror.
pub fn manifest(valve: &Dimensions, run: &Steady, frame: &str) -> String {
    let cell = run.cell.0;
    let room = Room::around(valve, cell);
    let (inner, outer) = (valve.rubber_inner_radius.0, valve.rubber_outer_radius.0);
    // Halfway between the seat and the lower side of the ring.
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

{fluid_and_frame}
# Plug, hub, disc and rubber ring, turned about z, which stands upright here.
[[scene.parts]]
name = "valve"
revolved = {{ profile = [{profile}] }}
position = ["0 mm", "{lift} mm", "0 mm"]
rotation = {{ axis = [1, 0, 0], angle = "-90 deg" }}

{beneath}
[[scene.probes]]
name = "gap_inner"
point = ["{half_cell} mm", "{middle} mm", "{near} mm"]

[[scene.probes]]
name = "gap_outer"
point = ["{half_cell} mm", "{middle} mm", "{far} mm"]

{outflow}
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
        second = second_end(valve),
        fluid_and_frame = fluid_and_frame(valve, cell, (run.viscosity.0, run.velocity.0), frame),
        beneath = beneath(valve, cell),
        outflow = outflow(valve, cell),
        half_cell = mm(0.5 * cell),
        profile = written(&moving::steel_and_ring(valve)),
        middle = mm(middle),
        near = mm(near),
        far = mm(far),
        cell = mm(cell),
    )
}
