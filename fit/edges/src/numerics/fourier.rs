//! Lengths of fast Fourier transforms, and transforms in closed form.

/// Returns the least length >= `least` that has no prime factor above 5, so that its transform is
/// fast. From 100 on it is at most 11 % longer than `least` (tested for every length to 5,000).
pub fn fast_length(least: usize) -> usize {
    (least.max(1)..)
        .find(|&n| is_smooth(n, &[2, 3, 5]))
        .unwrap_or(least)
}

/// Returns whether `n` >= 1 has no prime factors other than `primes`.
pub(crate) fn is_smooth(n: usize, primes: &[usize]) -> bool {
    let mut rest = n;
    for &prime in primes {
        while rest.is_multiple_of(prime) {
            rest /= prime;
        }
    }
    rest == 1
}

/// Prime factors that the length of a fast transform in two dimensions may have.
const PRIMES: [usize; 4] = [2, 3, 5, 7];

/// Returns the smallest fast length >= `least`, for `least` >= 1.
pub fn smooth(least: usize) -> usize {
    (least..).find(|&n| is_smooth(n, &PRIMES)).unwrap_or(least)
}

/// Returns the smallest fast even length >= `least`, for `least` >= 1.
pub fn smooth_even(least: usize) -> usize {
    2 * smooth(least.div_ceil(2))
}

/// Returns the smallest fast odd length >= `least`, for `least` >= 1.
pub fn smooth_odd(least: usize) -> usize {
    (least | 1..)
        .step_by(2)
        .find(|&n| is_smooth(n, &PRIMES))
        .unwrap_or(least)
}

/// Evaluates sinc t = sin t / t, the transform of a box, which is 1 at t = 0.
pub fn sinc(t: f64) -> f64 {
    if t.abs() < 1e-4 {
        1.0 - t * t / 6.0
    } else {
        t.sin() / t
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fast_lengths_are_smooth_and_near() {
        for least in 100..5000 {
            let found = fast_length(least);
            assert!(
                found >= least && found as f64 <= 1.11 * least as f64,
                "{least}: {found}"
            );
        }
        assert_eq!(
            [fast_length(1), fast_length(7), fast_length(1101)],
            [1, 8, 1125]
        );
    }
}
