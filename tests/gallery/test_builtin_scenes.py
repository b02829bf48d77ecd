"""The built-in scenes: sound geometry, exact surfaces under their meshes, and the images that they are to give."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from anamorph import gallery
from anamorph.base.errors import AnamorphError
from anamorph.gallery import solids
from anamorph.gallery.teapot import patches
from anamorph.rays.caster import Caster
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Diffuse, DirectionalLight, Glass, Mirror
from anamorph.surfaces.base import Surface
from anamorph.surfaces.bezier import BezierPatch
from anamorph.surfaces.plane import Plane
from anamorph.surfaces.sphere import Sphere

NAMES = (
    *("car-mirror", "spheres", "room", "flat-mirror", "spectacles-minus", "spectacles-plus", "magnifier"),
    *("curvature-series", "saddle", "car-windows", "facing-mirrors", "torus", "kitchen", "deforming"),
    *("cube-in-sphere", "cube-in-wavy-mirror"),
)
LENSES = ("spectacles-minus", "spectacles-plus", "magnifier")
CONCAVE = (*LENSES, "curvature-series", "kitchen")
"""Scenes in which some surfaces are the inside of a sphere."""
WITHOUT_SURFACES = ("cube-in-wavy-mirror",)
"""Scenes whose mirrors have normals that no surface through their vertices has."""
every_scene = pytest.mark.parametrize("name", NAMES)


@cache
def scene(name):
    return gallery.make(name)


def mesh(name, part):
    return next(mesh for mesh in scene(name).meshes if mesh.name == part)


def exact(part) -> tuple[Surface, np.ndarray]:
    assert part.surface is not None and part.parameters is not None, part.name
    return part.surface, part.parameters


def image(part) -> np.ndarray:
    """The pixels of a mesh's texture; none where it has no texture."""
    material = part.material
    if isinstance(material, Diffuse) and material.texture is not None:
        return material.texture.pixels
    return np.zeros((0, 0, 4), np.uint8)


def face_normals(positions, faces):
    a, b, c = np.moveaxis(np.asarray(positions, float)[faces], 1, 0)
    return np.cross(b - a, c - a)


def object_image(name, size=(160, 120)):
    """Object number (H, W) that each pixel sees first."""
    width, height = size
    pixels = np.stack(np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5), axis=-1).reshape(-1, 2)
    camera, geometry = scene(name).camera, flatten(scene(name))
    directions = camera.directions(pixels, size)
    triangle = Caster(geometry).cast(np.tile(camera.position, (len(pixels), 1)), directions).triangle
    return np.where(triangle < 0, 0, geometry.face_object[triangle]).reshape(height, width)


def test_the_list_is_complete_and_names_what_it_makes():
    assert gallery.names() == NAMES
    for name, entry in gallery.SCENES.items():
        assert entry.name == name == scene(name).name
        assert entry.summary and "\n" not in entry.summary


def test_an_unknown_scene_is_refused_with_the_names_of_the_known():
    with pytest.raises(AnamorphError, match=r"^scene 'car_mirror' is not built in; choose one of: car-mirror, [^\n]*$"):
        gallery.make("car_mirror")


@every_scene
def test_meshes_are_sound(name):
    meshes = scene(name).meshes
    assert len({mesh.name for mesh in meshes}) == len(meshes)
    for part in meshes:
        count = len(part.positions)
        assert part.positions.dtype in (np.float32, np.float64) and part.normals.dtype == np.float32, part.name
        assert np.isfinite(part.positions).all() and part.positions.shape == part.normals.shape == (count, 3), part.name
        assert part.faces.min() >= 0 and part.faces.max() < count, part.name
        np.testing.assert_allclose(np.linalg.norm(part.normals, axis=1), 1.0, atol=1e-5, err_msg=part.name)
        area = face_normals(part.positions, part.faces)
        assert (np.linalg.norm(area, axis=1) > 1e-14).all(), part.name
        agreement = np.einsum("fk,fck->fc", area, part.normals[part.faces].astype(float))
        assert (agreement > 0).all(), f"{part.name}: a normal points inside its triangle"


