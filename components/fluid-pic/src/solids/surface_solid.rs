//! Solids of triangulated surfaces. What they cover of a face is exact along one of its edges, and
//! the middle of some strips along the other.

use crate::solids::half_spaces::Covered;
use crate::solids::section::Section;
use std::sync::Arc;
use tremie_geometry::{Bounds, Frame, Surface, Vec3};

/// Most crossings of a line with a surface within a cell.
const CROSSINGS: usize = 8;
/// Distance on either side at which a face is looked at, as part of its edge: rounding must not open
/// one that the solid is flush with.
const FLUSH: f64 = 1e-9;
/// Step past a crossing, as part of the segment.
const PAST: f64 = 1e-9;

/// A solid of a triangulated surface, where it is.
#[derive(Clone, Debug)]
pub struct SurfaceSolid<const D: usize> {
    /// Its surface, in its own frame.
    pub surface: Arc<Surface>,
    /// That frame.
    pub frame: Frame,
    /// Where the grid is.
    pub section: Section<D>,
    /// Strips of a face.
    pub strips: usize,
}

impl<const D: usize> SurfaceSolid<D> {
    fn seen(&self, point: [f64; D]) -> Vec3 {
        self.frame.to_part(self.section.to_world(point))
    }

    /// Box around it in the world [m].
    pub fn bounds(&self) -> Bounds {
        let vertices = self.surface.mesh().vertices.iter();
        Bounds::of(vertices.map(|&vertex| self.frame.to_world(vertex)))
    }

    /// True if it holds a point.
    pub fn holds(&self, point: [f64; D]) -> bool {
        self.surface.contains(self.seen(point))
    }

    /// Where a segment first meets the surface, as part of it.
    pub fn first_met(&self, from: [f64; D], to: [f64; D]) -> Option<f64> {
        let crossing = self.surface.first_crossing(self.seen(from), self.seen(to))?;
        Some(crossing.fraction)
    }

    /// Distance of a point, negative inside, and the outward normal, if the surface is within
    /// reach.
    pub fn height(&self, point: [f64; D], reach: f64) -> Option<(f64, [f64; D])> {
        let closest = self.surface.closest_within(self.seen(point), reach)?;
        let normal = self.frame.turn_to_world(closest.normal);
        Some((closest.distance, self.section.along(normal.into())))
    }

    /// Covered share of a segment, and the middle of what is covered as part of it.
    fn on_segment(&self, from: [f64; D], to: [f64; D]) -> (f64, f64) {
        let (start, end) = (self.seen(from), self.seen(to));
        let at = |part: f64| start + (end - start) * part;
        let mut ends = [0.0; CROSSINGS + 2];
        let mut count = 1;
        while count <= CROSSINGS {
            let past = ends[count - 1] + if count > 1 { PAST } else { 0.0 };
            if past >= 1.0 {
                break;
            }
            let Some(crossing) = self.surface.first_crossing(at(past), end) else { break };
            ends[count] = (past + crossing.fraction * (1.0 - past)).min(1.0);
            count += 1;
        }
        ends[count] = 1.0;
        let (mut covered, mut moment) = (0.0, 0.0);
        for pair in ends[..=count].windows(2) {
            let (length, middle) = (pair[1] - pair[0], 0.5 * (pair[0] + pair[1]));
            if length > 2.0 * PAST && self.surface.contains(at(middle)) {
                covered += length;
                moment += length * middle;
            }
        }
        (covered, if covered > 0.0 { moment / covered } else { 0.5 })
    }

    /// Covered part of the lower face across an axis of a cell with this lower corner.
    pub fn face(&self, axis: usize, lower: [f64; D], h: f64) -> Covered<D> {
        let beside = |step: f64| {
            let mut moved = lower;
            moved[axis] += step * h;
            self.across(axis, moved, h)
        };
        let (below, above) = (beside(-FLUSH), beside(FLUSH));
        if above.share > below.share { above } else { below }
    }

