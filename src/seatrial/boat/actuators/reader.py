# SPDX-License-Identifier: MIT
"""The actuator models of a vehicle file: their constants, and which actuator uses which."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seatrial import _core
from seatrial.boat.actuators.constants import CURVE, STAGES, STARTS, USES, Constants
from seatrial.boat.actuators.stated_values import edges
from seatrial.boat.schema import ChainGroup, DeadZone, PairEntry, SteeredEntry
from seatrial.boat.steering import angle_names, check_steering, stages_of
from seatrial.util.errors import VehicleError
from seatrial.util.frames import Array


@dataclass(frozen=True)
class ChainReader:
    """The groups of a chain, with the actuators of the vehicle."""

    groups: Sequence[ChainGroup]
    actuators: Sequence[str]
    source: str  # for errors

    def place(self, name: str, where: str) -> int:
        """Number of an actuator. Raises VehicleError."""
        if name not in self.actuators:
            raise VehicleError(
                f"{self.source}: {where} names '{name}'; the actuators are {', '.join(self.actuators)}"
            )
        return self.actuators.index(name)

    def members(self, group: ChainGroup) -> list[int]:
        """Numbers of the actuators in a group."""
        names = group.actuators or self.actuators
        if len(set(names)) != len(names):
            raise VehicleError(
                f"{self.source}: chain group '{group.name}' names an actuator twice: {', '.join(names)}"
            )
        return [self.place(n, f"chain group '{group.name}'") for n in names]

    def constants(self) -> Constants:
        """All constants, group by group. Raises VehicleError."""
        names: list[str] = []
        values: list[float] = []
        estimated: list[str] = []
        index = np.full((len(self.actuators), len(STAGES)), -1, dtype=np.int32)
        for group in self.groups:
            for stage, name, given, members in self._stages(group):
                for one in (stage, *_also(group, stage, name)):
                    column = STAGES.index(one)
                    twice = [self.actuators[k] for k in members if index[k, column] >= 0]
                    if twice:
                        raise VehicleError(
                            f"{self.source}: chain: two groups give {one} of {', '.join(twice)}; "
                            "keep one of them"
                        )
                    index[members, column] = len(values)
                names.append(name)
                values.append(_start(stage, name) if isinstance(given, str) else given)
                estimated += [name] if isinstance(given, str) else []
        if len(set(names)) != len(names):
            raise VehicleError(f"{self.source}: chain: two groups have the same name; rename one")
        self._check_pairs(index)
        check_steering(self.groups, self.source)
        return Constants(tuple(names), np.array(values, dtype=float), index, tuple(estimated))

    def rows(self, constants: Constants, scales: Sequence[str], signs: Array) -> NDArray[np.int32]:
        """Rows (actuators, 20) as the core takes them: STAGES, then USES, -1 where absent.

        `signs` (actuators,): -1 where the reader negates the recorded command; its edges are
        exchanged.
        """
        rows = np.full((len(self.actuators), len(USES)), -1, dtype=np.int32)
        for group in self.groups:
            members = self.members(group)
            if group.scale is not None:
                if group.scale.signal not in scales:
                    raise VehicleError(
                        f"{self.source}: chain uses scale '{group.scale.signal}'; "
                        f"scales has {', '.join(scales) or 'none'}"
                    )
                rows[members, USES.index("scale")] = scales.index(group.scale.signal)
            if group.table is not None:
                rows[members, USES.index("tabulated")] = 1
            if group.pair is not None:
                self._place_pairs(rows, group.pair, signs)
            if group.steered is not None:
                self._place_angles(rows, group.steered, signs)
            if group.table is not None and not _odd(group.table):
                self._refuse_turned([k for k in members if signs[k] < 0], "a table")
        uneven = constants.index[:, STAGES.index("reverse_ratio")] >= 0
        self._refuse_turned(np.flatnonzero(uneven & (signs < 0)).tolist(), "reverse_ratio")
        index, turned = constants.index.copy(), signs < 0
        ahead, astern = STAGES.index("edge_forward"), STAGES.index("edge_reverse")
        index[turned, ahead] = constants.index[turned, astern]
        index[turned, astern] = constants.index[turned, ahead]
        return np.ascontiguousarray(np.column_stack([index, rows]))

    def _refuse_turned(self, places: Sequence[int], stage: str) -> None:
        """Refuse a one-sided stage of a negated command: full reverse would be read as full forward."""
        if places:
            names = " and ".join(self.actuators[k] for k in places)
            raise VehicleError(
                f"{self.source}: chain: {stage} distinguishes full forward from full reverse, but in "
                f"forward-right-down axes {names} have the opposite sign; give the inputs other names, and "
                "define forces: for them"
            )

    def _place_pairs(self, rows: NDArray[np.int32], pair: PairEntry, signs: Array) -> None:
        for names in pair.of:
            for across, (own, other) in enumerate((names, names[::-1])):
                k = self.place(own, "chain: pair")
                # offset and mirror are of the commands as the file has them
                turned = (own in pair.mirrored) != (signs[k] < 0)
                partner = self.place(other, "chain: pair")
                rows[k, USES.index("partner") : USES.index("steers")] = (partner, across, turned)

    def _place_angles(self, rows: NDArray[np.int32], entry: SteeredEntry, signs: Array) -> None:
        for thrust, angle in entry.of:
            k = self.place(angle, "chain: steered")
            rows[k, USES.index("steers")] = self.place(thrust, "chain: steered")
            rows[k, USES.index("scale")] = -1  # of a group of all actuators
            self._refuse_turned([k] if signs[k] < 0 else [], "an angle")

    def _stages(self, group: ChainGroup) -> Iterator[tuple[str, str, float | str, list[int]]]:
        """Stage, the constant's name, value or 'estimate', and its actuators."""
        suffix = f".{group.name}" if group.name else ""
        members = self.members(group)
        if group.table is not None:
            _check_table(group)
        turned = {self.place(name, "chain: steered") for name in angle_names(self.groups)}
        for stage, value in _single(group).items():
            # an angle's rate limit is in degrees, with the others of its constants
            own = [k for k in members if not (stage == "slew_rate" and k in turned)]
            yield stage, stage + suffix, value, own
        if group.pair is not None:
            paired = [self.place(n, "chain: pair") for names in group.pair.of for n in names]
            for stage, value in _of_pair(group.pair).items():
                yield stage, stage + suffix, value, paired
        if group.steered is not None:
            angles = [self.place(angle, "chain: steered") for _, angle in group.steered.of]
            for stage, (name, given) in stages_of(group.steered).items():
                yield stage, name + suffix, given, angles
        gains = group.gains or {}
        if gains and not np.isclose(np.mean(list(gains.values())), 1.0):
            raise VehicleError(
                f"{self.source}: chain: the gains' mean is {np.mean(list(gains.values())):.4g}; "
                "it must be 1: the coefficients contain the rest"
            )
        for name, gain in gains.items():
            yield "gain", f"gain.{name}", gain, [self.place(name, "gains")]

    def _check_pairs(self, index: NDArray[np.int32]) -> None:
        """Each actuator is in one pair at most, and has no other curve."""
        paired: set[str] = set()
        for group in self.groups:
            if group.pair is None:
                continue
            names = [n for two in group.pair.of for n in two]
            twice = {n for n in names if names.count(n) > 1 or n in paired}
            paired |= set(names)
            if twice or not names:
                raise VehicleError(
                    f"{self.source}: chain: pair: {', '.join(sorted(twice)) or 'no actuator'} "
                    "named; give two actuators a propeller, each once"
                )
            if odd := set(group.pair.mirrored) - set(names):
                raise VehicleError(
                    f"{self.source}: chain: pair: mirrored names {', '.join(sorted(odd))}; "
                    f"the pair has {', '.join(names)}"
                )
        tabulated = {self.actuators[k] for g in self.groups if g.table for k in self.members(g)}
        columns = [STAGES.index(stage) for stage in CURVE]
        for name in sorted(paired):
            if name in tabulated or np.any(index[self.place(name, "pair"), columns] >= 0):
                raise VehicleError(
                    f"{self.source}: chain: {name} is one of a pair, which stands instead of "
                    "dead_zone, power, reverse_ratio and table"
                )


