"""The package against the programs: the same numbers, the same bytes, the same sentences."""

from __future__ import annotations

import json
import re
import unittest
import warnings
from typing import Any

import midair
import numpy as np
from common import CAMPAIGN, EDGE, ROOT, Case, quiet, read_exr, refusal, run
from midair._words import in_python


class Bytes(Case):
    def test_tables_and_meshes_have_the_bytes_of_the_programs(self) -> None:
        cases: list[tuple[str, dict[str, Any], dict[str, Any]]] = [
            ("triangular", {}, {"refractive_index": 1.49}),
            ("triangular-pair", {"edge_length": 0.18}, {"incidence": [0, 20], "azimuth": "full"}),
            (
                "triangular-pair",
                {"dihedral_error_mrad": [0.5, 0, -0.3]},
                {"method": "rays", "rays": 4096, "sampler": "random", "seed": 7},
            ),
            ("full-cube", {}, {"incidence": "0:40:20", "azimuth": 10, "losses": "fresnel"}),
            ("canted", {"cant_deg": -5.0}, {"azimuth": "mean", "incidence": 10}),
            (
                "triangular",
                {"sag": 1e-4, "segments": 4},
                {"normals": "file", "rays": 1000, "incidence": 0.0},
            ),
            ("plate", {"depth": 2.5}, {"element": "plate", "azimuth": -45, "incidence": 30}),
        ]
        for name, shape, options in cases:
            with self.subTest(name), warnings.catch_warnings():
                warnings.simplefilter("ignore")
                mesh = midair.design(name, **shape)
                mesh.save(self.folder / "python.obj")
                run("bake", "design", name, "-o", self.folder / "mesh.obj", *flags(shape))
                self.assertEqual(
                    (self.folder / "python.obj").read_bytes(),
                    (self.folder / "mesh.obj").read_bytes(),
                )
                of_memory = midair.trace(mesh, self.folder / "memory.h5", **options)
                midair.trace(self.folder / "mesh.obj", **options).save(self.folder / "file.h5")
                table, obj = self.folder / "table.h5", self.folder / "mesh.obj"
                run("bake", "trace", obj, "-o", table, *flags(options))
                for other in ("memory.h5", "file.h5"):
                    same = (self.folder / other).read_bytes() == table.read_bytes()
                    self.assertTrue(same, (name, other))
                again = midair.open(table)
                self.assertEqual(again.content_hash, of_memory.content_hash)
                np.testing.assert_array_equal(again.histogram, of_memory.histogram)
        self.tell(len(cases), "cells")

    def test_a_mesh_of_arrays_is_the_mesh_of_its_file(self) -> None:
        pair = midair.design("triangular-pair")
        made = midair.Mesh(pair.vertices, pair.faces, design="triangular-pair")
        a, b = (midair.trace(mesh, refractive_index=1.5, incidence=20) for mesh in (pair, made))
        np.testing.assert_array_equal(a.histogram, b.histogram)


def page_data(page: str) -> dict[str, Any]:
    """Return what a page with sliders holds."""
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.S)
    assert found
    data: dict[str, Any] = json.loads(found[1])
    return data


