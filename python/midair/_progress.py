"""Progress of long work."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeAlias

#: A function that is called with what is done, how many, and of how many (None if not known);
#: True for a bar of tqdm, False for nothing, None for a bar where somebody looks.
Progress: TypeAlias = "Callable[[str, int, int | None], object] | bool | None"

#: Seconds before a bar appears.
DELAY = 2


@contextmanager
def told(progress: Progress) -> Iterator[Callable[[str, int, int | None], object] | None]:
    """Give the function that the native module tells its progress to."""
    if callable(progress):
        yield progress
        return
    bar = _Bar() if progress or (progress is None and _is_watched()) else None
    try:
        yield bar
    finally:
        if bar is not None:
            bar.close()


def _is_watched() -> bool:
    """Return whether a person looks at the output: a terminal or a notebook."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return type(shell).__name__ == "ZMQInteractiveShell" or sys.stderr.isatty()


class _Bar:
    """Bars of tqdm, one for each kind of work; nothing if tqdm is not installed."""

    def __init__(self) -> None:
        self._bar: Any = None
        self._what = ""

    def __call__(self, what: str, done: int, of: int | None) -> None:
        try:
            # In a notebook a bar of widgets needs ipywidgets, a bar of text does not.
            widgets = importlib.util.find_spec("ipywidgets") is not None
            tqdm = importlib.import_module("tqdm.auto" if widgets else "tqdm.std").tqdm
        except ImportError:
            return
        if self._bar is None or what != self._what:
            self.close()
            self._bar, self._what = tqdm(desc=what, total=of, delay=DELAY, leave=False), what
        self._bar.total = of
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()
            self._bar = None
