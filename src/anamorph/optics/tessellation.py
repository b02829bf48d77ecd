"""Whether a specular mesh is fine enough for an image, inside and at its outline, and a scene whose meshes are.

Between its vertices a mesh has interpolated normals. Where the exact surface is known, so is what they are wrong by,
and how many pixels that is once a ray has been bent there: the error of the ray over what the ray turns in a pixel.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.optics.laws import reflect, refract
from anamorph.scene.camera import Camera
from anamorph.scene.model import Glass, Material, Mesh, Scene
from anamorph.scene.subdivision import split
from anamorph.surfaces.plane import Plane

MOST_CUTS = 6
MOST_TRIANGLES = 200_000

SMALLEST = 1.0
"""Triangles smaller than this are not cut, in pixels."""

OUTLINE = 0.33
"""How far the edges of a mesh may leave its exact surface, in pixels: its outline then lies within half a pixel."""

SAMPLES = ([0, 1], [1, 2], [2, 0], [0, 1, 2])
"""Where normals are compared: in the middle of each edge of a triangle, and in its own, by the corners around."""


def normal_errors(mesh: Mesh, camera: Camera, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """How far interpolated normals lead rays astray on each triangle, in pixels of the image.

    A ray that turns more slowly than the eye's own rays do counts as if it turned like them: where a mirror or a lens
    magnifies without bounds, so would the error.

    Parameters
    ----------
    mesh : Mesh
        A mirror or glass with its surface and parameters. Rays are followed through glass as if they left it by a flat
        face, so that a face's own share of what a lens does counts.
    camera : Camera
    size : (width, height)

    Returns
    -------
    errors : (F,) float64
        Pixels, the greatest of four samples; 0 for a triangle that is turned away or not in the image. One hidden
        behind others counts.
    areas : (F,) float64
        How large it is in the image, square pixels, and 0 likewise.
    """
    if mesh.surface is None or mesh.parameters is None:
        raise AnamorphError(f"part '{mesh.name}': has no exact surface to be compared with; leave it as it is")
    errors = np.zeros(len(mesh.faces))
    places, areas = _shown(mesh, camera, size)
    shown = areas > 0.0
    if not shown.any():
        return errors, areas
    eye, faces = np.asarray(camera.position, float), mesh.faces[shown]
    corners, normals = np.asarray(mesh.positions, float)[faces], np.asarray(mesh.normals, float)[faces]
    directions, distances = _bent(mesh.material, corners - eye, normals), np.linalg.norm(corners - eye, axis=2)
    left, turn, _ = np.linalg.svd(_turning(directions, places[shown]), full_matrices=False)
    turn = np.maximum(turn, 2.0 * np.tan(np.radians(camera.field_of_view) / 2.0) / size[1])
    for around in SAMPLES:
        parameters = mesh.surface.between(mesh.parameters[faces][:, around], mesh.positions[faces][:, around])
        points = mesh.surface.position(parameters)
        exact = mesh.surface.normals_toward(parameters, normals[:, around].sum(axis=1))
        interpolated = np.einsum("fk,fkj->fj", _weights(corners, points), normals)
        shown_ray = _bent(mesh.material, points - eye, interpolated)
        if isinstance(mesh.material, Glass):
            # Behind glass whole rays are interpolated, as long as the eye's distance: see `RayMesh`.
            shown_ray = np.einsum("fk,fkj->fj", _crossed(corners, eye, points) * distances, directions)
            shown_ray *= mesh.material.index / np.linalg.norm(shown_ray, axis=1, keepdims=True)
        astray = shown_ray - _bent(mesh.material, points - eye, exact)
        moved = np.linalg.norm(np.einsum("fji,fj->fi", left, astray) / turn, axis=1)
        errors[shown] = np.maximum(errors[shown], moved)
    return errors, areas


def refined_scene(scene: Scene, size: tuple[int, int], tolerance: float) -> Scene:
    """A scene whose mirrors and lenses have more triangles, where their normals err by more than a tolerance.

    Only meshes with an exact surface get them, for the scene's camera. Each triangle is judged for itself, and meshes
    that share an edge cut it alike; one that is shared with a mesh without an exact surface stays whole. A triangle is
    cut at most six times, and none that is smaller than a pixel. Of all these meshes together there are never more
    than 200,000 triangles: those that err the most come first. What the eye sees only in another mirror stays as it is,
    and so does what reaches behind the eye.

    Parameters
    ----------
    scene : Scene
    size : (width, height)
    tolerance : float
        Pixels.

    Returns
    -------
    Scene
        With the same objects in the same order.
    """
    if not 0.0 < tolerance < np.inf:
        raise AnamorphError(f"tolerance is {tolerance:g}; give a positive number of pixels")

    def errors_of(mesh: Mesh) -> np.ndarray:
        errors, areas = normal_errors(mesh, scene.camera, size)
        return np.where(areas > SMALLEST, errors, 0.0)

    return _refined(scene, errors_of, tolerance)


def outlined_scene(scene: Scene, camera: Camera, size: tuple[int, int]) -> Scene:
    """A scene whose mirrors and lenses have the outlines of their exact surfaces, to half a pixel.

    That is for meshes that turn away from the camera somewhere: between their vertices, none of their edges
    leaves the surface by more than that at its own distance from the eye. Where a surface ends, its border is the
    mesh's: straight from vertex to vertex, and where that is cut, along the surface. Edges are cut as by
    `refined_scene`.

    Parameters
    ----------
    scene : Scene
    camera : Camera
    size : (width, height)

    Returns
    -------
    Scene
        With the same objects in the same order, and in each mesh the vertices that were there before, first.
    """
    return _refined(scene, lambda mesh: outline_errors(mesh, camera, size), OUTLINE)


def outline_errors(mesh: Mesh, camera: Camera, size: tuple[int, int]) -> np.ndarray:
    """How far the edges of each triangle leave its exact surface, (F,) float64, pixels at its distance from the eye.

    It is told from the normals at their ends, as of an arc; 0 for a mesh that does not turn away from the eye anywhere.
    """
    eye, positions = np.asarray(camera.position, float), np.asarray(mesh.positions, float)
    facing = np.einsum("vi,vi->v", eye - positions, mesh.normals)
    if isinstance(mesh.surface, Plane) or facing.min() >= 0.0 or facing.max() <= 0.0:
        return np.zeros(len(mesh.faces))
    corners, normals = positions[mesh.faces], np.asarray(mesh.normals, float)[mesh.faces]
    edges, turns = (np.roll(each, -1, axis=1) - each for each in (corners, normals))
    leaves = np.abs(np.einsum("fei,fei->fe", edges, turns)).max(axis=1) / 8.0
    distance = np.linalg.norm(corners - eye, axis=2).min(axis=1)
    return leaves / np.maximum(distance, leaves) * size[1] / (2.0 * np.tan(np.radians(camera.field_of_view) / 2.0))


def _refined(scene: Scene, errors_of: Callable[[Mesh], np.ndarray], tolerance: float) -> Scene:
    """A scene whose triangles are cut until their errors, (F,) for a mesh, are no more than the tolerance."""
    chosen = [
        number
        for number, mesh in enumerate(scene.meshes)
        if mesh.specular and mesh.surface is not None and mesh.parameters is not None
    ]
    meshes = list(scene.meshes)
    for _ in range(MOST_CUTS if chosen else 0):
        errors = np.concatenate([errors_of(meshes[number]) for number in chosen])
        # Cutting the three edges of a triangle makes three more of it, and one more of each neighbour.
        most = max(MOST_TRIANGLES - len(errors), 0) // 6
        coarse = np.flatnonzero(errors > tolerance)
        coarse = coarse[np.argsort(-errors[coarse], kind="stable")][:most]
        if not len(coarse):
            break
        refined = [meshes[number] for number in chosen]
        edges, kept = _edges(refined, _beside(meshes, chosen))
        wanted = np.setdiff1d(edges[coarse], kept)
        if not len(wanted):
            break
        cuts = np.split(np.isin(edges, wanted), np.cumsum([len(mesh.faces) for mesh in refined[:-1]]))
        for number, cut in zip(chosen, cuts, strict=True):
            meshes[number] = split(meshes[number], cut) if cut.any() else meshes[number]
    return replace(scene, meshes=tuple(meshes))


def _beside(meshes: list[Mesh], chosen: list[int]) -> np.ndarray:
    """The triangles, (B, 3, 3) float32, of all other meshes that may share an edge with those that are chosen.

    That is those with two corners in the box around these: in a large scene, few.
    """
    own = np.concatenate([np.asarray(meshes[number].positions, np.float32) for number in chosen])
    low, high = own.min(axis=0, initial=np.inf), own.max(axis=0, initial=-np.inf)
    found = [np.zeros((0, 3, 3), np.float32)]
    for number, mesh in enumerate(meshes):
        positions = np.asarray(mesh.positions, np.float32)
        inside = ((positions >= low) & (positions <= high)).all(axis=1)
        if number not in chosen and inside.any():
            found.append(positions[mesh.faces[np.count_nonzero(inside[mesh.faces], axis=1) >= 2]])
    return np.concatenate(found)


def _edges(meshes: list[Mesh], beside: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A number for each edge of each triangle of meshes, (F, 3) int64, and of triangles `beside` them, (B, 3).

    Edges between the same two places have the same.
    """
    positions = np.concatenate([*(np.asarray(mesh.positions, np.float32) for mesh in meshes), beside.reshape(-1, 3)])
    first = np.cumsum([0, *(len(mesh.positions) for mesh in meshes)])
    faces = [mesh.faces + start for mesh, start in zip(meshes, first, strict=False)]
    faces.append(first[-1] + np.arange(3 * len(beside)).reshape(-1, 3))
    place = np.unique(positions, axis=0, return_inverse=True)[1].reshape(-1).astype(np.int64)
    start = place[np.concatenate(faces)]
    stop = np.roll(start, -1, axis=1)
    edges = np.minimum(start, stop) << 32 | np.maximum(start, stop)
    return edges[: len(edges) - len(beside)], edges[len(edges) - len(beside) :]


