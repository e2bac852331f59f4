//! Content hash: a hash of what a table says, whatever the file, the threads or the shards.
//!
//! It is SHA-256 over items in a fixed order. An item is its name in UTF-8, a zero byte, the length
//! of its value in bytes as a little-endian u64, and the value, little-endian (`FORMAT.md` lists
//! the items). Derived datasets are left out: they follow from the counts and are checked against
//! them on reading.

use sha2::{Digest, Sha256};

use crate::table::deviation::Deviations;
use crate::table::exact::Exact;
use crate::table::flat::{FlatEntries, FlatPaths};
use crate::table::provenance::Provenance;
use crate::table::symmetry::Symmetry;
use crate::table::table::Table;

/// Tag that starts the hashed content, whatever the version.
const TAG: &str = "retroreflective ray-shift table";

impl Table {
    /// Returns the SHA-256 of the content, 64 lower-case hex digits.
    ///
    /// It covers axes, counts and fates by randomisation (or, without counts, histogram, eta and
    /// fate fractions), the polygons of an exact table, the deviations, and the whole provenance.
    /// Two tables of equal hash are equal.
    pub fn content_hash(&self) -> String {
        let mut hash = Sha256::new();
        self.items(&mut |bytes| hash.update(bytes), false);
        hex(hash.finalize().as_ref())
    }

    /// Gives the items of the table to `sink`, piece by piece.
    #[cfg(feature = "hdf5")]
    pub(crate) fn content(&self, sink: &mut dyn FnMut(&[u8])) {
        self.items(sink, true);
    }

    /// Gives the items to `sink`, with or without the cubes. They follow from the mesh, and the hash
    /// leaves them out, so that programs which do not know them read the table too.
    fn items(&self, sink: &mut dyn FnMut(&[u8]), with_cubes: bool) {
        let mut items = ItemWriter(sink);
        items.text("format", TAG);
        items.floats("incidence_deg", self.axes.incidence_deg.iter().copied());
        items.floats("azimuth_deg", self.axes.azimuth_deg.iter().copied());
        items.integers("bins", [self.axes.bins as u64].into_iter());
        items.floats("shift_range", [self.axes.range].into_iter());
        match (&self.counts, &self.fate_counts) {
            (Some(counts), Some(fate_counts)) => {
                items.integers("counts", counts.iter().copied());
                items.integers("fate_counts", fate_counts.iter().copied());
            }
            _ => {
                items.floats("histogram", self.histogram.iter().copied());
                items.floats("retroreflected", self.retroreflected.iter().copied());
                items.floats("fate", self.fate.iter().copied());
            }
        }
        if let Some(exact) = &self.exact {
            items.exact(exact, with_cubes);
        }
        if let Some(deviations) = &self.deviations {
            items.deviations(deviations);
        }
        items.provenance(&self.provenance);
    }
}

/// Returns bytes as lower-case hex digits.
pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Writer of items, which gives their bytes to a function.
struct ItemWriter<'a>(&'a mut dyn FnMut(&[u8]));

