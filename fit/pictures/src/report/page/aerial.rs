//! Mid-air image of a sign, made as `fit render` makes it: what the numbers mean to an eye.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::ImageFormat;

use crate::images::exposure::automatic;
use crate::images::render::{uniform, uniform_psf};
use crate::images::shown::png;
use crate::images::{SILENT, Scale, Viewpoint};
use crate::report::page::markup::significant;
use crate::report::page::shown::Page;
use charts::escape;
use edges::photographs::photo::picture::Picture;
use edges::photographs::photo::transfer::Transfer;
use estimator::predict::Fitted;

/// Sign, 8 bits in sRGB.
const SIGN: &[u8] = include_bytes!("sign.png");

/// Width of a pixel of the sign, mm.
const PITCH_MM: f64 = 0.1;

/// Writes two figures: the sign, and its mid-air image at the farthest photograph of the least
/// incidence.
///
/// Returns `None` if the model has no blur there, and if no light returns.
pub(crate) fn figures(page: &Page) -> Option<String> {
    let sheet = Fitted::new(page.result, page.table).ok()?;
    let captures = &page.result.captures;
    let least = captures.iter().map(|c| c.incidence_deg);
    let incidence_deg = least.fold(f64::INFINITY, f64::min);
    let r_mm = captures
        .iter()
        .filter(|c| c.incidence_deg == incidence_deg)
        .map(|c| c.floating_distance_mm)
        .fold(0.0, f64::max);
    let azimuth_deg = match page.table.axes.azimuth_deg[..] {
        [only] => (!only.is_nan()).then_some(only),
        _ => page.result.domain.as_ref()?.azimuth_deg.map(|arc| arc[0]),
    };
    let place = Viewpoint {
        incidence_deg,
        azimuth_deg,
        r_mm,
    };
    let scale = Scale {
        pitch_mm: PITCH_MM,
        tangential_axis_deg: 0.0,
        seen_in_mirror: false,
    };
    let source = source()?;
    let psf = uniform_psf(&sheet, &place, &scale, None, SILENT).ok()?;
    let mut image = uniform(&source, &psf, SILENT);
    if image.peak_luminance() <= 0.0 {
        return None;
    }
    let exposure = automatic(&source, &image, 0.0);
    image.expose(0.0, exposure);
    let width = significant(PITCH_MM * source.width as f64, 3);
    let known = match psf.energy {
        Some(_) => format!("brightened {} times", significant(exposure, 2)),
        None => "its brightness is not known".into(),
    };
    let before = figure(
        SIGN,
        "A sign, as the source shows it",
        &format!("<b>Before</b>: a sign of {width} mm."),
    );
    let after = figure(
        &png(&image),
        "The mid-air image of the sign, computed from the estimates",
        &format!(
            "<b>After</b>: its mid-air image by the estimates, at {incidence_deg}\u{b0} and \
             {r_mm} mm, {known}."
        ),
    );
    Some(before + &after)
}

/// Returns the sign as linear light.
fn source() -> Option<Picture> {
    let sign = image::load_from_memory_with_format(SIGN, ImageFormat::Png).ok()?;
    let sign = sign.to_rgb8();
    let linear = |k: usize| -> Vec<f32> {
        let values = sign.pixels().map(|pixel| f32::from(pixel.0[k]) / 255.0);
        values.map(|v| Transfer::Srgb.to_linear(v)).collect()
    };
    Some(Picture {
        width: sign.width() as usize,
        height: sign.height() as usize,
        planes: vec![linear(0), linear(1), linear(2)],
        transfer: Transfer::Srgb,
        warnings: Vec::new(),
    })
}

/// Writes a picture with its caption, which is markup.
fn figure(png: &[u8], label: &str, caption: &str) -> String {
    format!(
        "<figure><svg class=\"picture\" viewBox=\"0 0 384 288\" role=\"img\" \
         aria-label=\"{}\"><image width=\"384\" height=\"288\" \
         href=\"data:image/png;base64,{}\"/></svg><figcaption>{caption}</figcaption></figure>\n",
        escape(label),
        STANDARD.encode(png)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that what is not blurred keeps every byte of the sign.
    #[test]
    fn the_sign_is_kept_by_both_conversions() {
        let source = source().expect("the sign is a PNG");
        assert_eq!((source.width, source.height), (384, 288));
        let bytes = png(&source);
        let pixels = |png: &[u8]| image::load_from_memory(png).expect("a PNG").to_rgb8();
        assert_eq!(pixels(&bytes), pixels(SIGN));
    }
}
