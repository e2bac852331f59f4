"""Photographs measured, sheets estimated, images predicted."""

from __future__ import annotations

import html
import json
import os
import pathlib
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import numpy.typing as npt

from midair import _midair
from midair._errors import Error, refusals, warn
from midair._picture import Picture, is_file, planes
from midair._progress import Progress, told
from midair._table import Floats, Table
from midair._table import open as open_table
from midair._words import File, Numbers, in_python, text, words

if TYPE_CHECKING:
    import xarray

#: Name of a manifest in memory. Each capture stands on a line of its own, after this many lines.
_MEMORY = "captures"
_BEFORE = 3


@dataclass(frozen=True)
class Edge:
    """Measured edge of one photograph.

    Attributes
    ----------
    frequency : ndarray, shape (n,)
        Frequencies along the normal of the edge, in `unit`.
    mtf, standard_error : ndarray, shape (n,)
        Modulation transfer function (1 at frequency 0), and its standard error.
    mtf50, mtf10 : float or None
        Frequencies at which the MTF falls to 0.5 and 0.1; None if it does not, or if noise hides
        it.
    angle_deg : float
        Direction of the normal of the edge: 0 is right, 90 is down.
    contrast : float
        Bright side minus dark side, in units of the picture.
    unit : str
        ``"cycles/pixel"``, or ``"1/mm"`` with a pixel pitch.
    warnings : list of str
        Doubts about the photograph.
    data : dict
        All that ``fit mtf --json`` writes.
    """

    frequency: Floats
    mtf: Floats
    standard_error: Floats
    mtf50: float | None
    mtf10: float | None
    angle_deg: float
    contrast: float
    unit: str
    warnings: list[str]
    data: dict[str, Any] = field(repr=False)

    def to_xarray(self) -> xarray.Dataset:
        """Return the curve as a dataset over the frequency."""
        import xarray

        return xarray.Dataset(
            {
                "mtf": ("frequency", self.mtf, {"units": "1", "long_name": "MTF"}),
                "standard_error": (
                    "frequency",
                    self.standard_error,
                    {"units": "1", "long_name": "standard error of the MTF"},
                ),
            },
            {"frequency": ("frequency", self.frequency, {"units": self.unit})},
        )


def measure(
    image: Picture | File,
    roi: Sequence[int] | None = None,
    *,
    pixel_pitch: float | None = None,
    at: Numbers | None = None,
    transfer: str | None = None,
    channel: str | None = None,
    accept: str | None = None,
) -> Edge:
    """Measure the MTF of a photograph of a slanted edge, as ``fit mtf`` does.

    Parameters
    ----------
    image : array or path
        Photograph: a file (EXR, PNG, TIFF, JPEG), or an array of shape (rows, columns) or (rows,
        columns, 3). An array is linear light unless `transfer` says ``"srgb"``.
    roi : four ints, optional
        Region that holds the edge: x, y, width, height, pixels. Without it the edge is searched.
    pixel_pitch : float, optional
        Side of a pixel, mm. Frequencies are then in 1/mm, otherwise in cycles per pixel.
    at : list of floats, optional
        Frequencies at which the MTF is named (``edge.data["at"]``).

    Raises
    ------
    Error
        If the photograph holds no edge that can be measured; the sentence says why.
    """
    options = dict(
        roi=roi,
        pixel_pitch=pixel_pitch,
        at=at,
        transfer=transfer,
        channel=channel,
        accept=accept,
    )
    held = None if is_file(image) else planes(image, "array")
    with refusals():
        made = _midair.measure(words("array" if held else image, json=True, **options), held)
    data = cast("dict[str, Any]", json.loads(made))
    warn(data["warnings"])
    return Edge(
        np.array(data["frequency"]),
        np.array(data["mtf"]),
        np.array(data["standard_error"]),
        data["mtf50"],
        data["mtf10"],
        data["edge_angle_deg"],
        data["contrast"],
        data["frequency_unit"],
        [in_python(warning) for warning in data["warnings"]],
        data,
    )


