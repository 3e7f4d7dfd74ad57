//! Force and vertices between frames: both linear in the compression, with the same weight.

use crate::mesh::Point;
use crate::table::check::{TableError, check};
use crate::table::contents::Contents;

/// Force and shape of a seal over its compression; all of it is checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    contents: Contents,
}

/// A place between two frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bracket {
    /// The frame before.
    pub frame: usize,
    /// Weight of the frame after, 0 to 1.
    pub weight: f64,
}

/// A compression beyond the table's last.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the seal is compressed by {:.4} mm, its table ends at {:.4} mm; make a table with a larger compression, or look for what presses so hard",
        1e3 * compression, 1e3 * last)]
pub struct BeyondTable {
    /// The compression [m].
    pub compression: f64,
    /// The table's last [m].
    pub last: f64,
}

impl Table {
    /// The table with these contents.
    ///
    /// # Errors
    /// If they are no table.
    pub fn new(contents: Contents) -> Result<Self, TableError> {
        check(&contents)?;
        Ok(Self { contents })
    }

    /// All that it holds.
    pub fn contents(&self) -> &Contents {
        &self.contents
    }

    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.contents.compressions.len()
    }

    /// The largest compression [m].
    pub fn last_compression(&self) -> f64 {
        self.contents.compressions[self.frames() - 1]
    }

    /// Place of `compression` [m] among the frames.
    ///
    /// # Errors
    /// If it lies beyond the last, or is no number.
    pub fn bracket(&self, compression: f64) -> Result<Bracket, BeyondTable> {
        let (all, last) = (&self.contents.compressions, self.last_compression());
        if compression > last || compression.is_nan() {
            return Err(BeyondTable { compression, last });
        }
        let after = all.partition_point(|c| *c <= compression).clamp(1, all.len() - 1);
        let (a, b) = (all[after - 1], all[after]);
        Ok(Bracket { frame: after - 1, weight: ((compression - a) / (b - a)).max(0.0) })
    }

    /// Force of the seat at a place between frames [N].
    pub fn force(&self, at: Bracket) -> f64 {
        mix(at.weight, self.contents.forces[at.frame], self.contents.forces[at.frame + 1])
    }

    /// Slope of the force between the two frames [N/m].
    pub fn slope(&self, at: Bracket) -> f64 {
        let rise = |values: &[f64]| values[at.frame + 1] - values[at.frame];
        rise(&self.contents.forces) / rise(&self.contents.compressions)
    }

    /// Writes the vertices at a place between frames into `out` [m], which must have room for each.
    pub fn vertices_into(&self, at: Bracket, out: &mut [Point]) {
        let (a, b) = (&self.contents.vertices[at.frame], &self.contents.vertices[at.frame + 1]);
        for ((out, a), b) in out.iter_mut().zip(a).zip(b) {
            *out = [mix(at.weight, a[0], b[0]), mix(at.weight, a[1], b[1])];
        }
    }

    /// As [`Table::vertices_into`], for these `vertices` alone.
    pub fn vertices_of_into(&self, at: Bracket, vertices: &[usize], out: &mut [Point]) {
        let (a, b) = (&self.contents.vertices[at.frame], &self.contents.vertices[at.frame + 1]);
        for (out, vertex) in out.iter_mut().zip(vertices) {
            let (a, b) = (a[*vertex], b[*vertex]);
            *out = [mix(at.weight, a[0], b[0]), mix(at.weight, a[1], b[1])];
        }
    }

    /// The vertices at a place between frames [m].
    pub fn vertices(&self, at: Bracket) -> Vec<Point> {
        let mut out = self.contents.vertices[at.frame].clone();
        self.vertices_into(at, &mut out);
        out
    }
}

fn mix(weight: f64, a: f64, b: f64) -> f64 {
    (1.0 - weight) * a + weight * b
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::example;

    #[test]
    fn force_and_vertices_have_the_same_weight() {
        let table = Table::new(example()).unwrap();
        let at = table.bracket(0.15).unwrap();
        assert_eq!(at.frame, 1);
        assert!((table.force(at) - 8.75).abs() < 1e-12);
        assert!((table.slope(at) - 75.0).abs() < 1e-9);
        assert!((table.vertices(at)[1][0] - 2.15).abs() < 1e-12);
        let frame = table.bracket(0.1).unwrap();
        assert_eq!(
            (table.force(frame), table.vertices(frame)),
            (5.0, example().vertices[1].clone())
        );
        let last = table.bracket(0.3).unwrap();
        assert_eq!((last.frame, table.force(last)), (1, 20.0));
    }

    #[test]
    fn below_zero_it_rests_and_beyond_the_end_is_an_error() {
        let table = Table::new(example()).unwrap();
        for compression in [0.0, -1e-9, -5.0, f64::NEG_INFINITY] {
            let at = table.bracket(compression).unwrap();
            assert_eq!((table.force(at), table.vertices(at)), (0.0, example().vertices[0].clone()));
        }
        for compression in [0.300_001, f64::INFINITY, f64::NAN] {
            let error = table.bracket(compression).unwrap_err().to_string();
            assert!(error.contains("300.0000 mm"), "{error}");
        }
    }
}
