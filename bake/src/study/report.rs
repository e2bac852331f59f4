//! Reports of a study: text for a person, CSV and JSON for a script.

use crate::study::fit::Reached;
use crate::study::study::{Reference, Series, Study, StudyPoint, name};
use serde_json::{Value, json};
use std::fmt::Write;
use tables::options::Sampler;

/// Returns the exponent of the L1 error against rays that theory predicts for a sampler.
///
/// Random counts have the exponent -1/2. In a scrambled net of N points in d dimensions, only the
/// N^(1 - 1/d) elementary boxes that the outline of a bin crosses contribute to the error. Each
/// contributes an independent error of order 1/N, so the sum is of order N^(-1/2 - 1/(2 d)). The
/// entrance has two dimensions. In a mean over azimuths, the azimuth is a third one.
pub(crate) fn expected_exponent(sampler: Sampler, azimuth_mean: bool) -> f64 {
    match (sampler, azimuth_mean) {
        (Sampler::Random, _) => -1.0 / 2.0,
        (Sampler::Sobol, false) => -3.0 / 4.0,
        (Sampler::Sobol, true) => -2.0 / 3.0,
    }
}

/// Returns the report as text: errors and times, slopes, and the times to the target.
pub(crate) fn text(study: &Study) -> String {
    let mut text = String::new();
    let threads = study.threads.map_or("all processors".into(), |threads| {
        format!("{threads} threads")
    });
    // Writing to a String cannot fail.
    let _ = writeln!(
        text,
        "{}: {} directions ({} as programs), {} x {} bins, {threads}; {} repeats: median seconds, \
        mean errors",
        study.design, study.directions, study.programs, study.bins, study.bins, study.repeats
    );
    let _ = writeln!(
        text,
        "L1 error per launched ray, against {}",
        against(&study.reference)
    );
    text.push_str(
        "\nmethod  tracer      sampler  rays/direction     seconds   L1 mean  L1 worst  \
        estimated  true/est.\n",
    );
    if let Reference::Exact { seconds } = study.reference {
        let _ = writeln!(
            text,
            "exact   beams       none                  0  \
            {seconds:10.5}         0         0          0          -"
        );
    }
    for series in &study.series {
        for point in &series.points {
            let _ = writeln!(
                text,
                "rays    {:10}  {:7}  {:14}  {:10.5}  {:8.2e}  {:8.2e}  {:9.2e}  {:9.3}",
                name(series.tracer),
                series.sampler.name(),
                point.rays,
                point.seconds,
                point.l1,
                point.worst_l1,
                point.estimated_l1,
                point.ratio()
            );
        }
    }
    text.push_str(
        "\nslope of the mean L1 against rays (of points with 4 rays per bin and randomisation or \
        more)\n",
    );
    for series in &study.series {
        let _ = writeln!(
            text,
            "  {:26} {}, expected {:.3}",
            title(series),
            slope_text(series),
            expected_exponent(series.sampler, study.azimuth_mean)
        );
    }
    text.push_str(&seconds_text(study));
    text
}

/// Returns the seconds that each method, tracer and sampler takes to reach the target error.
fn seconds_text(study: &Study) -> String {
    let mut text = format!(
        "\nseconds to L1 = {} in the worst direction\n",
        study.target
    );
    let exact = match study.reference {
        Reference::Exact { seconds } => {
            let _ = writeln!(text, "  {:26} {seconds:.5}", "exact");
            Some(seconds)
        }
        Reference::Sobol { .. } => None,
    };
    for series in &study.series {
        let time = match series.reached {
            Reached::At(seconds) => format!("{seconds:.5}"),
            Reached::Within(seconds) => format!("at most {seconds:.5}"),
            Reached::Never => "not reached; give more --rays".into(),
        };
        let times = match (exact, series.reached) {
            (Some(exact), Reached::At(seconds)) => {
                format!(", {:.0} times the exact method's", seconds / exact)
            }
            _ => String::new(),
        };
        let _ = writeln!(text, "  {:26} {time}{times}", title(series));
    }
    text
}

/// Returns the title of a series, such as "rays, program, sobol".
pub(crate) fn title(series: &Series) -> String {
    format!("rays, {}, {}", name(series.tracer), series.sampler.name())
}

/// Returns the fitted exponent as text, such as "-0.752 +- 0.004".
pub(crate) fn slope_text(series: &Series) -> String {
    match series.slope {
        None => "not fitted".into(),
        Some(slope) => match slope.standard_error {
            Some(error) => format!("{:.3} +- {error:.3}", slope.exponent),
            None => format!("{:.3}", slope.exponent),
        },
    }
}

/// Describes the reference, as the end of a sentence "L1 error against ...".
pub(crate) fn against(reference: &Reference) -> String {
    match reference {
        Reference::Exact { .. } => "the exact table".into(),
        Reference::Sobol {
            rays,
            estimated_l1,
            refusal,
        } => format!(
            "a Sobol table of {rays} rays per direction, whose own error is about \
            {estimated_l1:.1e} ({refusal})"
        ),
    }
}

/// Returns the measurements as CSV: one line for each point, with the exact method first.
pub(crate) fn csv(study: &Study) -> String {
    let mut csv = String::from(
        "method,tracer,sampler,rays_per_direction,seconds,l1_mean,l1_worst,l1_estimated_mean,\
        l1_estimated_worst\n",
    );
    if let Reference::Exact { seconds } = study.reference {
        let _ = writeln!(csv, "exact,beams,none,0,{seconds},0,0,0,0");
    }
    for series in &study.series {
        for point in &series.points {
            let _ = writeln!(
                csv,
                "rays,{},{},{},{},{},{},{},{}",
                name(series.tracer),
                series.sampler.name(),
                point.rays,
                point.seconds,
                point.l1,
                point.worst_l1,
                point.estimated_l1,
                point.worst_estimated_l1
            );
        }
    }
    csv
}

/// Returns the study as one line of JSON.
pub(crate) fn json(study: &Study) -> String {
    let reference = match &study.reference {
        Reference::Exact { seconds } => json!({ "method": "exact", "seconds": seconds }),
        Reference::Sobol {
            rays,
            estimated_l1,
            refusal,
        } => json!({
            "method": "rays", "sampler": "sobol", "rays": rays, "estimated_l1": estimated_l1,
            "reason": refusal,
        }),
    };
    let point = |point: &StudyPoint| {
        json!({
            "rays": point.rays, "seconds": point.seconds,
            "l1": point.l1, "worst_l1": point.worst_l1,
            "estimated_l1": point.estimated_l1, "worst_estimated_l1": point.worst_estimated_l1,
            "true_over_estimated": point.ratio(), "rays_per_bin": point.rays_per_bin,
        })
    };
    let series = |series: &Series| {
        json!({
            "method": "rays",
            "tracer": name(series.tracer),
            "sampler": series.sampler.name(),
            "points": series.points.iter().map(point).collect::<Vec<Value>>(),
            "slope": series.slope.map(|slope| json!({
                "exponent": slope.exponent, "standard_error": slope.standard_error,
                "rays": slope.range,
                "expected": expected_exponent(series.sampler, study.azimuth_mean),
            })),
            "seconds_to_target": series.reached.seconds(),
            "is_upper_bound": matches!(series.reached, Reached::Within(_)),
        })
    };
    let value = json!({
        "design": study.design,
        "directions": study.directions,
        "programs": study.programs,
        "bins": study.bins,
        "threads": study.threads,
        "repeats": study.repeats,
        "target": study.target,
        "reference": reference,
        "series": study.series.iter().map(series).collect::<Vec<Value>>(),
    });
    format!("{value}\n")
}
