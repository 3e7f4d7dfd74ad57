//! Volume of fluid that a part displaces in the domain, and its first moments.
//!
//! Buoyancy is that of what of a part lies in the domain, as if fluid stood all around it: also
//! where it rests on a floor, or a face cuts it. So it is the same for a part that is fixed, moves
//! or lies free. A cavity displaces less than nothing: the fluid in it weighs on it. A part that
//! reaches from one face to the opposite one, as a pipe does or a column, shows the fluid no ends
//! there: along that axis those do not count, and a straight one feels nothing.
//!
//! By the theorem of Gauss, with the axis in question as x, over the part of the surface that lies
//! between the planes across y and z, and for the areas of the ends over what lies beyond the
//! planes across x:
//!
//! ```text
//! V = int (min(max(x, x_lower), x_upper) - x_lower) n_x dA        V_x = V - (x_upper - x_lower) (A_lower + A_upper)/2
//! ```
//!
//! and alike for the first moments: pressure counts from the middle between the ends. Triangles are
//! cut at the planes, and the integrals over the pieces are exact.

use crate::cells::grid::{Grid, Side};
use crate::cells::vector::cross;
use tremie_geometry::{Bounds, Mesh, Vec3};

/// Fluid that a part displaces, by the axis of the acceleration that is balanced: volume, and the
/// integral of position over it, from a point of reference.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Displaced {
    /// Volumes.
    pub volume: [f64; 3],
    /// First moments.
    pub moment: [[f64; 3]; 3],
}

/// Of an end that lies in a face, or beyond it: as part of the domain's length, what counts as in
/// it.
const FLUSH: f64 = 1e-9;

/// Corners of a triangle that was cut by six planes.
#[derive(Clone, Copy)]
struct Polygon {
    corners: [[f64; 3]; 12],
    count: usize,
}

impl Polygon {
    const NONE: Self = Self { corners: [[0.0; 3]; 12], count: 0 };

    fn push(&mut self, corner: [f64; 3]) {
        self.corners[self.count] = corner;
        self.count += 1;
    }

    fn corners(&self) -> &[[f64; 3]] {
        &self.corners[..self.count]
    }

    /// Part of it where `sign x_a <= sign at`.
    fn below(&self, a: usize, at: f64, sign: f64) -> Self {
        let mut kept = Self::NONE;
        for (k, &from) in self.corners().iter().enumerate() {
            let to = self.corners()[(k + 1) % self.count];
            let (d, next) = (sign * (from[a] - at), sign * (to[a] - at));
            if d <= 0.0 {
                kept.push(from);
            }
            if (d < 0.0 && next > 0.0) || (d > 0.0 && next < 0.0) {
                let s = d / (d - next);
                let mut corner = std::array::from_fn(|b| from[b] + s * (to[b] - from[b]));
                corner[a] = at;
                kept.push(corner);
            }
        }
        kept
    }
}

/// Integrals of 1 and of position over an area or a volume.
#[derive(Clone, Copy, Debug, Default)]
struct VolumeSums {
    zeroth: f64,
    first: [f64; 3],
}

impl VolumeSums {
    fn add(&mut self, weight: f64, at: [f64; 3]) {
        self.zeroth += weight;
        for a in 0..3 {
            self.first[a] += weight * at[a];
        }
    }
}

impl Displaced {
    /// Of a volume with its centre at a place, wherever that is.
    pub fn whole(volume: f64, middle: [f64; 3]) -> Self {
        Self { volume: [volume; 3], moment: [middle.map(|x| x * volume); 3] }
    }

    /// Force and torque about the reference in a fluid at rest that gives so much to each volume.
    pub fn load(&self, lift: [f64; 3]) -> [[f64; 3]; 2] {
        let mut torque = [0.0; 3];
        for (a, moment) in self.moment.iter().enumerate() {
            let mut along = [0.0; 3];
            along[a] = lift[a];
            let own = cross(*moment, along);
            (0..3).for_each(|k| torque[k] += own[k]);
        }
        [std::array::from_fn(|a| lift[a] * self.volume[a]), torque]
    }

