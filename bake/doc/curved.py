#!/usr/bin/env python3
"""Rays per second on a mesh of curved faces: bake against Embree (embreex), in turns, in one run.

    bake design triangular-pair -o curved.obj --sag 1e-4 --segments 408
    pip install embreex numpy
    python curved.py curved.obj --bake path/to/bake

Both programs trace the same mesh from the same entrance. They reflect at interpolated normals, and
stop when a ray is outside.

Embree gets its rays as arrays, with one call per reflection. It computes in f32, and a ray starts
1e-6 before its facet. The rays are in the order of the tiles of the entrance, as in bake, so that
neighbouring rays find the same part of the tree in the cache. The row "Embree" counts the calls of
Embree alone. The row "with numpy" also counts the reflections, which Python computes.

The seconds of a bake of few rays are subtracted from those of bake: they go into mesh, hierarchy
and table. Seconds are those of the processor, because other users may share the machine. With two
threads they are those of the clock.
"""

import argparse
import json
import os
import statistics
import subprocess
import tempfile
import time

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"
import numpy as np
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh

FEW = 1000


def read(path):
    """Reads an OBJ file of `bake design`: corners [facet, 3, axis] and normals, in first edges."""
    v, n, f = [], [], []
    for line in open(path):
        kind, _, rest = line.partition(" ")
        if kind == "v":
            v.append(rest.split())
        elif kind == "vn":
            n.append(rest.split())
        elif kind == "f":
            f.append([word.split("//") for word in rest.split()])
    f = np.array(f, dtype=np.int64) - 1
    v = np.array(v, float)
    return (v / np.linalg.norm(v[1] - v[0]))[f[:, :, 0]], np.array(n, float)[f[:, :, 1]]


class Sheet:
    """The entrance of a pair cell: the apex is the origin, the light comes from (1, 1, 1)."""

    def __init__(self, path, incidence):
        self.corners, self.normals = read(path)
        n = np.ones(3) / np.sqrt(3)
        self.up, self.height = n, (self.corners @ n).max()
        # The rim is the rhombus between ends of edges; its plane and the first edge are those of
        # bake.
        flat = self.corners.reshape(-1, 3)
        rim = flat[flat @ n > self.height - 1e-9]
        u = np.array([1.0, 0, 0]) - n * n[0]
        self.u = u / np.linalg.norm(u)
        self.v = np.cross(n, self.u)
        points = np.stack([rim @ self.u, rim @ self.v], 1)
        corners = points[
            [
                points[:, 0].argmin(),
                points[:, 1].argmin(),
                points[:, 0].argmax(),
                points[:, 1].argmax(),
            ]
        ]
        self.corner, self.sides = self.rhombus(corners)
        angle = np.radians(incidence)
        self.travel = -n * np.cos(angle) + self.u * np.sin(angle)
        start = time.process_time()
        self.scene = rtcore_scene.EmbreeScene()
        TriangleMesh(self.scene, self.corners.astype(np.float32))
        self.trace(np.random.default_rng(0), 16)
        self.build_seconds = time.process_time() - start

    @staticmethod
    def rhombus(c):
        """Returns a corner of the entrance, and the two sides that start there."""
        around = c[np.argsort(np.arctan2(*(c - c.mean(0)).T[::-1]))]
        return around[0], np.stack([around[1] - around[0], around[3] - around[0]])

    def entries(self, rng, count):
        """Returns points of the entrance, in the order of tiles of 64."""
        square = rng.random((count, 2))
        tiles = max(1, int(np.sqrt(count / 64)))
        cell = np.minimum((square * tiles).astype(int), tiles - 1)
        square = square[np.argsort(cell[:, 1] * tiles + cell[:, 0], kind="stable")]
        flat = self.corner + square @ self.sides
        return flat[:, :1] * self.u + flat[:, 1:] * self.v + self.height * self.up

    def trace(self, rng, count):
        """Returns the seconds within Embree, all seconds, and eta.

        eta is the share of rays that three reflections send back within half a degree.
        """
        o = self.entries(rng, count)
        begin = time.process_time()
        d = np.broadcast_to(self.travel, o.shape).copy()
        bounces, out = np.zeros(count, int), d.copy()
        rays, inside = np.arange(count), 0.0
        for _ in range(64):
            start = time.process_time()
            hit = self.scene.run(o.astype(np.float32), d.astype(np.float32), output=True)
            inside += time.process_time() - start
            out[rays] = d
            met = hit["primID"] >= 0
            rays, o, d = rays[met], o[met], d[met]
            if not len(rays):
                break
            facet = hit["primID"][met]
            b, c = hit["u"][met].astype(float), hit["v"][met].astype(float)
            weights = np.stack([1 - b - c, b, c], 1)
            normal = np.einsum("ij,ijk->ik", weights, self.normals[facet])
            normal /= np.linalg.norm(normal, axis=1)[:, None]
            o = np.einsum("ij,ijk->ik", weights, self.corners[facet])
            d = d - 2 * (d * normal).sum(1)[:, None] * normal
            o += 1e-6 * d
            bounces[rays] += 1
        back = (bounces == 3) & (np.linalg.norm(out + self.travel, axis=1) < np.radians(0.5))
        return inside, time.process_time() - begin, back.mean()


