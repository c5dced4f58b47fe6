# SPDX-License-Identifier: MIT
"""Causes in words: the most probable one, what can't be told apart, probabilities."""

from collections.abc import Sequence

from seatrial.evaluation.comparison.cause_candidates import (
    BATTERY,
    NONE_OF_THESE,
    ONE_THRUSTER,
    TWO,
    signed,
)
from seatrial.evaluation.comparison.causes import Cause

SAME_EVIDENCE = 1e-6  # [-] difference of logarithms, of two candidates with one map
PROBABLE = 0.5  # from which on one cause is more probable than all others together


def most_probable(found: Sequence[Cause]) -> Cause | None:
    """The cause that is more probable than all others together; None: there is none."""
    return found[0] if found and found[0].probability > PROBABLE else None


def inseparable(found: Sequence[Cause]) -> bool:
    """Whether battery and one thruster lead, with one map: no term of the structure separates them."""
    leading = {cause.cause for cause in found[:2]} == {BATTERY, ONE_THRUSTER}
    return leading and abs(found[0].log_evidence - found[1].log_evidence) < SAME_EVIDENCE


def cause_text(found: Sequence[Cause]) -> str:
    """One sentence: what explains the difference best, and with which probability."""
    if not found:
        return "No cause can be computed: no coefficient was estimated in both models"
    first, rest = found[0], found[1:]
    if inseparable(found):
        both = f"{BATTERY} or {ONE_THRUSTER}"
        change = next(c.change for c in found if c.cause == BATTERY) or 0.0
        whole = sum(c.probability for c in found if c.cause in (BATTERY, ONE_THRUSTER))
        return (
            f"Most probable cause: {both} (thrust {signed(change)}), {probability_text(whole)}. No term of this "
            "structure separates the two"
        )
    others = ", ".join(
        f"{c.cause} {probability_text(c.probability)}" for c in rest if c.probability >= 0.01
    )
    tail = f" ({others})" if others else ""
    if most_probable(found) is None:
        listed = ", ".join([f"{first.cause} {probability_text(first.probability)}", others]).rstrip(
            ", "
        )
        return f"The cause is not clear: {listed}"
    return f"Most probable cause: {_named(first)}, {probability_text(first.probability)}{tail}"


def _named(cause: Cause) -> str:
    if cause.cause == NONE_OF_THESE:
        return "none of the single causes"
    if cause.change is None:
        return f"{cause.cause} ({cause.what})" if cause.cause == TWO else cause.cause
    return f"{cause.cause} ({cause.what} {signed(cause.change)})"


def probability_text(probability: float) -> str:
    """In per cent, without a false 0 or 100."""
    if probability > 0.99:
        return "> 99 %"
    return "< 1 %" if probability < 0.01 else f"{100.0 * probability:.0f} %"
