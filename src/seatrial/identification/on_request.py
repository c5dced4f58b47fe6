# SPDX-License-Identifier: MIT
"""Tables that `identify` makes on request: bootstrap, profile likelihood, accuracy against record length."""

from collections.abc import Sequence

import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.estimator import fit
from seatrial.identification.likelihood.fit_horizon import noise_floor
from seatrial.identification.likelihood.optimiser import maximise_likelihood
from seatrial.identification.likelihood.problem import EFFECT_KINDS
from seatrial.identification.solution import OUTPUT_ERROR, Fit, OutputErrorSettings
from seatrial.identification.uncertainty.bootstrap import INTERVAL_LEVEL, bootstrap, intervals
from seatrial.identification.uncertainty.covariance import sandwich_covariance
from seatrial.identification.uncertainty.dead_zone import with_dead_zone_profile
from seatrial.identification.uncertainty.lag import with_lag_by_square
from seatrial.identification.uncertainty.profile import Profile, profile
from seatrial.identification.uncertainty.record_length import accuracy_by_length, record_length_text
from seatrial.recording.recording import Recording
from seatrial.util.errors import IdentificationError
from seatrial.util.format import plus_minus, table

FEWEST_REPLICATES = 40  # replicates that an interval can be read from


def accuracy_tables(
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
    if model.estimator.method != OUTPUT_ERROR:
        raise IdentificationError(
            f"--bootstrap, --profile and --minutes belong to {OUTPUT_ERROR}, not to "
            f"{model.estimator.method}; add --method {OUTPUT_ERROR}"
        )
    if "prior" in model.estimator.settings:
        raise IdentificationError(
            "--bootstrap, --profile and --minutes weigh recordings alone: leave --prior out"
        )
    if replicates and replicates < FEWEST_REPLICATES:
        raise IdentificationError(
            f"--bootstrap {replicates}: an interval takes {FEWEST_REPLICATES} replicates or more; 200 are usual"
        )
    whole = _solution(model, recordings, vehicle)
    parts = [record_length_text(accuracy_by_length(whole))] if lengths else []
    if profiled:
        parts.append(profile_text([profile(whole, name) for name in profiled]))
    if replicates:
        parts.append(bootstrap_text(whole, replicates))
    return "\n\n".join(parts)


def _solution(model: Model, recordings: Sequence[Recording], vehicle: Vehicle) -> Fit:
    """The solution that a model is of, searched again from its parameters with its fit horizon."""
    chosen, usual = model.estimator.settings, OutputErrorSettings()
    settings = OutputErrorSettings(
        outlier=float(chosen.get("outlier") or usual.outlier),
        block=float(chosen.get("block") or usual.block),
        effects=tuple(k for k in EFFECT_KINDS if k in str(chosen.get("effects", "")).split(", ")),
        hold_noise=True,
        select_stages=False,
    )
    near = fit(recordings, vehicle, start=model, settings=settings)
    share = float(chosen.get("belief") or 0.0)
    at = maximise_likelihood(
        near.problem, near.theta, near.noise, least=noise_floor(near.problem, share)
    )
    covariance = with_lag_by_square(at, with_dead_zone_profile(at, sandwich_covariance(at)))
    if set(near.names) <= set(model.parameters):  # without effects: the errors that it states
        own = [model.parameters.index(name) for name in near.names]
        covariance = model.covariance[np.ix_(own, own)]
    return Fit(
        near.problem, at.theta, at.noise, at.runs, covariance, settings, near.findings, share
    )


def bootstrap_text(whole: Fit, replicates: int) -> str:
    """Standard errors by the sandwich and by the bootstrap, and its percentile intervals."""
    draws = bootstrap(whole, replicates)
    errors, own = draws.std(axis=0, ddof=1), np.sqrt(np.diag(whole.covariance))
    head = [
        f"bootstrap of {replicates}",
        "sandwich",
        "bootstrap",
        f"{INTERVAL_LEVEL:.0f} % from",
        "to",
    ]
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
