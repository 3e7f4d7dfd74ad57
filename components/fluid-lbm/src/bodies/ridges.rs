//! Places where links between two cells outside a body may pass through it: sharp edges, and walls
//! thinner than a link.
//!
//! Beside a sharp edge a link is inside where it is behind both of the faces that meet there. So a
//! few products tell which links may be cut; the surface itself decides (see `cut_links`). Lengths
//! in cells, but in the surface's frame.

use crate::lattice::d3q19::{C, C_F64, Q, dot};
use std::ops::RangeInclusive;
use tremie_geometry::{EdgeKind, Frame, Surface, Vec3};

/// Faces whose normals have a larger cosine make an edge that no link is cut by far enough to
/// matter: at 14 degrees not a tenth of a cell deep.
const BLUNT: f64 = 0.97;
/// Longest link.
const LONGEST: f64 = std::f64::consts::SQRT_2;
/// Distance between places of a surface where the body's thickness is measured [cells].
const SPACING: f64 = 0.75;
/// Most places along one side of a triangle where it is asked.
const MOST_PLACES: usize = 256;
/// Triangles up to which all heights of a convex surface are looked at to see that it is thin
/// nowhere.
const FEW: usize = 2000;

/// A sharp edge, in the surface's frame [m].
#[derive(Clone, Copy, Debug)]
struct Ridge {
    ends: [[f64; 3]; 2],
    normals: [[f64; 3]; 2],
    /// Largest depth of a link behind it.
    depth: f64,
}

/// A place on the surface with the other side near behind, and the normal there [m].
#[derive(Clone, Copy, Debug)]
struct Thin {
    point: [f64; 3],
    normal: [f64; 3],
}

/// All such places of a surface.
#[derive(Clone, Debug, Default)]
pub struct Ridges {
    ridges: Vec<Ridge>,
    thin: Vec<Thin>,
}

impl Ridges {
    /// Of a surface in cells of an edge [m].
    pub fn of(surface: &Surface, cell: f64) -> Self {
        let mesh = surface.mesh();
        let mut own = Self::default();
        for t in 0..mesh.triangles.len() as u32 {
            let (kinds, others) = (surface.edge_kinds(t), surface.neighbours(t));
            let corners = mesh.corners(t as usize).map(<[f64; 3]>::from);
            for k in (0..3).filter(|&k| kinds[k] == EdgeKind::Convex && t < others[k]) {
                let normals = [t, others[k]].map(|t| surface.normal(t).into());
                let cosine = dot(normals[0], normals[1]);
                if cosine < BLUNT {
                    // Half the link times the tangent of half the angle by which the surface turns.
                    let depth = 0.5 * LONGEST * ((1.0 - cosine) / (1.0 + cosine).max(0.02)).sqrt();
                    let ends = [corners[k], corners[(k + 1) % 3]];
                    own.ridges.push(Ridge { ends, normals, depth: depth.min(LONGEST) });
                }
            }
        }
        let wide = |t: u32| surface.width_along(surface.normal(t).into()) > LONGEST * cell;
        let is_simple = mesh.triangles.len() <= FEW && is_convex(surface);
        if !is_simple || !(0..mesh.triangles.len() as u32).all(wide) {
            own.find_thin(surface, cell);
        }
        own
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.ridges.is_empty() && self.thin.is_empty()
    }

    fn find_thin(&mut self, surface: &Surface, cell: f64) {
        let mesh = surface.mesh();
        for t in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(t).map(<[f64; 3]>::from);
            let normal: [f64; 3] = surface.normal(t as u32).into();
            let along = |from: [f64; 3], to: [f64; 3]| std::array::from_fn(|k| to[k] - from[k]);
            let sides: [[f64; 3]; 2] = [along(a, b), along(a, c)];
            let longest = sides.iter().map(|s| dot(*s, *s).sqrt()).fold(0.0, f64::max);
            let places = ((longest / (SPACING * cell)).ceil() as usize).clamp(1, MOST_PLACES);
            for i in 0..places {
                for j in 0..places - i {
                    let part = |k: usize| (k as f64 + 1.0 / 3.0) / places as f64;
                    let point: [f64; 3] = std::array::from_fn(|k| {
                        a[k] + part(i) * sides[0][k] + part(j) * sides[1][k]
                    });
                    let behind = |by: f64| Vec3::from_fn(|k, _| point[k] - by * cell * normal[k]);
                    if surface.first_crossing(behind(1e-6), behind(LONGEST)).is_some() {
                        self.thin.push(Thin { point, normal });
                    }
                }
            }
        }
    }

    /// Calls `visit` with begin and direction of links that begin in the layers `layers` and may be
    /// cut, some more than once; of the two ways along a link one.
    pub fn each_link(
        &self,
        frame: &Frame,
        cell: f64,
        layers: RangeInclusive<i32>,
        skip: impl Fn([i32; 3]) -> bool,
        mut visit: impl FnMut([i32; 3], usize),
    ) {
        // Centres of cells have whole coordinates.
        let place = |x: [f64; 3]| frame.to_world(x).map(|x| x / cell - 0.5).into();
        for ridge in &self.ridges {
            let ends = ridge.ends.map(place);
            let normals = ridge.normals.map(|normal| frame.turn_to_world(normal).into());
            links_at_ridge(ends, normals, ridge.depth, &layers, &skip, &mut visit);
        }
        for thin in &self.thin {
            links_at(
                place(thin.point),
                frame.turn_to_world(thin.normal).into(),
                &layers,
                &skip,
                &mut visit,
            );
        }
    }
}

