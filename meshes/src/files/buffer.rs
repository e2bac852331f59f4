//! Bytes of glTF buffers and accessors; each length is checked before it is used.

use std::path::{Component, Path};

use base64::Engine as _;
use glam::DVec3;
use gltf::accessor::{DataType, Dimensions};

use crate::files::load::{MAX_BYTES, read_bounded};
use crate::mesh::digits::single;
use crate::mesh::error::Fault;

/// Contents of the buffers of a glTF document, in its order.
#[derive(Debug)]
pub(crate) struct Buffers {
    /// Bytes of each buffer.
    pub contents: Vec<Vec<u8>>,
    /// For each buffer, true if it came from a file of its own and so is not part of the document's
    /// bytes.
    pub external: Vec<bool>,
}

impl Buffers {
    /// Resolves all buffers: the binary chunk, base64 data URIs, and files in or below `folder`.
    ///
    /// # Errors
    /// Returns [`Fault::BufferUri`] for another scheme, a path that leaves the folder, or bad
    /// base64, [`Fault::BufferUnreadable`] for a file that cannot be read, [`Fault::BufferShort`]
    /// for a buffer that is shorter than declared, and [`Fault::TooLarge`] for more bytes than the
    /// limit.
    pub(crate) fn resolve(
        document: &gltf::Document,
        binary: Option<&[u8]>,
        folder: Option<&Path>,
    ) -> Result<Self, Fault> {
        let mut buffers = Self {
            contents: Vec::new(),
            external: Vec::new(),
        };
        let mut total = 0;
        for buffer in document.buffers() {
            let index = buffer.index();
            let (content, external) = match buffer.source() {
                gltf::buffer::Source::Bin => {
                    let missing = Fault::BufferShort {
                        buffer: index,
                        found: 0,
                        needed: buffer.length(),
                    };
                    (binary.ok_or(missing)?.to_vec(), false)
                }
                gltf::buffer::Source::Uri(uri) => resolve_uri(index, uri, folder)?,
            };
            if content.len() < buffer.length() {
                return Err(Fault::BufferShort {
                    buffer: index,
                    found: content.len(),
                    needed: buffer.length(),
                });
            }
            // A small document may name one large file a thousand times.
            total += content.len() as u64;
            if total > MAX_BYTES {
                return Err(Fault::TooLarge {
                    what: "bytes",
                    found: total,
                    limit: MAX_BYTES,
                });
            }
            buffers.contents.push(content);
            buffers.external.push(external);
        }
        Ok(buffers)
    }

    /// Returns `count` elements of `width` bytes in a view, from `offset` on.
    ///
    /// # Errors
    /// Returns the reason, in words, if they run out of the buffer.
    fn elements<'b>(
        &'b self,
        view: gltf::buffer::View<'_>,
        offset: usize,
        count: usize,
        width: usize,
    ) -> Result<impl Iterator<Item = &'b [u8]>, &'static str> {
        let stride = view.stride().unwrap_or(width);
        if stride < width {
            return Err("its stride is shorter than its elements");
        }
        let outside = "it runs out of its buffer";
        let content = self.contents.get(view.buffer().index()).ok_or(outside)?;
        let end = view.offset().checked_add(view.length()).ok_or(outside)?;
        let content = content
            .get(view.offset()..end)
            .and_then(|c| c.get(offset..))
            .ok_or(outside)?;
        let needed = count
            .checked_sub(1)
            .and_then(|n| n.checked_mul(stride))
            .and_then(|n| n.checked_add(width));
        if count > 0 && needed.is_none_or(|needed| needed > content.len()) {
            return Err(outside);
        }
        Ok((0..count).map(move |element| &content[element * stride..element * stride + width]))
    }

    /// Returns the values of an accessor, each decoded from its little-endian bytes.
    ///
    /// A sparse accessor replaces some of its values; without a view the others are `zero`. The
    /// caller bounds the number of values.
    ///
    /// # Errors
    /// Returns the reason, in words, if the accessor has no bytes, or runs out of its buffer.
    fn values<T: Copy>(
        &self,
        accessor: &gltf::Accessor<'_>,
        zero: T,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, &'static str> {
        let (count, width) = (accessor.count(), accessor.size());
        let mut values: Vec<T> = match accessor.view() {
            Some(view) => self
                .elements(view, accessor.offset(), count, width)?
                .map(&decode)
                .collect(),
            None if accessor.sparse().is_some() => vec![zero; count],
            None => return Err("it has no bytes"),
        };
        let Some(sparse) = accessor.sparse() else {
            return Ok(values);
        };
        let (places, new) = (sparse.indices(), sparse.values());
        let size = places.index_type().size();
        let places = self.elements(places.view(), places.offset(), sparse.count(), size)?;
        let new = self.elements(new.view(), new.offset(), sparse.count(), width)?;
        for (place, bytes) in places.zip(new) {
            let value = values.get_mut(number(place) as usize);
            *value.ok_or("a sparse index is beyond its elements")? = decode(bytes);
        }
        Ok(values)
    }

    /// Returns the positions of an accessor, and the steps in which they are given: vectors of
    /// three f32, or of three integers of 8 or 16 bits (`KHR_mesh_quantization`).
    ///
    /// # Errors
    /// Returns the reason, in words, if the type is another or the elements cannot be read.
    pub(crate) fn positions(
        &self,
        accessor: &gltf::Accessor<'_>,
    ) -> Result<(Vec<DVec3>, Vec<DVec3>), &'static str> {
        if accessor.data_type() == DataType::F32 {
            let positions = self.vectors(accessor)?;
            let steps = positions.iter().map(|&p| single(p)).collect();
            return Ok((positions, steps));
        }
        let (bits, signed) = match accessor.data_type() {
            DataType::I8 => (8, true),
            DataType::U8 => (8, false),
            DataType::I16 => (16, true),
            DataType::U16 => (16, false),
            DataType::U32 | DataType::F32 => return Err("it is made of integers of 32 bits"),
        };
        if accessor.dimensions() != Dimensions::Vec3 {
            return Err("it is not made of three numbers each");
        }
        let largest = f64::from((1_i32 << (bits - i32::from(signed))) - 1);
        let unit = if accessor.normalized() {
            1.0 / largest
        } else {
            1.0
        };
        let decode = |bytes: &[u8]| {
            let component = |bytes: &[u8]| {
                let number = number(bytes) as i32;
                let wraps = signed && number >> (bits - 1) == 1;
                let least = if accessor.normalized() {
                    -largest
                } else {
                    f64::MIN
                };
                // The least integer has no positive counterpart: normalised it is -1 too.
                f64::from(if wraps { number - (1 << bits) } else { number }).max(least) * unit
            };
            let width = bytes.len() / 3;
            DVec3::from_array([0, 1, 2].map(|k| component(&bytes[k * width..(k + 1) * width])))
        };
        let positions = self.values(accessor, DVec3::ZERO, decode)?;
        let steps = vec![DVec3::splat(unit); positions.len()];
        Ok((positions, steps))
    }

    /// Returns the vectors of an accessor of three f32 each, such as normals.
    ///
    /// # Errors
    /// Returns the reason, in words, if the type is another or the elements cannot be read.
    pub(crate) fn vectors(
        &self,
        accessor: &gltf::Accessor<'_>,
    ) -> Result<Vec<DVec3>, &'static str> {
        if (accessor.data_type(), accessor.dimensions()) != (DataType::F32, Dimensions::Vec3) {
            return Err("it is not made of three 32-bit floats each");
        }
        self.values(accessor, DVec3::ZERO, |bytes| {
            let component = |at: usize| f64::from(f32::from_bits(number(&bytes[at..at + 4])));
            DVec3::new(component(0), component(4), component(8))
        })
    }

    /// Returns the indices of an accessor: unsigned integers of 8, 16 or 32 bits.
    ///
    /// # Errors
    /// Returns the reason, in words, if the type is another or the elements cannot be read.
    pub(crate) fn indices(&self, accessor: &gltf::Accessor<'_>) -> Result<Vec<u32>, &'static str> {
        let unsigned = matches!(
            accessor.data_type(),
            DataType::U8 | DataType::U16 | DataType::U32
        );
        if !unsigned || accessor.dimensions() != Dimensions::Scalar {
            return Err("it is not made of unsigned integers");
        }
        self.values(accessor, 0, number)
    }
}

