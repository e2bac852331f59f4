//! Tests that TIFFs of all kinds that people have give the light that was written, that the right
//! page is read, and that what is not read is told with a remedy.

use std::path::Path;

use crate::photographs::photo;
use crate::photographs::photo::channel::{Channel, Decode};
use crate::photographs::photo::picture::Picture;
use crate::photographs::photo::plane::Photo;
use crate::photographs::photo::transfer::Transfer;

const WIDTH: usize = 37;
const HEIGHT: usize = 23;

/// A ramp with structure in both directions, in [0, 1).
fn value(x: usize, y: usize) -> f64 {
    ((x * 7 + y * 11) % 97) as f64 / 97.0
}

/// Byte order and size of the numbers of a file.
#[derive(Clone, Copy)]
struct Kind {
    is_little: bool,
    is_big: bool,
}

const PLAIN: Kind = Kind {
    is_little: true,
    is_big: false,
};

/// Layout of the samples of a page.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Layout {
    bits: u32,
    /// 1: whole numbers, 2: signed ones, 3: floats.
    format: u64,
    samples: usize,
    is_planar: bool,
    /// Width and height of a strip or tile.
    part: [usize; 2],
}

const GREY: Layout = Layout {
    bits: 16,
    format: 1,
    samples: 1,
    is_planar: false,
    part: [WIDTH, 5],
};

/// A page: its entries, the data of its parts, and the pages within it.
struct Page {
    entries: Vec<(u64, Vec<u64>)>,
    is_tiled: bool,
    parts: Vec<Vec<u8>>,
    within: Vec<Page>,
}

impl Page {
    /// Makes a page of codes: the stored number of each pixel and sample.
    fn new(
        kind: Kind,
        layout: Layout,
        photometric: u64,
        code: impl Fn(usize, usize, usize) -> f64,
    ) -> Page {
        let Layout {
            bits,
            format,
            samples,
            is_planar,
            part,
        } = layout;
        let is_tiled = part[0] != WIDTH;
        let planes = if is_planar { samples } else { 1 };
        let mut parts = Vec::new();
        for plane in 0..planes {
            for top in (0..HEIGHT).step_by(part[1]) {
                for left in (0..WIDTH).step_by(part[0]) {
                    let rows = if is_tiled {
                        part[1]
                    } else {
                        part[1].min(HEIGHT - top)
                    };
                    let mut bytes = Vec::new();
                    for y in top..top + rows {
                        let mut row = Packed::default();
                        for x in left..left + part[0] {
                            let sample = |k| {
                                if x < WIDTH && y < HEIGHT {
                                    code(x, y, k)
                                } else {
                                    0.0
                                }
                            };
                            let ours = if is_planar {
                                plane..plane + 1
                            } else {
                                0..samples
                            };
                            ours.for_each(|k| row.push(kind, bits, format, sample(k)));
                        }
                        bytes.extend(row.whole());
                    }
                    parts.push(bytes);
                }
            }
        }
        let mut entries = vec![
            (256, vec![WIDTH as u64]),
            (257, vec![HEIGHT as u64]),
            (258, vec![bits.into(); samples]),
            (262, vec![photometric]),
            (277, vec![samples as u64]),
            (284, vec![if is_planar { 2 } else { 1 }]),
            (339, vec![format; samples]),
        ];
        if is_tiled {
            entries.extend([(322, vec![part[0] as u64]), (323, vec![part[1] as u64])]);
        } else {
            entries.push((278, vec![part[1] as u64]));
        }
        Page {
            entries,
            is_tiled,
            parts,
            within: Vec::new(),
        }
    }

    fn with(mut self, tag: u64, values: &[u64]) -> Page {
        self.entries.retain(|(other, _)| *other != tag);
        self.entries.push((tag, values.to_vec()));
        self
    }
}

/// Bits of a row, the first highest.
#[derive(Default)]
struct Packed {
    bytes: Vec<u8>,
    held: u64,
    count: u32,
}

impl Packed {
    fn push(&mut self, kind: Kind, bits: u32, format: u64, code: f64) {
        let number = match (format, bits) {
            (3, 16) => exr::prelude::f16::from_f64(code).to_bits().into(),
            (3, 32) => (code as f32).to_bits().into(),
            (3, _) => code.to_bits(),
            (2, _) => code as i64 as u64,
            _ => code as u64,
        };
        if bits.is_multiple_of(8) {
            self.bytes
                .extend(number_of(number, bits as usize / 8, kind.is_little));
            return;
        }
        (self.held, self.count) = (self.held << bits | number, self.count + bits);
        while self.count >= 8 {
            self.count -= 8;
            self.bytes.push((self.held >> self.count) as u8);
        }
    }

