//! Weights of quadrature, and of interpolation between evenly spaced points.

/// Positive nodes and weights of the 16-point Gauss-Legendre rule on [-1, 1] (Abramowitz and
/// Stegun, table 25.4).
pub const GAUSS_16: [(f64, f64); 8] = [
    (0.095_012_509_837_637_44, 0.189_450_610_455_068_5),
    (0.281_603_550_779_258_9, 0.182_603_415_044_923_6),
    (0.458_016_777_657_227_4, 0.169_156_519_395_002_54),
    (0.617_876_244_402_643_7, 0.149_595_988_816_576_73),
    (0.755_404_408_355_003, 0.124_628_971_255_533_87),
    (0.865_631_202_387_831_7, 0.095_158_511_682_492_78),
    (0.944_575_023_073_232_6, 0.062_253_523_938_647_89),
    (0.989_400_934_991_649_9, 0.027_152_459_411_754_095),
];

/// Returns the weights of the points -2 to 3 of a six-point interpolation at `t` in [0, 1).
pub fn lagrange(t: f64) -> [f64; 6] {
    const PLACES: [f64; 6] = [-2.0, -1.0, 0.0, 1.0, 2.0, 3.0];
    PLACES.map(|own| {
        PLACES
            .iter()
            .filter(|&&other| other != own)
            .map(|other| (t - other) / (own - other))
            .product()
    })
}
