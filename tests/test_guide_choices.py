# SPDX-License-Identifier: MIT
"""The guided path: what it asks, which recording tests, and when it stops or begins anew."""

import json
import shlex
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from cli_tools import documented, refused
from guided_logs import LEVER, Owner, lake_log, one_drive, tables
from survey_boat import driven

import seatrial
from seatrial.boat.vehicle import load_vehicle
from seatrial.commands import make_parser
from seatrial.commands.cli import main
from seatrial.guide import answers, held_out, scores_and_report
from seatrial.guide import model as guided_model
from seatrial.guide.answers import (
    BOW,
    BOW_QUESTION,
    LAST_QUARTER,
    OTHER_END,
    OTHER_NAMES,
    STERN,
    TEST_QUESTION,
)
from seatrial.guide.model import too_short_text
from seatrial.guide.steps import Steps, Task
from seatrial.inspection.proposal.sources import Choices
from seatrial.recording.excitation import find_roles
from seatrial.report.evidence import verdict
from seatrial.util.errors import RecordingError, SeatrialError
from seatrial.workflow.fitness import Criterion, Fitness, Level, Reason, Use

drive = lake_log


def test_only_what_no_log_can_tell_is_asked(drive, tmp_path, monkeypatch):
    def stop(*_, **__):
        raise SeatrialError("far enough")

    monkeypatch.setattr(guided_model, "identify_guided", stop)
    owner = Owner(**{"middle of the thrusters": "0.30 -0.12"})
    with pytest.raises(SeatrialError, match="far enough"):
        seatrial.auto([drive], tmp_path / "a", ask=owner)
    assert "turns to the left" in owner.asked[0] and owner.asked[1] == BOW_QUESTION
    assert len(owner.asked) == 3
    assert load_vehicle(tmp_path / "a" / "vehicle.yaml").lever == LEVER
    # the answers are in the vehicle file: nothing is asked again
    with pytest.raises(SeatrialError, match="far enough"):
        seatrial.auto([drive], tmp_path / "a", ask=(later := Owner()))
    assert later.asked == []


def test_a_heading_of_the_stern_is_turned(tmp_path, monkeypatch):
    recording = one_drive(seconds=120.0)
    drive = tables(tmp_path / "log", recording, flip=True)
    monkeypatch.setattr(guided_model, "identify_guided", _stop)
    names = OTHER_NAMES.format(names="left and right")
    asked = []
    for where, end, wrong in (("bow", BOW, names), ("stern", STERN, ""), ("other", BOW, OTHER_END)):
        owner = Owner(**{"Which end": end, "Driven ahead": wrong})
        with pytest.raises(SeatrialError, match="far enough"):
            seatrial.auto([drive], tmp_path / where, ask=owner)
        asked.append(any(question.startswith("Driven ahead") for question in owner.asked))
    assert asked == [True, False, True]  # left and right show which answer is wrong
    bow, stern, other = (
        load_vehicle(tmp_path / where / "vehicle.yaml") for where in ("bow", "stern", "other")
    )
    np.testing.assert_array_equal(other.mix, stern.mix)
    # nobody to ask: it is said
    proposal, given = answers.proposed([drive], Choices(), None, salvage=False)
    assumed = answers.assumptions(drive, proposal, given, None)
    assert any("left and right on the other side than the names say" in text for text in assumed)
    read = seatrial.read(drive, stern)
    turn = np.median(read.eta[:, 2] - recording.eta[:, 2])
    assert np.cos(turn) == pytest.approx(1.0, abs=1e-6)
    # by the heading of the stern the boat seems to drive astern
    np.testing.assert_allclose(stern.mix[0], [0.5, 0.5], atol=0.03)
    assert not np.allclose(bow.mix[0] * bow.input_signs, stern.mix[0] * stern.input_signs, atol=0.2)


def _stop(*_, **__):
    raise SeatrialError("far enough")


def guided_by(monkeypatch):
    """A list that gets the names of recordings that a model is sought from, which ends there."""
    seen = []

    def stop(found, *_, **__):
        seen.append([r.name for r in found])
        _stop()

    monkeypatch.setattr(guided_model, "identify_guided", stop)
    return seen