def bake(args, rays, threads):
    """Returns processor seconds, clock seconds of the bake, eta, and the peak of memory in MB."""
    command = [
        "/usr/bin/time",
        "-f",
        "%U %S %M",
        args.bake,
        "trace",
        args.mesh,
        "-o",
        args.table,
        "--normals",
        "file",
        "--json",
        "--incidence",
        str(args.incidence),
        "--sampler",
        "random",
        "--threads",
        str(threads),
        "--rays",
        str(rays),
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    user, system, peak = done.stderr.split()[-3:]
    report = json.loads(done.stdout)
    return (
        float(user) + float(system),
        report["seconds"],
        report["directions"][0]["retroreflected"],
        int(peak) / 1024,
    )


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("mesh")
    parser.add_argument("--bake", default="bake")
    parser.add_argument("--table", default=os.path.join(tempfile.gettempdir(), "curved-py.h5"))
    parser.add_argument("--incidence", type=float, default=20.0)
    parser.add_argument("--rays", type=int, default=1 << 20)
    parser.add_argument("--rounds", type=int, default=5)
    args = parser.parse_args()
    load = lambda: f"load {os.getloadavg()[0]:.1f}"
    start = time.perf_counter()
    sheet = Sheet(args.mesh, args.incidence)
    print(f"{len(sheet.corners)} facets; Embree: tree in {sheet.build_seconds:.1f} s, {load()}")
    rows, more = [], args.rays - FEW
    for turn in range(args.rounds):
        inside, whole, eta = sheet.trace(np.random.default_rng(turn), args.rays)
        few, one = bake(args, FEW, 1), bake(args, args.rays, 1)
        few_by_two, two = bake(args, FEW, 2), bake(args, args.rays, 2)
        rows.append(
            [
                args.rays / inside,
                args.rays / whole,
                more / (one[0] - few[0]),
                more / (two[1] - few_by_two[1]),
                few[0],
                one[3],
            ]
        )
        print(
            "round",
            turn,
            [f"{x / 1e6:.3f}" for x in rows[-1][:4]],
            f"M rays/s; eta {eta:.5f}, {one[2]:.5f}; {load()}",
            flush=True,
        )
    columns = list(zip(*rows))
    names = ["Embree, 1 thread", "with numpy", "bake, 1 thread", "bake, 2 threads, by the clock"]
    for name, column in zip(names, columns):
        print(
            f"{name}: {statistics.median(column) / 1e6:.3f} M rays/s "
            f"[{min(column) / 1e6:.3f}-{max(column) / 1e6:.3f}]"
        )
    ratio = [ours / embree for ours, embree in zip(columns[2], columns[0])]
    print(
        f"bake / Embree, 1 thread: {statistics.median(ratio):.2f} "
        f"[{min(ratio):.2f}-{max(ratio):.2f}]"
    )
    print(
        f"bake: {statistics.median(columns[4]):.1f} s to read the mesh, build the hierarchy "
        f"and trace {FEW} rays; "
        f"peak {max(columns[5]):.0f} MB"
    )
    print(f"all: {time.perf_counter() - start:.0f} s")


if __name__ == "__main__":
    main()
