# SPDX-License-Identifier: MIT
"""Stages of the actuator chain that are estimated: those that the file leaves open and the commands identify.

Latency, lag and dead zone are always estimated where they are identifiable. Others (full reverse over full forward
thrust, the curve's power, and these, latency or lag for each group of actuators) are candidates of a score test.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass

import msgspec
import numpy as np

from seatrial import _core
from seatrial.boat.actuators import ESTIMATE, STAGES, STARTS
from seatrial.boat.allocation import thruster_matrix
from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.boat.schema import ChainGroup, DeadZone
from seatrial.boat.static_forces import static_forces, usual_commands
from seatrial.boat.vehicle import WRENCH, Vehicle
from seatrial.recording.recording import Recording
from seatrial.util.errors import VehicleError
from seatrial.util.frames import Array

IGNORED_THRUST = 0.05  # of the summed thrust, at extreme values of a scale signal
# highest over lowest value of a scale signal: less does not identify its power
LEAST_SCALE_RATIO = 1.05
LEAST_EDGE_EFFECT = 0.05  # of the force, per edge, beyond a gain's: less does not identify the edge
CHAIN_FINDINGS = (  # of `with_estimated_stages`
    FindingKind.DEAD_ZONE_NOT_SOUGHT,
    FindingKind.DEAD_ZONE_ONE_EDGE,
    FindingKind.DEAD_ZONE_NOT_IDENTIFIABLE,
    FindingKind.SCALE_POWER_HELD,
)
STAGES_SELECTED = (
    FindingKind.SLEW_RATE_SELECTED,
    FindingKind.CURVE_STAGE_SELECTED,
    FindingKind.GROUP_STAGES_SELECTED,
)
# stages that each kind of actuator may have of its own
STAGES_BY_GROUP: tuple[str, ...] = (
    "latency",
    "lag",
    "power",
    "reverse_ratio",
)
# that each actuator may have: another motor, belt or controller; forces have gains of their own
STAGES_BY_ACTUATOR = ("latency", "lag")
PLACE_TOLERANCE = 0.1  # relative: thrusters at places that differ by more are two groups
Wider = Callable[[list[ChainGroup]], Vehicle | None]  # the vehicle with these groups for one


@dataclass(frozen=True)
class StageCandidate:
    """A stage that may be estimated: its finding, and the vehicle with it at its neutral value."""

    finding: Finding
    vehicle: Vehicle
    origin: dict[str, str]  # constants of the new vehicle by those of the old that they come from
    probe: Vehicle  # with all stages at their neutral values that one filter run can test


def with_free_stages(vehicle: Vehicle, recordings: Sequence[Recording]) -> Vehicle:
    """The vehicle with those stages of the chain that its file does not state."""
    return with_estimated_stages(vehicle, recordings)[0]


def with_estimated_stages(
    vehicle: Vehicle, recordings: Sequence[Recording]
) -> tuple[Vehicle, list[Finding]]:
    """The vehicle with the stages to estimate, and findings on those that are not."""
    has = _stated(vehicle)
    zones, of_zones = _dead_zones(vehicle, recordings)
    group = ChainGroup(
        latency=None if has["latency"] else STARTS["latency"],
        lag=None if has["lag"] else STARTS["lag"],
        dead_zone=zones.pop().dead_zone if [z.name for z in zones] == [""] else None,
    )
    held, of_powers = _powers_held(vehicle, recordings)
    whole = held.with_chain([*held.file.chain, group, *zones, *_remaining_delays(vehicle)])
    return whole, [*of_zones, *of_powers]


def _remaining_delays(vehicle: Vehicle) -> list[ChainGroup]:
    """Latency and lag for those actuators for which the file does not state them, if for others."""
    found = []
    for stage in ("latency", "lag"):
        given = vehicle.constants.index[:, STAGES.index(stage)] >= 0
        if given.any() and not given.all():
            others = [n for n, g in zip(vehicle.actuators, given, strict=True) if not g]
            group = ChainGroup(name=f"{stage}_others", actuators=others)
            found.append(_with(group, stage, STARTS[stage]))
    return found


def _powers_held(
    vehicle: Vehicle, recordings: Sequence[Recording]
) -> tuple[Vehicle, list[Finding]]:
    """The vehicle with powers of scale signals held where no recording identifies them."""
    given, findings = {}, []
    for group in vehicle.file.chain:
        if group.scale is None or group.scale.power != ESTIMATE:
            continue
        name = "scale_power" + (f".{group.name}" if group.name else "")
        if not _scale_varies(recordings, vehicle, group):
            given[name] = STARTS["scale_power"]
            names = name, group.scale.signal
            findings.append(finding_of(FindingKind.SCALE_POWER_HELD, *names, power=given[name]))
    return vehicle.with_stated(given), findings


def _scale_varies(recordings: Sequence[Recording], vehicle: Vehicle, group: ChainGroup) -> bool:
    """Whether a scale signal varies over more than `IGNORED_THRUST` of the group's thrust."""
    assert group.scale is not None
    scale = vehicle.scales.index(group.scale.signal)
    names = group.actuators or vehicle.actuators
    own = [vehicle.actuators.index(name) for name in names]
    values, thrusts = [np.zeros(0)], [np.zeros(0)]
    for recording in recordings:
        if recording.scales is None:
            continue
        commands, signal = recording.commands, recording.scales
        at = np.searchsorted(signal.stamps, commands.stamps, side="right") - 1
        values.append(signal.values[np.maximum(at, 0), scale])
        thrust = _core.allocate(vehicle.chain, np.ascontiguousarray(commands.values))[0]
        thrusts.append(np.abs(thrust[:, own]).sum(axis=1))
    value, thrust = np.concatenate(values), np.concatenate(thrusts)
    thrust = np.where(value > 0.0, thrust, 0.0)  # at 0 there is none, whatever the power
    if not thrust.sum() > 0.0:
        return False
    order = np.argsort(value, kind="stable")
    reached = np.cumsum(thrust[order]) / thrust.sum()
    low, high = value[order][
        np.searchsorted(reached, [IGNORED_THRUST / 2, 1.0 - IGNORED_THRUST / 2])
    ]
    return bool(high > LEAST_SCALE_RATIO * low)


