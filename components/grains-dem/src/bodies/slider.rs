//! One degree of freedom of a part: velocity Verlet along an axis, as spheres have it.

use crate::Vec3;
use crate::bodies::body_arrays::Twist;
use crate::bodies::springs::{SpringLaw, StopLaw};
use serde::{Deserialize, Serialize};
use tremie_messages::Problem;
use tremie_messages::scene::{Domain, Face};
use tremie_messages::{body::Load, scene};
use tremie_state::{StateError, StateExchange};

/// Force of contacts along an axis, added up in fixed point: whole numbers have the same sum in any
/// order, so that where bodies stand in memory does not enter the motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Along(i128);

/// 2^90: a unit is 8e-28 N, and sums up to 1e11 N have room.
const UNITS: f64 = (1u128 << 90) as f64;

impl Along {
    pub const NONE: Self = Self(0);

    /// A force along the axis [N].
    #[inline(always)]
    pub fn of(force: f64) -> Self {
        Self((force * UNITS) as i128)
    }

    /// Adds another.
    #[inline(always)]
    pub fn add(&mut self, other: Self) {
        self.0 = self.0.saturating_add(other.0);
    }

    /// The force [N].
    pub fn force(self) -> f64 {
        self.0 as f64 / UNITS
    }
}

/// Forces along the axis [N].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Pushes {
    pub spring: f64,
    pub stops: f64,
    pub contacts: f64,
    pub fluid: f64,
    /// Force of contacts on surfaces that it carries, and other forces from them.
    pub surface: f64,
    pub carried: f64,
}

/// The motion of a part along an axis.
#[derive(Clone, Debug)]
pub(crate) struct Slider {
    /// Unit vector.
    pub axis: Vec3,
    pub mass: f64,
    spring: SpringLaw,
    stops: StopLaw,
    /// Weight and constant force along the axis [N].
    constant: f64,
    /// Ratio of the whole part to its simulated part, see [`whole`](crate::bodies::mirrors::whole).
    pub whole: f64,
    /// Position of the part's origin at lift 0 [m].
    home: Vec3,
    /// Lift [m].
    pub lift: f64,
    /// Velocity along the axis [m/s]: of the full step between substeps, of the half step within
    /// one.
    pub velocity: f64,
    predicted: f64,
    /// Forces at the last evaluation.
    pub pushes: Pushes,
    /// Lift when neighbours were last listed [m].
    listed: f64,
}

impl Slider {
    /// Keeps lift, velocity and forces at a window's end, or puts them back.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.value("home", &mut self.home)?;
        state.value("lift", &mut self.lift)?;
        state.value("velocity", &mut self.velocity)?;
        state.value("predicted", &mut self.predicted)?;
        state.value("pushes", &mut self.pushes)?;
        state.value("listed", &mut self.listed)
    }

    /// A valid slider of a scene at its start, the part's origin at `position`.
    pub fn new(slider: &scene::Slider, position: Vec3, gravity: Vec3, whole: f64) -> Self {
        let axis = unit(slider.axis);
        let stops = StopLaw::new(slider.stops.as_ref(), slider.mass);
        Self {
            axis,
            mass: slider.mass,
            spring: SpringLaw::new(&slider.spring, stops.stiffness),
            stops,
            constant: slider.force + slider.mass * gravity.dot(&axis),
            whole,
            home: position - axis * slider.lift,
            lift: slider.lift,
            velocity: slider.velocity,
            predicted: slider.velocity,
            pushes: Pushes::default(),
            listed: slider.lift,
        }
    }

    fn acceleration(&self) -> f64 {
        let Pushes { spring, stops, contacts, fluid, surface, carried } = self.pushes;
        (spring + stops + contacts + fluid + surface + carried + self.constant) / self.mass
    }

    /// Half kick, drift and prediction of a substep; with `finish` the half kick that ends the
    /// substep before comes first.
    pub fn first_half(&mut self, dt: f64, finish: bool) {
        let kick = 0.5 * dt * self.acceleration();
        if finish {
            self.velocity += kick;
        }
        self.velocity += kick;
        self.predicted = self.velocity + kick;
        self.lift += dt * self.velocity;
    }

    /// Takes the forces at the new place: those of contacts are given, on the part in the domain
    /// [N].
    pub fn evaluate(&mut self, contacts: f64) {
        self.pushes.contacts = self.whole * contacts;
        self.pushes.spring = -self.spring.force(self.lift);
        self.pushes.stops = self.stops.force(self.lift, self.predicted);
        (self.pushes.surface, self.pushes.carried) = (0.0, 0.0);
    }

    /// Takes, besides, what a surface brings that it carries: the force of its contacts, and
    /// another.
    pub fn carry(&mut self, contacts: Vec3, other: Vec3) {
        self.pushes.surface += contacts.dot(&self.axis);
        self.pushes.carried += other.dot(&self.axis);
    }

    /// Half kick that ends a substep.
    pub fn second_half(&mut self, dt: f64) {
        self.velocity += 0.5 * dt * self.acceleration();
        self.predicted = self.velocity;
    }

    /// Takes the load of the fluid on the whole part.
    pub fn take(&mut self, load: Option<&Load>) {
        self.pushes.fluid = load.map_or(0.0, |load| Vec3::from(load.force).dot(&self.axis));
    }

    /// Position of the part's origin, before wrapping around [m].
    pub fn position(&self) -> Vec3 {
        self.home + self.axis * self.lift
    }

    /// Moves its way across a periodic face.
    pub fn shift(&mut self, by: Vec3) {
        self.home += by;
    }

    /// Velocity that forces see; that of the full step between substeps.
    pub fn twist(&self) -> Twist {
        Twist { v: self.axis * self.predicted, w: Vec3::zeros() }
    }

    /// Displacement since neighbours were listed [m].
    pub fn moved(&self) -> f64 {
        (self.lift - self.listed).abs()
    }

    /// Distances count from here on.
    pub fn begin_list(&mut self) {
        self.listed = self.lift;
    }

    /// Kinetic energy [J].
    pub fn kinetic(&self) -> f64 {
        0.5 * self.mass * self.velocity * self.velocity
    }

    /// Energy in spring and stops [J].
    pub fn elastic(&self) -> f64 {
        self.spring.energy(self.lift) + self.stops.energy(self.lift)
    }

    /// Energy of weight and constant force, from lift 0 [J].
    pub fn potential(&self) -> f64 {
        -self.constant * self.lift
    }

    /// Stiffness and dashpot that spring and stops have at most [N/m, kg/s].
    pub fn stiffest(&self) -> [f64; 2] {
        [self.spring.stiffest() + self.stops.stiffness, self.stops.gamma]
    }

    /// Stiffness of the stops, 0 without any, and of the spring at most [N/m].
    pub fn stiffnesses(&self) -> [f64; 2] {
        [self.stops.stiffness, self.spring.stiffest()]
    }

    /// Spring, weight and constant force along the axis at a lift [N].
    pub fn constant_at(&self, lift: f64) -> f64 {
        self.constant - self.spring.force(lift)
    }
}

