"""Virtual objects: every triangle of the scene looks for where the eye sees it in mirrors and lenses.

Source: Estalella, Martin, Drettakis, Tost, Devillers and Cazals, "Accurate interactive specular reflections on curved
objects" (2005). A shader that is not listed has the name of its module.

| what | module |
| --- | --- |
| draw mirrors and lenses: each sample's own ray | `leaving_rays` |
| bound the rays of each tile of samples, and of many | `tiles.wgsl`, `tile_tree` |
| which tiles may see each triangle | `triangle_tree`, `listing` |
| what each sample's ray meets of its tile's triangles; what stands still is kept | `meeting_rays`: `met.wgsl` |
| the scene's triangles, and which of them move | `triangle_records`, `moving_scene` |
| a frame | `virtual` |
"""

from anamorph.methods.virtual.virtual import METHOD as METHOD
from anamorph.methods.virtual.virtual import Options as Options