def with_slew_stage(vehicle: Vehicle, whole: Vehicle) -> Vehicle | None:
    """The vehicle with estimated stages, `whole`, and a slew rate; None where it has one, or no room."""
    chain, place = [*whole.file.chain], len(vehicle.file.chain)
    rates, angles = (
        whole.constants.index[:, STAGES.index(s)] >= 0 for s in ("slew_rate", "full_angle")
    )
    if place == len(chain) or (rates & ~angles).any():  # an angle's rate is its own
        return None
    chain[place] = _with(chain[place], "slew_rate", STARTS["slew_rate"])
    return with_room(whole, chain)


def stage_candidates(vehicle: Vehicle, whole: Vehicle) -> list[StageCandidate]:
    """Candidates beyond the stages of `whole`, which is `with_estimated_stages` of `vehicle`."""
    chain, place = whole.file.chain, len(vehicle.file.chain)

    def wider(groups: list[ChainGroup]) -> Vehicle | None:
        return with_room(whole, [*chain[:place], *groups, *chain[place + 1 :]])

    own = chain[place]
    missing = _missing_of_the_curve(vehicle, whole)
    return [*_of_the_curve(own, missing, wider), *_by_group(whole, own, missing, wider)]


def _missing_of_the_curve(vehicle: Vehicle, whole: Vehicle) -> list[str]:
    """Stages of the thrust curve that are not estimated yet, beside a dead zone that is."""
    has = _stated(vehicle)
    sought = {
        n.partition(".")[0] for n in set(whole.constants.names) - set(vehicle.constants.names)
    }
    if "edge_forward" not in sought:
        return []
    both = ("reverse_ratio",) if "edge_reverse" in sought else ()
    return [s for s in (*both, "power") if s not in sought and not has[s]]


