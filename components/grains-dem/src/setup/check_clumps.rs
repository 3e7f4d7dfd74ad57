//! Checks of clumps.

use crate::solver::clumps::{Clumps, Misfit};
use crate::solver::placement;
use serde::Serialize;
use tremie_geometry::{ClumpPiece, clump};
use tremie_grains_kit::checks::numbers::AXES;
use tremie_messages::{
    Problem,
    scene::{BodySet, Motion, Placement, PolyhedronPlacement, Scene},
};

/// The clumps of a scene.
pub(crate) fn clumps(scene: &Scene, problems: &mut Vec<Problem>) {
    let named = scene.bodies.iter().enumerate();
    let named = named.filter_map(|(i, set)| Some((i, set, set.clump.as_deref()?)));
    for (i, set, name) in named {
        let key = format!("scene.bodies[{i}].clump");
        if let Some((message, help)) = fault(scene, set, name) {
            problems.push(Problem::new(key, message).help(help));
        }
    }
    for (i, name) in scene.unions.iter().enumerate() {
        if !scene.bodies.iter().any(|set| set.clump.as_deref() == Some(name)) {
            let message = format!("is \"{name}\", but no set of bodies is in a clump of this name");
            problems.push(Problem::new(format!("scene.unions[{i}]"), message));
        }
    }
    let name = scene.bodies.iter().find_map(|set| set.clump.as_deref());
    if let (Some(name), Some(outlet)) = (name, scene.outlets.first()) {
        let message = format!(
            "is \"{}\", but there is the clump \"{name}\", and clumps do not come and go",
            outlet.name
        );
        let help = "leave out the outlet, or let its bodies move one by one";
        problems.push(Problem::new("scene.outlets[0].name", message).help(help));
    }
}

/// Places and velocities of the bodies of clumps, in a scene whose bodies are right.
pub(crate) fn wholes(scene: &Scene, problems: &mut Vec<Problem>) {
    let placed = placement::listed(scene);
    let size = scene.domain.size();
    for clump in Clumps::of_placed(scene, &placed).all() {
        let of = |rank: u32| {
            let set = placed[rank as usize].set;
            let name = scene.bodies[set].clump.as_deref().unwrap_or_default();
            (format!("scene.bodies[{set}].clump"), name)
        };
        let axes = (0..3).filter(|&axis| scene.domain.is_periodic(axis));
        for axis in axes.filter(|&axis| clump.extent(axis) > 0.5 * size[axis]) {
            let (key, name) = of(clump.first());
            let message = format!(
                "is \"{name}\", which reaches over {:.3e} m in {}, more than half of the domain, which wraps around \
                 there",
                clump.extent(axis),
                AXES[axis]
            );
            let help = "place the clump so that it lies across none of the faces that wrap around, or enlarge the domain";
            problems.push(Problem::new(key, message).help(help));
        }
        let Misfit { rank, expected, apart, scale } = clump.misfit(&placed);
        if apart > RIGID * scale {
            let (key, name) = of(rank);
            let [x, y, z]: [f64; 3] = expected.into();
            let message = format!(
                "is \"{name}\", but the velocities of its bodies are not those of a rigid motion: body {rank} differs by \
                 {apart:.3e} m/s"
            );
            let help = format!(
                "with the momenta of its bodies the clump gives this body ({x:.6e}, {y:.6e}, {z:.6e}) m/s: give each its \
                 velocity, that of the centroid and w x r"
            );
            problems.push(Problem::new(key, message).help(help));
        }
    }
}

/// Excess of the pieces of clumps over their unions: overlap that counts more than once.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClumpOverlap {
    /// Name of the clump that it is most of.
    pub clump: String,
    /// Volume of its pieces over that of their union, less one.
    pub excess: f64,
    /// True if its mass is that of the union.
    pub united: bool,
    /// Number of clumps with pieces that overlap.
    pub count: usize,
    /// Number of clumps examined.
    pub of: usize,
}

/// Clumps that are looked at: where there are more, the others are like them.
const LOOKED_AT: usize = 200;

/// Pieces that overlap by less than this part of the union touch.
const TOUCHING: f64 = 1e-3;

/// Overlap of the clump whose pieces overlap most, those whose overlaps count twice before the
/// others.
pub(crate) fn overlap(scene: &Scene) -> Option<ClumpOverlap> {
    let mut names: Vec<&str> = Vec::new();
    for name in scene.bodies.iter().filter_map(|set| set.clump.as_deref()) {
        if !names.contains(&name) && names.len() < LOOKED_AT {
            names.push(name);
        }
    }
    let of = |name: &&str| {
        let pieces = clump(scene, name);
        let sum = |of: fn(&ClumpPiece) -> f64| pieces.iter().map(of).sum::<f64>();
        let excess = sum(|piece| piece.volume) / sum(|piece| piece.share.volume) - 1.0;
        (name.to_string(), excess, scene.unions.iter().any(|united| united == name))
    };
    let all: Vec<_> = names.iter().map(of).filter(|(_, excess, _)| *excess > TOUCHING).collect();
    let worst = all.iter().max_by(|a, b| b.2.cmp(&a.2).then(a.1.total_cmp(&b.1)))?;
    let (clump, excess, united) = worst.clone();
    Some(ClumpOverlap { clump, excess, united, count: all.len(), of: names.len() })
}

/// Velocities that differ by less than this part are those of a rigid motion, but for rounding.
const RIGID: f64 = 1e-6;

fn fault(scene: &Scene, set: &BodySet, name: &str) -> Option<(String, &'static str)> {
    if name.is_empty() {
        return Some(("is empty, expected a name".into(), "name it, or leave it out"));
    }
    if set.motion != Motion::Free {
        let message =
            format!("is \"{name}\", but these bodies are not free: their motion is given already");
        return Some((
            message,
            "leave it out: bodies of one motion keep their places to each other",
        ));
    }
    let packed = match &set.placement {
        Placement::Listed(_) => false,
        Placement::Packed(_) => true,
        Placement::Polyhedra(own) => matches!(own.placement, PolyhedronPlacement::Packed(_)),
    };
    if packed {
        let message = format!("is \"{name}\", but these bodies are packed at random");
        return Some((message, "list the bodies that are joined, each where it is"));
    }
    if let Some(inlet) = scene.inlets.iter().find(|inlet| inlet.bodies == set.name) {
        let message =
            format!("is \"{name}\", but the inlet \"{}\" feeds bodies of this set", inlet.name);
        return Some((message, "give the inlet a set of its own"));
    }
    None
}
