#!/usr/bin/env python3
"""How near the tracing kernels of bake come to the limits of the processor.

    python roofline.py --bake path/to/bake [--mesh one.obj]

`--mesh` names a mesh of many facets that goes down the hierarchy. Needs valgrind and a C compiler.
For each cell:

- **Work of a ray**: valgrind's tool lackey counts operations and bytes of two bakes that differ in
  their number of rays only. The difference, divided by the rays, is the work of one ray. valgrind
  knows AVX2, so vectors of 256 bits are counted, as four lanes of 64 bits each.
- **Limits**: a C program measures how many lanes of 64 bits one core adds and multiplies each
  second with the widest vectors that it has, and how many bytes it copies within its first cache.
- **Speed**: rays per second of processor time of the same bake with more rays, one thread.

The shares say how much of each limit the kernel uses. What is left goes to instructions that no
vector has (histograms, masks, sorting) and to waiting for one another.
"""

import argparse
import os
import re
import resource
import shutil
import statistics
import subprocess
import tempfile

ERRORS = ["--dihedral-error-mrad=0.5,0,-0.3"]
FRESNEL = ["--losses", "fresnel", "--back", "tir", "--refractive-index", "1.49"]
CURVED = ["triangular-pair", "--sag", "1e-4", "--segments", "40"]
# Name, design, options of the bake, and how many times fewer rays are counted and timed.
CASES = [
    ("ideal cube", ["triangular"], [], 1),
    ("dihedral errors", ["triangular", *ERRORS], [], 1),
    ("Fresnel losses", ["triangular"], FRESNEL, 1),
    ("full cubes, lattice, dihedral errors", ["full-cube", *ERRORS], [], 1),
    ("rough facets", ["triangular"], ["--roughness", "0.001"], 4),
    ("9,600 curved facets", CURVED, ["--normals", "file"], 4),
]

LIMITS = r"""
#include <stdio.h>
#include <time.h>
// Twelve vectors must fit in the registers.
#ifdef __AVX512F__
#define LANES 8
#else
#define LANES 4
#endif
typedef double lanes __attribute__((vector_size(8 * LANES)));
static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}
int main(void) {
    lanes a[12];
    for (int k = 0; k < 12; k++) for (int i = 0; i < LANES; i++) a[k][i] = 1.0 + 0.01 * (k + i);
    const double by = 0.999999999, more = 1e-9;
    double best = 0.0, sum = 0.0;
    for (int round = 0; round < 7; round++) {
        long steps = 20000000;
        double start = now();
        for (long n = 0; n < steps; n++)
            for (int k = 0; k < 12; k++) a[k] = k % 2 ? a[k] * by : a[k] + more;
        double rate = 12.0 * LANES * steps / (now() - start);
        if (rate > best) best = rate;
        for (int k = 0; k < 12; k++) sum += a[k][0];
    }
    printf("%g ", best);
    static volatile double from[1024], to[1024];
    best = 0.0;
    for (int round = 0; round < 7; round++) {
        long steps = 2000000;
        double start = now();
        for (long n = 0; n < steps; n++) {
            __builtin_memcpy((void *)to, (void *)from, sizeof to);
            __asm__ volatile("" ::: "memory");
        }
        double rate = 2.0 * sizeof to * steps / (now() - start);
        if (rate > best) best = rate;
    }
    printf("%g\n", best);
    return sum == 0.0;
}
"""

#: Bytes, and lanes of 64 bits, of the types that lackey tells apart.
BYTES = {"I8": 1, "I16": 2, "I32": 4, "I64": 8, "F32": 4, "F64": 8, "V128": 16, "V256": 32}
LANES = {"F64": 1, "V128": 2, "V256": 4}


def limits(folder):
    """Returns lanes of 64 bits per second, and bytes copied in the first cache per second."""
    source, program = os.path.join(folder, "limits.c"), os.path.join(folder, "limits")
    with open(source, "w") as out:
        out.write(LIMITS)
    flags = ["-O3", "-march=native", "-ffp-contract=off", "-mprefer-vector-width=512"]
    subprocess.run(["cc", *flags, source, "-o", program], check=True)
    told = subprocess.run([program], check=True, capture_output=True, text=True).stdout
    return [float(word) for word in told.split()]


def command(args, mesh, trace, rays):
    """Returns the command of a bake of one direction by random points."""
    index = [] if "--refractive-index" in trace else ["--refractive-index", "1"]
    place = ["--incidence", "20", "--azimuth", "0", "--method", "rays", "--sampler", "random"]
    table = os.path.splitext(mesh)[0] + ".h5"
    count = ["--rays", str(rays), "--threads", "1"]
    return [args.bake, "trace", mesh, "-o", table, *index, *trace, *place, *count]


def work(words):
    """Returns lanes of arithmetic, other operations, and bytes of a command."""
    told = subprocess.run(
        ["valgrind", "--tool=lackey", "--detailed-counts=yes", *words],
        check=True,
        capture_output=True,
        text=True,
    ).stderr
    lanes = scalar = moved = 0
    for line in told.splitlines():
        found = re.match(r"==\d+==\s+([IFV]\d+)\s+([\d,]+)\s+([\d,]+)\s+([\d,]+)", line)
        if found:
            loads, stores, operations = (int(n.replace(",", "")) for n in found.groups()[1:])
            moved += (loads + stores) * BYTES.get(found[1], 0)
            if found[1] in LANES:
                lanes += operations * LANES[found[1]]
            else:
                scalar += operations
    return lanes, scalar, moved


def seconds(words):
    """Returns the processor time of a command, in seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(words, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--bake", default="bake", help="program to measure")
    parser.add_argument("--mesh", help="mesh of many facets, for a row of its own")
    parser.add_argument("--only", default="", help="cases whose names contain this text")
    parser.add_argument("--rounds", type=int, default=5, help="rounds of each time")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        peak, copied = limits(folder)
        print(f"one core: {peak / 1e9:.1f} G lanes/s, {copied / 1e9:.0f} GB/s in the first cache\n")
        heads = "lanes", "other operations", "bytes", "M rays/s", "of the lanes", "of the bytes"
        print("| cell | " + " | ".join(heads) + " |")
        print("| --- | --- | --- | --- | --- | --- | --- |")
        cases = [*CASES, (args.mesh, None, [], 4)] if args.mesh else CASES
        for name, design, trace, fewer in cases:
            if args.only not in name:
                continue
            mesh = os.path.join(folder, "cell.obj")
            if design:
                subprocess.run([args.bake, "design", *design, "-o", mesh], check=True)
            else:
                shutil.copy(name, mesh)
            few, some, count = (rays // fewer for rays in (1 << 17, 5 << 17, 1 << 25))
            both = [work(command(args, mesh, trace, rays)) for rays in (few, some)]
            lanes, scalar, moved = ((b - a) / (some - few) for a, b in zip(*both))
            longer = [seconds(command(args, mesh, trace, count)) for _ in range(args.rounds)]
            start = [seconds(command(args, mesh, trace, few)) for _ in range(args.rounds)]
            rate = (count - few) / (statistics.median(longer) - statistics.median(start))
            label = os.path.basename(name)
            print(
                f"| {label} | {lanes:.0f} | {scalar:.0f} | {moved:.0f} | {rate / 1e6:.3g} "
                f"| {100 * lanes * rate / peak:.0f} % | {100 * moved * rate / copied:.0f} % |"
            )


if __name__ == "__main__":
    main()
