"""Compares paths between the directions of a table with those of a table of that direction.

    python read_between.py FOLDER_OF_read_table TABLE.h5 TRUTH.h5 TOLERANCE

TRUTH.h5 holds one direction. eta and the mean shift are compared; their differences, and the mean
square of the shift, must be within the tolerance.
"""

import sys

import numpy as np

folder, table, truth, tolerance = sys.argv[1:]
sys.path.insert(0, folder)
from read_table import paths_between, read_table


def moments(paths, whole):
    """Returns eta, and the sums of the shift (u, v) and of its square over the light."""
    sums = np.zeros(4)
    for path in paths:
        # Triangles from the first corner; the mean square over a triangle is that of the middles
        # of its sides.
        first, corners = path["polygon"][0], path["polygon"]
        for a, b in zip(corners[1:-1], corners[2:]):
            (x, y), (z, w) = a - first, b - first
            share = 0.5 * (x * w - y * z) / whole * path["weight"]
            middles = np.array([first + a, a + b, b + first]) / 2
            shifts = middles @ path["matrix"].T + path["offset"]
            sums += share * np.array([1, *shifts.mean(0), (shifts**2).sum(1).mean()])
    return sums


table, truth = read_table(table), read_table(truth)
found = moments(paths_between(table, truth["incidence_deg"][0], 0), table["entrance_area"])
expected = moments(truth["paths"], truth["entrance_area"])
assert abs(expected[0] - truth["retroreflected"][0, 0]) < 1e-12, "the polygons hold all light"
assert (abs(found - expected) <= float(tolerance)).all(), (found, expected)
print("within", tolerance)
