# SPDX-License-Identifier: MIT
"""A tuning as text."""

from collections.abc import Sequence

import numpy as np

from seatrial.control.tuning.dead_zone import dead_zone
from seatrial.control.tuning.design import SENSITIVITY_LIMIT, Tuning
from seatrial.control.tuning.loops import Margins
from seatrial.util.format import table
from seatrial.util.frames import AXES, POSE_UNITS


def tuning_text(tuning: Tuning) -> str:
    """Gains, margins, and their limits."""
    drawn = f"worst of {tuning.draws} draws (seed {tuning.seed}), {tuning.curves}"
    nominal = f"the model has no standard errors: nominal model, {tuning.curves}"
    return "\n".join(
        [
            f"{tuning.model.name}: {tuning.action.upper()} gains, knob {tuning.knob:g} s, "
            f"{tuning.rate:g} Hz, for commands of at most 1",
            *allocation_line(tuning),
            gains_table(tuning),
            *guidance_lines(tuning),
            "Margins, each loop with the others closed, the worst of rest and the fastest motions:",
            margins_table(tuning.nominal, tuning.loops),
            f"The same, {drawn if tuning.draws else nominal} (sensitivity at most {SENSITIVITY_LIMIT:g}):",
            margins_table(tuning.worst, tuning.loops),
            *remarks(tuning),
        ]
    )


def allocation_line(tuning: Tuning) -> list[str]:
    """The scheme that allocates axis commands, unless the boat does it itself."""
    if tuning.allocator is None:
        return []
    return [f"Allocation {tuning.allocator.asked_scheme.value}: {tuning.allocator.why}"]


def guidance_lines(tuning: Tuning) -> list[str]:
    """What a boat without sway thrust can do, with the guidance's constants."""
    g = tuning.guidance
    if g is None:
        return []
    return [
        "No sway thrust: follows a path by line of sight with drift compensation, and keeps station "
        f"within {g.radius:.2g} m with the bow in the drift; sideways and at a heading of its own it can't.",
        f"Guidance: look-ahead {g.time:.3g} s times the speed, at least {g.radius:.2g} m; paths from "
        f"{g.slowest:.2g} m/s on, approach at up to {g.fastest:.2g} m/s.",
    ]


def gains_table(tuning: Tuning) -> str:
    """A row for each axis with thrust."""
    full, table_, delay = tuning.boat.authority, tuning.table(), tuning.delay
    rows = [
        (
            f"{AXES[i]} [1/{POSE_UNITS[i]}]", *(f"{x:.4g}" for x in table_[i]),
            f"{full[i]:.3g} {POSE_UNITS[i]}/s^2", f"{delay[i]:.3g}",
        )
        for i in tuning.boat.driven
    ]  # fmt: skip
    head = ("axis", "proportional", "integral [1/s]", "derivative [s]", "full command", "delay [s]")
    return table(head, rows)


def margins_table(found: Margins, loops: Sequence[str] = AXES) -> str:
    """A row a loop."""
    rows = [
        (
            axis,
            f"{found.gain_up[i]:.3g}" if np.isfinite(found.gain_up[i]) else "any",
            f"{np.degrees(found.phase[i]):.0f}", f"{found.delay[i]:.2g}",
            f"{found.sensitivity[i]:.2f}", f"{found.crossover[i]:.2g}",
        )
        for i, axis in enumerate(loops)
    ]  # fmt: skip
    head = ("axis", "gain, factor", "phase [deg]", "delay [s]", "sensitivity", "crossover [rad/s]")
    return table(head, rows)


def remarks(tuning: Tuning) -> list[str]:
    """Error at full command, and error within the dead zone."""
    axes = list(tuning.boat.driven)
    p, units = tuning.table()[axes, 0], [POSE_UNITS[i] for i in axes]
    reach = ", ".join(f"{1.0 / x:.2g} {unit}" for x, unit in zip(p, units, strict=True))
    names = ", ".join(AXES[i] for i in axes)
    found = [f"A single error of {reach} ({names}) results in full command."]
    dead = dead_zone(tuning.model, tuning.boat, tuning.allocator)[axes]
    if not dead.any():
        return found
    size = ", ".join(f"{x:.2g}" for x in dead)
    error = ", ".join(f"{d / x:.2g} {unit}" for d, x, unit in zip(dead, p, units, strict=True))
    effect = (
        f"station keeping is a slow limit cycle of about {error}"
        if tuning.action == "pid"
        else f"errors up to {error} remain"
    )
    found.append(f"Dead zone: commands up to {size} give no thrust; {effect}.")
    return found
