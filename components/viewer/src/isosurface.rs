//! Surfaces of equal speed or equal pressure.

use crate::field::Field;
use crate::scale::{Scale, rgba, speed};
use crate::view::{part, single};
use fast_surface_nets::ndshape::{RuntimeShape, Shape};
use fast_surface_nets::{SurfaceNetsBuffer, surface_nets};
use rerun::components::AlbedoFactor;
use rerun::{Clear, Mesh3D, RecordingStream, RecordingStreamResult};
use tremie_geometry::Vec3;
use tremie_messages::frame::SliceNode;

/// Colour of surfaces of equal pressure.
const PRESSURE: u32 = rgba([225, 160, 90]);
/// Colour of the free surface.
const WATER: u32 = rgba([70, 140, 200]);
/// Opacity of a surface, of 255.
const ALPHA: u8 = 140;

/// Quantity and value that a surface has everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Level {
    /// Speed [m/s].
    Speed(f64),
    /// Gauge pressure [Pa].
    Pressure(f64),
    /// The free surface: where the fluid fills half of what is around.
    FreeSurface,
}

impl Level {
    /// Name of its surface.
    fn name(self) -> &'static str {
        match self {
            Self::Speed(_) => "speed",
            Self::Pressure(_) => "pressure",
            Self::FreeSurface => "free-surface",
        }
    }

    /// Distance of a node below the level. Air is outside.
    fn below(self, node: &SliceNode) -> f32 {
        match self {
            Self::FreeSurface => 0.5 - node.fill,
            _ if node.is_air() => f32::MAX,
            Self::Speed(level) => (level - f64::from(speed(node.velocity))) as f32,
            Self::Pressure(level) => (level - f64::from(node.pressure)) as f32,
        }
    }
}

/// A surface that is drawn anew for each moment.
pub struct Isosurface {
    path: String,
    level: Level,
    /// Distance below the level at each node; negative inside the surface.
    values: Vec<f32>,
    found: SurfaceNetsBuffer,
    shown: bool,
}

impl Isosurface {
    /// The surface of `level` in the field `name` of `from`.
    pub fn new(from: &str, name: &str, level: Level) -> Self {
        let path =
            format!("scene/isosurfaces/{}/{}/{}", part(from), part(name), part(level.name()));
        let found = SurfaceNetsBuffer::default();
        Self { path, level, values: Vec::new(), found, shown: false }
    }

    /// Draws one moment.
    pub fn log(
        &mut self,
        stream: &RecordingStream,
        field: &Field<'_>,
        scale: &Scale,
    ) -> RecordingStreamResult<()> {
        self.find(field);
        if self.found.indices.is_empty() {
            // Said once: an entity that was never drawn needs no clearing.
            let gone = std::mem::take(&mut self.shown);
            return if gone { stream.log(self.path.as_str(), &Clear::flat()) } else { Ok(()) };
        }
        self.shown = true;
        let colour = match self.level {
            Level::Speed(level) => scale.colour(level as f32),
            Level::Pressure(_) => PRESSURE,
            Level::FreeSurface => WATER,
        };
        let [r, g, b, _] = colour.to_be_bytes();
        let normals = self.found.normals.iter().map(|n| {
            let unit = Vec3::from(n.map(f64::from)).try_normalize(0.0);
            single(unit.unwrap_or(Vec3::z()))
        });
        let flat = flat_axis(field.count());
        let places = self.found.positions.iter().map(|at| {
            let mut at = *at;
            if let Some(axis) = flat {
                at[axis] -= 1.0;
            }
            single(field.position(at))
        });
        let triangles = self.found.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]);
        let mesh = Mesh3D::new(places)
            .with_vertex_normals(normals)
            .with_triangle_indices(triangles)
            .with_albedo_factor(AlbedoFactor(rerun::Rgba32::from_unmultiplied_rgba(
                r, g, b, ALPHA,
            )));
        stream.log(self.path.as_str(), &mesh)
    }

    /// Finds the surface, by surface nets (Gibson, MERL report TR99-24, 1999).
    fn find(&mut self, field: &Field<'_>) {
        let mut count = field.count();
        let flat = flat_axis(count);
        if (0..3).any(|a| count[a] < 2 && flat != Some(a)) {
            // A row or a point has no surface; nothing was found before either.
            return;
        }
        fill(&mut self.values, field, self.level);
        if let Some(axis) = flat {
            repeat(&mut self.values, count, axis);
            count[axis] = LAYERS;
        }
        let shape = RuntimeShape::<u32, 3>::new(count.map(|n| n as u32));
        debug_assert_eq!(shape.size() as usize, self.values.len());
        let last = count.map(|n| n as u32 - 1);
        surface_nets(&self.values, &shape, [0; 3], last, &mut self.found);
    }
}

