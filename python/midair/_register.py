"""Where a photograph shows a rendered picture: shift, scale and rotation.

A coarse search over scales and rotations finds the start: the photograph, reduced to 32 pixels, is
correlated with the render at every shift. Least squares refine it on ever more pixels. The render
is interpolated and the photograph never, so its noise stays as it is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

import numpy as np
import numpy.typing as npt

from midair._errors import Error
from midair._picture import Picture, is_file, picture, planes
from midair._words import File

_Floats = npt.NDArray[np.floating[Any]]

EXTRA = 'pip install "midair[evaluate]"'

#: Pixels along the longer side of the photograph at each stage. The errors of the last stage are
#: those of a thousand pixels: a mid-air image holds no finer detail.
_STAGES = (32, 128, 512, 1024)
#: Scales and rotations of the search: factor from the render to the photograph, and radians.
_LARGEST_SCALE = 4.0
_LARGEST_TURN = math.radians(15)
#: Starts that are refined, and the correlation below which pictures are not of the same thing.
_STARTS = 5
_LEAST = 0.8
#: Unknowns of the light: gain, offset, and a difference of the blur to second order.
_LIGHT = 4
#: Tiles along a side, which are left out in turn for the standard errors.
_TILES = 8


def needed(name: str) -> Any:
    """Import a module that the extra `evaluate` brings."""
    try:
        return import_module(name)
    except ImportError as missing:
        raise Error(f"evaluate: needs {missing.name}; {EXTRA} brings it") from None


def colours(one: Picture | File, name: str, transfer: str | None = None) -> _Floats:
    """Return linear light of a file or an array, shape (1 or 3, rows, columns)."""
    light: Any = picture(one, transfer) if is_file(one) else one
    return planes(light, name)[1]


def below_full_scale(light: _Floats) -> npt.NDArray[np.bool_]:
    """Return which values are known: all, or those below the greatest if a thousandth has that."""
    top = light.max()
    return light < top if np.mean(light == top) > 1e-3 else np.ones(light.shape, bool)


@dataclass(frozen=True)
class Registration:
    """Place of a render in a photograph.

    A point of the photograph lies at ``shift + scale * R(rotation) * (point of the render)``, both
    from the centres of the pictures. Errors are standard errors, from leaving out tiles of the
    photograph in turn.

    Attributes
    ----------
    shift_px, shift_error_px : (float, float)
        To the right and down, pixels of the photograph.
    scale, scale_error : float
        Pixels of the photograph for one pixel of the render.
    rotation_deg, rotation_error_deg : float
        Clockwise, as the photograph is shown.
    residual_px, noise_px : float
        Shift that is left in the tiles (root mean square), and what noise alone would leave there.
        If the first is much larger, the photograph has perspective or distortion.
    correlation : float
        Correlation of the photograph with the registered render, 1 at best.
    region : (slice, slice)
        Rows and columns of the photograph that the render covers.
    """

    shift_px: tuple[float, float]
    shift_error_px: tuple[float, float]
    scale: float
    scale_error: float
    rotation_deg: float
    rotation_error_deg: float
    residual_px: float
    noise_px: float
    correlation: float
    region: tuple[slice, slice] = field(repr=False)
    _size: tuple[tuple[int, int], tuple[int, int]] = field(repr=False)

    def resample(self, rendered: Picture) -> npt.NDArray[np.float32]:
        """Return a render on the pixels of the photograph, within `region`.

        It is interpolated by splines of order 5. Its shape has to be that of the registered render.
        """
        light = colours(rendered, "rendered")
        if light.shape[1:] != self._size[1]:
            rows, columns = self._size[1]
            raise Error(
                f"evaluate: the registered render has {columns} x {rows} pixels, and this one "
                f"{light.shape[2]} x {light.shape[1]}; render all at one size"
            )
        ndimage = needed("scipy.ndimage")
        at = _in_render(_similarity(self), _pixels(self.region, 1), self._size)
        made = [ndimage.map_coordinates(one, at, order=5, mode="mirror") for one in light]
        return np.moveaxis(np.stack(made), 0, -1).astype(np.float32)


def register(
    rendered: Picture | File, photograph: Picture | File, *, transfer: str | None = None
) -> Registration:
    """Find where a photograph shows a rendered picture.

    Parameters
    ----------
    rendered, photograph : path or array
        Files, or arrays of linear light of shape (rows, columns) or (rows, columns, 3). The scale
        between them may be 1/4 to 4, the rotation up to 15 degrees.
    transfer : {"linear", "srgb"}, optional
        Meaning of integers in files; without it each file decides.

    Raises
    ------
    Error
        If the pictures are too small or even, or do not show the same thing.
    """
    light = [
        colours(one, name, transfer).mean(axis=0, dtype=np.float64)
        for one, name in ((rendered, "rendered"), (photograph, "photograph"))
    ]
    for one, name in zip(light, ("rendered", "photograph")):
        if min(one.shape) < 16:
            raise Error(f"register: the {name} picture is below 16 x 16 pixels; give a larger one")
        if not np.ptp(one) > 0:
            raise Error(f"register: the {name} picture is even; give one with details")
    render, photo = light
    known = below_full_scale(photo)
    steps = sorted({max(1, -(-max(photo.shape) // pixels)) for pixels in _STAGES}, reverse=True)
    size = ((photo.shape[0], photo.shape[1]), (render.shape[0], render.shape[1]))
    likely = _starts(photo, render, steps[0])
    for step in steps:
        stages = [_Stage(photo, known, render, size, step, p) for p in likely]
        for one in stages:
            one.refine()
        best = max(stages, key=lambda one: one.correlation(whole=True))
        # All starts go on to the second stage.
        likely = [one.p for one in stages] if step == steps[0] else [best.p]
    correlation = best.correlation()
    if not correlation > _LEAST:
        raise Error(
            "register: the photograph does not show the rendered picture (correlation "
            f"{correlation:.2f}); turn, mirror or crop it so that both show the same thing, "
            f"upright within 15 degrees, and within a factor of {_LARGEST_SCALE:.0f} in size"
        )
    return best.registration()


def _starts(photo: _Floats, render: _Floats, step: int) -> list[_Floats]:
    """Return the likeliest shifts, logarithms of scales, and rotations, by correlation."""
    ndimage, feature = needed("scipy.ndimage"), needed("skimage.feature")
    small = _reduced(photo, step)
    # Half of a step moves the rims by half a pixel.
    by = 2 / max(small.shape)
    count = math.ceil(math.log(_LARGEST_SCALE) / by)
    turns = math.ceil(_LARGEST_TURN / by)
    scored = []
    for i in range(-count, count + 1):
        scale = math.exp(i * math.log(_LARGEST_SCALE) / count)
        # Each pixel of the reduced render is at most as large as one of the reduced photograph.
        own = max(1, int(step / scale))
        reduced = _reduced(render, own)
        if min(reduced.shape) < 4:
            continue
        magnified = scale * own / step
        half = [math.ceil(0.5 * (n * magnified + m)) for n, m in zip(reduced.shape, small.shape)]
        y, x = np.mgrid[-half[0] : half[0] + 1, -half[1] : half[1] + 1].astype(float)
        for j in range(-turns, turns + 1):
            turn = j * _LARGEST_TURN / turns
            cosine, sine = math.cos(turn) / magnified, math.sin(turn) / magnified
            rows = 0.5 * (reduced.shape[0] - 1) - sine * x + cosine * y
            columns = 0.5 * (reduced.shape[1] - 1) + cosine * x + sine * y
            canvas = ndimage.map_coordinates(reduced, [rows, columns], order=1)
            alike = feature.match_template(canvas, small)
            row, column = np.unravel_index(np.argmax(alike), alike.shape)
            # The photograph's centre lies there on the canvas, whose centre is the render's.
            down = half[0] - (row + 0.5 * (small.shape[0] - 1))
            right = half[1] - (column + 0.5 * (small.shape[1] - 1))
            start = np.array([right * step, down * step, math.log(scale), turn])
            scored.append((float(alike[row, column]), start))
    scored.sort(key=lambda one: -one[0])
    return [start for _, start in scored[:_STARTS]]


def _reduced(light: _Floats, step: int) -> _Floats:
    """Return means over squares of `step` pixels."""
    rows, columns = (n // step for n in light.shape)
    cut = light[: rows * step, : columns * step]
    made: _Floats = cut.reshape(rows, step, columns, step).mean(axis=(1, 3))
    return made


def _pixels(region: tuple[slice, slice], step: int) -> tuple[_Floats, _Floats]:
    """Return rows and columns of the centres of squares of `step` pixels of a region."""
    rows, columns = (np.arange(s.start, s.stop - step + 1, step) for s in region)
    middle = 0.5 * (step - 1)
    y, x = np.meshgrid(rows + middle, columns + middle, indexing="ij")
    return y, x


def _similarity(found: Registration) -> _Floats:
    return np.array([*found.shift_px, math.log(found.scale), math.radians(found.rotation_deg)])


def _from_centre(p: _Floats, at: tuple[_Floats, _Floats], size: Any) -> tuple[_Floats, _Floats]:
    """Return right and down of points of the photograph from the centre of the render in it."""
    y, x = at
    return x - 0.5 * (size[0][1] - 1) - p[0], y - 0.5 * (size[0][0] - 1) - p[1]


def _in_render(p: _Floats, at: tuple[_Floats, _Floats], size: Any) -> tuple[_Floats, _Floats]:
    """Return rows and columns in the render of points of the photograph."""
    right, down = _from_centre(p, at, size)
    cosine, sine = math.cos(p[3]) / math.exp(p[2]), math.sin(p[3]) / math.exp(p[2])
    rows = 0.5 * (size[1][0] - 1) - sine * right + cosine * down
    columns = 0.5 * (size[1][1] - 1) + cosine * right + sine * down
    return rows, columns


def _solved(by: _Floats, light: _Floats) -> _Floats:
    """Return the factors of the columns that are nearest to the light, by least squares."""
    size = np.sqrt(np.einsum("ij,ij->j", by, by)) + 1e-300
    by = by / size
    solved: _Floats = np.linalg.lstsq(by.T @ by, by.T @ light, rcond=None)[0] / size
    return solved


class _Stage:
    """Photograph and render with fewer pixels, and the similarity between them."""

    def __init__(
        self, photo: _Floats, known: Any, render: _Floats, size: Any, step: int, p: _Floats
    ) -> None:
        ndimage = needed("scipy.ndimage")
        self.size, self.step, self.p = size, step, p
        self.photo = _reduced(photo, step)
        self.known = _reduced(known.astype(float), step) == 1
        self.of_render = max(1, int(step / math.exp(p[2])))
        self.render = _reduced(render, self.of_render)
        self.spline = ndimage.spline_filter(self.render, order=3, mode="mirror")
        whole = (slice(0, self.photo.shape[0] * step), slice(0, self.photo.shape[1] * step))
        self.at = _pixels(whole, step)

    def seen(self, p: _Floats) -> tuple[_Floats, npt.NDArray[np.bool_]]:
        """Return the render on the photograph's pixels, black outside, and which it covers."""
        ndimage = needed("scipy.ndimage")
        middle = 0.5 * (self.of_render - 1)
        at = _in_render(p, self.at, self.size)
        rows, columns = ((one - middle) / self.of_render for one in at)
        inside = (rows >= 0) & (rows <= self.render.shape[0] - 1)
        inside &= (columns >= 0) & (columns <= self.render.shape[1] - 1)
        light = ndimage.map_coordinates(
            self.spline, [rows, columns], order=3, mode="mirror", prefilter=False
        )
        return np.where(inside, light, 0.0), inside

    def used(self, p: _Floats) -> npt.NDArray[np.bool_]:
        """Return which pixels are compared: known, and at a distance from the rim of the render,
        where slopes are not known."""
        ndimage = needed("scipy.ndimage")
        inside = ndimage.binary_erosion(self.seen(p)[1], iterations=3, border_value=1)
        used: npt.NDArray[np.bool_] = inside & self.known
        return used

    def columns(self, p: _Floats, use: npt.NDArray[np.bool_]) -> _Floats:
        """Return the derivatives of the light by gain, offset, blur and similarity."""
        ndimage = needed("scipy.ndimage")
        light, _ = self.seen(p)
        down, right = np.gradient(light, self.step)
        wider = ndimage.laplace(light)
        x, y = _from_centre(p, self.at, self.size)
        by = [light, np.ones_like(light), wider, ndimage.laplace(wider), -right, -down]
        by += [-(right * x + down * y), right * y - down * x]
        return np.stack([one[use] for one in by], axis=-1)

    def refine(self) -> None:
        """Improve the similarity by least squares, and again with the pixels that are then used."""
        for _ in range(2):
            self.p = self._nearer(self.p, self.used(self.p))

    def _nearer(self, p: _Floats, use: npt.NDArray[np.bool_]) -> _Floats:
        """Return the similarity by Gauss and Newton, with shorter steps where they do not help."""
        if np.count_nonzero(use) < 0.05 * use.size:
            return p
        photo, step = self.photo[use], np.zeros(4)
        best = math.inf
        for _ in range(40):
            by = self.columns(p + step, use)
            rest = photo - by[:, :_LIGHT] @ _solved(by[:, :_LIGHT], photo)
            loss = float(rest @ rest)
            if loss > best:
                step = 0.5 * step
            else:
                p, best = p + step, loss
                solved = _solved(by, photo)
                if not solved[0] > 0:
                    break
                step = solved[_LIGHT:] / solved[0]
            # Two pixels of the stage at most, at the rims too.
            rim = 0.5 * max(self.size[0])
            moved = max(np.abs(step[:2]).max(), np.abs(step[2:]).max() * rim)
            step *= min(1.0, 2 * self.step / max(moved, 1e-300))
            if moved < 1e-4 * self.step:
                break
        return p

    def correlation(self, whole: bool = False) -> float:
        """Return the correlation over what the render covers, or over the whole photograph."""
        light, inside = self.seen(self.p)
        use = self.known if whole else self.known & inside
        pair = self.photo[use], light[use]
        if use.sum() < 16 or min(np.ptp(one) for one in pair) <= 0:
            return -1.0
        return float(np.corrcoef(*pair)[0, 1])

    def registration(self) -> Registration:
        """Return the similarity with its errors."""
        use = self.used(self.p)
        by, light = self.columns(self.p, use), self.photo[use]
        solved = _solved(by, light)
        rest, gain = light - by @ solved, solved[0]
        rows, columns = np.nonzero(use)
        tile = sum(
            (which - which.min()) * _TILES // (np.ptp(which) + 1) * factor
            for which, factor in ((rows, _TILES), (columns, 1))
        )
        squares = np.zeros((_TILES**2, by.shape[1], by.shape[1]))
        products = np.zeros((_TILES**2, by.shape[1]))
        # Square of the shift that is left, weighted by what the tiles tell of it, and its share by
        # noise: sums over tiles.
        left = noise = weight = 0.0
        for k in range(_TILES**2):
            own = tile == k
            x, r = by[own], rest[own]
            squares[k], products[k] = x.T @ x, x.T @ r
            if len(r) < 16:
                continue
            # Gain, offset and blur of the tile are its own.
            basis = np.linalg.qr(x[:, :_LIGHT])[0]
            slopes = x[:, _LIGHT : _LIGHT + 2]
            slopes = gain * (slopes - basis @ (basis.T @ slopes))
            r = r - basis @ (basis.T @ r)
            told = slopes.T @ slopes
            values, vectors = np.linalg.eigh(told)
            seen = values > 1e-6 * values.max() + 1e-300
            along = slopes @ vectors[:, seen]
            left += float(np.sum((along.T @ r) ** 2 / values[seen]))
            # Noise differs from pixel to pixel, as light does.
            freedom = len(r) / max(len(r) - by.shape[1], 1)
            noise += freedom * float(np.sum((along.T**2 @ r**2) / values[seen]))
            weight += float(values.sum())
        total, toward = squares.sum(axis=0), products.sum(axis=0)
        without = [
            np.linalg.lstsq(total - squares[k], toward - products[k], rcond=None)[0]
            for k in range(_TILES**2)
            if squares[k, 1, 1] > 0
        ]
        moved = np.array(without)[:, _LIGHT:] / gain
        count = len(moved)
        error = np.sqrt((count - 1) / count * np.sum((moved - moved.mean(axis=0)) ** 2, axis=0))
        scale = math.exp(self.p[2])
        return Registration(
            shift_px=(float(self.p[0]), float(self.p[1])),
            shift_error_px=(float(error[0]), float(error[1])),
            scale=scale,
            scale_error=scale * float(error[2]),
            rotation_deg=math.degrees(self.p[3]),
            rotation_error_deg=math.degrees(error[3]),
            residual_px=math.sqrt(2 * left / weight),
            noise_px=math.sqrt(2 * noise / weight),
            correlation=self.correlation(),
            region=_region(self.p, self.size),
            _size=self.size,
        )


def _region(p: _Floats, size: Any) -> tuple[slice, slice]:
    """Return a rectangle of the photograph's pixels that the render covers."""
    whole = (slice(0, size[0][0]), slice(0, size[0][1]))
    rows, columns = _in_render(p, _pixels(whole, 1), size)
    inside = (rows >= 0) & (rows <= size[1][0] - 1) & (columns >= 0) & (columns <= size[1][1] - 1)
    (bottom, right), (top, left) = inside.shape, (0, 0)
    # The side with the most uncovered pixels goes first.
    while bottom > top and right > left:
        part = inside[top:bottom, left:right]
        open_sides = [np.mean(~side) for side in (part[0], part[-1], part[:, 0], part[:, -1])]
        worst = int(np.argmax(open_sides))
        if open_sides[worst] == 0:
            return slice(top, bottom), slice(left, right)
        top, bottom = top + (worst == 0), bottom - (worst == 1)
        left, right = left + (worst == 2), right - (worst == 3)
    raise Error("register: the render covers nothing of the photograph; give a larger part")
