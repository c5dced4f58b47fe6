# SPDX-License-Identifier: MIT
"""Short recordings of pushed boats whose pose errors are correlated: the search ends at the truth.

A velocity that wanders explains both, with quite another boat and small errors; it is less likely by hundreds.
"""

from dataclasses import dataclass

import msgspec
import numpy as np
import pytest
from conftest import at_length

from seatrial.boat.schema import ChainGroup, DeadZone
from seatrial.identification.estimator import fit
from seatrial.simulation.plan import DisturbanceForce, PlanFile, load_plan, with_seed
from seatrial.simulation.trials import simulate

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
