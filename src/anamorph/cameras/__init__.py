"""Nonlinear cameras: ray meshes made by hand and not by optics, to show a scene as no lens does.

Source: Vallance, "Trilinear projection" (PhD thesis, 2005), chapter 6, section 7.4, and the papers that are its
appendices F and G. Each maker returns a `RayMesh`, most of them one that fills an image of a given size, to be drawn by
`anamorph.render(scene, camera=...)`. Shadows and shading are those of the scene; only the rays are the camera's.

| maker | what it shows | source |
| --- | --- | --- |
| `pinhole` | what a `Camera` shows, exactly, by two triangles | chapter 2 |
| `orthographic` | the same without perspective: parallel rays | chapter 2 |
| `perspective` | more perspective, none, or a reversed one, by one number | appendix F |
| `anti_perspective` | what is nearer, smaller: rays that converge in a point before them | appendix G, 4 |
| `pushbroom` | perspective upright, none across: an eye that moves sideways | chapter 2 |
| `panorama` | all around an eye, on a cylinder | |
| `strip` | upright lines that an eye sees on its way from view to view | appendix F, 2.1 |
| `detail_and_context` | the middle magnified, the rim as in perspective, joined smoothly | 6.1 |
| `multi_perspective` | two views of one thing side by side, and what leads from one to the other | 6.2 |
| `inward_sphere` | a map of a thing, seen from all around it | 6.3 |
| `refracting_plane` | what a plane with the normals of a sphere refracts: a lens of one face | 7.4 |
| `from_surface` | what any exact surface sees along its normals | appendix F |
| `from_triangles` | what triangles with normals see | appendix F, 3 |
| `from_rays` | any rays at any places of the image | appendix F, 3 |
| `RaySurface` | surfaces given vertex by vertex, as to OpenGL | appendix F, 3 |
| `real_camera` | what a calibrated camera's lens shows, by its model: see below | |
| `cube_strip` | six faces of a cube around an eye, side by side | |
| `from_function` | any smooth function from image points to rays, divided as finely as it wants | |
| `from_grid` | what the rays of any grid see: what all of these are built on | 5 |

Models of lenses, closed forms both ways: `DistortedPinhole`; `Fisheye`, by its law equidistant, equisolid or
stereographic, with `kannala_brandt`, `f_theta` and `dome_master`; `DoubleSphere`; `UnifiedOmnidirectional`;
`Equirectangular`; `Cylindrical`. Their `Intrinsics` count pixels from the top left corner.
"""

from anamorph.cameras.all_around import Cylindrical as Cylindrical
from anamorph.cameras.all_around import Equirectangular as Equirectangular
from anamorph.cameras.catadioptric import DoubleSphere as DoubleSphere
from anamorph.cameras.catadioptric import UnifiedOmnidirectional as UnifiedOmnidirectional
from anamorph.cameras.detail_and_context import detail_and_context as detail_and_context
from anamorph.cameras.distorted_pinhole import DistortedPinhole as DistortedPinhole
from anamorph.cameras.fisheye import Fisheye as Fisheye
from anamorph.cameras.fisheye import dome_master as dome_master
from anamorph.cameras.fisheye import f_theta as f_theta
from anamorph.cameras.fisheye import kannala_brandt as kannala_brandt
from anamorph.cameras.from_function import from_function as from_function
from anamorph.cameras.grid import from_grid as from_grid
from anamorph.cameras.immediate import RaySurface as RaySurface
from anamorph.cameras.inward_sphere import inward_sphere as inward_sphere
from anamorph.cameras.lens_model import Intrinsics as Intrinsics
from anamorph.cameras.lens_model import LensModel as LensModel
from anamorph.cameras.linear import anti_perspective as anti_perspective
from anamorph.cameras.linear import orthographic as orthographic
from anamorph.cameras.linear import perspective as perspective
from anamorph.cameras.linear import pinhole as pinhole
from anamorph.cameras.linear import pushbroom as pushbroom
from anamorph.cameras.multi_perspective import multi_perspective as multi_perspective
from anamorph.cameras.panorama import panorama as panorama
from anamorph.cameras.ray_sets import from_rays as from_rays
from anamorph.cameras.ray_sets import from_triangles as from_triangles
from anamorph.cameras.real import cube_strip as cube_strip
from anamorph.cameras.real import real_camera as real_camera
from anamorph.cameras.refracting_plane import refracting_plane as refracting_plane
from anamorph.cameras.strip import strip as strip
from anamorph.cameras.surface import from_surface as from_surface
