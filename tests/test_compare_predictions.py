# SPDX-License-Identifier: MIT
"""Before and after on recordings: which model predicts them better, and what a few seconds tell."""

import json
from dataclasses import replace

import msgspec
import numpy as np
import pytest
from cli_tools import done, refused, run
from conftest import TABLE_II
from scipy import stats

import seatrial
from seatrial.boat.model_file import load, save
from seatrial.boat.schema import Integration, RecordingEntry
from seatrial.evaluation.comparison.compare import compare
from seatrial.evaluation.comparison.console import comparison_text
from seatrial.evaluation.comparison.parameters import Joint
from seatrial.evaluation.comparison.prediction import rms_difference
from seatrial.io.trial_files import write_trial
from seatrial.simulation.trials import plant_model, simulate
from tests.boats.plans import planned

LOADED = {name: value / 1.2 for name, value in TABLE_II["AF"].items()}  # of more mass


def test_the_interval_of_a_difference_of_errors_holds():
    """Two models with a common error: 95 % intervals over blocks, 95 % of the time."""
    rng = np.random.default_rng(1)
    inside, alarms, runs = 0, 0, 400
    for _ in range(runs):
        common, a, b, c = rng.normal(size=(4, 30, 10))
        interval, _, _ = rms_difference(
            np.sum((common + 0.5 * a) ** 2, axis=1),
            np.sum((common + 0.3 * b) ** 2, axis=1),
            np.full(30, 10.0),
        )
        want = np.sqrt(1.25) - np.sqrt(1.09)
        inside += interval[0] <= want <= interval[1]
        _, p, _ = rms_difference(
            np.sum((common + 0.3 * b) ** 2, axis=1), np.sum((common + 0.3 * c) ** 2, axis=1),
            np.full(30, 10.0),
        )  # fmt: skip
        alarms += p < 0.05
    assert stats.binomtest(inside, runs, 0.95).pvalue > 0.001
    assert stats.binomtest(alarms, runs, 0.05).pvalue > 0.001


@pytest.fixture(scope="module")
def heavier(mp):
    """Trials of the boat with its payload; the models of both, at a step that models come with."""
    plan = planned("paper-like", "S4", "S7", seconds=120.0)
    after = planned(plan, coefficients=LOADED)
    trials = list(simulate(after, mp))
    step = Integration("runge-kutta", 1 / 30)
    models = (replace(plant_model(one, mp), integration=step) for one in (plan, after))
    return *models, trials


@pytest.mark.system
def test_the_model_of_the_loaded_boat_predicts_it_better(heavier):
    before, after, trials = heavier
    records = [t.recording for t in trials]
    found = compare(before, after, records, horizon=0.5)
    assert found.better == {h: {"u": "B", "v": "B", "r": "B"} for h in ("0.5", "1")}
    last = found.ahead[-1]
    assert (last.recording, last.horizon, last.starts) == ("all", 1.0, "filter")
    for axis in last.axes.values():
        assert 0 < axis.interval[0] < axis.difference < axis.interval[1]
    text = comparison_text(found)
    assert "=> the change matters for prediction: B is better in surge" in text
    untold = msgspec.structs.replace(found, pairs=[], joint=Joint(chi2=4.0, freedom=5, p=0.55))
    assert (
        "=> prediction shows a change within the coefficients' errors: B is better in surge"
        in comparison_text(untold)
    )
    turned = compare(after, before, records).ahead[-1]
    for symbol, axis in turned.axes.items():
        assert axis.difference == pytest.approx(-last.axes[symbol].difference, abs=1e-9)
        assert axis.better == "A"


def test_a_boat_predicts_as_well_as_itself(heavier):
    _, after, trials = heavier
    found = compare(after, after, [trials[0].recording])
    assert found.better == {"1": {"u": None, "v": None, "r": None}}
    assert [a.p for a in found.ahead[0].axes.values()] == [1.0, 1.0, 1.0]
    assert "both predict these recordings equally well" in comparison_text(found)


def test_a_recording_that_a_model_has_seen_is_no_fair_test(heavier):
    before, after, trials = heavier
    record = trials[0].recording
    after = replace(after, recordings=(RecordingEntry(record.name, record.duration),))
    text = comparison_text(compare(before, after, [record]))
    assert f"warning: B was identified from {record.name}, which favours it" in text


def test_a_few_seconds_tell_nothing(heavier):
    before, after, trials = heavier
    found = compare(before, after, [trials[0].recording.cut(10, 17)])
    assert found.ahead[0].axes["u"].interval is None
    assert "too short to decide which predicts better" in comparison_text(found)


def test_the_command_line(heavier, mp, af, tmp_path, capsys):
    before, after, trials = heavier
    save(before, tmp_path / "old.yaml")
    save(after, tmp_path / "new.yaml")
    drive = write_trial(trials[0], tmp_path)
    files = [str(tmp_path / "old.yaml"), str(tmp_path / "new.yaml")]
    shown = done(capsys, "compare", *files, drive, "--json", tmp_path / "c.json")
    content = json.loads((tmp_path / "c.json").read_text())
    a, b = (load(file) for file in files)
    found = compare(a, b, [seatrial.read(drive, a.vehicle)], labels=tuple(files))
    want = msgspec.to_builtins(found)
    assert content == json.loads(json.dumps(want))
    assert f"{100 * content['ahead'][0]['axes']['u']['a']:.3f}" in shown
    save(after.with_vehicle(af), tmp_path / "af.yaml")
    other = ["compare", files[0], str(tmp_path / "af.yaml"), str(drive)]
    assert "give the vehicle file of these recordings with --vehicle" in refused(capsys, *other)
    assert run(capsys, *other, "--vehicle", "mallard-mp")[0] == 0
    assert "is an input of this command" in refused(capsys, "compare", *files, "--json", files[0])
