# SPDX-License-Identifier: MIT
"""`seatrial live` from end to end: a replay, stopped through the API of its page, and what is saved."""

import json
import os
import signal
import subprocess
import sys
import threading
import urllib.request
from argparse import Namespace
from contextlib import suppress
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import waiting
from conftest import all_values, make_model
from survey_boat import TRUTH, boat
from waiting import PATIENCE, free_port

import seatrial
from seatrial.boat.findings import FindingKind, finding_of
from seatrial.boat.model_file import save
from seatrial.boat.schema import EstimatorEntry
from seatrial.commands import live
from seatrial.commands.cli import main
from seatrial.poolside.state import LiveState, SignalState
from seatrial.simulation.plan import load_plan
from seatrial.util.files import dump_yaml

TRIAL = "S4-MP"


def get(port, path):
    with urllib.request.urlopen(f"http://127.0.0.1:{port}{path}", timeout=PATIENCE) as answer:
        return json.load(answer)


def post(port, path, body):
    request = urllib.request.Request(
        f"http://127.0.0.1:{port}{path}",
        json.dumps(body).encode(),
        {"content-type": "application/json"},
    )
    with urllib.request.urlopen(request, timeout=PATIENCE) as answer:
        return json.load(answer)


def until(port, wanted):
    """The state once it is as wanted."""
    seen = []

    def found():
        with suppress(OSError):
            seen[:] = [get(port, "/api/state")]
            return seen[0] if wanted(seen[0]) else None

    return waiting.until(found, lambda: seen)


@pytest.fixture(scope="module")
def trials(tmp_path_factory):
    """The trial that is replayed, with its vehicle's file."""
    folder = tmp_path_factory.mktemp("trials")
    plan = folder / "plan.yaml"
    plan.write_text(
        "seatrial: plan 1\nbased_on: clean\nvehicles: [mallard-mp]\n"
        f"trials: {{{TRIAL[:2]}: {{drive: surge, duration: 120}}}}\n"
    )
    assert main(["simulate", "--plan", str(plan), "-o", str(folder), "--quiet"]) == 0
    return folder


@pytest.fixture(scope="module")
def session(trials, tmp_path_factory):
    """Of a whole trial at 40 times its pace: the folder, the states on the way, the track, the result."""
    out, port, seen = tmp_path_factory.mktemp("live") / "drive", free_port(), {}

    def operate():
        try:
            seen["begin"] = until(port, lambda state: state["poses"] > 0)
            post(port, "/api/mark", {"text": "begin"})
            seen["end"] = until(
                port,
                lambda state: (
                    state["message"].startswith("The source has ended") and state["parameters"]
                ),
            )
            seen["track"] = get(port, "/api/track?since=0")
        finally:
            seen["saved"] = post(port, "/api/stop", {})

    operator = threading.Thread(target=operate)
    operator.start()
    vehicle, log = trials / f"vehicle-{TRIAL[-2:]}.yaml", trials / TRIAL
    code = main([
        "live", str(vehicle), str(log), "-o", str(out), "--speed", "40", "--port", str(port), "--no-browser",
        "--walls", "-3", "-3", "3", "3", "--json", str(out.parent / "live.json"), "--quiet",
    ])  # fmt: skip
    operator.join()
    assert code == 0
    return out, seen, json.loads((out.parent / "live.json").read_text())


@pytest.mark.system
def test_the_saved_recording_is_the_log(session, trials):
    out, _, _ = session
    vehicle = seatrial.load_vehicle(trials / f"vehicle-{TRIAL[-2:]}.yaml")
    log = seatrial.read(trials / TRIAL, vehicle)
    kept = seatrial.read(
        out / "recording", seatrial.load_vehicle(out / "recording" / "vehicle.yaml")
    )
    np.testing.assert_array_equal(kept.stamps, log.stamps)
    np.testing.assert_array_equal(kept.raw, log.raw)
    np.testing.assert_array_equal(kept.commands.values, log.commands.values)


@pytest.mark.system
def test_the_saved_model_is_near_the_truth(session):
    out, _, _ = session
    model, truth = seatrial.load(out / "model.yaml"), load_plan("clean").plant.coefficients
    assert set(model.values) == set(truth)
    for name, value in truth.items():
        error = abs(model.values[name] - value)
        assert error < 4.0 * model.standard_errors[name], name
        assert error < 0.1 * max(abs(value), 0.1), name


