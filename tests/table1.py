"""Repeats the published comparison: two sheets, three pictures, two distances, four models.

    python tests/table1.py BIN_FOLDER OUT_FOLDER [--seeded-lpips]

It needs the package midair with its extra `evaluate`. LPIPS is scored where torch, lpips and its
weights are there; with --seeded-lpips by random weights, which only show that it is scored.

All models are fitted to the same photographs of edges. The truth is wave optics of the cubes
(kernel wave) in the light of an LED, photographed with camera noise. No fitted model has this
physics here: the proposed model is fitted without the wavelength. The script writes table.csv,
table.md and pictures.png into OUT_FOLDER.
"""

import json
import re
import struct
import subprocess
import sys
import warnings
import zlib
from pathlib import Path

import midair
import numpy as np

SHEETS = {"A": {"c": 0.40, "mu": 0.5}, "B": {"c": 0.18, "mu": 0.3}}
LIGHT = "520:0.25,535:0.5,550:0.25"  # green LED: wavelength in nm, and weight
DISTANCES = [150, 300]
INCIDENCE, AZIMUTH, PITCH_MM = 20, 30, 0.1
MODELS = ["proposed", "saito", "guo", "mrm"]
SCORES = {"psnr_db": "PSNR (dB)", "ssim": "SSIM", "flip": "FLIP", "lpips": "LPIPS"}
HIGHER_IS_BETTER = {"psnr_db", "ssim"}
WIDTH, HEIGHT = 384, 288
FULL_WELL, READ_NOISE = 20_000, 3  # electrons


# ---- Pictures. Arrays hold linear light, in the shape (rows, columns, 3). Files are 16-bit PNG.


def write_png(path, image, bits=16):
    height, width, _ = image.shape
    kind = ">u2" if bits == 16 else "u1"
    pixels = np.round(np.clip(image, 0, 1) * (2**bits - 1)).astype(kind)
    pixels = np.ascontiguousarray(pixels).view(np.uint8).reshape(height, width, -1)
    lines = b"".join(b"\1" + np.diff(row, axis=0, prepend=np.uint8(0)).tobytes() for row in pixels)
    chunk = lambda name, data: (
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    )
    head = struct.pack(">IIBBBBB", width, height, bits, 2, 0, 0, 0)
    data = chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(lines, 9)) + chunk(b"IEND", b"")
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + data)


def read(path):
    return midair.picture(path)


def srgb(light):
    light = np.clip(light, 0, 1)
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


GLYPHS = {  # letters of 5 x 7 pixels: two hexadecimal digits for each row
    "A": "0E11111F111111",
    "I": "0E04040404040E",
    "R": "1E11111E141211",
    "E": "1F10101E10101F",
    "X": "11110A040A1111",
    "T": "1F040404040404",
    "2": "0E11010204081F",
    "5": "1F101E0101110E",
    "G": "0E11101711110F",
    "O": "0E11111111110E",
    "K": "11121418141211",
    "S": "0F10100E01011E",
    " ": "00" * 7,
}


def write_text(image, text, left, top, size, colour):
    for letter in text:
        rows = [int(GLYPHS[letter][i : i + 2], 16) for i in range(0, 14, 2)]
        bitmap = np.array([[row >> (4 - x) & 1 for x in range(5)] for row in rows], bool)
        mask = np.kron(bitmap, np.ones((size, size), bool))
        image[top : top + 7 * size, left : left + 5 * size][mask] = colour
        left += 6 * size


def sign():
    image = np.full((HEIGHT, WIDTH, 3), [0.0, 0.02, 0.12])
    image[12:-12, 12:-12] = [0.0, 0.35, 0.08]
    white = [0.95, 0.95, 0.95]
    write_text(image, "EXIT", 30, 36, 9, white)
    write_text(image, "GATE 25", 30, 120, 6, [0.95, 0.8, 0.05])
    write_text(image, "TAKE EXIT 52 AT GATE 2", 30, 186, 2, white)
    write_text(image, "TAKE EXIT 52 AT GATE 2", 30, 212, 1, white)
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    arrow = (abs(y - 68) < 36 - (x - 300)) & (x > 300) | (
        (abs(y - 68) < 12) & (x > 262) & (x <= 300)
    )
    image[arrow] = white
    return image


