//! Typed access to a group of the file.
//!
//! Name, type, shape and size are checked before anything is read.

use std::collections::HashSet;
use std::fmt::Display;
use std::path::Path as FilePath;

use hdf5::dataset::Layout;
use hdf5::filters::Filter;
use hdf5::types::{
    FixedAscii, FixedUnicode, FloatSize, IntSize, TypeDescriptor, VarLenAscii, VarLenUnicode,
};
use hdf5::{Attribute, Dataset, Group, H5Type, LinkType};
use ndarray::{ArrayD, Dimension, IxDyn};

use crate::error::{BAKE_LESS, Error};
use crate::file::limits::MOST_BYTES;
use crate::library::BAKE_AGAIN;
use crate::library::confine::Ledger;
use crate::library::layout::names::{self, DimensionScale, Variable};
use crate::table::axes::Axes;
use crate::table::fate::Fate;
use crate::table::provenance::Provenance;

/// Rounding that another writer may have in scales and derived datasets.
pub(crate) const ROUNDING: f64 = 1e-12;

/// Longest text that is read from a fixed-length attribute, bytes; a table needs some hundred.
const MOST_TEXT: usize = 4096;

/// Largest chunk, bytes: 4096 x 4096 bins.
const MOST_CHUNK: u64 = 1 << 27;

/// Group of the file, with the names that it really holds.
pub(crate) struct Place<'a> {
    pub(crate) group: &'a Group,
    pub(crate) file: &'a FilePath,
    prefix: &'static str,
    ledger: &'a Ledger,
    links: HashSet<String>,
    pub(crate) attributes: HashSet<String>,
}

