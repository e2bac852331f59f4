#!/usr/bin/env python3
"""Measures the headline figures of `bake` and `fit`, and writes them as one page.

    python tests/bench_report.py target/release -o doc/measured.md

Each task is a whole process, start and files included. Seconds by the clock are medians of
`--rounds` runs with their range, the memory is the largest resident size. The studies at the end
are run once. A busy machine makes seconds long, so the page says the load before and after.
"""

import argparse
import concurrent.futures
import datetime
import os
import pathlib
import re
import shlex
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
CAMPAIGN = ROOT / "tests/captures/public_per_angle/captures.toml"
TABLE = "--refractive-index 1.49 --incidence 0:45:5 --azimuth 30"
RAYS = "--method rays --bins 128 --incidence 0,15,30,45 --rays 4194304"

# What is measured once the cells are there: a name, and the command line. Braces name files.
TASKS = [
    ("exact table, ten directions, pair of cubes", f"bake trace pair.obj -o pair.h5 {TABLE}"),
    (
        "exact table, ten directions, 2,048 unlike cubes",
        "bake trace unlike.obj -o unlike.h5 --incidence 0:45:5 --edge-length 3",
    ),
    ("rays, ideal cube, random points, 16.8 M", f"bake trace cube.obj -o r.h5 {RAYS} --sampler random"),
    ("rays, ideal cube, Sobol points, 16.8 M", f"bake trace cube.obj -o r.h5 {RAYS}"),
    ("rays, dihedral errors, 16.8 M", f"bake trace errors.obj -o r.h5 {RAYS}"),
    (
        "rays, Fresnel losses, 16.8 M",
        f"bake trace cube.obj -o r.h5 {RAYS} --refractive-index 1.49 --losses fresnel --back tir",
    ),
    ("rays, full cubes, dihedral errors, 16.8 M", f"bake trace full.obj -o r.h5 {RAYS}"),
    ("rays, rough facets, 16.8 M", f"bake trace cube.obj -o r.h5 {RAYS} --roughness 0.001"),
    (
        "rays, 998,784 curved facets, 2.1 M",
        "bake trace curved.obj -o r.h5 --method rays --normals file --incidence 20 --rays 2097152 "
        "--sampler random",
    ),
    ("`fit estimate`, 20 photographs", "fit estimate {campaign} --table pair.h5 -o result.json"),
    (
        "`fit estimate --loss mtf`, 20 photographs",
        "fit estimate {campaign} --table pair.h5 -o m.json --loss mtf",
    ),
    ("`fit predict`, two distances, ten angles", "fit predict result.json --table pair.h5 "
     "--distance 150,300 --incidence 0:45:5 -o mtf.csv"),
    ("`fit render`, 3840 x 2160 pixels in colour, to EXR", "fit render {scene} --source 4k.png -o a.exr"),
    ("`fit render`, 7680 x 4320 pixels in colour, to PNG", "fit render {scene} --source 8k.png -o a.png"),
    ("`fit explore` of a nominal sheet", "fit explore --sheet prism-0.1 --source {sign} --width 200 "
     "--distance 1000 --incidence 20 -o page.html"),
]

CELLS = {
    "pair": "triangular-pair",
    "cube": "triangular",
    "errors": "triangular --dihedral-error-mrad=0.5,0,-0.3",
    "full": "full-cube --dihedral-error-mrad=0.5,0,-0.3",
    "curved": "triangular-pair --sag 1e-4 --segments 408",
}


def words(args, line):
    """Returns the words of a command line, with programs and files in place."""
    names = {
        "campaign": CAMPAIGN,
        "sign": ROOT / "doc/sign.png",
        "scene": "--params result.json --table pair.h5 --distance 150 --incidence 20 --width 384",
    }
    program, *rest = shlex.split(line.format(**names))
    return [str(args.programs / program), *rest]


