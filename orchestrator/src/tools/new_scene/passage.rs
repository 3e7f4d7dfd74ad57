//! The way of a flow through a part: a space that leads from one face of the part's box to another and
//! meets no other face.
//!
//! The box is looked at in voxels. A tube's bore is such a space, and so is that of an elbow; the space
//! around them is none, because it meets the sides. The width of a way is that of its narrowest place,
//! and the bore is the width of the widest way (a bottleneck path, by Dijkstra's method).

use super::domain_face::DomainFace;
use super::voxels::{Voxels, squared_distances};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};
use tremie_geometry::{Bounds, Surface, Vec3};

/// Voxels across a bore below which it is looked at again, from nearby.
const FEW: f64 = 12.0;

/// A way through a part from an inlet to an outlet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passage {
    /// Face at which it begins.
    pub inlet: DomainFace,
    /// Face at which it ends.
    pub outlet: DomainFace,
    /// A point in it at the inlet, far from walls [m].
    pub inside: Vec3,
    /// The box around it [m].
    pub bounds: Bounds,
    /// Width of its narrowest place on the widest way [m].
    pub bore: f64,
    /// Length of the shortest way along the axes [m].
    pub length: f64,
    /// Its area at the inlet [m²].
    pub inlet_area: f64,
    /// The least area of its sections on the way [m²].
    pub least_area: f64,
    /// Its volume [m³].
    pub volume: f64,
}

impl Passage {
    /// The passage between the first two faces of a part's box, inlet and outlet, that have one; `None` where no way
    /// leads through, or only one that is open to other faces as well. What [`Surface::contains`] is solid.
    pub fn find(surface: &Surface, ends: &[[DomainFace; 2]]) -> Option<Self> {
        let bounds = surface.bounds();
        let voxels = Voxels::of(surface, &bounds);
        let passage = ends.iter().find_map(|ends| OpenBox::of(&voxels, *ends).passage())?;
        let edge = voxels.edges.max();
        if passage.bore >= FEW * edge {
            return Some(passage);
        }
        // A narrow bore in a large part: its own box, with some wall around it.
        let mut near = passage.bounds.grown(1.5 * edge);
        let (inlet, outlet) = (passage.inlet, passage.outlet);
        for face in [inlet, outlet] {
            let k = face.axis();
            match face.is_upper() {
                true => near.max[k] = bounds.max[k],
                false => near.min[k] = bounds.min[k],
            }
        }
        let nearby = OpenBox::of(&Voxels::of(surface, &near), [inlet, outlet]).passage();
        Some(nearby.unwrap_or(passage))
    }
}

/// A box in voxels that is open at two faces.
struct OpenBox {
    voxels: Voxels,
    inlet: DomainFace,
    outlet: DomainFace,
}

impl OpenBox {
    /// A box that is open at two faces: what is beyond them is shut.
    fn of(voxels: &Voxels, [inlet, outlet]: [DomainFace; 2]) -> Self {
        let mut solid = voxels.solid.clone();
        for (i, solid) in solid.iter_mut().enumerate() {
            *solid |= [inlet, outlet].iter().any(|face| voxels.is_beyond(i, *face));
        }
        let voxels = Voxels { solid, ..*voxels };
        Self { voxels, inlet, outlet }
    }

    /// The largest space that leads from inlet to outlet and meets no side.
    fn passage(&self) -> Option<Passage> {
        let mut seen = self.voxels.solid.clone();
        let mut largest: Vec<usize> = Vec::new();
        for i in 0..seen.len() {
            if seen[i] || !self.voxels.is_at(i, self.inlet) {
                continue;
            }
            let space = self.space_of(i, &mut seen);
            let ends = space.iter().any(|&i| self.voxels.is_at(i, self.outlet));
            if ends
                && space.len() > largest.len()
                && !space.iter().any(|&i| self.voxels.is_outside(i))
            {
                largest = space;
            }
        }
        if largest.is_empty() { None } else { self.measured(&largest) }
    }

