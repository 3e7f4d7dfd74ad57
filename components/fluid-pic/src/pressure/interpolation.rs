//! Interpolation from a coarse level to the next finer one, and its transpose.
//!
//! One axis is refined after the other, the first one last. Along an axis each coarse cell has two
//! children, a quarter of its edge on either side of its centre:
//!
//! ```text
//! lower child: q + s_below (q_below - q)       upper child: q + s_above (q_above - q)
//! ```
//!
//! The slope `s` of a face between coarse cells is a quarter where the face is open. It shrinks
//! with the open part of the face, so that nothing is interpolated through a wall. Towards air,
//! where `q` is 0 at the surface, it is steeper.

use crate::grid::periodic_ghosts::PeriodicGhosts;
use crate::pressure::coarsen::LevelShape;
use tremie_team::{Cut, Team};

/// Stored values that are one piece of work.
const PIECE: usize = 8192;

/// The shapes and arrays between two levels.
pub struct Interpolation<const D: usize> {
    /// Shape k has the axes before k coarse and the others fine; k = 0 is the fine level.
    shapes: Vec<LevelShape<D>>,
    /// An array for each shape between the fine level and the coarse one.
    between: Vec<Vec<f32>>,
    /// Ghosts of shape k along axis k, from which the level is made coarser.
    finer: Vec<PeriodicGhosts>,
    /// Ghosts of shape k + 1 along axis k, from which it is refined.
    coarser: Vec<PeriodicGhosts>,
}

/// Rows of a shape: start of each in memory, and the place of the row of coarse cells above which
/// it lies.
struct Row {
    start: usize,
    parent: usize,
    /// 0 for a lower child along the axis, 1 for an upper one.
    side: usize,
}

impl<const D: usize> Interpolation<D> {
    /// Between a level and the next coarser one.
    pub fn new(fine: &LevelShape<D>) -> Self {
        let coarse = fine.coarser();
        let shapes: Vec<_> = (0..=D)
            .map(|k| {
                let of = |coarse: [usize; D], fine: [usize; D]| {
                    std::array::from_fn(|a| if a < k { coarse[a] } else { fine[a] })
                };
                let all = std::array::from_fn(|a| fine.pair[a] * coarse.cells[a]);
                let shape =
                    LevelShape::stored_as(of(coarse.cells, all), of(coarse.room, fine.room));
                LevelShape { periodic: fine.periodic, ..shape }
            })
            .collect();
        // Where the number of cells is odd, ghosts are no neighbours.
        let joined = |k: usize| move |a: usize| a == k && !fine.has_seam(a);
        let finer = (0..D).map(|k| shapes[k].ghosts(joined(k))).collect();
        let coarser = (0..D).map(|k| shapes[k + 1].ghosts(joined(k))).collect();
        let between: Vec<_> = shapes[1..D].iter().map(|shape| vec![0.0; shape.stored]).collect();
        Self { shapes, between, finer, coarser }
    }

    /// The row of the shape `k` that begins at a multiple of its row's length.
    fn row(&self, k: usize, number: usize) -> Option<[isize; D]> {
        let shape = &self.shapes[k];
        let mut at = [0; D];
        let mut rest = number;
        for a in 1..D {
            let stored = shape.room[a] + 2;
            let along = rest % stored;
            rest /= stored;
            if along == 0 || along > shape.cells[a] {
                return None;
            }
            at[a] = along as isize - 1;
        }
        Some(at)
    }

    /// The row of coarse cells to which a row of shape `k` belongs, where axes from `fine` on are
    /// fine.
    fn parent_row(&self, at: [isize; D], fine: usize) -> usize {
        let coarse = &self.shapes[D];
        (1..D)
            .map(|a| {
                let along = if a >= fine && self.is_paired(a) { at[a] / 2 } else { at[a] };
                (along + 1) as usize * coarse.stride[a]
            })
            .sum()
    }

    fn is_paired(&self, axis: usize) -> bool {
        self.shapes[D].cells[axis] < self.shapes[0].cells[axis]
    }

