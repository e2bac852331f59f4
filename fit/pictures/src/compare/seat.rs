//! A viewer in front of a mid-air image: the incidence that follows from plain numbers.
//!
//! The middle of the image is the origin. x is to the right of the viewer, y is up, and z is
//! towards the viewer. All places are as the viewer sees them, as if there were no half mirror. A
//! sheet of tilt 0 is upright and faces along z. At a tilt of 90 degrees it lies flat and faces up.
//! Azimuths are about its normal, from that of a viewer in the middle above the sheet's normal.

use nalgebra::Vector3;

use crate::error::Error;
use crate::images::Viewpoint;
use crate::images::render::view::{CameraView, PixelView};

/// Where the sheet is behind the image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Behind {
    /// So far along the line of sight through the middle of the image: the distance R, mm.
    Distance(f64),
    /// At this height on this line, mm above the image; negative below it.
    Height(f64),
}

/// Viewer, image and sheet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seat {
    /// Place of the viewer, mm.
    pub viewer_mm: [f64; 3],
    /// Where the sheet is.
    pub behind: Behind,
    /// Tilt of the sheet from the upright, degrees.
    pub tilt_deg: f64,
    /// Azimuth for a viewer in the middle above the sheet's normal, degrees.
    pub azimuth_deg: f64,
    /// Width and height of the image, mm.
    pub size_mm: [f64; 2],
}

/// What the viewer sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight {
    /// Incidence, azimuth and distance in the middle of the image.
    pub middle: Viewpoint,
    /// Direction of the plane of incidence in the image, degrees: 0 is right, 90 is down.
    pub tangential_axis_deg: f64,
    /// Least and greatest incidence over the image, degrees.
    pub incidence_deg: [f64; 2],
    /// Distance from the viewer to the middle of the image, mm.
    pub viewer_mm: f64,
}

/// Word of messages for the place of the viewer.
const VIEWER: &str = "--viewer";

