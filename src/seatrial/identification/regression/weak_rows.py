# SPDX-License-Identifier: MIT
"""Rows of the weak form: the equations of motion multiplied by smooth test functions.

With p'' the earth-fixed acceleration, R of Eq. (1) and z = x + i y, Eq. (12) in the plane is

    p'' = R(psi) (g_u + i g_v) + i r p'        psi'' = g_r        g: sums of terms, linear in theta

Both sides are multiplied by phi(t - c) and integrated. On the left, integration by parts moves the derivative to
phi: -int phi' p'. p' is the slope of local quadratics, which is the true velocity averaged by a known kernel
kappa; so the thrust, which the smoothed state does not contain, is averaged by kappa too (both sides through the
same filter: weak-form SINDy, Messenger and Bortz 2021; Shinbrot 1957). The rows of a window are turned by its own
heading at c, a constant, into surge and sway.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from seatrial import _core
from seatrial.boat.model import thrust_trace
from seatrial.boat.structure import VELOCITIES
from seatrial.boat.vehicle import Vehicle
from seatrial.inspection.consistency.accelerations import Complex, smooth, smooth_poses
from seatrial.recording.pose_noise import pose_noise
from seatrial.recording.recording import Recording
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array, Mask

VELOCITY_NOISE_SHARE = 0.05  # of the RMS speed: noise that smoothed velocities may have
ACCELERATION_NOISE_SHARE = 0.06  # of the RMS acceleration: noise that the left side may have
LARGEST_STATE_WIDTH = 0.6  # [s]
FEWEST_STATE_POSES = 2.0  # half-length of a local quadratic in poses, at the least
TEST_WIDTH_RANGE = (0.4, 1.5)  # [s]
BRIDGED_PERIODS = 2.5  # median periods between smoothed poses that interpolation may bridge


@dataclass(frozen=True)
class Widths:
    """Half-lengths [s] of the smoothing kernels."""

    state: float  # of the local quadratics
    test: float  # of the test functions


@dataclass(frozen=True)
class Kernels:
    """Weights on an even grid, all of one odd length; their sums are the integrals."""

    step: float  # [s] of the grid
    stride: int  # grid steps from one window to the next
    test: Array  # (k,) phi
    slope: Array  # (k,) -phi'
    driven: Array  # (k,) phi averaged by kappa

    @property
    def support(self) -> Mask:
        """Grid points of a window at which the state enters."""
        return self.test > 0


def choose_widths(recordings: Sequence[Recording]) -> Widths:
    """The narrowest widths that keep the noise small against the excitation, common to plane and heading.

    A local quadratic through n poses has a slope with noise sigma sqrt(12 / n^3) / period; the
    second derivative of a test function of half-length h takes white noise to
    sigma sqrt(22.5 period / h^5).
    """
    noise = pose_noise(*recordings)
    period = float(np.median([r.period for r in recordings]))
    parts = [smooth(r) for r in recordings]
    if not any(len(p.t) for p in parts):
        names = ", ".join(r.name for r in recordings)
        raise IdentificationError(
            f"{names}: no second without drop-outs; record longer, or look for "
            "drop-outs with inspect"
        )
    sigma = np.array([noise.position, noise.heading])
    speed = np.array([_rms([p.velocity for p in parts]), _rms([p.r for p in parts])])
    bend = np.array([_rms([p.acceleration for p in parts]), _rms([p.r_dot for p in parts])])
    poses = float(np.max(12.0 * (sigma / period / (VELOCITY_NOISE_SHARE * speed)) ** 2)) ** (1 / 3)
    half = float(np.max(22.5 * period * (sigma / (ACCELERATION_NOISE_SHARE * bend)) ** 2)) ** (
        1 / 5
    )
    return Widths(
        float(np.clip(poses / 2, FEWEST_STATE_POSES, LARGEST_STATE_WIDTH / period) * period),
        float(np.clip(half, *TEST_WIDTH_RANGE)),
    )


def _rms(parts: Sequence[Array] | Sequence[Complex]) -> float:
    squares = np.concatenate([np.abs(part) ** 2 for part in parts])
    return float(np.sqrt(np.mean(squares))) + 1e-12  # against a division by 0


def make_kernels(widths: Widths, period: float, finest: float) -> Kernels:
    """Kernels for poses every `period` [s], on a grid that divides it, no coarser than `finest`."""
    fine = int(np.ceil(period / finest))
    step = period / fine
    half = max(2, round(widths.test / step))
    s = np.arange(-half, half + 1) / half
    test = (1.0 - s**2) ** 2
    slope = 4.0 * s * (1.0 - s**2) / (half * step) / test.sum()
    side = max(2, round(widths.state / period))
    i = 2 * np.abs(np.arange(-side * fine, side * fine + 1))
    sides = [np.maximum(i - 1, 0) // (2 * fine), (i + 1) // (2 * fine)]  # of a step, from c on
    kappa = np.sum([np.maximum(side * (side + 1.0) - p * (p + 1.0), 0.0) for p in sides], axis=0)
    triangle = fine - np.abs(np.arange(1 - fine, fine))  # of the interpolation between poses
    average = np.convolve(kappa, triangle)
    test = test / test.sum()
    pad = len(average) // 2
    driven = np.convolve(test, average / average.sum())
    return Kernels(step, max(1, half // 2), np.pad(test, pad), np.pad(slope, pad), driven)


def window_sums(values: Array, weights: Array, stride: int) -> Array:
    """sum_k weights[k] values[b stride + k] for all whole windows b: (windows, columns)."""
    count = -(-len(weights) // stride)
    blocks = len(values) // stride
    if blocks < count:
        return np.zeros((0, values.shape[1]))
    W = np.pad(weights, (0, count * stride - len(weights))).reshape(count, stride)
    parts = W @ values[: blocks * stride].reshape(blocks, stride, -1)
    return np.asarray(sum(parts[m : blocks - count + 1 + m, m] for m in range(count)))


@dataclass(frozen=True)
class _Terms:
    """Some terms of a structure, in the order of their axes."""

    structure: _core.Structure
    turn: Complex  # (n, plane) from the axis of each term of the plane into earth axes
    sums: Array  # (terms, coefficients + 1) ones that add a term to its coefficient's column

    @property
    def plane(self) -> int:
        """Number of terms in surge and sway."""
        return int(self.turn.shape[1])


@dataclass(frozen=True)
class Windows:
    """The windows of one recording; `driven` gives the columns that depend on the chain's constants."""

    vehicle: Vehicle
    recording: Recording
    kernels: Kernels
    t: Array  # (n,) [s] the grid
    nu: Array  # (n, 3) smoothed body velocity
    nu_dot: Array  # (n, 3) its derivative, for acceleration terms
    turn: Complex  # (n,) exp(i psi)
    velocity: Complex  # (n,) earth-fixed
    keep: Mask  # (windows,) without drop-outs

    @cached_property
    def centres(self) -> Array:
        """Times (m,) [s] of the kept windows' centres."""
        return np.asarray(self.t[self._middle])

    @cached_property
    def left(self) -> Array:
        """(m, 3) int phi nu_dot from the poses, in the window's axes."""
        k = self.kernels
        moving = window_sums(_parts(self.velocity, self.nu[:, 2]), k.slope, k.stride)
        turning = window_sums(_parts(1j * self.nu[:, 2] * self.velocity), k.test, k.stride)
        moving[:, :2] -= turning
        plane = self._bodily(moving[self.keep][:, :2])[:, 0]
        return np.column_stack([plane.real, plane.imag, moving[self.keep][:, 2]])

    @cached_property
    def steady(self) -> Array:
        """(m, 3, n + 1) columns of the coefficients, terms without force; the last one is known."""
        force = np.zeros((len(self.t), len(self.vehicle.structure.forces)))
        return self._columns(self._terms(driven=False), force, self.kernels.test)

    def driven(self, constants: Array) -> Array:
        """(m, 3, n + 1) the same of the terms with a force, for constants (m,) of the chain."""
        force = thrust_trace(self.vehicle, constants, self.recording).forces(self.t)
        return self._columns(self._driven_terms, force, self.kernels.driven)

    @cached_property
    def _middle(self) -> NDArray[np.int64]:
        return np.flatnonzero(self.keep) * self.kernels.stride + len(self.kernels.test) // 2

    @cached_property
    def _driven_terms(self) -> "_Terms":
        return self._terms(driven=True)

    def _terms(self, *, driven: bool) -> "_Terms":
        """The terms with a force, or those without."""
        structure = self.vehicle.structure
        of_velocities = [set(t.factors) <= set(VELOCITIES) for t in structure.terms]
        chosen = [
            row for row, own in zip(structure.rows, of_velocities, strict=True) if own != driven
        ]
        rows = sorted(chosen, key=lambda row: row[0])
        n = len(structure.coefficients)
        part = _core.Structure(rows, n, len(structure.forces))
        along = np.array([(1.0, 1j)[row[0]] for row in rows if row[0] < 2])
        return _Terms(part, along * self.turn[:, None], np.eye(n + 1)[[row[1] for row in rows]])

    def _columns(self, terms: "_Terms", force: Array, kernel: Array) -> Array:
        products = _core.regressors(terms.structure, self.nu, self.nu_dot, force)
        plane, sums = terms.plane, terms.sums
        turned = products[:, :plane] * terms.turn
        whole = window_sums(_parts(turned, products[:, plane:]), kernel, self.kernels.stride)[
            self.keep
        ]
        bodily = self._bodily(whole[:, : 2 * plane])
        return np.stack(
            [
                bodily.real @ sums[:plane],
                bodily.imag @ sums[:plane],
                whole[:, 2 * plane :] @ sums[plane:],
            ],
            axis=1,
        )

    @cached_property
    def _middle_turn(self) -> Complex:
        return np.asarray(self.turn[self._middle][:, None])

    def _bodily(self, rows: Array) -> Complex:
        """Pairs of columns (m, 2 k) from earth axes into those at the window's middle (m, k)."""
        plane = np.ascontiguousarray(rows).view(np.complex128)
        return np.asarray(plane / self._middle_turn)


