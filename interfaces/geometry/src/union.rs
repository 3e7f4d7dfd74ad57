//! The union of convex pieces that overlap: the volume, centroid and inertia of their union, shared
//! among them.
//!
//! At a place where n pieces lie over each other, each has a share of 1/n: so that the shares add
//! up to the union, whatever the order of the pieces. Spheres of which no three overlap have shares
//! in closed form, by the caps of their lenses. All others are integrated along rays, on which a
//! convex piece is one interval, so that what lies along a ray is exact too; across the rays
//! squares are divided where their error is largest (Gauss's rule of 3 x 3 points, against that of
//! the four quarters) until the sum of all errors is below a bound; the union is then right to
//! [`TOLERANCE`].

use crate::{Convex, ConvexFace, Vec3};
use core::f64::consts::PI;
use nalgebra::Matrix3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Error of the union over the volume of all pieces; what is found is mostly better.
pub const TOLERANCE: f64 = 2e-5;

/// The estimate of the error at which integration ends, over the same: estimates miss what no ray
/// has met.
const ESTIMATE: f64 = 4e-6;

/// Squares after which integration ends in any case.
const MOST_SQUARES: usize = 200_000;

/// Squares across the rays to begin with, along each axis.
const FIRST: u32 = 12;

/// A convex piece.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    form: Form,
    /// All of it, about the origin.
    whole: Sums,
    /// Its own centre, and the radius about that which holds it [m].
    centre: Vec3,
    reach: f64,
}

#[derive(Clone, Debug, PartialEq)]
enum Form {
    Ball,
    /// Outward normals and offsets of its faces.
    Solid(Vec<(Vec3, f64)>),
}

/// The part of a union that is a piece's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// Volume [m³].
    pub volume: f64,
    /// Centre of that volume [m].
    pub centroid: Vec3,
    /// Inertia about it for a density of one [m⁵].
    pub inertia: Matrix3<f64>,
}

/// Integrals of 1, x and x x^T over a volume.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Sums {
    volume: f64,
    first: Vec3,
    /// Of xx, yy, zz, yz, zx, xy.
    second: [f64; 6],
}

/// The two axes of each entry of [`Sums::second`].
const PAIRS: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [1, 2], [2, 0], [0, 1]];

impl Piece {
    /// A sphere.
    pub fn ball(centre: Vec3, radius: f64) -> Self {
        let volume = 4.0 / 3.0 * PI * radius * radius * radius;
        let own = 0.2 * volume * radius * radius;
        let whole = Sums::of(volume, centre, [own, own, own, 0.0, 0.0, 0.0]);
        Self { form: Form::Ball, whole, centre, reach: radius }
    }

    /// A polyhedron, `size` times as large as it is in its own frame, whose axes are `axes` and
    /// whose origin is `centre`.
    pub fn solid(convex: &Convex, size: f64, axes: [Vec3; 3], centre: Vec3) -> Self {
        let turned = |v: Vec3| (0..3).fold(Vec3::zeros(), |sum, a| sum + axes[a] * v[a]);
        let placed = |v: &Vec3| centre + (turned(*v) * size);
        let mut mesh = convex.mesh();
        mesh.vertices.iter_mut().for_each(|v| *v = placed(v));
        let moments = mesh.moments();
        let trace = 0.5 * moments.inertia.trace();
        let own = PAIRS.map(|[a, b]| {
            if a == b { trace - moments.inertia[(a, a)] } else { -moments.inertia[(a, b)] }
        });
        let middle = moments.centroid;
        let reach = mesh.vertices.iter().map(|&v| (v - middle).norm()).fold(0.0, f64::max);
        let face = |face: &ConvexFace| {
            let normal = turned(face.normal);
            (normal, face.offset * size + normal.dot(&centre))
        };
        let faces = convex.faces().iter().map(face).collect();
        let whole = Sums::of(moments.volume, middle, own);
        Self { form: Form::Solid(faces), whole, centre: middle, reach }
    }

