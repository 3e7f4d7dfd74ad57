//! Pairs of materials that may meet, with their laws and the extreme pairs under each.

use crate::contact::contact_law::Law;
use crate::contact::material_laws::{Surface, surfaces};
use crate::contact::springs::Reduced;
use crate::solver::clumps::{self, Whole};
use crate::solver::placement;
use tremie_grains_kit::packing::random_packing;
use tremie_messages::{
    Problem,
    scene::{BodySet, Face, Inlet, InletVelocity, Motion, Placement, PolyhedronPlacement, Scene},
};

/// A body that may meet others.
#[derive(Clone, Copy, Debug)]
struct LightestBody {
    /// Mass [kg], of a clump's body that of the clump; infinite where the motion is given.
    mass: f64,
    /// Mass that a contact has to move, at least [kg]; see [`clumps::Whole::felt`].
    felt: f64,
    /// Radius [m].
    radius: f64,
    /// The clump that it belongs to.
    clump: Option<u32>,
}

impl LightestBody {
    /// A body by itself.
    fn alone(mass: f64, radius: f64) -> Self {
        Self { mass, felt: mass, radius, clump: None }
    }

    /// A body that does not move: of infinite mass.
    fn still(radius: f64) -> Self {
        Self::alone(f64::INFINITY, radius)
    }

    /// True if two belong to one clump, so that they never touch.
    fn is_joined_to(&self, other: &Self) -> bool {
        self.clump.is_some() && self.clump == other.clump
    }
}

/// The bodies of one material.
struct BodyKind<'a> {
    material: &'a str,
    bodies: usize,
    free: usize,
    /// The two lightest and the two heaviest free bodies.
    lightest: [LightestBody; 2],
    heaviest: [LightestBody; 2],
    /// The two that are heaviest for their size: of most mass over the square of the radius.
    densest: [LightestBody; 2],
    /// Smallest and largest radius of all.
    radii: [f64; 2],
    /// Common clump of all the bodies, or `Many`; `None` without bodies.
    sole: Option<Sole>,
}

/// Common clump of the bodies of a kind, if there is one.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Sole {
    /// All belong to this clump.
    Clump(u32),
    /// They do not all belong to one clump.
    Many,
}

/// The bodies of a scene by material, with the surfaces that they may meet.
pub(crate) struct BodyStatistics<'a> {
    scene: &'a Scene,
    kinds: Vec<BodyKind<'a>>,
    surfaces: Vec<Surface<'a>>,
    /// Number of bodies that stand for those that inlets feed.
    fed: usize,
    /// Largest speed of anything at the start [m/s].
    pub speed: f64,
}

/// Two materials that may meet, under their law.
pub(crate) struct MaterialPair<'a> {
    /// Name of the pair, as "glass with glass".
    pub name: String,
    /// The materials, that of a surface last.
    pub materials: [&'a str; 2],
    /// Their law.
    pub law: Law,
    /// The lightest pair.
    pub light: Reduced,
    /// The heaviest pair.
    pub heavy: Reduced,
    /// The pair that sinks deepest into each other for its size, with the smaller radius [m].
    pub soft: (Reduced, f64),
    /// Sum of the inverse masses that a contact of the lightest pair has to move [1/kg].
    pub inverse_mass: f64,
    /// True if the pair is a body with a wall or a part.
    pub with_surface: bool,
    /// Most contacts under this law that a body can have at once.
    pub contacts: f64,
}

/// Bodies of two materials that may meet: the lightest, the heaviest, those that are heaviest for
/// their size, and the most contacts of one of them at once.
struct Pairs {
    light: [LightestBody; 2],
    heavy: [LightestBody; 2],
    dense: [LightestBody; 2],
    contacts: usize,
}

/// Neighbours of a sphere in the densest packing of equal ones, and walls in a corner.
const MOST_NEIGHBOURS: usize = 12;
const MOST_WALLS: usize = 3;

