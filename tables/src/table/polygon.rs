//! Area and centroid of polygons.

/// Signed area of a polygon, positive when it is counter-clockwise; relative to its first corner, so that a
/// polygon far from the origin loses no digits.
pub(crate) fn area(corners: &[[f64; 2]]) -> f64 {
    0.5 * fan(corners).map(|(_, _, twice)| twice).sum::<f64>()
}

/// Centroid of a polygon; its first corner where the area is 0.
pub(crate) fn centroid(corners: &[[f64; 2]]) -> [f64; 2] {
    let Some(&[x, y]) = corners.first() else {
        return [0.0; 2];
    };
    let total: f64 = fan(corners).map(|(_, _, twice)| twice).sum();
    if total == 0.0 {
        return [x, y];
    }
    let sum = |axis: usize| {
        fan(corners)
            .map(|(a, b, twice)| twice * (a[axis] + b[axis]))
            .sum::<f64>()
            / (3.0 * total)
    };
    [x + sum(0), y + sum(1)]
}

/// The triangles from the first corner: two sides as vectors, and twice the signed area.
pub(crate) fn fan(corners: &[[f64; 2]]) -> impl Iterator<Item = ([f64; 2], [f64; 2], f64)> + '_ {
    let origin = corners.first().copied().unwrap_or_default();
    let side = move |corner: &[f64; 2]| [corner[0] - origin[0], corner[1] - origin[1]];
    corners.windows(2).map(move |pair| {
        let (a, b) = (side(&pair[0]), side(&pair[1]));
        (a, b, a[0] * b[1] - a[1] * b[0])
    })
}