    /// Fills the last byte.
    fn whole(mut self) -> Vec<u8> {
        if self.count > 0 {
            self.bytes.push((self.held << (8 - self.count)) as u8);
        }
        self.bytes
    }
}

fn number_of(number: u64, size: usize, is_little: bool) -> Vec<u8> {
    let mut bytes = number.to_le_bytes()[..size].to_vec();
    if !is_little {
        bytes.reverse();
    }
    bytes
}

/// Writes a TIFF.
fn file(kind: Kind, pages: &[Page]) -> Vec<u8> {
    let Kind { is_little, is_big } = kind;
    let number = |value: u64, size| number_of(value, size, is_little);
    let wide = if is_big { 8 } else { 4 };
    let mut bytes = if is_little {
        b"II".to_vec()
    } else {
        b"MM".to_vec()
    };
    let head = if is_big {
        vec![(43, 2), (8, 2), (0, 2)]
    } else {
        vec![(42, 2)]
    };
    head.into_iter()
        .for_each(|(value, size)| bytes.extend(number(value, size)));
    let first = bytes.len();
    bytes.resize(first + wide, 0);
    chain(&mut bytes, kind, pages, Some(first));
    bytes
}

/// Writes pages. Each is put into the place that the one before it has for it, the first at `to`.
/// Returns their places.
fn chain(bytes: &mut Vec<u8>, kind: Kind, pages: &[Page], mut to: Option<usize>) -> Vec<u64> {
    let wide = if kind.is_big { 8 } else { 4 };
    let number = |value: u64, size| number_of(value, size, kind.is_little);
    let mut places = Vec::new();
    for page in pages {
        let within = chain(bytes, kind, &page.within, None);
        let mut entries = page.entries.clone();
        let mut offsets = Vec::new();
        for part in &page.parts {
            offsets.push(bytes.len() as u64);
            bytes.extend(part);
        }
        let lengths = page.parts.iter().map(|part| part.len() as u64).collect();
        let [place, length] = if page.is_tiled {
            [324, 325]
        } else {
            [273, 279]
        };
        for (tag, list) in [(place, offsets), (length, lengths)] {
            if !page.entries.iter().any(|(own, _)| *own == tag) {
                entries.push((tag, list));
            }
        }
        if !within.is_empty() {
            entries.push((330, within));
        }
        entries.sort();
        // Type 4 holds numbers of 4 bytes, type 1 bytes.
        let is_bytes = |tag| matches!(tag, 270 | 347 | 34675);
        let mut directory = number(entries.len() as u64, if kind.is_big { 8 } else { 2 });
        for (tag, values) in &entries {
            let (type_, size) = if is_bytes(*tag) { (1, 1) } else { (4, 4) };
            directory.extend(
                [
                    number(*tag, 2),
                    number(type_, 2),
                    number(values.len() as u64, wide),
                ]
                .concat(),
            );
            let mut list: Vec<u8> = values.iter().flat_map(|v| number(*v, size)).collect();
            if list.len() > wide {
                directory.extend(number(bytes.len() as u64, wide));
                bytes.append(&mut list);
            } else {
                list.resize(wide, 0);
                directory.append(&mut list);
            }
        }
        let at = bytes.len();
        if let Some(to) = to {
            bytes[to..to + wide].copy_from_slice(&number(at as u64, wide));
        }
        places.push(at as u64);
        bytes.append(&mut directory);
        to = to.map(|_| bytes.len());
        bytes.resize(bytes.len() + wide, 0);
    }
    places
}

/// Gives the bytes to a reader as a file of this name.
fn read<T>(name: &str, bytes: &[u8], reader: impl Fn(&Path) -> T) -> T {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("it is written");
    reader(&path)
}

fn load(bytes: &[u8], channel: Channel) -> Result<Photo, String> {
    let options = Decode {
        transfer: None,
        channel,
    };
    read("a.tif", bytes, |path| {
        photo::load(path, &options).map_err(|e| e.to_string())
    })
}

fn colour(bytes: &[u8]) -> Picture {
    read("a.tif", bytes, |path| {
        photo::load_colour(path, None).expect("it is read")
    })
}

