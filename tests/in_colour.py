"""Checks the lamps of `fit` with the package colour-science.

    python in_colour.py FIT TABLE.h5

For each named illuminant, the MTF of waves in its light, as the eye sees it, is compared with that
of the product of colour-science's illuminant and luminous efficiency, a line each nanometre. `fit`
keeps both curves every 5 nm and takes eight wavelengths for their product.

The eight are exact for polynomials of degree 15, so a smooth mean has what rounding of the curves
leaves: 1e-5. Where the OTF ends for a wavelength within the lamp, it has a kink there. A rule whose
nodes are d apart errs by up to s p d^2/8 at a kink of slope s in light of density p: at 0.2 /mm along
the second axis it is 0.0011 per nm at 612 nm, p is 0.005 per nm and d some 24 nm, together 4e-4.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import colour
import numpy as np

ILLUMINANTS = ["A", "D65", "E", "LED-B1", "LED-B2", "LED-B3", "LED-B4", "LED-B5"]
SMOOTH, KINK = 2e-5, 5e-4

fit, table = sys.argv[1:]
at = "--c 0.15 --mu 0.5 --distance 1000 --incidence 0 --azimuth 30 --json --frequency"
frequencies = [0.02, 0.04, 0.06, 0.08, 0.1, 0.12, 0.15, 0.2]


def mtf(*light):
    line = [fit, "predict", "--table", table, *light, *at.split(), ",".join(map(str, frequencies))]
    done = subprocess.run(line, capture_output=True, text=True)
    if done.returncode:
        sys.exit(done.stderr)
    return np.array([row["mtf"] for row in json.loads(done.stdout)["predictions"]])


shape = colour.SpectralShape(380, 780, 1)
eye = colour.SDS_LEFS["CIE 1924 Photopic Standard Observer"].copy().align(shape)
failed = False
with tempfile.TemporaryDirectory() as folder:
    setup = Path(folder) / "setup.toml"
    for name in ILLUMINANTS:
        setup.write_text(f'[setup]\nspectrum = "{name}"\n')
        lamp = colour.SDS_ILLUMINANTS[name].copy().align(shape)
        lines = zip(shape.wavelengths, lamp.values * eye.values)
        light = ",".join(f"{nm:.0f}:{power:.9g}" for nm, power in lines if power > 0)
        ours, theirs = mtf("--setup", str(setup)), mtf("--wavelength-nm", light)
        off = np.sort(np.abs(ours - theirs), axis=None)
        middle, most = float(off[off.size // 2]), float(off[-1])
        failed |= middle > SMOOTH or most > KINK
        print(f"{name:8} {off.size} MTFs, off by {middle:.1e} in the median, {most:.1e} at most")
if failed:
    sys.exit(f"a median is above {SMOOTH:.0e}, or an MTF is off by more than {KINK:.0e}")
