# SPDX-License-Identifier: MIT
"""`seatrial tune`: its files, its page, its refusals."""

import dataclasses

import msgspec
import numpy as np
import pytest
import yaml
from cli_tools import done, refused
from conftest import ROOT
from tune_tools import in_loop, mallard

import seatrial
from seatrial.commands.cli import main
from seatrial.control import Reference, gains_of, load_gains, ros_parameters, save_gains, tune
from seatrial.control.tuning.console import tuning_text
from seatrial.control.tuning.page import tuning_report
from seatrial.control.tuning.responses import responses, steps_of
from seatrial.util.errors import FileError, SeatrialError


@pytest.fixture(scope="module")
def tuning():
    return tune(mallard(), 0.8, draws=10)


@pytest.fixture
def model_file(tmp_path):
    path = tmp_path / "model.yaml"
    seatrial.save(mallard(spread=0.0), path)
    return path


def test_the_command_writes_what_the_library_finds(model_file, tmp_path, capsys):
    outs = [tmp_path / name for name in ("gains.yaml", "ros.yaml", "ros2.yaml", "page.html")]
    flags = ("-o", "--ros", "--ros2", "--report")
    told = [str(x) for pair in zip(flags, outs, strict=True) for x in pair]
    shown = done(capsys, "tune", model_file, "--knob", "0.8", "-q", *told)
    own = tune(seatrial.load(model_file), 0.8)
    assert shown.startswith(tuning_text(own))
    assert all(f"wrote {out}" in shown for out in outs)
    found = load_gains(outs[0])
    np.testing.assert_allclose(found.proportional, own.table()[:, 0], rtol=1e-9)
    assert found.action == "pid" and found.knob == 0.8 and found.inputs == ["F_u", "F_v", "F_r"]
    ros, ros2 = (yaml.safe_load(out.read_text())["seatrial_tracking"] for out in outs[1:3])
    assert ros2["ros__parameters"] == ros
    assert (ros.pop("action"), ros.pop("allocation")) == ("pid", "vehicle")
    numbers = [x for v in ros.values() for x in (v if isinstance(v, list) else [v])]
    assert all(isinstance(x, float) for x in numbers)  # ROS 2 takes no 1 for 1.0
    header = (ROOT / "ros/common/include/seatrial_ros/tracking_settings.hpp").read_text()
    assert all(f'Parameter{{"{name}"' in header for name in set(ros) - {"knob"})
    assert ros["derivative"] == pytest.approx(own.table()[:, 2].tolist())
    assert ros["mix"] == pytest.approx(own.boat.mix.ravel().tolist(), abs=1e-12)
    assert outs[3].read_text().startswith("<!DOCTYPE html")
    assert main(["tune", str(model_file), "--knob", "0.8", "-q", *told]) == 0  # over its own files


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--knob", "0.05"], "the smallest robust one: --knob"),
        (["--knob", "-1"], "knob -1 s: expected a time constant above 0 s, up to 100 s"),
        (["--rate", "0"], "rate 0 Hz: expected 0.1 to 10000 Hz"),
        (["--delay", "nan"], "delay nan s: expected 0 to 100 s"),
        (["-o", "MODEL"], "is an input of this command"),
    ],
)
def test_mistakes_are_one_line_and_nothing_is_written(model_file, tmp_path, capsys, more, said):
    before = sorted(tmp_path.iterdir())
    given = [model_file if x == "MODEL" else x for x in more]
    out = [] if "-o" in more else ["-o", tmp_path / "gains.yaml"]
    assert said in refused(capsys, "tune", model_file, "-q", *given, *out)
    assert sorted(tmp_path.iterdir()) == before


def test_two_outputs_in_one_file_are_refused(model_file, tmp_path, capsys):
    both = ["-o", tmp_path / "one.yaml", "--ros", tmp_path / "one.yaml"]
    assert "is an input of this command" in refused(capsys, "tune", model_file, "-q", *both)


def test_gains_come_back_from_their_file(tuning, tmp_path):
    save_gains(tuning, tmp_path / "gains.yaml")
    assert_close(
        msgspec.to_builtins(load_gains(tmp_path / "gains.yaml")),
        msgspec.to_builtins(gains_of(tuning)),
    )