@every_scene
def test_materials_have_what_they_need_and_stay_small(name):
    textures = set()
    for part in scene(name).meshes:
        if not isinstance(part.material, Diffuse):
            continue
        assert (part.material.texture is not None) == (part.texcoords is not None), part.name
        if part.colors is not None:
            assert part.colors.min() >= 0.0 and part.colors.max() <= 1.0, part.name
        if part.material.texture is not None:
            pixels = part.material.texture.pixels
            assert pixels.dtype == np.uint8 and pixels.shape[2] == 4
            assert all(extent <= 1024 and extent & (extent - 1) == 0 for extent in pixels.shape[:2]), part.name
            textures.add(pixels.tobytes())
    assert len(textures) <= 15
    assert sum(map(len, textures)) <= 24 * 2**20


@every_scene
def test_a_scene_is_the_same_each_time(name):
    for one, other in zip(scene(name).meshes, gallery.make(name).meshes, strict=True):
        np.testing.assert_array_equal(one.positions, other.positions)
        np.testing.assert_array_equal(one.normals, other.normals)
        np.testing.assert_array_equal(image(one), image(other))


@every_scene
def test_suns_are_unit_directions(name):
    for light in scene(name).lights:
        if isinstance(light, DirectionalLight):
            assert np.linalg.norm(light.toward) == pytest.approx(1.0)


@pytest.mark.parametrize("name", [name for name in NAMES if name not in WITHOUT_SURFACES])
def test_reflectors_lie_on_their_exact_surfaces(name):
    reflectors = [part for part in scene(name).meshes if part.specular]
    assert reflectors
    for part in reflectors:
        assert isinstance(part.material, Glass if name in LENSES else Mirror)
        surface, parameters = exact(part)
        # Single precision, a metre or some tens of metres from the origin.
        np.testing.assert_allclose(surface.position(parameters), part.positions, atol=2e-7, rtol=1e-7)
        normal = surface.normal(parameters)
        if name in CONCAVE:
            normal *= np.sign(np.sum(normal * part.normals))
        np.testing.assert_allclose(normal, part.normals, atol=1e-6)
        middle = parameters[part.faces].mean(axis=1)
        area = face_normals(part.positions, part.faces)
        outside = np.einsum("fk,fk->f", area, surface.normal(middle)) > 0
        assert outside.all() or (name in CONCAVE and not outside.any()), part.name
        # Parameters are continuous in every triangle: halfway between vertices they stay near the triangle.
        size = np.sqrt(np.linalg.norm(area, axis=1).max())
        assert np.linalg.norm(surface.position(middle) - part.positions[part.faces].mean(axis=1), axis=1).max() < size


def test_the_door_mirror_is_the_papers():
    mirror = mesh("car-mirror", "mirror")
    assert isinstance(mirror.surface, Sphere) and mirror.surface.radius == 1.4
    assert len(mirror.positions) == 49 and len(mirror.faces) == 72
    eye = np.asarray(scene("car-mirror").camera.position)
    distance = np.linalg.norm(mirror.positions[24] - eye)
    assert 0.65 < distance < 0.85
    assert (np.einsum("vk,vk->v", mirror.normals, eye - mirror.positions) > 0).all()
    assert 9_000 <= sum(len(part.faces) for part in scene("car-mirror").meshes) <= 11_000