@pytest.mark.system
def test_the_saved_model_is_that_of_identify(session):
    out, _, _ = session
    vehicle = seatrial.load_vehicle(out / "recording" / "vehicle.yaml")
    again = seatrial.identify([seatrial.read(out / "recording", vehicle)], vehicle)
    saved = seatrial.load(out / "model.yaml").coefficients  # of ten digits
    np.testing.assert_allclose(saved, again.coefficients, rtol=1e-9)


@pytest.mark.system
def test_the_estimate_at_the_end_is_that_of_the_saved_model(session):
    out, seen, _ = session
    model = seatrial.load(out / "model.yaml")
    for one in seen["end"]["parameters"]:
        value = all_values(model)[one["name"]]
        assert abs(one["value"] - value) < max(3.0 * one["error"], 1e-9), one["name"]


@pytest.mark.system
def test_the_page_had_all_of_the_drive(session, trials):
    _, seen, _ = session
    state, rows = seen["end"], seen["track"]["rows"]
    log = seatrial.read(
        trials / TRIAL, seatrial.load_vehicle(trials / f"vehicle-{TRIAL[-2:]}.yaml")
    )
    assert state["poses"] == len(log.stamps)
    assert state["time"] == pytest.approx(log.duration)
    assert 0.5 * log.duration < state["driven"] <= log.duration
    assert state["marks"][0][1] == "begin"
    assert state["walls"] == [[-3, -3], [3, -3], [3, 3], [-3, 3]]
    assert {one["use"] for one in state["uses"]} == {"odometry", "control", "simulation"}
    assert [one["axis"] for one in state["coverage"]] == ["surge", "sway", "yaw"]
    assert {one["name"] for one in state["signals"]} >= {"pose", "F_u", "F_v", "F_r"}
    assert len(rows) == pytest.approx(5.0 * log.duration, rel=0.1)
    assert rows[-1][1:3] == pytest.approx(
        log.eta[np.searchsorted(log.t, rows[-1][0] - 1e-6), :2].tolist()
    )


@pytest.mark.system
def test_the_result_names_what_is_saved(session):
    out, seen, result = session
    paths = {name: str(out / path) for name, path in (
        ("recording", "recording"), ("vehicle", "recording/vehicle.yaml"), ("model", "model.yaml"), ("report", "report.html"),
    )}  # fmt: skip
    assert seen["saved"] == paths
    assert result["seatrial"] == "live 1"
    assert [result[name] for name in ("recording", "model", "report")] == [
        paths[name] for name in ("recording", "model", "report")
    ]
    assert "seatrial predict" in result["next"]
    assert (out / "report.html").read_text().startswith("<!DOCTYPE html>")
    assert {path.name for path in out.iterdir()} == {"recording", "model.yaml", "report.html"}


def begun(trials, *arguments):
    """The exit code of a replay on any port."""
    boat, log = str(trials / "vehicle-MP.yaml"), str(trials / TRIAL)
    return main(["live", boat, log, "--no-browser", "--port", "0", *arguments])


@pytest.mark.parametrize(
    ("arguments", "fault"),
    [
        (["--address", "0.0.0.0"], "give a token"),
        (["--token", "short"], "5 characters"),
        (["--walls", "0", "0", "1", "1", "--area", "walls.yaml"], "not both"),
        (["--walls", "0", "0", "0", "1"], "area"),
        (["--area", "nowhere.yaml"], "no such file"),
        (["--speed", "-1"], "speed"),
        (["-o", "full"], "is not empty"),
    ],
)
def test_a_mistake_is_one_line(trials, tmp_path, monkeypatch, capsys, arguments, fault):  # noqa: PLR0917
    monkeypatch.chdir(tmp_path)
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "file").touch()
    assert begun(trials, *arguments) == 1
    told = capsys.readouterr().err
    assert fault in told and told.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["full"]  # nothing is begun


