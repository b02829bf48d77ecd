"""Is a scene fit to be drawn? Each check names the part and the remedy, so that no image is black or NaN."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import get_args

import numpy as np
from trimesh.triangles import closest_point

from anamorph.base.errors import AnamorphError
from anamorph.scene.camera import Camera
from anamorph.scene.lens_pairs import least_edge, lens_pairs
from anamorph.scene.model import (
    AmbientLight,
    Diffuse,
    DirectionalLight,
    Glass,
    Light,
    LinearImage,
    Mesh,
    Mirror,
    PointLight,
    Scene,
    Sky,
    Texture,
    Wrap,
)
from anamorph.scene.triangles import doubled_areas, has_area, turned_over

TOUCHING = 1e-5
"""An eye nearer to a mirror than this share of the mirror's size is on it."""

MOST_MESHES = 0xFFFF
"""The seen buffers hold an object's number in 16 bits."""


FARTHEST = 1e9
"""Metres: what is farther out is a mistake, and its square soon more than float32 holds."""

SMALLEST_SHARE = 1e-5
"""A mesh smaller than this share of its coordinates has fewer than 200 float32 steps across."""


KNIFE = 1e-5
"""The least thickness of a lens's edge, as a share of the lens's size."""

TURNED_OVER = 1e-2
"""The share of a mirror's or lens's area that may be wound against its normals: slivers, between normals that bend."""


def check_scene(scene: Scene) -> Scene:
    """The scene without its degenerate triangles; raises AnamorphError for what its camera cannot show."""
    checked = check_contents(scene)
    check_camera(scene.camera, f"scene '{scene.name}': eye")
    _check_eye(checked)
    return checked


def check_contents(scene: Scene) -> Scene:
    """The same for a scene that is not seen by its own camera."""
    if not scene.meshes:
        raise AnamorphError(f"scene '{scene.name}': has no meshes; add a part")
    if len(scene.meshes) > MOST_MESHES:
        raise AnamorphError(
            f"scene '{scene.name}': has {len(scene.meshes)} meshes, and {MOST_MESHES} can be told apart; join some"
        )
    meshes = tuple(_checked(mesh) for mesh in scene.meshes)
    _check_lenses(meshes)
    for number, light in enumerate(scene.lights, start=1):
        _check_light(light, f"scene '{scene.name}': light {number}")
    _check_sky(scene.sky, f"scene '{scene.name}': sky")
    return replace(scene, meshes=meshes)


def check_triangles(where: str, positions: np.ndarray, faces: np.ndarray) -> None:
    """Finite vertices, and triangles between them."""
    if not len(positions) or not len(faces):
        raise AnamorphError(f"{where}: is empty; remove the part or give it triangles")
    broken = np.flatnonzero(~np.isfinite(positions).all(axis=1))
    if len(broken):
        raise AnamorphError(
            f"{where}: vertex {broken[0]} has a NaN or infinite coordinate ({len(broken)} such); mend the model"
        )
    if np.min(faces) < 0 or np.max(faces) >= len(positions):
        raise AnamorphError(
            f"{where}: a face names vertex {np.max(faces) if np.max(faces) >= len(positions) else np.min(faces)}, "
            f"but there are {len(positions)}; mend the model"
        )


def check_camera(camera: Camera, where: str) -> None:
    """An eye that looks somewhere, with its head not along its view."""
    for name in ("position", "target", "up"):
        value = getattr(camera, name)
        if not _are_numbers(value, (3,)):
            raise AnamorphError(f"{where}: {name} is {value}; give three finite numbers")
        if np.abs(value).max() > FARTHEST:
            raise AnamorphError(f"{where}: {name} is {value}; give no number beyond {FARTHEST:.0e}")
    forward = np.subtract(camera.target, camera.position)
    if not forward.any():
        raise AnamorphError(f"{where}: position and target are the same point; move one of them")
    across = np.linalg.norm(np.cross(forward, camera.up))
    if across <= 1e-9 * np.linalg.norm(forward) * np.linalg.norm(camera.up):
        raise AnamorphError(f"{where}: up is {camera.up}, along the view; give another direction")
    if not _are_numbers(camera.field_of_view) or not 0.0 < camera.field_of_view < 180.0:
        raise AnamorphError(f"{where}: field_of_view is {camera.field_of_view}; give degrees between 0 and 180")


def _are_numbers(values: object, shape: tuple[int, ...] = ()) -> bool:
    """Whether these are finite numbers, not text, in an array of the shape."""
    try:
        array = np.asarray(values)
    except ValueError:
        return False
    return array.shape == shape and array.dtype.kind in "iuf" and bool(np.isfinite(array).all())


