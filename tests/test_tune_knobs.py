# SPDX-License-Identifier: MIT
"""The smallest knob whose loops bear all draws of the model: what is proposed is permitted, less is not."""

import dataclasses
import re

import numpy as np
import pytest
from conftest import at_length, make_model
from survey_boat import TRUTH as TWIN
from survey_boat import boat as twin
from test_tune import HOLD, C
from tune_tools import CHAIN, LAG, LATENCY, mallard

from seatrial.boat.vehicle import vehicle_from
from seatrial.control import tune
from seatrial.control.tuning.design import (
    SENSITIVITY_LIMIT,
    gains_for,
    knobs_from,
    rounded_up,
    smallest_knob,
)
from seatrial.control.tuning.linear import linearise, redrawn
from seatrial.control.tuning.loops import Feedback, frequencies, open_loop
from seatrial.control.tuning.robustness import draws_of, worst_of
from seatrial.util.errors import ControlError


def test_a_stronger_thruster_in_a_draw_is_one():
    """A draw is seen under the gains' own command units: its strength is not divided out."""
    boat = linearise(model := mallard())
    strong = dataclasses.replace(model, coefficients=model.coefficients * _only(model, "X_F", 1.3))
    gains = gains_for(boat, 0.5, HOLD, "pid")
    feedback = Feedback(gains, boat.speeds, frequencies(0.5, 0.14), HOLD)
    weak, loop = (open_loop(b, feedback)[0, :, 0, 0] for b in (boat, redrawn(boat, strong)))
    np.testing.assert_allclose(loop / weak, 1.3)


def _only(model, name, factor):
    return np.where(np.array(model.structure.coefficients) == name, factor, 1.0)


def test_a_knob_that_asks_too_much_is_told_the_smallest_that_does_not():
    model = mallard()
    with pytest.raises(ControlError, match=r"knob 0\.1 s is not robust .* --knob \S+$") as e:
        tune(model, 0.1, draws=2)
    smallest = float(str(e.value).rpartition(" ")[2])
    assert (tune(model, smallest, draws=2).worst.sensitivity <= SENSITIVITY_LIMIT).all()
    with pytest.raises(ControlError, match=f"--knob {smallest:g}$"):
        tune(model, 0.97 * smallest, draws=2)


def test_twice_as_slow_a_boat_with_twice_the_delay_bears_twice_the_knob():
    """By the law of similarity: coefficients as their units ask, lengths the same."""
    slow = {
        **{name: C[name] / 2 for name in ("X_u", "Y_v", "N_r")},
        **{name: C[name] / 4 for name in ("X_F", "Y_F", "N_F")},
    }
    quick = mallard(spread=0.0)
    chain = [{**CHAIN[0], "latency": 2 * LATENCY, "lag": 2 * LAG}]
    for model, knob, rate in (
        (quick, 0.2, 50.0),
        (mallard(spread=0.0, chain=chain, **slow), 0.4, 25.0),
    ):
        with pytest.raises(ControlError) as e:
            tune(model, knob, rate=rate)
        found = float(str(e.value).rpartition(" ")[2])
        assert found / knob == pytest.approx(2.4, abs=0.2)  # rounded up
    expected = tune(quick, 1.0).worst
    other = tune(mallard(spread=0.0, chain=chain, **slow), 2.0, rate=25.0).worst
    np.testing.assert_allclose(other.sensitivity, expected.sensitivity, rtol=1e-3)
    np.testing.assert_allclose(other.delay, 2.0 * expected.delay, rtol=1e-3)


def test_a_model_too_uncertain_for_any_knob_is_told_so():
    model = mallard(spread=10.0)
    with pytest.raises(
        ControlError, match=r"mallard: no knob up to 100 s is robust .* identify it with more"
    ):
        tune(model, 50.0, draws=2)


@pytest.mark.parametrize(
    ("munk", "advice"),
    [at_length(-20.0, "fit a skeg, or try --action pd"), (-7.0, "Larger ones may fail")],
)
def test_a_boat_that_is_unstable_by_itself_is_told_so(munk, advice):
    """More driving does not help it. Sway and yaw ahead: v' = Y_v v + Y_ur u r, r' = N_uv u v + N_r r."""
    content = twin([{"latency": 0.05, "lag": 0.1}]).to_mapping()
    content["structure"]["yaw"].append("N_uv * u * v")
    model = make_model(vehicle_from(content, "twin"), TWIN | {"N_uv": munk})
    with pytest.raises(ControlError, match=advice) as e:
        tune(model, 2.0, draws=2)
    speed, time = re.search(
        r"unstable at (\S+) m/s ahead, where a turn doubles within (\S+) s", str(e.value)
    ).groups()
    top = (-TWIN["X_u"] - np.sqrt(TWIN["X_u"] ** 2 - 4.0 * TWIN["X_uu"] * TWIN["X_F"])) / (
        2.0 * TWIN["X_uu"]
    )
    assert float(speed) == pytest.approx(top, rel=0.02)
    square = top**2 * TWIN["Y_ur"] * munk
    half = (TWIN["Y_v"] - TWIN["N_r"]) / 2.0
    growth = (TWIN["Y_v"] + TWIN["N_r"]) / 2.0 + np.sqrt(half**2 + square)
    assert float(time) == pytest.approx(np.log(2.0) / growth, rel=0.05)


def test_the_smallest_knob_has_all_draws_as_witnesses():
    boat = linearise(model := mallard())
    boats = draws_of(boat, model, 5, 1)
    gains = gains_for(boat, 0.1, HOLD, "pd")
    found = worst_of(boats, gains, 0.1, HOLD, 1.0)
    knob = smallest_knob(boats, found, (0.1, HOLD, "pd", 1.0))
    assert (
        worst_of(boats, gains_for(boat, knob, HOLD, "pd"), knob, HOLD, 1.0).sensitivity
        <= SENSITIVITY_LIMIT
    ).all()


@pytest.mark.parametrize(
    ("low", "high", "knob"),
    [(0.437, 200, 0.44), (1.75, 1.85, 1.8), (5.03, 5.12, 5.1), (63.5, 68, 64), (120, 200, None)],
)
def test_a_narrow_window_of_robust_knobs_is_found_at_its_lower_end(low, high, knob):
    assert next((k for k in knobs_from(0.18) if low <= k < high), None) == knob


@pytest.mark.parametrize("knob", [at_length(0.3), 5.0])
def test_without_sway_thrust_the_proposed_knob_is_permitted_and_a_smaller_one_is_not(knob):
    """Also where the request is too large: the bend, which is that of the look-ahead, counts in the search, too."""
    guided = make_model(twin([{"latency": 0.05, "lag": 0.1}]), TWIN)
    with pytest.raises(ControlError, match="the smallest robust one: --knob") as caught:
        tune(guided, knob, draws=2)
    proposed = float(str(caught.value).rpartition(" ")[2])
    assert (tune(guided, proposed, draws=2).worst.sensitivity <= SENSITIVITY_LIMIT).all()
    with pytest.raises(ControlError, match="is not robust"):
        tune(guided, 0.95 * proposed, draws=2)


@pytest.mark.parametrize(
    ("value", "up"), [(0.2301, 0.24), (0.23, 0.23), (1.0, 1.0), (9.91, 10.0), (23.4, 24.0)]
)
def test_knobs_are_rounded_up(value, up):
    assert rounded_up(value) == pytest.approx(up)