    /// By a closed mesh in a window, its vertices being placed by `place`; moments are about
    /// `reference`.
    pub fn by(
        mesh: &Mesh,
        place: impl Fn([f64; 3]) -> [f64; 3],
        window: &Bounds,
        reference: [f64; 3],
    ) -> Self {
        let placed = || {
            (0..mesh.triangles.len()).map(|triangle| {
                mesh.corners(triangle).map(|corner| {
                    let corner = place(corner.into());
                    std::array::from_fn::<f64, 3, _>(|a| corner[a] - reference[a])
                })
            })
        };
        let own = Bounds::of(placed().flatten());
        let window = Bounds {
            min: window.min - Vec3::from(reference),
            max: window.max - Vec3::from(reference),
        };
        let held = Bounds {
            min: Vec3::from_fn(|a, _| own.min[a].clamp(window.min[a], window.max[a])),
            max: Vec3::from_fn(|a, _| own.max[a].clamp(window.min[a], window.max[a])),
        };
        let mut all = Self::default();
        for axis in 0..3 {
            // The axis first: cyclic, so that normals keep their side.
            let turned = |x: [f64; 3]| std::array::from_fn(|a| x[(axis + a) % 3]);
            let [held, window] = [held, window].map(|bounds| Bounds {
                min: turned(bounds.min.into()).into(),
                max: turned(bounds.max.into()).into(),
            });
            let triangles = placed().map(|corners| corners.map(turned));
            let sums = along(triangles, &held, &window);
            all.volume[axis] = sums.zeroth;
            all.moment[axis] = std::array::from_fn(|a| sums.first[(a + 3 - axis) % 3]);
        }
        all
    }
}

/// Volume and first moments that count along the first axis.
fn along(
    triangles: impl Iterator<Item = [[f64; 3]; 3]>,
    held: &Bounds,
    window: &Bounds,
) -> VolumeSums {
    let (lower, upper) = (held.min[0], held.max[0]);
    let length = window.max[0] - window.min[0];
    let inside = [window.min[0] + FLUSH * length, window.max[0] - FLUSH * length];
    let (mut volume, mut ends) = (VolumeSums::default(), [VolumeSums::default(); 2]);
    for corners in triangles {
        let mut polygon = Polygon::NONE;
        corners.into_iter().for_each(|corner| polygon.push(corner));
        for a in [1, 2] {
            polygon = polygon.below(a, held.max[a], 1.0).below(a, held.min[a], -1.0);
        }
        let within = polygon.below(0, upper, 1.0).below(0, lower, -1.0);
        within.each(|area, at| {
            // The moment along the axis is half of the square.
            let [x, y, z] = at;
            volume.add(area * (x - lower), [0.5 * (x + lower), y, z]);
        });
        // A triangle in the plane itself is within.
        if polygon.corners().iter().any(|corner| corner[0] > upper) {
            polygon.below(0, upper, -1.0).each(|area, [_, y, z]| {
                volume.add(area * (upper - lower), [0.5 * (upper + lower), y, z]);
            });
        }
        if length.is_finite() {
            polygon.below(0, inside[0], 1.0).each(|area, at| ends[0].add(-area, at));
            polygon.below(0, inside[1], -1.0).each(|area, at| ends[1].add(area, at));
        }
    }
    let least = 1e-9 * (held.max[1] - held.min[1]) * (held.max[2] - held.min[2]);
    if ends.iter().all(|end| end.zeroth.abs() > least) {
        for end in ends {
            let half = -0.5 * (upper - lower);
            volume.zeroth += half * end.zeroth;
            for a in [1, 2] {
                volume.first[a] += half * end.first[a];
            }
        }
    }
    volume
}

impl Polygon {
    /// Calls `visit` with parts of `n_x dA` and where they are, so that sums of quadratic functions
    /// are exact.
    fn each(&self, mut visit: impl FnMut(f64, [f64; 3])) {
        let corners = self.corners();
        for k in 2..corners.len() {
            let [a, b, c] = [corners[0], corners[k - 1], corners[k]];
            let area = 0.5 * ((b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1]));
            for [p, q] in [[a, b], [b, c], [c, a]] {
                visit(area / 3.0, std::array::from_fn(|i| 0.5 * (p[i] + q[i])));
            }
        }
    }
}

