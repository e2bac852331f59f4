"""Options of Python as the words of a command line, and back."""

from __future__ import annotations

import inspect
import numbers
import os
import re
from collections.abc import Iterable
from functools import cache
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


#: Words that follow an option as its value. Other words go on with the sentence.
_VALUES = (
    "angular auto eq1 exact facets file fresnel full guo linear lobe mean mirror mrm mse mtf none "
    "off plate proposed published radial random rays render retroreflector saito separable shift "
    "sobol spectral srgb tir trapped wave"
).split()

#: A whole command, or an option with its place holder and its value.
_OPTION = re.compile(
    r"""
    (?P<command> `[^`]*` | \b(?:bake|fit|cargo|make)[ ]
        (?:datasheet|design|trace|merge|inspect|verify|estimate|mtf|optimise|plan|predict|render|install)\b [^;`)]* )
    | (?<![\w-]) --(?P<name>[a-z][a-z-]*)
        (?: [ ]<[^<>]*>(?:\.\.\.)?
        | [ =](?P<value> -?[\w,/.:-]*\d[\w,/.:-]*(?<![,.:]) | [A-Z]+(?:[/,][A-Z]+)*(?![\w-])
            | \w+(?=:)
            | (?:%s)(?![\w-]) ) )?
    """
    % "|".join(_VALUES),
    re.VERBOSE,
)


@cache
def keywords() -> dict[str, bool]:
    """Return the keywords of the package, and of each whether it is True or False."""
    import midair

    made: dict[str, bool] = {}
    things = [getattr(midair, name) for name in midair.__all__]
    for thing in [*things, *vars(midair.Result).values()]:
        if inspect.isfunction(thing):
            for name, one in inspect.signature(thing).parameters.items():
                made[name] = one.annotation == "bool"
    return made


def in_python(sentence: str) -> str:
    """Return a sentence with keywords (``kernel=``) where a program names its options."""

    def one(found: re.Match[str]) -> str:
        name = (found["name"] or "").replace("-", "_")
        if name not in keywords():
            return found[0]
        value = found["value"]
        if value is None:
            return f"{name}=" + ("True" if keywords()[name] else "")
        is_bare = re.fullmatch(r"-?[\d.]+|[A-Z]+", value)
        return f"{name}={value}" if is_bare else f'{name}="{value}"'

    return _OPTION.sub(one, sentence)
