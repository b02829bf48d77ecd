"""What stands on the viewer's canvas: coarse while things move, the very image of `render` at rest."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
import pytest
import wgpu
from hypothesis import given
from hypothesis import strategies as st

import anamorph as an
from anamorph.base.errors import AnamorphError
from anamorph.base.srgb import encode_srgb
from anamorph.gallery import make
from anamorph.gpu.device import get_device
from anamorph.gpu.targets import COLOR_FORMAT, make_texture, read_texture
from anamorph.gpu.timing import device_timer
from anamorph.methods import Specification
from anamorph.scene.model import Scene
from anamorph.viewer.compose import Average, Composer, FalseColorTexture, Shown
from anamorph.viewer.fluency import PATIENCE, RESOLUTIONS, SLOWEST, Fluency, scaled
from anamorph.viewer.method_images import MethodImages
from anamorph.viewer.showing import Showing, shifts
from anamorph.viewer.state import EYE_DISTANCE, Aspect, EyeSide, Half, State, looking_eye, shown_camera

SIZE = (96, 64)
STATE = State(
    make("flat-mirror").camera, Half(Specification.parse("pervertex")), Half(Specification.parse("raytrace")), samples=2
)


@pytest.fixture(scope="module")
def scene() -> Scene:
    return make("flat-mirror")


def linear_texture(colors: np.ndarray) -> wgpu.GPUTexture:
    """An image (H, W, 3) on the device."""
    height, width = colors.shape[:2]
    texture = get_device().create_texture(
        size=(width, height, 1),
        format=COLOR_FORMAT,
        usage=wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST,
    )
    full = np.concatenate([colors, np.ones((height, width, 1))], axis=-1).astype(np.float16)
    get_device().queue.write_texture(
        {"texture": texture}, full, {"bytes_per_row": 8 * width, "rows_per_image": height}, (width, height, 1)
    )
    return texture


def composed(
    halves: tuple[Shown, ...], size: tuple[int, int], divider: float = 0.5, corner: tuple[int, int] = (0, 0)
) -> np.ndarray:
    """The canvas (H, W, 3), 0 to 1 in sRGB."""
    left, top = corner
    target = make_texture((left + size[0], top + size[1]), COLOR_FORMAT)
    encoder = get_device().create_command_encoder()
    attachment = {
        "view": target.create_view(),
        "clear_value": (0, 0, 0, 1),
        "load_op": "clear",
        "store_op": "store",
    }
    render_pass = encoder.begin_render_pass(color_attachments=[attachment])
    Composer(COLOR_FORMAT).draw(render_pass, halves, (*corner, *size), divider)
    render_pass.end()
    get_device().queue.submit([encoder.finish()])
    return read_texture(target)[..., :3].astype(float)


def move(showing: Showing, scene: Scene, state: State) -> None:
    """Take notice of a state, and finish the image that it begins."""
    while showing.update(scene, state, SIZE) and showing.moving:
        pass


def settle(showing: Showing) -> None:
    while showing.rest():
        pass


@given(st.lists(st.floats(0.1, 1e5), max_size=60))
def test_the_resolution_stays_among_the_resolutions_and_follows_the_times(times: list[float]) -> None:
    fluency = Fluency()
    for milliseconds in times:
        after = fluency.after(milliseconds)
        assert 0 <= after.number < len(RESOLUTIONS)
        assert after.number <= fluency.number or milliseconds > SLOWEST
        assert after.number >= fluency.number or milliseconds < SLOWEST
        fluency = after


def test_one_slow_frame_is_forgiven_and_the_second_is_not() -> None:
    once = Fluency().after(2 * SLOWEST)
    assert once.resolution == 1.0
    assert once.after(2 * SLOWEST).resolution == 0.5
    assert once.after(0.9 * SLOWEST).after(2 * SLOWEST).resolution == 1.0
    slowest = Fluency()
    for _ in range(PATIENCE):
        slowest = slowest.after(1000 * SLOWEST)
    assert slowest.resolution == RESOLUTIONS[-1]


def test_a_finer_image_is_tried_only_where_it_should_be_fast_enough() -> None:
    assert Fluency(2).after(0.3 * SLOWEST).number == 1
    assert Fluency(2).after(0.5 * SLOWEST).number == 2


@given(st.integers(1, 4000), st.integers(1, 4000), st.sampled_from(RESOLUTIONS))
def test_no_image_vanishes(width: int, height: int, scale: float) -> None:
    assert min(scaled((width, height), scale)) >= 1
    assert scaled((width, height), 1.0) == (width, height)


@pytest.mark.parametrize("samples", [1, 2, 3, 4, 8])
def test_shifts_are_those_of_an_image_with_samples_and_each_beginning_is_balanced(samples: int) -> None:
    steps = (np.arange(samples) + 0.5) / samples - 0.5
    wanted = {(round(x, 9), round(y, 9)) for x in steps for y in steps} if samples > 1 else set()
    found = shifts(samples)
    assert {(round(x, 9), round(y, 9)) for x, y in found} == wanted and len(found) == len(wanted)
    for count in range(2, len(found) + 1, 2):
        assert np.abs(np.mean(found[:count], axis=0)).max() <= 0.5 / count + 1e-9


def test_eyes_are_apart_by_their_distance_and_look_at_one_point() -> None:
    left, right = (looking_eye(replace(STATE, eye=side)) for side in (EyeSide.LEFT, EyeSide.RIGHT))
    assert np.linalg.norm(np.subtract(left.position, right.position)) == pytest.approx(EYE_DISTANCE)
    assert np.subtract(right.position, left.position) @ STATE.camera.axes()[0] == pytest.approx(EYE_DISTANCE)
    assert left.target == right.target == STATE.camera.target
    outside = replace(STATE.camera, position=(3.0, 2.0, 1.0))
    assert shown_camera(replace(STATE, observer=outside, eye=EyeSide.LEFT)) == outside


def test_the_canvas_shows_each_half_in_its_place_as_srgb() -> None:
    rng = np.random.default_rng(5)
    first, second = rng.uniform(0.0, 1.2, (2, 8, 12, 3)).astype(np.float16)
    shown = (Shown(linear_texture(first)), Shown(linear_texture(second)))
    canvas = composed(shown, (12, 8), 1.0 / 3.0)
    wanted = encode_srgb(np.clip(np.where(np.arange(12)[:, None] < 4, first, second), 0.0, 1.0).astype(float))
    assert np.abs(canvas - wanted).max() < 1.0 / 255.0
    moved = composed(shown, (12, 8), 1.0 / 3.0, corner=(5, 3))
    assert np.array_equal(moved[3:, 5:], canvas) and not moved[:3].any() and not moved[:, :5].any()
    alone = composed(shown[:1], (12, 8), 0.25)
    assert np.abs(alone - encode_srgb(np.clip(first, 0.0, 1.0).astype(float))).max() < 1.0 / 255.0


def test_a_coarse_image_is_blended_and_a_false_color_image_is_not() -> None:
    black_white = np.zeros((1, 2, 3))
    black_white[:, 1] = 1.0
    image = composed((Shown(linear_texture(black_white)),), (16, 4))[0, :, 0]
    assert (np.diff(image) >= 0.0).all() and len(np.unique(image)) > 4
    false_color = FalseColorTexture()
    false_color.write(np.array([[[255, 0, 0, 255], [0, 0, 255, 255]]], np.uint8))
    colors = composed((Shown(linear_texture(black_white), false_color.texture),), (16, 4))
    assert (colors[:, :8] == (1, 0, 0)).all() and (colors[:, 8:] == (0, 0, 1)).all()


def test_a_half_without_an_image_is_black() -> None:
    white = Shown(linear_texture(np.ones((4, 4, 3))))
    canvas = composed((Shown(), white), (4, 4), 0.5)
    assert not canvas[:, :2].any() and (canvas[:, 2:] > 0.99).all()
    assert not composed((), (4, 4)).any()


def test_the_average_is_the_mean_of_its_images() -> None:
    images = np.random.default_rng(3).uniform(0.0, 4.0, (9, 5, 6, 3)).astype(np.float16)
    average = Average((6, 5))
    for image in images:
        average.add(linear_texture(image))
    mean = images.astype(float).mean(axis=0)
    assert np.abs(read_texture(average.texture)[..., :3] - mean).max() < 4.0 * 9 / 2048
    average.restart()
    average.add(linear_texture(images[0]))
    assert np.array_equal(read_texture(average.texture)[..., :3], images[0])


def test_at_rest_the_image_is_that_of_render(scene: Scene) -> None:
    showing = Showing()
    assert showing.update(scene, STATE, SIZE)
    assert not showing.update(scene, STATE, SIZE)
    settle(showing)
    assert showing.at_rest and showing.samples_done == 4
    shown = showing.halves[0].image
    assert shown is not None
    wanted = an.render(scene, "pervertex", size=SIZE, samples=2).color
    assert np.abs(read_texture(shown)[..., :3] - wanted).max() < 2e-3 * max(1.0, wanted.max())


@pytest.mark.parametrize("steps", [1, 3])
@pytest.mark.parametrize("change", [{"picked": (0.5, 0.5)}, {"samples": 3}, {"samples": 1}])
def test_no_sample_counts_twice_when_something_is_asked_for_meanwhile(
    scene: Scene, steps: int, change: dict[str, Any]
) -> None:
    showing = Showing()
    showing.update(scene, STATE, SIZE)
    for _ in range(steps):
        showing.rest()
    after = replace(STATE, **change)
    showing.update(scene, after, SIZE)
    settle(showing)
    assert showing.samples_done == (0 if after.samples == 1 else after.samples**2)
    shown = showing.halves[0].image
    assert shown is not None
    wanted = an.render(scene, "pervertex", size=SIZE, samples=after.samples).color
    assert np.abs(read_texture(shown)[..., :3] - wanted).max() < 2e-3 * max(1.0, wanted.max())


def test_while_it_moves_the_image_is_coarse_where_that_is_asked_for(scene: Scene) -> None:
    showing = Showing()
    showing.update(scene, replace(STATE, resolution=0.25), SIZE)
    assert showing.image == (24, 16) and not showing.at_rest
    settle(showing)
    assert showing.image == SIZE


def test_times_at_rest_are_those_of_the_last_image_that_moved_with_the_devices(scene: Scene) -> None:
    showing = Showing()
    state = State(
        scene.camera, Half(Specification.parse("pervertex")), Half(Specification.parse("raytrace")), samples=2
    )
    showing.update(scene, state, (48, 32))
    told = dict(showing.phases)
    assert told["prepare"] > 0.0 and ("device" in told) == (device_timer() is not None)
    settle(showing)
    assert dict(showing.phases) == told


def test_what_moves_starts_the_image_over_and_an_aspect_does_not(scene: Scene) -> None:
    showing = Showing()
    showing.update(scene, STATE, SIZE)
    settle(showing)
    before = showing.halves[0].image
    assert showing.update(scene, replace(STATE, first=replace(STATE.first, aspect=Aspect.STATUS)), SIZE)
    assert showing.at_rest and showing.halves[0].image is before
    settle(showing)
    false_color = showing.halves[0].false_color
    assert false_color is not None and false_color.size[:2] == SIZE
    nearer = replace(STATE.camera, field_of_view=30.0)
    showing.update(scene, replace(STATE, camera=nearer), SIZE)
    assert showing.samples_done == 0 and showing.halves[0].false_color is None


def test_errors_are_measured_while_it_moves_and_at_rest(scene: Scene) -> None:
    showing = Showing()
    state = replace(
        STATE,
        first=Half(Specification.parse("environment"), Aspect.ERROR),
        second=Half(Specification.parse("raytrace")),
        split=True,
    )
    move(showing, scene, state)
    assert showing.halves[0].false_color is not None and showing.halves[1].false_color is None
    settle(showing)
    worst = showing.measured[Specification.parse("environment")].figures.angular_mrad.max
    assert worst is not None and worst > 1.0
    assert showing.frames[Specification.parse("raytrace")].color.shape[:2] == SIZE[::-1]


def test_a_method_that_cannot_leaves_its_half_black_and_says_why(scene: Scene) -> None:
    showing = Showing()
    state = replace(STATE, split=True, second=Half(Specification.parse("pervertex:antialias=3")))
    showing.update(scene, state, SIZE)
    settle(showing)
    assert showing.halves[0].image is not None and showing.halves[1].image is None
    assert "antialias" in showing.failures[0] and len(showing.failures) == 1
    showing.update(scene, replace(state, second=Half(Specification.parse("raytrace"))), SIZE)
    assert not showing.failures and showing.halves[1].image is not None


class _Sized:
    """A method's session that draws only small images."""

    def __init__(self, size: tuple[int, int], widest: int) -> None:
        self.size, self._widest = size, widest
        self.texture = linear_texture(np.ones((size[1], size[0], 3)))

    def drawing(self, camera: an.Camera, shift: tuple[float, float] = (0.0, 0.0)) -> Generator[None, None, None]:
        if self.size[0] > self._widest:
            raise AnamorphError("too large")
        yield from ()

    def wait(self) -> None:
        pass

    def phases(self) -> dict[str, float]:
        return {}


