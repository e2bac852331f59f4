//! Nominal sheets: numbers from public sources, and assumptions, for who has neither a sheet nor a
//! fit of one.
//!
//! Each sheet brings the table of its cell, so that a picture needs no bake. `bake` made these
//! tables (`fit/sheets/README.md` has the commands).

use std::path::Path;

use tables::Table;

use crate::result::by_hand::{ByHand, NOMINAL, Spread};
use crate::result::parameter::{AtAngle, Parameter};
use crate::result::report::ResultFile;
use crate::result::table::TableResult;
use edges::names::Spectrum;

/// Cell of a nominal sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Cell {
    /// Pairs of triangular cubes behind a flat front of index 1.49 (acrylic), with metal on their
    /// back.
    Prisms,
    /// Pairs of triangular cubes behind a flat front of index 1.49, without metal: they reflect
    /// totally.
    BarePrisms,
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
        /// Reflectance at each incidence, degrees.
        mu: &'static [(f64, f64)],
    },
    /// Lobe of a fixed angle: A = a R and mu at each incidence, degrees.
    Angles(&'static [(f64, f64, f64)]),
}

/// Nominal sheet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nominal {
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

/// mu of prisms of index 1.49 with aluminium on their back, by incidence: the light that `bake`
/// returns with these losses, divided by that without (means over all azimuths, 550 nm).
///
/// Single azimuths differ from it by at most 0.25 %.
const PRISMS: [(f64, f64); 11] = [
    (0.0, 0.6028),
    (5.0, 0.6024),
    (10.0, 0.6012),
    (15.0, 0.5993),
    (20.0, 0.5967),
    (25.0, 0.5935),
    (30.0, 0.5901),
    (35.0, 0.5870),
    (40.0, 0.5848),
    (45.0, 0.5841),
    (50.0, 0.5838),
];

/// mu of hollow full cubes of aluminium, as [`PRISMS`].
///
/// Single azimuths differ from it by 0.2 % up to 25 degrees, 2.8 % at 30 and 16 % from 35 on.
const HOLLOW_CUBES: [(f64, f64); 14] = [
    (0.0, 0.7400),
    (5.0, 0.7388),
    (10.0, 0.7350),
    (15.0, 0.7286),
    (20.0, 0.7193),
    (25.0, 0.7089),
    (27.5, 0.7052),
    (30.0, 0.7050),
    (32.0, 0.7086),
    (34.0, 0.7127),
    (36.0, 0.7047),
    (37.0, 0.7014),
    (38.0, 0.6989),
    (40.0, 0.6953),
];

/// mu of a sheet whose table holds all losses.
const LOSSES_IN_TABLE: [(f64, f64); 1] = [(0.0, 1.0)];