/// Returns the unsigned integer of at most four little-endian bytes.
pub(crate) fn number(bytes: &[u8]) -> u32 {
    bytes
        .iter()
        .rev()
        .fold(0, |number, &byte| number << 8 | u32::from(byte))
}

/// Returns the bytes behind a URI and whether they came from a file of their own.
fn resolve_uri(buffer: usize, uri: &str, folder: Option<&Path>) -> Result<(Vec<u8>, bool), Fault> {
    let shown = || uri.chars().take(60).collect::<String>();
    let wrong = |reason| Fault::BufferUri {
        buffer,
        uri: shown(),
        reason,
    };
    if let Some(data) = uri.strip_prefix("data:") {
        let (media, content) = data.split_once(',').ok_or(wrong("it has no data"))?;
        if !media.ends_with(";base64") {
            return Err(wrong("it is not base64"));
        }
        // Some writers pad base64, others do not.
        let engine = base64::engine::GeneralPurpose::new(
            &base64::alphabet::STANDARD,
            base64::engine::GeneralPurposeConfig::new()
                .with_decode_padding_mode(base64::engine::DecodePaddingMode::Indifferent),
        );
        return engine
            .decode(content.trim())
            .map(|content| (content, false))
            .map_err(|_| wrong("its base64 is damaged"));
    }
    let decoded = percent_decoded(uri).ok_or(wrong("its percent escapes are damaged"))?;
    if decoded.contains(':') {
        return Err(wrong("only data URIs and relative files are read"));
    }
    let relative = Path::new(&decoded);
    if decoded.contains('\\')
        || !relative
            .components()
            .all(|c| matches!(c, Component::Normal(_) | Component::CurDir))
    {
        return Err(wrong("it leaves the folder of the file"));
    }
    let folder = folder.ok_or(wrong("there is no folder to look in"))?;
    let path = folder.join(relative);
    // A link in the folder may lead anywhere, and errors could show what stands there.
    let folder = if folder == Path::new("") {
        Path::new(".")
    } else {
        folder
    };
    if let (Ok(folder), Ok(real)) = (folder.canonicalize(), path.canonicalize())
        && !real.starts_with(folder)
    {
        return Err(wrong("it leaves the folder of the file"));
    }
    match read_bounded(&path, MAX_BYTES) {
        Ok(content) => Ok((content, true)),
        Err(Fault::NotAFile) => Err(wrong("it is no regular file")),
        Err(Fault::Unreadable(source)) => Err(Fault::BufferUnreadable {
            buffer,
            path,
            source,
        }),
        Err(other) => Err(other),
    }
}

/// Decodes the `%XX` escapes of a URI; `None` if they are not hex or not UTF-8.
fn percent_decoded(uri: &str) -> Option<String> {
    let mut bytes = uri.bytes();
    let mut decoded = Vec::with_capacity(uri.len());
    while let Some(byte) = bytes.next() {
        if byte == b'%' {
            let mut digit = || (bytes.next()? as char).to_digit(16);
            decoded.push((digit()? * 16 + digit()?) as u8);
        } else {
            decoded.push(byte);
        }
    }
    String::from_utf8(decoded).ok()
}