impl<'a> BodyStatistics<'a> {
    pub fn of(scene: &'a Scene) -> Self {
        let mut all =
            Self { scene, kinds: Vec::new(), surfaces: surfaces(scene), fed: 0, speed: 0.0 };
        for (set, whole) in scene.bodies.iter().zip(clumps::wholes(scene)) {
            let material = set.material.as_str();
            if !all.kinds.iter().any(|kind| kind.material == material) {
                all.kinds.push(BodyKind::none(material));
            }
            let kind = all.kinds.iter_mut().find(|kind| kind.material == material);
            let Some(kind) = kind else { continue };
            for d in random_packing::diameters_of(set) {
                let alone = LightestBody::alone(placement::mass_in(scene, set.density, d), 0.5 * d);
                let joined = |Whole { number, mass, felt }| LightestBody {
                    mass,
                    felt,
                    radius: alone.radius,
                    clump: Some(number),
                };
                kind.add(whole.map_or(alone, joined), set.motion == Motion::Free);
            }
        }
        for inlet in &scene.inlets {
            let Some(set) = scene.bodies.iter().find(|set| set.name == inlet.bodies) else {
                continue;
            };
            let of_set = |kind: &&mut BodyKind| kind.material == set.material;
            let Some(kind) = all.kinds.iter_mut().find(of_set) else { continue };
            // Two of each, which may meet.
            for d in inlet.diameters.extremes().into_iter().flat_map(|d| [d, d]) {
                let grain = LightestBody::alone(placement::mass_in(scene, set.density, d), 0.5 * d);
                kind.add(grain, set.motion == Motion::Free);
                all.fed += 1;
            }
        }
        all.speed = speed(scene);
        all
    }

    /// Mass that a contact of a set's smallest body has to move, at least [kg], and its radius [m].
    pub fn lightest(scene: &Scene, set: &BodySet, whole: Option<Whole>) -> Option<(f64, f64)> {
        let smallest = random_packing::diameters_of(set).into_iter().reduce(f64::min)?;
        let own = placement::mass_in(scene, set.density, smallest);
        Some((whole.map_or(own, |whole| whole.felt), 0.5 * smallest))
    }

    /// Number of bodies at the start.
    pub fn bodies(&self) -> usize {
        self.kinds.iter().map(|kind| kind.bodies).sum::<usize>() - self.fed
    }

    /// Number of bodies that move under forces.
    pub fn free(&self) -> usize {
        self.kinds.iter().map(|kind| kind.free).sum()
    }

    /// Smallest and largest diameter; 0 without bodies.
    pub fn diameters(&self) -> [f64; 2] {
        let largest = self.kinds.iter().fold(0.0, |r: f64, kind| r.max(kind.radii[1]));
        [2.0 * self.kinds.iter().fold(largest, |r, kind| r.min(kind.radii[0])), 2.0 * largest]
    }

    /// Pairs of materials that may meet without a law.
    pub fn problems(&self) -> Vec<Problem> {
        let mut problems = Vec::new();
        let mut missing: Vec<[&str; 2]> = Vec::new();
        self.each(|a, b, what, _| {
            let known = |pair: &[&str; 2]| *pair == [a, b] || *pair == [b, a];
            if self.scene.law(a, b).is_some() || missing.iter().any(known) {
                return;
            }
            missing.push([a, b]);
            let message = format!("has no law for \"{a}\" and \"{b}\", but {what}");
            let help =
                format!("add a [[scene.contacts]] with between = [\"{a}\", \"{b}\"] and its law");
            problems.push(Problem::new("scene.contacts", message).help(help));
        });
        problems
    }

