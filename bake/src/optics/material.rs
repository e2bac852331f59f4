//! Refractive indices by wavelength, of published materials and of what a user types.
//!
//! Wavelengths are in vacuum, nm.
//!
//! - Transparent materials are Sellmeier formulas: PMMA and polycarbonate by Sultanova, Kasarova
//!   and Nikolov (Acta Physica Polonica A 116, 585, 2009), N-BK7 by Schott's data sheet.
//! - Metals are the Lorentz-Drude models of Rakic, Djurisic, Elazar and Majewski (Applied Optics
//!   37, 5271, 1998), which are fits to measured films.
//!
//! Silver as measured by Johnson and Christy (Physical Review B 6, 4370, 1972) absorbs less than
//! the model of silver: 2 % against 3 to 8 % from 450 nm on. Commercial mirrors are nearer to the
//! model. A user who knows better gives N,K.

use crate::error::Error;
use num_complex::Complex64;

/// Largest refractive index that is accepted.
const LARGEST: f64 = 10.0;

/// Energy of a photon times its wavelength, eV nm.
const EV_NM: f64 = 1_239.841_984;

/// Joins names by commas.
fn names<'a>(names: impl Iterator<Item = &'a str>) -> String {
    Vec::from_iter(names).join(", ")
}

/// A transparent material: n^2 = 1 + sum B l^2 / (l^2 - C), with the wavelength l in micrometres.
struct Glass {
    name: &'static str,
    /// Terms (B, C), C in square micrometres.
    terms: &'static [(f64, f64)],
    /// Shortest and longest wavelength of the formula, nm.
    range: (f64, f64),
}

const GLASSES: [Glass; 3] = [
    Glass {
        name: "pmma",
        terms: &[(1.1819, 0.011_313)],
        range: (436.8, 1052.0),
    },
    Glass {
        name: "polycarbonate",
        terms: &[(1.4182, 0.021_304)],
        range: (436.8, 1052.0),
    },
    Glass {
        name: "bk7",
        terms: &[
            (1.039_612_12, 0.006_000_698_67),
            (0.231_792_344, 0.020_017_914_4),
            (1.010_469_45, 103.560_653),
        ],
        range: (300.0, 2500.0),
    },
];

/// A Lorentz-Drude metal. All numbers but the strengths are in eV.
struct Metal {
    name: &'static str,
    plasma: f64,
    /// Strength and damping of the free electrons.
    free: (f64, f64),
    /// Strength, damping and frequency of the bound electrons.
    bound: &'static [(f64, f64, f64)],
    /// Shortest and longest wavelength of the model, nm.
    range: (f64, f64),
}

const METALS: [Metal; 2] = [
    Metal {
        name: "aluminium",
        plasma: 14.98,
        free: (0.523, 0.047),
        bound: &[
            (0.227, 0.333, 0.162),
            (0.050, 0.312, 1.544),
            (0.166, 1.351, 1.808),
            (0.030, 3.382, 3.473),
        ],
        range: (62.0, 248_000.0),
    },
    Metal {
        name: "silver",
        plasma: 9.01,
        free: (0.845, 0.048),
        bound: &[
            (0.065, 3.886, 0.816),
            (0.124, 0.452, 4.481),
            (0.011, 0.065, 8.185),
            (0.840, 0.916, 9.083),
            (5.646, 2.419, 20.29),
        ],
        range: (248.0, 12_398.0),
    },
];

/// Returns the wavelength, nm, if it is given and lies in the range `from` to `to`, nm.
///
/// # Errors
///
/// Returns [`Error::Usage`] if no wavelength is given, or if it lies outside the range.
fn within(
    option: &'static str,
    text: &str,
    wavelength_nm: Option<f64>,
    (from, to): (f64, f64),
) -> Result<f64, Error> {
    match wavelength_nm {
        Some(nm) if (from..=to).contains(&nm) => Ok(nm),
        Some(nm) => Err(Error::Usage(format!(
            "{option} {text} is known from {from} to {to} nm, not at --wavelength-nm {nm}; give a \
            number instead"
        ))),
        None => Err(Error::Usage(format!(
            "{option} {text} depends on the wavelength; give the wavelength too, such as \
            --wavelength-nm 550"
        ))),
    }
}