/// Bounds in which a part counts whose extent along each axis is given: between the faces; beyond a
/// symmetry plane in which it is its own image, as far as on this side; and beyond periodic faces
/// as a whole, unless it is as long as the domain. The box of cells begins at `min`.
pub fn window(
    grid: &Grid,
    (min, cell): ([f64; 3], f64),
    extent: [f64; 3],
    mirrors: [bool; 3],
) -> Bounds {
    let mut bounds = Bounds {
        min: Vec3::from_element(f64::NEG_INFINITY),
        max: Vec3::from_element(f64::INFINITY),
    };
    for a in 0..3 {
        let length = f64::from(grid.n[a]) * cell;
        if grid.periodic[a] && extent[a] < length * (1.0 - FLUSH) {
            continue;
        }
        let beyond = |side: usize| {
            if mirrors[a] && grid.sides[a][side] == Side::Symmetry { length } else { 0.0 }
        };
        (bounds.min[a], bounds.max[a]) = (min[a] - beyond(0), min[a] + length + beyond(1));
    }
    bounds
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use tremie_geometry::Surface;
    use tremie_messages::scene::Geometry;

    fn box_of(size: [f64; 3]) -> Surface {
        Surface::of(&Geometry::Box { size }).unwrap()
    }

    proptest! {
        /// A box that is cut by another is a box.
        #[test]
        fn a_box_in_a_box_is_a_box(
            size in prop::array::uniform3(0.5..2.0f64),
            at in prop::array::uniform3(-1.0..1.0f64),
            lower in prop::array::uniform3(-1.0..0.2f64),
            extent in prop::array::uniform3(0.1..2.0f64),
        ) {
            let upper: [f64; 3] = std::array::from_fn(|a| lower[a] + extent[a]);
            let bounds = Bounds { min: lower.into(), max: upper.into() };
            let surface = box_of(size);
            let place = |p: [f64; 3]| std::array::from_fn(|a| p[a] + at[a]);
            let reference = [0.3, -0.2, 0.7];
            let found = Displaced::by(surface.mesh(), place, &bounds, reference);
            let ends: [[f64; 2]; 3] = std::array::from_fn(|a| {
                let low = (at[a] - 0.5 * size[a]).max(lower[a]);
                [low, (at[a] + 0.5 * size[a]).min(upper[a]).max(low)]
            });
            let volume: f64 = ends.iter().map(|[low, high]| high - low).product();
            for axis in 0..3 {
                // From face to face it shows no ends.
                let is_through = ends[axis] == [lower[axis], upper[axis]];
                let volume = if is_through { 0.0 } else { volume };
                prop_assert!((found.volume[axis] - volume).abs() < 1e-12, "{axis} {found:?} {volume}");
                for a in (0..3).filter(|&a| !is_through || a != axis) {
                    let middle = 0.5 * (ends[a][0] + ends[a][1]) - reference[a];
                    let moment = found.moment[axis][a];
                    prop_assert!((moment - volume * middle).abs() < 1e-12, "{axis} {a} {found:?}");
                }
            }
        }
    }

    /// Half a sphere, and its centroid at 3/8 of the radius, as the moments of the whole mesh are.
    #[test]
    fn half_a_sphere_displaces_half() {
        let surface = Surface::of(&Geometry::Sphere { radius: 1.0 }).unwrap();
        let whole = surface.mesh().moments().volume;
        for a in 0..3 {
            for side in [1.0, -1.0] {
                let mut bounds = Bounds::of([[-2.0; 3], [2.0; 3]]);
                if side > 0.0 {
                    bounds.min[a] = 0.0
                } else {
                    bounds.max[a] = 0.0
                }
                let found = Displaced::by(surface.mesh(), |p| p, &bounds, [0.0; 3]);
                assert!((found.volume[a] / whole - 0.5).abs() < 1e-3, "{found:?} {whole}");
                let middle = found.moment[(a + 1) % 3][a] / found.volume[0];
                assert!((middle - 0.375 * side).abs() < 2e-3, "{a} {side}: {middle}");
            }
        }
        let bounds = Bounds::of([[-2.0; 3], [2.0; 3]]);
        let all = Displaced::by(&surface.inside_out().mesh().clone(), |p| p, &bounds, [0.0; 3]);
        assert!(all.volume.iter().all(|volume| (volume + whole).abs() < 1e-12));
    }
}
