"""The reference: a ray for every pixel that looks at a mirror or a lens, traced until it meets what is neither.

Source: Whitted, "An improved illumination model for shaded display" (1980), without its branching: a path goes on as
reflected or as refracted light, never as both. Embree casts the rays. The paths are a room of their own, because other
methods and the viewer trace too.

| part of the paper | what | module |
| --- | --- | --- |
| reflected and refracted rays | paths from mirror to mirror and through glass | `methods.tracing` |
| rays from the eye | a ray through every pixel that may look at a mirror or a lens, and its colour | `raytrace` |
| not in it | the pixels' rays of a ray mesh that is the camera | `pixel_rays` |
"""

from anamorph.methods.raytrace.raytrace import METHOD as METHOD
from anamorph.methods.raytrace.raytrace import Options as Options
from anamorph.methods.raytrace.raytrace import TracedDrawing as TracedDrawing
