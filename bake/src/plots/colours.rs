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

/// Part of all light that may be denser than the scale reaches.
///
/// Slivers where polygons barely overlap, and the noise of rays, would else make all colours pale.
const BEYOND: f64 = 0.005;

/// Scale of densities from 0.
#[derive(Debug)]
pub(crate) struct Scale {
    /// Density at the end of the scale; 0 without light.
    pub(crate) highest: f64,
    /// Largest density of all, which has the colour of the end.
    pub(crate) largest: f64,
}

impl Scale {
    /// Makes a scale for densities, each with the light that has it.
    pub(crate) fn of(mut light: Vec<[f64; 2]>) -> Scale {
        light.sort_by(|p, q| q[0].total_cmp(&p[0]));
        let all: f64 = light.iter().map(|[_, share]| share).sum();
        let mut beyond = 0.0;
        let reached = light.iter().find(|[_, share]| {
            beyond += share;
            beyond > BEYOND * all
        });
        Scale {
            highest: reached.map_or(0.0, |[density, _]| *density),
            largest: light.first().map_or(0.0, |[density, _]| *density),
        }
    }

    /// Returns the step of a density, from 1 to [`STEPS`]; `None` for no light.
    pub(crate) fn step(&self, density: f64) -> Option<usize> {
        let share = density / self.highest;
        (share > 0.0).then(|| ((share * STEPS as f64).ceil() as usize).clamp(1, STEPS))
    }
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
    }

    #[test]
    fn the_scale_leaves_out_the_densest_slivers() {
        // 0.4 % of the light has the density 9.
        let scale = Scale::of(vec![[1.0, 99.6], [9.0, 0.4]]);
        assert_eq!((scale.highest, scale.largest), (1.0, 9.0));
        let steps = [0.0, 1e-9, 1.0 / 64.0, 0.5, 1.0, 9.0].map(|density| scale.step(density));
        let expected = [None, Some(1), Some(1), Some(32), Some(64), Some(64)];
        assert_eq!(steps, expected);
        let dark = Scale::of(Vec::new());
        assert_eq!(dark.step(0.0), None, "a picture without light");
    }
}