impl<'a> Place<'a> {
    /// Lists the objects and attributes of a group.
    pub(crate) fn new(
        group: &'a Group,
        file: &'a FilePath,
        prefix: &'static str,
        ledger: &'a Ledger,
    ) -> Result<Place<'a>, Error> {
        let failed = |error| Error::hdf5(file, &format!("group /{prefix}"), &error);
        let mut links = HashSet::new();
        let visit = group.iter_visit_default(|name, info| {
            // A soft link may loop, and an external link leaves the file. Neither is part of a
            // table.
            if matches!(info.link_type, LinkType::Hard) {
                links.insert(name.to_owned());
            }
            Ok(())
        });
        visit.map_err(failed)?;
        let attributes = group.attr_names().map_err(failed)?.into_iter().collect();
        Ok(Place {
            group,
            file,
            prefix,
            ledger,
            links,
            attributes,
        })
    }

    /// Opens a group inside this one.
    pub(crate) fn inside(
        &self,
        group: &'a Group,
        prefix: &'static str,
    ) -> Result<Place<'a>, Error> {
        Place::new(group, self.file, prefix, self.ledger)
    }

    /// Returns whether the group holds an object of this name.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.links.contains(name)
    }

    /// Returns the name with that of the group, for messages.
    pub(crate) fn named(&self, name: &str) -> String {
        format!("{}{name}", self.prefix)
    }

    /// Returns a function that makes the error for an object that the library refuses.
    pub(crate) fn hdf5(&self, kind: &str, name: &str) -> impl Fn(hdf5::Error) -> Error {
        let place = format!("{kind} {}", self.named(name));
        move |error| Error::hdf5(self.file, &place, &error)
    }

    /// Makes the error for an attribute or a dataset that a table does not have so.
    pub(crate) fn wrong(&self, kind: &str, name: &str, fault: impl Display) -> Error {
        let fault = format!("{kind} {} {fault}", self.named(name));
        Error::file(self.file, fault, BAKE_AGAIN)
    }

    /// Returns an attribute with its type, if type and number of values are as expected.
    pub(crate) fn attribute(
        &self,
        name: &str,
        values: usize,
        expected: &'static str,
    ) -> Result<(Attribute, TypeDescriptor), Error> {
        if !self.attributes.contains(name) {
            return Err(self.wrong("attribute", name, "is missing"));
        }
        let failed = self.hdf5("attribute", name);
        let attribute = self.group.attr(name).map_err(&failed)?;
        let kind = self.kind(attribute.dtype().map_err(&failed)?);
        let shape = attribute.get_shape().map_err(&failed)?;
        let fits = match (kind.as_ref(), expected) {
            (Ok(TypeDescriptor::Float(_)), "a number" | "numbers") => true,
            (
                Ok(TypeDescriptor::Integer(_) | TypeDescriptor::Unsigned(_)),
                "a number" | "numbers" | "an integer",
            ) => true,
            (Ok(TypeDescriptor::VarLenUnicode | TypeDescriptor::VarLenAscii), "a text") => true,
            (Ok(TypeDescriptor::FixedUnicode(n) | TypeDescriptor::FixedAscii(n)), "a text") => {
                *n <= MOST_TEXT
            }
            _ => false,
        };
        // libhdf5 reads as much as the type needs, even if a damaged file holds less.
        let needed = |kind: &TypeDescriptor| match kind {
            text if TEXTS.contains(text) => HEAP_REFERENCE,
            kind => kind.size(),
        };
        let stored = attribute.storage_size();
        let found = match kind {
            Ok(kind) if fits && shape.iter().product::<usize>() == values => {
                if stored >= (values * needed(&kind)) as u64 {
                    return Ok((attribute, kind));
                }
                format!("{kind} in {stored} bytes")
            }
            Ok(kind) => format!("{kind} of shape {shape:?}"),
            Err(other) => format!("{other} of shape {shape:?}"),
        };
        let fault = format!("is {found}, expected {expected}");
        Err(self.wrong("attribute", name, fault))
    }

    /// Returns the element type, or the words for a type that has no Rust counterpart.
    pub(crate) fn kind(&self, datatype: hdf5::Datatype) -> Result<TypeDescriptor, String> {
        datatype
            .to_descriptor()
            .map_err(|_| "an unknown type".to_owned())
    }

    /// Reads an attribute that is a text.
    pub(crate) fn text(&self, name: &str) -> Result<String, Error> {
        let (attribute, kind) = self.attribute(name, 1, "a text")?;
        let texts = texts(&attribute, &kind).map_err(self.hdf5("attribute", name))?;
        let bytes = texts.into_iter().next().unwrap_or_default();
        String::from_utf8(bytes)
            .map_err(|_| self.wrong("attribute", name, "is not UTF-8, expected a text"))
    }

    /// Reads an attribute that is a number.
    pub(crate) fn number(&self, name: &str) -> Result<f64, Error> {
        let (attribute, _) = self.attribute(name, 1, "a number")?;
        first(&attribute).map_err(self.hdf5("attribute", name))
    }

    /// Reads an attribute that is an integer.
    pub(crate) fn integer(&self, name: &str) -> Result<u64, Error> {
        let (attribute, _) = self.attribute(name, 1, "an integer")?;
        first(&attribute).map_err(self.hdf5("attribute", name))
    }

    /// Reads an attribute of `N` numbers.
    pub(crate) fn numbers<const N: usize>(&self, name: &str) -> Result<[f64; N], Error> {
        let (attribute, _) = self.attribute(name, N, "numbers")?;
        let mut values = [0.0; N];
        attribute
            .read_into_raw(&mut values)
            .map_err(self.hdf5("attribute", name))?;
        Ok(values)
    }

    /// Returns a dataset of an allowed element type, stored inside the file by known means, its
    /// type and its shape.
    pub(crate) fn dataset(
        &self,
        name: &str,
        allowed: &[TypeDescriptor],
    ) -> Result<(Dataset, TypeDescriptor, Vec<usize>), Error> {
        if !self.has(name) {
            return Err(self.wrong("dataset", name, "is missing"));
        }
        let failed = self.hdf5("dataset", name);
        let found = self.group.dataset(name).map_err(&failed)?;
        let kind = self.kind(found.dtype().map_err(&failed)?);
        let kind = match kind {
            Ok(kind) if allowed.contains(&kind) => kind,
            other => {
                let found = other.map_or_else(|other| other, |kind| kind.to_string());
                let fault = format!("holds {found}, expected {}", allowed[0]);
                return Err(self.wrong("dataset", name, fault));
            }
        };
        let shape = found.get_shape().map_err(&failed)?;
        let bytes = shape
            .iter()
            .map(|&n| n as u128)
            .try_fold(8_u128, u128::checked_mul)
            .unwrap_or(u128::MAX);
        if bytes > u128::from(MOST_BYTES) {
            let dataset = self.named(name);
            let fault =
                format!("dataset {dataset} claims {bytes} bytes, above the limit of {MOST_BYTES}");
            return Err(Error::file(self.file, fault, BAKE_LESS));
        }
        match unusual_storage(&found).map_err(&failed)? {
            Some(found) => Err(Error::file(
                self.file,
                format!("dataset {} is stored {found}", self.named(name)),
                "copy the table with h5repack or bake it again",
            )),
            None => Ok((found, kind, shape)),
        }
    }

    /// Reads a dataset whose shape fits `expected`, where `None` stands for any length.
    pub(crate) fn flat<T: NumericElement>(
        &self,
        name: &str,
        expected: &[Option<usize>],
    ) -> Result<(Vec<T>, Vec<usize>), Error> {
        let (dataset, _, shape) = self.dataset(name, &[T::KIND])?;
        let fits = shape.len() == expected.len()
            && shape
                .iter()
                .zip(expected)
                .all(|(found, expected)| expected.is_none_or(|n| n == *found));
        if !fits {
            let sides: Vec<_> = expected
                .iter()
                .map(|n| n.map_or("n".to_owned(), |n| n.to_string()))
                .collect();
            let fault = format!("has shape {shape:?}, expected [{}]", sides.join(", "));
            return Err(self.wrong("dataset", name, fault));
        }
        self.ledger
            .enter(self.file, 8 * shape.iter().product::<usize>() as u64)?;
        let values = dataset.read_raw().map_err(self.hdf5("dataset", name))?;
        Ok((values, shape))
    }

    /// Reads an array of this shape.
    pub(crate) fn array<T: NumericElement, D: Dimension>(
        &self,
        variable: &Variable,
        shape: &[usize],
    ) -> Result<ndarray::Array<T, D>, Error> {
        let expected: Vec<_> = shape.iter().copied().map(Some).collect();
        let (values, shape) = self.flat(variable.name, &expected)?;
        let internal = |error: ndarray::ShapeError| {
            self.hdf5("dataset", variable.name)(hdf5::Error::Internal(error.to_string()))
        };
        ArrayD::from_shape_vec(IxDyn(&shape), values)
            .and_then(|array| array.into_dimensionality())
            .map_err(internal)
    }

    /// Reads a dimension scale.
    pub(crate) fn scale(&self, scale: &DimensionScale) -> Result<Vec<f64>, Error> {
        Ok(self.flat(scale.name, &[None])?.0)
    }

    /// Makes the error for a dataset that differs from what the others ask for.
    pub(crate) fn differs(
        &self,
        name: &str,
        index: usize,
        expected: impl Display,
        found: impl Display,
    ) -> Error {
        let fault = format!("is {found} at index {index}, expected {expected}");
        self.wrong("dataset", name, fault)
    }

    /// Checks that a scale holds the centres of the bins.
    pub(crate) fn bins(&self, scale: &DimensionScale, axes: &Axes) -> Result<(), Error> {
        let (centres, _) = self.flat::<f64>(scale.name, &[Some(axes.bins)])?;
        let wrong =
            |&(i, found): &(usize, &f64)| !near(*found, axes.bin_centre(i), ROUNDING * axes.range);
        match centres.iter().enumerate().find(wrong) {
            Some((i, found)) => Err(self.differs(scale.name, i, axes.bin_centre(i), found)),
            None => Ok(()),
        }
    }

    /// Reads the fates, which must be those that tables of this provenance have.
    pub(crate) fn fates(&self, provenance: &Provenance) -> Result<&'static [Fate], Error> {
        let scale = &names::FATE_NAME;
        let (dataset, kind, shape) = self.dataset(scale.name, &TEXTS)?;
        let fates = provenance.fates(shape.first().copied().unwrap_or(0));
        if shape != [fates.len()] {
            let fault = format!("has shape {shape:?}, expected [{}]", fates.len());
            return Err(self.wrong("dataset", scale.name, fault));
        }
        let names = texts(&dataset, &kind).map_err(self.hdf5("dataset", scale.name))?;
        match names
            .iter()
            .zip(fates)
            .position(|(name, fate)| name != fate.name().as_bytes())
        {
            Some(i) => {
                let found = String::from_utf8_lossy(&names[i]);
                Err(self.differs(scale.name, i, fates[i].name(), found))
            }
            None => Ok(fates),
        }
    }

    /// Reads the number of randomisations and checks that they are numbered from 0.
    pub(crate) fn randomisations(&self) -> Result<usize, Error> {
        let scale = &names::RANDOMISATION;
        let (indices, _) = self.flat::<u64>(scale.name, &[None])?;
        match indices
            .iter()
            .enumerate()
            .find(|&(i, &index)| i as u64 != index)
        {
            Some((i, found)) => Err(self.differs(scale.name, i, i, found)),
            None => Ok(indices.len()),
        }
    }
}

