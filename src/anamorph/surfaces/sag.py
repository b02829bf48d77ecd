"""Surfaces that are given by their sag: how deep they lie below the plane that touches their apex."""

from __future__ import annotations

from abc import abstractmethod
from typing import Self

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.surfaces.axes import check_axes
from anamorph.surfaces.base import Surface


class SagSurface(Surface):
    """position = apex + u right + v up - sag(u, v) outward, with u and v in metres.

    A surface of this kind is a frozen dataclass with the fields `apex` (3,) and `axes` (3, 3), whose rows are the unit
    vectors right, up and outward at the apex. Positive curvatures bulge outward.
    """

    metric = True

    apex: np.ndarray
    axes: np.ndarray

    @property
    @abstractmethod
    def shape(self) -> tuple[float, ...]:
        """The numbers of its sag, as its compiled sag reads them."""

    @property
    @abstractmethod
    def apex_curvatures(self) -> tuple[float, ...]:
        """Those at the apex that can be told apart, 1/m: one where it is round, else along right and along up."""

    @abstractmethod
    def with_apex_curvatures(self, curvatures: tuple[float, ...]) -> Self:
        """The surface with other curvatures at its apex, and all else as it is."""

    @abstractmethod
    def sag(self, uv: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The sag, (N,), and its slopes along u and v, (N, 2)."""

    @property
    def numbers(self) -> np.ndarray:
        return np.concatenate([self.apex, np.ravel(self.axes), self.shape])

    def position(self, uv: np.ndarray) -> np.ndarray:
        local = np.column_stack([uv, -self.sag(uv)[0]])
        return np.asarray(self.apex, float) + local @ np.asarray(self.axes, float)

    def normal(self, uv: np.ndarray) -> np.ndarray:
        slopes = self.sag(uv)[1]
        normal = np.column_stack([slopes, np.ones(len(slopes))]) @ np.asarray(self.axes, float)
        return normal / np.linalg.norm(normal, axis=1, keepdims=True)

    def parameters(self, points: np.ndarray, near: np.ndarray | None = None) -> np.ndarray:
        """The (u, v), (N, 2) float64, of the surface points above or below `points` (N, 3)."""
        return (np.asarray(points, float) - self.apex) @ np.asarray(self.axes, float)[:2].T


def check_sag(name: str, surface: SagSurface) -> None:
    """Refuse a surface without a place, a shape or axes; `name` is for messages."""
    if np.shape(surface.apex) != (3,) or not np.isfinite(surface.apex).all():
        raise AnamorphError(f"{name}: apex is {surface.apex}; give three finite numbers in metres")
    if not np.isfinite(surface.shape).all():
        raise AnamorphError(f"{name}: its shape has the numbers {surface.shape}; give finite ones")
    check_axes(name, surface.axes)


def root(name: str, square: np.ndarray) -> np.ndarray:
    """Square roots in the formula of a sag; where there is none, the surface does not reach so far from its apex."""
    if (square <= 0.0).any():
        raise AnamorphError(f"{name}: has no points so far from its apex; keep closer to it, or make it flatter")
    return np.sqrt(square)
