//! Rows of cells that take part in a computation, in pieces for a team of threads.

use std::ops::Range;
use tremie_team::instructions::Work;
use tremie_team::{Cut, Team, Variant};

/// Stored cells of a piece, if a row is not longer.
const CELLS_PER_PIECE: usize = 4096;

/// What a cell's value becomes, span by span. `fill` is to be inlined, and all that it calls in its
/// loops: else the compiler keeps them in portable instructions.
pub trait FillSpan<T>: Sync {
    /// Gives values to the stored cells of a span.
    fn fill(&self, span: &Range<usize>, values: &mut [T]);
}

/// The spans of a piece, filled.
struct FillPiece<'a, T, F> {
    rows: &'a CellRows,
    piece: usize,
    values: &'a mut [T],
    work: &'a F,
}

impl<T, F: FillSpan<T>> Work for FillPiece<'_, T, F> {
    #[inline(always)]
    fn run(self) {
        let first = self.rows.start(self.piece);
        for span in self.rows.spans(self.piece) {
            let values = &mut self.values[span.start - first..span.end - first];
            self.work.fill(&span, values);
        }
    }
}

/// Cells that take part, row by row: of each row the range from the first to the last of them. Rows
/// are grouped in pieces that do not depend on the number of threads, so that sums do not either.
#[derive(Clone, Debug, Default)]
pub struct CellRows {
    /// Piece k has the stored cells from entry k to entry k + 1.
    bounds: Vec<u32>,
    /// Ranges of stored cells, in their order.
    spans: Vec<Range<u32>>,
    /// Piece k has the spans from entry k to entry k + 1.
    first_span: Vec<u32>,
}

impl CellRows {
    /// Takes stored cells in rows of a length. `takes_part` says which.
    pub fn rebuild(&mut self, stored: usize, row: usize, takes_part: impl Fn(usize) -> bool) {
        self.rebuild_spans(stored, row, |start| {
            let end = (start + row).min(stored);
            let first = (start..end).find(|&at| takes_part(at))?;
            let last = (first..end).rev().find(|&at| takes_part(at)).unwrap_or(first);
            Some(first..last + 1)
        });
    }

    /// Takes of each row, given its start, a range of stored cells.
    pub fn rebuild_spans(
        &mut self,
        stored: usize,
        row: usize,
        mut span: impl FnMut(usize) -> Option<Range<usize>>,
    ) {
        let piece = row * (CELLS_PER_PIECE / row).max(1);
        self.bounds.clear();
        self.spans.clear();
        self.first_span.clear();
        for start in (0..stored).step_by(row) {
            if start % piece == 0 {
                self.bounds.push(start as u32);
                self.first_span.push(self.spans.len() as u32);
            }
            if let Some(span) = span(start) {
                self.spans.push(span.start as u32..span.end as u32);
            }
        }
        self.bounds.push(stored as u32);
        self.first_span.push(self.spans.len() as u32);
    }

    /// First stored cell of a piece.
    #[inline(always)]
    fn start(&self, piece: usize) -> usize {
        self.bounds[piece] as usize
    }

    /// Ranges of stored cells of a piece.
    #[inline(always)]
    pub fn spans(&self, piece: usize) -> impl Iterator<Item = Range<usize>> + '_ {
        let spans = self.first_span[piece] as usize..self.first_span[piece + 1] as usize;
        self.spans[spans].iter().map(|span| span.start as usize..span.end as usize)
    }

    /// Fills the spans of an array, in the widest instructions that are there.
    #[inline(always)]
    pub fn fill<T: Send>(
        &self,
        team: &mut Team,
        variant: Variant,
        values: &mut [T],
        work: &impl FillSpan<T>,
    ) {
        team.for_pieces(Cut::at(values, &self.bounds), |piece, values: &mut [T]| {
            variant.run(FillPiece { rows: self, piece, values, work });
        });
    }

    /// Number of pieces.
    pub fn pieces(&self) -> usize {
        self.bounds.len().saturating_sub(1)
    }

    /// Ranges of all stored cells that take part.
    pub fn all_spans(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        self.spans.iter().map(|span| span.start as usize..span.end as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_hold_all_that_take_part() {
        let takes_part = |at: usize| at % 100 > 20 && at % 100 < 30 && at / 100 % 7 != 3;
        let mut rows = CellRows::default();
        rows.rebuild(100_000, 100, takes_part);
        let in_spans: usize = rows.all_spans().map(|span| span.len()).sum();
        assert_eq!(in_spans, (0..100_000).filter(|&at| takes_part(at)).count());
        let by_piece: usize = (0..rows.bounds.len() - 1)
            .flat_map(|k| rows.spans(k).collect::<Vec<_>>())
            .map(|s| s.len())
            .sum();
        assert_eq!(by_piece, in_spans);
        for piece in 0..rows.bounds.len() - 1 {
            assert!(rows.spans(piece).all(|span| span.start >= rows.start(piece)));
        }
    }
}
