"""Frames of lenses by per-vertex refraction, against rays and against what opticians reckon."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from lens_scenes import AXES, CAMERA, CENTER, MINUS, SIZE, defined, lens_of, of_glass, scene_of, slab, walls
from scenes import drawn

from anamorph.frame import Frame, Status
from anamorph.gallery import make
from anamorph.gallery.flat_mirror import plane_mirror
from anamorph.gallery.solids import grid
from anamorph.gallery.textures import checkerboard
from anamorph.lenses.lens import lens_between
from anamorph.lenses.making import make_lens
from anamorph.lenses.prescription import Prescription
from anamorph.measure.errors import measure, silhouettes
from anamorph.optics.dispersion import line_indices
from anamorph.scene.camera import Camera
from anamorph.scene.model import AmbientLight, Diffuse, Glass, Scene, Sky
from anamorph.surfaces.sphere import round_surface

BUILT_IN = ("spectacles-minus", "spectacles-plus", "magnifier")


@cache
def built_in(name: str, specification: str) -> Frame:
    return drawn(make(name), specification, SIZE)


def inner(reference: Frame) -> np.ndarray:
    return (reference.specular > 0) & ~silhouettes(reference.object_id, reference.specular)


@pytest.mark.parametrize("name", BUILT_IN)
def test_built_in_lenses_are_right_to_a_twentieth_of_a_pixel(name):
    reference, frame = built_in(name, "raytrace"), built_in(name, "pervertex:map=image")
    errors = measure(reference, frame)
    assert errors.pixels.median <= 0.02
    assert errors.pixels.p95 <= 0.05
    assert errors.pixels.max <= 0.1
    # A gap between two books is narrower than a pixel: the truth's silhouettes do not know of it, and a map shows it.
    number = {mesh.name: index + 1 for index, mesh in enumerate(make(name).meshes)}
    gaps = errors.maps.other_object & (reference.object_id == number.get("books"))
    assert gaps.sum() <= 0.004 * errors.maps.specular.sum()
    assert (errors.maps.other_object & ~gaps).sum() <= 1


@pytest.mark.parametrize("name", BUILT_IN)
def test_no_pixel_of_a_lens_goes_without_an_answer(name):
    reference, frame = built_in(name, "raytrace"), built_in(name, "pervertex:map=image")
    assert (frame.status[frame.specular > 0] == Status.OUTSIDE).mean() <= 1e-3
    away = ~silhouettes(reference.specular)
    assert (frame.specular == reference.specular)[away].all()


@pytest.mark.parametrize("name", BUILT_IN)
def test_built_in_lenses_have_the_truths_colours_where_these_are_smooth(name):
    reference, frame = built_in(name, "raytrace"), built_in(name, "pervertex:map=image")
    same_colors(reference, frame)


def same_colors(reference: Frame, frame: Frame) -> None:
    """Where the truth hardly changes from pixel to pixel, or to its diagonal neighbours, the frame is alike."""
    smooth = inner(reference)
    for row, column in ((0, 1), (1, 0), (1, 1), (1, -1)):
        for step in (-1, 1):
            moved = np.roll(reference.color, (step * row, step * column), (0, 1))
            smooth &= np.abs(moved - reference.color).max(axis=-1) < 0.02
    assert smooth.sum() > 500
    difference = np.abs(frame.color - reference.color)[smooth]
    assert np.percentile(difference, 95) <= 0.005
    assert np.percentile(difference, 99.5) <= 0.03


def test_the_edge_band_is_the_edge_and_has_its_colour():
    """Seen through the back, the far rim of a minus lens is a broad band."""
    scene = make("spectacles-minus")
    number = next(index for index, mesh in enumerate(scene.meshes) if mesh.name.endswith("/edge")) + 1
    reference, frame = (built_in("spectacles-minus", name) for name in ("raytrace", "pervertex:map=image"))
    band = inner(reference) & (reference.object_id == number)
    assert band.sum() > 1500
    assert (frame.object_id[band] == number).mean() >= 0.998
    difference = (frame.color - reference.color)[band & (frame.object_id == number)]
    assert np.percentile(np.abs(difference), 99) <= 0.01
    # Within the edge the rays have not been bent by the far face: where they meet it is not where the truth's do.
    assert (frame.status[band & (frame.object_id == number)] == Status.WARPED).all()


@pytest.mark.parametrize("tint", [(0.3, 0.6, 0.9), (1.0, 1.0, 1.0)])
def test_tint_and_fresnels_share_are_the_truths(tint):
    """Light crosses two faces to the scene, and one to the edge."""
    scene = scene_of(lens_of(MINUS, tint))
    reference, frame = drawn(scene, "raytrace", SIZE), drawn(scene, "pervertex:map=image", SIZE)
    same_colors(reference, frame)
    edge = inner(reference) & (reference.object_id == 3) & (frame.object_id == 3)
    assert edge.sum() > 100
    assert np.percentile(np.abs(frame.color - reference.color)[edge], 95) <= 0.006


@pytest.fixture(scope="module")
def dome():
    """A flat back and a steep front, which reflects totally from 23 mm outward."""
    front = round_surface(CENTER + 0.025 * AXES[2], AXES, 1.0 / 0.03)
    back = round_surface(CENTER, AXES * [[-1], [1], [-1]], 0.0)
    lens = lens_between(front, back, CENTER, AXES, 0.0285, Glass(1.5), vertices=721)
    scene = scene_of(lens, camera=replace(CAMERA, field_of_view=18.0))
    return drawn(scene, "raytrace", SIZE), drawn(scene, "pervertex:map=image", SIZE)


def test_total_reflection_says_so_where_it_happens(dome):
    reference, frame = dome
    defined(frame)
    total = (reference.status == Status.TOTAL_REFLECTION) & (reference.specular > 0)
    away = ~silhouettes(total.astype(int), reference.specular)
    for _ in range(3):
        away = ~silhouettes((~away).astype(int)) & away
    assert (total & away).sum() > 1000 and (~total & away & (reference.specular > 0)).sum() > 3000
    assert (frame.status[total & away & (frame.object_id == 3)] == Status.TOTAL_REFLECTION).mean() > 0.9
    assert (frame.specular[total & away] > 0).all()
    passed = ~total & away & (reference.specular > 0) & (reference.object_id != 3)
    assert (frame.status[passed] == Status.TOTAL_REFLECTION).mean() <= 0.02


def test_what_is_not_totally_reflected_is_right(dome):
    reference, frame = dome
    errors = measure(reference, frame)
    passed = inner(reference) & (reference.status != Status.TOTAL_REFLECTION) & (reference.object_id != 3)
    passed &= frame.status != Status.TOTAL_REFLECTION
    assert passed.sum() > 3000
    assert np.median(errors.maps.pixels[passed]) <= 0.3
    assert np.percentile(errors.maps.pixels[passed], 95) <= 0.6


VIEWS = {
    "front": (Camera((0.05, 0.55, 0.0), (0.0, 0.5, 0.4), field_of_view=24.0), 0.5),
    "oblique": (Camera((0.12, 0.58, 0.52), (0.0, 0.5, 0.4), field_of_view=30.0), 0.6),
    "aside": (Camera((0.3, 0.55, 0.43), (0.0, 0.5, 0.4), field_of_view=20.0), None),
    "in the plane of the lens": (Camera((0.3, 0.52, 0.401), (0.0, 0.5, 0.4), field_of_view=20.0), None),
    "near": (Camera((0.0, 0.5, 0.412), (0.0, 0.5, 0.0), field_of_view=70.0), 0.7),
    "between the faces": (Camera((0.0, 0.5, 0.399), (0.0, 0.5, 0.0), field_of_view=60.0), None),
    "far": (Camera((0.1, 0.6, 1.9), (0.0, 0.5, 0.4), field_of_view=4.0), 0.1),
}


@pytest.mark.parametrize("name", VIEWS)
def test_an_eye_anywhere_gets_a_defined_image(name):
    camera, bound = VIEWS[name]
    scene = scene_of(lens_of(MINUS), camera=camera)
    frame = drawn(scene, "pervertex:map=image", SIZE)
    defined(frame)
    if bound is not None:
        reference = drawn(scene, "raytrace", SIZE)
        counted = inner(reference) & (reference.status != Status.TOTAL_REFLECTION) & (reference.object_id != 3)
        assert counted.sum() > 500
        # A triangle with one corner that reflects totally shows the edge.
        assert (frame.status[counted] == Status.TOTAL_REFLECTION).mean() <= 0.02
        counted &= frame.status != Status.TOTAL_REFLECTION
        errors = measure(reference, frame).maps
        assert np.percentile(errors.pixels[counted], 95) <= bound
        assert (frame.object_id != reference.object_id)[counted].mean() <= 0.01


@pytest.mark.parametrize(("distance", "field_of_view"), [(0.004, 90.0), (0.014, 40.0)])
def test_a_tolerance_holds_for_an_eye_as_near_as_spectacles_or_nearer(distance, field_of_view):
    """A triangle of the lens is then as wide as a good part of the image, and rays turn much on it."""
    camera = Camera((0.0, 0.5, 0.4 + distance), (0.0, 0.5, 0.0), field_of_view=field_of_view)
    scene = scene_of(lens_of(MINUS), camera=camera)
    errors = measure(drawn(scene, "raytrace", SIZE), drawn(scene, "pervertex:tolerance=0.5", SIZE))
    counted = errors.maps.specular & ~errors.maps.silhouette
    assert (errors.maps.pixels[counted] <= 0.5).mean() >= 0.999


def test_a_mirror_is_seen_through_a_lens():
    mirror = plane_mirror("mirror", (-0.6, 0.1, -0.1), (1.0, 0.0, 0.5), (0.0, 0.8, 0.0))
    scene = scene_of(lens_of(MINUS), mirror)
    reference = drawn(scene, "raytrace", SIZE)
    lens = inner(reference) & (reference.specular == 2) & (reference.status != Status.TOTAL_REFLECTION)
    behind = np.isin(reference.object_id, [6, 11])
    errors = measure(reference, drawn(scene, "pervertex:map=image", SIZE)).maps
    assert (lens & behind).sum() > 1000
    # The mirror in the lens's map is seen from the map's viewpoint, and not along the rays.
    assert np.median(errors.pixels[lens & behind]) <= 0.6
    assert np.percentile(errors.pixels[lens & behind], 95) <= 1.5
    blind = drawn(scene, "pervertex:map=image,bounces=2", SIZE)
    assert (blind.object_id[lens & behind] != reference.object_id[lens & behind]).mean() > 0.99


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_lens_is_seen_in_a_mirror(side):
    mirror = plane_mirror("mirror", (-0.2, 0.35, 0.0), (0.4, 0.0, 0.0), (0.0, 0.3, 0.0))
    prescription = replace(MINUS, diameter=60.0)
    lens = make_lens(prescription, (-0.08, 0.42, 0.28), (-0.3 * side, 0.0, side))
    camera = Camera((0.25, 0.65, 0.9), (-0.03, 0.47, 0.0), field_of_view=9.0)
    scene = Scene("lens", (mirror, *lens.meshes, *walls()), camera)
    reference, frame = drawn(scene, "raytrace", SIZE), drawn(scene, "pervertex:map=image", SIZE)
    blind = drawn(replace(scene, meshes=(mirror, *walls())), "pervertex:map=image,bounces=1", SIZE)
    # What only the lens changes: without it the mirror's image is exact.
    bent = (
        inner(reference)
        & (reference.specular == 1)
        & (np.linalg.norm(blind.position - reference.position, axis=-1) > 1e-3)
    )
    assert bent.sum() > 100
    close = np.linalg.norm(frame.position - reference.position, axis=-1) < 0.03
    assert (close & (frame.object_id == reference.object_id))[bent].mean() > 0.8


@pytest.fixture(scope="module")
def dispersed():
    """A frame with glass of a low Abbe number, and frames of glass of each line's index alone."""
    indices = line_indices(1.6, 25.0)
    lenses = [lens_of(replace(MINUS, index=1.6), abbe=25.0)]
    lenses += [of_glass(lenses[0], Glass(index)) for index in indices]
    return [drawn(scene_of(lens), "pervertex:map=image", SIZE) for lens in lenses]


