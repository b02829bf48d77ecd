"""Per-vertex reflection and refraction: maps from the best virtual viewpoints, and what each pixel finds in them.

Source: Kakimoto, Tatsukawa, Chun, Nishita, "Real-time reflection and refraction on a per-vertex basis" (2007). The
numbers in brackets are its steps. A shader that is not listed has the name of its module.

With `map=image`, the paper's way, a map holds colours, and is warped so that every vertex is exact:

| section of the paper | what | module |
| --- | --- | --- |
| 3.1 (1), 4.5 | reflect or refract the eye's ray at every vertex | `optics.ray_meshes` |
| 3, 4.1 | all steps up to the texture coordinates, for what an eye sees of each body | `seen` |
| 4.1 | divide what spreads its rays too wide | `division`; as one cube map instead: `cube_plan` |
| 3.2 (2) | the virtual viewpoint, with each ray counted by its pixels | `optics.viewpoint`, `bundle` |
| 3.3 (2), 4.2, 4.3 | the view volume, also of converging rays and turned to the principal directions | `warp` |
| 3.1 (3.1) | what each vertex ray hits | `bundle`, `surroundings`; what stands close to the body: `mounting` |
| 3.4 (3.2 to 3.4) | where the map shows that hit: the vertex's texture coordinates | `warp` |
| 4.4 | bodies in the maps of other bodies, and so on, level by level | `frame_maps`, `level` |
| (2) | draw the maps, of which only what is looked up | `atlas`, `looked_up.wgsl` |
| (4) | draw the scene, and the bodies with their maps | `pervertex`, `warp.wgsl`; a lens (4.5): `lens.wgsl` |
| 6, Figure 16 | where a map does not show what a ray meets | `inconsistency` |
| (2) | the rectangle of each map in one texture | `rectangles` |
| Figures 1, 16 | balls at the hits, and wires | `vertex_marks`, `overlay` |
| | what may be chosen | `options` |

With `map=surfaces`, beyond the paper, a map holds triangles, and each pixel follows its own ray through it:

| what | module |
| --- | --- |
| where each map is seen from, and what it must hold | `surface_plan` |
| what is left of a patch in the image | `visible_rays` |
| what no map sees, by triangles of the body | `unseen` |
| draw the maps, and how near they see anything | `rectangles`, `surface_maps`: `surface_map.wgsl`, `nearest.wgsl` |
| edges that may hide what lies behind them between the middles of texels | `silhouettes`, `silhouettes.wgsl` |
| which triangles look into which maps | `looking` |
| bend each pixel's ray, and find what it meets | `finding`: `found.wgsl` |
| what a ray meets in a map, and whether that is proved | `search.wgsl`, `meeting.wgsl`, `map_line.wgsl` |
"""

from anamorph.methods.pervertex.finding import SurfaceDrawing as SurfaceDrawing
from anamorph.methods.pervertex.inconsistency import map_lines as map_lines
from anamorph.methods.pervertex.inconsistency import shown_distances as shown_distances
from anamorph.methods.pervertex.looking import is_bent_in as is_bent_in
from anamorph.methods.pervertex.options import MAXIMUM_BOUNCES as MAXIMUM_BOUNCES
from anamorph.methods.pervertex.options import Options as Options
from anamorph.methods.pervertex.pervertex import METHOD as METHOD
from anamorph.methods.pervertex.seen import Seen as Seen
from anamorph.methods.pervertex.seen import seen_bodies as seen_bodies
from anamorph.methods.pervertex.surroundings import Surroundings as Surroundings
from anamorph.methods.pervertex.surroundings import surroundings_of as surroundings_of
from anamorph.methods.pervertex.warp import MapPlan as MapPlan