@dataclass(frozen=True)
class Estimate:
    """Parameter with its standard error; None if the photographs only bound it.

    Attributes
    ----------
    value, standard_error : float or None
        The number, if all incidences share it.
    per_angle : dict
        Otherwise a value and a standard error for each incidence, degrees.
    per_distance : dict
        The same of a blur of its own at each floating distance, mm.
    """

    value: float | None
    standard_error: float | None
    per_angle: dict[float, tuple[float | None, float | None]]
    per_distance: dict[float, tuple[float | None, float | None]] = field(default_factory=dict)

    @classmethod
    def _of(cls, number: Mapping[str, Any] | None) -> Estimate | None:
        if number is None:
            return None

        def each(places: str, place: str) -> dict[float, tuple[float | None, float | None]]:
            entries = number.get(places, [])
            return {own[place]: (own["value"], own["standard_error"]) for own in entries}

        return cls(
            number.get("value"),
            number.get("standard_error"),
            each("per_angle", "incidence_deg"),
            each("per_distance", "floating_distance_mm"),
        )

    def __str__(self) -> str:
        def one(value: float | None, error: float | None) -> str:
            if value is None:
                return "only bounded"
            return f"{value:.5g}" + ("" if error is None else f" ± {error:.2g}")

        places = [(f"{deg:g}°", pair) for deg, pair in self.per_angle.items()]
        places += [(f"{mm:g} mm", pair) for mm, pair in self.per_distance.items()]
        if not places:
            return one(self.value, self.standard_error)
        return ", ".join(f"{one(*pair)} at {place}" for place, pair in places)


@dataclass(frozen=True)
class Report:
    """Page of an estimate, of a plan or of a cell, or page with sliders. A notebook shows it; `save` writes it to a file.

    Attributes
    ----------
    html : str
        The page, which needs no other file.
    """

    html: str = field(repr=False)

    def save(self, path: File) -> None:
        """Write the page to a file, whole or not at all."""
        with refusals():
            _midair.write(os.fspath(path), self.html)

    def _repr_html_(self) -> str:
        # A frame of its own, so that the styles of page and notebook do not mix.
        return (
            f'<iframe srcdoc="{html.escape(self.html)}" title="page of a sheet" '
            'style="width: 100%; height: 600px; border: 0"></iframe>'
        )


