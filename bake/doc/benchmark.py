#!/usr/bin/env python3
"""Rays per second of processor time: bake against Mitsuba 3, in turns, in one run.

    pip install mitsuba numpy
    python benchmark.py --bake path/to/bake --rounds 5

Both programs trace the same cell into a histogram of 128 x 128 shifts. Where the cell is not ideal
they count exit directions too. Mitsuba runs its fastest known way: the LLVM variant, all rays of a
direction at once, ray_intersect_preliminary with a reflection of its own. Its start, its scene and
its compilation are left out. The seconds of bake are those of the whole process, its file included.

Mitsuba averages both polarisations at each surface, where bake follows them. It counts shifts and
exit directions in two histograms, where bake counts them jointly. So it has less to do in both.

DRJIT_LIBLLVM_PATH must name a library of LLVM that Mitsuba accepts (19 for version 3.9.1).
"""

import argparse
import json
import os
import resource
import statistics
import subprocess
import tempfile

import drjit as dr
import mitsuba as mi
import numpy as np

from meshes import divided, many, read, rhombus, rim, write

BINS, HALF = 128, 2.0
# The edge length of cells of `bake design`.
EDGE = 3.0
ERRORS = ["--dihedral-error-mrad=0.5,0,-0.3"]
FOUR = [0, 15, 30, 45]
TEN = list(range(0, 50, 5))
PAIR = ["triangular-pair"]
SHIFTS = ["--deviations", "off"]
UNLIKE = {"pairs": 32, "moved": 1e-4}


class Case:
    """A cell: the options of bake, the angles, the rays, and what Mitsuba does on it."""

    def __init__(self, name, design, trace, angles=FOUR, rays=1 << 22, **own):
        self.name, self.design, self.trace = name, design, trace
        self.angles, self.rays = angles, rays
        self.index = own.get("index", 1.0)
        self.alpha = own.get("alpha")
        self.exits = own.get("exits", False)
        # Copies of a periodic cell on either side of the one where the light enters.
        self.copies = own.get("copies", 0)
        # Pairs along each side of a mesh of many pairs, and how far apices are moved.
        self.pairs = own.get("pairs", 0)
        self.moved = own.get("moved", 0.0)
        self.whole = own.get("whole", False)


CASES = [
    Case("ideal cube", ["triangular"], [], TEN, 1 << 24),
    Case("dihedral errors", ["triangular", *ERRORS], [], exits=True),
    Case(
        "Fresnel losses",
        ["triangular"],
        ["--refractive-index", "1.49", "--losses", "fresnel", "--back", "tir"],
        index=1.49,
    ),
    Case("full cubes, lattice, dihedral errors", ["full-cube", *ERRORS], [], exits=True, copies=4),
    Case("rough facets", ["triangular"], ["--roughness", "0.001"], exits=True, alpha=1e-3),
    Case("2,048 equal cubes", PAIR, [], [0, 20, 40], 1 << 21, pairs=32),
    Case("2,048 unlike cubes", PAIR, SHIFTS, [0, 20, 40], 1 << 21, **UNLIKE),
    Case(
        "2,048 unlike cubes, exit directions",
        PAIR,
        [],
        [0, 20, 40],
        1 << 21,
        exits=True,
        **UNLIKE,
    ),
    Case("unlike cubes, one mesh", PAIR, SHIFTS, [0, 20, 40], 1 << 21, whole=True, **UNLIKE),
    Case(
        "unlike cubes, one mesh, exit directions",
        PAIR,
        [],
        [0, 20, 40],
        1 << 21,
        whole=True,
        exits=True,
        **UNLIKE,
    ),
]


