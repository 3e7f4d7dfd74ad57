//! The volume that observers see.

use crate::observed::observed_cells::ObservedCells;
use tremie_messages::frame::{SliceNode, VolumeHeader};
use tremie_messages::scene::Scene;
use tremie_messages::start::{VolumeGrid, VolumeSpec};

/// What the start contract says of all cells of a scene.
pub fn volume_spec(name: &str, scene: &Scene, cell: f64, cells: [usize; 3]) -> VolumeSpec {
    VolumeSpec {
        name: name.into(),
        origin: scene.domain.min.map(|x| x + 0.5 * cell),
        step: [cell; 3],
        count: cells.map(|n| n as u64),
    }
}

/// Fills `nodes` with the cells of an edge [m] that an observer asked for.
pub fn fill_volume(
    fluid: &impl ObservedCells,
    cell: f64,
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
        step: [cell * grid.stride as f64; 3],
        count: grid.count,
        ..VolumeHeader::default()
    }
}