def test_a_recording_may_test_the_others(tmp_path, monkeypatch):
    logs = [tables(tmp_path / name, one_drive(60.0, seed)) for name, seed in (("a", 1), ("b", 2))]
    seen = guided_by(monkeypatch)
    for where, options in (
        ("given", {"test": logs[0]}),
        ("answered", {"ask": Owner(**{TEST_QUESTION: "a"})}),
        ("answered", {}),  # which is remembered
    ):
        with pytest.raises(SeatrialError, match="far enough"):
            seatrial.auto(logs, tmp_path / where, **options)
    # a further log, and the same log under another path
    roundabout = tmp_path / "b" / ".." / "a"
    for test, given in ((logs[0], logs[1:]), (roundabout, logs)):
        with pytest.raises(SeatrialError, match="far enough"):
            seatrial.auto(given, tmp_path / "given", test=test)
    assert seen == [["b"]] * 5
    for wrong, given, why in (
        ("c", logs, "there is no such log; give one of .*/a, .*/b or another one"),
        ("a", logs[:1], "it is the only log; give another one"),
    ):
        with pytest.raises(SeatrialError, match=f"^--test {wrong}: {why}$"):
            seatrial.auto(given, tmp_path / "nowhere", test=wrong)
    assert not (tmp_path / "nowhere").exists()
    (tmp_path / "file").write_text("")
    with pytest.raises(SeatrialError, match="is a file; give a folder"):
        seatrial.auto(logs, tmp_path / "file")


def test_the_recording_that_tests_is_asked_again_when_recordings_change(tmp_path, monkeypatch):
    names = ("a", "b", "c")
    logs = [tables(tmp_path / n, one_drive(60.0, seed)) for seed, n in enumerate(names, 1)]
    monkeypatch.setattr(guided_model, "identify_guided", _stop)

    def asked(given, answer=LAST_QUARTER, folder="out"):
        owner = Owner(**{TEST_QUESTION: answer})
        with pytest.raises(SeatrialError, match="far enough"):
            seatrial.auto(given, tmp_path / folder, ask=owner)
        return TEST_QUESTION in owner.asked

    assert asked(logs[:2], "a") and not asked(logs[:2])
    assert Steps(tmp_path / "out").answer("test") == "a"
    assert asked(logs) and not asked(logs)  # the last quarter is an answer, too
    assert asked(logs[1:], "b")
    seen = guided_by(monkeypatch)
    for given in (
        logs[1:],
        logs[::2],
    ):  # nobody to ask: the answer holds while its recording is there
        with pytest.raises(SeatrialError, match="far enough"):
            seatrial.auto(given, tmp_path / "out")
    assert seen == [["c"], ["a", "c"]]


def test_the_folder_of_another_boat_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(guided_model, "identify_guided", _stop)
    first = tables(tmp_path / "first", one_drive(60.0))
    with pytest.raises(SeatrialError, match="far enough"):
        seatrial.auto([first], tmp_path / "boat")
    other = tables(tmp_path / "other", one_drive(60.0, 2))
    text = (other / "commands.csv").read_text()
    (other / "commands.csv").write_text(text.replace("left,right", "bow,stern"))
    words = (
        r"boat has a vehicle file that does not describe .*other: .*left.*give another one with -o"
    )
    with pytest.raises(RecordingError, match=words):
        seatrial.auto([other], tmp_path / "boat")


def test_an_axis_that_is_driven_at_the_end_only_is_not_held_out(tmp_path, monkeypatch):
    """A run of pulses in surge, then in yaw, has no yaw in its first three quarters."""
    drive = tables(tmp_path / "log", one_drive(240.0))
    lengths = []

    def roles(vehicle, recordings):
        if recordings[0].duration < 200.0:
            raise RecordingError("yaw: no recording excites it")
        return find_roles(vehicle, recordings)

    def stop(found, *_, **__):
        lengths.append(found[0].duration)
        _stop()

    monkeypatch.setattr(held_out, "find_roles", roles)
    monkeypatch.setattr(guided_model, "identify_guided", stop)
    with pytest.raises(SeatrialError, match="far enough"):
        seatrial.auto([drive], tmp_path / "out")
    assert lengths == [pytest.approx(240.0, abs=0.5)]


@pytest.mark.parametrize(
    "content", ["[]", '{"seatrial": "steps 1", "steps": 3}', "{", '{"seatrial": "model 3"}']
)
def test_a_file_of_steps_that_is_none_is_refused(tmp_path, content):
    (tmp_path / "steps.json").write_text(content)
    with pytest.raises(SeatrialError, match=r"steps\.json"):
        Steps(tmp_path)


def test_steps_of_other_inputs_or_changed_files_are_not_done(tmp_path):
    file = tmp_path / "model.yaml"
    file.write_text("one")
    steps = Steps(tmp_path)
    steps.note("model", "abc", [file])
    assert Steps(tmp_path).done("model", "abc", [file])
    assert not Steps(tmp_path).done("model", "abd", [file])
    file.write_text("two")
    assert not Steps(tmp_path).done("model", "abc", [file])
    file.unlink()
    assert not Steps(tmp_path).done("model", "abc", [file])
    odd = {"seatrial": "steps 1", "steps": {"model": 3, "answers": [1]}}
    (tmp_path / "steps.json").write_text(json.dumps(odd))
    assert not Steps(tmp_path).done("model", "abc", []) and Steps(tmp_path).answer("test") is None


