"""What a surface does to one ray of light: reflection, refraction, and how much of it goes which way."""

from __future__ import annotations

import numpy as np


def reflect(incident: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Directions after a mirror: r = i - 2 (n.i) n.

    Parameters
    ----------
    incident : (N, 3) array
        Unit directions, pointing at the surface.
    normal : (N, 3) array
        Unit normals, of either side.

    Returns
    -------
    (N, 3) float64
        Unit directions.
    """
    incident, normal = np.asarray(incident, float), np.asarray(normal, float)
    return incident - 2.0 * np.sum(normal * incident, axis=-1, keepdims=True) * normal


def refract(incident: np.ndarray, normal: np.ndarray, eta: float | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Directions behind an interface, by Snell's law: t = eta i + (eta cos_i - cos_t) n.

    Parameters
    ----------
    incident : (N, 3) array
        Unit directions, pointing at the surface.
    normal : (N, 3) array
        Unit normals, against `incident`.
    eta : float or (N,) array
        Refractive index on the incident side over the index on the other side.

    Returns
    -------
    direction : (N, 3) float64
        Unit directions: refracted, or reflected where reflection is total.
    total : (N,) bool
        Where no light passes.
    """
    incident, normal = np.asarray(incident, float), np.asarray(normal, float)
    eta = np.broadcast_to(np.asarray(eta, float), incident.shape[:-1])
    cosine = -np.sum(normal * incident, axis=-1)
    # The sine from the tangential part keeps its digits at normal incidence, where 1 - cos^2 loses them.
    tangential = incident + cosine[..., None] * normal
    transmitted = 1.0 - eta**2 * np.sum(tangential**2, axis=-1)
    total = transmitted < 0.0
    direction = eta[..., None] * tangential - np.sqrt(np.maximum(transmitted, 0.0))[..., None] * normal
    return np.where(total[..., None], reflect(incident, normal), direction), total


def fresnel(eta: float | np.ndarray, cosine: np.ndarray) -> np.ndarray:
    """The share of unpolarised light that a clear interface reflects, by Fresnel's equations.

    Parameters
    ----------
    eta : float or (N,) array
        Refractive index on the incident side over the index on the other side.
    cosine : (N,) array
        Cosine between the incident ray and the normal, 0 to 1.

    Returns
    -------
    (N,) float64
        1 where reflection is total.
    """
    eta, cosine = np.asarray(eta, float), np.asarray(cosine, float)
    transmitted = np.sqrt(np.maximum(1.0 - eta**2 * (1.0 - cosine**2), 0.0))
    # Zero over zero happens at grazing incidence on an interface that is none (eta = 1).
    across, along = np.maximum(eta * cosine + transmitted, 1e-300), np.maximum(cosine + eta * transmitted, 1e-300)
    return 0.5 * (((eta * cosine - transmitted) / across) ** 2 + ((cosine - eta * transmitted) / along) ** 2)