fn is_convex(surface: &Surface) -> bool {
    let all = 0..surface.mesh().triangles.len() as u32;
    all.into_iter().all(|t| !surface.edge_kinds(t).contains(&EdgeKind::Concave))
}

fn links_at_ridge(
    [a, b]: [[f64; 3]; 2],
    normals: [[f64; 3]; 2],
    depth: f64,
    layers: &RangeInclusive<i32>,
    skip: &impl Fn([i32; 3]) -> bool,
    visit: &mut impl FnMut([i32; 3], usize),
) {
    let along: [f64; 3] = std::array::from_fn(|k| b[k] - a[k]);
    // Along the axis in which the edge is longest, its other coordinates change by at most 1 a
    // layer: the ranges below stay small.
    let axis = (1..3).fold(0, |m, k| if along[k].abs() > along[m].abs() { k } else { m });
    if along[axis] == 0.0 {
        return;
    }
    let (low, high) = if along[axis] > 0.0 { (a[axis], b[axis]) } else { (b[axis], a[axis]) };
    let slope = along.map(|x| x / along[axis]);
    let reach = 1.0 + depth;
    for k in (low - reach).ceil() as i32..=(high + reach).floor() as i32 {
        let on = f64::from(k).clamp(low, high) - a[axis];
        let range: [RangeInclusive<i32>; 3] = std::array::from_fn(|j| {
            if j == axis {
                return k..=k;
            }
            let (middle, wide) = (a[j] + slope[j] * on, reach + slope[j].abs());
            (middle - wide).ceil() as i32..=(middle + wide).floor() as i32
        });
        let [xs, ys, zs] = range;
        for z in *zs.start().max(layers.start())..=*zs.end().min(layers.end()) {
            for y in ys.clone() {
                for x in xs.clone() {
                    links_behind([x, y, z], a, normals, skip, visit);
                }
            }
        }
    }
}

/// The links of a cell that are behind both faces somewhere on their way.
fn links_behind(
    at: [i32; 3],
    on: [f64; 3],
    normals: [[f64; 3]; 2],
    skip: &impl Fn([i32; 3]) -> bool,
    visit: &mut impl FnMut([i32; 3], usize),
) {
    let way: [f64; 3] = std::array::from_fn(|k| f64::from(at[k]) - on[k]);
    let heights = normals.map(|normal| dot(way, normal));
    if heights[0].max(heights[1]) > LONGEST || heights[0].max(heights[1]) < 0.0 || skip(at) {
        return;
    }
    for i in 1..=Q / 2 {
        let (mut enters, mut leaves) = (0.0_f64, 1.0_f64);
        for (height, normal) in heights.into_iter().zip(normals) {
            let rise = dot(C_F64[i], normal);
            if rise < 0.0 {
                enters = enters.max(-height / rise);
            } else if rise > 0.0 {
                leaves = leaves.min(-height / rise);
            } else if height > 0.0 {
                leaves = -1.0;
            }
        }
        if enters < leaves {
            visit(at, i);
        }
    }
}

/// The links that pass through a face near a place on it.
fn links_at(
    on: [f64; 3],
    normal: [f64; 3],
    layers: &RangeInclusive<i32>,
    skip: &impl Fn([i32; 3]) -> bool,
    visit: &mut impl FnMut([i32; 3], usize),
) {
    let reach = 1.0 + SPACING;
    let [xs, ys, zs] = on.map(|x| (x - reach).ceil() as i32..=(x + reach).floor() as i32);
    for z in *zs.start().max(layers.start())..=*zs.end().min(layers.end()) {
        for y in ys.clone() {
            for x in xs.clone() {
                let at = [x, y, z];
                if skip(at) {
                    continue;
                }
                let way: [f64; 3] = std::array::from_fn(|k| f64::from(at[k]) - on[k]);
                let height = dot(way, normal);
                for i in (1..=Q / 2).filter(|&i| C[i] != [0; 3]) {
                    let end = height + dot(C_F64[i], normal);
                    if (height >= 0.0) != (end >= 0.0) {
                        visit(at, i);
                    }
                }
            }
        }
    }
}
