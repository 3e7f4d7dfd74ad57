//! The space of the fluid: conduit, bore, cone and chamber, as one closed surface.
//!
//! Conduit and bore have the same radius, so that they meet in two ellipses, in planes at 45
//! degrees to both. Cut into the same sectors, conduit and bore share the corners of these
//! ellipses, and the surface closes without a cut.

use super::dimensions::{Closure, Dimensions};
use std::cmp::Ordering;
use std::f64::consts::{FRAC_1_SQRT_2, PI};
use tremie_geometry::{CYLINDER_SEGMENTS, GeometryError, Mesh, Vec3, mend};

/// Sectors around.
const N: usize = CYLINDER_SEGMENTS as usize;

/// The surface of the space that the fluid may fill, in the valve's frame [m]; it reaches `beyond`
/// [m] past the openings, so that the faces of a domain there are open.
pub fn frame(valve: &Dimensions, beyond: f64) -> Result<Mesh, GeometryError> {
    let step = 2.0 * PI / N as f64;
    let mut frame = Frame {
        mesh: Mesh::default(),
        // Polygons of the same area as the circles: flow areas are exact.
        stretch: (step / libm::sin(step)).sqrt(),
        axis: valve.conduit_axis.0,
    };
    let bore = frame.stretch * valve.bore_radius.0;
    let inlet = valve.inlet.0 - beyond;
    let end = match valve.closure {
        Closure::Pressure => valve.blind_end.0.max(bore),
        Closure::Safety => valve.orifice[0].0.max(bore),
    };
    frame.conduit(bore, inlet, end);
    frame.bore(bore, -valve.cone_depth());
    frame.about_conduit(&[[0.0, inlet], [valve.bore_radius.0, inlet]]);
    match valve.closure {
        Closure::Pressure => frame.about_conduit(&[[valve.bore_radius.0, end], [0.0, end]]),
        Closure::Safety => {
            let (wide, narrow) = (valve.bore_radius.0, valve.orifice_radius.0);
            let (back, outlet) = (valve.orifice[1].0, valve.second_outlet.0 + beyond);
            let profile = [
                [wide, end],
                [narrow, end],
                [narrow, back],
                [wide, back],
                [wide, outlet],
                [0.0, outlet],
            ];
            frame.about_conduit(&profile);
        }
    }
    let (chamber, top) = (valve.chamber_radius.0, valve.chamber_height.0 + beyond);
    // Open at the bottom edge, where the bore's wall ends; `mend` joins equal corners.
    frame.about_valve(&[
        [valve.bore_radius.0, -valve.cone_depth()],
        [valve.rubber_inner_radius.0, 0.0],
        [chamber, 0.0],
        [chamber, top],
        [0.0, top],
    ]);
    mend(frame.mesh).map(|(mesh, _)| mesh)
}

struct Frame {
    mesh: Mesh,
    /// Ratio of the radii of corners to those of circles.
    stretch: f64,
    /// Height of the conduit's axis [m].
    axis: f64,
}

impl Frame {
    fn triangle(&mut self, corners: [Vec3; 3]) {
        let first = self.mesh.vertices.len() as u32;
        self.mesh.vertices.extend(corners);
        self.mesh.triangles.push([first, first + 1, first + 2]);
    }

    /// Two triangles, less those without area.
    fn quad(&mut self, [a, b, c, d]: [Vec3; 4]) {
        for corners in [[a, b, c], [a, c, d]] {
            let [p, q, r] = corners;
            if p != q && q != r && r != p {
                self.triangle(corners);
            }
        }
    }

    /// The conduit's wall from `from` to `to` along z, open where the bore leaves it upwards.
    fn conduit(&mut self, radius: f64, from: f64, to: f64) {
        let axis = self.axis;
        let at = |k: usize, z: f64| {
            let [cos, sin] = direction(k);
            Vec3::new(radius * cos, axis + radius * sin, z)
        };
        for k in 0..N {
            let (a, b) = (k, k + 1);
            // Half the opening's width along z at each edge; none in the lower half.
            let [wa, wb] = [a, b].map(|k| radius * direction(k)[1].max(0.0));
            self.quad([at(a, from), at(b, from), at(b, -wb), at(a, -wa)]);
            self.quad([at(a, wa), at(b, wb), at(b, to), at(a, to)]);
        }
    }

    /// The bore's wall from the conduit up to `top`.
    fn bore(&mut self, radius: f64, top: f64) {
        let axis = self.axis;
        let foot = |k: usize| {
            let [cos, sin] = direction(k);
            Vec3::new(radius * cos, axis + (radius * sin).abs(), radius * sin)
        };
        for k in 0..N {
            let [a, b] = [foot(k), foot(k + 1)];
            self.quad([a, b, Vec3::new(b.x, top, b.z), Vec3::new(a.x, top, a.z)]);
        }
    }

