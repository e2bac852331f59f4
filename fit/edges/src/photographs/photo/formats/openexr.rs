//! Reading of EXR photographs: the layer and channels are chosen, and their blocks streamed into
//! planes.

use std::collections::HashSet;
use std::fs::File;
use std::io::BufReader;

use exr::block::UncompressedBlock;
use exr::block::reader::ChunksReader;
use exr::error::Error as ExrError;
use exr::meta::attribute::{Chromaticities, SampleType};
use exr::meta::header::Header;
use exr::prelude::f16;
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use crate::photographs::photo::{
    Channel, Curve, Curves, Decode, Fault, Format, GIVEN, Photo, Picture, REC709, Taken, Transfer,
    caught, check_packed, check_size,
};

/// Bit of the version field that means "deep data inside" (OpenEXR file layout, version field).
const DEEP_FLAG: u8 = 0x08;

/// Number of blocks that are unpacked at a time.
const AT_ONCE: usize = 16;

/// Channels of the file by their index, with their weights in a plane.
type Terms = Vec<(usize, f32)>;

/// Reads the plane that `options` ask for. `first` holds the first bytes of the file.
pub(in crate::photographs::photo) fn read(
    reader: BufReader<File>,
    first: &[u8],
    options: &Decode,
) -> Result<Photo, Fault> {
    let mut half_only = false;
    let mut alone = false;
    let transfer = options.transfer.unwrap_or(Transfer::Linear);
    let (width, height, mut planes, warnings) = read_planes(reader, first, transfer, |headers| {
        let (header, terms, warnings) = select(headers, &options.channel)?;
        let stored = &headers[header].channels.list;
        alone = terms.len() == 1;
        let is_half = |term: &(usize, f32)| stored[term.0].sample_type == SampleType::F16;
        half_only = terms.iter().all(is_half);
        Ok((header, vec![terms], warnings))
    })?;
    let luminance = planes.swap_remove(0);
    let largest = luminance.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let clip_level = if largest == 1.0 {
        Some(1.0)
    } else if half_only && transfer == Transfer::Linear {
        Some(f16::MAX.to_f32())
    } else {
        None
    };
    Ok(Photo {
        width,
        height,
        luminance,
        clip_level,
        clips_alone: alone,
        transfer: match options.transfer {
            Some(given) => Curves::one(Curve::Named(given), GIVEN).taken(),
            None => Taken::linear("EXR"),
        },
        warnings,
    })
}

/// Reads red, green and blue, or the luminance if the file has no colour.
pub(crate) fn read_colour(reader: BufReader<File>, first: &[u8]) -> Result<Picture, Fault> {
    let mut differences = None;
    let (width, height, mut planes, warnings) =
        read_planes(reader, first, Transfer::Linear, |headers| {
            let single = |index| vec![(index, 1.0)];
            for layer in layers(headers) {
                let indices = if let [Some(red), Some(green), Some(blue)] = layer.primaries() {
                    [red, green, blue]
                } else if let Some(indices) = layer.differences() {
                    let primaries = headers[layer.header].shared_attributes.chromaticities;
                    differences = Some(primaries.map_or(Some(REC709), weights));
                    indices
                } else {
                    continue;
                };
                return Ok((layer.header, indices.map(single).to_vec(), Vec::new()));
            }
            let (header, terms, warnings) = select(headers, &Channel::Luminance)?;
            Ok((header, vec![terms], warnings))
        })?;
    if let (Some(weights), [red, luma, blue]) = (differences, &mut planes[..]) {
        let lack = || Fault::Damaged(Format::Exr, "its primaries make no colours".into());
        let weights = weights.ok_or_else(lack)?;
        let pixels = red.iter_mut().zip(luma).zip(blue);
        pixels.for_each(|((red, green), blue)| {
            let luma = *green;
            (*red, *blue) = ((1.0 + *red) * luma, (1.0 + *blue) * luma);
            *green = (luma - weights[0] * *red - weights[2] * *blue) / weights[1];
        });
    }
    Ok(Picture {
        width,
        height,
        planes,
        transfer: Transfer::Linear,
        warnings,
    })
}

/// Returns the share of red, green and blue in luminance for the primaries of a file: the amounts
/// that make its white (SMPTE RP 177). Returns `None` if they do not make it.
fn weights(primaries: Chromaticities) -> Option<[f32; 3]> {
    let light = |at: exr::math::Vec2<f32>| {
        let [x, y] = [at.x(), at.y()].map(f64::from);
        Vector3::new(x / y, 1.0, (1.0 - x - y) / y)
    };
    let columns = [primaries.red, primaries.green, primaries.blue].map(light);
    let amounts = Matrix3::from_columns(&columns)
        .lu()
        .solve(&light(primaries.white))?;
    let weights = [0, 1, 2].map(|k| amounts[k] as f32);
    (weights.iter().all(|w| w.is_finite()) && weights[1] > 0.0).then_some(weights)
}

