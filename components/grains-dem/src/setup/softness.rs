//! Expected overlap of bodies: at an impact, and under the weight of a bed.
//!
//! A contact law is one of small overlaps. The depth of an impact is that of a pair with its
//! dashpot,
//!
//! ```text
//! delta = v sqrt(m*/k) exp(-z/s atan(s/z)),    s = sqrt(1 - z^2), z the damping ratio
//! ```
//!
//! (with the hyperbolic functions where z is more than 1; under Hertz's law, by Antypov & Elliott,
//! *EPL* 94 (2011) 50004, the power 4/5 of the exponential), at the largest difference of given
//! velocities and what a fall to the bed's place adds, in a fluid no more than the terminal
//! velocity (drag by Schiller and Naumann, 1935). At rest, a grain at the bottom bears the pressure
//! of all that lies above, `p d^2`.

use crate::Vec3;
use crate::bodies::placed_parts::PlacedPart;
use crate::contact::contact_law::Law;
use crate::setup::material_pairs::{MaterialPair, inlet_velocity};
use core::f64::consts::PI;
use serde::Serialize;
use tremie_grains_kit::packing::random_packing;
use tremie_messages::{
    Finding,
    finding::short,
    scene::{
        BodySet, Course, Face, FluidMaterial, Inlet, Motion, Part, Placement, PolyhedronPlacement,
        Scene,
    },
};

/// Overlap over the smaller radius beyond which a contact is no small overlap.
pub(crate) const SMALL: f64 = 0.1;
/// The overlap that remedies aim at.
const GOOD: f64 = 0.05;
/// Volume of grains over that of the bed that they make.
const BED: f64 = 0.6;

/// Overlaps to be expected.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Softness {
    /// At an impact.
    pub impact: Option<Overlap>,
    /// At rest, under what lies above.
    pub rest: Option<Overlap>,
}

/// An overlap to be expected.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Overlap {
    /// Over the smaller radius.
    pub ratio: f64,
    /// Bodies that overlap, and source of the number, in words.
    pub why: String,
    /// Advice that makes it small.
    pub remedy: String,
}

impl Softness {
    /// Softness of a valid scene; `speed` is what the user expects [m/s].
    pub(crate) fn of(
        scene: &Scene,
        parts: &[PlacedPart],
        encounters: &[MaterialPair<'_>],
        speed: Option<f64>,
    ) -> Self {
        let impacts =
            Impacts { given: given_speeds(scene, parts), fall: Fall::of(scene), expected: speed };
        let pressure = pressure(scene);
        let worst = |of: &dyn Fn(&MaterialPair<'_>) -> Option<Overlap>| {
            encounters.iter().filter_map(of).max_by(|a, b| a.ratio.total_cmp(&b.ratio))
        };
        Self {
            impact: worst(&|encounter| at_impact(encounter, &impacts)),
            rest: worst(&|encounter| at_rest(encounter, scene, pressure)),
        }
    }

    /// With verdicts.
    pub(crate) fn findings(&self) -> impl Iterator<Item = Finding> + '_ {
        let of = |quantity: &str, overlap: &Option<Overlap>| {
            overlap.as_ref().map(|Overlap { ratio, why, remedy }| {
                let beyond = format!(
                    "{why}; beyond {SMALL} an overlap is not small, and a run ends where one reaches 0.5"
                );
                Finding::new(quantity, *ratio, "1").because(why).doubtful_if(
                    *ratio > SMALL,
                    beyond,
                    remedy,
                )
            })
        };
        let impact = of("overlap at an impact over the radius", &self.impact);
        impact.into_iter().chain(of("overlap at rest over the radius", &self.rest))
    }
}

/// The impact of the pair that is heaviest for its size.
fn at_impact(encounter: &MaterialPair<'_>, impacts: &Impacts) -> Option<Overlap> {
    let (speed, whence) = impacts.speed(encounter.with_surface);
    let (pair, radius) = encounter.soft;
    let power = encounter.law.spring.law().exponent() + 1.0;
    let left = libm::pow(damped(encounter.law.damping_ratio(pair)), 2.0 / power);
    // What the dashpot takes is taken from where contact begins.
    let gap = encounter.law.gap;
    let depth = (encounter.law.largest_overlap(pair, speed) + gap) * left - gap;
    let ratio = not_negative(depth / radius);
    let why = format!("{} at {} m/s, {whence}", encounter.name, short(speed));
    let remedy = stiffer(&encounter.law, libm::pow(ratio / GOOD, power));
    (ratio.is_finite() && speed > 0.0).then_some(Overlap { ratio, why, remedy })
}