def test_the_command_says_what_is_assumed_and_what_is_next(drive, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    log = tables(tmp_path / "short log", one_drive(90.0))
    result = tmp_path / "auto.json"
    options = ["--lever", "0", "0", "--name", "tub", "--json", str(result)]
    assert main(["auto", str(log), *options]) == 0
    content = documented("auto", result)
    assert content["identified"]["name"] == "tub"
    assert all(Path(content[name]).is_file() for name in ("report", "scores"))
    said = capsys.readouterr().out
    assert "tub, output-error" in said and "\nassumed: axes forward-left-up" in said
    assert said.splitlines()[-1].startswith("next: ")
    assert (tmp_path / "short log-model" / "report.html").is_file()
    assert "none.csv" in refused(capsys, "auto", tmp_path / "none.csv")
    assert main(["auto", str(log), "--lever", "100", "0", "-o", "far"]) == 1


def test_a_path_that_is_stopped_says_how_to_go_on(drive, tmp_path, capsys, monkeypatch):
    def interrupt(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(guided_model, "identify_guided", interrupt)
    assert main(["auto", str(drive), "-o", str(tmp_path / "otter")]) == 130
    assert "stopped; the same command goes on where it was" in capsys.readouterr().err
    assert load_vehicle(tmp_path / "otter" / "vehicle.yaml").name == "otter"
    assert main(["auto", str(drive), "-o", str(tmp_path / "otter"), "--lever", "0", "0"]) == 130
    assert "options on the boat are not used: change the file" in capsys.readouterr().out


def test_data_that_is_there_is_used_before_more_is_driven(tmp_path):
    """The boat is fast in the last quarter only, which tests the model."""
    calls = iter(range(10**6))

    def size(rng):
        return rng.uniform(-1.0, 1.0) * (0.35 if next(calls) < 100 else 1.0)

    log = tables(tmp_path / "logs" / "pond", driven({}, [size, size], seconds=240.0)[1])
    step = seatrial.auto([log], tmp_path / "pond").next
    words = shlex.split(step.do)
    assert (
        words[:2] == ["seatrial", "identify"]
        and str(tmp_path / "pond" / "model-of-all.yaml") in words
    )
    assert make_parser().parse_args(words[1:])
    assert "lacks the last quarter of each log. If that is not enough: " in step.why


@pytest.mark.parametrize(
    ("held", "name", "said"),
    [
        (90.0, "pool-held-out", "record 70 s more, or give another drive with --test"),
        (10.0, "pool-held-out", "record 70 s more"),
        (90.0, "other", "record 50 s more"),
    ],
)
def test_too_short_says_what_there_is_what_it_takes_and_how_to_get_there(held, name, said):
    """270 s of 320 s for 16 parameters; a quarter of what is recorded further is held out, too."""
    found = SimpleNamespace(solution=SimpleNamespace(problem=SimpleNamespace(free=range(16))))

    def drive(seconds, name):
        t = np.arange(0.0, seconds)
        return SimpleNamespace(duration=seconds, name=name, t=t, valid=t >= 0.0)

    text = too_short_text(found, [drive(270.0, "pool")], [drive(held, name)])
    assert text == f"270 s identify the model, choosing terms takes 320 s: {said}"
    # long enough for these parameters, but not for all terms that the search tried
    found.solution.problem.free = range(13)
    text = too_short_text(found, [drive(270.0, "pool")], [drive(held, name)])
    assert text == "the recordings ask for more terms than 270 s tell apart: record longer"


@pytest.mark.parametrize(("level", "used"), [(Level.LIMITED, True), (Level.NOT_FIT, False)])
def test_a_model_that_is_not_fit_for_odometry_is_not_to_be_used_for_it(level, used, monkeypatch):
    for module in (scores_and_report, verdict):
        monkeypatch.setattr(module, "wished", lambda _: "")
    ratio = Reason(Criterion.CONSISTENCY, "surge", 2.5, 1.25, 1.0)
    fit = [Fitness(use, Level.FIT, ratio) for use in (Use.SIMULATION, Use.CONTROL)]
    evidence = SimpleNamespace(fitness=(*fit, Fitness(Use.ODOMETRY, level, ratio)))
    here = Task((Path("pool"),), Path("out"), None, print, False, None)
    step = scores_and_report.after_report(here, evidence, None)
    assert step.do.startswith("seatrial predict") == used
    if not used:
        assert "use it for simulation and control" in step.do
        assert "For odometry (not fit): identify also" in step.do