fn srgb(share: f64) -> f64 {
    Transfer::Srgb.to_linear(share as f32).into()
}

/// Asserts the light of all pixels, to a tolerance.
fn assert_light(case: &str, photo: &Photo, light: impl Fn(f64) -> f64, tolerance: f64) {
    assert_eq!((photo.width, photo.height), (WIDTH, HEIGHT), "{case}");
    for (i, &found) in photo.luminance.iter().enumerate() {
        let wanted = light(value(i % WIDTH, i / WIDTH));
        let off = (f64::from(found) - wanted).abs();
        assert!(off <= tolerance, "{case}: {found} for {wanted}");
    }
}

/// Samples of every kind, in both byte orders, as TIFF and BigTIFF. The light is the code over the
/// largest one; f32 rounds it to 6e-8, the sRGB curve to 3e-7, and packed samples of more than 8
/// bits are spread over words, to 1/131070.
#[test]
fn samples_of_every_kind_are_light() {
    let mut cases = 0;
    let kinds = [(true, false), (false, false), (true, true), (false, true)];
    for (is_little, is_big) in kinds {
        let kind = Kind { is_little, is_big };
        for (format, sizes) in [
            (1, vec![1, 2, 4, 8, 10, 12, 14, 16, 32]),
            (2, vec![8, 16, 32]),
            (3, vec![16, 32, 64]),
        ] {
            for bits in sizes {
                for photometric in [1, 0] {
                    // White is 0 only where there is a largest code.
                    if photometric == 0 && (format == 2 || bits == 64 || (format, bits) == (3, 16))
                    {
                        continue;
                    }
                    let layout = Layout {
                        bits,
                        format,
                        ..GREY
                    };
                    let full = match format {
                        1 => (1_u64 << bits) as f64 - 1.0,
                        2 => (1_u64 << (bits - 1)) as f64 - 1.0,
                        _ => 1.0,
                    };
                    let code = |v: f64| match format {
                        1 => (full * v).round(),
                        2 => (full * (2.0 * v - 1.0)).round(),
                        _ => v,
                    };
                    let page = Page::new(kind, layout, photometric, |x, y, _| code(value(x, y)));
                    let light = |v: f64| {
                        let share = code(v) / full;
                        let share = if photometric == 0 { 1.0 - share } else { share };
                        if format == 1 && bits <= 8 {
                            srgb(share)
                        } else {
                            share
                        }
                    };
                    let tolerance = match (format, bits) {
                        (1, 10 | 12 | 14) => 0.5 / 65535.0 + 1e-7,
                        // Halves have 11 bits.
                        (3, 16) => 0.5_f64.powi(11),
                        _ => 4e-7,
                    };
                    let case = format!("{kinds:?} {layout:?} {photometric}");
                    let photo = load(&file(kind, &[page]), Channel::Luminance).expect(&case);
                    assert_light(&case, &photo, light, tolerance);
                    assert_eq!(photo.clip_level, (format != 3).then_some(1.0), "{case}");
                    cases += 1;
                }
            }
        }
    }
    assert_eq!(cases, 4 * (2 * 9 + 3 + 3 + 1));
}

/// Strips and tiles, with the samples of a pixel together or in planes: each channel has its own
/// light, and alpha does not disturb. Tiles in planes made the decoder panic.
#[test]
fn strips_tiles_and_planes_hold_the_same_colours() {
    let mut cases = 0;
    for (bits, format) in [(8, 1), (12, 1), (16, 1), (32, 3)] {
        for part in [[WIDTH, HEIGHT], [WIDTH, 5], [16, 16], [64, 32]] {
            for is_planar in [false, true] {
                for samples in [3, 4, 5] {
                    let layout = Layout {
                        bits,
                        format,
                        samples,
                        is_planar,
                        part,
                    };
                    let full = if format == 3 {
                        1.0
                    } else {
                        (1_u64 << bits) as f64 - 1.0
                    };
                    let share = |v: f64, k: usize| [v, 0.5 * v, 1.0 - v, 0.25, 0.7][k];
                    let code = |v, k| {
                        let code: f64 = full * share(v, k);
                        if format == 3 { code } else { code.round() }
                    };
                    let extra: &[u64] = match samples {
                        3 => &[],
                        4 => &[2],
                        _ => &[2, 0],
                    };
                    let page = Page::new(PLAIN, layout, 2, |x, y, k| code(value(x, y), k));
                    let page = if extra.is_empty() {
                        page
                    } else {
                        page.with(338, extra)
                    };
                    let bytes = file(PLAIN, &[page]);
                    for (k, channel) in Channel::PRIMARIES.into_iter().enumerate() {
                        let case = format!("{layout:?} {channel}");
                        let photo = load(&bytes, channel).expect(&case);
                        let light = |v: f64| {
                            let share = code(v, k) / full;
                            if bits == 8 { srgb(share) } else { share }
                        };
                        // Of 12 bits, spread over words.
                        let spread = if bits == 12 { 0.5 / 65535.0 } else { 0.0 };
                        assert_light(&case, &photo, light, 4e-7 + spread);
                        cases += 1;
                    }
                }
            }
        }
    }
    assert_eq!(cases, 4 * 4 * 2 * 3 * 3);
}

