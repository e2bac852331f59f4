# Prints the reference values of metrics.rs: python metrics.py
#
# With the program `fit` as an argument, it also runs that program and compares the values. With a
# second argument it writes the seeded weights to that path.
# pip install numpy scikit-image flip-evaluator torch torchvision lpips safetensors
import json
import pathlib
import subprocess
import sys
import tempfile

import lpips
import numpy as np
import torch
from flip_evaluator import flip_python_api as flip
from PIL import Image
from skimage.metrics import peak_signal_noise_ratio, structural_similarity

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "doc"))
import lpips_weights

y, x = np.mgrid[0:40, 0:48]


def picture(k):
    r = (x * 5 + y * 3 + k * ((x * y) % 17)) % 256
    g = (x * 2 + y * 7 + k * ((x + 2 * y) % 23)) % 256
    b = (x * x + y + k * ((3 * x + y) % 29)) % 256
    return np.stack([r, g, b], -1) / 255.0


def random(count, place):
    h = np.arange(count, dtype=np.uint32) * np.uint32(2654435761) + np.uint32(place * 40503)
    h ^= h >> np.uint32(15)
    h *= np.uint32(2246822519)
    h ^= h >> np.uint32(13)
    return h.astype(np.float64) / 2**32


a, b = picture(0), picture(2)
values = {"psnr_db": peak_signal_noise_ratio(a, b, data_range=1.0)}
options = dict(
    gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1.0, channel_axis=2
)
values["ssim"] = structural_similarity(a, b, **options)
options = dict(
    inputsRGB=True, applyMagma=False, computeMeanError=True, parameters={"ppd": 67.02064}
)
values["flip"] = flip.evaluate(a.astype(np.float32), b.astype(np.float32), "LDR", **options)[1]

model = lpips.LPIPS(
    net="alex", version="0.1", pretrained=False, pnet_rand=True, verbose=False
).eval()
convolutions = [
    layer
    for s in range(1, 6)
    for layer in getattr(model.net, f"slice{s}")
    if hasattr(layer, "weight")
]
place = 0
with torch.no_grad():
    for convolution, linear in zip(convolutions, model.lins):
        inputs = convolution.weight[0].numel()
        scales = [lambda r: (r - 0.5) * 4 / np.sqrt(inputs), lambda r: 0.1 * (r - 0.5), lambda r: r]
        for tensor, scale in zip(
            [convolution.weight, convolution.bias, linear.model[-1].weight], scales
        ):
            place += 1
            tensor.copy_(
                torch.from_numpy(scale(random(tensor.numel(), place)).astype(np.float32)).reshape(
                    tensor.shape
                )
            )
    as_tensor = lambda p: torch.from_numpy(p.astype(np.float32)).permute(2, 0, 1)[None]
    values["lpips"] = model(as_tensor(a), as_tensor(b), normalize=True).item()
print(values)

# The limits are those of metrics.rs, except 1e-4 for LPIPS.
if len(sys.argv) > 1:
    program = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as folder:
        for name, image in [("a.png", a), ("b.png", b)]:
            Image.fromarray(np.round(255 * image).astype(np.uint8)).save(f"{folder}/{name}")
        weights = pathlib.Path(
            sys.argv[2] if len(sys.argv) > 2 else f"{folder}/weights.safetensors"
        ).resolve()
        lpips_weights.save(model, weights)
        command = [program, "evaluate", "a.png", "b.png", "--lpips", weights, "--json"]
        said = json.loads(
            subprocess.run(command, cwd=folder, check=True, stdout=subprocess.PIPE).stdout
        )
    limits = {"psnr_db": 4e-5, "ssim": 1e-5, "flip": 1e-3, "lpips": 1e-4}
    off = {name: abs(said[name] - values[name]) for name in limits}
    print(f"{program.name} evaluate differs by", off)
    sys.exit(any(off[name] > limit for name, limit in limits.items()))
