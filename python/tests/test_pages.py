"""The Python in the pages, run from top to bottom of each page."""

from __future__ import annotations

import os
import re
import unittest
import warnings

from common import ROOT, Case


class Pages(Case):
    def test_python_of_the_pages_runs(self) -> None:
        blocks = 0
        # The pages name files as seen from the root of the repository.
        here = os.getcwd()
        self.addCleanup(os.chdir, here)
        for name in ("tests", "doc"):
            os.symlink(ROOT / name, self.folder / name)
        os.chdir(self.folder)
        for page in ("README.md", "doc/python.md", "doc/compare.md"):
            names: dict[str, object] = {}
            found = re.findall(r"^```python\n(.*?)^```", (ROOT / page).read_text(), re.M | re.S)
            self.assertTrue(found, page)
            for block in found:
                with self.subTest(page, block=block), warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    exec(compile(block, page, "exec"), names)
                blocks += 1
        self.tell(blocks, "blocks")


if __name__ == "__main__":
    unittest.main()
