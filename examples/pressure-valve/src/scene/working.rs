//! A manifest in which the valve works: a piston pushes slurry through it.

use super::dimensions::{Closure, Dimensions};
use super::grains::{self, Grains};
use super::moving;
use super::rubber::Resting;
use super::text::{Room, beneath, fluid_and_frame, mm, outflow, second_end, written};
use std::f64::consts::PI;
use tremie_messages::units::{Length, Pressure, Stiffness, Time, Velocity, Viscosity, Volume};

/// A run from rest: a piston compresses the fluid beneath the valve until it opens, and stops; the
/// valve closes. It begins shut, at rest, the ring compressed.
///
/// The defaults are the control run of Mutabaruka and Kamrin without grains, with the volume of the
/// reservoir chosen (they do not state it).
#[derive(Clone, Debug, PartialEq)]
pub struct Working {
    /// Edge of a cell [m].
    pub cell: Length,
    /// Lattice speed: edge of a cell over a time step of the fluid [m/s].
    pub lattice_speed: Velocity,
    /// Volume between the piston and the conduit at the start [m³].
    pub reservoir: Volume,
    /// Velocity of the piston [m/s].
    pub piston: Velocity,
    /// Time at which the piston stops [s].
    pub stop: Time,
    /// End of the run [s].
    pub until: Time,
    /// Dynamic viscosity of the fluid [Pa·s].
    pub viscosity: Viscosity,
    /// Pressure above the valve, at the outlet [Pa].
    pub outlet: Pressure,
    /// Stiffness of the spring at lift 0 [N/m].
    pub spring_rate: Stiffness,
    /// Compression of the spring at lift 0 [m].
    pub spring_preload: Length,
    /// Lift at which the spring is solid [m].
    pub spring_stroke: Length,
    /// Stiffness of a rigid ring on its seat [N/m].
    pub ring_stiffness: Stiffness,
}

/// The ring of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ring<'a> {
    /// Rigid, in one piece with the valve. It touches the seat at a lift as high as its lip. The
    /// stop there is as stiff as the rubber is on the whole when the valve is shut.
    Rigid,
    /// Of rubber, at rest on its seat, its table in a file.
    Rubber(&'a str, Resting),
}

impl Default for Working {
    fn default() -> Self {
        Self {
            cell: Length(3e-4),
            lattice_speed: Velocity(2500.0),
            reservoir: Volume(4e-3),
            piston: Velocity(6.0),
            stop: Time(25e-3),
            until: Time(35e-3),
            viscosity: Viscosity(1e-3),
            outlet: Closure::Pressure.outlet(),
            spring_rate: Stiffness(625.0),
            spring_preload: Length(92e-3),
            spring_stroke: Length(4.5e-3),
            // 61.5 N compress a ring with free sides by 0.452 mm, by finite elements, and one that
            // the hub guides by 0.421 mm.
            ring_stiffness: Stiffness(1.36e5),
        }
    }
}

impl Working {
    /// A form that takes minutes: wider cells, half the speed of sound, and a reservoir as compliant
    /// as the default's, which is a quarter of its volume. The orifice of a safety valve is ten cells
    /// wide: at seven it passes too little, and the valve opens at too small a flow.
    pub fn coarse(closure: Closure) -> Self {
        Self {
            cell: Length(match closure {
                Closure::Pressure => 6e-4,
                Closure::Safety => 4e-4,
            }),
            lattice_speed: Velocity(1250.0),
            reservoir: Volume(1e-3),
            ..Self::default()
        }
    }

    /// The same with the pressure above the valve, and the piston, that belong to a closure.
    pub fn closed_by(self, closure: Closure) -> Self {
        Self { outlet: closure.outlet(), piston: closure.piston(), ..self }
    }
}

/// Thickness below which the cone of a safety valve is solid again [cells]. Its single cells would
/// keep their pressure while that beneath them leaves through the orifice, and so carry the valve.
/// A conduit with a blind end is not emptied: there they let out what is beneath the valve.
const CONE_CLOSES_BESIDE_ORIFICE: f64 = 1.0;

/// Width of gaps below which their walls slip [cells]: so wide that they slip at all lifts. Without
/// slip a lattice stops a flow through a few cells that real walls hardly slow.
const SLIPS_BELOW: f64 = 8.0;

/// The same on cells too wide for that. There an open valve would hold at lifts at which its seat
/// freezes, and hunt. So walls slip only where the valve would hang as it closes.
const SLIPS_BELOW_ON_WIDE_CELLS: f64 = 1.75;

/// Fraction of the ring's lip beyond which cells are wide.
const WIDE: f64 = 0.8;