/// Returns whether two numbers agree within a tolerance; NaN agrees with nothing.
pub(crate) fn near(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance
}

/// Element types of numeric datasets.
pub(crate) trait NumericElement: H5Type {
    /// Element type in the file.
    const KIND: TypeDescriptor;
}

impl NumericElement for f64 {
    const KIND: TypeDescriptor = TypeDescriptor::Float(FloatSize::U8);
}

impl NumericElement for u64 {
    const KIND: TypeDescriptor = TypeDescriptor::Unsigned(IntSize::U8);
}

/// Bytes of a text of variable length in a file: its length, and its place in a heap.
const HEAP_REFERENCE: usize = 16;

/// Element types of texts of variable length.
const TEXTS: [TypeDescriptor; 2] = [TypeDescriptor::VarLenUnicode, TypeDescriptor::VarLenAscii];

/// Reads the only value of an attribute.
fn first<T: H5Type + Default + Copy>(attribute: &Attribute) -> hdf5::Result<T> {
    let mut value = [T::default()];
    attribute.read_into_raw(&mut value)?;
    Ok(value[0])
}

/// Reads texts of any type, as bytes: the types of the crate take any bytes for UTF-8.
fn texts(place: &hdf5::Container, kind: &TypeDescriptor) -> hdf5::Result<Vec<Vec<u8>>> {
    fn of<T: H5Type + AsRef<[u8]>>(place: &hdf5::Container) -> hdf5::Result<Vec<Vec<u8>>> {
        Ok(place
            .read_raw::<T>()?
            .iter()
            .map(|text| text.as_ref().to_owned())
            .collect())
    }
    match kind {
        TypeDescriptor::VarLenUnicode => of::<VarLenUnicode>(place),
        TypeDescriptor::VarLenAscii => of::<VarLenAscii>(place),
        TypeDescriptor::FixedUnicode(_) => of::<FixedUnicode<MOST_TEXT>>(place),
        _ => of::<FixedAscii<MOST_TEXT>>(place),
    }
}

