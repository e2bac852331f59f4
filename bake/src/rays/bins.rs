//! Bins of a histogram of shifts, and the bin that a shift falls in.

use glam::DVec2;

/// Bins of a histogram over u, v in [-range, range].
///
/// A bin holds its lower edge and not its upper edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bins {
    /// Number of bins along each axis.
    pub count: usize,
    /// Number of bins per edge length.
    pub density: f64,
}

impl Bins {
    /// Makes `count` bins along each axis over [-range, range] edge lengths.
    pub(crate) fn new(count: usize, range: f64) -> Self {
        Bins {
            count,
            density: count as f64 / (2.0 * range),
        }
    }

    /// Returns the number of bins of the whole histogram.
    pub(crate) fn len(&self) -> usize {
        self.count * self.count
    }

    /// Returns the place of a shift (u, v), counted in bins from the lower end of the histogram.
    pub(crate) fn position(&self, shift: DVec2) -> DVec2 {
        shift * self.density + DVec2::splat(self.count as f64 / 2.0)
    }

    /// Returns the bin of a shift, v slow, u fast, or `None` if the shift lies outside the
    /// histogram.
    pub(crate) fn find(&self, shift: DVec2) -> Option<usize> {
        let at = self.position(shift);
        let end = self.count as f64;
        let within = at.x >= 0.0 && at.y >= 0.0 && at.x < end && at.y < end;
        within.then(|| at.y as usize * self.count + at.x as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_hold_their_lower_edge() {
        let bins = Bins::new(4, 2.0);
        assert_eq!(bins.find(DVec2::new(-2.0, -2.0)), Some(0));
        assert_eq!(bins.find(DVec2::new(-1.0, -2.0)), Some(1));
        assert_eq!(bins.find(DVec2::new(-2.0, -1.0)), Some(4));
        assert_eq!(bins.find(DVec2::new(1.999_999, 1.999_999)), Some(15));
        assert_eq!(bins.find(DVec2::new(2.0, 0.0)), None);
        assert_eq!(bins.find(DVec2::new(0.0, -2.000_001)), None);
        assert_eq!(bins.find(DVec2::new(f64::NAN, 0.0)), None);
    }
}
