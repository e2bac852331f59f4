"""Pictures compared: the scores against their definitions."""

from __future__ import annotations

import importlib.util
import math
import unittest
import warnings
from typing import Any

import midair
import numpy as np
from common import Case

PACKAGES = ("skimage", "flip_evaluator")


def pictures() -> tuple[np.ndarray, np.ndarray]:
    """Return two unlike pictures of linear light."""
    random = np.random.default_rng(3)
    y, x = np.mgrid[0:24, 0:32]
    first = np.stack([(x * 5 + y * 3) % 37, (x + y * 7) % 29, (x * y) % 31], -1) / 40.0
    return first, np.clip(first + 0.1 * random.standard_normal(first.shape), 0, 1)


def srgb(light: np.ndarray) -> np.ndarray:
    """Return values encoded by IEC 61966-2-1."""
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


def ssim(a: np.ndarray, b: np.ndarray) -> float:
    """Return the mean SSIM of one colour, window by window (Wang et al. 2004, eq. 13)."""
    gauss = np.exp(-0.5 * (np.arange(-5, 6) / 1.5) ** 2)
    weight = np.outer(gauss, gauss) / np.sum(gauss) ** 2
    values = []
    for row in range(a.shape[0] - 10):
        for column in range(a.shape[1] - 10):
            p, q = (one[row : row + 11, column : column + 11] for one in (a, b))
            m, n = np.sum(weight * p), np.sum(weight * q)
            v, w = np.sum(weight * (p - m) ** 2), np.sum(weight * (q - n) ** 2)
            both = np.sum(weight * (p - m) * (q - n))
            alike = (2 * m * n + 1e-4) * (2 * both + 9e-4)
            values.append(alike / ((m * m + n * n + 1e-4) * (v + w + 9e-4)))
    return float(np.mean(values))


@unittest.skipIf(
    any(importlib.util.find_spec(name) is None for name in PACKAGES),
    "midair[evaluate] is not installed",
)
class Evaluate(Case):
    def test_scores_are_those_of_their_definitions(self) -> None:
        a, b = pictures()
        scores = midair.evaluate(
            0.5 * a, 0.5 * b, exposure=2.0, network=lambda p, q: (p - q).mean()
        )
        shown = [srgb(one) for one in (a, b)]
        mean = np.mean((shown[0] - shown[1]) ** 2)
        # Values are rounded to f32, 6e-8 of 1; the scores are smooth in them.
        self.assertAlmostEqual(scores.psnr_db, -10 * math.log10(mean), delta=1e-4)
        own = np.mean([ssim(shown[0][..., k], shown[1][..., k]) for k in range(3)])
        self.assertAlmostEqual(scores.ssim, own, delta=1e-5)
        self.assertTrue(0.01 < scores.flip < 1, scores.flip)
        # The network sees -1..1, which doubles the difference.
        if importlib.util.find_spec("torch"):
            difference = 2 * float(np.mean(shown[0] - shown[1]))
            self.assertAlmostEqual(scores.lpips, difference, delta=1e-5)

    def test_equal_pictures_are_equal(self) -> None:
        a, _ = pictures()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            # A network, so that no weights are looked for.
            scores = midair.evaluate(a, a.copy(), network=lambda p, q: (p - q).mean())
        self.assertEqual((scores.psnr_db, scores.flip), (math.inf, 0.0))
        self.assertAlmostEqual(scores.ssim, 1.0, delta=1e-12)

    def test_lpips_without_weights_is_left_out_with_a_warning(self) -> None:
        def none(*_: Any) -> Any:
            raise OSError("no weights")

        a, b = pictures()
        with self.assertWarns(midair.MidairWarning):
            self.assertIsNone(midair.evaluate(a, b, network=none).lpips)

    def test_pictures_that_cannot_be_compared_are_refused(self) -> None:
        a, b = pictures()
        cases = [(a[:-1], b), (a[:8], b[:8]), (a[..., :2, 0][0], b)]
        for one, other in cases:
            with self.assertRaises((midair.Error, TypeError)):
                midair.evaluate(one, other)


if __name__ == "__main__":
    unittest.main()