def test_without_its_packages_it_says_what_to_install(trials, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "uvicorn", None)
    monkeypatch.delitem(sys.modules, "seatrial.poolside.web.server", raising=False)
    assert begun(trials) == 1
    assert "pip install 'seatrial[live]'" in capsys.readouterr().err


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_keeps_the_recording(trials, tmp_path, sent):
    port, out = free_port(), tmp_path / "drive"
    vehicle = trials / "vehicle-MP.yaml"
    program = subprocess.Popen(
        [sys.executable, "-m", "seatrial", "live", str(vehicle), "-", "-o", str(out), "--port", str(port)],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env={name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"},
    )  # fmt: skip
    try:
        for i in range(50):
            program.stdin.write(f'{{"t": {0.1 * i:.1f}, "pose": [0.1, {0.01 * i}, 0]}}\n')
            program.stdin.write(f'{{"t": {0.1 * i:.1f}, "command": [0.1, 0, 0]}}\n')
        program.stdin.flush()
        said = program.stdout.readline()
        until(port, lambda state: state["poses"] == 50)
        program.send_signal(sent)
        _, complained = program.communicate(timeout=PATIENCE)
    finally:
        program.kill()
    assert program.returncode == 130
    assert f"http://127.0.0.1:{port}/" in said
    assert str(out / "recording") in complained
    kept = seatrial.read(
        out / "recording", seatrial.load_vehicle(out / "recording" / "vehicle.yaml")
    )
    assert len(kept.stamps) == 50 and kept.eta[-1, 1] == pytest.approx(0.49)


def test_a_drive_without_a_model_fails(trials, tmp_path, monkeypatch, capsys):
    lines = [f'{{"t": {0.1 * i:.1f}, "pose": [0, 0, {i}]}}\n' for i in range(60)]
    read, write = os.pipe()
    os.write(write, "".join(lines).encode())
    os.close(write)
    port = free_port()
    stop = threading.Thread(
        target=lambda: (until(port, lambda s: s["poses"] > 0), post(port, "/api/stop", {}))
    )
    stop.start()
    with os.fdopen(read) as inlet:
        monkeypatch.setattr(sys, "stdin", inlet)
        code = main(
            ["live", str(trials / "vehicle-MP.yaml"), "-", "-o", str(tmp_path / "drive"), "--port", str(port),
             "--no-browser", "--quiet"]
        )  # fmt: skip
        stop.join()
    said = capsys.readouterr()
    assert code == 1
    assert "recording" in said.out and "next: seatrial inspect" in said.out
    assert said.err.startswith(
        "seatrial: The recording is saved, but there is no model: no command has come: send commands of F_u"
    )
    assert (tmp_path / "drive" / "recording" / "poses.csv").exists()


class Page:
    """A page that is closed at the third look."""

    def __init__(self):
        self.looks = 0

    @property
    def connected(self):
        self.looks += 1
        return self.looks < 3


@pytest.mark.parametrize(
    ("saved", "looks"), [((("report", "r.html"),), 3), ((("recording", "r"),), 0)]
)
def test_a_saved_report_is_served_until_its_page_is_closed(saved, looks, monkeypatch, capsys):
    monkeypatch.setattr(live, "LAST_LOOK", 0.0)
    page, state = Page(), LiveState(vehicle="boat", saved=saved)
    live._leave(page, SimpleNamespace(state=lambda: state))
    assert page.looks == looks
    assert ("until it is closed, or Ctrl-C" in capsys.readouterr().out) == (looks > 0)


def test_ctrl_c_ends_the_page_of_a_saved_report(monkeypatch):
    """The session is saved: it is no fault."""

    def interrupted(_):
        raise KeyboardInterrupt

    monkeypatch.setattr(live.time, "sleep", interrupted)
    live._leave(Page(), SimpleNamespace(state=lambda: LiveState(vehicle="boat")))


def saved_session(folder, findings=()):
    """Paths of a recording with its vehicle file, and of a model with these findings."""
    recording = folder / "recording"
    recording.mkdir(exist_ok=True)
    (recording / "vehicle.yaml").write_text(dump_yaml(boat().to_mapping()))
    estimator = EstimatorEntry("output-error", findings=[*findings])
    save(replace(make_model(boat(), TRUTH), estimator=estimator), folder / "model.yaml")
    return {"recording": str(recording), "model": str(folder / "model.yaml")}


def test_the_line_that_mends_the_vehicle_file_is_printed_at_the_end(tmp_path, capsys):
    wrong = SignalState("F_r", "command", 9, finding="turns the other way", edit="F_r: {sign: -1}")
    saved = tuple(saved_session(tmp_path).items())
    state = LiveState(vehicle="boat", signals=(wrong,), saved=saved)
    live._saved(Namespace(json=None), SimpleNamespace(state=lambda: state), tmp_path)
    said = capsys.readouterr()
    assert "F_r: turns the other way; change the vehicle file: F_r: {sign: -1}" in said.err
    assert f"next: seatrial predict {tmp_path / 'model.yaml'}" in said.out


def test_the_last_line_is_what_the_saved_model_asks_for(tmp_path):
    """A lever arm that was found makes wrong coefficients; it ended with the use of them."""
    lever = finding_of(FindingKind.UNMODELLED_LEVER_ARM, size=0.26)
    for findings, said in (([], " predict "), ([lever], " --effect lever ")):
        assert said in live._next(Namespace(), saved_session(tmp_path, findings))