def natural():
    """Returns a natural scene: land and sky of fractal noise, and three shaded spheres."""
    random = np.random.default_rng(7)
    y, x = np.mgrid[:HEIGHT, :WIDTH] / WIDTH
    noise = np.zeros_like(x)
    for octave in range(1, 8):
        n = 2**octave
        grid = random.standard_normal((n + 2, n + 2))
        u, v = x * n, y * n
        i, j = u.astype(int), v.astype(int)
        smooth = lambda t: t * t * (3 - 2 * t)
        a, b = smooth(u - i), smooth(v - j)
        low = grid[j, i] * (1 - a) + grid[j, i + 1] * a
        high = grid[j + 1, i] * (1 - a) + grid[j + 1, i + 1] * a
        noise += (low * (1 - b) + high * b) / 1.7**octave
    land = (y > 0.38 + 0.06 * noise)[..., None]
    shade = (0.5 + 0.35 * np.tanh(noise))[..., None]
    image = np.where(land, shade * [0.25, 0.45, 0.12], (1 - 0.4 * shade) * [0.35, 0.55, 0.9])
    for cx, cy, r, colour in [
        (0.25, 0.5, 0.12, [0.9, 0.12, 0.08]),
        (0.55, 0.57, 0.09, [0.95, 0.6, 0.05]),
        (0.8, 0.45, 0.14, [0.5, 0.2, 0.7]),
    ]:
        dx, dy = (x - cx) / r, (y - cy) / r
        inside = dx**2 + dy**2 < 1
        z = np.sqrt(np.maximum(0, 1 - dx**2 - dy**2))
        light = np.clip(0.15 + 0.85 * (0.5 * z - 0.5 * dx - 0.6 * dy), 0.04, 1) * (
            1 + 0.2 * np.tanh(2 * noise)
        )
        image[inside] = (light[..., None] * colour)[inside]
    return np.clip(image, 0, 0.95)


def chart():
    """Returns a test chart: a star of 36 rays, and bars of 0.25 to 2.5 line pairs per mm."""
    y, x = np.mgrid[:HEIGHT, :WIDTH].astype(float)
    image = np.full((HEIGHT, WIDTH), 0.9)
    dx, dy = x - 130, y - 144
    star = np.sin(36 * np.arctan2(dy, dx)) > 0
    image[(np.hypot(dx, dy) < 120) & star] = 0.02
    top = 20
    for period in [40, 28, 20, 14, 10, 7, 5, 4]:
        rows = (y >= top) & (y < top + 26)
        image[rows & (x >= 265) & (x < 318) & ((x - 265) % period < period / 2)] = 0.02
        image[rows & (x >= 325) & (x < 375) & ((y - top) % period < period / 2)] = 0.02
        top += 32
    return np.repeat(image[..., None], 3, axis=2)


# ---- The programs.


