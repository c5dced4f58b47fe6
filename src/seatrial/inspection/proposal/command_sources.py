# SPDX-License-Identifier: MIT
"""Columns of the same actuators by their names: a pilot's and an autopilot's, commanded and measured."""

from collections.abc import Iterable, Sequence

from seatrial.inspection.proposal.columns.names import read_name

PILOT = frozenset(("manual", "rc", "pilot", "stick", "joy", "joystick", "teleop", "operator"))
AUTOPILOT = frozenset(("auto", "autopilot", "autonomous", "ap", "nav", "controller", "mpc", "pid"))
COMMANDED = frozenset(
    ("cmd", "command", "commanded", "desired", "des", "setpoint", "sp", "target", "ref", "demand")
)
MEASURED = frozenset(("measured", "meas", "actual", "act", "feedback", "fb"))


def measured_twins(names: Iterable[str]) -> set[str]:
    """Columns that measure what another one commands: rpm_left beside rpm_cmd_left, or left_actual beside left."""
    found: dict[tuple[str, ...], list[str]] = {}
    words = {name: read_name(name).words for name in names}
    for name, own in words.items():
        found.setdefault(tuple(w for w in own if w not in COMMANDED | MEASURED), []).append(name)
    twins: set[str] = set()
    for same in found.values():
        commanded = [n for n in same if COMMANDED & {*words[n]}]
        plain = [n for n in same if not MEASURED & {*words[n]}]
        kept = commanded or plain
        twins |= {*same} - {*kept} if kept else set()
    return twins


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
        if of:
            of[0][tuple(w for w in words if w not in PILOT | AUTOPILOT)] = name
        else:
            common.append(name)
    pilot, autopilot = found
    if not pilot or pilot.keys() != autopilot.keys():
        return ()
    sets = ({*own.values(), *common} for own in found)
    return tuple(tuple(name for name in names if name in own) for own in sets)