def test_the_door_mirror_fills_the_image_and_its_rim_hides_its_border():
    seen = object_image("car-mirror")
    columns = np.flatnonzero((seen == 1).any(axis=0))
    assert 0.6 < (columns[-1] - columns[0] + 1) / seen.shape[1] < 0.78
    mirror, eye = mesh("car-mirror", "mirror"), np.asarray(scene("car-mirror").camera.position)
    geometry = flatten(scene("car-mirror"))
    border = np.flatnonzero((np.indices((7, 7)) % 6 == 0).any(axis=0))
    caster = Caster(geometry)
    triangle = caster.cast(np.tile(eye, (len(border), 1)), mirror.positions[border] - eye).triangle
    names = {scene("car-mirror").meshes[geometry.face_object[one] - 1].name for one in triangle}
    assert names == {"housing"}


def test_the_door_mirror_shows_road_own_car_houses_sky_and_the_car_behind():
    view, geometry = scene("car-mirror"), flatten(scene("car-mirror"))
    u, v = np.meshgrid(np.linspace(-0.064, 0.064, 60), np.linspace(-0.043, 0.043, 40))
    uv = np.stack([u.ravel(), v.ravel()], axis=-1)
    surface, _ = exact(mesh("car-mirror", "mirror"))
    point, normal = surface.position(uv), surface.normal(uv)
    incident = point - view.camera.position
    incident /= np.linalg.norm(incident, axis=1, keepdims=True)
    reflected = incident - 2 * np.einsum("nk,nk->n", incident, normal)[:, None] * normal
    assert (reflected[:, 2] > 0.8).all(), "the mirror looks backward"
    triangle = Caster(geometry).cast(point + 0.002 * normal, reflected).triangle
    objects = np.where(triangle < 0, 0, geometry.face_object[triangle])
    names = np.array(["sky", *(part.name.split("/")[0].split("-")[0] for part in view.meshes)])[objects].reshape(
        u.shape
    )
    share = {name: np.mean(names == name) for name in np.unique(names)}
    assert share["road"] > 0.2 and share["house"] > 0.05 and share["sky"] > 0.05 and share["tree"] > 0.01
    assert 0.03 < share["own"] < 0.2
    assert "car-0" in {view.meshes[number - 1].name for number in np.unique(objects) if number}
    # The own car is at the inner edge, which is the right one: u runs to the right seen from the eye.
    assert np.mean(names[:, -10:] == "own") > 5 * np.mean(names[:, :30] == "own")


def test_teapot_has_newells_32_patches_symmetric_about_its_middle_plane():
    found = patches()
    assert [part for part, _ in found].count("body") == 8 and len(found) == 32

    def key(control):
        return tuple(sorted(map(tuple, np.round(control.reshape(-1, 3) + 0.0, 9) + 0.0)))

    assert {key(control) for _, control in found} == {key(control * (1, 1, -1)) for _, control in found}
    assert len({point for _, control in found for point in key(control)}) == 290
    points = np.concatenate([control.reshape(-1, 3) for _, control in found])
    assert points[:, 1].min() == 0.0 and points[:, 1].max() == 3.15
    # Two sums over the patches as they have been published.
    assert np.abs(points).sum() == pytest.approx(1824.975)
    assert sum(np.sum(control.sum(axis=(0, 1)) ** 2) for _, control in found) == pytest.approx(55231.76837)


def test_teapots_normals_point_outside_and_its_poles_are_level():
    inside = {"handle": None, "spout": None}
    for part, control in patches():
        patch = BezierPatch(control)
        middle, normal = patch.position(np.array([[0.5, 0.5]]))[0], patch.normal(np.array([[0.5, 0.5]]))[0]
        if part in inside:
            assert middle[2] * normal[2] > 0, part
        elif part in ("rim", "bottom"):
            assert normal[1] * (1 if part == "rim" else -1) > 0.9
        else:
            assert middle[[0, 2]] @ normal[[0, 2]] > 0, part
    lid_pole = BezierPatch(next(control for part, control in patches() if part == "lid")).normal(np.array([[0.3, 1.0]]))
    bottom_pole = BezierPatch(next(control for part, control in patches() if part == "bottom"))
    np.testing.assert_allclose(lid_pole, [[0, 1, 0]], atol=1e-9)
    np.testing.assert_allclose(bottom_pole.normal(np.array([[0.7, 0.0]])), [[0, -1, 0]], atol=1e-9)


