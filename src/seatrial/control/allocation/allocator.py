# SPDX-License-Identifier: MIT
"""Wrenches to thruster commands, for any geometry: the core's on-board allocator, set up by name."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from seatrial import _core
from seatrial.boat.model import Model
from seatrial.boat.vehicle import Vehicle
from seatrial.control.allocation.thruster_effectiveness import Effectiveness, effectiveness
from seatrial.util.errors import AllocationError
from seatrial.util.frames import AXES, Array, Mask, frozen_array

PRIORITY: Final = "yaw, surge+sway"
# [command units] from a dead zone's edge to the idle command, as in MallARD's F_os
IDLE_MARGIN: Final = 0.04
HYSTERESIS: Final = 0.02  # [command units] of wrench, before a thruster switches its side
DEMANDS = 200  # wrenches over which `auto` compares schemes
ERROR_DIGITS = 9  # [command units] in which two wrench errors differ
REACH_LIMIT = 1e6  # times a direction: the search for the largest wrench ends there


class AllocatorScheme(str, Enum):
    """How a wrench becomes thruster commands; in the order of the core's codes."""

    MP = "moore-penrose"
    AF = "always-forward"
    NULL_SPACE = "null-space"
    SIGN_PATTERN = "sign-pattern"
    FEWEST = "fewest-crossings"  # null-space for as many thrusters as possible, sign-pattern for the rest
    AUTO = "auto"  # the least wrench error of these, then the least power

    @property
    def code(self) -> int:
        """The core's number for it; of `auto`, as in gains files before there was a choice, the bias."""
        return min(list(AllocatorScheme).index(self), 4)


# what `auto` chooses from; at equal error and power the first
CHOICES = (AllocatorScheme.MP, AllocatorScheme.SIGN_PATTERN, AllocatorScheme.FEWEST)