    /// Calls `work` for each row of an array of shape `k`, with its first cell, its number and its
    /// values.
    fn each_row(
        &self,
        team: &mut Team,
        k: usize,
        array: &mut [f32],
        work: impl Fn([isize; D], usize, &mut [f32]) + Sync,
    ) {
        let length = self.shapes[k].row_length();
        let rows_per_piece = (PIECE / length).max(1);
        team.for_pieces(Cut::every(array, length * rows_per_piece), |piece, rows: &mut [f32]| {
            for (number, row) in (piece * rows_per_piece..).zip(rows.chunks_mut(length)) {
                if let Some(at) = self.row(k, number) {
                    work(at, number, row);
                }
            }
        });
    }

    /// Sums the residuals of the fine level into the right side of the coarse one. Ghosts of `rest`
    /// become those of the axes that wrap around, but for a seam.
    pub fn restrict(
        &mut self,
        team: &mut Team,
        rest: &mut [f32],
        slope: &[Vec<f32>; D],
        coarse: &mut [f32],
    ) {
        let mut between = std::mem::take(&mut self.between);
        for k in 0..D {
            let (done, open) = between.split_at_mut(k.min(D - 1));
            let from = if k == 0 { &mut *rest } else { &mut done[k - 1][..] };
            self.finer[k].fill(from);
            let to = if k + 1 == D { &mut *coarse } else { &mut open[0][..] };
            self.restrict_along(team, k, from, &slope[k], to);
        }
        self.between = between;
    }

    fn restrict_along(
        &self,
        team: &mut Team,
        axis: usize,
        from: &[f32],
        slope: &[f32],
        to: &mut [f32],
    ) {
        let (fine, target) = (&self.shapes[axis], &self.shapes[axis + 1]);
        let n = target.cells[0];
        self.each_row(team, axis + 1, to, |at, _, to| {
            let parent = self.parent_row(at, axis + 1);
            let to = &mut to[1..=n];
            if !self.is_paired(axis) {
                to.copy_from_slice(&from[fine.row_start(at) + 1..][..n]);
                return;
            }
            if axis == 0 {
                let s = &slope[parent..][..n + 2];
                let r = &from[fine.row_start(at)..][..2 * n + 2];
                for i in 0..n {
                    let (below, above) = (s[i + 1], s[i + 2]);
                    // Child 0 of the cell stands at 2 i + 1 behind the ghost.
                    let children = &r[2 * i..2 * i + 4];
                    to[i] = below * (children[0] - children[1])
                        + (children[1] + children[2])
                        + above * (children[3] - children[2]);
                }
                return;
            }
            let stride = fine.stride[axis];
            let mut first = at;
            first[axis] *= 2;
            let lower = fine.row_start(first) + 1;
            let coarse_stride = self.shapes[D].stride[axis];
            let below = &slope[parent + 1..][..n];
            let above = &slope[parent + coarse_stride + 1..][..n];
            let row = |start: usize| &from[start..][..n];
            let (r0, r1, r2, r3) =
                (row(lower - stride), row(lower), row(lower + stride), row(lower + 2 * stride));
            for i in 0..n {
                to[i] = below[i] * (r0[i] - r1[i]) + (r1[i] + r2[i]) + above[i] * (r3[i] - r2[i]);
            }
        });
    }

    /// Adds the interpolated coarse solution where there is an equation: where `inverse` is not 0.
    pub fn prolong(
        &mut self,
        team: &mut Team,
        coarse: &mut [f32],
        slope: &[Vec<f32>; D],
        inverse: &[f32],
        q: &mut [f32],
    ) {
        let mut between = std::mem::take(&mut self.between);
        for k in (1..D).rev() {
            let (open, done) = between.split_at_mut(k);
            let from = if k + 1 == D { &mut *coarse } else { &mut done[0][..] };
            self.coarser[k].fill(from);
            self.prolong_along(team, k, from, &slope[k], &mut open[k - 1]);
        }
        let from = if D == 1 { coarse } else { &mut between[0][..] };
        self.coarser[0].fill(from);
        self.prolong_last(team, from, &slope[0], inverse, q);
        self.between = between;
    }

    /// Row of shape `k` as a child along axis `k`.
    fn child(&self, at: [isize; D], axis: usize) -> Row {
        let source = &self.shapes[axis + 1];
        let mut from = at;
        let side = if self.is_paired(axis) { (at[axis] % 2) as usize } else { 0 };
        if self.is_paired(axis) {
            from[axis] /= 2;
        }
        Row { start: source.row_start(from), parent: self.parent_row(at, axis), side }
    }

