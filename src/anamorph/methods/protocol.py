"""What a method is: a name, its options, and what opens a session. docs/methods.md says how to add one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from anamorph.frame import View
from anamorph.methods.session import Session


@dataclass(frozen=True)
class Method:
    """A registered method.

    Parameters
    ----------
    name : str
    summary : str
        One line for lists.
    source : str
        The paper and sections it builds on.
    options : type
        A frozen dataclass whose fields have defaults and are bool, int, float or str. Those that `options.option`
        makes say what they may be, which `options.check_options` holds them to, and its docstring says what they mean.
    open : callable
        (View, options) -> Session.
    refracts : bool
        Whether it draws scenes with glass.
    ray_meshes : bool
        Whether its camera may be a ray mesh.
    """

    name: str
    summary: str
    source: str
    options: type
    open: Callable[[View, Any], Session]
    refracts: bool = False
    ray_meshes: bool = False