fn finite(text: &str) -> Option<f64> {
    text.trim().parse::<f64>().ok().filter(|x| x.is_finite())
}

/// Reads a refractive index: a number, a name, or nm:index pairs.
///
/// Between two pairs the index is linear in the wavelength. A plain number is returned as it is;
/// [`crate::Plan::new`] checks its range.
///
/// # Errors
///
/// Returns [`Error::Usage`] if `text` is none of these, if a pair does not have a wavelength above 0
/// and an index from 1 to 10, if two pairs have the same wavelength, if a name or pairs are given
/// without a wavelength, or if the index is not known at the wavelength.
pub fn refractive_index(text: &str, wavelength_nm: Option<f64>) -> Result<f64, Error> {
    let option = "--refractive-index";
    if let Some(index) = finite(text) {
        return Ok(index);
    }
    let name = match text.trim() {
        "acrylic" => "pmma",
        other => other,
    };
    if let Some(glass) = GLASSES.iter().find(|glass| glass.name == name) {
        let micrometres = within(option, text, wavelength_nm, glass.range)? * 1e-3;
        let squared = micrometres * micrometres;
        let terms = glass.terms.iter().map(|(b, c)| b * squared / (squared - c));
        return Ok((1.0 + terms.sum::<f64>()).sqrt());
    }
    let wrong = || {
        let names = names(GLASSES.iter().map(|glass| glass.name));
        Error::Usage(format!(
            "--refractive-index {text}: give a number from 1 to 10, {names} or nm:index pairs such \
            as 450:1.50,650:1.49"
        ))
    };
    let pair = |part: &str| {
        let (nm, index) = part.split_once(':')?;
        let (nm, index) = (finite(nm)?, finite(index)?);
        (nm > 0.0 && (1.0..=LARGEST).contains(&index)).then_some((nm, index))
    };
    let pairs: Option<Vec<(f64, f64)>> = text.split(',').map(pair).collect();
    let mut pairs = pairs.ok_or_else(wrong)?;
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (Some(first), Some(last)) = (pairs.first(), pairs.last()) else {
        return Err(wrong());
    };
    if pairs.windows(2).any(|pair| pair[0].0 == pair[1].0) {
        return Err(wrong());
    }
    let nm = within(option, text, wavelength_nm, (first.0, last.0))?;
    let after = pairs.partition_point(|pair| pair.0 < nm);
    let (to, index) = pairs[after];
    let Some(&(from, before)) = after.checked_sub(1).and_then(|k| pairs.get(k)) else {
        return Ok(index);
    };
    let part = (nm - from) / (to - from);
    Ok(before + part * (index - before))
}