def test_teapots_patches_meet_at_identical_vertices():
    pots = [part for part in scene("room").meshes if part.name.startswith("teapot/")]
    assert len(pots) == 32
    triangles = np.concatenate([part.positions[part.faces] for part in pots])
    _, index = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    faces = index.reshape(-1, 3)
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    _, uses = np.unique(edges, axis=0, return_counts=True)
    assert uses.max() == 2
    # Open are only the rim inside, the lid below, and both ends of handle and spout: six rings of Newell's.
    around, tube = 4 * 8, 2 * 8
    assert np.sum(uses == 1) == 2 * around + 4 * tube


def test_the_ball_is_watertight_across_its_seam():
    ball = mesh("spheres", "mirror-ball")
    _, index = np.unique(ball.positions + 0.0, axis=0, return_inverse=True)
    faces = index.reshape(-1)[ball.faces]
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    _, uses = np.unique(edges, axis=0, return_counts=True)
    assert (uses == 2).all()
    assert np.ptp(exact(ball)[1][ball.faces], axis=1).max() < 0.1


@pytest.mark.parametrize(("name", "part"), [("flat-mirror", "mirror"), ("spheres", "mirror-flat")])
def test_flat_mirrors_are_two_triangles_that_face_the_eye(name, part):
    mirror = mesh(name, part)
    assert isinstance(mirror.surface, Plane) and len(mirror.faces) == 2
    assert (mirror.normals @ (scene(name).camera.position - mirror.positions[0]) > 0).all()


@pytest.mark.parametrize(("name", "part", "least"), [
    ("flat-mirror", "mirror", 0.2), ("spheres", "mirror-ball", 0.06), ("spheres", "mirror-flat", 0.04),
])  # fmt: skip
def test_mirrors_fill_a_good_part_of_their_images(name, part, least):
    number = [one.name for one in scene(name).meshes].index(part) + 1
    assert np.mean(object_image(name) == number) > least


@pytest.mark.parametrize("name", ["kettle", "toaster", "saucepan"])
def test_the_kitchens_bodies_are_closed_and_convex(name):
    body = mesh("kitchen", name)
    _, index = np.unique(body.positions + 0.0, axis=0, return_inverse=True)
    faces = index.reshape(-1)[body.faces]
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    _, uses = np.unique(edges, axis=0, return_counts=True)
    assert (uses == 2).all()
    surface, parameters = exact(body)
    inner = parameters[(parameters[:, 1] > 0.0) & (parameters[:, 1] < 1.0)]
    assert (surface.curvatures(inner) > -1e-6).all()
    heights = body.positions @ body.normals[::7].T - np.einsum("vk,vk->v", body.positions, body.normals)[::7]
    assert heights.max() < 1e-6


def test_the_kitchen_has_some_ten_thousands_of_vertices_and_a_bowl_to_look_into():
    assert 20_000 < sum(len(part.positions) for part in scene("kitchen").meshes if not part.specular) < 90_000
    bowl, eye = mesh("kitchen", "mixing-bowl"), np.asarray(scene("kitchen").camera.position)
    assert (np.einsum("vk,vk->v", bowl.normals, exact(bowl)[0].center - bowl.positions) > 0.0).all()
    assert np.linalg.norm(eye - exact(bowl)[0].center) > exact(bowl)[0].radius
    kettle = [part.name for part in scene("kitchen").meshes].index("kettle") + 1
    assert np.mean(object_image("kitchen") == kettle) > 0.08


def volume(shape):
    """By Gauss: the flux of position / 3 through the skin."""
    return (
        np.einsum("fk,fk->", shape.positions[shape.faces].mean(axis=1), face_normals(shape.positions, shape.faces)) / 6
    )


