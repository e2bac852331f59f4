# Writes the weights that `fit evaluate --lpips` reads: python lpips_weights.py WEIGHTS.safetensors
# (pip install lpips safetensors)
import sys
import lpips
from safetensors.torch import save_file


def save(model, path):
    convolutions = [
        layer
        for s in range(1, 6)
        for layer in getattr(model.net, f"slice{s}")
        if hasattr(layer, "weight")
    ]
    tensors = {}
    for i, (convolution, linear) in enumerate(zip(convolutions, model.lins), 1):
        tensors |= {
            f"conv{i}.weight": convolution.weight,
            f"conv{i}.bias": convolution.bias,
            f"lin{i}.weight": linear.model[-1].weight,
        }
    save_file({name: tensor.detach().contiguous() for name, tensor in tensors.items()}, path)


if __name__ == "__main__":
    save(lpips.LPIPS(net="alex", version="0.1", verbose=False), sys.argv[1])
