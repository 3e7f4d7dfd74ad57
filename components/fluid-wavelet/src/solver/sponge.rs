//! A layer at faces of the domain in which the gas relaxes to a state: what runs into it comes back
//! neither from it nor from the face.

use crate::bodies::body_mask::BlockPlaces;
use crate::gas::gas_law::MOST_FIELDS;
use crate::grid::block_tree::{BlockAddress, BlockDomain};

/// A layer along faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sponge {
    /// The faces, the lower and the upper one of each axis.
    pub faces: [[bool; 2]; 3],
    /// Width [m].
    pub width: f64,
    /// Rate of relaxation at the face, from which it falls by its square [1/s].
    pub rate: f64,
    /// Fields of the state.
    pub state: [f64; MOST_FIELDS],
}

impl Sponge {
    /// Adds the relaxation of a block's own points to their rates.
    pub fn add(
        &self,
        domain: &BlockDomain,
        places: &BlockPlaces,
        block: BlockAddress,
        own: &[f64],
        rates: &mut [f64],
    ) {
        let shape = &places.shape;
        let upper: [f64; 3] = std::array::from_fn(|a| {
            let points = domain.blocks_along(0, a) as usize * shape.edge[a];
            places.origin[a] + places.coarsest * points as f64
        });
        // Most blocks are far from all faces.
        let low = places.padded_point(block, shape.ghosts);
        let high: [f64; 3] = std::array::from_fn(|a| {
            low[a] + places.spacing(block.level) * (shape.edge[a] - 1) as f64
        });
        let is_near = (0..shape.dims).any(|a| {
            self.faces[a][0] && low[a] - places.origin[a] < self.width
                || self.faces[a][1] && upper[a] - high[a] < self.width
        });
        if !is_near {
            return;
        }
        for point in 0..shape.points {
            let at = places.padded_point(block, shape.padded_at(point));
            let mut to_face = f64::INFINITY;
            for a in 0..shape.dims {
                for (side, way) in
                    [at[a] - places.origin[a], upper[a] - at[a]].into_iter().enumerate()
                {
                    to_face = if self.faces[a][side] { to_face.min(way) } else { to_face };
                }
            }
            let inside = 1.0 - to_face / self.width;
            if inside > 0.0 {
                let rate = self.rate * inside * inside;
                for field in 0..shape.dims + 2 {
                    let k = field * shape.points + point;
                    rates[k] -= rate * (own[k] - self.state[field]);
                }
            }
        }
    }
}