/// Palettes of grey and of colours, YCbCr within a JPEG and without: the colours are those that
/// other programs show. A JPEG is compared with the reader of JPEG files, whose conversion rounds
/// to one code, 2.3/255 of light at most.
#[test]
fn palettes_and_luma_are_colours() {
    let layout = Layout { bits: 8, ..GREY };
    let code = |x, y| (255.0 * value(x, y)).round();
    let indexed = Page::new(PLAIN, layout, 3, |x, y, _| code(x, y));
    let map = |k: usize, i: u64| match k {
        0 => i,
        1 => 255 - i,
        _ => i / 2,
    };
    let grey: Vec<u64> = (0..768).map(|i| 256 * (255 - i % 256)).collect();
    let bytes = file(PLAIN, &[indexed.with(320, &grey)]);
    let photo = load(&bytes, Channel::Luminance).expect("it is read");
    assert_light(
        "grey",
        &photo,
        |v| srgb(1.0 - (255.0 * v).round() / 255.0),
        4e-7,
    );
    assert!(photo.warnings.iter().all(|text| !text.contains("palette")));
    assert_eq!(colour(&bytes).planes.len(), 1);

    let coloured: Vec<u64> = (0..768)
        .map(|i| 257 * map(i / 256, i as u64 % 256))
        .collect();
    let indexed = Page::new(PLAIN, layout, 3, |x, y, _| code(x, y));
    let bytes = file(PLAIN, &[indexed.with(320, &coloured)]);
    for (k, channel) in Channel::PRIMARIES.into_iter().enumerate() {
        let photo = load(&bytes, channel).expect("it is read");
        let light = |v: f64| srgb(map(k, (255.0 * v).round() as u64) as f64 / 255.0);
        assert_light("palette", &photo, light, 4e-7);
        assert!(photo.warnings.iter().any(|text| text.contains("palette")));
    }

    let picture = image::RgbImage::from_fn(WIDTH as u32, HEIGHT as u32, |x, y| {
        image::Rgb([(6 * x) as u8, (9 * y) as u8, (200 - 3 * x) as u8])
    });
    let mut jpeg = Vec::new();
    image::codecs::jpeg::JpegEncoder::new_with_quality(&mut jpeg, 95)
        .encode_image(&picture)
        .expect("memory takes it");
    let shown = image::load_from_memory(&jpeg)
        .expect("it is a JPEG")
        .to_rgb8();
    let layout = Layout {
        bits: 8,
        samples: 3,
        part: [WIDTH, HEIGHT],
        ..GREY
    };
    let mut packed = Page::new(PLAIN, layout, 6, |_, _, _| 0.0).with(259, &[7]);
    packed.parts = vec![jpeg];
    // Without a JPEG: luma and differences as JFIF defines them, and what they stand for.
    let luma = |x: usize, y: usize| {
        [
            x as f64 * 4.0 + 30.0,
            y as f64 * 3.0 + 90.0,
            140.0 - x as f64,
        ]
    };
    let plain = Page::new(PLAIN, layout, 6, |x, y, k| luma(x, y)[k]).with(530, &[1, 1]);
    let rgb = |[y, b, r]: [f64; 3]| {
        let (b, r) = (b - 128.0, r - 128.0);
        [
            y + 1.402 * r,
            y - 0.344_136 * b - 0.714_136 * r,
            y + 1.772 * b,
        ]
    };
    let code = |x: usize, y: usize, k: usize| rgb(luma(x, y))[k].clamp(0.0, 255.0);
    let stored = |x: usize, y: usize, k: usize| f64::from(shown.get_pixel(x as u32, y as u32).0[k]);
    type Codes<'a> = &'a dyn Fn(usize, usize, usize) -> f64;
    let cases: [(&str, Page, Codes); 2] = [("JPEG", packed, &stored), ("plain", plain, &code)];
    let mut pixels = 0;
    for (case, page, wanted) in cases {
        let picture = colour(&file(PLAIN, &[page]));
        for (k, plane) in picture.planes.iter().enumerate() {
            for (i, found) in plane.iter().enumerate() {
                let wanted = srgb(wanted(i % WIDTH, i / WIDTH, k) / 255.0);
                assert!(
                    (f64::from(*found) - wanted).abs() < 2.3 / 255.0,
                    "{case} {k} {i}"
                );
                pixels += 1;
            }
        }
    }
    assert_eq!(pixels, 2 * 3 * WIDTH * HEIGHT);
}

