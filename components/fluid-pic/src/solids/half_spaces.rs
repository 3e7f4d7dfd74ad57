//! Convex solids as common parts of half spaces, and what of faces and cells they cover, exactly.

use crate::solids::section::Section;
use tremie_geometry::{Convex, Frame, Vec3};

/// What lies so near to a face and along it covers it, as part of the edge: rounding must not open a
/// face that the solid is flush with.
const FLUSH: f64 = 1e-9;

/// Most half spaces of a solid.
const MOST: usize = Convex::MOST_FACES;
/// Most corners of a square cut by so many.
const MOST_CORNERS: usize = MOST + 4;

/// A convex solid where it is.
#[derive(Clone, Copy, Debug)]
pub struct HalfSpaces<const D: usize> {
    /// Outward unit normals in the world and offsets, as far as the grid sees them.
    planes: [([f64; D], f64); MOST],
    count: usize,
}

/// Covered part of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Covered<const D: usize> {
    /// Its share of the face.
    pub share: f64,
    /// Its centre [m].
    pub centre: [f64; D],
}

/// A polygon of few corners.
struct Polygon {
    corners: [[f64; 2]; MOST_CORNERS],
    count: usize,
}

impl Polygon {
    fn square(lower: [f64; 2], h: f64) -> Self {
        let [x, y] = lower;
        let mut corners = [[0.0; 2]; MOST_CORNERS];
        corners[..4].copy_from_slice(&[[x, y], [x + h, y], [x + h, y + h], [x, y + h]]);
        Self { corners, count: 4 }
    }

    /// Keeps what lies where `normal . x <= offset` (Sutherland & Hodgman 1974).
    fn clip(&mut self, normal: [f64; 2], offset: f64) {
        let over = |c: [f64; 2]| normal[0] * c[0] + normal[1] * c[1] - offset;
        let whole = &self.corners[..self.count];
        if whole.iter().all(|&corner| over(corner) <= 0.0) {
            return;
        }
        let mut kept = [[0.0; 2]; MOST_CORNERS];
        let mut count = 0;
        let mut keep = |corner: [f64; 2]| {
            if count < MOST_CORNERS {
                kept[count] = corner;
                count += 1;
            }
        };
        for k in 0..whole.len() {
            let (from, to) = (whole[k], whole[(k + 1) % whole.len()]);
            let (start, end) = (over(from), over(to));
            if start <= 0.0 {
                keep(from);
            }
            if (start <= 0.0) != (end <= 0.0) {
                let part = start / (start - end);
                keep([0, 1].map(|a| from[a] + part * (to[a] - from[a])));
            }
        }
        (self.corners, self.count) = (kept, count);
    }

    /// Area and centre.
    fn measure(&self) -> (f64, [f64; 2]) {
        let origin = self.corners[0];
        let (mut twice, mut moment) = (0.0, [0.0; 2]);
        for k in 1..self.count.saturating_sub(1) {
            let [p, q] = [k, k + 1].map(|k| [0, 1].map(|a| self.corners[k][a] - origin[a]));
            let area = p[0] * q[1] - p[1] * q[0];
            twice += area;
            (0..2).for_each(|a| moment[a] += area * (p[a] + q[a]) / 3.0);
        }
        if twice <= 0.0 {
            return (0.0, origin);
        }
        (0.5 * twice, [0, 1].map(|a| origin[a] + moment[a] / twice))
    }
}

impl<const D: usize> HalfSpaces<D> {
    /// A polyhedron of a size, in a frame.
    pub fn of(convex: &Convex, size: f64, frame: &Frame, section: &Section<D>) -> Self {
        let mut own = Self { planes: [([0.0; D], 0.0); MOST], count: 0 };
        for face in convex.faces().iter().take(MOST) {
            let normal = frame.turn_to_world(face.normal);
            let origin = frame.to_world([0.0; 3]);
            // The plane's points of the section: what lies across it is a constant.
            let across: f64 = (0..3)
                .filter(|axis| !section.axes.contains(axis))
                .map(|axis| normal[axis] * section.through[axis])
                .sum();
            let offset = size * face.offset + normal.dot(&origin) - across;
            own.planes[own.count] = (section.along(normal.into()), offset);
            own.count += 1;
        }
        own
    }

    /// All that lies on the far side of a plane from its normal.
    pub fn beyond(point: [f64; 3], normal: [f64; 3], section: &Section<D>) -> Self {
        let mut own = Self { planes: [([0.0; D], 0.0); MOST], count: 1 };
        let offset = section.axes.iter().map(|&axis| normal[axis] * point[axis]).sum();
        own.planes[0] = (section.along(normal), offset);
        own
    }

    fn planes(&self) -> &[([f64; D], f64)] {
        &self.planes[..self.count]
    }

    /// Height of a point over the plane that it is farthest beyond: negative inside, and the
    /// distance there; and that plane's normal.
    pub fn height(&self, point: [f64; D]) -> (f64, [f64; D]) {
        let over = |(normal, offset): &([f64; D], f64)| {
            (0..D).map(|a| normal[a] * point[a]).sum::<f64>() - offset
        };
        let mut highest = (f64::NEG_INFINITY, [0.0; D]);
        for plane in self.planes() {
            let height = over(plane);
            // A plane across the section has no normal in it, and says inside or out.
            if height > highest.0 {
                highest = (height, plane.0);
            }
        }
        highest
    }

