"""Names: every option of a program has its keyword, and every example has its types."""

from __future__ import annotations

import importlib.util
import inspect
import pkgutil
import re
import subprocess
import sys
import unittest
from collections.abc import Callable

import midair
from common import ROOT, Case, run

#: Options that mean something at a command line only.
OF_A_SHELL = {"output", "json", "help", "list", "plot", "report", "resume", "save_every", "truth"}
#: Keywords that a program has not.
OF_PYTHON = {"folder", "progress", "table", "result"}
#: Options that a prediction in Python does not need.
OF_PREDICT = {"against", "channel", "floating_distance", "model"}
#: Options of a sheet without a fit, which are the keywords of `midair.sheet`.
OF_A_SHEET = {
    "a",
    "a_times_r",
    "angular_spread_mrad",
    "c",
    "half_mirror",
    "kernel",
    "mu",
    "setup",
    "sheet",
    "wavelength_nm",
}
#: Options that stand first in Python, without a keyword of their own name.
FIRST = {"captures", "goal", "mesh", "image", "params", "plan", "name", "second", "source"}


class Signatures(Case):
    def test_keywords_are_the_options_of_the_programs(self) -> None:
        verbs: list[tuple[Callable[..., object], str, str, set[str]]] = [
            (midair.design, "bake", "design", set()),
            (midair.trace, "bake", "trace", set()),
            (midair.measure, "fit", "mtf", set()),
            (midair.estimate, "fit", "estimate", set()),
            (midair.plan, "fit", "plan", set()),
            (midair.simulate, "fit", "simulate", set()),
            (midair.datasheet, "bake", "datasheet", set()),
            (midair.optimise, "bake", "optimise", set()),
            (midair.study, "fit", "study", set()),
            # Pictures against a quantity are a matter of xarray in Python, model and channel are
            # those of the result, and --floating-distance is another name of --distance.
            (midair.Result.predict, "fit", "predict", OF_PREDICT | OF_A_SHEET),
            (midair.Result.render, "fit", "render", OF_PREDICT | OF_A_SHEET | {"beside"}),
            (midair.Result.explore, "fit", "explore", OF_PREDICT | OF_A_SHEET),
        ]
        compared = 0
        sheet = set(inspect.signature(midair.sheet).parameters)
        self.assertEqual(sheet, OF_A_SHEET | {"table", "pixel_pitch"})
        for function, program, verb, left_out in verbs:
            told = run(program, "completions", "bash").stdout
            found = re.search(rf'{program}__(?:subcmd__)?{verb}\)\s+opts="([^"]*)"', told)
            assert found, verb
            options = set(re.findall(r"--([a-z][a-z-]*)", found[1]))
            wanted = {option.replace("-", "_") for option in options}
            parameters = inspect.signature(function).parameters.values()
            keywords = {
                one.name for one in parameters if one.kind is not one.VAR_KEYWORD
            } - FIRST - {"self", "picture", "frequency"} | (wanted & {"frequency"})
            missing = wanted - keywords - OF_A_SHELL - left_out - FIRST - {"table"}
            self.assertEqual(missing, {"params"} & missing, (verb, "has no keyword"))
            self.assertLessEqual(keywords - wanted, OF_PYTHON | OF_A_SHELL, verb)
            compared += len(wanted)
        self.tell(compared, "options")

    def test_no_default_stands_in_python(self) -> None:
        cases = 0
        verbs = (
            midair.datasheet,
            midair.design,
            midair.estimate,
            midair.measure,
            midair.optimise,
            midair.plan,
            midair.study,
            midair.trace,
        )
        for function in verbs:
            for one in inspect.signature(function).parameters.values():
                if one.kind is one.KEYWORD_ONLY:
                    self.assertIn(one.default, (None, False, one.empty), one.name)
                    cases += 1
        self.tell(cases, "keywords")

    def test_everything_public_is_described(self) -> None:
        cases = 0
        for name in midair.__all__:
            thing = getattr(midair, name)
            if name == "__version__":
                continue
            self.assertTrue(inspect.getdoc(thing), name)
            cases += 1
            if inspect.isclass(thing):
                for member, value in vars(thing).items():
                    described = callable(value) or isinstance(value, property)
                    if described and not member.startswith("_"):
                        self.assertTrue(inspect.getdoc(value), f"{name}.{member}")
                        cases += 1
        self.tell(cases, "names")

    def test_the_types_are_right(self) -> None:
        if importlib.util.find_spec("mypy") is None:
            self.skipTest("mypy is not installed")
        files = [ROOT / "python" / "tests" / "examples.py"]
        mypy = [sys.executable, "-m", "mypy", "--strict", "--config-file=", "--no-incremental"]
        # midair.mitsuba derives from classes of a package that most people do not install.
        has_mitsuba = importlib.util.find_spec("mitsuba") is not None
        modules = ["midair"] + [
            f"midair.{one.name}"
            for one in pkgutil.iter_modules(midair.__path__)
            if has_mitsuba or one.name != "mitsuba"
        ]
        for what in ([word for name in modules for word in ("-m", name)], files):
            done = subprocess.run(
                [*mypy, *what], capture_output=True, text=True, check=False, cwd=self.folder
            )
            self.assertEqual(done.returncode, 0, done.stdout)
        self.tell(1 + len(files), "runs of mypy")


if __name__ == "__main__":
    unittest.main()