def assert_close(a, b):
    if isinstance(a, dict):
        assert a.keys() == b.keys()
        for key in a:
            assert_close(a[key], b[key])
    elif isinstance(a, (list, tuple)):
        for x, y in zip(a, b, strict=True):
            assert_close(x, y)
    else:
        assert a == (pytest.approx(b, rel=1e-9) if isinstance(a, float) else b)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("seatrial: gains 1", "seatrial: gains 9", "gains 9"),
        ("knob:", "knobb:", "unknown key 'knobb'; did you mean 'knob'"),
        ("knob: 0.8", "knob: -1.0", "knob"),
        ("inputs: [F_u, F_v, F_r]", "inputs: [F_u, F_v]", "mix has 3 rows; expected one for each of the inputs"),
    ],
)  # fmt: skip
def test_a_damaged_gains_file_is_one_line(tuning, tmp_path, old, new, said):
    path = tmp_path / "gains.yaml"
    save_gains(tuning, path)
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(SeatrialError, match=said) as e:
        load_gains(path)
    assert "\n" not in str(e.value)


def test_a_missing_gains_file_is_told(tmp_path):
    with pytest.raises(FileError):
        load_gains(tmp_path / "none.yaml")


def test_ros_parameters_are_plain_lists(tuning):
    for value in ros_parameters(tuning).values():
        assert isinstance(value, (float, str)) or all(isinstance(x, float) for x in value)


def test_step_responses_are_those_of_python_control():
    """Of the surge loop, which N_ud leaves to itself."""
    control = pytest.importorskip("control")
    own = tune(mallard(spread=0.0), 0.8)
    t = np.linspace(0.0, 9.6, 97)
    (found,) = steps_of(own, [own.boat], t)
    s = control.tf("s")
    for axis, drag in enumerate((0.20, 0.23, 0.48)):
        g = own.gains[axis]
        delay = control.tf(*control.pade(0.05 + own.hold, 6))
        plant = delay / ((0.08 * s + 1) * s * (s + drag))
        on_step = g.proportional + g.integral / s  # the reference's velocity, for D, has no step
        loop = (on_step + g.derivative * s) * plant
        closed = control.minreal(on_step * plant / (1 + loop), verbose=False)
        _, y = control.step_response(closed, t)
        # the yaw loop is that with surge closed; N_ud moves it by less than this
        np.testing.assert_allclose(found[axis], y, atol=8e-3)
    assert 1.1 < found.max() < 1.6 and abs(found[:, -1] - 1.0).max() < 0.03


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_the_step_response_is_that_of_the_controller_itself(axis):
    """In the simulator: a goal so near that no command is limited and the boat stays nearly at rest."""
    own = tune(mallard(chain=[{"latency": 0.05, "lag": 0.08}], spread=0.0), 0.8)
    goal = Reference.still(1e-3 * np.eye(3)[axis])
    rows = in_loop(own.model, seatrial.TrackingController(own), lambda *_: (goal,), 8.0, radius=0.0)
    t, found = zip(*((t, 1e3 * eta[axis]) for t, eta, *_ in rows), strict=True)
    np.testing.assert_allclose(steps_of(own, [own.boat], np.array(t))[0, axis], found, atol=0.015)


def test_bands_hold_the_model_and_have_width(tuning):
    curves = responses(tuning)
    for one in (curves.gain, curves.phase, curves.sensitivity, curves.step):
        assert (one.low <= one.y).all() and (one.y <= one.high).all()
        assert (one.high - one.low).max() > 0
    # the loop's slope at low frequencies: a third-order integrator's
    slope = np.diff(np.log(curves.gain.y[0, :5])) / np.diff(np.log(curves.gain.x[:5]))
    assert slope == pytest.approx(-2.0, abs=0.4)
    assert curves.sensitivity.y.max() == pytest.approx(tuning.nominal.sensitivity.max(), rel=0.05)


def test_the_page_says_what_was_found(tuning):
    html = tuning_report(tuning)
    assert html == tuning_report(tuning)
    for title in ("Gains", "Margins", "Step of the reference", "Frequency response", "Provenance"):
        assert f"<h2>{title}</h2>" in html
    for value in (*tuning.table().ravel(), *tuning.worst.sensitivity):
        assert f'<data value="{float(value)!r}">' in html


def test_the_page_of_a_boat_with_markup_in_its_name_is_text(tuning):
    vehicle = tuning.model.vehicle
    file = msgspec.structs.replace(vehicle.file, name="<b>x</b>")
    model = dataclasses.replace(tuning.model, vehicle=dataclasses.replace(vehicle, file=file))
    html = tuning_report(dataclasses.replace(tuning, model=model))
    assert "<b>x</b>" not in html and "&lt;b&gt;x&lt;/b&gt;" in html


def test_what_the_dead_zone_leaves_is_said(tuning):
    text = tuning_text(tuning)
    assert "Dead zone: commands up to 0.16, 0.16, 0.16 give no thrust" in text
    assert "Dead zone" not in tuning_text(tune(mallard("AF"), 0.8, draws=1))
