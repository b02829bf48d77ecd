"""What the viewer tells its user: what panel and reports show, gathered once a frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from anamorph.measure.errors import Statistics
from anamorph.methods.specification import Specification
from anamorph.reflections.reflection_points import ReflectionStatus
from anamorph.scene.camera import Camera
from anamorph.scene.model import Scene

Vector = tuple[float, float, float]
Rectangle = tuple[float, float, float, float]
"""Left, top, right, bottom, in logical pixels of the canvas."""


class Request(StrEnum):
    """What a user can ask for that is no state."""

    SAVE_IMAGE = "save-image"
    SAVE_SCENE = "save-scene"
    SAVE_COMPARISON = "save-comparison"
    SAVE_TURNTABLE = "save-turntable"
    SAVE_TURNTABLE_SERIES = "save-turntable-series"
    SAVE_PATH = "save-path"
    SAVE_PATH_SERIES = "save-path-series"
    CANCEL = "cancel"
    DISMISS = "dismiss"


@dataclass(frozen=True)
class Stop:
    """Where a path meets something: the object's name ("eye", a mesh's, or "sky"), and the world point, metres."""

    name: str
    point: Vector


@dataclass(frozen=True)
class Inspection:
    """What is seen at one pixel.

    Parameters
    ----------
    pixel : (x, y)
        Whole pixels of the image from its top left.
    method : Specification
    seen : str
        The object's name, or "sky", or "nothing".
    point : three floats or None
        World point that the method shows, metres; None for the sky.
    distance : float or None
        Along the path from the eye to what is seen, metres; None for the sky.
    status : str
        How the pixel got its value.
    path : tuple of Stop
        The true path, from the eye over each specular surface to its end; a path into the sky ends some way along.
    reference : str
        The name of what is there in truth.
    angular_mrad, pixels : float or None
        The error there; None where it is not measured: the pixel looks at no specular surface.
    silhouette : bool
        Whether the pixel is within one pixel of a silhouette in the reference, where errors count apart.
    """

    pixel: tuple[int, int]
    method: Specification
    seen: str
    point: Vector | None
    distance: float | None
    status: str
    path: tuple[Stop, ...]
    reference: str
    angular_mrad: float | None
    pixels: float | None
    silhouette: bool


@dataclass(frozen=True)
class Reflection:
    """One of the reflection points or refraction points of a point.

    Parameters
    ----------
    name : str
        Of the mirror, or of the face of a lens that the eye looks at.
    path : tuple of three floats each
        Where on it, metres; through a lens, where on both faces.
    pixel : (x, y) or None
        Where the eye's image shows it, from the image's top left, which need not be inside; None behind the eye.
    length : float
        Of the path from the eye to the point, metres; in glass times the refractive index.
    order : int
        1 where the point is seen the right way round, -1 where it is seen mirrored, 0 at a focus.
    hidden : bool
        Whether something stands in the path.
    """

    name: str
    path: tuple[Vector, ...]
    pixel: tuple[float, float] | None
    length: float
    order: int
    hidden: bool


@dataclass(frozen=True)
class Reflections:
    """Where the mirrors and lenses of a scene show a point to the eye.

    Parameters
    ----------
    point : three floats
        Metres.
    eye : three floats
        Metres.
    status : ReflectionStatus
        What is known of them all.
    found : tuple of Reflection
        By the length of their paths.
    """

    point: Vector
    eye: Vector
    status: ReflectionStatus
    found: tuple[Reflection, ...]


@dataclass(frozen=True)
class Figures:
    """The errors of what one half shows, and how its specular pixels got their value."""

    angular_mrad: Statistics
    pixels: Statistics
    other_object_percent: float | None
    status_percent: Mapping[str, float]


@dataclass(frozen=True)
class Progress:
    """Of something long that runs."""

    what: str
    done: int
    total: int


@dataclass(frozen=True)
class Facts:
    """What there is to tell.

    Parameters
    ----------
    scene : Scene
        As it was opened, before any control.
    size : (width, height)
        Of the canvas, logical pixels.
    image : (width, height)
        Of what was drawn last, pixels.
    full : (width, height)
        Of an image at full resolution, pixels.
    adapter : str
    frame_ms : float
        What the last image of several that moved took to draw; 0 before there are two.
    phases_ms : mapping of str to float
        What the last frame's time went to.
    samples_done, samples_total : int
        Of the image at rest: how many images it averages so far, and will.
    figures : tuple of Figures or None
        Of the halves, once measured.
    inspection : Inspection or None
    reflections : Reflections or None
        Of the state's point.
    searching : bool
        Whether reflection points are still searched for: these, or those of the vertices that are counted.
    message : str
        What went wrong, or has been done; may be empty.
    progress : Progress or None
    home : Camera or None
        The eye that a reset returns to; None for the scene's own.
    """

    scene: Scene
    size: tuple[int, int]
    image: tuple[int, int]
    full: tuple[int, int]
    adapter: str
    frame_ms: float = 0.0
    phases_ms: Mapping[str, float] = field(default_factory=dict)
    samples_done: int = 0
    samples_total: int = 0
    figures: tuple[Figures | None, ...] = ()
    inspection: Inspection | None = None
    reflections: Reflections | None = None
    searching: bool = False
    message: str = ""
    progress: Progress | None = None
    home: Camera | None = None
