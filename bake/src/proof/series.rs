//! Numbers that are polynomials of degree 2 in a patch of directions up to a known error.
//!
//! Each operation keeps the part up to degree 2 in (s, t), and adds a bound of the rest to the
//! error. A function is replaced by its Taylor polynomial in the middle; what is left is at most a
//! sixth of its greatest third derivative times the cube of the change (Taylor's theorem). Affine
//! numbers alone would not do: the error of one operation is the next one's to enlarge, and after
//! three facets it was 7000 times the square of the change.

use std::ops::{Add, Mul, Neg, Sub};

use num_complex::Complex64;

use crate::proof::moving::Affine;

/// Real number, within `error` of a polynomial of degree 2.
///
/// An error that is infinite or not a number means that there is no bound.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Series {
    /// Factors of 1, s, t, s^2, s t and t^2, where s and t are in [-1, 1].
    value: [f64; 6],
    error: f64,
}

impl From<f64> for Series {
    fn from(value: f64) -> Self {
        Series::affine([value, 0.0, 0.0])
    }
}

impl Add for Series {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Series {
            value: std::array::from_fn(|k| self.value[k] + other.value[k]),
            error: self.error + other.error,
        }
    }
}

impl Neg for Series {
    type Output = Self;

    fn neg(self) -> Self {
        Series {
            value: self.value.map(|x| -x),
            error: self.error,
        }
    }
}

impl Sub for Series {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul<f64> for Series {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Series {
            value: self.value.map(|x| factor * x),
            error: factor.abs() * self.error,
        }
    }
}

impl Mul for Series {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let (a, b) = (self.value, other.value);
        let [[_, first, second], [_, other_first, other_second]] = [self.sizes(), other.sizes()];
        let cubes = first * other_second + second * (other_first + other_second);
        let error = self.error * (other.most() + other.error) + other.error * self.most();
        let outer = |i: usize, j: usize| a[i] * b[j] + a[j] * b[i];
        Series {
            value: [
                a[0] * b[0],
                outer(0, 1),
                outer(0, 2),
                outer(0, 3) + a[1] * b[1],
                outer(0, 4) + outer(1, 2),
                outer(0, 5) + a[2] * b[2],
            ],
            error: cubes + error,
        }
    }
}

impl Series {
    /// Returns an affine number.
    pub(crate) fn affine([middle, s, t]: Affine) -> Self {
        Series {
            value: [middle, s, t, 0.0, 0.0, 0.0],
            error: 0.0,
        }
    }

    /// Returns an affine number and what this one is off from it at most.
    ///
    /// The squares of s and t lie between 0 and 1, so half of their factors belongs to the number.
    pub(crate) fn enclosed(&self) -> (Affine, f64) {
        let [middle, s, t, ss, st, tt] = self.value;
        let rest = 0.5 * (ss.abs() + tt.abs()) + st.abs();
        ([middle + 0.5 * (ss + tt), s, t], rest + self.error)
    }

    /// Returns bounds of the parts of the degrees 0, 1 and 2.
    fn sizes(&self) -> [f64; 3] {
        let [middle, s, t, ss, st, tt] = self.value.map(f64::abs);
        [middle, s + t, ss + st + tt]
    }

    /// Returns a bound of the magnitude of the polynomial.
    fn most(&self) -> f64 {
        self.sizes().iter().sum()
    }

    /// Returns the greatest change from the value in the middle.
    fn radius(&self) -> f64 {
        let [_, first, second] = self.sizes();
        first + second + self.error
    }

    /// Returns a function of this number: by its value, its first two derivatives in the middle,
    /// and a bound of the third one.
    fn taylor(&self, [value, first, second]: [f64; 3], third: f64) -> Self {
        let change = *self - self.value[0].into();
        let mut found = Series::from(value) + change * first + change * change * (0.5 * second);
        found.error += third / 6.0 * self.radius().powi(3);
        found
    }

