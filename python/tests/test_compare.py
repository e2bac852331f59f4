"""Photographs registered and compared: against planted places, and closed forms of the light.

The pictures are boards of rectangles, each blurred by a Gaussian. Their light at any point is a
product of error functions, so a photograph turned, magnified and shifted is computed without
interpolation.
"""

from __future__ import annotations

import importlib.util
import math
import unittest
import warnings
from collections.abc import Callable
from typing import Any

import midair
import numpy as np
from common import CAMPAIGN, Case, quiet

PACKAGES = ("scipy", "skimage", "flip_evaluator")
#: Columns and rows of renders, and the standard deviation of their blur, pixels.
SIZE = (240, 180)
BLUR = 2.5
#: Place of a photograph that is the render: shift, scale and rotation.
STRAIGHT = (0.0, 0.0, 1.0, 0.0)
FULL_WELL, READ_NOISE = 20_000, 3  # electrons

Light = Callable[[np.ndarray, np.ndarray], np.ndarray]


def erf(x: np.ndarray) -> np.ndarray:
    """Return the error function by Abramowitz and Stegun 7.1.26, whose error is below 1.5e-7."""
    t = 1 / (1 + 0.3275911 * np.abs(x))
    series = 0.254829592 + t * (-0.284496736 + t * (1.421413741 + t * (-1.453152027)))
    rest = t * (series + t**4 * 1.061405429) * np.exp(-x * x)
    return np.sign(x) * (1 - rest)