/// Layers that stand for one: then its surface is a strip, as wide as the layer is deep.
const LAYERS: usize = 3;

/// The axis along which a field is a single layer.
fn flat_axis(count: [usize; 3]) -> Option<usize> {
    let mut flat = (0..3).filter(|&a| count[a] == 1);
    flat.next().filter(|_| flat.next().is_none())
}

/// Repeats a single layer across an axis.
fn repeat(values: &mut Vec<f32>, count: [usize; 3], axis: usize) {
    let stride: usize = count[..axis].iter().product();
    let layer = std::mem::take(values);
    for row in layer.chunks_exact(stride) {
        (0..LAYERS).for_each(|_| values.extend_from_slice(row));
    }
}

/// Distances below the level. Solid nodes take the mean of the fluid around them, so that the
/// surface goes on into a body, where it is out of sight, and does not wrap it.
fn fill(values: &mut Vec<f32>, field: &Field<'_>, level: Level) {
    values.clear();
    values.extend(field.nodes().iter().map(|node| level.below(node)));
    let count = field.count();
    for k in 0..count[2] {
        for j in 0..count[1] {
            for i in 0..count[0] {
                let index = field.index([i, j, k]);
                if field.nodes()[index].solid != 0 {
                    values[index] = beside_solid(field, [i, j, k], level);
                }
            }
        }
    }
}

/// Mean over the fluid nodes next to a solid one; outside the surface, if there is none.
fn beside_solid(field: &Field<'_>, at: [usize; 3], level: Level) -> f32 {
    let count = field.count();
    let near = |a: usize| at[a].saturating_sub(1)..(at[a] + 2).min(count[a]);
    let (mut sum, mut number) = (0.0, 0);
    for k in near(2) {
        for j in near(1) {
            for i in near(0) {
                let node = &field.nodes()[field.index([i, j, k])];
                if node.solid == 0 {
                    sum += level.below(node);
                    number += 1;
                }
            }
        }
    }
    if number == 0 { f32::MAX } else { sum / number as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::tests::volume;

    fn hill(p: Vec3) -> SliceNode {
        let r = p.add_scalar(-10.0).norm();
        SliceNode {
            velocity: [(10.0 - r).max(0.0) as f32, 0.0, 0.0],
            pressure: -r as f32,
            fill: 1.0,
            ..SliceNode::default()
        }
    }

    #[test]
    fn a_hill_of_speed_has_spheres_as_surfaces() {
        let (header, nodes) = volume([20; 3], hill);
        let field = Field::new(&header, &nodes).unwrap();
        for (level, radius) in [(Level::Speed(4.0), 6.0), (Level::Pressure(-7.0), 7.0)] {
            let mut surface = Isosurface::new("fluid", "lattice", level);
            surface.find(&field);
            assert!(surface.found.positions.len() > 200);
            for at in &surface.found.positions {
                let p = field.position(*at).map(|x| x - 10.0);
                assert!((p.norm() - radius).abs() < 0.15, "{p:?}");
            }
        }
        let mut nowhere = Isosurface::new("fluid", "lattice", Level::Speed(1e3));
        nowhere.find(&field);
        assert!(nowhere.found.indices.is_empty());
    }

    #[test]
    fn a_body_in_fast_flow_is_not_wrapped() {
        let (header, nodes) = volume([20; 3], |p| {
            let solid = p.add_scalar(-10.0).norm() < 2.5;
            let velocity = if solid { [0.0; 3] } else { [5.0, 0.0, 0.0] };
            SliceNode { velocity, fill: 1.0, solid: solid.into(), ..SliceNode::default() }
        });
        let field = Field::new(&header, &nodes).unwrap();
        let mut surface = Isosurface::new("fluid", "lattice", Level::Speed(4.0));
        surface.find(&field);
        for at in &surface.found.positions {
            let p = field.position(*at).map(|x| x - 10.0);
            assert!(p.norm() < 2.5, "only inside the body: {p:?}");
        }
    }
}
