"""Which meshes are parts of one thing, by their names: the two faces of a lens, the patches of a teapot."""

from __future__ import annotations

from collections.abc import Sequence

from anamorph.scene.lens_pairs import lens_pairs
from anamorph.scene.model import Mesh


def part_names(meshes: Sequence[Mesh]) -> list[str]:
    """What each mesh is part of: the lens LENS for LENS/anything, else what stands before the first "/" of its name."""
    lenses = sorted((lens.name for lens in lens_pairs(meshes)), key=len, reverse=True)

    def part(name: str) -> str:
        own = (lens for lens in lenses if name == lens or name.startswith(f"{lens}/"))
        return next(own, name.partition("/")[0])

    return [part(mesh.name) for mesh in meshes]


def specular_parts(meshes: Sequence[Mesh]) -> dict[str, tuple[int, ...]]:
    """The parts with a mirror or glass in them: of each name, the indices of all its meshes."""
    parts: dict[str, list[int]] = {}
    for number, name in enumerate(part_names(meshes)):
        parts.setdefault(name, []).append(number)
    return {name: tuple(own) for name, own in parts.items() if any(meshes[number].specular for number in own)}