    /// Pairs of materials that may meet, each with its law.
    pub fn encounters(&self) -> Vec<MaterialPair<'a>> {
        let mut found: Vec<MaterialPair<'a>> = Vec::new();
        self.each(|a, b, _, Pairs { light, heavy, dense, contacts }| {
            let Some(law) = self.scene.law(a, b).map(Law::new) else { return };
            let with_surface = light[1].radius.is_infinite();
            let side = if with_surface { "surface of " } else { "" };
            let name = format!("{a} with {side}{b}");
            let by_mean_mass = law.spring.law().is_by_mean_mass();
            // The dense ones sink deepest, but where the stiffness goes with the mass the small do.
            let sinking = if by_mean_mass { light } else { dense };
            let soft = (reduced(sinking).0, sinking[0].radius.min(sinking[1].radius));
            let light = if by_mean_mass { quickest(light, heavy) } else { light };
            let ((light, inverse_mass), (heavy, _)) = (reduced(light), reduced(heavy));
            if let Some(known) = found.iter_mut().find(|known| known.name == name) {
                known.contacts = (known.contacts + contacts as f64).min(MOST_WALLS as f64);
                // A slider is lighter than what stands still.
                if inverse_mass > known.inverse_mass {
                    (known.light, known.inverse_mass) = (light, inverse_mass);
                }
                if heavy.root_mass > known.heavy.root_mass {
                    (known.heavy, known.soft) = (heavy, soft);
                }
                return;
            }
            let (contacts, materials) = (contacts as f64, [a, b]);
            found.push(MaterialPair {
                name,
                materials,
                law,
                light,
                heavy,
                soft,
                inverse_mass,
                with_surface,
                contacts,
            });
        });
        found
    }

    /// Visits the pairs of materials that may meet: their names, the fact, and the bodies.
    fn each(&self, mut visit: impl FnMut(&'a str, &'a str, String, Pairs)) {
        for (index, a) in self.kinds.iter().enumerate() {
            for b in &self.kinds[index..] {
                let same = a.material == b.material;
                if a.free + b.free == 0 || a.never_meets(b, same) {
                    continue;
                }
                let [light, heavy, dense] = if same {
                    let other = |of: [LightestBody; 2]| {
                        let free =
                            if a.free >= 2 { of[1] } else { LightestBody::still(a.radii[0]) };
                        [of[0], free]
                    };
                    // The second is none where all that are free are in one clump.
                    let deep = |[one, other]: [LightestBody; 2]| {
                        [
                            one,
                            if other.mass > 0.0 { other } else { LightestBody::still(one.radius) },
                        ]
                    };
                    [other(a.lightest), other(a.heaviest), deep(other(a.densest))]
                } else {
                    let of = |kind: &BodyKind, grain: LightestBody| {
                        if kind.free > 0 { grain } else { LightestBody::still(kind.radii[0]) }
                    };
                    [
                        [of(a, a.lightest[0]), of(b, b.lightest[0])],
                        [of(a, a.heaviest[0]), of(b, b.heaviest[0])],
                        [of(a, a.densest[0]), of(b, b.densest[0])],
                    ]
                };
                let others = if same { a.bodies - 1 } else { a.bodies.max(b.bodies) };
                let what = "bodies of these materials may touch".into();
                let contacts = others.min(MOST_NEIGHBOURS);
                visit(a.material, b.material, what, Pairs { light, heavy, dense, contacts });
            }
        }
        for kind in self.kinds.iter().filter(|kind| kind.free > 0) {
            for surface in &self.surfaces {
                let flat = LightestBody::alone(surface.mass, f64::INFINITY);
                let [light, heavy, dense] =
                    [kind.lightest, kind.heaviest, kind.densest].map(|of| [of[0], flat]);
                let pairs = Pairs { light, heavy, dense, contacts: 1 };
                let what = format!("bodies of \"{}\" may touch {}", kind.material, surface.name);
                visit(kind.material, surface.material, what, pairs);
            }
        }
    }
}

impl<'a> BodyKind<'a> {
    fn none(material: &'a str) -> Self {
        Self {
            material,
            bodies: 0,
            free: 0,
            lightest: [LightestBody::alone(f64::INFINITY, f64::INFINITY); 2],
            heaviest: [LightestBody::alone(0.0, 0.0); 2],
            densest: [LightestBody::alone(0.0, 1.0); 2],
            radii: [f64::INFINITY, 0.0],
            sole: None,
        }
    }

    /// True if bodies of two kinds cannot touch: there is but one, or they all belong to one clump.
    fn never_meets(&self, other: &Self, same: bool) -> bool {
        let one_clump = match (self.sole, other.sole) {
            (Some(Sole::Clump(a)), Some(Sole::Clump(b))) => a == b,
            _ => false,
        };
        (same && self.bodies < 2) || one_clump
    }

    fn add(&mut self, grain: LightestBody, free: bool) {
        self.sole = match (self.sole, grain.clump.filter(|_| free)) {
            (None, Some(clump)) => Some(Sole::Clump(clump)),
            (Some(Sole::Clump(known)), Some(clump)) if known == clump => self.sole,
            _ => Some(Sole::Many),
        };
        self.bodies += 1;
        self.radii = [self.radii[0].min(grain.radius), self.radii[1].max(grain.radius)];
        if !free {
            return;
        }
        self.free += 1;
        self.lightest = first_two(self.lightest, grain, |a, b| a.felt < b.felt);
        self.heaviest = first_two(self.heaviest, grain, |a, b| a.mass > b.mass);
        let denser: fn(&LightestBody, &LightestBody) -> bool =
            |a, b| a.mass / (a.radius * a.radius) > b.mass / (b.radius * b.radius);
        self.densest = first_two(self.densest, grain, denser);
    }
}

