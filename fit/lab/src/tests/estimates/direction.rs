//! Tests of `estimator::estimate::scene::direction` on planted campaigns.

use crate::planted::{table, truth};
use edges::names::Kernel;
use edges::names::LobeShape;
use estimator::estimate::scene::direction::*;

/// The front of a baseline takes its part of the light and of its error alike, so the relative
/// error stays; `mrm` returns all light, without an error. Fresnel's equations at 30 degrees
/// and an index of 1.49 give a reflectance of 0.0402 (sin(a - b) and tan(a - b) over those of
/// the sum, b = 19.609 degrees).
#[test]
fn the_front_takes_light_and_error_alike() {
    let sheet = truth(Kernel::Saito, LobeShape::Ggx, 2e-3, 0.24, 0.5);
    let mut table = table(&sheet, &[30.0], 20.0);
    table.standard_error = &table.retroreflected * 0.03;
    let direction = table.direction(30.0, Some(20.0)).expect("it is held");
    let seen = Along {
        incidence_rad: 30.0_f64.to_radians(),
        normal: [1.0, 0.0],
        spectrum: None,
    };
    let projected = ProjectedDirection::new(&direction, Some(20.0), 1.49, seen);
    let (a, b) = (30.0_f64.to_radians(), (0.5_f64 / 1.49).asin());
    let front =
        0.5 * (((a - b).sin() / (a + b).sin()).powi(2) + ((a - b).tan() / (a + b).tan()).powi(2));
    for (kernel, part, error) in [
        (Kernel::Eq1, 1.0, 0.03),
        (Kernel::Saito, (1.0 - front).powi(2), 0.03),
        (Kernel::Mrm, 1.0 / direction.retroreflected, 0.0),
    ] {
        let found = projected.returned_as(kernel);
        let share = found.retroreflected / direction.retroreflected;
        assert!(
            (share / part - 1.0).abs() < 1e-12,
            "{kernel:?}: {share} {part}"
        );
        let relative = found.relative_error();
        assert!((relative - error).abs() < 1e-12, "{kernel:?}: {relative}");
    }
}
