"""BSDF `midair_sheet`: what a retroreflective sheet does to one ray of a path.

Camera paths run against the light. A ray of the camera that meets the sheet is treated as light of
its own direction: the reverse of every way of light through a cell is a way of light itself, with
the same share of power, so the table at the direction of the camera's ray holds them all. The ray
leaves shifted by s and turned by delta, both as the table has them for that direction, without a
change of sign. (The reverse of a path with (s, delta) has (-s, -delta), so for ideal cubes, and to
first order for all others, the distribution is even and the sign makes no difference. The sign of s
*relative* to delta does.)
"""

from __future__ import annotations

import warnings
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from midair._errors import Error, MidairWarning
from midair.mitsuba._directions import Directions, choose, is_scalar, read_two
from midair.mitsuba._grid import grid_of
from midair.mitsuba._keys import SHEET, Keys, Numbers, numbers_of

#: Entries of the table of the lobe, and where the radial lobe is cut, in A tan(angle).
_LOBE = 2048
_CUT = 2.4 * np.pi


def delta_class() -> type:
    """Return the base class, for the current variant, of BSDFs that only send a ray on."""

    class MidairDelta(mi.BSDF):  # type: ignore[misc, name-defined]
        """BSDF without light in any direction that was not sampled."""

        def eval(self, context: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return mi.Spectrum(0)

        def pdf(self, context: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return mi.Float(0)

        def eval_pdf(self, context: Any, si: Any, wo: Any, active: Any = True) -> tuple[Any, Any]:
            return mi.Spectrum(0), mi.Float(0)

    return MidairDelta


def sheet_class(delta: type) -> type:
    """Return the class of the BSDF for the current variant."""

    class MidairSheet(delta):  # type: ignore[misc, valid-type]
        """Retroreflective sheet with the shifts of a table; doc/renderer.md lists the keys."""

        plugin = "midair_sheet"
        known = SHEET

        def __init__(self, props: Any) -> None:
            super().__init__(props)
            self._take(numbers_of(Keys(props, self.plugin, self.known)))
            self.m_components = [mi.BSDFFlags.DeltaReflection | mi.BSDFFlags.FrontSide]
            self.m_flags = self.m_components[0]

        def _take(self, numbers: Numbers) -> None:
            self.numbers = numbers
            self.directions = Directions(grid_of(numbers.table))
            self.c = _parameter([numbers.c])
            self.mu = _parameter(numbers.mu.values)
            self.A = _parameter(numbers.A.values) if numbers.A is not None else None
            self.quantile = _quantile(numbers.lobe) if numbers.A is not None else None
            self.first_edge = numbers.first_edge
            self.has_spread = numbers.spread > 0

        def traverse(self, callback: Any) -> None:
            names = ["c", "mu"] + ([] if self.A is None else ["A"])
            for name in names:
                callback.put(name, getattr(self, name), mi.ParamFlags.Differentiable)

        def _angles(self, si: Any) -> tuple[Any, Any, Any, Any, Any, Any]:
            """Return sine of the incidence, azimuth (degrees), u, and the basis across the ray.

            All in the local frame of the surface: u along the ray's travel in the sheet, v = n x u,
            x across the reversed ray in the plane of incidence, towards u.
            """
            wi = si.wi
            sine = dr.sqrt(dr.maximum(wi.x * wi.x + wi.y * wi.y, 0))
            straight = sine < 1e-6
            edge_x, edge_y = mi.Float(1), mi.Float(0)
            if self.first_edge is not None:
                local = si.to_local(mi.Vector3f(*self.first_edge))
                length = dr.sqrt(local.x * local.x + local.y * local.y)
                edge_x, edge_y = local.x / length, local.y / length
            scale = choose(straight, 1, sine)
            # At normal incidence the light has no direction in the sheet: any will do.
            u_x = choose(straight, edge_x, -wi.x / scale)
            u_y = choose(straight, edge_y, -wi.y / scale)
            across, along = edge_x * u_y - edge_y * u_x, edge_x * u_x + edge_y * u_y
            azimuth = dr.rad2deg(dr.atan2(across, along))
            x = mi.Vector3f(u_x * wi.z, u_y * wi.z, choose(straight, 0, sine))
            return sine, azimuth, u_x, u_y, x, mi.Vector3f(-u_y, u_x, 0)

        def eta(self, si: Any, active: Any = True) -> Any:
            """Return the share of the light that comes back along the ray; 0 from behind."""
            sine, azimuth, *_ = self._angles(si)
            made = self.directions.eta(sine, azimuth, active & (si.wi.z > 0))
            return choose(si.wi.z > 0, made, 0)

        def follow(
            self, si: Any, pick: Any, point: Any, slot: Any, lobe: Any, spread: Any, active: Any
        ) -> tuple[Any, Any, Any]:
            """Return weight, shift and new direction (both local) of a ray that meets the sheet.

            The shift is in units of the scene. All random numbers are uniform in [0, 1): `pick` and
            `slot` single ones, `point`, `lobe` and `spread` pairs.
            """
            front = active & (si.wi.z > 0)
            sine, azimuth, u_x, u_y, x, v = self._angles(si)
            eta, du, dv, along, across = self.directions.draw(
                sine, azimuth, pick, slot, point, front
            )
            size = self.numbers.per_mm * _at(self.c, None, sine, front)
            shift = mi.Vector2f(size * (du * u_x - dv * u_y), size * (du * u_y + dv * u_x))
            weight = mi.Spectrum(choose(front, _at(self.mu, self.numbers.mu, sine, front) * eta, 0))
            if self.has_spread:
                along, across = self._spread(spread, sine, along, across)
            if self.A is not None:
                narrow, colour = self._narrowing(si, lobe)
                radius = narrow * _at(self.A, self.numbers.A, sine, front)
                r_x, r_y, t = self._lobe(lobe, front)
                along, across = along + r_x / radius, across + r_y / radius
                if colour is not None:
                    weight = weight * colour(t, narrow)
            direction = dr.normalize(si.wi + along * x + across * v)
            return weight, shift, direction

        def _lobe(self, lobe: Any, active: Any) -> tuple[Any, Any, Any]:
            """Draw from the lobe: A tan(angle) along x and along v, and the distance from 0."""
            if self.numbers.lobe == "separable":
                x = _signed(self.quantile, lobe.x, active)
                y = _signed(self.quantile, lobe.y, active)
                return x, y, mi.Vector2f(x, y)
            if self.numbers.lobe == "gaussian":
                r = dr.sqrt(-dr.log(1 - lobe.x))
            else:
                r = _quantile_at(self.quantile, lobe.x, active)
            sine, cosine = dr.sincos(2 * dr.pi * lobe.y)
            return r * cosine, r * sine, r

        def _narrowing(self, si: Any, lobe: Any) -> tuple[Any, Any]:
            """Return the factor on A at the wavelength that is drawn, and the weights of all.

            Without a reference wavelength, and outside of spectral variants, both do nothing. The
            four wavelengths of a path share its directions; the lobe is that of one of them, and
            each wavelength weighs by its own density over the mean of all (hero wavelengths).
            """
            if not mi.is_spectral or self.numbers.wavelength_nm is None:
                return mi.Float(1), None
            own = self.numbers.wavelength_nm / si.wavelengths
            n = len(own)
            # The remainder of the choice goes on as a uniform number.
            x = lobe.x * n
            hero = dr.minimum(mi.UInt32(x), n - 1)
            lobe.x = x - mi.Float(hero)
            narrow = own[0]
            for k in range(1, n):
                narrow = choose(hero == k, own[k], narrow)

            def weights(t: Any, narrow: Any) -> Any:
                density = type(own)()
                for k in range(n):
                    density[k] = self._density(t, own[k] / narrow)
                mean = dr.mean(density)
                return mi.Spectrum(density / choose(mean > 0, mean, 1))

            return narrow, weights

        def _density(self, t: Any, ratio: Any) -> Any:
            """Return the density of the lobe that is `ratio` times narrower, up to a factor."""

            def sinc2(s: Any) -> Any:
                safe = choose(dr.abs(s) < 1e-4, 1, s)
                return choose(dr.abs(s) < 1e-4, 1, dr.square(dr.sin(safe) / safe))

            if self.numbers.lobe == "separable":
                return ratio * ratio * sinc2(ratio * t.x) * sinc2(ratio * t.y)
            s = ratio * t
            if self.numbers.lobe == "gaussian":
                return ratio * ratio * dr.exp(-s * s)
            if self.numbers.lobe == "radial":
                return ratio * ratio * choose(s < _CUT, sinc2(s), 0)
            raise Error(
                f"midair_sheet has no density of the lobe {self.numbers.lobe}; name another one"
            )

        def _spread(self, spread: Any, sine: Any, along: Any, across: Any) -> tuple[Any, Any]:
            """Add the angular spread: Gaussian, wider in the plane of incidence by refraction."""
            sigma, index = self.numbers.spread, self.directions.grid.index
            x, y = mi.warp.square_to_std_normal(spread)
            inside = dr.sqrt(dr.maximum(1 - dr.square(sine / index), 0))
            outside = dr.sqrt(dr.maximum(1 - dr.square(sine), 1e-12))
            return along + sigma * x * inside / outside, across + sigma * y

        # What a stock integrator sees: straight back, without shift and lobe.
        def sample(
            self, context: Any, si: Any, sample1: Any, sample2: Any, active: Any = True
        ) -> tuple[Any, Any]:
            made = mi.BSDFSample3f()
            made.wo = si.wi
            made.pdf, made.eta = mi.Float(1), mi.Float(1)
            made.sampled_type = mi.UInt32(+mi.BSDFFlags.DeltaReflection)
            made.sampled_component = mi.UInt32(0)
            warnings.warn(
                f"{self.plugin}: this integrator returns light straight back, without the shift "
                'and the lobe; use the integrator {"type": "midair_path"}',
                MidairWarning,
                stacklevel=2,
            )
            sine, *_ = self._angles(si)
            front = active & (si.wi.z > 0)
            factor = _at(self.mu, self.numbers.mu, sine, front) * self.eta(si, front)
            return made, mi.Spectrum(choose(front, factor, 0))

        def to_string(self) -> str:
            n = self.numbers
            return (
                f"MidairSheet[\n  table = {n.table!r},\n  c = {n.c:g} mm,\n"
                f"  mu = {n.mu},\n  A = {n.A},\n  lobe = {n.lobe}\n]"
            )

    return MidairSheet


def _parameter(values: Any) -> Any:
    """Return a parameter of the scene: one number, or one for each fitted incidence."""
    if is_scalar():
        return float(values[0]) if len(values) == 1 else [float(one) for one in values]
    return mi.Float([float(one) for one in values])


def _at(parameter: Any, given: Any, sine: Any, active: Any) -> Any:
    """Return a parameter at an incidence: linear between the fitted ones, constant beyond."""
    if given is None or len(given.values) == 1:
        return parameter
    degrees = dr.rad2deg(dr.asin(dr.minimum(sine, 1)))
    if is_scalar():
        return mi.Float(float(np.interp(float(degrees), given.incidence_deg, parameter)))
    total, last = mi.Float(0), len(given.values) - 1
    low = mi.UInt32(0)
    for k, edge in enumerate(given.incidence_deg[1:-1], 1):
        low = choose(degrees >= edge, mi.UInt32(k), low)
    high = dr.minimum(low + 1, last)
    left, right = mi.Float(given.incidence_deg[0]), mi.Float(given.incidence_deg[1])
    for k in range(1, last):
        left = choose(low == k, given.incidence_deg[k], left)
        right = choose(low == k, given.incidence_deg[k + 1], right)
    t = dr.clip((degrees - left) / (right - left), 0, 1)
    total += (1 - t) * dr.gather(mi.Float, parameter, low, active)
    total += t * dr.gather(mi.Float, parameter, high, active)
    return total


def _quantile(lobe: str) -> Any:
    """Return the distances A tan(angle) below which equal shares of a lobe lie, and their steps.

    Radial: the density of the distance is sin^2(t) / t up to 2.4 pi. Separable: sin^2(t) / t^2 on
    both sides, kept as t (1 - share), which is finite at the end: t is 1 / (pi (1 - share)) there.
    """
    if lobe == "gaussian":
        return None
    share = np.linspace(0, 1, _LOBE)
    if lobe == "radial":
        t = np.linspace(0, _CUT, 400_001)
        density = np.sin(t) ** 2 / np.maximum(t, 1e-300)
        values = np.interp(share, _mass(t, density), t)
    elif lobe == "separable":
        t = np.concatenate([np.linspace(0, 40, 400_001), np.geomspace(40, 1e6, 2_000_001)[1:]])
        density = (np.sinc(t / np.pi)) ** 2
        # Beyond 40 the square of the sine is replaced by its mean, 1/2.
        density[t > 40] = 0.5 / t[t > 40] ** 2
        mass = _mass(t, density) * (1 - 1 / (np.pi * 1e6))
        inner = np.interp(share[:-1], mass, t) * (1 - share[:-1])
        values = np.append(inner, 1 / np.pi)
    else:
        raise Error(f"midair_sheet has no samples of the lobe {lobe}; name another one")
    pairs = np.column_stack([values, np.append(np.diff(values), 0)]).astype(np.float32).ravel()
    return pairs if is_scalar() else mi.Float(pairs)


def _mass(t: Any, density: Any) -> Any:
    """Return the share below each t, by the trapezoidal rule."""
    parts = np.diff(t) * (density[1:] + density[:-1]) / 2
    total = np.concatenate([[0], np.cumsum(parts)])
    return total / total[-1]


def _quantile_at(values: Any, share: Any, active: Any) -> Any:
    """Return the tabulated distance at a share, linear between entries."""
    x = share * (_LOBE - 1)
    k = dr.minimum(mi.UInt32(x), _LOBE - 2)
    pair = read_two(values, k, active)
    return pair.x + (x - mi.Float(k)) * pair.y


def _signed(values: Any, x: Any, active: Any) -> Any:
    """Return a distance of the separable lobe, on either side with the same chance."""
    share = dr.abs(2 * x - 1)
    t = _quantile_at(values, share, active) / dr.maximum(1 - share, 1e-7)
    return choose(x < 0.5, -t, t)