    /// Bits that tell it from others.
    pub(crate) fn bits(&self) -> impl Iterator<Item = u64> + '_ {
        let faces = match &self.form {
            Form::Ball => &[][..],
            Form::Solid(faces) => faces,
        };
        let planes =
            faces.iter().flat_map(|(normal, offset)| [normal[0], normal[1], normal[2], *offset]);
        let own = self.centre.iter().copied().chain([self.reach, faces.len() as f64]);
        own.chain(planes).map(f64::to_bits)
    }

    /// Its own volume [m³].
    pub fn volume(&self) -> f64 {
        self.whole.volume
    }

    fn is_ball(&self) -> bool {
        self.form == Form::Ball
    }

    /// The part of a ray from a point along a unit vector that is inside, as distances from the
    /// point.
    fn along(&self, from: Vec3, way: Vec3) -> Option<[f64; 2]> {
        let ends = match &self.form {
            Form::Ball => {
                let d = self.centre - from;
                let middle = d.dot(&way);
                let off = d - (way * middle);
                let half = (self.reach * self.reach - off.dot(&off)).max(0.0).sqrt();
                [middle - half, middle + half]
            }
            Form::Solid(faces) => {
                let mut ends = [f64::NEG_INFINITY, f64::INFINITY];
                for (normal, offset) in faces {
                    let (speed, room) = (normal.dot(&way), offset - normal.dot(&from));
                    if speed > 0.0 {
                        ends[1] = ends[1].min(room / speed);
                    } else if speed < 0.0 {
                        ends[0] = ends[0].max(room / speed);
                    } else if room < 0.0 {
                        return None;
                    }
                }
                ends
            }
        };
        (ends[0] < ends[1]).then_some(ends)
    }
}

impl Sums {
    /// Of a volume with its centre, and the integrals about that.
    fn of(volume: f64, centre: Vec3, own: [f64; 6]) -> Self {
        let second =
            std::array::from_fn(|k| own[k] + volume * centre[PAIRS[k][0]] * centre[PAIRS[k][1]]);
        Self { volume, first: (centre * volume), second }
    }

    fn add(&mut self, other: &Self, factor: f64) {
        self.volume += factor * other.volume;
        self.first += other.first * factor;
        for (sum, more) in self.second.iter_mut().zip(other.second) {
            *sum += factor * more;
        }
    }

    fn share(&self) -> Share {
        let centroid = self.first * (1.0 / self.volume);
        let mut central = Matrix3::zeros();
        for (k, [a, b]) in PAIRS.into_iter().enumerate() {
            central[(a, b)] = self.second[k] - self.volume * centroid[a] * centroid[b];
            central[(b, a)] = central[(a, b)];
        }
        let trace = central.trace();
        let inertia =
            Matrix3::from_fn(
                |a, b| {
                    if a == b { trace - central[(a, a)] } else { -central[(a, b)] }
                },
            );
        Share { volume: self.volume, centroid, inertia }
    }
}

/// The shares of pieces in their union, in their order. Places should lie near the origin, as seen
/// from the sizes of the pieces.
pub fn shares(pieces: &[Piece]) -> Vec<Share> {
    let mut sums: Vec<Sums> = pieces.iter().map(|piece| piece.whole).collect();
    let pairs = near_pairs(pieces);
    for group in groups(pieces.len(), &pairs) {
        let own: Vec<[usize; 2]> =
            pairs.iter().copied().filter(|[i, _]| group.contains(i)).collect();
        if own.iter().flatten().all(|&i| pieces[i].is_ball()) && !has_triple(pieces, &own) {
            for [i, j] in own {
                let lens = lens(&pieces[i], &pieces[j]);
                sums[i].add(&lens, -0.5);
                sums[j].add(&lens, -0.5);
            }
        } else {
            integrate(pieces, &group, &own, &mut sums);
        }
    }
    // A piece that hides in others keeps a share, however rough the integration was.
    for (sum, piece) in sums.iter_mut().zip(pieces) {
        if sum.volume < LEAST * piece.whole.volume {
            let mut own = Sums::default();
            own.add(&piece.whole, LEAST);
            *sum = own;
        }
    }
    sums.iter().map(Sums::share).collect()
}

/// The smallest share, over the piece's volume.
const LEAST: f64 = 1e-6;

/// Pairs of pieces that may overlap: spheres that do, and others whose spheres around them do.
fn near_pairs(pieces: &[Piece]) -> Vec<[usize; 2]> {
    let mut pairs = Vec::new();
    for i in 0..pieces.len() {
        for j in i + 1..pieces.len() {
            let (a, b) = (&pieces[i], &pieces[j]);
            if (a.centre - b.centre).norm() < a.reach + b.reach {
                pairs.push([i, j]);
            }
        }
    }
    pairs
}

/// Pieces that hang together, each group in ascending order; pieces that overlap none are in none.
fn groups(count: usize, pairs: &[[usize; 2]]) -> Vec<Vec<usize>> {
    let mut of: Vec<usize> = (0..count).collect();
    // The least number in a group spreads; as many rounds as the group is long.
    loop {
        let mut changed = false;
        for &[i, j] in pairs {
            let least = of[i].min(of[j]);
            changed |= of[i] != least || of[j] != least;
            (of[i], of[j]) = (least, least);
        }
        if !changed {
            break;
        }
    }
    let members = |first: usize| (0..count).filter(|&i| of[i] == first).collect::<Vec<_>>();
    (0..count).filter(|&i| of[i] == i).map(members).filter(|group| group.len() > 1).collect()
}

