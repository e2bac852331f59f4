"""Builds the wheel: the programs first, packed as data, then the module by maturin.

The programs `bake`, `fit` and `airr-reader` lie in the wheel as scripts, so that `pip install` puts
them beside each other on the path. They are whole programs, not entry points of Python: they start
without an interpreter, and `airr-reader` has no other code.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import maturin
from maturin import get_requires_for_build_sdist, get_requires_for_build_wheel  # noqa: F401

ROOT = Path(__file__).resolve().parent.parent
EXAMPLE = ROOT / "python" / "midair" / "example"
SCRIPTS = ROOT / "python" / "midair.data" / "scripts"
PROGRAMS = ("bake", "fit", "airr-reader")
#: Profile of cargo: release, or dev, which tests have compiled already.
PROFILE = os.environ.get("AIRR_PROFILE", "release")


def build_programs() -> list[Path]:
    """Build the programs, lay them where maturin packs them, and return them.

    Not the module: maturin names the interpreter in its environment, so it links once more.
    """
    packages = [word for name in ("bake", "fit", "reader") for word in ("-p", name)]
    cargo = os.environ.get("CARGO", "cargo")
    build = [cargo, "build", "--profile", PROFILE, "--locked", *packages]
    subprocess.run(build, cwd=ROOT, check=True)
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    folder = target / ("debug" if PROFILE == "dev" else PROFILE)
    SCRIPTS.mkdir(parents=True, exist_ok=True)
    for name in PROGRAMS:
        shutil.copy2(folder / name, SCRIPTS / name)
    return [SCRIPTS / name for name in PROGRAMS]


def tag(files: list[Path]) -> list[str]:
    """Return maturin's option for the manylinux tag: the oldest C library that all files run with.

    maturin looks at the module only, and refuses it if it needs a younger one. An older tag needs zig as the C
    compiler. Tried with `airr-reader` and HDF5: cargo zigbuild --target
    x86_64-unknown-linux-gnu.2.17 makes a program for glibc 2.17, once tables/hdf5.cmake sets
    CMAKE_C_COMPILER to the CC_x86_64_unknown_linux_gnu of the environment. It is not done: all
    crates would be compiled again for that target, and nothing be shared with `make build`.
    """
    needed = [
        int(minor)
        for file in files
        for minor in re.findall(rb"\0GLIBC_2\.(\d+)(?=[.\0])", file.read_bytes())
    ]
    return ["--compatibility", f"manylinux_2_{max(needed)}"] if needed else []


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    """Write the metadata (PEP 517). maturin wants the folder of data there, empty or not."""
    SCRIPTS.mkdir(parents=True, exist_ok=True)
    return maturin.prepare_metadata_for_build_wheel(metadata_directory, config_settings)


def build_sdist(sdist_directory, config_settings=None):
    """Build the source archive (PEP 517)."""
    SCRIPTS.mkdir(parents=True, exist_ok=True)
    return maturin.build_sdist(sdist_directory, config_settings)


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Build the wheel (PEP 517)."""
    files = build_programs()
    # The campaign of midair.example().
    shutil.copytree(ROOT / "tests" / "captures" / "public_shared", EXAMPLE, dirs_exist_ok=True)
    os.environ["MATURIN_PEP517_ARGS"] = " ".join(["--profile", PROFILE, *tag(files)])
    return maturin.build_wheel(wheel_directory, config_settings, metadata_directory)
