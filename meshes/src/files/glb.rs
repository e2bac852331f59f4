//! Binary glTF container: a header, a JSON chunk and, in some files, a binary chunk.

use crate::mesh::error::Fault;

/// First bytes of a GLB file.
const MAGIC: &[u8; 4] = b"glTF";
/// Kind of the JSON chunk.
const JSON: u32 = u32::from_le_bytes(*b"JSON");
/// Kind of the binary chunk.
const BIN: u32 = u32::from_le_bytes(*b"BIN\0");

/// Returns whether the bytes begin as a binary glTF file.
pub(crate) fn is_binary(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Returns the JSON chunk and the binary chunk of a GLB file.
///
/// Every length is checked against the bytes that are there.
///
/// # Errors
/// Returns [`Fault::GlbContainer`] if the bytes are cut short, or are not version 2 with a first
/// chunk of JSON.
pub(crate) fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Fault> {
    let wrong = |reason| Fault::GlbContainer { reason };
    if !is_binary(bytes) {
        return Err(wrong("it does not start with 'glTF'"));
    }
    let version = word(bytes, 4).ok_or(wrong("its header is cut short"))?;
    let length = word(bytes, 8).ok_or(wrong("its header is cut short"))? as usize;
    if version != 2 {
        return Err(wrong("its version is not 2"));
    }
    let bytes = bytes
        .get(..length)
        .ok_or(wrong("it is shorter than its header says"))?;
    let (kind, json, next) = chunk(bytes, 12).ok_or(wrong("its first chunk is cut short"))?;
    if kind != JSON {
        return Err(wrong("its first chunk is not JSON"));
    }
    if next >= bytes.len() {
        return Ok((json, None));
    }
    let (kind, binary, _) = chunk(bytes, next).ok_or(wrong("its second chunk is cut short"))?;
    Ok((json, (kind == BIN).then_some(binary)))
}

/// Makes a GLB file of a JSON text and a binary chunk, both padded to four bytes.
///
/// # Panics
/// Panics if the file would be longer than its 32-bit length can say; meshes within
/// [`crate::mesh::mesh::MAX_ELEMENTS`] are not.
pub(crate) fn file(json: &str, binary: &[u8]) -> Vec<u8> {
    let padded = |length: usize| length.div_ceil(4) * 4;
    let total = 12 + 8 + padded(json.len()) + 8 + padded(binary.len());
    let mut bytes = Vec::with_capacity(total);
    let word = |bytes: &mut Vec<u8>, value: usize| {
        bytes.extend(
            u32::try_from(value)
                .expect("a GLB file is shorter than 4 GiB")
                .to_le_bytes(),
        );
    };
    bytes.extend(MAGIC);
    word(&mut bytes, 2);
    word(&mut bytes, total);
    for (kind, content, filler) in [(JSON, json.as_bytes(), b' '), (BIN, binary, 0)] {
        word(&mut bytes, padded(content.len()));
        word(&mut bytes, kind as usize);
        bytes.extend(content);
        bytes.resize(bytes.len() + padded(content.len()) - content.len(), filler);
    }
    bytes
}

/// Reads a little-endian u32.
fn word(bytes: &[u8], at: usize) -> Option<u32> {
    bytes
        .get(at..at.checked_add(4)?)?
        .try_into()
        .ok()
        .map(u32::from_le_bytes)
}

/// Returns kind and content of the chunk at `at`, and the offset of the next chunk.
fn chunk(bytes: &[u8], at: usize) -> Option<(u32, &[u8], usize)> {
    let length = word(bytes, at)? as usize;
    let kind = word(bytes, at + 4)?;
    let end = at.checked_add(8)?.checked_add(length)?;
    Some((kind, bytes.get(at + 8..end)?, end))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let json = r#"{"a":1}"#;
        let bytes = file(json, &[1, 2, 3, 4, 5]);
        let (read, binary) = chunks(&bytes).expect("a whole file");
        assert_eq!(read, format!("{json} ").as_bytes());
        assert_eq!(binary, Some(&[1, 2, 3, 4, 5, 0, 0, 0][..]));
    }

    #[test]
    fn every_cut_file_is_refused() {
        let bytes = file(r#"{"a":1}"#, &[1, 2, 3, 4]);
        let refused = (0..bytes.len())
            .filter(|&length| chunks(&bytes[..length]).is_err())
            .count();
        assert_eq!(refused, bytes.len());
    }
}
