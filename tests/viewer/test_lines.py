"""The line renderer against an image of the same lines made with numpy, and where lines run through the eye."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import wgpu
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from anamorph.base.srgb import encode_srgb
from anamorph.gpu.device import get_device
from anamorph.projection import camera_projection
from anamorph.scene.camera import Camera
from anamorph.viewer.lines import HALO, LineRenderer
from anamorph.viewer.marks import Marks, dot_marks, joined, line_marks

SIZE = (96, 64)
CAMERA = Camera((0.2, 0.1, 4.0), (0.0, 0.0, 0.0), field_of_view=40.0)
CLIP = camera_projection(CAMERA, SIZE).clip
GREY = (0.5, 0.5, 0.5)
ORANGE = (1.0, 0.4, 0.1, 1.0)
RIM_ALPHA = 0.5


@cache
def renderer(form: str, halo: bool) -> LineRenderer:
    return LineRenderer(form, halo)


def drawn(marks: Marks, halo: bool = False, form: str = "rgba8unorm", ratio: float = 1.0, clip=CLIP) -> np.ndarray:
    """What is drawn over grey, (H, W, 3) from 0 to 1."""
    device = get_device()
    usage = wgpu.TextureUsage.RENDER_ATTACHMENT | wgpu.TextureUsage.COPY_SRC
    texture = device.create_texture(size=(*SIZE, 1), format=form, usage=usage)
    encoder = device.create_command_encoder()
    attachment = {"view": texture.create_view(), "load_op": "clear", "store_op": "store", "clear_value": (*GREY, 1.0)}
    render_pass = encoder.begin_render_pass(color_attachments=[attachment])
    lines = renderer(form, halo)
    lines.upload(marks)
    lines.draw(render_pass, clip, SIZE, ratio)
    render_pass.end()
    device.queue.submit([encoder.finish()])
    layout = {"bytes_per_row": 4 * SIZE[0], "rows_per_image": SIZE[1]}
    data = device.queue.read_texture({"texture": texture}, layout, (*SIZE, 1))
    image = np.frombuffer(data, np.uint8).reshape(SIZE[1], SIZE[0], 4) / 255.0
    assert (image[..., 3] == 1.0).all()
    return image[..., :3]


def distances(ends: np.ndarray) -> np.ndarray:
    """How far each pixel's centre is from the image of a segment (2, 3), (H, W) pixels; infinite for none."""
    homogeneous = np.column_stack([ends, np.ones(2)]) @ CLIP.T
    heights = homogeneous[:, 3] - homogeneous[:, 2]
    if (heights < 0.0).all():
        return np.full(SIZE[::-1], np.inf)
    first, second = homogeneous
    if heights[0] < 0.0:
        first = first + heights[0] / (heights[0] - heights[1]) * (second - first)
    if heights[1] < 0.0:
        second = second + heights[1] / (heights[1] - heights[0]) * (first - second)
    a, b = ((point[:2] / point[3] * [0.5, -0.5] + 0.5) * SIZE for point in (first, second))
    x, y = np.meshgrid(np.arange(SIZE[0]) + 0.5, np.arange(SIZE[1]) + 0.5)
    offset, way = np.stack([x, y], axis=-1) - a, b - a
    share = np.clip(offset @ way / max(way @ way, 1e-30), 0.0, 1.0)
    return np.linalg.norm(offset - share[..., None] * way, axis=-1)


def expected(ends, color, width: float, rim: float = 0.0) -> np.ndarray:
    """One line over grey, with a rim or without."""
    away, alpha = distances(np.asarray(ends, float)), color[3] * min(width, 1.0)
    radius = max(0.5 * width, 0.5)
    core = np.clip(radius + 0.5 - away, 0.0, 1.0) * alpha
    dark = np.clip(radius + 0.5 + rim - away, 0.0, 1.0) * RIM_ALPHA * alpha**2 * (rim > 0.0)
    under = np.array(GREY) * (1.0 - dark * (1.0 - core) - core)[..., None]
    return under + core[..., None] * encode_srgb(np.array(color[:3]))