class Allocator:
    """Wrench [F_u, F_v, F_r] in forward-left-up axes and command units to thruster commands.

    Inverts the identified curves: the wrench is the one commanded, within the limits.
    Thrusters that change sides (see `switching`) keep theirs from one call to the next.
    """

    def __init__(
        self,
        boat: Model | Vehicle | Effectiveness,
        scheme: str = "auto",
        *,
        priority: str = PRIORITY,
        invert: bool = True,
        margin: float | None = None,
        hysteresis: float = HYSTERESIS,
        limits: float | Mapping[str, float] | None = None,
        demands: ArrayLike | None = None,
    ) -> None:
        """Set up once; about 10 ms with eight thrusters.

        `scheme`: auto takes the one with the least wrench error over `demands` (m, 3), then the least power.
        Without demands these are wrenches of random thrusts. With the curves inverted a dead zone costs no
        wrench, and the null-space bias costs authority: auto takes the bias only without the inversion.

        `priority`: axes in the order in which they are served at the limits; those joined by + are
        scaled by one factor. `invert`: False sends thrusts as commands, as the paper does. `margin`: from the
        dead zone's edge to the idle command (default: up to the vehicle's F_os, or
        0.04). `hysteresis`: of wrench. `limits`: of |command|, for all or by thruster (default: the
        vehicle's, or 1). All in command units. Raises AllocationError.
        """
        self.boat = boat if isinstance(boat, Effectiveness) else effectiveness(boat)
        self.asked_scheme = _scheme(scheme)
        self.thrusters = self.boat.thrusters
        self.rank = ranks(priority)  # of surge, sway and yaw
        self._invert, self.hysteresis = invert, _not_negative("hysteresis", hysteresis)
        self.limits = frozen_array(_limits(self.boat, limits))
        self.edges = frozen_array(self._edges())
        self.idle_commands = frozen_array(self._idle_commands(margin))  # (2, n) forward, astern
        self.core_scheme = self.asked_scheme
        if self.asked_scheme is AllocatorScheme.AUTO:
            self.core_scheme = self._least_error(demands)
        self._core = self._checked_core(self.core_scheme)
        self.sides = frozen_array(self._core.sides)
        self.idle_power = float(self._core.idle_power)
        self.idle = frozen_array(self._core.allocate(np.zeros((1, 3)))[0][0])
        self.reset()

    @property
    def switching(self) -> tuple[str, ...]:
        """Thrusters that operate on both sides of their dead zone."""
        return tuple(n for n, s in zip(self.thrusters, self.sides, strict=True) if s == 0)

    @property
    def scheme(self) -> AllocatorScheme:
        """The scheme in use: for `auto`, the one that was chosen."""
        if self.core_scheme is not AllocatorScheme.FEWEST:
            return self.core_scheme
        every = len(self.switching) == len(self.thrusters)
        return (
            AllocatorScheme.SIGN_PATTERN if every
            else AllocatorScheme.FEWEST if self.switching
            else AllocatorScheme.NULL_SPACE
        )  # fmt: skip

    @property
    def why(self) -> str:
        """Why the thrusters stay outside their dead zones, as text."""
        chosen = "least wrench error, then least power: "
        return (chosen if self.asked_scheme is AllocatorScheme.AUTO else "") + self._why

    @property
    def _why(self) -> str:
        sides = {1.0: "forward", -1.0: "astern"}
        kept = ", ".join(
            f"{n} {sides[s]}" for n, s in zip(self.thrusters, self.sides, strict=True) if s != 0
        )
        if self.core_scheme is AllocatorScheme.MP:
            return "least thrust; every thruster crosses its dead zone"
        if self.core_scheme is AllocatorScheme.AF:
            return f"Table I: {kept}"
        switching = ", ".join(self.switching)
        if not self.switching:
            return f"a bias in T's null space keeps them out: {kept}"
        if self.core_scheme is AllocatorScheme.SIGN_PATTERN:
            return f"sides switch with hysteresis, no idle thrust: {switching}"
        some = f"{kept} by a bias; " if kept else ""
        return f"{some}no bias within the limits keeps out {switching}: their sides switch with hysteresis"

    def allocate(self, wrench: ArrayLike, *, saturate: bool = True) -> Array:
        """Commands (n,) for a wrench (3,), or (m, n) for (m, 3), in sequence.

        Beyond the limits the wrench is reduced in the order of `priority`; with `saturate` False that
        raises AllocationError. So does a wrench that is not a number.
        """
        # Wrenches as rows; the core inverts T and the thrusters' curves within the limits
        rows, single = _as_rows(wrench, 3, "wrench")
        commands, shares, _ = self.allot(rows)
        # Beyond the limits: refuse, with the share that is attainable
        if not saturate and (over := np.flatnonzero(shares.min(axis=1) < 1.0)).size:
            requested = rows[over[0]]
            share = float(self._core.reach(requested[None, :], 1.0)[0])
            raise AllocationError(
                f"wrench {', '.join(f'{x:g}' for x in requested)}: {self.scheme.value} reaches "
                f"{share:.3g} of it within the limits; reduce the wrench, or allow saturation"
            )
        return commands[0] if single else commands

    def allot(self, wrenches: Array) -> tuple[Array, Array, Mask]:
        """Commands (m, n), the share (m, 3) of each axis within the limits, and where hysteresis held a side.

        Held: the wrench differs from the requested one by less than the hysteresis; no side switches.
        """
        rows, _ = _as_rows(wrenches, 3, "wrench")
        commands, shares, held = self._core.allocate(rows)
        return np.asarray(commands), np.asarray(shares), np.asarray(held) > 0

    def wrench(self, commands: ArrayLike) -> Array:
        """Steady wrench (3,) of commands (n,); (m, 3) of (m, n)."""
        rows, single = _as_rows(commands, len(self.thrusters), "commands")
        given = np.asarray(self._core.wrench(rows)[0])
        return given[0] if single else given

    def thrust(self, commands: ArrayLike) -> Array:
        """Steady thrust of each thruster (n,) at commands (n,), or (m, n) of (m, n)."""
        rows, single = _as_rows(commands, len(self.thrusters), "commands")
        found = np.asarray(self._core.thrust(rows))
        return found[0] if single else found

    def commands(self, thrust: ArrayLike) -> Array:
        """Commands (n,) for thrusts (n,), or (m, n) for (m, n), without limits.

        For zero thrust: the dead-zone edge on the thruster's current side.
        """
        rows, single = _as_rows(thrust, len(self.thrusters), "thrust")
        found = np.asarray(self._core.command(rows))
        return found[0] if single else found

    def power(self, commands: ArrayLike) -> Array:
        """Power (m,) of commands (m, n): |thrust|^(3/2) of each; 1 is one thruster at full command."""
        rows, _ = _as_rows(commands, len(self.thrusters), "commands")
        return np.asarray(self._core.wrench(rows)[1])

    def reach(self, directions: ArrayLike) -> Array:
        """The largest attainable wrench (m,) along directions (m, 3), as a multiple of each."""
        rows, _ = _as_rows(directions, 3, "direction")
        return np.asarray(self._core.reach(rows, REACH_LIMIT))

    def reset(self) -> None:
        """Set the thrusters that switch to their forward side."""
        self._core.reset()

    def _least_error(self, demands: ArrayLike | None) -> AllocatorScheme:
        """Of the possible `CHOICES` the one with the least wrench error by the true curves, then power."""
        judge = self._checked_core(AllocatorScheme.MP, invert=True)
        rows = self._some_demands(judge) if demands is None else _as_rows(demands, 3, "demands")[0]
        found = {}
        for scheme in CHOICES:
            core = self._build(scheme, self.limits, self.idle_commands)
            if core.fault:
                continue
            given, power = judge.wrench(np.asarray(core.allocate(rows)[0]))
            error = float(np.sqrt(np.mean((np.asarray(given) - rows) ** 2)))
            found[scheme] = (round(error, ERROR_DIGITS), float(np.mean(power)))
        return min(found, key=lambda scheme: found[scheme])

    def _some_demands(self, judge: _core.Allocator) -> Array:
        """Wrenches (m, 3) of thrusts drawn evenly between the limits; the same each time."""
        share = np.random.default_rng(0).uniform(-1.0, 1.0, (DEMANDS, len(self.thrusters)))
        return np.ascontiguousarray(judge.wrench(np.ascontiguousarray(share * self.limits))[0])

    def _checked_core(
        self, scheme: AllocatorScheme, *, invert: bool | None = None
    ) -> _core.Allocator:
        core = self._build(scheme, self.limits, self.idle_commands, invert=invert)
        if core.fault:
            raise AllocationError(
                f"{self.boat.vehicle.source}: {self._fault_text(core.fault, scheme)}"
            )
        return core

    def _build(
        self, scheme: AllocatorScheme, limits: Array, idle: Array, *, invert: bool | None = None
    ) -> _core.Allocator:
        return _core.Allocator(
            self.boat.vehicle.chain, self.boat.constants, np.ascontiguousarray(self.boat.T),
            np.vstack([limits, idle]), scheme.code, self._invert if invert is None else invert, self.hysteresis,
            np.array(self.rank, dtype=np.int32),
        )  # fmt: skip

    def _edges(self) -> Array:
        """(2, n) dead-zone edges forward and astern from the core. Raises AllocationError."""
        n = len(self.thrusters)
        probe = self._build(AllocatorScheme.MP, np.full(n, 4.0), np.full((2, n), 2.0))
        if probe.fault:
            raise AllocationError(
                f"{self.boat.vehicle.source}: {self._fault_text(probe.fault, AllocatorScheme.MP)}"
            )
        return np.asarray(probe.edges)

    def _idle_commands(self, margin: float | None) -> Array:
        """(2, n) idle commands, forward and astern."""
        stated = self.boat.vehicle.file.allocation.F_os
        if margin is None and stated > 0.0:
            over = stated - self.edges[0]
            if over.min() < 0.0:
                k = int(over.argmin())
                raise AllocationError(
                    f"{self.boat.vehicle.source}: F_os {stated:g} lies in the dead zone of "
                    f"{self.thrusters[k]}, which ends at {self.edges[0, k]:g}; raise F_os"
                )
        else:
            over = np.full(len(self.thrusters), _not_negative("margin", margin, IDLE_MARGIN))
        idle = self.edges + over
        tight = idle.max(axis=0) >= self.limits
        if tight.any():
            k = int(tight.argmax())
            raise AllocationError(
                f"{self.boat.vehicle.source}: {self.thrusters[k]}: dead zone to "
                f"{self.edges[:, k].max():g} and idle command {idle[:, k].max():g} leave no room below the "
                f"limit {self.limits[k]:g}; raise the limit, or lower F_os or margin"
            )
        return np.asarray(idle)

    def _fault_text(self, code: int, scheme: AllocatorScheme) -> str:
        names = ", ".join(self.thrusters)
        no_idle = (
            f"T's null space has no bias within the limits that keeps all of {names} outside their dead zones"
            if scheme is AllocatorScheme.NULL_SPACE
            else "the limits leave hardly any wrench in some direction"
        )
        return (
            "",
            f"{len(self.thrusters)} thrusters ({names}); the allocator takes 3 to 8, or 2 without sway thrust",
            f"{names} can't actuate {', '.join(AXES[i] for i in self.boat.driven)} independently; "
            "check positions and angles",
            "a thruster's curve can't be inverted: a propeller's pair, or thrust that does not rise "
            "with the command outside the dead zone; check its chain",
            "no room between a dead zone and its limit; check dead_zone and limit",
            "always-forward needs thrusters whose wrenches cancel at equal thrust, as MallARD's "
            "four; use auto",
            f"{scheme.value}: {no_idle}; use auto",
        )[code]


