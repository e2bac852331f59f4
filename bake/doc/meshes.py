"""Meshes of many cubes for the benchmarks."""

import numpy as np


def read(path):
    """Returns corners, facets and the lattice of an OBJ file of `bake design`."""
    corners, facets, lattice = [], [], None
    for line in open(path):
        words = line.split()
        if words[:1] == ["v"]:
            corners.append([float(x) for x in words[1:4]])
        elif words[:1] == ["f"]:
            facets.append([int(word.split("/")[0]) - 1 for word in words[1:4]])
        elif words[:2] == ["#", "lattice"]:
            lattice = np.array([float(x) for x in words[2].split(",")]).reshape(2, 3)
    return np.array(corners), np.array(facets), lattice


def rim(corners):
    """Returns the sheet's normal and the height of the highest corner along it."""
    normal = np.ones(3) / np.sqrt(3)
    return normal, (corners @ normal).max()


def rhombus(corners):
    """Returns a corner of the entrance of a sheet of pairs, and the two sides that start there."""
    normal, top = rim(corners)
    points = corners[corners @ normal > top - 1e-9]
    away = np.linalg.norm(points - points.mean(0), axis=1)
    tips = [points[away.argmax()]]
    for _ in range(3):
        # The farthest point from all corners so far is the next corner.
        near = np.min([np.linalg.norm(points - tip, axis=1) for tip in tips], 0)
        tips.append(points[(near + 1e-6 * away).argmax()])
    # The first two corners are opposite ones.
    return tips[0], tips[2] - tips[0], tips[3] - tips[0]


def many(corners, facets, pairs, moved):
    """Returns the mesh of pairs x pairs pairs, whose apices are moved at random by up to `moved`."""
    rng = np.random.default_rng(1)
    _, a, b = rhombus(corners)
    used = np.bincount(facets.ravel(), minlength=len(corners))
    normal, top = rim(corners)
    apices = (used == 3) & (corners @ normal < top - 1e-9)
    all_corners, all_facets = [], []
    for i in range(pairs):
        for j in range(pairs):
            own = corners + i * a + j * b
            own[apices] += rng.uniform(-1, 1, (apices.sum(), 3)) * moved
            all_facets.append(facets + len(corners) * len(all_corners))
            all_corners.append(own)
    return np.concatenate(all_corners), np.concatenate(all_facets)


def divided(corners, facets):
    """Cuts the facets of the first cube, so that the mesh cannot be taken apart into cubes."""
    new_corners, new_facets = list(corners), list(facets[3:])
    for k, facet in enumerate(facets[:3]):
        pieces = [list(facet)]
        for _ in range(3 if k else 4):
            a, b, c = pieces.pop(0)
            middle = len(new_corners)
            new_corners.append(np.mean([new_corners[a], new_corners[b], new_corners[c]], 0))
            pieces += [[a, b, middle], [b, c, middle], [c, a, middle]]
        new_facets += [np.array(piece) for piece in pieces]
    return np.array(new_corners), np.array(new_facets)


def write(path, corners, facets):
    """Writes an OBJ file."""
    with open(path, "w") as out:
        for corner in corners:
            out.write("v " + " ".join(repr(float(x)) for x in corner) + "\n")
        for facet in facets:
            out.write("f " + " ".join(str(i + 1) for i in facet) + "\n")