def board(seed: int, blur: float) -> Light:
    """Return the light of a board at places from its centre, pixels of the render: text-like bars
    and a few large signs, blurred by a standard deviation of `blur` pixels."""
    random = np.random.default_rng(seed)
    width, height = SIZE
    rectangles = [(-0.42 * width, 0.42 * width, -0.4 * height, 0.4 * height, [0.02, 0.3, 0.08])]
    for row in np.arange(-0.33 * height, 0.3 * height, 22):
        left = -0.38 * width
        while left < 0.34 * width:
            size = random.uniform(3, 16)
            tall = random.choice([4, 9, 15])
            colour = random.choice([[0.6, 0.4, 0.6], [0.6, 0.3, -0.05]])
            rectangles.append((left, left + size, row, row + tall, list(colour)))
            left += size + random.uniform(3, 9)

    def light(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        made = np.zeros((*x.shape, 3))
        by, far = math.sqrt(2) * blur, 6 * blur
        for left, right, top, bottom, colour in rectangles:
            near = (x > left - far) & (x < right + far) & (y > top - far) & (y < bottom + far)
            u, v = x[near], y[near]
            across = erf((u - left) / by) - erf((u - right) / by)
            down = erf((v - top) / by) - erf((v - bottom) / by)
            made[near] += 0.25 * (across * down)[:, None] * colour
        return made

    return light


def seen(light: Light, size: tuple[int, int], place: tuple[float, ...]) -> np.ndarray:
    """Return the light on the pixels of a photograph of columns and rows, at shift (right, down),
    scale and rotation (degrees)."""
    right, down, scale, turn = place
    y, x = np.mgrid[0 : size[1], 0 : size[0]].astype(float)
    x, y = x - 0.5 * (size[0] - 1) - right, y - 0.5 * (size[1] - 1) - down
    cosine, sine = (f(math.radians(turn)) / scale for f in (math.cos, math.sin))
    return light(cosine * x + sine * y, cosine * y - sine * x)


def photograph(light: np.ndarray, exposure: float, random: np.random.Generator) -> np.ndarray:
    """Return a photograph of light, with the noise of photons and of the camera."""
    electrons = random.poisson(np.maximum(exposure * light * FULL_WELL, 0))
    return (electrons + READ_NOISE * random.standard_normal(light.shape)) / FULL_WELL


def drawn(random: np.random.Generator) -> tuple[float, ...]:
    """Return a place: shift of up to 15 pixels, scale 0.7 to 1.6, rotation of up to 8 degrees."""
    shift = random.uniform(-15, 15, 2)
    return (*shift, math.exp(random.uniform(math.log(0.7), math.log(1.6))), random.uniform(-8, 8))


def network() -> Any:
    """Return LPIPS by seeded weights, so that nothing is downloaded; None without its packages."""
    if any(importlib.util.find_spec(name) is None for name in ("torch", "lpips")):
        return None
    import lpips
    import torch

    torch.manual_seed(1)
    return lpips.LPIPS(net="alex", pretrained=False, pnet_rand=True, verbose=False).eval()


@unittest.skipIf(
    any(importlib.util.find_spec(name) is None for name in PACKAGES),
    "midair[evaluate] is not installed",
)
class Compare(Case):
    def setUp(self) -> None:
        super().setUp()
        catch = warnings.catch_warnings()
        catch.__enter__()
        self.addCleanup(catch.__exit__, None, None, None)
        warnings.simplefilter("ignore")
        self.network = network()

    def test_places_are_found_within_their_errors(self) -> None:
        random = np.random.default_rng(5)
        deviations, residuals = [], []
        for seed in range(12):
            place = drawn(random)
            # From parts of the board to wide surroundings.
            wide = random.uniform(0.8, 1.8) * place[2]
            size = (int(SIZE[0] * wide), int(SIZE[1] * wide))
            # Every second photograph is less sharp than the render, as by a model that is wrong.
            light = seen(board(seed, BLUR * (1.25 if seed % 2 else 1.0)), size, place)
            taken = photograph(light, 0.8, random)
            found = midair.register(seen(board(seed, BLUR), SIZE, STRAIGHT), taken)
            values = [*found.shift_px, found.scale, found.rotation_deg]
            errors = [*found.shift_error_px, found.scale_error, found.rotation_error_deg]
            deviations.append((np.array(values) - place) / errors)
            residuals.append(found.residual_px / found.noise_px)
            self.assertLess(max(found.shift_error_px), 0.01)
            self.assertGreater(found.correlation, 0.98)
        # The mean square of 48 deviations by Gauss is 1 with a standard error of (2/48)^0.5 = 0.2;
        # errors from 64 tiles add 2/63 of it, and the blur that differs adds 2e-3 pixels at the
        # rim. Four such errors are allowed.
        rms = float(np.sqrt(np.mean(np.square(deviations))))
        most = float(np.abs(deviations).max())
        print(f"deviations: rms {rms:.2f}, most {most:.2f}; residuals {np.max(residuals):.2f}")
        self.assertTrue(0.4 < rms < 1.35 and most < 4, (rms, most))
        # What is left in 64 tiles, two axes each, is that of noise within (2/128)^0.5 / 2 = 6 %,
        # and that of the difference of the blur.
        self.assertLess(max(residuals[::2]), 1.25)
        self.tell(len(deviations), "photographs")

    def test_scores_are_those_of_aligned_pictures(self) -> None:
        random = np.random.default_rng(8)
        worst: dict[str, float] = {}
        count = 0
        for seed in range(6):
            place = drawn(random)
            size = (int(SIZE[0] * place[2] * 1.1), int(SIZE[1] * place[2] * 1.1))
            taken = photograph(seen(board(seed, BLUR), size, place), 0.8, random)
            # Models: the truth, one too sharp, one too soft and too bright.
            models = {"a": (BLUR, 1.0), "b": (0.8 * BLUR, 1.0), "c": (1.3 * BLUR, 1.1)}
            renders = {
                name: light * seen(board(seed, blur), SIZE, STRAIGHT)
                for name, (blur, light) in models.items()
            }
            shot = midair.Shot("A", 150, "board", taken, renders, exposure=0.8)
            made = midair.compare([shot], reference=1.0, network=self.network)
            region = made.registrations["A", 150, "board"].region
            self.assertGreater(taken[region].size, 0.55 * 3 * SIZE[0] * SIZE[1] * place[2] ** 2)
            for name, (blur, light) in models.items():
                # The same model, computed on the pixels of the photograph.
                aligned = 0.8 * light * seen(board(seed, blur), size, place)
                own = midair.evaluate(aligned[region], taken[region], network=self.network)
                found = made.scores["A", 150, name, "board"]
                for score in ("psnr_db", "ssim", "flip", "lpips"):
                    expected, value = getattr(own, score), getattr(found, score)
                    self.assertEqual(value is None, expected is None, score)
                    if value is not None:
                        change = abs(value / expected - 1)
                        worst[score] = max(worst.get(score, 0.0), change)
                        self.assertLess(change, 0.02, (seed, name, score))
                        count += 1
        print({score: round(change, 5) for score, change in worst.items()})
        self.assertGreaterEqual(count, 6 * 3 * 3)
        self.tell(count, "scores")

    def test_exposure_is_that_of_the_reference_or_of_least_squares(self) -> None:
        light = seen(board(1, BLUR), SIZE, STRAIGHT)
        taken = photograph(light, 0.5, np.random.default_rng(2))
        renders = {"right": light, "bright": 1.5 * light}
        shots = [midair.Shot("A", 150, "board", taken, renders, exposure=5.0)]
        known = midair.compare(shots, reference=0.1, network=self.network).scores
        free = midair.compare(shots, network=self.network).scores
        psnr = [
            [one["A", 150, name, "board"].psnr_db for name in renders] for one in (known, free)
        ]
        # Too much light costs: the values differ by a third. By least squares it does not.
        self.assertGreater(psnr[0][0], psnr[0][1] + 10)
        self.assertAlmostEqual(psnr[1][0], psnr[1][1], delta=1e-4)
        self.assertAlmostEqual(psnr[0][0], psnr[1][0], delta=0.05)
        # A photograph of the edge stands for the step between its sides.
        source = CAMPAIGN.parent / "source.exr"
        white = midair.measure(source).contrast
        one, other = (
            midair.compare(shots, reference=own, network=self.network) for own in (source, white)
        )
        self.assertEqual(one.scores, other.scores)
        self.assertTrue(0.1 < white < 1, white)
        with self.assertRaisesRegex(midair.Error, "A, 150 mm, board"):
            midair.compare([midair.Shot("A", 150, "board", taken, renders)], reference=0.1)

    def test_the_table_has_a_row_for_each_model(self) -> None:
        light = seen(board(1, BLUR), SIZE, STRAIGHT)
        random = np.random.default_rng(2)
        shots = [
            midair.Shot(sheet, distance, name, photograph(light, 0.5, random), renders)
            for sheet in "AB"
            for distance, name in ((150, "board"), (300, "board"), (300, "sign"))
            for renders in [{"one": light, "two": seen(board(1, 2 * BLUR), SIZE, STRAIGHT)}]
        ]
        made = midair.compare(shots, network=lambda *_: 1 / 0)
        lines = str(made).splitlines()
        self.assertEqual(lines[0].count("|"), 1 + 3 + 2 * 4)
        rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines[2:10]]
        self.assertEqual(
            [row[:3] for row in rows],
            [[s, f"{d} mm", m] for s in "AB" for d in (150, 300) for m in ("one", "two")],
        )
        # The right model is best everywhere; LPIPS is missing, and so is the sign at 150 mm.
        for row in rows:
            shown = 3 if row[1] == "150 mm" else 6
            self.assertEqual(sum("**" in cell for cell in row), shown * (row[2] == "one"), row)
            self.assertEqual(row.count("-"), 8 - shown, row)
        self.assertEqual(sum("LPIPS is left out" in note for note in made.notes), 1)
        csv = made.csv().splitlines()
        self.assertEqual([len(csv), csv[1].split(",")[-1]], [1 + 12, ""])
        self.tell(len(rows), "rows")

    def test_what_cannot_be_registered_is_refused(self) -> None:
        random = np.random.default_rng(4)
        light = seen(board(1, BLUR), SIZE, STRAIGHT)
        others = [
            light[::-1],  # upside down
            light[:, ::-1],  # mirrored
            np.moveaxis(light, 0, 1),  # lying
            seen(board(9, BLUR), SIZE, STRAIGHT)[20:-20, 20:-20],  # another board
            random.uniform(size=(180, 240)),  # noise
            np.ones((180, 240)),
            light[:12, :12],
        ]
        for other in others:
            with self.assertRaises(midair.Error):
                midair.register(light, other)
        renders = {"one": light, "two": light[1:]}
        with self.assertRaisesRegex(midair.Error, "differ in size"):
            midair.compare([midair.Shot("A", 150, "board", light, renders)])
        self.tell(len(others), "pictures")