    /// Covered part of a square across an axis with this lower corner.
    fn across(&self, axis: usize, lower: [f64; D], h: f64) -> Covered<D> {
        let mut across = (0..D).filter(|&a| a != axis);
        let along = across.next().unwrap_or(0);
        let strips = across.next().map(|a| (a, self.strips));
        let mut sum = Covered { share: 0.0, centre: [0.0; D] };
        let count = strips.map_or(1, |(_, count)| count);
        for k in 0..count {
            let mut from = lower;
            if let Some((a, count)) = strips {
                from[a] += (k as f64 + 0.5) / count as f64 * h;
            }
            let mut to = from;
            to[along] += h;
            let (share, middle) = self.on_segment(from, to);
            sum.share += share;
            from[along] += middle * h;
            (0..D).for_each(|a| sum.centre[a] += share * from[a]);
        }
        let share = sum.share / count as f64;
        let centre = if share > 0.0 { sum.centre.map(|x| x / sum.share) } else { lower };
        Covered { share, centre }
    }

    /// Covered share of a cell with this lower corner.
    pub fn cell(&self, lower: [f64; D], h: f64) -> f64 {
        let slice = |k: usize| {
            let mut at = lower;
            at[0] += (k as f64 + 0.5) / self.strips as f64 * h;
            self.across(0, at, h).share
        };
        (0..self.strips).map(slice).sum::<f64>() / self.strips as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::scene::{Geometry, Pose};

    fn tilted_box() -> SurfaceSolid<3> {
        let surface = Surface::of(&Geometry::Box { size: [0.5, 0.3, 0.4] }).unwrap();
        let pose = Pose { position: [0.02, 0.01, 0.0], orientation: [0.1, 0.2, -0.3, 1.0] };
        SurfaceSolid {
            surface: Arc::new(surface),
            frame: Frame::of(&pose),
            section: Section::SPACE,
            strips: 4,
        }
    }

    /// The same box, as half spaces, covers the same.
    #[test]
    fn a_surface_covers_what_its_half_spaces_do() {
        use crate::solids::half_spaces::HalfSpaces;
        let solid = tilted_box();
        let convex = tremie_geometry::Convex::of_mesh(solid.surface.mesh()).unwrap();
        let exact = HalfSpaces::<3>::of(&convex, 1.0, &solid.frame, &Section::SPACE);
        let (mut volume, mut exact_volume) = (0.0, 0.0);
        for i in -4..4 {
            for j in -4..4 {
                for k in -4..4 {
                    let lower = [i, j, k].map(|n| 0.1 * f64::from(n));
                    for axis in 0..3 {
                        let (face, is) =
                            (solid.face(axis, lower, 0.1), exact.face(axis, lower, 0.1));
                        assert!((face.share - is.share).abs() < 0.04, "{face:?} {is:?}");
                    }
                    volume += solid.cell(lower, 0.1);
                    exact_volume += exact.cell(lower, 0.1);
                }
            }
        }
        assert!((volume / exact_volume - 1.0).abs() < 5e-3, "{volume} {exact_volume}");
    }

    #[test]
    fn a_thin_plate_is_met_by_a_segment_through_it() {
        let surface = Surface::of(&Geometry::Box { size: [0.01, 1.0, 1.0] }).unwrap();
        let plate = SurfaceSolid::<3> {
            surface: Arc::new(surface),
            frame: Frame::of(&Pose::IDENTITY),
            section: Section::SPACE,
            strips: 4,
        };
        let met = plate.first_met([-0.1, 0.0, 0.0], [0.1, 0.0, 0.0]).unwrap();
        assert!((met - 0.475).abs() < 1e-9);
        assert!(plate.first_met([-0.1, 0.0, 0.6], [0.1, 0.0, 0.6]).is_none());
        let cell = plate.cell([-0.05, 0.0, 0.0], 0.1);
        assert!((cell - 0.1).abs() < 0.15, "{cell}");
    }
}
