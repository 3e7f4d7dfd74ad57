//! A turned section in the world, carried by a body.

use crate::mesh::Point;
use crate::table::Surface;
use tremie_geometry::Frame;
use tremie_messages::scene::Pose;
use tremie_messages::{BodyState, SurfaceVertex};

/// Where the section's frame is, and how it moves.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    /// The section's frame in the carrier's.
    inner: Pose,
    /// The section's axes x, y and z in the world.
    axes: [[f64; 3]; 3],
    /// Direction of each vertex from the axis, in the world, times the polygon's stretch.
    radial: Vec<[f64; 3]>,
    origin: [f64; 3],
    carrier: BodyState,
}

impl Placed {
    /// At rest, its carrier at the world's origin.
    pub fn new(inner: Pose, surface: &Surface) -> Self {
        let carrier = BodyState::at_rest(0, [0.0; 3]);
        let radial = vec![[0.0; 3]; surface.vertex_count()];
        let mut placed = Self { inner, axes: [[0.0; 3]; 3], radial, origin: [0.0; 3], carrier };
        placed.follow(&carrier, surface);
        placed
    }

    /// Takes the section to where its carrier is.
    pub fn follow(&mut self, carrier: &BodyState, surface: &Surface) {
        let BodyState { position, orientation, .. } = *carrier;
        let (outer, inner) = (Frame::of(&Pose { position, orientation }), Frame::of(&self.inner));
        let axis = |k: usize| {
            let unit = std::array::from_fn(|i| if i == k { 1.0 } else { 0.0 });
            outer.turn_to_world(inner.turn_to_world(unit))
        };
        let axes = std::array::from_fn(axis);
        self.origin = outer.to_world(self.inner.position);
        self.carrier = *carrier;
        // Most carriers slide and never turn.
        if axes != self.axes {
            self.axes = axes;
            for (vertex, radial) in self.radial.iter_mut().enumerate() {
                let [cos, sin] = surface.turn(vertex);
                *radial = std::array::from_fn(|i| cos * axes[0][i] + sin * axes[1][i]);
            }
        }
    }

    /// Writes the vertices of the section `points`, which change by `rates` [m/s].
    pub fn write(
        &self,
        surface: &Surface,
        points: &[Point],
        rates: &[Point],
        out: &mut [SurfaceVertex],
    ) {
        let BodyState { position, velocity, angular_velocity: w, .. } = self.carrier;
        let z = self.axes[2];
        for ((point, radial), out) in surface.section.iter().zip(&self.radial).zip(out) {
            let ([r, h], [dr, dh]) = (points[*point as usize], rates[*point as usize]);
            let place = std::array::from_fn(|i| self.origin[i] + (r * radial[i] + h * z[i]));
            let arm: [f64; 3] = std::array::from_fn(|i| place[i] - position[i]);
            let turning = [
                w[1] * arm[2] - w[2] * arm[1],
                w[2] * arm[0] - w[0] * arm[2],
                w[0] * arm[1] - w[1] * arm[0],
            ];
            let moving = |i: usize| velocity[i] + turning[i] + (dr * radial[i] + dh * z[i]);
            *out = SurfaceVertex { position: place, velocity: std::array::from_fn(moving) };
        }
    }

    /// A vector of the world in the section's frame.
    pub fn turn_to_section(&self, vector: [f64; 3]) -> [f64; 3] {
        self.axes.map(|axis| axis[0] * vector[0] + axis[1] * vector[1] + axis[2] * vector[2])
    }

    /// Reference point of the carrier.
    pub fn reference(&self) -> [f64; 3] {
        self.carrier.position
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::Table;
    use crate::table::example;

    #[test]
    fn vertices_are_where_two_frames_take_them_and_move_with_body_and_shape() {
        let table = Table::new(example()).unwrap();
        let surface = table.surface(7);
        let inner = Pose { position: [0.1, -0.2, 0.3], orientation: [0.5, 0.5, 0.5, 0.5] };
        let mut placed = Placed::new(inner, &surface);
        let orientation = [0.0, 0.6, 0.0, 0.8];
        let carrier = BodyState {
            orientation,
            velocity: [1.0, 2.0, 3.0],
            angular_velocity: [0.3, -0.4, 0.5],
            ..BodyState::at_rest(0, [4.0, 5.0, 6.0])
        };
        placed.follow(&carrier, &surface);
        let points = table.vertices(table.bracket(0.12).unwrap());
        let rates: Vec<Point> = points.iter().map(|[r, z]| [0.1 * r, -0.2 * z]).collect();
        let mut out = vec![SurfaceVertex::default(); surface.vertex_count()];
        placed.write(&surface, &points, &rates, &mut out);
        let outer = Frame::of(&Pose { position: [4.0, 5.0, 6.0], orientation });
        let inner = Frame::of(&inner);
        let local = surface.places(&points);
        // A little later, everything moved on.
        let dt = 1e-7;
        let later: Vec<Point> =
            points.iter().zip(&rates).map(|(p, v)| [p[0] + v[0] * dt, p[1] + v[1] * dt]).collect();
        let moved = surface.places(&later);
        let close = |a: [f64; 3], b: [f64; 3], by: f64| (0..3).all(|i| (a[i] - b[i]).abs() < by);
        for (vertex, out) in out.iter().enumerate() {
            let place = outer.to_world(inner.to_world(local[vertex]));
            assert!(close(out.position, place, 1e-12));
            let grown = outer.to_world(inner.to_world(moved[vertex]));
            let arm: [f64; 3] = std::array::from_fn(|i| place[i] - carrier.position[i]);
            let w = carrier.angular_velocity;
            let turning = [
                w[1] * arm[2] - w[2] * arm[1],
                w[2] * arm[0] - w[0] * arm[2],
                w[0] * arm[1] - w[1] * arm[0],
            ];
            let expected = |i: usize| carrier.velocity[i] + turning[i] + (grown[i] - place[i]) / dt;
            assert!(close(out.velocity, std::array::from_fn(expected), 1e-6));
            let back =
                placed.turn_to_section(outer.turn_to_world(inner.turn_to_world(local[vertex])));
            assert!(close(back, local[vertex], 1e-12));
        }
    }
}