class Result:
    """Estimate of a sheet: c, a and mu with standard errors, and what follows from them.

    Attributes
    ----------
    c, a, mu : Estimate or None
        Corner size (mm), diffraction spread (1/mm; for the kernel ``angular`` A = a R without
        unit), and reflectance. None if the model has no such parameter.
    own_blur : Estimate or None
        Blur of the mid-air photographs that the reference does not have, pixels (standard
        deviation; negative if the reference is less sharp). None if the photographs do not ask for
        it.
    angular_spread : Estimate or None
        Standard deviation of the direction of the returned light, mrad. None if the photographs do
        not ask for it.
    dihedral_errors : tuple of Estimate or None
        Errors of the dihedral angles at the edges 1, 2 and 3 of all cubes, mrad. None if the
        photographs do not ask for them.
    roughness, surface_roughness : Estimate or None
        Roughness of facets and of the front face, of a published baseline.
    verdict : str
        ``"good"``, ``"strained"`` or ``"poor"``: whether the model describes the photographs.
    warnings : list of str
        Doubts about the campaign, and about each photograph.
    suspects : list of dict
        Mistakes (key ``what``) that would explain a misfit, a further blur, or why mu differs (key
        ``explains``), the best first.
    chi2, degrees_of_freedom : float or None
        Sum of squares in units of the noise, and the number that noise alone would give. They
        depend on the photographs and on the loss, so compare them between fits by one loss.
    data : dict
        All that ``fit estimate -o`` writes.
    """

    def __init__(self, result: _midair.Result, table: Table, has_pitch: bool = True) -> None:
        self._result = result
        self._has_pitch = has_pitch
        self._table = table
        self.data: dict[str, Any] = json.loads(result.json())
        data = self.data
        self.c = Estimate._of(data["c_mm"])
        self.a = Estimate._of(data["a_per_mm"] or data["a_times_r"])
        self.mu = Estimate._of(data["mu"])
        self.verdict: str = (data.get("fit") or {}).get("verdict", "unknown")
        self.own_blur = Estimate._of(data.get("own_blur_px"))
        self.angular_spread = Estimate._of(data.get("angular_spread_mrad"))
        errors = data.get("dihedral_errors_mrad")
        self.dihedral_errors = errors and tuple(Estimate._of(error) for error in errors)
        self.roughness = Estimate._of(data.get("roughness"))
        self.surface_roughness = Estimate._of(data.get("surface_roughness"))
        fit = data.get("fit") or {}
        self.suspects: list[dict[str, Any]] = fit.get("suspects", [])
        self.chi2: float | None = fit.get("chi2")
        self.degrees_of_freedom: float | None = fit.get("degrees_of_freedom")
        self.warnings: list[str] = [in_python(warning) for warning in data["warnings"]] + [
            f"{capture['image']}: {in_python(warning)}"
            for capture in data["captures"]
            for warning in capture["warnings"]
        ]

    @property
    def table(self) -> Table:
        """Table of the sheet."""
        return self._table

    @property
    def kernel(self) -> str:
        """Name of the blur terms that the estimate chose or was given."""
        return cast(str, self.data["kernel"])

    @property
    def candidates(self) -> list[dict[str, Any]]:
        """Models that were compared, the best first, each with its criterion (BIC)."""
        return cast("list[dict[str, Any]]", self.data["candidates"])

    def to_json(self) -> str:
        """Return the result as ``fit estimate -o`` writes it."""
        return self._result.json()

    def save(self, path: File) -> None:
        """Write the result to a file as ``fit estimate -o`` does, whole or not at all."""
        with refusals():
            _midair.write(os.fspath(path), self.to_json())

    def __reduce__(self) -> tuple[Any, ...]:
        # Photographs stay behind, as in a file: the copy has no `report`.
        return _of_json, (self.to_json(), self._table, self._has_pitch)

    def report(self) -> Report:
        """Return the page with estimates, curves, choice of the model and warnings.

        Raises
        ------
        Error
            If the result was loaded from a file or a pickle, which do not hold the photographs.
        """
        made = self._result.report("midair.estimate(...)")
        if made is None:
            raise Error("the result holds no photographs; estimate again for a report")
        return Report(made)

    def curves(self) -> xarray.Dataset:
        """Return measured and modelled MTF of each photograph, and their residual.

        The dimensions are `capture` and `place`, a number along the curve; `frequency_per_mm` is a
        variable, because photographs may have other frequencies. Shorter curves end in NaN.
        """
        import xarray

        captures = self.data["captures"]
        length = max(len(capture["curves"]["measured"]) for capture in captures)
        names = ("frequency_per_mm", "measured", "standard_error", "modelled")
        arrays = {
            name: np.array(
                [
                    np.pad(
                        np.array(capture["curves"][name], float),
                        (0, length - len(capture["curves"][name])),
                        constant_values=np.nan,
                    )
                    for capture in captures
                ]
            )
            for name in names
        }
        units = {"frequency_per_mm": "1/mm"}
        dataset = xarray.Dataset(
            {
                name: (("capture", "place"), array, {"units": units.get(name, "1")})
                for name, array in arrays.items()
            },
            {
                "capture": [capture["image"] for capture in captures],
                "incidence_deg": (
                    "capture",
                    [capture["incidence_deg"] for capture in captures],
                    {"units": "degree"},
                ),
                "floating_distance_mm": (
                    "capture",
                    [capture["floating_distance_mm"] for capture in captures],
                    {"units": "mm"},
                ),
            },
        )
        # At frequency 0 the MTF is 1 without an error, and there is no residual.
        errors = dataset.standard_error.where(dataset.standard_error > 0)
        dataset["residual"] = (dataset.measured - dataset.modelled) / errors
        dataset["residual"].attrs = {"units": "1", "long_name": "in standard errors"}
        return dataset

    def predict(
        self,
        distance: Numbers,
        incidence: Numbers,
        azimuth: Numbers | None = None,
        *,
        frequency: Numbers | None = None,
        table: Table | None = None,
    ) -> xarray.Dataset:
        """Predict MTF and luminance elsewhere, as ``fit predict`` does.

        Parameters
        ----------
        distance : float or list
            Floating distances R, mm: the way from the sheet to the image.
        incidence, azimuth : float or list
            Directions in the air, degrees.
        frequency : list or text, optional
            Frequencies in the image, 1/mm, such as ``"0:5:0.05"``.
        table : Table, optional
            Table of the same cell with other directions.

        Returns
        -------
        xarray.Dataset
            `mtf` and its interval of 95 % (`mtf_low`, `mtf_high`) over `floating_distance_mm`,
            `incidence_deg`, `azimuth_deg`, `axis` (tangential, sagittal) and `frequency_per_mm`;
            `luminance` relative to the source, with its interval; `retroreflected`; and `outside`,
            the names of what lies outside of the photographs. The MTF is NaN where nothing comes
            back.
        """
        import xarray

        source = table or self._table
        options = dict(distance=distance, incidence=incidence, azimuth=azimuth, frequency=frequency)
        with refusals():
            made = _midair.predict(
                words("result", table="table", json=True, **options),
                self._result,
                source._table,
            )
        data = json.loads(made)
        warn(data["warnings"])
        predictions = data["predictions"]
        frequencies = np.array(data["frequency_per_mm"])
        keys = ("floating_distance_mm", "incidence_deg", "azimuth_deg", "axis")
        axes = {
            key: list(dict.fromkeys(prediction[key] for prediction in predictions)) for key in keys
        }
        shape = tuple(len(values) for values in axes.values())
        names = ("luminance", "luminance_low", "luminance_high", "retroreflected")
        single = {name: np.full(shape, np.nan) for name in names}
        curves = {
            name: np.full((*shape, len(frequencies)), np.nan)
            for name in ("mtf", "mtf_low", "mtf_high")
        }
        outside = np.full(shape, "", dtype=object)
        for prediction in predictions:
            place = tuple(axes[key].index(prediction[key]) for key in keys)
            single["retroreflected"][place] = prediction["retroreflected"]
            if prediction["luminance"] is not None:
                single["luminance"][place] = prediction["luminance"]
            low, high = prediction.get("luminance_interval") or (np.nan, np.nan)
            single["luminance_low"][place], single["luminance_high"][place] = low, high
            if prediction["mtf"]:
                curves["mtf"][place] = prediction["mtf"]
            if prediction.get("mtf_interval"):
                ends = np.array(prediction["mtf_interval"])
                curves["mtf_low"][place], curves["mtf_high"][place] = ends.T
            outside[place] = " ".join(prediction["outside"])
        coords: dict[str, Any] = {
            "floating_distance_mm": (keys[0], axes[keys[0]], {"units": "mm"}),
            "incidence_deg": (keys[1], axes[keys[1]], {"units": "degree"}),
            "azimuth_deg": (
                keys[2],
                [np.nan if azimuth is None else azimuth for azimuth in axes[keys[2]]],
                {"units": "degree"},
            ),
            "axis": axes["axis"],
            "frequency_per_mm": ("frequency_per_mm", frequencies, {"units": "1/mm"}),
        }
        return xarray.Dataset(
            {
                **{
                    name: ((*keys, "frequency_per_mm"), array, {"units": "1"})
                    for name, array in curves.items()
                },
                **{name: (keys, array, {"units": "1"}) for name, array in single.items()},
                "outside": (keys, outside.astype(str)),
            },
            coords,
            {"Conventions": "CF-1.11", "kernel": data["kernel"]},
        )

    def render(
        self,
        picture: Picture,
        distance: float | None = None,
        incidence: float | None = None,
        azimuth: float | None = None,
        *,
        pixel_pitch: float | None = None,
        width: float | None = None,
        tangential_axis: float | None = None,
        seen_in_mirror: bool = False,
        luminance: float | None = None,
        ambient: float | None = None,
        ambient_nits: float | None = None,
        exposure: float | None = None,
        auto_exposure: bool = False,
        camera: Result | File | None = None,
        transfer: str | None = None,
        view: File | None = None,
        tolerance: float | None = None,
        forward: str | None = None,
        samples: int | None = None,
        seed: int | None = None,
        sequence: str | None = None,
        threads: int | None = None,
        table: Table | Sequence[Table] | None = None,
    ) -> npt.NDArray[np.float32]:
        """Render the mid-air image of a picture, as ``fit render`` does.

        Parameters
        ----------
        picture : array, shape (rows, columns) or (rows, columns, 3)
            Source, linear light (or sRGB, with ``transfer="srgb"``).
        distance, incidence, azimuth : float
            Floating distance R (mm) and direction (degrees).
        pixel_pitch : float, optional
            Side of a pixel in the plane of the image, mm; that of the photographs if left out.
        width : float, optional
            Width of the picture in the plane of the image, mm, in place of `pixel_pitch`.
        exposure : float, optional
            Factor on the light.
        luminance, ambient, ambient_nits : float, optional
            Luminance of the source's white (cd/m2), and light behind the image: a share of it, or
            cd/m2.
        auto_exposure : bool
            True to make the brightest pixel as bright as that of the picture.
        camera : Result or path, optional
            Result whose camera photographs the image: the blur of its pixel and of its lens is
            added, as a comparison with a photograph needs it.
        view : path, optional
            File with the places of camera, image and sheet, in place of distance and direction.
        table : Table or three of them, optional
            Another table of the fitted cell, or those of red, green and blue light, where the index
            of the prisms differs.

        Returns
        -------
        ndarray of float32
            Linear light, in the shape and the units of the picture.
        """
        options: dict[str, Any] = dict(
            distance=distance,
            incidence=incidence,
            azimuth=azimuth,
            pixel_pitch=pixel_pitch,
            width=width,
            tangential_axis=tangential_axis,
            seen_in_mirror=seen_in_mirror,
            luminance=luminance,
            ambient=ambient,
            ambient_nits=ambient_nits,
            exposure=exposure,
            auto_exposure=auto_exposure,
            camera="camera" if isinstance(camera, Result) else camera,
            transfer=transfer,
            view=view,
            tolerance=tolerance,
            forward=forward,
            samples=samples,
            seed=seed,
            sequence=sequence,
            threads=threads,
        )
        if not self._has_pitch and pixel_pitch is None and width is None and view is None:
            raise Error(
                "numbers of a sheet have no camera; give width, the width of the picture in the "
                "air, mm, or pixel_pitch"
            )
        named = dict(source="picture", params="result", table="table", output="image.exr")
        given = self._table if table is None else table
        tables = [given] if isinstance(given, Table) else list(given)
        with refusals():
            seen = None
            if isinstance(camera, Result):
                seen = camera._result
            elif camera is not None:
                seen = _midair.read_result(os.fspath(camera), None)
            made, facts = _midair.render(
                words(**named, **options),
                self._result,
                seen,
                [one._table for one in tables],
                planes(picture, "picture"),
            )
        warn(json.loads(facts)["warnings"])
        if np.ndim(picture) == 2:
            return made[0]
        return np.stack(made, axis=-1)

    def explore(
        self,
        picture: Picture | None = None,
        *,
        distance: float | None = None,
        incidence: float | None = None,
        azimuth: float | None = None,
        width: float | None = None,
        nearest: float | None = None,
        farthest: float | None = None,
        luminance: float | None = None,
        ambient: float | None = None,
        ambient_nits: float | None = None,
        transfer: str | None = None,
        threads: int | None = None,
        table: Table | None = None,
    ) -> Report:
        """Make a page with sliders that shows the mid-air image at once, as ``fit explore`` does.

        Parameters
        ----------
        picture : array, shape (rows, columns) or (rows, columns, 3), optional
            Picture that the page shows first, linear light (or sRGB, with ``transfer="srgb"``).
        distance, incidence, azimuth, width : float, optional
            What the page shows first (mm, degrees, degrees, mm).
        nearest, farthest : float, optional
            Ends of the slider of distances, mm.
        luminance, ambient, ambient_nits : float, optional
            Light that the page shows first, as in `render`.

        Returns
        -------
        Report
            The page. A notebook shows it; ``save`` writes it for a browser.
        """
        options: dict[str, Any] = dict(
            distance=distance,
            incidence=incidence,
            azimuth=azimuth,
            width=width,
            nearest=nearest,
            farthest=farthest,
            luminance=luminance,
            ambient=ambient,
            ambient_nits=ambient_nits,
            transfer=transfer,
            threads=threads,
        )
        named = dict(table="table", output="explore.html")
        if picture is not None:
            named["source"] = "picture"
        with refusals():
            page, facts = _midair.explore(
                words("result", **named, **options),
                self._result,
                (table or self._table)._table,
                None if picture is None else planes(picture, "picture"),
            )
        warn(json.loads(facts)["warnings"])
        return Report(page)

    def __repr__(self) -> str:
        return f"<midair.Result: {self._said()}, {self.verdict}>"

    def _said(self) -> str:
        return ", ".join(f"{name} = {value}" for name, value in self._named() if value)

    def _named(self) -> list[tuple[str, Estimate | None]]:
        """Return all parameters with their names and units."""
        return [
            ("c (mm)", self.c),
            ("a (1/mm)" if self.data["a_per_mm"] else "A = a R", self.a),
            ("roughness", self.roughness),
            ("surface roughness", self.surface_roughness),
            ("mu", self.mu),
        ]

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><th>{name}</th><td>{html.escape(str(value))}</td></tr>"
            for name, value in (
                *self._named(),
                ("kernel", self.kernel),
                ("fit", self.verdict),
                ("warnings", len(self.warnings)),
            )
            if value is not None
        )
        return f"<table>{rows}</table>"