def timed(argv):
    """Runs a command. Returns seconds by the clock, of the processor, and megabytes."""
    begin = time.perf_counter()
    child = subprocess.Popen(argv, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    said = child.stderr.read().decode()
    _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode:
        raise SystemExit(f"{shlex.join(argv)}\n{said}")
    clock = time.perf_counter() - begin
    return clock, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def prepare(args):
    """Writes the cells and the pictures that the tasks take.

    It runs in a process of its own, because a child counts the memory of its parent as its own.
    """
    sys.path.insert(0, str(ROOT / "bake/doc"))
    import meshes
    import numpy as np
    from PIL import Image

    for name, design in CELLS.items():
        timed(words(args, f"bake design {design} -o {name}.obj"))
    corners, facets, _ = meshes.read("pair.obj")
    meshes.write("unlike.obj", *meshes.many(corners, facets, 32, 1e-4))
    sign = Image.open(ROOT / "doc/sign.png").convert("RGB")
    for name, size in (("4k.png", (3840, 2160)), ("8k.png", (7680, 4320))):
        grain = np.random.default_rng(2).integers(0, 32, (size[1], size[0], 3))
        Image.fromarray(
            np.minimum(np.asarray(sign.resize(size)) + grain, 255).astype("uint8")
        ).save(name)


def figure(values, digits):
    """Returns the median of values and their range."""
    low, high = min(values), max(values)
    return f"{statistics.median(values):.{digits}f} [{low:.{digits}f}-{high:.{digits}f}]"


def tasks(args, out):
    """Measures the seconds of every task."""
    out("| task | seconds | processor seconds | MB |\n| --- | --- | --- | --- |")
    for name, line in TASKS:
        if args.only and not re.search(args.only, name):
            continue
        rounds = [timed(words(args, line)) for _ in range(args.rounds)]
        clock, used, size = zip(*rounds)
        out(f"| {name} | {figure(clock, 3)} | {figure(used, 3)} | {max(size):.0f} |")


def study(args, out):
    """Draws campaigns: errors beside the Cramer-Rao bound, and coverage of 95 % intervals."""
    line = f"fit study --ranges {ROOT}/fit/doc/ranges.toml --table pair.h5 --seed 1 --csv trials.csv"
    done = subprocess.run(
        words(args, f"{line} --campaigns {args.campaigns}"), capture_output=True, text=True
    )
    if done.returncode:
        raise SystemExit(done.stderr)
    out(f"\n{args.campaigns} campaigns drawn from fit/doc/ranges.toml:\n\n```text")
    out(done.stdout.strip() + "\n```")


def machine():
    """Returns the processor, the cores and the load of this machine."""
    model = re.search(r"model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text())
    cores = len(os.sched_getaffinity(0))
    return f"{model[1] if model else 'unknown processor'}, {cores} cores, load {os.getloadavg()[0]:.1f}"


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("programs", help="folder of bake and fit")
    parser.add_argument("-o", "--output", help="page to write; it is printed as well")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--campaigns", type=int, default=1900, help="0: no study")
    parser.add_argument("--only", help="measure the tasks whose names match this expression")
    args = parser.parse_args()
    commit = subprocess.run(
        ["git", "-C", str(ROOT), "rev-parse", "--short", "HEAD"], capture_output=True, text=True
    ).stdout.strip()
    page = []

    def out(text):
        print(text, flush=True)
        page.append(text)

    out(
        f"# Measured figures\n\nWritten by `make bench-report` on {datetime.date.today()} at commit "
        f"{commit or 'unknown'}: {machine()}. Whole processes, medians of {args.rounds} rounds "
        "[smallest-largest].\n"
    )
    output = args.output and pathlib.Path(args.output).resolve()
    args.programs = pathlib.Path(args.programs).resolve()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        with concurrent.futures.ProcessPoolExecutor(1) as pool:
            pool.submit(prepare, args).result()
        tasks(args, out)
        if args.campaigns:
            study(args, out)
        os.chdir("/")
    out(f"\nLoad at the end: {os.getloadavg()[0]:.1f}.")
    if output:
        output.write_text("\n".join(page) + "\n")


if __name__ == "__main__":
    main()
