"""Meshes of cells."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from midair import _midair
from midair._errors import refusals
from midair._words import File, words


class Mesh:
    """Mesh of one cell of a sheet.

    Parameters
    ----------
    vertices : array_like, shape (n, 3)
        Corners, in any unit.
    faces : array_like of int, shape (m, 3)
        Three indices of vertices for each facet, counter-clockwise seen from the light.
    design : str
        Name that a table will hold.
    lattice : two vectors, optional
        Vectors by which the cell repeats, in the unit of the vertices.
    hollow : bool
        True if the cubes are hollow.
    """

    def __init__(
        self,
        vertices: npt.ArrayLike,
        faces: npt.ArrayLike,
        *,
        design: str = "mesh",
        lattice: Sequence[Sequence[float]] | None = None,
        hollow: bool = False,
    ) -> None:
        corners = np.ascontiguousarray(vertices, dtype=np.float64)
        indices = np.asarray(faces)
        if indices.size and (indices.min() < 0 or indices.dtype.kind not in "iu"):
            raise TypeError("faces holds indices of vertices: whole numbers from 0")
        with refusals():
            self._mesh = _midair.Mesh(
                np.atleast_2d(corners),
                np.atleast_2d(indices).astype(np.uint32),
                design,
                None if lattice is None else [[float(x) for x in row] for row in lattice],
                hollow,
            )

    @classmethod
    def _of(cls, mesh: _midair.Mesh) -> Mesh:
        made = cls.__new__(cls)
        made._mesh = mesh
        return made

    @property
    def vertices(self) -> npt.NDArray[np.float64]:
        """Corners, shape (n, 3)."""
        return self._mesh.vertices

    @property
    def faces(self) -> npt.NDArray[np.uint32]:
        """Indices of the corners of each facet, shape (m, 3)."""
        return self._mesh.faces

    @property
    def design(self) -> str:
        """Name of the design."""
        return self._mesh.design

    def save(self, path: File) -> None:
        """Write the mesh to a file, .obj (exact) or .glb."""
        with refusals():
            self._mesh.write(os.fspath(path))

    def __reduce__(self) -> tuple[Any, ...]:
        return _of_obj, (self._mesh.obj(),)

    def __repr__(self) -> str:
        return f"<midair.Mesh {self.design}: {len(self.faces)} facets>"


def _of_obj(text: str) -> Mesh:
    """Return the mesh of a pickle."""
    with refusals():
        return Mesh._of(_midair.Mesh.of_obj(text))


def design(
    name: str,
    *,
    edge_length: float | None = None,
    truncation: float | None = None,
    cant_deg: float | None = None,
    gap: float | None = None,
    dihedral_error_mrad: Sequence[float] | None = None,
    sag: float | None = None,
    segments: int | None = None,
    edge_radius: float | None = None,
    strips: int | None = None,
    apex_flat: float | None = None,
    depth: float | None = None,
    thickness: float | None = None,
    diameter: float | None = None,
) -> Mesh:
    """Make the mesh of a design, as ``bake design`` does (``bake design --help`` says more).

    Parameters
    ----------
    name : str
        ``"triangular"``, ``"triangular-pair"``, ``"full-cube"``, ``"canted"``, ``"plate"``,
        ``"bead"`` and others; ``bake design --list`` prints all.
    edge_length : float, optional
        Edge of a cube from its apex, in the unit of the mesh.
    dihedral_error_mrad : three floats, optional
        Errors of the angles between the mirrors, mrad; positive is wider than 90 degrees.
    truncation, cant_deg, gap, sag, segments, edge_radius, strips, apex_flat
        Further shapes of cubes.
    depth, thickness, diameter
        Shapes of plates and beads.

    Raises
    ------
    Error
        If there is no such design, or an option has no meaning for it or is out of range.
    """
    options: dict[str, Any] = dict(
        edge_length=edge_length,
        truncation=truncation,
        cant_deg=cant_deg,
        gap=gap,
        dihedral_error_mrad=dihedral_error_mrad,
        sag=sag,
        segments=segments,
        edge_radius=edge_radius,
        strips=strips,
        apex_flat=apex_flat,
        depth=depth,
        thickness=thickness,
        diameter=diameter,
    )
    with refusals():
        return Mesh._of(_midair.design(words(name, output="mesh.obj", **options)))
