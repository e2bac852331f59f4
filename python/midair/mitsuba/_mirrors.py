"""BSDFs `midair_half_mirror`, thin, and `midair_plate`, a micro-mirror array plate."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from midair._errors import Error
from midair.mitsuba._directions import choose
from midair.mitsuba._keys import SHEET, Keys


def half_mirror_class(delta: type) -> type:
    """Return the class of the half mirror for the current variant."""

    class MidairHalfMirror(delta):  # type: ignore[misc, valid-type]
        """Thin half mirror: reflects a share of the light, passes another, absorbs the rest."""

        def __init__(self, props: Any) -> None:
            super().__init__(props)
            keys = Keys(props, "midair_half_mirror", ["transmittance", "reflectance"])
            passed = keys.number("transmittance", 0.5)
            thrown = keys.number("reflectance", 0.5)
            if passed + thrown > 1 + 1e-9:
                raise Error(
                    f"midair_half_mirror: transmittance {passed:g} and reflectance {thrown:g} make "
                    "more than 1; give shares of the light that add up to 1 at most"
                )
            self.transmittance = mi.Float(passed)
            self.reflectance = mi.Float(thrown)
            both = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
            self.m_components = [mi.BSDFFlags.DeltaReflection | both, mi.BSDFFlags.Null | both]
            self.m_flags = self.m_components[0] | self.m_components[1]

        def traverse(self, callback: Any) -> None:
            for name in ("transmittance", "reflectance"):
                callback.put(name, getattr(self, name), mi.ParamFlags.Differentiable)

        def sample(
            self, context: Any, si: Any, sample1: Any, sample2: Any, active: Any = True
        ) -> tuple[Any, Any]:
            total = dr.maximum(self.reflectance + self.transmittance, 1e-9)
            chance = dr.detach(self.reflectance / total)
            reflects = sample1 < chance
            made = mi.BSDFSample3f()
            made.wo = choose(reflects, _mirrored(si.wi), -si.wi)
            made.pdf = choose(reflects, chance, 1 - chance)
            made.eta = mi.Float(1)
            made.sampled_component = choose(reflects, mi.UInt32(0), mi.UInt32(1))
            made.sampled_type = choose(
                reflects,
                mi.UInt32(+mi.BSDFFlags.DeltaReflection),
                mi.UInt32(+mi.BSDFFlags.Null),
            )
            share = choose(reflects, self.reflectance, self.transmittance)
            return made, mi.Spectrum(share / dr.maximum(made.pdf, 1e-9)) & active

        def guided(self, si: Any, returned: Any) -> tuple[Any, Any]:
            """Return weight and direction of a path before the sheet, or after it (`returned`)."""
            weight = choose(returned, self.reflectance, self.transmittance)
            return mi.Spectrum(weight), choose(returned, _mirrored(si.wi), -si.wi)

        def eval_null_transmission(self, si: Any, active: Any = True) -> Any:
            return mi.Spectrum(self.transmittance)

        def to_string(self) -> str:
            return (
                f"MidairHalfMirror[\n  transmittance = {self.transmittance},\n"
                f"  reflectance = {self.reflectance}\n]"
            )

    return MidairHalfMirror


def plate_class(sheet: type) -> type:
    """Return the class of the plate for the current variant, from that of the sheet."""

    class MidairPlate(sheet):  # type: ignore[misc, valid-type]
        """Micro-mirror array plate: passes light with both components in the plate reversed.

        The table is that of `bake trace --element plate`. Light of either side makes an image.
        Behind the plate the way of light runs against that of the table: the in-plane direction of
        travel, and so the entry of the table, is that of the light before the plate, and the shift
        is its negative.
        """

        plugin = "midair_plate"
        known = [key for key in SHEET if key != "params"]

        def __init__(self, props: Any) -> None:
            super().__init__(props)
            options = self.numbers.table.provenance.get("options", "")
            if "--element plate" not in options:
                raise Error(
                    "midair_plate: the table is that of a sheet, not of a plate; trace it with "
                    'element="plate" (bake trace --element plate), or use midair_sheet'
                )
            both = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
            self.m_components = [mi.BSDFFlags.DeltaTransmission | both]
            self.m_flags = self.m_components[0]

        def _faced(self, si: Any) -> tuple[Any, Any]:
            """Return the surface as light of the front sees it, and the sign of the shift."""
            faced = type(si)(si)
            back = si.wi.z < 0
            faced.wi = mi.Vector3f(si.wi.x, si.wi.y, dr.abs(si.wi.z))
            return faced, choose(back, mi.Float(-1), mi.Float(1))

        def eta(self, si: Any, active: Any = True) -> Any:
            return super().eta(self._faced(si)[0], active)

        def follow(
            self, si: Any, pick: Any, point: Any, slot: Any, lobe: Any, spread: Any, active: Any
        ) -> tuple[Any, Any, Any]:
            faced, sign = self._faced(si)
            weight, shift, out = super().follow(faced, pick, point, slot, lobe, spread, active)
            # Straight back on the other side of the plate.
            return weight, sign * shift, mi.Vector3f(out.x, out.y, -sign * out.z)

        def sample(
            self, context: Any, si: Any, sample1: Any, sample2: Any, active: Any = True
        ) -> tuple[Any, Any]:
            made, weight = super().sample(context, self._faced(si)[0], sample1, sample2, active)
            made.wo = mi.Vector3f(si.wi.x, si.wi.y, -si.wi.z)
            made.sampled_type = mi.UInt32(+mi.BSDFFlags.DeltaTransmission)
            return made, weight

    return MidairPlate


def _mirrored(wi: Any) -> Any:
    return mi.Vector3f(-wi.x, -wi.y, wi.z)
