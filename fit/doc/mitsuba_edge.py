"""Renders the mid-air image of a picture in Mitsuba 3, from a table and a result.

    python mitsuba_edge.py --source edge.exr --params result.json --table sheet.h5 \
        --distance 300 --incidence 20 -o mitsuba.exr --compare aerial.exr

The table is from `bake trace` and must hold the direction. The result is from `fit estimate`, with
the kernel eq1, angular, shift or lobe. --compare names the image that `fit render` made with the
same options: the script prints the root mean square difference and the standard error of its own
samples, and fails if the difference is larger than 1.2 standard errors.

The script needs mitsuba, h5py, numpy, and an LLVM that Mitsuba takes. Mitsuba 3.9 wants LLVM 19;
DRJIT_LIBLLVM_PATH names it.
"""

import argparse, json, os, sys

import numpy as np
import mitsuba as mi
import drjit as dr

sys.path.append(os.path.join(os.path.dirname(__file__), "..", "..", "tables"))
from read_table import read_table

ap = argparse.ArgumentParser()
for name in ("--source", "--params", "--table", "--output"):
    ap.add_argument(name, *(["-o"] if name == "--output" else []), required=True)
ap.add_argument("--compare")
ap.add_argument("--distance", type=float, required=True)
ap.add_argument("--incidence", type=float, required=True)
ap.add_argument("--azimuth", type=float)
ap.add_argument("--samples", type=int, default=1024)
args = ap.parse_args()
mi.set_variant("llvm_ad_rgb")
F, U, V = mi.Float, mi.UInt32, mi.Vector2f

# ---- Table: the triangles of the shift's polygons (exact), or its bins as pairs of triangles; one
# row [a, b, c] each.
table, fit = read_table(args.table), json.load(open(args.params))
i = int(np.flatnonzero(np.isclose(table["incidence_deg"], args.incidence))[0])
azimuths = table["azimuth_deg"]
j = 0 if len(azimuths) == 1 else int(np.flatnonzero(np.isclose(azimuths, args.azimuth))[0])
triangles, power = [], []
cross = lambda a, b: abs(a[0] * b[1] - a[1] * b[0])
if "paths" in table:
    for path in (p for p in table["paths"] if (p["incidence"], p["azimuth"]) == (i, j)):
        corners = path["polygon"]
        shift = corners @ path["matrix"].T + path["offset"]
        for k in range(1, len(corners) - 1):
            triangles.append(shift[[0, k, k + 1]])
            power.append(
                path["weight"] * cross(corners[k] - corners[0], corners[k + 1] - corners[0])
            )
else:
    u, v = table["shift_u"], table["shift_v"]
    half = (u[1] - u[0]) / 2
    for row, column in np.argwhere(table["histogram"][i, j] > 0):
        low, high = np.array([u[column], v[row]]) - half, np.array([u[column], v[row]]) + half
        triangles += [[low, [high[0], low[1]], high], [low, high, [low[0], high[1]]]]
        power += 2 * [table["histogram"][i, j, row, column]]
choose = mi.DiscreteDistribution(np.array(power, dtype=np.float32))
corner = [
    [F(np.array(triangles)[:, k, axis].astype(np.float32)) for axis in (0, 1)] for k in range(3)
]


# ---- Result: parameters at this incidence, linear between the fitted ones.
def at(parameter):
    if "per_angle" not in parameter:
        return parameter["value"]
    rows = parameter["per_angle"]
    return float(
        np.interp(args.incidence, [r["incidence_deg"] for r in rows], [r["value"] for r in rows])
    )


kernel = fit["kernel"]
c = at(fit["c_mm"]) if kernel != "lobe" else 0.0
a = {
    "eq1": lambda: at(fit["a_per_mm"]),
    "lobe": lambda: at(fit["a_per_mm"]),
    "shift": lambda: None,
    "angular": lambda: at(fit["a_times_r"]) / args.distance,
}[kernel]()
if a is not None and fit["lobe"] not in ("radial", "separable"):
    sys.exit(f"this script samples the lobes radial and separable, not {fit['lobe']}")
energy = at(fit["mu"]) * table["retroreflected"][i, j] * fit["half_mirror"]
t = np.linspace(0, 2.4 * np.pi if fit["lobe"] == "radial" else 4000 * np.pi, 1 << 22)[1:]
mass = np.cumsum(np.sin(t) ** 2 / t ** (1 if fit["lobe"] == "radial" else 2))
quantile = F(
    np.interp(np.linspace(0, 1, 65537), np.r_[0, mass] / mass[-1], np.r_[0, t]).astype(np.float32)
)


def inverse(x):
    x = x * 65536
    k = dr.minimum(U(x), 65535)
    return dr.lerp(dr.gather(F, quantile, k), dr.gather(F, quantile, k + 1), x - F(k))


def offset(sampler):
    """mm, (tangential, sagittal): Sugawara and Koizumi's ray shift, and Eq. (1)."""
    k, share = choose.sample_reuse(sampler.next_1d())
    b = mi.warp.square_to_uniform_triangle(mi.Point2f(share, sampler.next_1d()))
    x = [dr.gather(F, p[0], k) for p in corner]
    y = [dr.gather(F, p[1], k) for p in corner]
    mix = lambda p: p[0] + b.x * (p[1] - p[0]) + b.y * (p[2] - p[0])
    shift = c * V(mix(x) * np.cos(np.radians(args.incidence)), mix(y))
    if a is None:
        return shift
    r, s = sampler.next_1d(), sampler.next_1d()
    if fit["lobe"] == "radial":
        lobe = inverse(r) * V(dr.cos(2 * np.pi * s), dr.sin(2 * np.pi * s))
    else:
        signed = lambda x: dr.select(x < 0.5, -inverse(1 - 2 * x), inverse(2 * x - 1))
        lobe = V(signed(r), signed(s))
    return shift + lobe / a


# ---- Render: a texture that is black outside, gathered from where the light of a pixel comes.
source = np.atleast_3d(
    np.array(mi.Bitmap(args.source).convert(component_format=mi.Struct.Type.Float32))
)[..., :3]
h, w, planes = source.shape
texture = mi.Texture2f(
    mi.TensorXf(np.pad(source, ((1, 1), (1, 1), (0, 0)))), wrap_mode=dr.WrapMode.Clamp
)
pitch, groups = fit["camera"]["pixel_pitch_mm"], 8
lane = dr.arange(U, h * w * (each := args.samples // groups))
pixel = lane // each
images = []
for group in range(groups):
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(group, len(lane))
    place = V(F(pixel % w), F(pixel // w)) + 1.5 - offset(sampler) / pitch
    values = texture.eval(mi.Point2f(place / V(w + 2, h + 2)))
    images.append(
        np.stack([np.array(dr.block_sum(v, each)) / each for v in values], -1).reshape(h, w, planes)
        * energy
    )
image = np.mean(images, 0)
mi.Bitmap(image.astype(np.float32)).write(args.output)
if args.compare:
    other = np.atleast_3d(
        np.array(mi.Bitmap(args.compare).convert(component_format=mi.Struct.Type.Float32))
    )[..., :planes]
    error = np.sqrt(np.mean(np.var(images, 0, ddof=1)) / groups)
    difference = np.sqrt(np.mean((image - other) ** 2))
    print(
        f"difference {difference:.3e}, standard error of {args.samples} samples {error:.3e}, "
        f"light {energy:.5f}, sums {image.sum():.2f} and {other.sum():.2f}"
    )
    sys.exit(int(difference > 1.2 * error))
