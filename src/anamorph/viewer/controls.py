"""The controls of a scene, of the eye and of a method, made from these: what can be set, within which limits.

Nothing is remembered here: a value of a control changes the scene as it was opened, whatever was set before.
"""

from __future__ import annotations

import dataclasses
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from anamorph.base.errors import AnamorphError, nearest
from anamorph.editing.arching import arch_of
from anamorph.editing.bending import bend_of
from anamorph.editing.edit import Edit, edit, lens_of
from anamorph.editing.grinding import USUAL, index_limits, optics_of, power_limits
from anamorph.methods.options import limits_of, summaries
from anamorph.methods.protocol import Method
from anamorph.scene.camera import Camera
from anamorph.scene.checks import check_camera
from anamorph.scene.model import Glass, Mesh, Mirror, Scene
from anamorph.scene.parts import specular_parts

TURNS = {
    "swivel": "about its up axis; positive turns what faces you to your right",
    "tilt": "about its right axis; positive turns what faces you upward",
    "roll": "about its outward axis; positive turns it counter-clockwise as you look at it",
}
MOVES = {"right": "to the right, as you look at it", "up": "upward", "outward": "the way it faces"}
SHAPES = ("curvature", "cross_curvature", "added_curvature", "reflectance", "power", "index")
WHATS = (*TURNS, *MOVES, *SHAPES)
LABELS = {"power": "back vertex power"}
"""Of what is not labelled by its own name."""

MOST_TURN = 45.0
ROUND = (1.0, 2.0, 5.0, 10.0)

EYE = "eye"
EYE_REACH = 4.0
"""How far a control takes the eye from where the scene has it, in its distances from its target."""

STEPS = 1000.0
"""Into how many steps a control's range is divided, about."""

KINDS = {bool: "flag", int: "whole", float: "number", str: "word"}


@dataclass(frozen=True)
class Control:
    """Something that can be set to a number.

    Parameters
    ----------
    key : str
        "PART/what": what values are kept under.
    label : str
    group : str
        The part.
    unit : str
        "°", "mm", "m", "1/m", "D" or "".
    low, high : float
        Limits; a curvature, a power or an index may reach further where the part does.
    default : float
        As the scene was opened.
    step : float
    summary : str
        One line on what it does, and on its sign.
    """

    key: str
    label: str
    group: str
    unit: str
    low: float
    high: float
    default: float
    step: float
    summary: str


@dataclass(frozen=True)
class OptionControl:
    """An option of a method.

    Parameters
    ----------
    name : str
    kind : str
        "flag", "whole", "number", "choice", or "word" for text without choices.
    default : bool, int, float or str
    choices : tuple
        Of a choice, the only values there are.
    low, high : float or None
        Of numbers; None where there is no limit.
    unit : str
    summary : str
    """

    name: str
    kind: str
    default: Any
    choices: tuple[Any, ...]
    low: float | None
    high: float | None
    unit: str
    summary: str


# Made anew they would take a panel's whole frame.
@lru_cache(maxsize=4)
def scene_controls(scene: Scene) -> tuple[Control, ...]:
    """The controls of every part of a scene that has a mirror or glass in it, part by part."""
    parts = _parts(scene)
    return tuple(
        control for name, own in parts.items() for control in _part_controls(name, [scene.meshes[i] for i in own])
    )


def edited(scene: Scene, values: Mapping[str, float]) -> Scene:
    """The scene with the values of its controls.

    Parameters
    ----------
    scene : Scene
        As it was opened.
    values : mapping of str to float
        By the keys of `scene_controls`, in their units; what is left out stays. They may lie beyond the limits.

    Returns
    -------
    Scene
        Its meshes that nothing is changed of are the very same, and without values so is it.

    Raises
    ------
    AnamorphError
        There is no such control, or the part cannot be made so.
    """
    if not values:
        return scene
    parts, meshes = _parts(scene), list(scene.meshes)
    for name, given in _by_part(values, parts).items():
        own = parts[name]
        for number, mesh in zip(own, edit(tuple(meshes[i] for i in own), _edit(given)), strict=True):
            meshes[number] = mesh
    same = all(new is old for new, old in zip(meshes, scene.meshes, strict=True))
    return scene if same else replace(scene, meshes=tuple(meshes))


def part_edits(scene: Scene, values: Mapping[str, float]) -> dict[str, Edit]:
    """What `values` change of each part, by its name: as a scene file says it."""
    return {name: _edit(given) for name, given in _by_part(values, _parts(scene)).items()}


def reading(control: Control, value: float) -> str:
    """A value as a user reads it: a curvature with its radius beside it."""
    if control.unit != "1/m":
        return f"{value:.4g} {control.unit}".rstrip()
    if control.key.endswith("/added_curvature"):
        return "as it was" if value == 0.0 else f"more {'convex' if value > 0.0 else 'concave'}"
    if abs(value) < control.step / 2.0:
        return "flat"
    return f"{'convex' if value > 0.0 else 'concave'}, R = {1.0 / abs(value):.4g} m"


def eye_controls(camera: Camera, scene: Scene) -> tuple[Control, ...]:
    """The controls of an eye: where it is, and its field of view. See `with_eye`."""
    opened = scene.camera
    reach = EYE_REACH * float(np.linalg.norm(np.subtract(opened.target, opened.position)))
    step, places = _round(2.0 * reach / STEPS), zip("xyz", opened.position, camera.position, strict=True)
    controls = [
        Control(
            f"{EYE}/{axis}", axis, EYE, "m", min(at - reach, now), max(at + reach, now), at, step,
            f"where the eye is along the world's {axis} axis; it keeps looking at its target",
        )
        for axis, at, now in places
    ]  # fmt: skip
    field = Control(
        f"{EYE}/field_of_view", "field of view", EYE, "°", min(1.0, camera.field_of_view),
        max(150.0, camera.field_of_view), opened.field_of_view, 0.5, "the full vertical angle of the image",
    )  # fmt: skip
    return (*controls, field)


