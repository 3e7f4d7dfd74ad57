//! Who may meet whom under which law, and the extreme pairs under each.

use crate::{
    law::{Law, Reduced},
    laws::{Surface, surfaces},
    packing, placement,
};
use core::f64::consts::PI;
use tremie_messages::{
    Problem,
    scene::{
        BodySet, ContactLaw, Face, InletVelocity, Motion, Placement, PolyhedronPlacement, Scene,
        Spring,
    },
};

/// Mass [kg], infinite where the motion is given, and radius [m].
type Grain = (f64, f64);

/// The bodies of one material.
struct Kind<'a> {
    material: &'a str,
    bodies: usize,
    free: usize,
    /// The two lightest and the two heaviest free bodies.
    lightest: [Grain; 2],
    heaviest: [Grain; 2],
    /// Smallest and largest radius of all.
    radii: [f64; 2],
}

/// The bodies of a scene by material, with what they may meet.
pub(crate) struct Population<'a> {
    scene: &'a Scene,
    kinds: Vec<Kind<'a>>,
    surfaces: Vec<Surface<'a>>,
    /// How many bodies stand for those that inlets feed.
    fed: usize,
    /// Largest speed of anything at the start [m/s].
    pub speed: f64,
}

/// Two materials that may meet, under their law.
pub(crate) struct Encounter<'a> {
    /// Which, as "glass with glass".
    pub name: String,
    /// Their law.
    pub law: &'a ContactLaw,
    /// The lightest pair.
    pub light: Reduced,
    /// The heaviest pair.
    pub heavy: Reduced,
    /// Sum of the inverse masses of the lightest pair [1/kg].
    pub inverse_mass: f64,
    /// Whether it is with a wall or a part.
    pub with_surface: bool,
    /// Most contacts under this law that a body can have at once.
    pub contacts: f64,
}

/// Neighbours of a sphere in the densest packing of equal ones, and walls in a corner.
const MOST_NEIGHBOURS: usize = 12;
const MOST_WALLS: usize = 3;

impl<'a> Population<'a> {
    pub fn of(scene: &'a Scene) -> Self {
        let mut all =
            Self { scene, kinds: Vec::new(), surfaces: surfaces(scene), fed: 0, speed: 0.0 };
        for set in &scene.bodies {
            let material = set.material.as_str();
            if !all.kinds.iter().any(|kind| kind.material == material) {
                all.kinds.push(Kind::none(material));
            }
            let kind = all.kinds.iter_mut().find(|kind| kind.material == material);
            let Some(kind) = kind else { continue };
            for d in packing::diameters_of(set) {
                let mass = placement::mass(set.density, d);
                kind.add((mass, 0.5 * d), set.motion == Motion::Free);
            }
        }
        for inlet in &scene.inlets {
            let Some(set) = scene.bodies.iter().find(|set| set.name == inlet.bodies) else {
                continue;
            };
            let of_set = |kind: &&mut Kind| kind.material == set.material;
            let Some(kind) = all.kinds.iter_mut().find(of_set) else { continue };
            // Two of each, which may meet.
            for d in inlet.diameters.extremes().into_iter().flat_map(|d| [d, d]) {
                kind.add((placement::mass(set.density, d), 0.5 * d), set.motion == Motion::Free);
                all.fed += 1;
            }
        }
        all.speed = speed(scene);
        all
    }

    /// Mass and radius of the lightest body of a set.
    pub fn lightest(set: &BodySet) -> Option<Grain> {
        let smallest = packing::diameters_of(set).into_iter().reduce(f64::min)?;
        Some((placement::mass(set.density, smallest), 0.5 * smallest))
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

    /// What may meet under which law.
    pub fn encounters(&self) -> Vec<Encounter<'a>> {
        let mut found: Vec<Encounter<'a>> = Vec::new();
        self.each(|a, b, _, (light, heavy, contacts)| {
            let Some(law) = self.scene.law(a, b) else { return };
            let with_surface = light[1].1.is_infinite();
            let side = if with_surface { "surface of " } else { "" };
            let name = format!("{a} with {side}{b}");
            let ((light, inverse_mass), (heavy, _)) = (reduced(light), reduced(heavy));
            if let Some(known) = found.iter_mut().find(|known| known.name == name) {
                known.contacts = (known.contacts + contacts as f64).min(MOST_WALLS as f64);
                // A slider is lighter than what stands still.
                if inverse_mass > known.inverse_mass {
                    (known.light, known.inverse_mass) = (light, inverse_mass);
                }
                if heavy.root_mass > known.heavy.root_mass {
                    known.heavy = heavy;
                }
                return;
            }
            let contacts = contacts as f64;
            found.push(Encounter { name, law, light, heavy, inverse_mass, with_surface, contacts });
        });
        found
    }

    /// Visits the pairs of materials that may meet: their names, the fact, and the lightest pair, the
    /// heaviest pair, and the most contacts at once.
    fn each(
        &self,
        mut visit: impl FnMut(&'a str, &'a str, String, ([Grain; 2], [Grain; 2], usize)),
    ) {
        for (index, a) in self.kinds.iter().enumerate() {
            for b in &self.kinds[index..] {
                let same = a.material == b.material;
                if a.free + b.free == 0 || (same && a.bodies < 2) {
                    continue;
                }
                let (light, heavy) = if same {
                    let other = |of: [Grain; 2]| {
                        if a.free >= 2 { of } else { [of[0], (f64::INFINITY, a.radii[0])] }
                    };
                    (other(a.lightest), other(a.heaviest))
                } else {
                    let of = |kind: &Kind, grain: Grain| {
                        if kind.free > 0 { grain } else { (f64::INFINITY, kind.radii[0]) }
                    };
                    (
                        [of(a, a.lightest[0]), of(b, b.lightest[0])],
                        [of(a, a.heaviest[0]), of(b, b.heaviest[0])],
                    )
                };
                let others = if same { a.bodies - 1 } else { a.bodies.max(b.bodies) };
                let what = "bodies of these materials may touch".into();
                visit(a.material, b.material, what, (light, heavy, others.min(MOST_NEIGHBOURS)));
            }
        }
        for kind in self.kinds.iter().filter(|kind| kind.free > 0) {
            for surface in &self.surfaces {
                let flat = (surface.mass, f64::INFINITY);
                let pairs = ([kind.lightest[0], flat], [kind.heaviest[0], flat], 1);
                let what = format!("bodies of \"{}\" may touch {}", kind.material, surface.name);
                visit(kind.material, surface.material, what, pairs);
            }
        }
    }
}

