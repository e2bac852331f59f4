//! Campaigns with one planted mistake each: how often the verdict notices it, and whether the right
//! suspect is named first.

use serde::Serialize;
use tables::Table;

use crate::simulate::photograph;
use crate::simulate::{Params, PixelNoise};
use crate::study::trial::{campaign as manifest_of, source};
use edges::names::{Kernel, ParameterKind};
use edges::photographs::Campaign;
use estimator::Error;
use estimator::estimate::campaign::campaign;
use estimator::estimate::{Candidates, Estimated, Options, Progress, Value, Verdict};

/// Mistake that is planted in a campaign.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Mistake {
    /// None: how often a good campaign is called strained.
    None,
    /// Two incidences exchanged.
    Exchanged,
    /// Incidence of one photograph off by 2 to 30 degrees.
    Incidence,
    /// Tangential axis off by 90 degrees.
    Axis,
    /// Azimuth off by 10 to 50 degrees.
    Azimuth,
    /// Refractive index off: the sheet is hollow, or of another material.
    Index,
    /// A single cube in place of the pair.
    Cell,
    /// Exposure of one photograph off by 1 to 30 %.
    Exposure,
    /// Lobe that is not among the candidates.
    Lobe,
}

impl Mistake {
    /// All mistakes, in the order of their rows.
    pub(crate) const ALL: [Mistake; 9] = [
        Mistake::None,
        Mistake::Exchanged,
        Mistake::Incidence,
        Mistake::Axis,
        Mistake::Azimuth,
        Mistake::Index,
        Mistake::Cell,
        Mistake::Exposure,
        Mistake::Lobe,
    ];

    /// Returns the words for a table.
    pub const fn words(self) -> &'static str {
        match self {
            Mistake::None => "none",
            Mistake::Exchanged => "incidences exchanged",
            Mistake::Incidence => "one incidence",
            Mistake::Axis => "axis off by 90 deg",
            Mistake::Azimuth => "azimuth",
            Mistake::Index => "refractive index",
            Mistake::Cell => "cell",
            Mistake::Exposure => "one exposure",
            Mistake::Lobe => "lobe",
        }
    }

    /// Returns whether a suspect says this mistake.
    fn is_said_by(self, what: &str) -> bool {
        match self {
            Mistake::None => false,
            Mistake::Exchanged => what.starts_with("the incidences") && what.contains("exchanged"),
            Mistake::Incidence => what.starts_with("the incidence of"),
            Mistake::Axis => what.starts_with("the tangential axis"),
            Mistake::Azimuth => what.starts_with("the azimuth"),
            Mistake::Index => what.starts_with("the refractive index"),
            Mistake::Cell => what.starts_with("the table"),
            Mistake::Exposure => what.starts_with("the exposure"),
            Mistake::Lobe => what.contains("--lobe"),
        }
    }
}

/// Result of one campaign with a mistake.
#[derive(Debug, Clone, Serialize)]
pub struct Trial {
    /// Number of the campaign.
    pub index: u64,
    /// Mistake that was planted.
    pub mistake: Mistake,
    /// Largest error of c, a and mu that the mistake causes, in standard errors of the fit without
    /// it; infinite if a parameter is lost.
    pub effect: f64,
    /// Quality of the fit with the mistake; `None` if it was refused.
    pub verdict: Option<Verdict>,
    /// Suspects, the best first.
    pub suspects: Vec<String>,
    /// True if the first suspect is the mistake.
    pub first: bool,
}

impl Trial {
    /// Returns whether the mistake was noticed: by the verdict, by a refusal, or by a suspect.
    pub(crate) fn is_caught(&self) -> bool {
        self.verdict != Some(Verdict::Good) || !self.suspects.is_empty()
    }
}

/// Fits a campaign twice: as it is, and with the mistake whose turn it is. `other` is a table that
/// a user could give besides `table`.
///
/// # Errors
/// Fails if the campaign without the mistake has no estimate.
pub fn run(
    params: &Params,
    (seed, index): (u64, u64),
    table: &Table,
    options: &Options,
) -> Result<Trial, Error> {
    let mut draw = PixelNoise::new(seed, index, u64::MAX - 7);
    let count = Mistake::ALL.len() as u64;
    // Every second campaign is good.
    let mistake = match index % 2 {
        0 => Mistake::None,
        _ => Mistake::ALL[1 + ((index / 2) % (count - 1)) as usize],
    };
    let estimate = |params: &Params, manifest: &Campaign| {
        let photographs = source(params, photograph::saved);
        campaign(manifest, &photographs, table, options, &Progress::SILENT)
    };
    let right = estimate(params, &manifest_of(params, &[]))?;
    let wrong = (mistake != Mistake::None).then(|| {
        let (params, manifest) = planted(params, mistake, &mut draw);
        estimate(&params, &manifest).ok()
    });
    let shown = wrong.as_ref().map_or(Some(&right), Option::as_ref);
    let suspects = shown.map_or(Vec::new(), |shown| {
        let suspects = shown.suspects.iter();
        suspects.map(|own| own.what.clone()).collect()
    });
    Ok(Trial {
        index,
        mistake,
        effect: shown.map_or(f64::INFINITY, |shown| effect(&right, shown)),
        verdict: shown.map(|shown| shown.goodness.verdict),
        first: suspects
            .first()
            .is_some_and(|what| mistake.is_said_by(what)),
        suspects,
    })
}

