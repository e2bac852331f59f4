//! Section of the page on how sure the estimates are: profile likelihoods, and how errors of c and
//! of the spread go together.

use std::fmt::Write;

use edges::names::{ParameterId, ParameterKind};
use estimator::result::Parameter;

use crate::report::page::estimates::{INTERVAL, symbol};
use crate::report::page::evidence::LikelihoodProfile;
use charts::{Axis, Panel, minus, svg};

use crate::report::page::markup::{significant, table};
use crate::report::page::shown::Page;

/// Rise of the sum of squares at the ends of a 95 % interval of one parameter (chi-square with 1
/// degree of freedom).
const INTERVAL_RISE: f64 = 3.841;

/// Rise of the sum of squares at a one-sided 95 % bound of one parameter.
const BOUND_RISE: f64 = 2.706;

/// Rise of the sum of squares at the border of a 95 % region of two parameters (2 degrees of
/// freedom).
const REGION_RISE: f64 = 5.991;

/// Width and height of a figure, in the figure's own units.
const SIZE: [f64; 2] = [360.0, 236.0];

/// Left, top, width and height of the panel in a figure, in the figure's own units.
const FRAME: [f64; 4] = [54.0, 10.0, 294.0, 184.0];

/// Writes profile likelihoods, ellipses, and a table of errors and correlations.
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
    // An angular spread may be hidden in any photographs.
    let bounded = page.result.bounds.keys();
    let mut hidden = bounded.filter(|id| id.kind != ParameterKind::AngularSpread);
    if hidden.next().is_none() {
        out.push_str("<p>The photographs determine every parameter.");
    } else {
        out.push_str(
            "<p>The photographs do not determine every parameter. If the effect of a parameter is \
             too small to be seen, the parameter has a bound in place of a value.",
        );
    }
    if !page.evidence.profiles.is_empty() {
        out.push_str(
            " Each curve shows how much \u{3c7}\u{b2} rises if one parameter is held at another \
             value and all others are fitted again. A narrow valley means a sure estimate. Where \
             the curve stays below the dashed line, the value agrees with the photographs.",
        );
    }
    out.push_str("</p>\n");
    let _ = writeln!(out, "<div class=\"wide grid\">\n{figures}</div>");
    if !pairs.is_empty() {
        let rows: Vec<_> = pairs.iter().map(|pair| pair.row().into()).collect();
        let spread = format!("standard error of {}", pairs[0].symbol);
        let head = [
            "",
            "incidence",
            "standard error of c",
            spread.as_str(),
            "correlation",
        ];
        out.push_str(&table("Errors and correlations", &head, &rows));
        out.push_str(
            "<p>The correlation says whether the errors of two parameters go together: 0 means \
             not at all, +1 and \u{2212}1 mean fully.</p>\n",
        );
    }
    out
}

/// Returns the symbol of a parameter, with its incidence if it has one, and its unit.
fn symbol_at(id: ParameterId) -> (String, &'static str) {
    let (symbol, _, unit) = symbol(id.kind);
    let at = id.place();
    let at = at.map_or(String::new(), |place| format!(" at {place}"));
    (format!("{symbol}{at}"), unit)
}

/// Draws the profile likelihood of one parameter.
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
                "{symbol} lies between {} and {} (shaded)",
                significant(least, 3),
                significant(most, 3)
            ),
        ),
        Some([Some(least), _]) => (
            BOUND_RISE,
            Some([least, last[0]]),
            format!("{symbol} is larger than {} (shaded)", significant(least, 3)),
        ),
        Some([_, Some(most)]) => (
            BOUND_RISE,
            Some([first[0], most]),
            format!("{symbol} is smaller than {} (shaded)", significant(most, 3)),
        ),
        Some(_) => (BOUND_RISE, None, format!("{symbol} is not bounded")),
        None => (
            INTERVAL_RISE,
            interval(page, profile.id),
            format!("The 95 % interval of {symbol} is shaded"),
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
        " The dotted line is the truth."
    } else {
        ""
    };
    format!(
        "<figure>{}<figcaption><b>{symbol}</b>: rise of \u{3c7}\u{b2} if {symbol} is held at \
         another value. {caption}. The dashed line is the 95 % limit of pixel \
         noise.{dotted}</figcaption></figure>\n",
        svg(SIZE, &format!("Rise of chi-square. {caption}"), &body)
    )
}

