//! Sums over the cells of rows, and the vectors of an iteration: the same bits on any number of
//! threads and in whichever instructions, because pieces and lanes are always the same.

use crate::grid::cell_rows::{CellRows, FillSpan};
use std::ops::Range;
use tremie_team::instructions::Work;
use tremie_team::{Cut, Team, Variant};

/// Partial sums that are made side by side.
const LANES: usize = 8;

/// Room for the sums of pieces.
#[derive(Clone, Debug, Default)]
pub struct RowSums {
    of_pieces: Vec<f64>,
}

/// What is summed over cells, or the largest of which is found. `add` is to be inlined.
trait PieceSum<const N: usize>: Sync {
    /// Takes the cells of a span, whose results it joins with those that are there.
    fn add(&self, span: Range<usize>, results: &mut [f64; N]);
}

/// The results of a piece.
struct SumPiece<'a, S, const N: usize> {
    rows: &'a CellRows,
    piece: usize,
    results: &'a mut [f64],
    sum: &'a S,
}

impl<S: PieceSum<N>, const N: usize> Work for SumPiece<'_, S, N> {
    #[inline(always)]
    fn run(self) {
        let mut results = [0.0; N];
        for span in self.rows.spans(self.piece) {
            self.sum.add(span, &mut results);
        }
        self.results.copy_from_slice(&results);
    }
}

/// Scalar products of pairs of arrays.
struct Dots<'a, const N: usize>([[&'a [f64]; 2]; N]);

impl<const N: usize> PieceSum<N> for Dots<'_, N> {
    #[inline(always)]
    fn add(&self, span: Range<usize>, results: &mut [f64; N]) {
        for ([a, b], result) in self.0.iter().zip(results) {
            let (a, rest_a) = a[span.clone()].as_chunks::<LANES>();
            let (b, rest_b) = b[span.clone()].as_chunks::<LANES>();
            let mut lanes = [0.0; LANES];
            for (a, b) in a.iter().zip(b) {
                for lane in 0..LANES {
                    lanes[lane] += a[lane] * b[lane];
                }
            }
            let rest: f64 = rest_a.iter().zip(rest_b).map(|(a, b)| a * b).sum();
            *result += lanes.iter().sum::<f64>() + rest;
        }
    }
}

/// The largest magnitude.
struct Largest<'a>(&'a [f64]);

impl PieceSum<1> for Largest<'_> {
    #[inline(always)]
    fn add(&self, span: Range<usize>, [result]: &mut [f64; 1]) {
        let (values, rest) = self.0[span].as_chunks::<LANES>();
        let mut lanes = [0.0_f64; LANES];
        for values in values {
            for lane in 0..LANES {
                lanes[lane] = lanes[lane].max(values[lane].abs());
            }
        }
        let all = lanes.iter().chain(rest);
        *result = all.fold(*result, |most, value| most.max(value.abs()));
    }
}

/// `own + factor other`.
struct AddScaled<'a> {
    factor: f64,
    other: &'a [f64],
}

impl FillSpan<f64> for AddScaled<'_> {
    #[inline(always)]
    fn fill(&self, span: &Range<usize>, values: &mut [f64]) {
        for (own, other) in values.iter_mut().zip(&self.other[span.clone()]) {
            *own += self.factor * other;
        }
    }
}

/// `other + factor own`.
struct Turn<'a> {
    factor: f64,
    other: &'a [f64],
}

impl FillSpan<f64> for Turn<'_> {
    #[inline(always)]
    fn fill(&self, span: &Range<usize>, values: &mut [f64]) {
        for (own, other) in values.iter_mut().zip(&self.other[span.clone()]) {
            *own = other + self.factor * *own;
        }
    }
}

impl RowSums {
    fn of<const N: usize>(
        &mut self,
        team: &mut Team,
        variant: Variant,
        rows: &CellRows,
        sum: &impl PieceSum<N>,
    ) -> &[[f64; N]] {
        self.of_pieces.clear();
        self.of_pieces.resize(N * rows.pieces(), 0.0);
        team.for_pieces(Cut::every(&mut self.of_pieces, N), |piece, results: &mut [f64]| {
            variant.run(SumPiece { rows, piece, results, sum });
        });
        self.of_pieces.as_chunks().0
    }

    /// Scalar products of pairs of arrays.
    pub fn dots<const N: usize>(
        &mut self,
        team: &mut Team,
        variant: Variant,
        rows: &CellRows,
        pairs: [[&[f64]; 2]; N],
    ) -> [f64; N] {
        let of_pieces = self.of(team, variant, rows, &Dots(pairs));
        of_pieces.iter().fold([0.0; N], |sums, piece| std::array::from_fn(|k| sums[k] + piece[k]))
    }

    /// The largest magnitude in an array.
    pub fn largest(
        &mut self,
        team: &mut Team,
        variant: Variant,
        rows: &CellRows,
        values: &[f64],
    ) -> f64 {
        let of_pieces = self.of(team, variant, rows, &Largest(values));
        of_pieces.iter().fold(0.0, |most, [piece]| most.max(*piece))
    }
}

impl CellRows {
    /// `values += factor other`.
    pub fn add_scaled(
        &self,
        (team, variant): (&mut Team, Variant),
        values: &mut [f64],
        factor: f64,
        other: &[f64],
    ) {
        self.fill(team, variant, values, &AddScaled { factor, other });
    }

    /// `values = other + factor values`.
    pub fn turn(
        &self,
        (team, variant): (&mut Team, Variant),
        values: &mut [f64],
        factor: f64,
        other: &[f64],
    ) {
        self.fill(team, variant, values, &Turn { factor, other });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_the_same_bits_in_all_instructions_and_on_all_threads() {
        let (stored, row) = (40_000, 200);
        let value = |k: usize| ((k * 7919) % 1013) as f64 / 97.0 - 5.0;
        let a: Vec<f64> = (0..stored).map(value).collect();
        let b: Vec<f64> = (0..stored).map(|k| value(k + 11)).collect();
        let mut rows = CellRows::default();
        rows.rebuild(stored, row, |at| at % row > 3 && at % row < 190 && at / row % 5 != 2);
        let expected: f64 = rows.all_spans().flatten().map(|at| a[at] * b[at]).sum();
        let mut found = Vec::new();
        for threads in [1, 2, 3] {
            let mut team = Team::new("test", threads).unwrap();
            for variant in Variant::ALL {
                let mut sums = RowSums::default();
                let [dot] = sums.dots(&mut team, variant, &rows, [[&a, &b]]);
                let most = sums.largest(&mut team, variant, &rows, &a);
                let mut c = a.clone();
                rows.turn((&mut team, variant), &mut c, 0.3, &b);
                rows.add_scaled((&mut team, variant), &mut c, -1.7, &a);
                found.push((dot.to_bits(), most.to_bits(), c));
            }
        }
        assert!(found.iter().all(|one| *one == found[0]));
        let (dot, most, c) = &found[0];
        assert!((f64::from_bits(*dot) - expected).abs() < 1e-9 * expected.abs().max(1e3));
        let largest = rows.all_spans().flatten().map(|at| a[at].abs()).fold(0.0, f64::max);
        assert_eq!(f64::from_bits(*most), largest);
        let at = rows.all_spans().flatten().nth(77).unwrap();
        assert!((c[at] - (b[at] + 0.3 * a[at] - 1.7 * a[at])).abs() < 1e-13);
        assert_eq!(c[0], a[0], "cells of no row stay as they are");
    }
}
