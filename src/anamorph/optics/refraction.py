"""An eye before a lens, as a ray mesh: the ray that leaves the lens, for every vertex of the face that the eye sees.

Source: Kakimoto et al. 2007, section 4.5. The eye's ray is refracted at the vertex, by the exact normal there, and
once more where it meets the other face's exact surface.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.optics.laws import fresnel, refract
from anamorph.raymesh import RayMesh, RayStatus
from anamorph.scene.camera import Eye
from anamorph.scene.lens_pairs import border_edges
from anamorph.scene.model import Glass, Mesh
from anamorph.surfaces.intersection import meet_all, pack


@dataclass(frozen=True, eq=False)
class Refractor:
    """What of a round lens does not depend on the eye.

    Parameters
    ----------
    positions, normals : (V, 3) float64
        Of the vertices of the near face, by which the eye's rays enter, on its exact surface; normals out of the glass.
    faces : (F, 3) int32
    far_kind : int
        The exact surface of the far face, with its numbers, as `exact.pack` gives them.
    far_numbers : (48,) float64
    far_sign : float
        1 where that surface's own normals point out of the glass, else -1.
    index : float
        Refractive index of the glass, for the d line.
    abbe : float or None
    middle, axis : (3,) float64
        The middle of the far face's border, and the unit direction of the lens's axis from the near face to the far.
    radius : float
        From the axis to the edge, metres.
    """

    positions: np.ndarray
    normals: np.ndarray
    faces: np.ndarray
    far_kind: int
    far_numbers: np.ndarray
    far_sign: float
    index: float
    abbe: float | None
    middle: np.ndarray
    axis: np.ndarray
    radius: float


def refractor(near: Mesh, far: Mesh) -> Refractor:
    """Prepare a lens for `refracted_rays`, once for all frames.

    Parameters
    ----------
    near, far : Mesh
        The two faces of a round lens from `lenses/lens.py`: the one that the eye sees, and the other.
    """
    glass = near.material
    if not isinstance(glass, Glass) or not isinstance(far.material, Glass):
        raise AnamorphError(f"lens {near.name!r}, {far.name!r}: is not of glass; give both faces the material glass")
    if glass.index != far.material.index:
        raise AnamorphError(f"lens {near.name!r}, {far.name!r}: its faces have two indices; give both the same")
    positions, normals, _ = _exact(near)
    far_positions, _, sign = _exact(far)
    border = far_positions[_border(far)]
    # The borders are circles about the axis, whatever the faces are.
    middle = border.mean(axis=0)
    axis = middle - positions[_border(near)].mean(axis=0)
    axis /= np.linalg.norm(axis)
    radii = border - middle
    radius = np.linalg.norm(radii - np.outer(radii @ axis, axis), axis=1).max()
    kind, numbers = pack(far.surface)
    return Refractor(
        positions, normals, near.faces, kind, numbers, sign, glass.index, glass.abbe, middle, axis, float(radius)
    )


def _exact(face: Mesh) -> tuple[np.ndarray, np.ndarray, float]:
    """Positions and outside normals, (V, 3) each, and 1 or -1 by which the surface's own normals are outside."""
    if face.surface is None or face.parameters is None:
        raise AnamorphError(f"lens face {face.name!r}: has no exact surface; make the lens with make_lens")
    normals = face.surface.normal(face.parameters)
    sign = 1.0 if np.sum(normals * face.normals) > 0.0 else -1.0
    return face.surface.position(face.parameters), sign * normals, sign


def _border(face: Mesh) -> np.ndarray:
    """The vertices on the border."""
    vertices = np.unique(border_edges(face))
    if not len(vertices):
        raise AnamorphError(f"lens face {face.name!r}: has no border; give the two faces of a lens as two meshes")
    return vertices


def refracted_rays(lens: Refractor, eye: Eye, index: float | None = None) -> RayMesh:
    """The ray mesh of `lens` as `eye` sees it, for one frame.

    A ray starts where it leaves the far face. What is given where it does not leave there goes on smoothly from the
    neighbours where it can: BACK_FACING and LEFT_BY_EDGE vertices have the ray through both surfaces as if these
    went on beyond the edge, or if they do not, the one in the glass from where it entered; TOTAL_REFLECTION vertices
    have the reflected ray in the glass.

    Parameters
    ----------
    lens : Refractor
    eye : Eye
    index : float, optional
        Refractive index, for light of another colour than the d line.

    Returns
    -------
    RayMesh
        Directions have the length of the eye's distance, with which interpolating them is exact behind a flat slab.
    """
    index = lens.index if index is None else index
    offset = eye.offsets(lens.positions)
    distance = np.linalg.norm(offset, axis=1, keepdims=True)
    away = np.einsum("ij,ij->i", offset, lens.normals) >= 0.0
    inside, exits, normals, met = to_far_face(lens, lens.positions, lens.normals, offset / distance, index)
    leaving, total = refract(inside, normals, index)
    origins = np.where(met[:, None], exits, lens.positions)
    directions = np.where(met[:, None], leaving, inside)

    radial = exits - lens.middle
    radial -= np.outer(radial @ lens.axis, lens.axis)
    by_edge = ~met | (np.einsum("ij,ij->i", radial, radial) > (lens.radius * (1.0 + 1e-9)) ** 2)
    status = np.full(len(offset), np.uint8(RayStatus.OK))
    status[total] = RayStatus.TOTAL_REFLECTION
    status[by_edge] = RayStatus.LEFT_BY_EDGE
    status[away] = RayStatus.BACK_FACING
    entering = 1.0 - fresnel(1.0 / index, _cosines(offset / distance, lens.normals))
    transmittance = np.where(total, entering, entering * (1.0 - fresnel(index, _cosines(inside, normals))))
    return RayMesh(eye.image(lens.positions), origins, distance * directions, lens.faces, status, transmittance)


def to_far_face(
    lens: Refractor, positions: np.ndarray, normals: np.ndarray, directions: np.ndarray, index: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Let rays enter a lens by its near face, and find where they meet the far face's surface, beyond its edge too.

    Parameters
    ----------
    lens : Refractor
    positions, normals : (N, 3) float64
        Where they enter, and the normals of the near face there, out of the glass.
    directions : (N, 3) float64
        Unit directions before they enter.
    index : float
        Refractive index.

    Returns
    -------
    inside : (N, 3) float64
        Unit directions in the glass.
    exits, normals : (N, 3) float64
        Where they meet the far face's surface, and its unit normals there, against the rays in the glass.
    met : (N,) bool
        False where they do not; `exits` and `normals` say nothing there.
    """
    inside, _ = refract(directions, normals, 1.0 / index)
    exits, far_normals, met = np.empty_like(inside), np.empty_like(inside), np.empty(len(inside), bool)
    start = ((lens.middle - positions) @ lens.axis) / np.maximum(inside @ lens.axis, 1e-3)
    facing = np.broadcast_to(-lens.axis, inside.shape)
    unused = np.zeros((len(inside), 2))
    meet_all(lens.far_kind, lens.far_numbers, positions, inside, start, unused, facing, exits, far_normals, met)
    return inside, exits, -lens.far_sign * far_normals, met


def _cosines(directions: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Cosines between unit directions and unit normals of either side, (N,)."""
    return np.minimum(np.abs(np.einsum("ij,ij->i", directions, normals)), 1.0)
