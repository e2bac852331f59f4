//! The options of a sheet without a fit.

use std::path::{Path, PathBuf};

use clap::ArgGroup;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use tables::Table;

use crate::cli::failure::Failure;
use crate::cli::options::parse;
use edges::names::{Kernel, Spectrum};
use edges::photographs::Setup;
use edges::photographs::manifest::captures;
use estimator::result::{ByHand, Nominal, ResultFile, Spread, TableResult};

/// Numbers of a sheet that nobody has fitted. They take the place of a result.
#[derive(Debug, Clone, clap::Args)]
#[command(
    next_help_heading = "Sheet without a fit",
    group = ArgGroup::new("own_sheet").args(["sheet", "c"])
)]
pub(crate) struct Numbers {
    /// Sheet whose numbers come from public sources, and from assumptions.
    ///
    /// It takes the place of a result. It brings a table of its cell, so that --table can be left
    /// out.
    #[arg(long, value_name = "NAME", value_parser = sheets())]
    pub sheet: Option<&'static Nominal>,
    /// Corner size c, mm: the edge of a cube from its apex.
    ///
    /// It takes the place of a result. Give what spreads the light too: --wavelength-nm, --a or
    /// --a-times-r.
    #[arg(long, value_name = "MM", value_parser = parse::positive, allow_negative_numbers = true)]
    pub c: Option<f64>,
    /// Kernel of these numbers: wave, eq1 or angular.
    ///
    /// It follows from the numbers. If it is named, it must be the one that follows.
    #[arg(
        long,
        value_name = "KERNEL",
        value_parser = kernel,
        requires = "c",
        conflicts_with = "sheet"
    )]
    pub kernel: Option<Kernel>,
    /// Wavelengths of the source, nm, with weights; diffraction follows from them and from c.
    ///
    /// Write 550, or 450:0.2,550:0.5,620:0.3. The table must be exact.
    #[arg(
        long,
        value_name = "NM[:WEIGHT],...",
        value_parser = Spectrum::parse,
        requires = "c",
        conflicts_with_all = ["a", "a_times_r", "sheet"]
    )]
    pub wavelength_nm: Option<Spectrum>,
    /// Diffraction spread a, 1/mm, the same at every distance.
    #[arg(
        long,
        value_name = "A",
        value_parser = parse::positive,
        allow_negative_numbers = true,
        requires = "c",
        conflicts_with_all = ["a_times_r", "sheet"]
    )]
    pub a: Option<f64>,
    /// Diffraction spread A = a R of a lobe of fixed angle.
    #[arg(
        long,
        value_name = "A",
        value_parser = parse::positive,
        allow_negative_numbers = true,
        requires = "c",
        conflicts_with = "sheet"
    )]
    pub a_times_r: Option<f64>,
    /// Angular spread of the returned light, mrad: standard deviation across the plane of incidence,
    /// outside of the sheet.
    ///
    /// It describes cubes whose dihedral angles differ from cell to cell: independent errors of e
    /// mrad spread the light by 2 e times the refractive index.
    #[arg(
        long,
        value_name = "MRAD",
        value_parser = parse::positive,
        allow_negative_numbers = true,
        requires = "own_sheet"
    )]
    pub angular_spread_mrad: Option<f64>,
    /// Reflectance mu of the sheet.
    ///
    /// Without it the luminance is not known, and an image has the brightness of its source. A
    /// --sheet has its own.
    #[arg(
        long,
        value_name = "MU",
        value_parser = parse::share,
        allow_negative_numbers = true,
        requires = "own_sheet"
    )]
    pub mu: Option<f64>,
    /// Transmittance times reflectance of the half mirror; 0.25 if left out.
    #[arg(
        long,
        value_name = "TR",
        value_parser = parse::share,
        allow_negative_numbers = true,
        requires = "own_sheet"
    )]
    pub half_mirror: Option<f64>,
    /// File whose table [setup] names half mirror, polarisers, film and light.
    ///
    /// A captures.toml is such a file. Its keys are half_mirror_transmittance,
    /// half_mirror_reflectance, polarisation, analyser, retarder, seen_in_mirror and the wavelengths
    /// of the light.
    #[arg(
        long,
        value_name = "SETUP.toml",
        conflicts_with = "half_mirror",
        requires = "own_sheet"
    )]
    pub setup: Option<PathBuf>,
}