class Numbers(Case):
    def setUp(self) -> None:
        super().setUp()
        self.table = midair.trace(
            midair.design("triangular-pair"),
            self.folder / "pair.h5",
            refractive_index=1.49,
            incidence="0:45:5",
            azimuth=30,
        )

    def test_measurements(self) -> None:
        cases = 0
        given: list[dict[str, Any]] = [
            {},
            {"pixel_pitch": 0.05, "at": [0.5, 1.0]},
            {"roi": [100, 60, 140, 120], "channel": "luminance"},
        ]
        for options in given:
            told = json.loads(run("fit", "mtf", EDGE, "--json", *flags(options)).stdout)
            edge = midair.measure(EDGE, **options)
            self.assertEqual(edge.data, told)
            np.testing.assert_array_equal(edge.mtf, told["mtf"])
            cases += 1
        self.tell(cases, "measurements")

    def test_estimates_and_what_follows_from_them(self) -> None:
        file = self.folder / "result.json"
        given: list[dict[str, Any]] = [
            {},
            {"kernel": "eq1", "lobe": "radial", "per_angle": ["a", "mu"], "loss": "mtf"},
            {"kernel": "eq1", "threads": 1, "loss": "mse"},
        ]
        for options in given:
            run(
                "fit", "estimate", CAMPAIGN, "--table", self.folder / "pair.h5", "-o", file,
                *flags(options),
            )  # fmt: skip
            result = quiet(midair.estimate, CAMPAIGN, self.folder / "pair.h5", **options)
            told = json.loads(file.read_text())
            self.assertEqual(timeless(result.data), timeless(told))
            self.assertEqual(timeless(json.loads(result.to_json())), timeless(told))
        self.tell(len(given), "estimates")

    def test_numbers_of_each_angle_or_distance(self) -> None:
        number = {"value": 0.5, "standard_error": 0.25}
        written = [
            (number, "0.5 ± 0.25"),
            ({"per_angle": [{"incidence_deg": 20, **number}]}, "0.5 ± 0.25 at 20°"),
            ({"per_distance": [{"floating_distance_mm": 150, **number}]}, "0.5 ± 0.25 at 150 mm"),
        ]
        for given, expected in written:
            self.assertEqual(str(midair.Estimate._of(given)), expected)
        apart = midair.Estimate._of(written[2][0])
        assert apart is not None
        self.assertEqual(apart.per_distance, {150: (0.5, 0.25)})
        self.tell(len(written), "forms")

    def test_predictions(self) -> None:
        file = self.folder / "result.json"
        result = quiet(midair.estimate, CAMPAIGN, self.table)
        result.save(file)
        told = run(
            "fit", "predict", file, "--table", self.folder / "pair.h5", "--distance", "150,300",
            "--incidence", "0:40:20", "--frequency", "0:2:0.5", "--json",
        )  # fmt: skip
        made = quiet(result.predict, [150, 300], [0, 20, 40], frequency="0:2:0.5")
        cases = 0
        for prediction in json.loads(told.stdout)["predictions"]:
            at = made.sel(
                floating_distance_mm=prediction["floating_distance_mm"],
                incidence_deg=prediction["incidence_deg"],
                axis=prediction["axis"],
            ).squeeze()
            np.testing.assert_array_equal(at.mtf, prediction["mtf"])
            np.testing.assert_array_equal(
                np.stack([at.mtf_low, at.mtf_high], -1), prediction["mtf_interval"]
            )
            self.assertEqual(float(at.luminance), prediction["luminance"])
            cases += 1
        self.assertEqual(cases, 2 * 3 * 2)
        loaded = quiet(midair.load, file, self.table)
        np.testing.assert_array_equal(
            quiet(loaded.predict, 300, 20).mtf, quiet(result.predict, 300, 20).mtf
        )
        with self.assertRaises(midair.Error):
            loaded.report()
        self.assertIn("<html", result.report().html)
        self.assertIn("srcdoc", result.report()._repr_html_())
        self.assertIn("<table>", result._repr_html_())
        self.tell(cases, "predictions")

    def test_images(self) -> None:
        result = quiet(midair.estimate, CAMPAIGN, self.table)
        result.save(self.folder / "result.json")
        sign = ROOT / "doc" / "sign.png"
        source, cases = quiet(midair.picture, sign), 0
        options: dict[str, Any]
        for options in (
            {"distance": 300, "incidence": 20, "pixel_pitch": 0.1, "exposure": 15.0},
            {"distance": 150.0, "incidence": 0, "ambient": 0.01},
            {"distance": 150, "incidence": 10, "forward": "render", "samples": 4, "seed": 3},
        ):
            out = self.folder / "aerial.exr"
            run(
                "fit", "render", "--source", sign, "--params", self.folder / "result.json",
                "--table", self.folder / "pair.h5", "-o", out, *flags(options),
            )  # fmt: skip
            made = quiet(result.render, source, **options)
            np.testing.assert_array_equal(made, read_exr(out))
            self.assertEqual(made.shape, source.shape)
            cases += 1
        grey = source if source.ndim == 2 else source[:, :, 1]
        made = quiet(result.render, grey, 150, 0)
        self.assertEqual(made.shape, grey.shape)
        self.tell(cases, "images")

    def test_pages_with_sliders(self) -> None:
        result = quiet(midair.estimate, CAMPAIGN, self.table)
        result.save(self.folder / "result.json")
        sign, cases = ROOT / "doc" / "sign.png", 0
        options = {"distance": 400, "incidence": 12, "farthest": 900}
        for source in (None, sign):
            page = self.folder / "explore.html"
            run(
                "fit", "explore", self.folder / "result.json", "--table", self.folder / "pair.h5",
                "-o", page, *flags(options), *([] if source is None else ["--source", source]),
            )  # fmt: skip
            picture = None if source is None else quiet(midair.picture, source)
            made = quiet(result.explore, picture, **options)
            told, own = (page_data(text) for text in (page.read_text(), made.html))
            # A result in memory has no file name, and neither has a picture.
            for data in (told, own):
                data.pop("title")
                if data["source"]:
                    data["source"].pop(0)
            self.assertEqual(own, told)
            self.assertEqual(bool(own["source"]), source is not None)
            cases += 1
        with self.assertRaisesRegex(midair.Error, "incidence"):
            result.explore(incidence=80)
        self.tell(cases, "pages")

    def test_sheets_without_a_fit(self) -> None:
        picture = np.zeros((40, 60), np.float32)
        picture[10:30, 20:40] = 0.5
        cases: list[dict[str, Any]] = [
            {"wavelength_nm": 550, "mu": 0.5},
            {"a": 4.0, "half_mirror": 0.2, "mu": 0.3},
            {"a_times_r": 600.0},
        ]
        for options in cases:
            told = run(
                "fit", "predict", "--c", "0.2", *flags(options), "--table",
                self.folder / "pair.h5", "--distance=300", "--incidence=20", "--json",
            )  # fmt: skip
            told = json.loads(told.stdout)["predictions"]
            sheet = midair.sheet(self.table, c=0.2, pixel_pitch=0.1, **options)
            made = quiet(sheet.predict, 300, 20)
            for index, axis in enumerate(("tangential", "sagittal")):
                at = made.sel(axis=axis).squeeze()
                np.testing.assert_array_equal(at.mtf, told[index]["mtf"])
            image = quiet(sheet.render, picture, 300, 20, auto_exposure=True)
            self.assertAlmostEqual(float(image.max()), 0.5, delta=1e-6)
        told = run(
            "fit", "predict", "--sheet=published", "--distance=300", "--incidence=20", "--json"
        )  # fmt: skip
        told = json.loads(told.stdout)["predictions"]
        made = quiet(quiet(midair.sheet, sheet="published", pixel_pitch=0.1).predict, 300, 20)
        np.testing.assert_array_equal(made.sel(axis="tangential").squeeze().mtf, told[0]["mtf"])
        with self.assertRaisesRegex(midair.Error, "prism-0.1"):
            midair.sheet(sheet="prism")
        with self.assertRaises(TypeError):
            midair.sheet(c=0.2)
        with self.assertRaises(midair.Error):
            midair.sheet(self.table, c=0.2)
        with self.assertRaisesRegex(midair.Error, "pixel_pitch"):
            midair.sheet(self.table, c=0.2, a=4.0).render(picture, 300, 20)
        self.tell(len(cases), "sheets")

    def test_campaigns_and_studies(self) -> None:
        params = self.folder / "params.toml"
        params.write_text(PARAMS)
        run("fit", "simulate", params, "-o", self.folder / "program")
        manifest = midair.simulate(params, self.folder / "python")
        self.assertEqual(manifest, str(self.folder / "python" / "captures.toml"))
        files = sorted(path.name for path in (self.folder / "program").iterdir())
        for name in files:
            one, other = (self.folder / folder / name for folder in ("program", "python"))
            self.assertEqual(one.read_bytes(), other.read_bytes(), name)
        ranges = ROOT / "fit" / "doc" / "ranges.toml"
        options = {"table": self.folder / "pair.h5", "ranges": ranges, "campaigns": 2, "seed": 5}
        told = json.loads(run("fit", "study", *flags(options), "--json").stdout)
        self.assertEqual(timeless(midair.study(**options)), timeless(told))
        self.tell(len(files), "files of a campaign, and a study")


