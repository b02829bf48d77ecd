"""CAD files: exact faces, in metres, on the right side, and trimmed; written by the tests through OpenCASCADE."""

from __future__ import annotations

import math
import sys

import door_mirror
import numpy as np
import pytest
from OCP.BRep import BRep_Builder
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_Transform
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder, BRepPrimAPI_MakeSphere, BRepPrimAPI_MakeTorus
from OCP.Geom import Geom_SphericalSurface
from OCP.GeomConvert import GeomConvert
from OCP.gp import gp_Ax1, gp_Ax2, gp_Ax3, gp_Dir, gp_Pnt, gp_Trsf, gp_Vec
from OCP.IGESControl import IGESControl_Controller, IGESControl_Writer
from OCP.Interface import Interface_Static
from OCP.Message import Message
from OCP.STEPControl import STEPControl_AsIs, STEPControl_Writer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS_Shell

from anamorph import gallery
from anamorph.base.errors import AnamorphError
from anamorph.base.steps import drain
from anamorph.cli.commands import main
from anamorph.files import cad
from anamorph.files.cad import choose, load_cad, read_cad
from anamorph.files.models import load_parts
from anamorph.files.opening import open_scene
from anamorph.files.source import FaceChoice
from anamorph.methods.tracing.launch import eye_rays
from anamorph.methods.tracing.paths import PathTracer
from anamorph.rays.caster import Caster
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Diffuse

FORMATS = ("step", "igs")
LEAST_ANGLE = 2.0
"""Degrees."""


def save(shape, path, unit="MM"):
    """Write a shape whose lengths are millimetres, in a unit of the file."""
    Message.DefaultMessenger_s().ChangePrinters().Clear()
    if path.suffix == ".step":
        Interface_Static.SetCVal_s("write.step.unit", unit)
        writer = STEPControl_Writer()
        writer.Transfer(shape, STEPControl_AsIs)
    else:
        IGESControl_Controller.Init_s()
        writer = IGESControl_Writer("IN" if unit == "INCH" else "MM", 1)
        writer.AddShape(shape)
        writer.ComputeModel()
    writer.Write(str(path))
    Interface_Static.SetCVal_s("write.step.unit", "MM")
    return path


def exact(mesh):
    """Positions and normals of the surface at the vertices; the mesh's own must be these, rounded."""
    positions, normals = mesh.surface.position(mesh.parameters), mesh.surface.normal(mesh.parameters)
    np.testing.assert_allclose(mesh.positions, positions, atol=2.5e-7)
    np.testing.assert_allclose(mesh.normals, normals, atol=2.5e-7)
    corners = positions[mesh.faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.sum(across * normals[mesh.faces].sum(axis=1), axis=1) > 0).all()
    return positions, normals


def volume_and_area(meshes):
    volume = area = 0.0
    for mesh in meshes:
        corners = exact(mesh)[0][mesh.faces]
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        volume += np.sum(corners[:, 0] * across) / 6.0
        area += np.linalg.norm(across, axis=1).sum() / 2.0
    return volume, area


@pytest.mark.parametrize("kind", FORMATS)
@pytest.mark.parametrize("unit", ["MM", "INCH"])
def test_a_sphere_is_exact_in_metres_whatever_the_unit(tmp_path, kind, unit):
    path = save(BRepPrimAPI_MakeSphere(gp_Pnt(10, 20, 30), 254.0).Shape(), tmp_path / f"ball.{kind}", unit)
    (mesh,) = load_cad(path)
    positions, normals = exact(mesh)
    outward = (positions - [0.01, 0.02, 0.03]) / 0.254
    np.testing.assert_allclose(np.linalg.norm(outward, axis=1), 1.0, atol=1e-9)
    np.testing.assert_allclose(normals, outward, atol=1e-8)
    np.testing.assert_allclose(mesh.surface.curvatures(mesh.parameters), 1.0 / 0.254, rtol=1e-6)
    assert volume_and_area([mesh])[0] == pytest.approx(4 / 3 * math.pi * 0.254**3, rel=0.03)


@pytest.mark.parametrize("kind", FORMATS)
def test_a_torus_is_exact_and_closed(tmp_path, kind):
    path = save(BRepPrimAPI_MakeTorus(20.0, 5.0).Shape(), tmp_path / f"ring.{kind}")
    meshes = load_cad(path, FaceChoice(density=64))
    for mesh in meshes:
        positions, _ = exact(mesh)
        distance = np.hypot(positions[:, 0], positions[:, 1])
        np.testing.assert_allclose(np.hypot(distance - 0.02, positions[:, 2]), 0.005, atol=1e-11)
        around = (distance - 0.02) / 0.005 / distance
        expected = np.sort(np.stack([np.full_like(around, 200.0), around], axis=1), axis=1)[:, ::-1]
        np.testing.assert_allclose(mesh.surface.curvatures(mesh.parameters), expected, atol=1e-5)
    volume, area = volume_and_area(meshes)
    assert volume == pytest.approx(2 * math.pi**2 * 0.02 * 0.005**2, rel=5e-3)
    assert area == pytest.approx(4 * math.pi**2 * 0.02 * 0.005, rel=5e-3)


