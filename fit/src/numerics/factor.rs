//! Normal matrices and their triangular factors: sums of squares without the rows that make them.

use nalgebra::{DMatrix, DVector};

/// Adds row^T row to the upper triangle of `normal`.
pub(crate) fn add(normal: &mut DMatrix<f64>, row: &[f64]) {
    for (j, &b) in row.iter().enumerate() {
        let mut column = normal.column_mut(j);
        for (sum, &a) in column.iter_mut().zip(&row[..=j]) {
            *sum += a * b;
        }
    }
}

/// Factors `normal` into R^T R and returns the upper triangular R. Only the upper triangle of
/// `normal` is read. A column that depends on earlier columns, to rounding, gets a row of zeros.
pub(crate) fn of(mut normal: DMatrix<f64>) -> DMatrix<f64> {
    let n = normal.nrows();
    for i in 0..n {
        let whole = normal[(i, i)];
        let taken: f64 = (0..i).map(|k| normal[(k, i)].powi(2)).sum();
        let pivot = whole - taken;
        let keep = pivot > 1e-13 * whole;
        let root = if keep { pivot.sqrt() } else { 0.0 };
        normal[(i, i)] = root;
        for j in i + 1..n {
            let taken: f64 = (0..i).map(|k| normal[(k, i)] * normal[(k, j)]).sum();
            normal[(i, j)] = if keep {
                (normal[(i, j)] - taken) / root
            } else {
                0.0
            };
            normal[(j, i)] = 0.0;
        }
    }
    normal
}

/// Solves the first `n` rows of R x = column `c` of R. An unknown whose row of R is zero becomes 0.
pub(crate) fn back_substituted(factor: &DMatrix<f64>, n: usize, c: usize) -> DVector<f64> {
    let mut x = DVector::zeros(n);
    for i in (0..n).rev() {
        let rest: f64 = (i + 1..n).map(|j| factor[(i, j)] * x[j]).sum();
        if factor[(i, i)] > 0.0 {
            x[i] = (factor[(i, c)] - rest) / factor[(i, i)];
        }
    }
    x
}
