# SPDX-License-Identifier: MIT
"""The guided path: from logs to a validated model in one call, and on from where it was stopped."""

import shlex
import shutil

import numpy as np
import pytest
from guided_logs import CURRENT, LEVER, SECONDS, lake_log, one_drive, tables
from survey_boat import LAG, LATENCY, TRUTH, as_stated

import seatrial
from seatrial.boat.model_file import load
from seatrial.boat.vehicle import load_vehicle
from seatrial.commands import make_parser
from seatrial.evaluation.scores import load_scores
from seatrial.evaluation.through_water import known_current
from seatrial.guide import model as guided_model
from seatrial.guide.answers import LAST_QUARTER
from seatrial.guide.steps import Steps, Task
from seatrial.guide.vehicle_file import vehicle_of
from seatrial.inspection.proposal.sources import Choices
from seatrial.onboard.live.playback import replay
from seatrial.onboard.predictor import Health
from seatrial.util.errors import SeatrialError

pytestmark = pytest.mark.system
drive = lake_log


@pytest.fixture(scope="module")
def guided(drive, tmp_path_factory):
    """The path without anyone to ask, and what it said."""
    folder, said = tmp_path_factory.mktemp("out") / "lake", []
    return seatrial.auto([drive], folder, say=said.append), said


def test_one_call_finds_terms_effects_and_truth(guided):
    found, _ = guided
    model = found.model
    # v r in surge and -u r in sway are terms of every boat: their coefficients are beside 1
    truth = {
        **TRUTH,
        "X_vr": TRUTH["X_vr"] - 1.0,
        "Y_ur": TRUTH["Y_ur"] + 1.0,
        "latency": LATENCY,
        "lag": LAG,
    }
    assert set(model.values) == set(TRUTH) - {"Y_F", "N_b"}
    assert as_stated(model, {n: x for n, x in truth.items() if n not in ("Y_F", "N_b")}) == {}
    np.testing.assert_allclose(model.vehicle.lever, LEVER, atol=0.01)
    (entry,) = model.recordings
    assert entry.effects["current_x"] == pytest.approx(
        CURRENT[0], abs=4 * entry.errors["current_x"]
    )
    assert entry.effects["current_y"] == pytest.approx(
        CURRENT[1], abs=4 * entry.errors["current_y"]
    )


def test_a_stated_lever_arm_that_is_slightly_wrong_is_found_and_makes_no_term(drive, tmp_path):
    """Two centimetres off, by a tape measure."""
    near = Choices(lever=(LEVER[0], LEVER[1] + 0.02))
    model = seatrial.auto([drive], tmp_path / "lake", choices=near).model
    assert set(model.values) == set(TRUTH) - {"Y_F", "N_b"}
    np.testing.assert_allclose(model.vehicle.lever, LEVER, atol=0.005)


def test_it_is_tested_on_what_was_held_out(guided):
    found, said = guided
    (row,) = found.scores.recordings
    assert row.recording.endswith("held-out") and not row.seen
    assert row.length == pytest.approx(SECONDS / 4, abs=0.5)
    assert found.model.recordings[0].length == pytest.approx(0.75 * SECONDS, abs=0.5)
    for score in row.scores.values():
        assert score.ratio < 0.3 and score.as_expected
    assert any(LAST_QUARTER in one for one in found.assumed)
    assert any("lever is estimated" in one for one in found.assumed)
    (whole,) = (one for one in found.assumed if "A model of all the data: " in one)
    assert "--effect lever" in whole and "model-of-all.yaml" in whole
    assert [line.split()[0] for line in said] == [
        "vehicle",
        "inspect",
        "identify",
        "validate",
        "report",
    ]


def test_odometry_along_its_log_knows_the_current(guided, drive):
    """Without it the gate rejects poses and the filter begins anew."""
    model = guided[0].model
    recording = seatrial.read(drive, model.vehicle).cut(0.0, 120.0)
    assert known_current(model, recording) == pytest.approx(CURRENT, abs=0.005)
    outs = [out for out in replay(model, recording, 5.0) if out.stamp > recording.stamps[50]]
    assert len(outs) > 500
    bad = Health.MODEL_DOUBTED | Health.GATE_REJECTING | Health.REINITIALISED
    assert not any(out.motion.health & bad for out in outs)


def test_the_next_step_keeps_what_was_found_and_writes_no_model_over_it(guided, drive):
    """And it can be run."""
    words = shlex.split(guided[0].next.do)
    assert words[:2] == ["seatrial", "predict"] and "-o" in words
    args = make_parser().parse_args(words[1:])
    assert args.out == guided[0].folder / "odometry.csv"


def test_its_files_are_those_of_the_single_commands(guided):
    folder = guided[0].folder
    assert {p.name for p in folder.iterdir()} == {
        "vehicle.yaml", "inspect.txt", "model.yaml", "scores.json", "report.html", "steps.json",
    }  # fmt: skip
    assert load(folder / "model.yaml").values == pytest.approx(guided[0].model.values)
    assert load_scores(folder / "scores.json") == guided[0].scores
    assert load_vehicle(folder / "vehicle.yaml").automatic
    assert "lake-held-out" in (folder / "report.html").read_text()


def test_what_is_done_is_not_done_again(guided, drive, monkeypatch):
    found, _ = guided
    folder, calls = found.folder, []
    before = (folder / "model.yaml").read_bytes()

    def count(*args, **kwargs):
        calls.append(args)
        raise SeatrialError("identified again")

    monkeypatch.setattr(guided_model, "identify_guided", count)
    again = seatrial.auto([drive], folder)
    assert not calls and again.scores == found.scores and again.next == found.next
    assert (folder / "model.yaml").read_bytes() == before
    # an edited vehicle file is used, and asks for another model
    file = folder / "vehicle.yaml"
    text = file.read_text()
    file.write_text(text.replace("name: lake", "name: pond"))
    with pytest.raises(SeatrialError, match="identified again"):
        seatrial.auto([drive], folder)
    file.write_text(text)
    # and so does another version of the program
    monkeypatch.setattr("seatrial.guide.steps.version", lambda _: "9.9.9")
    with pytest.raises(SeatrialError, match="identified again"):
        seatrial.auto([drive], folder)


def test_a_model_of_other_recordings_is_replaced_with_a_word(guided, tmp_path, monkeypatch):
    folder = tmp_path / "lake"
    shutil.copytree(guided[0].folder, folder)
    another = tables(tmp_path / "pond", one_drive(60.0, 2))
    here = Task((another,), folder, None, print, salvage=False, steps=Steps(folder))
    vehicle_of(here, Choices())
    assert any(
        "whose model was of lake and is replaced (-o for another boat)" in a for a in here.assumed
    )