class Answers(Case):
    def test_data_sheets(self) -> None:
        files = [self.folder / f"{name}.obj" for name in ("pair", "other")]
        meshes = [midair.design("triangular-pair"), midair.design("canted", cant_deg=5.0)]
        for mesh, file in zip(meshes, files, strict=True):
            mesh.save(file)
        options = {"refractive_index": 1.49, "cells": 2, "step": 10, "incidence": [0, 20]}
        for count in (1, 2):
            printed = run("bake", "datasheet", *files[:count], "--json", *flags(options)).stdout
            of_memory = quiet(midair.datasheet, *meshes[:count], **options)
            of_files = quiet(midair.datasheet, *files[:count], **options)
            self.assertEqual(of_files.data, json.loads(printed))
            self.assertIn("Data sheet", of_memory.html)
            self.assertEqual(nameless(of_memory.data), nameless(of_files.data))
        self.tell(4, "data sheets")

    def test_the_best_cell(self) -> None:
        goal, file = self.folder / "goal.toml", self.folder / "best.obj"
        text = (ROOT / "bake" / "doc" / "goal.toml").read_text()
        goal.write_text("cells = 200\n" + text)
        printed = json.loads(run("bake", "optimise", goal, "-o", file, "--json").stdout)
        best = quiet(midair.optimise, goal)
        told = {"seconds", "mesh"}
        self.assertEqual(
            {name: own for name, own in best.data.items() if name not in told},
            {name: own for name, own in printed.items() if name not in told},
        )
        best.mesh.save(self.folder / "python.obj")
        self.assertEqual((self.folder / "python.obj").read_bytes(), file.read_bytes())
        best.save(self.folder / "front.svg")
        self.assertIn("<svg", (self.folder / "front.svg").read_text())
        goal.write_text("cells = 200\n" + text.replace('"both"', '"mtf"'))
        with self.assertRaises(ValueError):
            quiet(midair.optimise, goal).save(self.folder / "front.svg")

    def test_plans_of_photographs(self) -> None:
        file, manifest = self.folder / "plan.toml", self.folder / "planned.toml"
        table = midair.trace(
            midair.design("triangular-pair"),
            self.folder / "pair.h5",
            refractive_index=1.49,
            incidence="0:30:10",
            azimuth=30,
        )
        text = (ROOT / "fit" / "doc" / "plan.toml").read_text()
        file.write_text('tell_apart = ["eq1", "angular"]\n' + text)
        words = ("--table", self.folder / "pair.h5", "-o", manifest, "--json")
        printed = json.loads(run("fit", "plan", file, *words).stdout)
        planned = midair.plan(file, table)
        self.assertEqual(planned.data, printed)
        self.assertEqual(planned.manifest, manifest.read_text())
        planned.save(self.folder / "python.toml")
        self.assertEqual((self.folder / "python.toml").read_bytes(), manifest.read_bytes())
        self.assertIn('type="checkbox"', planned.report.html)
        self.assertEqual(midair.plan(file, self.folder / "pair.h5").data, printed)
        with self.assertRaises(midair.Error):
            midair.plan(self.folder / "none.toml", table)


