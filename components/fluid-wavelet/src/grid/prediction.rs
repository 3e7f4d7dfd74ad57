//! Interpolation of a block from its parent: what the interpolating wavelets of fourth order
//! (Deslauriers and Dubuc) predict on the finer level.
//!
//! Even points are the parent's. Odd ones are `(-1, 9, 9, -1)/16` of the four nearest along each
//! axis in turn.

use crate::grid::block_shape::{BlockShape, GHOSTS};

/// Interpolates one field of a block, ghosts included, from its parent's, whose ghosts are filled.
/// `child` is the number of the block among its parent's children. `room` is as long as a field.
pub fn predict(
    shape: &BlockShape,
    child: usize,
    parent: &[f64],
    out: &mut [f64],
    room: &mut [f64],
) {
    let half = shape.half(child);
    match shape.dims {
        1 => refine_along(shape, 0, half[0], parent, out),
        2 => {
            refine_along(shape, 1, half[1], parent, room);
            refine_along(shape, 0, half[0], room, out);
        }
        _ => {
            refine_along(shape, 2, half[2], parent, out);
            refine_along(shape, 1, half[1], out, room);
            refine_along(shape, 0, half[0], room, out);
        }
    }
}

/// The parent's point at or below a child's along an axis, both counted from the first ghost, and
/// whether the child's lies between it and the next.
#[inline(always)]
pub fn parent_point(edge: usize, half: usize, point: usize) -> (usize, bool) {
    // Along the parent, point p of the child is (half edge + p - GHOSTS)/2 beyond its first own one.
    let along = (half * edge + point) as isize - GHOSTS as isize;
    ((along.div_euclid(2) + GHOSTS as isize) as usize, along.rem_euclid(2) == 1)
}

/// Interpolates along one axis.
fn refine_along(shape: &BlockShape, axis: usize, half: usize, from: &[f64], to: &mut [f64]) {
    if axis == 0 {
        return refine_rows(shape, half, from, to);
    }
    let (edge, stride, run) = (shape.edge[axis], shape.stride[axis], shape.padded[0]);
    let mut end = shape.padded;
    end[axis] = 1;
    for point in 0..shape.padded[axis] {
        let (below, is_between) = parent_point(edge, half, point);
        for row in shape.rows([0; 3], end) {
            let (at, source) = (row + point * stride, row + below * stride);
            let of = |first: usize| &from[first..first + run];
            let to = &mut to[at..at + run];
            if is_between {
                let (f0, f1) = (of(source - stride), of(source));
                let (f2, f3) = (of(source + stride), of(source + 2 * stride));
                for k in 0..run {
                    to[k] = between([f0[k], f1[k], f2[k], f3[k]]);
                }
            } else {
                to.copy_from_slice(of(source));
            }
        }
    }
}

/// Interpolates along x, row by row.
fn refine_rows(shape: &BlockShape, half: usize, from: &[f64], to: &mut [f64]) {
    let first = parent_point(shape.edge[0], half, 0);
    let run = shape.padded[0];
    for row in shape.rows([0; 3], [1, shape.padded[1], shape.padded[2]]) {
        let (from, to) = (&from[row..row + run], &mut to[row..row + run]);
        let (mut below, mut is_between) = first;
        for to in to {
            if is_between {
                let of = &from[below - 1..below + 3];
                *to = between([of[0], of[1], of[2], of[3]]);
                below += 1;
            } else {
                *to = from[below];
            }
            is_between = !is_between;
        }
    }
}

/// The value in the middle of four points.
#[inline(always)]
fn between([f0, f1, f2, f3]: [f64; 4]) -> f64 {
    (9.0 * (f1 + f2) - (f0 + f3)) * (1.0 / 16.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cubic in each coordinate, which fourth order is exact for.
    fn cubic(x: [f64; 3]) -> f64 {
        x.iter().zip([0.7, -0.3, 0.5]).map(|(x, c)| 1.0 + x * (c + x * (0.2 - c * x))).product()
    }

    #[test]
    fn cubics_are_predicted_exactly() {
        for (dims, edge) in [(1, 16), (2, 8), (3, 4)] {
            let shape = BlockShape::new(dims, edge);
            let fill = |origin: [f64; 3], spacing: f64| -> Vec<f64> {
                let mut field = vec![0.0; shape.stored];
                for z in 0..shape.padded[2] {
                    for y in 0..shape.padded[1] {
                        for x in 0..shape.padded[0] {
                            let at = [x, y, z];
                            field[shape.place(at)] = cubic(std::array::from_fn(|a| {
                                origin[a] + spacing * (at[a] as f64 - shape.ghosts[a] as f64)
                            }));
                        }
                    }
                }
                field
            };
            let parent = fill([0.0; 3], 0.1);
            for child in 0..shape.children() {
                let half = shape.half(child);
                let origin = half.map(|h| 0.05 * (h * edge) as f64);
                let (mut found, mut room) = (vec![0.0; shape.stored], vec![0.0; shape.stored]);
                predict(&shape, child, &parent, &mut found, &mut room);
                for (found, exact) in found.iter().zip(fill(origin, 0.05)) {
                    assert!((found - exact).abs() < 1e-13, "{dims}-d child {child}");
                }
            }
        }
    }
}