def _of_the_curve(
    own: ChainGroup, missing: Sequence[str], wider: Wider
) -> Iterator[StageCandidate]:
    """Missing stages of the thrust curve, the same for all actuators; `own`: the group that has it."""
    whole_curve = own
    for stage in missing:
        whole_curve = _with(whole_curve, stage, 1.0)
    probe = wider([whole_curve])
    for stage in missing:
        alone = wider([_with(own, stage, 1.0)])
        if alone is not None:
            selected = finding_of(FindingKind.CURVE_STAGE_SELECTED, stage=stage)
            yield StageCandidate(selected, alone, {}, probe or alone)


def _by_group(
    whole: Vehicle, own: ChainGroup, missing: Sequence[str], wider: Wider
) -> Iterator[StageCandidate]:
    """Stages that all actuators share in `own`, and those that the curve lacks, one for each group of them.

    Of one group: latency and lag, one for each actuator that has a command of its own.
    """
    groups, stages = actuator_groups(whole), STAGES_BY_GROUP
    if len(groups) == 1 and whole.actuators == whole.inputs:
        groups = {name: [name] for name in whole.actuators}
        stages = STAGES_BY_ACTUATOR
    kinds = ["+".join(m) if whole.file.thrusters else name for name, m in groups.items()]
    for stage in stages if len(groups) > 1 else ():
        shared = 1.0 if stage in missing else getattr(own, stage)
        if shared is not None:
            parts = [
                _with(ChainGroup(name=f"{stage}_{name}", actuators=members), stage, shared)
                for name, members in groups.items()
            ]
            split = wider([_with(own, stage, None), *parts])
            if split is None:
                continue
            origin = {f"{stage}.{part.name}": stage for part in parts}
            selected = finding_of(FindingKind.GROUP_STAGES_SELECTED, *kinds, stage=stage)
            yield StageCandidate(selected, split, origin, split)


def with_room(vehicle: Vehicle, chain: list[ChainGroup]) -> Vehicle | None:
    """The vehicle with this chain; None where it has more constants than the core takes."""
    with suppress(VehicleError):
        return vehicle.with_chain(chain)
    return None


def _with(group: ChainGroup, stage: str, value: float | None) -> ChainGroup:
    """The group with another value of one stage."""
    changed: ChainGroup = msgspec.structs.replace(group, **{stage: value})
    return changed


def actuator_groups(vehicle: Vehicle) -> dict[str, list[str]]:
    """Actuators that serve the same generalised forces, by the first of these; by all, if it leads two kinds.

    Thrusters: those that stand as far from the origin, and as far off the way there; by the first of them.
    """
    if vehicle.file.thrusters:
        return _groups_by_place(vehicle)
    groups: dict[tuple[int, ...], list[str]] = {}
    for k, name in enumerate(vehicle.actuators):
        groups.setdefault(tuple(np.flatnonzero(vehicle.mix[:, k]).tolist()), []).append(name)
    kinds = {serves: names for serves, names in groups.items() if serves}
    first = Counter(serves[0] for serves in kinds)
    named = {}
    for serves, names in kinds.items():
        own = [vehicle.forces[i].name for i in serves]
        named[own[0] if first[serves[0]] == 1 else "_".join(own)] = names
    return named