def ranks(priority: str) -> list[int]:
    """Rank of surge, sway and yaw out of "yaw, surge+sway". Raises AllocationError."""
    groups = [[name.strip() for name in group.split("+")] for group in priority.split(",")]
    if sorted(name for group in groups for name in group) != sorted(AXES):
        raise AllocationError(
            f"priority '{priority}': name surge, sway and yaw once each, joined by , or +, as in "
            f"'{PRIORITY}'"
        )
    return [next(i for i, group in enumerate(groups) if axis in group) for axis in AXES]


def _scheme(name: str) -> AllocatorScheme:
    try:
        return AllocatorScheme(name)
    except ValueError:
        every = ", ".join(scheme.value for scheme in AllocatorScheme)
        raise AllocationError(f"no scheme '{name}'; there are {every}") from None


def _limits(boat: Effectiveness, given: float | Mapping[str, float] | None) -> Array:
    """(n,) largest |command|."""
    stated = boat.vehicle.file.allocation.limit or 1.0
    by_name = given if isinstance(given, Mapping) else {}
    if odd := set(by_name) - set(boat.thrusters):
        raise AllocationError(
            f"limits names {', '.join(sorted(odd))}; the thrusters are {', '.join(boat.thrusters)}"
        )
    common = stated if given is None or isinstance(given, Mapping) else given
    limits = np.array([by_name.get(name, common) for name in boat.thrusters], dtype=float)
    if not np.all((limits > 0.0) & np.isfinite(limits)):
        raise AllocationError(f"limits {limits.tolist()}: each must be a number above 0")
    return limits


def _not_negative(name: str, value: float | None, default: float = 0.0) -> float:
    number = default if value is None else float(value)
    if not (np.isfinite(number) and number >= 0.0):
        raise AllocationError(f"{name} {number:g}: must be a number not below 0")
    return number


def _as_rows(values: ArrayLike, width: int, what: str) -> tuple[Array, bool]:
    """(m, width) contiguous, and whether a single row was given."""
    try:
        array = np.array(values, dtype=float, order="C")
    except (TypeError, ValueError):
        raise AllocationError(
            f"{what} {values!r}; expected ({width},) or (m, {width}) numbers"
        ) from None
    if array.ndim not in (1, 2) or array.shape[-1] != width:
        raise AllocationError(f"{what} of shape {array.shape}; expected ({width},) or (m, {width})")
    if not np.isfinite(array).all():
        raise AllocationError(f"{what} {array.tolist()}: not a finite number")
    return np.atleast_2d(array), array.ndim == 1
