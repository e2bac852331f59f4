//! Nominal sheets: numbers from public sources, and assumptions, for who has neither a sheet nor a
//! fit of one.
//!
//! Each sheet brings the table of its cell, so that a picture needs no bake. `bake` made these
//! tables (`fit/sheets/README.md` has the commands).

use std::path::Path;

use tables::Table;

use crate::names::Spectrum;
use crate::result::by_hand::{ByHand, NOMINAL, Spread};
use crate::result::report::{AtAngle, Parameter, ResultFile};
use crate::result::table::TableResult;

/// Cell of a nominal sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Cell {
    /// Pairs of triangular cubes behind a flat front of index 1.49 (acrylic), with metal on their
    /// back.
    Prisms,
    /// Hollow full cubes.
    HollowCubes,
}

/// Cause that spreads the light of a nominal sheet.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Blur {
    /// Diffraction by wave optics.
    Waves {
        /// Wavelength, nm.
        wavelength_nm: f64,
        /// Reflectance.
        mu: f64,
    },
    /// Lobe of a fixed angle: A = a R and mu at each incidence, degrees.
    Angles(&'static [(f64, f64, f64)]),
}

/// Nominal sheet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Nominal {
    /// Name that the command line takes.
    pub name: &'static str,
    /// Description of the sheet, with the source of its size.
    pub about: &'static str,
    /// Assumptions about it.
    pub assumed: &'static str,
    cell: Cell,
    c_mm: f64,
    blur: Blur,
}

/// Light that returns from three mirrors of aluminium, 0.91 each.
const ALUMINIUM: f64 = 0.91 * 0.91 * 0.91;

/// Light that passes a front of index 1.49 twice.
const FRONT: f64 = (1.0 - 0.0387) * (1.0 - 0.0387);

/// A and mu of the fits that the authors of the method published.
const PUBLISHED: [(f64, f64, f64); 10] = [
    (0.0, 735.0, 0.252),
    (5.0, 705.0, 0.249),
    (10.0, 649.0, 0.246),
    (15.0, 576.0, 0.239),
    (20.0, 509.0, 0.231),
    (25.0, 384.0, 0.223),
    (30.0, 344.0, 0.205),
    (35.0, 250.0, 0.190),
    (40.0, 238.0, 0.169),
    (45.0, 191.0, 0.202),
];

/// All nominal sheets.
const ALL: [Nominal; 4] = [
    Nominal {
        name: "prism-0.1",
        about: "fine prism sheet: acrylic cubes of 0.1 mm, which is 0.12 mm between grooves \
            (US patent 6,843,571 names 0.013 to 0.178 mm)",
        assumed: "ideal cubes, index 1.49, aluminium on the back (0.91 a mirror), light of 550 nm",
        cell: Cell::Prisms,
        c_mm: 0.1,
        blur: Blur::Waves {
            wavelength_nm: 550.0,
            mu: FRONT * ALUMINIUM,
        },
    },
    Nominal {
        name: "prism-0.2",
        about: "coarse prism sheet: acrylic cubes of 0.2 mm (US patent 3,684,348 names edges below \
            0.635 mm)",
        assumed: "ideal cubes, index 1.49, aluminium on the back (0.91 a mirror), light of 550 nm",
        cell: Cell::Prisms,
        c_mm: 0.2,
        blur: Blur::Waves {
            wavelength_nm: 550.0,
            mu: FRONT * ALUMINIUM,
        },
    },
    Nominal {
        name: "hollow-0.2",
        about: "array of hollow full cubes with edges of 0.2 mm (US patent 3,684,348 names edges \
            below 0.635 mm)",
        assumed: "ideal cubes of aluminium (0.91 a mirror), no front, light of 550 nm",
        cell: Cell::HollowCubes,
        c_mm: 0.2,
        blur: Blur::Waves {
            wavelength_nm: 550.0,
            mu: ALUMINIUM,
        },
    },
    Nominal {
        name: "published",
        about: "the sheet whose a and mu the authors of the method published, for 0 to 45 degrees \
            (Sugawara and Koizumi 2025, public fits; c is about 0.08 mm)",
        assumed: "prisms of index 1.49, because the sheet is not named; the blur grows with the \
            distance (kernel angular); mu as published, and it may contain more than the sheet",
        cell: Cell::Prisms,
        c_mm: 0.08,
        blur: Blur::Angles(&PUBLISHED),
    },
];

impl Nominal {
    /// Returns all nominal sheets.
    pub(crate) fn all() -> &'static [Nominal] {
        &ALL
    }

    /// Returns the sheet of a name, or `None` if there is none.
    pub(crate) fn named(name: &str) -> Option<&'static Nominal> {
        ALL.iter().find(|sheet| sheet.name == name)
    }

    /// Reads the table of the cell, which is part of the program.
    ///
    /// # Errors
    /// Returns an error of the table if the program is damaged.
    pub(crate) fn table(&self) -> Result<Table, tables::Error> {
        let bytes: &[u8] = match self.cell {
            Cell::Prisms => include_bytes!("../../sheets/prisms.h5"),
            Cell::HollowCubes => include_bytes!("../../sheets/hollow-cubes.h5"),
        };
        tables::read_held(bytes, Path::new(self.name))
    }

    /// Returns the sheet as a result. `mu` and `half_mirror` take the place of its own if given.
    ///
    /// `table` is that of the cell.
    pub(crate) fn result(
        &self,
        table: TableResult,
        mu: Option<f64>,
        half_mirror: f64,
        pixel_pitch_mm: f64,
    ) -> ResultFile {
        let (spread, own_mu) = match self.blur {
            Blur::Waves { wavelength_nm, mu } => {
                let line = Spectrum::monochromatic(wavelength_nm);
                (
                    Spread::Wave(line.expect("550 nm is a wavelength")),
                    Some(mu),
                )
            }
            // The values by incidence follow.
            Blur::Angles(_) => (Spread::Angle(1.0), None),
        };
        let sheet = ByHand {
            c_mm: self.c_mm,
            spread,
            mu: mu.or(own_mu),
            half_mirror,
            pixel_pitch_mm,
        };
        let mut result = sheet.result(table);
        result.stop = NOMINAL.into();
        if let Blur::Angles(values) = self.blur {
            let per_angle = |value: fn(&(f64, f64, f64)) -> f64| Parameter::PerAngle {
                per_angle: (values.iter())
                    .map(|own| AtAngle {
                        incidence_deg: own.0,
                        value: Some(value(own)),
                        standard_error: None,
                    })
                    .collect(),
            };
            result.a_times_r = Some(per_angle(|own| own.1));
            if mu.is_none() {
                result.mu = Some(per_angle(|own| own.2));
            }
        }
        result.warnings.push(format!(
            "{} is no measured sheet: {}; assumed: {}",
            self.name, self.about, self.assumed
        ));
        result
    }
}
