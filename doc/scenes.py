"""Draws doc/desk.png and doc/stage.png: sheets in scenes of Mitsuba, by three models.

    python doc/scenes.py [SAMPLES]

SAMPLES are the paths of a pixel (512). The script needs the package midair[mitsuba] and pillow.
Both sheets have cubes with edges of 1 mm. Beside the table of ray shifts stand two models without
it: a lobe, and the rough facets of Saito, Yue and Koizumi (2024). Each has the one number with
which its MTF differs least from that of the sheet at 600 mm, where a laboratory may have measured
it.
"""

import sys
import warnings
from pathlib import Path

import midair
import midair.mitsuba as mm
import mitsuba as mi
import numpy as np
from PIL import Image, ImageDraw

HERE = Path(__file__).resolve().parent
SAMPLES = int(sys.argv[1]) if len(sys.argv) > 1 else 512
MEASURED_MM = 600.0
#: A = 2.8 c / wavelength, for 1 mm and 550 nm.
SHEET = {"c": 1.0, "A": 5091.0, "mu": 0.6}
INDEX = 1.49
#: Height of the panels, widths of the view and of a close-up, gap, pixels.
HEIGHT, WIDE, CLOSE, GAP = 240, 337, 157, 8


def nearest(table):
    """Return the numbers of the nearest lobe and of the nearest rough facets, incidence 0."""
    frequency = np.arange(1, 200) * 0.01
    place = dict(distance=MEASURED_MM, incidence=0, azimuth=0, frequency=list(frequency))

    def mtf(**numbers):
        return midair.sheet(table, **numbers).predict(**place).mtf.values

    def least(tried, model):
        return float(tried[np.argmin([np.square(model(one) - own).sum() for one in tried])])

    own = mtf(c=SHEET["c"], a_times_r=SHEET["A"])
    # Cubes of 1 um have no visible shift.
    lobe = least(
        np.geomspace(0.1, 1, 60) * SHEET["A"], lambda one: mtf(c=1e-3, a_times_r=one)
    )
    rough = least(
        np.geomspace(1e-4, 1e-3, 200),
        lambda one: saito(one, 2 * np.pi * MEASURED_MM * frequency),
    )
    print(f"A of the lobe: {lobe:.0f}, of the sheet {SHEET['A']:.0f}; roughness {rough:.2e}")
    # Three Gaussians make one. Its standard deviation is 2 index roughness across the plane of
    # incidence and grows in it by refraction, which is what an angular spread is.
    return {"c": 0.0, "A": lobe, "mu": SHEET["mu"]}, {
        "c": 0.0, "angular_spread_mrad": 2e3 * INDEX * rough, "mu": SHEET["mu"],
    }


def saito(roughness, k):
    """Return the MTF of three rough facets at normal incidence, by k = 2 pi R f.

    The densities of their slopes are Beckmann's, which come nearer to this sheet than GGX.
    fit/doc/model.md gives the formula for all directions.
    """
    return np.exp(-3 * (np.sqrt(8 / 3) * INDEX * roughness * k) ** 2 / 4)


def diffuse(*colour):
    return {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(colour)}}


def block(at, size, bsdf):
    """Return a box on its lower side, by the middle of that side and its width, height, depth."""
    w, h, d = size
    x, y, z = at
    move = mi.ScalarTransform4f().translate([x, y + h / 2, z]).scale([w / 2, h / 2, d / 2])
    return {"type": "cube", "to_world": move, "bsdf": bsdf}


