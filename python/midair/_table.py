"""Ray-shift tables."""

from __future__ import annotations

import os
import pathlib
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from midair import _midair
from midair._errors import Error, refusals, warn
from midair._mesh import Mesh
from midair._progress import Progress, told
from midair._words import File, Numbers, words

if TYPE_CHECKING:
    import xarray

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Path:
    """One way of light through a cube: a polygon of entry points, and the map of their shifts.

    A ray that enters at p leaves shifted by ``matrix @ p + offset``. All lengths are in edge
    lengths, in the incidence frame (u along the in-plane direction of travel, v = n x u).

    Attributes
    ----------
    polygon : ndarray, shape (n, 2)
        Corners (u, v) of the points of entry, counter-clockwise.
    matrix : ndarray, shape (2, 2)
        Linear part of the shift.
    offset : ndarray, shape (2,)
        Constant part of the shift.
    weight : float
        Share of the power that comes back, 1 without losses.
    deviation : ndarray, shape (2,)
        Tangents of the angles from straight back, in the plane of incidence and along v.
    """

    polygon: Floats
    matrix: Floats
    offset: Floats
    weight: float
    deviation: Floats

    @property
    def area(self) -> float:
        """Area of the polygon, square edge lengths."""
        u, v = self.polygon.T
        return float(0.5 * np.sum(u * np.roll(v, -1) - np.roll(u, -1) * v))

    def shift(self, entry: npt.ArrayLike) -> Floats:
        """Return the shifts of rays that enter at `entry`, shape (..., 2), in the same shape."""
        made: Floats = np.asarray(entry, float) @ self.matrix.T + self.offset
        return made


