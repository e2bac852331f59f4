//! A camera before a mid-air image: at which incidence, azimuth and distance the sheet shows every
//! pixel.
//!
//! ```text
//!                     |  the image's plane        /  the sheet's plane
//!        camera       | x, a pixel               / h
//!          E ---------+-------------------------+
//!                     |<--------- R ---------->/  \  theta, to the normal
//!                     |                       /    n
//! ```
//!
//! All is given as the camera sees it, so as if the half mirror were not there: where it sees the
//! sheet by reflection, the sheet is given where its mirror image is. The light of pixel x comes
//! along h, x, E; the sheet sent it back along the way on which it came, so h is where it was
//! returned, the angle of E - x with the sheet's normal its incidence, and
//! |h - x| the distance R that its blur has grown over. The blur is that of the plane across the ray, carried along the ray to the
//! image's plane.

use std::path::{Path, PathBuf};

use nalgebra::Vector3;

use crate::document::Bounds;
use crate::document::error as document;
use crate::document::{Document, Section};
use crate::images::spot::Viewpoint;

/// Directions this close to the normal have no azimuth of their own, rad.
const UPRIGHT: f64 = 1e-9;

/// What a VIEW.toml says; lengths in mm, directions of length 1.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CameraView {
    file: PathBuf,
    camera: Vector3<f64>,
    centre: Vector3<f64>,
    right: Vector3<f64>,
    down: Vector3<f64>,
    pitch_mm: f64,
    sheet: Vector3<f64>,
    normal: Vector3<f64>,
    /// In the sheet's plane, azimuth 0.
    first_edge: Vector3<f64>,
    /// -1 where the camera sees the sheet in the half mirror, which turns azimuths round.
    handedness: f64,
    /// Luminance behind the image, in units of the source's white.
    pub ambient: f64,
    /// Refractive index of the sheet's coating.
    pub coating: Option<f64>,
}

/// How a pixel is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Seen {
    /// Where on the sheet.
    pub place: Viewpoint,
    /// From (tangential, sagittal) mm across the ray to (columns, rows).
    pub pixels_from_mm: [[f64; 2]; 2],
    /// The place in the picture, columns and rows from its middle, that the sheet's front face
    /// mirrors there; `None` where the mirrored ray misses the image's plane.
    pub mirrored: Option<[f64; 2]>,
}

/// A pixel that shows no sheet.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum Error {
    /// The sheet turns its back.
    #[error("{}: the camera sees the back of the sheet at pixel ({column:.0}, {row:.0}); turn \
    `normal` of [sheet] towards \
             the camera", file.display())]
    Back {
        /// The view.
        file: PathBuf,
        /// Column.
        column: f64,
        /// Row.
        row: f64,
    },
    /// The sheet stands before the image.
    #[error("{}: at pixel ({column:.0}, {row:.0}) the sheet is not behind the image; move \
    `position_mm` of [sheet] away from \
             the camera", file.display())]
    Before {
        /// The view.
        file: PathBuf,
        /// Column.
        column: f64,
        /// Row.
        row: f64,
    },
    /// The image is seen from its edge.
    #[error("{}: the camera lies in the image's plane; move `position_mm` of [camera] before the \
    image", file.display())]
    Edge {
        /// The view.
        file: PathBuf,
    },
}

