# SPDX-License-Identifier: MIT
"""Whether the drive is enough for each use: by the model's covariance, and by its predictions of what came."""

from collections.abc import Iterator, Sequence

import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.physics import backward_thrust
from seatrial.poolside.needs import Need, needs_of
from seatrial.poolside.state import PredictionState, UseState
from seatrial.util.errors import ModelError
from seatrial.util.format import percent
from seatrial.workflow.fitness import (
    CONSISTENT,
    CONSISTENT_SO_SO,
    Criterion,
    Level,
    Reason,
    Use,
    level_of,
)

STEADY_UPDATES = 3  # of the model, and
STEADY_SECONDS = 10.0  # [s] in which a verdict must not change
LIMITED_RATIO = 2.0  # of a width over the allowed one, at most for a limited fitness
TOO_SHORT = "the drive is still too short for the standard errors of a saved model: drive on"
NEGLIGIBLE = 0.02  # of constant velocity's error ahead: a smaller one needs no comparison
ORDER = list(Level)


class Enough:
    """The verdict on every use, and whether it is steady."""

    def __init__(self, uses: Sequence[Use] = tuple(Use)) -> None:
        self.uses = tuple(uses)
        self.needs: list[Need] = []
        self.states = _all_unfit(uses, "there is no model yet")
        self._fit_since: list[float] = []  # [s] of the updates since all uses are fit
        self._whole = True

    @property
    def enough(self) -> bool:
        """Whether every use is fit, and was so over the last updates, and the drive gives a model."""
        since = self._fit_since
        return (
            self._whole and len(since) >= STEADY_UPDATES and since[-1] - since[0] >= STEADY_SECONDS
        )

    def update(
        self,
        t: float,
        model: Model | None,
        predictions: Sequence[PredictionState] = (),
        *,
        whole: bool = True,
    ) -> tuple[UseState, ...]:
        """A new model at t [s]: the verdict on every use. whole: the drive is long enough for `identify`."""
        self._whole = whole
        if model is None:
            self._fit_since = []
            return self.states
        try:
            self.needs = needs_of(model, self.uses)
        except ModelError:
            self.needs, self._fit_since = [], []
            self.states = _all_unfit(self.uses, Reason(Criterion.UNSTABLE).text())
            return self.states
        self.states = tuple(_use_state(use, model, self.needs, predictions) for use in self.uses)
        fit = all(one.level == Level.FIT.value for one in self.states)
        self._fit_since = [*self._fit_since, t] if fit else []
        if not whole:
            self.states = tuple(_at_most_limited(one) for one in self.states)
        return self.states


def _all_unfit(uses: Sequence[Use], why: str) -> tuple[UseState, ...]:
    return tuple(UseState(use.value, Level.NOT_FIT.value, why, 0.0) for use in uses)


def _at_most_limited(one: UseState) -> UseState:
    if one.level != Level.FIT.value:
        return one
    return UseState(one.use, Level.LIMITED.value, TOO_SHORT, one.share)


def _use_state(
    use: Use, model: Model, needs: Sequence[Need], predictions: Sequence[PredictionState]
) -> UseState:
    own = [need for need in needs if need.use is use]
    ratios = [need.ratio(model.covariance) for need in own]
    share = (
        float(np.mean([min(1.0, 1.0 / r**2) if r > 0.0 else 1.0 for r in ratios])) if own else 0.0
    )
    found = [_graded(need, ratio) for need, ratio in zip(own, ratios, strict=True)]
    found += _other_criteria(use, model, own, predictions)
    level, _, reason = max(found, key=lambda one: (ORDER.index(one[0]), one[1]))
    return UseState(use.value, level.value, reason, share)


def _graded(need: Need, ratio: float) -> tuple[Level, float, str]:
    """The level by one need, its ratio, and the reason."""
    if need.beyond:
        reason = f"{need.subject}: disturbances alone exceed the limit; more driving does not help"
        return Level.LIMITED, ratio, reason
    reason = f"{need.subject}: 95 % interval is {percent(ratio)} of the allowed one"
    return level_of(ratio, 1.0, LIMITED_RATIO), ratio, reason


def _other_criteria(
    use: Use, model: Model, own: Sequence[Need], predictions: Sequence[PredictionState]
) -> Iterator[tuple[Level, float, str]]:
    """Criteria that no covariance has: signs of thrust, and the error of predictions over the expected one."""
    if not own:
        yield Level.NOT_FIT, 0.0, Reason(Criterion.NO_INPUT).text()
    if use is Use.CONTROL:
        for name in backward_thrust(model):
            yield Level.NOT_FIT, 0.0, Reason(Criterion.BACKWARD, name).text()
        return
    for one in predictions:
        if one.expected is None or not one.expected > 0.0 or one.rms < NEGLIGIBLE * one.constant:
            continue
        value = one.rms / one.expected
        level = level_of(value, CONSISTENT, CONSISTENT_SO_SO)
        reason = Reason(Criterion.CONSISTENCY, one.axis, value, CONSISTENT, 1.0)
        yield level, value / CONSISTENT, reason.text()
