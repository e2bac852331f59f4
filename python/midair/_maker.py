"""Cells for a maker: data sheets, and the best cell of a goal."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from midair import _midair
from midair._errors import refusals, warn
from midair._fit import Report
from midair._mesh import Mesh
from midair._progress import Progress, told
from midair._words import File, Numbers, words


@dataclass(frozen=True)
class Datasheet(Report):
    """Data sheet of a cell, or of two compared. A notebook shows it; `save` writes the page.

    Attributes
    ----------
    html : str
        The page, which needs no other file.
    data : dict
        All numbers, as ``bake datasheet --json`` prints them.
    """

    data: dict[str, Any] = field(repr=False)


def datasheet(
    mesh: Mesh | File,
    second: Mesh | File | None = None,
    *,
    refractive_index: float | str | None = None,
    incidence: Numbers | None = None,
    azimuth: float | None = None,
    distance: float | None = None,
    error_mrad: float | None = None,
    cells: int | None = None,
    seed: int | None = None,
    step: float | None = None,
    up_to: float | None = None,
    angular_tolerance: float | None = None,
    metal: str | Sequence[float] | None = None,
    wavelength_nm: float | None = None,
    edge_length: float | None = None,
    azimuth_zero: Sequence[float] | None = None,
    lattice: Sequence[float] | None = None,
    unit: str | None = None,
    progress: Progress = None,
) -> Datasheet:
    """Make the data sheet of a cell, or compare two, as ``bake datasheet`` does.

    Parameters
    ----------
    mesh, second : Mesh or path
        Meshes of the cells.
    refractive_index : float or str, optional
        Index behind the front face, or the name of a material.
    incidence, azimuth, distance
        Directions of spots and tolerances, degrees, and the distance of the image, mm.
    error_mrad, cells, seed
        Random cells: the deviation of their dihedral errors, and their number.
    step, up_to, angular_tolerance
        The map over all directions, degrees.
    metal, wavelength_nm
        Metal of coated facets.
    progress : callable, bool, optional
        See `midair.estimate`.

    Raises
    ------
    Error
        If a mesh is no cell of planar facets, or an option is out of range.
    """
    options: dict[str, Any] = dict(
        refractive_index=refractive_index,
        incidence=incidence,
        azimuth=azimuth,
        distance=distance,
        error_mrad=error_mrad,
        cells=cells,
        seed=seed,
        step=step,
        up_to=up_to,
        angular_tolerance=angular_tolerance,
        metal=metal,
        wavelength_nm=wavelength_nm,
        edge_length=edge_length,
        azimuth_zero=azimuth_zero,
        lattice=lattice,
        unit=unit,
    )
    both = [mesh] if second is None else [mesh, second]
    files = [own.design if isinstance(own, Mesh) else own for own in both]
    held = [own._mesh if isinstance(own, Mesh) else None for own in (mesh, second)]
    with refusals(), told(progress) as tell:
        page, data, warnings = _midair.datasheet(words(*files, **options), held, tell)
    warn(warnings)
    return Datasheet(page, json.loads(data))


@dataclass(frozen=True)
class Best:
    """Best cell of a goal.

    Attributes
    ----------
    mesh : Mesh
        The cell, mm.
    front : str or None
        Picture of the front between sharpness and light, SVG; None unless the goal is of both.
    data : dict
        All numbers, as ``bake optimise --json`` prints them.
    """

    mesh: Mesh
    front: str | None = field(repr=False)
    data: dict[str, Any] = field(repr=False)

    def save(self, path: File) -> None:
        """Write the picture of the front to a file, .svg."""
        if self.front is None:
            raise ValueError('the goal has one best cell and no front; write best = "both" in it')
        with refusals():
            _midair.write(os.fspath(path), self.front)


def optimise(goal: File, *, progress: Progress = None) -> Best:
    """Search the cell whose mid-air image is sharpest, brightest or both, as ``bake optimise`` does.

    Parameters
    ----------
    goal : path
        What is wanted and what may vary, as TOML; ``bake optimise --help`` shows an example.
    progress : callable, bool, optional
        See `midair.estimate`.

    Raises
    ------
    Error
        If the goal cannot be used, or no cell meets it.
    """
    with refusals(), told(progress) as tell:
        made = _midair.optimise(words(goal, output="best.obj"), tell)
    mesh, data, front, warnings = made
    warn(warnings)
    return Best(Mesh._of(mesh), front, json.loads(data))
