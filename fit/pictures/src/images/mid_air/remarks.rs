//! Warnings about an image that was rendered.

use crate::images::Writing;
use crate::images::mid_air::facts::range;
use crate::images::mid_air::image::Rendered;
use crate::images::render::camera::Camera;
use edges::photographs::photo::picture::Picture;
use estimator::predict::{Fitted, between};

/// Returns the warnings about the source and its blur.
pub(super) fn of_image(source: &Picture, rendered: &Rendered, sheet: &Fitted<'_>) -> Vec<String> {
    let mut warnings = source.warnings.clone();
    let spots = &rendered.spots;
    let [low, high] = range(spots, |spot| spot.place.incidence_deg);
    let at = if low == high {
        format!("{low} deg")
    } else {
        format!("{low:.2} to {high:.2} deg")
    };
    if source.peak() <= 0.0 {
        warnings.push("the source has no light: all of its pixels are black".into());
    }
    if spots.iter().any(|spot| spot.energy.is_none()) {
        warnings.push(
            "the result has no mu (no reference photograph, or --mu left out): the image has the \
            brightness of the source"
                .into(),
        );
    }
    if spots.iter().all(|spot| spot.energy == Some(0.0)) {
        warnings.push(format!(
            "nothing is returned at incidence {at}: the image is black"
        ));
    }
    if let [spot] = &spots[..]
        && spot.interpolated
    {
        let direction = (sheet.table).direction(spot.place.incidence_deg, spot.place.azimuth_deg);
        let share = direction.ok().map(|own| (low, own.retroreflected));
        warnings.extend(share.and_then(|place| between(sheet, [place])));
    }
    if rendered.transfer_error > 1e-3 {
        warnings.push(format!(
            "the blur is much finer than a pixel: the contrast of single pixels errs by up to \
            {:.1} %",
            100.0 * rendered.transfer_error
        ));
    }
    warnings
}

/// Returns the warning for a camera whose lens was not measured.
pub(super) fn of_camera(camera: &Camera) -> Option<String> {
    camera.is_assumed().then(|| {
        "the lens of the camera is assumed, because its result has no reference photograph".into()
    })
}

/// Returns the warning for a picture that got fewer pixels, of `pitch_mm`.
pub(super) fn of_reduced(source: &Picture, reduced: &Picture, pitch_mm: f64) -> String {
    format!(
        "the picture was reduced from {} x {} to {} x {} pixels of {pitch_mm:.3} mm, because its \
        blur is very wide: nothing that it leaves to see is lost",
        source.width, source.height, reduced.width, reduced.height
    )
}

/// Returns the warning for a picture so wide that one incidence does not stand for all of it.
///
/// From twice its distance on, rays to its rims leave the middle one by 45 degrees and more.
pub fn spacious(width_mm: f64, distance_mm: f64) -> Option<String> {
    (width_mm >= 2.0 * distance_mm).then(|| {
        format!(
            "the picture is {width_mm:.0} mm wide, and floats {distance_mm:.0} mm from its sheet: \
            its rims are seen at other incidences than its middle; exchange --width and \
            --distance if they are mixed up"
        )
    })
}

/// Share of the light beyond the rim of the picture from which on a warning says so.
const MUCH: f64 = 0.05;

/// Returns the warning for light that falls outside of the picture.
///
/// It is known where all pixels have one blur: what returns, and is not in the image.
pub(super) fn beyond_the_rim(source: &Picture, rendered: &Rendered) -> Option<String> {
    let [spot] = &rendered.spots[..] else {
        return None;
    };
    let returned = spot.energy.unwrap_or(1.0) * source.mean_luminance();
    let lost = 1.0 - rendered.image.mean_luminance() / returned;
    (returned > 0.0 && lost > MUCH).then(|| {
        format!(
            "{:.0} % of the light falls beyond the rim of the picture, and is not in the image; \
            give the picture a wider dark margin (with a larger --width) to see it",
            100.0 * lost
        )
    })
}

/// Returns the warning for an image that is brighter than its file can hold.
pub fn clipped(image: &Picture, writing: Writing) -> Option<String> {
    let clipped = image.above_white();
    (writing != Writing::Exr && clipped > 0).then(|| {
        format!(
            "{clipped} values are above 1 and were clipped; write .exr, or give a smaller \
            --exposure"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::images::Viewpoint;
    use crate::images::render::sampled::Spotted;
    use edges::photographs::photo::transfer::Transfer;

    /// A quarter of the light of 0.5 returns, and the image holds three fifths of it.
    #[test]
    fn light_beyond_the_rim_is_what_returns_and_is_not_there() {
        let grey = |light: f32| Picture {
            width: 8,
            height: 4,
            planes: vec![vec![light; 32]],
            transfer: Transfer::Linear,
            warnings: Vec::new(),
        };
        let rendered = |light: f32| Rendered {
            image: grey(light),
            spots: vec![Spotted {
                place: Viewpoint {
                    incidence_deg: 0.0,
                    azimuth_deg: None,
                    r_mm: 150.0,
                },
                energy: Some(0.25),
                interpolated: false,
            }],
            transfer_error: 0.0,
            tiles: None,
            sampling_error: None,
        };
        let said = beyond_the_rim(&grey(0.5), &rendered(0.6 * 0.125)).expect("it is much");
        assert!(said.starts_with("40 % of the light"), "{said}");
        assert_eq!(beyond_the_rim(&grey(0.5), &rendered(0.96 * 0.125)), None);
    }
}