impl Seat {
    /// Computes what the viewer sees.
    ///
    /// # Errors
    /// Returns [`Error::Seat`] if the viewer is not in front of the image or sees the back of the
    /// sheet, and if the sheet is not behind the image.
    pub fn sight(&self) -> Result<Sight, Error> {
        let viewer = Vector3::from(self.viewer_mm);
        let away = -viewer.normalize();
        if viewer.z <= 0.0 {
            return Err(Error::Seat(
                "--viewer: the last number must be above 0: the viewer is in front of the image"
                    .into(),
            ));
        }
        let r_mm = match self.behind {
            Behind::Distance(r_mm) => r_mm,
            Behind::Height(height_mm) => height_mm / away.y,
        };
        if !(r_mm.is_finite() && r_mm > 0.0) {
            return Err(Error::Seat(
                "--sheet-height: the line of sight does not come to this height behind the image; \
                give a height below 0 for a viewer above the image, or --distance"
                    .into(),
            ));
        }
        let (sine, cosine) = self.tilt_deg.to_radians().sin_cos();
        let normal = Vector3::new(0.0, sine, cosine);
        let down = Vector3::new(0.0, -cosine, sine);
        let (turn, rest) = (-self.azimuth_deg).to_radians().sin_cos();
        let first_edge = down * rest + normal.cross(&down) * turn;
        let view = CameraView::of_a_viewer(VIEWER, viewer, away * r_mm, [normal, first_edge]);
        let [half_width, half_height] = self.size_mm.map(|side| 0.5 * side);
        let at = |x: f64, y: f64| -> Result<PixelView, Error> {
            view.at([x * half_width, y * half_height])
                .map_err(|error| match error {
                    Error::Back(..) => Error::Seat(
                        "the viewer sees the back of the sheet; change --sheet-tilt or --viewer"
                            .into(),
                    ),
                    Error::Before(..) => Error::Seat(
                        "the sheet cuts the image; give a longer --distance or a smaller --width"
                            .into(),
                    ),
                    other => other,
                })
        };
        let middle = at(0.0, 0.0)?;
        let mut range = [middle.place.incidence_deg; 2];
        for x in [-1.0, 0.0, 1.0] {
            for y in [-1.0, 0.0, 1.0] {
                let deg = at(x, y)?.place.incidence_deg;
                range = [range[0].min(deg), range[1].max(deg)];
            }
        }
        let [[right, _], [below, _]] = middle.pixels_from_mm;
        Ok(Sight {
            middle: middle.place,
            tangential_axis_deg: below.atan2(right).to_degrees(),
            incidence_deg: range,
            viewer_mm: viewer.norm(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seat(viewer_mm: [f64; 3], tilt_deg: f64, behind: Behind) -> Seat {
        Seat {
            viewer_mm,
            behind,
            tilt_deg,
            azimuth_deg: 10.0,
            size_mm: [0.0, 0.0],
        }
    }

    /// Angles by hand: a viewer at (0, 1, 1) looks down by 45 degrees, one at (1, 0, sqrt 3) by 30
    /// from the right. Rounding is below 1e-12 of a degree.
    #[test]
    fn incidence_azimuth_and_distance_follow_by_trigonometry() {
        let root = 3.0_f64.sqrt();
        let at = Behind::Distance(500.0);
        let cases = [
            // Upright: the azimuth of a viewer above is that of the seat, and 90 less from the
            // right, because azimuths run right-handed about the normal, from below to the right.
            (seat([0.0, 1.0, 1.0], 0.0, at), [45.0, 10.0, 500.0], 90.0),
            (seat([1.0, 0.0, root], 0.0, at), [30.0, -80.0, 500.0], 180.0),
            // Leant back by the angle of sight: straight.
            (seat([0.0, 1.0, 1.0], 45.0, at), [0.0, 10.0, 500.0], 90.0),
            (seat([0.0, 1.0, 1.0], 30.0, at), [15.0, 10.0, 500.0], 90.0),
            // Flat on the floor, 300 mm below the image, seen by 30 degrees from the horizontal:
            // the line of sight is 600 mm long, and the viewer is now below the normal.
            (
                seat([0.0, 1.0, root], 90.0, Behind::Height(-300.0)),
                [60.0, -170.0, 600.0],
                -90.0,
            ),
        ];
        for (seat, [incidence, azimuth, r_mm], axis) in cases {
            let found = seat.sight().expect("the sheet is seen");
            let middle = found.middle;
            assert!((middle.incidence_deg - incidence).abs() < 1e-6, "{found:?}");
            let turned = middle.azimuth_deg.expect("it is known") - azimuth;
            if incidence > 0.0 {
                assert!(turned.abs() < 1e-9, "{found:?}");
                let axis = (found.tangential_axis_deg - axis).rem_euclid(360.0);
                assert!(axis.min(360.0 - axis) < 1e-9, "{found:?}");
            }
            assert!((middle.r_mm - r_mm).abs() < 1e-9, "{found:?}");
            assert_eq!(found.incidence_deg, [middle.incidence_deg; 2]);
        }
    }

    /// A picture 400 mm wide, 1 m in front of the viewer: its rims are seen by atan 0.2.
    #[test]
    fn incidence_changes_over_the_picture() {
        let wide = Seat {
            size_mm: [400.0, 0.0],
            ..seat([0.0, 0.0, 1000.0], 0.0, Behind::Distance(500.0))
        };
        let found = wide.sight().expect("the sheet is seen");
        let rim = 0.2_f64.atan().to_degrees();
        assert!(found.incidence_deg[0].abs() < 1e-9);
        assert!((found.incidence_deg[1] - rim).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn impossible_seats_are_refused() {
        let at = Behind::Distance(500.0);
        let cases = [
            (seat([0.0, 1.0, -1.0], 0.0, at), "the last number"),
            (seat([0.0, 1.0, 0.0], 0.0, at), "the last number"),
            (seat([0.0, -1.0, 1.0], 90.0, at), "back of the sheet"),
            (
                seat([0.0, 1.0, 1.0], 0.0, Behind::Height(100.0)),
                "--sheet-height",
            ),
            (
                seat([0.0, 0.0, 1.0], 0.0, Behind::Height(-100.0)),
                "--sheet-height",
            ),
        ];
        for (seat, said) in cases {
            let error = seat.sight().expect_err("it is impossible").to_string();
            assert!(error.contains(said), "{error}");
        }
        let cut = Seat {
            size_mm: [10.0, 800.0],
            ..seat([0.0, 0.0, 1000.0], 60.0, Behind::Distance(100.0))
        };
        let said = cut.sight().expect_err("it is impossible").to_string();
        assert!(said.contains("cuts the image"), "{said}");
    }
}