impl CameraView {
    /// Reads a VIEW.toml.
    ///
    /// # Errors
    /// [`document::Error`] with file, line, key and remedy.
    pub(crate) fn load(file: &Path) -> Result<CameraView, document::Error> {
        let document = Document::read(file)?;
        let parsed = document.parse()?;
        let known = ["camera", "image", "sheet", "ambient", "coating"];
        let root = Section::root(&document, &parsed, &known)?;
        let section = |key, known: &[&'static str]| root.required(key, root.section(key, known)?);
        let camera = section("camera", &["position_mm"])?;
        let image = section("image", &["centre_mm", "right", "down", "pixel_pitch_mm"])?;
        let keys = ["position_mm", "normal", "first_edge", "seen_in_mirror"];
        let sheet = section("sheet", &keys)?;

        let right = direction(&image, "right", None)?;
        let normal = direction(&sheet, "normal", None)?;
        let pitch = image.number("pixel_pitch_mm", Bounds::POSITIVE)?;
        let mirrored = sheet.flag("seen_in_mirror")?.unwrap_or(false);
        let ambient = match root.section("ambient", &["luminance"])? {
            Some(ambient) => {
                let luminance = ambient.number("luminance", Bounds::NOT_NEGATIVE)?;
                ambient.required("luminance", luminance)?
            }
            None => 0.0,
        };
        let coating = match root.section("coating", &["refractive_index"])? {
            Some(coating) => {
                let index = coating.number("refractive_index", Bounds::POSITIVE)?;
                Some(coating.required("refractive_index", index)?)
            }
            None => None,
        };
        Ok(CameraView {
            file: file.to_owned(),
            camera: point(&camera, "position_mm")?,
            centre: point(&image, "centre_mm")?,
            right,
            down: direction(&image, "down", Some(&right))?,
            pitch_mm: image.required("pixel_pitch_mm", pitch)?,
            sheet: point(&sheet, "position_mm")?,
            normal,
            first_edge: direction(&sheet, "first_edge", Some(&normal))?,
            handedness: if mirrored { -1.0 } else { 1.0 },
            ambient,
            coating,
        })
    }

    /// One pixel, mm.
    pub(crate) fn pitch_mm(&self) -> f64 {
        self.pitch_mm
    }

    /// How the point is seen that lies `column`, `row` pixels from the middle of the picture.
    ///
    /// # Errors
    /// [`Error`].
    pub(crate) fn at(&self, [column, row]: [f64; 2]) -> Result<Seen, Error> {
        let file = || self.file.clone();
        let plane = self.right.cross(&self.down);
        let point = self.centre + (self.right * column + self.down * row) * self.pitch_mm;
        let to_image = (point - self.camera).norm();
        let ray = (point - self.camera) / to_image;
        let across = ray.dot(&plane);
        if to_image == 0.0 || across.abs() < 1e-6 {
            return Err(Error::Edge { file: file() });
        }
        let cosine = -ray.dot(&self.normal);
        if cosine <= 1e-6 {
            return Err(Error::Back {
                file: file(),
                column,
                row,
            });
        }
        let to_sheet = (self.camera - self.sheet).dot(&self.normal) / cosine;
        let r_mm = to_sheet - to_image;
        if r_mm <= 0.0 {
            return Err(Error::Before {
                file: file(),
                column,
                row,
            });
        }
        // The light went to the sheet along the camera's ray; u is its direction within the sheet.
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
        Ok(Seen {
            place: Viewpoint {
                incidence_deg: sine.atan2(cosine).to_degrees(),
                azimuth_deg: Some(azimuth.to_degrees()),
                r_mm,
            },
            pixels_from_mm: [[t[0], s[0]], [t[1], s[1]]],
            mirrored: self.mirrored(ray, self.camera + ray * to_sheet, plane),
        })
    }

    /// The source is seen by the sheet where its mid-air image is: a ray that the front face turns
    /// back meets it there.
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

/// Share of unpolarised light that a flat face of `index` reflects at an incidence (Fresnel's
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

fn point(section: &Section<'_>, key: &'static str) -> Result<Vector3<f64>, document::Error> {
    Ok(Vector3::from(section.required(key, section.vector(key)?)?))
}

/// A direction of length 1, made perpendicular to another.
fn direction(
    section: &Section<'_>,
    key: &'static str,
    to: Option<&Vector3<f64>>,
) -> Result<Vector3<f64>, document::Error> {
    let given = point(section, key)?;
    let rest = to.map_or(given, |to| given - to * given.dot(to));
    let length = rest.norm() / given.norm();
    if length > 1e-6 {
        return Ok(rest.normalize());
    }
    Err(document::Error::OutOfRange {
        place: section.place_of(key),
        key: key.to_owned(),
        value: rest.norm(),
        must_be: "a direction: longer than 0, and not along the other direction of its section",
    })
}
