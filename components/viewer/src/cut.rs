//! A cut through the fluid: a mesh coloured by speed, and arrows on some of its nodes.

use crate::scale::{AIR, GREY, Scale, speed};
use crate::view::{Eye, facing, part, single, unit};
use rerun::components::Radius;
use rerun::{Arrows3D, Color, Mesh3D, RecordingStream, RecordingStreamResult};
use tremie_geometry::Vec3;
use tremie_messages::frame::{SliceHeader, SliceNode};
use tremie_messages::scene::Domain;

/// A cut whose shape was drawn.
pub struct Cut {
    path: String,
    shape: Shape,
    arrows: Vec<usize>,
    /// Longest arrow [m].
    reach: f64,
}

/// Geometry of a cut; frames of equal shape differ in colours alone.
#[derive(Clone, Copy, PartialEq)]
pub struct Shape {
    origin: Vec3,
    step: [Vec3; 2],
    count: [usize; 2],
}

impl Shape {
    /// Of a frame.
    pub fn new(header: &SliceHeader) -> Self {
        Self {
            origin: header.origin.into(),
            step: header.step.map(Vec3::from),
            count: header.count.map(|n| n as usize),
        }
    }

    fn node(&self, k: usize) -> Vec3 {
        let (i, j) = (k % self.count[0], k / self.count[0]);
        self.origin + self.step[0] * (i as f64) + self.step[1] * (j as f64)
    }

    /// Triangles between nodes that `inside` accepts.
    fn triangles(&self, inside: impl Fn(Vec3) -> bool) -> Vec<[u32; 3]> {
        let [m, n] = self.count.map(|n| n as u32);
        let all = (0..n.saturating_sub(1)).flat_map(move |j| {
            (0..m.saturating_sub(1)).flat_map(move |i| {
                let k = i + m * j;
                [[k, k + 1, k + m + 1], [k, k + m + 1, k + m]]
            })
        });
        all.filter(|corners| corners.iter().all(|k| inside(self.node(*k as usize)))).collect()
    }

    /// Draws it, without colours, as far as it lies in the domain.
    pub fn log(
        &self,
        stream: &RecordingStream,
        path: &str,
        domain: &Domain,
    ) -> RecordingStreamResult<()> {
        let nodes = (0..self.count[0] * self.count[1]).map(|k| single(self.node(k)));
        let mesh = Mesh3D::update_fields()
            .with_vertex_positions(nodes)
            .with_triangle_indices(self.triangles(|point| inside(domain, point)));
        stream.log_static(path, &mesh)
    }

    /// Nodes that carry an arrow: about `wanted` on a grid of equal spacing both ways; and that
    /// spacing [m].
    fn arrows(&self, wanted: u32) -> (Vec<usize>, f64) {
        let [m, n] = self.count;
        let lengths = [self.step[0].norm(), self.step[1].norm()];
        let area = (m as f64 * lengths[0]) * (n as f64 * lengths[1]);
        if wanted == 0 || !area.is_normal() {
            return (Vec::new(), 0.0);
        }
        let spacing = (area / f64::from(wanted)).sqrt();
        let stride = lengths.map(|length| ((spacing / length).round() as usize).max(1));
        // Begins half a stride inside, where the flow is, not on the wall.
        let picks = |axis: usize| (stride[axis] / 2..self.count[axis]).step_by(stride[axis]);
        let nodes = picks(1).flat_map(|j| picks(0).map(move |i| i + m * j)).collect();
        (nodes, spacing.max(lengths[0]).max(lengths[1]))
    }
}

impl Cut {
    /// Draws the shape of a cut, on which `wanted` arrows will stand.
    pub fn open(
        stream: &RecordingStream,
        from: &str,
        name: &str,
        header: &SliceHeader,
        wanted: u32,
        eye: Vec3,
        domain: &Domain,
    ) -> RecordingStreamResult<Self> {
        let shape = Shape::new(header);
        let path = format!("scene/cuts/{}/{}", part(from), part(name));
        let (mut arrows, spacing) = shape.arrows(wanted);
        arrows.retain(|k| inside(domain, shape.node(*k)));
        let cut = Self { path, shape, arrows, reach: 1.6 * spacing };
        cut.log_shape(stream, eye, domain)?;
        Ok(cut)
    }

    /// True if a frame is of the shape that was drawn.
    pub fn fits(&self, header: &SliceHeader) -> bool {
        self.shape == Shape::new(header)
    }

    /// Entity of the mesh.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// An eye that looks straight at the cut, from the side of `towards`.
    pub fn eye(&self, up: Vec3, towards: Vec3) -> Eye {
        let side = |axis: usize| {
            let steps = self.shape.count[axis].saturating_sub(1) as f64;
            self.shape.step[axis].map(|x| x * steps)
        };
        facing(self.shape.origin, [side(0), side(1)], up, towards)
    }