def with_eye(camera: Camera, key: str, value: float) -> Camera:
    """The eye with one of its controls set."""
    keys = [f"{EYE}/{what}" for what in ("x", "y", "z", "field_of_view")]
    if key not in keys:
        raise AnamorphError(f"no control '{key}'{nearest(key, keys)} (known: {', '.join(keys)})")
    values = dict(zip(keys, (*camera.position, camera.field_of_view), strict=True))
    x, y, z, field = (values | {key: value}).values()
    changed = replace(camera, position=(x, y, z), field_of_view=field)
    check_camera(changed, EYE)
    return changed


@lru_cache(maxsize=32)
def option_controls(method: Method) -> tuple[OptionControl, ...]:
    """The options of a method, in their order."""
    texts = summaries(method.options)

    def control(field: dataclasses.Field[Any]) -> OptionControl:
        limits = limits_of(field)
        kind = "choice" if limits.choices else KINDS.get(type(field.default), "word")
        summary = texts.get(field.name, "")
        return OptionControl(
            field.name, kind, field.default, limits.choices, limits.low, limits.high, limits.unit, summary
        )

    return tuple(control(field) for field in dataclasses.fields(method.options))


@lru_cache(maxsize=2)
def _parts(scene: Scene) -> dict[str, tuple[int, ...]]:
    return specular_parts(scene.meshes)


def _part_controls(name: str, meshes: list[Mesh]) -> list[Control]:
    specular = [mesh for mesh in meshes if mesh.specular]
    size = float(np.linalg.norm(np.ptp(np.concatenate([mesh.positions for mesh in specular]).astype(float), axis=0)))
    away = _round(1e3 * size)
    return [
        *(_control(name, what, "°", (-MOST_TURN, MOST_TURN), 0.0, f"turn it {how}") for what, how in TURNS.items()),
        *(_control(name, what, "mm", (-away, away), 0.0, f"move it {how}") for what, how in MOVES.items()),
        *_shape_controls(name, meshes, specular),
    ]


def _shape_controls(name: str, meshes: list[Mesh], specular: list[Mesh]) -> list[Control]:
    controls = []
    bend = bend_of(specular[0]) if len(specular) == 1 else None
    if bend is not None:
        # Whoever has two keys has two curvatures.
        for what, curvature in zip(SHAPES, bend.curvatures, strict=False):
            which = "of its other section, " if what == "cross_curvature" else ""
            summary = f"{which}one over the radius: positive is convex, 0 flat, negative concave"
            controls.append(_control(name, what, "1/m", bend.limits, curvature, summary))
    arch = arch_of([mesh for mesh in specular if isinstance(mesh.material, Mirror)])
    if arch is not None:
        summary = "one over a radius, added to the mirror's own: positive is more convex, negative more concave"
        controls.append(_control(name, "added_curvature", "1/m", (-arch.limit, arch.limit), 0.0, summary))
    match specular[0].material:
        case Mirror(reflectance=reflectance):
            summary = "the share of light that it reflects, seen squarely"
            controls.append(_control(name, "reflectance", "", (0.0, 1.0), reflectance, summary))
    lens = lens_of(meshes)
    if lens is not None:
        front, back = meshes[lens.front], meshes[lens.back]
        optics, limits = optics_of(front, back), power_limits(front, back)
        if optics is not None and limits is not None:
            summary = "at the back, for far objects: positive converges; the back is bent, the front stays"
            controls.append(_control(name, "power", "D", limits, optics.power, summary))
    glass = next((mesh.material for mesh in specular if isinstance(mesh.material, Glass)), None)
    if glass is not None:
        low, high = USUAL if lens is None else index_limits(meshes[lens.front], meshes[lens.back])
        limits = min(low, glass.index), max(high, glass.index)
        summary = "refractive index of the glass" + ("; the power stays" if lens is not None else "")
        controls.append(_control(name, "index", "", limits, glass.index, summary))
    return controls


def _control(part: str, what: str, unit: str, limits: tuple[float, float], default: float, summary: str) -> Control:
    low, high = limits
    step = _round((high - low) / STEPS)
    label = LABELS.get(what, what.replace("_", " "))
    return Control(f"{part}/{what}", label, part, unit, low, high, default, step, summary)


def _round(value: float) -> float:
    """The round number (1, 2 or 5 times a power of ten) at or above a positive value."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(next(digit for digit in ROUND if digit * power >= value * (1.0 - 1e-9)) * power)


def _by_part(values: Mapping[str, float], parts: Mapping[str, tuple[int, ...]]) -> dict[str, dict[str, float]]:
    """Values by part, then by what is set of it."""
    given: dict[str, dict[str, float]] = defaultdict(dict)
    for key, value in values.items():
        part, _, what = key.rpartition("/")
        if part not in parts:
            raise AnamorphError(f"no control '{key}'{nearest(part, parts)} (parts: {', '.join(parts) or 'none'})")
        if what not in WHATS:
            raise AnamorphError(f"no control '{key}'{nearest(what, WHATS)} (known: {', '.join(WHATS)})")
        given[part][what] = value
    return given


def _edit(given: Mapping[str, float]) -> Edit:
    swivel, tilt, roll = (given.get(what, 0.0) for what in TURNS)
    right, up, outward = (1e-3 * given.get(what, 0.0) for what in MOVES)
    shapes = {what: given[what] for what in SHAPES if what in given}
    return Edit((swivel, tilt, roll), (right, up, outward), **shapes)
