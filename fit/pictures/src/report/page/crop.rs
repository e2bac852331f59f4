//! Crop of a photograph for a warning: the region around its edge, small, with edge and region
//! drawn.

use std::io::Cursor;

use base64::Engine;
use image::{ImageFormat, Rgb, RgbImage};

use edges::photographs::Shot;
use edges::photographs::edge::line::EdgeLine;
use edges::photographs::measure;
use edges::photographs::photo::plane::Photo;

use charts::escape;

/// Longer side of a crop, pixels: sharp on a phone, and 30 kB.
const LONGEST: usize = 240;

/// Margin around the region, as a part of its longer side.
const MARGIN: f64 = 0.15;

/// Colour of saturated pixels.
const CLIPPED: Rgb<u8> = Rgb([230, 40, 30]);

/// Rectangle of pixels: left, top, width, height.
type Rectangle = [usize; 4];

/// Writes a crop as SVG markup.
///
/// It shows the tone-mapped pixels, with the region and its edge as lines. Returns `None` if the
/// photograph cannot be read any more.
pub(crate) fn crop(shot: &Shot, label: &str) -> Option<String> {
    let photo = shot.load().ok()?;
    let measured = measure::edge(&photo, shot.roi, &shot.accepted).ok();
    let whole = [0, 0, photo.width, photo.height];
    let roi = measured.as_ref().map(|m| m.region).or(shot.roi);
    let roi = roi.map_or(whole, |r| [r.x, r.y, r.width, r.height]);
    let view = around(roi, whole);
    let picture = png(&photo, view)?;
    let [x, y, width, height] = view;
    let data = base64::engine::general_purpose::STANDARD.encode(picture);
    let region = if roi == whole {
        String::new()
    } else {
        drawn_region(roi)
    };
    let edge = measured.map_or(String::new(), |m| drawn_edge(m.line, roi));
    Some(format!(
        "<svg class=\"photo\" viewBox=\"{x} {y} {width} {height}\" role=\"img\" aria-label=\"{}\">\
         <image x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" \
         href=\"data:image/png;base64,{data}\"/>\
         {region}{edge}</svg>\n",
        escape(label)
    ))
}

/// Returns the region with its margin, cut at the sides of the picture.
fn around([x, y, width, height]: Rectangle, [_, _, wide, high]: Rectangle) -> Rectangle {
    let margin = (MARGIN * width.max(height) as f64).ceil() as usize;
    let grown = |from: usize, size: usize, all: usize| {
        let low = from.saturating_sub(margin);
        (low, (from + size + margin).min(all) - low)
    };
    let ((x, width), (y, height)) = (grown(x, width, wide), grown(y, height, high));
    [x, y, width, height]
}

/// Encodes a rectangle of a photograph as PNG.
///
/// Blocks of pixels are averaged. The brightness is stretched from the darkest to the brightest 1 %
/// and encoded with a gamma of 2.2.
fn png(photo: &Photo, [x, y, width, height]: Rectangle) -> Option<Vec<u8>> {
    // In camera raw, blocks of 3 x 3 hold at least one pixel of every colour.
    let mosaic = photo.luminance.iter().any(|value| value.is_nan());
    let block = (width.max(height).div_ceil(LONGEST)).max(if mosaic { 3 } else { 1 });
    let size = [width.div_ceil(block), height.div_ceil(block)];
    let saturated = photo.clip_level.unwrap_or(f32::INFINITY);
    let mut means = Vec::with_capacity(size[0] * size[1]);
    for row in 0..size[1] {
        for column in 0..size[0] {
            let rows = y + row * block..(y + (row + 1) * block).min(y + height);
            let columns = x + column * block..(x + (column + 1) * block).min(x + width);
            let (mut sum, mut count, mut clipped) = (0.0_f64, 0_u32, false);
            for line in rows {
                let row = &photo.luminance[line * photo.width..][columns.clone()];
                for &value in row.iter().filter(|value| !value.is_nan()) {
                    sum += f64::from(value);
                    count += 1;
                    clipped |= value >= saturated;
                }
            }
            let mean = match count {
                0 => means.last().map_or(0.0, |&(mean, _)| mean),
                _ => sum / f64::from(count),
            };
            means.push((mean, clipped));
        }
    }
    let mut sorted: Vec<f64> = means.iter().map(|m| m.0).collect();
    sorted.sort_by(f64::total_cmp);
    let percent = sorted.len() / 100;
    let (low, high) = (sorted[percent], sorted[sorted.len() - 1 - percent]);
    let range = if high > low { high - low } else { 1.0 };
    let picture = RgbImage::from_fn(size[0] as u32, size[1] as u32, |column, row| {
        let (mean, clipped) = means[row as usize * size[0] + column as usize];
        if clipped {
            return CLIPPED;
        }
        let grey = 255.0 * ((mean - low) / range).clamp(0.0, 1.0).powf(1.0 / 2.2);
        Rgb([grey.round() as u8; 3])
    });
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, ImageFormat::Png).ok()?;
    Some(bytes.into_inner())
}

