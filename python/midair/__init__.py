"""Retroreflective sheets: traced, estimated from photographs, and predicted.

Three steps, from nothing to the sharpness of a mid-air image::

    import midair

    table = midair.trace(midair.design("triangular-pair"), refractive_index=1.49, azimuth=30)
    result = midair.estimate(midair.example(), table)
    result.predict(distance=[150, 300], incidence=[0, 20, 40]).mtf

The functions are those of the programs `bake` and `fit`: the same numbers, the same defaults, the
same sentences when something is wrong (`Error`). Names of options are those of the command lines,
with `_` for `-`; an option that is left out (None) has the default of the program.

Lengths are in edge lengths of a cube in tables, and in mm in photographs and images. Angles are in
degrees. Light is linear.
"""

from midair import _programs as _programs
from midair._compare import Comparison, Shot, compare
from midair._errors import Error, MidairWarning
from midair._evaluate import Scores, evaluate
from midair._fit import Edge, Estimate, Plan, Report, Result
from midair._fit import estimate, example, load, measure, plan, sheet, simulate, study
from midair._maker import Best, Datasheet, datasheet, optimise
from midair._mesh import Mesh, design
from midair._picture import picture
from midair._register import Registration, register
from midair._table import Path, Table, open, trace
from midair._version import __version__

__all__ = [
    "Best",
    "Comparison",
    "Datasheet",
    "Edge",
    "Error",
    "Estimate",
    "Mesh",
    "MidairWarning",
    "Path",
    "Plan",
    "Registration",
    "Report",
    "Result",
    "Scores",
    "Shot",
    "Table",
    "__version__",
    "compare",
    "datasheet",
    "design",
    "estimate",
    "evaluate",
    "example",
    "load",
    "measure",
    "open",
    "optimise",
    "picture",
    "plan",
    "register",
    "sheet",
    "simulate",
    "study",
    "trace",
]
