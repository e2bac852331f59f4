//! Tests of camera raw: DNG files made byte by byte, whose edge is known.

use std::path::{Path, PathBuf};

use crate::planted::{camera, params, truth};
use crate::simulate::PlantedEdge;
use crate::simulate::photograph as simulate;
use edges::names::Kernel;
use edges::names::LobeShape;
use edges::photographs::Estimator;
use edges::photographs::edge::fault::Fault;
use edges::photographs::manifest::captures;
use edges::photographs::measure;
use edges::photographs::photo;
use edges::photographs::photo::channel::{Channel, Decode};
use estimator::model::{Camera, Lens};

const WHITE: u32 = 15_000;

/// Black levels of the four places of a mosaic, row by row.
const BLACK: [u16; 4] = [500, 520, 540, 560];

/// Light at a place of the mosaic.
type Light<'a> = &'a dyn Fn(usize, usize) -> f64;

/// A directory entry: tag, type, count and value.
struct Entry(u16, u16, u32, Vec<u8>);

fn short(tag: u16, values: &[u16]) -> Entry {
    let bytes = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    Entry(tag, 3, values.len() as u32, bytes)
}

fn long(tag: u16, value: u32) -> Entry {
    Entry(tag, 4, 1, value.to_le_bytes().to_vec())
}

fn rational(tag: u16, [n, d]: [u32; 2]) -> Entry {
    Entry(tag, 5, 1, [n.to_le_bytes(), d.to_le_bytes()].concat())
}

/// The bytes of a directory at `at` in its file. Values that do not fit into it follow behind it.
fn directory(entries: &[Entry], at: u32) -> Vec<u8> {
    let mut bytes = (entries.len() as u16).to_le_bytes().to_vec();
    let mut rest: Vec<u8> = Vec::new();
    let behind = at + 6 + 12 * entries.len() as u32;
    for Entry(tag, kind, count, value) in entries {
        bytes.extend(tag.to_le_bytes());
        bytes.extend(kind.to_le_bytes());
        bytes.extend(count.to_le_bytes());
        if value.len() <= 4 {
            bytes.extend(value);
            bytes.resize(bytes.len() + 4 - value.len(), 0);
        } else {
            bytes.extend((behind + rest.len() as u32).to_le_bytes());
            rest.extend(value);
        }
    }
    bytes.extend([0; 4]);
    bytes.extend(rest);
    bytes
}

/// The content of a DNG file.
#[derive(Clone, Copy)]
struct Dng {
    width: usize,
    height: usize,
    /// Colours of the mosaic, row by row, 0 red to 2 blue; `None` for a sensor without colours.
    mosaic: Option<[u8; 4]>,
    orientation: u16,
    seconds: [u32; 2],
}

impl Dng {
    /// Returns the bytes of the file: 16 bits per pixel, not compressed.
    fn bytes(&self, light: Light) -> Vec<u8> {
        let mut pixels = Vec::new();
        for y in 0..self.height {
            for x in 0..self.width {
                let black = self.mosaic.map_or(BLACK[0], |_| BLACK[2 * (y % 2) + x % 2]);
                let span = f64::from(WHITE) - f64::from(black);
                let code = (f64::from(black) + span * light(x, y)).round();
                pixels.extend((code.clamp(0.0, f64::from(WHITE)) as u16).to_le_bytes());
            }
        }
        let exif = [
            rational(33434, self.seconds),
            rational(33437, [28, 10]),
            short(34855, &[200]),
        ];
        let root = |exif_at: u32, pixels_at: u32| {
            let mut entries = vec![
                long(254, 0),
                long(256, self.width as u32),
                long(257, self.height as u32),
                short(258, &[16]),
                short(259, &[1]),
                short(262, &[if self.mosaic.is_some() { 32803 } else { 34892 }]),
                Entry(271, 2, 5, b"Test\0".to_vec()),
                Entry(272, 2, 5, b"None\0".to_vec()),
                long(273, pixels_at),
                short(274, &[self.orientation]),
                short(277, &[1]),
                long(278, self.height as u32),
                long(279, pixels.len() as u32),
            ];
            if let Some(mosaic) = self.mosaic {
                entries.push(short(33421, &[2, 2]));
                entries.push(Entry(33422, 1, 4, mosaic.to_vec()));
            }
            entries.push(long(34665, exif_at));
            entries.push(Entry(50706, 1, 4, vec![1, 4, 0, 0]));
            if self.mosaic.is_some() {
                entries.push(short(50713, &[2, 2]));
                entries.push(short(50714, &BLACK));
            } else {
                entries.push(short(50714, &BLACK[..1]));
            }
            entries.push(long(50717, WHITE));
            directory(&entries, 8)
        };
        let exif_at = 8 + root(0, 0).len() as u32;
        let exif = directory(&exif, exif_at);
        let pixels_at = exif_at + exif.len() as u32;
        let mut bytes = b"II*\0".to_vec();
        bytes.extend(8_u32.to_le_bytes());
        bytes.extend(root(exif_at, pixels_at));
        bytes.extend(exif);
        bytes.extend(pixels);
        bytes
    }