impl<'a> Kind<'a> {
    fn none(material: &'a str) -> Self {
        Self {
            material,
            bodies: 0,
            free: 0,
            lightest: [(f64::INFINITY, f64::INFINITY); 2],
            heaviest: [(0.0, 0.0); 2],
            radii: [f64::INFINITY, 0.0],
        }
    }

    fn add(&mut self, grain: Grain, free: bool) {
        self.bodies += 1;
        self.radii = [self.radii[0].min(grain.1), self.radii[1].max(grain.1)];
        if !free {
            return;
        }
        self.free += 1;
        self.lightest = first_two(self.lightest, grain, |a, b| a.0 < b.0);
        self.heaviest = first_two(self.heaviest, grain, |a, b| a.0 > b.0);
    }
}

fn first_two([a, b]: [Grain; 2], c: Grain, before: fn(&Grain, &Grain) -> bool) -> [Grain; 2] {
    if before(&c, &a) {
        [c, a]
    } else if before(&c, &b) {
        [a, c]
    } else {
        [a, b]
    }
}

/// Reduced mass and radius, and the sum of inverse masses.
fn reduced([a, b]: [Grain; 2]) -> (Reduced, f64) {
    let inverse_mass = 1.0 / a.0 + 1.0 / b.0;
    let radius = 1.0 / (1.0 / a.1 + 1.0 / b.1);
    (Reduced { root_mass: (1.0 / inverse_mass).sqrt(), radius }, inverse_mass)
}

fn speed(scene: &Scene) -> f64 {
    let norm = |v: &[f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    let mut fastest = 0.0f64;
    for inlet in &scene.inlets {
        if let InletVelocity::Given(velocity) = &inlet.velocity {
            fastest = norm(velocity).max(fastest);
        }
    }
    for set in &scene.bodies {
        if let Placement::Listed(list) = &set.placement {
            fastest = list.iter().fold(fastest, |v, sphere| v.max(norm(&sphere.velocity)));
        }
        if let Placement::Polyhedra(own) = &set.placement
            && let PolyhedronPlacement::Listed(list) = &own.placement
        {
            fastest = list.iter().fold(fastest, |v, body| v.max(norm(&body.velocity)));
        }
        fastest = motion_speed(&set.motion).max(fastest);
    }
    for part in &scene.parts {
        fastest = motion_speed(&part.motion).max(fastest);
    }
    for face in scene.domain.faces.iter().flatten() {
        if let Face::Wall { velocity } = face {
            fastest = norm(velocity).max(fastest);
        }
    }
    fastest
}

fn motion_speed(motion: &Motion) -> f64 {
    if let Motion::Slider(slider) = motion {
        return slider.velocity.abs();
    }
    let Motion::Prescribed(points) = motion else { return 0.0 };
    let norm = |v: &[f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    points.iter().fold(0.0, |v: f64, point| v.max(norm(&point.velocity)))
}

/// Duration of a collision without damping at a relative speed [s]: `pi sqrt(m*/k_n)` for linear
/// springs; under Hertz's law `2.9432 delta_max/v` (Landau & Lifshitz, *Theory of Elasticity*, sec. 9).
pub(crate) fn contact_time(law: &ContactLaw, pair: Reduced, speed: f64) -> f64 {
    let mass = pair.root_mass * pair.root_mass;
    match law.spring {
        Spring::Linear { normal_stiffness, .. } => PI * (mass / normal_stiffness).sqrt(),
        Spring::Hertz { .. } => 2.943_225_5 * largest_overlap(law, pair, speed) / speed,
    }
}

/// Largest overlap of an undamped head-on collision at a relative speed [m].
pub(crate) fn largest_overlap(law: &ContactLaw, pair: Reduced, speed: f64) -> f64 {
    let mass = pair.root_mass * pair.root_mass;
    match law.spring {
        Spring::Linear { normal_stiffness, .. } => speed * (mass / normal_stiffness).sqrt(),
        Spring::Hertz { effective_modulus, .. } => {
            let hertz = 4.0 / 3.0 * effective_modulus * pair.radius.sqrt();
            libm::pow(1.25 * mass * speed * speed / hertz, 0.4)
        }
    }
}

/// Damping ratio of the normal dashpot; that of Hertz's law in the sense of [`Law`].
pub(crate) fn damping_ratio(law: &ContactLaw, pair: Reduced) -> f64 {
    let resolved = Law::new(law);
    match law.spring {
        Spring::Linear { normal_stiffness, .. } => {
            let gamma = resolved.at(1.0, 1.0, pair).gamma_n;
            gamma / (2.0 * pair.root_mass * normal_stiffness.sqrt())
        }
        Spring::Hertz { effective_modulus, .. } => {
            let hertz = 4.0 / 3.0 * effective_modulus * pair.radius.sqrt();
            let gamma = resolved.at(1.0, 1.0, pair).gamma_n;
            gamma / (5f64.sqrt() * pair.root_mass * hertz.sqrt())
        }
    }
}
