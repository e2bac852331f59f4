"""Examples of the documentation, as code that mypy reads and that runs.

    python examples.py CAPTURES.toml FOLDER
"""

from __future__ import annotations

import sys
from pathlib import Path

import midair
import numpy as np


def readme(captures: str) -> midair.Result:
    """The three lines of the README, and a campaign of one's own."""
    table = midair.trace(midair.design("triangular-pair"), refractive_index=1.49, azimuth=30)
    result = midair.estimate(midair.example(), table)
    assert result.c is not None and result.c.value is not None
    assert abs(result.c.value - 0.33) < 0.003
    result = midair.estimate(captures, table)
    result.predict(distance=[150, 300], incidence=range(0, 50, 5)).mtf
    return result


def tables(folder: Path) -> None:
    """Tables: made, read, looked up."""
    mesh = midair.design("triangular-pair", edge_length=0.18, dihedral_error_mrad=[0.1, 0, 0])
    mesh.save(folder / "pair.obj")
    table = midair.trace(
        folder / "pair.obj",
        folder / "pair.h5",
        refractive_index=1.49,
        incidence="0:40:20",
        azimuth="full:30",
        progress=lambda what, done, of: None,
    )
    table = midair.open(folder / "pair.h5")
    eta: float = table.eta_at(10, 15)
    areas = [path.weight * path.area for path in table.polygons(10, 15)]
    u = np.linspace(-2, 2, 9)
    otf = table.otf(u[:, None], u[None, :], 10, 15)
    shifts = table.sample(1000, seed=1, incidence=10, azimuth=15)
    data = table.to_xarray()
    print(eta, sum(areas), otf.shape, shifts.mean(axis=0), data.sizes["azimuth_deg"])


def photographs(captures: str, result: midair.Result) -> None:
    """Photographs: measured, from files and arrays."""
    folder = Path(captures).parent
    picture = midair.picture(folder / "source.exr")
    edge = midair.measure(picture, pixel_pitch=0.05, at=[0.5, 1.0])
    print(edge.mtf50, edge.unit, edge.to_xarray().sizes)
    assert result.c is not None and result.c.value is not None
    campaign = {
        "setup": {"pixel_pitch_mm": 0.05},
        "reference": {"image": picture},
        "capture": [
            {
                "image": midair.picture(folder / "aerial_150mm_20deg_tan.exr"),
                "floating_distance_mm": 150,
                "incidence_deg": 20,
                "azimuth_deg": 30,
                "exposure": 6.0,
            }
        ],
    }
    alone = midair.estimate(campaign, result.table, kernel="eq1", lobe="radial")
    print(alone.c, alone.a, alone.mu, alone.verdict, alone.curves().sizes)


def images(result: midair.Result, folder: Path) -> None:
    """Images: rendered, and what is kept."""
    source = np.zeros((64, 64, 3), np.float32)
    source[16:48, 16:48] = [1.0, 0.5, 0.0]
    image = result.render(source, distance=150, incidence=20, pixel_pitch=0.1)
    print(image.max(), image.shape)
    result.report().save(folder / "report.html")
    result.save(folder / "result.json")
    print(midair.load(folder / "result.json", result.table))
    try:
        midair.trace(midair.design("triangular-pair"), incidence=95)
    except midair.Error as error:
        print(error.file, error.place, error.remedy)


def answers(folder: Path) -> None:
    """A cell's data sheet, and the photographs to take."""
    pair = midair.design("triangular-pair")
    sheet = midair.datasheet(pair, refractive_index=1.49, cells=2, step=10.0, unit="mm")
    sheet.save(folder / "data.html")
    table = midair.trace(pair, refractive_index=1.49, incidence=[0, 20], azimuth=30)
    (folder / "plan.toml").write_text(
        """photographs = 2
        [beliefs]
        kernel = "eq1"
        c_mm = { from = 0.15, to = 0.3 }
        a_per_mm = { from = 2, to = 5 }
        mu = { from = 0.3, to = 0.6 }
        [choices]
        floating_distance_mm = [100, 300]
        incidence_deg = [0, 20]
        azimuth_deg = [30]
        """
    )
    plan = midair.plan(folder / "plan.toml", table)
    plan.save(folder / "planned.toml")
    print(sorted(sheet.data), len(plan.data["photographs"]))


if __name__ == "__main__":
    found = readme(sys.argv[1])
    tables(Path(sys.argv[2]))
    photographs(sys.argv[1], found)
    images(found, Path(sys.argv[2]))
    answers(Path(sys.argv[2]))
