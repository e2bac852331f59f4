"""The small program that opens tables, found and named to the native module."""

from __future__ import annotations

import sysconfig
from importlib.metadata import PackageNotFoundError, files
from pathlib import Path

from midair import _midair

_NAME = "airr-reader"


def _places() -> list[Path]:
    """Return the places of the program: where the wheel was unpacked, then where scripts are."""
    try:
        packed = [Path(str(file.locate())) for file in files("midair") or [] if file.name == _NAME]
    except PackageNotFoundError:
        packed = []
    beside = Path(__file__).resolve().parents[1] / "bin" / _NAME
    return [*packed, beside, Path(sysconfig.get_path("scripts")) / _NAME]


def use() -> None:
    """Name the program to the native module. A missing one is refused when a table is opened."""
    places = _places()
    found = next((place for place in places if place.is_file()), places[-1])
    _midair.use_reader(str(found.resolve()))


use()
