"""The words that name a scene, and the options of a model: on the command line, and typed into the viewer."""

from __future__ import annotations

import argparse
import shlex
from typing import NoReturn

from anamorph.base.errors import AnamorphError
from anamorph.files.source import FaceChoice, Source
from anamorph.files.units_and_axes import UNITS


class Parser(argparse.ArgumentParser):
    """Says what is wrong in one line, like every other error here."""

    def error(self, message: str) -> NoReturn:
        raise AnamorphError(f"{message}; see '{self.prog} --help'")


def add_model_options(parser: argparse.ArgumentParser) -> None:
    """Let a parser take what there is to say of a model file."""
    models = parser.add_argument_group("models")
    models.add_argument("--units", metavar="UNIT", default="", help=f"of its lengths: {', '.join(UNITS)} (m)")
    axes = "which way its axes point, as 'z up' or 'x back, z up' (y up, z back)"
    models.add_argument("--axes", metavar="AXES", default="", help=axes)
    group = parser.add_argument_group("CAD files (.step, .stp, .iges, .igs)")
    group.add_argument(
        "--scene", metavar="SCENE", dest="mirror_of", help="put the CAD mirror where this scene has its own"
    )
    group.add_argument("--faces", metavar="1,3|NAME", type=_faces, help="only these faces, by number or name (all)")
    group.add_argument("--density", metavar="N", type=_density, help="cells along the longer side of a face (24)")
    group.add_argument("--flip", action="store_true", help="the other side of the faces is their outside")


def source_of(arguments: argparse.Namespace) -> Source:
    """What the arguments name, with what `add_model_options` has taken."""
    choice = _face_choice(arguments)
    return Source(arguments.scene, choice, arguments.mirror_of, arguments.units, arguments.axes)


def _face_choice(arguments: argparse.Namespace) -> FaceChoice | None:
    """What is said of the faces of a CAD file; None where nothing is."""
    said = {"faces": arguments.faces, "density": arguments.density, "flip": arguments.flip or None}
    said = {name: value for name, value in said.items() if value is not None}
    return FaceChoice(**said) if said else None


def source_in(words: str) -> Source:
    """A scene's name and the options of a model in one text, as they stand after `anamorph view`."""
    parser = Parser(prog="anamorph view", add_help=False, allow_abbrev=False)
    parser.add_argument("scene", metavar="SCENE|MODEL")
    add_model_options(parser)
    try:
        given = shlex.split(words)
    except ValueError:
        raise AnamorphError(f"{words}: a quotation mark is not closed; close it, or leave it out") from None
    return source_of(parser.parse_args(given))


def _faces(text: str) -> tuple[int | str, ...]:
    entries = [entry.strip() for entry in text.split(",")]
    if not all(entries):
        raise argparse.ArgumentTypeError(f"'{text}' names no faces; write numbers or names with commas, like 1,3")
    return tuple(int(entry) if entry.isascii() and entry.isdigit() else entry for entry in entries)


def _density(text: str) -> int:
    if not (text.isascii() and text.isdigit() and int(text) > 0):
        raise argparse.ArgumentTypeError(f"'{text}' is no density; write a whole number of cells along a face")
    return int(text)
