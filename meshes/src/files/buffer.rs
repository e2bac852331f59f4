//! Bytes of glTF buffers and accessors; each length is checked before it is used.

use std::path::{Component, Path};

use base64::Engine as _;
use gltf::accessor::{DataType, Dimensions};

use crate::files::bounded::{MAX_BYTES, read_bounded};
use crate::mesh::error::{Counted, Fault};

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
                    what: Counted::Bytes,
                    found: total,
                    limit: MAX_BYTES,
                });
            }
            buffers.contents.push(content);
            buffers.external.push(external);
        }
        Ok(buffers)
    }

    /// Returns the elements of an accessor as little-endian bytes, each as long as its type.
    ///
    /// # Errors
    /// Returns the reason, in words, if the accessor is sparse, has no view, or runs out of its
    /// buffer.
    fn elements<'b>(
        &'b self,
        accessor: &gltf::Accessor<'_>,
    ) -> Result<impl Iterator<Item = &'b [u8]>, &'static str> {
        if accessor.sparse().is_some() {
            return Err("it is sparse");
        }
        let view = accessor
            .view()
            .ok_or("it has no bytes: compressed meshes are not read")?;
        let width = accessor.size();
        let stride = view.stride().unwrap_or(width);
        if stride < width {
            return Err("its stride is shorter than its elements");
        }
        let outside = "it runs out of its buffer";
        let content = self.contents.get(view.buffer().index()).ok_or(outside)?;
        let end = view.offset().checked_add(view.length()).ok_or(outside)?;
        let content = content
            .get(view.offset()..end)
            .and_then(|c| c.get(accessor.offset()..))
            .ok_or(outside)?;
        let count = accessor.count();
        let needed = count
            .checked_sub(1)
            .and_then(|n| n.checked_mul(stride))
            .and_then(|n| n.checked_add(width));
        if count > 0 && needed.is_none_or(|needed| needed > content.len()) {
            return Err(outside);
        }
        Ok((0..count).map(move |element| &content[element * stride..element * stride + width]))
    }

    /// Returns the positions of an accessor: vectors of three f32.
    ///
    /// # Errors
    /// Returns the reason, in words, if the type is another or the elements cannot be read.
    pub(crate) fn positions(
        &self,
        accessor: &gltf::Accessor<'_>,
    ) -> Result<Vec<[f32; 3]>, &'static str> {
        if (accessor.data_type(), accessor.dimensions()) != (DataType::F32, Dimensions::Vec3) {
            return Err("it is not made of three 32-bit floats each");
        }
        let float = |bytes: &[u8], at: usize| {
            f32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
        };
        Ok(self
            .elements(accessor)?
            .map(|e| [float(e, 0), float(e, 4), float(e, 8)])
            .collect())
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
        let number = |bytes: &[u8]| {
            bytes
                .iter()
                .rev()
                .fold(0_u32, |number, &byte| number << 8 | u32::from(byte))
        };
        Ok(self.elements(accessor)?.map(number).collect())
    }
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
