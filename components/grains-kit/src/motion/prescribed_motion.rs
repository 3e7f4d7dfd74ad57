//! Motions that the scene prescribes, integrated exactly.

use crate::Vec3;
use crate::space::rigid_body::Twist;
use tremie_messages::scene::{Course, MotionPoint, TimedMotion};

/// Velocities over time with their integrals: linear between points, or constant ones times a
/// factor.
#[derive(Clone, Debug, Default)]
pub struct Path {
    points: Vec<MotionKnot>,
    factor: Option<(Twist, Course)>,
}

/// Velocities at a time, and their integrals up to it.
#[derive(Clone, Copy, Debug)]
struct MotionKnot {
    time: f64,
    twist: Twist,
    /// Displacement [m], and the integral of the angular velocity [rad].
    travelled: Twist,
}

impl Path {
    /// The path through `points`, or the constant `twist` where there are none.
    pub fn new(points: &[MotionPoint], twist: Twist) -> Self {
        let knot = |point: &MotionPoint| MotionKnot {
            time: point.time,
            twist: Twist { v: point.velocity.into(), w: point.angular_velocity.into() },
            travelled: Twist::zero(),
        };
        let mut path = Self { points: points.iter().map(knot).collect(), factor: None };
        if path.points.is_empty() {
            path.points.push(MotionKnot { time: 0.0, twist, travelled: Twist::zero() });
        }
        for k in 1..path.points.len() {
            path.points[k].travelled = path.points[k - 1].travelled_until(&path.points[k]);
        }
        path
    }

    /// Velocities times a factor over time.
    pub fn of_factor(twist: Twist, course: &Course) -> Self {
        Self { points: Vec::new(), factor: Some((twist, course.clone())) }
    }

    /// That of a part.
    pub fn timed(timed: &TimedMotion) -> Self {
        let twist = Twist { v: timed.velocity.into(), w: timed.angular_velocity.into() };
        Self::of_factor(twist, &timed.course)
    }

    /// Velocities at a time [s].
    pub fn twist(&self, time: f64) -> Twist {
        if let Some((twist, course)) = &self.factor {
            return times(twist, course.at(time));
        }
        let after = self.points.partition_point(|knot| knot.time <= time);
        match (after.checked_sub(1).map(|before| self.points[before]), self.points.get(after)) {
            (Some(a), Some(b)) => a.between(b, time),
            (Some(a), None) => a.twist,
            (None, first) => first.map_or(Twist::zero(), |first| first.twist),
        }
    }

    /// Displacement and integral of the angular velocity from one time to another.
    pub fn travelled(&self, from: f64, to: f64) -> Twist {
        if let Some((twist, course)) = &self.factor {
            return times(twist, course.integral(to) - course.integral(from));
        }
        let (a, b) = (self.integral(from), self.integral(to));
        Twist { v: b.v - a.v, w: b.w - a.w }
    }

    /// The integral up to a constant.
    fn integral(&self, time: f64) -> Twist {
        let after = self.points.partition_point(|knot| knot.time <= time);
        let knot = &self.points[after.saturating_sub(1)];
        let end = MotionKnot { time, twist: self.twist(time), travelled: Twist::zero() };
        knot.travelled_until(&end)
    }
}

fn times(twist: &Twist, factor: f64) -> Twist {
    Twist { v: twist.v * factor, w: twist.w * factor }
}

impl MotionKnot {
    fn between(&self, next: &Self, time: f64) -> Twist {
        let s = (time - self.time) / (next.time - self.time);
        let mix = |a: Vec3, b: Vec3| a + (b - a) * s;
        Twist { v: mix(self.twist.v, next.twist.v), w: mix(self.twist.w, next.twist.w) }
    }

    /// The integral up to another time, between which velocities are linear.
    fn travelled_until(&self, other: &Self) -> Twist {
        let half = 0.5 * (other.time - self.time);
        Twist {
            v: self.travelled.v + (self.twist.v + other.twist.v) * half,
            w: self.travelled.w + (self.twist.w + other.twist.w) * half,
        }
    }
}

/// The orientation `q`, a unit quaternion `(x, y, z, w)`, turned by a rotation vector in the world
/// frame, exactly.
pub fn turn(q: [f64; 4], rotation: Vec3) -> [f64; 4] {
    let angle = rotation.norm_squared().sqrt();
    // sin(angle/2)/angle, by its series where the quotient would lose digits.
    let s = if angle > 1e-4 { libm::sin(0.5 * angle) / angle } else { 0.5 - angle * angle / 48.0 };
    let (h, c) = (rotation * s, libm::cos(0.5 * angle));
    let [x, y, z, w] = q;
    let turned = [
        c * x + h.x * w + h.y * z - h.z * y,
        c * y + h.y * w + h.z * x - h.x * z,
        c * z + h.z * w + h.x * y - h.y * x,
        c * w - h.x * x - h.y * y - h.z * z,
    ];
    let length = turned.iter().fold(0.0, |sum, c| sum + c * c).sqrt();
    turned.map(|c| c / length)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(time: f64, v: f64, w: f64) -> MotionPoint {
        MotionPoint { time, velocity: [v, 0.0, -v], angular_velocity: [0.0, 0.0, w] }
    }

    #[test]
    fn displacements_are_integrals_across_points() {
        let path = Path::new(&[point(1.0, 0.0, 0.0), point(3.0, 4.0, 1.0)], Twist::zero());
        for (time, x, v) in [(0.5, 0.0, 0.0), (2.0, 1.0, 2.0), (3.0, 4.0, 4.0), (5.0, 12.0, 4.0)] {
            assert_eq!((path.travelled(0.0, time).v.x, path.twist(time).v.x), (x, v));
        }
        assert_eq!(path.travelled(2.0, 5.0).v.x, 11.0);
        let early = Path::new(&[point(1.0, 2.0, 0.0)], Twist::zero());
        assert_eq!((early.travelled(0.0, 3.0).v.x, early.twist(0.0).v.x), (6.0, 2.0));
        let steady = Path::new(&[], Twist { v: Vec3::x(), w: Vec3::zeros() });
        assert_eq!(steady.travelled(1.0, 3.0).v.x, 2.0);
    }

    #[test]
    fn turning_about_a_fixed_axis_is_exact() {
        let axis = Vec3::new(0.36, 0.48, 0.8);
        let mut q = [0.0, 0.0, 0.0, 1.0];
        for _ in 0..1000 {
            q = turn(q, axis * 0.01);
        }
        let exact = nalgebra::UnitQuaternion::from_scaled_axis(axis * 10.0);
        let error = (0..4).map(|a| (q[a] - exact.coords[a]).abs()).fold(0.0, f64::max);
        assert!(error < 1e-13, "{error}");
    }
}
