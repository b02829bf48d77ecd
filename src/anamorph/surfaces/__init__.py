"""Exact surfaces, which meshes approximate. To add another surface, follow `base`.

| module | what it holds |
| --- | --- |
| `base` | what every surface says of itself: position, normal, curvatures, parameters, motion |
| `plane`, `sphere` | those of closed form |
| `sag`, `toroid`, `even_asphere` | lens faces, given by their depth below the plane that touches their apex |
| `patch`, `bezier`, `nurbs` | surfaces of CAD and of modelling, by two parameters with derivatives |
| `intersection` | where rays meet any of them, and the registry by which compiled loops know them |
| `sag_search`, `patch_search` | the two Newton iterations with which they are met |
| `nurbs_pieces`, `bsplines` | NURBS as polynomials in one array, and their basis |
| `device_numbers` | their numbers as the device reads them, in a frame that is near and as large as their mesh |
| `meet.wgsl` | where rays meet them on the device, by `closed_form.wgsl`, `height.wgsl` and `patch.wgsl` |
| `axes`, `similarity` | a surface's own axes, and motions |
"""