@pytest.mark.parametrize("kind", FORMATS)
def test_a_trimmed_solid_ends_on_its_trim_curves_and_keeps_its_reversed_faces(tmp_path, kind):
    ball = BRepPrimAPI_MakeSphere(20.0).Shape()
    drill = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(3, 0, -50), gp_Dir(0, 0, 1)), 8.0, 100.0).Shape()
    path = save(BRepAlgoAPI_Cut(ball, drill).Shape(), tmp_path / f"drilled.{kind}")
    faces = read_cad(path)
    assert sorted(face.surface.sign for face in faces) == [-1.0, 1.0]
    outside, hole = sorted((face.mesh(40) for face in faces), key=lambda mesh: -len(mesh.surface.poles[0]))
    positions, normals = exact(hole)
    np.testing.assert_allclose(np.hypot(positions[:, 0] - 0.003, positions[:, 1]), 0.008, atol=1e-11)
    # The hole is looked at from its axis.
    assert (np.sum(normals[:, :2] * (positions[:, :2] - [0.003, 0.0]), axis=1) < -0.0079).all()
    positions, _ = exact(outside)
    border = np.hypot(positions[:, 0] - 0.003, positions[:, 1]) - 0.008
    assert border.min() > -1e-8
    on_it = np.abs(border) < 1e-8
    assert on_it.sum() > 60
    # All around, without a gap longer than two cells.
    angles = np.sort(np.arctan2(positions[on_it, 1], positions[on_it, 0] - 0.003))
    assert np.diff(angles).max() < 2.0 * 0.0032 / 0.008
    # Volume of a ball with a hole beside its middle, by quadrature.
    x, y = np.meshgrid(np.linspace(-0.02, 0.02, 1201), np.linspace(-0.02, 0.02, 1201))
    height = np.sqrt(np.maximum(0.0, 0.02**2 - x**2 - y**2)) * (np.hypot(x - 0.003, y) > 0.008)
    assert volume_and_area([outside, hole])[0] == pytest.approx(2.0 * height.sum() * (0.04 / 1200) ** 2, rel=0.01)


def test_several_faces_are_chosen_by_number_name_and_pattern(tmp_path):
    faces = read_cad(save(BRepPrimAPI_MakeBox(10.0, 20.0, 30.0).Shape(), tmp_path / "box.step"))
    assert [face.name for face in faces] == [f"face-{number}" for number in range(1, 7)]
    volume, area = volume_and_area([face.mesh() for face in faces])
    assert (volume, area) == (pytest.approx(6e-6, rel=1e-6), pytest.approx(2200e-6, rel=1e-6))
    assert [face.number for face in choose(faces, (5, 2), "box.step")] == [2, 5]
    assert [face.number for face in choose(faces, ("face-[13]", 2), "box.step")] == [1, 2, 3]
    assert choose(faces, ("*",), "box.step") == choose(faces, (), "box.step") == faces
    with pytest.raises(AnamorphError, match=r"^box\.step: has no face '7'[^\n]*1 to 6[^\n]*$"):
        choose(faces, (7,), "box.step")
    with pytest.raises(AnamorphError, match=r"^box\.step: has no face 'face-9'; did you mean 'face-[^\n]*$"):
        choose(faces, ("face-9",), "box.step")


def test_names_in_the_file_are_kept():
    (face,) = read_cad(door_mirror.FILE)
    assert (face.number, face.name) == (1, "glass")


@pytest.mark.parametrize("kind", FORMATS)
def test_a_face_moved_by_its_location_is_where_it_was_moved(tmp_path, kind):
    move = gp_Trsf()
    move.SetRotation(gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)), math.pi / 2)
    move.SetTranslationPart(gp_Vec(100, 0, 7))
    sphere = Geom_SphericalSurface(gp_Ax3(), 50.0)
    face = BRepBuilderAPI_MakeFace(sphere, -0.4, 0.4, -0.3, 0.3, 1e-6).Shape().Moved(TopLoc_Location(move))
    (mesh,) = load_cad(save(face, tmp_path / f"moved.{kind}"))
    positions, normals = exact(mesh)
    np.testing.assert_allclose(np.linalg.norm(positions - [0.1, 0.0, 0.007], axis=1), 0.05, atol=1e-10)
    # It bulged along x, and was turned to y.
    assert normals.mean(axis=0)[1] > 0.9
    assert len(mesh.faces) == 2 * 24 * math.ceil(24 * 0.6 / (0.8 * np.cos(np.linspace(-0.3, 0.3, 9)).mean()))


