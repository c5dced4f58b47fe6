# SPDX-License-Identifier: MIT
"""Quaternions x y z w, as arrays (n, 4)."""

import numpy as np

from seatrial.util.frames import Array

SMALL_ANGLE = 1e-4  # [rad] between two rotations: below it linear interpolation is exact enough


def yaw(quaternion: Array) -> Array:
    """Heading (n,) [rad] of quaternions (n, 4) of any length; NaN for zero ones."""
    x, y, z, w = unit(quaternion).T
    return np.asarray(np.arctan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z))


def unit(q: Array) -> Array:
    """Quaternions (n, 4) of length 1; NaN for those without a direction."""
    with np.errstate(invalid="ignore", divide="ignore"):
        # so that squares neither overflow nor underflow
        scaled = q / np.max(np.abs(q), axis=1, keepdims=True)
        return np.asarray(scaled / np.linalg.norm(scaled, axis=1, keepdims=True))


def product(a: Array, b: Array) -> Array:
    """Rotations a after b (n, 4)."""
    ax, ay, az, aw = a.T
    bx, by, bz, bw = b.T
    return np.column_stack(
        [
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        ]
    )


def rotated(q: Array, vector: Array) -> Array:
    """Vectors (n, 3) rotated by quaternions (n, 4)."""
    of_one = unit(q)
    axis = 2.0 * np.cross(of_one[:, :3], vector)
    return np.asarray(vector + of_one[:, 3:] * axis + np.cross(of_one[:, :3], axis))


def slerp(a: Array, b: Array, share: Array) -> Array:
    """Rotations (n, 4) on the shorter arc from a to b, at shares (n, 1) of it."""
    a, b = unit(a), unit(b)
    near = np.sum(a * b, axis=1, keepdims=True)
    b, near = np.where(near < 0, -b, b), np.minimum(np.abs(near), 1.0)
    angle = np.arccos(near)
    arc = np.where(angle > SMALL_ANGLE, angle, 1.0)
    left, right = np.sin((1 - share) * arc) / np.sin(arc), np.sin(share * arc) / np.sin(arc)
    straight = angle <= SMALL_ANGLE
    return np.asarray(np.where(straight, a + share * (b - a), left * a + right * b))


def of_angles(angles: Array, order: str = "xyz") -> Array:
    """Rotations (n, 4) by angles (n, 3) [rad] about x, y and z, in this order, each about the turned axis."""
    q = np.tile([0.0, 0.0, 0.0, 1.0], (len(angles), 1))
    for axis in ("xyz".index(letter) for letter in order):
        one = np.zeros_like(q)
        one[:, axis], one[:, 3] = np.sin(angles[:, axis] / 2), np.cos(angles[:, axis] / 2)
        q = product(q, one)
    return q


def of_matrix(columns: Array) -> Array:
    """Rotations (n, 4) of matrices (n, 9), column by column; NaN for those that are zero or NaN."""
    a, d, g, b, e, h, c, f, i = columns.T  # rows a b c, d e f, g h i
    x, y, z, w = 1 + a - e - i, 1 - a + e - i, 1 - a - e + i, 1 + a + e + i
    by_part = np.array([
        [x, b + d, c + g, h - f],
        [b + d, y, f + h, c - g],
        [c + g, f + h, z, d - b],
        [h - f, c - g, d - b, w],
    ])  # fmt: skip
    largest = np.argmax(np.array([x, y, z, w]), axis=0)
    found = unit(by_part[largest, :, np.arange(len(columns))])
    return np.where((columns == 0.0).all(axis=1)[:, None], np.nan, found)