/// The first and the second of three; of bodies of one clump the first alone, for they never touch.
fn first_two(
    [a, b]: [LightestBody; 2],
    c: LightestBody,
    before: fn(&LightestBody, &LightestBody) -> bool,
) -> [LightestBody; 2] {
    let first = if before(&c, &a) { c } else { a };
    let mut others = [b, if before(&c, &a) { a } else { c }]
        .into_iter()
        .filter(|other| !other.is_joined_to(&first))
        .collect::<Vec<_>>();
    others.sort_by(|x, y| match (before(x, y), before(y, x)) {
        (true, _) => std::cmp::Ordering::Less,
        (_, true) => std::cmp::Ordering::Greater,
        _ => std::cmp::Ordering::Equal,
    });
    [first, others.first().copied().unwrap_or(b)]
}

/// The masses and the reduced radius, and the sum of the inverse masses that a contact has to move.
fn reduced([a, b]: [LightestBody; 2]) -> (Reduced, f64) {
    let inverse_mass = 1.0 / a.mass + 1.0 / b.mass;
    let radius = 1.0 / (1.0 / a.radius + 1.0 / b.radius);
    // Of a wall or a part, and where a motion is given, the mass does not count.
    let counts = |body: &LightestBody| body.mass.is_finite() && body.radius.is_finite();
    let mean_mass = match (counts(&a), counts(&b)) {
        (true, true) => 0.5 * (a.mass + b.mass),
        (false, true) => b.mass,
        _ => a.mass,
    };
    let reduced = Reduced { root_mass: (1.0 / inverse_mass).sqrt(), radius, mean_mass };
    (reduced, 1.0 / a.felt + 1.0 / b.felt)
}

/// Where the stiffness goes with the mean mass, the pair whose contacts are quickest: a light body
/// is, with another one or with a heavy one.
fn quickest(light: [LightestBody; 2], heavy: [LightestBody; 2]) -> [LightestBody; 2] {
    let mut best = light;
    let rate = |pair: [LightestBody; 2]| {
        let (masses, inverse_mass) = reduced(pair);
        masses.mean_mass * inverse_mass
    };
    for pair in [[light[0], heavy[0]], [light[0], heavy[1]], [heavy[0], light[1]]] {
        // Else they may be one and the same body.
        let apart = pair[0].mass != pair[1].mass && pair[0].radius != pair[1].radius;
        if apart && !pair[0].is_joined_to(&pair[1]) && rate(pair) > rate(best) {
            best = pair;
        }
    }
    best
}

fn speed(scene: &Scene) -> f64 {
    let norm = |v: &[f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    let mut fastest = 0.0f64;
    for inlet in &scene.inlets {
        fastest = inlet_velocity(scene, inlet).map_or(0.0, |velocity| norm(&velocity)).max(fastest);
    }
    for set in &scene.bodies {
        let factor = match &set.motion {
            Motion::Timed(timed) => timed.course.largest(),
            _ => 1.0,
        };
        if let Placement::Listed(list) = &set.placement {
            fastest = list.iter().fold(fastest, |v, sphere| v.max(factor * norm(&sphere.velocity)));
        }
        if let Placement::Polyhedra(own) = &set.placement
            && let PolyhedronPlacement::Listed(list) = &own.placement
        {
            fastest = list.iter().fold(fastest, |v, body| v.max(factor * norm(&body.velocity)));
        }
        fastest = motion_speed(&set.motion).max(fastest);
    }
    for part in &scene.parts {
        fastest = motion_speed(&part.motion).max(fastest);
    }
    for face in scene.domain.faces.iter().flatten() {
        if let Face::Wall { velocity, course } = face {
            fastest = (norm(velocity) * course.largest()).max(fastest);
        }
    }
    fastest
}

/// Largest velocity that the scene gives to grains at an inlet [m/s]; that of a face which follows
/// the flow is not known.
pub fn inlet_velocity(scene: &Scene, inlet: &Inlet) -> Option<[f64; 3]> {
    match inlet.velocity {
        InletVelocity::Given(velocity) => Some(velocity),
        InletVelocity::Face { axis, side } => match &scene.domain.faces[axis][side] {
            Face::Velocity(open) => Some(open.velocity.map(|v| v * open.course.largest())),
            _ => None,
        },
    }
}

fn motion_speed(motion: &Motion) -> f64 {
    if let Motion::Slider(slider) = motion {
        return slider.velocity.abs();
    }
    let norm = |v: &[f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    if let Motion::Timed(timed) = motion {
        return norm(&timed.velocity) * timed.course.largest();
    }
    let Motion::Prescribed(points) = motion else { return 0.0 };
    points.iter().fold(0.0, |v: f64, point| v.max(norm(&point.velocity)))
}
