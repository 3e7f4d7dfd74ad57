//! The plane that observers see.

use crate::observed::observed_cells::ObservedCells;
use tremie_messages::frame::{SliceHeader, SliceNode};
use tremie_messages::scene::{Placement, Scene};
use tremie_messages::start::SliceSpec;

/// A plane across an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    axis: usize,
    /// Where it crosses the axis [m].
    position: f64,
    /// Lower face of the domain along the axis [m].
    lower: f64,
}

impl Cut {
    /// The plane of a plane scene; else one through the first listed sphere, or the middle of the
    /// domain, that contains gravity and is normal to a horizontal axis.
    pub fn of(scene: &Scene) -> Self {
        let level = if scene.gravity[1].abs() > scene.gravity[2].abs() { 2 } else { 1 };
        let axis = scene.domain.across.unwrap_or(level);
        let first = scene.bodies.iter().find_map(|set| match &set.placement {
            Placement::Listed(spheres) => spheres.first().map(|sphere| sphere.position[axis]),
            Placement::Packed(_) | Placement::Polyhedra(_) => None,
        });
        let middle = 0.5 * (scene.domain.min[axis] + scene.domain.max[axis]);
        Self { axis, position: first.unwrap_or(middle), lower: scene.domain.min[axis] }
    }

    /// The two axes in the plane, the first of them running fastest.
    fn plane(self) -> [usize; 2] {
        [[1, 2], [0, 2], [0, 1]][self.axis]
    }

    /// What the start contract says of it, in a box of cells.
    pub fn spec(self, name: &str, cells: [usize; 3]) -> SliceSpec {
        let [fast, slow] = self.plane().map(|axis| cells[axis] as u64);
        SliceSpec { name: name.into(), nodes: fast * slow }
    }

    /// Fills `nodes` with the layer of cells of an edge [m] that holds it.
    pub fn fill(
        self,
        fluid: &impl ObservedCells,
        cell: f64,
        nodes: &mut [SliceNode],
    ) -> SliceHeader {
        let Self { axis, position, lower } = self;
        let cells = fluid.cells();
        let [fast, slow] = self.plane();
        let mut corner = fluid.centre([0; 3]);
        let layer = layer(cells, (axis, position), (lower, cell), [fast, slow]);
        for (node, at) in nodes.iter_mut().zip(layer) {
            *node = fluid.node(at);
        }
        if cells[axis] > 1 {
            corner[axis] += ((position - corner[axis]) / cell).round() * cell;
        }
        let mut step = [[0.0; 3]; 2];
        (step[0][fast], step[1][slow]) = (cell, cell);
        let count = [cells[fast], cells[slow]].map(|n| n as u64);
        SliceHeader { origin: corner, step, count, ..SliceHeader::default() }
    }
}

/// Cells of the layer that holds a position on an axis [m], the axis `fast` running fastest; of
/// positions outside the box the nearest layer. Cells of an edge begin at `lower` on the axis [m].
pub fn layer(
    cells: [usize; 3],
    (axis, position): (usize, f64),
    (lower, cell): (f64, f64),
    [fast, slow]: [usize; 2],
) -> impl Iterator<Item = [usize; 3]> {
    let layer = ((position - lower) / cell).floor().clamp(0.0, (cells[axis] - 1) as f64);
    (0..cells[slow]).flat_map(move |k| {
        (0..cells[fast]).map(move |j| {
            let mut at = [layer as usize; 3];
            (at[fast], at[slow]) = (j, k);
            at
        })
    })
}
