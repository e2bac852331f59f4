//! Tests of several modules together.

#![allow(clippy::too_many_lines, reason = "a test is one list of cases")]

/// Photographs: edges, noise, lenses, lamps and what cameras do to them.
mod camera {
    mod cameras;
    mod channels;
    mod correlation;
    mod edge;
    mod effects;
    mod exponent;
    mod further;
    mod known;
    mod lamps;
    mod lens;
    mod pixels;
    #[cfg(feature = "raw")]
    mod raw;
}

/// Estimates of planted sheets.
mod estimates {
    pub(super) mod azimuth;
    mod baselines;
    mod campaign;
    mod direction;
    mod estimate;
    mod forward;
    mod wave;
}

/// What an estimate says of itself: errors, bounds, verdicts, suspects, unverified inputs.
mod trust {
    mod carried;
    mod diagnosis;
    mod goodness;
    mod mirror;
    mod one_sided;
    mod perturbed;
    mod suspects;
    mod unverified;
}

/// Predictions, and sheets without photographs.
mod predictions {
    mod by_hand;
    mod legibility;
    mod nominal;
    pub(super) mod prediction;
    mod sample;
}

/// Simulated campaigns, studies of many, and plans.
mod studies {
    mod plan;
    mod selection;
    mod simulate_campaign;
    pub(super) mod statistics;
    pub(super) mod study;
}
