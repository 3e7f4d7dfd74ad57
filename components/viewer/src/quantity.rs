//! Quantities that colour a cut.

use crate::scale::speed;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tremie_geometry::Vec3;
use tremie_messages::frame::{SliceHeader, SliceNode};

/// A quantity that colours a cut in a view of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum CutQuantity {
    /// Gauge pressure.
    Pressure,
    /// Density of the fluid.
    Density,
    /// Length of the density's gradient in the cut: shocks and edges of wakes.
    Schlieren,
    /// Curl of the velocity across the cut.
    Vorticity,
    /// Level of refinement of the fluid's grid.
    Level,
}

impl CutQuantity {
    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pressure => "pressure",
            Self::Density => "density",
            Self::Schlieren => "schlieren",
            Self::Vorticity => "vorticity",
            Self::Level => "level",
        }
    }

    /// Words for its legend.
    pub fn words(self) -> &'static str {
        match self {
            Self::Pressure => "Gauge pressure",
            Self::Density => "Density",
            Self::Schlieren => "Gradient of the density",
            Self::Vorticity => "Vorticity across the cut",
            Self::Level => "Level of refinement",
        }
    }

    /// Its unit, as a legend writes it after a number.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Pressure => " Pa",
            Self::Density => " kg/m³",
            Self::Schlieren => " kg/m⁴",
            Self::Vorticity => " 1/s",
            Self::Level => "",
        }
    }

    /// True if values of both signs count.
    pub fn is_signed(self) -> bool {
        matches!(self, Self::Pressure | Self::Vorticity)
    }

    /// Its values at the nodes of a cut; 0 where there is no fluid.
    pub fn values(self, header: &SliceHeader, nodes: &[SliceNode]) -> Vec<f32> {
        let grid = CutGrid::new(header, nodes);
        let value = |k: usize| match self {
            _ if !nodes[k].is_fluid() => 0.0,
            Self::Pressure => nodes[k].pressure,
            Self::Density => nodes[k].density,
            Self::Level => nodes[k].level as f32,
            Self::Schlieren => {
                let slope = [0, 1].map(|a| grid.slope(k, a, |node| node.density));
                speed([slope[0], slope[1], 0.0])
            }
            Self::Vorticity => {
                let [along, up] = grid.directions;
                let part = |of: Vec3| move |node: &SliceNode| dot(node.velocity, of);
                grid.turn * (grid.slope(k, 0, part(up)) - grid.slope(k, 1, part(along)))
            }
        };
        (0..nodes.len()).map(value).collect()
    }
}

fn dot(velocity: [f32; 3], direction: Vec3) -> f32 {
    (0..3).map(|a| velocity[a] * direction[a] as f32).sum()
}

/// The nodes of a cut, to take differences between.
struct CutGrid<'a> {
    nodes: &'a [SliceNode],
    count: [usize; 2],
    /// Steps between nodes [m].
    steps: [f64; 2],
    /// Unit vectors along them.
    directions: [Vec3; 2],
    /// 1, or -1 where the two directions turn about the negative of an axis of the world.
    turn: f32,
}

impl<'a> CutGrid<'a> {
    fn new(header: &SliceHeader, nodes: &'a [SliceNode]) -> Self {
        let steps = header.step.map(Vec3::from);
        let lengths = steps.map(|step| step.norm());
        let directions = [steps[0] / lengths[0], steps[1] / lengths[1]];
        let normal = directions[0].cross(&directions[1]);
        let is_backwards = normal[normal.iamax()] < 0.0;
        Self {
            nodes,
            count: header.count.map(|n| n as usize),
            steps: lengths,
            directions,
            turn: if is_backwards { -1.0 } else { 1.0 },
        }
    }

    /// Difference along a direction between the fluid nodes beside node `k`, or from the one that
    /// there is to it [1/m].
    fn slope(&self, k: usize, direction: usize, value: impl Fn(&SliceNode) -> f32) -> f32 {
        let stride = [1, self.count[0]][direction];
        let place = [k % self.count[0], k / self.count[0]][direction];
        let fluid = |k: usize| Some(k).filter(|&k| self.nodes[k].is_fluid());
        let below = (place > 0).then(|| k - stride).and_then(fluid);
        let above = (place + 1 < self.count[direction]).then(|| k + stride).and_then(fluid);
        let steps = usize::from(below.is_some()) + usize::from(above.is_some());
        if steps == 0 {
            return 0.0;
        }
        let at = |beside: Option<usize>| value(&self.nodes[beside.unwrap_or(k)]);
        (at(above) - at(below)) / (steps as f64 * self.steps[direction]) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::Stamp;

    #[test]
    fn a_gas_that_turns_and_thins_has_its_curl_and_its_gradient() {
        // A cut of x and z turns about -y.
        let header = SliceHeader {
            stamp: Stamp::default(),
            origin: [0.0; 3],
            step: [[0.1, 0.0, 0.0], [0.0, 0.0, 0.1]],
            count: [5, 4],
        };
        let nodes: Vec<_> = (0..20)
            .map(|k| {
                let [x, z] = [k % 5, k / 5].map(|n| 0.1 * n as f32);
                let turns = [3.0 * z, 0.0, -3.0 * x];
                SliceNode {
                    velocity: turns,
                    density: 2.0 + 4.0 * x,
                    fill: 1.0,
                    ..SliceNode::default()
                }
            })
            .collect();
        let near = |quantity: CutQuantity, expected: f32| {
            let values = quantity.values(&header, &nodes);
            assert!(values.iter().all(|value| (value - expected).abs() < 1e-4), "{values:?}");
        };
        near(CutQuantity::Vorticity, 6.0);
        near(CutQuantity::Schlieren, 4.0);
    }
}
