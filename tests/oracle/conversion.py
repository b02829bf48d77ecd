"""From the tracer's scenes to the package's, and from the package's lenses to the tracer's parts."""

from __future__ import annotations

import numpy as np

import anamorph
from anamorph.lenses.lens import Lens
from anamorph.lenses.making import lens_axes
from anamorph.surfaces.base import Surface
from oracle.parts import round_edge
from oracle.scene import DIFFUSE, GLASS, MIRROR, Camera, Mesh, Part, Scene, Shape, Trim
from oracle.subrays import Shown


def package_scene(scene: Scene) -> anamorph.Scene:
    """The same scene for the package, with exact surfaces where parts have shapes."""
    random = np.random.default_rng(0)
    meshes = tuple(_package_mesh(part, random.uniform(0.2, 0.9, 3)) for part in scene.parts)
    camera = scene.camera
    return anamorph.Scene(
        scene.name, meshes, anamorph.Camera(camera.position, camera.target, camera.up, camera.field_of_view)
    )


def shown_by(scene: Scene, method: str, size: tuple[int, int]) -> Shown:
    """What one of the package's methods shows of a scene."""
    frame = anamorph.render(package_scene(scene), method=method, size=size, seen=True)
    direction = np.zeros_like(frame.position) if frame.ray_direction is None else frame.ray_direction
    return Shown(frame.position, frame.object_id, frame.specular, frame.status, direction)


def _package_mesh(part: Part, color: np.ndarray) -> anamorph.Mesh:
    materials = {
        DIFFUSE: anamorph.Diffuse(tuple(color.tolist())),
        MIRROR: anamorph.Mirror(),
        GLASS: anamorph.Glass(part.index),
    }
    surface = None if part.shape is None else _package_surface(part.shape)
    return anamorph.Mesh(
        name=part.name,
        positions=part.mesh.positions.astype(np.float32),
        faces=part.mesh.faces.astype(np.int32),
        normals=part.mesh.normals.astype(np.float32),
        material=materials[part.material],
        surface=surface,
        parameters=None if surface is None else part.mesh.parameters,
    )


def _package_surface(shape: Shape) -> Surface:
    match shape.kind:
        case "plane":
            return anamorph.Plane(shape.origin, shape.axes[0], shape.axes[1])
        case "sphere":
            return anamorph.Sphere(shape.origin, shape.numbers[0], shape.axes)
        case "toroid":
            return anamorph.Toroid(shape.origin, *shape.numbers, shape.axes)
        case "asphere":
            return anamorph.EvenAsphere(shape.origin, *shape.numbers[:2], shape.numbers[2:], shape.axes)
    raise ValueError(f"the package has no {shape.kind}; trace its mesh")


def worn_parts(
    prescription: anamorph.Prescription,
    eye: tuple[float, float, float],
    gaze: tuple[float, float, float],
    vertices: int = 547,
    name: str = "lens",
) -> list[Part]:
    """The three parts of the lens that an eye wears."""
    worn = anamorph.worn_lens(prescription, eye, gaze, name=name, vertices=vertices)
    middle = np.asarray(eye) + 1e-3 * prescription.vertex_distance * np.asarray(gaze) / np.linalg.norm(gaze)
    return lens_parts(worn, middle, lens_axes(gaze), 5e-4 * prescription.diameter)


def lens_parts(lens: Lens, middle: np.ndarray, axes: np.ndarray, radius: float) -> list[Part]:
    """The parts of a round lens about the third of `axes` through `middle`."""
    faces = []
    for mesh in (lens.front, lens.back):
        own = Mesh(mesh.positions, mesh.normals, mesh.faces.astype(np.int64), mesh.parameters)
        height = (own.positions - middle) @ axes[2]
        ends = height.min() - 0.05 * radius, height.max() + 0.05 * radius
        trim = Trim(middle, axes, radius, *ends)
        shape = _shape(mesh.surface, mesh.side)
        faces.append(Part(mesh.name, own, GLASS, mesh.material.index, shape, trim))
    edge = lens.edge
    band = Mesh(edge.positions, edge.normals, edge.faces.astype(np.int64))
    return [*faces, Part(edge.name, band, finer=round_edge(*faces, axes))]


def built_in(name: str) -> Scene:
    """A built-in scene with one lens; what else is in it stands as triangles after the lens."""
    scene = anamorph.open_scene(name)[0]
    named = {mesh.name: mesh for mesh in scene.meshes}
    own = {kind: named[f"lens/{kind}"] for kind in ("front", "back", "edge")}
    border = own["edge"].positions[: len(own["edge"].positions) // 2].astype(float)
    middle = border.mean(axis=0)
    outward = np.cross(border[0] - middle, border[len(border) // 4] - middle)
    right = (border[0] - middle) / np.linalg.norm(border[0] - middle)
    outward /= np.linalg.norm(outward)
    axes = np.stack([right, np.cross(outward, right), outward])
    radius = float(np.linalg.norm((border - middle) @ axes[:2].T, axis=1).mean())
    lens = lens_parts(Lens(own["front"], own["back"], own["edge"]), middle, axes, radius)
    others = [
        Part(mesh.name, Mesh(mesh.positions, mesh.normals, mesh.faces.astype(np.int64)))
        for mesh in scene.meshes
        if all(mesh is not one for one in own.values())
    ]
    camera = scene.camera
    return Scene(name, (*lens, *others), Camera(camera.position, camera.target, camera.field_of_view, camera.up))


def _shape(surface: Surface, side: float) -> Shape:
    """The package's surface by its documented fields."""
    match surface:
        case anamorph.Sphere():
            return Shape("sphere", np.asarray(surface.center), np.asarray(surface.axes), (surface.radius,), side)
        case anamorph.Toroid():
            numbers = surface.base_curvature, surface.cross_curvature
            return Shape("toroid", np.asarray(surface.apex), np.asarray(surface.axes), numbers, side)
        case anamorph.EvenAsphere():
            numbers = surface.curvature, surface.conic, *surface.coefficients
            return Shape("asphere", np.asarray(surface.apex), np.asarray(surface.axes), numbers, side)
        case anamorph.Plane():
            axes = np.stack([surface.edge_u, surface.edge_v, np.cross(surface.edge_u, surface.edge_v)]).astype(float)
            return Shape("plane", np.asarray(surface.origin), axes / np.linalg.norm(axes, axis=1)[:, None], (), side)
    raise ValueError(f"{type(surface).__name__} is no surface of a lens here")