    fn prolong_along(
        &self,
        team: &mut Team,
        axis: usize,
        from: &[f32],
        slope: &[f32],
        to: &mut [f32],
    ) {
        let (target, source) = (&self.shapes[axis], &self.shapes[axis + 1]);
        let n = target.cells[0];
        let coarse_stride = self.shapes[D].stride[axis];
        self.each_row(team, axis, to, |at, _, to| {
            let Row { start, parent, side } = self.child(at, axis);
            let here = &from[start + 1..][..n];
            let to = &mut to[1..=n];
            if !self.is_paired(axis) {
                to.copy_from_slice(here);
                return;
            }
            let beyond = if side == 0 {
                &from[start + 1 - source.stride[axis]..][..n]
            } else {
                &from[start + 1 + source.stride[axis]..][..n]
            };
            let s = &slope[parent + side * coarse_stride + 1..][..n];
            for i in 0..n {
                to[i] = here[i] + s[i] * (beyond[i] - here[i]);
            }
        });
    }

    fn prolong_last(
        &self,
        team: &mut Team,
        from: &[f32],
        slope: &[f32],
        inverse: &[f32],
        q: &mut [f32],
    ) {
        let (target, source) = (&self.shapes[0], &self.shapes[1]);
        let (length, n) = (target.row_length(), source.cells[0]);
        self.each_row(team, 0, q, |at, number, q| {
            let parent = self.parent_row(at, 0);
            let t = &from[source.row_start(at)..][..n + 2];
            let inverse = &inverse[number * length..][..length];
            let put = |q: &mut f32, inverse: f32, value: f32| {
                *q += if inverse > 0.0 { value } else { 0.0 };
            };
            if !self.is_paired(0) {
                for i in 1..=n {
                    put(&mut q[i], inverse[i], t[i]);
                }
                return;
            }
            let s = &slope[parent..][..n + 2];
            for i in 1..=n {
                let (below, here, above) = (t[i - 1], t[i], t[i + 1]);
                let child = 2 * i - 1;
                put(&mut q[child], inverse[child], here + s[i] * (below - here));
                put(&mut q[child + 1], inverse[child + 1], here + s[i + 1] * (above - here));
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Interpolation and its transpose: `r . P q = (P^T r) . q`, whatever the slopes.
    #[test]
    fn restriction_is_the_transpose_of_interpolation() {
        let mut team = Team::new("test", 2).unwrap();
        let fine = LevelShape::<3>::new([7, 1, 6], [false; 3]);
        let coarse = fine.coarser();
        let mut interpolation = Interpolation::new(&fine);
        let mut seed = 7_u32;
        let mut random = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as f32 / (1 << 24) as f32 - 0.5
        };
        let inside = |shape: &LevelShape<3>, place: usize| {
            let mut rest = place;
            (0..3).rev().all(|a| {
                let along = rest / shape.stride[a];
                rest %= shape.stride[a];
                along > 0 && along <= shape.cells[a]
            })
        };
        let mut values = |shape: &LevelShape<3>| -> Vec<f32> {
            (0..shape.stored).map(|at| if inside(shape, at) { random() } else { 0.0 }).collect()
        };
        let (mut r, mut q) = (values(&fine), values(&coarse));
        let mut slope: [Vec<f32>; 3] = std::array::from_fn(|_| values(&coarse));
        // No slope through the faces of the box.
        for a in 0..3 {
            for at in 0..coarse.stored {
                if at < coarse.stride[a] || !inside(&coarse, at - coarse.stride[a]) {
                    slope[a][at] = 0.0;
                }
            }
        }
        let mut fine_q = vec![0.0; fine.stored];
        interpolation.prolong(&mut team, &mut q, &slope, &vec![1.0; fine.stored], &mut fine_q);
        let mut coarse_r = vec![0.0; coarse.stored];
        interpolation.restrict(&mut team, &mut r, &slope, &mut coarse_r);
        let dot =
            |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| f64::from(a * b)).sum::<f64>();
        let (left, right) = (dot(&r, &fine_q), dot(&coarse_r, &q));
        assert!((left - right).abs() < 1e-5 * left.abs().max(1.0), "{left} {right}");
        assert!(left.abs() > 1e-2);
    }
}