    /// All voxels that a way leads to from one.
    fn space_of(&self, from: usize, seen: &mut [bool]) -> Vec<usize> {
        let mut space = vec![from];
        seen[from] = true;
        let mut next = 0;
        while let Some(&i) = space.get(next) {
            for other in self.voxels.neighbours(i) {
                if !std::mem::replace(&mut seen[other], true) {
                    space.push(other);
                }
            }
            next += 1;
        }
        space
    }

    fn measured(&self, space: &[usize]) -> Option<Passage> {
        let clearance = self.clearance();
        let begins = || space.iter().copied().filter(|&i| self.voxels.is_at(i, self.inlet));
        let deepest = begins().max_by(|&a, &b| clearance[a].total_cmp(&clearance[b]))?;
        let edges = self.voxels.edges;
        let half = edges * 0.5;
        let centre = |i: usize| self.voxels.centre(i);
        let corners = space.iter().flat_map(|&i| [centre(i) - half, centre(i) + half]);
        let volume = edges.product();
        let edge = volume.cbrt();
        let (steps, least) = self.least_section(begins())?;
        Some(Passage {
            inlet: self.inlet,
            outlet: self.outlet,
            inside: centre(deepest),
            bounds: Bounds::of(corners),
            // From the middle of a voxel to that of one of wall, on both sides.
            bore: 2.0 * self.widest_way(begins(), &clearance)? - edge,
            length: steps as f64 * edge,
            inlet_area: begins().count() as f64 * volume / edges[self.inlet.axis()],
            least_area: least as f64 * edge * edge,
            volume: space.len() as f64 * volume,
        })
    }

    /// Distances of all voxels from the nearest wall, but from none beyond inlet and outlet [m].
    fn clearance(&self) -> Vec<f64> {
        let is_beyond = |i| [self.inlet, self.outlet].iter().any(|f| self.voxels.is_beyond(i, *f));
        let wall = |(i, solid): (usize, &bool)| match *solid && !is_beyond(i) {
            true => 0.0,
            false => f64::INFINITY,
        };
        let walls: Vec<f64> = self.voxels.solid.iter().enumerate().map(wall).collect();
        let squared = squared_distances(walls, self.voxels.count, self.voxels.edges);
        squared.into_iter().map(f64::sqrt).collect()
    }

    /// The least clearance on the way from inlet to outlet on which it is greatest.
    fn widest_way(&self, begins: impl Iterator<Item = usize>, clearance: &[f64]) -> Option<f64> {
        // Of clearances above zero the bits are in their order.
        let mut waiting: BinaryHeap<(u64, Reverse<usize>)> =
            begins.map(|i| (clearance[i].to_bits(), Reverse(i))).collect();
        let mut done = self.voxels.solid.clone();
        while let Some((width, Reverse(i))) = waiting.pop() {
            if std::mem::replace(&mut done[i], true) {
                continue;
            }
            if self.voxels.is_at(i, self.outlet) {
                return Some(f64::from_bits(width));
            }
            for other in self.voxels.neighbours(i).filter(|&other| !done[other]) {
                waiting.push((width.min(clearance[other].to_bits()), Reverse(other)));
            }
        }
        None
    }