def _of_json(text: str, table: Table, has_pitch: bool) -> Result:
    """Return the result of a pickle."""
    with refusals():
        return Result(_midair.result_of_json(text), table, has_pitch)


def _toml(value: Any) -> str:
    """Return a value of a manifest as TOML."""
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if getattr(value, "ndim", None) == 0:
        value = value.item()
    if isinstance(value, (str, os.PathLike)):
        # All characters that TOML has no room for are escaped.
        return json.dumps(os.fspath(value))
    if isinstance(value, Mapping):
        # What is None is left out. Keys are quoted, so that a wrong one is refused by its name.
        entries = [
            f"{json.dumps(str(key))} = {_toml(item)}"
            for key, item in value.items()
            if item is not None
        ]
        return "{ " + ", ".join(entries) + " }"
    if isinstance(value, (list, tuple, np.ndarray)):
        return "[" + ", ".join(_toml(item) for item in value) + "]"
    return text(value)


def _manifest(
    captures: Mapping[str, Any], folder: File | None
) -> tuple[str, list[tuple[str, npt.NDArray[np.float32], bool]]]:
    """Return a campaign as the text of a manifest, one line for each capture, and its pictures."""
    pictures = []
    base = os.fspath(folder) if folder is not None else os.getcwd()

    def shot(given: Mapping[str, Any], name: str) -> dict[str, Any]:
        if not isinstance(given, Mapping):
            raise TypeError(
                f"{name} is a dict with the keys of the manifest, such as image and exposure, not "
                f"{type(given).__name__}"
            )
        image = given.get("image")
        if image is None:
            return dict(given)
        if is_file(image):
            return {**given, "image": os.path.join(base, os.fspath(image))}
        if given.get("exposure") is None and name != "reference":
            raise Error(
                f"{_MEMORY}: {name}: an array holds no settings of the camera, and there is no "
                "`exposure`; give the exposure relative to the reference"
            )
        pictures.append(planes(image, name))
        return {**given, "image": name}

    known = {"setup", "reference", "capture"}
    if unknown := sorted(set(captures) - known, key=str):
        raise Error(
            f"{_MEMORY}: {unknown[0]!r} is no part of a campaign; use setup, reference, capture"
        )
    reference = captures.get("reference")
    if isinstance(reference, (list, tuple)):
        names = ["reference", *(f"reference {k}" for k in range(1, len(reference)))]
        references: Any = [shot(*one) for one in zip(reference, names, strict=True)]
    elif reference is not None:
        references = shot(reference, "reference")
    setup = captures.get("setup")
    lines = [
        f"setup = {_toml({} if setup is None else setup)}",
        "" if reference is None else f"reference = {_toml(references)}",
        "capture = [",
    ]
    shots = captures.get("capture", [])
    if not isinstance(shots, (list, tuple)):
        raise TypeError(f"capture is a list of dicts, not {type(shots).__name__}")
    for number, given in enumerate(shots):
        lines.append(f"  {_toml(shot(given, f'capture {number}'))},")
    return "\n".join([*lines, "]", ""]), pictures


