"""The paper's line drawings, of what this package computes: Figures 3, 4 and 8."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from figures import diagram as dg
from figures.panels import Panel, draw, labelled, places
from figures.warps import warps

import anamorph as an
from anamorph import gallery
from anamorph.gallery.curvature_series import curved_mirror
from anamorph.lenses.making import make_lens
from anamorph.lenses.prescription import Prescription
from anamorph.optics.reflection import Reflector, reflected_rays, reflector
from anamorph.optics.refraction import Refractor, refracted_rays, refractor
from anamorph.optics.viewpoint import virtual_viewpoint
from anamorph.raymesh import RayMesh

SIZE = (475, 440)
UP, AHEAD, RIGHT = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, -1.0]), np.array([1.0, 0.0, 0.0])


def rays_of(
    eye: np.ndarray, near: np.ndarray, rays: RayMesh, behind: float, ahead: float, radius: float
) -> list[an.Mesh]:
    """The eye's rays to a surface, those that leave it for `ahead` metres, and their extensions `behind` it."""
    ways = rays.unit_directions()
    incident = np.stack([np.broadcast_to(eye, near.shape), near], axis=1)
    parts = [
        dg.rods(incident, radius, dg.INCIDENT, "incident"),
        dg.rods(np.stack([rays.origins, rays.origins + ahead * ways], axis=1), radius, dg.REFLECTED, "onward"),
    ]
    if behind > 0.0:
        lines = np.stack([rays.origins, rays.origins - behind * ways], axis=1)
        parts.append(dg.rods(lines, radius, dg.EXTENDED, "extended"))
    return parts


def viewpoint() -> list[list[Panel]]:
    """Figure 3: the rays at the vertices of the door mirror, and the point nearest to all of their lines."""
    scene = gallery.make("car-mirror")
    mirror, eye = scene.meshes[0], np.asarray(scene.camera.position)
    warp = warps(scene, (640, 480))[0]
    point = warp.plan.viewpoint[:3] / warp.plan.viewpoint[3]
    rays = warp.body_rays.rays
    meshes = [
        *rays_of(eye, rays.origins, rays, 0.47, 0.55, 0.0013),
        dg.rods(dg.edges(mirror), 0.0026, dg.SURFACE, "mirror"),
        dg.balls([eye], 0.022, dg.EYE, "eye"),
        dg.balls([point], 0.02, dg.VIEWPOINT, "viewpoint"),
    ]
    middle = np.array([0.90, 1.06, -0.42])
    views = {
        "from above": dg.far_camera(middle, UP, AHEAD, 1.12),
        "from the side (the car's left)": dg.far_camera(middle, -RIGHT, UP, 1.12),
    }
    panels = []
    for words, camera in views.items():
        image = dg.drawing("viewpoint", meshes, camera)
        at = places(
            image.camera, SIZE, eye=eye, point=point, mirror=rays.origins[rays.origins[:, :2].sum(axis=1).argmax()]
        )
        x, y = at["eye"]
        u, v = at["point"]
        labels = [("eye", (x, y - 14), "mb"), ("virtual viewpoint", (u + 8, v + 26), "lt")]
        labels.append(("mirror", (at["mirror"][0] + 10, at["mirror"][1] - 10), "lb"))
        panels.append(Panel(labelled(draw(image, size=SIZE), labels), words))
    key = "blue: the eye's rays    teal: reflected rays    orange: their lines behind the mirror"
    panels[0] = replace(panels[0], caption=f"{panels[0].caption}\n{key}")
    return [panels]


def view_volume() -> list[list[Panel]]:
    """Figure 4: the view volume of the map, close to the mirror and in the street."""
    scene = gallery.make("car-mirror")
    eye = np.asarray(scene.camera.position)
    warp = warps(scene, (640, 480))[0]
    point = warp.plan.viewpoint[:3] / warp.plan.viewpoint[3]
    rays, projection = warp.body_rays.rays, warp.plan.projections[0]
    near, ends = dg.volume(projection, 0.62)
    sides = np.stack([np.broadcast_to(point, ends.shape), ends], axis=1)
    close = dg.drawing(
        "view volume",
        [
            *rays_of(eye, rays.origins, rays, 0.0, 0.5, 0.0008),
            dg.rods(dg.edges(scene.meshes[0]), 0.002, dg.SURFACE, "mirror"),
            dg.rods(sides, 0.0025, dg.VOLUME, "sides"),
            dg.rods(dg.loop(near), 0.0045, dg.VIEWPOINT, "near"),
            dg.balls([eye], 0.022, dg.EYE, "eye"),
            dg.balls([point], 0.02, dg.VIEWPOINT, "viewpoint"),
        ],
        dg.far_camera(np.array([0.90, 1.06, -0.42]), UP, AHEAD, 1.12),
    )
    at = places(close.camera, SIZE, eye=eye, point=point, near=near[near[:, 0].argmax()])
    labels = [
        ("eye", (at["eye"][0], at["eye"][1] - 14), "mb"),
        ("virtual viewpoint", (at["point"][0] + 14, at["point"][1]), "lm"),
        ("near plane", (at["near"][0] + 12, at["near"][1] - 4), "lb"),
    ]
    first, last = dg.volume(projection, 42.0)
    street = replace(
        scene,
        meshes=(
            *(mesh for mesh in scene.meshes[1:] if not mesh.name.startswith("housing")),
            dg.rods(np.stack([first, last], axis=1), 0.16, (0.9, 0.02, 0.02), "sides"),
            dg.rods(dg.loop(last), 0.16, (0.9, 0.02, 0.02), "far"),
        ),
        camera=an.Camera((-4.0, 21.0, -19.0), (-1.0, 0.0, 17.0), field_of_view=50.0),
    )
    return [
        [
            Panel(labelled(draw(close, size=SIZE), labels), "from above: near plane (red) and sides (green)"),
            Panel(draw(street, size=SIZE), "its sides in the street, cut off after 42 m"),
        ]
    ]