@given(st.floats(0.1, 2.0), st.floats(0.1, 2.0), st.integers(3, 20), st.floats(-90.0, 90.0), st.integers(0, 2))
def test_solids_are_closed_and_wound_outward(radius, height, sides, degrees, axis):
    prism = sides / 2 * np.sin(2 * np.pi / sides) * radius**2 * height
    for solid, expected in (
        (solids.cylinder(radius, height, sides), prism),
        (solids.box((0, 0, 0), (radius, height, 2.0)), 2 * radius * height),
    ):
        assert volume(solid.turned(degrees, axis).moved(0.3, -0.2, 1.0)) == pytest.approx(expected, rel=1e-9)


def test_an_icosphere_is_nearly_a_ball_and_has_its_count_of_triangles():
    points, faces = solids.icosphere(3)
    assert len(faces) == 20 * 4**3 and len(points) == 10 * 4**3 + 2
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 1.0)
    assert volume(solids.creased(points, faces)) == pytest.approx(4 / 3 * np.pi, rel=0.02)


def test_creases_keep_a_box_sharp_and_a_ball_smooth():
    box = solids.box((-1, -1, -1), (1, 1, 1))
    sharp = solids.creased(box.positions, box.faces, 60.0)
    assert len(sharp.positions) == 24 and (np.abs(sharp.normals).max(axis=1) == 1.0).all()
    assert len(solids.creased(box.positions, box.faces, 100.0).positions) == 8
    points, faces = solids.icosphere(2)
    ball = solids.creased(points, faces, 60.0)
    assert len(ball.positions) == len(points)
    np.testing.assert_allclose(ball.normals, ball.positions, atol=0.05)


def test_a_grid_shows_the_top_left_of_its_image_at_its_top_left():
    grid = solids.grid((0, 0, 0), (2, 0, 0), (0, 1, 0), (4, 3), (0.25, 0.5, 0.75, 1.0))
    top_left = np.argmax(grid.positions[:, 1] - grid.positions[:, 0])
    bottom_right = np.argmin(grid.positions[:, 1] - grid.positions[:, 0])
    np.testing.assert_allclose(grid.texcoords[[top_left, bottom_right]], [[0.25, 0.5], [0.75, 1.0]])
    np.testing.assert_allclose(grid.normals, [[0, 0, 1]] * 20)


def test_the_town_is_never_seen_from_behind():
    geometry = flatten(scene("car-mirror"))
    normals = face_normals(geometry.positions, geometry.faces)
    eyes = np.array([[0, 14, -100], [0, 14, 170], [-2, 2, -30], [3, 3, 60], [-30, 25, 20], [30, 25, 20], [0, 40, 30]])
    generator = np.random.default_rng(1)
    origins = np.repeat(eyes.astype(float), 3000, axis=0)
    houses = np.concatenate([part.positions for part in scene("car-mirror").meshes if part.name.startswith("house")])
    directions = houses[generator.integers(len(houses), size=len(origins))] - origins
    directions += generator.normal(size=directions.shape)
    triangle = Caster(geometry).cast(origins, directions).triangle
    hit = triangle >= 0
    behind = np.einsum("nk,nk->n", normals[triangle[hit]], directions[hit]) > 0
    # Into one's own car one looks through its open windows.
    behind &= geometry.face_object[triangle[hit]] != 2
    assert hit.sum() > 10_000 and behind.mean() < 0.0008, np.unique(geometry.face_object[triangle[hit][behind]])


@pytest.mark.parametrize("name", LENSES)
def test_whoever_looks_through_a_lens_goes_round_the_lens(name):
    glass = np.concatenate([mesh.positions for mesh in scene(name).meshes if mesh.specular])
    middle = (glass.min(axis=0) + glass.max(axis=0)) / 2.0
    assert np.linalg.norm(scene(name).camera.target - middle) < 0.1 * np.linalg.norm(np.ptp(glass, axis=0))
