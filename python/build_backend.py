"""Builds the wheel: the programs first, packed as data, then the module by maturin.

The programs `bake`, `fit` and `airr-reader` lie in the wheel as scripts, so that `pip install` puts
them beside each other on the path. They are whole programs, not entry points of Python: they start
without an interpreter, and `airr-reader` has no other code.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import maturin
from maturin import (  # noqa: F401
    build_sdist,
    get_requires_for_build_sdist,
    get_requires_for_build_wheel,
    prepare_metadata_for_build_wheel,
)

ROOT = Path(__file__).resolve().parent.parent
SCRIPTS = ROOT / "python" / "airr.data" / "scripts"
PROGRAMS = ("bake", "fit", "airr-reader")


def build_programs() -> None:
    """Build the programs and lay them where maturin packs them."""
    packages = [word for name in ("bake", "fit", "reader") for word in ("-p", name)]
    cargo = os.environ.get("CARGO", "cargo")
    subprocess.run([cargo, "build", "--release", "--locked", *packages], cwd=ROOT, check=True)
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    SCRIPTS.mkdir(parents=True, exist_ok=True)
    for name in PROGRAMS:
        shutil.copy2(target / "release" / name, SCRIPTS / name)


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Build the wheel (PEP 517)."""
    build_programs()
    return maturin.build_wheel(wheel_directory, config_settings, metadata_directory)
