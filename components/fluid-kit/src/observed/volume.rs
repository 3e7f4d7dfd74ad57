//! The volume that observers see.

use crate::observed::observed_cells::ObservedCells;
use tremie_messages::frame::{SliceNode, VolumeHeader};
use tremie_messages::scene::Scene;
use tremie_messages::start::{VolumeGrid, VolumeSpec};

/// What the start contract says of all cells of a scene.
pub fn volume_spec(name: &str, scene: &Scene, cell: f64, cells: [usize; 3]) -> VolumeSpec {
    let step = steps(scene, cell);
    VolumeSpec {
        name: name.into(),
        origin: std::array::from_fn(|a| scene.domain.min[a] + 0.5 * step[a]),
        step,
        count: cells.map(|n| n as u64),
    }
}

/// Steps from cell to cell along each axis [m]: across a plane scene its depth.
pub fn steps(scene: &Scene, cell: f64) -> [f64; 3] {
    let mut steps = [cell; 3];
    if let (Some(axis), Some(depth)) = (scene.domain.across, scene.domain.depth()) {
        steps[axis] = depth;
    }
    steps
}

/// Fills `nodes` with the cells that an observer asked for; `step` leads from cell to cell along
/// each axis [m].
pub fn fill_volume(
    fluid: &impl ObservedCells,
    step: [f64; 3],
    grid: &VolumeGrid,
    nodes: &mut [SliceNode],
) -> VolumeHeader {
    let [across, deep, high] = grid.count;
    let all =
        (0..high).flat_map(|k| (0..deep).flat_map(move |j| (0..across).map(move |i| [i, j, k])));
    for (node, at) in nodes.iter_mut().zip(all) {
        *node = fluid.node(grid.lattice_node(at).map(|n| n as usize));
    }
    VolumeHeader {
        origin: fluid.centre(grid.first.map(|n| n as usize)),
        step: step.map(|step| step * grid.stride as f64),
        count: grid.count,
        ..VolumeHeader::default()
    }
}
