"""All that a user of the viewer can set, as frozen data: whoever changes something makes another state.

Nothing here knows of windows, of imgui or of the device: panel, gestures, shortcuts, tests and saved files all drive
this one state.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum

from anamorph.base.vectors import Vector, tuple_of
from anamorph.methods.specification import Specification
from anamorph.scene.camera import Camera

REFERENCE = Specification.parse("raytrace")
"""The method that errors are measured against, and that the second half shows at first."""

EYE_DISTANCE = 0.065
"""Between the two eyes, metres."""


class Aspect(StrEnum):
    """What is shown of a method."""

    IMAGE = "image"
    ERROR = "error"
    STATUS = "status"
    COUNTS = "counts"


class Drawing(StrEnum):
    """What is drawn into space, over the image."""

    WIREFRAME = "wireframe"
    HITS = "hits"
    VIEWPOINT = "viewpoint"
    VOLUME = "volume"
    REFLECTIONS = "reflections"


class EyeSide(StrEnum):
    """Which eye looks: the one on either side, or one midway between both."""

    LEFT = "left"
    MIDDLE = "middle"
    RIGHT = "right"


@dataclass(frozen=True)
class Half:
    """What one half of the image shows: a method with its options, and an aspect of it."""

    method: Specification
    aspect: Aspect = Aspect.IMAGE


@dataclass(frozen=True)
class State:
    """What the viewer shows.

    Parameters
    ----------
    camera : Camera
        The eye, midway between the two.
    first, second : Half
        Of the image left of the divider, and right of it. Without a split, the first fills the image.
    split : bool
    divider : float
        Its place, as a share of the image's width.
    eye : EyeSide
    observer : Camera or None
        Where the image is taken from, when not from the eye: to look at eye, mirror and rays from outside.
    values : mapping of str to float
        What has been set of the scene's controls, by their keys: see `controls`.
    unit : str
        Of errors: "mrad" or "px".
    drawings : frozenset of Drawing
    samples : int
        A side: when nothing moves, a pixel averages samples x samples images.
    resolution : float
        Pixels of the image for each of the canvas, along one axis, while things move; 0 for as many as keep it
        fluid. When nothing moves, there is one for each.
    panel, help : bool
        Whether these are open.
    opening : str or None
        What is typed so far to name another scene; None while none is asked for.
    picked : (x, y) or None
        The picked point of the image, as shares of its width and height from the top left.
    picked_outside : bool
        Whether that is the observer's image, and not the eye's; only while there are both.
    point : three floats or None
        The world point whose reflection points are shown, metres: what was seen at the picked point of the image. It
        stays as eye and scene move.
    views : tuple of Camera
        What has been remembered, each as `shown_camera` gave it; a path goes through them in their order.
    """

    camera: Camera
    first: Half
    second: Half
    split: bool = False
    divider: float = 0.5
    eye: EyeSide = EyeSide.MIDDLE
    observer: Camera | None = None
    values: Mapping[str, float] = field(default_factory=dict)
    unit: str = "mrad"
    drawings: frozenset[Drawing] = frozenset()
    samples: int = 4
    resolution: float = 0.0
    panel: bool = True
    help: bool = False
    opening: str | None = None
    picked: tuple[float, float] | None = None
    picked_outside: bool = False
    point: Vector | None = None
    views: tuple[Camera, ...] = ()

    @property
    def halves(self) -> tuple[Half, ...]:
        """Those that are seen."""
        return (self.first, self.second) if self.split else (self.first,)


def looking_eye(state: State) -> Camera:
    """The eye that looks: `state.camera`, or one to its side that looks at the same target."""
    if state.eye is EyeSide.MIDDLE:
        return state.camera
    aside = EYE_DISTANCE / 2.0 * (1.0 if state.eye is EyeSide.RIGHT else -1.0)
    return replace(state.camera, position=tuple_of(state.camera.position + aside * state.camera.axes()[0]))


def shown_camera(state: State) -> Camera:
    """Where the image is taken from: the eye that looks, or the observer."""
    return state.observer or looking_eye(state)


def with_picked(state: State, picked: tuple[float, float] | None) -> State:
    """The state with a point of the shown image picked, or with none; it also notes whose image that is.

    Which point of the world is seen there is not known before it is looked into.
    """
    return replace(state, picked=picked, picked_outside=picked is not None and state.observer is not None, point=None)


def with_observer(state: State, observer: Camera | None) -> State:
    """The state with an observer, or without one; a point that was picked in the observer's image goes too."""
    seen = replace(state, observer=observer)
    return with_picked(seen, None) if observer is None and state.picked_outside else seen
