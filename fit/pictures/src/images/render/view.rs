//! Camera in front of a mid-air image: the incidence, azimuth and distance of every pixel on the
//! sheet.
//!
//! ```text
//!                     |  the image's plane        /  the sheet's plane
//!        camera       | x, a pixel               / h
//!          E ---------+-------------------------+
//!                     |<--------- R ---------->/  \  theta, to the normal
//!                     |                       /    n
//! ```
//!
//! All positions are given as the camera sees them, as if there were no half mirror. If the camera
//! sees the sheet in the half mirror, give the position of its mirror image. The light of pixel x
//! passes h, x and E. The sheet sent it back at h along the way on which it came. So its incidence
//! is the angle between E - x and the sheet's normal, and the distance R, over which its blur has
//! grown, is |h - x|. The blur is computed in the plane across the ray and projected along the ray
//! to the plane of the image.

use std::path::{Path, PathBuf};

use nalgebra::Vector3;
use serde::Deserialize;
use toml::Spanned;

use crate::error::Error;
use crate::images::spot::Viewpoint;
use edges::document::{self, Bounds, Document, Table, not_negative, positive};

/// Sine of the incidence below which the azimuth is not defined.
const UPRIGHT: f64 = 1e-9;

/// Content of a VIEW.toml: lengths in mm, directions of length 1.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraView {
    /// File that was read.
    file: PathBuf,
    /// Position of the camera, mm.
    camera: Vector3<f64>,
    /// Middle of the mid-air image, mm.
    centre: Vector3<f64>,
    /// Direction of the columns of the picture, to the right.
    right: Vector3<f64>,
    /// Direction of the rows of the picture, downwards.
    down: Vector3<f64>,
    /// Width of a pixel, mm.
    pitch_mm: f64,
    /// A point of the sheet, mm.
    sheet: Vector3<f64>,
    /// Normal of the sheet.
    normal: Vector3<f64>,
    /// Direction of azimuth 0 in the plane of the sheet.
    first_edge: Vector3<f64>,
    /// Sign of azimuths: -1 if the camera sees the sheet in the half mirror, which reverses them;
    /// else 1.
    handedness: f64,
    /// Luminance behind the image, in units of the white of the source.
    pub ambient: f64,
    /// Refractive index of the sheet's coating; `None` without a coating.
    pub coating: Option<f64>,
}

/// View of one pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelView {
    /// Incidence and azimuth on the sheet, and distance R.
    pub place: Viewpoint,
    /// Matrix that converts (tangential, sagittal) mm across the ray to (columns, rows).
    pub pixels_from_mm: [[f64; 2]; 2],
    /// Place in the picture that the front face of the sheet reflects there, in columns and rows
    /// from the middle of the picture.
    ///
    /// It is `None` if the reflected ray misses the plane of the image.
    pub mirrored: Option<[f64; 2]>,
}

impl CameraView {
    /// Reads a VIEW.toml.
    ///
    /// # Errors
    /// Returns a [`document::Error`] with file, line, key and remedy if the file cannot be read, if
    /// a key is missing or unknown, or if a value is outside its range.
    pub fn load(file: &Path) -> Result<CameraView, document::Error> {
        let document = Document::read(file)?;
        let Tables {
            camera: Table(camera),
            image: Table(image),
            sheet: Table(sheet),
            ambient,
            coating,
        } = document.parse()?;
        let direction = |key, given: &Spanned<Point>, to: Option<&Vector3<f64>>| {
            direction(given.get_ref().0, to).ok_or_else(|| {
                document.place(given.span()).error(format!(
                    "`{key}` is no direction: it must be longer than 0, and not along the other \
                    direction of its section; correct the value"
                ))
            })
        };
        let right = direction("right", &image.right, None)?;
        let normal = direction("normal", &sheet.normal, None)?;
        Ok(CameraView {
            file: file.to_owned(),
            camera: camera.position_mm.0,
            centre: image.centre_mm.0,
            right,
            down: direction("down", &image.down, Some(&right))?,
            pitch_mm: image.pixel_pitch_mm,
            sheet: sheet.position_mm.0,
            normal,
            first_edge: direction("first_edge", &sheet.first_edge, Some(&normal))?,
            handedness: if sheet.seen_in_mirror { -1.0 } else { 1.0 },
            ambient: ambient.map_or(0.0, |table| table.0.luminance),
            coating: coating.map(|table| table.0.refractive_index),
        })
    }

    /// Places a viewer in front of an image about the origin, whose columns run along x and whose
    /// rows run against y, with pixels of 1 mm. `name` stands for the file in messages.
    pub(crate) fn of_a_viewer(
        name: &str,
        viewer: Vector3<f64>,
        sheet: Vector3<f64>,
        [normal, first_edge]: [Vector3<f64>; 2],
    ) -> CameraView {
        CameraView {
            file: name.into(),
            camera: viewer,
            centre: Vector3::zeros(),
            right: Vector3::x(),
            down: -Vector3::y(),
            pitch_mm: 1.0,
            sheet,
            normal,
            first_edge,
            handedness: 1.0,
            ambient: 0.0,
            coating: None,
        }
    }

    /// Returns whether the camera sees the sheet in the half mirror.
    pub fn is_in_mirror(&self) -> bool {
        self.handedness < 0.0
    }

    /// Returns the width of a pixel, mm.
    pub fn pitch_mm(&self) -> f64 {
        self.pitch_mm
    }

