"""Notebooks run from start to end, draw pictures, and hold nothing of the computer they ran on."""

from __future__ import annotations

import importlib.util
import json
import os
import re
import subprocess
import sys
import time
import unittest
from typing import Any
from unittest import mock

from common import ROOT, Case

NOTEBOOKS = sorted((ROOT / "python" / "notebooks").glob("*.ipynb"))
#: What the notebooks import, and what runs them.
NEEDED = ("nbclient", "nbformat", "ipykernel", "matplotlib", "pandas", "xarray")
MISSING = [name for name in NEEDED if importlib.util.find_spec(name) is None]
#: Seconds that a notebook may take.
LIMIT = 60
#: Bytes of a stored notebook, with its pictures.
SIZE = 400_000
#: Places of a computer: folders of users and temporary folders, and the files of a kernel.
PLACES = re.compile(r"(?<![\w.])/(?:root|home|tmp|work|Users|mnt|var)/|ipykernel_|[A-Z]:\\\\")


def pictures(cells: list[Any]) -> int:
    """Return how many pictures the outputs of cells hold."""
    return sum(
        "image/png" in output.get("data", {})
        for cell in cells
        for output in cell.get("outputs", [])
    )


def lacking(notebook: str) -> str:
    """Return what a notebook needs and this computer lacks: Mitsuba or LLVM; empty if nothing."""
    if "midair.mitsuba" not in notebook:
        return ""
    code = "import midair.mitsuba as mm; mm.set_variant('llvm_ad_rgb')"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False
    )
    return "" if done.returncode == 0 else done.stderr.strip().splitlines()[-1].split(": ", 1)[-1]


class Notebooks(Case):
    def setUp(self) -> None:
        super().setUp()
        # What a kernel and matplotlib keep in the home of a user goes into the temporary folder.
        names = ("IPYTHONDIR", "JUPYTER_RUNTIME_DIR", "MPLCONFIGDIR")
        kept = mock.patch.dict(os.environ, {name: str(self.folder / name) for name in names})
        kept.start()
        self.addCleanup(kept.stop)

    @unittest.skipIf(MISSING, f"not installed: {', '.join(MISSING)}")
    def test_notebooks_run(self) -> None:
        import nbformat
        from nbclient import NotebookClient

        drawn = 0
        for path in NOTEBOOKS:
            with self.subTest(path.name):
                if reason := lacking(path.read_text(encoding="utf-8")):
                    print(f"{path.name}: not run: {reason}")
                    self.skipTest(reason)
                notebook = nbformat.read(path, as_version=4)
                for cell in notebook.cells:
                    cell.pop("outputs", None)
                    if cell.cell_type == "code":
                        cell.outputs = []
                client = NotebookClient(
                    notebook,
                    timeout=LIMIT,
                    kernel_name="python3",
                    resources={"metadata": {"path": str(path.parent)}},
                )
                start = time.monotonic()
                client.execute()  # raises where a cell raises
                seconds = time.monotonic() - start
                found = pictures(notebook.cells)
                print(f"{path.name}: {found} pictures, {seconds:.1f} s")
                self.assertLess(seconds, LIMIT)
                self.assertGreater(found, 0)
                drawn += found
        self.tell(len(NOTEBOOKS), f"notebooks, {drawn} pictures")

    def test_stored_notebooks_are_clean(self) -> None:
        for path in NOTEBOOKS:
            with self.subTest(path.name):
                text = path.read_text(encoding="utf-8")
                notebook = json.loads(text)
                self.assertLess(len(text.encode()), SIZE)
                self.assertGreater(pictures(notebook["cells"]), 0, "stored without its pictures")
                self.assertIsNone(PLACES.search(text), "a place of the computer that ran it")
                for cell in notebook["cells"]:
                    self.assertEqual(cell["metadata"], {}, "metadata of a run")
        self.tell(len(NOTEBOOKS), "stored notebooks")


if __name__ == "__main__":
    unittest.main()
