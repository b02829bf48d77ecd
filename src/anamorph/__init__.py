"""What an eye sees in a curved mirror, and how far each method is from the truth.

The public names are loaded when first used, so that the command line answers at once.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from anamorph.base.errors import AnamorphError as AnamorphError
    from anamorph.base.notes import AnamorphNote as AnamorphNote
    from anamorph.files.gltf.exporting import save_gltf as save_gltf
    from anamorph.files.models import load_model as load_model
    from anamorph.files.opening import open_scene as open_scene
    from anamorph.files.sky_image import read_sky_image as read_sky_image
    from anamorph.frame import Frame as Frame
    from anamorph.frame import Status as Status
    from anamorph.lenses.lens import Lens as Lens
    from anamorph.lenses.making import make_lens as make_lens
    from anamorph.lenses.making import worn_lens as worn_lens
    from anamorph.lenses.prescription import Prescription as Prescription
    from anamorph.measure.compare import compare as compare
    from anamorph.methods import METHODS as METHODS
    from anamorph.raymesh import RayMesh as RayMesh
    from anamorph.reflections.open_paths import visible as visible
    from anamorph.reflections.reflection_points import ReflectionPoints as ReflectionPoints
    from anamorph.reflections.reflection_points import ReflectionStatus as ReflectionStatus
    from anamorph.reflections.reflection_points import reflection_points as reflection_points
    from anamorph.reflections.refraction_points import RefractionPoints as RefractionPoints
    from anamorph.reflections.refraction_points import refraction_points as refraction_points
    from anamorph.rendering import render as render
    from anamorph.scene.camera import Camera as Camera
    from anamorph.scene.model import AmbientLight as AmbientLight
    from anamorph.scene.model import Diffuse as Diffuse
    from anamorph.scene.model import DirectionalLight as DirectionalLight
    from anamorph.scene.model import Glass as Glass
    from anamorph.scene.model import LinearImage as LinearImage
    from anamorph.scene.model import Mesh as Mesh
    from anamorph.scene.model import Mirror as Mirror
    from anamorph.scene.model import PointLight as PointLight
    from anamorph.scene.model import Scene as Scene
    from anamorph.scene.model import Sky as Sky
    from anamorph.scene.model import Texture as Texture
    from anamorph.surfaces.bezier import BezierPatch as BezierPatch
    from anamorph.surfaces.even_asphere import EvenAsphere as EvenAsphere
    from anamorph.surfaces.plane import Plane as Plane
    from anamorph.surfaces.sphere import Sphere as Sphere
    from anamorph.surfaces.toroid import Toroid as Toroid
    from anamorph.viewer.backends.choice import view as view

_HOMES = {
    "anamorph.base.errors": ("AnamorphError",),
    "anamorph.base.notes": ("AnamorphNote",),
    "anamorph.frame": ("Frame", "Status"),
    "anamorph.measure.compare": ("compare",),
    "anamorph.methods": ("METHODS",),
    "anamorph.raymesh": ("RayMesh",),
    "anamorph.reflections.open_paths": ("visible",),
    "anamorph.reflections.reflection_points": ("ReflectionPoints", "ReflectionStatus", "reflection_points"),
    "anamorph.reflections.refraction_points": ("RefractionPoints", "refraction_points"),
    "anamorph.rendering": ("render",),
    "anamorph.scene.camera": ("Camera",),
    "anamorph.lenses.lens": ("Lens",),
    "anamorph.lenses.making": ("make_lens", "worn_lens"),
    "anamorph.lenses.prescription": ("Prescription",),
    "anamorph.files.gltf.exporting": ("save_gltf",),
    "anamorph.files.models": ("load_model",),
    "anamorph.files.sky_image": ("read_sky_image",),
    "anamorph.scene.model": (
        "AmbientLight", "Diffuse", "DirectionalLight", "Glass", "LinearImage", "Mesh",
        "Mirror", "PointLight", "Scene", "Sky", "Texture",
    ),
    "anamorph.files.opening": ("open_scene",),
    "anamorph.surfaces.bezier": ("BezierPatch",),
    "anamorph.surfaces.even_asphere": ("EvenAsphere",),
    "anamorph.surfaces.plane": ("Plane",),
    "anamorph.surfaces.sphere": ("Sphere",),
    "anamorph.surfaces.toroid": ("Toroid",),
    "anamorph.viewer.backends.choice": ("view",),
}  # fmt: skip
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = sorted(_HOME_OF)


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'anamorph' has no attribute {name!r}")
    return getattr(import_module(_HOME_OF[name]), name)


def __dir__() -> list[str]:
    return __all__