/// Returns the fault in the way a dataset is stored, before it is read; `None` without a fault.
fn unusual_storage(dataset: &Dataset) -> hdf5::Result<Option<&'static str>> {
    let creation = dataset.dcpl()?;
    if !creation.get_external()?.is_empty() {
        return Ok(Some("in another file"));
    }
    if matches!(creation.get_layout()?, Layout::Virtual) {
        return Ok(Some("as a view of other datasets"));
    }
    let known = |filter: &Filter| {
        matches!(
            filter,
            Filter::Deflate(_) | Filter::Shuffle | Filter::Fletcher32
        )
    };
    if !creation.get_filters()?.iter().all(known) {
        return Ok(Some(
            "through a filter other than shuffle, deflate and fletcher32",
        ));
    }
    let Some(chunk) = creation.get_chunk()? else {
        return Ok(None);
    };
    let elements = chunk
        .iter()
        .try_fold(1_u64, |bytes, &n| bytes.checked_mul(n as u64));
    let kind = dataset.dtype()?;
    // A text of variable length is a length, an address and an index in the file, and a pointer in
    // memory.
    let element = if TEXTS.contains(&kind.to_descriptor()?) {
        16
    } else {
        kind.size() as u64
    };
    let bytes = elements.and_then(|n| n.checked_mul(element));
    let Some(bytes) = bytes.filter(|&bytes| bytes <= MOST_CHUNK) else {
        return Ok(Some("in chunks above 128 MiB"));
    };
    // Deflate adds at most 5 bytes per 16 KiB and some at the ends. A longer chunk would inflate
    // past its size.
    let most = bytes + bytes / 1024 + 64;
    let mut inflated = false;
    dataset.chunks_visit(|chunk| {
        inflated |= chunk.size > most;
        0
    })?;
    Ok(inflated.then_some("in a chunk that is longer than its content"))
}
