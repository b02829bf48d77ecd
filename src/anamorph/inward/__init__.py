"""Scenes drawn by raster through rays that converge in a point, and go on beyond it.

Source: Vallance and Calder, "Inward looking projections" (2003), appendix G of Vallance, "Trilinear projection".

| part of the paper | what | module |
| --- | --- | --- |
| 4 | the point of convergence, and whether there is one | `converging` |
| 4.4 | the rays of a concave mirror, as if they had one | `converging` |
| 4.1, 4.2, 6 | views from that point: one, or four through the faces of a tetrahedron | `field_views` |
| 4.1 to 4.3 | near and far field in one depth buffer | `field_maps` |
| 6 | each pixel looked up in them | `raster` |

`INWARD` is a method that sees through such ray meshes, and through nothing else::

    anamorph.render(scene, anamorph.inward.INWARD, camera=anamorph.cameras.inward_sphere((0, 0, 0), 2.0, (800, 400)))
"""

from anamorph.inward.converging import Converging as Converging
from anamorph.inward.converging import converging as converging
from anamorph.inward.converging import toward_one_point as toward_one_point
from anamorph.inward.raster import INWARD as INWARD
from anamorph.inward.raster import Options as Options
