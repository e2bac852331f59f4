"""What goes wrong, as exceptions and warnings."""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from midair import _midair


class Error(Exception):
    """The reason why something cannot be done: one sentence, as the programs print it.

    Attributes
    ----------
    sentence : str
        The whole sentence.
    file : str or None
        File that the sentence is about.
    place : str or None
        Line of the file (``"line 12"``), or the option (``"--incidence"``).
    remedy : str or None
        What to do.
    """

    def __init__(self, sentence: str) -> None:
        super().__init__(sentence)
        self.sentence = sentence
        self.file, self.place, self.remedy = _parts(sentence)


class MidairWarning(UserWarning):
    """A doubt about a result: one sentence, as the programs print it."""


def _parts(sentence: str) -> tuple[str | None, str | None, str | None]:
    """Return the file, the place and the remedy that a sentence names."""
    head, colon, _ = sentence.partition(": ")
    file = place = None
    if colon and not head.startswith("-"):
        found = re.fullmatch(r"(.+?):(\d+)", head)
        named = found[1] if found else head
        if found or "/" in named or os.path.exists(named) or re.search(r"\.\w{2,5}$", named):
            file = named
            place = f"line {found[2]}" if found else None
    option = re.search(r"(?<![\w-])--[a-z][a-z-]*", head if colon else sentence)
    if place is None and file is None and option is not None:
        place = option[0]
    # A remedy stands behind the last semicolon. A short sentence only says what must be.
    _, semicolon, remedy = sentence.rpartition("; ")
    return file, place, remedy if semicolon else sentence.partition(": ")[2] or None


@contextmanager
def refusals() -> Iterator[None]:
    """Turn the refusals of the native module into `Error`."""
    try:
        yield
    except _midair.Refusal as refusal:
        raise Error(str(refusal)) from None


def warn(sentences: Iterable[str], stacklevel: int = 3) -> None:
    """Give each sentence as a `MidairWarning` of the caller's caller."""
    for sentence in sentences:
        warnings.warn(sentence, MidairWarning, stacklevel=stacklevel)