    fn log_shape(
        &self,
        stream: &RecordingStream,
        eye: Vec3,
        domain: &Domain,
    ) -> RecordingStreamResult<()> {
        let shape = &self.shape;
        shape.log(stream, &self.path, domain)?;
        let arrows = Arrows3D::update_fields()
            .with_origins(self.arrows.iter().map(|k| single(shape.node(*k) + self.lift(eye))))
            .with_radii([Radius::new_ui_points(0.7)])
            .with_colors([Color::from_rgb(245, 245, 245)]);
        stream.log_static(self.arrow_path(), &arrows)
    }

    /// Arrows float a little in front of the mesh, else half of their width would sink into it.
    fn lift(&self, eye: Vec3) -> Vec3 {
        let normal = unit(self.shape.step[0].cross(&self.shape.step[1]));
        let side = normal.dot(&(eye - self.shape.origin)).signum();
        normal.map(|x| x * side * 0.02 * self.reach)
    }

    fn arrow_path(&self) -> String {
        format!("{}/arrows", self.path)
    }

    /// Draws one moment.
    pub fn log(
        &self,
        stream: &RecordingStream,
        nodes: &[SliceNode],
        scale: &Scale,
    ) -> RecordingStreamResult<()> {
        let colour = |node: &SliceNode| node_colour(node, scale, speed(node.velocity));
        let mesh = Mesh3D::update_fields().with_vertex_colors(nodes.iter().map(colour));
        stream.log(self.path.as_str(), &mesh)?;
        if self.arrows.is_empty() {
            return Ok(());
        }
        let stretch = (self.reach / scale.max()) as f32;
        let vectors = self.arrows.iter().map(|k| match nodes.get(*k) {
            Some(node) if node.is_fluid() => arrow(node.velocity, stretch, self.reach as f32),
            _ => [0.0; 3],
        });
        stream.log(self.arrow_path(), &Arrows3D::update_fields().with_vectors(vectors))
    }
}

/// Colour of a node whose fluid has a value: grey in a solid, dark where there is neither.
pub fn node_colour(node: &SliceNode, scale: &Scale, value: f32) -> Color {
    Color::from_u32(match node {
        node if node.solid != 0 => GREY,
        node if node.is_air() => AIR,
        _ => scale.colour(value),
    })
}

/// True if a point is in the box, up to rounding: the rectangle around an oblique cut reaches
/// beyond.
fn inside(domain: &Domain, point: Vec3) -> bool {
    let size = domain.size();
    (0..3).all(|a| {
        let slack = 1e-6 * size[a];
        (domain.min[a] - slack..=domain.max[a] + slack).contains(&point[a])
    })
}

/// A velocity as an arrow, no longer than what the end of the scale has.
fn arrow(velocity: [f32; 3], stretch: f32, reach: f32) -> [f32; 3] {
    let length = speed(velocity) * stretch;
    let stretch = if length > reach { stretch * reach / length } else { stretch };
    velocity.map(|v| v * stretch)
}

/// Speeds in the fluid [m/s].
pub fn speeds(nodes: &[SliceNode]) -> Vec<f32> {
    nodes.iter().filter(|node| node.is_fluid()).map(|node| speed(node.velocity)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape(count: [usize; 2]) -> Shape {
        Shape {
            origin: Vec3::zeros(),
            step: [Vec3::new(1e-3, 0.0, 0.0), Vec3::new(0.0, 0.0, 1e-3)],
            count,
        }
    }

    #[test]
    fn triangles_cover_the_grid() {
        let all = shape([3, 2]).triangles(|_| true);
        assert_eq!(all.len(), 4);
        assert!(all.iter().flatten().all(|k| *k < 6));
        assert!(shape([1, 5]).triangles(|_| true).is_empty());
        let right = shape([3, 2]).triangles(|point| point[0] > 0.5e-3);
        assert_eq!(right, [[1, 2, 5], [1, 5, 4]]);
    }

    #[test]
    fn arrows_are_about_as_many_as_asked_for() {
        for wanted in [100, 400, 1000] {
            let (nodes, _) = shape([160, 100]).arrows(wanted);
            let ratio = nodes.len() as f64 / f64::from(wanted);
            assert!((0.6..1.6).contains(&ratio), "{wanted}: {}", nodes.len());
        }
        assert_eq!(shape([4, 4]).arrows(1000).0.len(), 16);
        assert!(shape([4, 4]).arrows(0).0.is_empty());
    }

    #[test]
    fn arrows_do_not_outgrow_their_cell() {
        assert_eq!(arrow([3.0, 0.0, 4.0], 1.0, 10.0), [3.0, 0.0, 4.0]);
        assert!((speed(arrow([30.0, 0.0, 40.0], 1.0, 10.0)) - 10.0).abs() < 1e-5);
    }
}
