//! Reasons why a window holds no edge that can be measured, and what to do about each.

use crate::photographs::manifest::roi::Roi;

/// A reason why no edge was found, or why the edge cannot be trusted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[allow(
    missing_docs,
    reason = "the message of a variant says what its fields are"
)]
#[non_exhaustive]
pub enum Fault {
    /// A window without contrast: all pixels are alike, or the step is lost in noise.
    #[error(
        "there is no edge in it: the contrast is {contrast:.3e} at a pixel noise of {noise:.3e}; \
        check the exposure, or give the roi of the edge"
    )]
    NoContrast { contrast: f64, noise: f64 },
    /// A profile that rises and falls, with its range in steps of the edge.
    #[error(
        "it holds more than one edge (the light across it ranges over {0:.1} times the step); \
        give the roi of one edge"
    )]
    SeveralEdges(f64),
    /// Several edges, each of which could be measured: regions about them, the longest edge first.
    #[error("it holds {} edges; give the roi of one of them: {}", .0.len(), listed(.0))]
    Choice(Vec<Roi>),
    /// Straight marks, so many, of which none is an edge that can be measured.
    #[error(
        "none of its {0} marks is a straight edge tilted by 1 to 44 degrees with 8 pixels \
        free on either side; give the roi of the edge, or tilt and enlarge it"
    )]
    NoSlantedEdge(usize),
    /// A window with fewer than 8 pixels on one side of the edge.
    #[error(
        "fewer than 8 pixels lie on one side of the edge; give a larger roi, centred on the edge"
    )]
    TooSmall,
    /// A window without light, and the share of its pixels that are exactly 0.
    #[error(
        "the region is black: {:.1} % of its pixels are exactly 0; check the roi, or expose more",
        100.0 * .0
    )]
    Black(f64),
    /// A bright plateau with too many clipped pixels.
    #[error(
        "{:.1} % of its bright pixels are clipped (exactly {level}): the bright plateau is lost; \
        expose less, or give a roi that is not clipped",
        100.0 * share
    )]
    Clipped { share: f64, level: f64 },
    /// A dark plateau with too many pixels that are exactly 0, as a share.
    #[error(
        "{:.1} % of its dark pixels are exactly 0: the dark plateau is cut off; keep the camera's \
        black offset, or expose more",
        100.0 * .0
    )]
    CutOff(f64),
    /// Pixels that do not follow the edge, too large a share to be left out.
    #[error(
        "{:.1} % of its pixels do not follow one smooth edge: another mark, dirt, or a damaged \
        edge; give the roi of a clean part",
        100.0 * .0
    )]
    NotAlone(f64),
    /// Light that differs too much over the window: the ratio of the largest to the smallest, less 1.
    #[error(
        "the light varies by {:.0} % over it; give a smaller roi, or light the edge evenly",
        100.0 * .0
    )]
    Uneven(f64),
    /// An edge that follows no smooth curve.
    #[error(
        "the edge is wavy: {rms_px:.2} pixels (root mean square) are left about a smooth curve, \
        which lowers the MTF by {:.0} % where it is one half (10 % is the limit); give a roi of a \
        smoother part",
        100.0 * loss
    )]
    Wavy { rms_px: f64, loss: f64 },
    /// Rows or columns that are shifted against their neighbours.
    #[error(
        "every second of its {what} is shifted by about {shift_px:.1} pixels across the edge, as \
        the fields of interlaced video are, which lowers the MTF by {:.0} % where it is one half \
        (10 % is the limit); take a progressive picture, or keep every second of its {what}",
        100.0 * loss
    )]
    Shifted {
        what: &'static str,
        shift_px: f64,
        loss: f64,
    },
    /// A second edge beside the first, a ghost.
    #[error(
        "the edge is doubled: a second edge, {:.0} % as steep, lies {distance_px:.1} pixels away; \
        remove the second reflection (a coated or wedged half mirror) or the shake of the camera, \
        or accept it as \"doubled\" if the sheet itself makes it",
        100.0 * share
    )]
    Doubled { share: f64, distance_px: f64 },
    /// An edge along the rows or columns of pixels.
    #[error(
        "the edge is aligned with the pixel grid: it is tilted by {tilt_deg:.2} degrees and \
        crosses {crossed_px:.2} pixels in the window (1 is needed), so pixels lie at too few \
        distances from it; tilt it by 2 to 10 degrees, best by 5 (ISO 12233), or give a roi that \
        is longer along the edge"
    )]
    Aligned { tilt_deg: f64, crossed_px: f64 },
    /// A blur as wide as the window.
    #[error(
        "the blur (10 to 90 % over {rise_px:.0} pixels) fills the window ({length_px:.0} pixels \
        across the edge); focus, or give a larger roi"
    )]
    Blurred { rise_px: f64, length_px: f64 },
}

impl Fault {
    /// Returns the name of the kind of fault, by which faults are counted.
    pub fn kind(&self) -> &'static str {
        match self {
            Fault::NoContrast { .. } => "no contrast",
            Fault::SeveralEdges { .. } | Fault::Choice { .. } => "several edges",
            Fault::NoSlantedEdge { .. } => "no slanted edge",
            Fault::TooSmall => "too small",
            Fault::Black { .. } => "black",
            Fault::Clipped { .. } => "clipped",
            Fault::CutOff { .. } => "cut off at 0",
            Fault::NotAlone { .. } => "not alone",
            Fault::Uneven { .. } => "uneven light",
            Fault::Wavy { .. } => "wavy",
            Fault::Shifted { .. } => "shifted rows",
            Fault::Doubled { .. } => "doubled",
            Fault::Aligned { .. } => "aligned with the pixels",
            Fault::Blurred { .. } => "blur wider than the window",
        }
    }
}

fn listed(rois: &[Roi]) -> String {
    let all: Vec<String> = rois.iter().map(ToString::to_string).collect();
    all.join(", ")
}

/// A fault that the user may accept. It then becomes a warning instead of a refusal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Accepted {
    /// A second edge: [`Fault::Doubled`].
    Doubled,
}

impl Accepted {
    /// The names that a manifest may use, in the order of the variants.
    pub const NAMES: [&'static str; 1] = ["doubled"];

    /// Returns the fault that has this name in a manifest, or `None`.
    pub fn from_name(name: &str) -> Option<Accepted> {
        (name == "doubled").then_some(Accepted::Doubled)
    }
}
