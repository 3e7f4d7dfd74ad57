//! The place of a grid in the world: all of space, or a plane across an axis.

use tremie_geometry::Vec3;

/// Coordinates of a grid of `D` axes in the world. Of a plane, the two axes are the world's others,
/// in their order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section<const D: usize> {
    /// Axes of the world along those of the grid.
    pub axes: [usize; D],
    /// A point of the plane [m]; in space any.
    pub through: [f64; 3],
}

impl Section<3> {
    /// All of space.
    pub const SPACE: Self = Self { axes: [0, 1, 2], through: [0.0; 3] };
}

impl<const D: usize> Section<D> {
    /// A point of the grid in the world [m].
    #[inline]
    pub fn to_world(&self, point: [f64; D]) -> Vec3 {
        let mut world = Vec3::from(self.through);
        for a in 0..D {
            world[self.axes[a]] = point[a];
        }
        world
    }

    /// Components of a vector of the world along the grid's axes.
    #[inline]
    pub fn along(&self, vector: [f64; 3]) -> [f64; D] {
        self.axes.map(|axis| vector[axis])
    }

    /// A vector of the grid in the world.
    #[inline]
    pub fn vector_to_world(&self, vector: [f64; D]) -> [f64; 3] {
        let mut world = [0.0; 3];
        for a in 0..D {
            world[self.axes[a]] = vector[a];
        }
        world
    }

    /// Sign of a turn about the plane's axis of the world, seen in the grid, whose second axis is
    /// a quarter turn from its first.
    #[inline]
    pub fn handedness(&self) -> f64 {
        // x and z, in this order, turn about -y.
        if D == 2 && self.axes[0] == 0 && self.axes[D - 1] == 2 { -1.0 } else { 1.0 }
    }

    /// The axis of the world across a plane; 2 in space.
    #[inline]
    pub fn across(&self) -> usize {
        (0..3).find(|axis| !self.axes.contains(axis)).unwrap_or(2)
    }

    /// A turn of the world as the grid has it: in a plane the last component.
    pub fn turn(&self, turn: [f64; 3]) -> [f64; 3] {
        if D == 3 { turn } else { [0.0, 0.0, self.handedness() * turn[self.across()]] }
    }

    /// A turn of the grid in the world.
    pub fn turn_to_world(&self, turn: [f64; 3]) -> [f64; 3] {
        if D == 3 {
            return turn;
        }
        let mut world = [0.0; 3];
        world[self.across()] = self.handedness() * turn[2];
        world
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A turn in the plane of x and z moves points as it does in space.
    #[test]
    fn a_plane_turns_as_space_does() {
        for axes in [[0, 2], [0, 1], [1, 2]] {
            let section = Section { axes, through: [0.3; 3] };
            let mut omega = [0.0; 3];
            omega[section.across()] = 2.0;
            let arm = [0.7, -0.4];
            let world = Vec3::from(omega).cross(&Vec3::from(section.vector_to_world(arm)));
            let turn = section.turn(omega)[2];
            let plane = [-turn * arm[1], turn * arm[0]];
            assert_eq!(section.along(world.into()), plane);
            assert_eq!(section.turn_to_world(section.turn(omega)), omega);
        }
    }
}
