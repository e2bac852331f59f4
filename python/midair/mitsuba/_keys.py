"""Keys of a sheet in a scene, checked, and the numbers that they mean."""

from __future__ import annotations

import difflib
import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mitsuba as mi
import numpy as np

from midair._errors import Error, warn
from midair._fit import Estimate, Result, load
from midair._table import Table
from midair._table import open as open_table

#: Objects that a scene names by a text, because a dict of Mitsuba has room for texts and numbers.
_HELD: dict[str, Any] = {}
_PREFIX = "midair:"

LOBES = ("radial", "separable", "gaussian")
SHEET = (
    "table params channel c mu A a R lobe wavelength_nm angular_spread_mrad first_edge unit_mm"
).split()


def hold(thing: Any) -> str:
    """Keep a table or a result for as long as the process runs, and return its name for scenes."""
    for name, held in _HELD.items():
        if held is thing:
            return name
    name = f"{_PREFIX}{type(thing).__name__.lower()}:{len(_HELD)}"
    _HELD[name] = thing
    return name


def unknown(name: str, plugin: str, known: Sequence[str]) -> Error:
    """Return the error of a key that a plugin does not have."""
    # `alpha` is nearer to `A` than any distance of letters tells, so all keys are listed too.
    near = difflib.get_close_matches(name, known, 1, 0.5)
    near = near or [one for one in known if one.lower() == name.lower()]
    meant = f"did you mean {near[0]}? " if near else ""
    return Error(f"{plugin}: {name!r} is no key of it; {meant}the keys are {', '.join(known)}")


class Keys:
    """Keys that a user gave to one object of a scene."""

    def __init__(self, props: Any, plugin: str, known: Sequence[str] = SHEET) -> None:
        self.props, self.plugin, self.known = props, plugin, list(known)
        for name in props.keys():
            if name not in self.known:
                raise unknown(name, plugin, self.known)

    def has(self, name: str) -> bool:
        """Return whether a key was given."""
        return name in self.props

    def number(self, name: str, default: float | None = None, least: float = 0.0) -> Any:
        """Return a number above `least`, or `least` itself where that is 0."""
        if not self.has(name):
            return default
        value = self._single(name)
        if not np.isfinite(value) or value < least:
            raise Error(f"{self.plugin}: {name} is {value:g}; give a number from {least:g} on")
        return value

    def _single(self, name: str) -> float:
        value = self.props[name]
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            kind = type(value).__name__
            colour = "Color" in kind or "Spectrum" in kind or isinstance(value, mi.Object)
            what = "a colour or a texture" if colour else f"a {kind}"
            raise Error(f"{self.plugin}: {name} is {what}; give one number, for all colours")
        return float(value)

    def text(self, name: str, default: str | None = None) -> Any:
        """Return a text."""
        if not self.has(name):
            return default
        value = self.props[name]
        if not isinstance(value, str):
            raise Error(f"{self.plugin}: {name} is a {type(value).__name__}; give a text")
        return value

    def flag(self, name: str) -> bool:
        """Return true or false; false if left out."""
        value = self.props.get(name, False)
        if not isinstance(value, bool):
            raise Error(f"{self.plugin}: {name} is {value!r}; give true or false")
        return value

    def vector(self, name: str) -> tuple[float, float, float] | None:
        """Return a vector that is not 0."""
        if not self.has(name):
            return None
        try:
            made = [float(one) for one in self.props[name]]
        except (TypeError, ValueError):
            made = []
        if len(made) != 3 or not np.isfinite(made).all() or np.linalg.norm(made) == 0:
            raise Error(
                f"{self.plugin}: {name} is no direction; give three numbers, such as [1, 0, 0]"
            )
        return made[0], made[1], made[2]

    def held(self, name: str) -> Any:
        """Return the path of a file, or the object that `hold` keeps; None if left out."""
        value = self.text(name)
        if value is None or not value.startswith(_PREFIX):
            # Paths in XML are relative to the file.
            return value and str(mi.file_resolver().resolve(value))
        if value not in _HELD:
            raise Error(
                f"{self.plugin}: {name} was an object of another process; save it to a file and "
                "give the path"
            )
        return _HELD[value]

    def curve(self, name: str) -> Curve | None:
        """Return a number, or numbers by incidence such as ``"0:0.52, 20:0.49"``."""
        if not self.has(name):
            return None
        if isinstance(self.props[name], str):
            try:
                pairs = [part.split(":") for part in self.props[name].split(",")]
                return Curve.of({float(at): float(value) for at, value in pairs})
            except ValueError:
                raise Error(
                    f"{self.plugin}: {name} is {self.props[name]!r}; give a number, or values by "
                    'incidence such as "0:0.52, 20:0.49"'
                ) from None
        return Curve([self.number(name)], [0.0])


