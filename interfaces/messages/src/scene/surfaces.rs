//! Deformable surfaces: seals of rubber.

use super::Pose;
use serde::{Deserialize, Serialize};

/// A surface that changes its shape: a section turned about the z axis, carried by a part.
///
/// The component with the role rubber finds its shape. All other components know from the scene
/// which vertices its facets have (`tremie_geometry::Turned`), and receive the positions of the
/// vertices.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DeformableSurface {
    /// Name, unique among the surfaces and parts of the scene.
    pub name: String,
    /// Name of the part that carries it, to which it is bonded.
    pub carrier: String,
    /// File of the table of its force and shapes: absolute path, in a recording from the folder of its run.
    pub table: String,
    /// Pose of the section's frame in the carrier's frame.
    pub pose: Pose,
    /// Steps in which the section is turned.
    pub sectors: u32,
    /// Name of the material, for contacts.
    pub material: String,
    /// Stiffness of its contact with walls, planes and parts other than its carrier, for each unit
    /// of its area [N/m³].
    pub seat_stiffness: f64,
    /// Shape at the start.
    #[serde(default)]
    pub start: SurfaceStart,
    /// Section that is turned.
    pub section: Section,
}

/// The shape of a deformable surface at the start; by default that at rest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SurfaceStart {
    /// Compression [m].
    pub compression: f64,
    /// Radius and height of each point of its section then [m]; none where it is at rest.
    pub points: Vec<[f64; 2]>,
}

/// The outline of a section, in the half plane of radius and height.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Section {
    /// Radius and height `[r, z]` of each point at rest [m]. One with the radius 0 stays on the
    /// axis.
    pub points: Vec<[f64; 2]>,
    /// Its edges, the material to their left: those of the seat first, then the exposed, the
    /// covered and the bonded.
    pub edges: Vec<SectionEdge>,
}

/// An edge of a section.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SectionEdge {
    /// The points where it begins and ends.
    pub points: [u32; 2],
    /// Kind of facets that the edge sweeps.
    pub kind: FacetKind,
}

/// Kind of a piece of a deformable surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FacetKind {
    /// A: touches the seat when fully compressed.
    #[default]
    Seat,
    /// B: stays free.
    Exposed,
    /// Lies against its carrier, along which it slides: neither a fluid nor grains get there.
    Covered,
    /// Held by the carrier.
    Bonded,
}

impl Section {
    /// True if a point is on the axis, where it stays.
    pub fn is_on_axis(&self, point: u32) -> bool {
        self.points[point as usize][0] == 0.0
    }
}

impl DeformableSurface {
    /// Radius and height of each point of its section at the start [m].
    pub fn start_points(&self) -> &[[f64; 2]] {
        if self.start.points.is_empty() { &self.section.points } else { &self.start.points }
    }

    /// Number of its vertices: on the axis one for each point of an edge, else one for each sector.
    pub fn vertex_count(&self) -> usize {
        let section = &self.section;
        let mut used = vec![false; section.points.len()];
        section.edges.iter().flat_map(|edge| edge.points).for_each(|p| used[p as usize] = true);
        let vertices = |point: usize| {
            if section.is_on_axis(point as u32) { 1 } else { self.sectors as usize }
        };
        (0..used.len()).filter(|&point| used[point]).map(vertices).sum()
    }

    /// Number of its facets: two for each edge and sector, one where the edge ends on the axis.
    pub fn facet_count(&self) -> usize {
        let of = |edge: &SectionEdge| {
            edge.points.iter().filter(|point| !self.section.is_on_axis(**point)).count()
        };
        self.section.edges.iter().map(of).sum::<usize>() * self.sectors as usize
    }
}
