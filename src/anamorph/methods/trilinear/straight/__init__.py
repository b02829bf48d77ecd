"""Scene triangles drawn through ray triangles with straight edges, as the thesis does: for its figures and tables.

Source: Vallance, "Trilinear projection" (PhD thesis, 2005), chapters 4 and 5. Exact edges need nothing of this room:
without it, the method lacks its option `edges=straight` and no more.

| section | what | where |
| --- | --- | --- |
| 4.2, 4.3 | the order in which projected corners are joined | `chains` |
| 4.1, 4.6 | one scene triangle's shapes, and what of them lies before the origins | `shapes`: `project_triangle` |
| 4.5.1 | a scene triangle divided | `barycentric_grid` |
| 4.5.2, 5.2 | a shape's two chains as points, with more at levels of t and at the ray triangle's sides | `traces` |
| 5.2 | what the edges of a ray triangle sweep | `swept_sides` |
| | what lies between the two chains, as triangles near the ray triangle | `strips`, `cutting` |
| | all that in bulk | `fill`, `bulk`: `straight_pieces` |
| | as the device draws it | `edges`: `StraightEdges`; `straight.wgsl` |
"""

from anamorph.methods.trilinear.straight.bulk import straight_pieces as straight_pieces
from anamorph.methods.trilinear.straight.edges import StraightEdges as StraightEdges
from anamorph.methods.trilinear.straight.shapes import Shape as Shape
from anamorph.methods.trilinear.straight.shapes import project_triangle as project_triangle
