//! A symmetric matrix stored from each row's first entry to the diagonal, and its factors L D Lᵀ
//! (Jennings 1966). A section of n nodes across takes rows of about 2n entries, which no ordering
//! for general sparse matrices improves much at such sizes.

/// A symmetric matrix in envelope form. The envelope is found once; factors replace the values.
#[derive(Clone, Debug)]
pub(super) struct Skyline {
    /// Column of each row's first entry.
    first: Vec<usize>,
    /// Begin of each row in `values`; row i ends with its diagonal.
    start: Vec<usize>,
    values: Vec<f64>,
    diagonal: Vec<f64>,
    /// A row of L D.
    row: Vec<f64>,
}

/// A pivot of zero: something can move without resistance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Singular;

impl Skyline {
    /// All zero, with room for the entries that couple the unknowns of each group.
    pub fn new<'a>(unknowns: usize, groups: impl Iterator<Item = &'a [usize]>) -> Self {
        let mut first: Vec<usize> = (0..unknowns).collect();
        for group in groups {
            let lowest = group.iter().copied().min().unwrap_or(0);
            for &unknown in group {
                first[unknown] = first[unknown].min(lowest);
            }
        }
        let mut start = vec![0];
        for (row, first) in first.iter().enumerate() {
            start.push(start[row] + row + 1 - first);
        }
        let values = vec![0.0; start[unknowns]];
        Self { first, start, values, diagonal: vec![0.0; unknowns], row: vec![0.0; unknowns] }
    }

    pub fn clear(&mut self) {
        self.values.fill(0.0);
    }

    /// Adds to the entry at `row`, `column` if that is in the lower triangle.
    pub fn add(&mut self, row: usize, column: usize, value: f64) {
        if column <= row {
            self.values[self.start[row] + column - self.first[row]] += value;
        }
    }

    /// Replaces the values by the factors and returns how many pivots are negative.
    ///
    /// No pivot is sought: at a stable equilibrium the matrix is positive definite, and on the way
    /// there its other pivots may be negative, but not small.
    pub fn factor(&mut self) -> Result<usize, Singular> {
        let mut negative = 0;
        for i in 0..self.diagonal.len() {
            let (first, start) = (self.first[i], self.start[i]);
            let largest = self.values[start + i - first].abs();
            self.row[first..=i].copy_from_slice(&self.values[start..start + i - first + 1]);
            for j in first..i {
                let from = first.max(self.first[j]);
                let above =
                    &self.values[self.start[j] + from - self.first[j]..self.start[j + 1] - 1];
                self.row[j] -= dot(&self.row[from..j], above);
            }
            let mut pivot = self.row[i];
            for j in first..i {
                let factor = self.row[j] / self.diagonal[j];
                pivot -= factor * self.row[j];
                self.values[start + j - first] = factor;
            }
            if pivot.abs() <= 1e-14 * largest || pivot.is_nan() {
                return Err(Singular);
            }
            negative += usize::from(pivot < 0.0);
            self.diagonal[i] = pivot;
        }
        Ok(negative)
    }

    /// Solves with the factors; `x` holds the right side and then the solution.
    pub fn solve(&self, x: &mut [f64]) {
        let n = self.diagonal.len();
        for i in 0..n {
            let row = self.below(i);
            x[i] -= dot(row, &x[self.first[i]..i]);
        }
        for (x, pivot) in x.iter_mut().zip(&self.diagonal) {
            *x /= pivot;
        }
        for i in (0..n).rev() {
            let value = x[i];
            for (factor, x) in self.below(i).iter().zip(&mut x[self.first[i]..i]) {
                *x -= factor * value;
            }
        }
    }

    /// Row of L without its diagonal.
    fn below(&self, row: usize) -> &[f64] {
        &self.values[self.start[row]..self.start[row + 1] - 1]
    }
}

/// In four partial sums, always the same four: vectorised, and the same bits everywhere.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (a_fours, a_rest) = a.as_chunks::<4>();
    let (b_fours, b_rest) = b.as_chunks::<4>();
    for (a, b) in a_fours.iter().zip(b_fours) {
        for lane in 0..4 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain of triples; entries from a fixed pattern, not positive definite.
    fn example() -> (Skyline, Vec<Vec<f64>>) {
        let groups: Vec<Vec<usize>> = (0..9).map(|i| vec![i, i + 1, (i * 5 + 3) % 11]).collect();
        let mut matrix = Skyline::new(11, groups.iter().map(Vec::as_slice));
        let mut dense = vec![vec![0.0; 11]; 11];
        for (number, group) in groups.iter().enumerate() {
            for &a in group {
                for &b in group {
                    let value = 1.0 / (1.0 + number as f64 + (a + b) as f64)
                        - 0.3 * f64::from(u8::from(a == b));
                    matrix.add(a, b, value);
                    dense[a][b] += value;
                }
            }
        }
        for i in 0..11 {
            let sign = if i % 4 == 1 { -3.0 } else { 3.0 };
            matrix.add(i, i, sign);
            dense[i][i] += sign;
        }
        (matrix, dense)
    }

    #[test]
    fn solves_an_indefinite_system() {
        let (mut matrix, dense) = example();
        let expected: Vec<f64> = (0..11).map(|i| 1.0 - 0.2 * i as f64).collect();
        let mut x: Vec<f64> =
            dense.iter().map(|row| row.iter().zip(&expected).map(|(a, x)| a * x).sum()).collect();
        assert_eq!(matrix.factor(), Ok(3), "as many negative pivots as negative eigenvalues");
        matrix.solve(&mut x);
        for (x, expected) in x.iter().zip(&expected) {
            assert!((x - expected).abs() < 1e-13, "{x} {expected}");
        }
    }

    #[test]
    fn a_loose_part_is_singular() {
        let mut matrix = Skyline::new(3, [&[0, 1][..], &[2]].into_iter());
        for (a, b, value) in [(0, 0, 1.0), (1, 0, -1.0), (1, 1, 1.0), (2, 2, 1.0)] {
            matrix.add(a, b, value);
        }
        assert_eq!(matrix.factor(), Err(Singular));
    }
}
