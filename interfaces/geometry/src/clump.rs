//! The pieces of a scene's clumps, with what each has of their union.

use crate::{Convex, Piece, Share, Vec3, shares};
use std::collections::BTreeMap;
use std::sync::Mutex;
use tremie_messages::scene::{Placement, PolyhedronPlacement, Scene};

/// A body of a clump.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClumpPiece {
    /// Index of its set in the scene, and its own in the set's list.
    pub set: usize,
    /// See `set`.
    pub index: usize,
    /// Its whole volume [m³].
    pub volume: f64,
    /// Its share of the clump's union; the centroid as seen from the body's centre.
    pub share: Share,
}

/// A body as it is listed.
struct Listed {
    set: usize,
    index: usize,
    centre: Vec3,
    /// Diameter of a sphere, or of one as large as the polyhedron [m].
    diameter: f64,
    /// Orientation, and number of the shape in the scene.
    solid: Option<([f64; 4], usize)>,
}

/// The bodies of a clump, in the order of the scene; those of shapes that are none are left out.
pub fn clump(scene: &Scene, name: &str) -> Vec<ClumpPiece> {
    let listed = listed(scene, name);
    let Some(first) = listed.first().map(|body| body.centre) else { return Vec::new() };
    let mut shapes = BTreeMap::new();
    let mut placed = Vec::with_capacity(listed.len());
    for body in listed {
        let at = body.centre - first;
        let piece = match body.solid {
            None => Some(Piece::ball(at, 0.5 * body.diameter)),
            Some((q, shape)) => {
                let unit =
                    |shape: usize| Some(Convex::hull(&scene.shapes[shape].vertices).ok()?.unit());
                let convex = shapes.entry(shape).or_insert_with(|| unit(shape));
                convex.as_ref().map(|convex| Piece::solid(convex, body.diameter, axes(q), at))
            }
        };
        placed.extend(piece.map(|piece| (body, at, piece)));
    }
    let pieces: Vec<Piece> = placed.iter().map(|(.., piece)| piece.clone()).collect();
    let shares = known(&pieces);
    let of = |((body, at, piece), mut share): ((Listed, Vec3, Piece), Share)| {
        share.centroid -= at;
        ClumpPiece { set: body.set, index: body.index, volume: piece.volume(), share }
    };
    placed.into_iter().zip(shares).map(of).collect()
}

/// The shares of pieces, which are asked for again and again while a scene is looked at.
fn known(pieces: &[Piece]) -> Vec<Share> {
    static KNOWN: Mutex<BTreeMap<Vec<u64>, Vec<Share>>> = Mutex::new(BTreeMap::new());
    const MOST: usize = 100_000;
    let key: Vec<u64> = pieces.iter().flat_map(Piece::bits).collect();
    let lock = || KNOWN.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    if let Some(found) = lock().get(&key) {
        return found.clone();
    }
    let found = shares(pieces);
    let mut known = lock();
    if known.len() >= MOST {
        known.clear();
    }
    known.insert(key, found.clone());
    found
}

fn listed(scene: &Scene, name: &str) -> Vec<Listed> {
    let sets = scene.bodies.iter().enumerate();
    let sets = sets.filter(|(_, set)| set.clump.as_deref() == Some(name));
    let of_set = |(set, own): (usize, &tremie_messages::scene::BodySet)| match &own.placement {
        Placement::Listed(list) => list
            .iter()
            .enumerate()
            .map(|(index, sphere)| Listed {
                set,
                index,
                centre: sphere.position.into(),
                diameter: sphere.diameter,
                solid: None,
            })
            .collect(),
        Placement::Polyhedra(own) => {
            let shape = scene.shapes.iter().position(|shape| shape.name == own.shape);
            let (Some(shape), PolyhedronPlacement::Listed(list)) = (shape, &own.placement) else {
                return Vec::new();
            };
            list.iter()
                .enumerate()
                .map(|(index, body)| Listed {
                    set,
                    index,
                    centre: body.position.into(),
                    diameter: body.diameter,
                    solid: Some((body.orientation, shape)),
                })
                .collect()
        }
        Placement::Packed(_) => Vec::new(),
    };
    sets.flat_map(of_set).collect()
}

/// Images of the axes under the rotation of a unit quaternion.
fn axes([x, y, z, w]: [f64; 4]) -> [Vec3; 3] {
    [
        Vec3::new(1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)),
        Vec3::new(2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)),
        Vec3::new(2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)),
    ]
}