def _groups_by_place(vehicle: Vehicle) -> dict[str, list[str]]:
    matrix, scale = thruster_matrix(vehicle.thrusters)
    arms = np.abs(matrix[2]) * scale[2]  # [m] of their moments
    found: list[tuple[float, float, list[str]]] = []
    for one, arm in zip(vehicle.thrusters, arms.tolist(), strict=True):
        away = float(np.hypot(one.x, one.y))
        across = arm / max(away, 1e-9)
        like = [
            m
            for r, a, m in found
            if abs(r - away) < PLACE_TOLERANCE * max(r, away) and abs(a - across) < PLACE_TOLERANCE
        ]
        if like:
            like[0].append(one.name)
        else:
            found.append((away, across, [one.name]))
    return {names[0]: names for _, _, names in found}


def _stated(vehicle: Vehicle) -> dict[str, bool]:
    given = vehicle.constants.index >= 0
    return {stage: bool(given[:, STAGES.index(stage)].any()) for stage in STAGES}


def has_curve(vehicle: Vehicle) -> bool:
    """Whether the file states where thrust begins; a power alone does not."""
    return any(g.table or g.dead_zone or g.pair or g.steered for g in vehicle.file.chain)


def _dead_zones(
    vehicle: Vehicle, recordings: Sequence[Recording]
) -> tuple[list[ChainGroup], list[Finding]]:
    """Dead zones that the commands identify, and findings on the others.

    Actuators that serve the same forces are one group: each group has its own.
    """
    if has_curve(vehicle):
        return [], []
    if not (vehicle.file.thrusters or vehicle.file.forces):
        return [], [finding_of(FindingKind.DEAD_ZONE_NOT_SOUGHT, *WRENCH)]
    kinds = {} if vehicle.file.thrusters else actuator_groups(vehicle)
    if len(kinds) < 2:
        kinds = {"": list(vehicle.actuators)}
    groups, findings = [], []
    for kind, members in kinds.items():
        zone, finding = _dead_zone(vehicle, recordings, members)
        if zone is not None:
            name, own = (f"dead_zone_{kind}", members) if kind else ("", None)
            groups.append(ChainGroup(name=name, actuators=own, dead_zone=zone))
        findings += [] if finding is None else [finding]
    return groups, findings


def _dead_zone(
    vehicle: Vehicle, recordings: Sequence[Recording], members: Sequence[str]
) -> tuple[DeadZone | None, Finding | None]:
    """The dead zone of some actuators, if identifiable, and a finding if not or only in part."""
    ahead, astern = _edge_effect(vehicle, recordings, members) > LEAST_EDGE_EFFECT
    start = STARTS["edge_forward"]
    if ahead and astern:
        return DeadZone(start, STARTS["edge_reverse"]), None
    if ahead or astern:
        side = "astern" if ahead else "ahead"
        one_edge = finding_of(FindingKind.DEAD_ZONE_ONE_EDGE, *members, side=side)
        return DeadZone(start, "forward"), one_edge
    return None, finding_of(FindingKind.DEAD_ZONE_NOT_IDENTIFIABLE, *members)


def _edge_effect(
    vehicle: Vehicle, recordings: Sequence[Recording], members: Sequence[str]
) -> Array:
    """What another edge (2,) of some actuators, forward and reverse, would change beyond forces' gains.

    In units of the force, over the edge. 0 where thrusters are always beyond it and balanced, or know
    one thrust only: a gain has the same effect.
    """
    rows = usual_commands([r.commands.values for r in recordings])

    def forces(forward: float, reverse: float) -> Array:
        zone = ChainGroup(actuators=list(members), dead_zone=DeadZone(forward, reverse))
        return static_forces(vehicle.with_chain([zone]), rows)

    edge = STARTS["edge_forward"]
    now = forces(edge, edge)
    power = (now**2).sum(axis=0)
    found = []
    for other in ((2 * edge, edge), (edge, 2 * edge)):
        change = (forces(*other) - now) / edge
        share = np.divide((change * now).sum(axis=0), power, out=0 * power, where=power > 0)
        left = ((change - share * now) ** 2).sum(axis=0)
        found.append(np.sqrt(np.divide(left, power, out=0 * power, where=power > 0)).max())
    return np.array(found)
