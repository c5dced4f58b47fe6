# SPDX-License-Identifier: MIT
"""Tables on request: bootstrap, profile likelihood, accuracy against record length."""

from collections.abc import Callable, Sequence

import numpy as np

from seatrial.identification.solution import OUTPUT_ERROR, Fit
from seatrial.identification.uncertainty.bootstrap import INTERVAL_LEVEL, bootstrap, intervals
from seatrial.identification.uncertainty.profile import Profile, profile
from seatrial.identification.uncertainty.record_length import accuracy_by_length, record_length_text
from seatrial.util.errors import IdentificationError
from seatrial.util.format import plus_minus, table
from seatrial.util.progress import over

FEWEST_REPLICATES = 40  # for a 95 % interval by order statistics


def accuracy_tables(
    solution: Fit | None,
    *,
    replicates: int = 0,
    profiled: Sequence[str] = (),
    lengths: bool = False,
) -> str:
    """Tables for the terminal, from the solution that a model came from.

    `replicates` of the bootstrap, 0 for none; `profiled`: parameters whose likelihood is profiled;
    `lengths`: accuracy against length. Raises IdentificationError where another method has no
    solution, or where it rests on a prior.
    """
    if solution is None:
        raise IdentificationError(
            f"--bootstrap, --profile and --minutes belong to {OUTPUT_ERROR}; add --method {OUTPUT_ERROR}"
        )
    if solution.problem.prior is not None:
        raise IdentificationError(
            "--bootstrap, --profile and --minutes are for recordings without a prior: leave --prior out"
        )
    if replicates and replicates < FEWEST_REPLICATES:
        raise IdentificationError(
            f"--bootstrap {replicates}: an interval needs {FEWEST_REPLICATES} replicates or more; 200 are usual"
        )
    makers: list[Callable[[], str]] = []
    if lengths:
        makers.append(lambda: record_length_text(accuracy_by_length(solution)))
    if profiled:
        makers.append(
            lambda: profile_text([profile(solution, name) for name in over(profiled, "profile")])
        )
    if replicates:
        makers.append(lambda: bootstrap_text(solution, replicates))
    return "\n\n".join(make() for make in over(makers))


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
