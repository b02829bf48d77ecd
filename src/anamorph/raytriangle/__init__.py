"""A point through one ray triangle: where it is seen, in float64, compiled and on the device; and what cannot be seen.

Source: Vallance, "Trilinear projection" (PhD thesis, 2005), chapter 3. A ray triangle is three rays: origins p and
directions n (3, 3), the directions of any length; in between, both are interpolated with the weights (1 - u - v, u, v).
The thesis's parametric triangle at t is the one between the points p + t n.

| section | what | where |
| --- | --- | --- |
| 3.6, A.3 | what does not depend on the point: the triangle's own units and its cubics' coefficients | `scaled` |
| | without the roots at which no ray passes through any point | `factors` |
| | the same as rows of numbers that compiled loops read | `rows` |
| 3.3 | all real roots of a cubic of any degree | `roots` |
| 3.1 to 3.5, 3.8 | all rays that pass through a point | `solve` |
| | through many points, on all the cores | `points`: `project_points` |
| 3.6 | the same on the graphics device, not imported here | `on_device`: `project_points_on_device` |
| 3.7 | which points no ray meets | `sides`: `side_surfaces` |
| | which samples of an image each ray triangle owns | `owners` |
| | a tree of boxes | `parting` |
| | which boxes and surfels it may see, bounded linearly | `camera_frames`, `bounds`: `seen_weights` |
| | which boxes it may see, by its side walls (Mei, Popescu and Sacks 2007, section 5.2) | `walls`: `meets_volume` |
| | which points are seen once (the same, section 5.1) | `sweeping`: `seen_once`, `sees_once` |
"""

from anamorph.raytriangle.points import Projections as Projections
from anamorph.raytriangle.points import project_points as project_points
from anamorph.raytriangle.sides import SideSurfaces as SideSurfaces
from anamorph.raytriangle.sides import side_surfaces as side_surfaces
from anamorph.raytriangle.sweeping import seen_once as seen_once
from anamorph.raytriangle.sweeping import sees_once as sees_once
from anamorph.raytriangle.sweeping import switches as switches
