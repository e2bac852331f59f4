"""Draws doc/sign.png, and doc/aerial.png: the sign and its mid-air image at two floating distances.

    python3 doc/aerial.py target/release

The argument is the folder of the programs `bake` and `fit`. The script needs the package midair. It
makes photographs of a known sheet (wave optics, cubes of 0.18 mm), fits the sheet, and renders the
sign.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "tests"))
from table1 import read, sign, srgb, write_png

DISTANCES_MM = [150, 300]
EXPOSURE = "11"  # the mid-air image is about 1/11 as bright as its source
GAP_PX = 8

SHEET = """seed = 1
[camera]
width = 192
height = 128
pixel_pitch_mm = 0.08
[truth]
kernel = "wave"
wavelength_nm = 535
refractive_index = 1.49
pair = true
c = 0.18
mu = 0.6
[reference]
exposure = 1.0
""" + "".join(
    f"""[[capture]]
floating_distance_mm = {distance}.0
incidence_deg = 20.0
azimuth_deg = 30.0
edge_normal_deg = {angle}.0
exposure = 6.0
"""
    for distance in DISTANCES_MM
    for angle in (5, 95)
)


def main():
    programs = Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)

        def run(line):
            program, *words = line.split()
            subprocess.run([programs / program, *words], cwd=here, check=True, capture_output=True)

        (here / "sheet.toml").write_text(SHEET)
        write_png(HERE / "sign.png", srgb(sign()), bits=8)
        run("bake design triangular-pair -o pair.obj")
        run("bake trace pair.obj -o pair.h5 --refractive-index 1.49 --incidence 20 --azimuth 30")
        run("fit simulate sheet.toml -o photographs")
        run(
            "fit estimate photographs/captures.toml --table pair.h5 --kernel wave "
            "--wavelength-nm 535 -o result.json"
        )
        pictures = [srgb(sign())]
        for distance in DISTANCES_MM:
            image = f"aerial-{distance}.png"
            run(
                f"fit render --source {HERE / 'sign.png'} --params result.json --table pair.h5 "
                f"--distance {distance} --incidence 20 --azimuth 30 --pixel-pitch 0.1 "
                f"--exposure {EXPOSURE} -o {image}"
            )
            pictures.append(srgb(read(here / image)))
    gap = np.full((pictures[0].shape[0], GAP_PX, 3), 0.5)
    row = [part for picture in pictures for part in (picture, gap)][:-1]
    write_png(HERE / "aerial.png", np.concatenate(row, axis=1), bits=8)


if __name__ == "__main__":
    main()
