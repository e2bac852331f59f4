"""Integrator `midair_path`: a path tracer that moves its paths at retroreflective sheets.

On ordinary surfaces it is the usual one: emitters are sampled, and both ways to reach an emitter
are weighted by the power heuristic. Where a path meets a sheet, one draw of shift and lobe moves
its origin and turns it, and it goes on.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

from midair._errors import Error, MidairWarning
from midair.mitsuba._directions import choose, is_scalar
from midair.mitsuba._keys import Keys

KEYS = ["max_depth", "rr_depth", "guided"]
#: What a path has met: a sheet or a guiding half mirror; 0 otherwise.
_SHEET, _MIRROR = 1, 2


@dataclass
class Found:
    """What a scene holds that the integrator must know of."""

    sheets: list[Any]
    #: Whether all sheets are rectangles, whose border needs no ray.
    are_rectangles: bool
    #: Whether derivatives by a parameter of the scene are being followed.
    is_followed: bool


def path_class(sheet: type, mirror: type) -> type:
    """Return the class of the integrator for the current variant."""

    class MidairPath(mi.SamplingIntegrator):  # type: ignore[misc, name-defined]
        """Path tracer for scenes with sheets; doc/renderer.md lists the keys."""

        def __init__(self, props: Any) -> None:
            super().__init__(props)
            keys = Keys(props, "midair_path", KEYS)
            self.max_depth = _count(keys, "max_depth", -1)
            self.rr_depth = _count(keys, "rr_depth", 5)
            self.is_guided = keys.flag("guided")
            self._known: tuple[Any, Found] | None = None
            self._is_forward = False

        def search(self, scene: Any) -> Found:
            """Return what a scene holds, or raise an error about its sheets."""
            return search(scene, sheet)

        def _found(self, scene: Any) -> Found:
            """Return what a scene holds."""
            # Parameters are replaced between renders, so each render looks again. Scalar variants
            # come here with every ray, and have no derivatives.
            if self._known is not None and self._known[0] is scene:
                return self._known[1]
            found = self.search(scene)
            if is_scalar():
                self._known = scene, found
            if not found.sheets:
                warnings.warn(
                    "midair_path: the scene has no midair_sheet and no midair_plate, so this is an "
                    'ordinary path tracer; give a shape the BSDF {"type": "midair_sheet"}',
                    MidairWarning,
                    stacklevel=3,
                )
            return found

        def sample(
            self, scene: Any, sampler: Any, ray: Any, medium: Any = None, active: Any = True
        ) -> tuple[Any, Any, list[Any]]:
            found = self._found(scene)
            step = _Step(self, scene, found, sheet, mirror)
            state = _State.of(ray, active)
            if is_scalar():
                while state.active:
                    step(sampler, state)
            else:

                def body(sampler: Any, state: _State) -> tuple[Any, _State]:
                    step(sampler, state)
                    return sampler, state

                _, state = dr.while_loop(
                    (sampler, state),
                    lambda sampler, state: state.active,
                    body,
                    labels=("sampler", "state"),
                    # Reverse derivatives need each turn in memory, forward ones must not have it.
                    mode="evaluated"
                    if found.is_followed and not self._is_forward
                    else "symbolic",
                    max_iterations=self.max_depth if self.max_depth > 0 else None,
                    label="midair_path",
                )
            return choose(state.seen, state.light, 0), state.seen, []

        def render_forward(self, *arguments: Any, **options: Any) -> Any:
            """Return the derivative of an image, which `dr.forward` follows in `mi.render`."""
            self._is_forward = True
            try:
                return super().render_forward(*arguments, **options)
            finally:
                self._is_forward = False

        def to_string(self) -> str:
            return (
                f"MidairPath[\n  max_depth = {self.max_depth},\n  rr_depth = {self.rr_depth},\n"
                f"  guided = {self.is_guided}\n]"
            )

    return MidairPath


class _State:
    """State of a path between two surfaces."""

    DRJIT_STRUCT: dict[str, Any]

    @classmethod
    def of(cls, ray: Any, active: Any) -> _State:
        made = _state_class()()
        made.ray = mi.Ray3f(ray)
        made.light, made.factor = mi.Spectrum(0), mi.Spectrum(1)
        made.eta, made.depth = mi.Float(1), mi.UInt32(0)
        made.before = dr.zeros(mi.Interaction3f)
        made.density, made.is_delta = mi.Float(1), mi.Bool(True)
        made.returned, made.seen, made.active = mi.Bool(False), mi.Bool(False), mi.Bool(active)
        return made


def _state_class() -> type:
    """Return the state for the current variant, which names the types of its fields."""
    fields = {
        "ray": mi.Ray3f,
        "light": mi.Spectrum,
        "factor": mi.Spectrum,
        "eta": mi.Float,
        "depth": mi.UInt32,
        "before": mi.Interaction3f,
        "density": mi.Float,
        "is_delta": mi.Bool,
        "returned": mi.Bool,
        "seen": mi.Bool,
        "active": mi.Bool,
    }
    return type("State", (_State,), {"DRJIT_STRUCT": fields})


class _Step:
    """One turn of the loop: from a surface to the next."""

    def __init__(self, integrator: Any, scene: Any, found: Found, sheet: type, mirror: type):
        self.integrator, self.scene, self.has_sheets = integrator, scene, bool(found.sheets)
        self.has_spread = any(one.has_spread for one in found.sheets)
        self.are_rectangles = found.are_rectangles
        self.sheet, self.mirror = sheet, mirror
        self.limit = integrator.max_depth if integrator.max_depth >= 0 else 0xFFFFFFFF
        self.context = mi.BSDFContext()
        self.has_emitters = len(scene.emitters()) > 0

    def __call__(self, sampler: Any, s: _State) -> None:
        scene = self.scene
        si = scene.ray_intersect(
            s.ray, ray_flags=+mi.RayFlags.All, coherent=s.depth == 0, active=s.active
        )
        self._emission(si, s)
        s.seen |= s.active & si.is_valid()
        active = s.active & si.is_valid() & (s.depth + 1 < self.limit)
        if is_scalar() and not active:
            s.active = False
            return
        bsdf = si.bsdf(s.ray)
        has_lobe = active & mi.has_flag(bsdf.flags(), mi.BSDFFlags.Smooth)
        light = sampler.next_2d()
        ds, emitted = scene.sample_emitter_direction(si, light, True, has_lobe)
        has_lobe &= ds.pdf != 0
        wo = si.to_local(ds.d)
        pick, point = sampler.next_1d(), sampler.next_2d()
        # One call of the BSDF gives both: its value towards the emitter, and a new direction.
        is_ours = mi.Bool(False)
        if self.has_sheets:
            # No emitter is sampled from a sheet, so its lobe has these numbers.
            spread = sampler.next_2d() if self.has_spread else mi.Point2f(0)
            numbers = pick, point, sampler.next_1d(), light, spread
            value, density, bs, weight, is_ours = self._meet(s, si, bsdf, wo, numbers, active)
        else:
            value, density, bs, weight = bsdf.eval_pdf_sample(
                self.context, si, wo, pick, point, active
            )
        value = si.to_world_mueller(value, -wo, si.wi)
        ours = choose(ds.delta, 1, _heuristic(ds.pdf, density))
        s.light = choose(has_lobe, s.light + s.factor * (value * emitted * ours), s.light)
        weight = si.to_world_mueller(weight, -bs.wo, si.wi)
        ray = si.spawn_ray(si.to_world(bs.wo))
        # Rays begin a little above their surface, along its normal. That would move a mid-air image
        # by some 0.01 mm at 300 mm, so rays of sheets and half mirrors begin on their own line.
        above = dr.dot(ray.o - si.p, si.n) / dr.dot(ray.d, si.n)
        ray.o = choose(is_ours, si.p + above * ray.d, ray.o)
        s.ray = choose(active, ray, s.ray)
        s.factor = choose(active, s.factor * weight, s.factor)
        s.eta = choose(active, s.eta * bs.eta, s.eta)
        s.before = choose(
            active, mi.Interaction3f(si.t, si.time, si.wavelengths, si.p, si.n), s.before
        )
        s.density = choose(active, bs.pdf, s.density)
        is_delta = mi.has_flag(bs.sampled_type, mi.BSDFFlags.Delta)
        s.is_delta = choose(active, is_delta, s.is_delta)
        s.depth = choose(si.is_valid() & active, s.depth + 1, s.depth)
        s.active = active & self._goes_on(sampler, s)

    def _emission(self, si: Any, s: _State) -> None:
        """Add the light of an emitter that the path has met."""
        if not self.has_emitters:
            return
        emitter = si.emitter(self.scene)
        if is_scalar():
            if emitter is None:
                return
            chance = 0.0
            if not s.is_delta:
                ds = mi.DirectionSample3f(self.scene, si, s.before)
                chance = self.scene.pdf_emitter_direction(s.before, ds)
            ours = _heuristic(s.density, chance)
            s.light = s.light + s.factor * (emitter.eval(si) * ours)
            return
        ds = mi.DirectionSample3f(self.scene, si, s.before)
        chance = self.scene.pdf_emitter_direction(s.before, ds, s.active & ~s.is_delta)
        ours = _heuristic(s.density, choose(s.is_delta, 0, chance))
        here = s.factor * (emitter.eval(si, s.active) * ours)
        s.light = choose(s.active, s.light + here, s.light)

    def _meet(
        self, s: _State, si: Any, bsdf: Any, wo: Any, numbers: tuple[Any, ...], active: Any
    ) -> tuple[Any, Any, Any, Any, Any]:
        """Evaluate and sample BSDFs, with sheets that move `si.p` and half mirrors that guide.

        Returns what `eval_pdf_sample` does, and which paths have met a sheet or a guiding mirror.
        """
        guides, context = self.integrator.is_guided, self.context
        sheet, mirror = self.sheet, self.mirror

        def meet(self: Any, si: Any, wo: Any, given: Any, active: Any) -> tuple[Any, ...]:
            *numbers, returned = given
            if isinstance(self, sheet):
                weight, shift, out = self.follow(si, *numbers, active)
                return mi.Spectrum(0), mi.Float(0), _sent(out), weight, shift, mi.UInt32(_SHEET)
            none = mi.Vector2f(0)
            if guides and isinstance(self, mirror):
                weight, out = self.guided(si, returned)
                return mi.Spectrum(0), mi.Float(0), _sent(out), weight, none, mi.UInt32(_MIRROR)
            pick, point, *_ = numbers
            made = self.eval_pdf_sample(context, si, wo, pick, point, active)
            return *made, none, mi.UInt32(0)

        given = (*numbers, s.returned)
        if is_scalar():
            made = meet(bsdf, si, wo, given, active)
        else:
            made = dr.dispatch(bsdf, meet, si, wo, given, active)
        value, density, bs, weight, shift, met = made
        at_sheet = active & (met == _SHEET)
        shift = si.sh_frame.s * shift.x + si.sh_frame.t * shift.y
        inside = self._is_on_sheet(si, shift, at_sheet)
        weight = choose(at_sheet & _isnt(inside), 0, weight)
        si.p = choose(at_sheet, si.p + shift, si.p)
        s.returned |= at_sheet
        return value, density, bs, weight, active & (met != 0)

    def _is_on_sheet(self, si: Any, shift: Any, active: Any) -> Any:
        """Return whether a shifted place still lies on its sheet."""
        if is_scalar() and not active:
            return False
        shift = dr.detach(shift)
        if self.are_rectangles:
            # Their u and v go from 0 to 1 along two sides at right angles.
            u = si.uv.x + dr.dot(shift, si.dp_du) / dr.squared_norm(si.dp_du)
            v = si.uv.y + dr.dot(shift, si.dp_dv) / dr.squared_norm(si.dp_dv)
            return (u >= 0) & (u <= 1) & (v >= 0) & (v <= 1)
        return self._is_hit(si, shift, active)

    def _is_hit(self, si: Any, shift: Any, active: Any) -> Any:
        """Return whether a short ray across the sheet meets it at a shifted place."""
        # Long enough for the sag of a curved sheet and for the rounding of coordinates.
        place = dr.detach(si.p) + shift
        size = dr.maximum(dr.max(dr.abs(place)), 1)
        reach = 0.1 * dr.norm(shift) + 1e-5 * size
        normal = mi.Vector3f(si.n)
        probe = mi.Ray3f(
            place + reach * normal, -normal, 2 * reach, si.time, si.wavelengths
        )
        hit = self.scene.ray_intersect_preliminary(probe, coherent=False, active=active)
        same = hit.is_valid()
        # Within an instance, an intersection without details names the instance alone.
        if is_scalar():
            return same and (hit.shape is None or hit.shape == si.shape)
        same &= hit.instance == si.instance
        return same & ((hit.shape == si.shape) | (hit.shape == None))  # noqa: E711

    def _goes_on(self, sampler: Any, s: _State) -> Any:
        """Return whether paths go on: those without light end, long ones by chance."""
        brightest = dr.max(mi.unpolarized_spectrum(s.factor))
        goes_on = brightest != 0
        chance = dr.detach(dr.minimum(brightest * dr.square(s.eta), 0.95))
        by_chance = s.depth >= self.integrator.rr_depth
        s.factor = choose(by_chance, s.factor / dr.maximum(chance, 1e-12), s.factor)
        return goes_on & (_isnt(by_chance) | (sampler.next_1d() < chance))


def _sent(direction: Any) -> Any:
    """Return the sample of a BSDF that sends a ray in one direction."""
    made = mi.BSDFSample3f()
    made.wo, made.pdf, made.eta = direction, mi.Float(1), mi.Float(1)
    made.sampled_type = mi.UInt32(+mi.BSDFFlags.DeltaReflection)
    made.sampled_component = mi.UInt32(0)
    return made


def _heuristic(ours: Any, other: Any) -> Any:
    """Return the weight of a sample by the power heuristic; derivatives do not follow it."""
    a, b = dr.square(ours), dr.square(other)
    return dr.detach(choose(a > 0, a / dr.maximum(a + b, 1e-30), 0))


def _isnt(mask: Any) -> Any:
    """Return the opposite of a mask; ~ of a bool of Python is a number."""
    return not mask if isinstance(mask, bool) else ~mask


def _count(keys: Keys, name: str, default: int) -> int:
    value = keys.props.get(name, default)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or value != int(value):
        raise Error(f"midair_path: {name} is {value!r}; give a whole number")
    if value < -1 or (name == "rr_depth" and value < 1):
        raise Error(f"midair_path: {name} is {value:g}; give 1 or more" + (
            ", or -1 for no limit" if name == "max_depth" else ""))
    return int(value)


def search(scene: Any, sheet: type) -> Found:
    """Return the sheets of a scene, instances included.

    Raises
    ------
    Error
        If a sheet lies inside another BSDF, which would lose its shift, or if azimuth 0 is not
        defined on a mesh.
    """
    found = Found([], True, False)
    seen: set[Any] = set()

    class Walk(mi.TraversalCallback):  # type: ignore[misc, name-defined]
        def __init__(self, owner: Any) -> None:
            super().__init__()
            self.owner = owner

        def put(self, name: str, value: Any, flags: Any, kind: Any = None) -> None:
            if isinstance(value, mi.Object):
                visit(value, self.owner)
                return
            if kind is not None:
                value = mi.get_property(value, kind, self.owner)
            if dr.is_diff_v(value) and dr.is_float_v(value):
                # In the pass without derivatives, results of arithmetic have none.
                found.is_followed |= dr.grad_enabled(value * 1)

    def visit(thing: Any, owner: Any) -> None:
        if isinstance(thing, sheet):
            _check(thing, owner)
            found.are_rectangles &= (
                isinstance(owner, mi.Shape) and owner.shape_type() == +mi.ShapeType.Rectangle
            )
            if thing not in found.sheets:
                found.sheets.append(thing)
        if id(thing) in seen:
            return
        seen.add(id(thing))
        thing.traverse(Walk(thing))

    visit(scene, None)
    return found


def _check(sheet: Any, owner: Any) -> None:
    if isinstance(owner, mi.BSDF):
        raise Error(
            f"{sheet.plugin}: lies inside of {owner.class_name()}, which would lose the shift; "
            "give it to the shape itself (its back reflects nothing)"
        )
    is_mesh = isinstance(owner, mi.Mesh)
    if is_mesh and sheet.first_edge is None and not owner.has_vertex_texcoords():
        raise Error(
            f"{sheet.plugin}: its mesh has no texture coordinates, so azimuth 0 is not defined; "
            "give first_edge, a vector in the sheet such as [1, 0, 0]"
        )