/// Returns the parser of the names of nominal sheets.
pub(in crate::cli) fn sheets() -> impl TypedValueParser<Value = &'static Nominal> {
    let named = |sheet: &'static Nominal| PossibleValue::new(sheet.name).help(sheet.about);
    PossibleValuesParser::new(Nominal::all().iter().map(named))
        .try_map(|name| Nominal::named(&name).ok_or("no such sheet"))
}

fn kernel(text: &str) -> Result<Kernel, String> {
    let known = [Kernel::Wave, Kernel::Eq1, Kernel::Angular];
    let named = known.into_iter().find(|kernel| kernel.name() == text);
    named.ok_or_else(|| "use wave, eq1 or angular".into())
}

/// Light that passes a half mirror of 50 % and is reflected by it.
pub(in crate::cli) const HALF_MIRROR: f64 = 0.25;

impl Numbers {
    /// Reads the table of a file, or that of the nominal sheet where no file is named.
    ///
    /// # Errors
    /// Returns the errors of reading, and [`Failure::Usage`] without a file and a sheet.
    pub(in crate::cli) fn table(
        &self,
        verb: &'static str,
        file: Option<&Path>,
    ) -> Result<Table, Failure> {
        match (file, self.sheet) {
            (Some(file), _) => Ok(tables::read(file)?),
            (None, Some(sheet)) => Ok(sheet.table()?),
            (None, None) => {
                let message = "give the table of the sheet's cell: --table";
                Err(Failure::conflict(verb, message))
            }
        }
    }

    /// Returns the numbers as a result of this table.
    ///
    /// `pixel_pitch_mm` is that of images, mm.
    ///
    /// # Errors
    /// Returns [`Failure::Usage`] if there are no numbers, or if nothing says what spreads the
    /// light.
    pub(in crate::cli) fn result(
        &self,
        verb: &'static str,
        pixel_pitch_mm: f64,
        table: &Table,
    ) -> Result<ResultFile, Failure> {
        let setup = match &self.setup {
            Some(file) => Some(captures::setup_of(file).map_err(estimator::Error::from)?),
            None => None,
        };
        let own = setup.as_ref().map(|(setup, _)| setup);
        let mut result = self.unpolarised(verb, pixel_pitch_mm, table, own)?;
        if let Some((setup, warnings)) = setup {
            result.warnings.extend(warnings);
            if result.kernel.has_waves() && setup.spectrum.is_some() {
                result.wavelength_nm.clone_from(&setup.spectrum);
            }
            result.polarisation = setup.polarisation;
            result.seen_in_mirror = Some(setup.is_in_mirror());
            result.colours = setup.colours();
            result.stray = setup.stray;
        }
        Ok(result)
    }