def _place(found: re.Match[str]) -> str:
    """Return the place of a line of a manifest in memory."""
    line = int(found[1])
    if line <= _BEFORE:
        return f"{_MEMORY}: {('setup', 'reference', 'capture')[line - 1]}"
    return f"{_MEMORY}: capture {line - _BEFORE - 1}"


def estimate(
    captures: File | Mapping[str, Any],
    table: Table | File | Sequence[Table | File],
    *,
    folder: File | None = None,
    expect_table: str | None = None,
    model: str | None = None,
    kernel: str | None = None,
    lobe: str | None = None,
    per_angle: str | Sequence[str] | None = None,
    shared: str | Sequence[str] | None = None,
    wavelength_nm: str | float | None = None,
    channel: str | None = None,
    forward: str | None = None,
    loss: str | None = None,
    samples: int | None = None,
    seed: int | None = None,
    sequence: str | None = None,
    fit_azimuth: bool = False,
    diagnose: float | None = None,
    threads: int | None = None,
    progress: Progress = None,
) -> Result:
    """Estimate c, a and mu of a sheet from photographs, as ``fit estimate`` does.

    Parameters
    ----------
    captures : path or dict
        Manifest (captures.toml), or its content: ``{"setup": {...}, "reference": {...},
        "capture": [{...}, ...]}`` with the keys of the manifest; ``"reference"`` may be a list. Each ``"image"`` is a path or an
        array of shape (rows, columns) or (rows, columns, 3), of linear light unless
        ``"transfer": "srgb"`` is given. Captures are counted from 0 in messages.
    table : Table, path, or list of them
        Table of the sheet. Further tables are tried if the first does not describe the
        photographs.
    folder : path, optional
        Folder that paths of images in a dict are relative to; the working folder by default.
    model, kernel, lobe, per_angle, shared
        Terms of the model; what is left out is chosen by a criterion.
    forward, loss, samples, seed, sequence
        How the model is evaluated and compared.
    fit_azimuth : bool
        True to estimate the azimuth of the sheet too.
    diagnose : float
        Seconds that the search for mistakes may take if the fit is not good: 10 by default, 0 for
        no search.
    progress : callable, bool, optional
        A function that is called with what is done (text), how many, and of how many (None if not
        known). True shows a bar of tqdm, False nothing. Without it a bar appears on a terminal or
        in a notebook, if tqdm is installed and the work takes over two seconds.

    Raises
    ------
    Error
        If the manifest, a photograph or the table cannot be used; the sentence says why.
    """
    given = [table] if isinstance(table, (Table, str, os.PathLike)) else list(table)
    tables = [one if isinstance(one, Table) else open_table(one) for one in given]
    campaign = _manifest(captures, folder) if isinstance(captures, Mapping) else None
    options: dict[str, Any] = dict(
        expect_table=expect_table,
        model=model,
        kernel=kernel,
        lobe=lobe,
        per_angle=per_angle,
        shared=shared,
        wavelength_nm=wavelength_nm,
        channel=channel,
        forward=forward,
        loss=loss,
        samples=samples,
        seed=seed,
        sequence=sequence,
        fit_azimuth=fit_azimuth,
        diagnose=diagnose,
        threads=threads,
    )
    first = tables[0]._table.name if tables else "table"
    file = _MEMORY if campaign else captures
    try:
        with refusals(), told(progress) as tell:
            made = _midair.estimate(
                words(file, table=first, **options),
                [one._table for one in tables],
                campaign,
                tell,
            )
    except Error as error:
        if campaign is None:
            raise
        raise Error(re.sub(rf"\b{_MEMORY}:(\d+)", _place, error.sentence)) from None
    result = Result(made, tables[0])
    warn(result.warnings)
    return result


