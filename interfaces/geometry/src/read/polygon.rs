//! Polygons into triangles, by cutting off ears.
//!
//! Every corner is kept, also one in line with its neighbours: the polygon on the other side of
//! that edge has it too, and leaving it out would tear the surface.

use crate::Vec3;
use crate::exact::turn;

/// Triangles of a polygon of at least three corners, as indices into `corners`, wound like it. A
/// polygon that is not plane is cut as it appears along its mean normal; one that crosses itself is
/// cut somehow, but its border is kept.
pub fn triangulate(corners: &[Vec3]) -> Vec<[usize; 3]> {
    if let [a, b, c, d] = corners
        && let Some(halves) = halve([*a, *b, *c, *d])
    {
        return halves.to_vec();
    }
    let view = View::of(corners);
    let mut left: Vec<usize> = (0..corners.len()).collect();
    let mut triangles = Vec::with_capacity(corners.len().saturating_sub(2));
    let mut at = 0;
    while left.len() > 3 {
        let n = left.len();
        let ear = (0..n).map(|k| (at + k) % n).find(|&i| view.is_ear(corners, &left, i));
        let i = ear.unwrap_or(at % n);
        triangles.push([left[(i + n - 1) % n], left[i], left[(i + 1) % n]]);
        left.remove(i);
        // The next ear is not taken beside this one: that would make fans of thin triangles.
        at = (i + 1) % (n - 1);
    }
    if let [a, b, c] = left[..] {
        triangles.push([a, b, c]);
    }
    triangles
}

/// A convex quadrilateral cut along its shorter diagonal.
fn halve(corners: [Vec3; 4]) -> Option<[[usize; 3]; 2]> {
    let view = View::of(&corners);
    let all = [0, 1, 2, 3];
    if !(0..4).all(|i| view.turns_left(&corners, all[(i + 3) % 4], i, all[(i + 1) % 4])) {
        return None;
    }
    let [a, b, c, d] = corners;
    Some(if (a - c).norm_squared() <= (b - d).norm_squared() {
        [[0, 1, 2], [0, 2, 3]]
    } else {
        [[0, 1, 3], [1, 2, 3]]
    })
}

/// The axis along which a polygon appears largest, and whether from that side it runs clockwise.
struct View {
    axis: usize,
    clockwise: bool,
}

impl View {
    fn of(corners: &[Vec3]) -> Self {
        let n = corners.len();
        let fan = (1..n.saturating_sub(1))
            .map(|i| (corners[i] - corners[0]).cross(&(corners[i + 1] - corners[0])))
            .fold(Vec3::zeros(), |sum, cross| sum + cross);
        let axis = fan.iamax();
        Self { axis, clockwise: fan[axis] < 0.0 }
    }

    /// Sign of the turn at the second of three corners, positive for one to the polygon's inside.
    fn turn(&self, corners: &[Vec3], a: usize, b: usize, c: usize) -> f64 {
        let turn = turn(self.axis, corners[a], corners[b], corners[c]);
        if self.clockwise { -turn } else { turn }
    }

    fn turns_left(&self, corners: &[Vec3], a: usize, b: usize, c: usize) -> bool {
        self.turn(corners, a, b, c) > 0.0
    }

    /// True if corner `i` of those left can be cut off: it sticks out, and no other is in the
    /// triangle.
    fn is_ear(&self, corners: &[Vec3], left: &[usize], i: usize) -> bool {
        let n = left.len();
        let (a, b, c) = (left[(i + n - 1) % n], left[i], left[(i + 1) % n]);
        let inside = |p: usize| {
            let off =
                corners[p] != corners[a] && corners[p] != corners[b] && corners[p] != corners[c];
            off && self.turn(corners, a, b, p) >= 0.0
                && self.turn(corners, b, c, p) >= 0.0
                && self.turn(corners, c, a, p) >= 0.0
        };
        self.turns_left(corners, a, b, c) && !left.iter().any(|&p| inside(p))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twice the areas of the triangles, signed against the polygon's normal z.
    fn areas(corners: &[Vec3]) -> Vec<f64> {
        triangulate(corners)
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| corners[i]);
                (b - a).cross(&(c - a)).z
            })
            .collect()
    }

    #[test]
    fn an_arrow_head_is_cut_at_its_notch() {
        let arrow = [[0.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 2.0, 0.0], [1.0, 1.0, 0.0]];
        let arrow = arrow.map(Vec3::from);
        let areas = areas(&arrow);
        assert!(areas.iter().all(|&a| a > 0.0), "{areas:?}");
        assert_eq!(areas.iter().sum::<f64>(), 2.0);
    }

    #[test]
    fn corners_in_line_are_kept() {
        let square: Vec<Vec3> = [[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2], [0, 1]]
            .iter()
            .map(|p| Vec3::new(f64::from(p[0]), f64::from(p[1]), 5.0))
            .collect();
        let areas = areas(&square);
        assert_eq!(areas.len(), 6);
        assert!(areas.iter().all(|&a| a > 0.0), "{areas:?}");
        assert_eq!(areas.iter().sum::<f64>(), 8.0);
    }

    #[test]
    fn a_comb_seen_from_behind_keeps_its_area() {
        let mut comb = vec![Vec3::zeros(), Vec3::new(0.0, 3.0, 0.0)];
        for i in 0..20 {
            let x = f64::from(i);
            comb.extend([Vec3::new(x + 0.5, 1.0, 0.0), Vec3::new(x + 1.0, 3.0, 0.0)]);
        }
        comb.push(Vec3::new(20.0, 0.0, 0.0));
        let areas = areas(&comb);
        assert!(areas.iter().all(|&a| a < 0.0), "{areas:?}");
        // A rectangle of 20 x 3, less 20 notches of width 1 and depth 2.
        assert!((areas.iter().sum::<f64>() + 2.0 * 40.0).abs() < 1e-12);
    }

    #[test]
    fn a_tilted_ring_of_many_corners_is_filled() {
        let corner = |i: i32| {
            let (sin, cos) = libm::sincos(f64::from(i) * std::f64::consts::TAU / 500.0);
            Vec3::new(cos, sin, 2.0 * cos)
        };
        let ring: Vec<Vec3> = (0..500).map(corner).collect();
        let triangles = triangulate(&ring);
        let sum = triangles.iter().fold(Vec3::zeros(), |sum, t| {
            let [a, b, c] = t.map(|i| ring[i]);
            sum + (b - a).cross(&(c - a)) * 0.5
        });
        // The ellipse with half axes 1 and sqrt(5), as a polygon of 500.
        assert!((sum.norm() - std::f64::consts::PI * 5f64.sqrt()).abs() < 2e-4);
    }
}
