//! Measurement of one photograph: its edge is found, and disturbances are repaired or refused.
//!
//! A repair is made only if its cause is seen, and it is a warning. A veil (light that reaches both
//! sides alike) needs no repair, because both plateaus are free in all later steps.

use crate::photographs::edge;
use crate::photographs::edge::curve::Waves;
use crate::photographs::edge::fault::Accepted;
use crate::photographs::edge::fault::Fault;
use crate::photographs::edge::lattice::Lattice;
use crate::photographs::edge::line::EdgeLine;
use crate::photographs::edge::shape;
use crate::photographs::illumination;
use crate::photographs::illumination::Light;
use crate::photographs::manifest::roi::Roi;
use crate::photographs::photo::plane::Photo;
use crate::photographs::pixels::{correlation, defects, processing, saturation};
use crate::photographs::profile::Profile;
use crate::photographs::window::Window;
use crate::photographs::{band, chart};

/// Largest share of a window's pixels that may be off the edge's profile. More of them are no
/// defects of a sensor.
const MOST_OFF: f64 = 0.01;

/// Unevenness of the light above which a polynomial no longer describes it.
const MOST_UNEVEN: f64 = 4.0;

/// Unevenness of the light above which a polynomial does not describe it well enough to even out a
/// profile.
const MOST_EVENED: f64 = 1.0;

/// Largest number of rounds of repair. Each round finds the edge again in the repaired window. Even
/// light needs two rounds, light that varies by a factor of 3 needs four.
const ROUNDS: usize = 6;

/// A measured edge.
#[derive(Debug, Clone)]
pub struct Measurement {
    /// Region of the photograph that the window covers: the region that was given or found, the
    /// whole photograph, or a band of them about the edge.
    pub region: Roi,
    /// The pixels of the region, repaired.
    pub window: Window,
    /// Pixels of the region in the light that the camera saw: uneven light is not evened out.
    pub as_lit: Window,
    /// The edge, in the window's coordinates.
    pub line: EdgeLine,
    /// The profile of the edge: its pixels, sorted into bins.
    pub profile: Profile,
    /// Ratio of the largest to the smallest light that was evened out, less 1.
    pub unevenness: f64,
    /// Number of times, as a variance, that the noise on the edge exceeds that beside it, if the
    /// camera reduced the latter.
    pub reduced_noise: Option<f64>,
    /// Warnings about what was assumed, was repaired or is doubtful, one sentence each. Those of
    /// the photograph come first.
    pub warnings: Vec<String>,
}

/// Measures the edge in a region of a photograph, or, without a region, its only edge.
///
/// Of a large region a band about its edge is measured.
///
/// Without a region the whole photograph is used if it holds nothing but the edge. If it holds
/// other marks too, the region of its only slanted edge is used. A fault in `accepted` becomes a
/// warning.
///
/// # Errors
/// Fails if there is no edge, if there are several, or if something would make the result wrong,
/// such as clipped pixels, uneven light or a wavy or doubled edge.
pub fn edge(photo: &Photo, roi: Option<Roi>, accepted: &[Accepted]) -> Result<Measurement, Fault> {
    let region = |photo, roi| region(photo, roi, accepted);
    if roi.is_some() {
        return region(photo, roi);
    }
    let fault = match region(photo, None) {
        Ok(measurement) => return Ok(measurement),
        Err(fault) => fault,
    };
    let candidates = chart::regions(photo);
    let marks = candidates.len();
    let mut edges: Vec<(Roi, Measurement)> = Vec::new();
    for roi in candidates {
        let Ok(measurement) = region(photo, Some(chart::middle(&roi))) else {
            continue;
        };
        let new = |(other, found): &(Roi, Measurement)| {
            !chart::one_line((other, &found.line), (&roi, &measurement.line))
        };
        if measurement.line.is_slanted() && edges.iter().all(new) {
            edges.push((roi, measurement));
        }
    }
    if edges.len() > 1 {
        let rois = edges.into_iter().map(|(roi, _)| roi);
        return Err(Fault::Choice(rois.collect()));
    }
    match (edges.pop(), fault) {
        (Some((roi, _)), fault) => {
            let mut measurement = region(photo, Some(roi))?;
            measurement.warnings.push(format!(
                "the edge was found among other marks; give {roi} to choose it yourself (only this \
                part counts, and mu is that at its middle; the whole photograph was refused: \
                {fault})"
            ));
            Ok(measurement)
        }
        (None, Fault::SeveralEdges { .. } | Fault::NotAlone { .. }) if marks > 1 => {
            Err(Fault::NoSlantedEdge(marks))
        }
        (None, fault) => Err(fault),
    }
}