def drawn_by(monkeypatch: pytest.MonkeyPatch, widest: int = 10**6, seconds: float = 0.0) -> list[tuple[int, int]]:
    """The sizes of the images that are drawn from now on, by a method with these limits and a clock of its own."""
    sizes: list[tuple[int, int]] = []

    def session(self: MethodImages, camera: an.Camera, size: tuple[int, int]) -> _Sized:
        sizes.append(size)
        return _Sized(size, widest)

    for module in ("base.steps", "viewer.showing"):
        monkeypatch.setattr(f"anamorph.{module}.perf_counter", lambda: seconds * len(sizes))
    monkeypatch.setattr(MethodImages, "session", session)
    return sizes


def test_an_unknown_method_begins_with_the_coarsest_image_and_a_known_one_does_not(scene, monkeypatch) -> None:
    sizes = drawn_by(monkeypatch)
    showing = Showing()
    for number in range(len(RESOLUTIONS)):
        moved = replace(STATE, camera=replace(STATE.camera, field_of_view=40.0 + number))
        showing.update(scene, moved, SIZE)
    assert sizes == [scaled(SIZE, scale) for scale in reversed(RESOLUTIONS)]
    showing.update(scene, replace(STATE, first=Half(Specification.parse("pervertex:bounces=2"))), SIZE)
    assert sizes[-1] == SIZE


