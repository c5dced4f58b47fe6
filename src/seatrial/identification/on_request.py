# SPDX-License-Identifier: MIT
"""What identify tells on request: bootstrap, profile likelihood, accuracy against length."""

from collections.abc import Sequence

import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.estimator import fit
from seatrial.identification.likelihood.fit_horizon import least_noise
from seatrial.identification.likelihood.optimiser import search
from seatrial.identification.likelihood.problem import KINDS
from seatrial.identification.solution import METHOD, Fit, OutputErrorSettings
from seatrial.identification.uncertainty.bootstrap import LEVEL, bootstrap, intervals
from seatrial.identification.uncertainty.covariance import sandwich
from seatrial.identification.uncertainty.dead_zone import as_likely
from seatrial.identification.uncertainty.lag import by_squares
from seatrial.identification.uncertainty.profile import Profile, profile
from seatrial.identification.uncertainty.record_length import minutes, minutes_text
from seatrial.recording.recording import Recording
from seatrial.util.errors import IdentificationError
from seatrial.util.format import plus_minus, table

FEWEST = 40  # replicates that an interval can be read from


def evidence(
    model: Model,
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    *,
    replicates: int = 0,
    profiled: Sequence[str] = (),
    lengths: bool = False,
) -> str:
    """Tables for the terminal, from the solution that a model of output-error came from.

    `replicates` of the bootstrap, 0 for none; `profiled`: parameters whose likelihood is profiled;
    `lengths`: accuracy against length. Raises IdentificationError for a model of another method, or
    one that rests on a prior.
    """
    if model.estimator.method != METHOD:
        raise IdentificationError(
            f"--bootstrap, --profile and --minutes belong to {METHOD}, not to "
            f"{model.estimator.method}; add --method {METHOD}"
        )
    if "prior" in model.estimator.settings:
        raise IdentificationError(
            "--bootstrap, --profile and --minutes weigh recordings alone: leave --prior out"
        )
    if replicates and replicates < FEWEST:
        raise IdentificationError(
            f"--bootstrap {replicates}: an interval takes {FEWEST} replicates or more; 200 are usual"
        )
    whole = _solution(model, recordings, vehicle)
    parts = [minutes_text(minutes(whole))] if lengths else []
    if profiled:
        parts.append(profile_text([profile(whole, name) for name in profiled]))
    if replicates:
        parts.append(bootstrap_text(whole, replicates))
    return "\n\n".join(parts)


def _solution(model: Model, recordings: Sequence[Recording], vehicle: Vehicle) -> Fit:
    """What a model came from, found again from where it ends: believed as closely as it was."""
    chosen, usual = model.estimator.settings, OutputErrorSettings()
    settings = OutputErrorSettings(
        outlier=float(chosen.get("outlier") or usual.outlier),
        block=float(chosen.get("block") or usual.block),
        effects=tuple(k for k in KINDS if k in str(chosen.get("effects", "")).split(", ")),
        hold_noise=True,
        extras=False,
    )
    near = fit(recordings, vehicle, start=model, settings=settings)
    share = float(chosen.get("belief") or 0.0)
    at = search(near.problem, near.theta, near.noise, least=least_noise(near.problem, share))
    covariance = by_squares(at, as_likely(at, sandwich(at)))
    if set(near.names) <= set(model.parameters):  # without effects: the errors that it states
        own = [model.parameters.index(name) for name in near.names]
        covariance = model.covariance[np.ix_(own, own)]
    return Fit(
        near.problem, at.theta, at.noise, at.passes, covariance, settings, near.findings, share
    )


def bootstrap_text(whole: Fit, replicates: int) -> str:
    """Standard errors by the sandwich and by the bootstrap, and its percentile intervals."""
    draws = bootstrap(whole, replicates)
    errors, own = draws.std(axis=0, ddof=1), np.sqrt(np.diag(whole.covariance))
    head = [f"bootstrap of {replicates}", "sandwich", "bootstrap", f"{LEVEL:.0f} % from", "to"]
    rows = [
        [name, f"{a:.2g}", f"{b:.2g}", f"{low:.5g}", f"{high:.5g}"]
        for name, a, b, (low, high) in zip(whole.names, own, errors, intervals(draws), strict=True)
    ]
    return table(head, rows)


def profile_text(found: Sequence[Profile]) -> str:
    """Intervals by profile likelihood beside the estimates."""
    head = ["profile likelihood", "estimate", "95 % from", "to"]
    rows = [[p.name, _estimate(p), _end(p.low), _end(p.high)] for p in found]
    return table(head, rows)


def _estimate(found: Profile) -> str:
    """With its standard error, where it has one."""
    if found.error == 0.0:
        return f"{found.value:.5g} at its bound"
    return plus_minus(found.value, found.error)


def _end(value: float) -> str:
    """An interval's end."""
    return f"{value:.5g}" if np.isfinite(value) else "open"
