"""How alike two pictures look, by the packages that papers cite."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import Any

import numpy as np
import numpy.typing as npt

from midair._errors import Error, warn
from midair._picture import Picture
from midair._register import EXTRA, colours
from midair._words import File


@dataclass(frozen=True)
class Scores:
    """How alike two pictures look. A score is None without its package.

    Attributes
    ----------
    psnr_db : float
        Peak signal-to-noise ratio over all colours, dB; infinite for equal pictures.
    ssim : float or None
        Structural similarity of Wang et al. 2004, Gaussian window of standard deviation 1.5 pixels,
        mean over the colours (scikit-image); 1 for equal pictures.
    flip : float or None
        Mean FLIP error of Andersson et al. 2020 (flip-evaluator); 0 for equal pictures.
    lpips : float or None
        LPIPS distance of Zhang et al. 2018, AlexNet, version 0.1 (lpips); None also without its
        weights.
    """

    psnr_db: float
    ssim: float | None
    flip: float | None
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
    as sRGB. `midair.compare` registers photographs first.

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
        If the pictures differ in size, or are smaller than the window of SSIM (11 x 11 pixels).
    """
    scores, notes = scored(
        colours(rendered, "rendered", transfer),
        colours(photograph, "photograph", transfer),
        exposure,
        pixels_per_degree,
        network,
    )
    warn(notes)
    return scores


def scored(
    rendered: npt.NDArray[Any],
    photograph: npt.NDArray[Any],
    exposure: float,
    pixels_per_degree: float,
    network: Any,
) -> tuple[Scores, list[str]]:
    """Return the scores of pictures of shape (1 or 3, rows, columns), and what is left out."""
    a, b = shown = [_shown(one, exposure) for one in (rendered, photograph)]
    if a.shape != b.shape:
        sizes = " and ".join(f"{one.shape[1]} x {one.shape[0]}" for one in shown)
        raise Error(
            f"evaluate: the pictures have {sizes} pixels; crop one to the size of the other, or "
            "register them with midair.compare"
        )
    if min(a.shape[:2]) < 11:
        raise Error("evaluate: SSIM needs 11 x 11 pixels; compare a larger part")
    error = float(np.mean((a.astype(float) - b) ** 2))
    notes: list[str] = []

    def left_out(name: str, score: Callable[[], float], remedy: str) -> float | None:
        try:
            return score()
        except Exception as reason:  # a missing package, or weights that cannot be loaded
            notes.append(f"{name} is left out: {reason}; {remedy}")
            return None

    def ssim() -> float:
        return float(
            import_module("skimage.metrics").structural_similarity(
                a,
                b,
                gaussian_weights=True,
                sigma=1.5,
                use_sample_covariance=False,
                data_range=1.0,
                channel_axis=2,
            )
        )

    def flip() -> float:
        compared = import_module("flip_evaluator").evaluate
        ppd = {"ppd": float(pixels_per_degree)}
        return float(compared(b, a, "LDR", inputsRGB=True, applyMagma=False, parameters=ppd)[1])

    def lpips() -> float:
        torch: Any = import_module("torch")
        pair = [torch.from_numpy(2 * np.moveaxis(one, -1, 0)[None] - 1) for one in (a, b)]
        own = network or _network()
        if isinstance(own, Exception):
            raise own
        with torch.no_grad():
            return float(own(*pair))

    scores = Scores(
        psnr_db=-10 * math.log10(error) if error else math.inf,
        ssim=left_out("SSIM", ssim, f"{EXTRA} brings it"),
        flip=left_out("FLIP", flip, f"{EXTRA} brings it"),
        lpips=left_out("LPIPS", lpips, "the packages torch and lpips bring it"),
    )
    return scores, notes


@cache
def _network() -> Any:
    """Return the LPIPS network of the package lpips, or why there is none, which is tried once."""
    try:
        return import_module("lpips").LPIPS(net="alex", version="0.1", verbose=False)
    except Exception as reason:  # a missing package, or weights that cannot be loaded
        return reason


def _shown(light: npt.NDArray[Any], exposure: float) -> npt.NDArray[np.float32]:
    """Return what a display shows of a picture: sRGB values, shape (rows, columns, 3)."""
    light = np.clip(exposure * np.moveaxis(light, 0, -1), 0.0, 1.0)
    light = np.broadcast_to(light, (*light.shape[:2], 3))
    curve = 1.055 * np.maximum(light, 0.0031308) ** (1 / 2.4) - 0.055
    return np.where(light <= 0.0031308, 12.92 * light, curve).astype(np.float32)