/// Reads the complex refractive index n + ik of a metal: a name or `N,K`.
///
/// # Errors
///
/// Returns [`Error::Usage`] if `text` is neither a known name nor two numbers with N above 0 and K at
/// least 0, both at most 1000, if a name is given without a wavelength, or if the index is not known
/// at the wavelength.
pub fn metal(text: &str, wavelength_nm: Option<f64>) -> Result<Complex64, Error> {
    let Some(metal) = METALS.iter().find(|metal| metal.name == text.trim()) else {
        let numbers: Option<Vec<f64>> = text.split(',').map(finite).collect();
        return match numbers.as_deref() {
            Some(&[n, k]) if n > 0.0 && k >= 0.0 && n <= 1e3 && k <= 1e3 => {
                Ok(Complex64::new(n, k))
            }
            _ => Err(Error::Usage(format!(
                "--metal {text}: give {} or the complex refractive index N,K, such as 0.96,6.7",
                names(METALS.iter().map(|metal| metal.name))
            ))),
        };
    };
    let energy = EV_NM / within("--metal", text, wavelength_nm, metal.range)?;
    let plasma = metal.plasma * metal.plasma;
    let (strength, damping) = metal.free;
    let mut permittivity =
        1.0 - strength * plasma / Complex64::new(energy * energy, energy * damping);
    for &(strength, damping, frequency) in metal.bound {
        let gap = frequency * frequency - energy * energy;
        permittivity += strength * plasma / Complex64::new(gap, -energy * damping);
    }
    // n + ik is the root in the first quadrant.
    let size = (permittivity.re * permittivity.re + permittivity.im * permittivity.im).sqrt();
    let k = ((size - permittivity.re) / 2.0).sqrt();
    Ok(Complex64::new(permittivity.im / (2.0 * k), k))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn index(text: &str, nm: f64) -> f64 {
        refractive_index(text, Some(nm)).unwrap()
    }

    /// Checks N-BK7 against n_d, n_F and n_C of the data sheet, and the polymers against what the
    /// formulas of the article give at their d line.
    #[test]
    fn glasses_are_those_of_the_sheets() {
        let cases = [
            ("bk7", 587.561_8, 1.516_80),
            ("bk7", 486.132_7, 1.522_38),
            ("bk7", 656.272_5, 1.514_32),
            ("pmma", 587.6, 1.4906),
            ("acrylic", 587.6, 1.4906),
            ("polycarbonate", 587.6, 1.5848),
        ];
        for (name, nm, expected) in cases {
            // Half of the last digit that is given.
            let digits = if name == "bk7" { 5e-6 } else { 5e-5 };
            assert!((index(name, nm) - expected).abs() <= digits, "{name} {nm}");
        }
    }

    /// Checks metals against five digits of the model's tables in the database
    /// refractiveindex.info, whose wavelengths have five digits too.
    #[test]
    fn metals_are_those_of_the_article() {
        let cases = [
            ("silver", 544.37, (0.133_81, 3.1276)),
            ("silver", 637.09, (0.144_32, 3.8404)),
            ("aluminium", 550.33, (0.967_08, 6.4617)),
            ("aluminium", 649.74, (1.4192, 7.4649)),
        ];
        let mut compared = 0;
        for (name, nm, (n, k)) in cases {
            let found = metal(name, Some(nm)).unwrap();
            // The slopes of n and k by the wavelength are at most 7 and 15 a micrometre. A
            // wavelength that is rounded to 1e-5 micrometres is off by half of that and moves n and
            // k by its slopes.
            assert!((found.re - n).abs() < 5e-5, "{name} {nm}: {found}");
            assert!((found.im - k).abs() < 15e-5, "{name} {nm}: {found}");
            compared += 1;
        }
        assert_eq!(compared, 4);
    }

    #[test]
    fn pairs_are_joined_by_straight_lines() {
        let pairs = "650:1.48,450:1.50, 550:1.49";
        for (nm, expected) in [(450.0, 1.50), (500.0, 1.495), (550.0, 1.49), (650.0, 1.48)] {
            assert!((index(pairs, nm) - expected).abs() < 1e-15);
        }
        assert_eq!(index("500:1.5", 500.0), 1.5);
        assert_eq!(refractive_index("1.49", None).ok(), Some(1.49));
        assert_eq!(
            metal("0.96,6.7", None).ok(),
            Some(Complex64::new(0.96, 6.7))
        );
    }

    #[test]
    fn what_is_unknown_is_said() {
        let glass = |text, nm| refractive_index(text, nm).unwrap_err().to_string();
        let cases = [
            (
                glass("glass", None),
                "--refractive-index glass: give a number from 1 to 10, pmma, polycarbonate, bk7 or",
            ),
            (glass("450:1.5,450:1.4", Some(450.0)), "give a number"),
            (glass("450:0.5", Some(450.0)), "give a number"),
            (
                glass("bk7", None),
                "bk7 depends on the wavelength; give the wavelength too",
            ),
            (
                glass("pmma", Some(300.0)),
                "pmma is known from 436.8 to 1052 nm, not at --wavelength-nm 300",
            ),
            (glass("450:1.5,550:1.4", Some(560.0)), "from 450 to 550 nm"),
            (
                metal("tin", None).unwrap_err().to_string(),
                "--metal tin: give aluminium, silver or",
            ),
            (
                metal("0,1", None).unwrap_err().to_string(),
                "--metal 0,1: give",
            ),
            (
                metal("silver", None).unwrap_err().to_string(),
                "--metal silver depends",
            ),
        ];
        for (said, expected) in &cases {
            assert!(said.contains(expected), "{said}");
        }
    }
}
