# SPDX-License-Identifier: MIT
"""Values of the chain's constants, written into the groups that state them."""

from collections.abc import Mapping, Sequence

import msgspec

from seatrial.boat.actuators.constants import ESTIMATE, STAGES
from seatrial.boat.schema import ChainGroup, DeadZone, Estimate


def stated(
    groups: Sequence[ChainGroup], values: Mapping[str, float | Estimate]
) -> list[ChainGroup]:
    """The groups with these values of constants, by name, or left to the estimator."""
    return [_stated(group, values) for group in groups]


def _stated(group: ChainGroup, values: Mapping[str, float | Estimate]) -> ChainGroup:
    suffix = f".{group.name}" if group.name else ""
    here = {stage: values[stage + suffix] for stage in STAGES if stage + suffix in values}

    changes: dict[str, object] = {}
    if group.dead_zone is not None and {"edge_forward", "edge_reverse"} & set(here):
        zone = edges(group.dead_zone)
        changes["dead_zone"] = DeadZone(
            here.get("edge_forward", zone.forward), here.get("edge_reverse", zone.reverse)
        )
    if group.scale is not None:
        power = _put(group.scale, here, {"power": "scale_power"})
        changes["scale"] = msgspec.structs.replace(group.scale, **power)
    if group.pair is not None:
        dead = _put(group.pair, here, {"dead_zone": "pair_dead_zone"})
        ends = {end: f"pair_offset_{end}" for end in ("along", "across")}
        offset = msgspec.structs.replace(group.pair.offset, **_put(group.pair.offset, here, ends))
        changes["pair"] = msgspec.structs.replace(group.pair, offset=offset, **dead)
    if group.steered is not None:
        keys = {
            key: name + suffix
            for key, name in (
                ("angle_deg", "steer_angle"), ("offset_deg", "steer_offset"),
                ("rate_deg", "steer_rate"), ("dead_zone", "steer_dead_zone"),
            )
        }  # fmt: skip
        given = _put(group.steered, values, keys)
        changes["steered"] = msgspec.structs.replace(group.steered, **given)
    if group.gains is not None:
        changes["gains"] = {n: values.get(f"gain.{n}", gain) for n, gain in group.gains.items()}
    single = {stage: stage for stage in ("latency", "reverse_ratio", "power", "lag", "slew_rate")}
    return msgspec.structs.replace(group, **_put(group, here, single), **changes)


def _put(
    entry: msgspec.Struct, values: Mapping[str, float | Estimate], keys: Mapping[str, str]
) -> dict[str, float | Estimate]:
    """Values, by stage, of those keys that the entry gives."""
    given = {key: stage for key, stage in keys.items() if getattr(entry, key) is not None}
    return {key: values[stage] for key, stage in given.items() if stage in values}


def edges(given: DeadZone | Estimate) -> DeadZone:
    """Both edges, also where the file leaves them to the estimator in one word."""
    return DeadZone(ESTIMATE, ESTIMATE) if isinstance(given, str) else given
