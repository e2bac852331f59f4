"""A ray-shift table on the device: eta and shifts at any direction.

- **eta** between nodes of the grid is interpolated by parabolas.
- **Shifts** between nodes are a mixture: a node is drawn with its bilinear weight times its eta,
  and a shift from the distribution of that node, in the incidence frame.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
import numpy.typing as npt

from midair._table import Floats
from midair.mitsuba._grid import Axis, Grid


class Directions:
    """Table on the device of the current variant.

    Angles of the sheet enter as `sine`, the sine of the incidence in the air, and `azimuth`, in
    degrees.
    """

    def __init__(self, grid: Grid) -> None:
        self.grid = grid
        self.eta_values = _floats(_threes(grid))
        self.corners, self.node = _floats(_corners(grid)), _floats(_nodes(grid))
        self.entry = _floats(grid.entry)
        self.deviation = None if grid.deviation is None else _floats(grid.deviation)
        self.along = _Cells(grid.along)
        self.around = None if grid.around is None else _Cells(grid.around)
        self.cells = 1 if grid.around is None else grid.around.cells

    def _place(self, sine: Any, azimuth: Any) -> tuple[Any, Any, Any, Any, Any]:
        """Return the cell and the place within it, of both angles, and whether it is inside."""
        grid = self.grid
        tangent = sine / dr.sqrt(dr.maximum(grid.index**2 - sine * sine, 1e-12))
        i, f = self.along.find(tangent)
        # Rounding of single precision must not darken the ends.
        low, high = float(grid.along.x[0]), float(grid.along.x[-1])
        inside = (tangent >= low - 1e-6 * high) & (tangent <= high + 1e-6 * high)
        if self.around is None:
            return i, f, mi.UInt32(0), mi.Float(0), inside
        first = float(grid.around.x[0])  # type: ignore[union-attr]
        turned = azimuth - first
        turned = turned - 360 * dr.floor(turned / 360) + first
        j, g = self.around.find(turned)
        return i, f, j, g, inside

    def eta(self, sine: Any, azimuth: Any, active: Any = True) -> Any:
        """Return the share of the light that comes back; 0 outside of the table."""
        return self._eta(*self._place(sine, azimuth), active)

    def _eta(self, i: Any, f: Any, j: Any, g: Any, inside: Any, active: Any) -> Any:
        row, (a, b, c) = self.along.parabola(i, f)
        if self.around is None:
            column, parts, (x, y, z) = mi.UInt32(0), 1, (1, 0, 0)
        else:
            column, (x, y, z) = self.around.parabola(j, g)
            column, parts = column // 2, self.around.axis.cells * self.around.axis.parts
        total = mi.Float(0)
        for k, weight in enumerate((a, b, c)):
            three = _read_four(self.eta_values, (row + k) * parts + column, active)
            total = total + weight * (x * three.x + y * three.y + z * three.z)
        return choose(inside, dr.maximum(total, 0), 0)

    def draw(
        self, sine: Any, azimuth: Any, pick: Any, slot: Any, point: Any, active: Any = True
    ) -> tuple[Any, Any, Any, Any, Any]:
        """Draw what happens to a ray: eta, and shift (u, v) and deviation (along u, along v).

        `pick`, `slot` and the two numbers of `point` are uniform in [0, 1). Shifts are in edge
        lengths, deviations are tangents. Where eta is 0 the rest has no meaning.
        """
        i, f, j, g, inside = self._place(sine, azimuth)
        eta = self._eta(i, f, j, g, inside, active)
        # One of the four nodes around is drawn.
        four = _read_four(self.corners, i * self.cells + j, active)
        low = (1 - f) * ((1 - g) * four.x + g * four.y)
        high = f * ((1 - g) * four.z + g * four.w)
        chosen = pick * (low + high)
        is_high = chosen >= low
        left = choose(is_high, low + f * (1 - g) * four.z, (1 - f) * (1 - g) * four.x)
        row = choose(is_high, i + 1, i)
        column = choose(chosen >= left, j + 1, j)
        node = _read_four(self.node, row * (self.cells + 1) + column, active)
        first, n = mi.UInt32(node.x), mi.UInt32(node.y)
        active = active & (n > 0)
        if is_scalar() and not active:
            return eta, mi.Float(0), mi.Float(0), mi.Float(0), mi.Float(0)
        x = slot * node.y
        at = dr.minimum(mi.UInt32(x), dr.maximum(n, 1) - 1)
        e = first + at
        tail = _read_four(self.entry, 2 * e + 1, active)
        keep = x - mi.Float(at) < tail.z
        e = choose(keep, e, first + mi.UInt32(tail.w))
        head = _read_four(self.entry, 2 * e, active)
        tail = _read_four(self.entry, 2 * e + 1, active)
        p, q = mi.Float(point.x), mi.Float(point.y)
        if self.grid.is_exact:
            # The other half of the parallelogram is turned into the triangle.
            over = p + q > 1
            p, q = choose(over, 1 - p, p), choose(over, 1 - q, q)
        u = head.x + p * head.z + q * tail.x
        v = head.y + p * head.w + q * tail.y
        if self.deviation is None:
            return eta, u, node.z * v, mi.Float(0), mi.Float(0)
        turned = read_two(self.deviation, e, active)
        return eta, u, node.z * v, turned.x, node.z * turned.y


# Memory is read in records, because masked reads of single numbers are what a draw costs most.


def _threes(grid: Grid) -> Floats:
    """Return eta at the three points of each part of an azimuth, shape (records, 4)."""
    if grid.around is None:
        made = np.pad(grid.eta[:, None, :], ((0, 0), (0, 0), (0, 3)))
    else:
        first, middle, last = grid.eta[:, :-2:2], grid.eta[:, 1::2], grid.eta[:, 2::2]
        made = np.stack([first, middle, last, np.zeros_like(first)], axis=-1)
    return made.reshape(-1, 4)


def _corners(grid: Grid) -> Floats:
    """Return eta at the four nodes around each cell, shape (cells, 4), one read for a draw."""
    eta = grid.node_eta
    # All azimuths follow the last one; a mean over azimuths has one node on either side.
    after = np.roll(eta, -1, axis=1)
    made = np.stack([eta[:-1], after[:-1], eta[1:], after[1:]], axis=-1)
    return made.reshape(-1, 4)


def _nodes(grid: Grid) -> Floats:
    """Return first entry, number of entries and sign of v of each node, shape (nodes, 4).

    The first azimuth stands once more behind the last.
    """
    place, flip = np.append(grid.place, grid.place[0]), np.append(grid.flip, grid.flip[0])
    rows = len(grid.along.x)
    own = np.arange(rows)[:, None] * (len(grid.start) // rows) + place
    sign = np.broadcast_to(np.where(flip, -1.0, 1.0), own.shape)
    made = np.stack([grid.start[own], grid.count[own], sign, np.zeros(own.shape)], axis=-1)
    return made.reshape(-1, 4)


class _Cells:
    """Axis on the device."""

    def __init__(self, axis: Axis) -> None:
        self.axis = axis
        steps = np.diff(axis.x)
        self.step = float(steps.mean()) if np.ptp(steps) < 1e-9 * steps.mean() else None

    def find(self, x: Any) -> tuple[Any, Any]:
        """Return the cell of x, and the place within it from 0 to 1."""
        nodes, last = self.axis.x, self.axis.cells - 1
        if self.step is not None:
            place = (x - float(nodes[0])) / self.step
        elif is_scalar():
            place = float(np.interp(float(x), nodes, np.arange(len(nodes))))
        else:
            # A ramp for each cell, from 0 to 1: quicker than a search, which reads memory.
            place = mi.Float(0)
            for low, high in zip(nodes[:-1], nodes[1:]):
                place += dr.clip((x - float(low)) * float(1 / (high - low)), 0, 1)
        cell = mi.UInt32(dr.clip(dr.floor(place), 0, last))
        return cell, dr.clip(place - mi.Float(cell), 0, 1)

    def parabola(self, cell: Any, place: Any) -> tuple[Any, list[Any]]:
        """Return the first of three points of the finer grid, and their weights."""
        parts = self.axis.parts
        part = place * parts
        own = dr.minimum(dr.floor(part), parts - 1)
        f = part - own
        first = 2 * (cell * parts + mi.UInt32(own))
        return first, [(1 - f) * (1 - 2 * f), 4 * f * (1 - f), f * (2 * f - 1)]


def choose(mask: Any, yes: Any, no: Any) -> Any:
    """Return `yes` where the mask is true, else `no`; in scalar variants of any types."""
    if isinstance(mask, (bool, np.bool_)):
        return yes if mask else no
    return dr.select(mask, yes, no)


def is_scalar() -> bool:
    """Return whether the current variant computes one number at a time."""
    return str(mi.variant()).startswith("scalar")


def _floats(values: npt.ArrayLike) -> Any:
    flat = np.ascontiguousarray(np.asarray(values, np.float32).ravel())
    return flat if is_scalar() else mi.Float(flat)


def read_two(values: Any, index: Any, active: Any) -> Any:
    """Return a record of two numbers."""
    if is_scalar():
        return mi.Vector2f(*(float(one) for one in values[2 * int(index) : 2 * int(index) + 2]))
    return dr.gather(mi.Vector2f, values, index, active)


def _read_four(values: Any, index: Any, active: Any) -> Any:
    if is_scalar():
        return mi.Vector4f(*(float(one) for one in values[4 * int(index) : 4 * int(index) + 4]))
    return dr.gather(mi.Vector4f, values, index, active)