@pytest.mark.parametrize("channel", [0, 1, 2])
def test_each_channel_is_the_image_through_glass_of_that_one_index(dispersed, channel):
    whole, *single = (frame.color[..., channel] for frame in dispersed)
    shown = dispersed[0].specular > 0
    difference = np.abs(whole - single[channel])[shown]
    # Images are half floats, of which this is two steps below 1.
    assert np.median(difference) <= 1e-3
    # Edges differ by how the maps' texels lie.
    assert np.percentile(difference, 95) <= 0.05
    if channel != 1:
        others = np.abs(whole - single[1])[shown]
        assert (others > 0.05).mean() > 3.0 * (difference > 0.05).mean()


def grey(scene: Scene) -> Scene:
    meshes = []
    for mesh in scene.meshes:
        material = mesh.material
        if isinstance(material, Diffuse):
            value = float(np.mean(material.color))
            image = checkerboard(128, 8, (220, 220, 220), (60, 60, 60)) if material.texture is not None else None
            material = Diffuse(color=(value, value, value), texture=image)
        meshes.append(replace(mesh, material=material))
    even = Sky((0.5, 0.5, 0.5), (0.5, 0.5, 0.5), (0.5, 0.5, 0.5))
    return replace(scene, meshes=tuple(meshes), lights=(AmbientLight(),), sky=even)