/// A grain at the bottom.
fn at_rest(encounter: &MaterialPair<'_>, scene: &Scene, pressure: f64) -> Option<Overlap> {
    let (pair, radius) = encounter.soft;
    let gravity = Vec3::from(scene.gravity).norm_squared().sqrt();
    let own = if encounter.with_surface { pair.root_mass * pair.root_mass * gravity } else { 0.0 };
    let force = (pressure * 4.0 * radius * radius).max(own);
    let spring = encounter.law.spring.law();
    let ratio = not_negative(spring.overlap_under(force, pair) / radius);
    let why = format!(
        "{} under {} N, the pressure {} Pa of the bed on a grain of {} m, or its own weight",
        encounter.name,
        short(force),
        short(pressure),
        short(2.0 * radius)
    );
    let remedy = stiffer(&encounter.law, libm::pow(ratio / GOOD, spring.exponent()));
    (ratio.is_finite() && force > 0.0).then_some(Overlap { ratio, why, remedy })
}

/// Contacts that begin at a gap may end there too.
fn not_negative(ratio: f64) -> f64 {
    if ratio < 0.0 { 0.0 } else { ratio }
}

fn stiffer(law: &Law, factor: f64) -> String {
    let remedy = law.spring.law().remedy(factor);
    format!("{remedy} {GOOD}, with a shorter time step; or lower speeds and lighter loads")
}

/// Ratio of the depth of an impact with a dashpot to that without.
fn damped(zeta: f64) -> f64 {
    let square = 1.0 - zeta * zeta;
    let s = square.abs().sqrt();
    if s < 1e-6 {
        return libm::exp(-1.0);
    }
    let angle = if square > 0.0 { libm::atan2(s, zeta) } else { libm::atanh(s / zeta) };
    libm::exp(-zeta / s * angle)
}

/// Speeds of impacts to be expected [m/s], and where they come from.
struct Impacts {
    /// Differences of given velocities of bodies, and of bodies and surfaces.
    given: [f64; 2],
    fall: Fall,
    /// Relative speed that the user expects [m/s].
    expected: Option<f64>,
}

impl Impacts {
    /// Speed of an encounter, and its source in words.
    fn speed(&self, with_surface: bool) -> (f64, String) {
        if let Some(expected) = self.expected {
            return (expected, "the expected speed".into());
        }
        let (given, Fall { height, speed, terminal }) =
            (self.given[usize::from(with_surface)], &self.fall);
        let mut parts = Vec::new();
        if given > 0.0 {
            parts.push(format!("given velocities differ by {} m/s", short(given)));
        }
        if *speed > 0.0 {
            let how = if *terminal {
                "sinking in the fluid".into()
            } else {
                format!("a fall of {} m", short(*height))
            };
            parts.push(format!("{how} makes {} m/s", short(*speed)));
        }
        (given.hypot(*speed), parts.join(", "))
    }
}

/// The box around some velocities [m/s].
#[derive(Clone, Copy)]
struct Velocities {
    low: Vec3,
    high: Vec3,
}

impl Velocities {
    fn none() -> Self {
        Self { low: Vec3::repeat(f64::INFINITY), high: Vec3::repeat(f64::NEG_INFINITY) }
    }

    fn add(&mut self, v: &[f64; 3]) {
        (self.low, self.high) = (self.low.inf(&Vec3::from(*v)), self.high.sup(&Vec3::from(*v)));
    }

    /// Adds the speeds of a motion with a factor over time.
    fn add_timed(&mut self, v: &[f64; 3], course: &Course) {
        for factor in course.extremes() {
            self.add(&v.map(|v| v * factor));
        }
    }

    /// The largest difference of one of these and one of the others; 0 where there is none of
    /// either.
    fn apart(&self, other: &Self) -> f64 {
        let most = (self.high - other.low).sup(&(other.high - self.low));
        let square = most.norm_squared();
        if square.is_finite() { square.sqrt() } else { 0.0 }
    }
}

