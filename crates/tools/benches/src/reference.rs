//! A fixed piece of work, so that figures of two machines can be compared.

use std::hint::black_box;

/// Name of its row.
pub(crate) const NAME: &str = "reference kernel";
/// Description for the report.
pub(crate) const NOTE: &str = "reference kernel: product of two fixed matrices of 24 x 24 in f64, \
                               13,824 multiplications and additions";

/// Rows and columns.
// Both fit the first-level cache, so the figure is of the core, not of its memory.
const SIZE: usize = 24;

type Matrix = [[f64; SIZE]; SIZE];

/// Two matrices.
pub(crate) struct Kernel {
    left: Matrix,
    right: Matrix,
}

impl Kernel {
    /// Always the same ones.
    pub(crate) fn new() -> Self {
        let filled = |from: usize| {
            let value = |place: usize| ((from + 7 * place) % 13) as f64 - 6.0;
            std::array::from_fn(|row| std::array::from_fn(|column| value(SIZE * row + column)))
        };
        Self {
            left: filled(3),
            right: filled(5),
        }
    }

    /// Does the work; the compiler knows neither the factors nor the use of the product.
    pub(crate) fn work(&self) {
        black_box(product(black_box(&self.left), black_box(&self.right)));
    }
}

fn product(left: &Matrix, right: &Matrix) -> Matrix {
    let mut product = [[0.0; SIZE]; SIZE];
    for (row, sums) in left.iter().zip(&mut product) {
        for (factor, line) in row.iter().zip(right) {
            for (sum, value) in sums.iter_mut().zip(line) {
                *sum += factor * value;
            }
        }
    }
    product
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_product_is_that_of_the_matrices() {
        let Kernel { left, right } = Kernel::new();
        let product = product(&left, &right);
        for (row, column) in [(0, 0), (3, 17), (23, 23)] {
            let sum: f64 = (0..SIZE).map(|k| left[row][k] * right[k][column]).sum();
            assert_eq!(product[row][column], sum);
        }
        assert!(product.iter().flatten().any(|value| *value != 0.0));
    }
}