def windows_of(
    vehicle: Vehicle, recording: Recording, widths: Widths, finest: float = 1 / 60
) -> Windows:
    """The windows of a recording. Raises IdentificationError where it is too short for one."""
    r = recording
    own = smooth_poses(r.t, r.eta, r.valid, r.segment, window=2 * widths.state, stride=0.0)
    k = make_kernels(widths, r.period, finest)
    grid = np.arange(0.0, r.duration, k.step)
    if len(own.t) < 2 or len(grid) < len(k.test):
        raise IdentificationError(_too_short(r, k))
    psi = np.interp(grid, own.t, own.psi)
    rate = np.interp(grid, own.t, own.r)
    velocity = np.interp(grid, own.t, own.velocity.real) + 1j * np.interp(
        grid, own.t, own.velocity.imag
    )
    turn = np.exp(1j * psi)
    body = velocity / turn
    nu = np.column_stack([body.real, body.imag, rate])
    bad = ~_covered(grid, own.t, r)
    spoiled = window_sums(bad[:, None].astype(float), k.support.astype(float), k.stride)[:, 0]
    found = Windows(
        vehicle, r, k, grid, np.ascontiguousarray(nu),
        np.ascontiguousarray(np.gradient(nu, k.step, axis=0)), turn, velocity, spoiled < 0.5,
    )  # fmt: skip
    if not found.keep.any():
        raise IdentificationError(_too_short(r, k))
    return found


def _covered(grid: Array, centres: Array, recording: Recording) -> Mask:
    """Grid points between two smoothed poses of one continuous interval."""
    i = np.clip(np.searchsorted(centres, grid, side="right") - 1, 0, len(centres) - 2)
    inside = (grid >= centres[0]) & (grid <= centres[-1])
    near = np.diff(centres) < BRIDGED_PERIODS * recording.period
    stretch = recording.segment[np.searchsorted(recording.t, centres)]
    return np.asarray(inside & (near & (np.diff(stretch) == 0))[i])


def _parts(plane: Complex, *further: Array) -> Array:
    """Real and imaginary parts as columns, then further columns."""
    columns = np.ascontiguousarray(plane.reshape(len(plane), -1)).view(np.float64)
    return np.column_stack([columns, *further])


def _too_short(recording: Recording, kernels: Kernels) -> str:
    length = len(kernels.test) * kernels.step
    return (
        f"{recording.name}: no {length:.1f} s without drop-outs; record longer, or look "
        "for drop-outs with inspect"
    )