    fn write(&self, folder: &Path, name: &str, light: Light) -> PathBuf {
        let file = folder.join(name);
        std::fs::write(&file, self.bytes(light)).expect("the folder takes files");
        file
    }
}

fn decode(channel: Channel) -> Decode {
    Decode {
        transfer: None,
        channel,
    }
}

/// The light of a source edge without noise, blurred by a camera alone.
fn source(normal_deg: f64) -> (Dng, Vec<f64>) {
    let truth = truth(Kernel::Lobe, LobeShape::Radial, 3.0, 0.3, 0.6);
    let mut params = params(1, truth, &[0.0], &[200.0], camera(1e12));
    params.camera.width = 360;
    params.camera.height = 360;
    params.reference = Some(PlantedEdge {
        normal_deg,
        offset_px: 0.4,
        ..PlantedEdge::SOURCE
    });
    let dng = Dng {
        width: params.camera.width,
        height: params.camera.height,
        mosaic: Some([0, 1, 1, 2]),
        orientation: 1,
        seconds: [1, 100],
    };
    let light = simulate::light(&params, None).expect("the parameters are valid");
    (dng, light)
}

/// The edge of every colour has the MTF of the lens and one pixel, like an edge that all pixels
/// see: nothing is filled in or averaged. The pixels of the other colours show bright and dark
/// stripes; using one of them would show in the MTF.
///
/// The MTF is within 0.002 up to half the sampling frequency, as for known edges of all pixels
/// (src/tests/edge.rs). Averages of 2 x 2 pixels would lose 0.1 at a quarter of the sampling
/// frequency: 1 - cos(pi / 4) of an MTF of 0.4.
#[test]
fn each_colour_has_the_mtf_of_its_own_pixels() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (mut cases, mut worst, mut worst_angle) = (0, 0.0_f64, 0.0_f64);
    for normal_deg in [5.3, -23.0, 97.0, 211.0] {
        let (dng, light) = source(normal_deg);
        for mosaic in [[0, 1, 1, 2], [1, 2, 0, 1]] {
            for (colour, channel) in Channel::PRIMARIES.into_iter().enumerate() {
                let dng = Dng {
                    mosaic: Some(mosaic),
                    ..dng
                };
                let seen = |x: usize, y: usize| {
                    if usize::from(mosaic[2 * (y % 2) + x % 2]) == colour {
                        light[y * dng.width + x]
                    } else {
                        [0.05, 0.9][(x / 8) % 2]
                    }
                };
                let file = dng.write(folder.path(), "edge.dng", &seen);
                let photo = photo::load(&file, &decode(channel.clone())).expect("it is a DNG");
                assert_eq!(photo.warnings, Vec::<String>::new());
                let held = photo.luminance.iter().filter(|v| !v.is_nan()).count();
                let share = if channel == Channel::Green { 2 } else { 4 };
                assert_eq!(held * share, dng.width * dng.height);
                let found = measure::edge(&photo, None, &[]).unwrap_or_else(|fault| {
                    panic!("{normal_deg} deg, {channel}: {fault}");
                });
                let turn = (found.line.normal_rad.to_degrees() - normal_deg + 540.0)
                    .rem_euclid(360.0)
                    - 180.0;
                worst_angle = worst_angle.max(turn.abs());
                let pitch_mm = 0.08;
                let mtf = Estimator::new(&found.profile, pitch_mm, 400, 50).measure(&found.profile);
                let lens = Some(Lens {
                    blur_mm: std::f64::consts::SQRT_2 * std::f64::consts::PI * 0.55 * pitch_mm,
                    exponent: 2.0,
                });
                let known = Camera { pitch_mm, lens };
                for k in 1..=50 {
                    let frequency = 0.01 * f64::from(k) / pitch_mm;
                    let wanted = known.otf(frequency, normal_deg.to_radians()).abs();
                    worst = worst.max((mtf.modulus[k as usize] - wanted).abs());
                }
                cases += 1;
            }
        }
    }
    println!("{cases} cases: largest MTF error {worst:.5}, angle error {worst_angle:.1e} deg");
    assert_eq!(cases, 24);
    assert!(worst < 0.002, "{worst}");
    assert!(worst_angle < 1e-3, "{worst_angle}");
}

