"""The viewer's controls: made from scene, eye and method, and each does what it says."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import flat_mirror, scene_with, spherical_mirror

from anamorph import gallery
from anamorph.base.errors import AnamorphError
from anamorph.editing.bending import bend_of
from anamorph.files.opening import open_scene
from anamorph.methods import METHODS, Method
from anamorph.methods.options import Limits, check_options, limits_of, option, summaries
from anamorph.scene.camera import Camera
from anamorph.scene.model import Scene
from anamorph.viewer.controls import (
    OptionControl,
    edited,
    eye_controls,
    option_controls,
    part_edits,
    reading,
    scene_controls,
    with_eye,
)

POSE = ["swivel", "tilt", "roll", "right", "up", "outward"]
NAMES = ["car-mirror", "spectacles-plus", "magnifier", "saddle", "room", "spheres", "flat-mirror", "torus"]
SCENES = {name: gallery.make(name) for name in NAMES}


@pytest.fixture(scope="module", autouse=True)
def scenes_made_once():
    """Making a scene takes longer than all that is done with it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(gallery, "make", SCENES.__getitem__)
        yield


def keys(scene: Scene) -> list[str]:
    return [control.key for control in scene_controls(scene)]


def test_each_specular_part_gets_the_controls_that_mean_something_of_it():
    def expected(part: str, *shapes: str) -> list[str]:
        return [f"{part}/{what}" for what in (*POSE, *shapes)]

    assert keys(SCENES["car-mirror"]) == expected("mirror", "curvature", "reflectance")
    assert keys(SCENES["spectacles-plus"]) == expected("lens", "power", "index")
    assert keys(SCENES["room"]) == expected("teapot", "reflectance")
    toroids = [expected(part, "curvature", "cross_curvature", "reflectance") for part in ("saddle", "cylinder")]
    assert keys(SCENES["saddle"]) == [*toroids[0], *toroids[1]]
    ball, flat = (
        expected("mirror-ball", "curvature", "reflectance"),
        expected("mirror-flat", "curvature", "reflectance"),
    )
    assert keys(SCENES["spheres"]) == [*ball, *flat]
    assert scene_controls(replace(scene_with(), meshes=scene_with().meshes[:2])) == ()


@pytest.mark.parametrize("name", SCENES)
def test_controls_have_units_limits_and_a_default_within(name):
    for control in scene_controls(SCENES[name]):
        assert control.low <= control.default <= control.high and control.low < control.high
        assert 0.0 < control.step <= (control.high - control.low) / 100.0
        group, _, what = control.key.rpartition("/")
        assert group == control.group
        assert control.label == ("back vertex power" if what == "power" else what.replace("_", " "))
        units = dict.fromkeys(POSE[:3], "°") | dict.fromkeys(POSE[3:], "mm") | {"power": "D"}
        assert control.unit == units.get(what, "1/m" if "curvature" in what else "")
        assert control.summary and "\n" not in control.summary


@pytest.mark.parametrize("name", SCENES)
def test_every_control_reaches_its_limits_and_leaves_the_rest_alone(name):
    scene = SCENES[name]
    for control in scene_controls(scene):
        assert edited(scene, {control.key: control.default}) is scene
        for value in (control.low, control.high):
            changed = edited(scene, {control.key: value})
            for old, new in zip(scene.meshes, changed.meshes, strict=True):
                own = old.name == control.group or old.name.startswith(f"{control.group}/")
                assert new is old or own
            assert changed is scene or any(a is not b for a, b in zip(scene.meshes, changed.meshes, strict=True))
            assert (changed is scene) == (value == control.default)
        settings = {other.key: other.default for other in scene_controls(changed)}
        if control.label not in POSE:
            assert settings[control.key] == pytest.approx(control.high, abs=1e-3)


def test_no_values_are_the_scene_itself_and_nothing_is_remembered():
    scene = SCENES["car-mirror"]
    assert edited(scene, {}) is scene
    values = {"mirror/swivel": 10.0, "mirror/curvature": 1.5}
    one = edited(scene, values)
    edited(scene, {"mirror/tilt": 30.0})
    again = edited(scene, dict(reversed(values.items())))
    for a, b in zip(one.meshes, again.meshes, strict=True):
        np.testing.assert_array_equal(a.positions, b.positions)


