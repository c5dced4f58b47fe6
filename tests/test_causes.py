# SPDX-License-Identifier: MIT
"""Posterior probabilities of physical changes: known causes, the closed form, what can't be told apart."""

import re
from collections import Counter
from dataclasses import replace

import msgspec
import numpy as np
import pytest
from conftest import TABLE_II, make_model
from estimates import estimated
from scipy import stats
from survey_boat import boat as survey
from survey_boat import driven

import seatrial
from benchmarks.studies.payload import loaded
from seatrial.boat.vehicle import vehicle_from
from seatrial.evaluation.comparison import causes as module
from seatrial.evaluation.comparison.cause_candidates import (
    BATTERY,
    CAUSES,
    CURRENT,
    DRAG,
    MASS,
    NO_CHANGE,
    NONE_OF_THESE,
    OFF_CENTRE,
    ONE_THRUSTER,
    TWO,
    candidates,
)
from seatrial.evaluation.comparison.cause_text import cause_text
from seatrial.evaluation.comparison.causes import causes, evidence
from seatrial.evaluation.comparison.compare import compare
from seatrial.evaluation.comparison.console import comparison_text
from seatrial.evaluation.comparison.parameters import pairs, views
from seatrial.identification.estimator import output_error
from tests.boats.plans import driven_by, planned
from tests.boats.vehicles import by_columns

TRUTH = TABLE_II["MP"]
MORE = 1.2  # times mass and inertia
ERROR = 0.02  # relative standard error of every coefficient


def found(a, b):
    seen = views(a, b)
    return causes(a, b, pairs(a, b, seen, {}), seen)


def scaled(factor, of):
    return {n: v * factor if of(n) else v for n, v in TRUTH.items()}


OWN_DRAG = ("X_u", "X_uu", "Y_v", "Y_vv", "N_r", "N_rr")
HEAVIER = {name: value / MORE for name, value in TRUTH.items()}
KNOWN = {
    NO_CHANGE: (TRUTH, None),
    MASS: (HEAVIER, MORE - 1.0),
    OFF_CENTRE: (HEAVIER | {"N_ud": TRUTH["N_ud"] / MORE + 0.1}, MORE - 1.0),
    BATTERY: (scaled(0.8, lambda n: n.endswith("_F")), -0.2),
    DRAG: (scaled(1.3, lambda n: n in OWN_DRAG), 0.3),
    CURRENT: (TRUTH | {"X_u": -0.14, "X_uu": -1.1, "Y_v": -0.3, "Y_vv": -0.7}, None),
    TWO: ({n: v * (0.8 if n.endswith("_F") else 1.0) for n, v in HEAVIER.items()}, None),
    NONE_OF_THESE: (scaled(0.6, lambda n: n == "N_r"), None),
}


@pytest.mark.parametrize("cause", KNOWN)
def test_a_known_cause_is_the_most_probable_one(mp, cause):
    values, change = KNOWN[cause]
    every = [
        found(estimated(mp, TRUTH, 2 * k), estimated(mp, values, 2 * k + 1)) for k in range(10)
    ]
    first = Counter(one[0].cause for one in every)
    assert first[cause] >= (9 if cause == NO_CHANGE else 10), (
        first
    )  # of an unchanged boat errors vary
    for one in every:
        assert {c.cause for c in one} == {*CAUSES}
        assert sum(c.probability for c in one) == pytest.approx(1.0)
        assert one[0].log_evidence == 0.0
    if change is not None:
        sizes = [one[0].change for one in every if one[0].cause == cause]
        assert np.mean(sizes) == pytest.approx(change, abs=0.02)


def test_two_causes_at_once_are_named_with_their_sizes(mp):
    one = found(estimated(mp, TRUTH, 2), estimated(mp, KNOWN[TWO][0], 3))
    text = cause_text(one)
    sizes = re.search(r"two of these \(mass ([+-]\d+) % and battery ([+-]\d+) %\), > 99 %", text)
    assert sizes is not None, text
    assert [float(size) for size in sizes.groups()] == pytest.approx([20.0, -20.0], abs=4.0)


def test_a_payload_that_raises_drag_is_two_causes(mp):
    """A deeper draught: drag of every axis is up by 30 %, over 20 % more mass."""
    loaded_boat = {n: v * (1.3 if n in OWN_DRAG else 1.0) for n, v in HEAVIER.items()}
    leading = Counter()
    for k in range(10):
        one = found(estimated(mp, TRUTH, 2 * k), estimated(mp, loaded_boat, 2 * k + 1))
        leading[one[0].cause] += 1
        sizes = re.search(r"mass ([+-]\d+) % and drag ([+-]\d+) %", cause_text(one))
        if one[0].cause == TWO:
            assert sizes is not None, cause_text(one)
            assert [float(x) for x in sizes.groups()] == pytest.approx([20.0, 30.0], abs=9.0)
    assert leading[TWO] >= 9, leading


