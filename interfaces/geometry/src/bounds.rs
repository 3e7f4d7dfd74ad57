//! Boxes along the axes.

use crate::Vec3;

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
    pub const EMPTY: Self = {
        let far = f64::INFINITY;
        Self { min: Vec3::new(far, far, far), max: Vec3::new(-far, -far, -far) }
    };

    /// The least box around points; [`Bounds::EMPTY`] for none.
    #[inline]
    pub fn of(points: impl IntoIterator<Item = impl Into<Vec3>>) -> Self {
        points.into_iter().fold(Self::EMPTY, Self::with)
    }

    /// The least box that holds this one and a point.
    #[inline]
    pub fn with(self, point: impl Into<Vec3>) -> Self {
        let point = point.into();
        self.union(&Self { min: point, max: point })
    }

    /// The least box that holds both.
    #[inline]
    pub fn union(&self, other: &Self) -> Self {
        // Unlike nalgebra's `inf` and `sup`, which let through a coordinate that is no number.
        Self {
            min: self.min.zip_map(&other.min, f64::min),
            max: self.max.zip_map(&other.max, f64::max),
        }
    }

    /// This box, larger by `margin` on every side.
    #[inline]
    pub fn grown(&self, margin: f64) -> Self {
        Self { min: self.min.add_scalar(-margin), max: self.max.add_scalar(margin) }
    }

    /// True if a point is in the box or on its sides.
    pub fn contains(&self, point: impl Into<Vec3>) -> bool {
        let point = point.into();
        (0..3).all(|k| self.min[k] <= point[k] && point[k] <= self.max[k])
    }

    /// True if the boxes have a point in common.
    #[inline]
    pub fn meets(&self, other: &Self) -> bool {
        (0..3).all(|k| self.min[k] <= other.max[k] && other.min[k] <= self.max[k])
    }

    /// Edge lengths [m].
    pub fn size(&self) -> Vec3 {
        self.max - self.min
    }

    /// Length of the diagonal [m].
    pub fn diagonal(&self) -> f64 {
        self.size().norm()
    }

    /// Its middle.
    pub fn centre(&self) -> Vec3 {
        (self.min + self.max) * 0.5
    }

    /// The largest magnitude of a coordinate in it: what rounding errors scale with.
    pub(crate) fn magnitude(&self) -> f64 {
        self.min.iter().chain(&self.max).fold(0.0, |m, x| x.abs().max(m))
    }

    /// Square of the distance from a point to the box, zero inside.
    #[inline]
    pub(crate) fn distance_squared(&self, point: Vec3) -> f64 {
        let outside = |k: usize| (self.min[k] - point[k]).max(point[k] - self.max[k]).max(0.0);
        Vec3::new(outside(0), outside(1), outside(2)).norm_squared()
    }

    /// Half the area of its sides.
    pub(crate) fn half_area(&self) -> f64 {
        let [x, y, z] = self.size().into();
        x * y + y * z + z * x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_measures_from_its_sides() {
        let unit = Bounds::of([[0.0; 3], [1.0; 3]]);
        assert_eq!(unit.distance_squared(Vec3::new(0.5, 1.0, 0.0)), 0.0);
        assert_eq!(unit.distance_squared(Vec3::new(-1.0, 3.0, 0.5)), 5.0);
        assert!(unit.meets(&Bounds::of([[1.0; 3], [2.0; 3]])));
        assert!(!unit.meets(&Bounds::of([[1.0, 1.0, 1.1], [2.0; 3]])));
        assert!(!Bounds::EMPTY.meets(&unit) && !Bounds::EMPTY.contains([0.0; 3]));
        assert_eq!(
            unit.grown(1.0),
            Bounds { min: Vec3::from_element(-1.0), max: Vec3::from_element(2.0) }
        );
    }
}