/// Colours that were multiplied by their alpha are the light; those that were not are multiplied
/// once; a sample that the file does not explain is left out.
#[test]
fn alpha_counts_once() {
    let layout = Layout { samples: 4, ..GREY };
    let mut cases = 0;
    // Half of full scale is 32768 of 65535.
    let half = 32768.0 / 65535.0;
    for (extra, share, says) in [
        (1, 1.0, "stored"),
        (2, half, "black"),
        (0, 1.0, "4 samples"),
    ] {
        let code = |v: f64, k: usize| {
            if k < 3 {
                (30000.0 * v).round()
            } else {
                32768.0
            }
        };
        let page = Page::new(PLAIN, layout, 2, |x, y, k| code(value(x, y), k));
        let picture = colour(&file(PLAIN, &[page.with(338, &[extra])]));
        for plane in &picture.planes {
            for (i, found) in plane.iter().enumerate() {
                let wanted = share * code(value(i % WIDTH, i / WIDTH), 0) / 65535.0;
                assert!((f64::from(*found) - wanted).abs() < 1e-6, "{extra} {i}");
            }
            cases += 1;
        }
        let told = picture.warnings.iter().any(|text| text.contains(says));
        assert!(told, "{extra}: {:?}", picture.warnings);
    }
    assert_eq!(cases, 9);
}

/// The first page that is neither a smaller copy nor a mask is the picture. Other pictures of a
/// file are told, smaller copies are not.
#[test]
fn the_picture_is_the_full_page() {
    // The pages differ by their light, in twentieths.
    let page = |twentieths: u64, kind: Option<u64>| {
        let page = Page::new(PLAIN, GREY, 1, |_, _, _| 3000.0 * twentieths as f64);
        match kind {
            Some(kind) => page.with(254, &[kind]),
            None => page,
        }
    };
    let text = |words: &str| words.bytes().map(u64::from).collect::<Vec<_>>();
    let within = |mut page: Page, inner: Page| {
        page.within = vec![inner];
        page
    };
    let cases: Vec<(&str, Vec<Page>, u64, &str)> = vec![
        ("one page", vec![page(1, None)], 1, ""),
        (
            "a thumbnail first",
            vec![page(1, Some(1)), page(2, Some(0))],
            2,
            "page 2",
        ),
        (
            "a mask first",
            vec![page(1, Some(4)), page(2, None)],
            2,
            "page 2",
        ),
        (
            "old thumbnail first",
            vec![page(1, None).with(255, &[2]), page(2, None)],
            2,
            "page 2",
        ),
        (
            "a pyramid",
            vec![page(1, Some(0)), page(2, Some(1)), page(3, Some(1))],
            1,
            "",
        ),
        (
            "a stack",
            vec![page(1, Some(2)), page(2, Some(2)), page(3, Some(2))],
            1,
            "2 more pages",
        ),
        (
            "a stack of ImageJ",
            vec![page(1, None).with(270, &text("ImageJ=1.54f\nimages=40\nslices=40\n"))],
            1,
            "39 more pages",
        ),
        (
            "a thumbnail around",
            vec![within(page(1, Some(1)), page(2, Some(0)))],
            2,
            "within it",
        ),
        (
            "thumbnails only",
            vec![page(1, Some(1)), page(2, Some(1))],
            1,
            "smaller copies",
        ),
    ];
    let mut count = 0;
    for (case, pages, wanted, says) in cases {
        let photo = load(&file(PLAIN, &pages), Channel::Luminance).expect(case);
        let light = 3000.0 * wanted as f32 / 65535.0;
        assert!(
            photo.luminance.iter().all(|v| (v - light).abs() < 1e-6),
            "{case}"
        );
        let told = photo.warnings.join("; ");
        assert!(
            if says.is_empty() {
                told.is_empty()
            } else {
                told.contains(says)
            },
            "{case}: {told}"
        );
        count += 1;
    }
    assert_eq!(count, 9);
}

