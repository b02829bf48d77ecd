"""The options of `pervertex`."""

from __future__ import annotations

from dataclasses import dataclass

from anamorph.methods.options import option

MAXIMUM_BOUNCES = 8


@dataclass(frozen=True)
class Options:
    """Options of `pervertex`.

    Parameters
    ----------
    antialias : int
        Samples a pixel of the image and of the maps: 1 or 4.
    mipmaps : bool
        Whether maps have mipmaps.
    resolution : float
        Texels of a map for each pixel that it fills, along one axis.
    projective : bool
        Whether texture coordinates are projective; false is the paper's plain (s, t).
    align : bool
        Whether maps are turned to the principal directions of their rays.
    field : float
        Degrees: a body whose rays spread wider is too wide for one map.
    wide : str
        What is drawn for such a body: "patches", into which it is divided, with a map each, or "cube", a cube map at
        its virtual viewpoint. Where there is no such point behind it, it is divided all the same.
    bounces : int
        How many specular interfaces a path may meet: a mirror is one, a lens is two.
    refine : int
        Steps that each fragment takes through its map towards what its own ray meets; 0 is the paper.
    start : str
        What the steps start from: "vertices", the places that the vertex rays give; "direction", a far point along
        each vertex ray, so that no ray is cast at all.
    tolerance : float
        Pixels: where what a fragment shows may be further than this from what it should, its tile of the image is
        traced. 0 traces nothing. At least three refinements go before.
    overlay : str
        What to draw over the image: "none"; "mesh", the mirror's wireframe and a ball at each vertex ray's hit, as
        the paper's Figure 1; "inconsistency", the fragments and the vertices that may not show what their rays meet,
        its Figure 16.
    """

    antialias: int = option(1, choices=(1, 4))
    mipmaps: bool = False
    resolution: float = option(1.0, low=0.01, high=16.0)
    projective: bool = True
    align: bool = True
    field: float = option(100.0, low=1.0, high=150.0, unit="degrees")
    wide: str = option("patches", choices=("patches", "cube"))
    bounces: int = option(3, low=1, high=MAXIMUM_BOUNCES)
    refine: int = option(0, low=0, high=16)
    start: str = option("vertices", choices=("vertices", "direction"))
    tolerance: float = option(0.0, low=0.0, unit="pixels")
    overlay: str = option("none", choices=("none", "mesh", "inconsistency"))

    @property
    def casts(self) -> bool:
        """Whether what the vertex rays hit is found (step 3.1); else a vertex looks up a point far along its ray."""
        return self.start == "vertices"

    @property
    def strict(self) -> bool:
        """Whether a map must show all that its body does: then a vertex whose ray meets something before the near
        plane has no place in it."""
        return self.tolerance > 0.0
