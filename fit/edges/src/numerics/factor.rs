//! Normal matrices and their triangular factors: sums of squares without the rows that make them.

use nalgebra::{DMatrix, DVector};
use pulp::{Arch, Simd, WithSimd};

/// Number of rows that are multiplied at a time.
const ROWS: usize = 4;

/// Largest number of elements that a processor multiplies at once.
const LANES: usize = 8;

/// Sum of row^T row over many rows.
///
/// Four rows are added to each element at a time, and to neighbouring elements of a column at once.
pub struct Products {
    size: usize,
    /// Length of a row or a column, in whole lanes. Their ends are zeros.
    width: usize,
    /// Upper triangle, column by column, and the rest of its lanes.
    sums: Vec<f64>,
    /// Rows that wait, one behind the other.
    waiting: Vec<f64>,
    rows: usize,
    arch: Arch,
}

impl Products {
    /// Creates the sum over no rows of `size` values each.
    pub fn new(size: usize) -> Products {
        let width = size.next_multiple_of(LANES);
        Products {
            size,
            width,
            sums: vec![0.0; width * size],
            waiting: vec![0.0; ROWS * width],
            rows: 0,
            arch: Arch::new(),
        }
    }

    /// Adds a row.
    pub fn add(&mut self, row: &[f64]) {
        self.waiting[self.rows * self.width..][..self.size].copy_from_slice(row);
        self.rows += 1;
        if self.rows == ROWS {
            self.flush();
        }
    }

    fn flush(&mut self) {
        let (width, sums, waiting) = (self.width, &mut self.sums, &self.waiting);
        self.arch.dispatch(Flush {
            width,
            sums,
            waiting,
        });
        self.rows = 0;
    }

    /// Returns the sum. Only its upper triangle is filled.
    pub fn sum(mut self) -> DMatrix<f64> {
        self.waiting[self.rows * self.width..].fill(0.0);
        self.flush();
        let all = DMatrix::from_vec(self.width, self.size, self.sums);
        all.rows(0, self.size).upper_triangle()
    }
}

/// The products of the rows that wait, as the lanes of each kind of processor make them. All give
/// the same bits.
struct Flush<'a> {
    width: usize,
    sums: &'a mut [f64],
    waiting: &'a [f64],
}

impl WithSimd for Flush<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (a, rest) = self.waiting.split_at(self.width);
        let (b, rest) = rest.split_at(self.width);
        let (c, d) = rest.split_at(self.width);
        let lanes = S::F64_LANES;
        let sum = |a, b| simd.add_f64s(a, b);
        for (j, column) in self.sums.chunks_exact_mut(self.width).enumerate() {
            let end = (j + 1).next_multiple_of(lanes);
            let by = [a, b, c, d].map(|row| simd.splat_f64s(row[j]));
            let [a, b, c, d] = [a, b, c, d].map(|row| S::as_simd_f64s(&row[..end]).0);
            let (column, _) = S::as_mut_simd_f64s(&mut column[..end]);
            for ((((own, &a), &b), &c), &d) in column.iter_mut().zip(a).zip(b).zip(c).zip(d) {
                let first = sum(simd.mul_f64s(a, by[0]), simd.mul_f64s(b, by[1]));
                let second = sum(simd.mul_f64s(c, by[2]), simd.mul_f64s(d, by[3]));
                *own = sum(*own, sum(first, second));
            }
        }
    }
}

