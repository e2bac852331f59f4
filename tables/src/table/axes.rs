//! Axes of a table: its directions and its bins.

/// Directions and bins of a table.
///
/// Two axes are equal if all their values are equal. The NaN azimuth of a mean table equals itself.
#[derive(Debug, Clone)]
pub struct Axes {
    /// Incidences outside the sheet, degrees, ascending, 0 <= theta < 90.
    pub incidence_deg: Vec<f64>,
    /// Azimuths, degrees, ascending; the single value NaN for a mean over all azimuths.
    pub azimuth_deg: Vec<f64>,
    /// Number of bins along each of u and v.
    pub bins: usize,
    /// Half width of the histogram, edge lengths: it covers u and v in [-range, range].
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
    /// Returns whether the table holds the mean over all azimuths instead of single azimuths.
    pub fn is_mean(&self) -> bool {
        matches!(self.azimuth_deg[..], [azimuth] if azimuth.is_nan())
    }

    /// Returns the width of a bin, edge lengths.
    pub fn bin_width(&self) -> f64 {
        2.0 * self.range / self.bins as f64
    }

    /// Returns the centre of bin `i`, edge lengths.
    pub fn bin_centre(&self, i: usize) -> f64 {
        (i as f64 + 0.5) * self.bin_width() - self.range
    }

    /// Returns the number of incidences and the number of azimuths.
    pub fn shape(&self) -> (usize, usize) {
        (self.incidence_deg.len(), self.azimuth_deg.len())
    }

    /// Returns all directions (incidence, azimuth), degrees, in the order of the arrays.
    ///
    /// The incidence changes slowly, the azimuth fast.
    pub fn directions(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let azimuths = move |&i| self.azimuth_deg.iter().map(move |&a| (i, a));
        self.incidence_deg.iter().flat_map(azimuths)
    }
}
