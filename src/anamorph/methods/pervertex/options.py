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
    map : str
        What a map holds: "surfaces", the triangles that it sees, among which each pixel's own ray finds what it meets;
        "image", the paper's colours, which are warped.
    antialias : int
        Samples a pixel of the image and of the maps: 1 or 4.
    resolution : float
        Texels of a map for each pixel that it fills, along one axis.
    projective : bool
        Whether the texture coordinates of maps of colours are projective; false is the paper's plain (s, t).
    align : bool
        Whether maps are turned to the principal directions of their rays.
    field : float
        Degrees: a body whose rays spread wider is too wide for one map.
    wide : str
        What is drawn for such a body with maps of colours: "patches", into which it is divided, with a map each, or
        "cube", a cube map at its virtual viewpoint. Without such a point behind it, it is divided into patches.
    bounces : int
        How many specular interfaces a path may meet with maps of colours: a mirror is one, a lens is two. Paths that
        are traced may meet eight.
    tolerance : float
        With maps of surfaces: above 0, what is doubtful is traced.
    overlay : str
        What to draw over an image of warped colours: "none"; "mesh", the mirror's wireframe and a ball at each vertex
        ray's hit, as the paper's Figure 1; "inconsistency", the fragments and the vertices that do not show what their
        rays meet, its Figure 16.
    """

    map: str = option("surfaces", choices=("surfaces", "image"))
    antialias: int = option(1, choices=(1, 4))
    resolution: float = option(1.0, low=0.01, high=16.0)
    projective: bool = True
    align: bool = True
    field: float = option(100.0, low=1.0, high=150.0, unit="degrees")
    wide: str = option("patches", choices=("patches", "cube"))
    bounces: int = option(3, low=1, high=MAXIMUM_BOUNCES)
    tolerance: float = option(0.0, low=0.0, unit="pixels")
    overlay: str = option("none", choices=("none", "mesh", "inconsistency"))
