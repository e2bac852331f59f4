//! Making of a table from its content, the items of the content hash, as another process sends
//! them.
//!
//! Nothing is trusted: lengths are compared with one another and limited, and the table must obey
//! the rules of [`crate::table::check`] at the end.

use std::io::{self, BufRead, Read};

use ndarray::{Array, Array2, Dimension, ShapeError};

use crate::file::limits::MOST_BYTES;
use crate::options::{StatedOptions, Word};
use crate::table::axes::Axes;
use crate::table::check;
use crate::table::deviation::{Deviations, Grid};
use crate::table::exact::Exact;
use crate::table::flat::FlatEntries;
use crate::table::flat::FlatPaths;
use crate::table::provenance;
use crate::table::provenance::Provenance;
use crate::table::symmetry::Symmetry;
use crate::table::table::Table;

/// Longest name of an item, bytes.
const MOST_NAME: u64 = 64;

/// Reader of the items of a stream.
struct ItemReader<R> {
    from: R,
    /// Name of the next item; empty at the end.
    name: String,
    /// Length of the next item, bytes.
    length: u64,
}

impl<R: BufRead> ItemReader<R> {
    /// Reads the head of the first item.
    fn new(from: R) -> io::Result<ItemReader<R>> {
        let mut items = ItemReader {
            from,
            name: String::new(),
            length: 0,
        };
        items.advance()?;
        Ok(items)
    }

    /// Reads the head of the next item.
    fn advance(&mut self) -> io::Result<()> {
        let mut name = Vec::new();
        (&mut self.from).take(MOST_NAME).read_until(0, &mut name)?;
        if name.pop().is_some_and(|last| last != 0) {
            return Err(wrong("an item without a name"));
        }
        self.name = String::from_utf8(name).map_err(|_| wrong("a name that is no text"))?;
        self.length = 0;
        if !self.name.is_empty() {
            let mut length = [0; 8];
            self.from.read_exact(&mut length)?;
            self.length = u64::from_le_bytes(length);
        }
        if self.length > MOST_BYTES {
            return Err(wrong("an item that is too long"));
        }
        Ok(())
    }

