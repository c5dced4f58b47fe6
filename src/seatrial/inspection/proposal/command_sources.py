# SPDX-License-Identifier: MIT
"""Two sources of the same commands by their names: a pilot's sticks, and an autopilot's outputs."""

from collections.abc import Sequence

from seatrial.inspection.proposal.columns.names import read_name

PILOT = frozenset(("manual", "rc", "pilot", "stick", "joy", "joystick", "teleop", "operator"))
AUTOPILOT = frozenset(("auto", "autopilot", "autonomous", "ap", "nav", "controller", "mpc", "pid"))


def by_source(names: Sequence[str]) -> tuple[tuple[str, ...], ...]:
    """The pilot's and the autopilot's channels of the same actuators; empty: the names are not so.

    cmd_manual_left and cmd_auto_left differ by the word for the source alone. Channels without one are of both.
    """
    found: list[dict[tuple[str, ...], str]] = [{}, {}]
    common = []
    for name in names:
        words = read_name(name).words
        of = [
            own for own, source in zip(found, (PILOT, AUTOPILOT), strict=True) if source & {*words}
        ]
        if len(of) > 1:
            return ()
        if of:
            of[0][tuple(w for w in words if w not in PILOT | AUTOPILOT)] = name
        else:
            common.append(name)
    pilot, autopilot = found
    if not pilot or pilot.keys() != autopilot.keys():
        return ()
    sets = ({*own.values(), *common} for own in found)
    return tuple(tuple(name for name in names if name in own) for own in sets)