@dataclass(frozen=True)
class Curve:
    """Number, or numbers by incidence (degrees): linear between them and constant beyond."""

    values: list[float]
    incidence_deg: list[float]

    @classmethod
    def of(cls, pairs: dict[float, float]) -> Curve:
        """Return the curve through values by incidence."""
        nodes = sorted(pairs)
        return cls([pairs[one] for one in nodes], nodes)

    def times(self, factor: float) -> Curve:
        """Return the curve times a factor."""
        return Curve([one * factor for one in self.values], self.incidence_deg)

    def __str__(self) -> str:
        if len(self.values) == 1:
            return f"{self.values[0]:g}"
        each = zip(self.incidence_deg, self.values)
        return ", ".join(f"{at:g}:{value:g}" for at, value in each)


@dataclass(frozen=True)
class Numbers:
    """What the keys of a sheet mean.

    Attributes
    ----------
    table : Table
        Table of its cell.
    c : float
        Corner size, mm.
    mu : Curve
        Reflectance.
    A : Curve or None
        Diffraction spread a R; None without diffraction.
    lobe : str
        Shape of the lobe of diffraction.
    wavelength_nm : float or None
        Wavelength at which A holds, in spectral variants.
    spread : float
        Standard deviation of the tangent of the angle across the plane of incidence.
    first_edge : three floats or None
        Azimuth 0, a vector of the world; None for the direction of increasing u of the surface.
    per_mm : float
        Units of the scene in one mm.
    """

    table: Table
    c: float
    mu: Curve
    A: Curve | None
    lobe: str
    wavelength_nm: float | None
    spread: float
    first_edge: tuple[float, float, float] | None
    per_mm: float


def numbers_of(keys: Keys) -> Numbers:
    """Return the numbers that the keys of a sheet or a plate give.

    Raises
    ------
    Error
        If a key is unknown, missing or contradicts another.
    """
    name = keys.plugin
    params = keys.held("params")
    table = keys.held("table")
    if table is None and isinstance(params, Result):
        table = params.table
    if table is None:
        raise Error(f"{name}: has no table; give table, the file that `bake trace -o` wrote")
    if not isinstance(table, Table):
        if not os.path.exists(table):
            raise Error(
                f"{table}: there is no such file, which {name} names as its table; make it with "
                "`bake trace`, or give another path"
            )
        table = open_table(table)
    far = keys.number("R")
    fitted = _Fitted.of(keys, params, table, far) if params is not None else _Fitted()
    c = keys.number("c", fitted.c)
    if c is None:
        raise Error(f"{name}: has no c, the corner size in mm; give c, or params (a result.json)")
    mu = keys.curve("mu") or fitted.mu
    if mu is None:
        raise Error(
            f"{name}: has no mu, the reflectance; give mu"
            + (" (the result has none, for lack of a reference photograph)" if params else "")
        )
    if keys.has("A") and keys.has("a"):
        raise Error(f"{name}: A and a are the same spread (A = a R); give one of them")
    spread_a = keys.curve("A")
    if keys.has("a"):
        if far is None:
            raise Error(
                f"{name}: a holds at one distance; give R too, the path from the sheet to the "
                "image in mm, or A = a R"
            )
        spread_a = keys.curve("a").times(far)  # type: ignore[union-attr]
    spread_a = spread_a or fitted.A
    if spread_a is not None and min(spread_a.values) <= 0:
        raise Error(f"{name}: A is 0; leave it out for a sheet without diffraction")
    lobe = keys.text("lobe", fitted.lobe)
    if lobe not in LOBES:
        raise Error(f"{name}: there is no lobe {lobe!r}; use {', '.join(LOBES)}")
    wavelength = keys.number("wavelength_nm")
    return Numbers(
        table=table,
        c=c,
        mu=mu,
        A=spread_a,
        lobe=lobe,
        wavelength_nm=wavelength,
        spread=1e-3 * keys.number("angular_spread_mrad", fitted.spread_mrad),
        first_edge=keys.vector("first_edge"),
        per_mm=1 / keys.number("unit_mm", 1.0, 1e-9),
    )


