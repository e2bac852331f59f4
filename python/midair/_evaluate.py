"""How alike two pictures look, by the packages that papers cite."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
import numpy.typing as npt

from midair._errors import Error, warn
from midair._picture import Picture, picture, planes
from midair._words import File

EXTRA = 'pip install "midair[evaluate]"'


@dataclass(frozen=True)
class Scores:
    """How alike two pictures look.

    Attributes
    ----------
    psnr_db : float
        Peak signal-to-noise ratio over all colours, dB (scikit-image); infinite for equal pictures.
    ssim : float
        Structural similarity of Wang et al. 2004, Gaussian window of standard deviation 1.5 pixels,
        mean over the colours (scikit-image); 1 for equal pictures.
    flip : float
        Mean FLIP error of Andersson et al. 2020 (flip-evaluator); 0 for equal pictures.
    lpips : float or None
        LPIPS distance of Zhang et al. 2018, AlexNet, version 0.1 (lpips); None without the package
        or without weights.
    """

    psnr_db: float
    ssim: float
    flip: float
    lpips: float | None


def evaluate(
    rendered: Picture | File,
    photograph: Picture | File,
    *,
    exposure: float = 1.0,
    pixels_per_degree: float = 67.02064,
    transfer: str | None = None,
    network: Callable[[Any, Any], Any] | None = None,
) -> Scores:
    """Compare a rendered picture with a photograph of the same thing, size and place.

    The pictures are compared as a display shows them: the light times `exposure`, clipped to 0..1,
    as sRGB.

    Parameters
    ----------
    rendered, photograph : path or array
        Files, or arrays of linear light of shape (rows, columns) or (rows, columns, 3).
    exposure : float
        Factor on the light of both pictures.
    pixels_per_degree : float
        Pixels in one degree of view, for FLIP. The default is that of its authors: a display of
        3840 pixels in 0.7 m, seen from 0.7 m.
    transfer : {"linear", "srgb"}, optional
        Meaning of integers in files; without it each file decides.
    network : callable, optional
        LPIPS network. Without it the one of the package lpips is taken, if its weights are there.

    Raises
    ------
    Error
        If the pictures differ in size, are smaller than the window of SSIM (11 x 11 pixels), or the
        packages are not installed.
    """
    try:
        metrics: Any = import_module("skimage.metrics")
        flip: Any = import_module("flip_evaluator")
    except ImportError as missing:
        raise Error(f"evaluate: needs {missing.name}; {EXTRA} brings it") from None
    shown = [
        _shown(one, name, exposure, transfer)
        for one, name in ((rendered, "rendered"), (photograph, "photograph"))
    ]
    a, b = shown
    if a.shape != b.shape:
        sizes = " and ".join(f"{one.shape[1]} x {one.shape[0]}" for one in shown)
        raise Error(f"evaluate: the pictures have {sizes} pixels; crop one to the size of the other")
    if min(a.shape[:2]) < 11:
        raise Error("evaluate: SSIM needs 11 x 11 pixels; compare a larger part")
    same = np.array_equal(a, b)
    ssim = metrics.structural_similarity(
        a,
        b,
        gaussian_weights=True,
        sigma=1.5,
        use_sample_covariance=False,
        data_range=1.0,
        channel_axis=2,
    )
    ppd = {"ppd": float(pixels_per_degree)}
    error = flip.evaluate(b, a, "LDR", inputsRGB=True, applyMagma=False, parameters=ppd)[1]
    return Scores(
        psnr_db=math.inf if same else float(metrics.peak_signal_noise_ratio(b, a, data_range=1.0)),
        ssim=float(ssim),
        flip=float(error),
        lpips=_lpips(a, b, network),
    )


def _shown(
    one: Picture | File, name: str, exposure: float, transfer: str | None
) -> npt.NDArray[np.float32]:
    """Return what a display shows of a picture: sRGB values, shape (rows, columns, 3)."""
    light = picture(one, transfer) if isinstance(one, (str, os.PathLike)) else one
    _, colours, _ = planes(light, name)
    light = np.clip(exposure * np.moveaxis(colours, 0, -1), 0.0, 1.0)
    light = np.broadcast_to(light, (*light.shape[:2], 3))
    curve = 1.055 * np.maximum(light, 0.0031308) ** (1 / 2.4) - 0.055
    return np.where(light <= 0.0031308, 12.92 * light, curve).astype(np.float32)


def _lpips(a: npt.NDArray[Any], b: npt.NDArray[Any], network: Any) -> float | None:
    """Return the LPIPS distance, or warn in one sentence and return None."""
    try:
        torch: Any = import_module("torch")
        if network is None:
            network = import_module("lpips").LPIPS(net="alex", version="0.1", verbose=False)
        pair = [torch.from_numpy(2 * np.moveaxis(one, -1, 0)[None] - 1) for one in (a, b)]
        with torch.no_grad():
            return float(network(*pair))
    except Exception as reason:  # a missing package, or weights that cannot be loaded
        warn([f"LPIPS is left out: {reason}; the packages torch and lpips bring it"], stacklevel=4)
        return None