/// The largest differences of velocities that the scene gives to bodies and inlets, and of these
/// and walls and parts [m/s].
fn given_speeds(scene: &Scene, parts: &[PlacedPart]) -> [f64; 2] {
    let (mut bodies, mut surfaces) = (Velocities::none(), Velocities::none());
    let course = |motion: &Motion, to: &mut Velocities| match motion {
        Motion::Prescribed(points) => points.iter().for_each(|point| to.add(&point.velocity)),
        Motion::Timed(timed) => to.add_timed(&timed.velocity, &timed.course),
        Motion::Slider(slider) => to.add(&slider.axis.map(|x| x * slider.velocity)),
        Motion::Free | Motion::Fixed => {}
    };
    for set in &scene.bodies {
        let mut placed = |velocity| match &set.motion {
            Motion::Timed(timed) => bodies.add_timed(velocity, &timed.course),
            _ => bodies.add(velocity),
        };
        match &set.placement {
            Placement::Listed(list) => list.iter().for_each(|sphere| placed(&sphere.velocity)),
            Placement::Polyhedra(own) => match &own.placement {
                PolyhedronPlacement::Listed(list) => {
                    list.iter().for_each(|body| placed(&body.velocity));
                }
                PolyhedronPlacement::Packed(_) => bodies.add(&[0.0; 3]),
            },
            Placement::Packed(_) => bodies.add(&[0.0; 3]),
        }
        course(&set.motion, &mut bodies);
    }
    for inlet in &scene.inlets {
        if let Some(velocity) = inlet_velocity(scene, inlet) {
            bodies.add(&velocity);
        }
    }
    // Planes and fixed parts are at rest.
    surfaces.add(&[0.0; 3]);
    scene.parts.iter().for_each(|part| course(&part.motion, &mut surfaces));
    for face in scene.domain.faces.iter().flatten() {
        if let Face::Wall { velocity, course } = face {
            surfaces.add_timed(velocity, course);
        }
    }
    [bodies.apart(&bodies), bodies.apart(&surfaces) + turning(scene, parts)]
}

/// The largest speed of a part's surface as the part turns about its reference point [m/s].
fn turning(scene: &Scene, parts: &[PlacedPart]) -> f64 {
    let norm = |v: [f64; 3]| Vec3::from(v).norm_squared().sqrt();
    let of = |(part, placed): (&Part, &PlacedPart)| match &part.motion {
        Motion::Prescribed(points) => {
            let spins = points.iter().map(|point| norm(point.angular_velocity));
            spins.fold(0.0, f64::max) * placed.shape.bounding_radius()
        }
        Motion::Timed(timed) => {
            norm(timed.angular_velocity) * timed.course.largest() * placed.shape.bounding_radius()
        }
        _ => 0.0,
    };
    scene.parts.iter().zip(parts).map(of).fold(0.0, f64::max)
}

/// Fall of bodies to the place where they come to rest, with its height and speed.
struct Fall {
    height: f64,
    speed: f64,
    /// True if the fluid sets the speed.
    terminal: bool,
}

/// Grains somewhere along gravity.
struct Layer {
    /// Height of the lowest and of the highest over the floor [m]; 0 for the highest where there is
    /// but one.
    bottom: f64,
    top: f64,
    /// Volume of all [m³].
    volume: f64,
}

impl Fall {
    fn of(scene: &Scene) -> Self {
        let none = Self { height: 0.0, speed: 0.0, terminal: false };
        let Some(down) = down(scene) else { return none };
        let free = || scene.bodies.iter().filter(|set| set.motion == Motion::Free);
        if free().next().is_none() {
            return none;
        }
        let length = scene.domain.size()[down];
        // Where the domain wraps around there is no floor: as far as it is long.
        let height =
            if scene.domain.is_periodic(down) { length } else { highest_fall(scene, down) };
        let weight = |density: f64| {
            scene.fluid.as_ref().map_or(1.0, |fluid| (1.0 - fluid.density / density).abs())
        };
        let pull = scene.gravity[down].abs();
        let heaviest = free().fold(0.0, |most: f64, set| most.max(weight(set.density)));
        let freely = (2.0 * pull * heaviest * height).sqrt();
        let terminal = scene.fluid.as_ref().map(|fluid| {
            let of = |set: &BodySet| terminal_speed(fluid, set.density, largest(scene, set), pull);
            free().map(of).fold(0.0, f64::max)
        });
        match terminal {
            Some(terminal) if terminal < freely => Self { height, speed: terminal, terminal: true },
            _ => Self { height, speed: freely, terminal: false },
        }
    }
}

/// The largest diameter of a set, fed ones among them [m].
fn largest(scene: &Scene, set: &BodySet) -> f64 {
    let fed = scene.inlets.iter().filter(|inlet| inlet.bodies == set.name);
    let fed = fed.map(|inlet| inlet.diameters.extremes()[1]);
    random_packing::diameters_of(set).into_iter().chain(fed).fold(0.0, f64::max)
}

/// The axis along which gravity is strongest.
fn down(scene: &Scene) -> Option<usize> {
    let g = scene.gravity;
    let down = (0..3).fold(0, |best, a| if g[a].abs() > g[best].abs() { a } else { best });
    (g[down] != 0.0).then_some(down)
}

