# SPDX-License-Identifier: MIT
"""The search ends at the truth, or says that it got lost.

Of short recordings of pushed boats whose pose errors are correlated, a velocity that wanders explains both, with quite
another boat and small errors; it is less likely by hundreds.
"""

from dataclasses import dataclass, replace
from importlib import import_module

import msgspec
import numpy as np
import pytest
from conftest import at_length, on_request
from method_trials import pulses_of

import seatrial
from seatrial.boat.schema import ChainGroup, DeadZone
from seatrial.identification.estimator import OutputErrorSettings, fit, output_error
from seatrial.identification.likelihood.filter_runs import filter_along
from seatrial.identification.likelihood.linearised import Point
from seatrial.identification.likelihood.optimiser import Outcome
from seatrial.simulation.plan import DisturbanceForce, PlanFile, load_plan, with_seed
from seatrial.simulation.trials import simulate
from seatrial.util.errors import SeatrialError

QUICK = {
    "X_u": -0.1, "X_uu": -3.0, "X_F": 0.3, "Y_v": -0.3, "Y_vv": -4.0, "Y_F": 0.25,
    "N_r": -0.8, "N_rr": -0.5, "N_F": 2.0, "N_ud": 0.1, "N_uu": -0.4,
}  # fmt: skip
SLOW = {
    "X_u": -0.5, "X_uu": -0.6, "X_F": 0.1, "Y_v": -0.6, "Y_vv": -1.5, "Y_F": 0.1,
    "N_r": -1.0, "N_rr": -0.1, "N_F": 0.8, "N_ud": -0.1, "N_uu": 0.3,
}  # fmt: skip


@dataclass(frozen=True)
class Scene:
    """A boat, what pushes it, and how its poses err."""

    coefficients: dict[str, float]
    chain: ChainGroup
    force: DisturbanceForce
    rate: float  # [Hz]
    noise: float  # [m]
    memory: float  # [s]
    length: float  # [s] of each of three recordings

    def plan(self, seed: int) -> PlanFile:
        plan, replace = with_seed(load_plan("paper-like"), seed), msgspec.structs.replace
        return replace(
            plan,
            plant=replace(
                plan.plant,
                coefficients=self.coefficients,
                chain=[self.chain],
                unmodelled=self.force,
            ),
            pose=replace(plan.pose, rate=self.rate, position_noise=self.noise, noise_correlation=self.memory),
            trials={name: replace(plan.trials[name], duration=self.length) for name in ("S1", "S2", "S3")},
        )  # fmt: skip


QUICK_CHAIN = ChainGroup(lag=0.2, dead_zone=DeadZone(0.05, 0.12))
SLOW_CHAIN = ChainGroup(lag=0.3, dead_zone=DeadZone(0.12, 0.12))
SCENES = {
    "let go in position alone": (Scene(QUICK, QUICK_CHAIN, DisturbanceForce(0.03, 1.0), 10.0, 0.01, 0.2, 60.0), 4),
    "let go while far off": (Scene(SLOW, SLOW_CHAIN, DisturbanceForce(0.03, 1.5), 10.0, 0.004, 0.3, 70.0), 502),
    "as long as may be": (Scene(SLOW, SLOW_CHAIN, DisturbanceForce(0.06, 1.5), 50.0, 0.002, 0.5, 60.0), 8),
    "diverging": (Scene(SLOW, SLOW_CHAIN, DisturbanceForce(0.06, 1.5), 50.0, 0.002, 0.5, 60.0), 6),
}  # fmt: skip


@pytest.mark.parametrize(
    "name",
    [
        at_length("let go in position alone"),
        "let go while far off",
        at_length("as long as may be"),
        at_length("diverging"),
    ],
)
def test_the_search_ends_at_the_truth(mp, name):
    scene, seed = SCENES[name]
    made = list(simulate(scene.plan(seed), mp))
    found = fit([trial.recording for trial in made], made[0].vehicle)
    values = dict(zip(found.problem.names, found.theta.tolist(), strict=True))
    for coefficient, true in scene.coefficients.items():
        off = abs(values[coefficient] - true)
        assert off < 4.0 * found.errors[coefficient] or values[coefficient] == 0.0, coefficient
    for coefficient in ("X_F", "Y_F", "N_F"):
        assert values[coefficient] == pytest.approx(scene.coefficients[coefficient], rel=0.3)
    noise = found.model().noise
    assert noise.correlated is not None
    assert scene.memory < 2.0 * noise.correlated.memory < 4.1 * scene.memory
    assert np.hypot(noise.correlated.position, noise.position) == pytest.approx(
        scene.noise, rel=0.5
    )
    assert noise.process.walk_linear < 1e-3


@pytest.fixture(scope="module")
def far():
    """Recordings, the model found, and start models with all coefficients off, often twofold.

    They believe themselves: they have the noise of the model found, which has no process noise.
    """
    vehicle = seatrial.load_vehicle("mallard-mp")
    recordings = pulses_of(with_seed(load_plan("hard"), 1), vehicle)
    found = output_error(recordings, vehicle)
    factors = np.exp(np.random.default_rng(3).normal(0.0, 0.7, (4, len(found.coefficients))))
    starts = [replace(found, coefficients=found.coefficients * f) for f in factors]
    return vehicle, recordings, found, starts


@pytest.mark.system
@pytest.mark.parametrize("hold", [False, True])
@pytest.mark.parametrize("which", [0, *map(on_request, (1, 2, 3))])
def test_start_models_that_are_far_off_and_sure_of_themselves_lead_to_the_same_model(
    far, hold, which
):
    vehicle, recordings, found, starts = far
    settings = OutputErrorSettings(hold_noise=hold)
    errors = np.array([found.standard_errors[n] for n in found.structure.coefficients])
    other = output_error(recordings, vehicle, settings=settings, start=starts[which])
    assert np.abs((other.coefficients - found.coefficients) / errors).max() < 0.05


@pytest.mark.parametrize("which", [0, on_request(1)])
def test_a_search_that_got_lost_says_so(far, monkeypatch, which):
    monkeypatch.setattr(
        import_module("seatrial.identification.likelihood.optimiser"),
        "far_from_poses",
        lambda _: False,
    )
    vehicle, recordings, _, starts = far
    settings = OutputErrorSettings(hold_noise=True)
    with pytest.raises(SeatrialError, match=r"no solution: .*by one clock|poses are rejected"):
        output_error(recordings, vehicle, settings=settings, start=starts[which])


def test_a_start_model_that_never_gets_near_the_poses_is_an_outcome_with_advice(far, monkeypatch):
    def nowhere(problem, *begin, **_):
        return Point(*begin, filter_along(problem, *begin)), Outcome.CONVERGED

    monkeypatch.setattr(import_module("seatrial.identification.first_search"), "search", nowhere)
    vehicle, recordings, _, starts = far
    settings = OutputErrorSettings(hold_noise=True, outlier=np.inf, select_stages=False)
    with pytest.raises(SeatrialError, match="the poses are nowhere near: no model of this"):
        output_error(recordings, vehicle, settings=settings, start=starts[0])
