"""What the viewer saves opens as the very same view, whatever the scene came from; what is wrong is named."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import door_mirror
import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from anamorph.base.errors import AnamorphError
from anamorph.editing.edit import Edit
from anamorph.files.opening import open_scene
from anamorph.files.scene_file import Settings
from anamorph.files.source import FaceChoice, Source
from anamorph.files.tables import Table
from anamorph.files.toml import toml_text
from anamorph.files.view_file import Opened, open_view, save_view
from anamorph.methods import Specification
from anamorph.scene.camera import Camera
from anamorph.scene.model import Scene
from anamorph.viewer.controls import edited, part_edits, scene_controls
from anamorph.viewer.saving import save_scene
from anamorph.viewer.state import Aspect, Drawing, EyeSide, Half, State, with_picked
from anamorph.viewer.view_table import state_of, values_of, view_of

SIZE = (640, 480)

coordinates = st.floats(-1e6, 1e6)
vectors = st.tuples(coordinates, coordinates, coordinates)
offsets = st.tuples(*[st.floats(0.5, 9.0)] * 3)
methods = st.sampled_from(("pervertex", "raytrace:bounces=3", "environment:face=64", "trilinear")).map(
    Specification.parse
)
shares = st.one_of(st.sampled_from((0.0, 1.0)), st.floats(0.0, 1.0))


@st.composite
def cameras(draw: st.DrawFn) -> Camera:
    position = draw(vectors)
    x, y, z = (at + away for at, away in zip(position, draw(offsets), strict=True))
    return Camera(position, (x, y, z), (0.0, draw(st.sampled_from((1.0, 2.0**-30))), 0.0), draw(st.floats(0.01, 179.0)))


def looked(state: State, picked: tuple[float, float] | None, outside: bool) -> State:
    """Looked into by who looks, or by the eye alone."""
    return with_picked(state, picked) if outside else replace(state, picked=picked)


states = st.builds(
    lambda picked, outside, **others: looked(State(**others), picked, outside),
    camera=cameras(),
    first=st.builds(Half, methods, st.sampled_from(Aspect)),
    second=st.builds(Half, methods, st.sampled_from(Aspect)),
    split=st.booleans(),
    divider=shares,
    eye=st.sampled_from(EyeSide),
    observer=st.none() | cameras(),
    unit=st.sampled_from(("mrad", "px")),
    drawings=st.frozensets(st.sampled_from(Drawing)),
    samples=st.integers(1, 32),
    resolution=st.floats(0.0, 4.0),
    panel=st.booleans(),
    help=st.booleans(),
    picked=st.none() | st.tuples(shares, shares),
    outside=st.booleans(),
    views=st.lists(cameras(), max_size=3).map(tuple),
)

values_of_toml = st.recursive(
    st.booleans() | st.integers(-(2**60), 2**60) | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(st.characters(exclude_categories=["Cs"])),
    lambda inner: st.lists(inner, max_size=3),
    max_leaves=5,
)  # fmt: skip
keys = st.from_regex(r"[A-Za-z_][A-Za-z0-9_-]{0,8}", fullmatch=True)


def same(one: Scene, other: Scene) -> bool:
    """Whether two scenes hold the same numbers in all that is drawn."""
    arrays = [
        (getattr(a, name), getattr(b, name))
        for a, b in zip(one.meshes, other.meshes, strict=True)
        for name in ("positions", "faces", "normals", "texcoords", "colors", "parameters")
    ]
    named = [(a.name, a.specular, type(a.surface)) for a in one.meshes]
    return named == [(b.name, b.specular, type(b.surface)) for b in other.meshes] and all(
        (a is None and b is None) or np.array_equal(a, b) for a, b in arrays
    )


@given(st.dictionaries(keys, values_of_toml | st.dictionaries(keys, values_of_toml) | st.just([{"a": 1}, {"b": "x"}])))
@example({"a": '"\\\x7f\x00é\n', "b": {"c": 5e-324}, "d": [{"e": {"f": [1.0, -0.0]}}, {}]})
def test_toml_is_read_back_as_it_was_given(values: dict[str, Any]) -> None:
    assert repr(tomllib.loads(toml_text(values))) == repr(values) or tomllib.loads(toml_text(values)) == values


@pytest.mark.parametrize("value", [np.inf, np.nan, "\ud800"])
def test_what_toml_cannot_say_is_refused_in_one_line(value: Any) -> None:
    with pytest.raises(AnamorphError, match=r"^key: [^\n]*$"):
        toml_text({"key": value})


@given(states)
def test_a_state_survives_its_table(state: State) -> None:
    read = tomllib.loads(toml_text({"view": view_of(state)}))["view"]
    table = Table(Path("view.toml"), ("view",), read, {})
    opened = Opened(builtin_scene("flat-mirror"), Settings(SIZE, str(state.first.method), table), state.camera)
    assert state_of(opened) == state


SCENES: dict[str, Scene] = {}


def builtin_scene(name: str) -> Scene:
    if name not in SCENES:
        SCENES[name] = open_scene(name)[0]
    return SCENES[name]


@given(st.data())
@settings(max_examples=10, suppress_health_check=[HealthCheck.function_scoped_fixture])
@pytest.mark.parametrize("name", ["flat-mirror", "spectacles-minus"])
def test_a_saved_view_opens_the_same_and_draws_the_same(tmp_path: Path, name: str, data: st.DataObject) -> None:
    scene = builtin_scene(name)
    # Small turns and moves, so that the eye stays before its mirror; a third of all stay as they are.
    values = {
        control.key: value
        for control in scene_controls(scene)
        if (value := data.draw(st.none() | st.floats(0.0, 1.0), label=control.key)) is not None
    }
    values = {key: spread(scene, key, share) for key, share in values.items()}
    values = {key: value for key, value in values.items() if value != 0.0 or "/curvature" in key}
    state = replace(data.draw(states), camera=scene.camera, values=values)
    opened = Opened(scene, Settings(), scene.camera, source=Source(name))
    save_scene(tmp_path / "view.toml", opened, state, SIZE)

    again = open_view(tmp_path / "view.toml")
    assert again.settings.size == SIZE and again.source == Source(name)
    assert same(again.scene, scene)
    restored = state_of(again)
    assert restored.values == pytest.approx(values, rel=1e-15)
    assert replace(restored, values={}) == replace(state, values={})
    # To the last bit, in the viewer and to every other command.
    assert part_edits(scene, restored.values) == part_edits(scene, values) == dict(again.edits)
    drawn, drawn_settings = open_scene(tmp_path / "view.toml")
    assert same(drawn, edited(scene, values)) and drawn.camera == state.camera
    assert (drawn.name, drawn_settings.method) == (scene.name, str(state.first.method))
    assert [mesh.material.__dict__ for mesh in drawn.meshes if mesh.specular] == [
        mesh.material.__dict__ for mesh in edited(scene, values).meshes if mesh.specular
    ]


def spread(scene: Scene, key: str, share: float) -> float:
    control = next(control for control in scene_controls(scene) if control.key == key)
    if control.unit in ("°", "mm"):
        return (share - 0.5) * min(control.high, 20.0) / 4.0
    return control.default + (share - 0.5) * 0.2 * (control.high - control.default)


@given(st.floats(-1e4, 1e4).filter(lambda value: value == 0 or abs(value) > 1e-300))
@example(0.1)
@example(1.9999999999)
def test_millimetres_come_back_from_metres(value: float) -> None:
    (found,) = values_of({"a": Edit(move=(1e-3 * value, 0.0, 0.0))}).values() or (0.0,)
    assert 1e-3 * found == 1e-3 * value and found == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("value", [0.1, 2.5, -37.0, 0.07, 12.3, 1999.9])
def test_round_millimetres_come_back_round(value: float) -> None:
    assert values_of({"a": Edit(move=(0.0, 1e-3 * value, 0.0))}) == {"a/up": value}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    trimesh.creation.box((0.2, 0.4, 0.1)).export(tmp_path / "box [1].glb")
    (tmp_path / "views").mkdir()
    (tmp_path / "room.toml").write_text(
        'builtin = "spheres"\nsize = [30, 20]\n[[part]]\nname = "*"\nturn = [5, 0, 0]\n'
    )
    return tmp_path


def saved_and_opened(folder: Path, opened: Opened, values: dict[str, float]) -> Opened:
    state = replace(state_of(opened), values=values)
    save_scene(folder / "views" / "view.toml", opened, state, SIZE)
    again = open_view(folder / "views" / "view.toml")
    assert same(again.scene, opened.scene) and again.scene.name == opened.scene.name
    assert again.camera == opened.camera and values_of(again.edits) == values
    assert same(open_scene(folder / "views" / "view.toml")[0], edited(opened.scene, values))
    return again


def test_a_view_of_a_model_file_names_it_from_where_the_view_is(folder: Path) -> None:
    again = saved_and_opened(folder, open_view(folder / "box [1].glb"), {"mirror/swivel": 3.0})
    assert "../box [1].glb" in (folder / "views" / "view.toml").read_text()
    assert again.source is not None and Path(again.source.name).resolve() == (folder / "box [1].glb").resolve()


def test_a_view_of_a_scene_file_keeps_that_files_own_changes_once(folder: Path) -> None:
    opened = open_view(folder / "room.toml")
    assert not opened.edits and opened.settings.size == (30, 20)
    first = saved_and_opened(folder, opened, {"mirror-ball/up": 2.5})
    # A view of a view starts from what the first started from.
    again = saved_and_opened(folder, first, {"mirror-ball/up": 2.5, "mirror-ball/reflectance": 0.5})
    assert again.source is not None and Path(again.source.name).name == "room.toml"


def test_a_view_of_a_cad_mirror_in_a_scenes_place_keeps_its_choice(folder: Path) -> None:
    pytest.importorskip("OCP", exc_type=ImportError)
    opened = open_view(door_mirror.FILE, FaceChoice((1,), 6, False), "flat-mirror")
    again = saved_and_opened(folder, opened, {})
    assert again.source is not None
    assert (again.source.choice, again.source.mirror_of) == (FaceChoice((1,), 6, False), "flat-mirror")


def test_a_scene_whose_mirror_gives_way_may_be_a_file(folder: Path) -> None:
    scene = builtin_scene("flat-mirror")
    source = Source(folder / "box.step", FaceChoice(("glass*", 2), 7, True), folder / "room.toml")
    save_view(folder / "views" / "v.toml", Opened(scene, Settings(), scene.camera, {}, source), scene.camera, SIZE,
              "pervertex", {}, {})  # fmt: skip
    read = tomllib.loads((folder / "views" / "v.toml").read_text())
    assert (read["base"], read["mirror_of"]) == ("../box.step", "../room.toml")
    assert (read["faces"], read["density"], read["flip"]) == (["glass*", 2], 7, True)


def test_a_scene_made_in_python_cannot_be_named(tmp_path: Path) -> None:
    scene = builtin_scene("flat-mirror")
    opened = Opened(scene, Settings(), scene.camera)
    with pytest.raises(AnamorphError, match=r"^scene 'flat-mirror' was made in Python[^\n]*save the image[^\n]*$"):
        save_scene(tmp_path / "view.toml", opened, state_of(opened), SIZE)
    assert not list(tmp_path.iterdir())


def test_a_view_that_would_not_open_is_not_saved(tmp_path: Path) -> None:
    opened = open_view("flat-mirror")
    x, y, z = np.subtract(2.0 * np.array(opened.camera.target), opened.camera.position).tolist()
    behind = replace(opened.camera, position=(x, y, z))
    for camera in (behind, replace(opened.camera, target=opened.camera.position)):
        with pytest.raises(AnamorphError):
            save_scene(tmp_path / "view.toml", opened, replace(state_of(opened), camera=camera), SIZE)
    assert not list(tmp_path.iterdir())


def test_a_part_of_any_name_is_meant_by_its_own_name_alone(tmp_path: Path) -> None:
    scene = builtin_scene("flat-mirror")
    opened = Opened(scene, Settings(), scene.camera, source=Source("flat-mirror"))
    save_view(tmp_path / "v.toml", opened, scene.camera, SIZE, "pervertex", {'a[*]?\\"b': Edit((1.0, 0.0, 0.0))}, {})
    part = tomllib.loads((tmp_path / "v.toml").read_text())["part"][0]
    assert part == {"name": 'a[[][*]][?]\\"b', "turn": [1.0, 0.0, 0.0]}


VIEW = 'builtin = "flat-mirror"\n[[part]]\nname = "mirror"\nturn = [1, 0, 0]\n[view]\n'


def test_a_file_that_does_more_than_keep_a_view_opens_with_its_changes_made(tmp_path: Path) -> None:
    for text in (
        VIEW.replace("turn = [1, 0, 0]", "turn = [1, 0, 0]\nreflectance = 0.5\nrotate = [0, 0, 0]"),
        VIEW.replace('"mirror"', '"mirr*"'),
        VIEW.replace("[view]", '[[part]]\nname = "mirror"\nmove = [0, 0, 0]\n[view]'),
        VIEW.replace("[view]", "[view]\nsplit = true\n[sky]"),
        VIEW.replace("[view]", ""),
    ):
        (tmp_path / "view.toml").write_text(text)
        opened = open_view(tmp_path / "view.toml")
        assert not opened.edits and same(opened.scene, open_scene(tmp_path / "view.toml")[0])
        assert opened.source == Source(tmp_path / "view.toml")
        assert state_of(opened).split == ("split" in text)


def test_a_name_that_is_also_a_pattern_is_none_of_a_view(tmp_path: Path) -> None:
    renamed = 'builtin = "spheres"\n[[part]]\nname = "mirror-ball"\nrename = "mirror*"\n'
    (tmp_path / "base.toml").write_text(renamed)
    for pattern, parts in (("mirror*", set()), ("mirror[*]", {"mirror*"})):
        view = f'base = "base.toml"\n[[part]]\nname = "{pattern}"\nturn = [1, 0, 0]\n[view]\n'
        (tmp_path / "view.toml").write_text(view)
        assert set(open_view(tmp_path / "view.toml").edits) == parts


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        (VIEW + "splt = true\n", 6, ["unknown key 'splt'", "did you mean 'split'"]),
        (VIEW + "split = 1\n", 6, ["split is 1", "true or false"]),
        (VIEW + "divider = 1.5\n", 6, ["divider is 1.5", "from 0 to 1"]),
        (VIEW + "divider = nan\n", 6, ["divider", "a number"]),
        (VIEW + "eye = 'lft'\n", 6, ["'lft'", "did you mean 'left'"]),
        (VIEW + "aspect = 'erorr'\n", 6, ["'erorr'", "did you mean 'error'"]),
        (VIEW + "second_aspect = 3\n", 6, ["second_aspect is 3", "text"]),
        (VIEW + "second = 'pervertx'\n", 6, ["'pervertx'", "did you mean 'pervertex'"]),
        (VIEW + "unit = 'm'\n", 6, ["unit is 'm'", "mrad"]),
        (VIEW + "drawings = 'hits'\n", 6, ["drawings", "a list"]),
        (VIEW + "drawings = ['hits', 'hit']\n", 6, ["'hit'", "did you mean 'hits'"]),
        (VIEW + "samples = 0\n", 6, ["samples is 0", "from 1 to 32"]),
        (VIEW + "samples = 2.5\n", 6, ["samples is 2.5", "whole"]),
        (VIEW + "resolution = -1\n", 6, ["resolution is -1", "from 0 to 4"]),
        (VIEW + "panel = 'yes'\n", 6, ["panel", "true or false"]),
        (VIEW + "picked = [0.5]\n", 6, ["picked", "two shares"]),
        (VIEW + "picked = [0.5, 2]\n", 6, ["picked", "from 0 to 1"]),
        (VIEW + "picked = [nan, 0.5]\n", 6, ["picked", "from 0 to 1"]),
        (VIEW + "picked_outside = 1\n", 6, ["picked_outside is 1", "true or false"]),
        (VIEW + "picked_outside = true\n", 6, ["picked_outside needs picked", "leave picked_outside out"]),
        (VIEW + "picked = [0.5, 0.5]\npicked_outside = true\n", 7, ["picked_outside needs observer"]),
        (VIEW + "views = 3\n", 6, ["views is 3", "[[views]]"]),
        (VIEW + "views = [{ position = [0, 0, 1] }]\n", 6, ["views needs the key 'target'"]),
        (VIEW + "[[view.views]]\nposition = [0, 0, 1]\ntarget = [0, 0]\n", 8, ["target", "three numbers"]),
        (VIEW + "observer = 3\n", 6, ["observer", "[observer]"]),
        (VIEW + "observer = { position = [0, 0, 1] }\n", 6, ["observer needs the key 'target'"]),
        (VIEW.replace("[1, 0, 0]", "[1, 0]"), 4, ["turn", "three numbers"]),
        (VIEW.replace('"mirror"', '"miror"'), 3, ["'miror'", "did you mean 'mirror'"]),
        (VIEW.replace("[view]", "view = 3"), 5, ["unknown key 'view'"]),
        ("view = 3\n" + VIEW.replace("[view]", ""), 1, ["view", "[view]"]),
    ],
)
def test_a_mistake_in_a_view_is_named_with_its_line_and_key(
    tmp_path: Path, text: str, line: int, words: list[str]
) -> None:
    path = tmp_path / "view.toml"
    path.write_text(text)
    with pytest.raises(AnamorphError) as caught:
        state_of(open_view(path))
    message = str(caught.value)
    assert message.startswith(f"{path}, line {line}: ") and "\n" not in message, message
    assert all(word in message for word in words), message


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('base = "view.toml"\n', ["base", "starts from this file itself"]),
        ('base = "loop.toml"\n', ["starts from this file itself"]),
        ('base = "no.glb"\n', ["base names 'no.glb'", "check the name"]),
        ('base = "box.glb"\nbuiltin = "room"\n', ["keep one"]),
        ('base = "box.glb"\nfaces = [1]\n', ["faces is for a base that is a CAD file"]),
        ('base = "box.glb"\nmirror_of = "car-mirror"\n', ["mirror_of is for a base that is a CAD file"]),
        ('builtin = "room"\ndensity = 3\n', ["density is for a base that is a CAD file"]),
        ("base = 3\n", ["base is 3", "text"]),
        (
            'base = "box.glb"\n[view]\nobserver = { position = [0, 0, 0], target = [0, 0, 0] }',
            ["observer", "same point"],
        ),
        (
            'base = "box.glb"\n[view]\nviews = [{ position = [0, 0, 1], target = [0, 0, 0], up = [0, 0, 2] }]',
            ["number 1 of views", "along the view"],
        ),
        ('base = "box.glb"\n[eye]\nposition = [0, 0, 0]\ntarget = [0, 0, 0]\n[view]', ["eye", "same point"]),
    ],
)
def test_a_base_that_cannot_be_started_from_is_named(tmp_path: Path, text: str, words: list[str]) -> None:
    trimesh.creation.box((0.2, 0.4, 0.1)).export(tmp_path / "box.glb")
    (tmp_path / "loop.toml").write_text('base = "view.toml"\n')
    (tmp_path / "view.toml").write_text(text)
    with pytest.raises(AnamorphError) as caught:
        state_of(open_view(tmp_path / "view.toml"))
    assert str(tmp_path) in str(caught.value) and "\n" not in str(caught.value)
    assert all(word in str(caught.value) for word in words), str(caught.value)


DOCUMENT = Path(__file__).resolve().parents[2] / "docs" / "scene-file.md"


def test_the_documented_view_opens_and_every_key_is_documented(tmp_path: Path) -> None:
    text = DOCUMENT.read_text().split("## `[view]`")[1]
    (tmp_path / "view.toml").write_text(text.split("```toml\n")[1].split("```")[0])
    state = state_of(open_view(tmp_path / "view.toml"))
    assert (state.split, state.divider, state.values) == (True, 0.6, {"mirror/swivel": 3.0})
    observed = replace(state, observer=state.camera, picked=(0.5, 0.5), views=(state.camera,))
    assert [key for key in view_of(observed) if f"`{key}`" not in text] == []


def test_a_scene_is_drawn_as_its_base_wants_unless_it_says_otherwise(tmp_path: Path) -> None:
    (tmp_path / "base.toml").write_text('builtin = "flat-mirror"\nsize = [30, 20]\nmethod = "environment"\n')
    (tmp_path / "on.toml").write_text('base = "base.toml"\n')
    (tmp_path / "own.toml").write_text('base = "base.toml"\nsize = [8, 9]\nmethod = "raytrace"\n')
    assert open_scene(tmp_path / "on.toml")[1] == Settings((30, 20), "environment")
    assert open_scene(tmp_path / "own.toml")[1] == Settings((8, 9), "raytrace")