fn floor_area(scene: &Scene, down: usize) -> f64 {
    (0..3).filter(|a| *a != down).map(|a| scene.domain.size()[a]).product()
}

/// The farthest that a body falls until it lies on those that were below it [m].
fn highest_fall(scene: &Scene, down: usize) -> f64 {
    let (domain, up) = (&scene.domain, scene.gravity[down] < 0.0);
    // Over the face that gravity points to.
    let height = |x: f64| if up { x - domain.min[down] } else { domain.max[down] - x };
    let of_region = |region: [f64; 2]| {
        let [a, b] = region.map(height);
        [a.min(b), a.max(b)]
    };
    let mut layers: Vec<Layer> = Vec::new();
    for set in scene.bodies.iter().filter(|set| set.motion == Motion::Free) {
        let mut ball = |x: f64, d: f64| {
            let volume = domain.body_volume(d);
            layers.push(Layer { bottom: height(x) - 0.5 * d, top: 0.0, volume });
        };
        let packing = match &set.placement {
            Placement::Listed(list) => {
                list.iter().for_each(|sphere| ball(sphere.position[down], sphere.diameter));
                continue;
            }
            Placement::Polyhedra(own) => match &own.placement {
                PolyhedronPlacement::Listed(list) => {
                    list.iter().for_each(|body| ball(body.position[down], body.diameter));
                    continue;
                }
                PolyhedronPlacement::Packed(packing) => packing,
            },
            Placement::Packed(packing) => packing,
        };
        let [bottom, top] = of_region([packing.min[down], packing.max[down]]);
        layers.push(Layer { bottom, top, volume: set.placement.sizes().volume() });
    }
    layers.sort_by(|a, b| a.bottom.total_cmp(&b.bottom));
    let area = floor_area(scene, down);
    let (mut bed, mut fall) = (0.0, 0.0f64);
    for Layer { bottom, top, volume } in layers {
        fall = fall.max(bottom - bed);
        bed += volume / (BED * area);
        fall = fall.max(top - bed);
    }
    let fed = |inlet: &Inlet| of_region([inlet.min[down], inlet.max[down]])[1];
    scene.inlets.iter().map(fed).fold(fall, f64::max)
}

/// The speed at which a sphere sinks or rises in a fluid [m/s], under a `pull` [m/s²].
fn terminal_speed(fluid: &FluidMaterial, density: f64, diameter: f64, pull: f64) -> f64 {
    let weight = (density - fluid.density).abs() * PI / 6.0 * diameter * diameter * diameter * pull;
    let drag = |v: f64| {
        let re = fluid.density * v * diameter / fluid.viscosity;
        let coefficient =
            if re < 1000.0 { 24.0 / re * (1.0 + 0.15 * libm::pow(re, 0.687)) } else { 0.44 };
        coefficient * PI / 8.0 * fluid.density * v * v * diameter * diameter
    };
    // Stokes' drag is less than any at the same speed: its terminal speed is the largest.
    let (mut low, mut high) = (0.0, weight / (3.0 * PI * fluid.viscosity * diameter));
    for _ in 0..100 {
        let v = 0.5 * (low + high);
        if drag(v) > weight { high = v } else { low = v }
    }
    high
}

/// The pressure of all free bodies on the floor [Pa]: of their weight less buoyancy, and of what
/// inlets add until the domain is full, where no outlet takes it away.
fn pressure(scene: &Scene) -> f64 {
    let Some(down) = down(scene).filter(|&down| !scene.domain.is_periodic(down)) else {
        return 0.0;
    };
    let excess = |set: &BodySet| {
        (set.density - scene.fluid.as_ref().map_or(0.0, |fluid| fluid.density)).abs()
    };
    let free = || scene.bodies.iter().filter(|set| set.motion == Motion::Free);
    let volume: f64 = free().map(|set| set.placement.sizes().volume()).sum();
    let mass: f64 = free().map(|set| excess(set) * set.placement.sizes().volume()).sum();
    let room = scene.domain.size().into_iter().product::<f64>() * BED - volume;
    let fed = |inlet: &Inlet| free().find(|set| set.name == inlet.bodies).map_or(0.0, excess);
    let heaviest = scene.inlets.iter().map(fed).fold(0.0, f64::max);
    let more = if scene.outlets.is_empty() { heaviest * room.max(0.0) } else { 0.0 };
    scene.gravity[down].abs() * (mass + more) / floor_area(scene, down)
}
