//! Reasons why an image or a page cannot be made.

use std::path::PathBuf;

use edges::names::Kernel;

use crate::explore::MOST_CORNERS;
use crate::images::render::psf::LARGEST;

/// Reason why an image or a page cannot be made.
#[derive(Debug, thiserror::Error)]
#[allow(
    missing_docs,
    reason = "the message of a variant says what its fields are"
)]
#[non_exhaustive]
pub enum Error {
    /// Output file with another ending.
    #[error("{}: an image is written as .exr, .png, .tif or .jpg; give one of these endings",
        .0.display())]
    Ending(PathBuf),
    /// Image that the encoder cannot write, and its message.
    #[error("{}: the image could not be encoded ({}); try another of .exr, .png, \
        .tif and .jpg",
        .0.display(), .1)]
    Encode(PathBuf, String),
    /// Sheet without a blur at this place.
    #[error(transparent)]
    Sheet(#[from] estimator::Error),
    /// Sheet of a comparison, by name, without numbers at a place.
    #[error("{}: {}", .0, .1)]
    Contender(String, estimator::Error),
    /// Viewer who does not see the image in front of the sheet.
    #[error("{}", .0)]
    Seat(String),
    /// Blur that reaches too many pixels.
    #[error(
        "the blur at incidence {incidence_deg} deg, distance {r_mm} mm is {size} pixels wide, and \
        at most {LARGEST} are computed; give the size of the picture as --width, mm, so that it \
        gets fewer pixels (which loses nothing under such a blur), or a larger one; under --view \
        give a picture of fewer pixels and a larger pixel_pitch_mm in [image]"
    )]
    Wide {
        incidence_deg: f64,
        r_mm: f64,
        size: usize,
    },
    /// Light that is spread so far that its transform fits into no page.
    #[error(
        "the page would need {megabytes:.0} MB, because light leaves up to {reach:.0} edge lengths \
        from its place; give a shorter --farthest than {} mm, or a longer --nearest than {} mm",
        distance_mm[1],
        distance_mm[0]
    )]
    Large {
        megabytes: f64,
        reach: f64,
        distance_mm: [f64; 2],
    },
    /// Table of so many polygons that a page would take many minutes.
    #[error(
        "the polygons of a direction of the table have {corners} corners, and pages take at most \
        {MOST_CORNERS}; use fit render"
    )]
    ManyCorners { corners: usize },
    /// Page for polarised light.
    #[error(
        "a page with sliders knows unpolarised light only; use fit render or fit predict for \
        polarised light"
    )]
    Polarised,
    /// View file that cannot be read.
    #[error(transparent)]
    CameraView(#[from] edges::document::Error),
    /// Camera that is behind the sheet, at a column and row from the middle of the picture.
    #[error("{}: the camera sees the back of the sheet at pixel ({:.0}, {:.0}); turn `normal` of \
        [sheet] towards the camera", .0.display(), .1[0], .1[1])]
    Back(PathBuf, [f64; 2]),
    /// Sheet in front of the image, at a column and row from the middle of the picture.
    #[error("{}: at pixel ({:.0}, {:.0}) the sheet is not behind the image; move `position_mm` of \
        [sheet] away from the camera", .0.display(), .1[0], .1[1])]
    Before(PathBuf, [f64; 2]),
    /// Camera in the plane of the image.
    #[error("{}: the camera lies in the image's plane; move `position_mm` of [camera] in front \
        of the image", .0.display())]
    Edge(PathBuf),
    /// Model without samples: only its OTF is known.
    #[error(
        "the model of this result has no samples: --forward render works only with the kernels \
        eq1, angular, shift and lobe; use --forward spectral"
    )]
    NoSamples,
    /// Kernel whose blur holds at one distance only, or belongs to another model.
    #[error(
        "a result of the kernel {} cannot be rendered in a scene: its lobe is not that of one \
        angle or one distance; estimate again with --kernel angular", .0.name()
    )]
    NoBsdf(Kernel),
    /// Result with dihedral errors, which the plugin of Mitsuba cannot add to a table.
    #[error(
        "a result with dihedral_errors_mrad cannot be rendered in a scene of Mitsuba; bake a table of \
        cubes with these errors (bake design --dihedral-error-mrad), and estimate with it"
    )]
    BentCubes,
    /// Result without a lens, whose file was named as that of the camera.
    #[error("{}: has no lens, or a damaged one: its numbers were given by hand, or it is of an \
        earlier version without a reference photograph; give what `fit estimate -o` wrote", .0.display())]
    NoLens(PathBuf),
    /// Camera for a render by samples.
    #[error("--camera: works only with --forward spectral; leave one of the two out")]
    SampledCamera,
    /// Tables of three colours for a render by samples.
    #[error("three tables work only with --forward spectral; give one, or leave the option out")]
    SampledColours,
    /// Pixel, by column and row, whose blur cannot be computed.
    #[error("at pixel ({:.0}, {:.0}) of the view: {}", .0[0], .0[1], .1)]
    Pixel([f64; 2], Box<Error>),
}