    /// Part of a segment that it covers, as fractions of the segment.
    pub fn span(&self, from: [f64; D], to: [f64; D]) -> Option<[f64; 2]> {
        self.span_of(from, to, |_| 0.0)
    }

    /// The same, with planes moved outwards by a distance that depends on their normal.
    #[inline]
    fn span_of(
        &self,
        from: [f64; D],
        to: [f64; D],
        slack: impl Fn(&[f64; D]) -> f64,
    ) -> Option<[f64; 2]> {
        let (mut first, mut last) = (0.0_f64, 1.0_f64);
        for (normal, offset) in self.planes() {
            let offset = offset + slack(normal);
            let over = |p: [f64; D]| (0..D).map(|a| normal[a] * p[a]).sum::<f64>() - offset;
            let (start, end) = (over(from), over(to));
            match (start <= 0.0, end <= 0.0) {
                (true, true) => {}
                (false, false) => return None,
                (false, true) => first = first.max(start / (start - end)),
                (true, false) => last = last.min(start / (start - end)),
            }
        }
        (first < last).then_some([first, last])
    }

    /// The polygon that it covers of a square across `axis` (three dimensions).
    fn of_square(&self, axis: usize, lower: [f64; D], h: f64) -> (f64, [f64; 2]) {
        let [b, c] = others(axis);
        let mut polygon = Polygon::square([lower[b], lower[c]], h);
        for (normal, offset) in self.planes() {
            let offset = offset + flush(normal, axis, h);
            polygon.clip([normal[b], normal[c]], offset - normal[axis] * lower[axis]);
            if polygon.count == 0 {
                return (0.0, [0.0; 2]);
            }
        }
        polygon.measure()
    }

    /// Covered part of the lower face across an axis of a cell with this lower corner.
    pub fn face(&self, axis: usize, lower: [f64; D], h: f64) -> Covered<D> {
        let mut centre = lower;
        if D == 2 {
            let along = 1 - axis;
            let mut to = lower;
            to[along] += h;
            let slack = |normal: &[f64; D]| flush(normal, axis, h);
            let Some([first, last]) = self.span_of(lower, to, slack) else {
                return Covered { share: 0.0, centre };
            };
            centre[along] += 0.5 * (first + last) * h;
            return Covered { share: last - first, centre };
        }
        let (area, middle) = self.of_square(axis, lower, h);
        let [b, c] = others(axis);
        (centre[b], centre[c]) = (middle[0], middle[1]);
        Covered { share: area / (h * h), centre }
    }

    /// Covered share of a cell with this lower corner.
    pub fn cell(&self, lower: [f64; D], h: f64) -> f64 {
        if D == 2 {
            let mut polygon = Polygon::square([lower[0], lower[1]], h);
            for (normal, offset) in self.planes() {
                polygon.clip([normal[0], normal[1]], *offset);
                if polygon.count == 0 {
                    return 0.0;
                }
            }
            return polygon.measure().0 / (h * h);
        }
        self.volume(lower, h) / (h * h * h)
    }

    /// Volume of what it shares with a cube, by the divergence theorem: a third of the sum over all
    /// faces of their area times their distance from the cube's middle (three dimensions).
    fn volume(&self, lower: [f64; D], h: f64) -> f64 {
        let centre = lower.map(|x| x + 0.5 * h);
        let far = 0.5 * h * 3.0_f64.sqrt();
        let height = |(normal, offset): &([f64; D], f64)| {
            offset - (0..D).map(|a| normal[a] * centre[a]).sum::<f64>()
        };
        if self.planes().iter().any(|plane| height(plane) < -far) {
            return 0.0;
        }
        let mut sum = 0.0;
        for axis in 0..D {
            let mut upper = lower;
            upper[axis] += h;
            sum += 0.5 * h * (self.of_square(axis, lower, h).0 + self.of_square(axis, upper, h).0);
        }
        for (k, plane) in self.planes().iter().enumerate() {
            let distance = height(plane);
            if distance.abs() < far {
                sum += distance * self.on_plane(k, centre, distance, h);
            }
        }
        (sum / 3.0).max(0.0)
    }

    /// Area of its face on plane `k` inside a cube about `centre`, from whose middle the plane is at
    /// a distance (three dimensions).
    fn on_plane(&self, k: usize, centre: [f64; D], distance: f64, h: f64) -> f64 {
        let normal = self.planes[k].0;
        let n = Vec3::from(std::array::from_fn(|a| normal[a]));
        let least = n.iamin();
        let Some(u) = n.cross(&Vec3::ith(least, 1.0)).try_normalize(0.0) else { return 0.0 };
        let v = n.cross(&u);
        let foot = n * distance;
        let mut polygon = Polygon::square([-h; 2], 2.0 * h);
        let mut clip = |m: Vec3, offset: f64| {
            polygon.clip([m.dot(&u), m.dot(&v)], offset - m.dot(&foot));
        };
        for a in 0..3 {
            clip(Vec3::ith(a, 1.0), 0.5 * h);
            clip(-Vec3::ith(a, 1.0), 0.5 * h);
        }
        for (other, (m, offset)) in self.planes().iter().enumerate() {
            if other != k {
                let m = Vec3::from(std::array::from_fn(|a| m[a]));
                let over = (0..3).map(|a| m[a] * centre[a]).sum::<f64>();
                clip(m, offset - over);
            }
        }
        polygon.measure().0
    }
}

