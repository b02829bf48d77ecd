"""The figures of the paper on inward looking projections, appendix G of the thesis: 1 to 9."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from figures import diagram as dg
from figures.panels import Panel, draw, labelled, places
from figures.ray_surfaces import seen

import anamorph as an
from anamorph import cameras
from anamorph.gallery.cube import cube, cube_scene
from anamorph.gallery.solids import box, lattice
from anamorph.gallery.textures import checkerboard
from anamorph.inward import INWARD
from anamorph.inward.field_views import CORNERS
from anamorph.optics.laws import reflect
from anamorph.surfaces.sphere import Sphere

HALF = (475, 356)
SQUARE = (475, 475)
THIRD = (313, 313)
MAP = (960, 480)
METHOD = INWARD.with_options(antialias=4)

VERTEX_ON = an.Camera((-1.6, 0.6, 1.6), (0.0, 0.0, 0.0), field_of_view=40.0)
"""An edge of the cube in the middle, and its top in sight."""
BEHIND = 3.1
"""From the image plane of Figure 4 to its point of convergence, behind the cube, metres."""

WALLS = (
    ("+x", (214, 110, 90)),
    ("-x", (96, 146, 206)),
    ("+y", (226, 226, 218)),
    ("-y", (120, 108, 96)),
    ("+z", (120, 176, 104)),
    ("-z", (232, 186, 88)),
)
ROOM = 2.0
"""Half a side of Blinn's room, metres."""


def volumes() -> list[list[Panel]]:
    """Figures 1 and 2: the view volumes of a perspective and of an anti-perspective image, and two things in them."""
    pyramid = np.array(
        [[0.35, -0.3, -1.3], [0.35, -0.3, -0.8], [-0.15, -0.3, -0.8], [-0.15, -0.3, -1.3], [0.1, 0.25, -1.05]]
    )
    faces = np.array([[0, 3, 4], [3, 2, 4], [2, 1, 4], [1, 0, 4], [0, 1, 2], [0, 2, 3]], np.int32)
    things = [
        an.Mesh("pyramid", pyramid, faces, np.tile([0.0, 1.0, 0.0], (5, 1)), an.Diffuse((0.86, 0.72, 0.40))),
        box((-0.2, -0.25, -2.5), (0.3, 0.25, -2.0)).mesh("cube", an.Diffuse((0.55, 0.68, 0.80))),
    ]
    plane, far = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]), 2.9
    camera = dg.far_camera(np.array([0.0, 0.0, -1.4]), (0.85, 0.45, 0.55), (0.0, 1.0, 0.0), 3.2)
    panels = []
    for words, point, near_half, point_name in (
        ("1: perspective: rays part from the viewpoint", 0.5, 0.15, "viewpoint"),
        ("2: anti-perspective: rays converge", -1.9, 0.55, "point of convergence"),
    ):
        tip = np.array([0.0, 0.0, point])
        near = np.column_stack([near_half * plane, np.zeros(4)])
        end = tip + (near - tip) * (point + far) / point
        parts = [
            *things,
            dg.rods(
                np.concatenate([dg.loop(near), dg.loop(end), np.stack([near, end], axis=1)]), 0.012, dg.VOLUME, "volume"
            ),
            dg.rods(np.stack([near, np.broadcast_to(tip, near.shape)], axis=1), 0.006, dg.EXTENDED, "rays"),
            dg.balls([tip], 0.05, dg.VIEWPOINT, "point"),
        ]
        at = places(camera, HALF, point=tip, plane=near[3])
        labels = [
            (point_name, (at["point"][0], at["point"][1] - 12), "mb"),
            ("image plane", (at["plane"][0], at["plane"][1] - 6), "mb"),
        ]
        panels.append(Panel(labelled(draw(dg.drawing("volume", parts, camera), "raytrace", HALF), labels), words))
    return [panels]


def cubes() -> list[list[Panel]]:
    """Figures 3 and 4: a cube in perspective and in anti-perspective."""
    scene = replace(cube_scene(), meshes=(cube(),), camera=VERTEX_ON)
    wide = replace(VERTEX_ON, field_of_view=104.0)
    rays = cameras.anti_perspective(wide, SQUARE, BEHIND)
    return [
        [
            Panel(seen(scene, None, SQUARE, "raytrace:antialias=4"), "3: in perspective"),
            Panel(seen(scene, rays, SQUARE, METHOD), "4: in anti-perspective, by raster"),
        ]
    ]


def mirror_rays() -> list[list[Panel]]:
    """Figure 5: rays of an eye reflected by a spherical concave mirror, for an eye at its center and for others."""
    angles = np.radians(np.linspace(-38.0, 38.0, 13))
    points = np.stack([np.sin(angles), np.zeros(13), -np.cos(angles)], axis=-1)
    rim = np.radians(np.linspace(-48.0, 48.0, 49))
    arc = np.stack([np.sin(rim), np.zeros(49), -np.cos(rim)], axis=-1)
    camera = dg.far_camera(np.array([0.0, 0.0, -0.35]), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0), 1.75)
    panels = []
    for eye, words in (
        ((0.0, 0.0, 0.0), "at the center: rays come\nback through it"),
        ((0.0, 0.0, -0.25), "beside it on the axis: the\nouter ones miss the point"),
        ((0.25, 0.0, 0.0), "beside it across: they run\nalong a caustic"),
    ):
        way = points - eye
        reflected = reflect(way / np.linalg.norm(way, axis=1, keepdims=True), -points)
        ends = points + 1.7 * reflected
        parts = [
            dg.rods(np.stack([arc[:-1], arc[1:]], axis=1), 0.012, dg.SURFACE, "mirror"),
            dg.rods(np.stack([np.broadcast_to(eye, points.shape), points], axis=1), 0.005, dg.INCIDENT, "incident"),
            dg.rods(np.stack([points, ends], axis=1), 0.005, dg.EXTENDED, "reflected"),
            dg.balls([np.array(eye)], 0.025, dg.EYE, "eye"),
        ]
        panels.append(Panel(draw(dg.drawing("mirror", parts, camera), "raytrace", THIRD), words))
    return [panels]