/// A and mu of the fits that the authors of the method published.
///
/// Their c is about 0.08 mm, and they do not say of which length. It is not the edge of a cube: the
/// aperture of such a cube spreads light of 550 nm by an A of 440 or less, and theirs is 735. It
/// can be the depth of the cubes, edge / sqrt 3: at normal incidence A = 735 is 2 to 15 % less
/// sharp than the ideal waves of an edge of 0.139 mm, from 50 mm to 3 m. With an edge of 0.130 mm
/// it would be sharper than they are.
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
const ALL: [Nominal; 6] = [
    Nominal {
        name: "prism-0.1",
        about: "fine prism sheet: acrylic cubes of 0.1 mm, which is 0.12 mm between grooves \
            (US patent 6,843,571 names 0.013 to 0.178 mm)",
        assumed: "ideal cubes, index 1.49, aluminium on the back and Fresnel's reflection at the \
            front (mu by incidence, from bakes), light of 550 nm",
        cell: Cell::Prisms,
        c_mm: 0.1,
        blur: Blur::Waves {
            wavelength_nm: 550.0,
            mu: &PRISMS,
        },
    },
    Nominal {
        name: "prism-0.2",
        about: "coarse prism sheet: acrylic cubes of 0.2 mm (US patent 3,684,348 names edges below \
            0.635 mm)",
        assumed: "ideal cubes, index 1.49, aluminium on the back and Fresnel's reflection at the \
            front (mu by incidence, from bakes), light of 550 nm",
        cell: Cell::Prisms,
        c_mm: 0.2,
        blur: Blur::Waves {
            wavelength_nm: 550.0,
            mu: &PRISMS,
        },
    },
    Nominal {
        name: "prism-0.1-tir",
        about: "fine prism sheet without metal: acrylic cubes of 0.1 mm that reflect totally (US \
            patent 6,843,571 names 0.013 to 0.178 mm)",
        assumed: "ideal cubes, index 1.49, no metal: total reflection up to 19 degrees at the worst \
            azimuth, losses by Fresnel's equations in the table, light of 550 nm",
        cell: Cell::BarePrisms,
        c_mm: 0.1,
        blur: Blur::Waves {
            wavelength_nm: 550.0,
            mu: &LOSSES_IN_TABLE,
        },
    },
    Nominal {
        name: "prism-0.2-tir",
        about: "coarse prism sheet without metal: acrylic cubes of 0.2 mm that reflect totally (US \
            patent 3,684,348 names edges below 0.635 mm)",
        assumed: "ideal cubes, index 1.49, no metal: total reflection up to 19 degrees at the worst \
            azimuth, losses by Fresnel's equations in the table, light of 550 nm",
        cell: Cell::BarePrisms,
        c_mm: 0.2,
        blur: Blur::Waves {
            wavelength_nm: 550.0,
            mu: &LOSSES_IN_TABLE,
        },
    },
    Nominal {
        name: "hollow-0.2",
        about: "array of hollow full cubes with edges of 0.2 mm (US patent 3,684,348 names edges \
            below 0.635 mm)",
        assumed: "ideal cubes of aluminium, no front, light of 550 nm (mu by incidence, from \
            bakes: a mean over azimuths, from which single ones differ by 0.2 % up to 25 degrees, \
            3 % at 30 and 16 % from 35 on)",
        cell: Cell::HollowCubes,
        c_mm: 0.2,
        blur: Blur::Waves {
            wavelength_nm: 550.0,
            mu: &HOLLOW_CUBES,
        },
    },
    Nominal {
        name: "published",
        about: "the sheet whose a and mu the authors of the method published, for 0 to 45 degrees \
            (Sugawara and Koizumi 2025, public fits)",
        assumed: "prisms of index 1.49, because the sheet is not named; edges of 0.139 mm: the \
            published c of about 0.08 mm is taken as the depth of the cubes, because cubes with \
            edges of 0.08 mm would blur 1.7 times more by diffraction alone; the blur grows with \
            the distance (kernel angular); mu as published, and it may contain more than the sheet",
        cell: Cell::Prisms,
        c_mm: 0.139,
        blur: Blur::Angles(&PUBLISHED),
    },
];

impl Nominal {
    /// Returns all nominal sheets.
    pub fn all() -> &'static [Nominal] {
        &ALL
    }

    /// Returns the sheet of a name, or `None` if there is none.
    pub fn named(name: &str) -> Option<&'static Nominal> {
        ALL.iter().find(|sheet| sheet.name == name)
    }

    /// Reads the table of the cell, which is part of the program.
    ///
    /// # Errors
    /// Returns an error of the table if the program is damaged.
    pub fn table(&self) -> Result<Table, tables::Error> {
        let bytes: &[u8] = match self.cell {
            Cell::Prisms => include_bytes!("../../../sheets/prisms.h5"),
            Cell::BarePrisms => include_bytes!("../../../sheets/prisms-tir.h5"),
            Cell::HollowCubes => include_bytes!("../../../sheets/hollow-cubes.h5"),
        };
        tables::read_in_memory(bytes, Path::new(self.name))
    }

    /// Returns the sheet as a result. `mu` and `half_mirror` take the place of its own if given.
    ///
    /// `table` is that of the cell.
    pub fn result(
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
                    by_incidence(mu.iter().copied()),
                )
            }
            // The values of A by incidence follow.
            Blur::Angles(values) => (
                Spread::Angle(1.0),
                by_incidence(
                    values
                        .iter()
                        .map(|&(incidence_deg, _, mu)| (incidence_deg, mu)),
                ),
            ),
        };
        let sheet = ByHand {
            c_mm: self.c_mm,
            spread,
            angular_spread_mrad: None,
            mu,
            half_mirror,
            pixel_pitch_mm,
        };
        let mut result = sheet.result(table);
        result.stop = NOMINAL.into();
        if mu.is_none() {
            result.mu = Some(own_mu);
        }
        if let Blur::Angles(values) = self.blur {
            let spreads = values
                .iter()
                .map(|&(incidence_deg, a, _)| (incidence_deg, a));
            result.a_times_r = Some(by_incidence(spreads));
        }
        result.warnings.push(format!(
            "{} is no measured sheet: {}; assumed: {}",
            self.name, self.about, self.assumed
        ));
        result
    }
}

/// Returns a parameter of these values, each at an incidence in degrees.
fn by_incidence(values: impl Iterator<Item = (f64, f64)>) -> Parameter {
    let at = |(incidence_deg, value)| AtAngle {
        incidence_deg,
        value: Some(value),
        standard_error: None,
    };
    Parameter::PerAngle {
        per_angle: values.map(at).collect(),
    }
}
