//! Elements that are not corner cubes (plate of slit mirrors, bead), with the real programs.

use tables::ShiftLine;
use tests::files::argument;
use tests::page::commands;
use tests::program::{bake, run};

/// The OTF of the shift of a plate at azimuth 45 is a product of two sincs.
///
/// The shifts fill a square. Its sides are perpendicular to the mirrors of the two layers, and each
/// is 2 w P(s) pitches long (`bake/src/tests/elements/plate.rs`). Each sinc belongs to one side, as
/// the image shows it.
#[test]
fn a_plate_blurs_as_its_slits_do() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let design = "design plate -o plate.glb --edge-length 0.5";
    bake(here, &format!("{design} --depth 3 --thickness 0.02")).done();
    let trace = "trace plate.glb -o plate.h5 --element plate";
    let directions = "--refractive-index 1.5 --azimuth 45";
    bake(here, &format!("{trace} {directions}")).done();
    let judged = bake(here, "verify plate.h5 --mesh plate.glb --rays 65536");
    assert_eq!(judged.code, Some(0), "{}", judged.err);

    let table = tables::read(&here.join("plate.h5")).unwrap();
    assert_eq!(table.provenance.element(), tables::options::Element::Plate);
    // GLB holds numbers of single precision, so thicknesses and depths are right to 6e-8.
    let (w, c_mm, mut cases) = (0.98, 0.5, 0);
    for &incidence_deg in &table.axes.incidence_deg {
        let incidence = incidence_deg.to_radians();
        let inside = (incidence.sin() / 1.5).asin().tan();
        let s = 3.0 * inside * std::f64::consts::FRAC_1_SQRT_2 / w;
        let odd = 1.0 - (1.0 - s.rem_euclid(2.0)).abs();
        let direction = table.direction(incidence_deg, Some(45.0)).unwrap();
        assert!((direction.retroreflected - (w * odd).powi(2)).abs() < 1e-6);
        for angle in [0.0, 0.4, 1.3] {
            let (ny, nx) = f64::sin_cos(angle);
            let Some(line) = ShiftLine::new(&direction, incidence, [nx, ny]) else {
                assert!(direction.retroreflected < 1e-12);
                continue;
            };
            for frequency in [0.2, 0.7, 1.9] {
                let (kx, ky) = (nx * incidence.cos() * frequency, ny * frequency);
                let sinc = |k: f64| {
                    let half = std::f64::consts::PI * k * c_mm * 2.0 * w * odd;
                    half.sin() / half
                };
                let turned = std::f64::consts::FRAC_1_SQRT_2;
                let expected = sinc((kx - ky) * turned) * sinc((kx + ky) * turned);
                // The OTF is tabulated to 1.6e-5. The numbers of the closed form are right to 1e-6.
                let (otf, _) = line.otf(c_mm, 300.0, frequency);
                assert!(
                    (otf.norm() - expected.abs()).abs() < 1.7e-5,
                    "{incidence_deg} deg, {angle}, {frequency} /mm: {otf} is not {expected}"
                );
                cases += 1;
            }
        }
    }
    assert_eq!(cases, 81, "nine incidences at which light is imaged");
}

/// The worked examples of the manual run as printed and write their pictures.
#[test]
fn the_manual_runs_as_printed() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let manual = std::fs::read_to_string(argument("bake/doc/elements.md")).unwrap();
    let mut ran = 0;
    for words in commands(&manual) {
        let (program, arguments) = words.split_first().unwrap();
        let run = run(program, here, arguments);
        assert_eq!(run.code, Some(0), "{}\n{}", run.line, run.err);
        ran += 1;
    }
    assert_eq!(ran, 6);
    for picture in ["plate.svg", "bead.svg"] {
        assert!(here.join(picture).is_file(), "{picture}");
    }
    let table = tables::read(&here.join("bead.h5")).unwrap();
    assert!(table.provenance.has_glass() && table.deviations.is_some());
}