def _odd(table: Sequence[Sequence[float]]) -> bool:
    """Whether a table (rows of command and thrust) is odd-symmetric."""
    rows = np.array(table, dtype=float)
    return bool(np.allclose(rows, -rows[::-1], atol=1e-9))


def _also(group: ChainGroup, stage: str, name: str) -> tuple[str, ...]:
    """Stages that share a stage's constant."""
    zone = group.dead_zone
    of_angle = name.startswith("steer_dead_zone")
    symmetric = of_angle or (isinstance(zone, DeadZone) and zone.symmetric)
    shared = symmetric and stage == "edge_forward"
    return ("edge_reverse",) if shared else ()


def _start(stage: str, name: str) -> float:
    """Start value of an estimated constant."""
    return STARTS.get(name.partition(".")[0], STARTS[stage])


def _single(group: ChainGroup) -> dict[str, float | str]:
    """The constants that a group gives each of its actuators."""
    zone = None if group.dead_zone is None else edges(group.dead_zone)
    values = {
        "latency": group.latency,
        "edge_forward": None if zone is None else zone.forward,
        "edge_reverse": None if zone is None or zone.symmetric else zone.reverse,
        "reverse_ratio": group.reverse_ratio,
        "power": group.power,
        "lag": group.lag,
        "slew_rate": group.slew_rate,
        "scale_power": group.scale.power if group.scale else None,
    }
    return {stage: value for stage, value in values.items() if value is not None}


def _of_pair(pair: PairEntry) -> dict[str, float | str]:
    values = {
        "pair_offset_along": pair.offset.along,
        "pair_offset_across": pair.offset.across,
        "pair_dead_zone": pair.dead_zone,
    }
    return {stage: value for stage, value in values.items() if value is not None}


def _check_table(group: ChainGroup) -> None:
    table = np.array(group.table, dtype=float)
    if group.dead_zone or group.power or group.reverse_ratio:
        raise VehicleError(
            "chain: a table replaces dead_zone, power and reverse_ratio; give one or the other"
        )
    if len(table) < 2 or len(table) > _core.MAX_TABLE or np.any(np.diff(table[:, 0]) <= 0):
        raise VehicleError(
            f"chain: a table needs 2 to {_core.MAX_TABLE} points with rising commands"
        )
    if abs(np.interp(1.0, table[:, 0], table[:, 1]) - 1.0) > 1e-9:
        raise VehicleError(
            "chain: a table must give thrust 1 at command 1; divide it by that value"
        )
