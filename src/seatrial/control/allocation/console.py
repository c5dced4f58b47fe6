# SPDX-License-Identifier: MIT
"""The comparison of schemes as text and as JSON."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from seatrial.boat.vehicle import WRENCH
from seatrial.control.allocation.schemes import AllocationComparison, Drive, Row, yaw_beside_surge
from seatrial.util.frames import AXES

WIDTH = 21  # [characters] of a scheme's name


def allocation_text(found: AllocationComparison) -> str:
    """The boat, a table of authority and idle power by scheme, and one for every recording."""
    lines = [_boat(found), *_thrusters(found), "", *_authority(found), *_differential(found)]
    drives = max((row.drives for row in found.rows), key=len, default=())
    for place, drive in enumerate(drives):
        lines += ["", *_drive_lines(found, place, drive)]
    lines += ["", f"scheme: {found.allocator.scheme.value}: {found.allocator.why}"]
    return "\n".join(lines)


def wrench_text(found: AllocationComparison, wrench: Sequence[float]) -> str:
    """Commands for one wrench (3,). Raises AllocationError where it is out of reach."""
    own = found.allocator
    commands = own.allocate(wrench, saturate=False)
    requested = ", ".join(f"{name} {x:g}" for name, x in zip(WRENCH, wrench, strict=True))
    lines = [f"{own.scheme.value}: {requested}"]
    lines += [f"  {name:<16}{c:9.4f}" for name, c in zip(own.thrusters, commands, strict=True)]
    return "\n".join(lines)


def allocation_json(found: AllocationComparison) -> dict[str, Any]:
    """The same as JSON."""
    names = found.boat.thrusters
    return {
        "vehicle": found.boat.vehicle.name,
        "axes": "forward-left-up",
        "thrusters": {
            name: {
                "effectiveness": found.boat.T[:, k].tolist(),
                "dead_zone": {
                    "forward": float(found.allocator.edges[0, k]),
                    "reverse": float(found.allocator.edges[1, k]),
                },
                "limit": float(found.allocator.limits[k]),
            }
            for k, name in enumerate(names)
        },
        "scale": dict(zip(AXES, found.boat.scale.tolist(), strict=True)),
        "priority": found.priority,
        "chosen": found.allocator.scheme.value,
        "schemes": [_row_json(row) for row in found.rows],
    }


def _row_json(row: Row) -> dict[str, Any]:
    content: dict[str, Any] = {"scheme": row.name, "why": row.why}
    if row.allocator is not None and row.authority is not None:
        content |= {
            "authority": {
                axis: {"positive": float(a), "negative": float(b)}
                for axis, (a, b) in zip(AXES, row.authority, strict=True)
            },
            "idle_power": row.idle_power,
            "idle": dict(zip(row.allocator.thrusters, row.allocator.idle.tolist(), strict=True)),
            "switching": list(row.allocator.switching),
        }
    content["drives"] = [_drive_json(drive) for drive in row.drives]
    return content


def _drive_json(drive: Drive) -> dict[str, Any]:
    return {
        "recording": drive.recording,
        "minutes": drive.minutes,
        "crossings_per_minute": dict(drive.crossings),
        "wrench_error": dict(zip(AXES, drive.error.tolist(), strict=True)),
        "wrench_asked": dict(zip(AXES, drive.requested.tolist(), strict=True)),
        "limited": drive.limited,
        "power": drive.power,
    }


def _boat(found: AllocationComparison) -> str:
    own = found.boat
    kind = "identified coefficients" if own.identified else "positions and directions"
    return (
        f"{own.vehicle.name}: {len(own.thrusters)} thrusters, T from {kind}; wrench in command units, "
        "forward-left-up; at the limits: " + found.priority
    )


def _thrusters(found: AllocationComparison) -> list[str]:
    own, T = found.allocator, found.boat.T
    axes = list(found.boat.driven)
    head = "".join(f"{AXES[i]:>8}" for i in axes)
    lines = [f"  {'thruster':<16}{head}   {'dead zone':<18}limit"]
    for k, name in enumerate(own.thrusters):
        given = "".join(f"{x:8.3f}" for x in T[axes, k])
        astern, ahead = own.edges[1, k], own.edges[0, k]
        zone = f"{-astern:.3f} to {ahead:.3f}" if astern or ahead else "none known"
        lines.append(f"  {name:<16}{given}   {zone:<18}{own.limits[k]:.2f}")
    return lines


def _authority(found: AllocationComparison) -> list[str]:
    axes = list(found.boat.driven)
    head = "".join(f"{AXES[i]:>15}" for i in axes)
    lines = [f"  {'most of one axis':<{WIDTH}}{head}   idle power"]
    for row in found.rows:
        if row.authority is not None:
            ends = "".join(
                f"{f'{_hundredths(-b)} to {_hundredths(a)}':>15}"
                for a, b in np.asarray(row.authority)[axes].tolist()
            )
            lines.append(f"  {row.name:<{WIDTH}}{ends}   {row.idle_power:10.3f}")
        elif row.allocator is None and not row.drives:
            lines.append(f"  {row.name:<{WIDTH}} not possible: {row.why}")
    return lines


def _hundredths(value: float) -> str:
    """Two decimals; zero has no sign."""
    return f"{round(value, 2) + 0.0:.2f}"


def _differential(found: AllocationComparison) -> list[str]:
    """Of a boat without sway thrust: the yaw that is left beside surge."""
    if len(found.boat.driven) == 3:
        return []
    left = ", ".join(
        f"{_hundredths(-least)} to {_hundredths(most)} at {surge:.2f}"
        for surge, least, most in yaw_beside_surge(found.allocator).tolist()
    )
    return ["", f"  no sway thrust; yaw that is left at a surge of: {left}"]


def _drive_lines(found: AllocationComparison, place: int, drive: Drive) -> Sequence[str]:
    lines = [
        f"  {drive.recording}, {drive.minutes:.1f} min",
        f"  {'':<{WIDTH}}{'crossings/min':>15}{'wrench error':>15}{'limited':>10}{'power':>9}",
    ]
    for row in found.rows:
        if row.drives:
            d = row.drives[place]
            lines.append(
                f"  {row.name:<{WIDTH}}{d.crossing:15.1f}{100 * d.error_share:13.1f} %"
                f"{100 * d.limited:8.1f} %{d.power:9.3f}"
            )
    return lines
