"""Virtual objects: every triangle of the scene looks for where the eye sees it in mirrors and lenses.

Source: Estalella, Martin, Drettakis, Tost, Devillers and Cazals, "Accurate interactive specular reflections on curved
objects" (2005). A shader that is not listed has the name of its module.

By default, `search=tiles`, triangles look for the rays that may meet them:

| what | module |
| --- | --- |
| draw mirrors and lenses: each sample's own ray | `leaving_rays` |
| bound the rays of each tile of samples, and of many | `tiles.wgsl`, `tile_tree` |
| which tiles may see each triangle | `triangle_tree`, `listing` |
| what each sample's ray meets of its tile's triangles; what stands still is kept | `meeting_rays`: `met.wgsl` |
| the scene's triangles, and which of them move | `triangle_records`, `moving_scene` |

With `search=cubemap`, the paper's way, vertices look for their one reflection point on each mirror:

| section of the paper | what | module |
| --- | --- | --- |
| 4.1 | cube maps of a reflector's positions and normals | `reflector_maps` |
| 4.2, 4.3, 6.1 | the search on these maps, also for what a reflector hides | `cube_search`, `device_search` |
| 5 | grids, between whose corners vertices are interpolated | `mesh_grid`, `octree` |
| | which vertices are searched for | `grid_search`, `interpolated.wgsl` |
| 3 | draw the virtual objects, and put them where the mirrors are seen | `virtual_meshes`, `shown_meshes.wgsl` |
| | a frame of both | `virtual` |
"""

from anamorph.methods.virtual.virtual import METHOD as METHOD
from anamorph.methods.virtual.virtual import Options as Options