def test_only_glass_with_an_abbe_number_makes_fringes():
    plain, coloured = (
        drawn(grey(scene_of(lens_of(MINUS, abbe=abbe))), "pervertex:map=image", SIZE).color for abbe in (None, 20.0)
    )
    assert np.ptp(plain, axis=-1).max() <= 1e-6
    assert (np.ptp(coloured, axis=-1) > 0.05).sum() > 200
    reference = drawn(grey(scene_of(lens_of(MINUS, abbe=20.0))), "raytrace", SIZE).color
    fringes = [np.subtract(*np.moveaxis(color[..., [0, 2]], -1, 0)) for color in (coloured, reference)]
    strong = np.abs(fringes[1]) > 0.1
    assert (np.sign(fringes[0]) == np.sign(fringes[1]))[strong].mean() > 0.95


def test_a_flat_slab_is_exact():
    """Its rays leave parallel to how they came; only how far beside changes unevenly, and by micrometres."""
    scene = scene_of(slab(vertices=547))
    errors = measure(drawn(scene, "raytrace", SIZE), drawn(scene, "pervertex:map=image", SIZE))
    assert errors.pixels.p95 <= 1e-3
    assert errors.pixels.max <= 5e-3
    assert errors.other_object_percent == 0.0


DISTANCE = 2.0
"""From a thin lens to the wall that is seen through it."""