/// Measures the one edge of a region, or of the whole photograph.
fn region(photo: &Photo, roi: Option<Roi>, accepted: &[Accepted]) -> Result<Measurement, Fault> {
    let mut warnings = photo.warnings.clone();
    let region = roi.unwrap_or(Roi {
        x: 0,
        y: 0,
        width: photo.width,
        height: photo.height,
    });
    let band = band::about_the_edge(photo, region);
    if let Some(band) = band {
        warnings.push(format!(
            "the region is large, and only {band} was measured, a band about the edge; give another \
            roi to choose yourself"
        ));
    }
    let region = band.unwrap_or(region);
    let Roi {
        x,
        y,
        width,
        height,
    } = region;
    let mut window = Window::of(photo, Some([x, y, width, height])).ok_or(Fault::TooSmall)?;
    warnings.extend(saturation::check(photo, &window)?);
    let gross = defects::exclude_gross(&mut window);
    if let Some(level) = photo.clip_level.filter(|_| photo.clips_alone)
        && window.extremes().1 >= f64::from(level)
    {
        window.set_ceiling(f64::from(level));
    }
    let mut repaired = repaired(window, gross)?;
    // Noise that neighbours share is seen only where the light is even. Once it is known, curve and
    // light are judged by it.
    let excess = correlation::excess(&repaired.window, &repaired.line, &repaired.profile);
    if excess > 1.0 {
        if repaired.is_even() && repaired.line.bend.is_none() {
            // Neither was found by the smaller errors, so neither will be found by the larger ones.
            repaired.count_noise(excess)?;
        } else {
            let mut window = repaired.as_lit;
            window.set_excess(excess);
            repaired = self::repaired(window, gross)?;
        }
        warnings.push(format!(
            "the noise of neighbouring pixels is correlated (demosaicing, smoothing or JPEG): it \
            counts {excess:.1} times, as a variance, in all standard errors"
        ));
    }
    warnings.extend(repaired.warnings());
    let Repaired {
        window,
        as_lit,
        line,
        profile,
        unevenness,
        waves,
        ..
    } = repaired;
    warnings.extend(shape::check(&profile, waves, accepted)?);
    warnings.extend(profile.warnings(&line));
    let rise_px = shape::rise_px(&profile).unwrap_or(0.0);
    let reduced_noise = processing::excess_on_edge(&window, &line, &profile, rise_px);
    let overshoot = processing::overshoot(&profile, rise_px);
    warnings.extend(processed(reduced_noise, overshoot));
    Ok(Measurement {
        region,
        as_lit: as_lit.without_those_of(&window),
        window,
        line,
        profile,
        unevenness,
        reduced_noise,
        warnings,
    })
}

/// Returns warnings about a camera that changed the edge.
fn processed(
    reduced_noise: Option<f64>,
    overshoot: Option<[f64; 2]>,
) -> impl Iterator<Item = String> {
    let reduced = reduced_noise.map(|ratio| {
        format!(
            "the noise beside the edge is {:.1} times smaller than that on the edge (noise \
            reduction, or JPEG that discards it): such a camera changes the edge too; switch noise \
            reduction off, and save raw or 16 bits",
            ratio.sqrt()
        )
    });
    let sharpened = overshoot.map(|[dark, bright]| {
        format!(
            "the light overshoots beside the edge (by {:.1} % of the step on the bright side, {:.1} \
            % on the dark one), which no lens does: the camera sharpened the photograph; switch \
            sharpening off, and save raw or 16 bits",
            100.0 * bright,
            100.0 * dark
        )
    });
    reduced.into_iter().chain(sharpened)
}

impl Measurement {
    /// Checks that the profile can be used by itself. The pixels can be used in light that is more
    /// uneven.
    ///
    /// # Errors
    /// Fails if the light was too uneven to be evened out.
    pub fn even_enough(&self) -> Result<(), Fault> {
        let unevenness = self.unevenness;
        if unevenness > MOST_EVENED {
            return Err(Fault::Uneven(unevenness));
        }
        Ok(())
    }
}