@pytest.mark.parametrize("convert", [lambda surface: surface, GeomConvert.SurfaceToBSplineSurface_s])
@pytest.mark.parametrize("first", [5.8, -0.6])
def test_a_face_across_the_seam_of_its_sphere_is_whole(tmp_path, convert, first):
    surface = convert(Geom_SphericalSurface(gp_Ax3(), 50.0))
    path = save(BRepBuilderAPI_MakeFace(surface, first, first + 1.2, -0.3, 0.3, 1e-6).Shape(), tmp_path / "seam.step")
    (mesh,) = load_cad(path, FaceChoice(density=40))
    positions, _ = exact(mesh)
    np.testing.assert_allclose(np.linalg.norm(positions, axis=1), 0.05, atol=1e-11)
    # The parameters of a B-spline are not angles: what it covers is asked from the mesh's own extent.
    low, high = np.arctan2(positions[:, 1], positions[:, 0])[[0, -1]]
    top = positions[:, 2].max() / 0.05
    assert volume_and_area([mesh])[1] == pytest.approx(0.05**2 * (high - low) * 2 * top, rel=2e-3)
    assert high - low == pytest.approx(1.2, abs=0.1)


@pytest.mark.parametrize("kind", FORMATS)
def test_a_reversed_face_shows_its_other_side_and_a_flipped_one_its_first(tmp_path, kind):
    sphere = Geom_SphericalSurface(gp_Ax3(), 50.0)
    shell, builder = TopoDS_Shell(), BRep_Builder()
    builder.MakeShell(shell)
    builder.Add(shell, BRepBuilderAPI_MakeFace(sphere, -0.4, 0.4, -0.3, 0.3, 1e-6).Shape().Reversed())
    (face,) = read_cad(save(shell, tmp_path / f"reversed.{kind}"))
    mesh, back = face.mesh(), face.turned().mesh()
    assert exact(mesh)[1].mean(axis=0)[0] < -0.9
    assert exact(back)[1].mean(axis=0)[0] > 0.9
    assert (mesh.surface.curvatures(mesh.parameters) < 0).all()


def test_the_shipped_mirror_follows_its_formula():
    (mesh,) = load_cad(door_mirror.FILE, FaceChoice(density=60))
    positions, normals = exact(mesh)
    x, y, z = positions.T
    np.testing.assert_allclose(z, door_mirror.height(x, y), atol=1e-10)
    angle = np.linalg.norm(np.cross(normals, door_mirror.normal(x, y)), axis=1)
    assert angle.max() < 1e-6 and (normals[:, 2] > 0).all()
    inner = x > -door_mirror.SEAM + 1e-6
    curvatures = mesh.surface.curvatures(mesh.parameters)
    np.testing.assert_allclose(curvatures[inner], 1.0 / door_mirror.RADIUS, rtol=1e-5)
    assert 1.0 / curvatures.max() > 0.15
    assert np.allclose([np.ptp(x), np.ptp(y)], door_mirror.SIZE, atol=1e-9)
    # Rounded corners: no vertex beyond.
    wide, high = np.subtract(door_mirror.SIZE, 2 * door_mirror.CORNER) / 2
    corner = np.hypot(np.maximum(np.abs(x) - wide, 0), np.maximum(np.abs(y) - high, 0)) - door_mirror.CORNER
    assert corner.max() < 1e-8


def test_an_outline_is_smooth_and_its_triangles_are_sound_even_where_they_are_few():
    (mesh,) = load_cad(door_mirror.FILE, FaceChoice(density=12))
    corners = mesh.surface.position(mesh.parameters)[mesh.faces][..., :2]
    edges = np.roll(corners, -1, axis=1) - corners
    doubled = edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]
    whole = 4 * (0.095 * 0.065) - (4 - math.pi) * door_mirror.CORNER**2
    assert np.sum(doubled) / 2 == pytest.approx(whole, abs=1.5e-5)
    # The sine of a triangle's least angle is its doubled area over the product of its longer sides.
    lengths = np.sort(np.linalg.norm(edges, axis=2), axis=1)
    assert np.min(doubled / (lengths[:, 1] * lengths[:, 2])) > np.sin(np.radians(LEAST_ANGLE))


