# SPDX-License-Identifier: MIT
"""Thrust allocation: thruster geometry to T and T+, wrench command F to thruster commands f."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from seatrial.util.errors import VehicleError
from seatrial.util.frames import AXES, Array

ROUND_ANGLE = np.pi / 12  # [rad] 15 deg: steps of usual thruster angles
ROUND_PART = 0.02  # of such a step, distance of a round angle in radians
ROUND_DEGREES = 0.01  # [deg] distance of a round angle in degrees
ROUNDING = 1e-12  # of geometry and inverse, below which an entry is 0


class Scheme(str, Enum):
    """Method from a wrench command to thruster commands."""

    DIRECT = "direct"  # the commands are the actuators' own
    MP = "moore-penrose"  # f = T+ F, Eq. (10)
    AF = "always-forward"  # Table I and Eq. (11)

    @property
    def code(self) -> int:
        """The core's number for it."""
        return list(Scheme).index(self)


@dataclass(frozen=True)
class Thruster:
    """Position [m] and direction of thrust [rad] in forward-left-up body axes."""

    name: str
    x: float
    y: float
    angle: float  # from forward, towards left


def angle_remarks(angles_deg: Sequence[float]) -> tuple[str, ...]:
    """A warning where angles that should be in degrees are round in radians, and not all in degrees."""
    angles = np.array([angle for angle in angles_deg if angle])
    parts = np.abs(angles) / ROUND_ANGLE
    round_ones = (np.abs(parts - np.rint(parts)) < ROUND_PART) & (parts > 0.5) & (parts < 24.5)
    if not round_ones.all() or np.all(np.abs(angles - np.rint(angles)) < ROUND_DEGREES):
        return ()
    shown = ", ".join(f"{angle:g}" for angle in angles)
    return (f"angle_deg is in degrees, but {shown} look like radians (0.785 is 45 deg)",)


def thruster_matrix(
    thrusters: Sequence[Thruster], source: str = "", side: float = 1.0
) -> tuple[Array, Array]:
    """T (3, n) in command units and the scale (3,) that made it of the geometry.

    Row j of T is the geometric row (cos a; sin a; x sin a - y cos a) divided by its norm, so that
    MallARD's T is S / 2 with the sign matrix S of Table I. X_F, Y_F and N_F carry the scale.
    source, side: the vehicle file and the sign of its second axis to the left, for the error.
    """
    angle = np.array([t.angle for t in thrusters])
    x = np.array([t.x for t in thrusters])  # [m]
    y = np.array([t.y for t in thrusters])  # [m]
    geometry = np.vstack([np.cos(angle), np.sin(angle), x * np.sin(angle) - y * np.cos(angle)])
    geometry[np.abs(geometry) < ROUNDING] = 0.0
    scale = np.linalg.norm(geometry, axis=1)
    if np.linalg.matrix_rank(geometry, tol=1e-9) < 3:
        where = f"{source}: " if source else ""
        raise VehicleError(
            f"{where}thrusters: these {len(thrusters)} can't actuate surge, sway and yaw independently "
            "(rank of the geometry below 3); check their positions and angles. Where they are right, write in "
            f"place of thrusters: {_forces_text([t.name for t in thrusters], geometry * [[1.0], [side], [side]])}"
        )
    return geometry / scale[:, None], scale


def _forces_text(names: Sequence[str], geometry: Array) -> str:
    """`forces` of the vehicle file, on the axes that the thrusters act on. geometry: (3, n)."""
    forces = []
    for name, axis, row in zip(("F_u", "F_v", "F_r"), AXES, geometry, strict=True):
        of = ", ".join(f"{n}: {w:.4g}" for n, w in zip(names, row, strict=True) if w)
        forces += [f"{name}: {{axis: {axis}, of: {{{of}}}}}"] if of else []
    return f"forces: {{{', '.join(forces)}}}"


def inverse_for(scheme: Scheme, T: Array) -> Array:
    """T+ (n, 3); refuses a geometry for which the scheme does not give the commanded wrench."""
    inverse = np.linalg.pinv(T)
    inverse[np.abs(inverse) < ROUNDING] = 0.0
    if scheme is Scheme.AF:
        for sign in (1.0, -1.0):  # T max(0, +-2 T+_j) must be +-e_j
            given = T @ np.maximum(0.0, 2.0 * sign * inverse)
            if not np.allclose(given, sign * np.eye(3), atol=1e-9):
                raise VehicleError(
                    "allocation: always-forward needs thrusters whose forces cancel at equal "
                    "commands, as MallARD's four do; these do not: use moore-penrose"
                )
        if not np.allclose(T.sum(axis=1), 0.0, atol=1e-9):
            raise VehicleError(
                "allocation: always-forward leaves a wrench at rest with these thrusters; "
                "use moore-penrose"
            )
    return np.asarray(inverse, dtype=np.float64)


def with_shared_forces(T: Array) -> list[list[int]]:
    """Groups of two or more actuators with forces in common, directly or through others. T (forces, actuators)."""
    found: list[set[int]] = []
    for row in np.abs(T) > 0.0:
        own = set(np.flatnonzero(row).tolist())
        near = [kind for kind in found if kind & own]
        found = [kind for kind in found if not kind & own] + [own.union(*near)]
    return [sorted(kind) for kind in found if len(kind) > 1]
