//! The rigid seat, and its frictionless contact with the rubber.

use crate::fem::element::Symmetry;
use crate::mesh::Point;

/// A rigid seat: the height of its surface over the radius, a polyline with rounded corners. Its
/// first and last pieces go on without end.
#[derive(Clone, Debug, PartialEq)]
pub struct Seat {
    points: Vec<Point>,
    /// Half the width over which each corner is rounded by a parabola [m].
    rounding: f64,
}

/// Why a polyline is no seat.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SeatError {
    /// Too few points.
    #[error("the seat's meridian has {0} point, it needs at least 2")]
    TooShort(usize),
    /// A vertical or overhanging piece, or a number that is none.
    #[error(
        "point {at} of the seat's meridian lies at radius {found} m, not outside the one before ({before} m); give points from the inside to the outside, a wall as a steep slope"
    )]
    NotOutward {
        /// Number of the point, from 0.
        at: usize,
        /// Its radius [m].
        found: f64,
        /// The radius of the point before [m].
        before: f64,
    },
    /// A rounding that would eat a whole piece.
    #[error(
        "the seat's corners are rounded over {rounding} m to each side, but the piece after point {at} is only {length} m wide; round less"
    )]
    TooRound {
        /// Number of the point, from 0.
        at: usize,
        /// Width of the piece [m].
        length: f64,
        /// Half width of the rounding [m].
        rounding: f64,
    },
}

impl Seat {
    /// A flat seat at height `z` [m].
    pub fn flat(z: f64) -> Self {
        Self { points: vec![[0.0, z], [1.0, z]], rounding: 0.0 }
    }

    /// A seat along `points`, from the inside to the outside, with corners rounded over `rounding`
    /// to each side [m].
    ///
    /// # Errors
    /// If the radii do not grow, or corners' roundings would overlap.
    pub fn along(points: Vec<Point>, rounding: f64) -> Result<Self, SeatError> {
        if points.len() < 2 {
            return Err(SeatError::TooShort(points.len()));
        }
        for (at, pair) in points.windows(2).enumerate() {
            let [before, found] = [pair[0][0], pair[1][0]];
            if !(found > before && pair.iter().flatten().all(|x| x.is_finite())) {
                return Err(SeatError::NotOutward { at: at + 1, found, before });
            }
            let ends = usize::from(at > 0) + usize::from(at + 2 < points.len());
            if ends as f64 * rounding > found - before {
                return Err(SeatError::TooRound { at, length: found - before, rounding });
            }
        }
        Ok(Self { points, rounding })
    }

    /// The same seat, `by` higher [m].
    pub fn raised(mut self, by: f64) -> Self {
        self.points.iter_mut().for_each(|point| point[1] += by);
        self
    }

    /// The points of its meridian [m].
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// Half the width over which each corner is rounded [m].
    pub fn rounding(&self) -> f64 {
        self.rounding
    }

    /// Height of the surface at radius `r` [m], its slope, and how the slope changes [1/m].
    pub fn surface(&self, r: f64) -> [f64; 3] {
        let last = self.points.len() - 2;
        let piece = self.points[1..=last].iter().filter(|point| point[0] <= r).count();
        for corner in [piece, piece + 1] {
            if corner > 0 && corner <= last && (r - self.points[corner][0]).abs() < self.rounding {
                return self.corner(corner, r);
            }
        }
        let slope = self.slope(piece);
        [self.points[piece][1] + slope * (r - self.points[piece][0]), slope, 0.0]
    }

    fn slope(&self, piece: usize) -> f64 {
        let [a, b] = [self.points[piece], self.points[piece + 1]];
        (b[1] - a[1]) / (b[0] - a[0])
    }

    /// A parabola that meets the two pieces with their slopes.
    fn corner(&self, corner: usize, r: f64) -> [f64; 3] {
        let [at, z] = self.points[corner];
        let (before, after) = (self.slope(corner - 1), self.slope(corner));
        let change = (after - before) / (2.0 * self.rounding);
        let inside = r - at + self.rounding;
        [z + before * (r - at) + 0.5 * change * inside * inside, before + change * inside, change]
    }

