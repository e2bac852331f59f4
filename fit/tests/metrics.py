# The values that metrics.rs compares with: python metrics.py
# pip install numpy scikit-image flip-evaluator torch torchvision lpips
import lpips
import numpy as np
import torch
from flip_evaluator import flip_python_api as flip
from skimage.metrics import peak_signal_noise_ratio, structural_similarity

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
print("PSNR", peak_signal_noise_ratio(a, b, data_range=1.0))
options = dict(gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1.0, channel_axis=2)
print("SSIM", structural_similarity(a, b, **options))
options = dict(inputsRGB=True, applyMagma=False, computeMeanError=True, parameters={"ppd": 67.02064})
print("FLIP", flip.evaluate(a.astype(np.float32), b.astype(np.float32), "LDR", **options)[1])

model = lpips.LPIPS(net="alex", version="0.1", pretrained=False, pnet_rand=True, verbose=False).eval()
convolutions = [layer for s in range(1, 6) for layer in getattr(model.net, f"slice{s}") if hasattr(layer, "weight")]
place = 0
with torch.no_grad():
    for convolution, linear in zip(convolutions, model.lins):
        inputs = convolution.weight[0].numel()
        scales = [lambda r: (r - 0.5) * 4 / np.sqrt(inputs), lambda r: 0.1 * (r - 0.5), lambda r: r]
        for tensor, scale in zip([convolution.weight, convolution.bias, linear.model[-1].weight], scales):
            place += 1
            tensor.copy_(torch.from_numpy(scale(random(tensor.numel(), place)).astype(np.float32)).reshape(tensor.shape))
    as_tensor = lambda p: torch.from_numpy(p.astype(np.float32)).permute(2, 0, 1)[None]
    print("LPIPS", model(as_tensor(a), as_tensor(b), normalize=True).item())
