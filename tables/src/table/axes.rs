//! The directions and bins of a table.

/// The directions and bins of a table.
///
/// Two axes are equal when every value is; the NaN azimuth of a mean table equals itself.
#[derive(Debug, Clone)]
pub struct Axes {
    /// Incidence angles outside the sheet, degrees, ascending, 0 <= theta < 90.
    pub incidence_deg: Vec<f64>,
    /// Azimuths, degrees, ascending; the single value NaN for a mean over all azimuths.
    pub azimuth_deg: Vec<f64>,
    /// Bins along each of u and v.
    pub bins: usize,
    /// The histogram covers u, v in [-range, range], edge lengths.
    pub range: f64,
}

impl PartialEq for Axes {
    fn eq(&self, other: &Self) -> bool {
        let same = |a: &[f64], b: &[f64]| {
            a.len() == b.len()
                && a.iter()
                    .zip(b)
                    .all(|(a, b)| a == b || (a.is_nan() && b.is_nan()))
        };
        same(&self.incidence_deg, &other.incidence_deg)
            && same(&self.azimuth_deg, &other.azimuth_deg)
            && self.bins == other.bins
            && self.range == other.range
    }
}

impl Axes {
    /// Whether the table holds the mean over all azimuths instead of single ones.
    pub fn is_mean(&self) -> bool {
        matches!(self.azimuth_deg[..], [azimuth] if azimuth.is_nan())
    }

    /// Bin width, edge lengths.
    pub fn bin_width(&self) -> f64 {
        2.0 * self.range / self.bins as f64
    }

    /// Centre of bin `i`, edge lengths.
    pub fn bin_centre(&self, i: usize) -> f64 {
        (i as f64 + 0.5) * self.bin_width() - self.range
    }

    /// (directions along incidence, directions along azimuth).
    pub fn shape(&self) -> (usize, usize) {
        (self.incidence_deg.len(), self.azimuth_deg.len())
    }

    /// All directions (incidence, azimuth), degrees, in the order of the arrays: incidence slow,
    /// azimuth fast.
    pub fn directions(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let azimuths = move |&i| self.azimuth_deg.iter().map(move |&a| (i, a));
        self.incidence_deg.iter().flat_map(azimuths)
    }
}