LINES = {
    "level": [[-0.8, 0.3, 0.0], [0.7, 0.3, 0.0]],
    "oblique": [[-0.9, -0.7, 0.5], [0.8, 0.5, -1.0]],
    "beyond the image": [[-40.0, 0.2, -3.0], [60.0, -1.0, -3.0]],
    "from behind the eye": [[0.5, 0.4, 9.0], [-0.4, -0.3, -2.0]],
    "from beside the eye": [[0.7, 0.1, 4.0], [-0.4, -0.3, -2.0]],
    "from in front to far behind": [[0.3, -0.2, 1.0], [5.0, 3.0, 400.0]],
    "a point": [[0.3, 0.2, 0.0], [0.3, 0.2, 0.0]],
    "far away": [[-300.0, -200.0, -1000.0], [200.0, 150.0, -1000.0]],
    "outside": [[10.0, 0.0, 0.0], [10.0, 5.0, 0.0]],
    "behind": [[0.3, 0.2, 5.0], [-0.4, -0.3, 9.0]],
}


@pytest.mark.parametrize("halo", [False, True])
@pytest.mark.parametrize(("width", "alpha"), [(0.4, 1.0), (1.2, 0.8), (5.0, 0.6)])
@pytest.mark.parametrize("ends", LINES.values(), ids=LINES)
def test_a_line_is_where_numpy_draws_it(ends, width, alpha, halo):
    color = (*ORANGE[:3], alpha)
    image = drawn(line_marks([ends], color, width), halo)
    assert image == pytest.approx(expected(ends, color, width, HALO if halo else 0.0), abs=0.012)


def test_the_numpy_lines_are_in_the_image_but_for_those_that_cannot_be():
    empty = {name for name, ends in LINES.items() if (expected(ends, ORANGE, 3.0) == GREY).all()}
    assert empty == {"outside", "behind"}


def test_a_dot_is_a_disc_and_stands_over_lines():
    place = [0.3, 0.2, 0.0]
    dot = dot_marks([place], (0.0, 0.2, 1.0, 1.0), 4.0)
    assert drawn(dot) == pytest.approx(expected([place, place], (0.0, 0.2, 1.0, 1.0), 8.0), abs=0.012)
    line = line_marks([[[-5.0, 0.2, 0.0], [5.0, 0.2, 0.0]]], ORANGE, 3.0)
    inside = distances(np.array([place, place])) < 3.0
    for order in ([line, dot], [dot, line]):
        assert (drawn(joined(order))[inside] == encode_srgb(np.array([0.0, 0.2, 1.0])).round(2)).mean() > 0.3
        assert drawn(joined(order))[inside] == pytest.approx(drawn(dot)[inside], abs=0.01)


def test_later_lines_cover_earlier_ones():
    ends = [[[-0.8, 0.0, 0.0], [0.8, 0.0, 0.0]]]
    red, blue = line_marks(ends, (1.0, 0.0, 0.0, 1.0), 6.0), line_marks(ends, (0.0, 0.0, 1.0, 1.0), 6.0)
    assert drawn(joined([red, blue]))[32, 46] == pytest.approx([0.0, 0.0, 1.0])
    assert drawn(joined([blue, red]))[32, 46] == pytest.approx([1.0, 0.0, 0.0])
    nearer = line_marks(np.add(ends, (0.0, 0.0, 1.0)), (1.0, 0.0, 0.0, 1.0), 6.0)
    assert drawn(joined([nearer, blue]))[32, 46] == pytest.approx([0.0, 0.0, 1.0]), "nothing hides a line"


def test_widths_are_logical_pixels():
    ends = LINES["oblique"]
    assert drawn(line_marks([ends], ORANGE, 2.0), ratio=2.0) == pytest.approx(expected(ends, ORANGE, 4.0), abs=0.012)


@pytest.mark.parametrize("form", ["rgba8unorm", "rgba8unorm-srgb"])
def test_colours_are_linear_whatever_the_target_holds(form):
    place = [0.2, 0.1, 0.0]
    image = drawn(dot_marks([place], (0.2, 0.02, 0.7, 1.0), 8.0), form=form)
    middle = distances(np.array([place, place])) < 5.0
    assert image[middle] == pytest.approx(
        np.tile(encode_srgb(np.array([0.2, 0.02, 0.7])), (middle.sum(), 1)), abs=0.005
    )