impl Working {
    /// Force of spring and outlet that presses the ring on its seat when the valve is shut, at a
    /// lift of zero [N].
    pub fn closing_force(&self, valve: &Dimensions) -> f64 {
        let outer = valve.rubber_outer_radius.0;
        self.spring_rate.0 * self.spring_preload.0 + self.outlet.0 * PI * outer * outer
    }
}

/// Parts of the manifest that depend on the ring.
struct OfRing {
    valve: &'static str,
    profile: Vec<[f64; 2]>,
    /// Lift at the start, and at the lower stop [m].
    lifts: [f64; 2],
    stop_stiffness: f64,
    surface: String,
    /// Surface above the seat's gap, and the component that shapes it.
    side: &'static str,
    component: &'static str,
    settings: String,
}

impl OfRing {
    fn new(valve: &Dimensions, run: &Working, ring: Ring) -> Self {
        match ring {
            Ring::Rigid => Self {
                valve: "# Plug, hub, disc and rubber ring, turned about z, which stands upright here. The ring is rigid: it touches the
# seat at the lower stop, which has its stiffness.",
                profile: moving::steel_and_ring(valve),
                lifts: [
                    // It begins as deep in its stop as the closing force presses it.
                    valve.lip.0 - run.closing_force(valve) / run.ring_stiffness.0,
                    valve.lip.0,
                ],
                stop_stiffness: run.ring_stiffness.0,
                surface: String::new(),
                side: "valve",
                component: "",
                settings: String::new(),
            },
            Ring::Rubber(table, resting) => Self {
                valve: "# Plug, hub and disc of steel, turned about z, which stands upright here. At lift 0 metal touches metal.",
                profile: moving::steel(valve),
                lifts: [resting.lift, 0.0],
                stop_stiffness: METAL,
                surface: format!(
                    r#"
[scene.materials.rubber]
density = "{density} kg/m3"

# The ring below the disc. It begins as spring and outlet compress it.
[[scene.surfaces]]
name = "ring"
material = "rubber"
carrier = "valve"
table = "{table}"
position = ["0 mm", "0 mm", "{low} mm"]
sectors = 48
start = "{start} mm"
"#,
                    density = valve.rubber.0,
                    low = mm(-valve.lip.0),
                    start = short(1e3 * resting.compression),
                ),
                side: "ring",
                component: "\nrubber = \"rubber-table\"",
                settings: format!(
                    "\n[settings.rubber-table]\nsound_speed = \"{} m/s\" # a cell in a time step\n",
                    run.lattice_speed.0
                ),
            },
        }
    }
}

/// Stiffness of metal on metal [N/m].
const METAL: f64 = 1e7;

