"""Pictures as arrays: the same numbers as from files."""

from __future__ import annotations

import tomllib
import unittest
import warnings
from typing import Any

import midair
import numpy as np
from common import CAMPAIGN, EDGE, Case


def in_memory() -> dict[str, Any]:
    """Return the campaign with arrays in place of files."""
    campaign = tomllib.loads(CAMPAIGN.read_text())
    for shot in [campaign["reference"], *campaign["capture"]]:
        shot["image"] = midair.picture(CAMPAIGN.parent / shot["image"])
    return campaign


class Arrays(Case):
    def test_an_array_is_measured_as_its_file(self) -> None:
        file, array = midair.measure(EDGE), midair.picture(EDGE)
        shades = np.stack([array] * 3, axis=-1)
        cases: list[tuple[Any, float]] = [
            (array, 0.0),
            (array.astype(np.float64), 0.0),
            (array[::1, ::1].copy(order="F"), 0.0),
            # Three equal channels: the weights of luminance are rounded to f32.
            (shades, 1e-6),
            # Steps of 1 / 65535 are far below the noise.
            (np.round(array * 65535).astype(np.uint16), 1e-3),
            (np.round(array.astype(float) * (2**32 - 1)).astype(np.uint32), 1e-4),
            (array.astype(np.float16), 3e-3),
        ]
        for picture, within in cases:
            edge = midair.measure(picture)
            self.assertLessEqual(abs(edge.mtf50 / file.mtf50 - 1), within, picture.dtype)
            self.assertEqual(edge.unit, file.unit)
        green = midair.measure(shades * [0.5, 1, 0.5], channel="green")
        self.assertEqual(green.mtf50, file.mtf50)
        self.tell(len(cases) + 1, "arrays")

    def test_estimates_from_arrays_are_those_from_files(self) -> None:
        table = midair.trace(
            midair.design("triangular-pair"), refractive_index=1.49, incidence="0:45:5", azimuth=30
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            files = midair.estimate(CAMPAIGN, table)
            arrays = midair.estimate(in_memory(), table)
        self.assertFalse(np.isinf(arrays.curves().residual).any())
        # Paths and arrays may stand side by side, and numbers may be numpy's.
        mixed = tomllib.loads(CAMPAIGN.read_text())
        mixed["reference"]["image"] = midair.picture(CAMPAIGN.parent / "source.exr")
        mixed["capture"][3]["incidence_deg"] = np.array(mixed["capture"][3]["incidence_deg"])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            other = midair.estimate(mixed, table, folder=CAMPAIGN.parent)
        self.assertEqual(files.data["c_mm"], other.data["c_mm"])
        for name in ("c_mm", "a_per_mm", "mu", "kernel", "covariance", "candidates", "trusted"):
            self.assertEqual(files.data[name], arrays.data[name], name)
        self.assertIn("<svg", arrays.report().html)
        data = arrays.curves()
        self.assertLess(float(np.abs(data.residual).median()), 2.0)
        self.tell(len(data.capture), "photographs")

    def test_mistakes_in_a_campaign_are_named(self) -> None:
        table = midair.trace(
            midair.design("triangular-pair"), refractive_index=1.49, incidence=[0, 45], azimuth=30
        )
        cases = 0

        def refused(change: Any, *parts: str) -> None:
            nonlocal cases
            campaign = in_memory()
            change(campaign)
            with self.assertRaises(midair.Error) as caught, warnings.catch_warnings():
                warnings.simplefilter("ignore")
                midair.estimate(campaign, table)
            for part in parts:
                self.assertIn(part, caught.exception.sentence)
            cases += 1

        def spoil(value: float) -> Any:
            def change(campaign: dict[str, Any]) -> None:
                campaign["capture"][1]["image"] = campaign["capture"][1]["image"].copy()
                campaign["capture"][1]["image"][3, 5] = value

            return change

        capture = "captures: capture"
        refused(lambda c: c["capture"][2].update(incidense_deg=3), f"{capture} 2", "incidence_deg")
        refused(lambda c: c["capture"][1].update(incidence_deg=95), f"{capture} 1", "incidence_deg")
        refused(lambda c: c["capture"][0].pop("exposure"), "capture 0", "exposure")
        refused(lambda c: c["setup"].pop("pixel_pitch_mm"), "captures: setup", "pixel_pitch_mm")
        refused(lambda c: c.update(captures=[]), "captures", "capture")
        refused(lambda c: c.update(capture=[]), "captures")
        refused(lambda c: c["capture"][1].update(image="nowhere.exr"), "capture 1", "nowhere.exr")
        refused(lambda c: c["capture"][1].update({"a b": 1}), "capture 1", "a b")
        refused(lambda c: c["capture"][1].update(incidence_deg=None), "capture 1", "incidence_deg")
        for wrong_shape in ({"capture": {}}, {"reference": np.ones((5, 5))}, {"capture": [3]}):
            with self.assertRaises(TypeError):
                midair.estimate({**in_memory(), **wrong_shape}, table)
            cases += 1
        refused(spoil(np.nan), "capture 1", "column 5, row 3", "NaN")
        refused(spoil(np.inf), "capture 1", "column 5, row 3", "inf")
        # int64 has a full scale that no camera has: 16 bits in it would be black.
        for wrong in (
            np.ones((64, 64), int),
            np.zeros(5),
            np.zeros((4, 4, 2)),
            np.array([["a"]]),
            np.zeros((0, 3)),
        ):
            with self.assertRaises((midair.Error, TypeError)):
                midair.measure(wrong)
            cases += 1
        self.tell(cases, "mistakes")


if __name__ == "__main__":
    unittest.main()
