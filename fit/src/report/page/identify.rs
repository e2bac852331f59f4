//! What the photographs can tell: profile likelihoods, and how c and the spread trade against each
//! other.

use std::fmt::Write;

use crate::names::{ParameterId, ParameterKind};
use crate::result::Parameter;

use crate::report::page::chart::{Axis, Panel, svg};
use crate::report::page::estimates::{INTERVAL, symbol};
use crate::report::page::evidence::LikelihoodProfile;
use crate::report::page::markup::minus;
use crate::report::page::markup::{significant, table};
use crate::report::page::shown::Page;

/// Rise of the sum of squares at the ends of a 95 % interval of one parameter (chi-square, 1 degree
/// of freedom).
const INTERVAL_RISE: f64 = 3.841;

/// Rise at a one-sided 95 % bound.
const BOUND_RISE: f64 = 2.706;

/// Rise at the border of a 95 % region of two parameters (2 degrees of freedom).
const REGION_RISE: f64 = 5.991;

/// Size of a figure and the place of its panel.
const SIZE: [f64; 2] = [360.0, 236.0];
const FRAME: [f64; 4] = [54.0, 10.0, 294.0, 184.0];

/// Profiles and ellipses.
pub(crate) fn section(page: &Page) -> String {
    let mut figures: String = page
        .evidence
        .profiles
        .iter()
        .map(|p| profile(page, p))
        .collect();
    let pairs = Pair::of(page);
    if !pairs.is_empty() {
        figures.push_str(&ellipses(&pairs));
    }
    let mut out = String::new();
    if page.result.bounds.is_empty() {
        out.push_str("<p>The photographs determine every parameter.</p>\n");
    } else {
        out.push_str(
            "<p>The photographs do not determine every parameter: what fades out of sight in one \
            direction comes back as a \
             bound. Where the curve stays low, any value fits.</p>\n",
        );
    }
    let _ = writeln!(out, "<div class=\"wide grid\">\n{figures}</div>");
    if !pairs.is_empty() {
        let rows: Vec<_> = pairs.iter().map(|pair| pair.row().into()).collect();
        let head = [
            "",
            "incidence",
            "error of c",
            "error of the spread",
            "correlation",
        ];
        out.push_str(&table("Errors and correlations", &head, &rows));
    }
    out
}

/// The symbol of a parameter, with its incidence where it has one.
fn symbol_at(id: ParameterId) -> (String, &'static str) {
    let (symbol, _, unit) = symbol(id.kind);
    let at = id
        .incidence_deg
        .map_or(String::new(), |angle| format!(" at {angle}\u{b0}"));
    (format!("{symbol}{at}"), unit)
}

fn profile(page: &Page, profile: &LikelihoodProfile) -> String {
    let points = &profile.points;
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return String::new();
    };
    let (symbol, unit) = symbol_at(profile.id);
    let axis = if profile.bounded {
        Axis::logarithmic(first[0], last[0])
    } else {
        Axis::linear(first[0], last[0])
    };
    let panel = Panel {
        x: axis,
        y: Axis::linear(0.0, 10.0),
        frame: FRAME,
    };
    let bound = page
        .result
        .bounds
        .get(&profile.id)
        .map(|b| [b.at_least, b.at_most]);
    let (rise, shade, caption) = match bound {
        Some([Some(least), Some(most)]) => (
            BOUND_RISE,
            Some([least, most]),
            format!(
                "{symbol} lies between {} and {}",
                significant(least, 3),
                significant(most, 3)
            ),
        ),
        Some([Some(least), _]) => (
            BOUND_RISE,
            Some([least, last[0]]),
            format!("{symbol} is larger than {}", significant(least, 3)),
        ),
        Some([_, Some(most)]) => (
            BOUND_RISE,
            Some([first[0], most]),
            format!("{symbol} is smaller than {}", significant(most, 3)),
        ),
        Some(_) => (BOUND_RISE, None, format!("{symbol} is not bounded")),
        None => (
            INTERVAL_RISE,
            interval(page, profile.id),
            format!("{symbol} and its 95 % interval (shaded)"),
        ),
    };
    let truth = page
        .truth
        .and_then(|t| t.of(profile.id))
        .filter(|t| (first[0]..=last[0]).contains(t));
    let name = if unit.is_empty() {
        symbol.clone()
    } else {
        format!("{symbol} ({unit})")
    };
    let body = [
        shade.map_or(String::new(), |[low, high]| {
            panel.shade("interval", [low, 0.0], [high, 10.0])
        }),
        panel.grid(5, true),
        panel.names(&name, "rise of \u{3c7}\u{b2}"),
        panel.level("limit", rise),
        truth.map_or(String::new(), |t| panel.upright("planted", t)),
        panel.line("model", points),
    ]
    .concat();
    let dotted = if truth.is_some() {
        "; the dotted line is the truth"
    } else {
        ""
    };
    format!(
        "<figure>{}<figcaption><b>{symbol}</b>: how much worse the best fit becomes with {symbol} \
        held elsewhere. {caption}; \
         the dashed line is the 95 % limit of pixel noise{dotted}.</figcaption></figure>\n",
        svg(SIZE, &format!("Profile likelihood: {caption}"), &body)
    )
}

/// The 95 % interval of the covariance, which carries the errors of lens and table too.
fn interval(page: &Page, id: ParameterId) -> Option<[f64; 2]> {
    let covariance = &page.result.covariance;
    let i = covariance.names.iter().position(|&own| own == id)?;
    let half = INTERVAL * covariance.matrix[i][i]?.sqrt();
    let value = value(page, id)?;
    Some([value - half, value + half])
}

