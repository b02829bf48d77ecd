"""Frames with closed forms, and sessions that need no device: what the tests of measuring are made of."""

from __future__ import annotations

import numpy as np

from anamorph.frame import Frame
from anamorph.scene.camera import Camera

SIZE = (48, 32)
WALL = 9.0


def plane_truth(size: tuple[int, int] = SIZE, sky: bool = False) -> Frame:
    """A mirror in the plane z = 0 seen from one metre, in a pinhole camera; it shows a wall at z = 9 m, or the sky."""
    width, height = size
    x, y = np.meshgrid((np.arange(width) + 0.5 - width / 2) / 50.0, (height / 2 - np.arange(height) - 0.5) / 50.0)
    origin = np.stack([x, y, np.zeros_like(x)], axis=-1)
    direction = np.stack([x, y, np.ones_like(x)], axis=-1)
    direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
    position = direction if sky else origin + WALL * direction / direction[..., 2:]
    return frame_of(position, 0 if sky else 5, origin, direction)


def sphere_truth(radius: float = 1.4) -> Frame:
    """A convex sphere touching z = 0, seen by parallel rays along -z that are 1 mm apart; it shows a wall at z = 9."""
    width, height = SIZE
    x, y = np.meshgrid(np.arange(width) - width / 2 + 0.5, np.arange(height) - height / 2 + 0.5)
    x, y = 0.001 * x, 0.001 * y
    normal = np.stack([x, y, np.sqrt(radius**2 - x**2 - y**2)], axis=-1) / radius
    origin = radius * normal - [0.0, 0.0, radius]
    direction = 2.0 * normal[..., 2:] * normal - [0.0, 0.0, 1.0]
    position = origin + (WALL - origin[..., 2:]) / direction[..., 2:] * direction
    return frame_of(position, 5, origin, direction)


def frame_of(position: np.ndarray, object_id: int, origin: np.ndarray, direction: np.ndarray) -> Frame:
    shape = position.shape[:2]
    return Frame(
        color=np.full((*shape, 3), 0.5, np.float32),
        position=position.astype(np.float32),
        object_id=np.full(shape, object_id, np.uint32),
        specular=np.full(shape, 7, np.uint32),
        status=np.zeros(shape, np.uint8),
        ray_origin=origin.astype(np.float32),
        ray_direction=direction.astype(np.float32),
    )


class FakeSession:
    """A session that shows one frame, and remembers what was asked of it."""

    def __init__(self, frame: Frame) -> None:
        self.shown = frame
        self.calls: list[str] = []
        self.eyes: list[tuple[float, float, float]] = []

    def draw(self, camera: Camera, shift: tuple[float, float] = (0.0, 0.0)) -> None:
        self.calls.append("draw")
        self.eyes.append(camera.position)

    def deform(self, positions: np.ndarray, normals: np.ndarray) -> None:
        self.calls.append("deform")

    def wait(self) -> None:
        self.calls.append("wait")

    def frame(self, seen: bool = False) -> Frame:
        self.calls.append("frame")
        return self.shown if seen else Frame(self.shown.color)
