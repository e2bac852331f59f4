"""Sheets in scenes of Mitsuba, against the table itself."""

from __future__ import annotations

import unittest
import warnings

import midair
import numpy as np
from common import Case

try:
    import mitsuba as mi
    import midair.mitsuba as scenes
except ImportError:
    raise unittest.SkipTest("the package mitsuba is not installed") from None

try:
    scenes.set_variant("llvm_ad_rgb")
except midair.Error as error:
    raise unittest.SkipTest(error.sentence) from None


class Furnace(Case):
    def test_a_sheet_in_even_light_returns_mu_eta(self) -> None:
        table = midair.trace(
            midair.design("triangular-pair"),
            refractive_index=1.49,
            incidence="0:50:5",
            azimuth="full:5",
        )
        generator = np.random.default_rng(1)
        own = [(i, a) for i in (0.0, 20.0, 45.0) for a in (0.0, 15.0)]
        between = list(zip(generator.uniform(1, 49, 12), generator.uniform(0, 360, 12)))
        for incidence, azimuth in own + between:
            theta, phi = np.radians(incidence), np.radians(azimuth)
            # The camera's ray travels along the azimuth, as light of that direction does.
            back = np.array([-np.sin(theta) * np.cos(phi), -np.sin(theta) * np.sin(phi)])
            towards = np.array([*back, np.cos(theta)])
            made = mi.load_dict(
                {
                    "type": "scene",
                    "integrator": {"type": "midair_path", "max_depth": 3, "rr_depth": 100},
                    "camera": {
                        "type": "radiancemeter",
                        "origin": [float(x) for x in 100 * towards],
                        "direction": [float(x) for x in -towards],
                        "film": {
                            "type": "hdrfilm",
                            "width": 1,
                            "height": 1,
                            "rfilter": {"type": "box"},
                            "component_format": "float32",
                        },
                    },
                    "light": {"type": "constant"},
                    "sheet": {
                        "type": "rectangle",
                        "to_world": mi.ScalarTransform4f().scale(50),
                        "bsdf": scenes.sheet(table, c=0.2, mu=0.5, first_edge=[1, 0, 0]),
                    },
                }
            )
            image = np.array(mi.render(made, spp=64))
            # Every path has the same weight, so there is no noise; 1e-5 is the grid's error of eta.
            expected = 0.5 * table.eta_at(incidence, azimuth)
            np.testing.assert_allclose(image[0, 0], expected, atol=1e-5)
        self.tell(len(own) + len(between), "directions")


class Shifts(Case):
    def test_drawn_shifts_have_the_transfer_function_of_the_table(self) -> None:
        from midair.mitsuba._directions import Directions, grid_of

        n, cases = 1 << 20, 0
        table = midair.trace(
            midair.design("triangular-pair"),
            refractive_index=1.49,
            incidence="0:50:5",
            azimuth="full:5",
        )
        directions, generator = Directions(grid_of(table)), np.random.default_rng(2)
        for incidence, azimuth in ((0, 0), (20, 30), (40, 75), (20, 17), (40, 197)):
            numbers = [mi.Float(generator.random(n).astype(np.float32)) for _ in range(4)]
            sine = mi.Float(np.full(n, np.sin(np.radians(incidence)), np.float32))
            _, u, v, *_ = directions.draw(
                sine, mi.Float(float(azimuth)), numbers[0], numbers[1], mi.Point2f(*numbers[2:])
            )
            shifts = np.stack([np.array(u), np.array(v)], axis=1)
            for f in ([0.1, 0.0], [0.0, 0.2], [0.3, -0.2]):
                mean = np.exp(-2j * np.pi * (shifts @ np.array(f))).mean()
                truth = complex(table.otf(*f, incidence, azimuth))
                # Noise: 5 / sqrt(n) = 0.005. Between directions the mixture of neighbours, 5
                # degrees apart, differs from their polygons by less than 0.005.
                self.assertLess(abs(mean - truth), 0.005 + (0.005 if azimuth % 5 else 0))
                cases += 1
        self.tell(cases, "frequencies")


class Refusals(Case):
    def test_errors_name_the_remedy(self) -> None:
        table = midair.trace(
            midair.design("triangular-pair"), refractive_index=1.49, incidence="0:20:10",
            azimuth="full:10",
        )
        narrow = midair.trace(
            midair.design("triangular-pair"), refractive_index=1.49, incidence="0:20:10", azimuth=30
        )
        good = scenes.sheet(table, c=0.2, mu=0.5)
        cases = [
            ({**good, "mue": 0.5}, "did you mean mu?"),
            ({**good, "mu": {"type": "rgb", "value": [0.1, 0.2, 0.3]}}, "give one number"),
            ({**good, "a": 4.0}, "give R too"),
            ({**good, "table": "/nowhere.h5"}, "there is no such file"),
            ({"type": "midair_sheet", "c": 0.2, "mu": 0.5}, "give table"),
            (scenes.sheet(narrow, c=0.2, mu=0.5), "full:10"),
        ]
        for bsdf, remedy in cases:
            with self.assertRaises(midair.Error) as caught, warnings.catch_warnings():
                warnings.simplefilter("ignore")
                scenes.load(bsdf)
            self.assertIn(remedy, caught.exception.sentence)
        self.tell(len(cases), "refusals")


if __name__ == "__main__":
    unittest.main()