/// Width, height, planes and warnings of a picture.
type Planes = (usize, usize, Vec<Vec<f32>>, Vec<String>);

/// Reads planes, each of which is the sum of its terms. `choose` picks the header and the terms.
fn read_planes(
    reader: BufReader<File>,
    first: &[u8],
    transfer: Transfer,
    choose: impl FnOnce(&[Header]) -> Result<(usize, Vec<Terms>, Vec<String>), Fault>,
) -> Result<Planes, Fault> {
    if first.get(5).is_some_and(|flags| flags & DEEP_FLAG != 0) {
        return Err(Fault::Deep);
    }
    let broken = |error: ExrError| match error {
        ExrError::NotSupported(what) => {
            Fault::Unread(Format::Exr, format!("what its decoder calls \"{what}\""))
        }
        error => Fault::Damaged(Format::Exr, error.to_string()),
    };
    let length = reader.get_ref().metadata()?.len();
    let blocks = exr::block::read(reader, false).map_err(broken)?;
    let (chosen, terms, warnings) = choose(blocks.headers())?;
    let header = &blocks.headers()[chosen];
    if header.deep {
        return Err(Fault::Deep);
    }
    let (width, height) = (header.layer_size.width(), header.layer_size.height());
    check_size(width as u64, height as u64)?;
    let bytes = header.channels.bytes_per_pixel as u64;
    check_packed([width as u64, height as u64], bytes, length)?;
    let mut planes = vec![vec![0.0_f32; width * height]; terms.len()];
    let mut chunks = blocks
        .filter_chunks(false, |_, tile, block| {
            block.layer == chosen && tile.is_largest_resolution_level()
        })
        .map_err(broken)?;
    let meta = chunks.meta_data().clone();
    // Blocks are found by offsets, and two offsets may be the same.
    let (mut seen, mut covered) = (HashSet::new(), 0);
    loop {
        let packed: Vec<_> = chunks.by_ref().take(AT_ONCE).collect();
        if packed.is_empty() {
            break;
        }
        // The decoder's own threads would end the program if one of them panicked.
        let unpacked = packed.into_par_iter().map(|chunk| {
            caught(|| UncompressedBlock::decompress_chunk(chunk?, &meta, false))
                .unwrap_or_else(|reason| Err(ExrError::Invalid(reason.into())))
        });
        let unpacked: Vec<_> = unpacked.collect();
        for block in unpacked {
            let block = block.map_err(broken)?;
            let (at, size) = (block.index.pixel_position, block.index.pixel_size);
            if !seen.insert((at.x(), at.y())) {
                return Err(broken(ExrError::Invalid("a block is there twice".into())));
            }
            covered += size.area();
            for (plane, terms) in planes.iter_mut().zip(&terms) {
                let header = &meta.headers[chosen];
                add_block(plane, width, header, &block, terms, transfer).map_err(broken)?;
            }
        }
    }
    if covered != width * height {
        return Err(broken(ExrError::Invalid("blocks are missing".into())));
    }
    Ok((width, height, planes, warnings))
}

/// Adds the lines of one block to the plane, for the channels among `terms`.
fn add_block(
    plane: &mut [f32],
    width: usize,
    header: &Header,
    block: &UncompressedBlock,
    terms: &Terms,
    transfer: Transfer,
) -> exr::error::UnitResult {
    for line in block.lines(&header.channels) {
        let at = line.location;
        let Some((_, weight)) = terms.iter().find(|(index, _)| *index == at.channel) else {
            continue;
        };
        let start = at.position.y() * width + at.position.x();
        let pixels = plane.get_mut(start..start + at.sample_count);
        let outside = || ExrError::Invalid("a block lies outside the data window".into());
        let kind = header.channels.list[at.channel].sample_type;
        let samples = line.value.chunks_exact(kind.bytes_per_sample());
        for (pixel, bytes) in pixels.ok_or_else(outside)?.iter_mut().zip(samples) {
            let stored = match (kind, bytes) {
                (SampleType::F16, &[a, b]) => f16::from_ne_bytes([a, b]).to_f32(),
                (SampleType::F32, &[a, b, c, d]) => f32::from_ne_bytes([a, b, c, d]),
                (SampleType::U32, &[a, b, c, d]) => u32::from_ne_bytes([a, b, c, d]) as f32,
                _ => unreachable!("a half has 2 bytes, the others have 4"),
            };
            *pixel += weight * transfer.to_linear(stored);
        }
    }
    Ok(())
}

/// Channels of one layer: those of one header whose names are the same up to the last dot.
struct Layer {
    header: usize,
    name: String,
    /// Index in the header and last part of the name of each channel.
    channels: Vec<(usize, String)>,
}

impl Layer {
    fn find(&self, names: [&str; 2]) -> Option<usize> {
        let is_named = |name: &str| names.iter().any(|wanted| name.eq_ignore_ascii_case(wanted));
        let mut channels = self.channels.iter();
        Some(channels.find(|(_, name)| is_named(name))?.0)
    }