def nameless(data: Any) -> Any:
    """Return the numbers of data sheets without the names of the meshes, which are those of files."""
    if isinstance(data, dict):
        return {key: nameless(own) for key, own in data.items() if key != "name"}
    return [nameless(own) for own in data] if isinstance(data, list) else data


class Sentences(Case):
    def test_refusals_are_those_of_the_programs(self) -> None:
        mesh, table = self.folder / "pair.obj", self.folder / "pair.h5"
        midair.design("triangular-pair").save(mesh)
        midair.trace(mesh, table, refractive_index=1.49, azimuth=30)
        broken = self.folder / "broken.toml"
        broken.write_text(CAMPAIGN.read_text().replace("pixel_pitch_mm", "pixel_pich_mm", 1))
        nothing = self.folder / "nothing.h5"
        out = self.folder / "out.h5"
        cases: list[tuple[Any, tuple[object, ...], int]] = [
            (lambda: midair.trace(nothing), ("bake", "trace", nothing, "-o", out), 1),
            (
                lambda: midair.trace(mesh, incidence=95),
                ("bake", "trace", mesh, "-o", out, "--incidence=95"),
                2,
            ),
            (
                lambda: midair.trace(mesh, method="exact", roughness=0.01),
                ("bake", "trace", mesh, "-o", out, "--method=exact", "--roughness=0.01"),
                1,
            ),
            (lambda: midair.design("cone"), ("bake", "design", "cone", "-o", out), 2),
            (lambda: midair.open(mesh), ("bake", "verify", mesh), 1),
            (lambda: midair.open(nothing), ("bake", "verify", nothing), 1),
            (lambda: midair.measure(mesh), ("fit", "mtf", mesh), 1),
            (
                lambda: midair.estimate(broken, table),
                ("fit", "estimate", broken, "--table", table),
                1,
            ),
            (
                lambda: midair.estimate(CAMPAIGN, nothing),
                ("fit", "estimate", CAMPAIGN, "--table", nothing),
                1,
            ),
            (
                lambda: midair.estimate(CAMPAIGN, table, expect_table="0" * 64),
                ("fit", "estimate", CAMPAIGN, "--table", table, "--expect-table", "0" * 64),
                1,
            ),
            (lambda: midair.load(mesh, table), ("fit", "predict", mesh, "--table", table,
             "--distance=1", "--incidence=0"), 1),
        ]  # fmt: skip
        for call, command, code in cases:
            with self.subTest(command), warnings.catch_warnings():
                warnings.simplefilter("ignore")
                with self.assertRaises(midair.Error) as caught:
                    call()
                program, *words = command
                told = refusal(str(program), *words, code=code)
                self.assertEqual(caught.exception.sentence, with_keywords(told))
                self.assertTrue(caught.exception.remedy)
        self.tell(len(cases), "refusals")

    def test_an_error_names_file_place_and_remedy(self) -> None:
        broken = self.folder / "broken.toml"
        broken.write_text(CAMPAIGN.read_text().replace("pixel_pitch_mm", "pixel_pich_mm", 1))
        table = midair.trace(midair.design("triangular-pair"), incidence=0, refractive_index=1.49)
        with self.assertRaises(midair.Error) as caught:
            midair.estimate(broken, table)
        error = caught.exception
        self.assertEqual(error.file, str(broken))
        self.assertTrue(re.fullmatch(r"line \d+", error.place or ""), error.place)
        self.assertIn("pixel_pitch_mm", error.sentence)
        with self.assertRaises(midair.Error) as caught:
            midair.trace(midair.design("triangular-pair"), incidence=95)
        self.assertEqual((caught.exception.file, caught.exception.place), (None, "incidence"))
        with self.assertRaises(TypeError):
            midair.trace(midair.design("triangular-pair"), incidense=95)  # type: ignore[call-arg]

    def test_errors_name_keywords(self) -> None:
        pair = midair.design("triangular-pair")
        table = midair.trace(pair, incidence="0:45:5", azimuth=30, refractive_index=1.49)
        picture = np.zeros((8, 8), np.float32)
        sheet = midair.sheet(table, c=0.2, a=4.0, pixel_pitch=0.1)
        cases: list[tuple[Any, str, str]] = [
            (lambda: midair.trace(pair, incidence=95), "incidence", "incidence=95"),
            (lambda: midair.trace(pair, rays=64, tolerance=0.1), "rays", "rays= and tolerance="),
            (lambda: midair.trace(pair, shard="9/8"), "shard", 'shard="9/8"'),
            (
                lambda: midair.trace(pair, method="exact", roughness=0.01),
                "method",
                'method="exact": roughness=0.01',
            ),
            (lambda: midair.trace(pair, sampler="dice"), "sampler", "'sampler='"),
            (
                lambda: midair.estimate(CAMPAIGN, table, model="guo", kernel="eq1"),
                "kernel",
                "kernel=",
            ),
            (
                lambda: midair.estimate(CAMPAIGN, table, fit_azimuth=True),
                "fit_azimuth",
                "fit_azimuth=True",
            ),
            (lambda: sheet.render(picture, 300, 20, forward="random"), "forward", "'forward='"),
        ]
        for call, keyword, named in cases:
            with self.subTest(named):
                with self.assertRaises(midair.Error) as caught:
                    quiet(call)
                self.assertIn(named, caught.exception.sentence)
                self.assertNotIn(" --", caught.exception.sentence.split("bake trace")[0])
                self.assertEqual((caught.exception.file, caught.exception.place), (None, keyword))
        # A command stays one.
        told = "bake them all: bake trace --azimuth full --seed 3; leave out --fit-azimuth"
        self.assertEqual(
            in_python(told),
            "bake them all: bake trace --azimuth full --seed 3; leave out fit_azimuth=True",
        )
        self.tell(len(cases), "errors")

    def test_warnings_are_those_of_the_program(self) -> None:
        mesh = self.folder / "pair.obj"
        midair.design("triangular-pair").save(mesh)
        told = run("bake", "trace", mesh, "-o", self.folder / "pair.h5").stderr
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            midair.trace(mesh)
        told = with_keywords(told)
        self.assertIn("refractive_index= was left out", told)
        self.assertEqual([f"warning: {one.message}" for one in caught], told.splitlines())
        self.assertTrue(all(one.category is midair.MidairWarning for one in caught))
        self.assertEqual({one.filename for one in caught}, {__file__})


