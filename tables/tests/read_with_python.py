"""Opens a table with h5py, xarray and the reader of FORMAT.md.

Compares it with what the Rust test wrote.
"""

import hashlib
import importlib.util
import pathlib
import struct
import sys

import h5py
import numpy as np
import xarray

CHECKS = 0


def check(condition, what):
    global CHECKS
    CHECKS += 1
    if not condition:
        sys.exit(f"failed: {what}")


def content_hash(file):
    """Returns the hash as FORMAT.md describes it, from the file alone."""
    digest = hashlib.sha256()

    def item(name, value):
        digest.update(name.encode() + b"\0" + struct.pack("<Q", len(value)) + value)

    def floats(name, values):
        values = np.array(values, "<f8").ravel()
        values[np.isnan(values)] = np.frombuffer(struct.pack("<Q", 0x7FF8000000000000), "<f8")[0]
        item(name, values.tobytes())

    def integers(name, values):
        item(name, np.asarray(values).astype("<u8").tobytes())

    attrs = file.attrs
    item("format", attrs["format"].encode())
    floats("incidence_deg", file["incidence_deg"][()])
    floats("azimuth_deg", file["azimuth_deg"][()])
    integers("bins", len(file["shift_u"]))
    floats("shift_range", attrs["shift_range"])
    if "counts" in file:
        integers("counts", file["counts"][()])
        integers("fate_counts", file["fate_counts"][()])
    else:
        for name in ["histogram", "retroreflected", "fate"]:
            floats(name, file[name][()])
    if "exact" in file:
        group = file["exact"]
        floats("entrance_area", group.attrs["entrance_area"])
        integers("path_direction", group["path_direction"][()])
        for name in ["path_matrix", "path_offset", "path_weight", "path_deviation"]:
            if name in group:
                floats(name, group[name][()])
        if "path_passes" in group:
            integers("path_passes", group["path_passes"][()])
        if "path_jones" in group:
            floats("path_jones", group["path_jones"][()])
        integers("polygon_start", group["polygon_start"][()])
        floats("polygon_vertex", group["polygon_vertex"][()])
    if "deviation" in file:
        group = file["deviation"]
        integers("deviation_grid", [group.attrs["cells"], group.attrs["bins"]])
        floats("deviation_range", group.attrs["range"])
        for name in ["entry_start", "entry_place", "entry_rays"]:
            integers(name, group[name][()])
    texts = {
        "generator",
        "design",
        "mesh_hash",
        "edge_length_unit",
        "back",
        "losses",
        "method",
        "sampler",
    }
    for name in [
        "generator",
        "design",
        "mesh_hash",
        "edge_length",
        "edge_length_unit",
        "azimuth_zero",
        "refractive_index",
        "back",
        "losses",
        "reflectance",
        "method",
        "sampler",
        "seed",
        "angular_tolerance_deg",
        "tolerance",
        "lattice",
    ]:
        if name in texts:
            item(name, attrs[name].encode())
        elif name == "seed":
            integers(name, attrs[name])
        else:
            floats(name, attrs.get(name, []))
    for name in ["wavelength_nm", "metal_index"]:
        if name in attrs:
            floats(name, attrs[name])
    if "shards" in attrs:
        item("shards", attrs["shards"].encode())
    if "symmetry_rotations" in attrs:
        integers("symmetry_rotations", attrs["symmetry_rotations"])
        floats("symmetry_mirror_deg", attrs.get("symmetry_mirror_deg", []))
    if "direction_tolerance" in attrs:
        floats("direction_tolerance", attrs["direction_tolerance"])
    if "options" in attrs:
        item("options", attrs["options"].encode())
    return digest.hexdigest()