    fn primaries(&self) -> [Option<usize>; 3] {
        [
            self.find(["R", "red"]),
            self.find(["G", "green"]),
            self.find(["B", "blue"]),
        ]
    }

    /// Returns the channels of luminance and colour differences, which programs write to save room:
    /// (R - Y)/Y, Y and (B - Y)/Y.
    fn differences(&self) -> Option<[usize; 3]> {
        let [red, luma, blue] = ["RY", "Y", "BY"].map(|name| self.find([name, name]));
        Some([red?, luma?, blue?])
    }

    /// Returns the only channel that is not transparency, or `None` if there are none or several.
    fn only(&self) -> Option<usize> {
        let mut colours = self.channels.iter().filter(|(_, name)| !is_alpha(name));
        match (colours.next(), colours.next()) {
            (Some((index, _)), None) => Some(*index),
            _ => None,
        }
    }

    fn terms(&self, channel: &Channel) -> Option<Terms> {
        let one = |index: Option<usize>| index.map(|index| vec![(index, 1.0)]);
        match (channel, self.primaries()) {
            (Channel::Luminance, [Some(red), Some(green), Some(blue)]) => {
                Some([red, green, blue].into_iter().zip(REC709).collect())
            }
            (Channel::Luminance, _) => one(self.find(["Y", "luminance"]).or_else(|| self.only())),
            (Channel::Red, [red, _, _]) => one(red),
            (Channel::Green, [_, green, _]) => one(green),
            (Channel::Blue, [_, _, blue]) => one(blue),
            (Channel::Named(_), _) => None,
        }
    }
}

fn is_alpha(name: &str) -> bool {
    name.eq_ignore_ascii_case("A") || name.eq_ignore_ascii_case("alpha")
}

fn layers(headers: &[Header]) -> Vec<Layer> {
    let mut layers: Vec<Layer> = Vec::new();
    for (header, contents) in headers.iter().enumerate() {
        let part = contents.own_attributes.layer_name.as_ref();
        let part = part.map(ToString::to_string).unwrap_or_default();
        for (index, channel) in contents.channels.list.iter().enumerate() {
            let full = channel.name.to_string();
            let (prefix, last) = full.rsplit_once('.').unwrap_or(("", &full));
            let joint = if part.is_empty() || prefix.is_empty() {
                ""
            } else {
                "."
            };
            let name = [&part, joint, prefix].concat();
            let of_name = |layer: &&mut Layer| layer.header == header && layer.name == name;
            match layers.iter_mut().find(of_name) {
                Some(layer) => layer.channels.push((index, last.to_owned())),
                None => layers.push(Layer {
                    header,
                    name,
                    channels: vec![(index, last.to_owned())],
                }),
            }
        }
    }
    layers
}

/// Finds the first layer that has the plane that was asked for. Returns its header, the channels
/// whose weighted sum is the plane, and warnings.
fn select(headers: &[Header], wanted: &Channel) -> Result<(usize, Terms, Vec<String>), Fault> {
    let layers = layers(headers);
    let mut warnings = Vec::new();
    if let Channel::Named(name) = wanted {
        for (header, contents) in headers.iter().enumerate() {
            let mut channels = contents.channels.list.iter();
            if let Some(index) = channels.position(|channel| channel.name.to_string() == *name) {
                return Ok((header, vec![(index, 1.0)], warnings));
            }
        }
    }
    let able: Vec<_> = layers
        .iter()
        .filter_map(|layer| Some((layer, layer.terms(wanted)?)))
        .collect();
    let Some((layer, terms)) = able.first() else {
        let found = headers
            .iter()
            .flat_map(|header| header.channels.list.iter().map(|it| it.name.to_string()))
            .collect();
        return Err(Fault::NoChannel(wanted.clone(), found));
    };
    if able.len() > 1 {
        let name = if layer.name.is_empty() {
            "the one without a name"
        } else {
            &layer.name
        };
        warnings.push(format!(
            "{} layers hold a picture; {name} was used; to use another, set `channel` to the full \
            name of a channel",
            able.len()
        ));
    }
    if layer.channels.iter().any(|(_, name)| is_alpha(name)) {
        warnings.push("the alpha channel was ignored".into());
    }
    let stored = &headers[layer.header].channels.list;
    if *wanted == Channel::Luminance && terms.len() == 1 && layer.find(["Y", "luminance"]).is_none()
    {
        warnings.push(format!(
            "the file has neither Y nor R, G and B; its only channel, {}, was used as luminance",
            stored[terms[0].0].name
        ));
    }
    let primaries = headers[layer.header].shared_attributes.chromaticities;
    if terms.len() == 3 && primaries.is_some() {
        warnings.push(
            "the file names its own primaries, but its luminance was computed with the Rec. 709 \
            weights"
                .into(),
        );
    }
    Ok((layer.header, terms.clone(), warnings))
}