class Mitsuba:
    """The cell of a case in Mitsuba."""

    def __init__(self, case, path):
        corners, facets, lattice = read(path)
        corners, lattice = corners / EDGE, None if lattice is None else lattice / EDGE
        self.case = case
        self.normal, self.top = rim(corners)
        n = self.normal
        u = np.array([1.0, 0, 0]) - n * n[0]
        self.u = u / np.linalg.norm(u)
        self.v = np.cross(n, self.u)
        self.entrance(corners, lattice)
        if case.copies:
            corners, facets = self.patch(corners, facets, lattice)
        ends = corners[facets]
        normals = np.cross(ends[:, 1] - ends[:, 0], ends[:, 2] - ends[:, 0])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        normals *= np.sign(normals @ n)[:, None]
        # Rays start again beyond their facet, by more than the spacing of f32 at the rim.
        self.step = 1e-6 * max(1.0, float(np.abs(corners).max()))
        offsets = np.einsum("ij,ij->i", normals, ends[:, 0])
        mesh = mi.Mesh("cell", vertex_count=len(corners), face_count=len(facets))
        p = mi.traverse(mesh)
        p["vertex_positions"] = np.float32(corners.ravel())
        p["faces"] = np.uint32(facets.ravel())
        p.update()
        self.scene = mi.load_dict({"type": "scene", "cell": mesh})
        self.few = len(facets) == 3
        first = zip(normals[:3], offsets)
        self.planes = [(mi.Vector3f(*map(float, m)), float(d)) for m, d in first]
        self.normals = [mi.Float(np.float32(normals[:, k])) for k in range(3)]
        self.offsets = mi.Float(np.float32(offsets))
        if case.alpha:
            self.rough = mi.MicrofacetDistribution(mi.MicrofacetType.Beckmann, case.alpha, True)
        self.run(case.angles[0], 0)

    def entrance(self, corners, lattice):
        """Sets a corner and two sides of the entrance, a triangle or a parallelogram."""
        self.triangle = len(corners) == 4
        if self.case.copies:
            a, b = lattice
            self.corner = self.normal * self.top - (a + b) / 2
        elif self.triangle:
            a, b = corners[2] - corners[1], corners[3] - corners[1]
            self.corner = corners[1]
        else:
            self.corner, a, b = rhombus(corners)
        self.a, self.b = a, b

    def patch(self, corners, facets, lattice):
        """Returns the cell and its copies around it."""
        steps = range(-self.case.copies, self.case.copies + 1)
        moves = [i * lattice[0] + j * lattice[1] for i in steps for j in steps]
        return (
            np.concatenate([corners + move for move in moves]),
            np.concatenate([facets + len(corners) * k for k in range(len(moves))]),
        )

    def plane(self, facet, active):
        """Returns normal and offset of the planes of facets."""
        if self.few:
            (a, da), (b, db), (c, dc) = self.planes
            pick = lambda x, y, z: dr.select(facet == 0, x, dr.select(facet == 1, y, z))
            return pick(a, b, c), pick(da, db, dc)
        gather = lambda values: dr.gather(mi.Float, values, facet, active)
        return mi.Vector3f(*(gather(x) for x in self.normals)), gather(self.offsets)

    def run(self, angle, seed):
        """Traces one direction. Returns the share of light that comes back."""
        case = self.case
        sampler = mi.load_dict({"type": "independent"})
        seed = mi.UInt32(seed)
        dr.make_opaque(seed)
        sampler.seed(seed, case.rays)
        n, t = self.normal, np.radians(angle)
        d = -np.cos(t) * n + np.sin(t) * self.u
        front = 1.0
        if case.index != 1.0:
            inside = np.sqrt(1 - (np.sin(t) / case.index) ** 2)
            d = np.sin(t) / case.index * self.u - inside * n
            front = 1 - float(mi.fresnel(mi.Float(float(np.cos(t))), case.index)[0][0])
        travel = mi.Vector3f(*(mi.Float(float(x)) for x in d))
        dr.make_opaque(travel)
        place = sampler.next_2d()
        if self.triangle:
            place = mi.warp.square_to_uniform_triangle(place)
        point = lambda values: mi.Point3f(*map(float, values))
        start = point(self.corner) + mi.Vector3f(point(self.a)) * place.x
        start = start + mi.Vector3f(point(self.b)) * place.y
        count, o, out, weight = self.bounces(travel, start, sampler)
        up = mi.Vector3f(*map(float, n))
        shift = o + out * ((float(self.top) - dr.dot(o, up)) / dr.dot(out, up)) - start
        off = out + travel
        back = (count == 3) & (dr.squared_norm(off) < (1e-3 if case.exits else 1e-5))
        axes = [mi.Vector3f(*map(float, axis)) for axis in (self.u, self.v)]
        bins = lambda what, half: [
            mi.Int32(dr.floor((dr.dot(what, axis) + half) * (BINS / (2 * half)))) for axis in axes
        ]
        if case.index != 1.0:
            found = [self.counted(back, bins(shift, HALF), weight * front**2, mi.Float)]
        else:
            found = [self.counted(back, bins(shift, HALF), 1, mi.UInt32)]
        if case.exits:
            found.append(self.counted(back, bins(off, 0.002), 1, mi.UInt32))
        dr.eval(*found)
        return float(np.array(found[0]).sum()) / case.rays

    @staticmethod
    def counted(back, place, value, kind):
        """Returns a histogram of the rays that come back."""
        i, j = place
        inside = back & (i >= 0) & (j >= 0) & (i < BINS) & (j < BINS)
        counts = dr.zeros(kind, BINS**2)
        dr.scatter_reduce(
            dr.ReduceOp.Add, counts, value, mi.UInt32(i * BINS + j), inside, dr.ReduceMode.Expand
        )
        return counts

    @dr.syntax
    def bounces(self, travel, start, sampler):
        """Follows rays to their last reflection."""
        ray = mi.Ray3f(start, travel)
        count = mi.UInt32(0)
        weight = mi.Float(1)
        active = mi.Bool(True)
        while active & (count < 6):
            met = self.scene.ray_intersect_preliminary(ray, active=active)
            active &= met.is_valid()
            normal, offset = self.plane(met.prim_index, active)
            o = ray(met.t)
            o = o + normal * (offset - dr.dot(o, normal))
            if dr.hint(self.case.alpha is not None, mode="scalar"):
                frame = mi.Frame3f(normal)
                own, _ = self.rough.sample(frame.to_local(-ray.d), sampler.next_2d())
                normal = frame.to_world(own)
            c = -dr.dot(ray.d, normal)
            if dr.hint(self.case.index != 1.0, mode="scalar"):
                share, _, _, _ = mi.fresnel(c, 1 / self.case.index)
                weight[active] = weight * share
            d = ray.d + 2 * c * normal
            count[active] += 1
            ray.o = dr.select(active, o + self.step * d, ray.o)
            ray.d = dr.select(active, d, ray.d)
        return count, ray.o, ray.d, weight