def _shown(mesh: Mesh, camera: Camera, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Where corners are in the image, (F, 3, 2), and the area of each triangle there; 0 where it is not shown."""
    positions = np.asarray(mesh.positions, float)
    image = camera.image(positions, size)
    ahead = image[:, 2] > 0.0
    corners = (image[:, :2] / np.where(ahead, image[:, 2], 1.0)[:, None])[mesh.faces]
    # The image's y points down: what turns counter-clockwise in the world has a negative area.
    areas = -np.linalg.det(corners[:, 1:] - corners[:, :1]) / 2.0
    if isinstance(mesh.material, Glass):
        # Both sides are looked at, but where some corners show the one and some the other, rays do not change smoothly.
        toward = np.sum((np.asarray(camera.position) - positions) * mesh.normals, axis=1) > 0.0
        areas = np.abs(areas) * (toward[mesh.faces] == toward[mesh.faces][:, :1]).all(axis=1)
    inside = ((corners.max(axis=1) > 0.0) & (corners.min(axis=1) < np.asarray(size))).all(axis=1)
    shown = ahead[mesh.faces].all(axis=1) & inside
    return corners, np.where(shown & (areas > 1e-9), areas, 0.0)


def _turning(directions: np.ndarray, places: np.ndarray) -> np.ndarray:
    """How directions (F, 3, 3) at places (F, 3, 2) of the image change from pixel to pixel: (F, 3, 2)."""
    change = np.linalg.solve(places[:, 1:] - places[:, :1], directions[:, 1:] - directions[:, :1])
    return np.swapaxes(change, 1, 2)


def _bent(material: Material, incident: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Directions, (..., 3), after a mirror, or after glass left by a flat face, to first order."""
    incident = incident / np.linalg.norm(incident, axis=-1, keepdims=True)
    normal = normal / np.linalg.norm(normal, axis=-1, keepdims=True)
    if not isinstance(material, Glass):
        return reflect(incident, normal)
    against = np.where(np.sum(incident * normal, axis=-1, keepdims=True) > 0.0, -normal, normal)
    return material.index * refract(incident, against, 1.0 / material.index)[0]


def _crossed(corners: np.ndarray, eye: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Barycentric coordinates, (F, 3), of where the lines of sight to points (F, 3) cross the planes of triangles."""
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    far, near = (np.einsum("fi,fi->f", across, each) for each in (corners[:, 0] - eye, points - eye))
    return _weights(corners, eye + (far / np.where(near == 0.0, 1.0, near))[:, None] * (points - eye))


def _weights(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Barycentric coordinates, (F, 3), of the feet of points (F, 3) on the planes of triangles (F, 3, 3)."""
    edges = corners[:, 1:] - corners[:, :1]
    foot = np.einsum("fij,fj->fi", np.linalg.pinv(np.swapaxes(edges, 1, 2)), points - corners[:, 0])
    return np.concatenate([1.0 - foot.sum(axis=1, keepdims=True), foot], axis=1)
