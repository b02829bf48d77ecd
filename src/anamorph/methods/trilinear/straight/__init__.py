"""Scene triangles drawn through ray triangles with straight edges, as the thesis does: for its figures and tables.

Source: Vallance, "Trilinear projection" (PhD thesis, 2005), chapters 4 and 5.

| section | what | where |
| --- | --- | --- |
| 4.2, 4.3 | the order in which projected corners are joined | `connect` |
| 4.1, 4.6 | a scene triangle's shapes, and what of them lies before the origins | `shapes`: `project_triangle` |
| 4.2 to 5.2 | all that in bulk and compiled | `straight`: `straight_pieces` |
"""

from anamorph.methods.trilinear.straight.shapes import Shape as Shape
from anamorph.methods.trilinear.straight.shapes import project_triangle as project_triangle
from anamorph.methods.trilinear.straight.straight import StraightPieces as StraightPieces
from anamorph.methods.trilinear.straight.straight import straight_pieces as straight_pieces