impl ItemWriter<'_> {
    /// Writes the name and the length of an item.
    fn head(&mut self, name: &str, bytes: usize) {
        self.0(name.as_bytes());
        self.0(&[0]);
        self.0(&(bytes as u64).to_le_bytes());
    }

    /// Writes a text.
    fn text(&mut self, name: &str, value: &str) {
        self.head(name, value.len());
        self.0(value.as_bytes());
    }

    /// Writes an array of 8-byte numbers.
    fn words(&mut self, name: &str, values: impl ExactSizeIterator<Item = [u8; 8]>) {
        self.head(name, 8 * values.len());
        let mut buffer = Vec::with_capacity(1 << 16);
        for value in values {
            buffer.extend_from_slice(&value);
            if buffer.len() == 1 << 16 {
                self.0(&buffer);
                buffer.clear();
            }
        }
        self.0(&buffer);
    }

    /// Writes an array of integers.
    fn integers(&mut self, name: &str, values: impl ExactSizeIterator<Item = u64>) {
        self.words(name, values.map(u64::to_le_bytes));
    }

    /// Writes an array of numbers.
    ///
    /// The only NaN of a table is the azimuth of a mean. It is written with fixed payload bits,
    /// because they differ between machines.
    fn floats(&mut self, name: &str, values: impl ExactSizeIterator<Item = f64>) {
        self.words(
            name,
            values.map(|x| {
                if x.is_nan() {
                    0x7ff8_0000_0000_0000_u64.to_le_bytes()
                } else {
                    x.to_le_bytes()
                }
            }),
        );
    }

    /// Writes the polygons of an exact table.
    fn exact(&mut self, exact: &Exact, with_cubes: bool) {
        let flat = FlatPaths::new(exact);
        self.floats("entrance_area", [exact.entrance_area].into_iter());
        self.integers("path_direction", flat.direction.iter().copied());
        self.floats("path_matrix", flat.matrix.iter().copied());
        self.floats("path_offset", flat.offset.iter().copied());
        self.floats("path_weight", flat.weight.iter().copied());
        if !flat.deviation.is_empty() {
            self.floats("path_deviation", flat.deviation.iter().copied());
        }
        if !flat.passes.is_empty() {
            self.integers("path_passes", flat.passes.iter().copied());
        }
        if !flat.jones.is_empty() {
            self.floats("path_jones", flat.jones.iter().copied());
        }
        if with_cubes && !flat.cube.is_empty() {
            self.floats("path_cube", flat.cube.iter().copied());
        }
        self.integers("polygon_start", flat.start.iter().copied());
        self.floats("polygon_vertex", flat.vertex.iter().copied());
    }

    /// Writes the rays by shift and deviation.
    fn deviations(&mut self, found: &Deviations) {
        let flat = FlatEntries::new(found);
        let grid = [found.grid.cells, found.grid.bins].map(|n| n as u64);
        self.integers("deviation_grid", grid.into_iter());
        self.floats("deviation_range", [found.grid.range].into_iter());
        self.integers("entry_start", flat.start.iter().copied());
        self.integers("entry_place", flat.place.iter().copied());
        self.integers("entry_rays", flat.rays.iter().copied());
    }

    /// Writes the provenance.
    fn provenance(&mut self, provenance: &Provenance) {
        let Provenance {
            generator,
            design,
            mesh_hash,
            edge_length,
            edge_length_unit,
            azimuth_zero,
            refractive_index,
            back,
            losses,
            reflectance,
            method,
            sampler: _,
            seed,
            angular_tolerance_deg,
            tolerance,
            lattice,
            wavelength_nm,
            metal_index,
            shards,
            symmetry,
            direction_tolerance,
            options,
        } = provenance;
        self.text("generator", generator);
        self.text("design", design);
        self.text("mesh_hash", mesh_hash);
        self.floats("edge_length", [*edge_length].into_iter());
        self.text("edge_length_unit", edge_length_unit);
        self.floats("azimuth_zero", azimuth_zero.iter().copied());
        self.floats("refractive_index", [*refractive_index].into_iter());
        self.text("back", back.text());
        self.text("losses", losses.text());
        self.floats("reflectance", [*reflectance].into_iter());
        self.text("method", method.text());
        self.text("sampler", provenance.sampler_text());
        self.integers("seed", [*seed].into_iter());
        self.floats(
            "angular_tolerance_deg",
            [*angular_tolerance_deg].into_iter(),
        );
        self.floats("tolerance", [*tolerance].into_iter());
        let lattice: &[f64] = lattice.as_ref().map_or(&[], |rows| rows.as_flattened());
        self.floats("lattice", lattice.iter().copied());
        // An absent value gives no item, so that older tables keep their hash.
        if let Some(wavelength_nm) = wavelength_nm {
            self.floats("wavelength_nm", [*wavelength_nm].into_iter());
        }
        if let Some(metal_index) = metal_index {
            self.floats("metal_index", metal_index.iter().copied());
        }
        if let Some(shards) = shards {
            self.text("shards", &shards.to_string());
        }
        if *symmetry != Symmetry::NONE {
            self.integers(
                "symmetry_rotations",
                [u64::from(symmetry.rotations)].into_iter(),
            );
            let mirror = symmetry.mirror_deg;
            self.floats("symmetry_mirror_deg", mirror.iter().copied());
        }
        if let Some(tolerance) = direction_tolerance {
            self.floats("direction_tolerance", [*tolerance].into_iter());
        }
        if !options.text().is_empty() {
            self.text("options", options.text());
        }
    }
}
