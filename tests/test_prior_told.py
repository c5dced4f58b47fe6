# SPDX-License-Identifier: MIT
"""What is told of a prior: parameters that it contradicts, and factors that all axes share, seldom by chance."""

from dataclasses import replace

import numpy as np
import pytest
from test_prior import CONFLICTS, known

from seatrial.boat.findings import FindingKind, finding_of, finding_text, of_kinds
from seatrial.identification.prior import (
    PriorShift,
    common_factors,
    conflicts,
    prior_findings,
    widened,
)
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model


@pytest.fixture(scope="module")
def before(mp):
    return known(plant_model(load_plan("hard"), mp))


def test_the_pull_away_from_a_right_prior_is_a_standard_normal():
    """Prior N(0, 1), one datum of variance s^2: the mean of what comes after has variance 1 - error^2."""
    rng = np.random.default_rng(2)
    truth, s = rng.normal(size=4000), 0.5
    error = np.sqrt(1 / (1 + 1 / s**2))
    found = (truth + s * rng.normal(size=4000)) * error**2 / s**2
    pulls = np.array([PriorShift("X_u", 0.0, 1.0, f, error).normalised for f in found])
    assert np.std(pulls) == pytest.approx(1.0, abs=0.04)
    assert PriorShift("X_u", 0.0, 1.0, 0.1, 0.95).dominated


def test_a_right_prior_is_contradicted_by_chance_in_one_refit_out_of_twenty():
    rng = np.random.default_rng(3)
    alarms = sum(
        bool(conflicts([PriorShift("", 0.0, 1.0, z, 0.1) for z in rng.normal(size=15)]))
        for _ in range(400)
    )
    assert 8 <= alarms <= 34  # 20 +- 3.2 standard deviations
    assert (
        conflicts([PriorShift("X_u", 0.0, 1.0, 5.0, 0.95)]) == []
    )  # hardly seen: no contradiction
    (one,) = conflicts(
        [PriorShift("X_u", 0.0, 1.0, 1.2, 0.1), PriorShift("X_F", 0.0, 1.0, 4.0, 0.1)]
    )
    assert one.name == "X_F"


def test_what_became_of_the_prior_is_told():
    used, conflict, dominated = prior_findings(
        [PriorShift("X_u", -0.2, 0.04, -0.4, 0.01), PriorShift("Y_v", -0.2, 0.04, -0.21, 0.039)],
        0.2,
    )
    assert used == finding_of(FindingKind.PRIOR_USED, spread=0.2)
    assert "widened by 20 % of every parameter" in finding_text(used)
    assert conflict.subject == ("X_u",)
    assert "X_u changed from -0.2 ± 0.04 to -0.4 ± 0.01" in finding_text(conflict)
    assert dominated == finding_of(FindingKind.PRIOR_DOMINATES, "Y_v")


@pytest.mark.parametrize(
    ("what", "factor"), [("thrust", 0.5), ("thrust and drag", 0.5), ("drag", 2.2)]
)
def test_a_change_of_all_axes_is_no_change_of_each(before, what, factor):
    """Twice the mass: each coefficient may be half of what it was by chance, all together not."""
    wide = widened(before, 0.2)
    thrust = {"X_F", "Y_F", "N_F", "N_uu"}
    ways = {"thrust": thrust, "drag": set(before.values) - thrust - {"N_ud"}}
    moved = ways.get(what, ways["thrust"] | ways["drag"])
    values = [v * (factor if n in moved else 1.0) for n, v in before.values.items()]
    found = replace(before, coefficients=np.array(values), covariance=0.1 * before.covariance)
    best = min(common_factors(wide, found), key=lambda c: c.p)
    assert best.what == what
    assert best.p < 0.01
    for axis in ("surge", "sway", "yaw"):
        assert best.factors[axis] == pytest.approx(factor, abs=0.15)
    _, *told = prior_findings([], 0.2, [best])
    assert {f.values["quantity"] for f in told} == {what}
    assert {f.part("axis"): f.number("factor") for f in told} == best.factors


def test_factors_of_a_right_prior_are_contradicted_by_chance_only(before):
    rng, alarms = np.random.default_rng(4), 0
    wide = widened(before, 0.2)
    root = np.linalg.cholesky(wide.covariance + 1e-18 * np.eye(len(wide.covariance)))
    for _ in range(400):
        drawn = (root @ rng.normal(size=len(root)))[: len(before.coefficients)]
        found = replace(
            before, coefficients=before.coefficients + drawn, covariance=1e-4 * before.covariance
        )
        alarms += bool(of_kinds(prior_findings([], 0.2, common_factors(wide, found)), *CONFLICTS))
    assert 3 <= alarms <= 34  # three tests that are correlated at 5 % in all