/// An estimate of the blur.
fn value(page: &Page, id: ParameterId) -> Option<f64> {
    let result = page.result;
    let parameter = match id.kind {
        ParameterKind::CornerSize => return result.c_mm?.value,
        ParameterKind::APerMm => result.a_per_mm.as_ref()?,
        ParameterKind::ATimesR => result.a_times_r.as_ref()?,
        ParameterKind::Roughness => result.roughness.as_ref()?,
        ParameterKind::SurfaceRoughness => return result.surface_roughness?.value,
        ParameterKind::Mu | ParameterKind::Azimuth => return None,
    };
    match parameter {
        Parameter::Shared(number) => number.value,
        Parameter::PerAngle { per_angle } => {
            let at_angle = per_angle
                .iter()
                .find(|p| Some(p.incidence_deg) == id.incidence_deg);
            at_angle?.value
        }
    }
}

/// c and one spread: relative errors in %, their correlation, and where the truth lies.
struct Pair {
    symbol: String,
    incidence_deg: Option<f64>,
    error_c: f64,
    error_spread: f64,
    correlation: f64,
    truth: Option<[f64; 2]>,
}

impl Pair {
    fn of(page: &Page) -> Vec<Pair> {
        let covariance = &page.result.covariance;
        let size = ParameterKind::CornerSize.shared();
        let Some(c) = covariance.names.iter().position(|&own| own == size) else {
            return Vec::new();
        };
        let Some(c_mm) = value(page, size) else {
            return Vec::new();
        };
        let entries = covariance.names.iter().enumerate();
        entries
            .filter_map(|(i, &id)| {
                let spread = value(page, id).filter(|_| i != c)?;
                let of = |i: usize, j: usize| covariance.matrix[i][j];
                let (error_c, error_spread) = (of(c, c)?.sqrt(), of(i, i)?.sqrt());
                let planted = page
                    .truth
                    .and_then(|truth| Some([truth.of(size)?, truth.of(id)?]));
                Some(Pair {
                    symbol: symbol(id.kind).0.to_owned(),
                    incidence_deg: id.incidence_deg,
                    error_c: 100.0 * error_c / c_mm,
                    error_spread: 100.0 * error_spread / spread,
                    correlation: of(c, i)? / (error_c * error_spread),
                    truth: planted
                        .map(|[c, a]| [100.0 * (c / c_mm - 1.0), 100.0 * (a / spread - 1.0)]),
                })
            })
            .collect()
    }

    fn row(&self) -> Vec<String> {
        vec![
            format!("c and {}", self.symbol),
            self.incidence_deg
                .map_or("all".into(), |angle| format!("{angle}\u{b0}")),
            format!("{} %", significant(self.error_c, 2)),
            format!("{} %", significant(self.error_spread, 2)),
            minus(format!("{:+.2}", self.correlation)),
        ]
    }
}

/// All regions about the estimates, in per cent of them.
fn ellipses(pairs: &[Pair]) -> String {
    let scale = REGION_RISE.sqrt();
    let reach = |of: fn(&Pair) -> f64, axis: usize| {
        let truth = |p: &Pair| p.truth.map_or(0.0, |t| t[axis].abs());
        1.08 * pairs
            .iter()
            .map(|p| (scale * of(p)).max(truth(p)))
            .fold(0.0, f64::max)
    };
    let (x, y) = (reach(|p| p.error_c, 0), reach(|p| p.error_spread, 1));
    let panel = Panel {
        x: Axis::linear(-x, x),
        y: Axis::linear(-y, y),
        frame: FRAME,
    };
    let last = (pairs.len().max(2) - 1) as f64;
    // Blue for steep incidence over violet to red for grazing: one lightness, told apart on white
    // and on black.
    let colour = |i: usize| format!("hsl({:.0} 68% 54%)", 210.0 + 160.0 * i as f64 / last);
    let mut body = panel.grid(5, true);
    let spread = &pairs[0].symbol;
    body.push_str(&panel.names("change of c (%)", &format!("change of {spread} (%)")));
    for (i, pair) in pairs.iter().enumerate() {
        let r = pair.correlation.clamp(-1.0, 1.0);
        let half = scale * pair.error_spread;
        let map = [scale * pair.error_c, r * half, (1.0 - r * r).sqrt() * half];
        let style = format!("stroke:{}", colour(i));
        body.push_str(&panel.ellipse(&style, map));
        if let Some(truth) = pair.truth {
            let dot = panel.dots("planted-here", &[truth]);
            body.push_str(&format!("<g style=\"{style}\">{dot}</g>"));
        }
    }
    body.push_str(&panel.level("origin", 0.0));
    body.push_str(&panel.upright("origin", 0.0));
    let keys: String = pairs
        .iter()
        .enumerate()
        .filter_map(|(i, p)| {
            Some(format!(
                "<span class=\"key\" style=\"color:{}\">{}\u{b0}</span> ",
                colour(i),
                p.incidence_deg?
            ))
        })
        .collect();
    let dots = if pairs.iter().any(|p| p.truth.is_some()) {
        " Dots are the truth."
    } else {
        ""
    };
    format!(
        "<figure>{}<figcaption><b>c and {spread}</b>: 95 % region of the two together, about the \
        estimate. A long slanted \
         ellipse means that one can be traded for the other.{dots} {keys}</figcaption></figure>\n",
        svg(
            SIZE,
            &format!(
                "95 % regions of c and {spread}; errors and correlations are in the table below"
            ),
            &body
        )
    )
}
