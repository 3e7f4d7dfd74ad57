//! A field between its nodes.

use tremie_geometry::Vec3;
use tremie_messages::frame::{SliceNode, VolumeHeader};

/// A frame of a volume, to be asked anywhere.
#[derive(Clone, Copy, Debug)]
pub struct Field<'a> {
    origin: Vec3,
    step: Vec3,
    count: [usize; 3],
    nodes: &'a [SliceNode],
}

/// Values of a field at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Velocity [m/s].
    pub velocity: Vec3,
    /// Gauge pressure [Pa].
    pub pressure: f64,
    /// Density [kg/m³].
    pub density: f64,
    /// Level of refinement of the nearest node.
    pub level: u32,
}

impl<'a> Field<'a> {
    /// The field of a frame; `None` if the frame has no nodes, or not as many as it says.
    pub fn new(header: &VolumeHeader, nodes: &'a [SliceNode]) -> Option<Self> {
        let count = header.count.map(|n| n as usize);
        let fits = !nodes.is_empty() && count.iter().product::<usize>() == nodes.len();
        fits.then_some(Self {
            origin: header.origin.into(),
            step: header.step.into(),
            count,
            nodes,
        })
    }

    /// Nodes along each axis.
    pub fn count(&self) -> [usize; 3] {
        self.count
    }

    /// The shortest step between nodes [m].
    pub fn spacing(&self) -> f64 {
        self.step.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// All nodes, `x` running fastest.
    pub fn nodes(&self) -> &'a [SliceNode] {
        self.nodes
    }

    /// Index of a node.
    pub fn index(&self, [i, j, k]: [usize; 3]) -> usize {
        i + self.count[0] * (j + self.count[1] * k)
    }

    /// A point given in steps from the first node [m].
    pub fn position(&self, at: [f32; 3]) -> Vec3 {
        self.origin + Vec3::from(at.map(f64::from)).component_mul(&self.step)
    }

    /// Linear between the fluid nodes around `point`, constant over the last half step at the ends.
    /// `None` beyond that, and where the nearest node is solid or air.
    ///
    /// Other nodes around have no say: a body may move, and what a solid node says of velocity means
    /// nothing.
    pub fn at(&self, point: Vec3) -> Option<Sample> {
        let (low, part) = self.place(point)?;
        if !self.nearest(low, part).is_fluid() {
            return None;
        }
        Some(Sample { level: self.nearest(low, part).level, ..self.mix(low, part) })
    }

    /// True if a point is in the field, and neither in the fluid nor in a solid.
    pub fn is_air(&self, point: Vec3) -> bool {
        self.place(point).is_some_and(|(low, part)| self.nearest(low, part).is_air())
    }

    fn nearest(&self, low: [usize; 3], part: [f64; 3]) -> &SliceNode {
        &self.nodes[self.index(std::array::from_fn(|a| low[a] + usize::from(part[a] > 0.5)))]
    }

    /// The node below a point along each axis, and the point's part of the way to the next; `None`
    /// beyond half a step from the outermost nodes.
    fn place(&self, point: Vec3) -> Option<([usize; 3], [f64; 3])> {
        let mut low = [0; 3];
        let mut part = [0.0; 3];
        for a in 0..3 {
            let place = (point[a] - self.origin[a]) / self.step[a];
            let last = (self.count[a] - 1) as f64;
            // A little slack: the face of a box lies exactly half a step beyond the last node.
            if !(-0.5 - 1e-6..=last + 0.5 + 1e-6).contains(&place) {
                return None;
            }
            let place = place.clamp(0.0, last);
            low[a] = (place as usize).min(self.count[a].saturating_sub(2));
            part[a] = place - low[a] as f64;
        }
        Some((low, part))
    }

    fn mix(&self, low: [usize; 3], part: [f64; 3]) -> Sample {
        let mut sum = Sample { velocity: Vec3::zeros(), pressure: 0.0, density: 0.0, level: 0 };
        let mut whole = 0.0;
        for corner in 0..8_usize {
            let upper = |a: usize| corner >> a & 1;
            let weight: f64 =
                (0..3).map(|a| if upper(a) == 1 { part[a] } else { 1.0 - part[a] }).product();
            if weight == 0.0 {
                continue;
            }
            let node = &self.nodes[self.index(std::array::from_fn(|a| low[a] + upper(a)))];
            if node.is_fluid() {
                whole += weight;
                sum.velocity += Vec3::from(node.velocity.map(f64::from)) * weight;
                sum.pressure += weight * f64::from(node.pressure);
                sum.density += weight * f64::from(node.density);
            }
        }
        Sample {
            velocity: sum.velocity / whole,
            pressure: sum.pressure / whole,
            density: sum.density / whole,
            level: 0,
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use tremie_messages::Stamp;

    /// Nodes at the centres of unit cells, valued by a function of the position.
    pub(crate) fn volume(
        count: [u64; 3],
        value: impl Fn(Vec3) -> SliceNode,
    ) -> (VolumeHeader, Vec<SliceNode>) {
        let header =
            VolumeHeader { stamp: Stamp::default(), origin: [0.5; 3], step: [1.0; 3], count };
        let [nx, ny, nz] = count;
        let all = (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k])));
        (header, all.map(|at| value(at.map(|n| n as f64 + 0.5).into())).collect())
    }

    fn linear(p: Vec3) -> Vec3 {
        Vec3::new(1.0 + 2.0 * p.x - p.y, p.z, 0.5 * p.y)
    }

    #[test]
    fn a_linear_field_is_met_everywhere_between_nodes() {
        let (header, nodes) = volume([4, 5, 6], |p| SliceNode {
            velocity: crate::view::single(linear(p)),
            pressure: p[2] as f32,
            fill: 1.0,
            ..SliceNode::default()
        });
        let field = Field::new(&header, &nodes).unwrap();
        for p in [[0.5, 0.5, 0.5], [1.3, 2.9, 4.4], [3.5, 4.5, 5.5], [2.0, 1.0, 3.25]] {
            let p = Vec3::from(p);
            let sample = field.at(p).unwrap();
            assert!((sample.velocity - linear(p)).amax() < 1e-6, "{sample:?}");
            assert!((sample.pressure - p[2]).abs() < 1e-6);
        }
        assert_eq!(field.at(Vec3::new(0.0, 2.0, 2.0)), field.at(Vec3::new(0.5, 2.0, 2.0)));
        assert!(
            field.at(Vec3::new(-0.01, 2.0, 2.0)).is_none()
                && field.at(Vec3::new(2.0, 2.0, 6.01)).is_none()
        );
    }

    #[test]
    fn solids_are_left_out() {
        let (header, nodes) = volume([3, 3, 1], |p| SliceNode {
            velocity: [1.0, 0.0, 0.0],
            pressure: 0.0,
            fill: 1.0,
            solid: u32::from(p[0] > 1.0 && p[0] < 2.0),
            ..SliceNode::default()
        });
        let field = Field::new(&header, &nodes).unwrap();
        assert!(field.at(Vec3::new(1.5, 1.0, 0.5)).is_none());
        assert_eq!(field.at(Vec3::new(0.9, 1.0, 0.5)).unwrap().velocity, Vec3::x());
        assert!(Field::new(&header, &nodes[1..]).is_none());
    }
}
