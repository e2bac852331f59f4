//! Polygons of the entrance plane and their Fourier transform.

/// Signed area of a polygon, positive when it is counter-clockwise; relative to its first corner, so that a polygon far
/// from the origin loses no digits.
pub fn area(corners: &[[f64; 2]]) -> f64 {
    let Some(&[x, y]) = corners.first() else {
        return 0.0;
    };
    let twice: f64 = corners
        .windows(2)
        .map(|pair| (pair[0][0] - x) * (pair[1][1] - y) - (pair[0][1] - y) * (pair[1][0] - x))
        .sum();
    0.5 * twice
}
