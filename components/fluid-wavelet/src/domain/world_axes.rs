//! The axes of the gas's grid in the world.

use tremie_messages::scene::Scene;

/// Axes of the world in the order of the grid's. In a plane scene the last one is across it, and the
/// grid has none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldAxes {
    /// Axes of the world along those of the grid.
    pub order: [usize; 3],
    /// Axes of the grid: 2 or 3.
    pub dims: usize,
    /// Where the plane is on the axis across it [m].
    through: f64,
}

impl WorldAxes {
    /// Of a scene.
    pub fn of(scene: &Scene) -> Self {
        let domain = &scene.domain;
        match domain.across {
            Some(across) => Self {
                order: [[1, 2, 0], [0, 2, 1], [0, 1, 2]][across],
                dims: 2,
                through: 0.5 * (domain.min[across] + domain.max[across]),
            },
            None => Self { order: [0, 1, 2], dims: 3, through: 0.0 },
        }
    }

    /// A vector of the world along the grid's axes; what of it is across a plane is left out.
    pub fn along(&self, vector: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|a| if a < self.dims { vector[self.order[a]] } else { 0.0 })
    }

    /// A vector of the grid in the world.
    pub fn vector_to_world(&self, vector: [f64; 3]) -> [f64; 3] {
        let mut world = [0.0; 3];
        (0..self.dims).for_each(|a| world[self.order[a]] = vector[a]);
        world
    }

    /// A point of the grid in the world [m].
    pub fn to_world(self, point: [f64; 3]) -> [f64; 3] {
        let mut world = self.vector_to_world(point);
        if self.dims == 2 {
            world[self.order[2]] = self.through;
        }
        world
    }

    /// 1, or -1 where the grid's axes are a left hand in the world: x and z, in this order, turn
    /// about -y.
    fn handedness(&self) -> f64 {
        if self.order == [0, 2, 1] { -1.0 } else { 1.0 }
    }

    /// A turn of the world as the grid has it: in a plane the last component.
    pub fn turn(&self, turn: [f64; 3]) -> [f64; 3] {
        if self.dims == 3 { turn } else { [0.0, 0.0, self.handedness() * turn[self.order[2]]] }
    }

    /// A turn of the grid in the world.
    pub fn turn_to_world(&self, turn: [f64; 3]) -> [f64; 3] {
        if self.dims == 3 {
            return turn;
        }
        let mut world = [0.0; 3];
        world[self.order[2]] = self.handedness() * turn[2];
        world
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bodies::gas_body::cross;
    use tremie_messages::scene::{Domain, Face};

    #[test]
    fn a_plane_turns_as_space_does() {
        for across in 0..3 {
            let mut domain = Domain::new([0.0; 3], [1.0; 3], Face::WALLS);
            domain.across = Some(across);
            let axes = WorldAxes::of(&Scene::empty(domain));
            let mut omega = [0.0; 3];
            omega[across] = 2.0;
            let arm = [0.7, -0.4, 0.0];
            let world = cross(omega, axes.vector_to_world(arm));
            assert_eq!(axes.along(world), cross(axes.turn(omega), arm));
            assert_eq!(axes.turn_to_world(axes.turn(omega)), omega);
            assert_eq!(axes.to_world([0.2, 0.3, 0.0])[across], 0.5);
        }
    }
}
