"""Options of Python as the words of a command line."""

from __future__ import annotations

import numbers
import os
from collections.abc import Iterable
from typing import Any, TypeAlias

import numpy as np

#: A file.
File: TypeAlias = "str | os.PathLike[str]"

#: A number, a list of numbers, or text such as ``"0:45:5"`` (from 0 to 45 in steps of 5).
Numbers: TypeAlias = "float | str | Iterable[float]"


def text(value: Any) -> str:
    """Return one value as a command line has it."""
    if isinstance(value, str):
        return value
    if isinstance(value, os.PathLike):
        return str(os.fspath(value))
    if getattr(value, "ndim", None) == 0:
        # A number of numpy or xarray.
        value = value.item()
    if isinstance(value, numbers.Integral):
        return str(int(value))
    if isinstance(value, numbers.Real):
        return repr(float(value))
    if isinstance(value, Iterable):
        return ",".join(text(item) for item in value)
    raise TypeError(f"a number, a text or a list is wanted, not {type(value).__name__}")


def is_true(value: Any) -> bool:
    """Return whether a value is True, of Python or of numpy."""
    return isinstance(value, (bool, np.bool_)) and bool(value)


def is_false(value: Any) -> bool:
    """Return whether a value is False, of Python or of numpy."""
    return isinstance(value, (bool, np.bool_)) and not value


def words(*arguments: Any, **options: Any) -> list[str]:
    """Return arguments and options as words. None and False leave an option out."""
    made = [
        f"--{name.replace('_', '-')}" + ("" if is_true(value) else f"={text(value)}")
        for name, value in options.items()
        if value is not None and not is_false(value)
    ]
    if arguments:
        made += ["--", *(text(argument) for argument in arguments)]
    return made
