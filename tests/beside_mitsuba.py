"""Times the published loop in Mitsuba 3 / Dr.Jit beside `fit study --forward render`, in turns.

    python beside_mitsuba.py --peer mitsuba_fit.py --fit target/release/fit \
        --bake target/release/bake

--peer names a script that runs the published loop in Mitsuba. The script takes the arguments `time
--size 512 --spp 256 --tuned` and prints one line of JSON with forward_backward_s (seconds),
grad_mean and grad_std (each by a, then by c). It runs under this interpreter, which must have the
package mitsuba. DRJIT_LIBLLVM_PATH must name the LLVM library. fit/doc/loop.toml describes the
photographs. The output is a table; with --json a line of JSON follows it.
"""

import argparse, json, os, pathlib, subprocess, sys, tempfile

HERE = pathlib.Path(__file__).resolve().parent.parent
ADAM = 200

ap = argparse.ArgumentParser()
ap.add_argument("--peer", required=True)
ap.add_argument("--fit", default=HERE / "target/release/fit")
ap.add_argument("--bake", default=HERE / "target/release/bake")
ap.add_argument("--rounds", type=int, default=1)
ap.add_argument("--samples", default="16,256")
ap.add_argument("--randomisations", type=int, default=4)
ap.add_argument("--json", action="store_true")
args = ap.parse_args()


def run(*words, **keys):
    done = subprocess.run([str(w) for w in words], capture_output=True, text=True, **keys)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, words))}\n{done.stderr}")
    return done.stdout


def median(values):
    return sorted(values)[len(values) // 2]


with tempfile.TemporaryDirectory() as folder:
    bake, fit = map(lambda p: pathlib.Path(p).resolve(), (args.bake, args.fit))
    run(bake, "design", "triangular", "-o", "cube.obj", cwd=folder)
    run(
        bake,
        "trace",
        "cube.obj",
        "-o",
        "cube.h5",
        "--incidence",
        "0:45:5",
        "--azimuth",
        "180",
        cwd=folder,
    )
    run(fit, "simulate", HERE / "fit/doc/loop.toml", "-o", "photographs", cwd=folder)
    peers, ours = [], []
    for _ in range(args.rounds):
        peers.append(
            json.loads(
                run(sys.executable, args.peer, "time", "--size", 512, "--spp", 256, "--tuned")
            )
        )
        ours.append(
            json.loads(
                run(
                    fit,
                    "study",
                    "photographs/captures.toml",
                    "--table",
                    "cube.h5",
                    "--kernel",
                    "eq1",
                    "--lobe",
                    "separable",
                    "--shared",
                    "a,mu",
                    "--forward",
                    "render",
                    "--samples",
                    args.samples,
                    "--randomisations",
                    args.randomisations,
                    "--json",
                    cwd=folder,
                )
            )
        )
    peer = median([p["forward_backward_s"]["median"] for p in peers])
    noise = [median([p["grad_std"][k] / abs(p["grad_mean"][k]) for p in peers]) for k in (0, 1)]
    first = ours[0]
    angles = first["photographs"]
    print(
        f"Mitsuba, value and both derivatives, one angle: {peer:.3f} s; "
        f"gradient noise by a {noise[0]:.2%}, by c {noise[1]:.2%}"
    )
    print(
        f"its {ADAM} Adam iterations over {angles} angles, from that: {ADAM * angles * peer:.0f} s"
    )
    spectral = median([o["spectral_seconds"] for o in ours])
    print(
        f"closed form, whole estimate: {spectral:.4f} s, "
        f"{ADAM * angles * peer / spectral:,.0f} times faster"
    )
    rows = []
    for i, row in enumerate(first["rows"]):
        middle = lambda key: median([o["rows"][i][key] for o in ours])
        one = middle("seconds_to_evaluate") / angles
        rows.append(
            dict(
                sequence=row["sequence"],
                samples=row["samples"],
                evaluate_one_angle=one,
                times_faster=peer / one,
                draw_one_angle=middle("seconds_to_draw") / angles,
                gradient_noise=row["gradient_noise"],
                errors=row["errors"],
                estimate=middle("seconds"),
                times_faster_estimate=ADAM * angles * peer / middle("seconds"),
                iterations=row["iterations"],
            )
        )
        r = rows[-1]
        print(
            f"{r['sequence']:<12}{r['samples']:>5} a pixel: {one:.4f} s an angle, "
            f"{r['times_faster']:.1f} x; gradient noise by a {r['gradient_noise'][0]:.3%}, "
            f"by c {r['gradient_noise'][1]:.3%}; estimate {r['estimate']:.2f} s, "
            f"{r['times_faster_estimate']:.0f} x, off by {r['errors']['c']:.4%} in c, "
            f"{r['errors']['a']:.4%} in a"
        )
    if args.json:
        print(json.dumps(dict(mitsuba=peers, fit=ours, summary=rows, load=os.getloadavg())))
