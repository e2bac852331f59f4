//! Colours of densities: a scale that is ordered by lightness, in steps.

use kuva::render::color::Color;

/// Number of steps of the scale.
pub(crate) const STEPS: usize = 64;

/// Scale from low to high: matplotlib's viridis (CC0) reversed, in steps of an eighth.
///
/// It grows darker evenly, so people who do not see all colours can tell the order. No light is
/// white, like the paper.
const SCALE: [[f64; 3]; 9] = [
    [253.0, 231.0, 37.0],
    [173.0, 220.0, 48.0],
    [94.0, 201.0, 98.0],
    [40.0, 174.0, 128.0],
    [33.0, 145.0, 140.0],
    [44.0, 114.0, 142.0],
    [59.0, 82.0, 139.0],
    [71.0, 45.0, 123.0],
    [68.0, 1.0, 84.0],
];

/// Returns the step of a density, from 1 to [`STEPS`]; `None` for no light.
pub(crate) fn step(density: f64, highest: f64) -> Option<usize> {
    let share = density / highest;
    (share > 0.0).then(|| ((share * STEPS as f64).ceil() as usize).clamp(1, STEPS))
}

/// Returns the colour of a step.
pub(crate) fn colour(step: usize) -> Color {
    let place = (step.clamp(1, STEPS) - 1) as f64 / (STEPS - 1) as f64;
    let place = place * (SCALE.len() - 1) as f64;
    let left = (place as usize).min(SCALE.len() - 2);
    let share = place - left as f64;
    let mixed = |k: usize| SCALE[left][k] * (1.0 - share) + SCALE[left + 1][k] * share;
    let [r, g, b] = [0, 1, 2].map(|k| mixed(k).round() as u8);
    Color::Rgb(r, g, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_step_is_darker_than_the_one_before() {
        let luminance = |step: usize| -> f64 {
            let Color::Rgb(r, g, b) = colour(step) else {
                panic!("step {step} has no colour");
            };
            let linear = |v: u8| (f64::from(v) / 255.0).powf(2.2);
            0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b)
        };
        let all: Vec<f64> = (1..=STEPS).map(luminance).collect();
        assert!(all.windows(2).all(|pair| pair[0] > pair[1]), "{all:?}");
        let steps = [0.0, 1e-9, 1.0 / 64.0, 0.5, 1.0, 1.5].map(|density| step(density, 1.0));
        let expected = [None, Some(1), Some(1), Some(32), Some(64), Some(64)];
        assert_eq!(steps, expected);
        assert_eq!(step(0.0, 0.0), None, "a picture without light");
    }
}
