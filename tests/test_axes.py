# SPDX-License-Identifier: MIT
"""Identify in one axis system = identify in the other, transformed. Through files, as a user would."""

from functools import cache
from pathlib import Path

import msgspec
import numpy as np
import pytest
import yaml
from conftest import at_length, make_model
from test_model import frd

import seatrial
from seatrial import _core
from seatrial.boat.model_file import save
from seatrial.boat.vehicle import vehicle_from
from seatrial.evaluation.comparison.comparability import not_comparable
from seatrial.evaluation.comparison.prediction import with_signals
from seatrial.identification.methods import DEFAULT_METHOD, METHODS
from seatrial.identification.prior import check_prior
from seatrial.identification.regression.equation_error import equation_error
from seatrial.io.trial_files import write_trial
from seatrial.simulation.plan import TrialEntry, load_plan
from seatrial.simulation.trials import simulate
from seatrial.util.errors import VehicleError
from tests.boats.vehicles import by_columns

ODD = {"N_ud", "N_uu"}
SEED = 3


def short_plan():
    plan = load_plan("paper-like")
    trials = {
        n: TrialEntry(e.drive, 110.0)
        for n, e in plan.trials.items()
        if n in ("S1", "S2", "S3", "S7")
    }
    return msgspec.structs.replace(plan, seed=SEED, trials=trials)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """Of a scheme, by axes: the vehicle, its trials written and read, and the first one's raw poses."""

    @cache
    def get(scheme):
        out = tmp_path_factory.mktemp(scheme)
        vehicle = seatrial.load_vehicle(scheme)
        found = {}
        for label, v in (("flu", vehicle), ("frd", frd(vehicle))):
            made = [write_trial(t, out / label) for t in simulate(short_plan(), v)]
            raw = np.loadtxt(made[0] / "poses.csv", delimiter=",", skiprows=1)
            found[label] = (v, [seatrial.read(path, v) for path in made], raw)
        return found

    return get


def in_both_axes(recorded, method, out):
    """Model, file, scores and raw poses of one boat's trials, in either axes."""
    found = {}
    for label, (v, records, raw) in recorded.items():
        model = seatrial.identify(records[:3], v, method=method)
        save(model, out / f"{label}.yaml")
        scores = seatrial.validate(model, records[3:])
        content = yaml.safe_load((out / f"{label}.yaml").read_text())
        found[label] = (model, content, scores, raw)
    return found


@pytest.mark.parametrize(
    ("method", "scheme"),
    [
        ("equation-error", "mallard-mp"),
        at_length(DEFAULT_METHOD, "mallard-mp"),
        *(at_length(method, "mallard-af") for method in METHODS),
    ],
)
def test_the_axis_system_changes_only_the_signs_that_the_rule_names(
    recorded, tmp_path, method, scheme
):
    found = in_both_axes(recorded(scheme), method, tmp_path)
    flu_raw, frd_raw = found["flu"][3], found["frd"][3]
    np.testing.assert_allclose(frd_raw[:, 2:], -flu_raw[:, 2:], atol=1e-6)  # the files do differ
    inside = [found[k][0].coefficients for k in ("flu", "frd")]
    np.testing.assert_allclose(inside[0], inside[1], rtol=1e-4, atol=1e-5)
    constants = [found[k][0].constants for k in ("flu", "frd")]
    np.testing.assert_allclose(constants[0], constants[1], rtol=1e-4, atol=1e-5)
    if method == DEFAULT_METHOD:
        assert len(constants[0]) >= 2
    for name in found["flu"][0].values:
        sign = -1.0 if name in ODD else 1.0
        a, b = (found[k][1]["coefficients"][name] for k in ("flu", "frd"))
        assert b["value"] == pytest.approx(sign * a["value"], rel=1e-4, abs=1e-5), name
        assert b["standard_error"] == pytest.approx(a["standard_error"], rel=1e-3), name
    for symbol in "uvr":
        a, b = (found[k][2].recordings[0].scores[symbol].rms for k in ("flu", "frd"))
        assert a == pytest.approx(b, rel=1e-4)


def test_the_model_ship_is_the_same_boat_in_either_axes(cse1_vehicle, cse1):
    """Its table re-labelled: the same numbers with y and psi and the port-starboard commands negated."""
    content = cse1_vehicle.to_mapping()
    content["axes"] = "forward-left-up"
    for name in ("y", "psi"):
        content["pose"][name] = {**content["pose"][name], "sign": -1}
    for force in content["forces"].values():
        if force["axis"] != "surge":
            force["of"] = {k: -v for k, v in force["of"].items()}
    other = vehicle_from(content, "flu")
    path = Path(__file__).parents[1] / "data" / "cse1" / "csv" / "CSE1_data_random_run3.csv"
    models = [equation_error([r], v) for r, v in (
        (cse1["random_run3"], cse1_vehicle), (seatrial.read(path, other), other)
    )]  # fmt: skip
    np.testing.assert_allclose(models[0].coefficients, models[1].coefficients, rtol=1e-9)


def zoned(axes: str, *edges: float):
    """A boat driven by forces, its sway thruster with two edges of the dead zone."""
    structure = {
        "surge": ["X_u * u", "X_F * F_u"], "sway": ["Y_v * v", "Y_F * F_v"], "yaw": ["N_r * r", "N_F * F_r"],
    }  # fmt: skip
    zone = dict(zip(("forward", "reverse"), edges, strict=True))
    chain = [{"name": "v", "actuators": ["F_v"], "dead_zone": zone}]
    return by_columns("zoned", ("F_u", "F_v", "F_r"), structure, axes=axes, chain=chain)


def test_edges_change_sides_with_the_axes_and_no_model_takes_them_along_unseen():
    ours, theirs = zoned("forward-left-up", 0.1, 0.3), zoned("forward-right-down", 0.3, 0.1)
    values = {"X_u": -0.4, "X_F": 0.5, "Y_v": -0.6, "Y_F": 0.3, "N_r": -0.8, "N_F": 1.0}
    one, other = make_model(ours, values), make_model(theirs, values)
    push = np.zeros((2, 3))
    push[:, 1] = [-0.5, 0.5]
    felt = [_core.curve(m.vehicle.chain, m.constants, 1, push) for m in (one, other)]
    np.testing.assert_allclose(*felt)  # the same boat
    for refused in (
        lambda: one.with_vehicle(theirs),
        lambda: with_signals(other, ours),
        lambda: check_prior(one, theirs),
    ):
        with pytest.raises(VehicleError, match="the dead zone of F_v has two edges"):
            refused()
    odd = {n: why for n, why in not_comparable(one, other).items() if n.startswith("edge")}
    assert set(odd) == {"edge_forward.v", "edge_reverse.v"}
    assert all("the opposite direction" in why for why in odd.values())