    /// Height by which the seat must be raised to touch edges of an outline [m].
    pub fn gap<'a>(&self, edges: impl Iterator<Item = [&'a Point; 2]>) -> f64 {
        let mut least = f64::INFINITY;
        for [a, b] in edges {
            let (low, high) = (a[0].min(b[0]), a[0].max(b[0]));
            let corners =
                self.points.iter().map(|point| point[0]).filter(|r| *r > low && *r < high);
            let height = |r: f64| match b[0] - a[0] {
                0.0 => a[1].min(b[1]),
                width => a[1] + (b[1] - a[1]) * (r - a[0]) / width,
            };
            least = least.min(a[1] - self.surface(a[0])[0]).min(b[1] - self.surface(b[0])[0]);
            least = corners.map(|r| height(r) - self.surface(r)[0]).fold(least, f64::min);
        }
        least
    }
}

/// A point of the outline that may touch the seat: an end or the middle of an edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct ContactPoint {
    /// The edge's ends.
    pub nodes: [usize; 2],
    /// Their shares.
    pub shares: [f64; 2],
    /// Reference area that it stands for [m²].
    pub area: f64,
}

impl ContactPoint {
    /// The points of an edge, weighted after Simpson: as exact as two Gauss points, and contact
    /// begins with the node that comes first.
    pub fn of_edge(edge: [usize; 2], nodes: &[Point], symmetry: Symmetry) -> [Self; 3] {
        let [a, b] = edge.map(|node| nodes[node]);
        let length = libm::hypot(b[0] - a[0], b[1] - a[1]);
        [(1.0, 1.0 / 6.0), (0.5, 2.0 / 3.0), (0.0, 1.0 / 6.0)].map(|(share, weight)| {
            let shares = [share, 1.0 - share];
            let radius = shares[0] * a[0] + shares[1] * b[0];
            Self { nodes: edge, shares, area: weight * length * symmetry.depth(radius) }
        })
    }

    /// True if it is the middle of its edge.
    pub fn is_middle(&self) -> bool {
        self.shares[0] == self.shares[1]
    }
}

/// Energy, force and stiffness of a contact point that touches.
#[derive(Clone, Copy, Debug)]
pub(super) struct ContactResponse {
    /// Stored energy [J].
    pub energy: f64,
    /// Its derivative by the point's position [N]: minus the force of the seat on the rubber.
    pub force: [f64; 2],
    /// Second derivatives: rr, rz, zz [N/m].
    pub stiffness: [f64; 3],
}

/// A seat, and what may touch it.
#[derive(Clone, Debug)]
pub(super) struct Contact {
    /// The seat where it touches the undeformed section.
    pub seat: Seat,
    /// Along the edges that may touch.
    pub points: Vec<ContactPoint>,
    /// Pressure by depth [Pa/m].
    stiffness: f64,
}

impl Contact {
    /// Of `seat`, raised or lowered until it touches, and `edges` of an outline. `modulus`:
    /// pressure at a depth of a mean edge's length [Pa].
    pub fn new(
        seat: Seat,
        edges: &[[usize; 2]],
        nodes: &[Point],
        symmetry: Symmetry,
        modulus: f64,
    ) -> Self {
        let ends = || edges.iter().map(|edge| edge.map(|node| &nodes[node]));
        let gap = seat.gap(ends());
        let length: f64 = ends().map(|[a, b]| libm::hypot(b[0] - a[0], b[1] - a[1])).sum();
        Self {
            seat: seat.raised(if gap.is_finite() { gap } else { 0.0 }),
            points: edges
                .iter()
                .flat_map(|edge| ContactPoint::of_edge(*edge, nodes, symmetry))
                .collect(),
            stiffness: modulus * edges.len() as f64 / length,
        }
    }

    /// Response of `point` where it is `at`; `None` above the seat.
    pub fn touch(&self, point: &ContactPoint, at: Point) -> Option<ContactResponse> {
        touch(&self.seat, at, self.stiffness * point.area)
    }
}