def test_the_evidence_of_a_linear_change_is_the_closed_form(mp):
    """d = B - A is normal with covariance C_A + C_B + G S G'."""
    a, b = estimated(mp, TRUTH, 1), estimated(mp, HEAVIER, 2)
    seen = views(a, b)
    problem = module._problem(a, b, pairs(a, b, seen, {}), seen)
    every = {c.cause: c for c in candidates(problem)}
    both, n = a.covariance[:11, :11] + b.covariance[:11, :11], len(problem.names)
    apart = problem.values[1] - problem.values[0]
    units = np.diag(problem.units)

    def closed(covariance):
        return stats.multivariate_normal(np.zeros(n), covariance).logpdf(apart)

    logs = [evidence(problem, every[c])[0] for c in (NO_CHANGE, NONE_OF_THESE)]
    right = [closed(both), closed(both + units @ units)]
    assert logs[1] - logs[0] == pytest.approx(right[1] - right[0], rel=1e-6)


def test_what_no_term_separates_is_equally_probable_and_it_says_so(mp):
    values, _ = KNOWN[BATTERY]
    one = found(estimated(mp, TRUTH, 1), estimated(mp, values, 2))
    assert [c.cause for c in one[:2]] == [BATTERY, ONE_THRUSTER]
    assert one[0].probability == pytest.approx(one[1].probability)
    text = cause_text(one)
    assert "battery or one thruster (thrust -2" in text
    assert "No term of this structure separates the two" in text


def test_a_boat_whose_commands_are_forces_has_no_thruster_that_changes(mp):
    """Its autopilot allocates: less thrust in surge alone is of no known thruster."""
    content = mp.to_mapping() | {"thrusters": {}, "allocation": {"scheme": "direct"}}
    boat = vehicle_from(content, "forces")
    weaker = scaled(0.7, lambda name: name == "X_F")
    one = found(estimated(boat, TRUTH, 1), estimated(boat, weaker, 2))
    assert ONE_THRUSTER not in {c.cause for c in one}
    text = cause_text(one)
    assert "thruster" not in text
    # with its thrusters known, one of them may explain a part
    assert ONE_THRUSTER in {
        c.cause for c in found(estimated(mp, TRUTH, 1), estimated(mp, weaker, 2))
    }


def test_one_thruster_of_two_with_gains_of_their_own_is_named():
    forces = {
        "F_p": {"axis": "surge", "of": {"port": 1}},
        "F_s": {"axis": "surge", "of": {"star": 1}},
    }
    structure = {
        "surge": ["v * r", "X_u * u", "X_p * F_p", "X_s * F_s"],
        "sway": ["-1 * u * r", "Y_v * v"],
        "yaw": ["N_r * r", "N_p * F_p", "N_s * F_s"],
    }
    twin = by_columns("twin", ("port", "star"), structure, forces=forces)
    before = {
        "X_u": -0.5,
        "X_p": 0.4,
        "X_s": 0.4,
        "Y_v": -1.0,
        "N_r": -1.2,
        "N_p": -0.9,
        "N_s": 0.9,
    }
    after = before | {"X_s": 0.3, "N_s": 0.675}
    one = found(estimated(twin, before, 3), estimated(twin, after, 4))
    assert (one[0].cause, one[0].what) == (ONE_THRUSTER, "star")
    assert one[0].probability > 0.99
    assert one[0].change == pytest.approx(-0.25, abs=0.05)
    assert "one thruster (star -2" in cause_text(one)


def test_a_model_without_standard_errors_has_no_causes(mp):
    given = make_model(mp, TRUTH)
    given = replace(given, covariance=np.zeros_like(given.covariance))
    assert found(given, given) == []
    assert cause_text([]).startswith("No cause can be computed")


def test_two_estimates_from_one_recording_have_no_cause(mp):
    from test_compare import entry

    a, b = (replace(estimated(mp, v, 1), recordings=(entry("S1", "ab"),)) for v in (TRUTH, HEAVIER))
    assert compare(a, b).causes == []


@pytest.mark.system
def test_a_current_that_was_not_estimated_is_found_end_to_end():
    """A boat in still water, then in a current of 0.09 m/s: the change of its drag is the current's."""
    models = []
    for flow, seeds in (((0.0, 0.0), (1, 2)), ((0.08, -0.05), (3, 4))):
        recordings = []
        for seed in seeds:
            _, still = driven({}, (pushes, pushes), seconds=150.0, seed=seed)
            eta = still.eta.copy()
            eta[:, :2] += still.t[:, None] * flow
            recordings.append(replace(still, eta=eta, name=f"drive-{seed}"))
        models.append(output_error(recordings, survey([{"latency": 0.05, "lag": 0.1}])))
    first = compare(*models).causes[0]
    assert first.cause == CURRENT
    assert first.probability > 0.9


def pushes(rng):
    return rng.choice([-1, 1]) * rng.uniform(0.2, 1.0)


@pytest.mark.system
def test_a_payload_on_board_is_found_end_to_end(mp):
    """Simulated trials before and after: `compare` names mass off centre, with its size."""
    plan, models = planned("clean", "S1", "S2", "S3"), []
    for one in (plan, loaded(plan)):
        trials = [r.cut(0.0, 100.0) for r in driven_by(one, mp)]
        models.append(seatrial.identify(trials, mp))
    after = [msgspec.structs.replace(r, name=f"{r.name}-loaded") for r in models[1].recordings]
    models[1] = replace(
        models[1], recordings=tuple(after)
    )  # simulated ones have one name and no files
    comparison = compare(*models)
    first = comparison.causes[0]
    assert first.cause == OFF_CENTRE
    assert first.probability > 0.95
    assert first.change == pytest.approx(MORE - 1.0, abs=0.01)
    assert "Most probable cause: mass off centre (mass +20 %), > 99 %" in comparison_text(
        comparison
    )
