# SPDX-License-Identifier: MIT
"""One pass with several stages at their neutrals tells of each what a pass of its own would."""

import numpy as np
import pytest

import seatrial
from seatrial.identification.likelihood.filter_runs import filter_along
from seatrial.identification.likelihood.parameters import quadratic_drag
from seatrial.identification.problem_setup import problem_with
from seatrial.identification.selection.actuator_stages import stage_candidates, with_free_stages
from seatrial.identification.selection.score_test import score_test
from seatrial.identification.solution import OutputErrorSettings
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model

NOISE = np.array([7e-4, 3e-3, 1e-9, 1e-9, 1e-9, 1e-9, 1.0, 1e-9, 1e-9, 0.3, 1e-9, 1.0])


def parameters(problem):
    """The plant's, and what is not in it at its neutral."""
    plant = plant_model(load_plan("paper-like"), problem.vehicle).values
    known = dict(
        zip(problem.vehicle.constants.names, problem.vehicle.constants.values, strict=True)
    )
    return np.array([plant.get(name, known.get(name, 0.0)) for name in problem.names])


def test_one_pass_tells_of_each_stage_what_its_own_would(clean_mp):
    vehicle = seatrial.load_vehicle("mallard-mp")
    recordings = [clean_mp[name].recording for name in ("S1", "S3")]
    whole = with_free_stages(vehicle, recordings)
    found = stage_candidates(vehicle, whole)
    assert [e.finding.values["stage"] for e in found] == ["reverse_ratio", "power"]
    settings = OutputErrorSettings()
    together = problem_with(found[0].probe, vehicle, recordings, settings)
    shared = filter_along(together, parameters(together), NOISE)
    places = {
        together.names[i]: k for k, i in enumerate(together.free) if together.names[i] not in whole.constants.names
    }  # fmt: skip
    for extra, name, other in zip(
        found, ("reverse_ratio", "power"), ("power", "reverse_ratio"), strict=True
    ):
        alone = problem_with(extra.vehicle, vehicle, recordings, settings)
        own = filter_along(alone, parameters(alone), NOISE)
        (place,) = [k for k, i in enumerate(alone.free) if alone.names[i] == name]
        want = score_test(own, [place])
        got = score_test(shared, [places[name]], None, [places[other]])
        assert got.statistic == pytest.approx(want.statistic, rel=1e-6)
        assert got.gain == pytest.approx(want.gain, rel=1e-6)


def test_quadratic_drag_of_the_own_axis_never_drives_the_boat(clean_mp):
    vehicle = seatrial.load_vehicle("mallard-mp")
    assert quadratic_drag(vehicle.structure) == {"X_uu", "Y_vv", "N_rr"}  # N_uu turns it, rightly
    recordings = [clean_mp["S1"].recording]
    problem = problem_with(
        with_free_stages(vehicle, recordings), vehicle, recordings, OutputErrorSettings()
    )
    low, high = problem.bounds
    names = [problem.names[i] for i in problem.free]
    most = dict(zip(names, high, strict=True))
    assert [n for n in vehicle.structure.coefficients if most[n] == 0.0] == ["X_uu", "Y_vv", "N_rr"]
    assert low[names.index("X_uu")] == -np.inf
