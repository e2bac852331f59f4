//! Tests of PSNR, SSIM, FLIP and LPIPS against recorded values of the programs that are in common
//! use.
//!
//! fit/tests/metrics.py recorded the values with scikit-image 0.26.0, flip-evaluator 1.7, torch and
//! lpips 0.1.4.

use crate::images::Shown;
use crate::images::metrics;
use crate::images::metrics::lpips::Lpips;
use crate::photographs::photo::picture::Picture;
use crate::photographs::photo::transfer::Transfer;

const WIDTH: usize = 48;
const HEIGHT: usize = 40;

/// A picture of whole codes, made in the same way as in metrics.py.
fn shown(k: usize) -> Shown {
    let plane = |code: &dyn Fn(usize, usize) -> usize| -> Vec<f32> {
        let codes = (0..WIDTH * HEIGHT).map(|i| code(i % WIDTH, i / WIDTH) % 256);
        let light = codes.map(|code| Transfer::Srgb.to_linear(code as f32 / 255.0));
        light.collect()
    };
    let picture = Picture {
        width: WIDTH,
        height: HEIGHT,
        planes: vec![
            plane(&|x, y| x * 5 + y * 3 + k * ((x * y) % 17)),
            plane(&|x, y| x * 2 + y * 7 + k * ((x + 2 * y) % 23)),
            plane(&|x, y| x * x + y + k * ((3 * x + y) % 29)),
        ],
        transfer: Transfer::Srgb,
        warnings: Vec::new(),
    };
    Shown::new(&picture, 1.0)
}

#[test]
fn values_meet_those_of_other_programs() {
    let (a, b) = (shown(0), shown(2));
    let psnr = metrics::psnr(&a, &b).unwrap();
    // Codes are linearised and encoded again in f32, with an error of 1e-6 each: 10/ln 10 x
    // 2e-6/0.26.
    assert!((psnr - 11.640_472).abs() < 4e-5, "{psnr}");
    let ssim = metrics::ssim(&a, &b);
    assert!((ssim - 0.455_518_05).abs() < 1e-5, "{ssim}");
    let flip = metrics::flip(&a, &b, 67.020_64);
    // The crate holds an earlier release of NVIDIA's code, which rounds differently.
    assert!((flip - 0.528_178).abs() < 1e-3, "{flip}");
}

#[test]
fn equal_pictures_are_equal() {
    let a = shown(1);
    assert_eq!(metrics::psnr(&a, &a), None);
    assert!((metrics::ssim(&a, &a) - 1.0).abs() < 1e-12);
    assert_eq!(metrics::flip(&a, &a, 67.0), 0.0);
    assert_eq!(network().distance(&a, &a), 0.0);
}

fn network() -> Lpips {
    Lpips::from_tensors(weights()).unwrap()
}

/// Weights by formula, made in the same way as in metrics.py: a multiplicative hash of the index
/// and of the tensor's place.
fn weights() -> impl FnMut(&str, usize) -> Result<Vec<f32>, ()> {
    let mut place = 0_u32;
    move |name, count| {
        place += 1;
        let random = |i: u32| {
            let mut hash = i
                .wrapping_mul(2_654_435_761)
                .wrapping_add(place.wrapping_mul(40_503));
            hash ^= hash >> 15;
            hash = hash.wrapping_mul(2_246_822_519);
            hash ^= hash >> 13;
            f64::from(hash) / 4_294_967_296.0
        };
        let scale = |random: f64| match name {
            // A spread that keeps the sums of a layer about as large as its inputs.
            _ if name.starts_with("conv") && name.ends_with("weight") => {
                (random - 0.5) * 4.0 / (count as f64 / OUTPUTS[layer(name)]).sqrt()
            }
            _ if name.ends_with("bias") => 0.1 * (random - 0.5),
            _ => random,
        };
        Ok((0..count as u32).map(|i| scale(random(i)) as f32).collect())
    }
}

const OUTPUTS: [f64; 5] = [64.0, 192.0, 384.0, 256.0, 256.0];

fn layer(name: &str) -> usize {
    usize::from(name.as_bytes()[4] - b'1')
}

#[test]
fn lpips_meets_the_package_on_a_network_of_seeded_weights() {
    let distance = network().distance(&shown(0), &shown(2));
    // Sums of f32 in another order, 6e-8 each, through five layers.
    assert!((distance - RECORDED_LPIPS).abs() < 1e-5, "{distance}");
}

/// LPIPS by lpips 0.1.4 for the same weights and pictures.
const RECORDED_LPIPS: f64 = 0.531_500_5;

#[test]
fn weights_are_read_from_a_file_and_a_broken_one_is_refused() {
    let (mut header, mut data) = (serde_json::Map::new(), Vec::new());
    let mut made = weights();
    Lpips::from_tensors(|name, count| {
        let values = made(name, count)?;
        let start = data.len();
        data.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        let entry = serde_json::json!({
            "dtype": "F32", "shape": [count], "data_offsets": [start, data.len()]
        });
        header.insert(name.to_owned(), entry);
        Ok::<_, ()>(values)
    })
    .unwrap();
    let file = |header: &serde_json::Map<String, serde_json::Value>, data: &[u8]| {
        let header = serde_json::to_vec(header).unwrap();
        [&(header.len() as u64).to_le_bytes(), &header[..], data].concat()
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("weights.safetensors");
    std::fs::write(&path, file(&header, &data)).unwrap();
    let read = Lpips::read(&path).unwrap();
    let (a, b) = (shown(0), shown(2));
    assert_eq!(read.distance(&a, &b), network().distance(&a, &b));

    let mut lacking = header.clone();
    lacking.remove("lin3.weight");
    let mut halves = header.clone();
    halves["conv1.bias"]["dtype"] = "F16".into();
    let cases = [
        (file(&lacking, &data), "lin3.weight"),
        (file(&halves, &data), "conv1.bias"),
        (file(&header, &data[..data.len() - 4]), "lin5.weight"),
        (vec![255; 40], "not a whole safetensors file"),
        (Vec::new(), "not a whole safetensors file"),
    ];
    for (bytes, said) in &cases {
        std::fs::write(&path, bytes).unwrap();
        let error = Lpips::read(&path).unwrap_err().to_string();
        assert!(
            error.contains(said) && error.contains("lpips_weights.py"),
            "{error}"
        );
    }
    assert_eq!(cases.len(), 5);
}
