"""Opens a table with h5py and with xarray, and checks what they show.

    python read_table.py TABLE.h5 METHOD

METHOD is rays or exact. The table holds a single triangular cube with index 1.49. Its eta (dataset
retroreflected) has a closed form: 2/3 (1 - 2 tan^2 theta) for theta up to 19.47 degrees, where
theta is the incidence inside the sheet. The script calls only the packages, as a user does in a
notebook.
"""

import math
import sys

import h5py
import numpy as np
import xarray

path, method = sys.argv[1:]
directions = 0


def fraction(incidence_deg):
    inside = math.asin(math.sin(math.radians(incidence_deg)) / 1.49)
    return 2 / 3 * (1 - 2 * math.tan(inside) ** 2) if inside < math.radians(19.47) else None


def check_direction(incidence_deg, histogram, retroreflected, standard_error, fates):
    global directions
    assert abs(histogram.sum() - 1) < 1e-9, histogram.sum()
    assert (histogram >= 0).all()
    assert abs(fates.sum() - 1) < 1e-9, fates.sum()
    expected = fraction(incidence_deg)
    # Rays: 4.5 standard errors are allowed. A standard error counts as at least one ray of the
    # million that was launched. Exact: rounding is allowed.
    assert (standard_error == 0) == (method == "exact"), standard_error
    within = 1e-12 if method == "exact" else 4.5 * max(standard_error, 1e-6)
    assert expected is None or abs(retroreflected - expected) < within, (
        incidence_deg,
        retroreflected,
        expected,
    )
    directions += 1


# The groups have names for all dimensions: xarray calls a dimension without a name phony_dim_0.
group = {"rays": None, "exact": "exact"}[method]
with xarray.open_dataset(path, engine="h5netcdf", group=group) as data:
    assert data.sizes and not any("phony" in name for name in data.sizes), data.sizes
    assert group is None or data.sizes["path"] + 1 == data.sizes["bound"], data.sizes

with h5py.File(path) as file:
    assert [
        dimension.label or dimension[0].name.strip("/") for dimension in file["histogram"].dims
    ] == ["incidence_deg", "azimuth_deg", "shift_v", "shift_u"]
    assert list(file["incidence_deg"]) == [0, 10, 35] and list(file["azimuth_deg"]) == [0, 30]
    for i, incidence in enumerate(file["incidence_deg"]):
        for j in range(2):
            check_direction(
                incidence,
                *(
                    file[name][i, j]
                    for name in ("histogram", "retroreflected", "standard_error", "fate")
                ),
            )
    for name in ("incidence_deg", "azimuth_deg", "shift_u", "shift_v"):
        assert file[name].attrs["units"] and file[name].attrs["long_name"], name
    for name in (
        "format",
        "version",
        "generator",
        "design",
        "mesh_hash",
        "edge_length",
        "refractive_index",
        "back",
        "method",
        "sampler",
        "seed",
        "content_hash",
    ):
        assert name in file.attrs, name
    assert file.attrs["method"] == method and ("counts" in file) == (method == "rays")
    plain = file["histogram"][1, 1]

with xarray.open_dataset(path, engine="h5netcdf") as table:
    assert table.histogram.dims == ("incidence_deg", "azimuth_deg", "shift_v", "shift_u")
    assert table.retroreflected.dims == ("incidence_deg", "azimuth_deg")
    for incidence in (0, 10, 35):
        for azimuth in (0, 30):
            at = table.sel(incidence_deg=incidence, azimuth_deg=azimuth)
            check_direction(
                incidence,
                at.histogram.values,
                float(at.retroreflected),
                float(at.standard_error),
                at.fate.values,
            )
    assert np.array_equal(table.histogram.sel(incidence_deg=10, azimuth_deg=30).values, plain)
    # The ray shift of an ideal cube at normal incidence is 2(q - p), with the apex q. Rays enter
    # through a hexagon, which has point symmetry about q. So the mean of the shift is zero.
    upright = table.histogram.sel(incidence_deg=0, azimuth_deg=0)
    mean = [float((upright * upright[axis]).sum()) for axis in ("shift_u", "shift_v")]
    assert max(map(abs, mean)) < 3e-3, mean

print(f"read {directions // 2} directions twice")
