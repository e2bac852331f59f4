//! HDF5 objects to table, believing nothing.
//!
//! Every size is compared with the axes, and with a limit, before memory of that size is asked for.

use std::collections::HashSet;
use std::path::Path as FilePath;

use hdf5::dataset::Layout;
use hdf5::filters::Filter;
use hdf5::types::{
    FixedAscii, FixedUnicode, FloatSize, IntSize, TypeDescriptor, VarLenAscii, VarLenUnicode,
};
use hdf5::{Attribute, Dataset, File, Group, H5Type, LinkType};
use ndarray::{Array2, Array4, Array5, ArrayD, Dimension, IxDyn};

use super::{MOST_BYTES, Scale, Variable, attribute, exact};
use crate::check;
use crate::error::Error;
use crate::table::{Axes, Exact, Fate, Path, Provenance, Table};

/// Longest text that is taken from a fixed-length attribute; the longest of ours has some hundred bytes.
const MOST_TEXT: usize = 4096;

/// Largest chunk, bytes: 4096 x 4096 bins.
const MOST_CHUNK: u64 = 1 << 27;

/// Rounding that another writer may have in scales and derived datasets.
const ROUNDING: f64 = 1e-12;

/// Reads and checks everything but the content hash; returns the table and the hash that the file states.
pub(crate) fn load(file: &File, path: &FilePath) -> Result<(Table, String), Error> {
    let root = Place::new(file, path, "")?;
    let format = root.text(attribute::FORMAT)?;
    if format != super::FORMAT {
        return Err(Error::Format {
            file: path.to_owned(),
            found: format,
            expected: super::FORMAT,
        });
    }
    let found: u64 = root.integer(attribute::VERSION)?;
    if !(1..=super::VERSION).contains(&found) {
        return Err(Error::Version {
            file: path.to_owned(),
            found,
            newest: super::VERSION,
        });
    }
    let invalid = |source| Error::Invalid {
        file: path.to_owned(),
        source,
    };
    let provenance = provenance(&root)?;
    let axes = Axes {
        incidence_deg: root.scale(&super::INCIDENCE)?,
        azimuth_deg: root.scale(&super::AZIMUTH)?,
        bins: root.scale(&super::SHIFT_U)?.len(),
        range: root.number(attribute::SHIFT_RANGE)?,
    };
    check::axes(&axes).map_err(invalid)?;
    root.bins(&super::SHIFT_U, &axes)?;
    root.bins(&super::SHIFT_V, &axes)?;
    root.fates()?;

    let (i, j) = axes.shape();
    let (b, f) = (axes.bins, Fate::ALL.len());
    let rays: Array2<u64> = root.array(&super::RAYS, &[i, j])?;
    let histogram = root.array(&super::HISTOGRAM, &[i, j, b, b])?;
    let retroreflected = root.array(&super::RETROREFLECTED, &[i, j])?;
    let standard_error = root.array(&super::STANDARD_ERROR, &[i, j])?;
    let fate = root.array(&super::FATE, &[i, j, f])?;
    let mut stored = Table {
        axes,
        histogram,
        counts: None,
        retroreflected,
        standard_error,
        fate,
        fate_counts: None,
        rays,
        exact: root.exact(i * j)?,
        provenance,
    };
    if root.has(super::COUNTS.name) || root.has(super::FATE_COUNTS.name) {
        let r = root.randomisations()?;
        let counts: Array5<u64> = root.array(&super::COUNTS, &[i, j, r, b, b])?;
        let fate_counts: Array4<u64> = root.array(&super::FATE_COUNTS, &[i, j, r, f])?;
        check::counts(&counts, &fate_counts, &stored.rays).map_err(invalid)?;
        stored = derived(stored, counts, fate_counts, path)?;
    }
    check::check(&stored).map_err(invalid)?;
    Ok((stored, root.text(attribute::CONTENT_HASH)?))
}

/// The table that follows from the counts, if what is stored beside them agrees.
fn derived(
    stored: Table,
    counts: Array5<u64>,
    fate_counts: Array4<u64>,
    path: &FilePath,
) -> Result<Table, Error> {
    let Table {
        axes,
        histogram,
        retroreflected,
        standard_error,
        fate,
        exact,
        provenance,
        ..
    } = stored;
    let mut table = Table::from_counts(axes, counts, fate_counts, provenance);
    table.exact = exact;
    agree(&super::HISTOGRAM, histogram, &table.histogram, path)?;
    agree(
        &super::RETROREFLECTED,
        retroreflected,
        &table.retroreflected,
        path,
    )?;
    agree(
        &super::STANDARD_ERROR,
        standard_error,
        &table.standard_error,
        path,
    )?;
    agree(&super::FATE, fate, &table.fate, path)?;
    Ok(table)
}

