"""What shaders need to bend a pixel's own ray at the exact surfaces of a scene's mirrors and lenses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from anamorph.optics.dispersion import line_indices
from anamorph.optics.ray_meshes import Body, Side
from anamorph.optics.refraction import Refractor
from anamorph.scene.geometry import Geometry
from anamorph.scene.lens_pairs import border_edges
from anamorph.scene.model import Mesh, Mirror, Scene
from anamorph.surfaces.device_numbers import DeviceFrame, device_numbers, device_parameters

EXACT_SIDE = np.dtype(
    [
        ("origin", "f4", 3), ("unit", "f4"),
        ("surface", "u4"), ("far_surface", "u4"), ("reflectance", "f4"), ("radius", "f4"),
        ("middle", "f4", 3), ("sure_radius", "f4"), ("axis", "f4", 4), ("indices", "f4", 4),
        ("far_u", "f4", 4), ("far_v", "f4", 4),
    ]
)  # fmt: skip
"""`ExactSide` of bend.wgsl."""


@dataclass(frozen=True, eq=False)
class ExactSides:
    """All that bends rays in a scene, mesh by mesh, as bend.wgsl and bend_lens.wgsl read it.

    Parameters
    ----------
    records : (meshes,) of EXACT_SIDE
        Of each specular mesh; zero for the others. That of a lens's face is for light that enters there.
    numbers : (N,) float32
        Those of all exact surfaces.
    kinds : (meshes, 2) uint32
        The kind of each mesh's exact surface, and for a lens's face that of the other face: what the override constants
        SURFACE and FAR_SURFACE are for the pipeline that draws it.
    parameters : (V, 2) float32
        By vertex of the geometry: the parameters that `flat_hit` interpolates.
    """

    records: np.ndarray
    numbers: np.ndarray
    kinds: np.ndarray
    parameters: np.ndarray


def exact_sides(scene: Scene, geometry: Geometry, bodies: Sequence[Body]) -> ExactSides:
    """Pack the exact surfaces of a scene's bodies, for all eyes."""
    records = np.zeros(len(scene.meshes), EXACT_SIDE)
    kinds = np.zeros((len(scene.meshes), 2), np.uint32)
    parameters = np.zeros((len(geometry.positions), 2), np.float32)
    numbers = [np.zeros(1, np.float32)]

    def placed(mesh: Mesh, frame: DeviceFrame) -> tuple[int, int]:
        """The kind of a mesh's exact surface, and where its numbers begin."""
        kind, own = device_numbers(None if mesh.parameters is None else mesh.surface, frame)
        numbers.append(own)
        return kind, sum(map(len, numbers[:-1]))

    for body in bodies:
        for side in body.sides:
            for number in side.meshes:
                mesh, record = scene.meshes[number], records[number]
                far = [scene.meshes[other] for other in body.meshes if other != number and side.refracts]
                frame = DeviceFrame.around(np.concatenate([each.positions for each in (mesh, *far)]))
                record["origin"], record["unit"] = frame.origin, frame.unit
                kinds[number, 0], record["surface"] = placed(mesh, frame)
                if mesh.parameters is not None:
                    vertices = slice(*geometry.first_vertex[number : number + 2])
                    parameters[vertices] = device_parameters(mesh.surface, mesh.parameters)
                if isinstance(mesh.material, Mirror):
                    record["reflectance"] = mesh.material.reflectance
                for other in far:
                    kinds[number, 1], record["far_surface"] = placed(other, frame)
                    _pack_lens(record, side, other, frame)
    return ExactSides(records, np.concatenate(numbers), kinds, parameters)


def _pack_lens(record: np.ndarray, side: Side, far: Mesh, frame: DeviceFrame) -> None:
    lens = side.optics
    assert isinstance(lens, Refractor) and far.parameters is not None
    record["middle"], record["axis"][:3] = frame.points(lens.middle), lens.axis
    record["radius"] = lens.radius / frame.unit
    edges = far.exact_positions()[border_edges(far)].mean(axis=0) - lens.middle
    record["sure_radius"] = np.linalg.norm(edges - np.outer(edges @ lens.axis, lens.axis), axis=1).min() / frame.unit
    record["indices"][:3] = line_indices(lens.index, lens.abbe)
    places = np.column_stack([frame.points(far.exact_positions()), np.ones(len(far.positions))])
    fitted = np.linalg.lstsq(places, device_parameters(far.surface, far.parameters).astype(float), rcond=None)[0]
    record["far_u"], record["far_v"] = fitted.T
