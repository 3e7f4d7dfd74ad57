//! What lies beyond the faces of the domain.

use crate::gas::gas_law::{MOST_FIELDS, field_count};
use crate::grid::block_shape::BlockShape;
use crate::grid::block_tree::{BlockAddress, BlockTree};
use crate::grid::block_values::BeyondDomain;

/// A face of the domain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DomainFace {
    /// The other end lies beyond.
    Periodic,
    /// A mirror lies in it: a wall along which gas slips, and that takes no heat.
    Mirror,
    /// Gas of one state flows in, or lies beyond: its fields.
    Given([f64; MOST_FIELDS]),
    /// What reaches it leaves: the last points' values go on beyond.
    Open,
}

/// The faces of a domain, the lower and the upper one of each axis.
pub type DomainFaces = [[DomainFace; 2]; 3];

impl BeyondDomain for DomainFaces {
    fn fill(&self, tree: &BlockTree, block: BlockAddress, padded: &mut [f64]) {
        let shape = &tree.domain.shape;
        for axis in 0..shape.dims {
            let last = tree.domain.blocks_along(block.level, axis) - 1;
            for (side, end) in [(0, 0), (1, last)] {
                if block.at[axis] == end {
                    fill_face(shape, axis, side, self[axis][side], padded);
                }
            }
        }
    }
}

/// Fills the points on a face of the domain and those beyond it. The upper face's points are no
/// block's own, and those of the lower are treated like them.
fn fill_face(shape: &BlockShape, axis: usize, side: usize, face: DomainFace, padded: &mut [f64]) {
    let (stride, ghosts, edge) = (shape.stride[axis], shape.ghosts[axis], shape.edge[axis]);
    // The point on the face, and the step inwards.
    let (on_face, inward) =
        if side == 0 { (ghosts, stride as isize) } else { (ghosts + edge, -(stride as isize)) };
    let mut end = shape.padded;
    end[axis] = 1;
    let reach = if side == 0 { ghosts } else { ghosts - 1 } as isize;
    for (field, values) in
        padded.chunks_exact_mut(shape.stored).enumerate().take(field_count(shape.dims))
    {
        let is_normal = field == 1 + axis;
        for row in shape.rows([0; 3], end) {
            let run = if axis == 0 { 1 } else { shape.padded[0] };
            for place in row..row + run {
                let face_point = (place + on_face * stride) as isize;
                let at = |steps: isize| (face_point + steps * inward) as usize;
                match face {
                    DomainFace::Periodic => {}
                    DomainFace::Mirror => {
                        let sign = if is_normal { -1.0 } else { 1.0 };
                        values[at(0)] =
                            if is_normal { 0.0 } else { mirrored(values[at(1)], values[at(2)]) };
                        (1..=reach).for_each(|k| values[at(-k)] = sign * values[at(k)]);
                    }
                    DomainFace::Given(state) => {
                        (0..=reach).for_each(|k| values[at(-k)] = state[field]);
                    }
                    DomainFace::Open => {
                        (0..=reach).for_each(|k| values[at(-k)] = values[at(1)]);
                    }
                }
            }
        }
    }
}

/// Value in a mirror of what has these values at one and two points from it: of fourth order, and
/// the first where that would leave what both are.
fn mirrored(first: f64, second: f64) -> f64 {
    let value = first + (first - second) / 3.0;
    if (value - first).abs() <= 0.5 * first.abs() { value } else { first }
}
