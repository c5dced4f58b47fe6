# SPDX-License-Identifier: MIT
"""Parameters that are held at a neutral value, and the test whether the data ask for another one.

A stage of the actuator chain, an effect of a recording, gains of thrusters: each is tested by one filter pass.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from seatrial.boat.findings import Finding
from seatrial.identification.likelihood.filter_runs import FilterRuns
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.selection.score_test import ScoreTest, score_test
from seatrial.util.frames import Array


@dataclass(frozen=True)
class Held:
    """Parameters that are held, and the test of their neutral values."""

    test: ScoreTest
    problem: Problem  # in which they are free
    theta: Array  # where its search begins
    findings: Callable[[Array], Sequence[Finding]]  # of the parameters (names,) with them
    runs: FilterRuns | None = None  # a pass there, where it is at hand
    kind: str = ""  # of `EFFECT_KINDS`; empty: no effect


def held_test(
    runs: FilterRuns, problem: Problem, wider: Problem, *, after_step: bool = False
) -> ScoreTest:
    """The test of parameters that are free in a wider problem and held in `problem`, whose solution `runs` is.

    runs: at the neutral values, of the wider problem or of one that is wider still. A constant that is one for
    each group of actuators in the wider problem is tested by the differences between groups. `after_step`: see
    `score_test`.
    """
    before = {problem.names[i] for i in problem.free}
    after = {wider.names[i] for i in wider.free}
    names = [runs.problem.names[i] for i in runs.problem.free]
    neutral = [k for k, name in enumerate(names) if name not in after]
    new = [k for k, name in enumerate(names) if name in after - before]
    split = [k for k in new if names[k].partition(".")[0] in before - after]
    return score_test(
        runs, [k for k in new if k not in split[:1]], split, neutral, after_step=after_step
    )
