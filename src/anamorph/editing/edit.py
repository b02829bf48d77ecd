"""Changing a part of a scene where it stands: turned, moved, bent, ground to another power. Exact surfaces stay exact.

A part is one mesh, or several that stay together, as a lens: see `parts`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.base.vectors import Vector
from anamorph.editing.arching import arched
from anamorph.editing.bending import bent
from anamorph.editing.grinding import ground
from anamorph.scene.lens_pairs import LensPair, lens_pairs
from anamorph.scene.model import Glass, Mesh, Mirror
from anamorph.scene.pose import WORLD_UP, Pose, box_middle, mean_normal, upright_axes
from anamorph.surfaces.similarity import Similarity, rotation

INDICES = (0.1, 10.0)
"""The least and the greatest refractive index."""


@dataclass(frozen=True)
class Edit:
    """What is changed of a part; None leaves it as it is.

    Bending and grinding come first, then turning, then moving.

    Parameters
    ----------
    turn : (swivel, tilt, roll)
        Degrees, about the part's middle: positive ones turn the side that faces the onlooker to their right, upward,
        and counter-clockwise. Roll comes first, then tilt, then swivel.
    move : (right, up, outward)
        Metres, along the axes of the part before it is turned: see `part_pose`.
    curvature : float, optional
        Of a mirror, 1/m, positive where it bulges outward: see `bent`.
    cross_curvature : float, optional
        Of a toroid, along its arc, 1/m.
    added_curvature : float, optional
        Of a mirror of patches or CAD faces, added to what they have, 1/m: see `arched`.
    reflectance : float, optional
        Of mirrors, at normal incidence: 0 to 1.
    power : float, optional
        Back vertex power of a lens, dioptres: see `ground`.
    index : float, optional
        Refractive index of glass, 0.1 to 10; a lens keeps its power.
    """

    turn: Vector = (0.0, 0.0, 0.0)
    move: Vector = (0.0, 0.0, 0.0)
    curvature: float | None = None
    cross_curvature: float | None = None
    added_curvature: float | None = None
    reflectance: float | None = None
    power: float | None = None
    index: float | None = None


def edit(meshes: tuple[Mesh, ...], by: Edit) -> tuple[Mesh, ...]:
    """The meshes of one part, changed; what nothing is changed of is the very same mesh.

    Raises
    ------
    AnamorphError
        The part cannot be changed so.
    """
    _check(meshes, by)
    lens = lens_of(meshes)
    shaped = _shaped(meshes, lens, by)
    turned, moved = any(by.turn), any(by.move)
    if not turned and not moved:
        return shaped
    # Along the axes of the part as it was, so that bending it neither turns nor moves it.
    pose = part_pose(meshes, lens)
    swivel, tilt, roll = by.turn
    local = rotation((0.0, swivel, 0.0)) @ rotation((-tilt, 0.0, 0.0)) @ rotation((0.0, 0.0, roll))
    turn = pose.axes.T @ local @ pose.axes if turned else np.eye(3)
    motion = Similarity(1.0, turn, pose.center - turn @ pose.center + np.asarray(by.move) @ pose.axes)
    return tuple(mesh.moved(motion) for mesh in shaped)


def part_pose(meshes: Sequence[Mesh], lens: LensPair | None) -> Pose:
    """The middle and the axes of one part, of its specular meshes where it has some; `lens` as from `lens_of`.

    Outward is the mean normal; of a lens, that of its front. A body that looks all ways has the world's axes.
    """
    own = [mesh for mesh in meshes if mesh.specular] or meshes
    faces = own if lens is None else (meshes[lens.front], meshes[lens.back])
    outward = mean_normal(faces[:1] if lens is not None else faces)
    axes = np.eye(3) if outward is None else upright_axes(outward, WORLD_UP)
    return Pose(box_middle(faces, axes), axes)


def lens_of(meshes: Sequence[Mesh]) -> LensPair | None:
    """The lens that the meshes of one part are, if they are one."""
    found = lens_pairs(meshes)
    return found[0] if len(found) == 1 else None


def _check(meshes: tuple[Mesh, ...], by: Edit) -> None:
    name = meshes[0].name
    for field in fields(by):
        value = getattr(by, field.name)
        if value is not None and not np.isfinite(value).all():
            raise AnamorphError(f"part '{name}': {field.name} is {value}; give finite numbers")
    for key, material in (("reflectance", Mirror), ("index", Glass)):
        if getattr(by, key) is not None and not any(isinstance(mesh.material, material) for mesh in meshes):
            remedy = f"{material.__name__.lower()} = {{ {key} = {getattr(by, key):g} }}"
            raise AnamorphError(f"part '{name}': has no {key}, it is no {material.__name__.lower()}; give {remedy}")
    for key, low, high in (("reflectance", 0.0, 1.0), ("index", *INDICES)):
        value = getattr(by, key)
        if value is not None and not low <= value <= high:
            raise AnamorphError(f"part '{name}': {key} is {value:g}; give a number from {low:g} to {high:g}")


def _shaped(meshes: tuple[Mesh, ...], lens: LensPair | None, by: Edit) -> tuple[Mesh, ...]:
    """The meshes with their surfaces and materials changed."""
    changed = list(meshes)
    if by.curvature is not None or by.cross_curvature is not None:
        mirrors = [number for number, mesh in enumerate(meshes) if isinstance(mesh.material, Mirror)]
        if len(mirrors) != 1:
            raise AnamorphError(f"part '{meshes[0].name}': is {len(mirrors)} mirrors; bend one mirror at a time")
        changed[mirrors[0]] = bent(meshes[mirrors[0]], by.curvature, by.cross_curvature)
    if by.added_curvature is not None:
        mirrors = [number for number, mesh in enumerate(meshes) if isinstance(mesh.material, Mirror)]
        if not mirrors:
            raise AnamorphError(f"part '{meshes[0].name}': is no mirror; leave added_curvature out")
        further = arched(tuple(meshes[number] for number in mirrors), by.added_curvature)
        for number, mesh in zip(mirrors, further, strict=True):
            changed[number] = mesh
    if by.power is not None and lens is None:
        raise AnamorphError(f"part '{meshes[0].name}': has no power, it is no lens of two faces; leave power out")
    if lens is not None and (by.power is not None or by.index is not None):
        numbers = [number for number in (lens.front, lens.back, lens.edge) if number is not None]
        for number, mesh in zip(numbers, ground([meshes[i] for i in numbers], by.power, by.index), strict=True):
            changed[number] = mesh
    for number, mesh in enumerate(changed):
        match mesh.material:
            case Glass(index=index) if by.index not in (None, index):
                changed[number] = replace(mesh, material=replace(mesh.material, index=by.index))
            case Mirror(reflectance=reflectance) if by.reflectance not in (None, reflectance):
                changed[number] = replace(mesh, material=replace(mesh.material, reflectance=by.reflectance))
    return tuple(changed)
