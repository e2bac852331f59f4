//! `fit mtf` on edges whose MTF is known. They have no noise, so all error is the estimator's own.

use std::path::Path;

use tests::files::argument;
use tests::program::fit;

const PITCH_MM: f64 = 0.05;

/// Returns the numbers of a CSV, row by row: the frequency (1/mm) and the columns after it.
fn rows(text: &str) -> Vec<Vec<f64>> {
    text.lines()
        .skip(1)
        .map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect())
        .collect()
}

/// Returns the signed truth at a frequency between its rows, by the cubic through four rows.
///
/// The error is 3/128 h^4 f'''' for rows that lie h apart. A mid-air edge that is 1 mm wide has
/// f'''' of at most (2 pi 0.5 mm)^4 = 97, and h is 0.1 per mm. So the error is at most 2.3e-4, a
/// tenth of the limit.
fn cubic(truth: &[Vec<f64>], frequency: f64) -> f64 {
    let step = truth[1][0] - truth[0][0];
    let first = ((frequency / step) as usize)
        .saturating_sub(1)
        .min(truth.len() - 4);
    let four = &truth[first..first + 4];
    let weight = |j: usize| -> f64 {
        (0..4)
            .filter(|k| *k != j)
            .map(|k| (frequency - four[k][0]) / (four[j][0] - four[k][0]))
            .product()
    };
    (0..4).map(|j| weight(j) * four[j][1]).sum()
}

#[test]
fn the_mtf_of_every_edge_is_right_to_half_the_sampling_frequency() {
    let (mut edges, mut compared) = (0, 0);
    for (name, angle) in [
        ("camera_2deg", 2.0),
        ("camera_5deg", 5.0),
        ("camera_12deg", 12.0),
        ("camera_92deg", 92.0),
        ("aerial_10deg_incidence", 5.0),
    ] {
        let image = argument(&format!("tests/edges/{name}.exr"));
        let csv = std::fs::read_to_string(argument(&format!("tests/edges/{name}.csv"))).unwrap();
        let truth = rows(&csv);
        let run = fit(
            Path::new("."),
            &["mtf", &image, "--pixel-pitch", &PITCH_MM.to_string()],
        );
        assert_eq!(run.code, Some(0), "{}\n{}", run.line, run.err);
        // A clean edge gets no warning, and `fit` writes no remark if its output is a pipe.
        assert_eq!(run.err, "", "{name}");
        let object = fit(Path::new("."), &format!("mtf {image} --json")).done();
        let object: serde_json::Value = serde_json::from_str(&object).unwrap();
        let found = object["edge_angle_deg"].as_f64().unwrap();
        // An error of 1e-3 deg is 0.004 px at the end of an edge of 256 rows.
        assert!((found - angle).abs() < 1e-3, "{name}: {found} deg");
        let measured: Vec<_> = rows(&run.out)
            .into_iter()
            .filter(|row| row[0] <= 0.5 / PITCH_MM)
            .collect();
        assert!(
            measured.len() > 20 && measured.last().unwrap()[0] > 0.48 / PITCH_MM,
            "{name}: too few frequencies"
        );
        let mut largest = 0.0_f64;
        for row in &measured {
            largest = largest.max((row[1] - cubic(&truth, row[0]).abs()).abs());
            compared += 1;
        }
        println!("{name}: largest error {largest:.5}");
        assert!(largest < 0.002, "{name}: {largest}");
        edges += 1;
    }
    assert!(
        edges == 5 && compared > 200,
        "{edges} edges, {compared} frequencies"
    );
}
