"""The package within a process: Ctrl-C, progress, threads, h5py, and the reading program."""

from __future__ import annotations

import os
import platform
import re
import shutil
import signal
import subprocess
import sys
import textwrap
import threading
import time
import unittest
import warnings
from importlib.metadata import distribution
from pathlib import Path

import midair
from common import CAMPAIGN, Case

#: Rays that take a minute or more on any machine.
MANY = 1 << 34


def python(code: str, **options: object) -> subprocess.Popen[str]:
    """Start another interpreter."""
    return subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(code)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,  # type: ignore[call-overload]
    )


class Process(Case):
    def test_ctrl_c_ends_long_work(self) -> None:
        table = self.folder / "pair.h5"
        midair.trace(
            midair.design("triangular-pair"), table, refractive_index=1.49, azimuth=30
        )
        ranges = self.folder / "ranges.toml"
        ranges.write_text("[camera]\nwidth = 96\nheight = 64\n")
        works = {
            "trace": f"midair.trace(midair.design('triangular-pair'), method='rays', rays={MANY})",
            "study": f"midair.study(ranges={str(ranges)!r}, table={str(table)!r}, "
            "campaigns=100000)",
            "directions": "midair.trace("
            "midair.design('full-cube', dihedral_error_mrad=[0.5, 0.2, -0.3]), incidence='0,45', "
            "azimuth='full', direction_tolerance=0.003)",
        }
        for name, work in works.items():
            with self.subTest(name):
                # A job in the background of a shell ignores Ctrl-C, and so would its children.
                code = f"""
                import midair, signal, warnings
                signal.signal(signal.SIGINT, signal.default_int_handler)
                warnings.simplefilter("ignore")
                print("begins", flush=True)
                {work}
                print("done", flush=True)
                """
                child = python(code)
                self.addCleanup(child.kill)
                assert child.stdout is not None
                self.assertEqual(child.stdout.readline(), "begins\n")
                time.sleep(1.0)
                self.assertIsNone(child.poll(), name)
                child.send_signal(signal.SIGINT)
                out, err = child.communicate(timeout=60)
                self.assertEqual(out, "")
                self.assertTrue(err.rstrip().endswith("KeyboardInterrupt"), err)
        self.tell(len(works), "kinds of work")

    def test_progress_is_told_and_may_stop_the_work(self) -> None:
        told: list[tuple[str, int, int | None]] = []
        table = midair.trace(
            midair.design("triangular"),
            refractive_index=1.49,
            method="rays",
            rays=1 << 26,
            progress=lambda *news: told.append(news),
        )
        self.assertEqual(int(table._table.rays.sum()), (1 << 26) * 10)
        self.assertTrue(told)
        done = [count for _, count, _ in told]
        self.assertEqual(done, sorted(done))
        self.assertTrue(all(what == "rays" and of == (1 << 26) * 10 for what, _, of in told))

        def stop(*_: object) -> None:
            raise RuntimeError("enough")

        with self.assertRaisesRegex(RuntimeError, "enough"):
            midair.trace(midair.design("triangular"), method="rays", rays=MANY, progress=stop)
        self.tell(len(told) + 1, "calls")

    def test_other_threads_go_on(self) -> None:
        counted = 0
        ended = threading.Event()

        def count() -> None:
            nonlocal counted
            while not ended.is_set():
                counted += 1
                time.sleep(0.001)

        other = threading.Thread(target=count)
        other.start()
        midair.trace(
            midair.design("triangular"),
            refractive_index=1.5,
            method="rays",
            rays=1 << 26,
            threads=1,
        )
        ended.set()
        other.join()
        # With the lock of the interpreter held the other thread would count once or twice.
        self.assertGreater(counted, 20)
        self.tell(counted, "steps of another thread")

    def test_h5py_and_midair_share_a_process(self) -> None:
        code = """
            import sys, warnings
            first, second = sys.argv[1:3]
            __import__(first); __import__(second)
            import midair, h5py, numpy
            folder = sys.argv[3]
            pair = midair.design("triangular-pair")
            for turn in range(3):
                table = midair.trace(pair, f"{folder}/a{turn}.h5", refractive_index=1.49, seed=turn)
                with h5py.File(f"{folder}/b{turn}.h5", "w") as file:
                    data = file.create_dataset("x", data=numpy.arange(1e5), compression="gzip")
                    with h5py.File(f"{folder}/a{turn}.h5") as other:
                        assert numpy.array_equal(other["histogram"][()], table.histogram)
                        again = midair.open(f"{folder}/a{turn}.h5")
                        assert again.content_hash == table.content_hash
                with h5py.File(f"{folder}/b{turn}.h5") as file:
                    assert file["x"][77] == 77
            try:
                midair.open(f"{folder}/b0.h5")
            except midair.Error as error:
                assert "format" in error.sentence, error
            print("ok", h5py.version.hdf5_version)
        """
        for order in (["h5py", "midair"], ["midair", "h5py"]):
            child = subprocess.run(
                [sys.executable, "-c", textwrap.dedent(code), *order, str(self.folder)],
                capture_output=True,
                text=True,
                check=False,
            )
            self.assertEqual(child.returncode, 0, child.stderr)
            self.assertTrue(child.stdout.startswith("ok"), child.stdout)
        self.tell(2, "orders of import")

    def test_the_tag_names_a_c_library_with_which_all_files_run(self) -> None:
        found = distribution("midair")
        tagged = re.search(r"^Tag: .*-manylinux_2_(\d+)_", found.read_text("WHEEL") or "", re.M)
        if sys.platform != "linux" or platform.libc_ver()[0] != "glibc":
            self.skipTest("the C library is not glibc")
        assert tagged, found.read_text("WHEEL")
        native = {"bake", "fit", "airr-reader", "_midair.abi3.so"}
        needed = {}
        for file in found.files or []:
            if file.name in native:
                content = Path(str(file.locate())).read_bytes()
                versions = re.findall(rb"\0GLIBC_2\.(\d+)[.\0]", content)
                needed[file.name] = max(int(version) for version in versions)
        self.assertEqual(set(needed), native)
        self.assertEqual(max(needed.values()), int(tagged[1]), needed)
        self.tell(len(needed), "files")

    def test_the_module_shows_no_names_of_hdf5(self) -> None:
        if shutil.which("nm") is None:
            self.skipTest("nm is not on PATH")
        module = Path(midair._midair.__file__)
        dynamic = subprocess.run(["nm", "-D", module], capture_output=True, text=True, check=True)
        names = [line.split()[-1] for line in dynamic.stdout.splitlines() if " T " in line]
        self.assertIn("PyInit__midair", names)
        self.assertFalse([name for name in names if name.startswith("H5")], names)
        self.tell(len(names), "names")

    def test_tables_are_opened_by_the_reading_program(self) -> None:
        table = self.folder / "pair.h5"
        midair.trace(midair.design("triangular-pair"), table, refractive_index=1.49)
        if sys.platform != "linux":
            self.skipTest("looks at /proc")
        code = f"""
            import midair
            from midair import _midair
            _midair.use_reader  # The program is named once, at the import.
            print(midair.open({str(table)!r}).is_exact)
        """
        # Without the program the table is not read, least of all in this process.
        from midair import _programs

        found = [place for place in _programs._places() if place.is_file()]
        self.assertTrue(found)
        self.assertTrue(all(place.name == "airr-reader" for place in found), found)
        for place in {place.resolve() for place in found}:
            place.rename(place.with_suffix(".away"))
        try:
            child = python(code)
            _, err = child.communicate(timeout=60)
        finally:
            for place in {place.resolve() for place in found}:
                place.with_suffix(".away").rename(place)
        self.assertNotEqual(child.returncode, 0)
        self.assertIn("midair.Error", err.replace("midair._errors.", "midair."))
        self.assertIn("airr-reader", err)
        out, err = python(code).communicate(timeout=60)
        self.assertEqual((out, err), ("True\n", ""))
        self.tell(2, "interpreters")

    def test_no_network_home_or_path_is_needed(self) -> None:
        child = subprocess.run(
            [sys.executable, "-I", "-c", "import midair; print(midair.design('triangular'))"],
            env={},
            cwd=self.folder,
            capture_output=True,
            text=True,
            check=False,
        )
        self.assertEqual((child.stdout, child.stderr), ("<midair.Mesh triangular: 3 facets>\n", ""))
        self.assertFalse(os.listdir(self.folder))
        self.tell(1, "interpreter")

    def test_estimates_run_in_several_threads_at_once(self) -> None:
        table = midair.trace(midair.design("triangular-pair"), refractive_index=1.49, azimuth=30)
        made: list[str] = []

        def estimate() -> None:
            result = midair.estimate(CAMPAIGN, table, kernel="eq1", lobe="radial", threads=1)
            made.append(str(result))

        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            threads = [threading.Thread(target=estimate) for _ in range(3)]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
        self.assertEqual(len(made), 3)
        self.assertEqual(len(set(made)), 1)
        self.tell(len(made), "threads")


if __name__ == "__main__":
    unittest.main()
