//! Cholesky factorisation and solves in place, on the leading block of
//! preallocated storage, without allocation.

use nalgebra::DMatrix;

/// A lower triangular factor of at most the size it was made for.
#[derive(Debug, Clone)]
pub(crate) struct Cholesky {
    /// Row-major, so that the inner products run over adjacent numbers.
    rows: Vec<f64>,
    inverse_diagonal: Vec<f64>,
    size: usize,
}

impl Cholesky {
    pub(crate) fn new(capacity: usize) -> Self {
        Self {
            rows: vec![0.0; capacity * capacity],
            inverse_diagonal: vec![0.0; capacity],
            size: 0,
        }
    }

    /// Factors `matrix + shift I`; `false` when that is not positive definite.
    pub(crate) fn factor(&mut self, matrix: &DMatrix<f64>, shift: f64) -> bool {
        let n = matrix.nrows();
        self.fill(n, |i, j| matrix[(i, j)] + if i == j { shift } else { 0.0 })
    }

    /// Factors the rows and columns `chosen` of `matrix`.
    pub(crate) fn factor_block(&mut self, matrix: &DMatrix<f64>, chosen: &[usize]) -> bool {
        self.fill(chosen.len(), |i, j| matrix[(chosen[i], chosen[j])])
    }

    #[inline]
    fn fill(&mut self, n: usize, entry: impl Fn(usize, usize) -> f64) -> bool {
        self.size = n;
        for i in 0..n {
            let (above, rest) = self.rows.split_at_mut(i * n);
            let row = &mut rest[..n];
            for j in 0..i {
                let other = &above[j * n..j * n + j];
                let product = dot(&row[..j], other);
                row[j] = (entry(i, j) - product) * self.inverse_diagonal[j];
            }
            let pivot = entry(i, i) - dot(&row[..i], &row[..i]);
            // Written for NaN as well: a metric with one must not give accelerations.
            if pivot.is_nan() || pivot <= 0.0 {
                return false;
            }
            let root = pivot.sqrt();
            row[i] = root;
            self.inverse_diagonal[i] = 1.0 / root;
        }
        true
    }

    /// Replaces `x` by `L^-1 x`.
    pub(crate) fn solve_lower(&self, x: &mut [f64]) {
        let n = self.size;
        for i in 0..n {
            let row = &self.rows[i * n..i * n + i];
            let (done, rest) = x.split_at_mut(i);
            rest[0] = (rest[0] - dot(row, done)) * self.inverse_diagonal[i];
        }
    }

    /// Replaces `x` by the solution of `L L^T y = x`.
    pub(crate) fn solve(&self, x: &mut [f64]) {
        self.solve_lower(x);
        let n = self.size;
        for i in (0..n).rev() {
            let value = x[i] * self.inverse_diagonal[i];
            x[i] = value;
            let row = &self.rows[i * n..i * n + i];
            for (other, factor) in x[..i].iter_mut().zip(row) {
                *other -= factor * value;
            }
        }
    }
}

#[inline]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |sum, (x, y)| sum + x * y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_whole_and_block_and_refuses_indefinite() {
        let m = DMatrix::from_row_slice(3, 3, &[4.0, 1.0, 0.5, 1.0, 3.0, 0.2, 0.5, 0.2, 5.0]);
        let mut c = Cholesky::new(3);
        assert!(c.factor(&m, 0.0));
        let mut x = [1.0, 2.0, 3.0];
        c.solve(&mut x);
        let back = &m * nalgebra::DVector::from_row_slice(&x);
        for (value, wanted) in back.iter().zip([1.0, 2.0, 3.0]) {
            assert!((value - wanted).abs() < 1e-14);
        }
        assert!(c.factor_block(&m, &[0, 2]));
        let mut x = [4.5, 5.5];
        c.solve(&mut x);
        assert!((x[0] - 1.0).abs() < 1e-14 && (x[1] - 1.0).abs() < 1e-14);
        assert!(!c.factor(&m, -10.0));
    }
}
