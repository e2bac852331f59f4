"""Objects in other processes and in files: pickles, and results that are saved."""

from __future__ import annotations

import copy
import json
import multiprocessing
import pickle
from typing import Any

import numpy as np

import midair
from common import CAMPAIGN, Case, quiet, run


def looked_at(thing: Any) -> Any:
    """Return what another process sees of an object."""
    if isinstance(thing, midair.Mesh):
        return thing._mesh.hash
    if isinstance(thing, midair.Table):
        return thing.content_hash, thing._table.name
    return thing.to_json(), thing.table.content_hash, quiet(thing.predict, 300, 20).mtf.values


def refused(incidence: float) -> midair.Table:
    """Raise an error in another process."""
    return midair.trace(midair.design("triangular"), incidence=incidence)


class Pickles(Case):
    def setUp(self) -> None:
        super().setUp()
        self.table = midair.trace(
            midair.design("triangular-pair"), refractive_index=1.49, incidence="0:45:5", azimuth=30
        )

    def things(self) -> list[midair.Mesh | midair.Table | midair.Result]:
        pair = midair.design("triangular-pair")
        own = midair.Mesh(
            pair.vertices / 3, pair.faces, design="three words and ü",
            lattice=[[1, 0, 0], [0, 1, 0]], hollow=True,
        )  # fmt: skip
        rays = dict[str, Any](refractive_index=1.49, incidence=[0, 20], azimuth=30, rays=4096)
        counted = midair.trace(pair, method="rays", deviations=2, bins=32, **rays)
        self.table.save(self.folder / "pair.h5")
        return [
            midair.design("full-cube", dihedral_error_mrad=[0.1, 0, 0]),
            midair.design("bead"),
            own,
            self.table,
            counted,
            midair.open(self.folder / "pair.h5"),
            quiet(midair.estimate, CAMPAIGN, self.table),
            midair.sheet(self.table, c=0.2, a_times_r=600.0, mu=0.4),
            midair.sheet(sheet="prism-0.1"),
        ]

    def test_a_copy_is_the_same(self) -> None:
        things = self.things()
        for thing in things:
            for again in (pickle.loads(pickle.dumps(thing)), copy.deepcopy(thing)):
                self.assertIs(type(again), type(thing))
                self.assertEqual(repr(again), repr(thing))
                np.testing.assert_equal(looked_at(again), looked_at(thing))
        self.tell(len(things), "objects")

    def test_a_new_process_sees_the_same(self) -> None:
        things = self.things()
        with multiprocessing.get_context("spawn").Pool(1) as pool:
            seen = pool.map(looked_at, things)
            with self.assertRaises(midair.Error) as caught:
                pool.apply(refused, (95,))
        np.testing.assert_equal(seen, [looked_at(thing) for thing in things])
        self.assertEqual(caught.exception.place, "incidence")
        self.tell(len(seen), "objects in another process")

    def test_a_copy_renders_like_its_original(self) -> None:
        picture = np.zeros((40, 60), np.float32)
        picture[10:30, 20:40] = 0.5
        sheet = midair.sheet(self.table, c=0.2, a=4.0, pixel_pitch=0.1)
        again = pickle.loads(pickle.dumps(sheet))
        one, other = (quiet(each.render, picture, 300, 20) for each in (sheet, again))
        np.testing.assert_array_equal(one, other)
        unknown = pickle.loads(pickle.dumps(midair.sheet(self.table, c=0.2, a=4.0)))
        with self.assertRaisesRegex(midair.Error, "pixel_pitch"):
            unknown.render(picture, 300, 20)
        with self.assertRaisesRegex(midair.Error, "photographs"):
            again.report()

    def test_a_damaged_pickle_is_refused(self) -> None:
        make, (content, name) = self.table.__reduce__()
        with self.assertRaisesRegex(midair.Error, "damaged"):
            make(content[: len(content) // 2], name)
        make, (text, table, has_pitch) = midair.sheet(self.table, c=0.2, a=4.0).__reduce__()
        with self.assertRaisesRegex(midair.Error, "result"):
            make(text[:-20], table, has_pitch)


class Saved(Case):
    def test_results_are_saved_as_the_program_writes_them(self) -> None:
        pair = self.folder / "pair.h5"
        table = midair.trace(
            midair.design("triangular-pair"), pair, refractive_index=1.49,
            incidence="0:45:5", azimuth=30,
        )  # fmt: skip
        written, saved = self.folder / "program.json", self.folder / "python.json"
        cases: list[list[str]] = [[], ["--kernel=eq1", "--lobe=radial", "--per-angle=a,mu"]]
        for options in cases:
            run("fit", "estimate", CAMPAIGN, "--table", pair, "-o", written, *options)
            saved.write_text("an older file")
            midair.load(written, table).save(saved)
            self.assertEqual(saved.read_bytes(), written.read_bytes())
        result = quiet(midair.estimate, CAMPAIGN, table)
        result.save(saved)
        told = run(
            "fit", "predict", saved, "--table", pair, "--distance=300", "--incidence=20", "--json"
        )  # fmt: skip
        mtf = json.loads(told.stdout)["predictions"][0]["mtf"]
        made = quiet(result.predict, 300, 20).sel(axis="tangential").squeeze()
        np.testing.assert_array_equal(made.mtf, mtf)
        self.tell(len(cases), "results")

    def test_a_file_is_whole_or_as_it_was(self) -> None:
        result = midair.sheet(sheet="prism-0.1")
        page = quiet(result.explore)
        cases = 0
        for save in (result.save, page.save):
            for path in (self.folder, self.folder / "nowhere" / "file", "-"):
                with self.assertRaises(midair.Error):
                    save(path)
                cases += 1
            file = self.folder / "kept"
            file.write_text("kept")
            file.chmod(0o444)
            with self.assertRaisesRegex(midair.Error, "write-protected"):
                save(file)
            self.assertEqual(file.read_text(), "kept")
            file.unlink()
            save(file)
            self.assertGreater(file.stat().st_size, 1000)
            file.unlink()
            self.assertEqual(list(self.folder.iterdir()), [])
            cases += 2
        self.tell(cases, "files")
