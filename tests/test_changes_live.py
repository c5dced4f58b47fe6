# SPDX-License-Identifier: MIT
"""The test for a change of the boat beside odometry: what it says on lines, and the model that it adopts."""

import json
from concurrent.futures import Future
from dataclasses import replace

import msgspec
import numpy as np
import pytest
from changed_boats import drives_by_cause, known_model, sent
from cli_tools import refused
from conftest import CSE1
from given_lines import Given

import seatrial
from seatrial.evaluation.comparison.cause_candidates import BATTERY, MASS, NO_CHANGE, ONE_THRUSTER
from seatrial.monitoring.change_detector import ChangeDetector
from seatrial.onboard.boat_change import BoatChange, ChangeState
from seatrial.onboard.live import Adaptation, Settings, serve
from seatrial.onboard.live.protocol import NANO
from seatrial.onboard.live.server import Live
from seatrial.util.errors import FileError

model, drives = known_model, drives_by_cause


@pytest.fixture
def path(model, tmp_path):
    """Of the model's file."""
    seatrial.save(model, tmp_path / "model.yaml")
    return tmp_path / "model.yaml"


def as_lines(rows):
    return [json.dumps({"stamp": t, kind: values.tolist()}) for t, kind, values in rows]


def live(path, rows, *, automatic, orders=()):
    source, said, kept = Given([*as_lines(rows), *orders], json.loads), [], []
    adaptation = Adaptation(ChangeDetector(seatrial.load(path)), automatic, kept.append)
    served = serve(path, source, Settings(), said.append, adaptation)
    return served, source.answers, said, kept


@pytest.mark.system
def test_live_reports_the_change_and_adapts_at_once(path, drives):
    served, answers, said, kept = live(path, sent(drives[ONE_THRUSTER]), automatic=True)
    assert [line.split(":")[0] for line in said] == [
        "boat changed (noticed)", "boat changed (confirmed)", "adapted to the changed boat",
    ]  # fmt: skip
    shown = [answer.get("change") for answer in answers]
    assert shown[0] is None
    assert {c["state"] for c in shown if c} == {"noticed"}
    assert shown[-1] is None  # adapted
    assert served.odometer.model is kept[0]
    # odometry goes on without a jump
    pose = np.array([answer["pose"][:2] for answer in answers])
    assert np.hypot(*np.diff(pose, axis=0).T).max() < 0.05


def test_lines_that_cant_be_used_leave_the_test_as_it_is(model, drives, path):
    rows = sent(drives[BATTERY].cut(0.0, 30.0))
    at, middle = rows[900][0], 900
    odd = [
        f'{{"stamp": {at}, "pose": [NaN, 0, 0]}}', f'{{"stamp": {at}, "pose": [1e300, 0, 0]}}',
        f'{{"stamp": {at - 100 * NANO}, "pose": [0, 0, 0]}}',
        f'{{"stamp": {at + 3600 * NANO}, "pose": [1, 1, 1]}}', '{"adapt": true}', "rubbish",
    ]  # fmt: skip
    text, said = as_lines(rows), []
    source = Given([*text[:middle], *odd, *text[middle:]], json.loads)
    serve(path, source, Settings(), said.append, Adaptation(ChangeDetector(model)))
    expected = [
        "line 901: JSON is malformed", "line 902: pose at", "line 903: pose at", "line 904: pose at",
        "line 905: adapt: no confirmed change of the boat; the model stays", "line 906: JSON is malformed",
        "boat changed (noticed): battery", "6 of",
    ]  # fmt: skip
    assert len(said) == len(expected)
    assert all(line.startswith(begin) for line, begin in zip(said, expected, strict=True))
    assert "a number is NaN, infinite or out of range" in said[1]
    assert "its stamp is 100.0 s before the newest one; if the clock was set back" in said[2]
    assert "its stamp is 3600.0 s after the newest one; the next input is used if" in said[3]


