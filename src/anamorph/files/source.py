"""What names a scene: a built-in scene, a scene file or a model, and what there is to say of a CAD file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class FaceChoice:
    """Which faces of a CAD file are wanted, and how fine.

    Parameters
    ----------
    faces : tuple of int or str
        Numbers from 1 in the file's order, and names of faces or bodies (* stands for any letters); all where empty.
    density : int
        Cells along the longer side of each face, and to a full turn of its normal.
    flip : bool
        Whether the other side of each face is its outside: CAD programs turn the faces of a sheet as they like.
    """

    faces: tuple[int | str, ...] = ()
    density: int = 24
    flip: bool = False


@dataclass(frozen=True)
class Source:
    """What a scene is opened from.

    Parameters
    ----------
    name : str or Path
        The name of a built-in scene, a .toml scene file, or a model file. A model without mirrors and glass
        is stood before a convex mirror.
    choice : FaceChoice, optional
        Which faces of a CAD file, and how fine.
    mirror_of : str or Path, optional
        A scene whose mirror the CAD file `name` replaces.
    units : str
        The unit of a model file, as "mm"; "" for metres, or for what a CAD file says itself.
    axes : str
        Which way the axes of a model file point, as "x back, z up"; "" for y up and z to the back.
    """

    name: str | Path
    choice: FaceChoice | None = None
    mirror_of: str | Path | None = None
    units: str = ""
    axes: str = ""
