//! Why a window holds no edge that can be measured, and what to do about it.

use crate::photographs::roi::Roi;

/// Why no edge was found, or none that can be trusted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// All pixels are alike, or the step is lost in noise.
    #[error(
        "there is no edge in it: the contrast is {contrast:.3e} at a pixel noise of {noise:.3e}; \
             check the exposure, or give the roi of the edge"
    )]
    NoContrast {
        /// Difference of the two sides.
        contrast: f64,
        /// Standard deviation of a pixel.
        noise: f64,
    },
    /// The profile rises and falls.
    #[error(
        "it holds more than one edge (values along the normal range over {ratio:.1} times the \
        step); \
             give the roi of one edge"
    )]
    SeveralEdges {
        /// Range of the profile over its step.
        ratio: f64,
    },
    /// Several edges, each of which could be measured.
    #[error("it holds {} edges; give the roi of one of them: {}", rois.len(), listed(rois))]
    Choice {
        /// A region about each, the longest edge first.
        rois: Vec<Roi>,
    },
    /// Marks, but no edge that can be measured.
    #[error(
        "none of its {marks} marks is a straight edge tilted by 1 to 44 degrees with 8 pixels \
        free on either side; \
             give the roi of the edge, or tilt and enlarge it"
    )]
    NoSlantedEdge {
        /// Straight pieces found.
        marks: usize,
    },
    /// Too few pixels beside the edge.
    #[error(
        "fewer than 8 pixels lie on one side of the edge; give a larger roi, centred on the edge"
    )]
    TooSmall,
    /// Full-scale pixels.
    #[error(
        "{:.1} % of its bright pixels are clipped (exactly {level}): the bright plateau is lost; \
        expose less, \
             or give a roi that is not clipped", 100.0 * share
    )]
    Clipped {
        /// Share of the bright pixels.
        share: f64,
        /// The value at which they end, linear light.
        level: f64,
    },
    /// Pixels that are exactly 0.
    #[error(
        "{:.1} % of its dark pixels are exactly 0: the dark plateau is cut off; keep the camera's \
        black offset, \
             or expose more", 100.0 * share
    )]
    CutOff {
        /// Share of the dark pixels.
        share: f64,
    },
    /// Pixels that do not follow the edge.
    #[error(
        "{:.1} % of its pixels do not follow one straight edge: another mark, dirt, or a bent or \
        damaged edge; \
             give the roi of a clean straight part", 100.0 * share
    )]
    NotAlone {
        /// Share of the pixels.
        share: f64,
    },
    /// Light that differs too much over the window.
    #[error(
        "the light varies by {:.0} % over it; give a smaller roi, or light the edge evenly", 100.0 * unevenness
    )]
    Uneven {
        /// Largest over smallest light, less 1.
        unevenness: f64,
    },
    /// A curved edge.
    #[error(
        "the edge is bowed by {sagitta_px:.2} pixels; give a shorter roi, or correct the lens \
        distortion"
    )]
    Bowed {
        /// Height of the arc over its chord, pixels.
        sagitta_px: f64,
    },
    /// A ghost beside the edge.
    #[error(
        "the edge is doubled: {:.0} % of it comes again {distance_px:.1} pixels away; remove the \
        second reflection \
             (a coated or wedged half mirror) or the shake of the camera, or accept it as \
             \"doubled\" where the sheet \
             itself makes it", 100.0 * share
    )]
    Doubled {
        /// Steepness of the second edge over that of the first.
        share: f64,
        /// Distance of the two, pixels.
        distance_px: f64,
    },
    /// A blur as wide as the window.
    #[error(
        "the blur (10 to 90 % over {rise_px:.0} pixels) fills the window ({length_px:.0} pixels \
        across the edge); \
             focus, or give a larger roi"
    )]
    Blurred {
        /// Distance over which the profile rises from 10 to 90 % of its step, pixels.
        rise_px: f64,
        /// Length of the profile, pixels.
        length_px: f64,
    },
}

impl Fault {
    /// The kind of it, to be counted by.
    pub fn kind(&self) -> &'static str {
        match self {
            Fault::NoContrast { .. } => "no contrast",
            Fault::SeveralEdges { .. } | Fault::Choice { .. } => "several edges",
            Fault::NoSlantedEdge { .. } => "no slanted edge",
            Fault::TooSmall => "too small",
            Fault::Clipped { .. } => "clipped",
            Fault::CutOff { .. } => "cut off at 0",
            Fault::NotAlone { .. } => "not alone",
            Fault::Uneven { .. } => "uneven light",
            Fault::Bowed { .. } => "bowed",
            Fault::Doubled { .. } => "doubled",
            Fault::Blurred { .. } => "blur wider than the window",
        }
    }
}

fn listed(rois: &[Roi]) -> String {
    let all: Vec<String> = rois.iter().map(ToString::to_string).collect();
    all.join(", ")
}