def thin(power: float, eye_distance: float, prism: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Tangents of lines of sight through a thin lens near its axis, (N,), and the heights where they meet the wall."""
    prescription = Prescription(power, prism=prism, base=90.0, centre_thickness=0.3, base_curve=abs(power) / 2.0 + 1.0)
    if power > 0.0:
        prescription = replace(prescription, base_curve=power / 2.0)
    lens = make_lens(replace(prescription, diameter=12.0), tuple(CENTER.tolist()), (0.0, 0.0, -1.0))
    wall = grid((-3.0, -2.5, 0.4 - DISTANCE), (6.0, 0.0, 0.0), (0.0, 6.0, 0.0)).mesh("wall", Diffuse())
    eye = (0.0, 0.5, 0.4 + eye_distance)
    camera = Camera(eye, (0.0, 0.5, 0.0), field_of_view=float(np.degrees(0.004 / eye_distance)))
    frame = drawn(Scene("thin", (*lens.meshes, wall), camera), "pervertex:map=image", (64, 64))
    assert (frame.specular > 0).all() and (frame.object_id == 4).all()
    tangent = np.tan(np.radians(camera.field_of_view) / 2.0) * (1.0 - (np.arange(64) + 0.5) / 32.0)
    return tangent, frame.position[:, 32, 1] - 0.5


@pytest.mark.parametrize("power", [-6.0, -2.0, 0.4, 3.0])
def test_a_thin_lens_shows_the_image_where_and_as_large_as_it_should(power):
    """h = tan(a) (d + s - d s F): the image of a wall at s is s / (1 - s F) away, and larger by 1 / (1 - s F)."""
    near, far = 0.1, 0.3
    slopes = [np.polyfit(*thin(power, distance), 1)[0] for distance in (near, far)]
    for distance, slope in zip((near, far), slopes, strict=True):
        assert slope == pytest.approx(distance + DISTANCE - distance * DISTANCE * power, rel=5e-3)
    reduction = (slopes[1] - slopes[0]) / (far - near)
    assert DISTANCE / reduction == pytest.approx(DISTANCE / (1.0 - DISTANCE * power), rel=5e-3)


@pytest.mark.parametrize("power", [-6.0, 3.0])
def test_prentices_rule(power):
    """c centimetres from the axis a lens of F dioptres deviates by c F prism dioptres."""
    distance = 0.2
    tangent, height = thin(power, distance)
    at_lens = distance * tangent
    far = np.abs(at_lens) > 0.5e-3
    deviation = (height - at_lens)[far] / DISTANCE - tangent[far]
    assert deviation == pytest.approx(-at_lens[far] * power, rel=0.01)


def test_a_prism_deviates_by_its_prism_dioptres_toward_its_base():
    height = thin(-2.0, 0.1, prism=3.0)[1]
    plain = thin(-2.0, 0.1)[1]
    assert (height - plain) / DISTANCE == pytest.approx(np.full(64, 0.03), rel=0.01)


@pytest.mark.parametrize("name", ["spectacles-plus", "spectacles-minus"])
def test_nothing_is_proved_at_an_edge_that_tracing_does_not_see_there(name):
    """Tracing passes the far face by between its polygon and its circle; and a ray may end at once in the frame."""
    reference, frame = built_in(name, "raytrace:dispersion=false"), built_in(name, "pervertex")
    known = (frame.specular > 0) & np.isin(frame.status, [Status.PROVED, Status.SKY])
    assert known.sum() > 5_000
    assert np.array_equal(frame.object_id[known], reference.object_id[known])
    assert np.abs(frame.ray_direction - reference.ray_direction)[known].max() < 1e-3
