"""What the tests share: the files of the repository, and the programs that the wheel brought."""

from __future__ import annotations

import struct
import subprocess
import sysconfig
import tempfile
import unittest
import warnings
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
CAMPAIGN = ROOT / "tests" / "captures" / "public_per_angle" / "captures.toml"
EDGE = CAMPAIGN.parent / "aerial_150mm_10deg_tan.exr"
SCRIPTS = Path(sysconfig.get_path("scripts"))


def run(program: str, *arguments: object, code: int = 0) -> subprocess.CompletedProcess[str]:
    """Run a program of the wheel, and check its exit code."""
    command = [str(SCRIPTS / program), *(str(argument) for argument in arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == code, (command, done.returncode, done.stderr)
    return done


def refusal(program: str, *arguments: object, code: int = 1) -> str:
    """Return the sentence with which a program refuses."""
    return run(program, *arguments, code=code).stderr.splitlines()[-1].removeprefix("error: ")


def quiet(call: Any, *arguments: Any, **options: Any) -> Any:
    """Call without warnings."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return call(*arguments, **options)


def read_exr(path: Path) -> np.ndarray:
    """Read an EXR of 32-bit floats without compression, as `fit` writes it."""
    data = path.read_bytes()
    header, at = {}, 8
    while data[at]:
        name, kind, rest = data[at:].split(b"\0", 2)
        (size,) = struct.unpack("<i", rest[:4])
        header[name] = rest[4 : 4 + size]
        at += len(name) + len(kind) + 2 + 4 + size
    at += 1
    assert header[b"compression"] == b"\0", header[b"compression"]
    left, top, right, bottom = struct.unpack("<4i", header[b"dataWindow"])
    columns, rows = right - left + 1, bottom - top + 1
    channels = header[b"channels"].count(b"\x02\0\0\0")
    offsets = struct.unpack(f"<{rows}Q", data[at : at + 8 * rows])
    lines = [
        np.frombuffer(data, "<f4", channels * columns, offset + 8).reshape(channels, columns)
        for offset in offsets
    ]
    picture = np.stack(lines)
    # Channels are in the order of their names: B, G, R.
    return picture[:, 0] if channels == 1 else np.moveaxis(picture[:, ::-1], 1, -1)


class Case(unittest.TestCase):
    """Test with a temporary folder; it prints how many cases it ran."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def tell(self, cases: int, what: str) -> None:
        self.assertGreater(cases, 0)
        print(f"{self._testMethodName}: {cases} {what}")
