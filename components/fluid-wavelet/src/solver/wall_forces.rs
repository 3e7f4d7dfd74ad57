//! Forces of the gas on the faces of the domain.

use crate::gas::gas_law::MOST_FIELDS;
use crate::gas::viscous_flux::at_point;
use crate::grid::block_shape::BlockShape;
use crate::solver::wavelet_solver::WaveletSolver;

impl WaveletSolver {
    /// Force on a face of the domain: pressure from that at rest, and shear where the gas sticks
    /// [N]; of a plane gas for a metre of depth. Ghosts are filled.
    pub fn wall_force(&self, axis: usize, side: usize) -> [f64; 3] {
        let (shape, places, settings) = (self.shape(), self.places(), &self.settings);
        let (dims, count, gas) = (shape.dims, self.values.fields, &settings.gas);
        let stride = shape.stride[axis];
        // Outward.
        let outward = [-1.0, 1.0][side];
        let mut force = [0.0; 3];
        for &leaf in &self.tree.leaves {
            let (slot, block) = (leaf as usize, self.tree.blocks[leaf as usize]);
            let end = [0, self.tree.domain.blocks_along(block.level, axis) - 1][side];
            if block.at[axis] != end {
                continue;
            }
            let spacing = places.spacing(block.level);
            let area = spacing.powi(dims as i32 - 1);
            let field = |number: usize| {
                &self.values.padded[(slot * count + number) * shape.stored..][..shape.stored]
            };
            let fields: [&[f64]; MOST_FIELDS] =
                std::array::from_fn(|number| field(number.min(count - 1)));
            let marks = self.mask.of(&shape, slot);
            for (place, weight) in face_points(&shape, axis, side) {
                if marks.is_some_and(|marks| marks[place] != 0) {
                    continue;
                }
                let state = gas.state(dims, &fields.map(|field| field[place]));
                let push = weight * area;
                force[axis] += outward * push * (state.pressure - settings.rest_pressure);
                if gas.viscosity == 0.0 {
                    continue;
                }
                let temperature = state.pressure / (state.density * gas.gas_constant);
                let viscosity = gas.viscosity_at(temperature) / spacing;
                for a in (0..dims).filter(|&a| a != axis) {
                    // The velocity's slope, by momentum and density.
                    let [momentum, density] =
                        [fields[1 + a], fields[0]].map(|field| at_point(field, place, stride));
                    let slope = (momentum - state.velocity[a] * density) / state.density;
                    force[a] -= outward * push * viscosity * slope;
                }
            }
        }
        force
    }
}

/// Places of a block's points on a face of the domain, with their weights in points.
fn face_points(
    shape: &BlockShape,
    axis: usize,
    side: usize,
) -> impl Iterator<Item = (usize, f64)> + use<> {
    let shape = *shape;
    let (from, mut to) = shape.own();
    // The points at both ends of the block count by half.
    (0..shape.dims).for_each(|a| to[a] += 1);
    let mut first = from;
    if side == 1 {
        first[axis] = from[axis] + shape.edge[axis];
    }
    to[axis] = first[axis] + 1;
    (first[2]..to[2]).flat_map(move |z| {
        (first[1]..to[1]).flat_map(move |y| {
            (first[0]..to[0]).map(move |x| {
                let at = [x, y, z];
                let is_end = |a: usize| {
                    a < shape.dims && a != axis && (at[a] == from[a] || at[a] + 1 == to[a])
                };
                let halves = (0..3).filter(|&a| is_end(a)).count();
                (shape.place(at), 0.5_f64.powi(halves as i32))
            })
        })
    })
}