/// Camera raw is told whatever its name is: a DNG, and a mosaic in a page or within one.
#[cfg(not(feature = "raw"))]
#[test]
fn camera_raw_under_another_name_is_camera_raw() {
    let page = || Page::new(PLAIN, GREY, 1, |x, y, _| (30000.0 * value(x, y)).round());
    let mosaic = || Page::new(PLAIN, GREY, 32803, |_, _, _| 1.0);
    let mut around = page().with(254, &[1]);
    around.within = vec![mosaic()];
    let cases = [page().with(50706, &[1]), mosaic(), around];
    let count = cases.len();
    for page in cases {
        let error = load(&file(PLAIN, &[page]), Channel::Luminance).expect_err("it is refused");
        assert!(error.contains("camera raw"), "{error}");
    }
    assert_eq!(count, 3);
}

/// What is not read is named, with the kind of file to save.
#[test]
fn what_is_not_read_is_told_with_a_remedy() {
    let page = || Page::new(PLAIN, Layout { bits: 8, ..GREY }, 1, |_, _, _| 1.0);
    let of = |layout: Layout, photometric| Page::new(PLAIN, layout, photometric, |_, _, _| 1.0);
    let three = Layout {
        bits: 8,
        samples: 3,
        ..GREY
    };
    let cases = [
        ("ZSTD", page().with(259, &[50000])),
        ("LZMA", page().with(259, &[34925])),
        ("WebP", page().with(259, &[50001])),
        ("JPEG 2000", page().with(259, &[34712])),
        ("JPEG of an old kind", page().with(259, &[6])),
        ("fax", page().with(259, &[4])),
        ("compression 12345", page().with(259, &[12345])),
        ("L*a*b*", of(three, 8)),
        ("LogLuv", of(three, 32845)),
        ("mask", page().with(262, &[4])),
        ("kind 99", page().with(262, &[99])),
        ("24 bits", of(Layout { bits: 24, ..GREY }, 1)),
        (
            "floats of 24 bits",
            of(
                Layout {
                    bits: 24,
                    format: 3,
                    ..GREY
                },
                1,
            ),
        ),
        ("samples of the kind 6", page().with(339, &[6])),
        ("a palette in samples of 16 bits", of(GREY, 3)),
        ("unlike bits", of(three, 2).with(258, &[5, 6, 5])),
        ("fewer colours than pixels", of(three, 6).with(530, &[2, 2])),
        ("FillOrder 2", page().with(266, &[2])),
    ];
    let count = cases.len();
    for (named, page) in cases {
        let error = load(&file(PLAIN, &[page]), Channel::Luminance).expect_err(named);
        let save = "which fit does not read; save it as a TIFF of 16 bits";
        assert!(
            error.contains(named) && error.contains(save),
            "{named}: {error}"
        );
    }
    let four = Layout {
        bits: 8,
        samples: 4,
        ..GREY
    };
    let error = load(&file(PLAIN, &[of(four, 5)]), Channel::Luminance).expect_err("CMYK");
    assert!(error.contains("CMYK picture"), "{error}");
    assert_eq!(count, 18);
}

/// Makes a page of grey strips that are JPEGs. If `apart`, the tables of quantisation and of Huffman
/// codes, which all strips share, stand in the tag `JPEGTables`.
fn of_jpegs(apart: bool) -> Page {
    let rows = 8;
    let layout = Layout {
        bits: 8,
        part: [WIDTH, rows],
        ..GREY
    };
    let mut page = Page::new(PLAIN, layout, 1, |_, _, _| 0.0).with(259, &[7]);
    let mut tables = vec![0xff, 0xd8];
    let strip = |top: usize| {
        let rows = rows.min(HEIGHT - top);
        let code = |i: usize| (200.0 * value(i % WIDTH, top + i / WIDTH)) as u8;
        let pixels: Vec<u8> = (0..WIDTH * rows).map(code).collect();
        let mut bytes = Vec::new();
        let mut encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, 90);
        let grey = image::ExtendedColorType::L8;
        let encoded = encoder.encode(&pixels, WIDTH as u32, rows as u32, grey);
        encoded.expect("memory takes it");
        bytes
    };
    page.parts = (0..HEIGHT).step_by(rows).map(strip).collect();
    if apart {
        for (i, strip) in page.parts.iter_mut().enumerate() {
            let mut at = 2;
            // The marker of the scan ends the headers.
            while strip[at + 1] != 0xda {
                let length = usize::from(u16::from_be_bytes([strip[at + 2], strip[at + 3]]));
                match strip[at + 1] {
                    0xdb | 0xc4 => {
                        let table = strip.drain(at..at + 2 + length);
                        if i == 0 {
                            tables.extend(table);
                        }
                    }
                    _ => at += 2 + length,
                }
            }
        }
        let tables = tables.iter().chain(&[0xff, 0xd9]);
        let tables: Vec<u64> = tables.map(|&byte| byte.into()).collect();
        page = page.with(347, &tables);
    }
    page
}

