# SPDX-License-Identifier: MIT
"""Plans of trials, bundled ones changed."""

from collections.abc import Mapping
from typing import Any

import msgspec

from seatrial.boat.vehicle import Vehicle
from seatrial.recording.recording import Recording
from seatrial.simulation.plan import PlanFile, load_plan, with_seed
from seatrial.simulation.trials import simulate


def planned(
    plan: str | PlanFile, *names: str, seconds: float | None = None, seed: int | None = None,
    coefficients: Mapping[str, float] | None = None, **parts: Mapping[str, Any],
) -> PlanFile:  # fmt: skip
    """A plan with these trials or all, each so long [s], and other coefficients or keys of its parts.

    parts: keys of plant, pose, joypad, pool or operator that have other values.
    """
    replace = msgspec.structs.replace
    plan = load_plan(plan) if isinstance(plan, str) else plan
    plan = plan if seed is None else with_seed(plan, seed)
    trials = {name: plan.trials[name] for name in names or plan.trials}
    if seconds is not None:
        trials = {name: replace(entry, duration=seconds) for name, entry in trials.items()}
    if coefficients is not None:
        own = {**plan.plant.coefficients, **coefficients}
        parts["plant"] = {"coefficients": own, **parts.get("plant", {})}
    changed = {part: replace(getattr(plan, part), **keys) for part, keys in parts.items()}
    return replace(plan, trials=trials, **changed)


def driven_by(plan: PlanFile, vehicle: Vehicle) -> list[Recording]:
    """Recordings of all trials of a plan."""
    return [trial.recording for trial in simulate(plan, vehicle)]
