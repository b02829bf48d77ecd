"""What it costs to search maps of surfaces, and to trace: fitted to measurements.

The figures for software Vulkan were measured on two cores of an x86-64 processor, over the built-in scenes;
`anamorph bench choice` measures them again. On a graphics card searching has not been measured. It does there in
parallel what two cores do here, so that everything is searched.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from anamorph.gpu.device import get_adapter

DOUBTFUL, BENT_IN = 0.18, 0.6
"""The share of a body's pixels that a search leaves to be traced: for each interface, and of a body that may see
itself."""


@dataclass(frozen=True)
class Expected:
    """What one body would take.

    Parameters
    ----------
    pixels : float
        That show the body.
    lines : int
        Of the spectrum, that are followed apart.
    interfaces : int
        That its rays meet.
    maps : int
        That each pixel is looked for in: two where the body's rays converge.
    patches, triangles : int
        Its patches; triangles of the scene.
    bent_in : bool
        Whether it may see itself.
    """

    pixels: float
    lines: int
    interfaces: int
    maps: int
    patches: int
    triangles: int
    bent_in: bool

    @property
    def rays(self) -> float:
        """Rays from interface to interface, of all pixels."""
        return self.pixels * self.lines * (1 + self.interfaces)

    @property
    def looks(self) -> float:
        """How often a pixel's ray is followed through a map."""
        return self.pixels * self.lines * self.maps

    @property
    def left(self) -> float:
        """The share of these that a search leaves to be traced."""
        return BENT_IN if self.bent_in else DOUBTFUL * self.interfaces


@dataclass(frozen=True)
class Costs:
    """Costs of one frame, in nanoseconds of the whole machine.

    Parameters
    ----------
    search : float
        For each pixel, line of the spectrum and map, to follow its ray through the map, and to draw that.
    triangle : float
        For each triangle of the scene that a patch's map draws.
    patch : float
        For each patch, to plan its maps.
    trace : float
        For each ray from interface to interface, to cast and bend it.
    """

    search: float
    triangle: float
    patch: float
    trace: float

    def __str__(self) -> str:
        return (
            f"search {self.search:.0f} ns a pixel, {self.triangle:.0f} a triangle and {self.patch:.0f} a patch; "
            f"trace {self.trace:.0f} ns a ray"
        )

    def searching_pays(self, bodies: Sequence[Expected]) -> bool:
        """Whether searching bodies, with what that leaves to be traced, costs less than to trace them."""
        searching = sum(
            body.looks * self.search
            + body.patches * (self.patch + body.triangles * self.triangle)
            + body.left * body.rays * self.trace
            for body in bodies
        )
        return searching < sum(body.rays * self.trace for body in bodies)


SOFTWARE = Costs(search=332.0, triangle=352.0, patch=0.0, trace=168.0)
"""Of software Vulkan."""


def costs_here() -> Costs | None:
    """The costs on this machine's adapter; None where they have not been measured."""
    return SOFTWARE if get_adapter().info["adapter_type"] == "CPU" else None