fn agree<D: Dimension>(
    variable: &Variable,
    stored: ndarray::Array<f64, D>,
    computed: &ndarray::Array<f64, D>,
    path: &FilePath,
) -> Result<(), Error> {
    // NaN agrees with nothing.
    let differ = |(_, (a, b)): &(usize, (&f64, &f64))| !((*a - *b).abs() <= ROUNDING);
    match stored.iter().zip(computed).enumerate().find(differ) {
        Some((index, (&stored, &computed))) => Err(Error::Derived {
            file: path.to_owned(),
            dataset: variable.name,
            index,
            stored,
            computed,
        }),
        None => Ok(()),
    }
}

fn provenance(root: &Place) -> Result<Provenance, Error> {
    let lattice = match root.attributes.contains(attribute::LATTICE) {
        true => Some(root.numbers::<4>(attribute::LATTICE)?)
            .map(|[ax, ay, bx, by]| [[ax, ay], [bx, by]]),
        false => None,
    };
    Ok(Provenance {
        generator: root.text(attribute::GENERATOR)?,
        design: root.text(attribute::DESIGN)?,
        mesh_hash: root.text(attribute::MESH_HASH)?,
        edge_length: root.number(attribute::EDGE_LENGTH)?,
        edge_length_unit: root.text(attribute::EDGE_LENGTH_UNIT)?,
        azimuth_zero: root.numbers(attribute::AZIMUTH_ZERO)?,
        refractive_index: root.number(attribute::REFRACTIVE_INDEX)?,
        back: root.text(attribute::BACK)?,
        losses: root.text(attribute::LOSSES)?,
        reflectance: root.number(attribute::REFLECTANCE)?,
        method: root.text(attribute::METHOD)?,
        sampler: root.text(attribute::SAMPLER)?,
        seed: root.integer(attribute::SEED)?,
        angular_tolerance_deg: root.number(attribute::ANGULAR_TOLERANCE_DEG)?,
        tolerance: root.number(attribute::TOLERANCE)?,
        lattice,
    })
}

/// A group of the file, with the names that it really holds.
struct Place<'a> {
    group: &'a Group,
    file: &'a FilePath,
    prefix: &'static str,
    links: HashSet<String>,
    attributes: HashSet<String>,
}