/// The first and the last strip are cut at every fifth byte. The cut is left as it is, or the marker
/// of the end or zeros follow it.
#[test]
fn a_strip_that_is_cut_short_is_refused() {
    let mut lights = Vec::new();
    let mut count = 0;
    for apart in [false, true] {
        let mut page = of_jpegs(apart);
        let bytes = file(PLAIN, std::slice::from_ref(&page));
        lights.push(
            load(&bytes, Channel::Luminance)
                .expect("it is whole")
                .luminance,
        );
        for index in [0, page.parts.len() - 1] {
            let strip = page.parts[index].clone();
            // The marker of the end has 2 bytes, and the last byte of the data may be filling.
            for length in (0..strip.len() - 3).step_by(5) {
                let cut = &strip[..length];
                let filling = vec![0; strip.len() - length];
                for behind in [&filling[..0], &[0xff, 0xd9], &filling] {
                    page.parts[index] = [cut, behind].concat();
                    let bytes = file(PLAIN, std::slice::from_ref(&page));
                    let error = load(&bytes, Channel::Luminance).err();
                    let error = error.unwrap_or_else(|| panic!("{index} cut to {length}"));
                    assert!(error.contains("again") && !error.contains('\n'), "{error}");
                    count += 1;
                }
            }
            page.parts[index] = strip;
        }
    }
    assert_eq!(lights[0], lights[1]);
    assert!(count > 900, "{count}");
}

/// Strips outside of the file, and strips that claim more than the file, are refused.
#[test]
fn strips_without_bytes_are_refused() {
    let page = of_jpegs(false);
    let lengths: Vec<u64> = page.parts.iter().map(|it| it.len() as u64).collect();
    let longer = |place: usize| {
        let mut lengths = lengths.clone();
        lengths[place] = u32::MAX.into();
        (279, lengths)
    };
    let outside = (273, vec![u32::MAX.into(); lengths.len()]);
    let cases = (0..lengths.len()).map(longer).chain([outside]);
    let mut count = 0;
    for (tag, list) in cases {
        let bytes = file(PLAIN, &[of_jpegs(false).with(tag, &list)]);
        let error = load(&bytes, Channel::Luminance).expect_err("it claims too much");
        assert!(error.contains("again"), "{error}");
        count += 1;
    }
    assert_eq!(count, 4);
}

/// Every byte of a small TIFF, replaced by others, ends in a picture or an error.
#[test]
#[ignore = "seconds: `make test-full` runs it"]
fn damaged_directories_are_errors_or_pictures() {
    let mut page = Page::new(
        PLAIN,
        Layout {
            bits: 8,
            part: [16, 16],
            ..GREY
        },
        1,
        |x, y, _| (255.0 * value(x, y)).round(),
    );
    page.within = vec![Page::new(PLAIN, GREY, 1, |_, _, _| 9.0)];
    let mut cases = [0, 0];
    for is_big in [false, true] {
        let whole = file(Kind { is_big, ..PLAIN }, std::slice::from_ref(&page));
        let pixels = 3 * 2 * 256 + WIDTH * HEIGHT * 2;
        for at in (0..16).chain(pixels..whole.len()) {
            for byte in [0, 1, 3, 0x7f, 0xff] {
                let mut bytes = whole.clone();
                bytes[at] = byte;
                cases[usize::from(load(&bytes, Channel::Luminance).is_ok())] += 1;
            }
        }
    }
    assert!(cases.iter().all(|&count| count > 500), "{cases:?}");
}