    /// Computes the view of the point that lies `column`, `row` pixels from the middle of the
    /// picture.
    ///
    /// # Errors
    /// Returns an error if the camera lies in the plane of the image, if it sees the back of the
    /// sheet, and if the sheet is not behind the image.
    pub fn at(&self, [column, row]: [f64; 2]) -> Result<PixelView, Error> {
        let file = || self.file.clone();
        let plane = self.right.cross(&self.down);
        let point = self.centre + (self.right * column + self.down * row) * self.pitch_mm;
        let to_image = (point - self.camera).norm();
        let ray = (point - self.camera) / to_image;
        let across = ray.dot(&plane);
        if to_image == 0.0 || across.abs() < 1e-6 {
            return Err(Error::Edge(file()));
        }
        let cosine = -ray.dot(&self.normal);
        if cosine <= 1e-6 {
            return Err(Error::Back(file(), [column, row]));
        }
        let to_sheet = (self.camera - self.sheet).dot(&self.normal) / cosine;
        let r_mm = to_sheet - to_image;
        if r_mm <= 0.0 {
            return Err(Error::Before(file(), [column, row]));
        }
        // The light arrived at the sheet along the camera's ray. u is its direction in the sheet.
        let within = ray + self.normal * cosine;
        let sine = within.norm();
        let u = if sine > UPRIGHT {
            within / sine
        } else {
            self.first_edge
        };
        let turned = self.normal.cross(&self.first_edge) * self.handedness;
        let azimuth = u.dot(&turned).atan2(u.dot(&self.first_edge));
        let tangential = (u - ray * u.dot(&ray)).normalize();
        let sagittal = self.normal.cross(&u) * self.handedness;
        let carried = |offset: Vector3<f64>| {
            let offset = offset - ray * (offset.dot(&plane) / across);
            [self.right, self.down].map(|axis| offset.dot(&axis) / self.pitch_mm)
        };
        let [t, s] = [tangential, sagittal].map(carried);
        Ok(PixelView {
            place: Viewpoint {
                incidence_deg: sine.atan2(cosine).to_degrees(),
                azimuth_deg: Some(azimuth.to_degrees()),
                r_mm,
            },
            pixels_from_mm: [[t[0], s[0]], [t[1], s[1]]],
            mirrored: self.mirrored(ray, self.camera + ray * to_sheet, plane),
        })
    }

    /// Finds the place in the picture that the front face of the sheet reflects at `hit`.
    ///
    /// The sheet sees the source at the place of the mid-air image, so the reflected ray meets it
    /// there. Returns `None` if the ray misses the plane of the image.
    fn mirrored(
        &self,
        ray: Vector3<f64>,
        hit: Vector3<f64>,
        plane: Vector3<f64>,
    ) -> Option<[f64; 2]> {
        let back = ray - self.normal * (2.0 * ray.dot(&self.normal));
        let along = (self.centre - hit).dot(&plane) / back.dot(&plane);
        let offset = hit + back * along - self.centre;
        (along > 0.0 && along.is_finite())
            .then(|| [self.right, self.down].map(|axis| offset.dot(&axis) / self.pitch_mm))
    }
}

/// Returns the share of unpolarised light that a flat face of `index` reflects (Fresnel's
/// equations).
pub(crate) fn fresnel(index: f64, incidence_deg: f64) -> f64 {
    let (sine, cosine) = incidence_deg.to_radians().sin_cos();
    let inside = 1.0 - (sine / index).powi(2);
    if inside <= 0.0 {
        return 1.0;
    }
    let inside = inside.sqrt();
    let s = (cosine - index * inside) / (cosine + index * inside);
    let p = (index * cosine - inside) / (index * cosine + inside);
    0.5 * (s * s + p * p)
}

/// A VIEW.toml as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Tables {
    camera: Table<CameraTable>,
    image: Table<ImageTable>,
    sheet: Table<SheetTable>,
    ambient: Option<Table<AmbientTable>>,
    coating: Option<Table<CoatingTable>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraTable {
    position_mm: Point,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ImageTable {
    centre_mm: Point,
    right: Spanned<Point>,
    down: Spanned<Point>,
    #[serde(deserialize_with = "positive")]
    pixel_pitch_mm: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SheetTable {
    position_mm: Point,
    normal: Spanned<Point>,
    first_edge: Spanned<Point>,
    #[serde(default)]
    seen_in_mirror: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct AmbientTable {
    #[serde(deserialize_with = "not_negative")]
    luminance: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CoatingTable {
    #[serde(deserialize_with = "positive")]
    refractive_index: f64,
}

/// Three numbers in brackets.
#[derive(Deserialize)]
#[serde(try_from = "Vec<f64>")]
struct Point(Vector3<f64>);

impl TryFrom<Vec<f64>> for Point {
    type Error = serde::de::value::Error;

    fn try_from(numbers: Vec<f64>) -> Result<Point, Self::Error> {
        let [x, y, z] = numbers[..] else {
            let wrong = "must be three numbers in brackets; change the value";
            return Err(serde::de::Error::custom(wrong));
        };
        for number in numbers {
            Bounds::FINITE.checked::<Self::Error>(number)?;
        }
        Ok(Point(Vector3::new(x, y, z)))
    }
}

/// Scales a direction to length 1, and makes it perpendicular to `to` if that is given. Returns
/// `None` for a direction that has no length or is parallel to `to`.
fn direction(given: Vector3<f64>, to: Option<&Vector3<f64>>) -> Option<Vector3<f64>> {
    let rest = to.map_or(given, |to| given - to * given.dot(to));
    (rest.norm() / given.norm() > 1e-6).then(|| rest.normalize())
}
