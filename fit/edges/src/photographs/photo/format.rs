//! File formats of photographs.

use std::path::Path;

/// A file format that is read, as recognised by the file's contents.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Format {
    /// OpenEXR.
    Exr,
    /// Portable Network Graphics.
    Png,
    /// Tagged Image File Format, BigTIFF included.
    Tiff,
    /// JPEG (JFIF or Exif).
    Jpeg,
    /// Camera raw of any maker.
    Raw,
}

impl Format {
    /// Returns the format of a file by its first bytes, or `None` if it is unknown. Camera raw is
    /// not recognised in this way.
    pub fn of_signature(first: &[u8]) -> Option<Format> {
        const SIGNATURES: [(&[u8], Format); 7] = [
            (&[0x76, 0x2f, 0x31, 0x01], Format::Exr),
            (b"\x89PNG\r\n\x1a\n", Format::Png),
            (&[0xff, 0xd8, 0xff], Format::Jpeg),
            (b"II*\0", Format::Tiff),
            (b"MM\0*", Format::Tiff),
            (b"II+\0", Format::Tiff),
            (b"MM\0+", Format::Tiff),
        ];
        SIGNATURES
            .iter()
            .find(|(signature, _)| first.starts_with(signature))
            .map(|&(_, format)| format)
    }

    /// Returns the name of the format for messages.
    pub const fn name(self) -> &'static str {
        match self {
            Format::Exr => "EXR",
            Format::Png => "PNG",
            Format::Tiff => "TIFF",
            Format::Jpeg => "JPEG",
            Format::Raw => "camera raw",
        }
    }

    /// Returns the kind of this format that keeps most of a photograph, in words.
    pub(crate) const fn best(self) -> &'static str {
        match self {
            Format::Exr => "an EXR of scan lines that has R, G and B, or Y, for every pixel",
            Format::Png => "a PNG of 16 bits",
            Format::Tiff | Format::Raw => {
                "a TIFF of 16 bits or 32-bit floats, grey or RGB, without compression"
            }
            Format::Jpeg => "a baseline JPEG, or better as a PNG or TIFF of 16 bits",
        }
    }

    /// Returns the extensions that names of such files have, in small letters.
    pub const fn extensions(self) -> &'static [&'static str] {
        match self {
            Format::Exr => &["exr"],
            Format::Png => &["png"],
            Format::Tiff => &["tif", "tiff"],
            Format::Jpeg => &["jpg", "jpeg", "jpe"],
            Format::Raw => &CAMERA_RAW,
        }
    }
}

/// Extensions of camera raw files. Many of these files are TIFF inside; read as TIFF they would
/// give their thumbnail.
const CAMERA_RAW: [&str; 20] = [
    "3fr", "arw", "cr2", "cr3", "crw", "dcr", "dng", "erf", "iiq", "kdc", "mef", "mos", "mrw",
    "nef", "nrw", "orf", "pef", "raf", "rw2", "srw",
];

/// Returns whether a file is camera raw: by its extension, or, for a CR2, by its first bytes.
pub fn is_raw(extension: &str, first: &[u8]) -> bool {
    CAMERA_RAW.contains(&extension) || first.get(8..10) == Some(b"CR")
}

/// Returns the extension of a file's name in small letters; empty if there is none.
pub fn extension(path: &Path) -> String {
    let extension = path.extension().and_then(|name| name.to_str());
    extension.unwrap_or("").to_ascii_lowercase()
}
