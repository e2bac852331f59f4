"""Reads a ray-shift table (FORMAT.md, versions 1 to 4) with h5py and numpy alone.

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
        if not 1 <= table["version"] <= 4:
            raise ValueError(
                f"{name}: format version {table['version']}, this reader knows 1 to 4"
            )
        table.update(
            {key: data[()] for key, data in file.items() if isinstance(data, h5py.Dataset)}
        )
        table["fate_name"] = file["fate_name"].asstr()[()].tolist()
        if "exact" in file:
            group = {key: data[()] for key, data in file["exact"].items()}
            zero = np.zeros(2)
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
                    "deviation": group["path_deviation"][k] if "path_deviation" in group else zero,
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


def paths_between(table, incidence_deg, j):
    """Returns the paths at an incidence between those of an exact table, at its azimuth number j.

    A path that ends between the two incidences around is a ValueError. FORMAT.md, "Between
    directions", has the accuracy.
    """
    own = np.array([incidence_deg, *table["incidence_deg"]])
    tangent = np.tan(np.arcsin(np.sin(np.radians(own)) / table["refractive_index"]))
    i = int(np.clip(np.searchsorted(own[1:], incidence_deg) - 1, 0, len(own) - 3))
    t = (tangent[0] - tangent[i + 1]) / (tangent[i + 2] - tangent[i + 1])
    around = [
        [p for p in table["paths"] if (p["incidence"], p["azimuth"]) == (k, j)] for k in (i, i + 1)
    ]
    if len(around[0]) != len(around[1]):
        raise ValueError(f"a path ends between {own[i + 1]} and {own[i + 2]} deg")
    seen = [[_about_fixed_point(path) for path in side] for side in around]
    most = max([abs(p["deviation"]).max() for side in around for p in side], default=0) or 1

    def unlike(a, b):  # by shape, and by exit direction, which tells paths of one cube apart
        shape = abs(seen[0][a][2] - seen[1][b][2]).max()
        turned = abs(around[0][a]["deviation"] - around[1][b]["deviation"]).max()
        return shape + 4 * turned / most

    found, left = [], list(range(len(around[1])))
    for a, path in enumerate(around[0]):
        b = min(left, key=lambda b: unlike(a, b))
        left.remove(b)
        (fixed, corners, _), (other_fixed, others, _) = seen[0][a], seen[1][b]
        if len(corners) == len(others):  # the corners move on straight lines
            turns = [np.roll(others, n) for n in range(len(others))]
            outline = (1 - t) * corners + t * min(turns, key=lambda to: abs(to - corners).sum())
        else:  # the edges keep their slopes
            (from_a, edges_a), (from_b, edges_b) = _edges(corners), _edges(others)
            edges = np.concatenate([(1 - t) * edges_a, t * edges_b])
            edges = edges[np.argsort(np.angle(edges * TILT) % (2 * np.pi))]
            outline = (1 - t) * from_a + t * from_b + np.cumsum(edges)
        mix = {
            key: (1 - t) * path[key] + t * around[1][b][key]
            for key in ("weight", "matrix", "deviation")
        }
        middle = (1 - t) * fixed + t * other_fixed
        mix["offset"] = -mix["matrix"] @ [middle.real, middle.imag]
        outline = outline + middle
        found.append(mix | {"polygon": np.stack([outline.real, outline.imag], -1)})
    return found


# No edge of a polygon is level after this turn, so none is lost or counted twice.
TILT = np.exp(0.1j)


def _about_fixed_point(path):
    """Returns the fixed point of a path's map, the corners seen from it, and their reach around it.

    Points of the plane are complex numbers.
    """
    fixed = np.linalg.solve(path["matrix"], -path["offset"]) @ [1, 1j]
    corners = path["polygon"] @ [1, 1j] - fixed
    around = np.exp(1j * np.linspace(0, 2 * np.pi, 64, endpoint=False))
    return fixed, corners, (corners[:, None] * around.conj()).real.max(0)


def _edges(corners):
    """Returns the lowest corner of a convex polygon, and its edges from there on."""
    corners = np.roll(corners, -(corners * TILT).imag.argmin())
    return corners[0], np.roll(corners, -1) - corners


if __name__ == "__main__":
    read = read_table(sys.argv[1])
    for i, incidence in enumerate(read["incidence_deg"]):
        print(f"{incidence:6.2f} deg:", *(f"{eta:.5f}" for eta in read["retroreflected"][i]))
