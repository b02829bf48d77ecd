"""Faces of CAD files (STEP, IGES) as meshes whose every vertex is exact.

OpenCASCADE reads the file in a process of its own (`opencascade.py`); from there on a face is a NURBS surface and the
curves that trim it, and needs nothing but this package.
"""

from __future__ import annotations

import pickle
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from anamorph.base.errors import AnamorphError, nearest
from anamorph.files.reading import read
from anamorph.files.source import FaceChoice
from anamorph.files.trimming import TrimCurve, tessellate
from anamorph.scene.model import Diffuse, Material, Mesh
from anamorph.scene.triangles import has_area
from anamorph.surfaces.nurbs import NurbsSurface

SUFFIXES = (".step", ".stp", ".iges", ".igs")
MOST_DENSE = 1000
PROGRAM = Path(__file__).with_name("opencascade.py")


@dataclass(frozen=True, eq=False)
class CadFace:
    """A face of a CAD file.

    Parameters
    ----------
    number : int
        From 1, in the file's order.
    name : str
        Its own name in the file, or else made from that of its body and its number.
    body : str
        The name of the solid or shell that it belongs to, "" for none.
    surface : NurbsSurface
        Metres, its normals pointing outside.
    curves : tuple of TrimCurve
        Its borders.
    """

    number: int
    name: str
    body: str
    surface: NurbsSurface
    curves: tuple[TrimCurve, ...]

    def turned(self) -> CadFace:
        """The same face with its other side outside."""
        return replace(self, surface=replace(self.surface, sign=-self.surface.sign))

    def mesh(self, density: int = FaceChoice.density, material: Material | None = None) -> Mesh:
        """Triangles on the face; `density` as in `FaceChoice`."""
        parameters, faces = tessellate(self.surface, self.curves, density)
        exact = self.surface.position(parameters)
        faces = faces[has_area(exact, faces)]
        if not len(faces):
            raise AnamorphError(f"face {self.number} ('{self.name}'): has no area; choose others by their numbers")
        used, rows = np.unique(faces, return_inverse=True)
        faces = rows.reshape(-1, 3).astype(np.int32)
        return Mesh(
            name=self.name,
            positions=exact[used],
            faces=faces if self.surface.sign > 0 else np.ascontiguousarray(faces[:, ::-1]),
            normals=self.surface.normal(parameters[used]).astype(np.float32),
            material=material or Diffuse(),
            surface=self.surface,
            parameters=parameters[used],
        )


def load_cad(path: str | Path, choice: FaceChoice | None = None, material: Material | None = None) -> tuple[Mesh, ...]:
    """The chosen faces of a STEP or IGES file as meshes, in metres; diffuse unless a material is given."""
    choice = choice or FaceChoice()
    return meshes_of(chosen_faces(path, choice), choice.density, str(path), material)


def chosen_faces(path: str | Path, choice: FaceChoice) -> tuple[CadFace, ...]:
    """The chosen faces of a STEP or IGES file."""
    if not 1 <= choice.density <= MOST_DENSE:
        raise AnamorphError(f"{path}: density is {choice.density}; give 1 to {MOST_DENSE} cells along a face")
    chosen = choose(read_cad(path), choice.faces, str(path))
    return tuple(face.turned() for face in chosen) if choice.flip else chosen


def meshes_of(
    faces: tuple[CadFace, ...], density: int, where: str, material: Material | None = None
) -> tuple[Mesh, ...]:
    """Faces of the file `where` as meshes."""
    try:
        return tuple(face.mesh(density, material) for face in faces)
    except AnamorphError as error:
        raise AnamorphError(f"{where}: {error}") from None


def read_cad(path: str | Path) -> tuple[CadFace, ...]:
    """All faces of a STEP or IGES file."""
    path = Path(path)
    read(path, "CAD file")
    if not _has_opencascade():
        raise AnamorphError(f"{path}: CAD files need one more package; install it: pip install 'anamorph[cad]'")
    # Without -P the program's folder would come first where it looks for modules.
    done = subprocess.run([sys.executable, "-P", str(PROGRAM), str(path)], capture_output=True, check=False)
    if done.returncode != 0:
        said = done.stderr.decode(errors="replace").strip().splitlines()
        reason = said[-1] if said and done.returncode == 1 else "is damaged; export it again"
        raise AnamorphError(f"{path}: {reason}")
    try:
        return tuple(_face(number, **entry) for number, entry in enumerate(pickle.loads(done.stdout), start=1))
    except AnamorphError as error:
        raise AnamorphError(f"{path}: {error}") from None


def _has_opencascade() -> bool:
    try:
        return find_spec("OCP") is not None
    # What find_spec says of a module that is blocked.
    except ValueError:
        return False


def _face(number: int, name: str, body: str, sign: float, curves: list[dict], **surface) -> CadFace:
    return CadFace(
        number=number,
        name=name or (f"{body}/face-{number}" if body else f"face-{number}"),
        body=body,
        surface=NurbsSurface(**surface, sign=sign),
        curves=tuple(TrimCurve(**curve) for curve in curves),
    )


def choose(faces: tuple[CadFace, ...], wanted: Sequence[int | str], where: str) -> tuple[CadFace, ...]:
    """The faces of these numbers and names, in the file's order; all for none."""
    kept: set[int] = set()
    for choice in wanted:
        if isinstance(choice, int):
            hits = {face.number for face in faces if face.number == choice}
        else:
            hits = {face.number for face in faces if fnmatchcase(face.name, choice) or fnmatchcase(face.body, choice)}
        if not hits:
            names = sorted({face.name for face in faces} | {face.body for face in faces} - {""})
            listed = ", ".join(names[:12]) + (", ..." if len(names) > 12 else "")
            raise AnamorphError(
                f"{where}: has no face '{choice}'{nearest(str(choice), names)} "
                f"(faces 1 to {len(faces)}; names: {listed})"
            )
        kept |= hits
    return tuple(face for face in faces if face.number in kept) if wanted else faces
