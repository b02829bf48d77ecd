"""The reference's frames: traced pixels are shaded as drawn ones are, and its buffers say what its paths did."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import CAMERA, SIZE, drawn, flat_mirror, open_view, pixels_of, scene_with, spherical_mirror, surroundings

from anamorph import gallery
from anamorph.base.errors import AnamorphError
from anamorph.frame import Status, View
from anamorph.gallery.solids import box
from anamorph.measure.errors import silhouettes
from anamorph.methods import METHODS, Specification
from anamorph.methods.tracing.paths import specular_rectangle
from anamorph.rendering import draw_frame
from anamorph.scene.model import Diffuse, Glass, PointLight, Scene

CURVED = scene_with(spherical_mirror())


@pytest.fixture(scope="module")
def traced():
    return drawn(CURVED, "raytrace")


def glass_scene():
    glass = replace(box((-0.25, 0.3, -0.05), (0.1, 0.6, 0.05)).mesh("pane", Diffuse()), material=Glass(index=1.5))
    return scene_with(glass)


@pytest.mark.parametrize("name", ["car-mirror", "spheres", "flat-mirror", "room", "test"])
def test_traced_and_drawn_pixels_are_shaded_by_one_function(name):
    """Inside the traced rectangle every pixel is traced, also those that look past the mirror."""
    scene = CURVED if name == "test" else gallery.make(name)
    if name == "test":
        scene = replace(scene, lights=(*scene.lights, PointLight((0.3, 1.2, 0.8), (0.4, 0.3, 0.2))))
    traced, raster = drawn(scene, "raytrace"), drawn(scene, "environment:update=once,face=16")
    x0, y0, x1, y1 = specular_rectangle(scene, scene.camera, SIZE)
    inside = np.zeros(traced.specular.shape, bool)
    inside[y0:y1, x0:x1] = True
    direct = inside & (traced.specular == 0) & (raster.specular == 0)
    assert direct.sum() > 100
    same = direct & (traced.object_id == raster.object_id)
    assert same.sum() >= 0.98 * direct.sum()
    difference = np.abs(traced.color - raster.color).max(axis=-1)
    interior = same & ~silhouettes(raster.object_id, raster.specular)
    assert np.median(difference[interior]) <= 1e-3
    assert np.percentile(difference[interior], 90) <= 0.02
    assert np.percentile(difference[same], 99) <= 0.25
    # Seen points, and everything outside the rectangle, where both are drawn by one pipeline.
    solid = interior & (traced.object_id != 0)
    scale = np.linalg.norm(traced.position[solid] - np.array(scene.camera.position), axis=-1)
    assert (np.linalg.norm(traced.position - raster.position, axis=-1)[solid] <= 1e-3 * scale).mean() > 0.99
    assert (traced.color[~inside] == raster.color[~inside]).all()
    assert (traced.object_id[~inside] == raster.object_id[~inside]).all()


def test_untextured_pixels_are_equal_to_half_precision():
    bare = tuple(
        replace(mesh, material=Diffuse((0.7, 0.6, 0.5)), texcoords=None) if mesh.name == "floor" else mesh
        for mesh in CURVED.meshes
    )
    scene = replace(CURVED, meshes=bare, lights=(*CURVED.lights, PointLight((0.3, 1.2, 0.8), (0.4, 0.3, 0.2))))
    traced, raster = drawn(scene, "raytrace"), drawn(scene, "environment:face=16")
    same = (traced.specular == 0) & (raster.specular == 0) & (traced.object_id == raster.object_id)
    assert np.abs(traced.color - raster.color)[same].max() <= 2e-3


def test_the_seen_buffers_say_where_the_paths_end(traced):
    mirror = traced.specular == 1
    assert mirror.sum() > 5000
    assert set(np.unique(traced.status[mirror])) == {Status.TRACED, Status.SKY}
    assert set(np.unique(traced.status[~mirror])) == {Status.DIRECT, Status.SKY}
    assert ((traced.object_id == 0) == (traced.status == Status.SKY)).all()
    # The position lies on the last ray, which has unit direction.
    assert np.linalg.norm(traced.ray_direction, axis=-1) == pytest.approx(1.0, abs=1e-5)
    solid = traced.object_id != 0
    toward = traced.position - traced.ray_origin
    away = np.linalg.norm(np.cross(toward, traced.ray_direction), axis=-1)
    assert away[solid].max() <= 1e-4 * np.linalg.norm(toward, axis=-1)[solid].max()
    assert (np.einsum("hwi,hwi->hw", toward, traced.ray_direction)[solid] > 0).all()
    assert np.abs(traced.position - traced.ray_direction)[~solid].max() <= 1e-5
    # Mirror pixels' last rays leave from the mirror, the others' from the eye.
    sphere = CURVED.meshes[0].surface
    distance = np.linalg.norm(traced.ray_origin[mirror].astype(float) - sphere.center, axis=-1)
    assert distance == pytest.approx(sphere.radius, abs=1e-5)
    assert np.abs(traced.ray_origin[~mirror] - np.array(CAMERA.position, np.float32)).max() == 0.0


def test_direct_pixels_hold_the_point_that_projects_to_them(traced):
    direct = (traced.status == Status.DIRECT) & (traced.specular == 0)
    rows, columns = np.nonzero(direct)
    places = pixels_of(CAMERA, SIZE, traced.position[direct])
    assert places == pytest.approx(np.stack([columns, rows], axis=-1) + 0.5, abs=2e-3)


def test_supersampling_averages_shifted_frames():
    session = open_view(CURVED, "raytrace")
    shifted = []
    for y in (-0.25, 0.25):
        for x in (-0.25, 0.25):
            session.draw(CAMERA, (x, y))
            shifted.append(session.frame().color)
    expected = np.mean(shifted, axis=0)
    view = View(CURVED, CAMERA, SIZE, 2)
    frame = draw_frame(view, Specification.parse("raytrace"), seen=True)
    assert frame.color == pytest.approx(expected, abs=1e-6)
    assert (frame.position == drawn(CURVED, "raytrace").position).all()
    assert np.abs(shifted[0] - shifted[3]).max() > 0.1


@pytest.mark.parametrize("name", METHODS)
def test_a_shift_moves_the_sample_points_right_and_down(name):
    session = open_view(CURVED, name)
    session.draw(CAMERA)
    still = session.frame(seen=True)
    session.draw(CAMERA, (1.0, -1.0))
    moved = session.frame(seen=True)
    assert (moved.object_id[1:, :-1] == still.object_id[:-1, 1:]).mean() > 0.999
    assert (moved.specular[1:, :-1] == still.specular[:-1, 1:]).mean() > 0.999


def test_a_scene_without_a_mirror_is_drawn_directly():
    scene = Scene("diffuse", surroundings(), CAMERA)
    frame, other = drawn(scene, "raytrace"), drawn(scene, "pervertex")
    assert (frame.specular == 0).all()
    assert (frame.ray_origin == np.float32(CAMERA.position)).all()
    for name in ("color", "position", "object_id", "status"):
        assert (getattr(frame, name) == getattr(other, name)).all()


def test_a_mirror_outside_the_image_is_not_traced():
    camera = replace(CAMERA, target=(0.25, 0.65, 5.0))
    session = open_view(CURVED, "raytrace")
    session.draw(CAMERA)
    session.draw(camera)
    frame = session.frame(seen=True)
    assert (frame.specular == 0).all()
    assert np.isfinite(frame.color).all()
    assert (frame.ray_origin == np.float32(camera.position)).all(), "no rays are left of the frame before"


def test_paths_that_meet_too_many_mirrors_are_outside():
    """Two mirrors face each other, with the eye in between."""
    other = replace(flat_mirror(), name="other")
    plane = other.surface
    plane = replace(
        plane, origin=np.array([0.6, 0.0, 2.0]), edge_u=np.array([-1.2, 0, 0]), edge_v=np.array([0, 1.2, 0])
    )
    other = replace(
        other,
        positions=plane.position(other.parameters).astype(np.float32),
        normals=plane.normal(other.parameters).astype(np.float32),
        surface=plane,
    )
    scene = Scene("facing", (flat_mirror(), other, *surroundings()[:1]), CAMERA)
    counts = []
    for bounces in (1, 2, 8):
        frame = drawn(scene, f"raytrace:bounces={bounces}")
        outside = frame.status == Status.OUTSIDE
        counts.append(outside.sum())
        assert (frame.specular[outside] != 0).all()
        assert np.isfinite(frame.color).all()
        # It ends on the mirror it had reached.
        assert set(np.unique(frame.object_id[outside])) <= {1, 2}
    assert counts[0] > counts[1] > counts[2]


def test_glass_is_traced():
    frame = drawn(glass_scene(), "raytrace")
    looks = frame.specular == 1
    assert looks.sum() > 1000
    assert {int(Status.TRACED), int(Status.SKY)} <= set(np.unique(frame.status[looks]))
    assert (frame.object_id[looks] != 1).mean() > 0.9
    assert np.isfinite(frame.color).all()


@pytest.mark.parametrize("method", ["pervertex", "environment", "environment:mode=planar", "raytrace:truth=raymesh"])
def test_glass_elsewhere_is_one_line_that_names_the_remedy(method):
    with pytest.raises(AnamorphError, match="raytrace") as caught:
        open_view(glass_scene(), method)
    assert "pane" in str(caught.value)
    assert "not there yet" not in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("specification", "word"),
    [("raytrace:truth=none", "truth"), ("raytrace:bounces=0", "bounces"), ("raytrace:bounces=256", "bounces")],
)
def test_wrong_options_are_named(specification, word):
    with pytest.raises(AnamorphError, match=word) as caught:
        open_view(CURVED, specification)
    assert "\n" not in str(caught.value)


def test_ray_mesh_truth_is_the_interpolated_rays(traced):
    """It differs from surface truth by the tessellation, and less with more vertices."""
    differences = []
    for count in (4, 16):
        scene = scene_with(spherical_mirror(count=count))
        surface, raymesh = drawn(scene, "raytrace"), drawn(scene, "raytrace:truth=raymesh")
        both = (surface.specular == 1) & (raymesh.specular == 1)
        cosine = np.einsum("ni,ni->n", surface.ray_direction[both].astype(float), raymesh.ray_direction[both])
        differences.append(np.sqrt(np.median(2.0 - 2.0 * np.clip(cosine, -1.0, 1.0))))
    assert 1e-4 < differences[0] < 0.02
    assert differences[1] < differences[0] / 6.0
