# SPDX-License-Identifier: MIT
"""Angles as actuators: rudder, outboard, azimuth thruster. Their entry of a chain group, checked."""

from collections.abc import Sequence

from seatrial.boat.schema import ChainGroup, SteeredEntry
from seatrial.util.errors import SeatrialError, VehicleError


def steered_entries(groups: Sequence[ChainGroup]) -> list[SteeredEntry]:
    """The steered entries of a chain."""
    return [group.steered for group in groups if group.steered is not None]


def angle_names(groups: Sequence[ChainGroup]) -> list[str]:
    """Actuators that are angles."""
    return [angle for entry in steered_entries(groups) for _, angle in entry.of]


def angles_alone(groups: Sequence[ChainGroup]) -> list[ChainGroup]:
    """What is known of a chain before anything is identified: which angle turns which thrust, and by how much."""
    return [
        ChainGroup(steered=SteeredEntry(entry.of, entry.angle_deg))
        for entry in steered_entries(groups)
    ]


def stages_of(entry: SteeredEntry) -> dict[str, tuple[str, float | str]]:
    """By stage of the core's actuator: name of the constant, and its value or 'estimate'."""
    given = {
        "edge_forward": ("steer_dead_zone", entry.dead_zone),
        "full_angle": ("steer_angle", entry.angle_deg),
        "angle_offset": ("steer_offset", entry.offset_deg),
        "slew_rate": ("steer_rate", entry.rate_deg),
    }
    return {s: (name, value) for s, (name, value) in given.items() if value is not None}


def refuse_angles(groups: Sequence[ChainGroup], source: str, error: type[SeatrialError]) -> None:
    """Raise `error` where a chain has angles: the allocator takes thrust that is linear in its commands."""
    angles = angle_names(groups)
    if len(angles) == 1:
        raise error(
            f"{source}: {angles[0]} is an angle (chain: steered); the allocator takes thrusters in fixed "
            "directions. A thrust and its angle have one allocation, by the model's coefficients: "
            "`seatrial allocate`, `tune` (without --allocation) and MPC of the model use it"
        )
    if angles:
        raise error(
            f"{source}: {', '.join(angles)} are angles (chain: steered); the allocator takes thrusters in fixed "
            "directions. Commands identify, predict, mimic, sim and export, and the odometry node, work with them"
        )


def check_steering(groups: Sequence[ChainGroup], source: str) -> None:
    """Every actuator is in one steered pair at most, and none of them in a `pair`. Raises VehicleError."""
    names = [name for entry in steered_entries(groups) for two in entry.of for name in two]
    if any(not entry.of for entry in steered_entries(groups)):
        raise VehicleError(
            f"{source}: chain: steered: no actuator named; of: [[thrust, angle]] names two of the inputs"
        )
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise VehicleError(
            f"{source}: chain: steered: {', '.join(twice)} named twice; one angle turns one thrust"
        )
    paired = {name for g in groups if g.pair for two in g.pair.of for name in two}
    if both := sorted(paired & set(names)):
        raise VehicleError(
            f"{source}: chain: {', '.join(both)} is in a pair and steered; give one of the two"
        )
    for group in groups:
        scaled = set(angle_names(groups)) & set(group.actuators or [])
        gains = set(angle_names(groups)) & set(group.gains or {})
        if gains or (scaled and group.scale is not None):
            raise VehicleError(
                f"{source}: chain: {', '.join(sorted(gains or scaled))} is an angle, which has no gain "
                "and no scale; angle_deg is its size"
            )