def blinns_room() -> an.Scene:
    """A cubic room of six colours, seen from within."""
    walls = []
    for side, color in WALLS:
        dark = tuple(channel * 3 // 4 for channel in color)
        tiles = an.Diffuse((1.0, 1.0, 1.0), checkerboard(64, 4, color, (dark[0], dark[1], dark[2])))
        walls.append(box((-ROOM,) * 3, (ROOM,) * 3, side).mesh(side, tiles))
    lights = (an.AmbientLight((0.9, 0.9, 0.9), (0.9, 0.9, 0.9)),)
    return an.Scene("room", tuple(walls), an.Camera((0.0, 0.0, 0.0), (0.0, 0.0, -1.0)), lights)


def sphere_map(size: tuple[int, int]) -> an.RayMesh:
    """All around a point as a mirror ball far away shows it: the front in the middle, what is behind at the rim."""
    radius, angle = np.meshgrid(np.linspace(0.0, 0.995, 25), np.linspace(0.0, 2.0 * np.pi, 73))
    # The ball's normal halves the angle between the view and what is seen.
    turn = 2.0 * np.arcsin(radius)
    directions = np.stack([np.sin(turn) * np.cos(angle), np.sin(turn) * np.sin(angle), -np.cos(turn)], axis=-1)
    places = np.stack([radius * np.cos(angle), -radius * np.sin(angle)], axis=-1) * size[0] / 2.0 + size[0] / 2.0
    return an.RayMesh(
        image=np.column_stack([places.reshape(-1, 2), np.ones(places[..., 0].size)]),
        origins=np.zeros((places[..., 0].size, 3)),
        directions=directions.reshape(-1, 3),
        faces=lattice(*places.shape[:2])[:, ::-1].astype(np.int32),
        status=np.zeros(places[..., 0].size, np.uint8),
    )


def cube_map(size: tuple[int, int]) -> an.RayMesh:
    """All around a point as six images of a cube that is laid flat, in immediate mode."""
    surface = cameras.RaySurface(size)
    for column, row, forward, up in (
        (1, 0, (0, 1, 0), (0, 0, 1)), (0, 1, (-1, 0, 0), (0, 1, 0)), (1, 1, (0, 0, -1), (0, 1, 0)),
        (2, 1, (1, 0, 0), (0, 1, 0)), (3, 1, (0, 0, 1), (0, 1, 0)), (1, 2, (0, -1, 0), (0, 0, -1)),
    ):  # fmt: skip
        right = np.cross(forward, up)
        surface.viewport(column / 4, row / 3, (column + 1) / 4, (row + 1) / 3)
        surface.begin_surface("rays", columns=2)
        for y, x in ((1, -1), (1, 1), (-1, -1), (-1, 1)):
            surface.normal(*(np.array(forward) + x * right + y * np.array(up)).tolist())
            surface.vertex(0.0, 0.0, 0.0)
        surface.end_surface()
    return surface.ray_mesh()


def environment_maps() -> list[list[Panel]]:
    """Figures 6 to 8: a cubic room around a point, as three kinds of map."""
    scene = blinns_room()
    pole = np.radians(89.0)
    ball = Sphere(np.zeros(3), 1e-6, np.diag([-1.0, 1.0, -1.0]))
    unrolled = cameras.from_surface(ball, (640, 320), window=((-np.pi, np.pi), (-pole, pole)), rows=32, columns=64)
    made = (
        (sphere_map((320, 320)), (320, 320), "6: a sphere map"),
        (cube_map((428, 321)), (428, 321), "7: a cube map"),
        (unrolled, (640, 320), "8: a longitude/latitude map"),
    )
    panels = [Panel(np.maximum(seen(scene, rays, size), 0), words) for rays, size, words in made]
    return [panels[:2], panels[2:]]


def around_a_cube() -> list[list[Panel]]:
    """Figure 9: a cube from all around, and the four views that it is made of."""
    scene = replace(cube_scene(), meshes=(cube(),))
    rays = cameras.inward_sphere((0.0, 0.0, 0.0), 2.0, MAP, rows=24, columns=48, pole=1.0)
    views = []
    for number, corner in enumerate(CORNERS, start=1):
        x, y, z = (-2.0 * corner).tolist()
        up = -CORNERS[number - 2]
        one = an.Camera((x, y, z), (0.0, 0.0, 0.0), tuple(up.tolist()), 135.0)
        size = (232, 232)
        views.append(Panel(seen(scene, cameras.anti_perspective(one, size), size, METHOD), f"view {number} of 4"))
    return [
        views,
        [Panel(seen(scene, rays, MAP, METHOD), "9: the map that they make, its rays to within a degree of the poles")],
    ]