def run(program, *arguments, cwd):
    done = subprocess.run([program, *map(str, arguments)], cwd=cwd, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{program} {' '.join(map(str, arguments))}\n{done.stderr}")
    return done.stdout


def parameters(sheet, seed):
    text = f"""seed = {seed}
[camera]
width = 384
height = 256
pixel_pitch_mm = {PITCH_MM}
[truth]
kernel = "wave"
wavelength_nm = "{LIGHT}"
refractive_index = 1.49
pair = true
c = {sheet["c"]}
mu = {sheet["mu"]}
"""
    for incidence in [0, INCIDENCE, 40]:
        for distance in DISTANCES:
            for normal in [5, 97]:
                text += f"""[[capture]]
floating_distance_mm = {distance}.0
incidence_deg = {incidence}.0
azimuth_deg = {AZIMUTH}.0
edge_normal_deg = {normal}.0
exposure = 4.0
"""
    return text


def seeded():
    import lpips
    import torch

    torch.manual_seed(1)
    network = lpips.LPIPS(net="alex", pretrained=False, pnet_rand=True, verbose=False)
    return network.eval()


def main():
    programs, out = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
    network = seeded() if "--seeded-lpips" in sys.argv else None
    work = programs.parent / "table1"
    out.mkdir(parents=True, exist_ok=True)
    work.mkdir(parents=True, exist_ok=True)
    bake = lambda *a: run(programs / "bake", *a, cwd=work)
    fit = lambda *a: run(programs / "fit", *a, cwd=work)
    bake("design", "triangular-pair", "-o", "pair.obj")
    bake(
        "trace",
        "pair.obj",
        "-o",
        "pair.h5",
        "--refractive-index",
        1.49,
        "--incidence",
        f"0,{INCIDENCE},40",
        "--azimuth",
        AZIMUTH,
    )
    contents = {"sign": sign(), "natural": natural(), "chart": chart()}
    for name, image in contents.items():
        write_png(work / f"{name}.png", image)
    random = np.random.default_rng(2025)
    scores, notes, pictures, fits = {}, {}, [], []
    for number, (name, sheet) in enumerate(SHEETS.items()):
        (work / f"{name}.toml").write_text(parameters(sheet, 100 + number))
        fit("simulate", f"{name}.toml", "-o", f"photos_{name}", "--force")
        manifest = work / f"photos_{name}/captures.toml"
        # The fits do not get the wavelength, so only the truth has wave optics.
        blind = re.sub(r"(?m)^wavelength_nm.*\n", "", manifest.read_text())
        (manifest.parent / "blind.toml").write_text(blind)
        for model in MODELS:
            fit(
                "estimate",
                manifest.parent / "blind.toml",
                "--table",
                "pair.h5",
                "--model",
                model,
                "--lobe",
                "auto",
                "-o",
                f"{name}_{model}.json",
            )
            fits.append((name, model, json.loads((work / f"{name}_{model}.json").read_text())))
        fit(
            "estimate",
            manifest,
            "--table",
            "pair.h5",
            "--kernel",
            "wave",
            "--shared",
            "mu",
            "-o",
            f"{name}_truth.json",
        )
        truth = json.loads((work / f"{name}_truth.json").read_text())
        truth["c_mm"], truth["mu"] = (
            {"value": sheet[key], "standard_error": None} for key in ("c", "mu")
        )
        (work / f"{name}_truth.json").write_text(json.dumps(truth))
        place = ["--table", "pair.h5", "--incidence", INCIDENCE, "--azimuth", AZIMUTH]
        seen = json.loads(
            fit(
                "predict",
                f"{name}_truth.json",
                *place,
                "--distance",
                150,
                "--frequency",
                0,
                "--json",
            )
        )
        exposure = 0.9 / seen["predictions"][0]["luminance"]
        for distance in DISTANCES:
            for content in contents:
                at = [
                    *place,
                    "--distance",
                    distance,
                    "--pixel-pitch",
                    PITCH_MM,
                    "--exposure",
                    exposure,
                ]
                render = lambda who, to: fit(
                    "render",
                    "--source",
                    f"{content}.png",
                    "--params",
                    f"{name}_{who}.json",
                    *at,
                    "-o",
                    to,
                )
                render("truth", "light.png")
                electrons = random.poisson(
                    read(work / "light.png") * FULL_WELL
                ) + READ_NOISE * random.standard_normal((HEIGHT, WIDTH, 3))
                write_png(work / "photo.png", electrons / FULL_WELL)
                row = [read(work / "photo.png")]
                for model in MODELS:
                    render(model, "model.png")
                    pair = [work / "model.png", work / "photo.png"]
                    with warnings.catch_warnings(record=True) as told:
                        warnings.simplefilter("always")
                        score = midair.evaluate(*pair, network=network)
                    sentences = (str(one.message) for one in told)
                    notes |= dict.fromkeys(one for one in sentences if "left out" in one)
                    scores[name, distance, model, content] = score
                    row.append(read(work / "model.png"))
                if name == "A" and (content != "natural" or distance == 150):
                    pictures.append(np.concatenate([picture[::2, ::2] for picture in row], axis=1))
                print(f"sheet {name}, {distance} mm, {content}: done", file=sys.stderr)
    write_tables(out, scores, list(notes), fits)
    write_png(out / "pictures.png", srgb(np.concatenate(pictures, axis=0)), bits=8)


def write_tables(out, scores, notes, fits):
    table = midair.Comparison(scores, {}, notes)
    (out / "table.csv").write_text(table.csv())
    lines = [str(table)]
    behind, cells = [], 0
    for place in dict.fromkeys((name, distance, content) for name, distance, _, content in scores):
        name, distance, content = place
        for kind, title in SCORES.items():
            values = {m: getattr(scores[name, distance, m, content], kind) for m in MODELS}
            if None in values.values():
                continue
            best = (max if kind in HIGHER_IS_BETTER else min)(values, key=values.get)
            cells += 1
            if best != "proposed":
                behind.append(f"sheet {name}, {distance} mm, {content}, {title}: {best}")
    lines += [
        f"Proposed model ahead in {cells - len(behind)} of {cells} cells."
        + "".join(f"\n- behind: {b}" for b in behind),
        "",
    ]
    lines += [
        "| sheet | model | kernel | lobe | chi-square | parameters of the blur |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for name, model, result in fits:
        least = min(
            result["candidates"],
            key=lambda row: (
                row["criterion"]
                if row["kernel"] == result["kernel"] and row["lobe"] == result["lobe"]
                else 1e300
            ),
        )
        lines.append(
            f"| {name} | {model} | {result['kernel']} | {result['lobe'] or '-'} "
            f"| {least['loss']:.0f} | {least['parameters']} |"
        )
    (out / "table.md").write_text("\n".join(lines) + "\n")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