def test_the_shipped_file_is_what_its_program_writes(tmp_path):
    door_mirror.write(tmp_path / "again.step")
    (again,), (shipped,) = read_cad(tmp_path / "again.step"), read_cad(door_mirror.FILE)
    np.testing.assert_allclose(again.surface.poles, shipped.surface.poles, atol=1e-13)
    assert door_mirror.FILE.stat().st_size < 200_000


@pytest.mark.parametrize(
    ("kind", "damage"),
    [
        *(("step", damage) for damage in ("empty", "text", "half", "binary")),
        *(("igs", damage) for damage in ("empty", "text", "half", "binary")),
        ("stp", "half"),
        ("iges", "half"),
    ],
)
def test_a_damaged_file_is_one_line(tmp_path, kind, damage):
    whole = save(BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Shape(), tmp_path / f"box.{'step' if kind[0] == 's' else 'igs'}")
    data = whole.read_bytes()
    bad = {"empty": b"", "text": b"hello\n" * 30, "half": data[: len(data) // 3], "binary": bytes(range(256)) * 9}
    path = tmp_path / f"bad.{kind}"
    path.write_bytes(bad[damage])
    with pytest.raises(AnamorphError, match=r"^[^\n]*bad\.\w+: [^\n]*export[^\n]*$"):
        load_cad(path)


def test_what_ends_opencascade_is_one_line(tmp_path, monkeypatch):
    crash = tmp_path / "crash.py"
    crash.write_text(
        "import os, signal, sys\nprint('noise', file=sys.stderr, flush=True)\nos.kill(os.getpid(), signal.SIGSEGV)\n"
    )
    monkeypatch.setattr(cad, "PROGRAM", crash)
    with pytest.raises(AnamorphError, match=r"^[^\n]*is damaged[^\n]*$"):
        read_cad(door_mirror.FILE)


def test_without_opencascade_one_line_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "OCP", None)
    with pytest.raises(AnamorphError, match=r"^[^\n]*pip install 'anamorph\[cad\]'$"):
        load_cad(door_mirror.FILE)


def test_a_missing_file_and_a_wrong_density_are_one_line(tmp_path):
    with pytest.raises(AnamorphError, match=r"^[^\n]*there is no such CAD file[^\n]*$"):
        load_cad(tmp_path / "no.step")
    for density in (0, -3, 10**6):
        with pytest.raises(AnamorphError, match=r"^[^\n]*density is [^\n]*$"):
            load_cad(door_mirror.FILE, FaceChoice(density=density))
    (tmp_path / "a.obj").write_text("v 0 0 0\n")
    with pytest.raises(AnamorphError, match=r"^[^\n]*for CAD files[^\n]*$"):
        load_parts(tmp_path / "a.obj", choice=FaceChoice((1,)))


def test_the_cad_mirror_stands_where_the_built_in_one_was():
    scene, _ = open_scene(door_mirror.FILE, mirror_of="car-mirror")
    plain = gallery.make("car-mirror")
    assert [mesh.name for mesh in scene.meshes] == ["glass", *(mesh.name for mesh in plain.meshes[1:])]
    new, old = scene.meshes[0], plain.meshes[0]
    assert vars(new.material) == vars(old.material)
    positions, normals = exact(new)
    np.testing.assert_allclose(positions.mean(axis=0), old.positions.mean(axis=0), atol=5e-3)
    facing, was = normals.mean(axis=0), old.normals.mean(axis=0)
    assert facing @ was > 0.999 * np.linalg.norm(facing) * np.linalg.norm(was)
    # The aspheric part is outboard, on the left of who looks at it.
    bent = new.surface.curvatures(new.parameters)[:, 0] > 1.0
    right = np.cross((0.0, 1.0, 0.0), normals.mean(axis=0))
    assert (positions[bent] @ right).max() < positions.mean(axis=0) @ right
    assert np.ptp(positions[:, 1]) == pytest.approx(np.ptp(old.positions[:, 1]), abs=3e-3)


def test_surface_truth_of_the_cad_mirror_does_not_depend_on_its_density():
    records = []
    for density in (12, 48):
        scene, _ = open_scene(door_mirror.FILE, FaceChoice(density=density), "car-mirror")
        geometry = flatten(scene)
        records.append(drain(PathTracer(scene, geometry, Caster(geometry)).tracing(eye_rays(scene.camera, (64, 48)))))
    coarse, fine = records
    mirrored = ((coarse[:, 7].view(np.uint32) >> 24) == 1) & ((fine[:, 7].view(np.uint32) >> 24) == 1)
    assert mirrored.sum() > 500
    angle = np.linalg.norm(coarse[:, 4:7] - fine[:, 4:7], axis=1)[mirrored]
    assert angle.max() < 1e-6


def test_a_mirror_drawn_with_z_up_stands_upright(tmp_path):
    move = gp_Trsf()
    move.SetRotation(gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)), 0.3)
    sphere = Geom_SphericalSurface(gp_Ax3(), 1400.0)
    face = BRepBuilderAPI_MakeFace(sphere, -0.07, 0.07, -0.04, 0.04, 1e-6).Shape()
    path = save(BRepBuilderAPI_Transform(face, move, True).Shape(), tmp_path / "turned.step")
    scene, _ = open_scene(path, FaceChoice(density=6), "car-mirror")
    old = gallery.make("car-mirror").meshes[0]
    np.testing.assert_allclose(scene.meshes[0].surface.normal(scene.meshes[0].parameters).mean(axis=0),
                               old.surface.normal(old.parameters).mean(axis=0), atol=5e-3)  # fmt: skip
    assert np.ptp(scene.meshes[0].positions[:, 1]) == pytest.approx(0.112, abs=8e-3)


