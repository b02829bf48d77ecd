"""An image with reflection points in it, as the viewer shows them, without a viewer."""

from __future__ import annotations

import numpy as np

from anamorph.base.output import to_pixels
from anamorph.gpu.targets import PIXEL_FORMAT, make_texture, read_texture
from anamorph.projection import camera_projection
from anamorph.scene.camera import Camera
from anamorph.viewer.canvas import Painter
from anamorph.viewer.compose import FalseColorTexture, Shown
from anamorph.viewer.facts import Reflections
from anamorph.viewer.numbers import numbered, numbers_of
from anamorph.viewer.space import reflection_marks


def marked_image(color: np.ndarray, camera: Camera, reflections: Reflections) -> np.ndarray:
    """A camera's image with the paths over reflection points and their numbers.

    Parameters
    ----------
    color : (H, W, 3) float32
        Linear.
    camera : Camera
    reflections : Reflections

    Returns
    -------
    (H, W, 3) uint8
        sRGB.
    """
    height, width = color.shape[:2]
    pixels = np.full((height, width, 4), 255, np.uint8)
    pixels[..., :3] = to_pixels(color)
    painter, target = Painter(PIXEL_FORMAT), make_texture((width, height), PIXEL_FORMAT)
    painter.lines.upload(reflection_marks(reflections))
    shown = (Shown(false_color=FalseColorTexture().write(pixels)),)
    clip = camera_projection(camera, (width, height)).clip
    painter.draw(target, (0, 0, width, height), shown, 0.5, clip, 1.0)
    return numbered(read_texture(target)[..., :3], numbers_of(reflections, camera, (width, height)))