/// Factors `normal` into R^T R and returns the upper triangular R. Only the upper triangle of
/// `normal` is read. A column that depends on earlier columns, to rounding, gets a row of zeros. A
/// number that is not finite makes its row, and so those below, not finite: zeros would look like a
/// perfect fit.
pub fn of(mut normal: DMatrix<f64>) -> DMatrix<f64> {
    let n = normal.nrows();
    for i in 0..n {
        let whole = normal[(i, i)];
        let taken: f64 = (0..i).map(|k| normal[(k, i)].powi(2)).sum();
        let pivot = whole - taken;
        let root = if !pivot.is_finite() {
            f64::NAN
        } else if pivot > 1e-13 * whole {
            pivot.sqrt()
        } else {
            0.0
        };
        normal[(i, i)] = root;
        for j in i + 1..n {
            let taken: f64 = (0..i).map(|k| normal[(k, i)] * normal[(k, j)]).sum();
            normal[(i, j)] = if root == 0.0 {
                0.0
            } else {
                (normal[(i, j)] - taken) / root
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

/// Returns the step of Levenberg and Marquardt for the first `n` unknowns: the solution x of
/// (N + `damping` diag N) x = R^T r. N is R^T R, and r is column `c` of R.
///
/// Without damping it is `back_substituted`.
pub fn damped_step(factor: &DMatrix<f64>, n: usize, c: usize, damping: f64) -> DVector<f64> {
    if damping == 0.0 {
        return back_substituted(factor, n, c);
    }
    let own = factor.view((0, 0), (n, n)).upper_triangle();
    let rest = own.tr_mul(&factor.view((0, c), (n, 1)));
    let mut normal = own.tr_mul(&own);
    for i in 0..n {
        // An unknown that nothing depends on stays where it is.
        let own = normal[(i, i)];
        normal[(i, i)] = if own > 0.0 {
            own * (1.0 + damping)
        } else {
            1.0
        };
    }
    match normal.cholesky() {
        Some(normal) => normal.solve(&rest).column(0).into_owned(),
        None => DVector::zeros(n),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Little damping gives the step without damping, much of it the way of steepest descent, and
    /// any gives the least squares of the rows with those of the damping below them.
    #[test]
    fn damping_shortens_a_step() {
        let rows = DMatrix::from_fn(9, 4, |i, j| (0.37 * ((i + 1) * (j + 1)) as f64).sin());
        let factor = of(rows.tr_mul(&rows));
        let whole = damped_step(&factor, 3, 3, 0.0);
        let mut last = whole.norm();
        for damping in [1e-12, 1e-3, 1.0, 1e3] {
            let step = damped_step(&factor, 3, 3, damping);
            let left = rows.columns(0, 3);
            let normal = left.tr_mul(&left);
            let below = DMatrix::from_diagonal(&(normal.diagonal() * damping).map(f64::sqrt));
            let mut all = DMatrix::zeros(12, 3);
            all.rows_mut(0, 9).copy_from(&left);
            all.rows_mut(9, 3).copy_from(&below);
            let mut data = DVector::zeros(12);
            data.rows_mut(0, 9).copy_from(&rows.column(3));
            let slow = all.svd(true, true).solve(&data, 0.0).unwrap();
            // Normal equations err by their condition number times the rounding of what they
            // divide: the data over the least singular value of the rows. Sums of twelve terms and
            // three unknowns add a factor of some thirty.
            let singular = normal.singular_values();
            let condition = singular.max() / singular.min();
            let rounding = 30.0 * f64::EPSILON * condition * data.norm() / singular.min().sqrt();
            assert!((&step - slow).norm() < rounding, "{damping}");
            assert!(step.norm() <= last * (1.0 + 1e-9), "{damping}");
            last = step.norm();
        }
        assert!(last < 1e-2 * whole.norm());
        let barely = damped_step(&factor, 3, 3, 1e-12);
        // A damping of 1e-12 moves the step by that times the condition number, which is below 100.
        assert!((barely - &whole).norm() < 1e-10 * whole.norm());
    }

    /// A sum of squares that is no number, or beyond all numbers, does not become 0.
    #[test]
    fn a_factor_of_no_number_is_no_number() {
        for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for at in 0..3 {
                let mut normal = DMatrix::from_diagonal_element(3, 3, 4.0);
                normal[(at, at)] = wrong;
                let factor = of(normal.clone());
                assert!(factor[(at, at)].is_nan(), "{wrong} at {at}");
                assert!((0..at).all(|i| factor[(i, i)] == 2.0));
                normal[(at, at)] = 4.0;
                normal[(0, 2)] = wrong;
                assert!(of(normal)[(2, 2)].is_nan(), "{wrong} beside the diagonal");
            }
        }
    }

    /// Every kind of processor gives the bits of single numbers, whatever the number of vectors.
    #[test]
    fn vectors_give_the_bits_of_single_numbers() {
        let mut stream = crate::numerics::Stream(17);
        let mut cases = 0;
        for size in [1, 3, 8, 9, 16, 17, 31] {
            let mut products = Products::new(size);
            let rows: Vec<Vec<f64>> = (0..7)
                .map(|_| (0..size).map(|_| stream.normal()).collect())
                .collect();
            rows.iter().for_each(|row| products.add(row));
            let mut singly = products.sums.clone();
            Flush {
                width: products.width,
                sums: &mut singly,
                waiting: &products.waiting,
            }
            .with_simd(pulp::Scalar);
            products.flush();
            for j in 0..size {
                for i in 0..=j {
                    let [own, single] =
                        [&products.sums, &singly].map(|of| of[j * products.width + i]);
                    assert_eq!(own.to_bits(), single.to_bits(), "{size}: {i} {j}");
                    cases += 1;
                }
            }
        }
        assert_eq!(cases, 873);
    }

    /// Checks the products of small integers, which are exact, for every number of rows that is
    /// left over from groups of four.
    #[test]
    fn products_are_those_of_all_rows() {
        let mut cases = 0;
        for count in 0..=9 {
            let rows: Vec<[f64; 3]> = (0..count)
                .map(|k: i32| [f64::from(k), f64::from(k * k - 7), f64::from(3 - k)])
                .collect();
            let mut products = Products::new(3);
            rows.iter().for_each(|row| products.add(row));
            let sum = products.sum();
            for i in 0..3 {
                for j in i..3 {
                    let expected: f64 = rows.iter().map(|row| row[i] * row[j]).sum();
                    assert_eq!(sum[(i, j)], expected, "{count} rows, {i} {j}");
                    cases += 1;
                }
            }
        }
        assert_eq!(cases, 60);
    }
}