class Table:
    """Ray-shift table: for each direction, what share of the light comes back, and how shifted.

    `trace` makes one, `open` reads one. Shifts are in edge lengths of a cube.
    """

    def __init__(self, table: _midair.Table) -> None:
        self._table = table

    @property
    def incidence_deg(self) -> Floats:
        """Angles of incidence that the table holds, degrees from the normal."""
        return self._table.incidence_deg

    @property
    def azimuth_deg(self) -> Floats:
        """Azimuths that the table holds, degrees; NaN for a mean over all azimuths."""
        return self._table.azimuth_deg

    @property
    def eta(self) -> Floats:
        """Retroreflected share of the light, shape (incidence, azimuth)."""
        return self._table.eta

    @property
    def standard_error(self) -> Floats:
        """Standard error of `eta`; 0 for an exact table."""
        return self._table.standard_error

    @property
    def histogram(self) -> Floats:
        """Probability of each shift of the light that comes back within the range.

        Shape (incidence, azimuth, shift_v, shift_u); sums to 1 for each direction, or is 0 where
        nothing comes back.
        """
        return self._table.histogram

    @property
    def counts(self) -> npt.NDArray[np.uint64] | None:
        """Numbers of rays, shape (incidence, azimuth, randomisation, shift_v, shift_u).

        None for an exact table.
        """
        return self._table.counts

    @property
    def shift(self) -> Floats:
        """Centres of the bins along u, and along v, edge lengths."""
        return self._table.shift

    @property
    def is_exact(self) -> bool:
        """True if the table holds polygons, and no sampling error."""
        return self._table.is_exact

    @property
    def content_hash(self) -> str:
        """SHA-256 of the content, as ``bake verify`` prints it."""
        return self._table.content_hash

    @property
    def provenance(self) -> dict[str, str]:
        """Where the numbers come from: design, mesh, refractive index, method, seed and others."""
        return dict(self._table.provenance)

    def eta_at(self, incidence: float, azimuth: float | None = None) -> float:
        """Return the retroreflected share at a direction, degrees; interpolated where needed.

        An azimuth is needed unless the table holds one only.

        Raises
        ------
        Error
            If the direction lies outside of the table.
        """
        with refusals():
            eta, _ = self._table.eta_at(float(incidence), self._azimuth(azimuth))
        return eta

    def polygons(self, incidence: float, azimuth: float | None = None) -> list[Path]:
        """Return the paths of light at a direction, degrees; interpolated where needed.

        Raises
        ------
        Error
            If the table was made of rays, or the direction lies outside of it.
        """
        return self._paths(incidence, azimuth)[0]

    def otf(
        self,
        fx: npt.ArrayLike,
        fy: npt.ArrayLike,
        incidence: float,
        azimuth: float | None = None,
        *,
        c_mm: float | None = None,
    ) -> npt.NDArray[np.complex128]:
        """Return the transfer function of the ray shift alone, 1 at frequency 0.

        Parameters
        ----------
        fx, fy : array_like
            Frequencies along u and v: in cycles per edge length, or with `c_mm` in 1/mm. They are
            broadcast against each other.
        incidence, azimuth : float
            Direction, degrees.
        c_mm : float, optional
            Edge length of a cube, mm.

        Returns
        -------
        ndarray of complex
            In the shape of the frequencies; accurate to 1e-13 for the polygons or bins.
        """
        u, v = np.broadcast_arrays(np.asarray(fx, float), np.asarray(fy, float))
        scale = 1.0 if c_mm is None else float(c_mm)
        if not 0 < scale < np.inf:
            raise ValueError("c_mm is a length above 0, in mm")
        with refusals():
            values = self._table.otf(
                np.ascontiguousarray(u).ravel() * scale,
                np.ascontiguousarray(v).ravel() * scale,
                float(incidence),
                self._azimuth(azimuth),
            )
        return values.reshape(u.shape)

    def sample(
        self, n: int, seed: int, incidence: float, azimuth: float | None = None
    ) -> Floats:
        """Draw the shifts of light that comes back, shape (n, 2) as (u, v), edge lengths.

        The same seed gives the same numbers. Polygons are sampled exactly; bins of a table of rays
        are sampled evenly within each bin.

        Raises
        ------
        Error
            If nothing comes back at this direction, or the direction lies outside of the table.
        """
        generator = np.random.default_rng(seed)
        if self.is_exact and not np.isnan(self.azimuth_deg).any():
            return _of_polygons(self.polygons(incidence, azimuth), n, generator)
        with refusals():
            share = self._table.probability(float(incidence), self._azimuth(azimuth))
        total = share.sum()
        if total == 0:
            raise Error("nothing comes back at this direction; sample another one")
        ends = np.cumsum(share.ravel())
        drawn = np.searchsorted(ends, generator.random(n) * ends[-1], side="right")
        v, u = np.unravel_index(np.minimum(drawn, share.size - 1), share.shape)
        width = self.shift[1] - self.shift[0] if len(self.shift) > 1 else 2 * self._table.range
        within = (generator.random((n, 2)) - 0.5) * width
        made: Floats = np.stack([self.shift[u], self.shift[v]], axis=1) + within
        return made

    def to_xarray(self, unfold: bool = True) -> xarray.Dataset:
        """Return the table as a dataset with named dimensions and units.

        Parameters
        ----------
        unfold : bool
            True to list all azimuths that the symmetry of the cell gives, from 0 to 360, of which
            the last repeats the first: looking up the nearest azimuth then finds the right one.
            False to list the azimuths of the file only.
        """
        import xarray

        own = self._table
        histogram, fate = own.histogram, own.fate
        eta, error, rays = own.eta, own.standard_error, own.rays
        azimuths = own.azimuth_deg
        rotations, mirror = own.symmetry
        if unfold and (rotations > 1 or mirror is not None) and not np.isnan(azimuths).any():
            images = own.azimuths()
            if images[0][0] == 0:
                images.append((360.0, images[0][1], images[0][2]))
            place = np.array([index for _, index, _ in images])
            turned = np.array([mirrored for _, _, mirrored in images])
            azimuths = np.array([azimuth for azimuth, _, _ in images])
            histogram, fate = histogram[:, place], fate[:, place]
            eta, error, rays = eta[:, place], error[:, place], rays[:, place]
            histogram[:, turned] = histogram[:, turned, ::-1]
        directions = ("incidence_deg", "azimuth_deg")

        def named(values: Any, units: str, long_name: str) -> tuple[Any, Any, dict[str, str]]:
            dims, array = values
            return dims, array, {"units": units, "long_name": long_name}

        dataset = xarray.Dataset(
            {
                "retroreflected": named((directions, eta), "1", "retroreflected share, eta"),
                "standard_error": named((directions, error), "1", "standard error of eta"),
                "histogram": named(
                    ((*directions, "shift_v", "shift_u"), histogram),
                    "1",
                    "probability of the shift of light that comes back within the range",
                ),
                "fate": named(
                    ((*directions, "fate_name"), fate), "1", "share of the light by fate"
                ),
                "rays": named((directions, rays), "1", "rays launched, 0 if exact"),
            },
            {
                "incidence_deg": named(
                    ("incidence_deg", own.incidence_deg), "degree", "incidence from the normal"
                ),
                "azimuth_deg": named(
                    ("azimuth_deg", azimuths), "degree", "azimuth of incidence about the normal"
                ),
                "shift_v": named(("shift_v", own.shift), "edge_length", "shift along v = n x u"),
                "shift_u": named(
                    ("shift_u", own.shift), "edge_length", "shift along u, the direction of travel"
                ),
                "fate_name": ("fate_name", own.fate_names, {"long_name": "what became of light"}),
            },
            {
                "Conventions": "CF-1.11",
                "title": "retroreflective ray-shift table",
                "source": f"{self.provenance['generator']}, method {self.provenance['method']}",
                "content_hash": self.content_hash,
                **self.provenance,
            },
        )
        # The mean over azimuths has one azimuth without a number.
        return dataset.isel(azimuth_deg=0, drop=True) if np.isnan(azimuths).all() else dataset

    def save(self, path: File) -> None:
        """Write the table to an HDF5 file, the same bytes as ``bake trace`` writes."""
        with refusals():
            self._table.write(os.fspath(path))

    def __reduce__(self) -> tuple[Any, ...]:
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "table.h5"
            self.save(path)
            return _of_bytes, (path.read_bytes(), self._table.name)

    def __repr__(self) -> str:
        directions = f"{len(self.incidence_deg)} x {len(self.azimuth_deg)} directions"
        kind = "exact" if self.is_exact else "of rays"
        return f"<midair.Table {self.provenance['design']}: {directions}, {kind}>"

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{incidence:g}</td><td>{azimuth:g}</td><td>{eta:.6f}</td></tr>"
            for incidence, row in list(zip(self.incidence_deg, self.eta))[:12]
            for azimuth, eta in list(zip(self.azimuth_deg, row))[:1]
        )
        return (
            f"<p>{_escaped(repr(self)[1:-1])}</p><table><tr><th>incidence (deg)</th>"
            f"<th>azimuth (deg)</th><th>retroreflected</th></tr>{rows}</table>"
        )

    def _azimuth(self, azimuth: float | None) -> float | None:
        """Return the azimuth, or the only one of the table."""
        if azimuth is not None:
            return float(azimuth)
        only = self.azimuth_deg
        return float(only[0]) if len(only) == 1 and not np.isnan(only[0]) else None

    def _paths(self, incidence: float, azimuth: float | None) -> tuple[list[Path], float]:
        with refusals():
            paths, area = self._table.paths(float(incidence), self._azimuth(azimuth))
        made = [
            Path(polygon, matrix, np.array(offset), weight, np.array(deviation))
            for polygon, matrix, offset, weight, deviation in paths
        ]
        return made, area


