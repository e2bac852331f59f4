//! Facts about a mid-air image.

use serde::Serialize;

/// Least and greatest value over the image.
pub(crate) type Range = [f64; 2];

/// Facts about an image.
#[derive(Debug, Clone, Serialize)]
pub struct Facts {
    /// Columns of the picture.
    pub width: usize,
    /// Rows of the picture.
    pub height: usize,
    /// Planes of colour.
    pub channels: usize,
    /// Width and height of the mid-air image, mm.
    pub size_mm: [f64; 2],
    /// Factor on the light.
    pub exposure: f64,
    /// Side of a pixel in the air, mm.
    pub pixel_pitch_mm: f64,
    /// Incidence, degrees, least and greatest over the image.
    pub incidence_deg: Range,
    /// Azimuth, degrees; `None` for a table that is a mean over azimuths.
    pub azimuth_deg: Option<Range>,
    /// Optical path from the sheet to the image, mm.
    pub distance_mm: Range,
    /// True if the sheet is seen in the half mirror.
    pub seen_in_mirror: bool,
    /// Luminance relative to the source; null without mu.
    pub energy: Option<Range>,
    /// Luminance of white, cd/m2; absent where that of the source is not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub luminance_cd_m2: Option<Range>,
    /// Largest error of the contrast by the frequencies that were left out.
    pub transfer_error: f64,
    /// Number of tiles and largest error between their corners; null without a view.
    pub tiles: Option<TileFacts>,
    /// Standard error by the samples, root mean square over the image, before exposure; null
    /// without samples.
    pub sampling_error: Option<f64>,
    /// Mean and greatest luminance of the mid-air image, relative to the ambient light; null
    /// without ambient light.
    pub contrast: Option<Contrast>,
    /// Absent where the program did not read and write the pictures.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seconds: Option<Seconds>,
    /// Warnings.
    pub warnings: Vec<String>,
}

impl Facts {
    /// Adds luminances in cd/m2, for a source whose white has this luminance.
    pub fn lit_by(&mut self, source_cd_m2: Option<f64>) {
        let known = self.energy.zip(source_cd_m2);
        self.luminance_cd_m2 = known.map(|(energy, source)| energy.map(|own| own * source));
    }

    /// Returns size, place, luminance and exposure of the image, for a reader.
    pub fn text(&self) -> String {
        let [width, height] = self.size_mm;
        let span = |[low, high]: Range, digits: usize| match format!("{low:.digits$}") {
            low if low == format!("{high:.digits$}") => low,
            low => format!("{low} to {high:.digits$}"),
        };
        let light = self
            .energy
            .map_or("not known".into(), |energy| span(energy, 4));
        let white = (self.luminance_cd_m2).map_or(String::new(), |white| {
            format!(" ({} cd/m2)", span(white, 2))
        });
        format!(
            "{width:.1} x {height:.1} mm, {} mm from the sheet, incidence {} deg\n\
            luminance / source: {light}{white}; exposure {:.4}\n",
            span(self.distance_mm, 1),
            span(self.incidence_deg, 1),
            self.exposure
        )
    }
}

/// Tiles of a view.
#[derive(Debug, Clone, Serialize)]
pub struct TileFacts {
    /// Number of tiles along columns and rows.
    pub counts: [usize; 2],
    /// Largest error between their corners, as a share of the brightest pixel.
    pub error: f64,
}

/// Luminance of the image, relative to the ambient light.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Contrast {
    /// Mean over the image.
    pub mean: f64,
    /// Brightest pixel.
    pub peak: f64,
}

/// Times, seconds.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Seconds {
    /// Reading of the inputs.
    pub read: f64,
    /// The render.
    pub render: f64,
    /// Writing of the image.
    pub write: f64,
}

/// Returns the least and the greatest value over all items.
pub(super) fn range<T>(all: &[T], value: impl Fn(&T) -> f64) -> Range {
    let values = all.iter().map(value);
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
        [low.min(v), high.max(v)]
    })
}
