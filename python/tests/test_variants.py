"""Sheets in every kind of variant of Mitsuba, briefly: light, wavelengths, orders of set-up."""

from __future__ import annotations

import os
import subprocess
import sys
import unittest
from typing import Any

import midair
import numpy as np
from common import Case

try:
    import mitsuba as mi
    import midair.mitsuba as scenes
except ImportError:
    mi = None


def has(variant: str) -> bool:
    """Set a variant, and return whether it works here; LLVM may be missing."""
    try:
        scenes.set_variant(variant)
    except midair.Error:
        return False
    return True


def sheet_alone(
    table: midair.Table, square: tuple[float, float] | None = None, **keys: Any
) -> Any:
    """Return a sheet in the plane z = 0, seen along its normal.

    The light is even, or comes from a square: half of its side, and its height.
    """
    even = {"type": "spectrum", "value": 1.0}
    light: dict[str, Any] = {"type": "constant", "radiance": even}
    if square is not None:
        half, height = square
        to_world = mi.ScalarTransform4f().translate([0, 0, height]).scale([half, half, -1])
        light = {
            "type": "rectangle",
            "to_world": to_world,
            "light": {"type": "area", "radiance": even},
        }
    film = {"type": "hdrfilm", "width": 1, "height": 1, "component_format": "float32"}
    return scenes.load(
        {
            "type": "scene",
            "integrator": {"type": "midair_path", "max_depth": 3, "rr_depth": 100},
            "camera": {
                "type": "radiancemeter",
                "origin": [0.0, 0.0, 100.0],
                "direction": [0.0, 0.0, -1.0],
                "film": {**film, "rfilter": {"type": "box"}, "pixel_format": "luminance"},
            },
            "light": light,
            "sheet": {
                "type": "rectangle",
                "to_world": mi.ScalarTransform4f().scale(50),
                "bsdf": scenes.sheet(table, mu=0.5, first_edge=[1, 0, 0], **keys),
            },
        }
    )


@unittest.skipIf(mi is None, 'no package mitsuba: pip install "midair[mitsuba]"')
class Variants(Case):
    def setUp(self) -> None:
        super().setUp()
        self.table = midair.trace(
            midair.design("triangular-pair"),
            refractive_index=1.49,
            incidence="0:20:10",
            azimuth="full:30",
        )
        before = mi.variant()
        if before is not None:
            self.addCleanup(mi.set_variant, before)

    def test_every_kind_of_variant_returns_mu_eta(self) -> None:
        """Numbers one at a time, arrays of colours, and polarised light with the same weight."""
        expected, tried = 0.5 * self.table.eta_at(0, 0), 0
        for variant in ("scalar_rgb", "llvm_ad_rgb", "llvm_ad_mono_polarized"):
            if not has(variant):
                continue
            scene = sheet_alone(self.table, c=0.2, A=700.0)
            light = float(np.array(mi.render(scene, spp=16)).ravel()[0])
            # Every path has the same weight, so there is no noise; 1e-5 is the grid's error of eta.
            self.assertAlmostEqual(light, expected, delta=1e-5)
            tried += 1
        self.tell(tried, "variants")

    def test_the_lobe_narrows_as_the_wavelength(self) -> None:
        """Shares of a square light around the spot, against the integral of the lobe."""
        n, half, height, A, cases = 1 << 17, 0.25, 200.0, 500.0, 0
        nm = np.array([450.0, 500.0, 550.0, 700.0])
        for variant in ("llvm_ad_spectral", "llvm_ad_spectral_polarized"):
            if not has(variant):
                continue
            for lobe in ("gaussian", "separable"):
                scene = sheet_alone(
                    self.table, c=0.0, A=A, lobe=lobe, wavelength_nm=550.0, square=(half, height)
                )
                sampler = mi.load_dict({"type": "independent"})
                sampler.seed(1, n)
                ray = mi.RayDifferential3f(mi.Ray3f([0, 0, 100], [0, 0, -1]))
                ray.wavelengths = mi.UnpolarizedSpectrum(*nm.tolist())
                found = scene.integrator().sample(scene, sampler, ray)[0]
                seen = np.array(mi.unpolarized_spectrum(found), np.float64)
                seen /= 0.5 * self.table.eta_at(0, 0)
                # The density along one axis is exp(-t^2) or (sin t / t)^2, with t = A x / height.
                for own, share, noise in zip(nm, seen.mean(1), seen.std(1)):
                    reach = A * 550 / own * half / height
                    t = reach * ((np.arange(20_000) + 0.5) / 10_000 - 1)
                    density = np.exp(-(t**2)) / np.sqrt(np.pi)
                    if lobe == "separable":
                        density = np.sinc(t / np.pi) ** 2 / np.pi
                    expected = (2 * reach * density.mean()) ** 2
                    # Four standard errors, which are near 0.001.
                    self.assertLess(abs(share - expected), 4 * noise / np.sqrt(n), (lobe, own))
                    self.assertLess(noise / np.sqrt(n), 0.002)
                    cases += 1
        if cases == 0:
            self.skipTest("the spectral variants need LLVM")
        self.tell(cases, "wavelengths")

    def test_variants_may_be_set_before_and_after(self) -> None:
        """In new processes: a variant set first, one set later, one after another, and none."""
        start, end = "import mitsuba as mi", "import midair.mitsuba as scenes"
        first, second = "mi.set_variant('scalar_rgb')", "mi.set_variant('scalar_spectral')"
        load = "mi.load_dict({'type': 'midair_half_mirror'})"
        orders = [
            [start, first, end, load],
            [start, end, first, load],
            [start, first, end, second, load, first, load],
        ]
        for order in orders:
            done = python("; ".join([*order, "print('loaded')"]))
            self.assertEqual(done.stdout.strip(), "loaded", done.stderr)
        done = python(f"{end}; scenes.load({{'type': 'scene'}})")
        self.assertIn('call midair.mitsuba.set_variant("llvm_ad_rgb") first', done.stderr)
        self.tell(len(orders) + 1, "orders")

    def test_a_missing_llvm_is_named(self) -> None:
        done = python(
            "import midair.mitsuba as scenes; scenes.set_variant('llvm_ad_rgb')",
            DRJIT_LIBLLVM_PATH=str(self.folder / "none.so"),
        )
        self.assertIn("apt install libllvm", done.stderr)
        self.assertIn("scalar_rgb", done.stderr)
        self.tell(1, "message")


def python(code: str, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run code in a new process."""
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False,
        env={**os.environ, **variables},
    )


if __name__ == "__main__":
    unittest.main()
