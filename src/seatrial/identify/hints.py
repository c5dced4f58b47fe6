# SPDX-License-Identifier: MIT
"""Effects that nobody asked for but the data do: a score test of each kind."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from seatrial.errors import IdentificationError
from seatrial.filter_noise import DISTURBANCES, PROCESS, RAISED
from seatrial.frames import Array
from seatrial.identify.belief import least_noise
from seatrial.identify.problem import KINDS, Problem
from seatrial.identify.score_test import score_test
from seatrial.identify.search import Point, search
from seatrial.identify.whiteness import explained

ASKED = "less than half of the unmodelled force is left with"  # notes of effects begin so
WORTH = 20.0  # fall of -2 log likelihood from which on an effect is worth a word
GONE = 0.5  # of what pushes the boat must be left at most
CLEAR = 5.0  # standard deviations of chi-square, then
WORDS: dict[str, Callable[[Array], str]] = {  # by what it would be
    "lever": lambda s: f"poses of a point about {np.hypot(*s):.2g} m off the origin, a lever arm",
    "current": lambda s: f"a current of up to {np.hypot(*s.reshape(-1, 2).T).max():.2g} m/s",
    "trim": lambda _: "a steady push, as of thrusters that are not quite at rest",
    "wind": lambda _: "wind",
}


def hints(at: Point, share: float) -> list[str]:
    """The effect that the data ask for most, among those that are not sought; said in words.

    It is looked for only where something acts that the model does not say, and tried. `share`: how
    closely the model is believed.
    """
    problem = at.passes.problem
    places = {kind: _places(problem, kind) for kind in KINDS}
    new = {kind: own for kind, own in places.items() if not set(own) & set(problem.free)}
    if explained(at) or not new:
        return []
    wider = replace(problem, free=(*problem.free, *sum(new.values(), ())))
    passes = wider.passes(at.theta, at.noise, repeatable=False)
    asked = {}
    for kind, own in new.items():
        tested = [wider.free.index(i) for i in own]
        others = set(range(len(problem.free), len(wider.free))) - set(tested)
        test = score_test(passes, tested, neutral=sorted(others))
        likely = test.statistic > test.freedom + CLEAR * np.sqrt(2.0 * test.freedom)
        if likely and test.gain > WORTH:
            asked[kind] = test
    if not asked:
        return []
    kind = max(asked, key=lambda k: asked[k].gain)
    theta = at.theta.copy()
    theta[list(new[kind])] = asked[kind].step
    asked_for = replace(problem, free=(*problem.free, *new[kind]))
    try:
        there = search(asked_for, theta, at.noise, least=least_noise(asked_for, share))
    except IdentificationError:
        return []
    if not _quieter(at.noise, there.noise):
        return []
    return [
        f"{ASKED} {WORDS[kind](there.theta[list(new[kind])])}: if that may be, identify with "
        f"--effect {kind}, before further terms are sought"
    ]


def _quieter(before: Array, after: Array) -> bool:
    """Whether what pushes the boat, of the linear or the angular motion, is half gone: an effect that
    explains less may stand for another."""
    old, new = (np.hypot(n[PROCESS][:2], n[DISTURBANCES]) for n in (before, after))
    there = old > RAISED[DISTURBANCES]
    return bool((new < GONE * old)[there].any())


def _places(problem: Problem, kind: str) -> tuple[int, ...]:
    """Where effects of a kind stand among all parameters."""
    first = problem.size + problem.constants
    return tuple(
        i for i, n in enumerate(problem.names) if i >= first and n.partition("_")[0] == kind
    )
