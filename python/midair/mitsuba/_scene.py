"""Scenes of mid-air images: the standard set-up as a dict, and sheets as fragments."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from midair._errors import Error
from midair._fit import Result, load
from midair._picture import Picture, is_file
from midair._picture import picture as read_picture
from midair._table import Table
from midair._words import File
from midair.mitsuba._keys import SHEET, hold, unknown


def sheet(
    table: Table | File | None = None,
    *,
    params: Result | File | None = None,
    first_edge: Sequence[float] | None = None,
    **keys: Any,
) -> dict[str, Any]:
    """Return the BSDF `midair_sheet` for a scene: a dict of keys that Mitsuba takes.

    Parameters
    ----------
    table : Table or path, optional
        Table of the cell; a `midair.Result` as `params` brings its own.
    params : Result or path, optional
        Result of an estimate (result.json), in place of `c`, `mu` and `A`.
    first_edge : three floats, optional
        Azimuth 0: a vector of the world, projected on the sheet.
    **keys
        Further keys of doc/renderer.md: `c` (mm), `mu`, `A` (or `a`, 1/mm, with `R`, mm), `lobe`,
        `wavelength_nm`, `angular_spread_mrad`, `unit_mm`.

    Raises
    ------
    Error
        If a key is unknown.
    """
    given = {"table": table, "params": params, "first_edge": first_edge, **keys}
    made: dict[str, Any] = {"type": "midair_sheet"}
    for name, value in given.items():
        if value is None:
            continue
        if name not in SHEET:
            raise unknown(name, "midair_sheet", SHEET)
        if isinstance(value, (Table, Result)):
            value = hold(value)
        elif isinstance(value, os.PathLike):
            value = os.fspath(value)
        elif name == "first_edge" and not isinstance(value, str):
            value = [float(one) for one in value]
        made[name] = value
    return made


def scene(
    picture: Picture | File,
    table: Table | File | None = None,
    *,
    distance: float,
    incidence: float = 0.0,
    azimuth: float = 0.0,
    width: float = 100.0,
    params: Result | File | None = None,
    half_mirror: tuple[float, float] = (0.5, 0.5),
    source_distance: float | None = None,
    sheet_size: float | None = None,
    camera_distance: float = 1000.0,
    aperture: float | None = None,
    resolution: tuple[int, int] | None = None,
    field: float | None = None,
    samples: int = 256,
    guided: bool = True,
    **keys: Any,
) -> dict[str, Any]:
    """Return the standard set-up of a mid-air image as a dict for Mitsuba.

    The half mirror stands at the origin, at 45 degrees. The source lies below it and shines up; the
    half mirror reflects its light to the sheet behind (towards -z); what the sheet returns passes
    the half mirror and converges in front of it (towards +z), where the camera sees the picture
    upright. All lengths are in mm.

    Parameters
    ----------
    picture : array, shape (rows, columns) or (rows, columns, 3), or path
        Source, linear light (files as `midair.picture` reads them). Its pixels are even squares.
    table, params, **keys
        The sheet, as in `midair.mitsuba.sheet`.
    distance : float
        R: the path from the sheet to the mid-air image, mm.
    incidence : float
        Angle between the principal ray and the normal of the sheet, degrees. The sheet is turned
        about the vertical, so that the plane of incidence is horizontal in the picture.
    azimuth : float
        Azimuth of the light of the principal ray, degrees: the sheet is turned in its own plane.
    width : float
        Width of the picture, mm.
    half_mirror : two floats
        Transmittance and reflectance.
    source_distance : float, optional
        Path from the source to the half mirror, mm, as far as the image is from it; half of
        `distance` by default.
    sheet_size : float, optional
        Side of the square sheet, mm; by default it is as large as half of the field at its place
        needs, and twice as long along the plane of incidence as the angle asks for.
    camera_distance : float
        From the camera to the mid-air image, mm.
    aperture : float, optional
        Diameter of a lens that is focused on the image, mm; without it the camera is a pinhole.
    resolution : two ints, optional
        Columns and rows of the photograph; those of the picture by default.
    field : float, optional
        Width of the photograph in the plane of the image, mm; `width` by default.
    samples : int
        Paths of a pixel.
    guided : bool
        True to send every path through the half mirror to the sheet and by reflection to the
        source (`midair_path`): much less noise, but no other ways of light at the half mirror.

    Raises
    ------
    Error
        If no variant is set, or a length is out of range.
    """
    import mitsuba as mi

    if mi.variant() is None:
        raise Error(
            'no variant of Mitsuba is set; call midair.mitsuba.set_variant("llvm_ad_rgb") first'
        )
    lengths = {
        "distance": distance,
        "width": width,
        "sheet_size": sheet_size,
        "camera_distance": camera_distance,
        "aperture": aperture,
        "field": field,
        "samples": samples,
    }
    for name, value in lengths.items():
        if value is not None and not value > 0:
            raise Error(f"{name} is {value:g}; give a number above 0")
    near = distance / 2 if source_distance is None else float(source_distance)
    if not 0 < near < distance:
        raise Error(
            f"the source is {near:g} mm from the half mirror and the path to the sheet is "
            f"{distance:g} mm; give a source_distance between 0 and distance"
        )
    if not 0 <= incidence < 90:
        raise Error(f"the incidence is {incidence:g} degrees; give an angle from 0 to below 90")
    light = np.asarray(read_picture(picture) if is_file(picture) else picture, np.float32)
    if light.ndim == 2:
        light = np.repeat(light[..., None], 3, axis=-1)
    rows, columns = light.shape[:2]
    height = width * rows / columns
    behind = distance - near
    theta, phi = np.radians(incidence), np.radians(azimuth)
    normal = np.array([np.sin(theta), 0.0, np.cos(theta)])
    u = np.array([np.cos(theta), 0.0, -np.sin(theta)])
    v = np.array([0.0, 1.0, 0.0])
    # The light travels along u at azimuth phi from the first edge, counter-clockwise about n.
    edge = np.cos(phi) * u - np.sin(phi) * v
    film = (columns, rows) if resolution is None else resolution
    seen = width if field is None else float(field)
    reach = seen * (camera_distance + distance) / camera_distance
    if sheet_size is None:
        sheet_size = float(1.2 * (reach + 0.05 * distance) * max(1, rows / columns) / np.cos(theta))
    mirror_size = 1.5 * max(reach, width, height) + 0.1 * distance
    bsdf = sheet(table, params=params, **{"first_edge": list(edge), **keys})
    if params is not None:
        bsdf.setdefault("R", float(distance))
        _remark(table, params, (distance, incidence, azimuth), keys.get("channel"))
    camera: dict[str, Any] = {
        "type": "perspective" if aperture is None else "thinlens",
        "fov_axis": "x",
        "fov": float(np.degrees(2 * np.arctan(seen / 2 / camera_distance))),
        "near_clip": 1e-2 * camera_distance,
        "far_clip": 1e2 * (camera_distance + distance),
        "to_world": mi.ScalarTransform4f().look_at(
            origin=[0, 0, near + camera_distance], target=[0, 0, near], up=[0, 1, 0]
        ),
        "film": {
            "type": "hdrfilm",
            "width": int(film[0]),
            "height": int(film[1]),
            "rfilter": {"type": "box"},
            "pixel_format": "rgb",
            "component_format": "float32",
        },
        "sampler": {"type": "independent", "sample_count": int(samples)},
    }
    if aperture is not None:
        camera.update(aperture_radius=float(aperture) / 2, focus_distance=float(camera_distance))
    return {
        "type": "scene",
        "integrator": {"type": "midair_path", "max_depth": 6, "guided": bool(guided)},
        "camera": camera,
        "source": {
            "type": "rectangle",
            "to_world": _placed([0, -near, 0], [width / 2, 0, 0], [0, 0, -height / 2]),
            "bsdf": {"type": "diffuse", "reflectance": 0.0},
            "light": {"type": "area", "radiance": _texture(light)},
        },
        "half_mirror": {
            "type": "rectangle",
            "to_world": _placed(
                [0, 0, 0],
                [mirror_size / 2, 0, 0],
                [0, mirror_size / 2, -mirror_size / 2],
            ),
            "bsdf": {
                "type": "midair_half_mirror",
                "transmittance": float(half_mirror[0]),
                "reflectance": float(half_mirror[1]),
            },
        },
        "sheet": {
            "type": "rectangle",
            "to_world": _placed([0, 0, -behind], sheet_size / 2 * u, sheet_size / 2 * v),
            "bsdf": bsdf,
        },
    }


def _remark(
    table: Table | File | None,
    params: Result | File,
    place: tuple[float, float, float],
    channel: str | None,
) -> None:
    """Warn where a result does not hold at a place, as its predictions do."""
    try:
        if not isinstance(params, Result):
            if table is None:
                return
            params = load(params, table, channel=channel)
        params.predict(*place, table=table if isinstance(table, Table) else None)
    except Error:
        pass  # The sheet says what is wrong when the scene is loaded.


def _placed(middle: Any, right: Any, up: Any) -> Any:
    """Return the transform of a rectangle with this middle and these half sides."""
    import mitsuba as mi

    middle, right, up = (np.asarray(one, float) for one in (middle, right, up))
    normal = np.cross(right, up)
    normal = normal / np.linalg.norm(normal)
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2], matrix[:3, 3] = right, up, normal, middle
    return mi.ScalarTransform4f(matrix)


def _texture(light: npt.NDArray[np.float32]) -> dict[str, Any]:
    """Return a picture as a texture of even squares; the first row of a texture is below."""
    import mitsuba as mi

    return {
        "type": "bitmap",
        "bitmap": mi.Bitmap(np.ascontiguousarray(light[::-1])),
        "raw": not mi.is_spectral,
        "filter_type": "nearest",
        "wrap_mode": "clamp",
    }