/// The manifest, with the frame's surface in the file `frame`, whose unit is the millimetre. Half
/// the valve is in the domain, on one side of its mirror. With `slurry`, grains come with the
/// fluid.
pub fn manifest(
    valve: &Dimensions,
    run: &Working,
    slurry: Option<&Grains>,
    frame: &str,
    ring: Ring,
) -> String {
    let cell = run.cell.0;
    let room = Room::around(valve, cell);
    let bore = valve.bore_radius.0;
    let (inner, outer) = (valve.rubber_inner_radius.0, valve.rubber_outer_radius.0);
    // The lattice speed sets the step; the speed of sound is 1/sqrt(3) of it.
    let step = cell / run.lattice_speed.0;
    let is_rubber = matches!(ring, Ring::Rubber(..));
    let own = OfRing::new(valve, run, ring);
    format!(
        r#"# A piston pushes a {what} through a spring-loaded valve, and stops. Half of the valve: x = 0 is a mirror.

[run]
until = "{until} ms"

[scene.domain]
origin = {origin}
size = {size}
x = {{ lower = "symmetry", upper = "wall" }}
y = {{ lower = "wall", upper = {{ pressure = "{outlet} Pa", ramp = "0.2 ms" }} }}
z = {{ lower = {{ reservoir = {{ area = "{area} mm2", volume = "{volume} cm3", piston = "{piston} m/s", ramp = "0.2 ms", stop = "{stop} ms" }} }}, upper = {second} }}

{fluid_and_frame}
{valve_is}
[[scene.parts]]
name = "valve"
revolved = {{ profile = [{profile}] }}
rotation = {{ axis = [1, 0, 0], angle = "-90 deg" }}

[scene.parts.motion.slider]
axis = [0, 1, 0]
mass = "{mass} g"
lift = "{lift} mm"
spring = {{ rate = "{rate} N/m", preload = "{preload} mm", stroke = "{stroke} mm" }}
stops = {{ lower = "{lower} mm", upper = "{upper} mm", stiffness = "{stiffness} N/m", restitution = 0.3 }}
{surface}
# What is thinner than a lattice resolves holds no fluid; what presses there is measured where it is resolved. Walls
# of gaps that thin slip: they would hold the fluid, and with it the valve as it closes.
[[scene.gaps]]
name = "cone"
between = ["valve", "frame"]
ring = {{ axis = "y", through = ["0 mm", "0 mm", "0 mm"], radii = ["{cone_inner} mm", "{inner} mm"] }}
open_at = 2.0
close_at = {cone_close:?}
slip_below = {slip}
pressure_at = ["rim"]

[[scene.gaps]]
name = "seat"
between = ["{side}", "frame"]
ring = {{ axis = "y", through = ["0 mm", "0 mm", "0 mm"], radii = ["{inner} mm", "{gap_outer} mm"] }}
open_at = 1.5
close_at = 0.5
slip_below = {slip}
pressure_at = ["rim", "chamber"]

{beneath}
# In the bore, at the edge of the cone.
[[scene.probes]]
name = "rim"
point = ["{half_cell} mm", "{rim_y} mm", "{rim_z} mm"]

[[scene.probes]]
name = "chamber"
point = ["{half_cell} mm", "{chamber_y} mm", "{chamber_z} mm"]

# The channel between ring and seat.
[[scene.probes]]
name = "channel"
ring = {{ axis = "y", through = ["0 mm", "0 mm", "0 mm"], radii = ["{inner} mm", "{outer} mm"], heights = ["0 mm", "2 mm"] }}

{outflow}
{grains}[components]
fluid = "fluid-lbm"
grains = "grains-dem" # moves the valve{component}

[settings.fluid-lbm]
cell = "{cell} mm"
time_step = "{step} us"
collision = "bgk"
smagorinsky = 0.4
walls = "halfway"
velocity_lead = 1.0 # of the valve: what the water hammers must not answer late

[settings.grains-dem]
time_step = "{substep} us"
{settings}
[outputs]
signals = "20 us"
"#,
        until = ms(run.until),
        origin = Room::listed(room.origin),
        size = Room::listed(room.size),
        outlet = run.outlet.0,
        // Area and volume of the whole conduit: only their ratio counts, so half of it gives the
        // same.
        area = short(PI * bore * bore * 1e6),
        volume = short(run.reservoir.0 * 1e6),
        piston = run.piston.0,
        stop = ms(run.stop),
        second = second_end(valve),
        fluid_and_frame = fluid_and_frame(valve, cell, (run.viscosity.0, run.piston.0), frame),
        beneath = beneath(valve, cell),
        outflow = outflow(valve, cell),
        half_cell = mm(0.5 * cell),
        valve_is = own.valve,
        profile = written(&own.profile),
        lower = mm(own.lifts[1]),
        surface = own.surface,
        side = own.side,
        component = own.component,
        settings = own.settings,
        mass = short(valve.moving_mass.0 * 1e3),
        lift = short(1e3 * own.lifts[0]),
        rate = run.spring_rate.0,
        preload = mm(run.spring_preload.0),
        stroke = mm(run.spring_stroke.0),
        // A solid spring is the upper stop.
        upper = mm(run.spring_stroke.0),
        slip = if cell > WIDE * valve.lip.0 { SLIPS_BELOW_ON_WIDE_CELLS } else { SLIPS_BELOW },
        stiffness = own.stop_stiffness,
        cone_inner = mm(bore - 0.5 * cell),
        cone_close = match valve.closure {
            Closure::Pressure => 0.5,
            Closure::Safety => CONE_CLOSES_BESIDE_ORIFICE,
        },
        inner = mm(inner),
        outer = mm(outer),
        gap_outer = mm(outer + cell),
        rim_y = mm(-valve.cone_depth() - cell),
        rim_z = mm(bore - cell),
        chamber_y = mm(2.5 * cell),
        chamber_z = mm(0.5 * (outer + valve.chamber_radius.0)),
        cell = mm(cell),
        step = short(step * 1e6),
        what = if slurry.is_some() { "slurry" } else { "fluid" },
        grains = slurry.map_or(String::new(), |slurry| grains::tables(valve, slurry, is_rubber)),
        substep = short(1e6 * slurry.map_or(step, |slurry| slurry.time_step.0)),
    )
}

fn ms(time: Time) -> f64 {
    short(time.0 * 1e3)
}

/// Without the digits that rounding adds.
fn short(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}
