"""Reads a ray-shift table (FORMAT.md, versions 1 to 3) with h5py and numpy alone.

Usage: read_table.py TABLE.h5
"""

import sys

import h5py
import numpy as np


def read_table(name):
    """Returns axes, arrays and attributes as a dict, by their names in the file.

    An exact table also has 'paths', a list of dicts.
    """
    with h5py.File(name, "r") as file:
        table = {key: value for key, value in file.attrs.items()}
        if table.get("format") != "retroreflective ray-shift table":
            raise ValueError(f"{name}: not a ray-shift table")
        if not 1 <= table["version"] <= 3:
            raise ValueError(
                f"{name}: format version {table['version']}, this reader knows 1 to 3"
            )
        table.update(
            {key: data[()] for key, data in file.items() if isinstance(data, h5py.Dataset)}
        )
        table["fate_name"] = file["fate_name"].asstr()[()].tolist()
        if "exact" in file:
            group = {key: data[()] for key, data in file["exact"].items()}
            start, azimuths = group["polygon_start"].astype(int), len(table["azimuth_deg"])
            table["entrance_area"] = file["exact"].attrs["entrance_area"]
            table["paths"] = [
                {
                    "incidence": int(d) // azimuths,
                    "azimuth": int(d) % azimuths,
                    "weight": group["path_weight"][k],
                    "polygon": group["polygon_vertex"][start[k] : start[k + 1]],
                    "matrix": group["path_matrix"][k],
                    "offset": group["path_offset"][k],
                    "passes": int(group["path_passes"][k]) if "path_passes" in group else 0,
                }
                for k, d in enumerate(group["path_direction"])
            ]
        if "deviation" in file:
            group = file["deviation"]
            table["deviation"] = {key: data[()] for key, data in group.items()} | dict(group.attrs)
        return table


def deviation_image(table, i, j):
    """Returns the rays of a direction by deviation, and the middles of the bins.

    The rays are an image [along v, across]; the middles of the bins are tangents.
    """
    group = table["deviation"]
    bins, k = int(group["bins"]), i * len(table["azimuth_deg"]) + j
    own = slice(int(group["entry_start"][k]), int(group["entry_start"][k + 1]))
    image = np.bincount(
        (group["entry_place"][own] % bins**2).astype(int), group["entry_rays"][own], bins**2
    )
    return image.reshape(bins, bins), ((np.arange(bins) + 0.5) * 2 / bins - 1) * group["range"]


def at_azimuth(table, azimuth_deg):
    """Returns the histograms [incidence, v, u] and eta [incidence] at an azimuth.

    The table must hold the azimuth itself, or by its symmetry.
    """
    turn = 360 / table.get("symmetry_rotations", 1)
    mirror = table.get("symmetry_mirror_deg")
    for j, own in enumerate(table["azimuth_deg"]):
        for image, step in [(own, 1)] + ([(2 * mirror - own, -1)] if mirror is not None else []):
            if abs((azimuth_deg - image + turn / 2) % turn - turn / 2) < 1e-9:
                # A mirror turns v over.
                return {
                    "histogram": table["histogram"][:, j, ::step],
                    "retroreflected": table["retroreflected"][:, j],
                }
    raise KeyError(f"azimuth {azimuth_deg} deg is between those of the table")


if __name__ == "__main__":
    read = read_table(sys.argv[1])
    for i, incidence in enumerate(read["incidence_deg"]):
        print(f"{incidence:6.2f} deg:", *(f"{eta:.5f}" for eta in read["retroreflected"][i]))