def _escaped(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;")


def _of_polygons(paths: Sequence[Path], n: int, generator: np.random.Generator) -> Floats:
    """Draw shifts of the paths: a triangle by its power, and a point of it evenly."""
    corners, powers, owners = [], [], []
    for owner, path in enumerate(paths):
        first = path.polygon[0]
        for second, third in zip(path.polygon[1:], path.polygon[2:]):
            a, b = second - first, third - first
            corners.append((first, second, third))
            powers.append(path.weight * 0.5 * abs(a[0] * b[1] - a[1] * b[0]))
            owners.append(owner)
    ends = np.cumsum(powers)
    if len(ends) == 0 or ends[-1] == 0:
        raise Error("nothing comes back at this direction; sample another one")
    drawn = np.searchsorted(ends, generator.random(n) * ends[-1], side="right")
    drawn = np.minimum(drawn, len(ends) - 1)
    a, b = generator.random((2, n))
    # A point of the other half of the parallelogram is turned into the triangle.
    over = a + b > 1
    a[over], b[over] = 1 - a[over], 1 - b[over]
    first, second, third = np.moveaxis(np.array(corners)[drawn], 1, 0)
    entry = first + a[:, None] * (second - first) + b[:, None] * (third - first)
    chosen = np.array(owners)[drawn]
    matrices = np.array([path.matrix for path in paths])[chosen]
    offsets = np.array([path.offset for path in paths])[chosen]
    made: Floats = np.einsum("nij,nj->ni", matrices, entry) + offsets
    return made


def _of_bytes(content: bytes, name: str) -> Table:
    """Return the table of a pickle, which is that of a file with this content."""
    with tempfile.TemporaryDirectory() as folder, refusals():
        path = pathlib.Path(folder) / "table.h5"
        path.write_bytes(content)
        return Table(_midair.open(os.fspath(path), name))


def open(path: File) -> Table:
    """Read a table from an HDF5 file.

    A small program opens the file, without rights and with limits of memory and time, because the
    HDF5 library trusts a file and tables may come from strangers.

    Raises
    ------
    Error
        If the file is missing, no table, damaged, or changed after it was written.
    """
    with refusals():
        return Table(_midair.open(os.fspath(path)))


def trace(
    mesh: Mesh | File,
    output: File | None = None,
    *,
    refractive_index: float | str | None = None,
    incidence: Numbers | None = None,
    azimuth: Numbers | None = None,
    bins: int | None = None,
    range: float | None = None,
    angular_tolerance: float | None = None,
    direction_tolerance: float | None = None,
    deviations: float | str | None = None,
    wavelength_nm: float | None = None,
    back: str | None = None,
    losses: str | None = None,
    metal: str | None = None,
    reflectance: float | None = None,
    normals: str | None = None,
    roughness: float | str | None = None,
    element: str | None = None,
    glass_index: float | None = None,
    front: str | None = None,
    edge_length: float | None = None,
    azimuth_zero: Sequence[float] | None = None,
    lattice: Sequence[float] | None = None,
    unit: str | None = None,
    method: str | None = None,
    rays: int | None = None,
    tolerance: float | None = None,
    sampler: str | None = None,
    seed: int | None = None,
    shard: str | None = None,
    threads: int | None = None,
    progress: Progress = None,
) -> Table:
    """Trace light through a cell into a table of its ray shifts, as ``bake trace`` does.

    ``bake trace --help`` explains each option. A long bake that must survive a crash is better run
    by that program, which saves its state.

    Parameters
    ----------
    mesh : Mesh or path
        Mesh of one cell.
    output : path, optional
        File that receives the table too.
    refractive_index : float or str, optional
        Index behind the front face, or the name of a material (with `wavelength_nm`).
    incidence, azimuth : float, list, or text
        Directions in the air, degrees: ``30``, ``[0, 15, 30]``, ``"0:45:5"``; for the azimuth also
        ``"full"``, ``"full:10"`` and ``"mean"``.
    method : {"auto", "exact", "rays"}
        Exact polygons where all facets are planes, or rays.
    rays, tolerance, sampler, seed, shard
        How rays are drawn.
    losses, metal, reflectance, back, wavelength_nm
        What surfaces do to light.
    roughness, normals, deviations, element, glass_index, front
        What only some cells need.
    threads : int, optional
        Number of threads; the table does not depend on it.
    progress : callable, bool, optional
        See `midair.estimate`.

    Raises
    ------
    Error
        If the mesh is no cell, or an option is out of range.
    """
    options: dict[str, Any] = dict(
        refractive_index=refractive_index,
        incidence=incidence,
        azimuth=azimuth,
        bins=bins,
        range=range,
        angular_tolerance=angular_tolerance,
        direction_tolerance=direction_tolerance,
        deviations=deviations,
        wavelength_nm=wavelength_nm,
        back=back,
        losses=losses,
        metal=metal,
        reflectance=reflectance,
        normals=normals,
        roughness=roughness,
        element=element,
        glass_index=glass_index,
        front=front,
        edge_length=edge_length,
        azimuth_zero=azimuth_zero,
        lattice=lattice,
        unit=unit,
        method=method,
        rays=rays,
        tolerance=tolerance,
        sampler=sampler,
        seed=seed,
        shard=shard,
        threads=threads,
    )
    native = mesh._mesh if isinstance(mesh, Mesh) else None
    file = mesh.design if isinstance(mesh, Mesh) else mesh
    with refusals(), told(progress) as tell:
        table, warnings = _midair.trace(words(file, output="table.h5", **options), native, tell)
        if output is not None:
            table.write(os.fspath(output))
    warn(warnings)
    return Table(table)
