//! Bodies, clumps and parts whose motion and fluid loads are signals.
//!
//! Of bodies those are: the body of a set that lists one, and each clump, as long as there are no
//! more than [`BY_THEMSELVES`] of these in all; and the bodies of sets, and the clumps, that the
//! scene asks for. Parts that move always are.

use std::collections::{BTreeMap, BTreeSet};
use tremie_messages::scene::{BodySet, Placement, PolyhedronPlacement, Scene};

/// Largest number of single bodies and clumps that are followed without being asked for.
pub const BY_THEMSELVES: usize = 16;

/// Body or clump that is followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Followed {
    /// A body of a set, by the set's index and its place in it.
    Body {
        /// Index of the set.
        set: usize,
        /// Place in it.
        place: usize,
    },
    /// A clump, by its number.
    Clump(usize),
}

/// Bodies and clumps that a scene follows, with their names.
pub fn of_scene(scene: &Scene) -> Vec<(String, Followed)> {
    let (numbers, _) = clump_numbers(scene);
    let asked = |name: &str| scene.followed.iter().any(|followed| followed == name);
    let (mut singles, mut wanted) = (Vec::new(), Vec::new());
    let mut seen = BTreeSet::new();
    for (set, bodies) in scene.bodies.iter().enumerate() {
        let one = |name: &str, followed: Followed| (name.to_string(), followed);
        match (&bodies.clump, numbers[set]) {
            (Some(name), Some(number)) => {
                if seen.insert(number) {
                    let to = if asked(name) { &mut wanted } else { &mut singles };
                    to.push(one(name, Followed::Clump(number as usize)));
                }
            }
            _ => {
                let count = listed(bodies).unwrap_or(0);
                let fed = scene.inlets.iter().any(|inlet| inlet.bodies == bodies.name);
                if asked(&bodies.name) && count > 1 {
                    wanted.extend((0..count).map(|place| {
                        (format!("{}{place}", bodies.name), Followed::Body { set, place })
                    }));
                } else if count == 1 && (asked(&bodies.name) || !fed) {
                    let to = if asked(&bodies.name) { &mut wanted } else { &mut singles };
                    to.push(one(&bodies.name, Followed::Body { set, place: 0 }));
                }
            }
        }
    }
    if singles.len() > BY_THEMSELVES {
        singles.clear();
    }
    singles.extend(wanted);
    named(scene, singles)
}

/// The number of the clump of each set, in the order in which sets name them, and how many there
/// are.
pub fn clump_numbers(scene: &Scene) -> (Vec<Option<u32>>, usize) {
    let mut known = BTreeMap::new();
    let of = |set: &BodySet| {
        let next = known.len() as u32;
        Some(*known.entry(set.clump.clone()?).or_insert(next))
    };
    let numbers = scene.bodies.iter().map(of).collect();
    (numbers, known.len())
}

/// Number of bodies that a set lists.
fn listed(set: &BodySet) -> Option<usize> {
    match &set.placement {
        Placement::Listed(list) => Some(list.len()),
        Placement::Packed(_) => None,
        Placement::Polyhedra(own) => match &own.placement {
            PolyhedronPlacement::Listed(list) => Some(list.len()),
            PolyhedronPlacement::Packed(_) => None,
        },
    }
}

/// With names that can be those of signals and that nobody else has.
fn named(scene: &Scene, mut all: Vec<(String, Followed)>) -> Vec<(String, Followed)> {
    let mut taken: BTreeSet<String> = BTreeSet::new();
    taken.extend(scene.parts.iter().map(|part| part.name.clone()));
    taken.extend(scene.inlets.iter().map(|inlet| inlet.name.clone()));
    taken.extend(scene.outlets.iter().map(|outlet| outlet.name.clone()));
    taken.extend(scene.probes.iter().map(|probe| probe.name.clone()));
    for (name, followed) in &mut all {
        let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
        *name = name.chars().map(plain).collect();
        let what = if matches!(followed, Followed::Clump(_)) { "clump" } else { "body" };
        while !taken.insert(name.clone()) {
            *name = format!("{what}_{name}");
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::scene::{Domain, Face, Motion, Sphere};

    fn set(name: &str, count: usize, clump: Option<&str>) -> BodySet {
        let sphere = |k: usize| Sphere {
            position: [k as f64, 0.5, 0.5],
            diameter: 0.1,
            velocity: [0.0; 3],
            angular_velocity: [0.0; 3],
        };
        BodySet {
            name: name.into(),
            density: 1.0,
            material: "stone".into(),
            motion: Motion::Free,
            clump: clump.map(str::to_string),
            placement: Placement::Listed((0..count).map(sphere).collect()),
        }
    }

    fn names(bodies: Vec<BodySet>, followed: &[&str]) -> Vec<String> {
        let followed = followed.iter().map(|name| (*name).to_string()).collect();
        let domain = Domain::new([0.0; 3], [1.0; 3], Face::WALLS);
        let scene = Scene { bodies, followed, ..Scene::empty(domain) };
        of_scene(&scene).into_iter().map(|(name, _)| name).collect()
    }

    #[test]
    fn single_bodies_and_clumps_are_followed_and_others_where_asked_for() {
        let sets = || {
            vec![
                set("ball", 1, None),
                set("sand", 3, None),
                set("head", 1, Some("hammer")),
                set("handle", 5, Some("hammer")),
                set("my rock!", 1, None),
            ]
        };
        assert_eq!(names(sets(), &[]), ["ball", "hammer", "my_rock_"]);
        let asked = names(sets(), &["sand", "hammer"]);
        assert_eq!(asked, ["ball", "my_rock_", "sand0", "sand1", "sand2", "hammer"]);
        let many = (0..20).map(|k| set(&format!("b{k}"), 1, None)).collect();
        assert_eq!(names(many, &["b7"]), ["b7"]);
        // Names that are taken.
        let twice = vec![set("a", 2, None), set("a0", 1, None)];
        assert_eq!(names(twice, &["a"]), ["a0", "body_a0", "a1"]);
    }
}
