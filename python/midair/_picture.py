"""Pictures as arrays."""

from __future__ import annotations

import os
from typing import Any, TypeAlias, TypeGuard

import numpy as np
import numpy.typing as npt

from midair import _midair
from midair._errors import refusals, warn
from midair._words import File

#: An array of shape (rows, columns) or (rows, columns, 3), of linear light unless a `transfer` is
#: named. Unsigned integers of 8, 16 or 32 bits are divided by the largest integer of their type,
#: so that 1 is saturated.
Picture: TypeAlias = "npt.NDArray[Any]"


def is_file(picture: Picture | File) -> TypeGuard[File]:
    """Return whether a picture is a path."""
    return isinstance(picture, (str, os.PathLike))


def planes(picture: Any, name: str) -> tuple[str, npt.NDArray[np.float32], bool]:
    """Return the name of a picture, its planes (plane, row, column), and if it had integers."""
    array = np.asarray(picture)
    if array.dtype.kind != "f" and array.dtype not in (np.uint8, np.uint16, np.uint32):
        raise TypeError(
            f"{name}: a picture has floats, or integers of type uint8, uint16 or uint32, whose "
            f"greatest value is full scale; convert the {array.dtype} to one of them"
        )
    if array.ndim == 2:
        array = array[:, :, None]
    if array.ndim != 3:
        raise TypeError(
            f"{name}: a picture has the shape (rows, columns) or (rows, columns, 3), "
            f"not {array.shape}"
        )
    array = np.moveaxis(array, -1, 0)
    if array.dtype.kind == "f":
        return name, array.astype(np.float32, copy=False), False
    most = np.float32(np.iinfo(array.dtype).max)
    return name, array.astype(np.float32) / most, True


def picture(path: File, transfer: str | None = None) -> npt.NDArray[np.float32]:
    """Read a picture as linear light, shape (rows, columns) or (rows, columns, 3).

    Parameters
    ----------
    path : path
        EXR, PNG, TIFF or JPEG.
    transfer : {"linear", "srgb"}, optional
        Meaning of integers; without it the file decides, as for ``fit render --transfer``.

    Raises
    ------
    Error
        If the file is no picture, or is damaged.
    """
    with refusals():
        made, warnings = _midair.read_picture(os.fspath(path), transfer)
    warn(warnings)
    return made[0] if len(made) == 1 else np.stack(made, axis=-1)