/// True if any three spheres may have a point in common.
fn has_triple(pieces: &[Piece], pairs: &[[usize; 2]]) -> bool {
    let touch = |i: usize, j: usize| pairs.contains(&[i.min(j), i.max(j)]);
    pairs
        .iter()
        .any(|&[i, j]| (0..pieces.len()).any(|k| k != i && k != j && touch(i, k) && touch(j, k)))
}

/// The intersection of two spheres: a cap of each, or the smaller one.
fn lens(a: &Piece, b: &Piece) -> Sums {
    let way = b.centre - a.centre;
    let d = way.norm();
    if d <= (a.reach - b.reach).abs() {
        return if a.reach < b.reach { a.whole } else { b.whole };
    }
    let axis = way * (1.0 / d);
    let plane = 0.5 * (d + (a.reach - b.reach) * (a.reach + b.reach) / d);
    let mut sums = cap(a, axis, plane);
    sums.add(&cap(b, axis * -1.0, d - plane), 1.0);
    sums
}

/// The part of a sphere beyond a plane across a unit vector, at a distance from its centre.
fn cap(ball: &Piece, axis: Vec3, at: f64) -> Sums {
    let (r, c) = (ball.reach, at);
    // Of discs of area pi (r^2 - s^2), from c to r.
    let (r2, h) = (r * r, r - c);
    let volume = PI / 3.0 * h * h * (3.0 * r - h);
    let first = 0.25 * PI * (r2 - c * c) * (r2 - c * c);
    let powers = |n: i32| r.powi(n) - c.powi(n);
    let along = PI * (r2 * powers(3) / 3.0 - powers(5) / 5.0);
    // A disc of radius q has pi q^4/4 across.
    let across = 0.25 * PI * (r2 * r2 * h - 2.0 * r2 * powers(3) / 3.0 + powers(5) / 5.0);
    let about = |k: usize| {
        let [a, b] = PAIRS[k];
        let own = if a == b { across } else { 0.0 };
        own + (along - across) * axis[a] * axis[b]
    };
    // About the sphere's centre, and then about the origin.
    let moved = axis * first;
    let second = std::array::from_fn(|k| {
        let [a, b] = PAIRS[k];
        let x = ball.centre;
        about(k) + x[a] * moved[b] + x[b] * moved[a] + volume * x[a] * x[b]
    });
    Sums { volume, first: (moved + (ball.centre * volume)), second }
}

/// A square across the rays: what its four quarters give, of each piece of a group.
struct Square {
    /// Lower corner, and edges.
    at: [f64; 2],
    size: [f64; 2],
    quarters: [Vec<Sums>; 4],
    error: f64,
    /// Its number among those that have been made.
    number: usize,
}