/// Returns the 95 % interval of a parameter from the covariance.
///
/// The covariance includes the errors of lens and table.
fn interval(page: &Page, id: ParameterId) -> Option<[f64; 2]> {
    let covariance = &page.result.covariance;
    let i = covariance.names.iter().position(|&own| own == id)?;
    let half = INTERVAL * covariance.matrix[i][i]?.sqrt();
    let value = value(page, id)?;
    Some([value - half, value + half])
}

/// Returns the estimate of a parameter of the blur.
fn value(page: &Page, id: ParameterId) -> Option<f64> {
    let result = page.result;
    let parameter = match id.kind {
        ParameterKind::CornerSize => return result.c_mm?.value,
        ParameterKind::APerMm => result.a_per_mm.as_ref()?,
        ParameterKind::ATimesR => result.a_times_r.as_ref()?,
        ParameterKind::Roughness => result.roughness.as_ref()?,
        ParameterKind::SurfaceRoughness => return result.surface_roughness?.value,
        ParameterKind::OwnBlur
        | ParameterKind::AngularSpread
        | ParameterKind::DihedralError1
        | ParameterKind::DihedralError2
        | ParameterKind::DihedralError3
        | ParameterKind::Mu
        | ParameterKind::Azimuth => return None,
    };
    match parameter {
        Parameter::Shared(number) => number.value,
        Parameter::PerAngle { per_angle } => {
            let at_angle = per_angle.iter().find(|p| Some(p.incidence_deg) == id.at);
            at_angle?.value
        }
    }
}

/// c and one spread: relative errors in %, their correlation, and the place of the truth.
struct Pair {
    symbol: String,
    incidence_deg: Option<f64>,
    error_c: f64,
    error_spread: f64,
    correlation: f64,
    truth: Option<[f64; 2]>,
}

impl Pair {
    /// Collects c with every spread of the result.
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
                    incidence_deg: id.at,
                    error_c: 100.0 * error_c / c_mm,
                    error_spread: 100.0 * error_spread / spread,
                    correlation: of(c, i)? / (error_c * error_spread),
                    truth: planted
                        .map(|[c, a]| [100.0 * (c / c_mm - 1.0), 100.0 * (a / spread - 1.0)]),
                })
            })
            .collect()
    }

    /// Writes the row of the pair in the table.
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

/// Draws the 95 % regions of all pairs around the estimates, in per cent of the estimates.
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
    // From blue for a small incidence over violet to red for a large one. All have one lightness,
    // so they can be told apart on white and on black.
    let colour = |i: usize| format!("hsl({:.0} 68% 54%)", 210.0 + 160.0 * i as f64 / last);
    let mut body = panel.grid(5, true);
    let spread = &pairs[0].symbol;
    body.push_str(&panel.names("change of c (%)", &format!("change of {spread} (%)")));
    for (i, pair) in pairs.iter().enumerate() {
        let r = pair.correlation.clamp(-1.0, 1.0);
        let half = scale * pair.error_spread;
        let map = [scale * pair.error_c, r * half, (1.0 - r * r).sqrt() * half];
        body.push_str(&panel.ellipse(&colour(i), map));
        if let Some(truth) = pair.truth {
            let dot = panel.dots("planted-here", &[truth]);
            body.push_str(&format!("<g stroke=\"{}\">{dot}</g>", colour(i)));
        }
    }
    body.push_str(&panel.level("origin", 0.0));
    body.push_str(&panel.upright("origin", 0.0));
    let keys: String = pairs
        .iter()
        .enumerate()
        .filter_map(|(i, p)| {
            Some(format!(
                "<span class=\"key\"><svg viewBox=\"-1 -1 2 2\" role=\"img\" aria-label=\"colour of \
                its ellipse\"><circle r=\"0.5\" stroke=\"{}\"/></svg>{}\u{b0}</span> ",
                colour(i),
                p.incidence_deg?
            ))
        })
        .collect();
    let angles = if keys.is_empty() {
        ""
    } else {
        " One ellipse stands for each incidence angle:"
    };
    let dots = if pairs.iter().any(|p| p.truth.is_some()) {
        " Dots are the truth."
    } else {
        ""
    };
    format!(
        "<figure>{}<figcaption><b>c and {spread}</b>: the ellipse holds the pairs of values that \
         agree with the photographs (95 % region), as changes from the estimate. If it is long \
         and slanted, a change of c is nearly made up for by a change of {spread}.{dots}{angles} \
         {keys}</figcaption></figure>\n",
        svg(
            SIZE,
            &format!(
                "95 % regions of c and {spread}; errors and correlations are in the table below"
            ),
            &body
        )
    )
}
