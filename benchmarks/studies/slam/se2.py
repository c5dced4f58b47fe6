# SPDX-License-Identifier: MIT
"""Poses x, y [m], psi [rad] of the plane, as algebra: all functions broadcast over leading axes."""

import numpy as np

from seatrial.util.frames import Array


def turned(angle: Array) -> Array:
    """Angles in [-pi, pi)."""
    return np.asarray((np.asarray(angle) + np.pi) % (2.0 * np.pi) - np.pi)


def transform(pose: Array, points: Array) -> Array:
    """Points (..., 2) of the pose's frame in the frame that the pose (..., 3) is given in."""
    c, s = np.cos(pose[..., 2]), np.sin(pose[..., 2])
    x, y = points[..., 0], points[..., 1]
    return np.stack([pose[..., 0] + c * x - s * y, pose[..., 1] + s * x + c * y], axis=-1)


def compose(a: Array, b: Array) -> Array:
    """T_a T_b (..., 3)."""
    place = transform(a, b[..., :2])
    return np.concatenate([place, turned(a[..., 2] + b[..., 2])[..., None]], axis=-1)


def inverse(a: Array) -> Array:
    """T_a^-1 (..., 3)."""
    c, s = np.cos(a[..., 2]), np.sin(a[..., 2])
    x, y = a[..., 0], a[..., 1]
    return np.stack([-c * x - s * y, s * x - c * y, -np.asarray(a[..., 2])], axis=-1)


def between(a: Array, b: Array) -> Array:
    """T_a^-1 T_b (..., 3): b seen from a."""
    return compose(inverse(a), b)


def exponential(twist: Array) -> Array:
    """Where a constant body-fixed velocity (..., 3) leads in a unit of time: an arc."""
    angle = twist[..., 2]
    small = np.abs(angle) < 1e-6
    safe = np.where(small, 1.0, angle)
    along = np.where(small, 1.0, np.sin(safe) / safe)
    aside = np.where(small, 0.5 * angle, (1.0 - np.cos(safe)) / safe)
    u, v = twist[..., 0], twist[..., 1]
    return np.stack([along * u - aside * v, aside * u + along * v, angle], axis=-1)


def logarithm(pose: Array) -> Array:
    """The constant body-fixed velocity (..., 3) that leads there in a unit of time."""
    angle = turned(pose[..., 2])
    half = 0.5 * angle
    small = np.abs(angle) < 1e-6
    scale = np.where(small, 1.0, half / np.where(small, 1.0, np.tan(half)))
    x, y = pose[..., 0], pose[..., 1]
    return np.stack([scale * x + half * y, scale * y - half * x, angle], axis=-1)
