"""What the page on surface cameras says of errors and times, measured."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from figures.comparing import number, p95_of_things

import anamorph as an
from anamorph import cameras
from anamorph.base.steps import drain
from anamorph.frame import View
from anamorph.gallery.cube import board, cube, cube_scene
from anamorph.gallery.solids import lattice
from anamorph.inward import INWARD, toward_one_point
from anamorph.measure.errors import measure
from anamorph.measure.frame_times import timing_rounds
from anamorph.methods import Specification
from anamorph.optics.reflection import reflected_rays, reflector
from anamorph.surfaces.sphere import Sphere

MAP = (1024, 512)
QUADS = ((10, 10), (24, 48), (64, 128))
METHODS = {"raytrace": Specification.parse("raytrace"), "trilinear": Specification.parse("trilinear"), "inward": INWARD}
SQUARE = (512, 512)
RADIUS = 4.0
"""Of the mirror, metres."""
EYES = {
    "at the center": (0.0, 0.0, 0.0),
    "R/400 aside": (0.01, 0.0, 0.0),
    "R/40 aside": (0.1, 0.0, 0.0),
    "R/10 aside": (0.4, 0.0, 0.0),
    "R/10 nearer to the mirror": (0.0, 0.0, -0.4),
    "R/10 farther from it": (0.0, 0.0, 0.4),
    "R/4 nearer": (0.0, 0.0, -1.0),
}


def sphere(rows: int, columns: int, size: tuple[int, int]) -> an.RayMesh:
    """The map of the cube, from a sphere around it."""
    return cameras.inward_sphere((0.0, 0.0, 0.0), 2.0, size, rows, columns, pole=1.0)


def maps() -> Iterator[str]:
    """Rows of the inward spherical camera: quads, method, errors against the same rays traced and exact ones, time."""
    scene = cube_scene()
    exact = an.render(scene, "raytrace", sphere(256, 512, MAP), MAP, seen=True)
    for rows, columns in QUADS:
        rays = sphere(rows, columns, MAP)
        truth = an.render(scene, "raytrace", rays, MAP, seen=True)
        sessions = {name: each.open(View(scene, rays, MAP)) for name, each in METHODS.items()}
        times = drain(timing_rounds(sessions, [rays, replace(rays)], 20))
        for name, each in METHODS.items():
            frame = an.render(scene, each, rays, MAP, seen=True)
            own, true = measure(truth, frame), measure(exact, frame)
            cells = [
                f"{rows} x {columns}",
                f"`{name}`",
                number(p95_of_things(truth, own)),
                number(own.other_object_percent),
                number(own.flip),
                number(p95_of_things(exact, true)),
                f"{times[name].median / times['raytrace'].median:.2f}",
            ]
            yield "| " + " | ".join(cells) + " |"


def concave(half: float) -> an.Mesh:
    """A spherical concave mirror about the origin, `half` radians to either side of -z."""
    surface, across = Sphere(np.zeros(3), RADIUS), np.linspace(-half, half, 101)
    uv = np.stack([each.ravel() for each in np.meshgrid(np.pi + across, across)], axis=-1)
    faces = lattice(101, 101)[:, ::-1].astype(np.int32)
    normals = -surface.normal(uv)
    return an.Mesh("mirror", surface.position(uv), faces, normals, an.Mirror(), surface=surface, parameters=uv)


def mirrors() -> Iterator[str]:
    """Rows of a spherical concave mirror: the eye, and the error with a mirror of 50 and of 10 degrees."""
    moved = [
        (board(), (0.0, -0.9, -1.5)),
        (board(), (0.0, -0.9, 2.0)),
        (cube(), (0.0, 0.0, 2.8)),
        (cube(), (1.0, -0.6, -1.9)),
    ]
    meshes = [
        replace(mesh, name=f"{mesh.name}-{count}", positions=mesh.positions + np.array(by))
        for count, (mesh, by) in enumerate(moved)
    ]
    for words, place in EYES.items():
        errors = []
        for half in (25.0, 5.0):
            mirror = concave(np.radians(half))
            angle = 2.4 * half * RADIUS / (RADIUS + place[2])
            scene = replace(
                cube_scene(), meshes=tuple(meshes), camera=an.Camera(place, (0.0, 0.0, -RADIUS), field_of_view=angle)
            )
            with_mirror = replace(scene, meshes=(*meshes, mirror))
            truth = an.render(with_mirror, "raytrace:bounces=1", size=SQUARE, seen=True)
            rays = toward_one_point(reflected_rays(reflector(mirror), scene.camera.eye(SQUARE)))
            frame = an.render(scene, INWARD, rays, SQUARE, seen=True)
            found = measure(truth, replace(frame, specular=truth.specular))
            errors += [number(p95_of_things(truth, found)), number(found.pixels.p95)]
        yield f"| {words} | " + " | ".join(errors) + " |"


def rows() -> Iterator[str]:
    """All rows of the page's tables."""
    yield from maps()
    yield from mirrors()