class Camera(Case):
    """The blur of the camera in a render. Needs no more than the package."""

    def setUp(self) -> None:
        super().setUp()
        table = midair.trace(midair.design("triangular-pair"), refractive_index=1.49, azimuth=30)
        self.result = quiet(midair.estimate, CAMPAIGN, table)
        self.place = {"distance": 150, "incidence": 20, "azimuth": 30}
        catch = warnings.catch_warnings()
        catch.__enter__()
        self.addCleanup(catch.__exit__, None, None, None)
        warnings.simplefilter("ignore")

    def test_a_camera_multiplies_the_transform_by_its_lens_and_pixel(self) -> None:
        camera = self.result.data["camera"]
        # A sheet so sharp that the camera decides.
        sheet = midair.sheet(self.result.table, c=0.03, a=50, mu=1)
        point = np.zeros((256, 256))
        point[128, 128] = 1.0
        compared = 0
        for pitch in (0.05, 0.02):
            without, seen = (
                np.fft.rfft2(sheet.render(point, pixel_pitch=pitch, camera=one, **self.place))
                for one in (None, self.result)
            )
            y, x = np.meshgrid(np.fft.fftfreq(256), np.fft.rfftfreq(256), indexing="ij")
            frequency = np.hypot(x, y) / pitch
            lens = np.exp(-((frequency * camera["lens_blur_mm"]) ** camera["lens_exponent"]))
            wide = camera["pixel_pitch_mm"] / pitch
            pixel = np.sinc(wide * x) * np.sinc(wide * y) / (np.sinc(x) * np.sinc(y))
            # Higher frequencies that look alike on whole pixels have less than 1 % of the light up
            # to a quarter of the sampling frequency: both factors sinc are below 0.3 x 0.3 there.
            used = np.maximum(np.abs(x), np.abs(y)) < 0.25
            whole = np.abs(without).max()
            error = np.abs(seen - without * lens * pixel)[used].max() / whole
            off = np.abs(seen - without)[used].max() / whole
            print(f"pitch {pitch}: error {error:.5f}, without the camera {off:.3f}")
            self.assertLess(error, 0.01)
            self.assertGreater(off, 0.1)
            compared += np.count_nonzero(used)
        self.tell(compared, "frequencies")

    def test_cameras_that_cannot_be_used_are_refused(self) -> None:
        light = np.ones((40, 40))
        cases = [
            {"camera": midair.sheet(sheet="prism-0.1")},
            {"camera": "none.json"},
            {"camera": self.result, "forward": "render"},
        ]
        for case in cases:
            with self.assertRaises(midair.Error):
                self.result.render(light, **self.place, **case)
        file = self.folder / "camera.json"
        self.result.save(file)
        cameras = (self.result, file)
        own, read = (self.result.render(light, **self.place, camera=one) for one in cameras)
        self.assertTrue(np.array_equal(own, read))
        self.tell(len(cases), "refusals")

    def test_each_colour_of_a_dispersive_sheet_has_a_table(self) -> None:
        pair = midair.design("triangular-pair")
        tables = [
            midair.trace(pair, refractive_index=index, incidence=20, azimuth=30)
            for index in (1.58, 1.588, 1.604)
        ]
        white = np.zeros((60, 60, 3))
        white[20:40, 20:40] = 1
        grey = white[..., 0]
        sheet = midair.sheet(tables[1], c=0.2, a=4)
        image = sheet.render(white, pixel_pitch=0.1, table=tables, **self.place)
        for k, table in enumerate(tables):
            own = midair.sheet(table, c=0.2, a=4).render(grey, pixel_pitch=0.1, **self.place)
            self.assertTrue(np.array_equal(image[..., k], own))
        for wrong in (tables[:2], []):
            with self.assertRaises(midair.Error):
                sheet.render(white, pixel_pitch=0.1, table=wrong, **self.place)
        self.tell(len(tables), "colours")


if __name__ == "__main__":
    unittest.main()
