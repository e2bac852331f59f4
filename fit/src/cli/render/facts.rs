//! Facts about an image that `fit render` made.

use serde::Serialize;

/// Least and greatest value over the image.
pub(super) type Range = [f64; 2];

/// Facts about an image.
#[derive(Serialize)]
pub(crate) struct Report {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) channels: usize,
    /// Width and height of the mid-air image, mm.
    pub(super) size_mm: [f64; 2],
    /// Factor on the light.
    pub(super) exposure: f64,
    pub(super) pixel_pitch_mm: f64,
    pub(super) incidence_deg: Range,
    pub(super) azimuth_deg: Option<Range>,
    pub(super) distance_mm: Range,
    /// True if the sheet is seen in the half mirror.
    pub(super) seen_in_mirror: bool,
    /// Luminance relative to the source; null without mu.
    pub(super) energy: Option<Range>,
    /// Largest error of the contrast by the frequencies that were left out.
    pub(super) transfer_error: f64,
    /// Number of tiles and largest error between their corners; null without a view.
    pub(super) tiles: Option<TileReport>,
    /// Standard error by the samples, root mean square over the image, before exposure; null
    /// without samples.
    pub(super) sampling_error: Option<f64>,
    /// Mean and greatest luminance of the mid-air image, relative to the ambient light; null
    /// without ambient light.
    pub(super) contrast: Option<Contrast>,
    /// Absent where the program did not read and write the pictures.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) seconds: Option<Seconds>,
    pub(super) warnings: Vec<String>,
}

impl Report {
    /// Returns size, place, luminance and exposure of the image, for a reader.
    pub(super) fn text(&self) -> String {
        let [width, height] = self.size_mm;
        let span = |[low, high]: Range, digits: usize| match format!("{low:.digits$}") {
            low if low == format!("{high:.digits$}") => low,
            low => format!("{low} to {high:.digits$}"),
        };
        let light = self
            .energy
            .map_or("not known".into(), |energy| span(energy, 4));
        format!(
            "{width:.1} x {height:.1} mm, {} mm from the sheet, incidence {} deg\n\
            luminance / source: {light}; exposure {:.4}\n",
            span(self.distance_mm, 1),
            span(self.incidence_deg, 1),
            self.exposure
        )
    }
}

#[derive(Serialize)]
pub(super) struct TileReport {
    pub(super) counts: [usize; 2],
    pub(super) error: f64,
}

#[derive(Serialize)]
pub(super) struct Contrast {
    pub(super) mean: f64,
    pub(super) peak: f64,
}

#[derive(Serialize)]
pub(super) struct Seconds {
    pub(super) read: f64,
    pub(super) render: f64,
    pub(super) write: f64,
}

/// Returns the least and the greatest value over all items.
pub(super) fn range<T>(all: &[T], value: impl Fn(&T) -> f64) -> Range {
    let values = all.iter().map(value);
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
        [low.min(v), high.max(v)]
    })
}
