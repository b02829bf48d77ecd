"""The words that name a scene and its CAD options: on the command line, and typed into the viewer."""

from __future__ import annotations

import argparse
import shlex
from typing import NoReturn

from anamorph.base.errors import AnamorphError
from anamorph.files.source import FaceChoice, Source


class Parser(argparse.ArgumentParser):
    """Says what is wrong in one line, like every other error here."""

    def error(self, message: str) -> NoReturn:
        raise AnamorphError(f"{message}; see '{self.prog} --help'")


def add_cad_options(parser: argparse.ArgumentParser) -> None:
    """Let a parser take what there is to say of a CAD file."""
    group = parser.add_argument_group("CAD files (.step, .stp, .iges, .igs)")
    group.add_argument(
        "--scene", metavar="SCENE", dest="mirror_of", help="put the CAD mirror where this scene has its own"
    )
    group.add_argument("--faces", metavar="1,3|NAME", type=_faces, help="only these faces, by number or name (all)")
    group.add_argument("--density", metavar="N", type=_density, help="cells along the longer side of a face (24)")
    group.add_argument("--flip", action="store_true", help="the other side of the faces is their outside")


def face_choice(arguments: argparse.Namespace) -> FaceChoice | None:
    """What `add_cad_options` has taken of the faces of a CAD file; None where nothing is said."""
    said = {"faces": arguments.faces, "density": arguments.density, "flip": arguments.flip or None}
    said = {name: value for name, value in said.items() if value is not None}
    return FaceChoice(**said) if said else None


def source_in(words: str) -> Source:
    """A scene's name and its CAD options in one text, quoted as for a shell: as they stand after `anamorph view`."""
    parser = Parser(prog="anamorph view", add_help=False, allow_abbrev=False)
    parser.add_argument("scene", metavar="SCENE|MODEL")
    add_cad_options(parser)
    try:
        given = shlex.split(words)
    except ValueError:
        raise AnamorphError(f"{words}: a quotation mark is not closed; close it, or leave it out") from None
    arguments = parser.parse_args(given)
    return Source(arguments.scene, face_choice(arguments), arguments.mirror_of)


def _faces(text: str) -> tuple[int | str, ...]:
    entries = [entry.strip() for entry in text.split(",")]
    if not all(entries):
        raise argparse.ArgumentTypeError(f"'{text}' names no faces; write numbers or names with commas, like 1,3")
    return tuple(int(entry) if entry.isascii() and entry.isdigit() else entry for entry in entries)


def _density(text: str) -> int:
    if not (text.isascii() and text.isdigit() and int(text) > 0):
        raise argparse.ArgumentTypeError(f"'{text}' is no density; write a whole number of cells along a face")
    return int(text)
