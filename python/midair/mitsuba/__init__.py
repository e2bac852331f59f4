"""Retroreflective sheets in any scene of Mitsuba 3, with the shifts of a measured table.

Importing this module registers, for the current variant and for every later one:

- the BSDF ``midair_sheet``: a sheet with a table and the numbers c, mu and A;
- the BSDF ``midair_half_mirror``: a thin half mirror;
- the BSDF ``midair_plate``: a micro-mirror array plate;
- the integrator ``midair_path``: a path tracer that moves its paths at sheets.

A scene in a few lines::

    import midair.mitsuba
    import mitsuba as mi

    midair.mitsuba.set_variant("llvm_ad_rgb")
    scene = midair.mitsuba.scene("sign.png", table="sheet.h5", c=0.2, mu=0.5, distance=300)
    image = mi.render(midair.mitsuba.load(scene))

Lengths are in mm, in tables in edge lengths of a cube; the unit of a scene is the mm unless the key
`unit_mm` of a sheet says otherwise. Angles are in degrees. doc/renderer.md lists all keys, and says
what was measured.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from typing import Any

try:
    import mitsuba as mi
except ImportError as missing:  # pragma: no cover
    raise ImportError(
        'midair.mitsuba needs the package mitsuba; install it with pip install "midair[mitsuba]"'
    ) from missing

from midair._errors import Error
from midair._words import File
from midair.mitsuba._mirrors import half_mirror_class, plate_class
from midair.mitsuba._path import path_class
from midair.mitsuba._scene import scene, sheet
from midair.mitsuba._sheet import delta_class, sheet_class

__all__ = ["load", "scene", "set_variant", "sheet"]

#: Variants for which the plugins are registered.
_REGISTERED: set[str] = set()


def _register(old: str | None = None, new: str | None = None) -> None:
    """Register the plugins for the current variant, once."""
    variant = mi.variant()
    if variant is None or variant in _REGISTERED:
        return
    _REGISTERED.add(variant)
    delta = delta_class()
    bsdf, mirror = sheet_class(delta), half_mirror_class(delta)
    plate = plate_class(bsdf)
    integrator = path_class(bsdf, mirror)
    mi.register_bsdf("midair_sheet", lambda props: bsdf(props))
    mi.register_bsdf("midair_half_mirror", lambda props: mirror(props))
    mi.register_bsdf("midair_plate", lambda props: plate(props))
    mi.register_integrator("midair_path", lambda props: integrator(props))


def set_variant(name: str = "llvm_ad_rgb") -> None:
    """Set the variant of Mitsuba, as `mitsuba.set_variant` does, and say what it lacks.

    Raises
    ------
    Error
        If the variant does not exist, or needs an LLVM or a CUDA that is not there.
    """
    if name not in mi.variants():
        raise Error(f"there is no variant {name}; use one of {', '.join(mi.variants())}")
    try:
        mi.set_variant(name)
    except ImportError as error:
        if name.startswith("llvm"):
            raise Error(
                f"the variant {name} needs the library LLVM, which was not found; install it "
                "(Debian and Ubuntu: apt install libllvm19), name its file in "
                "DRJIT_LIBLLVM_PATH, or use scalar_rgb"
            ) from None
        raise Error(f"the variant {name} cannot be used here: {error}; use scalar_rgb") from None


def load(scene: Mapping[str, Any] | File) -> Any:
    """Load a scene (a dict, or an XML file) as Mitsuba does, with short errors.

    Mitsuba puts the sentence of an error at the end of a long text. This function raises that
    sentence.

    Raises
    ------
    Error
        If no variant is set, or a sheet of the scene cannot be made or would lose its shift.
    """
    if mi.variant() is None:
        raise Error(
            'no variant of Mitsuba is set; call midair.mitsuba.set_variant("llvm_ad_rgb") first'
        )
    try:
        if isinstance(scene, Mapping):
            made = mi.load_dict(dict(scene))
        else:
            made = mi.load_file(os.fspath(scene))
    except RuntimeError as error:
        found = re.search(r"^(?:midair\._errors\.)?Error: (.*)", str(error), re.S | re.M)
        if found is None:
            raise
        raise Error(" ".join(found[1].split())) from None
    # The integrator would find them too, but `mitsuba.render` hides its errors behind others.
    integrator: Any = made.integrator() if isinstance(made, mi.Scene) else None
    if hasattr(integrator, "search"):
        integrator.search(made)
    return made


_register()
mi.detail.add_variant_callback(_register)