def check_place(where: str, positions: np.ndarray) -> None:
    """Near enough to the origin for what its coordinates have been rounded to."""
    farthest, extent = float(np.abs(positions).max()), float(np.ptp(np.asarray(positions, float), axis=0).max())
    if farthest > FARTHEST:
        raise AnamorphError(f"{where}: has a coordinate of {farthest:.3g}; scale it to metres, within {FARTHEST:.0e}")
    if extent < SMALLEST_SHARE * farthest and (positions == positions.astype(np.float32)).all():
        raise AnamorphError(
            f"{where}: is {extent:.3g} m large and {farthest:.3g} m from the origin, too far for float32; "
            "translate everything to the origin, or remove the part"
        )


def _checked(mesh: Mesh) -> Mesh:
    where = f"part '{mesh.name}'"
    count = len(mesh.positions)
    _check_shape(where, "positions", mesh.positions, (count, 3))
    _check_shape(where, "faces", mesh.faces, (len(mesh.faces), 3))
    if not np.issubdtype(np.asarray(mesh.faces).dtype, np.integer):
        raise AnamorphError(f"{where}: faces are {np.asarray(mesh.faces).dtype}; give integers")
    check_triangles(where, mesh.positions, mesh.faces)
    check_place(where, mesh.positions)
    for name, width in (("normals", 3), ("texcoords", 2), ("colors", 3), ("parameters", 2)):
        values = getattr(mesh, name)
        if values is not None:
            _check_shape(where, name, values, (count, width))
            if not np.isfinite(values).all():
                raise AnamorphError(f"{where}: {name} have NaN or infinite numbers; mend the model")
    if mesh.colors is not None and (np.min(mesh.colors) < 0.0 or np.max(mesh.colors) > 1.0):
        raise AnamorphError(
            f"{where}: colors go from {np.min(mesh.colors):.3g} to {np.max(mesh.colors):.3g}; give linear numbers "
            "from 0 to 1, and what is brighter to the material's color"
        )
    kept = has_area(mesh.positions, mesh.faces)
    if not kept.any():
        raise AnamorphError(f"{where}: all its triangles are degenerate (points or lines); remove the part")
    used = np.unique(mesh.faces[kept])
    lengths = np.linalg.norm(np.asarray(mesh.normals, float)[used], axis=1)
    if lengths.min() == 0.0:
        raise AnamorphError(f"{where}: vertex {used[lengths.argmin()]} has a zero normal; compute normals for it")
    if np.abs(lengths - 1.0).max() > 1e-2:
        raise AnamorphError(f"{where}: normals are not of length 1; divide each by its length")
    _check_material(mesh, where)
    checked = mesh if kept.all() else replace(mesh, faces=mesh.faces[kept])
    if mesh.specular:
        _check_winding(checked, where)
    return checked


def _check_winding(mesh: Mesh, where: str) -> None:
    """One outside: methods that go by the winding and those that go by normals must see the same side."""
    turned = turned_over(mesh.positions, mesh.faces, mesh.normals)
    areas = np.linalg.norm(doubled_areas(mesh.positions, mesh.faces), axis=1)
    if areas[turned].sum() > TURNED_OVER * areas.sum():
        raise AnamorphError(
            f"{where}: its normals point against its winding at {turned.sum()} of {len(turned)} triangles; negate the "
            "normals there, or turn the triangles over"
        )


def _check_lenses(meshes: Sequence[Mesh]) -> None:
    """Faces with glass between them all the way around: else light that goes in has no defined way out."""
    for lens in lens_pairs(meshes):
        front, back = meshes[lens.front], meshes[lens.back]
        thickness = least_edge(front, back)
        least = KNIFE * np.linalg.norm(np.ptp(np.asarray(front.positions, float), axis=0))
        if thickness <= least:
            wrong = f"cross by {-1e3 * thickness:.3g} mm" if thickness < -least else "meet in a sharp edge, 0 mm thick"
            raise AnamorphError(f"lens '{lens.name}': its faces {wrong} at the border; make it thicker or smaller")


def _check_shape(where: str, name: str, values: np.ndarray, shape: tuple[int, int]) -> None:
    if np.shape(values) != shape:
        raise AnamorphError(f"{where}: {name} have shape {np.shape(values)}; give {shape}")


def _check_color(where: str, name: str, color: object) -> None:
    if not _are_numbers(color, (3,)) or np.asarray(color, float).min() < 0:
        raise AnamorphError(f"{where}: {name} is {color}; give three finite numbers, none below 0")


