//! Boxes along the axes.

use crate::Vec3;
use crate::vector::{norm, sub};

/// A closed box along the axes [m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Its least corner.
    pub min: Vec3,
    /// Its greatest corner.
    pub max: Vec3,
}

impl Bounds {
    /// The box that holds nothing.
    pub const EMPTY: Self = Self { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };

    /// The least box around points; [`Bounds::EMPTY`] for none.
    pub fn of(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, Self::with)
    }

    /// The least box that holds this one and a point.
    pub fn with(self, point: Vec3) -> Self {
        self.union(&Self { min: point, max: point })
    }

    /// The least box that holds both.
    pub fn union(&self, other: &Self) -> Self {
        Self {
            min: std::array::from_fn(|k| self.min[k].min(other.min[k])),
            max: std::array::from_fn(|k| self.max[k].max(other.max[k])),
        }
    }

    /// This box, larger by `margin` on every side.
    pub fn grown(&self, margin: f64) -> Self {
        Self { min: self.min.map(|x| x - margin), max: self.max.map(|x| x + margin) }
    }

    /// Whether a point is in the box or on its sides.
    pub fn contains(&self, point: Vec3) -> bool {
        (0..3).all(|k| self.min[k] <= point[k] && point[k] <= self.max[k])
    }

    /// Whether the boxes have a point in common.
    pub fn meets(&self, other: &Self) -> bool {
        (0..3).all(|k| self.min[k] <= other.max[k] && other.min[k] <= self.max[k])
    }

    /// Edge lengths [m].
    pub fn size(&self) -> Vec3 {
        sub(self.max, self.min)
    }

    /// Length of the diagonal [m].
    pub fn diagonal(&self) -> f64 {
        norm(self.size())
    }

    /// Its middle.
    pub fn centre(&self) -> Vec3 {
        std::array::from_fn(|k| 0.5 * (self.min[k] + self.max[k]))
    }

    /// The largest magnitude of a coordinate in it: what rounding errors scale with.
    pub(crate) fn magnitude(&self) -> f64 {
        self.min.iter().chain(&self.max).fold(0.0, |m, x| x.abs().max(m))
    }

    /// Square of the distance from a point to the box, zero inside.
    pub(crate) fn distance_squared(&self, point: Vec3) -> f64 {
        let outside = |k: usize| (self.min[k] - point[k]).max(point[k] - self.max[k]).max(0.0);
        let d = [outside(0), outside(1), outside(2)];
        d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
    }

    /// Half the area of its sides.
    pub(crate) fn half_area(&self) -> f64 {
        let [x, y, z] = self.size();
        x * y + y * z + z * x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_measures_from_its_sides() {
        let unit = Bounds::of([[0.0; 3], [1.0; 3]]);
        assert_eq!(unit.distance_squared([0.5, 1.0, 0.0]), 0.0);
        assert_eq!(unit.distance_squared([-1.0, 3.0, 0.5]), 5.0);
        assert!(unit.meets(&Bounds::of([[1.0; 3], [2.0; 3]])));
        assert!(!unit.meets(&Bounds::of([[1.0, 1.0, 1.1], [2.0; 3]])));
        assert!(!Bounds::EMPTY.meets(&unit) && !Bounds::EMPTY.contains([0.0; 3]));
        assert_eq!(unit.grown(1.0), Bounds { min: [-1.0; 3], max: [2.0; 3] });
    }
}