/// The light is linear from the black level of every place to the white level. Values below black
/// stay below 0, values at white are clipped, and the picture is turned by its orientation.
#[test]
fn levels_and_orientation() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let dng = Dng {
        width: 12,
        height: 8,
        mosaic: Some([0, 1, 1, 2]),
        orientation: 1,
        seconds: [1, 100],
    };
    let light = |x: usize, y: usize| -0.02 + 0.011 * (x + 12 * y) as f64;
    // A code is half a step off at most.
    let tolerance = 0.5 / f64::from(WHITE - 560) + 1e-6;
    let mut cases = 0;
    for orientation in 1..=8_u16 {
        let file = Dng { orientation, ..dng }.write(folder.path(), "levels.dng", &light);
        for channel in Channel::PRIMARIES {
            let photo = photo::load(&file, &decode(channel.clone())).expect("it is a DNG");
            assert_eq!(photo.warnings.len(), usize::from(orientation > 1));
            for y in 0..photo.height {
                for x in 0..photo.width {
                    // Place of the pixel in the file (TIFF 6.0, Orientation).
                    let (w, h) = (photo.width - 1, photo.height - 1);
                    let (u, v) = match orientation {
                        1 => (x, y),
                        2 => (w - x, y),
                        3 => (w - x, h - y),
                        4 => (x, h - y),
                        5 => (y, x),
                        6 => (y, w - x),
                        7 => (h - y, w - x),
                        _ => (h - y, x),
                    };
                    let found = f64::from(photo.luminance[y * photo.width + x]);
                    let colour = [0, 1, 1, 2][2 * (v % 2) + u % 2];
                    if Channel::PRIMARIES[colour] != channel {
                        assert!(found.is_nan());
                        continue;
                    }
                    let wanted = light(u, v).min(1.0);
                    assert!(
                        (found - wanted).abs() < tolerance,
                        "{found} is not {wanted}"
                    );
                    assert_eq!(found >= 1.0, wanted >= 1.0 - tolerance);
                    cases += 1;
                }
            }
        }
    }
    assert_eq!(cases, 8 * 12 * 8);
    let file = dng.write(folder.path(), "levels.dng", &light);
    let luminance = photo::load(&file, &decode(Channel::Luminance)).expect("green stands for it");
    let green = photo::load(&file, &decode(Channel::Green)).expect("it is a DNG");
    assert!(
        luminance.warnings[0].contains("green"),
        "{:?}",
        luminance.warnings
    );
    let bits = |photo: &photo::plane::Photo| {
        photo
            .luminance
            .iter()
            .map(|v| v.to_bits())
            .collect::<Vec<_>>()
    };
    assert_eq!(bits(&luminance), bits(&green));
    // A sensor without colours gives all its pixels, and no channel.
    let grey = Dng {
        mosaic: None,
        ..dng
    };
    let file = grey.write(folder.path(), "grey.dng", &light);
    let photo = photo::load(&file, &Decode::default()).expect("it is a DNG");
    assert!(photo.luminance.iter().all(|v| v.is_finite()));
    let error = photo::load(&file, &decode(Channel::Red)).expect_err("there is no red");
    assert!(
        error
            .to_string()
            .contains("set `channel` to what it has: luminance"),
        "{error}"
    );
}

/// Bright pixels at the white level are clipped, although 16 bits could hold more.
#[test]
fn clipping_is_known_from_the_file() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (dng, light) = source(5.3);
    let bright = light.iter().copied().fold(0.0, f64::max);
    let over = |x: usize, y: usize| 1.2 / bright * light[y * dng.width + x];
    let file = dng.write(folder.path(), "clipped.dng", &over);
    let photo = photo::load(&file, &decode(Channel::Blue)).expect("it is a DNG");
    let fault = measure::edge(&photo, None, &[]).expect_err("its bright side is clipped");
    assert!(matches!(fault, Fault::Clipped { .. }), "{fault}");
}

/// The exposure comes from the settings in the raw files: 1/100 s against 1/25 s.
#[test]
fn exposure_comes_from_the_raw_files() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (dng, light) = source(5.3);
    let seen = |x: usize, y: usize| light[y * dng.width + x];
    dng.write(folder.path(), "source.dng", &seen);
    let longer = Dng {
        seconds: [1, 25],
        ..dng
    };
    longer.write(folder.path(), "aerial.dng", &seen);
    let manifest = folder.path().join("captures.toml");
    let text = "[setup]\npixel_pitch_mm = 0.08\nhalf_mirror_transmittance = \
    0.5\nhalf_mirror_reflectance = 0.5\n\
                channel = \"red\"\n[reference]\nimage = \"source.dng\"\nexposure = \
                1.0\n[[capture]]\nimage = \"aerial.dng\"\n\
                floating_distance_mm = 150.0\nincidence_deg = 0.0\n";
    std::fs::write(&manifest, text).expect("the folder takes files");
    let campaign = captures::load(&manifest).expect("it is valid");
    assert_eq!(campaign.captures[0].shot.exposure, 4.0);
    let photo = campaign.captures[0].shot.load().expect("it is a DNG");
    assert!(measure::edge(&photo, None, &[]).is_ok());
}

/// A file that is cut short, or that holds noise, gives an error with its name, never a panic.
#[test]
fn damaged_files_are_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let dng = Dng {
        width: 12,
        height: 8,
        mosaic: Some([0, 1, 1, 2]),
        orientation: 1,
        seconds: [1, 100],
    };
    let whole = dng.bytes(&|_, _| 0.5);
    let file = folder.path().join("short.dng");
    let mut cases = 0;
    for length in (16..whole.len() - 1).step_by(7) {
        std::fs::write(&file, &whole[..length]).expect("the folder takes files");
        let error = photo::load(&file, &decode(Channel::Red)).expect_err("it is cut short");
        let text = error.to_string();
        assert!(
            text.contains("short.dng") && text.contains("camera raw"),
            "{text}"
        );
        cases += 1;
    }
    println!("{cases} cases");
    assert!(cases > 60, "{cases}");
}