def load(path: File, table: Table | File, *, channel: str | None = None) -> Result:
    """Load a result that ``fit estimate -o`` or `Result.save` wrote.

    Parameters
    ----------
    path : path
        File of the result.
    table : Table or path
        Table of the same cell.
    channel : str, optional
        Channel of a file with several results.
    """
    source = table if isinstance(table, Table) else open_table(table)
    with refusals():
        return Result(_midair.read_result(os.fspath(path), channel), source)


def sheet(
    table: Table | File | None = None,
    *,
    sheet: str | None = None,
    c: float | None = None,
    wavelength_nm: str | float | None = None,
    a: float | None = None,
    a_times_r: float | None = None,
    kernel: str | None = None,
    angular_spread_mrad: float | None = None,
    mu: float | None = None,
    half_mirror: float | None = None,
    setup: File | None = None,
    pixel_pitch: float | None = None,
) -> Result:
    """Make the result of a sheet that nobody has photographed, to predict and render with.

    Parameters
    ----------
    table : Table or path, optional
        Table of its cell. A named sheet brings its own.
    sheet : str, optional
        Name of a nominal sheet, such as ``"prism-0.1"``, whose numbers come from public sources and
        from assumptions (``fit render --help`` lists them). Or give ``c``:
    c : float, optional
        Corner size, mm.
    wavelength_nm, a, a_times_r
        What spreads the light: wave optics at these wavelengths; a lobe of this a (1/mm) at every
        distance; or a lobe of fixed angle, A = a R. Give one of them.
    angular_spread_mrad : float, optional
        Standard deviation of the direction of the returned light across the plane of incidence,
        mrad, for cubes whose dihedral angles differ from cell to cell.
    mu : float, optional
        Reflectance; without it the luminance is not known.
    half_mirror : float, optional
        Transmittance times reflectance of the half mirror.
    setup : path, optional
        TOML file with a table ``[setup]`` as in a manifest: polarisers, lamp, half mirror, ghost,
        haze.
    pixel_pitch : float, optional
        Side of a pixel of pictures, mm, for `Result.render`.
    """
    if table is not None:
        source = table if isinstance(table, Table) else open_table(table)
    elif sheet is not None:
        with refusals():
            source = Table(_midair.table_of_sheet(sheet))
    else:
        raise TypeError("give the table of the sheet's cell, or the name of a nominal sheet")
    options = dict(
        sheet=sheet,
        c=c,
        wavelength_nm=wavelength_nm,
        a=a,
        a_times_r=a_times_r,
        kernel=kernel,
        angular_spread_mrad=angular_spread_mrad,
        mu=mu,
        half_mirror=half_mirror,
        setup=setup,
        pixel_pitch=pixel_pitch,
    )
    with refusals():
        made = _midair.sheet(words(**options), source._table)
    return Result(made, source, has_pitch=pixel_pitch is not None)


