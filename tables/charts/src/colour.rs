//! Colours of charts: those of the report, hues of unordered curves, and an ordered scale.

/// Colours of a figure that stands alone, by their names in the style sheet; a page may have
/// others in the dark and on paper.
pub const PALETTE: [(&str, &str); 4] = [
    ("paper", "#ffffff"),
    ("ink", "#1d2226"),
    ("soft", "#59636e"),
    ("rule", "#dce1e6"),
];

/// Hues of curves without an order: first those of measured and modelled curves in the report.
pub const HUES: [&str; 6] = [
    "#1668c1", "#c2410c", "#1a7f37", "#7d4cc2", "#b8860b", "#0e8a94",
];

/// Number of steps of the ordered scale.
pub const STEPS: u8 = 64;

/// Ordered scale from dark to light: matplotlib's viridis (CC0) in steps of an eighth.
///
/// Its lightness grows evenly, so people who do not see all colours can still tell the order.
const SCALE: [[f64; 3]; 9] = [
    [68.0, 1.0, 84.0],
    [71.0, 45.0, 123.0],
    [59.0, 82.0, 139.0],
    [44.0, 114.0, 142.0],
    [33.0, 145.0, 140.0],
    [40.0, 174.0, 128.0],
    [94.0, 201.0, 98.0],
    [173.0, 220.0, 48.0],
    [253.0, 231.0, 37.0],
];

/// Part of the scale whose lines are seen on white.
const SEEN: f64 = 0.625;

/// Returns a colour of the scale, from dark (0) to light (1).
fn mixed(x: f64) -> [u8; 3] {
    let place = x.clamp(0.0, 1.0) * (SCALE.len() - 1) as f64;
    let left = (place as usize).min(SCALE.len() - 2);
    let share = place - left as f64;
    [0, 1, 2].map(|k| (SCALE[left][k] * (1.0 - share) + SCALE[left + 1][k] * share).round() as u8)
}

/// Returns the colour of the line number `index` of `count` ordered ones, dark ones first.
pub fn ramp(index: usize, count: usize) -> String {
    let last = count.max(2) - 1;
    hex(mixed(SEEN * index as f64 / last as f64))
}

/// Returns the colour of a step from 1 (light) to [`STEPS`] (dark); no light is white, like paper.
pub(crate) fn step_colour(step: u8) -> [u8; 3] {
    mixed(1.0 - f64::from(step.clamp(1, STEPS) - 1) / f64::from(STEPS - 1))
}

/// Ends of the scale of differences, and its middle: blue and orange of ColorBrewer, which people who
/// do not see all colours can tell apart.
const DIFFERENCES: [[f64; 3]; 3] = [
    [33.0, 102.0, 172.0],
    [247.0, 247.0, 247.0],
    [179.0, 88.0, 6.0],
];

/// Returns the colour of a difference, from 1 (less, blue) over the middle (none) to [`STEPS`]
/// (more, orange).
pub(crate) fn difference_colour(step: u8) -> [u8; 3] {
    let signed = 2.0 * f64::from(step.clamp(1, STEPS) - 1) / f64::from(STEPS - 1) - 1.0;
    let [less, none, more] = DIFFERENCES;
    let end = if signed < 0.0 { less } else { more };
    [0, 1, 2].map(|k| (none[k] + signed.abs() * (end[k] - none[k])).round() as u8)
}

/// Writes a colour as the attribute of a line has it.
fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance of WCAG 2.
    fn luminance(colour: [u8; 3]) -> f64 {
        let [r, g, b] = colour.map(|value| match f64::from(value) / 255.0 {
            value if value <= 0.03928 => value / 12.92,
            value => ((value + 0.055) / 1.055).powf(2.4),
        });
        0.2126 * r + 0.7152 * g + 0.0722 * b
    }

    /// Checks that both scales are ordered by lightness, and that the lightest line has a contrast
    /// of 2.8 with white.
    #[test]
    fn scales_are_ordered_by_lightness() {
        let steps: Vec<f64> = (1..=STEPS)
            .map(|step| luminance(step_colour(step)))
            .collect();
        assert!(steps.windows(2).all(|pair| pair[0] > pair[1]), "{steps:?}");
        let lines = (0..=100).map(|k| {
            let colour = u32::from_str_radix(&ramp(k, 101)[1..], 16).expect("six digits");
            let [_, rgb @ ..] = colour.to_be_bytes();
            luminance(rgb)
        });
        let lines: Vec<f64> = lines.collect();
        assert!(lines.windows(2).all(|pair| pair[0] < pair[1]), "{lines:?}");
        assert!(1.05 / (lines[100] + 0.05) > 2.8);
    }

    /// Checks that differences grow darker towards both ends, and that the ends differ in hue.
    #[test]
    fn differences_are_lightest_in_the_middle() {
        let steps: Vec<f64> = (1..=STEPS)
            .map(|step| luminance(difference_colour(step)))
            .collect();
        let (less, more) = steps.split_at(usize::from(STEPS / 2));
        assert!(less.windows(2).all(|pair| pair[0] < pair[1]), "{less:?}");
        assert!(more.windows(2).all(|pair| pair[0] > pair[1]), "{more:?}");
        let [[r, _, b], [red, _, blue]] = [1, STEPS].map(difference_colour);
        assert!(b > r && red > blue);
    }
}
