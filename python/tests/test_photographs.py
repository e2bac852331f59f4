"""Photographs by Mitsuba, against `render` and against what `estimate` makes of them."""

from __future__ import annotations

import unittest

import midair
import numpy as np
from common import Case

try:
    import drjit as dr
    import mitsuba as mi
    import midair.mitsuba as scenes
except ImportError:
    raise unittest.SkipTest("the package mitsuba is not installed") from None

try:
    scenes.set_variant("llvm_ad_rgb")
except midair.Error as error:
    raise unittest.SkipTest(error.sentence) from None


def pair() -> midair.Table:
    return midair.trace(
        midair.design("triangular-pair"),
        refractive_index=1.49, incidence="0:45:5", azimuth="full:5",
    )


class Photographs(Case):
    def test_estimate_finds_the_parameters_of_rendered_photographs(self) -> None:
        """The loop of two programs: photographs by Mitsuba, their c, A and mu by `estimate`."""
        pixels, pitch, fine, width, exposure = 160, 0.05, 1920, 24.0, 20.0
        # Paths have noise at the edge only, 0.04 there. That of a camera is equal everywhere, and
        # `estimate` refuses to trust an edge that has more.
        noise = 0.045
        truth = {"c": 0.3, "A": 2100.0, "mu": 0.5}
        table, generator = pair(), np.random.default_rng(3)
        step = width / fine
        x, y = np.meshgrid(*[(np.arange(fine) + 0.5) * step - width / 2] * 2)

        def edge(degrees: float) -> np.ndarray:
            a = np.radians(degrees)
            return np.clip(0.5 + (x * np.cos(a) - y * np.sin(a)) / step, 0, 1).astype(np.float32)

        def photographed(light: np.ndarray) -> np.ndarray:
            return (light + generator.normal(0, noise, light.shape)).astype(np.float32)

        captures = []
        for incidence in (0, 30):
            for degrees in (5, 95):
                scene = scenes.scene(
                    edge(degrees), table, **truth, distance=300, incidence=incidence, azimuth=30,
                    width=width, field=pixels * pitch, resolution=(pixels, pixels),
                    camera_distance=20000,
                )
                scene["camera"]["sampler"] = {"type": "multijitter", "sample_count": 256}
                seed = incidence + degrees
                light = np.array(mi.render(scenes.load(scene), seed=seed))[..., 0]
                captures.append(
                    {
                        "image": photographed(exposure * light),
                        "floating_distance_mm": 300,
                        "incidence_deg": incidence,
                        "azimuth_deg": 30,
                        "exposure": exposure,
                    }
                )
        # The source itself: the middle of the picture, four of its pixels for one of the camera.
        middle = slice((fine - 4 * pixels) // 2, (fine + 4 * pixels) // 2)
        source = edge(5)[middle, middle].reshape(pixels, 4, pixels, 4).mean((1, 3))
        campaign = {
            "setup": {
                "pixel_pitch_mm": pitch,
                "half_mirror_transmittance": 0.5,
                "half_mirror_reflectance": 0.5,
            },
            "reference": {"image": photographed(source), "exposure": 1.0},
            "capture": captures,
        }
        result = midair.estimate(
            campaign, table, kernel="angular", lobe="radial", shared="a,c,mu", progress=False
        )
        print(result.verdict, result.c, result.data["a_times_r"], result.mu)
        a_times_r = result.data["a_times_r"]
        found = {
            "c": (result.c.value, result.c.standard_error),
            "A": (a_times_r["value"], a_times_r["standard_error"]),
            "mu": (result.mu.value, result.mu.standard_error),
        }
        for name, (value, error) in found.items():
            # Three numbers within 3.5 of their own standard errors: by chance once in 700 runs,
            # and the seeds are fixed. A useless error would be large.
            self.assertLess(abs(value - truth[name]), 3.5 * error, name)
            self.assertLess(error, 0.02 * truth[name], name)
        self.assertEqual(result.verdict, "good")
        self.tell(len(found), "parameters")

    def test_a_picture_is_that_of_render(self) -> None:
        """Camera, sheet and picture in space, by paths and by `render` with a view."""
        rows, columns, pitch, distance, far, groups, each = 48, 64, 0.1, 300.0, 600.0, 8, 256
        table, generator, cases = pair(), np.random.default_rng(1), 0
        picture = np.zeros((rows, columns), np.float32)
        picture[8:40, 10:54] = np.kron(generator.random((8, 11)) > 0.5, np.ones((4, 4)))
        numbers = {"c": 0.2, "mu": 0.5}
        for azimuth, incidence in ((0, 0), (17, 20), (77, 35)):
            given = scenes.scene(
                picture, table, **numbers, A=2100.0, distance=distance, incidence=incidence,
                azimuth=azimuth, width=columns * pitch, camera_distance=far,
            )
            # `render` takes a picture as its samples, linear between them.
            given["source"]["light"]["radiance"]["filter_type"] = "bilinear"
            scene = scenes.load(given)
            theta, phi = np.radians(incidence), np.radians(azimuth)
            along = np.array([np.cos(theta), 0, -np.sin(theta)])
            edge = np.cos(phi) * along - np.sin(phi) * np.array([0, 1, 0])
            view = self.folder / "view.toml"
            view.write_text(
                f"[camera]\nposition_mm = [0, 0, {far}]\n"
                f"[image]\ncentre_mm = [0, 0, 0]\nright = [1, 0, 0]\ndown = [0, -1, 0]\n"
                f"pixel_pitch_mm = {pitch}\n"
                f"[sheet]\nposition_mm = [0, 0, {-distance}]\nseen_in_mirror = false\n"
                f"normal = [{np.sin(theta)}, 0, {np.cos(theta)}]\n"
                f"first_edge = [{edge[0]}, {edge[1]}, {edge[2]}]\n"
            )
            sheet = midair.sheet(table, **numbers, a_times_r=2100.0, half_mirror=0.25)
            truth = sheet.render(picture, view=view, tolerance=0.001).astype(float)
            seen = np.stack([self.paths(scene, seed, each, rows, columns, pitch, far, distance)
                             for seed in range(groups)])
            variance = seen.var(0, ddof=1) / groups
            apart, white = seen.mean(0) - truth, 0.5 * 0.25 * table.eta_at(incidence, azimuth)
            # The rms of 3072 pixels varies by 1 / sqrt(2 * 3072) = 0.013; 1.1 is asked.
            self.assertLess(np.sqrt((apart**2).mean() / variance.mean()), 1.1)
            # 48 blocks of 64 pixels: 4 standard errors each, and 0.001 of white that the tolerance
            # of `render` allows; 6 M paths leave a noise of 0.0007.
            blocks = apart.reshape(rows // 8, 8, columns // 8, 8).mean((1, 3)) / white
            noise = np.sqrt(variance.reshape(rows // 8, 8, columns // 8, 8).mean((1, 3)) / 64)
            np.testing.assert_array_less(np.abs(blocks), 4 * noise / white + 0.001)
            total = np.sqrt(variance.sum()) / truth.sum()
            self.assertLess(abs(seen.mean(0).sum() / truth.sum() - 1), 4 * total + 0.0005)
            print(f"{incidence} degrees: blocks {np.abs(blocks).max():.4f} of white,",
                  f"noise {noise.max() / white:.4f}, total {apart.sum() / truth.sum():.5f}")
            cases += 1
        self.tell(cases, "directions")

    def paths(
        self, scene: object, seed: int, each: int, rows: int, columns: int, pitch: float,
        far: float, distance: float,
    ) -> np.ndarray:
        """Return the light of rays through the middles of pixels, as `render` samples them."""
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(seed, rows * columns * each)
        pixel = dr.arange(mi.UInt32, rows * columns * each) // each
        x = (mi.Float(pixel % columns) + 0.5 - columns / 2) * pitch
        y = -(mi.Float(pixel // columns) + 0.5 - rows / 2) * pitch
        origin = mi.Point3f(0, 0, distance / 2 + far)
        ray = mi.Ray3f(origin, dr.normalize(mi.Point3f(x, y, distance / 2) - origin))
        light = scene.integrator().sample(scene, sampler, mi.RayDifferential3f(ray))[0]
        return np.array(dr.block_sum(light.x, each), np.float64).reshape(rows, columns) / each


if __name__ == "__main__":
    unittest.main()