def example() -> str:
    """Return the manifest of a small campaign that comes with the package.

    It has eight simulated photographs of a sheet of acrylic (index 1.49) at azimuth 30 degrees,
    whose c is 0.33 mm. ``truth.json`` beside the manifest holds all that was planted.

    Returns
    -------
    str
        Path of the manifest, for `estimate`.
    """
    return str(pathlib.Path(__file__).with_name("example") / "captures.toml")


@dataclass(frozen=True)
class Plan:
    """Planned photographs.

    Attributes
    ----------
    manifest : str
        Text of the manifest to fill in, TOML.
    report : Report
        Page to print, with boxes to tick.
    data : dict
        What ``fit plan --json`` prints: the photographs, the errors to expect, and what further
        photographs would bring.
    """

    manifest: str = field(repr=False)
    report: Report = field(repr=False)
    data: dict[str, Any]

    def save(self, path: File) -> None:
        """Write the manifest to a file, whole or not at all."""
        with refusals():
            _midair.write(os.fspath(path), self.manifest)


def plan(
    plan: File,
    table: Table | File,
    *,
    given: Result | None = None,
    threads: int | None = None,
) -> Plan:
    """Say which photographs tell a sheet's c, a and mu best, as ``fit plan`` does.

    Parameters
    ----------
    plan : path
        Beliefs and choices, as TOML; ``fit plan --help`` shows an example.
    table : Table or path
        Table of the cell, with the directions of the choices.
    given : Result, optional
        Result of earlier photographs, to which the planned ones add.

    Raises
    ------
    Error
        If the plan, the table or the result cannot be used.
    """
    if not isinstance(table, Table):
        table = open_table(table)
    with refusals():
        made = _midair.plan(
            words(plan, table="table", threads=threads),
            table._table,
            None if given is None else given._result,
        )
    data, manifest, page, warnings = made
    warn(warnings)
    return Plan(manifest, Report(page), json.loads(data))