/// A part that moves along one axis under forces. Forces are on the whole part and along the axis,
/// those of contacts, stops and spring at the end of the last substep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SliderState {
    /// Index into the scene's list of parts.
    pub part: usize,
    /// Lift [m].
    pub lift: f64,
    /// Velocity [m/s].
    pub velocity: f64,
    /// Force of the spring [N]; negative while it closes.
    pub spring_force: f64,
    /// Force of the grains [N].
    pub contact_force: f64,
    /// Force of the stops [N]; positive from the lower one.
    pub stop_force: f64,
    /// Force of the fluid, buoyancy included, as the last loads gave it [N].
    pub fluid_force: f64,
    /// Force of contacts on the surfaces that it carries [N].
    pub surface_force: f64,
    /// Other forces given for these surfaces [N].
    pub carrier_force: f64,
}

impl SliderState {
    pub(crate) fn of(part: usize, slider: &Slider) -> Self {
        let Pushes { spring, stops, contacts, fluid, surface, carried } = slider.pushes;
        Self {
            part,
            lift: slider.lift,
            velocity: slider.velocity,
            spring_force: spring,
            contact_force: contacts,
            stop_force: stops,
            fluid_force: fluid,
            surface_force: surface,
            carrier_force: carried,
        }
    }
}

/// The unit vector along a direction.
pub(crate) fn unit(direction: [f64; 3]) -> Vec3 {
    let direction = Vec3::from(direction);
    direction / direction.norm_squared().sqrt()
}

/// Component of an axis across a mirror that counts as along it.
const ACROSS: f64 = 1e-9;

/// Least length by which a surface must reach beyond a plane to be cut by it, over its size.
pub(crate) const ROOM: f64 = 1e-6;

/// Checks how a slider lies to the mirrors of the domain: `mirrors` are the axes across which they
/// cut it, `reaches` tells whether its surface is on both sides of a face.
pub(crate) fn across_mirrors(
    key: &str,
    slider: &scene::Slider,
    domain: &Domain,
    mirrors: [bool; 3],
    reaches: impl Fn(usize, usize) -> bool,
) -> Option<Problem> {
    for (a, name) in ["x", "y", "z"].into_iter().enumerate() {
        if mirrors[a] && unit(slider.axis)[a].abs() > ACROSS {
            let message = format!(
                "has a component along {name}, across the symmetry plane that cuts the part: its image would \
                 move the other way"
            );
            let help = format!("make {name} of the axis 0, or move the part off the plane");
            return Some(Problem::new(format!("{key}.motion.slider.axis"), message).help(help));
        }
        let cut_beside = |side: usize| domain.faces[a][side] == Face::Symmetry && reaches(a, side);
        if !mirrors[a] && (0..2).any(cut_beside) {
            let message = format!(
                "puts the slider across a symmetry plane in {name}, but not its origin on it: loads would \
                 count for the half alone"
            );
            let help = "put the origin of the part's frame on the plane, which makes it a whole";
            return Some(Problem::new(format!("{key}.position"), message).help(help));
        }
    }
    None
}
