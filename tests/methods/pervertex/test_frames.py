"""Per-vertex reflection: each step of the paper against a twin written here, and its frames against the reference."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from plans import plan_of
from scenes import (
    CAMERA,
    CENTER,
    SIZE,
    drawn,
    flat_mirror,
    open_view,
    pixels_of,
    scene_with,
    sky_scene,
    spherical_mirror,
    surroundings,
)

from anamorph.base.errors import AnamorphError
from anamorph.frame import Status, View
from anamorph.gallery import make
from anamorph.gallery.flat_mirror import plane_mirror
from anamorph.gallery.solids import box, globe, join, lattice
from anamorph.gpu.device import get_device
from anamorph.measure.errors import measure, silhouettes
from anamorph.methods.pervertex import Options, pervertex
from anamorph.methods.stage import Stage
from anamorph.projection import UNIFORM_BYTES
from anamorph.scene.camera import Camera
from anamorph.scene.model import Diffuse, Mesh, Mirror, Scene
from anamorph.surfaces.plane import Plane
from anamorph.surfaces.sphere import Sphere

CURVED = scene_with(spherical_mirror())


@pytest.fixture(scope="module")
def reference():
    return drawn(CURVED, "raytrace")


@pytest.fixture(scope="module")
def frame():
    return drawn(CURVED, "pervertex:map=image")


def test_the_device_gets_the_plans_lookups_and_projection_in_single_precision(monkeypatch):
    stage = Stage(View(CURVED, CAMERA, SIZE))
    drawing = pervertex.PerVertexDrawing(stage, Options())
    written = {}
    queue = get_device().queue
    monkeypatch.setattr(queue, "write_buffer", lambda buffer, offset, data: written.update({buffer: data.copy()}))
    drawing.prepare(get_device().create_command_encoder(), CAMERA, (0.0, 0.0))
    held = drawing.diagnostics()
    (level,) = held["levels"]
    body_rays, plan = plan_of(stage.view.scene)
    (draw,) = held["seen"].draws
    triangles, data = (written[buffer] for buffer in level.buffers)
    triangles = triangles.reshape(-1, 4)[draw.first : draw.first + draw.count]
    # Mesh 0 has the scene's first triangles, so that the number in the scene is that in the mirror.
    corners = data.reshape(-1, 4)[triangles[:, 2:3] + np.arange(3)]
    assert sorted(triangles[:, 0]) == list(range(len(body_rays.rays.faces)))
    assert plan.vertices.tolist() == list(range(len(body_rays.rays.origins)))
    assert corners.tolist() == plan.lookups[0, body_rays.rays.faces[triangles[:, 0]]].astype(np.float32).tolist()
    (view,), (corner,) = level.views, level.atlas.rectangles.corners
    (maps,) = written[level.maps]
    assert maps[: UNIFORM_BYTES // 4].tolist() == plan.projections[0].uniform(view.size, corner).tolist()
    assert draw.sides == 1
    assert view.size == tuple(int(texels) for texels in plan.texels[0])


@pytest.mark.parametrize(
    "specification",
    ["pervertex:map=image", "pervertex:map=image,projective=false", "pervertex:map=image,resolution=0.5"],
)
def test_every_vertex_shows_the_hit_of_its_own_ray(specification):
    """The paper's guarantee: the camera is turned so that each vertex in turn falls on a pixel's centre."""
    mirror = CURVED.meshes[0]
    session = open_view(CURVED, specification)
    checked = 0
    vertices = np.arange(10, len(mirror.positions) - 10, 5)
    for vertex in vertices[vertices % 9 % 8 != 0]:
        point = mirror.surface.position(mirror.parameters)[vertex]
        camera = replace(CAMERA, target=tuple(point.tolist()))
        session.draw(camera, (0.5, 0.5))
        seen = session.frame(seen=True)
        _, plan = plan_of(CURVED, camera)
        x, y = SIZE[0] // 2 - 1, SIZE[1] // 2 - 1
        assert seen.specular[y, x] == 1
        if not np.isfinite(plan.distances[vertex]):
            assert seen.object_id[y, x] == 0
            continue
        # The map may show there what stands in the line to the viewpoint, but not in the ray (the paper's Figure 16).
        if silhouettes(seen.object_id)[y, x]:
            continue
        assert seen.position[y, x] == pytest.approx(plan.hits[vertex], abs=2e-3)
        checked += 1
    assert checked >= 3


@pytest.mark.parametrize(
    "specification",
    ["pervertex", "environment:mode=planar", "pervertex:map=image", "pervertex:map=image,resolution=0.3"],
)
@pytest.mark.parametrize("camera", [CAMERA, Camera((-0.6, 0.9, 0.4), (0, 0.5, 0), (0.3, 1, 0), 50.0)])
def test_a_flat_mirror_of_two_triangles_is_exact(specification, camera):
    scene = scene_with(flat_mirror(), camera=camera)
    reference, frame = drawn(scene, "raytrace"), drawn(scene, specification)
    errors = measure(reference, frame)
    assert errors.pixels.p95 <= 0.05
    assert errors.pixels.max <= 0.05
    if "resolution" not in specification:
        assert errors.other_object_percent == 0.0


def test_plain_texture_coordinates_bend_a_flat_mirrors_image():
    """What the projective ones cure is real: the deviation from the paper is needed."""
    scene = scene_with(flat_mirror())
    errors = measure(drawn(scene, "raytrace"), drawn(scene, "pervertex:map=image,projective=false"))
    assert errors.pixels.median > 1.0


def test_a_curved_mirror_is_close_to_the_truth(reference, frame):
    errors = measure(reference, frame)
    assert errors.angular_mrad.median <= 1.0
    assert errors.angular_mrad.p95 <= 5.0
    assert errors.pixels.p95 <= 0.5
    assert errors.other_object_percent <= 1.0
    environment = measure(reference, drawn(CURVED, "environment"))
    assert environment.angular_mrad.p95 >= 10.0 * errors.angular_mrad.p95
    assert errors.rmse <= 0.1


def test_at_silhouettes_it_is_off_by_no_more_than_its_neighbours_differ(reference, frame):
    """Where the truth has an edge, every pixel still sees an object that the truth shows within two pixels."""
    rows, columns = np.nonzero((reference.specular == 1) & (frame.object_id != reference.object_id))
    for row, column in zip(rows, columns, strict=True):
        around = reference.object_id[max(row - 2, 0) : row + 3, max(column - 2, 0) : column + 3]
        assert frame.object_id[row, column] in around


def test_more_vertices_bring_it_nearer():
    p95 = []
    for count in (2, 4, 8, 16):
        scene = scene_with(spherical_mirror(count=count))
        p95.append(measure(drawn(scene, "raytrace"), drawn(scene, "pervertex:map=image")).angular_mrad.median)
    assert p95[0] > 3.0 * p95[1] > 9.0 * p95[2]
    assert p95[3] < p95[2]


def test_a_rim_over_the_border_does_not_disturb():
    """The rim hides the outer vertices from the eye, and stands in the way of their rays."""
    mirror = spherical_mirror()
    bars = [
        box((-0.23, 0.64, -0.03), (0.23, 0.68, 0.03)),
        box((-0.23, 0.32, -0.03), (0.23, 0.36, 0.03)),
        box((-0.23, 0.32, -0.03), (-0.185, 0.68, 0.03)),
        box((0.185, 0.32, -0.03), (0.23, 0.68, 0.03)),
    ]
    rim = join(bars).mesh("rim", Diffuse(color=(0.1, 0.1, 0.1)))
    scene = Scene("rim", (mirror, *surroundings(), rim), CAMERA)
    number = len(scene.meshes)
    reference, frame = drawn(scene, "raytrace"), drawn(scene, "pervertex:map=image")
    assert (frame.object_id[frame.specular == 0] == number).sum() > 500
    errors = measure(reference, frame)
    # The rim's own reflection, which the near plane leaves out, is seen in a narrow border.
    shows_rim = (reference.specular == 1) & (reference.object_id == number)
    inside = errors.maps.specular & ~errors.maps.silhouette & ~shows_rim
    assert np.percentile(errors.maps.angular[inside], 95) <= 5.0
    assert errors.maps.angular[inside].max() <= 40.0


def test_under_the_sky_alone_every_pixel_sees_the_sky():
    scene = sky_scene(spherical_mirror())
    reference, frame = drawn(scene, "raytrace"), drawn(scene, "pervertex:map=image")
    assert (frame.object_id == 0).all()
    assert (frame.status == Status.SKY).all()
    looks = frame.specular == 1
    assert np.linalg.norm(frame.position[looks], axis=1) == pytest.approx(1.0, abs=1e-5)
    assert measure(reference, frame).angular_mrad.max <= 3.0
    difference = np.abs(frame.color - reference.color)[looks & (reference.specular == 1)]
    assert np.percentile(difference, 99) <= 0.005
    # The gradient is steep at the horizon.
    assert difference.max() <= 0.04


def test_the_back_of_a_mirror_is_diffuse():
    """One mirror turns its back on the eye, another its front: the one has no plan."""
    camera = Camera((0.25, 0.65, -0.9), (0.0, 0.5, 0.0), field_of_view=32.0)
    other = replace(flat_mirror(), name="other", positions=flat_mirror().positions * [-1, 1, 1] + [0.3, 0, 1.5])
    turned = np.asarray(flat_mirror().faces)[:, ::-1]
    other = replace(other, faces=turned, normals=-flat_mirror().normals, surface=None, parameters=None)
    scene = scene_with(spherical_mirror(), other, camera=camera)
    _, plan = plan_of(scene)
    assert plan is None
    reference = drawn(scene, "raytrace")
    assert ((reference.object_id == 1) & (reference.specular == 0)).sum() > 1000
    for name in ("pervertex", "pervertex:map=image", "environment"):
        frame = drawn(scene, name)
        back = (
            (reference.object_id == 1)
            & (reference.specular == 0)
            & ~silhouettes(reference.object_id, reference.specular)
        )
        assert (frame.object_id[back] == 1).all()
        assert (frame.specular[back] == 0).all()
        assert (frame.status[back] == Status.DIRECT).all()
        assert np.abs(frame.color - reference.color)[back].max() < 2e-3


@pytest.mark.parametrize("name", ["pervertex", "pervertex:map=image", "environment"])
def test_a_mirror_that_shows_front_and_back_is_a_mirror_on_its_front_alone(name):
    """A gutter, concave toward the eye on one side only: its near half turns its back."""
    angles = np.linspace(-2.4, 2.4, 33)
    x, z = 0.15 * np.sin(angles), 0.15 * np.cos(angles)
    positions = np.concatenate([np.stack([x, np.full(33, y), z], axis=-1) for y in (0.35, 0.65)])
    normals = np.tile(np.stack([np.sin(angles), np.zeros(33), np.cos(angles)], axis=-1), (2, 1))
    gutter = Mesh(
        "mirror",
        positions.astype(np.float32),
        lattice(2, 33).astype(np.int32),
        normals.astype(np.float32),
        Mirror(back=(0.9, 0.0, 0.0)),
    )
    camera = Camera((0.5, 0.7, -0.6), (0.0, 0.5, 0.0), field_of_view=32.0)
    scene = scene_with(gutter, camera=camera)
    reference, frame = drawn(scene, "raytrace"), drawn(scene, name)
    inner = ~silhouettes(reference.object_id, reference.specular)
    back = inner & (reference.object_id == 1) & (reference.specular == 0)
    front = inner & (reference.specular == 1)
    assert back.sum() > 300 and front.sum() > 300
    assert (frame.specular[back] == 0).all()
    assert (frame.status[back] == Status.DIRECT).all()
    assert np.abs(frame.color - reference.color)[back].max() < 2e-3
    assert (frame.specular[front] == 1).all()


def defined(frame):
    for name in ("color", "position"):
        assert np.isfinite(getattr(frame, name)).all()
    assert set(np.unique(frame.status)) <= {int(status) for status in Status}
    assert (np.abs(np.linalg.norm(frame.position[frame.object_id == 0], axis=-1) - 1.0) < 1e-4).all()


@pytest.mark.parametrize("height", [1e-3, 1e-2, 0.1])
@pytest.mark.parametrize("mirror", [flat_mirror(), spherical_mirror(), spherical_mirror(30.0)])
def test_a_grazing_eye_gets_a_defined_image(mirror, height):
    camera = Camera((0.75, 0.55, 0.75 * height), (0.0, 0.5, 0.0), field_of_view=30.0)
    scene = scene_with(mirror, camera=camera)
    frame = drawn(scene, "pervertex:map=image")
    defined(frame)
    reference = drawn(scene, "raytrace")
    p95 = measure(reference, frame).pixels.p95
    if isinstance(mirror.surface, Plane) and p95 is not None:
        assert p95 <= 0.05


@pytest.mark.parametrize("distance", [30.0, 1e3, 1e5])
@pytest.mark.parametrize("mirror", [flat_mirror(), spherical_mirror()])
def test_a_very_distant_eye_sees_by_nearly_parallel_rays(mirror, distance):
    position = CENTER + distance * np.array([0.2, 0.1, 1.0])
    camera = Camera(tuple(position.tolist()), tuple(CENTER.tolist()), field_of_view=float(np.degrees(0.45 / distance)))
    scene = scene_with(mirror, camera=camera)
    # The eye's own images lose float32 digits at 10^5 m; the reflections must not.
    reference, frame = drawn(scene, "raytrace"), drawn(scene, "pervertex:map=image")
    defined(frame)
    errors = measure(reference, frame)
    assert errors.angular_mrad.median <= 2.0
    assert errors.angular_mrad.p95 <= 10.0


def inside_of_a_ball():
    parameters, faces = globe(12, 24)
    sphere = Sphere(CENTER, 3.0)
    return Mesh(
        "mirror",
        sphere.position(parameters).astype(np.float32),
        faces[:, ::-1].astype(np.int32),
        -sphere.normal(parameters).astype(np.float32),
        Mirror(),
        surface=sphere,
        parameters=parameters,
    )


@pytest.mark.parametrize("radius", [-10.0, -1.4, -0.9, -0.4])
def test_a_concave_mirror_gets_a_defined_image(radius):
    scene = scene_with(spherical_mirror(radius))
    frame = drawn(scene, "pervertex:map=image")
    defined(frame)
    assert (frame.status == Status.WARPED).sum() > 1000
    assert measure(drawn(scene, "raytrace"), frame).angular_mrad.median <= 10.0


@pytest.mark.parametrize("position", [(0.0, 0.5, 0.0), (0.3, 0.7, 1.0)])
def test_an_eye_inside_a_mirror_ball_gets_a_defined_image(position):
    """All reflected rays, or all normals, cancel out in the mean."""
    camera = Camera(position, (0.0, 0.4, -1.0))
    defined(drawn(scene_with(inside_of_a_ball(), camera=camera), "pervertex:map=image"))


def test_rays_or_normals_that_cancel_out_exactly_get_a_defined_image():
    """In the middle of a cube of mirrors, with no triangle wholly ahead, the mean ray and normal are zero."""
    shape = box((-2.0, -2.0, -2.0), (2.0, 2.0, 2.0))
    room = replace(shape, normals=-shape.normals, faces=shape.faces[:, ::-1]).mesh("mirror", Mirror())
    camera = Camera((0.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    frame = drawn(scene_with(room, camera=camera), "pervertex:map=image")
    defined(frame)
    assert (frame.specular == 1).all()
    assert (frame.status != Status.OUTSIDE).all(), "the two walls that are seen have maps of their own"


def ball():
    sphere = Sphere(CENTER, 0.3)
    parameters, faces = globe(16, 32)
    return Mesh(
        "mirror",
        sphere.position(parameters).astype(np.float32),
        faces.astype(np.int32),
        sphere.normal(parameters).astype(np.float32),
        Mirror(),
        surface=sphere,
        parameters=parameters,
    )


@pytest.mark.parametrize("position", [(0.0, 0.5, 0.9), (0.25, 2.0, 0.1), (0.0, 0.5, 1e4)])
def test_a_whole_ball_has_maps_for_all_its_rays(position):
    camera = Camera(position, tuple(CENTER.tolist()), (1.0, 0.0, 0.0), 30.0)
    scene = scene_with(ball(), camera=camera)
    frame = drawn(scene, "pervertex:map=image")
    defined(frame)
    assert (frame.status != Status.OUTSIDE).all()
    if position[2] < 1e4:
        reference, own_rays = drawn(scene, "raytrace"), drawn(scene, "pervertex")
        for each, median, p95 in ((frame, 1.0, 2.0), (own_rays, 0.05, 0.1)):
            errors = measure(reference, each)
            assert errors.pixels.median <= median
            assert errors.pixels.p95 <= p95
            assert errors.other_object_percent <= 2.0


def test_resolution_scales_the_map():
    widths = []
    for resolution in (0.5, 1.0, 2.0):
        stage = Stage(View(CURVED, CAMERA, SIZE))
        drawing = pervertex.PerVertexDrawing(stage, Options(resolution=resolution))
        drawing.prepare(get_device().create_command_encoder(), CAMERA, (0.0, 0.0))
        widths.append(drawing.diagnostics()["levels"][0].views[0].size[0])
    assert widths == pytest.approx([widths[1] / 2, widths[1], widths[1] * 2], abs=1)


@pytest.mark.parametrize(
    ("specification", "word"),
    [
        ("pervertex:map=image,antialias=2", "antialias"),
        ("pervertex:map=image,resolution=0", "resolution"),
        ("pervertex:map=image,resolution=nan", "resolution"),
        ("pervertex:map=image,resolution=1e9", "resolution"),
    ],
)
def test_wrong_options_are_named(specification, word):
    with pytest.raises(AnamorphError, match=word) as caught:
        open_view(CURVED, specification)
    assert "\n" not in str(caught.value)


def test_the_overlay_shows_a_red_ball_behind_every_vertex():
    """At each vertex' pixel, or beside it where the wires cross, stands a ball; elsewhere the frame is unchanged."""
    size = (640, 480)
    plain, overlaid = (
        drawn(CURVED, "pervertex:map=image", size),
        drawn(CURVED, "pervertex:map=image,overlay=mesh", size),
    )
    mirror = CURVED.meshes[0]
    _, plan = plan_of(CURVED, size=size)
    places = pixels_of(CAMERA, size, mirror.positions)
    red = (overlaid.color[..., 0] > 4.0 * overlaid.color[..., 1]) & (
        np.abs(overlaid.color - plain.color).max(-1) > 0.02
    )
    inner = np.arange(len(places)).reshape(9, 9)[1:-1, 1:-1].ravel()
    shown = [
        red[int(y) - 4 : int(y) + 5, int(x) - 4 : int(x) + 5].any()
        for x, y in places[inner][np.isfinite(plan.distances[inner])]
    ]
    assert len(shown) > 15
    assert np.mean(shown) >= 0.9
    sky = [
        red[int(y) - 2 : int(y) + 3, int(x) - 2 : int(x) + 3].any()
        for x, y in places[inner][~np.isfinite(plan.distances[inner])]
    ]
    assert np.mean(sky) <= 0.3
    assert (overlaid.position == plain.position).all()
    a, b = places[mirror.faces[20][0]], places[mirror.faces[20][1]]
    x, y = ((a + b) / 2.0).astype(int)
    wires = (overlaid.color[y - 1 : y + 2, x - 1 : x + 2] == 1.0).all(axis=-1)
    assert wires.any()


