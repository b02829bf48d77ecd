"""What a ray triangle sees, by projecting the scene into it instead of casting rays through it.

Source: Vallance, "Trilinear projection" (PhD thesis, 2005), chapters 3 to 5 and 7. A ray triangle is three rays:
origins p and directions n (3, 3), the directions of any length; in between, both are interpolated with the weights
(1 - u - v, u, v). The thesis's parametric triangle at t is the one between the points p + t n.

| section | what | where |
| --- | --- | --- |
| 3.6, A.3 | what does not depend on the point: the triangle's frame and its cubics' coefficients | `coefficients` |
| 3.3 | all real roots of a cubic of any degree | `cubic` |
| 3.1 to 3.5, 3.8 | the rays that pass through a point | `points`: `project_points` |
| 3.6 | the same on the graphics device, not imported here | `device`: `project_points_on_device` |
| 3.7 | which points, and which boxes, no ray meets | `sides`: `side_surfaces`; `boxes`: `bounding_planes` |
| 4.2, 4.3 | the order in which projected corners are joined | `connect` |
| 4.1, 4.6 | a scene triangle's shapes, and what of them lies before the origins | `shapes`: `project_triangle` |
| 4.2 to 5.2 | all that in bulk and compiled, drawn with straight edges | `straight`: `straight_pieces` |
| beyond it | rays, and the sides of scene edges, as functions of the picture: exact edges | `beams`, `pairs` |
| | which scene triangles all ray triangles see, and in which pieces of the picture | `tree`, `plan` |
| 7.2.3 | the rays that go on from a mirror seen in a mirror | `following`, by `pixels` and `samples` |
"""

from anamorph.trilinear.boxes import BoundingPlanes as BoundingPlanes
from anamorph.trilinear.boxes import bounding_planes as bounding_planes
from anamorph.trilinear.points import Projections as Projections
from anamorph.trilinear.points import project_points as project_points
from anamorph.trilinear.shapes import Shape as Shape
from anamorph.trilinear.shapes import project_triangle as project_triangle
from anamorph.trilinear.sides import SideSurfaces as SideSurfaces
from anamorph.trilinear.sides import side_surfaces as side_surfaces
from anamorph.trilinear.straight import StraightPieces as StraightPieces
from anamorph.trilinear.straight import straight_pieces as straight_pieces
