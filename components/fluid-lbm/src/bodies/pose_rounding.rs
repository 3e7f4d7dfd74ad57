//! Rounded poses of parts.
//!
//! A part moves by a small part of a cell in a step, and looking for its cells and links costs many
//! times what the step does. So they are looked for at its pose rounded to multiples of `part_step`
//! from its pose in the scene (`a`, the next power of two below): each coordinate to multiples of
//! `a`, each component of the quaternion to multiples of `a / (4 r)`, `r` being the distance of the
//! part's farthest point. They are found anew when the rounded pose changes. As long as it does
//! not, wall distances follow the motion to first order (see `mesh_links`); which cells are covered
//! is that of the rounded pose, off by `a/2` along an axis, and by `a/2` at its farthest point by
//! turning. The cells and links found depend on the pose alone, not on the way of the part to it.
//! So those of the pose before the last are kept: a part that trembles about the border of two
//! rounded poses costs no search.

/// The poses at which a part's cells and links are found.
#[derive(Clone, Copy, Debug)]
pub struct Rounding {
    /// Position of the part in the scene [cells].
    pub position: [f64; 3],
    /// Its orientation there.
    pub orientation: [f64; 4],
    /// Edge of the grid of positions; 0 for poses as they are.
    pub step: f64,
}

/// A position [cells] and an orientation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedMesh {
    /// Of the origin.
    pub position: [f64; 3],
    /// A unit quaternion `(x, y, z, w)`.
    pub orientation: [f64; 4],
}

impl Default for Rounding {
    /// Poses as they are.
    fn default() -> Self {
        Self { position: [0.0; 3], orientation: [0.0, 0.0, 0.0, 1.0], step: 0.0 }
    }
}

impl Rounding {
    /// The pose for a position and orientation, `radius` being the distance of the farthest point.
    pub fn of(&self, position: [f64; 3], orientation: [f64; 4], radius: f64) -> PlacedMesh {
        if self.step <= 0.0 {
            return PlacedMesh { position, orientation };
        }
        let to = |x: f64, step: f64| (x / step).round() * step;
        let away = std::array::from_fn(|a| {
            self.position[a] + to(position[a] - self.position[a], self.step)
        });
        let [x, y, z, w] = self.orientation;
        let turn = product(orientation, [-x, -y, -z, w]);
        let fine = self.step / (4.0 * radius);
        let turn = turn.map(|q| to(q, fine));
        let length = turn.iter().map(|q| q * q).sum::<f64>().sqrt();
        let turn = turn.map(|q| q / length);
        PlacedMesh { position: away, orientation: product(turn, self.orientation) }
    }
}

/// The rotation `b`, then `a`.
pub fn product(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    let ([ax, ay, az, aw], [bx, by, bz, bw]) = (a, b);
    [
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    ]
}