    /// Steps from inlet to outlet, and the voxels of the least section on the way: of all that are equally many
    /// steps from the inlet.
    fn least_section(&self, begins: impl Iterator<Item = usize>) -> Option<(usize, usize)> {
        let mut waiting: VecDeque<(usize, usize)> = begins.map(|i| (i, 0)).collect();
        let mut done = self.voxels.solid.clone();
        waiting.iter().for_each(|&(i, _)| done[i] = true);
        let mut counts: Vec<usize> = Vec::new();
        while let Some((i, steps)) = waiting.pop_front() {
            if counts.len() == steps {
                counts.push(0);
            }
            counts[steps] += 1;
            if self.voxels.is_at(i, self.outlet) {
                // The section at hand is not whole yet.
                return Some((steps + 1, counts[..steps.max(1)].iter().copied().min()?));
            }
            for other in self.voxels.neighbours(i) {
                if !std::mem::replace(&mut done[other], true) {
                    waiting.push_back((other, steps + 1));
                }
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;
    use tremie_messages::scene::Geometry;

    /// A tube about z, its bore 8 mm wide, 40 mm long.
    fn tube(bore: f64) -> Surface {
        let (inner, outer) = (0.5 * bore, 6e-3);
        let profile = vec![[inner, 0.0], [outer, 0.0], [outer, 40e-3], [inner, 40e-3]];
        Surface::of(&Geometry::Revolved { profile }).unwrap()
    }

    #[test]
    fn a_tube_leads_through() {
        let [inlet, outlet] = [DomainFace::ZMin, DomainFace::ZMax];
        let passage = Passage::find(&tube(8e-3), &[[inlet, outlet]]).unwrap();
        assert!((passage.bore / 8e-3 - 1.0).abs() < 0.1, "{passage:?}");
        let area = PI * 16e-6;
        for found in [passage.inlet_area, passage.least_area, passage.volume / 40e-3] {
            assert!((found / area - 1.0).abs() < 0.1, "{passage:?}, expected {area} m2");
        }
        assert!(passage.inside.xy().norm() < 1e-3 && passage.inside.z < 1e-3, "{passage:?}");
        // Across, the tube is no passage.
        assert_eq!(Passage::find(&tube(8e-3), &[[DomainFace::XMin, DomainFace::XMax]]), None);
    }

    #[test]
    fn a_way_that_is_open_to_the_sides_is_no_passage() {
        let outline = |points: &[[f64; 2]]| Geometry::Extruded {
            outline: points.iter().map(|p| p.map(|x| 1e-3 * x)).collect(),
            axis: 1,
            length: 4e-3,
        };
        // Walls of a bend in the plane of x and z, open towards y: the space is open there, and no passage.
        let bend =
            outline(&[[0.0, 0.0], [2.0, 0.0], [2.0, 6.0], [8.0, 6.0], [8.0, 8.0], [0.0, 8.0]]);
        let bend = Surface::of(&bend).unwrap();
        assert_eq!(Passage::find(&bend, &[[DomainFace::ZMin, DomainFace::XMax]]), None);
        let both = [[DomainFace::XMin, DomainFace::XMax], [DomainFace::ZMin, DomainFace::ZMax]];
        let passage = Passage::find(&tube(8e-3), &both).unwrap();
        assert_eq!((passage.inlet, passage.outlet), (DomainFace::ZMin, DomainFace::ZMax));
    }

    #[test]
    fn a_narrow_bore_is_looked_at_from_nearby() {
        let passage = Passage::find(&tube(1e-3), &[[DomainFace::ZMax, DomainFace::ZMin]]).unwrap();
        assert!((passage.bore / 1e-3 - 1.0).abs() < 0.15, "{passage:?}");
        assert!(passage.inside.z > 39e-3, "{passage:?}");
    }

    #[test]
    fn no_way_leads_through_a_ball_or_past_it() {
        let ball = Surface::of(&Geometry::Sphere { radius: 5e-3 }).unwrap();
        assert_eq!(Passage::find(&ball, &[[DomainFace::XMin, DomainFace::XMax]]), None);
    }

    /// The inside of a cylinder, which is solid around.
    #[test]
    fn a_cavity_is_a_passage() {
        let cylinder = Geometry::Cylinder { radius: 4e-3, length: 40e-3 };
        let cavity = Surface::of(&cylinder).unwrap().inside_out();
        let passage = Passage::find(&cavity, &[[DomainFace::ZMin, DomainFace::ZMax]]).unwrap();
        assert!((passage.bore / 8e-3 - 1.0).abs() < 0.1, "{passage:?}");
    }
}