def seconds(who):
    """Returns the processor seconds of this process or of its children."""
    used = resource.getrusage(who)
    return used.ru_utime + used.ru_stime


def bake(args, case, mesh, options):
    """Returns processor seconds of a bake, and the share of light that comes back."""
    angles = ",".join(map(str, case.angles))
    words = [args.bake, "trace", mesh, "-o", mesh + ".h5", "--incidence", angles, "--json"]
    words += ["--threads", str(args.threads), "--method", "rays", *case.trace, *options]
    # The unlike cubes of a mesh have no common edge length.
    words += ["--edge-length", str(EDGE)] if case.pairs else []
    before = seconds(resource.RUSAGE_CHILDREN)
    done = subprocess.run(words, capture_output=True, text=True)
    used = seconds(resource.RUSAGE_CHILDREN) - before
    if done.returncode:
        raise SystemExit(f"{' '.join(words)}\n{done.stderr}")
    report = json.loads(done.stdout)
    return used, [row["retroreflected"] for row in report["directions"]]


def mesh_of(args, case, folder):
    """Writes the mesh of a case and returns its path."""
    path = os.path.join(folder, "cell.obj")
    subprocess.run([args.bake, "design", *case.design, "-o", path], check=True, capture_output=True)
    if case.pairs:
        corners, facets, _ = read(path)
        corners, facets = many(corners, facets, case.pairs, case.moved)
        write(path, *(divided(corners, facets) if case.whole else (corners, facets)))
    return path


def measure(args, case, folder):
    """Returns millions of rays per processor second in each round: Mitsuba, and bake twice.

    It ends the script if another share of light comes back in bake than in Mitsuba.
    """
    mesh = mesh_of(args, case, folder)
    peer = Mitsuba(case, mesh)
    rays = case.rays * len(case.angles) / 1e6
    found = {"Mitsuba": [], "random": [], "Sobol": []}
    for turn in range(args.rounds):
        before = seconds(resource.RUSAGE_SELF)
        etas = [peer.run(angle, 1 + 1000 * turn + k) for k, angle in enumerate(case.angles)]
        found["Mitsuba"].append(rays / (seconds(resource.RUSAGE_SELF) - before))
        for name in ("random", "sobol"):
            options = ["--sampler", name, "--rays", str(case.rays)]
            used, own = bake(args, case, mesh, options)
            found[name.replace("sobol", "Sobol")].append(rays / used)
            off = max(abs(a - b) for a, b in zip(etas, own))
            # Five standard errors of the difference: each share has at most 0.25 / rays of
            # variance.
            if off > 5 * np.sqrt(0.5 / case.rays):
                raise SystemExit(f"{case.name}: other light comes back: {etas} and {own}")
    return found


def figure(values):
    """Returns the median and the range of values."""
    low, high = min(values), max(values)
    digits = 0 if low >= 20 else 1
    return f"{statistics.median(values):.{digits}f} [{low:.{digits}f}-{high:.{digits}f}]"


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--bake", default="bake")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--threads", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--only", help="trace the cases whose names contain this text")
    args = parser.parse_args()
    mi.set_variant("llvm_ad_rgb")
    dr.set_thread_count(args.threads)
    print(f"Mitsuba {mi.__version__}, {args.threads} threads, load {os.getloadavg()[0]:.1f}")
    print("\n| cell | Mitsuba | random points | Sobol points | ratio, random | ratio, Sobol |")
    print("| --- | --- | --- | --- | --- | --- |", flush=True)
    for case in CASES:
        if args.only and args.only not in case.name:
            continue
        with tempfile.TemporaryDirectory() as folder:
            found = measure(args, case, folder)
        ratio = {
            name: statistics.median(a / b for a, b in zip(found[name], found["Mitsuba"]))
            for name in ("random", "Sobol")
        }
        row = [figure(found[name]) for name in ("Mitsuba", "random", "Sobol")]
        row += [f"**{ratio['random']:.1f}**", f"{ratio['Sobol']:.1f}"]
        print("| " + " | ".join([case.name, *row]) + " |", flush=True)
    print(f"\nload {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