def test_once_warm_nothing_is_created(monkeypatch):
    many = line_marks(np.random.default_rng(1).uniform(-1, 1, (50, 2, 3)), ORANGE, 1.0)
    drawn(many)
    lines, device = renderer("rgba8unorm", False), get_device()

    def refused(*arguments, **named):
        raise AssertionError("something is created while drawing")

    for name in ("create_buffer", "create_bind_group", "create_render_pipeline", "create_shader_module"):
        monkeypatch.setattr(device, name, refused)
    for count in (50, 3, 0, 17):
        lines.upload(line_marks(many.segments.ends[:count], ORANGE))


def test_what_is_uploaded_replaces_what_was_there():
    drawn(line_marks([LINES["level"]] * 40, ORANGE, 4.0))
    assert drawn(line_marks([LINES["oblique"]], ORANGE, 2.0)) == pytest.approx(
        expected(LINES["oblique"], ORANGE, 2.0), abs=0.012
    )
    assert (drawn(joined([])) == drawn(line_marks(np.zeros((0, 2, 3)), ORANGE))).all()
    assert drawn(joined([])) == pytest.approx(np.broadcast_to(GREY, (*SIZE[::-1], 3)), abs=0.003)


EYE, FORWARD = np.array(CAMERA.position), CAMERA.axes()[2]
near = st.floats(-3.0, 3.0)
points = st.tuples(near, near, st.floats(-6.0, 8.0)).map(np.array)
behind = st.tuples(near, near, st.floats(0.01, 50.0)).map(
    lambda parts: EYE + np.array(parts[:2]) @ CAMERA.axes()[:2] - parts[2] * FORWARD
)


@settings(max_examples=60)
@given(first=st.one_of(points, behind), second=st.one_of(points, behind), width=st.floats(0.1, 12.0))
def test_any_line_is_where_numpy_draws_it(first, second, width):
    ends = np.array([first, second]).astype(np.float32).astype(float)
    # A line that passes the eye closely has an image that float32 cannot place.
    way = ends[1] - ends[0]
    share = np.clip((EYE - ends[0]) @ way / max(way @ way, 1e-12), 0.0, 1.0)
    assume(np.linalg.norm(ends[0] + share * way - EYE) > 0.05)
    image, wanted = drawn(line_marks([ends], ORANGE, width)), expected(ends, ORANGE, width)
    assert np.abs(image - wanted).max() < 0.06


@settings(max_examples=25)
@given(first=behind, second=behind)
def test_nothing_behind_the_eye_is_drawn(first, second):
    marks = joined([line_marks([[first, second]], ORANGE, 9.0), dot_marks([first, second], ORANGE, 20.0)])
    assert drawn(marks) == pytest.approx(np.broadcast_to(GREY, (*SIZE[::-1], 3)), abs=0.003)


@settings(max_examples=25)
@given(eye=st.tuples(near, near, near), scale=st.sampled_from([0.01, 1.0, 300.0]), width=st.floats(0.1, 12.0))
@example(eye=(0.0, 0.0, 0.0), scale=1.0, width=1.0)
@example(eye=(1.0, -2.0, 0.3), scale=300.0, width=9.0)
def test_what_stands_in_the_eye_itself_is_not_drawn(eye, scale, width):
    x, y, z = (scale * value for value in eye)
    camera = Camera((x, y, z), (x + 0.3, y - 0.2, z - 1.0))
    marks = joined([dot_marks([camera.position], ORANGE, 6.0), line_marks([[camera.position] * 2], ORANGE, width)])
    image = drawn(marks, clip=camera_projection(camera, SIZE).clip)
    assert image == pytest.approx(np.broadcast_to(GREY, (*SIZE[::-1], 3)), abs=0.003)


@settings(max_examples=40)
@given(first=points, share=st.sampled_from([0.0, 0.5, 1.0]), width=st.floats(0.1, 6.0))
def test_a_line_through_the_eye_shows_at_least_its_point(first, share, width):
    """What rounding adds to that point cannot be foretold."""
    depth = (first - EYE) @ FORWARD
    assume(abs(depth) > 0.2)
    image = drawn(line_marks([np.array([first, EYE + share * (EYE - first)])], ORANGE, width))
    if depth > 0.0:
        core = distances(np.array([first, first])) <= max(0.5 * width, 0.5) - 0.5
        assert (np.abs(image - GREY).max(axis=2)[core] > 0.02).all()