def with_keywords(told: str) -> str:
    """Return sentences of this file with the keywords that stand for options in Python."""
    for option, keyword in (
        ("--incidence 95", "incidence=95"),
        ("--method exact: --roughness 0.01", 'method="exact": roughness=0.01'),
        ("--expect-table", "expect_table="),
        ("--refractive-index 1", "refractive_index=1"),
        ("--refractive-index", "refractive_index="),
    ):
        told = told.replace(option, keyword)
    return told


def flags(options: dict[str, Any]) -> list[str]:
    """Return options as a user types them."""
    made = []
    for name, value in options.items():
        if isinstance(value, list):
            value = ",".join(str(item) for item in value)
        made.append(f"--{name.replace('_', '-')}={value}")
    return made


def timeless(data: Any) -> Any:
    """Return JSON without what a clock measured."""
    if isinstance(data, dict):
        return {key: timeless(value) for key, value in data.items() if "second" not in key}
    if isinstance(data, list):
        return [timeless(item) for item in data]
    return data


PARAMS = """
seed = 7
[truth]
kernel = "eq1"
lobe = "radial"
refractive_index = 1.49
pair = true
a = 4.0
c = 0.24
mu = 0.5
[camera]
width = 160
height = 128
[reference]
[[capture]]
floating_distance_mm = 150.0
incidence_deg = 20.0
azimuth_deg = 30.0
"""

if __name__ == "__main__":
    unittest.main()