def test_what_fails_finely_is_shown_coarsely_and_not_tried_again(scene, monkeypatch) -> None:
    sizes = drawn_by(monkeypatch, widest=SIZE[0] // 2)
    showing = Showing()
    showing.update(scene, STATE, SIZE)
    settle(showing)
    assert showing.failures == ("too large",)
    shown = showing.halves[0].image
    assert shown is not None and shown.size[:2] == scaled(SIZE, RESOLUTIONS[-1])
    assert sizes == [scaled(SIZE, RESOLUTIONS[-1]), SIZE]
    showing.update(scene, replace(STATE, camera=replace(STATE.camera, field_of_view=30.0)), SIZE)
    assert showing.failures == ()


def test_an_image_that_takes_long_comes_by_steps(scene, monkeypatch) -> None:
    monkeypatch.setattr("anamorph.viewer.showing.LONG", 1.0)
    sizes = drawn_by(monkeypatch, seconds=0.002)
    showing = Showing()
    showing.update(scene, replace(STATE, samples=1), SIZE)
    settle(showing)
    assert sizes == [scaled(SIZE, scale) for scale in reversed(RESOLUTIONS)]


class _Stepped(_Sized):
    """A method's session that draws in three steps, the last of which may fail."""

    drawn: ClassVar[list[an.Camera]] = []
    fails: ClassVar[bool] = False

    def __init__(self, size: tuple[int, int]) -> None:
        super().__init__(size, 10**6)

    def drawing(self, camera: an.Camera, shift: tuple[float, float] = (0.0, 0.0)) -> Generator[None, None, None]:
        yield
        yield
        if _Stepped.fails:
            raise AnamorphError("out of steps")
        _Stepped.drawn.append(camera)


@pytest.fixture
def stepped(monkeypatch: pytest.MonkeyPatch) -> list[an.Camera]:
    """A method that draws in steps, of which a frame has time for one; from where it has drawn."""
    sessions: dict[tuple[int, int], _Stepped] = {}

    def session(self: MethodImages, camera: an.Camera, size: tuple[int, int]) -> _Stepped:
        return sessions.setdefault(size, _Stepped(size))

    monkeypatch.setattr(MethodImages, "session", session)
    monkeypatch.setattr("anamorph.viewer.showing.FRAME", 0.0)
    monkeypatch.setattr(_Stepped, "fails", False)
    monkeypatch.setattr(_Stepped, "drawn", [])
    return _Stepped.drawn


def from_angle(degrees: float) -> State:
    return replace(STATE, camera=replace(STATE.camera, field_of_view=degrees))


def test_a_slow_image_is_drawn_over_several_frames_and_shown_when_it_is_done(scene, stepped) -> None:
    showing = Showing()
    move(showing, scene, from_angle(30.0))
    before = showing.halves[0].image
    assert before is not None and len(stepped) == 1
    other = replace(from_angle(40.0), first=Half(Specification.parse("environment")))
    assert showing.update(scene, other, SIZE) and showing.moving
    while showing.moving:
        assert showing.halves[0].image is before and len(stepped) == 1 and not showing.at_rest
        assert showing.update(scene, other, SIZE)
    assert [camera.field_of_view for camera in stepped] == [30.0, 40.0] and showing.halves[0].image is not None
    assert not showing.update(scene, other, SIZE)


def test_an_image_under_way_is_finished_and_then_the_newest_state_is_drawn(scene, stepped) -> None:
    showing = Showing()
    for degrees in (30.0, 31.0, 32.0):
        assert showing.update(scene, from_angle(degrees), SIZE)
    while showing.update(scene, from_angle(34.0), SIZE):
        # Whoever waits for this one is to ask for the next frame at once.
        assert showing.moving == (len(stepped) < 2)
    assert [camera.field_of_view for camera in stepped] == [30.0, 34.0]
    assert not showing.moving


def test_a_constant_drag_shows_images(scene, stepped) -> None:
    showing = Showing()
    for frame in range(40):
        showing.update(scene, from_angle(20.0 + frame), SIZE)
    assert len(stepped) >= 9


def test_a_stale_image_is_given_up_for_the_newest(scene, stepped, monkeypatch) -> None:
    monkeypatch.setattr("anamorph.viewer.showing.STALE", 0.0)
    showing = Showing()
    for degrees in (30.0, 31.0, 32.0):
        showing.update(scene, from_angle(degrees), SIZE)
    move(showing, scene, from_angle(32.0))
    assert [camera.field_of_view for camera in stepped] == [32.0]


def test_what_moves_nothing_waits_for_the_image_under_way(scene, stepped, monkeypatch) -> None:
    monkeypatch.setattr("anamorph.viewer.showing.STALE", 0.0)
    showing = Showing()
    showing.update(scene, STATE, SIZE)
    picked = replace(STATE, picked=(0.5, 0.5))
    move(showing, scene, picked)
    assert len(stepped) == 1 and not showing.moving


def test_refinement_is_left_at_once_when_something_moves(scene, stepped) -> None:
    showing = Showing()
    move(showing, scene, STATE)
    while showing.samples_done < 1:
        assert showing.rest()
    showing.rest()
    count = len(stepped)
    move(showing, scene, from_angle(30.0))
    assert len(stepped) == count + 1 and stepped[-1].field_of_view == 30.0
    settle(showing)
    assert showing.samples_done == 4 and {camera.field_of_view for camera in stepped[count:]} == {30.0}


@pytest.mark.parametrize("period", [7, 8, 9])
def test_no_sample_counts_for_one_half_alone_wherever_it_is_left(scene, stepped, monkeypatch, period) -> None:
    added: list[wgpu.GPUTexture] = []
    add = Average.add
    monkeypatch.setattr(Average, "add", lambda self, texture: (added.append(texture), add(self, texture)))
    showing = Showing()
    state = replace(STATE, split=True)
    move(showing, scene, state)
    for number in range(60):
        showing.rest()
        if number % period == 0:
            # What moves nothing begins the refinement anew from what is done.
            showing.update(scene, replace(state, unit=("px", "mrad")[number // period % 2]), SIZE)
    settle(showing)
    assert showing.samples_done == 4 and len(added) == 2 * 4


def test_a_failure_in_a_step_is_told_and_the_image_before_it_goes(scene, stepped) -> None:
    showing = Showing()
    move(showing, scene, STATE)
    _Stepped.fails = True
    showing.update(scene, from_angle(30.0), SIZE)
    assert not showing.failures
    move(showing, scene, from_angle(30.0))
    assert showing.failures == ("out of steps",) and showing.halves[0].image is None
    settle(showing)
    _Stepped.fails = False
    move(showing, scene, from_angle(31.0))
    assert not showing.failures and showing.halves[0].image is not None


def test_rest_finishes_what_is_under_way_first(scene, stepped) -> None:
    showing = Showing()
    showing.update(scene, STATE, SIZE)
    assert showing.moving and showing.rest() and not showing.at_rest
    settle(showing)
    assert showing.finished and showing.samples_done == 4 and not showing.moving


@pytest.mark.parametrize("method", ["raytrace", "trilinear"])
def test_at_rest_an_image_in_steps_is_that_of_render(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("anamorph.viewer.showing.FRAME", 0.0)
    mirrors = make("facing-mirrors")
    showing = Showing()
    state = State(mirrors.camera, Half(Specification.parse(method)), Half(Specification.parse("raytrace")), samples=2)
    showing.update(mirrors, replace(state, camera=replace(state.camera, field_of_view=30.0)), SIZE)
    move(showing, mirrors, state)
    settle(showing)
    shown = showing.halves[0].image
    assert shown is not None
    wanted = an.render(mirrors, method, size=SIZE, samples=2).color
    assert np.abs(read_texture(shown)[..., :3] - wanted).max() < 2e-3 * max(1.0, wanted.max())
