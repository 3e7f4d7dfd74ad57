//! A hollow cylinder, in which probes measure.

use serde::{Deserialize, Serialize};

/// The space between two radii about a line along an axis, and between two heights on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ring {
    /// Axis of the line: 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// A point of the line [m].
    pub through: [f64; 3],
    /// Inner and outer radius [m].
    pub radii: [f64; 2],
    /// Begin and end along the line, from the point [m].
    pub heights: [f64; 2],
}

impl Ring {
    /// The two axes across the line.
    pub fn across(&self) -> [usize; 2] {
        [(self.axis + 1) % 3, (self.axis + 2) % 3]
    }

    /// True if a point [m] is in the ring. Rings side by side never share a point.
    pub fn holds(&self, point: [f64; 3]) -> bool {
        let [b, c] = self.across().map(|a| point[a] - self.through[a]);
        let (square, height) = (b * b + c * c, point[self.axis] - self.through[self.axis]);
        // Half-open intervals: two rings that share a face never count a centre twice.
        let within = |x: f64, [from, to]: [f64; 2]| from <= x && x < to;
        within(square, self.radii.map(|r| r * r)) && within(height, self.heights)
    }

    /// Corners of the box around it [m].
    pub fn corners(&self) -> [[f64; 3]; 2] {
        [0, 1].map(|end| {
            std::array::from_fn(|a| {
                let reach = if a == self.axis {
                    self.heights[end]
                } else {
                    [-self.radii[1], self.radii[1]][end]
                };
                self.through[a] + reach
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ring_holds_what_lies_between_its_radii_and_heights() {
        let ring =
            Ring { axis: 1, through: [1.0, 2.0, 3.0], radii: [1.0, 2.0], heights: [-1.0, 0.5] };
        assert!(ring.holds([2.5, 2.0, 3.0]) && ring.holds([1.0, 1.0, 1.5]));
        for outside in [[1.5, 2.0, 3.0], [1.0, 2.0, 5.5], [2.5, 2.5, 3.0], [2.5, 0.9, 3.0]] {
            assert!(!ring.holds(outside), "{outside:?}");
        }
        assert_eq!(ring.corners(), [[-1.0, 1.0, 1.0], [3.0, 2.5, 5.0]]);
    }
}