impl<'a> Place<'a> {
    fn new(group: &'a Group, file: &'a FilePath, prefix: &'static str) -> Result<Place<'a>, Error> {
        let failed = |source| Error::Hdf5 {
            file: file.to_owned(),
            place: format!("group /{prefix}"),
            source,
        };
        let mut links = HashSet::new();
        let visit = group.iter_visit_default(|name, info| {
            // A soft link may loop and an external one leaves the file: neither is part of a table.
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
            links,
            attributes,
        })
    }

    fn has(&self, name: &str) -> bool {
        self.links.contains(name)
    }

    fn named(&self, name: &str) -> String {
        format!("{}{name}", self.prefix)
    }

    fn hdf5(&self, kind: &str, name: &str) -> impl Fn(hdf5::Error) -> Error {
        let (file, place) = (self.file.to_owned(), format!("{kind} {}", self.named(name)));
        move |source| Error::Hdf5 {
            file: file.clone(),
            place: place.clone(),
            source,
        }
    }

    fn attribute(
        &self,
        name: &str,
        values: usize,
        expected: &'static str,
    ) -> Result<(Attribute, TypeDescriptor), Error> {
        if !self.attributes.contains(name) {
            return Err(Error::MissingAttribute {
                file: self.file.to_owned(),
                attribute: self.named(name),
            });
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
        match kind {
            Ok(kind) if fits && shape.iter().product::<usize>() == values => Ok((attribute, kind)),
            kind => Err(Error::AttributeType {
                file: self.file.to_owned(),
                attribute: self.named(name),
                expected,
                found: format!(
                    "{} of shape {shape:?}",
                    kind.map_or_else(|other| other, |kind| kind.to_string())
                ),
            }),
        }
    }

    /// The element type, or the words for one that has no Rust counterpart.
    fn kind(&self, datatype: hdf5::Datatype) -> Result<TypeDescriptor, String> {
        datatype
            .to_descriptor()
            .map_err(|_| "an unknown type".to_owned())
    }

    fn text(&self, name: &str) -> Result<String, Error> {
        let (attribute, kind) = self.attribute(name, 1, "a text")?;
        let texts = texts(&attribute, &kind).map_err(self.hdf5("attribute", name))?;
        Ok(texts.into_iter().next().unwrap_or_default())
    }

    fn number(&self, name: &str) -> Result<f64, Error> {
        let (attribute, _) = self.attribute(name, 1, "a number")?;
        first(&attribute).map_err(self.hdf5("attribute", name))
    }

    fn integer(&self, name: &str) -> Result<u64, Error> {
        let (attribute, _) = self.attribute(name, 1, "an integer")?;
        first(&attribute).map_err(self.hdf5("attribute", name))
    }

    fn numbers<const N: usize>(&self, name: &str) -> Result<[f64; N], Error> {
        let (attribute, _) = self.attribute(name, N, "numbers")?;
        let mut values = [0.0; N];
        attribute
            .read_into_raw(&mut values)
            .map_err(self.hdf5("attribute", name))?;
        Ok(values)
    }

    /// A dataset of that element type, stored inside the file by known means, and its shape.
    fn dataset(
        &self,
        name: &str,
        allowed: &[TypeDescriptor],
    ) -> Result<(Dataset, TypeDescriptor, Vec<usize>), Error> {
        let (file, dataset) = (self.file.to_owned(), self.named(name));
        if !self.has(name) {
            return Err(Error::MissingDataset { file, dataset });
        }
        let failed = self.hdf5("dataset", name);
        let found = self.group.dataset(name).map_err(&failed)?;
        let kind = self.kind(found.dtype().map_err(&failed)?);
        let kind = match kind {
            Ok(kind) if allowed.contains(&kind) => kind,
            other => {
                let expected = allowed[0].to_string();
                let found = other.map_or_else(|other| other, |kind| kind.to_string());
                return Err(Error::DatasetType {
                    file,
                    dataset,
                    expected,
                    found,
                });
            }
        };
        let shape = found.get_shape().map_err(&failed)?;
        let bytes = shape
            .iter()
            .map(|&n| n as u128)
            .try_fold(8_u128, u128::checked_mul)
            .unwrap_or(u128::MAX);
        if bytes > u128::from(MOST_BYTES) {
            return Err(Error::DatasetSize {
                file,
                dataset,
                bytes,
                limit: MOST_BYTES,
            });
        }
        match unusual_storage(&found).map_err(&failed)? {
            Some(found) => Err(Error::Storage {
                file,
                dataset,
                found,
            }),
            None => Ok((found, kind, shape)),
        }
    }

    fn flat<T: Element>(
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
            let expected = format!("[{}]", sides.join(", "));
            return Err(Error::Shape {
                file: self.file.to_owned(),
                dataset: self.named(name),
                expected,
                found: shape,
            });
        }
        let values = dataset.read_raw().map_err(self.hdf5("dataset", name))?;
        Ok((values, shape))
    }

    fn array<T: Element, D: Dimension>(
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

    fn scale(&self, scale: &Scale) -> Result<Vec<f64>, Error> {
        Ok(self.flat(scale.name, &[None])?.0)
    }

    fn differs(&self, scale: &Scale, index: usize, expected: String, found: String) -> Error {
        Error::Scale {
            file: self.file.to_owned(),
            dataset: self.named(scale.name),
            index,
            expected,
            found,
        }
    }

    fn bins(&self, scale: &Scale, axes: &Axes) -> Result<(), Error> {
        let (centres, _) = self.flat::<f64>(scale.name, &[Some(axes.bins)])?;
        let wrong = |&(i, found): &(usize, &f64)| {
            !((found - axes.bin_centre(i)).abs() <= ROUNDING * axes.range)
        };
        match centres.iter().enumerate().find(wrong) {
            Some((i, found)) => {
                Err(self.differs(scale, i, axes.bin_centre(i).to_string(), found.to_string()))
            }
            None => Ok(()),
        }
    }

    fn fates(&self) -> Result<(), Error> {
        let scale = &super::FATE_NAME;
        let (dataset, kind, shape) = self.dataset(scale.name, &TEXTS)?;
        if shape != [Fate::ALL.len()] {
            let expected = format!("[{}]", Fate::ALL.len());
            let dataset = self.named(scale.name);
            return Err(Error::Shape {
                file: self.file.to_owned(),
                dataset,
                expected,
                found: shape,
            });
        }
        let names = texts(&dataset, &kind).map_err(self.hdf5("dataset", scale.name))?;
        match names
            .iter()
            .zip(Fate::ALL)
            .position(|(name, fate)| name != fate.name())
        {
            Some(i) => {
                Err(self.differs(scale, i, Fate::ALL[i].name().to_owned(), names[i].clone()))
            }
            None => Ok(()),
        }
    }

    fn randomisations(&self) -> Result<usize, Error> {
        let scale = &super::RANDOMISATION;
        let (indices, _) = self.flat::<u64>(scale.name, &[None])?;
        match indices
            .iter()
            .enumerate()
            .find(|&(i, &index)| i as u64 != index)
        {
            Some((i, found)) => Err(self.differs(scale, i, i.to_string(), found.to_string())),
            None => Ok(indices.len()),
        }
    }

    fn exact(&self, directions: usize) -> Result<Option<Exact>, Error> {
        if !self.has(exact::GROUP) {
            return Ok(None);
        }
        let group = self
            .group
            .group(exact::GROUP)
            .map_err(self.hdf5("group", exact::GROUP))?;
        let place = Place::new(&group, self.file, "exact/")?;
        let (start, shape) = place.flat::<u64>(exact::POLYGON_START, &[None])?;
        let Some(count) = shape[0].checked_sub(1) else {
            let dataset = place.named(exact::POLYGON_START);
            return Err(Error::Shape {
                file: self.file.to_owned(),
                dataset,
                expected: "[paths + 1]".into(),
                found: shape,
            });
        };
        let (direction, _) = place.flat::<u64>(exact::PATH_DIRECTION, &[Some(count)])?;
        let (matrix, _) =
            place.flat::<f64>(exact::PATH_MATRIX, &[Some(count), Some(2), Some(2)])?;
        let (offset, _) = place.flat::<f64>(exact::PATH_OFFSET, &[Some(count), Some(2)])?;
        let (weight, _) = place.flat::<f64>(exact::PATH_WEIGHT, &[Some(count)])?;
        let (vertex, _) = place.flat::<f64>(exact::POLYGON_VERTEX, &[None, Some(2)])?;
        let (vertices, _) = vertex.as_chunks::<2>();
        let mut paths = vec![Vec::new(); directions];
        let wrong =
            |dataset: &'static str, index: usize, expected: String, found: u64| Error::Scale {
                file: self.file.to_owned(),
                dataset: place.named(dataset),
                index,
                expected,
                found: found.to_string(),
            };
        for k in 0..count {
            let lower = if k == 0 { 0 } else { direction[k - 1] };
            if direction[k] < lower || direction[k] >= directions as u64 {
                let expected = format!("{lower} to {}", directions - 1);
                return Err(wrong(exact::PATH_DIRECTION, k, expected, direction[k]));
            }
            let begin = if k == 0 { 0 } else { start[k] };
            let polygon = (start[k] == begin && start[k + 1] >= begin)
                .then(|| vertices.get(begin as usize..start[k + 1] as usize))
                .flatten();
            let Some(polygon) = polygon else {
                let expected = format!("{begin} to {}", vertices.len());
                return Err(wrong(exact::POLYGON_START, k + 1, expected, start[k + 1]));
            };
            let m = &matrix[4 * k..4 * k + 4];
            paths[direction[k] as usize].push(Path {
                polygon: polygon.to_vec(),
                matrix: [[m[0], m[1]], [m[2], m[3]]],
                offset: [offset[2 * k], offset[2 * k + 1]],
                weight: weight[k],
            });
        }
        if start[count] != vertices.len() as u64 || (count == 0 && start[0] != 0) {
            return Err(wrong(
                exact::POLYGON_START,
                count,
                vertices.len().to_string(),
                start[count],
            ));
        }
        Ok(Some(Exact {
            entrance_area: place.number(exact::ENTRANCE_AREA)?,
            paths,
        }))
    }
}

/// The element types of numeric datasets.
trait Element: H5Type {
    const KIND: TypeDescriptor;
}

impl Element for f64 {
    const KIND: TypeDescriptor = TypeDescriptor::Float(FloatSize::U8);
}

impl Element for u64 {
    const KIND: TypeDescriptor = TypeDescriptor::Unsigned(IntSize::U8);
}

const TEXTS: [TypeDescriptor; 2] = [TypeDescriptor::VarLenUnicode, TypeDescriptor::VarLenAscii];

fn first<T: H5Type + Default + Copy>(attribute: &Attribute) -> hdf5::Result<T> {
    let mut value = [T::default()];
    attribute.read_into_raw(&mut value)?;
    Ok(value[0])
}

fn texts(place: &hdf5::Container, kind: &TypeDescriptor) -> hdf5::Result<Vec<String>> {
    fn of<T: H5Type + AsRef<str>>(place: &hdf5::Container) -> hdf5::Result<Vec<String>> {
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

/// What is wrong with the way a dataset is stored, before it is read.
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
    let bytes = elements.and_then(|n| n.checked_mul(dataset.dtype().ok()?.size() as u64));
    let Some(bytes) = bytes.filter(|&bytes| bytes <= MOST_CHUNK) else {
        return Ok(Some("in chunks above 128 MiB"));
    };
    // Deflate adds at most 5 bytes per 16 KiB and some at the ends; a longer chunk would inflate past its size.
    let most = bytes + bytes / 1024 + 64;
    let mut inflated = false;
    dataset.chunks_visit(|chunk| {
        inflated |= chunk.size > most;
        0
    })?;
    Ok(inflated.then_some("in a chunk that is longer than its content"))
}
