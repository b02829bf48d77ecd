"""Shaders, and what they need: a WGSL file names in `// needs:` lines the files that are compiled with it.

WGSL itself knows no files. The names are paths relative to this package, also in a shader of another package. Each
file is taken once, after what it needs; two files may need each other, because in WGSL the order means nothing.
"""

from __future__ import annotations

import re
from importlib import resources
from pathlib import Path

import wgpu

from anamorph.base.errors import AnamorphError
from anamorph.gpu.device import get_device, of_device

NEEDS = re.compile(r"^// needs: (.+)$", re.MULTILINE)


@of_device
def shader_module(*shaders: str | Path) -> wgpu.GPUShaderModule:
    """Compile shaders with what they need.

    Parameters
    ----------
    *shaders : str or Path
        WGSL files: names in this package, like "gpu/scene.wgsl", or the paths of files of another one.

    Raises
    ------
    AnamorphError
        If a file does not exist that is named here or is needed.
    """
    return get_device().create_shader_module(code="\n".join(joined(*shaders).values()))


def joined(*shaders: str | Path) -> dict[str | Path, str]:
    """The texts of shaders and of all that they need, in the order in which they are compiled; see `shader_module`."""
    texts: dict[str | Path, str] = {}
    order: list[str | Path] = []

    def add(shader: str | Path, needed_by: str) -> None:
        if shader in texts:
            return
        texts[shader] = _read(shader, needed_by)
        for name in needs(texts[shader]):
            add(name, f"{shader} needs it; ")
        order.append(shader)

    for shader in shaders:
        add(shader, "")
    return {shader: texts[shader] for shader in order}


def needs(text: str) -> list[str]:
    """The names of the files that a shader's text says it needs."""
    return [name.strip() for line in NEEDS.findall(text) for name in line.split(",")]


def _read(shader: str | Path, needed_by: str) -> str:
    path = shader if isinstance(shader, Path) else resources.files("anamorph") / shader
    if not path.is_file():
        raise AnamorphError(f"shader {shader}: there is no such file; {needed_by}give a path relative to the package")
    return path.read_text("utf-8")
