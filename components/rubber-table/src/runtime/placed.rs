//! A turned section in the world, carried by a body.

use crate::mesh::Point;
use crate::table::Surface;
use nalgebra::Matrix3;
use tremie_geometry::{Frame, Vec3};
use tremie_messages::scene::Pose;
use tremie_messages::{BodyState, SurfaceVertex};

/// Place and motion of the section's frame.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    /// The section's frame in the carrier's.
    inner: Pose,
    /// The section's axes x, y and z in the world: columns.
    axes: Matrix3<f64>,
    /// Direction of each vertex from the axis, in the world, times the polygon's stretch.
    radial: Vec<Vec3>,
    origin: Vec3,
    carrier: BodyState,
}

impl Placed {
    /// At rest, its carrier at the world's origin.
    pub fn new(inner: Pose, surface: &Surface) -> Self {
        let carrier = BodyState::at_rest(0, [0.0; 3]);
        let radial = vec![Vec3::zeros(); surface.vertex_count()];
        let (axes, origin) = (Matrix3::zeros(), Vec3::zeros());
        let mut placed = Self { inner, axes, radial, origin, carrier };
        placed.follow(&carrier, surface);
        placed
    }

    /// Takes the section to where its carrier is.
    pub fn follow(&mut self, carrier: &BodyState, surface: &Surface) {
        let BodyState { position, orientation, .. } = *carrier;
        let (outer, inner) = (Frame::of(&Pose { position, orientation }), Frame::of(&self.inner));
        let axes = [Vec3::x(), Vec3::y(), Vec3::z()]
            .map(|axis| outer.turn_to_world(inner.turn_to_world(axis)));
        let axes = Matrix3::from_columns(&axes);
        self.origin = outer.to_world(self.inner.position);
        self.carrier = *carrier;
        // Most carriers slide and never turn.
        if axes != self.axes {
            self.axes = axes;
            for (vertex, radial) in self.radial.iter_mut().enumerate() {
                let [cos, sin] = surface.turn(vertex);
                *radial = axes.column(0) * cos + axes.column(1) * sin;
            }
        }
    }

    /// Body that carries the section.
    pub fn carrier(&self) -> BodyState {
        self.carrier
    }

    /// Writes the vertices of the section `points`, which change by `rates` [m/s].
    pub fn write(
        &self,
        surface: &Surface,
        points: &[Point],
        rates: &[Point],
        out: &mut [SurfaceVertex],
    ) {
        let BodyState { position, velocity, angular_velocity, .. } = self.carrier;
        let (velocity, spin) = (Vec3::from(velocity), Vec3::from(angular_velocity));
        let (reference, z) = (Vec3::from(position), self.axes.column(2));
        for ((point, radial), out) in surface.section.iter().zip(&self.radial).zip(out) {
            let ([r, h], [dr, dh]) = (points[*point as usize], rates[*point as usize]);
            let place = self.origin + (radial * r + z * h);
            let turning = spin.cross(&(place - reference));
            let moving = velocity + turning + (radial * dr + z * dh);
            *out = SurfaceVertex { position: place.into(), velocity: moving.into() };
        }
    }

    /// A vector of the world in the section's frame.
    pub fn turn_to_section(&self, vector: Vec3) -> Vec3 {
        self.axes.tr_mul(&vector)
    }

    /// Reference point of the carrier.
    pub fn reference(&self) -> Vec3 {
        self.carrier.position.into()
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
        let close = |a: Vec3, b: Vec3, by: f64| (a - b).amax() < by;
        for (vertex, out) in out.iter().enumerate() {
            let place = outer.to_world(inner.to_world(local[vertex]));
            assert!(close(out.position.into(), place, 1e-12));
            let grown = outer.to_world(inner.to_world(moved[vertex]));
            let arm = place - Vec3::from(carrier.position);
            let turning = Vec3::from(carrier.angular_velocity).cross(&arm);
            let expected = Vec3::from(carrier.velocity) + turning + (grown - place) / dt;
            assert!(close(out.velocity.into(), expected, 1e-6));
            let back =
                placed.turn_to_section(outer.turn_to_world(inner.turn_to_world(local[vertex])));
            assert!(close(back, local[vertex], 1e-12));
        }
    }
}
