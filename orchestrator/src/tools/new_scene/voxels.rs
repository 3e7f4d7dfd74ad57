//! A part's box in voxels, and distances in it.

use super::domain_face::DomainFace;
use tremie_geometry::{Bounds, Row, RowScratch, Surface, Vec3};

/// Voxels of a box, about.
const VOXELS: f64 = 4e5;

/// A box in voxels, with a layer of them around it.
pub struct Voxels {
    /// Centre of the first [m].
    pub first: Vec3,
    /// Edges [m].
    pub edges: Vec3,
    /// Number along each axis.
    pub count: [usize; 3],
    /// Which are solid.
    pub solid: Vec<bool>,
}

impl Voxels {
    /// A box of a part. What [`Surface::contains`] is solid.
    pub fn of(surface: &Surface, bounds: &Bounds) -> Self {
        let size = bounds.size();
        let edge = (size.product() / VOXELS).cbrt();
        let inner: [usize; 3] =
            std::array::from_fn(|k| ((size[k] / edge).ceil() as usize).clamp(4, 4000));
        let edges = Vec3::from_fn(|k, _| size[k] / inner[k] as f64);
        let first = bounds.min - edges * 0.5;
        let count = inner.map(|count| count + 2);
        let mut voxels = Self { first, edges, count, solid: vec![false; count.iter().product()] };
        let mut scratch = RowScratch::default();
        let step = Vec3::new(edges[0], 0.0, 0.0);
        for row in 0..count[1] * count[2] {
            let start = voxels.centre(row * count[0]);
            let row = row * count[0]..(row + 1) * count[0];
            surface.fill_row(&Row { start, step }, &mut voxels.solid[row], &mut scratch);
        }
        voxels
    }

    /// Places along the axes of voxel `i`.
    fn place(&self, i: usize) -> [usize; 3] {
        let [x, y, _] = self.count;
        [i % x, i / x % y, i / (x * y)]
    }

    /// Its middle [m].
    pub fn centre(&self, i: usize) -> Vec3 {
        let place = self.place(i);
        Vec3::from_fn(|k, _| self.first[k] + place[k] as f64 * self.edges[k])
    }

    /// True if a voxel lies in the layer beyond a face.
    pub fn is_beyond(&self, i: usize, face: DomainFace) -> bool {
        let (k, place) = (face.axis(), self.place(i));
        place[k] == if face.is_upper() { self.count[k] - 1 } else { 0 }
    }

    /// True if a voxel is the first within a face.
    pub fn is_at(&self, i: usize, face: DomainFace) -> bool {
        let (k, place) = (face.axis(), self.place(i));
        place[k] == if face.is_upper() { self.count[k] - 2 } else { 1 }
    }

    /// True if a voxel lies outside the box.
    pub fn is_outside(&self, i: usize) -> bool {
        let place = self.place(i);
        (0..3).any(|k| place[k] == 0 || place[k] + 1 == self.count[k])
    }

    /// Neighbours of a voxel that are not solid.
    pub fn neighbours(&self, i: usize) -> impl Iterator<Item = usize> {
        let [x, y, _] = self.count;
        let (strides, place) = ([1, x, x * y], self.place(i));
        (0..3).flat_map(move |k| {
            let below = (place[k] > 0).then(|| i - strides[k]);
            let above = (place[k] + 1 < self.count[k]).then(|| i + strides[k]);
            below.into_iter().chain(above).filter(|&other| !self.solid[other])
        })
    }
}

/// Squares of the distances from the nearest places at which `of` is zero, on a grid of places.
///
/// One axis after the other, by the lower envelope of parabolas (Felzenszwalb and Huttenlocher, *Theory of
/// Computing* 8 (2012) 415).
pub fn squared_distances(mut of: Vec<f64>, count: [usize; 3], edges: Vec3) -> Vec<f64> {
    let strides = [1, count[0], count[0] * count[1]];
    let (mut line, mut envelope) = (Vec::new(), Vec::new());
    for k in 0..3 {
        let (stride, length) = (strides[k], count[k]);
        for begin in (0..of.len()).filter(|i| (i / stride).is_multiple_of(length)) {
            line.clear();
            line.extend((0..length).map(|i| of[begin + i * stride]));
            lower_envelope(&line, edges[k], &mut envelope);
            let mut at = 0;
            for i in 0..length {
                let x = i as f64 * edges[k];
                while envelope.get(at + 1).is_some_and(|(_, from)| *from < x) {
                    at += 1;
                }
                if let Some(&(lowest, _)) = envelope.get(at) {
                    let away = x - lowest as f64 * edges[k];
                    of[begin + i * stride] = line[lowest] + away * away;
                }
            }
        }
    }
    of
}

/// The parabolas that are lowest somewhere, each with where it begins to be.
fn lower_envelope(line: &[f64], edge: f64, envelope: &mut Vec<(usize, f64)>) {
    envelope.clear();
    for i in (0..line.len()).filter(|i| line[*i].is_finite()) {
        let x = i as f64 * edge;
        let meets = |other: usize| {
            let y = other as f64 * edge;
            (line[i] + x * x - line[other] - y * y) / (2.0 * (x - y))
        };
        while envelope.last().is_some_and(|&(other, from)| meets(other) <= from) {
            envelope.pop();
        }
        let from = envelope.last().map_or(f64::NEG_INFINITY, |&(other, _)| meets(other));
        envelope.push((i, from));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against all pairs of places.
    #[test]
    fn distances_are_those_of_the_nearest_place() {
        let (count, edges) = ([5, 4, 3], Vec3::new(1.0, 1.5, 0.7));
        let place = |i: usize| [i % 5, i / 5 % 4, i / 20];
        let zeros = [7, 33, 58];
        let of = (0..60).map(|i| if zeros.contains(&i) { 0.0 } else { f64::INFINITY }).collect();
        let found = squared_distances(of, count, edges);
        for i in 0..60 {
            let to = |j: usize| -> f64 {
                (0..3).map(|k| (edges[k] * (place(i)[k] as f64 - place(j)[k] as f64)).powi(2)).sum()
            };
            let nearest = zeros.map(to).into_iter().fold(f64::INFINITY, f64::min);
            assert!((found[i] - nearest).abs() < 1e-12, "{i}: {} {nearest}", found[i]);
        }
        let none = squared_distances(vec![f64::INFINITY; 60], count, edges);
        assert!(none.iter().all(|x| *x == f64::INFINITY));
    }
}
