//! Errors of reading, writing, merging and looking up tables.

use std::io;
use std::path::PathBuf;

use crate::error::mismatch::Mismatch;
use crate::error::no_direction::NoDirection;
use crate::error::output::OutputError;
use crate::table::invalid::Invalid;

/// Reason why a table could not be read, written, merged or looked up.
///
/// Each message is one sentence that names the file, the place in it and the remedy.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// File that cannot be opened or read.
    #[error("{}: cannot be read ({source}); check the name and the permissions", file.display())]
    Open {
        /// Path of the table.
        file: PathBuf,
        /// Message of the system.
        source: io::Error,
    },
    /// Path of a folder, a pipe or a device.
    #[error("{}: is not a regular file; name a table such as table.h5", file.display())]
    NotAFile {
        /// Path that was asked for.
        file: PathBuf,
    },
    /// File that does not start with the HDF5 signature.
    #[error(
        "{}: is not an HDF5 file ({bytes} bytes, without the HDF5 signature); name a table \
        written by `bake trace`",
        file.display()
    )]
    NotHdf5 {
        /// Path of the file.
        file: PathBuf,
        /// Length of the file, bytes.
        bytes: u64,
    },
    /// File that is larger than any table.
    #[error(
        "{}: is {bytes} bytes, above the limit of {limit}; bake fewer directions or bins",
        file.display()
    )]
    FileSize {
        /// Path of the file.
        file: PathBuf,
        /// Length of the file, bytes.
        bytes: u64,
        /// Greatest length that is read, bytes.
        limit: u64,
    },
    /// File whose bytes are not those that were written.
    #[error(
        "{}: is damaged (its bytes have SHA-256 {computed}, its seal says {stored}); copy it \
        again or bake it again",
        file.display()
    )]
    Damaged {
        /// Path of the file.
        file: PathBuf,
        /// Hash in the seal, lower-case hex.
        stored: String,
        /// Hash of the bytes, lower-case hex.
        computed: String,
    },
    /// Structure that the HDF5 library would walk without end.
    #[error(
        "{}: is damaged (the HDF5 global heap at byte {offset} does not add up); copy it again or \
        bake it again",
        file.display()
    )]
    Heap {
        /// Path of the file.
        file: PathBuf,
        /// Offset of the heap in the file, bytes.
        offset: usize,
    },
    /// Object that the HDF5 library refuses: cut short, a wrong checksum, an unreadable structure.
    #[error(
        "{}: {place} cannot be read or written ({source}); the file is cut short or damaged, copy \
        it again or bake it again",
        file.display()
    )]
    Hdf5 {
        /// Path of the file.
        file: PathBuf,
        /// Dataset or attribute with its name, or `file`.
        place: String,
        /// Message of the library.
        source: hdf5::Error,
    },
    /// HDF5 file that is not a ray-shift table.
    #[error(
        "{}: attribute format is {found:?}, not {expected:?}; name a table written by `bake trace`",
        file.display()
    )]
    Format {
        /// Path of the file.
        file: PathBuf,
        /// Name of the format in the file.
        found: String,
        /// Name of the format of tables.
        expected: &'static str,
    },
    /// Version that this program does not know.
    #[error(
        "{}: is of format version {found}, this program reads 1 to {newest}; update the program \
        or bake the table again",
        file.display()
    )]
    Version {
        /// Path of the file.
        file: PathBuf,
        /// Version in the file.
        found: u64,
        /// Newest version that is read.
        newest: u64,
    },
    /// Attribute that is missing.
    #[error("{}: attribute {attribute} is missing; bake the table again", file.display())]
    MissingAttribute {
        /// Path of the file.
        file: PathBuf,
        /// Name of the attribute.
        attribute: String,
    },
    /// Attribute of another type or shape.
    #[error(
        "{}: attribute {attribute} is {found}, expected {expected}; bake the table again",
        file.display()
    )]
    AttributeType {
        /// Path of the file.
        file: PathBuf,
        /// Name of the attribute.
        attribute: String,
        /// Content that a table has there.
        expected: &'static str,
        /// Content that the file has there.
        found: String,
    },
    /// Dataset that is missing, or is a link that leaves the file.
    #[error("{}: dataset {dataset} is missing; bake the table again", file.display())]
    MissingDataset {
        /// Path of the file.
        file: PathBuf,
        /// Name of the dataset.
        dataset: String,
    },
    /// Dataset of another element type.
    #[error(
        "{}: dataset {dataset} holds {found}, expected {expected}; bake the table again",
        file.display()
    )]
    DatasetType {
        /// Path of the file.
        file: PathBuf,
        /// Name of the dataset.
        dataset: String,
        /// Element type that a table has there.
        expected: String,
        /// Element type that the file has there.
        found: String,
    },
    /// Dataset of another shape.
    #[error(
        "{}: dataset {dataset} has shape {found:?}, expected {expected}; bake the table again",
        file.display()
    )]
    Shape {
        /// Path of the file.
        file: PathBuf,
        /// Name of the dataset.
        dataset: String,
        /// Shape that follows from the axes.
        expected: String,
        /// Shape in the file.
        found: Vec<usize>,
    },
    /// Dataset that claims more elements than any table holds.
    #[error(
        "{}: dataset {dataset} claims {bytes} bytes, above the limit of {limit}; bake fewer \
        directions or bins",
        file.display()
    )]
    DatasetSize {
        /// Path of the file.
        file: PathBuf,
        /// Name of the dataset.
        dataset: String,
        /// Number of bytes that the dataset claims.
        bytes: u128,
        /// Greatest number of bytes that is read.
        limit: u64,
    },
    /// File that claims far more content than its length allows.
    #[error(
        "{}: claims {claimed} bytes of content in a file of {bytes}, as a decompression bomb \
        does; if you trust it, store it uncompressed with `h5repack -f NONE`",
        file.display()
    )]
    Inflated {
        /// Path of the file.
        file: PathBuf,
        /// Bytes of all arrays so far.
        claimed: u64,
        /// Length of the file, bytes.
        bytes: u64,
    },
    /// Reading process that did not return a table.
    #[error(
        "{}: cannot be read: the process that reads it with the HDF5 library {what}; the file is \
        damaged or was made to do harm, copy it again or bake it again",
        file.display()
    )]
    Apart {
        /// Path of the file.
        file: PathBuf,
        /// Fate of the process, in words that follow "the process".
        what: String,
    },
    /// Reader that is missing, or is not the one that belongs to this program.
    #[error(
        "{}: cannot be read: {}, the program that opens tables for `bake` and `fit`, {what}; put \
        it beside this program, with `make install` or `cargo install --path reader`",
        file.display(), reader.display()
    )]
    Reader {
        /// Path of the table.
        file: PathBuf,
        /// Path at which the reader should be.
        reader: PathBuf,
        /// Fault of the reader, in words that follow its name.
        what: String,
    },
    /// Message of the process that reads tables, a sentence like the others here.
    #[error("{0}")]
    Told(String),
    /// Dataset that is stored in a way that a table never is: outside the file, through an unknown
    /// filter, or in an inflated chunk.
    #[error(
        "{}: dataset {dataset} is stored {found}; copy the table with h5repack or bake it again",
        file.display()
    )]
    Storage {
        /// Path of the file.
        file: PathBuf,
        /// Name of the dataset.
        dataset: String,
        /// Kind of storage, in words that follow "is stored".
        found: &'static str,
    },
    /// Scale that does not agree with the axes that the attributes describe.
    #[error(
        "{}: dataset {dataset} is {found} at index {index}, expected {expected}; bake the table \
        again",
        file.display()
    )]
    Scale {
        /// Path of the file.
        file: PathBuf,
        /// Name of the scale.
        dataset: String,
        /// Index of the first value that differs.
        index: usize,
        /// Value that belongs there.
        expected: String,
        /// Value in the file.
        found: String,
    },
    /// Derived dataset that does not follow from the counts.
    #[error(
        "{}: dataset {dataset} is {stored} at flat index {index}, but the counts give {computed}; \
        bake the table again",
        file.display()
    )]
    Derived {
        /// Path of the file.
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
    /// Numbers that break a rule of tables.
    #[error("{}: {source}; bake the table again", file.display())]
    Invalid {
        /// Path of the file.
        file: PathBuf,
        /// Rule and place.
        source: Invalid,
    },
    /// Content that differs from its hash.
    #[error(
        "{}: the content has hash {computed}, but attribute content_hash says {stored}; it was \
        changed after the bake, copy it again or bake it again",
        file.display()
    )]
    ContentHash {
        /// Path of the file.
        file: PathBuf,
        /// Hash in the file, lower-case hex.
        stored: String,
        /// Hash of the content, lower-case hex.
        computed: String,
    },
    /// Output that cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Tables that cannot be merged.
    #[error(transparent)]
    Merge(#[from] Mismatch),
    /// Direction outside of the table.
    #[error(transparent)]
    NoDirection(#[from] NoDirection),
    /// Polygons of so many corners that their interpolation would take without end.
    #[error(
        "incidence {incidence_deg} deg lies between directions of the table that have {corners} \
        corners of polygons, above the limit of {most} for interpolation; name a direction of the \
        table, or bake curved faces by rays (--method rays)"
    )]
    ManyCorners {
        /// Incidence, degrees.
        incidence_deg: f64,
        /// Number of corners of a direction around.
        corners: usize,
        /// Greatest number that is interpolated.
        most: usize,
    },
    /// Light in so many bins and deviations that moving it would take without end.
    #[error(
        "the table spreads the light at incidence {incidence_deg} deg over too many bins \
        ({bins} x {bins}) and exit directions; bake it with fewer --bins"
    )]
    Spread {
        /// Incidence, degrees.
        incidence_deg: f64,
        /// Number of bins along an axis.
        bins: usize,
    },
    /// Light that deviates farther than any table means, at this distance and corner size.
    #[error(
        "at this distance and corner size light would be off by {edges:.1e} edge lengths, above \
        the limit of 1e6; check the distance, and c_mm of the result"
    )]
    Astray {
        /// Greatest component of the move, edge lengths; infinite if distance and corner size give
        /// no finite number.
        edges: f64,
    },
}
