"""Times paths through a sheet beside paths through a mirror in its place, in turns.

    python tests/mitsuba_speed.py [ROUNDS]

The scene is the standard one with a half mirror, of 256 x 256 pixels and 256 paths each: by
`midair_path` with a sheet, and by `path` with a perfect mirror that faces the half mirror. A round
renders both; the ratio is that of paths in a second of the processor. It needs mitsuba, its LLVM
variant, and midair with that extra.
"""

import statistics
import sys
import time
import warnings

import drjit as dr
import midair
import midair.mitsuba as scenes
import mitsuba as mi
import numpy as np

SIDE, PATHS = 256, 256

# `path` is compiled with every plugin of the process, so it meets the sheet of the other scene too.
warnings.simplefilter("ignore")
scenes.set_variant("llvm_ad_rgb")
table = midair.trace(
    midair.design("triangular-pair"), refractive_index=1.49, incidence="0:45:5", azimuth="full:5"
)
made = scenes.scene(
    np.ones((SIDE, SIDE), np.float32), table, c=0.3, A=2000, mu=0.5, distance=300, incidence=0,
    azimuth=30, width=20, samples=PATHS, guided=False,
)
mirror = {
    **made,
    "integrator": {**made["integrator"], "type": "path"},
    "sheet": {**made["sheet"], "bsdf": {"type": "conductor", "material": "none"}},
}
del mirror["integrator"]["guided"]
loaded = {"sheet": scenes.load(made), "mirror": mi.load_dict(mirror)}


def seconds(scene, seed):
    start = time.process_time()
    dr.eval(mi.render(scene, seed=seed))
    dr.sync_thread()
    return time.process_time() - start


rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 15
for scene in loaded.values():  # compiles
    seconds(scene, 0)
ratios = []
for seed in range(1, rounds + 1):
    took = {name: seconds(scene, seed) for name, scene in loaded.items()}
    ratios.append(took["mirror"] / took["sheet"])
ratios.sort()
print(
    f"{SIDE * SIDE * PATHS / 1e6:.0f} M paths, {rounds} rounds: {statistics.median(ratios):.2f} "
    f"({ratios[0]:.2f} to {ratios[-1]:.2f}) of the speed of a mirror"
)