def test_a_closed_body_as_mirror_asks_which_face(tmp_path):
    path = save(BRepPrimAPI_MakeBox(100.0, 50.0, 4.0).Shape(), tmp_path / "plate.step")
    with pytest.raises(AnamorphError, match=r"^[^\n]*plate\.step: [^\n]*--faces[^\n]*$"):
        open_scene(path, mirror_of="car-mirror")
    scene, _ = open_scene(path, FaceChoice(("face-6",)), "car-mirror")
    assert scene.meshes[0].name == "face-6"


def test_a_cad_file_alone_is_a_model_before_a_mirror():
    scene, _ = open_scene(door_mirror.FILE)
    assert [mesh.name for mesh in scene.meshes] == ["mirror", "mirror-plate", "ground", "glass"]
    assert isinstance(scene.meshes[-1].material, Diffuse)


@pytest.mark.parametrize("source", ["car-mirror", "scene.toml", "model.obj"])
def test_what_is_for_cad_files_is_refused_for_others(source):
    for arguments in ({"choice": FaceChoice((1,))}, {"mirror_of": "car-mirror"}):
        with pytest.raises(AnamorphError, match=r"^[^\n]*are for CAD files[^\n]*$"):
            open_scene(source, **arguments)


def test_a_scene_whose_mirror_is_not_clear_is_refused():
    with pytest.raises(AnamorphError, match=r"^scene 'room': has 32 mirrors[^\n]*$"):
        open_scene(door_mirror.FILE, mirror_of="room")


def scene_file(folder, model):
    (folder / "s.toml").write_text(
        f'[eye]\nposition = [0, 0, 1]\ntarget = [0, 0, 0]\n[[model]]\nfile = "{door_mirror.FILE}"\n{model}\n'
    )
    return folder / "s.toml"


def test_a_scene_file_names_faces_density_and_material(tmp_path):
    choice = 'faces = ["gl*"]\ndensity = 5\nmirror = { reflectance = 0.7 }\nscale = 2.0'
    scene, _ = open_scene(scene_file(tmp_path, choice))
    (mesh,) = scene.meshes
    assert mesh.material.reflectance == 0.7
    assert np.ptp(exact(mesh)[0][:, 0]) == pytest.approx(0.38)
    assert len(mesh.positions) < 120


@pytest.mark.parametrize(
    ("model", "says"),
    [
        ("faces = [1.5]", "line 6: faces is"),
        ("faces = 2", "has no face '2'"),
        ("density = 2.5", "line 6: density is"),
        ("density = 0", "density is 0"),
        ('flip = "yes"', "line 6: flip is"),
    ],
)
def test_mistakes_in_a_scene_file_are_named(tmp_path, model, says):
    with pytest.raises(AnamorphError, match=rf"^[^\n]*{says}[^\n]*$"):
        open_scene(scene_file(tmp_path, model))


def test_the_command_line_chooses_scene_faces_and_density(tmp_path, capsys):
    render = ["render", str(door_mirror.FILE), "-o", str(tmp_path / "a.png"), "--size", "64x48", "-m", "raytrace"]
    assert main([*render, "--scene", "car-mirror", "--faces", "1,gl*", "--density", "6"]) == 0
    assert (tmp_path / "a.png").is_file()
    for wrong in (["--faces", "1,,2"], ["--density", "0"], ["--faces", "9"]):
        assert main([*render, *wrong]) == 2
        assert capsys.readouterr().err.count("\n") == 1
