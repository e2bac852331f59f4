"""Fits c and mu of a sheet to a photograph, by Adam and derivatives through the renderer.

    python doc/adam.py

The photograph is rendered here, with other random numbers, from a sheet whose c and mu are known.
Every step renders the scene, and compares it with the photograph. The script needs the package
midair[mitsuba].
"""

import warnings

import drjit as dr
import midair
import midair.mitsuba as mm
import mitsuba as mi
import numpy as np

TRUTH = {"c": 0.30, "mu": 0.55}
START = {"c": 0.15, "mu": 0.40}
STEPS, SAMPLES = 70, 256


def photographed(table, c, mu):
    """Return the scene: a picture of stripes, whose borders the camera does not see."""
    x = (np.arange(320) + 0.5) / 10
    # The border of a source jumps, and jumps have no derivative.
    stripes = np.tile(0.5 + 0.5 * np.sin(2 * np.pi * x), (320, 1))
    scene = mm.scene(
        stripes, table, c=c, mu=mu, A=2800.0, distance=300, incidence=10, azimuth=30,
        width=32, field=8, resolution=(80, 16), camera_distance=2000,
    )
    scene["source"]["light"]["radiance"]["filter_type"] = "bilinear"
    return mm.load(scene)


def main():
    mm.set_variant("llvm_ad_rgb")
    warnings.simplefilter("ignore")
    table = midair.trace(
        midair.design("triangular-pair"),
        refractive_index=1.49,
        incidence="0:30:5",
        azimuth="full:5",
    )
    photograph = mi.render(photographed(table, **TRUTH), seed=1_000_000, spp=16 * SAMPLES)
    scene = photographed(table, **START)
    params = mi.traverse(scene)
    keys = {"c": "sheet.bsdf.c", "mu": "sheet.bsdf.mu"}
    adam = mi.ad.Adam(lr=0.01, params={name: params[key] for name, key in keys.items()})
    for step in range(STEPS):
        adam.set_learning_rate(0.01 * 0.94 ** max(0, step - 35))
        for name, key in keys.items():
            params[key] = adam[name]
        params.update()
        image = mi.render(scene, params, seed=2 * step, seed_grad=2 * step + 1, spp=SAMPLES)
        loss = dr.mean(dr.square(image - photograph), axis=None)
        dr.backward(loss)
        adam.step()
    for name, true in TRUTH.items():
        print(f"{name}: {float(adam[name][0]):.4f}, true {true}")


if __name__ == "__main__":
    main()