/// Distance by which a plane that lies along a face across an axis is moved outwards.
#[inline]
fn flush<const D: usize>(normal: &[f64; D], axis: usize, h: f64) -> f64 {
    if normal[axis].abs() > 1.0 - 1e-9 { FLUSH * h } else { 0.0 }
}

/// The two other axes, in their order.
fn others(axis: usize) -> [usize; 2] {
    [[1, 2], [0, 2], [0, 1]][axis]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use tremie_messages::scene::Pose;

    fn cuboid(size: [f64; 3], orientation: [f64; 4], position: [f64; 3]) -> (Convex, Frame) {
        let corners: Vec<[f64; 3]> = (0..8)
            .map(|k| std::array::from_fn(|a| (f64::from(k >> a & 1) - 0.5) * size[a]))
            .collect();
        (Convex::hull(&corners).unwrap(), Frame::of(&Pose { position, orientation }))
    }

    proptest! {
        /// Cells add up to the solid.
        #[test]
        fn cells_add_up_to_the_solid(
            x in 0.0..0.1_f64, y in 0.0..0.1_f64, z in 0.0..0.1_f64,
            q in proptest::array::uniform4(-1.0..1.0_f64),
        ) {
            prop_assume!(q.iter().map(|q| q * q).sum::<f64>() > 0.1);
            let (convex, frame) = cuboid([0.5, 0.3, 0.37], q, [x, y, z]);
            let solid = HalfSpaces::<3>::of(&convex, 1.0, &frame, &Section::SPACE);
            let h = 0.1;
            let mut volume = 0.0;
            for i in -6..7 {
                for j in -6..7 {
                    for k in -6..7 {
                        volume += solid.cell([i, j, k].map(|n| f64::from(n) * h), h) * h * h * h;
                    }
                }
            }
            prop_assert!((volume / (0.5 * 0.3 * 0.37) - 1.0).abs() < 1e-9, "{}", volume);
        }
    }

    #[test]
    fn a_box_along_the_axes_is_exact() {
        let (convex, frame) = cuboid([0.35, 0.25, 0.15], [0.0, 0.0, 0.0, 1.0], [0.075, 0.0, 0.0]);
        let solid = HalfSpaces::<3>::of(&convex, 1.0, &frame, &Section::SPACE);
        // From -0.1 to 0.25 along x, -0.125 to 0.125 along y, -0.075 to 0.075 along z.
        let face = solid.face(2, [0.2, 0.1, 0.0], 0.1);
        assert!((face.share - 0.5 * 0.25).abs() < 1e-12, "{face:?}");
        assert!((face.centre[0] - 0.225).abs() < 1e-12 && (face.centre[1] - 0.1125).abs() < 1e-12);
        assert!((solid.cell([0.2, 0.1, 0.0], 0.1) - 0.5 * 0.25 * 0.75).abs() < 1e-12);
        assert_eq!(solid.face(2, [0.2, 0.1, 0.1], 0.1).share, 0.0);
        let flat = Section::<2> { axes: [0, 2], through: [0.0; 3] };
        let solid = HalfSpaces::of(&convex, 1.0, &frame, &flat);
        assert!((solid.cell([0.2, 0.0], 0.1) - 0.5 * 0.75).abs() < 1e-12);
        assert!((solid.face(0, [0.2, 0.0], 0.1).share - 0.75).abs() < 1e-12);
        assert!((solid.height([0.26, 0.0]).0 - 0.01).abs() < 1e-12);
    }

    /// A face in the plane of a solid's side is covered, whatever rounding says.
    #[test]
    fn a_face_that_is_flush_is_covered() {
        let flat = Section::<2> { axes: [0, 2], through: [0.0; 3] };
        for cells in 1..60 {
            let h = 0.0125;
            let (low, high) = (0.4, f64::from(cells).mul_add(h, 0.4));
            let (convex, frame) = cuboid(
                [high - low, 0.2, 0.1],
                [0.0, 0.0, 0.0, 1.0],
                [0.5 * (low + high), 0.0, 0.05],
            );
            let end = f64::from(32 + cells) * h;
            let solid = HalfSpaces::<2>::of(&convex, 1.0, &frame, &flat);
            assert_eq!(solid.face(0, [end, 0.025], h).share, 1.0, "{cells}");
            let solid = HalfSpaces::<3>::of(&convex, 1.0, &frame, &Section::SPACE);
            assert!((solid.face(0, [end, 0.0, 0.025], h).share - 1.0).abs() < 1e-9, "{cells}");
        }
    }
}
