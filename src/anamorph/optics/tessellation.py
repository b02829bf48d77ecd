"""A scene whose mirrors and lenses have the outlines of their exact surfaces.

Between its vertices a mesh has straight edges. Where the exact surface is known, so is how far they leave it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from anamorph.optics.borders import RoundBorder, border_middles, lens_borders, mirror_borders, split_edge, split_within
from anamorph.scene.camera import Camera
from anamorph.scene.lens_pairs import lens_pairs
from anamorph.scene.model import Mesh, Scene
from anamorph.scene.subdivision import cut_ends
from anamorph.surfaces.plane import Plane

MOST_CUTS = 6
MOST_TRIANGLES = 200_000

OUTLINE = 0.33
"""How far the edges of a mesh may leave its exact surface, in pixels: its outline then lies within half a pixel."""

BORDER = 0.05
"""How far they may leave its border, in pixels. At a third of one, what a pixel shows beside the border may be hidden
from all within half a pixel."""

ENLARGED = 20.0
"""How much less they may leave the border of a lens, which shows the far one enlarged and its edge obliquely."""


def outlined_scene(scene: Scene, camera: Camera, size: tuple[int, int]) -> Scene:
    """A scene whose mirrors and lenses have the outlines of their exact surfaces, to half a pixel.

    Where a mesh turns away from the camera somewhere, none of its edges leaves the surface by more than that, at its
    own distance from the eye, between its vertices. Where it ends, its border is on the surface, too: round or straight
    as borders.py says.

    Only meshes with an exact surface are cut, and the edges of lenses, which follow their faces. Each triangle is
    judged for itself, and meshes that share an edge cut it alike; one that is shared with another mesh without an exact
    surface stays whole. The border of a lens is cut all around or not at all, since the lens's axis is found by the
    means of its borders. A triangle is cut at most six times. Of the meshes with an exact surface together there are
    never more than 200,000 triangles: those that err the most come first.

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
    meshes = list(scene.meshes)
    chosen = [
        number
        for number, mesh in enumerate(meshes)
        if mesh.specular and mesh.surface is not None and mesh.parameters is not None
    ]
    lenses = lens_pairs(meshes) if chosen else ()
    bands = [lens.edge for lens in lenses if lens.edge is not None]
    borders = {number: mirror_borders(meshes[number]) for number in chosen}
    for lens in lenses:
        edge = None if lens.edge is None else meshes[lens.edge]
        borders[lens.front] = borders[lens.back] = lens_borders(meshes[lens.front], meshes[lens.back], edge)
    for _ in range(MOST_CUTS if chosen else 0):
        own = {number: meshes[number] for number in chosen}
        outline = np.concatenate([outline_errors(mesh, camera, size) for mesh in own.values()])
        found = [border_errors(mesh, borders[number], camera, size) for number, mesh in own.items()]
        beyond, arcs = (np.concatenate(each) for each in zip(*found, strict=True))
        beyond *= OUTLINE / BORDER
        if max(outline.max(), ENLARGED * beyond.max()) <= OUTLINE:
            break
        edges, kept = _edges(list(own.values()), _beside(meshes, [*chosen, *bands]))
        shared = np.isin(edges, kept)
        place, uses = np.unique(edges.ravel(), return_inverse=True, return_counts=True)[1:]
        last = (uses[place] == 1).reshape(edges.shape) & ~shared
        arcs &= last
        errors = np.where(arcs, beyond, np.maximum(outline[:, None], np.where(last, beyond, 0.0)))
        errors[shared] = 0.0
        owner = np.repeat(chosen, [len(mesh.faces) for mesh in own.values()])
        rings = [np.isin(owner, (lens.front, lens.back))[:, None] & (last | shared) for lens in lenses]
        for ring in rings:
            errors[ring] = ENLARGED * errors[ring].max(initial=0.0) if arcs[ring].all() else 0.0
        # Cutting the three edges of a triangle makes three more of it, and one more of each neighbour.
        most = max(MOST_TRIANGLES - len(errors), 0) // 6
        coarse = np.flatnonzero(errors.max(axis=1) > OUTLINE)
        coarse = coarse[np.argsort(-errors[coarse].max(axis=1), kind="stable")][:most]
        wanted = edges[coarse][errors[coarse] > OUTLINE]
        for ring in rings:
            wanted = wanted if np.isin(edges[ring], wanted).all() else np.setdiff1d(wanted, edges[ring])
        if not len(wanted):
            break
        cut = np.isin(edges, wanted)
        for number, mesh in own.items():
            here = owner == number
            meshes[number] = split_within(mesh, cut[here], arcs[here], borders[number]) if cut[here].any() else mesh
        for lens, ring in zip(lenses, rings, strict=True):
            if lens.edge is not None and cut[ring].any():
                before, after = ([each[face] for face in (lens.front, lens.back)] for each in (own, meshes))
                meshes[lens.edge] = split_edge(meshes[lens.edge], borders[lens.front][0], before, after)
    return replace(scene, meshes=tuple(meshes))


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
    return _pixels(leaves, corners, camera, size)


def border_errors(
    mesh: Mesh, rounds: Sequence[RoundBorder], camera: Camera, size: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray]:
    """How far the edges of each triangle leave the border of its exact surface.

    Returns
    -------
    errors : (F, 3) float64
        In pixels at its distance from the eye; 0 for an edge that two triangles have.
    arcs : (F, 3) bool
        Where the border is round.
    """
    ends, number = cut_ends(mesh.faces, np.ones(mesh.faces.shape, bool))
    border = np.bincount(number, minlength=len(ends)) == 1
    errors, arcs = np.zeros(len(ends)), np.zeros(len(ends), bool)
    assert mesh.surface is not None
    parameters, arcs[border] = border_middles(mesh, ends[border], rounds)
    corners = mesh.exact_positions()[ends[border]]
    leaves = np.linalg.norm(mesh.surface.position(parameters) - corners.mean(axis=1), axis=1)
    errors[border] = _pixels(leaves, corners, camera, size)
    return errors[number].reshape(mesh.faces.shape), arcs[number].reshape(mesh.faces.shape)


def _pixels(leaves: np.ndarray, corners: np.ndarray, camera: Camera, size: tuple[int, int]) -> np.ndarray:
    """Lengths (N,) in metres as pixels, at the nearest of corners (N, K, 3) to the eye."""
    distance = np.linalg.norm(corners - np.asarray(camera.position, float), axis=2).min(axis=1)
    focal = size[1] / (2.0 * np.tan(np.radians(camera.field_of_view) / 2.0))
    return leaves / np.maximum(distance, np.maximum(leaves, np.finfo(float).tiny)) * focal


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
