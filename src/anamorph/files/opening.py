"""Whatever names a scene - a built-in, a scene file, a model file - as a scene that can be drawn."""

from __future__ import annotations

from pathlib import Path

from anamorph import gallery
from anamorph.base.errors import AnamorphError, nearest
from anamorph.files import cad
from anamorph.files.cad import FaceChoice, chosen_faces
from anamorph.files.framing import stand_before_mirror
from anamorph.files.models import SUFFIXES, load_parts
from anamorph.files.placing import replace_mirror
from anamorph.files.scene_file import Settings, load_scene_file
from anamorph.scene.checks import check_scene
from anamorph.scene.model import Scene


def open_scene(
    source: str | Path,
    choice: FaceChoice | None = None,
    mirror_of: str | Path | None = None,
    above: tuple[Path, ...] = (),
) -> tuple[Scene, Settings]:
    """The scene, checked, and how it wants to be drawn.

    Parameters
    ----------
    source : str or Path
        The name of a built-in scene, a .toml scene file, or a model file, which is stood before a convex mirror.
    choice : FaceChoice, optional
        Which faces of a CAD file, and how fine.
    mirror_of : str or Path, optional
        A scene whose mirror the CAD file `source` replaces.
    above : tuple of Path
        The scene files that start from this one.
    """
    path = Path(source)
    suffix = path.suffix.lower()
    if suffix not in cad.SUFFIXES and (choice or mirror_of):
        raise AnamorphError(
            f"{source}: --scene, --faces, --density and --flip are for CAD files ({', '.join(cad.SUFFIXES)}); "
            "leave them out"
        )
    if mirror_of:
        scene, settings = open_scene(mirror_of, above=above)
        choice = choice or FaceChoice()
        return check_scene(replace_mirror(scene, chosen_faces(path, choice), choice.density, str(path))), settings
    if str(source) in gallery.names():
        return check_scene(gallery.make(str(source))), Settings(method=gallery.SCENES[str(source)].method)
    if suffix == ".toml":
        return load_scene_file(path, above)
    if suffix in SUFFIXES:
        meshes = tuple(part.mesh for part in load_parts(path, choice=choice, near=True))
        return check_scene(stand_before_mirror(meshes, path.stem)), Settings()
    if path.is_file():
        raise AnamorphError(
            f"{source}: is no scene file and no known model; give one that ends in .toml, {', '.join(SUFFIXES)}"
            f"{nearest(suffix, ('.toml', *SUFFIXES))}"
        )
    known = gallery.names()
    raise AnamorphError(
        f"'{source}' is no scene{nearest(str(source), known)} (built in: {', '.join(known)}); "
        f"or give a .toml scene file or a model ({', '.join(SUFFIXES)})"
    )