@pytest.mark.parametrize("options", ["antialias=4", "resolution=2"])
def test_antialiasing_and_finer_maps_change_edges_alone(frame, options):
    other = drawn(CURVED, f"pervertex:map=image,{options}")
    defined(other)
    difference = np.abs(other.color - frame.color).max(axis=-1)
    steady = np.ones(difference.shape, bool)
    for axis in (0, 1):
        for step in (-2, -1, 1, 2):
            steady &= np.abs(np.roll(frame.color, step, axis) - frame.color).max(axis=-1) < 0.03
    steady &= ~silhouettes(frame.object_id, frame.specular)
    assert steady.sum() > 0.3 * steady.size
    assert np.percentile(difference[steady], 99) <= 0.03
    assert difference[steady].max() <= 0.35
    if "antialias" in options:
        assert (difference > 0.03).sum() > 50
        assert (other.object_id == frame.object_id).mean() > 0.99


def facing_mirrors():
    """A mirror that shows another, with the first in it."""
    behind = plane_mirror("behind", (0.6, 0.2, 1.2), (-1.2, 0.0, 0.0), (0.0, 0.7, 0.0))
    return scene_with(spherical_mirror(), behind)


STEADY = {
    "curved": (CURVED, "map=image,overlay=mesh"),
    "smooth": (CURVED, "map=image,antialias=4"),
    "both regions": (scene_with(spherical_mirror(-0.4)), "map=image"),
    "patches": (scene_with(ball()), "map=image"),
    "in each other": (facing_mirrors(), "map=image,bounces=3"),
    "lens": (make("magnifier"), "map=image"),
    "surfaces": (CURVED, ""),
    "surfaces, smooth": (CURVED, "antialias=4"),
    "surfaces in both regions": (scene_with(spherical_mirror(-0.4)), ""),
    "surfaces in patches": (scene_with(ball()), ""),
    "surfaces, traced": (facing_mirrors(), "tolerance=0.5"),
}


@pytest.mark.parametrize("name", STEADY)
def test_nothing_is_created_on_the_device_in_the_steady_state(name, monkeypatch):
    device, made = get_device(), Counter()
    scene, options = STEADY[name]
    camera = scene.camera
    session = open_view(scene, f"pervertex:{options}")
    session.draw(camera)
    session.wait()
    kinds = ("buffer", "buffer_with_data", "texture", "bind_group", "render_pipeline", "sampler", "shader_module")
    for kind in (f"create_{kind}" for kind in kinds):
        original = getattr(device, kind)

        def counted(*args, original=original, kind=kind, **settings):
            made[kind] += 1
            return original(*args, **settings)

        monkeypatch.setattr(device, kind, counted)
    away = np.subtract(camera.position, camera.target)
    for step in range(5):
        aside = 0.01 * step * np.array([away[2], 0.0, -away[0]])
        session.draw(replace(camera, position=tuple((camera.position + aside).tolist())))
    session.wait()
    assert made == {}
    session.draw(replace(camera, position=tuple((camera.target + 0.4 * away).tolist())))
    assert name != "curved" or made["create_texture"] > 0, "maps that have become too coarse are made anew"