def test_moves_are_in_millimetres_and_turns_in_degrees():
    scene = scene_with(flat_mirror())
    mesh = edited(scene, {"mirror/outward": 250.0, "mirror/right": -30.0}).meshes[0]
    np.testing.assert_allclose(mesh.positions - scene.meshes[0].positions, [[-0.03, 0.0, 0.25]] * 4, atol=1e-6)
    normal = edited(scene, {"mirror/swivel": 30.0}).meshes[0].normals[0]
    np.testing.assert_allclose(normal, [0.5, 0.0, np.sqrt(0.75)], atol=1e-6)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"mirror/swivle": 1.0}, "no control 'mirror/swivle'; did you mean 'swivel'"),
        ({"miror/swivel": 1.0}, "no control 'miror/swivel'; did you mean 'mirror'"),
        ({"swivel": 1.0}, "no control 'swivel'"),
        ({"": 1.0}, "no control ''"),
        ({"mirror/power": 1.0}, "has no power"),
        ({"mirror/curvature": 1e4}, "out of reach"),
        ({"mirror/tilt": float("nan")}, "finite"),
        ({"box-1/tilt": 5.0}, "no control 'box-1/tilt'"),
    ],
)
def test_values_that_mean_nothing_are_one_line(values, words):
    with pytest.raises(AnamorphError, match=rf"^[^\n]*{words}[^\n]*$"):
        edited(scene_with(spherical_mirror()), values)


def test_a_curvature_is_read_as_a_radius():
    control = next(control for control in scene_controls(SCENES["car-mirror"]) if control.label == "curvature")
    told = [reading(control, value) for value in (0.8, -0.5, 0.0)]
    assert told == ["convex, R = 1.25 m", "concave, R = 2 m", "flat"]
    assert reading(scene_controls(SCENES["car-mirror"])[0], -12.5) == "-12.5 °"


EDITS = {
    "mirror": {"swivel": (-30.0, 30.0), "tilt": (-30.0, 30.0), "roll": (-45.0, 45.0), "right": (-200.0, 200.0),
               "up": (-200.0, 200.0), "outward": (-200.0, 200.0), "curvature": (-2.0, 2.0), "reflectance": (0.0, 1.0)},
    "lens": {"swivel": (-30.0, 30.0), "outward": (-5.0, 5.0), "power": (2.0, 10.0), "index": (1.5, 1.8)},
}  # fmt: skip


@settings(max_examples=25)
@given(st.data(), st.sampled_from([("car-mirror", "mirror"), ("spectacles-plus", "lens")]))
def test_what_is_set_is_what_a_scene_file_says_of_it(tmp_path_factory, data, of):
    name, part = of
    chosen = data.draw(st.sets(st.sampled_from(sorted(EDITS[part]))))
    values = {f"{part}/{what}": data.draw(st.floats(*EDITS[part][what]), label=what) for what in sorted(chosen)}
    wanted = edited(SCENES[name], values)
    lines = [f'builtin = "{name}"']
    for edit in part_edits(SCENES[name], values).values():
        said = {key: list(value) if isinstance(value, tuple) else value for key, value in vars(edit).items()}
        lines += [
            "[[part]]",
            f'name = "{part}"',
            *(f"{key} = {value!r}" for key, value in said.items() if value is not None),
        ]
    path = tmp_path_factory.mktemp("scene") / "scene.toml"
    path.write_text("\n".join(lines))
    try:
        scene, _ = open_scene(path)
    except AnamorphError as error:
        assert "behind the mirror" in str(error)
        return
    for one, other in zip(wanted.meshes, scene.meshes, strict=True):
        assert one.name == other.name
        np.testing.assert_array_equal(one.positions, other.positions)
        np.testing.assert_array_equal(one.normals, other.normals)
        assert vars(one.material) == vars(other.material)