impl PartialEq for Square {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Square {}

impl PartialOrd for Square {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Square {
    fn cmp(&self, other: &Self) -> Ordering {
        self.error.total_cmp(&other.error).then(other.number.cmp(&self.number))
    }
}

/// Axes of the rays: across, across and along; along none that geometry is likely to have, so that
/// no face of a polyhedron lies along them.
fn axes() -> [Vec3; 3] {
    let unit = |v: Vec3| v * (1.0 / v.norm());
    let along = unit(Vec3::new(0.267_949, 0.414_214, 0.869_967));
    let one = unit(along.cross(&Vec3::from([0.908_1, -0.331_7, 0.254_9])));
    [one, along.cross(&one), along]
}

/// Takes from the pieces of a group what they share with others.
fn integrate(pieces: &[Piece], group: &[usize], pairs: &[[usize; 2]], sums: &mut [Sums]) {
    let rays = Rays::new(pieces, group, pairs);
    let all: f64 = group.iter().map(|&i| pieces[i].volume()).sum();
    let mut heap = BinaryHeap::new();
    let mut error = 0.0;
    let edges = rays.size.map(|edge| edge / f64::from(FIRST));
    for k in 0..FIRST * FIRST {
        let cell = [k % FIRST, k / FIRST];
        let at = std::array::from_fn(|a| rays.low[a] + edges[a] * f64::from(cell[a]));
        let square = rays.square(at, edges, &rays.gauss(at, edges), heap.len());
        error += square.error;
        heap.push(square);
    }
    let mut made = heap.len();
    while error > ESTIMATE * all && made < MOST_SQUARES {
        let Some(Square { at, size, quarters, error: known, .. }) = heap.pop() else { break };
        error -= known;
        let half = size.map(|edge| 0.5 * edge);
        for (k, whole) in quarters.iter().enumerate() {
            let at = [at[0] + half[0] * (k % 2) as f64, at[1] + half[1] * (k / 2) as f64];
            let square = rays.square(at, half, whole, made);
            made += 1;
            error += square.error;
            heap.push(square);
        }
    }
    // In the order in which they were made: that of a heap is nobody's business.
    let mut squares = heap.into_vec();
    squares.sort_by_key(|square| square.number);
    for quarter in squares.iter().flat_map(|square| &square.quarters) {
        for (&piece, part) in group.iter().zip(quarter) {
            sums[piece].add(part, -1.0);
        }
    }
}

/// Parallel rays through the places where pieces of a group overlap.
struct Rays<'a> {
    pieces: Vec<&'a Piece>,
    axes: [Vec3; 3],
    /// Lower corner and edges of the rectangle across them.
    low: [f64; 2],
    size: [f64; 2],
}

/// Points and weights of Gauss's rule between 0 and 1.
const GAUSS: [(f64, f64); 3] = [
    (0.112_701_665_379_258_3, 5.0 / 18.0),
    (0.5, 4.0 / 9.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

impl<'a> Rays<'a> {
    fn new(pieces: &'a [Piece], group: &[usize], pairs: &[[usize; 2]]) -> Self {
        let axes = axes();
        let extent = |i: usize, a: usize| {
            let middle = pieces[i].centre.dot(&axes[a]);
            [middle - pieces[i].reach, middle + pieces[i].reach]
        };
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for &[i, j] in pairs {
            for a in 0..2 {
                let ([b, c], [d, e]) = (extent(i, a), extent(j, a));
                (low[a], high[a]) = (low[a].min(b.max(d)), high[a].max(c.min(e)));
            }
        }
        let size = std::array::from_fn(|a| high[a] - low[a]);
        Self { pieces: group.iter().map(|&i| &pieces[i]).collect(), axes, low, size }
    }

    fn square(&self, at: [f64; 2], size: [f64; 2], whole: &[Sums], number: usize) -> Square {
        let half = size.map(|edge| 0.5 * edge);
        let quarters = std::array::from_fn(|k| {
            self.gauss([at[0] + half[0] * (k % 2) as f64, at[1] + half[1] * (k / 2) as f64], half)
        });
        let of =
            |k: usize| quarters.iter().map(|quarter: &Vec<Sums>| quarter[k].volume).sum::<f64>();
        let error = whole.iter().enumerate().map(|(k, whole)| (of(k) - whole.volume).abs()).sum();
        Square { at, size, quarters, error, number }
    }

    /// Sums that pieces share with others in a square.
    fn gauss(&self, at: [f64; 2], size: [f64; 2]) -> Vec<Sums> {
        let mut sums = vec![Sums::default(); self.pieces.len()];
        let (mut spans, mut ends) = (Vec::new(), Vec::new());
        for (x, weight_x) in GAUSS {
            for (y, weight_y) in GAUSS {
                let across = [at[0] + x * size[0], at[1] + y * size[1]];
                let weight = weight_x * weight_y * size[0] * size[1];
                self.ray(across, weight, &mut sums, (&mut spans, &mut ends));
            }
        }
        sums
    }

    /// Adds what pieces share with others on a ray: `1 - 1/n` of each where n of them are.
    fn ray(
        &self,
        across: [f64; 2],
        weight: f64,
        sums: &mut [Sums],
        (spans, ends): (&mut Vec<(usize, [f64; 2])>, &mut Vec<f64>),
    ) {
        let from = (self.axes[0] * across[0]) + (self.axes[1] * across[1]);
        spans.clear();
        for (k, piece) in self.pieces.iter().enumerate() {
            spans.extend(piece.along(from, self.axes[2]).map(|span| (k, span)));
        }
        if spans.len() < 2 {
            return;
        }
        ends.clear();
        ends.extend(spans.iter().flat_map(|(_, span)| *span));
        ends.sort_by(f64::total_cmp);
        for pair in ends.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            let is_over = |(_, span): &&(usize, [f64; 2])| span[0] <= a && span[1] >= b;
            let count = if a < b { spans.iter().filter(is_over).count() } else { 0 };
            if count < 2 {
                continue;
            }
            let part = weight * (1.0 - 1.0 / count as f64);
            let piece = self.segment(from, [a, b], part);
            for (k, _) in spans.iter().filter(is_over) {
                sums[*k].add(&piece, 1.0);
            }
        }
    }

    /// Integrals along a piece of a ray, times a weight.
    fn segment(&self, from: Vec3, [a, b]: [f64; 2], weight: f64) -> Sums {
        let way = self.axes[2];
        let length = b - a;
        let middle = from + (way * (0.5 * (a + b)));
        let own = PAIRS.map(|[i, j]| way[i] * way[j] * length * length * length / 12.0 * weight);
        Sums::of(length * weight, middle, own)
    }
}