def scene(table, numbers, scale, eye, width, fov, size, aperture=None):
    """Return a set-up 2 `scale` deep: sign below, half mirror, sheet behind, and a floor before.

    The mid-air image floats at (0, 0, `scale`). `eye` is in units of `scale`.
    """
    near = scale
    made = mm.scene(
        HERE / "sign.png", table, distance=2 * near, width=width, sheet_size=4 * near, **numbers
    )
    film = {"type": "hdrfilm", "width": size[0], "height": size[1], "component_format": "float32"}
    made["camera"] = {
        "type": "perspective" if aperture is None else "thinlens",
        "fov": fov,
        "fov_axis": "y",
        "near_clip": 0.01 * near,
        "far_clip": 100.0 * near,
        "to_world": mi.ScalarTransform4f().look_at(
            origin=[near * one for one in eye], target=[0, 0, near], up=[0, 1, 0]
        ),
        "film": film,
        "sampler": {"type": "multijitter", "sample_count": SAMPLES},
    }
    if aperture is not None:
        focus = near * float(np.linalg.norm(np.subtract(eye, [0, 0, 1])))
        made["camera"].update(aperture_radius=aperture, focus_distance=focus)
    made["half_mirror"]["to_world"] = mi.ScalarTransform4f(
        [
            [0.75 * near, 0, 0, 0],
            [0, 0.6 * near, 0.707, 0],
            [0, -0.6 * near, 0.707, 0],
            [0, 0, 0, 1],
        ]
    )
    made["source"]["light"]["radiance"] = brighter(made["source"]["light"]["radiance"], 20)
    floor = -0.62 * near
    made["floor"] = block([0, floor - 0.04 * near, 2.6 * near], [8 * near, 0.04 * near, 4 * near],
                          diffuse(0.45, 0.30, 0.18))
    made["lamp"] = {
        "type": "sphere",
        "center": [-1.5 * near, 4 * near, 3 * near],
        "radius": 0.5 * near,
        "emitter": {"type": "area", "radiance": {"type": "rgb", "value": [30.0, 27.0, 24.0]}},
    }
    made["integrator"]["max_depth"] = 8
    return made, floor


def brighter(texture, factor):
    bitmap = texture["bitmap"]
    return {**texture, "bitmap": mi.Bitmap(np.array(bitmap) * np.float32(factor))}


def desk(table, numbers, fov, size):
    """A sign 100 mm before its half mirror, over a desk, by a lens of 12 mm."""
    made, floor = scene(table, numbers, 100.0, [0.9, 0.7, 5.0], 60.0, fov, size, aperture=6.0)
    made["mug"] = {
        "type": "cylinder",
        "p0": [-62, floor, 105],
        "p1": [-62, floor + 62, 105],
        "radius": 20,
        "bsdf": {"type": "twosided", "bsdf": diffuse(0.15, 0.3, 0.5)},
    }
    made["book"] = block([66, floor, 120], [44, 12, 62], diffuse(0.5, 0.12, 0.1))
    return made


def stage(table, numbers, fov, size):
    """A sign 1.5 m before its half mirror, 3 m from the sheet, seen 22 degrees off the axis."""
    made, floor = scene(table, numbers, 1500.0, [1.9, 0.25, 5.5], 700.0, fov, size)
    for side in (-1, 1):
        at = [side * 820, floor, 1500]
        made[f"stand{side + 1}"] = block(at, [180, 900, 180], diffuse(0.4, 0.4, 0.42))
        made[f"ball{side + 1}"] = {
            "type": "sphere", "center": [at[0], floor + 1050, 1500], "radius": 150,
            "bsdf": diffuse(0.6, 0.5, 0.2),
        }
    return made


def picture(make, table, numbers, fov, size):
    """Return a rendered scene as a picture of 8 bits."""
    light = np.array(mi.render(mm.load(make(table, numbers, fov, size))))
    return Image.fromarray(np.array(mi.Bitmap(light).convert(
        mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.UInt8, srgb_gamma=True)))


def figure(make, table, models, fov, zoom, name, title):
    """Draw one scene: the view, and a part of its image by each of the models."""
    whole = Image.new("RGB", (WIDE + len(models) * (GAP + CLOSE), HEIGHT + 20), "white")
    draw, left = ImageDraw.Draw(whole), 0
    panels = [(title, models["by its ray shifts"], fov, WIDE)]
    panels += [(caption, numbers, zoom, CLOSE) for caption, numbers in models.items()]
    for caption, numbers, angle, width in panels:
        drawn = picture(make, table, numbers, angle, (max(width, HEIGHT), HEIGHT))
        whole.paste(drawn.crop((drawn.width - width, 0, drawn.width, HEIGHT)), (left, 0))
        draw.text((left + 2, HEIGHT + 3), caption, fill="black", font_size=14)
        left += width + GAP
    whole.quantize(256, dither=Image.Dither.NONE).save(HERE / name, optimize=True)


def main():
    mm.set_variant("llvm_ad_rgb")
    warnings.simplefilter("ignore")
    table = midair.trace(
        midair.design("triangular-pair"),
        refractive_index=INDEX,
        incidence="0:50:5",
        azimuth="full:5",
    )
    lobe, rough = nearest(table)
    models = {"by its ray shifts": SHEET, "by a lobe": lobe, "by Saito's facets": rough}
    figure(desk, table, models, 24.0, 5.0, "desk.png", "A sign in the air, 200 mm from its sheet")
    figure(stage, table, models, 24.0, 2.6, "stage.png", "A sign in the air, 3 m from its sheet")


if __name__ == "__main__":
    main()