    /// Reads the value of the next item, which must have this name.
    fn bytes(&mut self, name: &str) -> io::Result<Vec<u8>> {
        self.expect(name)?;
        let mut bytes = Vec::new();
        let read = (&mut self.from).take(self.length).read_to_end(&mut bytes)?;
        if read as u64 != self.length {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        self.advance()?;
        Ok(bytes)
    }

    /// Checks the name of the next item.
    fn expect(&self, name: &str) -> io::Result<()> {
        if self.name == name {
            Ok(())
        } else {
            Err(wrong(&format!("{:?} in the place of {name}", self.name)))
        }
    }

    /// Reads a text.
    fn text(&mut self, name: &str) -> io::Result<String> {
        String::from_utf8(self.bytes(name)?).map_err(|_| wrong("a text that is none"))
    }

    /// Reads an array of 8-byte numbers.
    fn words<T>(&mut self, name: &str, value: fn([u8; 8]) -> T) -> io::Result<Vec<T>> {
        self.expect(name)?;
        let mut values = Vec::new();
        let mut buffer = [0; 1 << 13];
        let mut left = self.length;
        while left > 0 {
            let (here, _) = buffer.split_at_mut(left.min(1 << 13) as usize);
            self.from.read_exact(here)?;
            let (words, rest) = here.as_chunks::<8>();
            if !rest.is_empty() {
                return Err(wrong("a part of a number"));
            }
            values.extend(words.iter().map(|&word| value(word)));
            left -= here.len() as u64;
        }
        self.advance()?;
        Ok(values)
    }

    /// Reads an array that some tables leave out. It is then empty.
    fn optional<T>(&mut self, name: &str, value: fn([u8; 8]) -> T) -> io::Result<Vec<T>> {
        if self.name != name {
            return Ok(Vec::new());
        }
        self.words(name, value)
    }

    /// Reads an array of numbers.
    fn floats(&mut self, name: &str) -> io::Result<Vec<f64>> {
        self.words(name, f64::from_le_bytes)
    }

    /// Reads an array of integers.
    fn integers(&mut self, name: &str) -> io::Result<Vec<u64>> {
        self.words(name, u64::from_le_bytes)
    }

    /// Reads `N` numbers.
    fn some<const N: usize>(&mut self, name: &str) -> io::Result<[f64; N]> {
        self.floats(name)?
            .try_into()
            .map_err(|_| wrong("too few numbers or too many"))
    }

    /// Reads one number.
    fn float(&mut self, name: &str) -> io::Result<f64> {
        self.some(name).map(|[value]| value)
    }

    /// Reads one integer.
    fn integer(&mut self, name: &str) -> io::Result<u64> {
        match self.integers(name)?[..] {
            [value] => Ok(value),
            _ => Err(wrong("too few numbers or too many")),
        }
    }
}

/// Reads the table that the stream holds.
///
/// # Errors
/// Returns an error if the stream ends early or holds something else than a table.
pub(crate) fn table(from: impl BufRead) -> io::Result<Table> {
    let mut items = ItemReader::new(from)?;
    items.text("format")?;
    let axes = Axes {
        incidence_deg: items.floats("incidence_deg")?,
        azimuth_deg: items.floats("azimuth_deg")?,
        bins: items.integer("bins")? as usize,
        range: items.float("shift_range")?,
    };
    check::axes(&axes).map_err(|error| wrong(&error.to_string()))?;
    let ((i, j), b) = (axes.shape(), axes.bins);
    let counted = if items.name == "counts" {
        let counts = items.integers("counts")?;
        let fates = items.integers("fate_counts")?;
        // `check` compares the number of fates with the options.
        let r = counts.len() / (i * j * b * b).max(1);
        let f = fates.len() / (i * j * r).max(1);
        Some((
            shaped((i, j, r, b, b), counts)?,
            shaped((i, j, r, f), fates)?,
        ))
    } else {
        None
    };
    let table = match counted {
        Some((counts, fates)) => {
            let exact = exact(&mut items, i * j)?;
            let deviations = deviations(&mut items, i * j)?;
            let mut table = Table::from_counts(axes, counts, fates, provenance(&mut items)?);
            table.exact = exact;
            table.deviations = deviations;
            table
        }
        None => Table {
            histogram: shaped((i, j, b, b), items.floats("histogram")?)?,
            counts: None,
            retroreflected: shaped((i, j), items.floats("retroreflected")?)?,
            standard_error: Array2::zeros((i, j)),
            fate: {
                let fates = items.floats("fate")?;
                shaped((i, j, fates.len() / (i * j).max(1)), fates)?
            },
            fate_counts: None,
            rays: Array2::zeros((i, j)),
            axes,
            exact: exact(&mut items, i * j)?,
            deviations: None,
            provenance: provenance(&mut items)?,
            passage: None,
            errors_rad: [0.0; 3],
        },
    };
    check::check(&table).map_err(|error| wrong(&error.to_string()))?;
    Ok(table)
}

/// Gives an array its shape.
fn shaped<T, D: Dimension>(
    shape: impl ndarray::IntoDimension<Dim = D>,
    values: Vec<T>,
) -> io::Result<Array<T, D>> {
    Array::from_shape_vec(shape.into_dimension(), values)
        .map_err(|error: ShapeError| wrong(&error.to_string()))
}

/// Reads the polygons, if they come next.
fn exact(items: &mut ItemReader<impl BufRead>, directions: usize) -> io::Result<Option<Exact>> {
    if items.name != "entrance_area" {
        return Ok(None);
    }
    let entrance_area = items.float("entrance_area")?;
    let flat = FlatPaths {
        direction: items.integers("path_direction")?,
        matrix: items.floats("path_matrix")?,
        offset: items.floats("path_offset")?,
        weight: items.floats("path_weight")?,
        deviation: items.optional("path_deviation", f64::from_le_bytes)?,
        passes: items.optional("path_passes", u64::from_le_bytes)?,
        jones: items.optional("path_jones", f64::from_le_bytes)?,
        cube: items.optional("path_cube", f64::from_le_bytes)?,
        start: items.integers("polygon_start")?,
        vertex: items.floats("polygon_vertex")?,
    };
    let count = flat.direction.len();
    let lengths = [
        flat.matrix.len(),
        flat.offset.len(),
        flat.weight.len(),
        flat.start.len(),
    ];
    let optional = [
        (flat.deviation.len(), 2 * count),
        (flat.passes.len(), count),
        (flat.jones.len(), 8 * count),
        (flat.cube.len(), 9 * count),
    ];
    if lengths != [4 * count, 2 * count, count, count + 1]
        || optional
            .iter()
            .any(|&(found, all)| found != 0 && found != all)
    {
        return Err(wrong("paths of different numbers"));
    }
    let paths = flat.paths(directions).map_err(|misfit| {
        let (array, k) = (misfit.array, misfit.index);
        let (found, expected) = (misfit.found, misfit.expected);
        wrong(&format!("{array}[{k}] is {found}, not {expected}"))
    })?;
    Ok(Some(Exact {
        entrance_area,
        paths,
    }))
}

/// Reads the rays by shift and deviation, if they come next.
fn deviations(
    items: &mut ItemReader<impl BufRead>,
    directions: usize,
) -> io::Result<Option<Deviations>> {
    if items.name != "deviation_grid" {
        return Ok(None);
    }
    let [cells, bins] = items.integers("deviation_grid")?[..] else {
        return Err(wrong("a grid of other than two numbers"));
    };
    let grid = Grid {
        cells: cells as usize,
        bins: bins as usize,
        range: items.float("deviation_range")?,
    };
    let flat = FlatEntries {
        start: items.integers("entry_start")?,
        place: items.integers("entry_place")?,
        rays: items.integers("entry_rays")?,
    };
    if flat.start.len() != directions + 1 || flat.place.len() != flat.rays.len() {
        return Err(wrong("entries of different numbers"));
    }
    let entries = flat.entries();
    let entries = entries.map_err(|k| wrong(&format!("entry_start does not fit at {k}")))?;
    Ok(Some(Deviations { grid, entries }))
}

/// Reads the provenance.
fn provenance(items: &mut ItemReader<impl BufRead>) -> io::Result<Provenance> {
    Ok(Provenance {
        generator: items.text("generator")?,
        design: items.text("design")?,
        mesh_hash: items.text("mesh_hash")?,
        edge_length: items.float("edge_length")?,
        edge_length_unit: items.text("edge_length_unit")?,
        azimuth_zero: items.some("azimuth_zero")?,
        refractive_index: items.float("refractive_index")?,
        back: Word::read(items.text("back")?),
        losses: Word::read(items.text("losses")?),
        reflectance: items.float("reflectance")?,
        method: Word::read(items.text("method")?),
        sampler: provenance::sampler(items.text("sampler")?),
        seed: items.integer("seed")?,
        angular_tolerance_deg: items.float("angular_tolerance_deg")?,
        tolerance: items.float("tolerance")?,
        lattice: match items.floats("lattice")?[..] {
            [] => None,
            [ax, ay, bx, by] => Some([[ax, ay], [bx, by]]),
            _ => return Err(wrong("a lattice of other than four numbers")),
        },
        wavelength_nm: match items.name.as_str() {
            "wavelength_nm" => Some(items.float("wavelength_nm")?),
            _ => None,
        },
        metal_index: match items.name.as_str() {
            "metal_index" => Some(items.some("metal_index")?),
            _ => None,
        },
        shards: match items.name.as_str() {
            "shards" => Some(
                items
                    .text("shards")?
                    .parse()
                    .map_err(|()| wrong("shards that are none"))?,
            ),
            _ => None,
        },
        symmetry: match items.name.as_str() {
            "symmetry_rotations" => Symmetry {
                rotations: u32::try_from(items.integer("symmetry_rotations")?)
                    .map_err(|_| wrong("too many rotations"))?,
                mirror_deg: match items.floats("symmetry_mirror_deg")?[..] {
                    [] => None,
                    [mirror] => Some(mirror),
                    _ => return Err(wrong("more than one mirror")),
                },
            },
            _ => Symmetry::NONE,
        },
        direction_tolerance: match items.name.as_str() {
            "direction_tolerance" => Some(items.float("direction_tolerance")?),
            _ => None,
        },
        options: match items.name.as_str() {
            "options" => items.text("options")?.as_str().into(),
            _ => StatedOptions::none(),
        },
    })
}

/// Makes the error of a stream that is no table.
fn wrong(what: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what)
}