    /// Returns the reciprocal of a number above 0.
    pub(crate) fn reciprocal(&self) -> Self {
        let (x, least) = self.above_zero();
        let one = 1.0 / x;
        self.taylor([one, -one * one, 2.0 * one.powi(3)], 6.0 / least.powi(4))
    }

    /// Returns the square root of a number above 0.
    pub(crate) fn root(&self) -> Self {
        let (x, least) = self.above_zero();
        let root = x.sqrt();
        let of = [root, 0.5 / root, -0.25 / (root * x)];
        self.taylor(of, 0.375 * least.powf(-2.5))
    }

    /// Returns the value in the middle and the least value; no numbers if that is not above 0.
    fn above_zero(&self) -> (f64, f64) {
        let least = self.value[0] - self.radius();
        if least > 0.0 {
            (self.value[0], least)
        } else {
            (f64::NAN, f64::NAN)
        }
    }
}

/// Complex number, both of whose parts are known so.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Complex {
    pub re: Series,
    pub im: Series,
}

impl Add for Complex {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Complex {
            re: self.re + other.re,
            im: self.im + other.im,
        }
    }
}

impl Sub for Complex {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Complex {
            re: self.re - other.re,
            im: self.im - other.im,
        }
    }
}

impl Mul for Complex {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Complex {
            re: self.re * other.re - self.im * other.im,
            im: self.re * other.im + self.im * other.re,
        }
    }
}

impl Mul<Series> for Complex {
    type Output = Self;

    fn mul(self, factor: Series) -> Self {
        Complex {
            re: self.re * factor,
            im: self.im * factor,
        }
    }
}

impl Mul<f64> for Complex {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Complex {
            re: self.re * factor,
            im: self.im * factor,
        }
    }
}

impl Complex {
    pub(crate) fn conjugate(self) -> Self {
        Complex {
            re: self.re,
            im: -self.im,
        }
    }

    /// Returns the square of the magnitude.
    pub(crate) fn squared(self) -> Series {
        self.re * self.re + self.im * self.im
    }

    pub(crate) fn reciprocal(self) -> Self {
        let scale = self.squared().reciprocal();
        self.conjugate() * scale
    }

    /// Returns the square root of `start` + `slope` x, the one whose imaginary part is not
    /// negative.
    ///
    /// For z = start + slope x, its third derivative by x is 3/8 slope^3 / z^(5/2), and |z| is at
    /// least its value in the middle less slope times the change of x. Close to z = 0, as at the
    /// limit of total reflection, the magnitude of the root bounds it better.
    pub(crate) fn root(start: Complex64, slope: f64, x: Series) -> Self {
        let middle = start + slope * x.value[0];
        let root = match middle.sqrt() {
            root if root.im < 0.0 => -root,
            root => root,
        };
        let first = 0.5 * slope / root;
        let second = -0.5 * slope * first / middle;
        let least = middle.norm() - slope * x.radius();
        // Infinite where z may come to 0.
        let third = 0.375 * slope.powi(3) * least.max(0.0).powf(-2.5);
        let smooth = Complex {
            re: x.taylor([root.re, first.re, second.re], third),
            im: x.taylor([root.im, first.im, second.im], third),
        };
        let small = Complex::small((middle.norm() + slope.abs() * x.radius()).sqrt());
        if small.re.error < smooth.re.error.max(smooth.im.error) {
            small
        } else {
            smooth
        }
    }

    /// Returns any number of a magnitude of `most` at most whose imaginary part is not negative.
    fn small(most: f64) -> Self {
        let part = |middle: f64| Series {
            error: most - middle,
            ..middle.into()
        };
        Complex {
            re: part(0.0),
            im: part(0.5 * most),
        }
    }
}

impl From<Complex64> for Complex {
    fn from(number: Complex64) -> Self {
        Complex {
            re: number.re.into(),
            im: number.im.into(),
        }
    }
}

impl From<Series> for Complex {
    fn from(re: Series) -> Self {
        Complex { re, im: 0.0.into() }
    }
}