/// Penalty on the depth g below the seat's surface, measured along the axis: energy k g²/2, of
/// which the force is normal to the surface.
fn touch(seat: &Seat, at: Point, k: f64) -> Option<ContactResponse> {
    let [height, slope, change] = seat.surface(at[0]);
    let gap = at[1] - height;
    (gap <= 0.0).then(|| ContactResponse {
        energy: 0.5 * k * gap * gap,
        force: [-k * gap * slope, k * gap],
        stiffness: [k * (slope * slope - gap * change), -k * slope, k],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn valley() -> Seat {
        Seat::along(vec![[1.0, 1.0], [2.0, 0.0], [3.0, 0.5], [4.0, 0.5]], 0.2).unwrap()
    }

    #[test]
    fn the_surface_is_the_polyline_with_rounded_corners() {
        let seat = valley();
        assert_eq!(seat.surface(1.5), [0.5, -1.0, 0.0]);
        assert_eq!(seat.surface(0.0), [2.0, -1.0, 0.0], "the first piece goes on");
        assert_eq!(seat.surface(9.0), [0.5, 0.0, 0.0], "the last piece goes on");
        for corner in [2.0, 3.0] {
            for side in [-0.2, 0.2] {
                let (a, b) = (
                    seat.surface(corner + 0.999_999 * side),
                    seat.surface(corner + 1.000_001 * side),
                );
                assert!((a[0] - b[0]).abs() < 1e-6 && (a[1] - b[1]).abs() < 1e-5, "{a:?} {b:?}");
            }
        }
        for r in [1.9, 2.05, 2.9, 3.15] {
            let (below, here, above) =
                (seat.surface(r - 1e-5), seat.surface(r), seat.surface(r + 1e-5));
            assert!(((above[0] - below[0]) / 2e-5 - here[1]).abs() < 1e-9);
            assert!(((above[1] - below[1]) / 2e-5 - here[2]).abs() < 1e-9);
        }
    }

    #[test]
    fn forces_are_derivatives_and_normal_to_the_seat() {
        let (seat, k) = (valley(), 7.0);
        for at in [[1.5, 0.3], [2.1, -0.1], [2.9, 0.1], [3.5, 0.4]] {
            let here = touch(&seat, at, k).unwrap();
            let [_, slope, _] = seat.surface(at[0]);
            assert!((here.force[0] + slope * here.force[1]).abs() < 1e-12);
            for axis in 0..2 {
                let moved = |by: f64| {
                    let mut at = at;
                    at[axis] += by;
                    touch(&seat, at, k).unwrap()
                };
                let (above, below) = (moved(1e-5), moved(-1e-5));
                assert!(((above.energy - below.energy) / 2e-5 - here.force[axis]).abs() < 1e-8);
                for other in 0..2 {
                    let slope = (above.force[other] - below.force[other]) / 2e-5;
                    assert!((slope - here.stiffness[axis + other]).abs() < 1e-8);
                }
            }
        }
        assert!(touch(&seat, [1.5, 0.51], k).is_none());
    }

    #[test]
    fn the_gap_is_found_at_nodes_and_at_the_seats_corners() {
        let peak = Seat::along(vec![[0.0, 0.0], [1.0, 1.0], [2.0, 0.0]], 0.0).unwrap();
        let (a, b) = ([0.0, 3.0], [2.0, 3.0]);
        assert_eq!(peak.gap([[&a, &b]].into_iter()), 2.0);
        assert_eq!(peak.raised(2.0).surface(1.0)[0], 3.0);
        assert_eq!(valley().gap([[&[2.5, 0.75], &[2.5, 1.0]]].into_iter()), 0.5);
    }

    #[test]
    fn what_is_no_seat_is_refused() {
        assert_eq!(Seat::along(vec![[1.0, 0.0]], 0.0), Err(SeatError::TooShort(1)));
        let wall = Seat::along(vec![[1.0, 0.0], [2.0, 0.0], [2.0, 1.0]], 0.0);
        assert!(matches!(wall, Err(SeatError::NotOutward { at: 2, .. })));
        let round = Seat::along(vec![[0.0, 0.0], [1.0, 0.0], [2.0, 1.0], [3.0, 1.0]], 0.6);
        assert!(matches!(round, Err(SeatError::TooRound { at: 1, .. })));
    }
}
