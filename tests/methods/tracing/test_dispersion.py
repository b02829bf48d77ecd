"""Colour in the truth: three lines of the spectrum, each on its own way, and nothing else changed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import CAMERA, SIZE, drawn, flat_mirror, open_view, scene_with

from anamorph import gallery
from anamorph.base.errors import AnamorphError
from anamorph.base.steps import drain
from anamorph.frame import Status, View
from anamorph.gallery.solids import box
from anamorph.gpu.device import get_device
from anamorph.gpu.drawing import bind_scene, submit
from anamorph.gpu.targets import COLOR_FORMAT, begin_pass, make_target, read_texture
from anamorph.gpu.visibility import VisibilityBuffer
from anamorph.lenses.making import make_lens
from anamorph.lenses.prescription import Prescription
from anamorph.methods import Specification
from anamorph.methods.stage import Stage
from anamorph.methods.tracing.launch import EyeRays, eye_rays
from anamorph.methods.tracing.packing import packed
from anamorph.methods.tracing.paths import PathTracer
from anamorph.optics.dispersion import line_indices
from anamorph.projection import camera_projection
from anamorph.rays.caster import Caster
from anamorph.rendering import draw_frame
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import flatten
from anamorph.scene.model import AmbientLight, Diffuse, Glass, Mesh, Scene

SEEN = ("position", "object_id", "specular", "status", "ray_origin", "ray_direction")
EYE_TO_LENS, LENS_TO_WALL = 0.3, 3.0
SMALL = (64, 48)


def wall(low: float, high: float, color: tuple[float, float, float], slope: float) -> Mesh:
    """A diffuse wall behind the lens between two heights at its middle; its borders rise by `slope`."""
    x = np.array([-0.5, 0.5, 0.5, -0.5])
    y = np.array([low, low, high, high]) + slope * x
    positions = np.stack([x, y, np.full(4, -LENS_TO_WALL)], axis=-1).astype(np.float32)
    normals = np.tile(np.array([0.0, 0.0, 1.0], np.float32), (4, 1))
    return Mesh(f"wall-{low}", positions, np.array([[0, 1, 2], [0, 2, 3]], np.int32), normals, Diffuse(color))


def lens_of(prescription: Prescription) -> tuple[Mesh, ...]:
    """Its back vertex at the origin; the eye is on the positive z axis and the world along -z."""
    return make_lens(prescription, (0.0, 0.0, 0.0), (0.0, 0.0, -1.0), vertices=169).meshes


def before_a_wall(prescription: Prescription, edge: float) -> Scene:
    """An eye before a lens, and behind it a wall that is dark up to a height and bright above."""
    walls = wall(-0.5, edge, (0.1, 0.1, 0.1), 0.05), wall(edge, 0.5, (0.8, 0.8, 0.8), 0.05)
    camera = Camera((0.0, 0.0, EYE_TO_LENS), (0.0, 0.0, 0.0), field_of_view=3.4)
    return Scene("wall", (*lens_of(prescription), *walls), camera, (AmbientLight(),))


def glass_changed(scene: Scene, **changes) -> Scene:
    """`scene` with its glass of another index or Abbe number."""
    meshes = (
        replace(mesh, material=replace(mesh.material, **changes)) if isinstance(mesh.material, Glass) else mesh
        for mesh in scene.meshes
    )
    return replace(scene, meshes=tuple(meshes))


def lens_in_a_mirror() -> Scene:
    """A lens that is seen directly and in a flat mirror, before a checkered floor."""
    glass = replace(box((-0.1, 0.4, 0.2), (0.05, 0.55, 0.3)).mesh("block", Diffuse()), material=Glass(1.6, abbe=20.0))
    return scene_with(flat_mirror(), glass, camera=replace(CAMERA, position=(0.35, 0.7, 1.0)))


def tracer_of(scene: Scene) -> PathTracer:
    geometry = flatten(scene)
    return PathTracer(scene, geometry, Caster(geometry))


def edge_heights(frame) -> np.ndarray:
    """How far above the image's middle dark turns to bright, pixels, by colour: the mean of the middle columns."""
    height, width, _ = frame.color.shape
    columns = frame.color[:, width // 2 - 8 : width // 2 + 8].astype(float)
    bright, dark = columns[4:12].mean(axis=0), columns[-12:-4].mean(axis=0)
    return height / 2.0 - ((columns - dark) / (bright - dark)).sum(axis=0).mean(axis=0)


LENSES = {
    "plus": (Prescription(2.0, base_curve=2.0, centre_thickness=0.5, diameter=24.0, index=1.5, abbe=58.0), 0.03),
    "minus": (Prescription(-8.0, base_curve=0.0, centre_thickness=0.4, diameter=24.0, index=1.6, abbe=20.0), 0.21),
    "below": (Prescription(-8.0, base_curve=0.0, centre_thickness=0.4, diameter=24.0, index=1.74, abbe=20.0), -0.21),
    "prism": (Prescription(0.0, prism=4.0, base=90.0, base_curve=0.0, diameter=24.0, abbe=30.0), 0.12),
}
"""Each with the height on the wall, metres, of an edge that is seen well off its middle."""


@pytest.mark.parametrize("name", LENSES)
def test_in_the_image_red_and_blue_are_apart_by_prism_over_abbe_number(name):
    """Prentice: at height c a lens is a prism of power c F; its deviation differs by (c F + p) / V from C to F line."""
    prescription, edge = LENSES[name]
    scene, size = before_a_wall(prescription, edge), (48, 240)
    frame = draw_frame(View(scene, scene.camera, size, 4), Specification.parse("raytrace"))
    red, green, blue = edge_heights(frame)
    pixels = size[1] / (2.0 * np.tan(np.radians(scene.camera.field_of_view) / 2.0))
    # A plus lens lowers the look above its middle; a prism raises it toward its base, and sees the edge lower.
    deviation = 0.01 * prescription.prism - EYE_TO_LENS * green / pixels * prescription.sphere
    reach = EYE_TO_LENS + LENS_TO_WALL - EYE_TO_LENS * LENS_TO_WALL * prescription.sphere
    expected = -pixels * LENS_TO_WALL * deviation / prescription.abbe / reach
    assert abs(expected) > 1.5 and abs(green) < 0.4 * size[1]
    assert blue - red == pytest.approx(expected, rel=0.03)
    assert min(red, blue) < green < max(red, blue)
    same = edge_heights(
        draw_frame(View(scene, scene.camera, size, 4), Specification.parse("raytrace:dispersion=false"))
    )
    assert same == pytest.approx(green, abs=1e-3)


@pytest.mark.parametrize("name", LENSES)
def test_last_rays_of_red_and_blue_are_apart_by_prism_over_abbe_number(name):
    prescription, edge = LENSES[name]
    scene = before_a_wall(prescription, edge)
    tracer = tracer_of(scene)
    records = drain(tracer.tracing(eye_rays(scene.camera, SMALL)))
    red, blue = drain(tracer.tracing_colors(eye_rays(scene.camera, SMALL), records)).astype(float)
    words = records.view(np.uint32)
    through = (words[words[:, 14] > 0][:, 7] >> 24) == 2
    assert through.sum() > 2000
    records, red, blue = records[words[:, 14] > 0][through], red[through], blue[through]
    height, slope = records[:, 1].astype(float), prescription.sphere / prescription.abbe
    rise, side = ((blue - red)[:, axis] / -records[:, 6] for axis in (5, 4))
    clear = np.abs(height) > 1e-3
    tilt = 0.01 * prescription.prism / prescription.abbe
    np.testing.assert_allclose(rise[clear], tilt - height[clear] * slope, rtol=0.03)
    np.testing.assert_allclose(side, -records[:, 0] * slope, atol=0.03 * np.abs(rise).max())


SCENES = {
    "spectacles-minus": lambda: gallery.make("spectacles-minus"),
    "spectacles-plus": lambda: gallery.make("spectacles-plus"),
    "magnifier": lambda: gallery.make("magnifier"),
    "mirrored": lens_in_a_mirror,
}


@pytest.mark.parametrize("name", SCENES)
def test_each_colour_is_that_of_glass_with_its_index(name):
    """Bit for bit, textures' footprints too: no colour looks to where another goes."""
    scene = SCENES[name]()
    frame = drawn(scene, "raytrace")
    (glass,) = {mesh.material for mesh in scene.meshes if isinstance(mesh.material, Glass)}
    alone = [drawn(glass_changed(scene, index=n, abbe=None), "raytrace") for n in line_indices(glass.index, glass.abbe)]
    for channel, other in enumerate(alone):
        assert (frame.color[..., channel] == other.color[..., channel]).all()
    assert (alone[0].color != alone[2].color).any(axis=-1).mean() > 0.01
    # The seen buffers are the d line's.
    plain = drawn(scene, "raytrace:dispersion=false")
    assert (plain.color == alone[1].color).all()
    for buffer in SEEN:
        assert (getattr(frame, buffer) == getattr(alone[1], buffer)).all()
        assert (getattr(plain, buffer) == getattr(alone[1], buffer)).all()


def test_what_disperses_is_known_from_every_glass_on_the_way():
    scene = lens_in_a_mirror()
    frame, plain = drawn(scene, "raytrace"), drawn(scene, "raytrace:dispersion=false")
    apart = (frame.color != plain.color).any(axis=-1)
    assert (apart & (frame.specular == 1)).sum() > 50, "in the mirror too"
    assert (apart & (frame.specular == 2)).sum() > 50
    assert not apart[frame.specular == 0].any()
    assert (frame.color[..., 1] == plain.color[..., 1]).all()


@pytest.mark.parametrize("glass", [Glass(1.5), Glass(1.0, abbe=30.0)])
def test_where_nothing_disperses_nothing_is_traced_again(glass):
    scene = glass_changed(lens_in_a_mirror(), index=glass.index, abbe=glass.abbe)
    tracer = tracer_of(scene)
    records = drain(tracer.tracing(eye_rays(scene.camera, SIZE)))
    assert not tracer.disperses and not records.view(np.uint32)[:, 14].any()
    colors = drain(tracer.tracing_colors(eye_rays(scene.camera, SIZE), records))
    assert colors.shape == (2, 0, 16)
    frame, plain = drawn(scene, "raytrace"), drawn(scene, "raytrace:dispersion=false")
    assert (frame.color == plain.color).all()


def test_tiles_have_the_colours_of_the_whole_image():
    scene, shift = lens_in_a_mirror(), (0.25, -0.125)
    tracer = tracer_of(scene)
    whole = drain(tracer.tracing(eye_rays(scene.camera, SIZE, shift=shift)))
    met = whole.view(np.uint32)[:, 14].reshape(SIZE[::-1]).astype(bool)
    one = drain(tracer.tracing_colors(eye_rays(scene.camera, SIZE, shift=shift), whole))
    numbers = whole.view(np.uint32)[:, 14].reshape(SIZE[::-1])
    assert (numbers[met] == np.arange(1, met.sum() + 1)).all() and not numbers[~met].any()
    assert 200 < met.sum() < 0.9 * met.size and one.shape == (2, met.sum(), 16)
    corners = np.array([[x, y] for y in range(116, -1, -4) for x in range(0, 160, 8)])
    tiled = EyeRays(scene.camera, SIZE, corners, (8, 4), shift)
    records = drain(tracer.tracing(tiled))
    assert set(records.view(np.uint32)[:, 14]) == {0, 1}
    colors = drain(tracer.tracing_colors(tiled, records))
    own = records.view(np.uint32)[:, 14].reshape(-1, 4, 8)
    for (x, y), tile in zip(corners, own, strict=True):
        for row, column in np.argwhere(tile):
            expected = one[:, numbers[y + row, x + column] - 1]
            assert colors[:, tile[row, column] - 1].tobytes() == expected.tobytes()


def test_no_tiles_have_no_colours():
    scene = lens_in_a_mirror()
    tracer, none = tracer_of(scene), EyeRays(scene.camera, SIZE, np.zeros((0, 2), int), (4, 4))
    records = drain(tracer.tracing(none))
    assert drain(tracer.tracing_colors(none, records)).shape == (2, 0, 16)


def test_a_frame_without_dispersed_pixels_keeps_none_of_the_frame_before():
    scene = lens_in_a_mirror()
    away = replace(scene.camera, target=(0.25, 0.65, 5.0))
    session = open_view(scene, "raytrace")
    session.draw(scene.camera)
    session.draw(away)
    frame, plain = session.frame(seen=True), drawn(scene, "raytrace:dispersion=false", camera=away)
    assert (frame.color == plain.color).all() and (frame.specular == 0).all()


def test_each_line_of_the_spectrum_gives_its_own_colour_to_the_image():
    """By green's way alone all colours take it, also where others went their own ways before."""
    scene = lens_in_a_mirror()
    stage = Stage(View(scene, scene.camera, SIZE))
    stage.projection.write(camera_projection(scene.camera, SIZE), SIZE)
    tracer = PathTracer(scene, stage.geometry, Caster(stage.geometry))
    records = drain(tracer.tracing(eye_rays(scene.camera, SIZE)))
    colors = drain(tracer.tracing_colors(eye_rays(scene.camera, SIZE), records))
    whole = (0, 0, *SIZE)
    met = records.view(np.uint32)[:, 14].reshape(SIZE[::-1]) > 0
    visibility = VisibilityBuffer(stage.buffers, SIZE, lines=3)
    lines = [packed(records)]
    for color in colors:
        lines.append(lines[0].copy())
        lines[-1][:, met.ravel()] = packed(color)

    def image(green, *others):
        for number, line in enumerate((green, *others)):
            visibility.write(whole, line.reshape(2, *SIZE[::-1], 4), number)
        visibility.show(whole, 1 + len(others))
        target = make_target(SIZE, (COLOR_FORMAT,))
        encoder = get_device().create_command_encoder()
        render_pass = begin_pass(encoder, target)
        bind_scene(render_pass, stage.buffers, stage.projection)
        visibility.draw_color(render_pass)
        render_pass.end()
        submit(encoder)
        return read_texture(target.textures[0])[..., :3]

    green, red, blue = map(image, lines)
    together = image(*lines)
    assert (together == np.stack([red[..., 0], green[..., 1], blue[..., 2]], axis=-1)).all()
    assert (image(lines[0]) == green).all() and (together != green)[met].any()
    assert (together == green)[~met].mean() > 0.99, "but for the footprints beside what disperses"


def test_where_one_colour_is_totally_reflected_and_another_is_not():
    """At the end of a glass block the critical angle of blue is the smaller: a blue-less band, with finite colours."""
    scene = lens_in_a_mirror()
    tracer = tracer_of(scene)
    records = drain(tracer.tracing(eye_rays(scene.camera, SIZE)))
    red, blue = drain(tracer.tracing_colors(eye_rays(scene.camera, SIZE), records))
    status = [(colors.view(np.uint32)[:, 7] >> 16) & 0xFF for colors in (red, blue)]
    total = [each == Status.TOTAL_REFLECTION for each in status]
    assert (total[1] & ~total[0]).any()
    assert np.isfinite(drawn(scene, "raytrace").color).all()


def test_an_abbe_number_that_leaves_no_index_is_refused_in_one_line():
    with pytest.raises(AnamorphError, match=r"^glass: Abbe number 0.1 [^\n]*; give a larger one$"):
        line_indices(1.5, 0.1)
    with pytest.raises(AnamorphError, match=r"^glass: Abbe number"):
        line_indices(0.5, 0.1)