def main():
    kind, name, content, incidences, azimuths, bins, probability, eta, rays = sys.argv[1:]
    i, j, b = int(incidences), int(azimuths), int(bins)
    dims = {
        "histogram": ("incidence_deg", "azimuth_deg", "shift_v", "shift_u"),
        "retroreflected": ("incidence_deg", "azimuth_deg"),
        "standard_error": ("incidence_deg", "azimuth_deg"),
        "rays": ("incidence_deg", "azimuth_deg"),
        "fate": ("incidence_deg", "azimuth_deg", "fate_name"),
    }
    exact = kind in ("exact", "symmetric", "trapped", "lossy")
    if not exact:
        dims["counts"] = ("incidence_deg", "azimuth_deg", "randomisation", "shift_v", "shift_u")
        dims["fate_counts"] = ("incidence_deg", "azimuth_deg", "randomisation", "fate_name")

    with h5py.File(name, "r") as file:
        for variable, names in dims.items():
            for dimension, scale in enumerate(names):
                attached = file[variable].dims[dimension]
                check(
                    len(attached) == 1 and attached[0].name == "/" + scale,
                    f"{variable} dimension {dimension}",
                )
                check(file[scale].is_scale, f"{scale} is a scale")
            dataset = file[variable]
            check(dataset.chunks is not None, f"{variable} is chunked")
            check(
                dataset.shuffle and dataset.compression == "gzip" and dataset.fletcher32,
                f"{variable} filters",
            )
        check(file["histogram"].chunks == (1, 1, b, b), "a chunk per direction")
        for scale in ["incidence_deg", "azimuth_deg", "shift_u", "shift_v"]:
            check(
                isinstance(file[scale].attrs["units"], str) and file[scale].attrs["long_name"],
                f"{scale} units",
            )
        check(file.attrs["format"] == "retroreflective ray-shift table", "format")
        newer = kind == "deviations" or "options" in file.attrs
        front = {"trapped": (3, 11), "lossy": (4, 12)}
        version, fates = front.get(kind.split()[0], (2 if newer else 1, 10))
        check(file.attrs["version"] == version, "version")
        check(len(file["fate_name"]) == fates, "fates")
        check("d = -n cos(incidence) + t sin(incidence)" in file.attrs["frame"], "frame")
        check(file.attrs["content_hash"] == content, "content hash attribute")
        check(content_hash(file) == content, "content hash computed in Python")
        check(file.attrs["azimuths"].startswith("mean") == (kind == "mean"), "azimuths")
        check(
            file.attrs["design"] == "triangular-pair" and file.attrs["edge_length_unit"] == "mm",
            "texts",
        )
        check(
            file.attrs["lattice"].shape == (2, 2) and file.attrs["azimuth_zero"].shape == (3,),
            "vectors",
        )

    for options in [{"engine": "h5netcdf"}, {}]:
        with xarray.open_dataset(name, **options) as data:
            for variable, names in dims.items():
                check(data[variable].dims == names, f"xarray {variable} dims {data[variable].dims}")
            check(
                dict(data.sizes)["incidence_deg"] == i and data.sizes["azimuth_deg"] == j, "sizes"
            )
            step = 4.0 / b
            check(
                np.allclose(data.shift_u, (np.arange(b) + 0.5) * step - 2.0, atol=1e-15),
                "bin centres",
            )
            check(data.shift_u.attrs["units"] == "edge_length", "xarray units")
            check(data.incidence_deg.attrs["units"] == "degree", "xarray units")
            check(float(data.histogram[1, 0, 3, 4]) == float(probability), "histogram value")
            if kind != "mean":
                value = data.histogram.sel(
                    incidence_deg=10.0,
                    azimuth_deg=0.0,
                    shift_v=data.shift_v[3],
                    shift_u=data.shift_u[4],
                )
                check(float(value) == float(probability), "histogram by coordinates")
            else:
                check(bool(np.isnan(data.azimuth_deg).all()), "mean azimuth is NaN")
            check(float(data.retroreflected[1, 0]) == float(eta), "retroreflected")
            check(int(data.rays.sum()) == int(rays), "rays")
            total = data.histogram.sum(["shift_u", "shift_v"])
            check(bool((np.isclose(total, 1.0, atol=1e-12) | (total == 0)).all()), "histogram sums")
            check(bool(np.allclose(data.fate.sum("fate_name"), 1.0, atol=1e-12)), "fates sum to 1")
            returning = data.fate.sel(fate_name="retroreflected") + data.fate.sel(
                fate_name="out_of_range"
            )
            check(bool(np.allclose(returning, data.retroreflected, atol=1e-12)), "fates by name")
            check(
                data.attrs["refractive_index"] == 1.49 and data.attrs["content_hash"] == content,
                "xarray attrs",
            )

    reader = pathlib.Path(__file__).parent.parent / "read_table.py"
    spec = importlib.util.spec_from_file_location("read_table", reader)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    table = module.read_table(name)
    check(table["histogram"][1, 0, 3, 4] == float(probability), "read_table histogram")
    check(
        table["fate_name"][0] == "retroreflected"
        and len(table["fate_name"]) == fates,
        "read_table fates",
    )
    if kind == "deviations":
        group = table["deviation"]
        cells, bins = int(group["cells"]), int(group["bins"])
        pool = b // cells
        for direction in np.ndindex(i, j):
            k = direction[0] * j + direction[1]
            own = slice(*group["entry_start"][k : k + 2].astype(int))
            by_cell = np.bincount(
                (group["entry_place"][own] // bins**2).astype(int),
                group["entry_rays"][own],
                cells**2,
            )
            counts = table["counts"][direction].sum(0).reshape(cells, pool, cells, pool).sum((1, 3))
            check((by_cell.reshape(cells, cells) == counts).all(), "entries sum to counts")
            image, middles = module.deviation_image(table, *direction)
            check(image.sum() == counts.sum() and middles[bins // 2] == 0, "image of the spots")
    if kind == "symmetric":
        held = table["histogram"][1, 1]
        for azimuth, expected in [
            (30, held),
            (90, held),
            (-30, held),
            (330, held),
            (0, table["histogram"][1, 0]),
        ]:
            check(
                (module.at_azimuth(table, azimuth)["histogram"][1] == expected).all(),
                f"azimuth {azimuth}",
            )
        table["histogram"][1, 0, 2, 3] = 0.5
        table["azimuth_deg"] = np.array([10.0, 30.0])
        mirrored = module.at_azimuth(table, 50)
        check((mirrored["histogram"][1] == table["histogram"][1, 0, ::-1]).all(), "v turned over")
    elif exact:
        for direction in np.ndindex(i, j):
            here = [p for p in table["paths"] if (p["incidence"], p["azimuth"]) == direction]
            area = 0.0
            for path in here:
                x, y = path["polygon"].T
                area += path["weight"] * 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))
            check(
                abs(area / table["entrance_area"] - table["retroreflected"][direction]) < 1e-12,
                "polygon areas",
            )
    print(f"checks passed: {CHECKS}")


main()
