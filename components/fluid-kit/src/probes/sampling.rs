//! Cells that a probe reads.

use crate::cells::centres::Centres;
use crate::cells::grid::Grid;
use std::ops::Range;
use tremie_messages::scene::ProbeShape;

/// Cells that a probe reads, with their weights.
pub fn samples(grid: &Grid, centres: &Centres, shape: &ProbeShape) -> Vec<([i32; 3], f64)> {
    match shape {
        ProbeShape::Point(point) => between(grid, centres, *point),
        ProbeShape::Line { from, to } => {
            let along: [f64; 3] = std::array::from_fn(|a| to[a] - from[a]);
            let length = along.iter().map(|x| x * x).sum::<f64>().sqrt();
            // At least two points a cell.
            let count = (2.0 * length / centres.cell).ceil().max(1.0);
            let at = |k: i32| {
                let s = (f64::from(k) + 0.5) / count;
                std::array::from_fn(|a| from[a] + s * along[a])
            };
            (0..count as i32).flat_map(|k| between(grid, centres, at(k))).collect()
        }
        ProbeShape::Section { axis, position, min, max }
        | ProbeShape::Profile { axis, position, min, max, .. } => {
            let layer = ((position - centres.min[*axis]) / centres.cell).floor() as i32;
            let layer = layer.clamp(0, grid.n[*axis] - 1);
            let mut range = range(grid, centres, min, max);
            range[*axis] = layer..layer + 1;
            each(range)
        }
        ProbeShape::Region { min, max } => each(range(grid, centres, min, max)),
        ProbeShape::Ring(ring) => {
            let [min, max] = ring.corners();
            let centre = |at: [i32; 3]| {
                std::array::from_fn(|a| centres.min[a] + centres.cell * (f64::from(at[a]) + 0.5))
            };
            let mut cells = each(range(grid, centres, &min, &max));
            cells.retain(|(at, _)| ring.holds(centre(*at)));
            cells
        }
    }
}

/// Cells whose centres lie in a box.
fn range(grid: &Grid, centres: &Centres, min: &[f64; 3], max: &[f64; 3]) -> [Range<i32>; 3] {
    std::array::from_fn(|a| {
        let place = |x: f64| (x - centres.min[a]) / centres.cell - 0.5;
        let n = f64::from(grid.n[a]);
        let first = place(min[a]).ceil().clamp(0.0, n) as i32;
        first..(place(max[a]).floor() + 1.0).clamp(0.0, n) as i32
    })
}

fn each([x, y, z]: [Range<i32>; 3]) -> Vec<([i32; 3], f64)> {
    let rows = z.flat_map(|z| y.clone().map(move |y| (y, z)));
    rows.flat_map(|(y, z)| x.clone().map(move |x| ([x, y, z], 1.0))).collect()
}

/// The eight cells around a point, linear weights; at the box's faces the nearest ones.
fn between(grid: &Grid, centres: &Centres, point: [f64; 3]) -> Vec<([i32; 3], f64)> {
    let place: [f64; 3] = std::array::from_fn(|a| (point[a] - centres.min[a]) / centres.cell - 0.5);
    let corner = |k: usize| {
        let mut weight = 1.0;
        let at = std::array::from_fn(|a| {
            let (low, upper) = (place[a].floor(), k >> a & 1);
            let part = place[a] - low;
            weight *= if upper == 1 { part } else { 1.0 - part };
            let cell = low as i32 + upper as i32;
            if grid.periodic[a] { grid.wrap(a, cell) } else { cell.clamp(0, grid.n[a] - 1) }
        });
        (at, weight)
    };
    (0..8).map(corner).filter(|&(_, weight)| weight > 0.0).collect()
}