/// A window without defects, in even light, and its edge.
struct Repaired {
    window: Window,
    /// The window before uneven light was evened out.
    as_lit: Window,
    line: EdgeLine,
    profile: Profile,
    /// Ratio of the largest to the smallest light that was evened out, less 1.
    unevenness: f64,
    /// Waves of the edge about its curve.
    waves: Waves,
    /// Patterns of the pixel grid.
    lattice: Option<Lattice>,
    /// Number of pixels that were left out, and of all pixels.
    off: usize,
    pixels: usize,
}

/// Leaves defects out and evens the light out, until neither is found any more. `off` pixels are
/// left out already.
fn repaired(mut window: Window, mut off: usize) -> Result<Repaired, Fault> {
    let pixels = window.pixels().count() + off;
    let as_lit = window.clone();
    let mut so_far: Option<Light> = None;
    let (mut line, mut profile) = edge::straight(&window)?;
    let (mut waves, mut lattice) = (Waves::default(), None);
    for round in 0..ROUNDS {
        let light = illumination::find(&window, &line, &profile, so_far.as_ref());
        if let Some(light) = light {
            let unevenness = light.unevenness(&window);
            if unevenness > MOST_UNEVEN {
                return Err(Fault::Uneven(unevenness));
            }
            let before = so_far.replace(light).unwrap_or(Light::even(&window));
            window.change(|pixel| pixel.value * before.at(pixel) / light.at(pixel));
        }
        if light.is_some() {
            (line, profile) = edge::refine(&window, line)?;
        } else if round == 0 {
            (line, profile) = edge::bend(&window, line, profile)?;
        }
        // Light that is left looks like defects and waves.
        if light.is_some() && round + 1 < ROUNDS {
            continue;
        }
        waves = shape::waves(&window, &line, &profile);
        // Shifted rows look like defects along the edge.
        let found = shape::lattice(&window, &line, &profile);
        found.check()?;
        lattice = Some(found);
        let astray_px = waves.most_px + found.most_px();
        let taken_out = defects::exclude(&mut window, &line, &profile, astray_px);
        if taken_out > 0 {
            off += taken_out;
            (line, profile) = edge::refine(&window, line)?;
            waves = shape::waves(&window, &line, &profile);
        }
        let share = off as f64 / pixels as f64;
        if share > MOST_OFF {
            return Err(Fault::NotAlone(share));
        }
        // The first round has looked for the light of a straight edge.
        let was_bent = round == 0 && line.bend.is_some();
        if light.is_none() && taken_out == 0 && !was_bent {
            break;
        }
    }
    if let Some(light) = &so_far {
        profile.light = illumination::noise(&window, &line, &profile, light);
    }
    let unevenness = so_far.map_or(0.0, |light| light.unevenness(&window));
    Ok(Repaired {
        window,
        as_lit,
        line,
        profile,
        unevenness,
        waves,
        lattice,
        off,
        pixels,
    })
}

impl Repaired {
    /// Returns whether the light was even.
    fn is_even(&self) -> bool {
        self.unevenness == 0.0
    }

    /// Counts the noise of means `excess` times, as a variance.
    fn count_noise(&mut self, excess: f64) -> Result<(), Fault> {
        self.window.set_excess(excess);
        self.as_lit.set_excess(excess);
        self.line.normal_standard_error_rad *= excess.sqrt();
        self.profile = Profile::new(&self.window, &self.line).ok_or(Fault::TooSmall)?;
        self.waves = shape::waves(&self.window, &self.line, &self.profile);
        Ok(())
    }

    /// Returns warnings about what was repaired.
    fn warnings(&self) -> Vec<String> {
        let Repaired { off, pixels, .. } = self;
        let defects = (*off > 0).then(|| {
            format!(
                "{off} hot, dead or dirty pixels ({:.3} %) were left out",
                100.0 * *off as f64 / *pixels as f64
            )
        });
        let light = (!self.is_even()).then(|| {
            format!(
                "the light varies by {:.1} % over the window (vignetting or an uneven source), \
                which was corrected for MTFs; their standard errors include the correction; the \
                loss edge estimates the light itself",
                100.0 * self.unevenness
            )
        });
        defects
            .into_iter()
            .chain(light)
            .chain(self.lattice.iter().flat_map(Lattice::warnings))
            .collect()
    }
}