/// Returns the largest change of c, a and mu between two estimates, in standard errors of the
/// first. A parameter that has one value for each angle counts at each of them.
fn effect(right: &Estimated, wrong: &Estimated) -> f64 {
    let wrong = &wrong.best;
    let at = |kind: ParameterKind, place: Option<f64>| -> Option<f64> {
        let mut all = wrong.parameters.iter().zip(wrong.values());
        let found = all.find(|(id, _)| {
            let same = id.at.zip(place).is_none_or(|(a, b)| a == b);
            id.kind == kind && same
        });
        found.map(|(_, value)| value.value)
    };
    let all = right.best.parameters.iter().zip(right.best.values());
    let changes = all.map(|(id, own): (_, &Value)| {
        at(id.kind, id.at).map_or(f64::INFINITY, |value| {
            (value - own.value).abs() / own.standard_error
        })
    });
    changes.fold(0.0, f64::max)
}

/// Plants a mistake: in the manifest, or in the sheet that is photographed.
fn planted(params: &Params, mistake: Mistake, draw: &mut PixelNoise) -> (Params, Campaign) {
    let mut params = params.clone();
    let mut between = |low: f64, high: f64| low + (high - low) * draw.uniform();
    let mut angles: Vec<f64> = params.captures.iter().map(|s| s.incidence_deg).collect();
    angles.sort_by(f64::total_cmp);
    angles.dedup();
    let one = (between(0.0, 1.0) * params.captures.len() as f64) as usize;
    let truth = &mut params.truth;
    match mistake {
        Mistake::Index => {
            truth.refractive_index = if between(0.0, 1.0) < 0.5 { 1.0 } else { 1.586 };
        }
        Mistake::Cell => truth.pair = !truth.pair,
        Mistake::Lobe => truth.lobe = truth.lobe.other(),
        _ => {}
    }
    let mut manifest = manifest_of(&params, &[]);
    let captures = &mut manifest.captures;
    match mistake {
        Mistake::Exchanged => {
            let (low, high) = (angles[0], angles[angles.len() - 1]);
            for capture in captures {
                let deg = &mut capture.incidence_deg;
                *deg = match *deg {
                    own if own == low => high,
                    own if own == high => low,
                    own => own,
                };
            }
        }
        Mistake::Incidence => {
            let own = captures[one].incidence_deg;
            let by = between(2.0, 30.0);
            // Incidences of a table go to 45 degrees.
            captures[one].incidence_deg = if own + by <= 45.0 { own + by } else { own - by };
        }
        Mistake::Axis => captures
            .iter_mut()
            .for_each(|c| c.tangential_axis_deg += 90.0),
        Mistake::Azimuth => {
            let by = between(10.0, 50.0);
            for capture in captures {
                capture.azimuth_deg = capture.azimuth_deg.map(|deg| deg + by);
            }
        }
        Mistake::Exposure => {
            let by = between(1.01_f64.ln(), 1.3_f64.ln()).exp();
            let up = between(0.0, 1.0) < 0.5;
            captures[one].shot.exposure *= if up { by } else { 1.0 / by };
        }
        Mistake::None | Mistake::Index | Mistake::Cell | Mistake::Lobe => {}
    }
    (params, manifest)
}

/// Returns the options of these fits: the default ones of `fit estimate`, with the kernel that the
/// campaigns are drawn with.
pub fn options() -> Options {
    Options::new(Candidates {
        kernels: vec![Kernel::Eq1],
        ..Candidates::proposed()
    })
}

/// Numbers of campaigns with one mistake.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// Mistake that was planted.
    pub mistake: Mistake,
    /// Number of campaigns.
    pub campaigns: usize,
    /// Campaigns with a strained fit.
    pub strained: usize,
    /// Campaigns with a poor fit.
    pub poor: usize,
    /// Campaigns without an estimate.
    pub refused: usize,
    /// Campaigns with a good fit and a suspect, because mu differs between the incidences.
    pub doubted: usize,
    /// Campaigns in which the first suspect is the mistake.
    pub first: usize,
}

/// Numbers of campaigns by the effect of their mistake.
#[derive(Debug, Clone, Serialize)]
pub struct Band {
    /// Range of the effect, standard errors.
    pub effect: [f64; 2],
    /// Number of campaigns.
    pub campaigns: usize,
    /// Campaigns whose mistake was noticed.
    pub caught: usize,
}

/// Ends of the bands of effects, standard errors.
const BANDS: [f64; 6] = [0.0, 1.0, 3.0, 10.0, 30.0, f64::INFINITY];

/// Returns one row for each mistake.
pub fn rows(trials: &[Trial]) -> Vec<Row> {
    let row = |mistake: Mistake| {
        let own: Vec<&Trial> = trials.iter().filter(|t| t.mistake == mistake).collect();
        let of = |verdict| own.iter().filter(|t| t.verdict == verdict).count();
        Row {
            mistake,
            campaigns: own.len(),
            strained: of(Some(Verdict::Strained)),
            poor: of(Some(Verdict::Poor)),
            refused: of(None),
            doubted: own
                .iter()
                .filter(|t| t.verdict == Some(Verdict::Good) && t.is_caught())
                .count(),
            first: own.iter().filter(|t| t.first).count(),
        }
    };
    Mistake::ALL.into_iter().map(row).collect()
}

/// Returns the campaigns with mistakes by their effect.
pub fn bands(trials: &[Trial]) -> Vec<Band> {
    let band = |ends: &[f64]| {
        let effect = [ends[0], ends[1]];
        let inside = |t: &&Trial| {
            t.mistake != Mistake::None
                && t.effect >= effect[0]
                && (t.effect < effect[1] || effect[1].is_infinite())
        };
        let own: Vec<&Trial> = trials.iter().filter(inside).collect();
        Band {
            effect,
            campaigns: own.len(),
            caught: own.iter().filter(|t| t.is_caught()).count(),
        }
    };
    BANDS.windows(2).map(band).collect()
}