@dataclass(frozen=True)
class _Fitted:
    """Numbers of a result; None where it has none."""

    c: float | None = None
    mu: Curve | None = None
    A: Curve | None = None
    lobe: str = "radial"
    spread_mrad: float = 0.0

    @classmethod
    def of(cls, keys: Keys, params: Any, table: Table, far: float | None) -> _Fitted:
        name = keys.plugin
        if not isinstance(params, Result):
            if not os.path.exists(params):
                raise Error(
                    f"{params}: there is no such file, which {name} names as its params; make it "
                    "with `fit estimate -o`, or give another path"
                )
            params = load(params, table, channel=keys.text("channel"))
        cell = (params.data.get("table") or {}).get("cell") or {}
        meshes = cell.get("mesh_hash"), table.provenance["mesh_hash"]
        if meshes[0] and meshes[0] != meshes[1]:
            warn(
                [
                    f"{name}: the result was fitted with the table of another mesh "
                    f"({params.data['table'].get('design')})"
                ]
            )
        if params.dihedral_errors:
            raise Error(
                f"{name}: a result with dihedral errors cannot be rendered in a scene; bake a table of "
                "cubes with these errors (`bake design --dihedral-error-mrad`), and estimate with it"
            )
        kernel = params.kernel
        if kernel not in ("eq1", "angular", "shift", "lobe"):
            wave = (
                "its lobe depends on the distance R; give c and mu with A = 2.8 c / wavelength, or "
                'estimate again with kernel="angular"'
            )
            other = 'it is a published baseline; estimate again with model="proposed"'
            raise Error(
                f"{name}: a result of the kernel {kernel} cannot be rendered in a scene: "
                + (wave if kernel == "wave" else other)
            )
        spread_a = None
        if kernel in ("eq1", "lobe") and not (keys.has("A") or keys.has("a")):
            if far is None:
                raise Error(
                    f"{name}: the result has the kernel {kernel}, whose lobe is known in mm at the "
                    "distance R of the image; give R, the path from the sheet to the image in mm"
                )
            found = _curve(params.a, name, "a")
            spread_a = found and found.times(far)
        elif kernel == "angular":
            spread_a = _curve(params.a, name, "A")
        size = _curve(params.c, name, "c") if kernel != "lobe" else Curve([0.0], [0.0])
        spread = _curve(params.angular_spread, name, "angular_spread_mrad")
        return cls(
            c=0.0 if size is None else size.values[0],
            mu=_curve(params.mu, name, "mu"),
            A=spread_a,
            lobe=params.data["lobe"] or "radial",
            spread_mrad=0.0 if spread is None else spread.values[0],
        )


def _curve(given: Estimate | None, plugin: str, name: str) -> Curve | None:
    """Return an estimate as a curve; None if there is none, or only a bound, with a warning."""
    if given is None:
        return None
    if given.per_angle:
        known = {at: value for at, (value, _) in given.per_angle.items() if value is not None}
        return Curve.of(known) if known else None
    if given.value is None:
        warn([f"{plugin}: the photographs only bound {name}, so its blur is left out"])
        return None
    return Curve([given.value], [0.0])