/// Draws the region as a frame.
fn drawn_region([x, y, width, height]: Rectangle) -> String {
    format!("<rect class=\"region\" x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"/>")
}

/// Draws the edge, cut at the region in which it was found.
///
/// Pixel (i, j) covers i to i + 1 and j to j + 1.
fn drawn_edge(line: EdgeLine, [x, y, width, height]: Rectangle) -> String {
    let (sin, cos) = line.normal_rad.sin_cos();
    let centre = [
        0.5 * width as f64 + line.offset_px * cos,
        0.5 * height as f64 + line.offset_px * sin,
    ];
    let half = (width + height) as f64;
    // A straight edge has two points, a curved one follows its curve.
    let pieces = if line.bend.is_some() { 128 } else { 1 };
    let points: Vec<String> = (0..=pieces)
        .map(|k| {
            let along = half * (2.0 * f64::from(k) / f64::from(pieces) - 1.0);
            let across = line.bend.map_or(0.0, |bend| bend.at(along).0);
            let x = centre[0] - along * sin + across * cos;
            let y = centre[1] + along * cos + across * sin;
            format!("{x:.1} {y:.1}")
        })
        .collect();
    let path = format!("M{}", points.join("L"));
    format!(
        "<svg x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\">\
         <path class=\"edge under\" d=\"{path}\"/><path class=\"edge\" d=\"{path}\"/></svg>"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use edges::photographs::photo::taken::Taken;

    fn photo() -> Photo {
        // 500 x 300: dark left of column 250, bright right of it, the last column saturated.
        let luminance = (0..500 * 300)
            .map(|i| match i % 500 {
                499 => 1.0,
                x if x >= 250 => 0.8,
                _ => 0.1,
            })
            .collect();
        Photo {
            width: 500,
            height: 300,
            luminance,
            clip_level: Some(1.0),
            clips_alone: true,
            transfer: Taken::default(),
            warnings: Vec::new(),
        }
    }

    #[test]
    fn pixels_are_averaged_stretched_and_marked() {
        let bytes = png(&photo(), [0, 0, 500, 300]).expect("a picture");
        let picture = image::load_from_memory(&bytes).expect("a PNG").to_rgb8();
        // Blocks of 3 pixels make 500 pixels fit into 240.
        assert_eq!(picture.dimensions(), (167, 100));
        assert_eq!(picture.get_pixel(3, 50), &Rgb([0, 0, 0]));
        assert_eq!(picture.get_pixel(160, 50), &Rgb([255, 255, 255]));
        assert_eq!(picture.get_pixel(166, 50), &CLIPPED);
    }

    #[test]
    fn a_region_keeps_its_surroundings() {
        assert_eq!(
            around([100, 20, 200, 100], [0, 0, 500, 300]),
            [70, 0, 260, 150]
        );
        assert_eq!(around([0, 0, 500, 300], [0, 0, 500, 300]), [0, 0, 500, 300]);
    }

    #[test]
    fn the_edge_is_drawn_where_it_lies() {
        // An upright edge 10 pixels right of the centre of a region of 100 x 40.
        let line = EdgeLine {
            normal_rad: 0.0,
            offset_px: 10.0,
            bend: None,
            normal_standard_error_rad: 0.0,
        };
        let drawn = drawn_edge(line, [30, 5, 100, 40]);
        assert!(drawn.contains("x=\"30\" y=\"5\"") && drawn.contains("M60.0 -120.0L60.0 160.0"));
    }
}