def _check_texture(where: str, texture: Texture | None) -> None:
    if texture is not None:
        shape = np.shape(texture.pixels)
        if len(shape) != 3 or shape[2] != 4 or 0 in shape or texture.pixels.dtype != np.uint8:
            raise AnamorphError(f"{where}: its image is {shape} {texture.pixels.dtype}; give (H, W, 4) uint8")
        if len(texture.wraps) != 2 or not set(texture.wraps) <= set(get_args(Wrap)):
            raise AnamorphError(f"{where}: wraps of its image are {texture.wraps}; give two of {get_args(Wrap)}")


def _check_material(mesh: Mesh, where: str) -> None:
    match mesh.material:
        case Diffuse(color=color, texture=texture):
            _check_color(where, "color", color)
            _check_texture(where, texture)
            if texture is not None and mesh.texcoords is None:
                raise AnamorphError(f"{where}: has an image but no texture coordinates; give it texcoords")
        case Mirror(tint=tint, reflectance=reflectance, back=back):
            _check_color(where, "tint", tint)
            _check_color(where, "back", back)
            if not _are_numbers(reflectance) or not 0.0 <= reflectance <= 1.0:
                raise AnamorphError(f"{where}: reflectance is {reflectance}; give a number from 0 to 1")
        case Glass(index=index, tint=tint, abbe=abbe):
            _check_color(where, "tint", tint)
            if not _are_numbers(index) or index <= 0:
                raise AnamorphError(f"{where}: index is {index}; give a positive refractive index, 1.5 for glass")
            if abbe is not None and not (np.isfinite(abbe) and abbe > 0):
                raise AnamorphError(f"{where}: abbe is {abbe}; give a positive Abbe number, 58 for plastic")


def _check_light(light: Light, where: str) -> None:
    match light:
        case DirectionalLight(toward=toward, color=color):
            if not _are_numbers(toward, (3,)) or not np.any(toward):
                raise AnamorphError(f"{where}: toward is {toward}; give a direction, three finite numbers not all 0")
            _check_color(where, "color", color)
        case PointLight(position=position, color=color):
            if not _are_numbers(position, (3,)) or np.abs(position).max() > FARTHEST:
                raise AnamorphError(f"{where}: position is {position}; give three finite numbers")
            _check_color(where, "color", color)
        case AmbientLight(sky=sky, ground=ground):
            _check_color(where, "sky", sky)
            _check_color(where, "ground", ground)


def _check_sky(sky: Sky, where: str) -> None:
    for name in ("zenith", "horizon", "nadir"):
        _check_color(where, name, getattr(sky, name))
    if not isinstance(sky.image, LinearImage):
        _check_texture(where, sky.image)
        return
    shape = np.shape(sky.image.pixels)
    if len(shape) != 3 or shape[2] != 3 or 0 in shape or sky.image.pixels.dtype != np.float32:
        raise AnamorphError(f"{where}: its image is {shape} {sky.image.pixels.dtype}; give (H, W, 3) float32")
    if not np.isfinite(sky.image.pixels).all() or sky.image.pixels.min() < 0.0:
        raise AnamorphError(f"{where}: its image holds NaN, infinite or negative light; mend the image")


def _check_eye(scene: Scene) -> None:
    """Some mirror must show the eye its front: else every mirror pixel would be black."""
    eye = np.asarray(scene.camera.position, float)
    mirrors = [mesh for mesh in scene.meshes if isinstance(mesh.material, Mirror)]
    behind = []
    for mesh in mirrors:
        corners = np.asarray(mesh.positions, float)[mesh.faces]
        size = float(np.linalg.norm(np.ptp(corners.reshape(-1, 3), axis=0)))
        gap = np.linalg.norm(closest_point(corners, np.broadcast_to(eye, (len(corners), 3))) - eye, axis=1).min()
        if gap <= TOUCHING * size:
            raise AnamorphError(f"eye {scene.camera.position} is on the mirror '{mesh.name}'; move it away from it")
        area = doubled_areas(mesh.positions, mesh.faces)
        area /= np.linalg.norm(area, axis=1, keepdims=True)
        if np.sum(area * (eye - corners[:, 0]), axis=1).max() <= TOUCHING * size:
            behind.append(mesh.name)
    if mirrors and len(behind) == len(mirrors):
        raise AnamorphError(
            f"eye {scene.camera.position} is behind the mirror '{behind[0]}'; move it to the side its normals point to"
        )
