"""What goes wrong, as exceptions and warnings."""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from midair import _midair
from midair._words import in_python, keywords


class Error(Exception):
    """The reason why something cannot be done: one sentence.

    It is that of the programs, with keywords (``kernel=``) in place of options (``--kernel``).

    Attributes
    ----------
    sentence : str
        The whole sentence.
    file : str or None
        File that the sentence is about.
    place : str or None
        Line of the file (``"line 12"``), or the keyword (``"incidence"``).
    remedy : str or None
        What to do.
    """

    def __init__(self, sentence: str) -> None:
        super().__init__(sentence)
        self.sentence = sentence
        self.file, self.place, self.remedy = _parts(sentence)


class MidairWarning(UserWarning):
    """A doubt about a result: one sentence, that of the programs with keywords for options."""


def _parts(sentence: str) -> tuple[str | None, str | None, str | None]:
    """Return the file, the place and the remedy that a sentence names."""
    head, colon, _ = sentence.partition(": ")
    named = re.findall(r"(?<![\w.-])([a-z][a-z_]*)=", head if colon else sentence)
    keyword = next((name for name in named if name in keywords()), None)
    file = place = None
    if colon and not (keyword and head.startswith(f"{keyword}=")):
        found = re.fullmatch(r"(.+?):(\d+)", head)
        path = found[1] if found else head
        if found or "/" in path or os.path.exists(path) or re.search(r"\.\w{2,5}$", path):
            file = path
            place = f"line {found[2]}" if found else None
    if file is None:
        place = keyword
    # A remedy stands behind the last semicolon. A short sentence only says what must be.
    _, semicolon, remedy = sentence.rpartition("; ")
    return file, place, remedy if semicolon else sentence.partition(": ")[2] or None


@contextmanager
def refusals() -> Iterator[None]:
    """Turn the refusals of the native module into `Error`."""
    try:
        yield
    except _midair.Refusal as refusal:
        raise Error(in_python(str(refusal))) from None


def warn(sentences: Iterable[str], stacklevel: int = 3) -> None:
    """Give each sentence as a `MidairWarning` of the caller's caller."""
    for sentence in sentences:
        warnings.warn(in_python(sentence), MidairWarning, stacklevel=stacklevel)
