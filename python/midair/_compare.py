"""The published table: models of sheets against photographs of their mid-air images."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from midair._errors import Error, warn
from midair._evaluate import Scores, scored
from midair._fit import measure
from midair._picture import Picture
from midair._register import Registration, below_full_scale, colours, register
from midair._words import File

#: Scores, their headings, digits, and whether more is better.
_SCORES = {
    "psnr_db": ("PSNR (dB)", 2, True),
    "ssim": ("SSIM", 4, True),
    "flip": ("FLIP", 4, False),
    "lpips": ("LPIPS", 4, False),
}


@dataclass(frozen=True)
class Shot:
    """Photograph of a mid-air image, and what the models make of it.

    Parameters
    ----------
    sheet, picture : str
        Names of the sheet and of what it shows, for the table.
    distance : float
        Floating distance R, mm.
    photograph : path or array
        Linear light of shape (rows, columns) or (rows, columns, 3), or a file.
    renders : mapping from str to path or array
        Mid-air image by each model, all of one size (``fit render --camera``).
    exposure : float, optional
        Exposure relative to that of the reference, as in a manifest.
    """

    sheet: str
    distance: float
    picture: str
    photograph: Picture | File
    renders: Mapping[str, Picture | File]
    exposure: float | None = None


@dataclass(frozen=True)
class Comparison:
    """Scores of models against photographs; ``print`` shows them as a table in Markdown.

    Attributes
    ----------
    scores : dict
        `Scores` by sheet, distance (mm), model and picture.
    registrations : dict
        `Registration` by sheet, distance and picture.
    notes : list of str
        What is left out, and where the exposures come from.
    """

    scores: Mapping[tuple[str, float, str, str], Scores]
    registrations: Mapping[tuple[str, float, str], Registration]
    notes: list[str]

    def __str__(self) -> str:
        pictures = list(dict.fromkeys(picture for *_, picture in self.scores))
        heads = [f"{picture} {head}" for picture in pictures for head, *_ in _SCORES.values()]
        lines = [_row("sheet", "distance", "model", *heads), _row(*["---"] * (3 + len(heads)))]
        for sheet, distance, model in dict.fromkeys(place[:3] for place in self.scores):
            cells = [
                self._cell(sheet, distance, model, picture, score)
                for picture in pictures
                for score in _SCORES
            ]
            lines.append(_row(sheet, f"{distance:g} mm", model, *cells))
        lines += ["", *self.notes]
        if self.registrations:
            heads = ["shift (px)", "scale", "rotation (deg)", "residual (px)", "correlation"]
            lines += ["", _row("sheet", "distance", "picture", *heads), _row(*["---"] * 8)]
        for (sheet, distance, picture), found in self.registrations.items():
            shift = (f"{v:.3f} ± {e:.3f}" for v, e in zip(found.shift_px, found.shift_error_px))
            cells = [
                ", ".join(shift),
                f"{found.scale:.5f} ± {found.scale_error:.5f}",
                f"{found.rotation_deg:.3f} ± {found.rotation_error_deg:.3f}",
                f"{found.residual_px:.3f} (noise {found.noise_px:.3f})",
                f"{found.correlation:.4f}",
            ]
            lines.append(_row(sheet, f"{distance:g} mm", picture, *cells))
        return "\n".join(lines) + "\n"

    def _cell(self, sheet: str, distance: float, model: str, picture: str, score: str) -> str:
        """Return a score, in bold if it is the best of all models, or a dash."""
        own = self.scores.get((sheet, distance, model, picture))
        value: float | None = getattr(own, score, None)
        if value is None:
            return "-"
        _, digits, is_more = _SCORES[score]
        values = [
            getattr(other, score)
            for place, other in self.scores.items()
            if (*place[:2], place[3]) == (sheet, distance, picture)
        ]
        best = (max if is_more else min)(values)
        return f"**{value:.{digits}f}**" if value == best else f"{value:.{digits}f}"

    def csv(self) -> str:
        """Return one row for each sheet, distance, model and picture; a missing score is empty."""
        lines = ["sheet,distance_mm,model,picture," + ",".join(_SCORES)]
        for (sheet, distance, model, picture), own in self.scores.items():
            values = (getattr(own, score) for score in _SCORES)
            cells = ("" if value is None else f"{value:.5f}" for value in values)
            lines.append(f"{sheet},{distance:g},{model},{picture}," + ",".join(cells))
        return "\n".join(lines) + "\n"


def _exposure(render: npt.NDArray[Any], photo: npt.NDArray[Any]) -> float:
    """Return the factor that brings a render nearest to a photograph, by least squares."""
    photo, render = np.broadcast_arrays(photo.astype(float), render)
    known = below_full_scale(photo)
    return float(np.sum((photo * render)[known]) / np.sum((render**2)[known]))


def _row(*cells: str) -> str:
    return "| " + " | ".join(cells) + " |"


def compare(
    shots: Iterable[Shot],
    *,
    reference: Picture | File | float | None = None,
    brightness: float = 1.0,
    pixels_per_degree: float = 67.02064,
    transfer: str | None = None,
    network: Callable[[Any, Any], Any] | None = None,
) -> Comparison:
    """Compare models with photographs: sheets, distances, models and pictures in one table.

    Each photograph is registered with the mean of its renders, so that no model is favoured. The
    renders are brought to its pixels, and the part that they cover is scored by `midair.evaluate`.

    Parameters
    ----------
    shots : list of Shot
        Photographs and renders.
    reference : path, array or float, optional
        Photograph of the source's edge, whose bright side is the light 1 of the picture, or its
        value as a number (1 if the picture itself is such a photograph). The light of a render
        times this value and the exposure of the shot is the value of the photograph. Without it,
        the exposure of each render is found by least squares: the scores then ignore its
        brightness.
    brightness : float
        Factor on the values of the photographs, for looking at them.
    pixels_per_degree, transfer, network : optional
        As for `midair.evaluate`.

    Raises
    ------
    Error
        If a photograph does not show what is rendered, if a shot has no exposure, or if its renders
        differ in size.
    """
    scores: dict[tuple[str, float, str, str], Scores] = {}
    registrations = {}
    notes: dict[str, None] = {}
    white = None
    if reference is not None:
        if isinstance(reference, (int, float)):
            white = float(reference)
        else:
            white = measure(reference, transfer=transfer).contrast
        note = f"Exposures: from the reference, in which the light 1 has the value {white:.4g}."
    else:
        note = "Exposures: by least squares, so that the scores ignore the brightness."
    notes[note] = None
    for shot in shots:
        place = f"{shot.sheet}, {shot.distance:g} mm, {shot.picture}"
        if not shot.renders:
            raise Error(f"compare: {place} has no renders; give one for each model")
        photo = colours(shot.photograph, "photograph", transfer)
        renders = {name: colours(one, name, transfer) for name, one in shot.renders.items()}
        if len({one.shape[1:] for one in renders.values()}) > 1:
            raise Error(f"compare: the renders of {place} differ in size; render all at one size")
        if white is not None and shot.exposure is None:
            raise Error(
                f"compare: {place} has no exposure; give the one relative to the reference, or "
                "leave the reference out"
            )
        mean = np.mean([one.mean(axis=0) for one in renders.values()], axis=0)
        try:
            found = register(mean, np.moveaxis(photo, 0, -1))
        except Error as error:
            raise Error(f"compare: {place}: {error}") from None
        registrations[shot.sheet, shot.distance, shot.picture] = found
        photo = photo[(slice(None), *found.region)]
        for name, one in renders.items():
            seen = np.moveaxis(found.resample(np.moveaxis(one, 0, -1)), -1, 0)
            if white is None or shot.exposure is None:
                gain = _exposure(seen, photo)
            else:
                gain = white * shot.exposure
            made, missing = scored(gain * seen, photo, brightness, pixels_per_degree, network)
            scores[shot.sheet, shot.distance, name, shot.picture] = made
            notes |= dict.fromkeys(missing)
    warn([note for note in notes if "left out" in note])
    return Comparison(scores, registrations, list(notes))