def regions() -> list[list[Panel]]:
    """Figure 8: where the viewpoint lies for mirrors and lenses that make rays converge or diverge."""
    panels = []
    for words, curvature, eye, middle in (
        ("(a) concave mirror, the eye close to it", -1.0 / 0.9, (0.0, 0.0, 0.28), -0.22),
        ("(b) concave mirror, the eye far from it", -1.0 / 0.62, (0.26, 0.0, 1.0), 0.50),
    ):
        whole = reflector(curved_mirror(curvature, size=0.34))
        row = np.flatnonzero(np.abs(whole.positions[:, 1]) < 1e-6)
        row = row[np.argsort(whole.positions[row, 0])]
        mirror = Reflector(whole.positions[row], whole.normals[row], np.zeros((0, 3), np.int32))
        body = dg.rods(np.stack([mirror.positions[:-1], mirror.positions[1:]], axis=1), 0.007, dg.SURFACE, "mirror")
        rays = reflected_rays(mirror, an.Camera(eye, (0.0, 0.0, 0.0)).eye((640, 480)))
        panels.append(Panel(_section(np.array(eye), mirror.positions, rays, [body], 0.92, middle), words))
    for words, prescription, middle in (
        ("(c) concave lens", Prescription(-8.0, base_curve=1.0, diameter=100.0), 0.0),
        (
            "(d) convex lens, the eye far from it",
            Prescription(7.0, base_curve=3.5, diameter=100.0, centre_thickness=20.0),
            -0.11,
        ),
    ):
        lens = make_lens(prescription, (0.0, 0.0, 0.0), (0.0, 0.0, -1.0))
        lens_row = _row(refractor(lens.meshes[1], lens.meshes[0]), lens.meshes[1], 9, 0.044)
        eye = (0.0, 0.0, 0.27)
        rays = refracted_rays(lens_row, an.Camera(eye, (0.0, 0.0, 0.0)).eye((640, 480)))
        glass = [replace(mesh, material=an.Diffuse((0.72, 0.82, 0.90)), surface=None) for mesh in lens.meshes]
        panels.append(Panel(_section(np.array(eye), lens_row.positions, rays, glass, 0.50, middle), words))
    return [panels[:2], panels[2:]]


def _row(lens: Refractor, near: an.Mesh, count: int, half: float) -> Refractor:
    """A lens whose vertices are a row across its near face."""
    across = np.linspace(-half, half, count)
    assert isinstance(near.surface, an.Sphere)
    parameters = near.surface.parameters(np.column_stack([across, np.zeros((count, 2))]))
    positions, normals = near.surface.position(parameters), near.surface.normal(parameters)
    sign = 1.0 if normals[count // 2] @ lens.axis < 0.0 else -1.0
    return replace(lens, positions=positions, normals=sign * normals, faces=np.zeros((0, 3), np.int32))


def _section(
    eye: np.ndarray, near: np.ndarray, rays: RayMesh, bodies: list[an.Mesh], height: float, middle: float
) -> np.ndarray:
    """Rays in a level plane from above, `height` metres of it; where they cross, the regions before and beyond that."""
    ways = rays.unit_directions()
    point = virtual_viewpoint(rays.origins, ways)
    center = point[:3] / point[3]
    ahead = float(np.mean(np.einsum("ij,ij->i", center - rays.origins, ways)))
    behind = 1.3 * max(-ahead, 0.0)
    meshes = [*rays_of(eye, near, rays, behind, 1.0, 0.0028 * height), *bodies]
    meshes += [
        dg.balls([eye], 0.022 * height, dg.EYE, "eye"),
        dg.balls([center], 0.022 * height, dg.VIEWPOINT, "point"),
    ]
    size = (475, 270)
    camera = dg.far_camera(np.array([0.0, 0.0, middle]), UP, RIGHT, height)
    at = places(camera, size, eye=eye, point=center, start=rays.origins.mean(axis=0))
    labels = [("eye", (at["eye"][0], at["eye"][1] - 12), "mb")]
    labels.append(("virtual viewpoint", (max(at["point"][0], 80.0), at["point"][1] + 34), "mt"))
    if behind == 0.0:
        # Tinted sheets under the rays.
        down = np.array([0.0, -0.2 * height, 0.0])
        first, last = rays.origins[[0, -1]], rays.origins + ways
        meshes.append(dg.sheet(np.stack([center, *first]) + down, (0.99, 0.86, 0.52), "zooming"))
        meshes.append(dg.sheet(np.stack([center, *last]) + down, (0.74, 0.86, 0.97), "reversed"))
        start, point = np.array(at["start"]), np.array(at["point"])
        for words, share in (("zooming", 0.42), ("reversed", 1.6)):
            x, y = start + share * (point - start)
            labels.append((words, (float(x), float(y)), "mm"))
    return labelled(draw(dg.drawing("section", meshes, camera), size=size), labels)
