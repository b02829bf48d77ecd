"""Real cameras in the scene: a lens model where a `Camera` stands, and the strip of a cube's six faces."""

from __future__ import annotations

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.cameras.all_around import Cylindrical, Equirectangular
from anamorph.cameras.from_function import from_function
from anamorph.cameras.grid import Size, checked_size, from_grid, grid_points
from anamorph.cameras.lens_model import Intrinsics, LensModel
from anamorph.raymesh import RayMesh, RayStatus
from anamorph.scene.camera import Camera
from anamorph.scene.checks import check_camera

FACES = np.array(
    [
        [(0, 0, -1), (0, 1, 0), (1, 0, 0)],
        [(0, 0, 1), (0, 1, 0), (-1, 0, 0)],
        [(1, 0, 0), (0, 0, -1), (0, 1, 0)],
        [(1, 0, 0), (0, 0, 1), (0, -1, 0)],
        [(1, 0, 0), (0, 1, 0), (0, 0, 1)],
        [(-1, 0, 0), (0, 1, 0), (0, 0, -1)],
    ],
    float,
)
"""Right, up and forward of each face, by the camera's right, up and forward."""


def real_camera(model: LensModel, camera: Camera, size: Size, tolerance: float = 0.1, holes: bool = False) -> RayMesh:
    """What a real camera's lens shows from where `camera` stands, which gives place, target and up.

    Parameters
    ----------
    model : LensModel
        `DistortedPinhole`, `Fisheye`, `DoubleSphere`, `UnifiedOmnidirectional`, `Equirectangular`, `Cylindrical`, or
        one of one's own.
    camera : Camera
        Its field of view is not read.
    size : (width, height)
        Pixels: those for which the camera is calibrated.
    tolerance : float
        How far an interpolated ray may be from the model's, pixels.
    holes : bool
        Whether pixels may see nothing because the distortion folds back there. They are holes then, as those beyond
        the field of view always are.

    Returns
    -------
    RayMesh
        Vertices that see nothing are FOLDED or OUTSIDE; triangles have none of them.

    Raises
    ------
    AnamorphError
        Where the distortion folds back inside the image and `holes` is false, and where the size does not fit.
    """
    check_camera(camera, "camera")
    _check_size(model, checked_size(size))
    axes = camera.axes() * np.array([[1.0], [-1.0], [1.0]])
    position = np.asarray(camera.position, float)

    def rays(points: np.ndarray) -> tuple[np.ndarray, ...]:
        directions, status = model.rays(points)
        return np.broadcast_to(position, directions.shape), directions @ axes, status

    # Not the grid's vertices alone: a fold may lie between them.
    _, status = model.rays(grid_points(size, (64, 64)).reshape(-1, 2))
    folded = float(np.mean(status == RayStatus.FOLDED))
    if folded and not holes:
        raise AnamorphError(
            f"camera: the distortion folds back in {folded:.1%} of the image, which sees nothing; "
            "calibrate again or give holes=True"
        )
    return from_function(rays, size, tolerance)


def cube_strip(camera: Camera, side: int) -> RayMesh:
    """Six square images of `side` pixels side by side: right, left, up, down, ahead and back, 90 degrees each.

    They are a cube map's faces in its order, each seen from inside; up has what is behind at its top and down what is
    ahead. Each is exact by two triangles.
    """
    check_camera(camera, "camera")
    side = checked_size((side, side))[0]
    corners = (grid_points((side, side), (1, 1)) / side - 0.5) * (2.0, -2.0)
    faces = []
    for number, (right, above, ahead) in enumerate(FACES @ camera.axes()):
        directions = corners[..., :1] * right + corners[..., 1:] * above + ahead
        face = from_grid(np.broadcast_to(camera.position, directions.shape), directions, (side, side))
        face.image[:, 0] += number * side
        faces.append(face)
    return RayMesh(
        image=np.concatenate([face.image for face in faces]),
        origins=np.concatenate([face.origins for face in faces]),
        directions=np.concatenate([face.directions for face in faces]),
        faces=np.concatenate([face.faces + 4 * number for number, face in enumerate(faces)]),
        status=np.concatenate([face.status for face in faces]),
    )


def _check_size(model: LensModel, size: Size) -> None:
    intrinsics = getattr(model, "intrinsics", None)
    if isinstance(intrinsics, Intrinsics):
        intrinsics.check_size(size)
    if isinstance(model, Equirectangular | Cylindrical) and tuple(model.size) != size:
        raise AnamorphError(f"camera: size is {size[0]} x {size[1]}, and the model's {model.size}; give the same twice")