    /// Returns the result without what the setup says of polarisation.
    fn unpolarised(
        &self,
        verb: &'static str,
        pixel_pitch_mm: f64,
        table: &Table,
        setup: Option<&Setup>,
    ) -> Result<ResultFile, Failure> {
        let half_mirror = match setup {
            Some(setup) => setup.half_mirror_transmittance * setup.half_mirror_reflectance,
            None => self.half_mirror.unwrap_or(HALF_MIRROR),
        };
        let given = setup.and_then(|setup| setup.spectrum.as_ref());
        let spectrum = self.wavelength_nm.as_ref().or(given);
        if let Some(sheet) = self.sheet {
            let own = TableResult::of(&sheet.table()?);
            let given = TableResult::of(table);
            if !own.same_cell(&given) {
                let message = format!(
                    "--sheet {} is a sheet of {}, and the table is of {} with another {}; leave \
                    --table out, or give the numbers of your sheet: --c with --wavelength-nm, --a \
                    or --a-times-r",
                    sheet.name,
                    own.design,
                    given.design,
                    own.difference(&given)
                );
                return Err(Failure::conflict(verb, message));
            }
            let mut result = sheet.result(own, self.mu, half_mirror, pixel_pitch_mm);
            result.spread_by_mrad(self.angular_spread_mrad);
            return Ok(result);
        }
        let Some(c_mm) = self.c else {
            let message = "give a result, a --sheet, or the numbers of a sheet: --c with \
                --wavelength-nm, --a or --a-times-r";
            return Err(Failure::conflict(verb, message));
        };
        let spread = match (spectrum, self.a, self.a_times_r) {
            (Some(spectrum), ..) => Spread::Wave(spectrum.clone()),
            (None, Some(a), _) => Spread::Lobe(a),
            (None, None, Some(a)) => Spread::Angle(a),
            (None, None, None) => {
                let message = "--c alone says nothing of diffraction; give --wavelength-nm (wave \
                    optics), --a or --a-times-r too";
                return Err(Failure::conflict(verb, message));
            }
        };
        let sheet = ByHand {
            c_mm,
            spread,
            angular_spread_mrad: self.angular_spread_mrad,
            mu: self.mu,
            half_mirror,
            pixel_pitch_mm,
        };
        let result = sheet.result(TableResult::of(table));
        match self.kernel {
            Some(kernel) if kernel != result.kernel => Err(Failure::conflict(
                verb,
                format!(
                    "--kernel {} does not follow from the numbers, which are those of {}; leave \
                    it out, or give wave a --wavelength-nm, eq1 an --a, angular an --a-times-r",
                    kernel.name(),
                    result.kernel.name()
                ),
            )),
            _ => Ok(result),
        }
    }
}

#[cfg(all(test, feature = "full"))]
mod tests {
    use crate::cli::calls;

    /// A setup without half mirror says so, as `fit estimate` does. A result that is read names the
    /// file and the key of a number that no camera has.
    #[test]
    fn a_setup_without_half_mirror_warns_and_an_impossible_camera_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("s.toml");
        let table = calls::table_of_sheet("prism-0.1").unwrap();
        let of = |keys: &str| {
            std::fs::write(&file, format!("[setup]\n{keys}")).unwrap();
            let words = ["--sheet", "prism-0.1", "--setup", file.to_str().unwrap()];
            calls::sheet(&words.map(Into::into), &table).unwrap()
        };
        let both = of("half_mirror_transmittance = 0.5\nhalf_mirror_reflectance = 0.5\n");
        let none = of("");
        assert_eq!((both.half_mirror, none.half_mirror), (0.25, 1.0));
        assert_eq!(none.warnings.len(), both.warnings.len() + 1);
        let said = none.warnings.last().unwrap();
        assert!(said.contains("what is missing counts as 1"), "{said}");

        // A damaged result is refused by the key. Before, covariances that do not match their names
        // were left out without a word.
        let file = folder.path().join("r.json");
        let read = |damage: &dyn Fn(&mut serde_json::Value)| {
            let mut own: serde_json::Value = serde_json::from_str(&calls::json(&both)).unwrap();
            damage(&mut own);
            std::fs::write(&file, own.to_string()).unwrap();
            calls::read(&file, None)
        };
        assert!(read(&|_| ()).is_ok());
        type Damage = fn(&mut serde_json::Value);
        let refused: [(Damage, &str); 6] = [
            (
                |own| own["camera"]["pixel_pitch_mm"] = (-0.1).into(),
                "`camera.pixel_pitch_mm` is -0.1 but must be greater than 0",
            ),
            (|own| own["c_mm"]["value"] = (-0.1).into(), "`c_mm` is -0.1"),
            (
                |own| own["covariance"]["matrix"] = serde_json::json!([[1.0]]),
                "matrix is not",
            ),
            (
                |own| {
                    own["covariance"] = serde_json::json!({"names": ["c_mm"], "matrix": [[-1.0]]});
                },
                "the variance of c_mm is -1",
            ),
            (
                |own| own["c_mm"] = serde_json::json!({"valu": 0.2}),
                "missing field",
            ),
            (
                |own| own["mu"] = serde_json::json!({"valu": 0.2}),
                "Parameter at line",
            ),
        ];
        for (damage, expected) in refused {
            let Err(failure) = read(&damage) else {
                panic!("{expected} is not said");
            };
            let said = failure.to_string();
            assert!(said.contains("r.json") && said.contains(expected), "{said}");
        }
    }
}