@pytest.mark.system
def test_live_adapts_on_request(path, drives):
    rows = sent(drives[BATTERY])
    order = json.dumps({"stamp": rows[-1][0] + 1, "adapt": True})
    _, answers, said, kept = live(path, rows, automatic=False, orders=[order, order])
    assert answers[-1]["change"]["state"] == "confirmed"
    assert answers[-1]["change"]["cause"] == BATTERY
    assert len(kept) == 1
    assert said[-2:] == [
        f"line {len(rows) + 2}: adapt: no confirmed change of the boat; the model stays",
        f"1 of {len(rows) + 2} lines could not be used",
    ]  # fmt: skip


def test_the_command_line(model, path, tmp_path, capsys):
    still = replace(model, noise=msgspec.structs.replace(model.noise, process=None))
    seatrial.save(still, tmp_path / "still.yaml")
    for words, given in (
        ("is an input of this command", (path, "--live", "--adapted", path)),
        ("--adapted belongs to --live", (path, CSE1, "-o", "x.json", "--adapted", "y.yaml")),
        ("is a folder", (path, "--live", "--adapted", tmp_path)),
        ("--adapt off adapts none", (path, "--live", "--adapt", "off", "--adapted", "y.yaml")),
        ("no noise was estimated", (tmp_path / "still.yaml", "--live", "--adapt", "auto")),
    ):
        assert words in refused(capsys, "predict", *given)


def test_poses_that_state_more_noise_than_the_model_make_no_change(model, drives, path):
    """As of a SLAM that knows that it is uncertain: 3 cm and 30 mrad, as stated."""
    rng = np.random.default_rng(5)
    sizes = np.array([0.03, 0.03, 0.03])
    rows = sent(drives[NO_CHANGE].cut(0.0, 60.0))
    text = []
    for stamp, kind, values in rows:
        if kind == "pose":
            noisy = (values + sizes * rng.normal(size=3)).tolist()
            line = {"stamp": stamp, kind: noisy, "covariance": np.diag(sizes**2).tolist()}
        else:
            line = {"stamp": stamp, kind: values.tolist()}
        text.append(json.dumps(line))
    said = []
    serve(path, Given(text, json.loads), Settings(), said.append, Adaptation(ChangeDetector(model)))
    assert said == []


def test_odometry_outlives_its_test(path, drives, monkeypatch):
    def broken(self):
        raise np.linalg.LinAlgError("Singular matrix")

    monkeypatch.setattr(ChangeDetector, "look", broken)
    _, answers, said, _ = live(path, sent(drives[NO_CHANGE].cut(0.0, 5.0)), automatic=True)
    assert said == [
        "the test for a change of the boat failed (Singular matrix); it is off from now on"
    ]
    assert answers[-1]["t"] > answers[0]["t"] + 3.0


def test_a_test_that_runs_while_the_model_is_reloaded_does_not_count(model, path):
    said = []
    live = Live(
        path, Settings(clock="system"), said.append, Adaptation(ChangeDetector(model), True)
    )
    live._test = Future()  # one that runs
    live.reload()
    live._test.set_result(BoatChange(ChangeState.CONFIRMED, 0, MASS, model=model))
    now = live.odometer.model
    assert not [*live.take(json.dumps({"pose": [0.0, 0.0, 0.0]}), NANO)]
    assert not said
    assert live.odometer.model is now is live.adaptation.detector.model


def test_a_model_that_cant_be_kept_is_used(model, path):

    def keep(_):
        raise FileError("changed.yaml: can't be written")

    said = []
    live = Live(path, Settings(), said.append, Adaptation(ChangeDetector(model), False, keep))
    live._confirmed = live.writer.change = BoatChange(ChangeState.CONFIRMED, 0, MASS, model=model)
    assert not [*live.take(json.dumps({"adapt": True}), NANO)]
    assert said == ["adapted to the changed boat", "line 1: changed.yaml: can't be written"]
    assert live.odometer.model is model
    assert live.writer.change is None
