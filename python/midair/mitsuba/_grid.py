"""A ray-shift table as arrays of numpy: a grid of directions, with eta and shifts at its nodes.

The directions of a table are the nodes of a grid: along the incidence by tan(incidence inside),
around the azimuth by the azimuth itself, over all azimuths that the symmetry of the cell gives.

- **eta** between nodes is that of `Table.eta_at`, sampled on a finer grid and interpolated by
  parabolas. `Grid.eta_error` is the difference that 99 % of random directions keep.
- **A node** holds triangles (of an exact table: each polygon cut into triangles) or parallelograms
  (the bins of a table of rays), and an alias table that chooses one by its power in one step.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from midair._errors import Error, refusals
from midair._table import Floats, Table

#: Error of eta that 99 % of random directions must keep, or the finer grid is refined.
#: A parabola errs by f'' h^2 / 16 where a corner of a polygon vanishes, and far less elsewhere. The
#: remaining 1 % lies at jumps, where the table's own interpolation changes its paths abruptly.
FINE = 5e-6
#: Most directions at which the table is asked for its eta; each takes some 5 us.
MOST = 500_000
#: Random directions at which the interpolated eta is compared with that of the table.
TRIED = 1000


@dataclass(frozen=True)
class Axis:
    """Nodes of one angle, with cells of equal parts between them.

    `x` ascends. A cell has `parts` parts, so 2 * `parts` steps of the finer grid.
    """

    x: Floats
    parts: int

    @property
    def cells(self) -> int:
        """Number of cells between nodes."""
        return len(self.x) - 1

    @property
    def fine(self) -> Floats:
        """Points of the finer grid: the nodes, and equally spaced points between them."""
        steps = 2 * self.parts
        place = np.arange(self.cells * steps + 1) / steps
        return np.interp(place, np.arange(len(self.x)), self.x)


@dataclass(frozen=True)
class Grid:
    """Table as arrays of numpy; `Directions` brings them to the device.

    Attributes
    ----------
    index : float
        Refractive index behind the front face.
    along, around : Axis
        tan(incidence inside), and azimuth in degrees from 0 to 360. A mean over azimuths has no
        axis around (None).
    eta : ndarray, shape (fine incidences, fine azimuths)
        Share of the light that comes back.
    node_eta : ndarray, shape (incidences, azimuths)
        The same at the nodes.
    place, flip : ndarray, shape (azimuths,)
        Azimuth of the table that each node repeats, and whether v is turned over.
    start, count : ndarray, shape (incidences * azimuths of the table,)
        First entry of a distribution, and the number of its entries.
    entry : ndarray, shape (n, 8)
        Corner (u, v) and two sides of a triangle in edge lengths, threshold and alias.
    deviation : ndarray, shape (n, 2), or None
        Tangents of the angles from straight back; None if all are 0.
    is_exact : bool
        True for triangles, False for parallelograms.
    eta_error : float
        Difference from `Table.eta_at` that 99 % of random directions keep.
    """

    index: float
    along: Axis
    around: Axis | None
    eta: Floats
    node_eta: Floats
    place: npt.NDArray[np.int64]
    flip: npt.NDArray[np.bool_]
    start: npt.NDArray[np.int64]
    count: npt.NDArray[np.int64]
    entry: Floats
    deviation: Floats | None
    is_exact: bool
    eta_error: float


_KEPT: dict[str, Grid] = {}


def grid_of(table: Table) -> Grid:
    """Return a table as arrays. The last tables are kept, by their content.

    Raises
    ------
    Error
        If the table has one incidence only, or does not go all around.
    """
    key = table.content_hash
    if key not in _KEPT:
        while len(_KEPT) >= 8:
            _KEPT.pop(next(iter(_KEPT)))
        _KEPT[key] = _grid_of(table)
    return _KEPT[key]


def _grid_of(table: Table) -> Grid:
    incidences = table.incidence_deg
    if len(incidences) < 2:
        raise Error(
            f"the table holds the incidence {incidences[0]:g} only, and rays of a scene have many; "
            'trace it with several, such as incidence="0:60:5"'
        )
    if not table.is_exact and table._table.has_exits():
        raise Error(
            "the table of rays counts exit directions apart from paths, and a ray of a scene needs "
            'both; trace it with method="exact" (bake trace --method exact)'
        )
    index = float(table.provenance["refractive_index"])
    images = table._table.azimuths()
    is_mean = bool(np.isnan(table.azimuth_deg).any())
    azimuths = np.array([azimuth for azimuth, _, _ in images])
    if not is_mean:
        _all_around(table, azimuths)
    place = np.array([index for _, index, _ in images])
    flip = np.array([flipped for _, _, flipped in images])
    # The finer grid is refined until it is good enough, or as far as the work allows.
    gaps = 1 if is_mean else len(_unlike(place, flip))
    start, count, entry, deviation = _entries(table)
    parts_i, parts_a = 2, 2
    while True:
        along = Axis(_inside(incidences, index), parts_i)
        around = None if is_mean else Axis(np.append(azimuths, azimuths[0] + 360), parts_a)
        eta = _fine_eta(table, along, around, place, flip, index)
        node_eta = eta[:: 2 * parts_i, :: 1 if is_mean else 2 * parts_a]
        made = Grid(
            index=index,
            along=along,
            around=around,
            eta=eta,
            node_eta=np.ascontiguousarray(node_eta if is_mean else node_eta[:, :-1]),
            place=place,
            flip=flip,
            start=start,
            count=count,
            entry=entry,
            deviation=deviation,
            is_exact=_has_polygons(table),
            eta_error=0.0,
        )
        object.__setattr__(made, "eta_error", _eta_error(table, made))
        more_i, more_a = 2 * parts_i, 1 if is_mean else 2 * parts_a
        asked = ((len(incidences) - 1) * 2 * more_i + 1) * gaps * 2 * more_a
        if made.eta_error < FINE or asked > MOST:
            return made
        parts_i, parts_a = more_i, more_a


def _inside(incidence_deg: npt.ArrayLike, index: float) -> Floats:
    """Return tan(incidence inside) of incidences in the air."""
    sine = np.sin(np.radians(np.asarray(incidence_deg, float))) / index
    made: Floats = sine / np.sqrt(1 - sine * sine)
    return made


def _outside(tangent: npt.ArrayLike, index: float) -> Floats:
    """Return the incidences in the air, degrees, of tan(incidence inside)."""
    tan = np.asarray(tangent, float)
    sine = np.minimum(index * tan / np.sqrt(1 + tan * tan), 1.0)
    made: Floats = np.degrees(np.arcsin(sine))
    return made


def _all_around(table: Table, azimuths: Floats) -> None:
    """Refuse a table with a gap between azimuths in which it gives no answer."""
    widest = float(np.diff(table.azimuth_deg).max()) if len(table.azimuth_deg) > 1 else 0.0
    gaps = np.diff(np.append(azimuths, azimuths[0] + 360))
    if gaps.max() > widest + 1e-6:
        own = table.azimuth_deg
        held = f"{own[0]:g}" if len(own) == 1 else f"{own[0]:g} to {own[-1]:g}"
        raise Error(
            f"the table holds the azimuth {held} only, and rays of a scene have all; trace it with "
            'azimuth="full:10" (bake trace --azimuth full:10)'
        )


def _unlike(place: npt.NDArray[np.int64], flip: npt.NDArray[np.bool_]) -> dict[Any, int]:
    """Return the gaps between azimuths that symmetry does not make equal: name and first index."""
    made: dict[Any, int] = {}
    for j in range(len(place)):
        made.setdefault(_name(place, flip, j)[0], j)
    return made


def _name(
    place: npt.NDArray[np.int64], flip: npt.NDArray[np.bool_], j: int
) -> tuple[tuple[tuple[int, bool], tuple[int, bool]], bool]:
    """Return the name of the gap behind azimuth j, and whether it runs backwards."""
    k = (j + 1) % len(place)
    here, there = (int(place[j]), bool(flip[j])), (int(place[k]), bool(flip[k]))
    turned = (there[0], not there[1]), (here[0], not here[1])
    return ((here, there), False) if (here, there) <= turned else (turned, True)


def _fine_eta(
    table: Table,
    along: Axis,
    around: Axis | None,
    place: npt.NDArray[np.int64],
    flip: npt.NDArray[np.bool_],
    index: float,
) -> Floats:
    """Return eta on the finer grid."""
    incidences = _outside(along.fine, index)
    steps = 2 * along.parts
    # Own directions exactly, and none beyond the ends by rounding.
    incidences[::steps] = table.incidence_deg
    if around is None:
        return _asked(table, incidences, np.zeros(1))
    azimuths, steps = around.fine, 2 * around.parts
    made = np.empty((len(incidences), len(azimuths)))
    known: dict[Any, Floats] = {}
    for j in range(around.cells):
        name, backwards = _name(place, flip, j)
        columns = slice(j * steps, (j + 1) * steps + 1)
        if name not in known:
            values = _asked(table, incidences, azimuths[columns])
            known[name] = values[:, ::-1] if backwards else values
        made[:, columns] = known[name][:, ::-1] if backwards else known[name]
    return made


def _asked(table: Table, incidences: Floats, azimuths: Floats) -> Floats:
    """Return eta of the table, shape (incidences, azimuths)."""
    i, a = np.meshgrid(incidences, azimuths, indexing="ij")
    with refusals():
        values = table._table.etas(i.ravel(), a.ravel())
    return values.reshape(i.shape)


def eta_of(grid: Grid, incidence_deg: npt.ArrayLike, azimuth_deg: npt.ArrayLike) -> Floats:
    """Return the interpolated eta as the device computes it, in numpy; for directions inside."""
    tangent = _inside(incidence_deg, grid.index)
    rows, weights_i = _parabola(grid.along, tangent)
    if grid.around is None:
        made: Floats = np.sum(weights_i * grid.eta[rows, 0], axis=0)
        return made
    turned = (np.asarray(azimuth_deg, float) - grid.around.x[0]) % 360 + grid.around.x[0]
    columns, weights_a = _parabola(grid.around, turned)
    values = grid.eta[rows[:, None], columns[None]]
    made = np.sum(weights_i[:, None] * weights_a[None] * values, axis=(0, 1))
    return made


def _parabola(axis: Axis, x: Floats) -> tuple[npt.NDArray[np.int64], Floats]:
    """Return the three points of the finer grid around each x, and their weights."""
    cell = np.clip(np.searchsorted(axis.x, x, side="right") - 1, 0, axis.cells - 1)
    part = (x - axis.x[cell]) / (axis.x[cell + 1] - axis.x[cell]) * axis.parts
    own = np.clip(np.floor(part), 0, axis.parts - 1)
    f = np.clip(part - own, 0, 1)
    first = (2 * (cell * axis.parts + own)).astype(int)
    points = np.stack([first, first + 1, first + 2])
    return points, np.stack([(1 - f) * (1 - 2 * f), 4 * f * (1 - f), f * (2 * f - 1)])


def _eta_error(table: Table, grid: Grid) -> float:
    """Return the difference from the eta of the table that 99 % of random directions keep."""
    generator = np.random.default_rng(50)
    own = table.incidence_deg
    incidences = generator.uniform(own[0], own[-1], TRIED)
    azimuths = generator.uniform(0, 360, TRIED)
    if grid.around is not None:
        # Neighbours share what the table has to look up.
        i = np.searchsorted(own, incidences)
        order = np.lexsort((np.searchsorted(grid.around.x, azimuths), i))
        incidences, azimuths = incidences[order], azimuths[order]
    with refusals():
        asked = table._table.etas(incidences, azimuths)
    return float(np.quantile(np.abs(eta_of(grid, incidences, azimuths) - asked), 0.99))


def _has_polygons(table: Table) -> bool:
    """Return whether the distributions are polygons; the mean over azimuths has bins only."""
    return table.is_exact and not bool(np.isnan(table.azimuth_deg).any())


def _entries(
    table: Table,
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], Floats, Floats | None]:
    """Return the distributions of all directions of a table, one after the other."""
    starts, counts, entries, deviations = [], [], [], []
    total = 0
    for i, incidence in enumerate(table.incidence_deg):
        for j, azimuth in enumerate(table.azimuth_deg):
            if _has_polygons(table):
                shapes, powers, turned = _triangles(table, float(incidence), float(azimuth))
            else:
                shapes, powers, turned = _parallelograms(table, i, j)
            threshold, other = alias(powers)
            entries.append(np.column_stack([shapes, threshold, other]))
            deviations.append(turned)
            starts.append(total)
            counts.append(len(powers))
            total += len(powers)
    if total >= 1 << 24:
        raise Error(
            f"the table has {total} shapes, more than single precision counts; trace it with fewer "
            "bins or directions"
        )
    entry = np.concatenate(entries) if total else np.zeros((1, 8))
    deviation = np.concatenate(deviations) if total else np.zeros((1, 2))
    return (
        np.array(starts),
        np.array(counts),
        entry,
        deviation if np.abs(deviation).max(initial=0) > 0 else None,
    )


def _triangles(table: Table, incidence: float, azimuth: float) -> tuple[Floats, Floats, Floats]:
    """Return triangles of shifts of a direction (corner, two sides), powers and deviations."""
    shapes, powers, deviations = [], [], []
    for path in table.polygons(incidence, azimuth):
        shifted = path.shift(path.polygon)
        first = path.polygon[0]
        for k in range(1, len(path.polygon) - 1):
            a, b = path.polygon[k] - first, path.polygon[k + 1] - first
            power = path.weight * 0.5 * abs(a[0] * b[1] - a[1] * b[0])
            if power > 0:
                sides = shifted[k] - shifted[0], shifted[k + 1] - shifted[0]
                shapes.append(np.concatenate([shifted[0], *sides]))
                powers.append(power)
                deviations.append(path.deviation)
    return (
        np.array(shapes).reshape(-1, 6),
        np.array(powers, float),
        np.array(deviations).reshape(-1, 2),
    )


def _parallelograms(table: Table, i: int, j: int) -> tuple[Floats, Floats, Floats]:
    """Return the bins of a direction that hold light, their powers, and deviations of 0."""
    share, reach = table.histogram[i, j], table._table.range
    width = 2 * reach / len(share)
    v, u = np.nonzero(share)
    side = np.full(len(u), width)
    none = np.zeros(len(u))
    corner = np.stack([u, v], axis=1) * width - reach
    shapes = np.column_stack([corner, side, none, none, side])
    return shapes, share[v, u], np.zeros((len(u), 2))


def alias(powers: Floats) -> tuple[Floats, npt.NDArray[np.int64]]:
    """Return thresholds and aliases, by which one uniform number chooses an entry by its power.

    Of n entries, entry k = floor(n x) is chosen if the rest of n x is below threshold[k], otherwise
    entry alias[k].
    """
    n = len(powers)
    threshold, other = np.ones(n), np.arange(n)
    if n == 0:
        return threshold, other
    share = powers / powers.sum() * n
    small = [k for k in range(n) if share[k] < 1]
    large = [k for k in range(n) if share[k] >= 1]
    while small and large:
        k, rich = small.pop(), large[-1]
        threshold[k], other[k] = share[k], rich
        share[rich] -= 1 - share[k]
        if share[rich] < 1:
            small.append(large.pop())
    return threshold, other