    /// Adds the surface of revolution of a profile of corners `[r, z]` [m] about the conduit's
    /// axis.
    fn about_conduit(&mut self, profile: &[[f64; 2]]) {
        let (axis, stretch) = (self.axis, self.stretch);
        self.sweep(profile, |[cos, sin], [r, z]| {
            let r = stretch * r;
            Vec3::new(r * cos, axis + r * sin, z)
        });
    }

    /// Adds the surface of revolution of a profile of corners `[r, y]` [m] about the valve's axis.
    fn about_valve(&mut self, profile: &[[f64; 2]]) {
        let stretch = self.stretch;
        self.sweep(profile, |[cos, sin], [r, y]| {
            let r = stretch * r;
            Vec3::new(r * cos, y, r * sin)
        });
    }

    fn sweep(&mut self, profile: &[[f64; 2]], at: impl Fn([f64; 2], [f64; 2]) -> Vec3) {
        for edge in profile.windows(2) {
            for k in 0..N {
                let (a, b) = (direction(k), direction(k + 1));
                self.quad([at(a, edge[0]), at(b, edge[0]), at(b, edge[1]), at(a, edge[1])]);
            }
        }
    }
}

/// Cosine and sine of corner `k`, mirrored exactly from one eighth of the circle to the others.
fn direction(k: usize) -> [f64; 2] {
    let k = k % N;
    let (quarter, rest) = (k / (N / 4), k % (N / 4));
    let eighth = |k: usize| {
        let (sin, cos) = libm::sincos(2.0 * PI * k as f64 / N as f64);
        [cos, sin]
    };
    let [c, s] = match rest.cmp(&(N / 8)) {
        Ordering::Less => eighth(rest),
        Ordering::Equal => [FRAC_1_SQRT_2; 2],
        Ordering::Greater => {
            let [c, s] = eighth(N / 4 - rest);
            [s, c]
        }
    };
    // Zero stays positive: equal corners have equal bits.
    [[c, s], [-s, c], [-c, -s], [s, -c]][quarter].map(|x| x + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_geometry::Surface;
    use tremie_messages::units::Length;

    /// Volume of conduit, bore, cone and chamber; what conduit and bore share is half of
    /// Steinmetz's solid, 8/3 R³. 1e-5, as the polygons share a little less.
    #[test]
    fn the_frame_is_closed_and_has_its_volume() {
        for closure in [Closure::Pressure, Closure::Safety] {
            let valve = Dimensions { closure, ..Dimensions::default() };
            let mesh = frame(&valve, 1e-3).unwrap();
            let (r, inner) = (valve.bore_radius.0, valve.rubber_inner_radius.0);
            let (chamber, depth) = (valve.chamber_radius.0, valve.cone_depth());
            let along = match closure {
                Closure::Pressure => (valve.blind_end.0 - valve.inlet.0 + 1e-3) * r * r,
                Closure::Safety => {
                    let wide = (7.0 + 15.6 + 15.6 - 9.0 + 2.0) * 1e-3;
                    wide * r * r + 2e-3 * 4e-6
                }
            };
            let up = (-depth - valve.conduit_axis.0) * r * r;
            let round = along
                + up
                + depth / 3.0 * (r * r + r * inner + inner * inner)
                + (valve.chamber_height.0 + 1e-3) * chamber * chamber;
            let volume = PI * round - 8.0 / 3.0 * r.powi(3);
            let found = mesh.moments().volume;
            assert!((found / volume - 1.0).abs() < 1e-5, "{found} {volume}");
            let surface = Surface::new(mesh).unwrap();
            assert!(surface.contains([0.0, -9e-3, -15e-3]) && surface.contains([0.0, -5e-3, 0.0]));
            assert!(!surface.contains([0.0, -2e-3, 6e-3]));
        }
    }

    #[test]
    fn one_half_is_the_image_of_the_other() {
        let mesh = frame(&Dimensions::default(), 1e-3).unwrap();
        let sorted = |sign: f64| {
            let mut points: Vec<_> =
                mesh.vertices.iter().map(|v| [sign * v.x + 0.0, v.y, v.z]).collect();
            points.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
            points
        };
        assert_eq!(sorted(1.0), sorted(-1.0));
    }

    #[test]
    fn any_bore_closes() {
        for radius in [2e-3, 3.3e-3, 4.75e-3] {
            let valve = Dimensions {
                bore_radius: Length(radius),
                blind_end: Length(1.5 * radius),
                ..Dimensions::default()
            };
            assert_eq!(valve.misfits(), []);
            frame(&valve, 5e-4).unwrap();
        }
    }
}