def simulate(
    params: File,
    output: File,
    *,
    table: File | None = None,
    force: bool = False,
    threads: int | None = None,
) -> str:
    """Write a synthetic campaign with a known answer, as ``fit simulate`` does.

    Parameters
    ----------
    params : path
        Parameters, as TOML; ``fit simulate --help`` shows all keys.
    output : path
        Folder that is made.
    table : path, optional
        Exact table of the sheet, in place of the ideal cube.
    force : bool
        True to write into a folder that holds something.

    Returns
    -------
    str
        Path of the manifest, for `estimate`.
    """
    options = dict(output=output, table=table, force=force, threads=threads)
    with refusals():
        data = json.loads(_midair.simulate(words(params, **options)))
    warn(data["warnings"])
    return cast(str, data["manifest"])


def study(
    captures: File | None = None,
    *,
    table: File,
    ranges: File | None = None,
    campaigns: int | None = None,
    seed: int | None = None,
    choice: bool = False,
    mistakes: bool = False,
    other_table: File | None = None,
    csv: File | None = None,
    plot: File | None = None,
    model: str | None = None,
    kernel: str | None = None,
    lobe: str | None = None,
    per_angle: str | Sequence[str] | None = None,
    shared: str | Sequence[str] | None = None,
    forward: str | None = None,
    samples: Numbers | None = None,
    randomisations: int | None = None,
    threads: int | None = None,
    progress: Progress = None,
) -> dict[str, Any]:
    """Study how good estimates are, as ``fit study --json`` does.

    Parameters
    ----------
    captures : path, optional
        Manifest of photographs whose errors are compared with the Cramér-Rao bound.
    ranges : path, optional
        Ranges from which campaigns are drawn, in place of photographs.
    campaigns : int, optional
        Number of drawn campaigns.

    Returns
    -------
    dict
        What the program prints as JSON.
    """
    options: dict[str, Any] = dict(
        table=table,
        ranges=ranges,
        campaigns=campaigns,
        seed=seed,
        choice=choice,
        mistakes=mistakes,
        other_table=other_table,
        csv=csv,
        plot=plot,
        model=model,
        kernel=kernel,
        lobe=lobe,
        per_angle=per_angle,
        shared=shared,
        forward=forward,
        samples=samples,
        randomisations=randomisations,
        threads=threads,
        json=True,
    )
    arguments = () if captures is None else (captures,)
    with refusals(), told(progress) as tell:
        return cast("dict[str, Any]", json.loads(_midair.study(words(*arguments, **options), tell)))
