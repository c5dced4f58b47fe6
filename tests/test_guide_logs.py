# SPDX-License-Identifier: MIT
"""What a guided path takes from its folder: each recording from its own log, scores of the model that is there."""

import shlex
from types import SimpleNamespace

import numpy as np
from test_guide import one_drive, tables

from seatrial.boat.findings import FindingKind, finding_of
from seatrial.boat.vehicle import vehicle_from
from seatrial.guide import scores_and_report
from seatrial.guide.recordings import as_model_reads, driven_recordings
from seatrial.guide.steps import Steps, Task
from seatrial.guide.vehicle_file import vehicle_of
from seatrial.inspection.proposal.sources import Choices


def test_logs_of_one_name_are_each_read_again_from_their_own_file(tmp_path):
    """As `recording` of two sessions, one of them to test the model: another lever arm was estimated."""
    logs = tuple(tables(tmp_path / day / "run", one_drive(60.0, i)) for i, day in enumerate("ab"))
    out = tmp_path / "out"
    here = Task(logs, out, None, lambda _: None, salvage=False, steps=Steps(out))
    vehicle, _ = vehicle_of(here, Choices())
    recordings, _ = driven_recordings(here, vehicle, proposed_now=True)
    assert [one.name for one in recordings] == ["a/run", "b/run"]
    content = vehicle.to_mapping()
    content["pose"]["lever"] = [0.3, 0.1]
    model = SimpleNamespace(vehicle=vehicle_from(content, "vehicle.yaml"))
    for some in (recordings, recordings[::-1]):
        again = as_model_reads(here, model, vehicle, some)
        for before, after in zip(some, again, strict=True):
            np.testing.assert_allclose(after.raw[:, 2], before.raw[:, 2])
            off = np.hypot(*(after.eta - before.eta)[:, :2].T)
            np.testing.assert_allclose(off, np.hypot(0.3, 0.1))


def test_scores_of_another_model_are_not_those_of_this_one(tmp_path, monkeypatch):
    """The model was removed and made again from the same logs, with another answer on an effect."""
    for name, found in (("validate", "new"), ("scores_json", {}), ("load_scores", "kept")):
        monkeypatch.setattr(scores_and_report, name, lambda *_, found=found: found)
    here = Task((), tmp_path, None, lambda _: None, salvage=False, steps=Steps(tmp_path))
    for text, expected in (("lever", "new"), ("lever", "kept"), ("no lever", "new")):
        here.file("model.yaml").write_text(text)
        assert scores_and_report.scores_on(here, None, [], "of these logs") == expected


def test_what_tests_the_model_stays_out_of_the_next_command(tmp_path, monkeypatch):
    for name in ("assess", "scores_of", "evidence_of", "write_evidence", "predicted"):
        monkeypatch.setattr(scores_and_report, name, lambda *_: None)
    mismatch = finding_of(FindingKind.MODEL_MISMATCH, horizon=1.0)
    estimator = SimpleNamespace(findings=[mismatch], settings={})
    model = SimpleNamespace(warnings=(), estimator=estimator)
    drive, figures = (SimpleNamespace(sources=(name,)) for name in ("drive", "figures"))
    logs = {one.sources: tmp_path / f"{one.sources[0]}.bag" for one in (drive, figures)}
    here = Task((*logs.values(),), tmp_path, None, lambda _: None, False, Steps(tmp_path))
    here.log_of |= logs
    step = scores_and_report.report(
        here, model, [figures, drive], [drive], None, automatic=False, look=lambda: None
    )
    words = shlex.split(step.do)
    assert words[:3] == ["seatrial", "select", str(tmp_path / "drive.bag")]
    assert words[3:] == [
        "--vehicle", str(tmp_path / "vehicle.yaml"), "-o", str(tmp_path / "vehicle-chosen.yaml"),
    ]  # fmt: skip
