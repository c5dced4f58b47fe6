# SPDX-License-Identifier: MIT
"""Scores as a file: what validate writes, report reads instead of computing it again."""

import json
import math
from dataclasses import replace

import msgspec
import numpy as np
import pytest
from conftest import TABLE_II, make_model

import seatrial
from seatrial.commands.cli import main
from seatrial.evaluation import assessment
from seatrial.evaluation.scores import Scores, load_scores, scores_json
from seatrial.recording.from_poses import make_recording
from seatrial.recording.signal import Signal
from seatrial.recording.velocity import motion
from seatrial.report import report
from seatrial.report.evidence import model_evidence
from seatrial.util.errors import FileError, ModelError
from seatrial.util.files import dump_json


@pytest.fixture(scope="module")
def model(mp):
    return make_model(mp, TABLE_II["MP"], step=1 / 30)


@pytest.fixture(scope="module")
def drives(paper_mp):
    return [paper_mp[name].recording.cut(0.0, 60.0) for name in ("S4", "S7")]


@pytest.fixture(scope="module")
def scores(model, drives):
    return seatrial.validate(model, drives)


def written(scores: Scores, path):
    path.write_text(dump_json(scores_json(scores)))
    return path


def test_scores_come_back_from_their_file(scores, tmp_path):
    assert load_scores(written(scores, tmp_path / "scores.json")) == scores


def test_a_boat_that_never_moves_has_scores_that_come_back(model, tmp_path):
    """No ratio and no kurtosis: infinite and not a number, which JSON does not have."""
    stamps = np.arange(600) * 66_000_000
    hands_off = Signal(model.vehicle.inputs, stamps, np.zeros((600, len(model.vehicle.inputs))))
    still = make_recording("still", stamps, np.zeros((600, 3)), hands_off)
    scores = seatrial.validate(model, [still], reference="stencil")
    found = load_scores(written(scores, tmp_path / "scores.json"))
    surge = found.recordings[0].scores["u"]
    assert surge.ratio == math.inf
    assert math.isnan(surge.kurtosis)


def test_a_report_from_scores_is_that_of_its_own_and_computes_none(
    model, drives, scores, monkeypatch
):
    own = report(model, drives)
    monkeypatch.setattr(model_evidence, "assess", pytest.fail)
    monkeypatch.setattr(assessment, "axis_scores", pytest.fail)
    assert report(model, drives, scores=scores) == own


def test_scores_of_another_model_are_refused(model, drives, scores):
    other = replace(model, coefficients=1.01 * model.coefficients)
    with pytest.raises(ModelError, match="scores are of another model than mallard"):
        report(other, drives, scores=scores)


def test_scores_of_other_recordings_are_refused(model, drives, scores):
    with pytest.raises(ModelError, match=r"S4-MP: 20\.0 s long, is not among .* S7-MP"):
        report(model, [drives[0].cut(0.0, 20.0)], scores=scores)


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("{", "is not JSON"),
        ("[1]", "expected a JSON object, got list"),
        ('{"seatrial": "scores 9"}', "expected 'seatrial: scores 6'"),
        ('{"seatrial": "scores 6", "recordings": [3]}', "scores.json: "),
        ("[" * 100_000, "is not JSON"),
    ],
)
def test_a_file_that_is_none_is_one_line(tmp_path, text, match):
    path = tmp_path / "scores.json"
    path.write_text(text)
    with pytest.raises(FileError, match=match):
        load_scores(path)


def without_reference(scores: Scores) -> dict:
    """The file's content as it was before there was a choice of reference."""
    content = json.loads(dump_json(scores_json(scores)))
    del content["reference"]
    for row in content["recordings"]:
        del row["reference"]
    scored = [*content["recordings"], *content["pooled"]]
    for one in [*scored, *(h for row in content["recordings"] for h in row["horizons"])]:
        for axis in one["scores"].values():
            del axis["reference"]
    return content | {"seatrial": "scores 4"}


@pytest.fixture(scope="module")
def stencil_scores(model, drives):
    return seatrial.validate(model, drives, reference="stencil")


def test_scores_without_a_reference_are_the_stencils(stencil_scores, tmp_path):
    path = tmp_path / "scores.json"
    path.write_text(json.dumps(without_reference(stencil_scores)))
    found = load_scores(path)
    assert found == msgspec.structs.replace(stencil_scores, seatrial="scores 4")
    assert found.reference == "stencil"


def test_scores_without_odometry_are_read(scores, tmp_path):
    path = tmp_path / "scores.json"
    path.write_text(
        json.dumps(json.loads(dump_json(scores_json(scores))) | {"seatrial": "scores 5"})
    )
    assert load_scores(path) == msgspec.structs.replace(scores, seatrial="scores 5")


@pytest.mark.system
def test_a_report_from_the_stencils_scores_compares_with_the_stencil(
    model, drives, stencil_scores, scores
):
    page = report(model, drives, scores=stencil_scores)
    for found, reference in ((stencil_scores, "stencil"), (scores, "smoothed")):
        assert found.reference == reference
        assert {row.reference for row in found.recordings} == {reference}
    assert page != report(model, drives, scores=scores)
    own = [one.prediction for one in assessment.assess_from(model, drives, stencil_scores)]
    assert [one.measured.tolist() for one in own] == [
        motion(drive).nu[one.index].tolist() for drive, one in zip(drives, own, strict=True)
    ]


def test_scores_of_the_first_version_are_read(stencil_scores, tmp_path):
    content = without_reference(stencil_scores)
    del content["pooled"], content["fingerprint"]
    for row in content["recordings"]:
        assert not row.pop("findings")
        row["notes"] = []
    path = tmp_path / "scores.json"
    path.write_text(json.dumps(content | {"seatrial": "scores 3"}))
    found = load_scores(path)
    assert found.recordings == stencil_scores.recordings
    assert found.pooled == []


def test_the_command_takes_the_file(pool, tmp_path, capsys, monkeypatch):
    model, drive = str(pool / "model.yaml"), str(pool / "S4-AF")
    scores, page = tmp_path / "scores.json", tmp_path / "report.html"
    assert main(["validate", model, drive, "--json", str(scores), "-q"]) == 0
    monkeypatch.setattr(model_evidence, "assess", pytest.fail)
    assert main(["report", model, drive, "--scores", str(scores), "-o", str(page), "-q"]) == 0
    assert page.exists() and capsys.readouterr().err == ""


@pytest.mark.system
def test_the_command_has_the_stencils_scores_too(pool, tmp_path, capsys):
    model, drive, path = str(pool / "model.yaml"), str(pool / "S7-AF"), tmp_path / "scores.json"
    for chosen, word in (
        ("stencil", "five-point stencil, starts too"),
        ("smoothed", "smoothed vel"),
    ):
        arguments = ["validate", model, drive, "--reference", chosen, "--json", str(path), "-q"]
        assert main(arguments) == 0
        assert f"  reference: S7-AF: {word}" in capsys.readouterr().out
        assert load_scores(path).reference == chosen
