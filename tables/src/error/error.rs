//! What can go wrong with a table, and what to do about it.

use std::io;
use std::path::PathBuf;

use crate::error::mismatch::Mismatch;
use crate::error::no_direction::NoDirection;
use crate::error::output::OutputError;
use crate::table::invalid::Invalid;

/// Why a table could not be read, written, merged or looked up.
///
/// Each message is one sentence that names the file, the place in it and the remedy.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file cannot be opened or read.
    #[error("{}: cannot be read ({source}); check the name and the permissions", file.display())]
    Open {
        /// The table asked for.
        file: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The path names a folder, a pipe or a device.
    #[error("{}: is not a regular file; name a table such as table.h5", file.display())]
    NotAFile {
        /// The path asked for.
        file: PathBuf,
    },
    /// The file does not start with the HDF5 signature.
    #[error(
        "{}: is not an HDF5 file ({bytes} bytes, without the HDF5 signature); name a table \
        written by `bake \
         trace`",
        file.display()
    )]
    NotHdf5 {
        /// The file asked for.
        file: PathBuf,
        /// Its length.
        bytes: u64,
    },
    /// The file is larger than any table.
    #[error(
        "{}: is {bytes} bytes, above the limit of {limit}; bake fewer directions or bins",
        file.display()
    )]
    FileSize {
        /// The file asked for.
        file: PathBuf,
        /// Its length.
        bytes: u64,
        /// The greatest length that is read.
        limit: u64,
    },
    /// The bytes are not those that were written.
    #[error(
        "{}: is damaged (its bytes have SHA-256 {computed}, its seal says {stored}); copy it \
        again or bake \
         it again",
        file.display()
    )]
    Damaged {
        /// The file asked for.
        file: PathBuf,
        /// Hash in the seal, lower-case hex.
        stored: String,
        /// Hash of the bytes, lower-case hex.
        computed: String,
    },
    /// A structure that the HDF5 library would walk without end.
    #[error(
        "{}: is damaged (the HDF5 global heap at byte {offset} does not add up); copy it again or \
        bake it \
         again",
        file.display()
    )]
    Heap {
        /// The file asked for.
        file: PathBuf,
        /// Where the heap starts.
        offset: usize,
    },
    /// The HDF5 library refuses an object: cut short, a checksum that fails, an unreadable
    /// structure.
    #[error(
        "{}: {place} cannot be read or written ({source}); the file is cut short or damaged, copy \
        it again \
         or bake it again",
        file.display()
    )]
    Hdf5 {
        /// The file.
        file: PathBuf,
        /// Dataset, attribute or `file`.
        place: String,
        /// What the library says.
        source: hdf5::Error,
    },
    /// An HDF5 file of something else.
    #[error(
        "{}: attribute format is {found:?}, not {expected:?}; name a table written by `bake trace`",
        file.display()
    )]
    Format {
        /// The file.
        file: PathBuf,
        /// The name in the file.
        found: String,
        /// The name of this format.
        expected: &'static str,
    },
    /// A version that this program does not know.
    #[error(
        "{}: is of format version {found}, this program reads 1 to {newest}; update the program \
        or bake the \
         table again",
        file.display()
    )]
    Version {
        /// The file.
        file: PathBuf,
        /// Version in the file.
        found: u64,
        /// Newest version that is read.
        newest: u64,
    },
    /// An attribute is not there.
    #[error("{}: attribute {attribute} is missing; bake the table again", file.display())]
    MissingAttribute {
        /// The file.
        file: PathBuf,
        /// Name of the attribute.
        attribute: String,
    },
    /// An attribute has another type or shape.
    #[error(
        "{}: attribute {attribute} is {found}, expected {expected}; bake the table again",
        file.display()
    )]
    AttributeType {
        /// The file.
        file: PathBuf,
        /// Name of the attribute.
        attribute: String,
        /// What a table holds there.
        expected: &'static str,
        /// What the file holds there.
        found: String,
    },
    /// A dataset is not there, or is a link that leaves the file.
    #[error("{}: dataset {dataset} is missing; bake the table again", file.display())]
    MissingDataset {
        /// The file.
        file: PathBuf,
        /// Name of the dataset.
        dataset: String,
    },
    /// A dataset has another element type.
    #[error(
        "{}: dataset {dataset} holds {found}, expected {expected}; bake the table again",
        file.display()
    )]
    DatasetType {
        /// The file.
        file: PathBuf,
        /// Name of the dataset.
        dataset: String,
        /// What a table holds there.
        expected: String,
        /// What the file holds there.
        found: String,
    },
    /// A dataset has another shape.
    #[error(
        "{}: dataset {dataset} has shape {found:?}, expected {expected}; bake the table again",
        file.display()
    )]
    Shape {
        /// The file.
        file: PathBuf,
        /// Name of the dataset.
        dataset: String,
        /// The shape that the axes ask for.
        expected: String,
        /// The shape in the file.
        found: Vec<usize>,
    },
    /// A dataset claims more elements than any table holds.
    #[error(
        "{}: dataset {dataset} claims {bytes} bytes, above the limit of {limit}; bake fewer \
        directions or \
         bins",
        file.display()
    )]
    DatasetSize {
        /// The file.
        file: PathBuf,
        /// Name of the dataset.
        dataset: String,
        /// Bytes claimed.
        bytes: u128,
        /// The greatest number that is read.
        limit: u64,
    },
    /// The file claims far more than it holds.
    #[error(
        "{}: claims {claimed} bytes of content in a file of {bytes}, as a decompression bomb \
        does; if you trust it, \
         store it uncompressed with `h5repack -f NONE`",
        file.display()
    )]
    Inflated {
        /// The file.
        file: PathBuf,
        /// Bytes of all arrays so far.
        claimed: u64,
        /// Length of the file.
        bytes: u64,
    },
    /// The process that reads tables did not come back with one.
    #[error(
        "{}: cannot be read: the process that reads it with the HDF5 library {what}; the file is \
        damaged or was made to \
         do harm, copy it again or bake it again",
        file.display()
    )]
    Apart {
        /// The file.
        file: PathBuf,
        /// What became of the process.
        what: String,
    },
    /// What the process that reads tables says: a sentence like the others here.
    #[error("{0}")]
    Told(String),
    /// A dataset is stored in a way that a table never is (outside the file, an unknown filter, an
    /// inflated chunk).
    #[error(
        "{}: dataset {dataset} is stored {found}; copy the table with h5repack or bake it again",
        file.display()
    )]
    Storage {
        /// The file.
        file: PathBuf,
        /// Name of the dataset.
        dataset: String,
        /// How it is stored.
        found: &'static str,
    },
    /// A scale does not agree with the axes that the attributes describe.
    #[error(
        "{}: dataset {dataset} is {found} at index {index}, expected {expected}; bake the table \
        again",
        file.display()
    )]
    Scale {
        /// The file.
        file: PathBuf,
        /// Name of the scale.
        dataset: String,
        /// Index of the first value that differs.
        index: usize,
        /// The value that belongs there.
        expected: String,
        /// The value in the file.
        found: String,
    },
    /// A derived dataset does not follow from the counts.
    #[error(
        "{}: dataset {dataset} is {stored} at flat index {index}, the counts give {computed}; \
        bake the table \
         again",
        file.display()
    )]
    Derived {
        /// The file.
        file: PathBuf,
        /// Name of the dataset.
        dataset: &'static str,
        /// Index in row-major order.
        index: usize,
        /// Value in the file.
        stored: f64,
        /// Value that follows from the counts.
        computed: f64,
    },
    /// The numbers break a rule that every table obeys.
    #[error("{}: {source}; bake the table again", file.display())]
    Invalid {
        /// The file.
        file: PathBuf,
        /// The rule and the place.
        source: Invalid,
    },
    /// The content is not what was written.
    #[error(
        "{}: the content has hash {computed}, attribute content_hash says {stored}; it was \
        changed after the \
         bake, copy it again or bake it again",
        file.display()
    )]
    ContentHash {
        /// The file.
        file: PathBuf,
        /// Hash in the file, lower-case hex.
        stored: String,
        /// Hash of the content, lower-case hex.
        computed: String,
    },
    /// The table cannot be put in its place.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Tables that cannot be merged.
    #[error(transparent)]
    Merge(#[from] Mismatch),
    /// A direction that the table neither holds nor brackets.
    #[error(transparent)]
    NoDirection(#[from] NoDirection),
    /// Light that deviates so far, by the distance and the corner size asked for, that no table
    /// means it.
    #[error(
        "at this distance and corner size light goes {edges:.1e} edge lengths astray, above 1e6: \
        check the distance, and c_mm \
         of the result"
    )]
    Astray {
        /// How far along an axis, edge lengths; infinite where the distance or the corner size is
        /// no number to divide.
        edges: f64,
    },
}