def test_the_eye_is_moved_within_reach_and_keeps_looking_at_its_target():
    scene = SCENES["car-mirror"]
    far = replace(scene.camera, position=(99.0, 1.0, -70.0), field_of_view=0.5)
    for camera in (scene.camera, far):
        values = {
            **dict(zip(("eye/x", "eye/y", "eye/z"), camera.position, strict=True)),
            "eye/field_of_view": camera.field_of_view,
        }
        for control in eye_controls(camera, scene):
            assert control.low <= values[control.key] <= control.high
            assert with_eye(camera, control.key, values[control.key]) == camera
            assert control.low <= control.default <= control.high
    moved = with_eye(scene.camera, "eye/y", 1.5)
    assert moved.position == (scene.camera.position[0], 1.5, scene.camera.position[2])
    assert moved.target == scene.camera.target
    assert with_eye(scene.camera, "eye/field_of_view", 30.0).field_of_view == 30.0


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("eye/w", 1.0, "no control 'eye/w'"),
        ("eye/z", 0.0, "same point"),
        ("eye/x", float("nan"), "finite"),
        ("eye/field_of_view", 180.0, "between 0 and 180"),
    ],
)
def test_an_eye_that_sees_nothing_is_one_line(key, value, words):
    with pytest.raises(AnamorphError, match=rf"^[^\n]*{words}[^\n]*$"):
        with_eye(Camera((0.0, 1.0, 2.0), (0.0, 1.0, 0.0)), key, value)


@pytest.mark.parametrize("name", METHODS)
def test_every_option_of_a_method_has_a_control_that_says_what_it_means(name):
    method = METHODS[name]
    controls = option_controls(method)
    assert [control.name for control in controls] == list(vars(method.options()))
    for control in controls:
        assert control.summary and "\n" not in control.summary
        assert control.default == getattr(method.options(), control.name)
        if control.kind == "choice":
            assert control.default in control.choices
            for choice in control.choices:
                check_options(name, method.options(**{control.name: choice}))
        for limit in (control.low, control.high):
            if limit is not None:
                check_options(name, method.options(**{control.name: limit}))
        outside = {control.low: -1, control.high: 1}
        for limit, step in outside.items():
            if limit is not None:
                with pytest.raises(AnamorphError, match=rf"^{name}: {control.name} is [^\n]*; give a number[^\n]*$"):
                    check_options(name, replace(method.options(), **{control.name: limit + step}))


@dataclass(frozen=True)
class Later:
    """Options of a method that came later.

    Parameters
    ----------
    plain : float
        A number without
        limits.
    many, few : int
        Two at once.
    """

    plain: float = 0.5
    many: int = 3
    few: int = option(2, low=1, unit="pixels")
    word: str = "any"
    flag: bool = False
    odd: str = option("a", choices=("a", "b", "c"))


def test_a_method_that_comes_later_has_controls_too():
    method = Method("later", "one", "nobody", Later, lambda view, options: None)
    assert option_controls(method) == (
        OptionControl("plain", "number", 0.5, (), None, None, "", "A number without limits."),
        OptionControl("many", "whole", 3, (), None, None, "", "Two at once."),
        OptionControl("few", "whole", 2, (), 1, None, "pixels", "Two at once."),
        OptionControl("word", "word", "any", (), None, None, "", ""),
        OptionControl("flag", "flag", False, (), None, None, "", ""),
        OptionControl("odd", "choice", "a", ("a", "b", "c"), None, None, "", ""),
    )
    assert summaries(int) == {} or "plain" not in summaries(int)
    fields = Later.__dataclass_fields__
    assert limits_of(fields["plain"]) == Limits() and limits_of(fields["few"]) == Limits((), 1, None, "pixels")


@pytest.mark.parametrize(
    ("given_options", "said"),
    [
        ({"few": 0}, "later: few is 0; give a number of pixels from 1"),
        ({"odd": "d"}, "later: odd is 'd'; give a, b or c"),
        ({"plain": float("nan")}, "later: plain is nan; give a number"),
        ({"plain": float("inf")}, "later: plain is inf; give a number"),
        ({"few": float("inf")}, "later: few is inf; give a number of pixels from 1"),
    ],
)
def test_options_beyond_their_limits_are_named_with_what_may_be(given_options, said):
    with pytest.raises(AnamorphError) as caught:
        check_options("later", Later(**given_options))
    assert str(caught.value) == said
    check_options("later", Later())


def test_bending_by_a_control_is_what_the_control_says():
    scene = SCENES["flat-mirror"]
    changed = edited(scene, {"mirror/curvature": 0.3})
    mirror = next(mesh for mesh in changed.meshes if mesh.specular)
    assert bend_of(mirror).curvatures == pytest.approx((0.3,))
