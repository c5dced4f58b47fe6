# SPDX-License-Identifier: MIT
"""Plots with Matplotlib: what is drawn are the model's, scores' and recording's own numbers, with titles and legends."""

import subprocess
import sys
import warnings
from dataclasses import replace

import matplotlib as mpl
import msgspec
import numpy as np
import pytest
import steered_boat
from conftest import TABLE_II, all_values, make_model
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from survey_boat import TRUTH, boat, driven

import seatrial
from seatrial.boat.vehicle import vehicle_from
from seatrial.display.canvas import literal, symbol
from seatrial.evaluation.scores import load_scores, scores_json
from seatrial.util.errors import SeatrialError


@pytest.fixture(scope="module")
def model(paper_mp_model):
    return paper_mp_model


@pytest.fixture(scope="module")
def scores(model, paper_mp):
    return seatrial.validate(model, [paper_mp[name].recording for name in ("S4", "S7")])


@pytest.fixture(scope="module")
def recording(paper_mp):
    return paper_mp["S7"].recording


def drawn(figure: Figure) -> Figure:
    """Rendered without a warning; every plot has titles, a legend and something in it."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        figure.draw_without_rendering()
    legends = [*figure.legends, *(axes.get_legend() for axes in figure.axes if axes.get_legend())]
    explained = {text.get_text() for legend in legends for text in legend.get_texts()}
    for axes in figure.axes:
        shared = axes.get_shared_x_axes().get_siblings(axes)
        assert any(one.get_xlabel() for one in shared), axes
        assert axes.get_ylabel() or axes.get_yticklabels(), axes
        labels = axes.get_legend_handles_labels()[1]
        assert labels and set(labels) <= explained, axes
        lines = [np.asarray(line.get_ydata(), dtype=float) for line in axes.lines]
        assert any(np.isfinite(y).any() for y in lines), axes.get_title()
    return figure


def line(axes, label):
    (found,) = (one for one in axes.lines if one.get_label() == label)
    return np.column_stack([found.get_xdata(), found.get_ydata()])


def titled(figure, title):
    (found,) = (
        axes for axes in figure.axes if title in (axes.get_title("left"), axes.get_ylabel())
    )
    return found


def test_a_model_shows_its_relative_intervals(model):
    axes = titled(drawn(model.plot()), "Parameters")
    labels = [tick.get_text() for tick in axes.get_yticklabels()]
    names = [name for name in model.parameters if model.standard_errors[name] > 0]
    assert [label.partition(" = ")[0] for label in labels] == [symbol(name) for name in names]
    values = all_values(model)
    shown = {}
    for group in ("surge", "sway", "yaw", "thrusters"):
        for share, place in line(axes, group):
            shown[names[-round(place)]] = share, group
    for name in names:
        expected = 100 * 1.959964 * model.standard_errors[name] / abs(values[name])
        assert shown[name][0] == pytest.approx(np.clip(expected, 0.1, 1000.0)), name
    assert [shown[name][1] for name in ("X_u", "Y_v", "N_r", "lag")] == [
        "surge",
        "sway",
        "yaw",
        "thrusters",
    ]
    assert axes.get_xscale() == "log"


def test_a_model_shows_its_thrust_curve_with_the_dead_zone_and_the_lag(model):
    figure = model.plot()
    (curve,) = titled(figure, "Thrust curve").lines
    x, y = curve.get_xdata(), curve.get_ydata()
    edge = dict(zip(model.vehicle.constants.names, model.constants, strict=True))["edge_forward"]
    np.testing.assert_allclose(y[np.abs(x) < 0.9 * edge], 0.0, atol=1e-12)
    assert y[-1] == pytest.approx(1.0)
    bands = titled(figure, "Thrust curve").collections
    assert len(bands) == 1
    response = next(iter(titled(figure, "Step response").lines))
    lag = dict(zip(model.vehicle.constants.names, model.constants, strict=True))["lag"]
    t, force = response.get_xdata(), response.get_ydata()
    risen = t[np.searchsorted(force, 1 - np.exp(-1.0))]
    assert risen == pytest.approx(lag + model.constants[0], abs=0.05)


def test_a_model_that_is_given_has_no_empty_plot_of_intervals(mp):
    given = make_model(mp, TABLE_II["MP"])
    given = replace(given, covariance=np.zeros_like(given.covariance))
    figure = drawn(given.plot())
    assert [axes.get_title("left") for axes in figure.axes] == ["Thrust curve", "Step response"]


def test_an_angle_has_an_axis_of_its_own_in_degrees():
    figure = drawn(steered_boat.known().plot())
    assert [line.get_label() for line in titled(figure, "Thrust curve").lines] == ["motor"]
    axes = titled(figure, "Angle")
    (helm,) = axes.lines
    assert axes.get_ylabel() == "angle [deg]" and helm.get_label() == "helm"
    assert helm.get_ydata()[[0, 120, -1]] == pytest.approx([-39.0, -4.0, 31.0])
    assert {line.get_label() for line in titled(figure, "Step response").lines} >= {"motor", "helm"}


def test_a_boat_without_sway_thrust_has_no_empty_axes():
    vehicle, run = driven({}, [lambda rng: rng.uniform(-1, 1)] * 2, seconds=60.0)
    given = make_model(boat([{"latency": 0.05, "lag": 0.1}]), TRUTH)
    drawn(given.plot())
    figure = drawn(run.plot())
    still = replace(run, eta=run.eta * [1.0, 0.0, 0.0])  # straight ahead: no sway and no yaw
    titles = [axes.get_title("left") for axes in drawn(still.plot()).axes]
    assert "surge velocity" in titles
    assert not {"sway velocity", "yaw velocity"} & set(titles)
    assert len(figure.axes) > len(titles)
    assert vehicle.inputs == run.commands.names


def test_scores_show_error_floor_and_constant_velocity_over_the_horizon(scores):
    figure = drawn(scores.plot())
    assert [axes.get_title("left") for axes in figure.axes] == ["surge", "sway", "yaw"]
    pooled = [one for one in scores.pooled if one.start == "filter"]
    for axes, name, scale in zip(figure.axes, "uvr", (100.0, 100.0, 1.0), strict=True):
        for label, key in (
            ("constant velocity", "stays_constant"),
            ("noise floor", "floor"),
            ("expected error", "expected_rms"),
        ):
            shown = line(axes, label)
            np.testing.assert_allclose(shown[:, 0], [one.horizon for one in pooled])
            np.testing.assert_allclose(
                shown[:, 1], [scale * getattr(one.scores[name], key) for one in pooled]
            )
        (bars,) = axes.containers
        np.testing.assert_allclose(
            bars[0].get_ydata(), [scale * one.scores[name].rms for one in pooled]
        )
        (whiskers,) = bars[2]
        for segment, one in zip(whiskers.get_segments(), pooled, strict=True):
            low, high = one.scores[name].rms_interval or (one.scores[name].rms,) * 2
            np.testing.assert_allclose(np.sort(segment[:, 1]), [scale * low, scale * high])
        each = [one for one in axes.lines if to_hex(one.get_color()) == "#56b4e9"]
        assert len(each) == 2
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == [
        "each recording", "constant velocity", "expected error", "noise floor", "model (95 % interval)",
    ]  # fmt: skip


def test_scores_of_one_recording_and_of_an_older_file_are_drawn(scores, tmp_path):
    one = msgspec.structs.replace(scores, recordings=scores.recordings[:1])
    assert "S4" in drawn(one.plot()).get_suptitle()
    row = msgspec.structs.replace(scores.recordings[0], horizons=[])
    old = msgspec.structs.replace(scores, recordings=[row], pooled=[])
    (shown,) = line(drawn(old.plot()).axes[0], "constant velocity")
    assert shown[0] == scores.horizon
    path = tmp_path / "scores.json"
    path.write_bytes(msgspec.json.encode(scores_json(scores)))
    assert len(drawn(load_scores(path).plot()).axes) == 3


def test_an_axis_that_never_moves_has_no_plot_and_no_score_at_all_is_one_line(scores):
    def still(part):
        own = msgspec.structs.replace(part.scores["v"], rms=0.0, stays_constant=0.0, ratio=np.inf)
        return msgspec.structs.replace(part, scores={**part.scores, "v": own})

    rows = [
        msgspec.structs.replace(still(row), horizons=[still(h) for h in row.horizons])
        for row in scores.recordings
    ]
    found = msgspec.structs.replace(
        scores, recordings=rows, pooled=[still(one) for one in scores.pooled]
    )
    assert [axes.get_title("left") for axes in drawn(found.plot()).axes] == ["surge", "yaw"]
    with pytest.raises(SeatrialError, match="no scores to plot; validate it with a recording"):
        msgspec.structs.replace(scores, recordings=[], pooled=[]).plot()


def test_a_recording_shows_track_velocities_and_commands(recording):
    figure = drawn(recording.plot())
    track = line(titled(figure, "y [m]"), "track")
    usable = recording.eta[recording.valid, :2]
    np.testing.assert_array_equal(track[np.isfinite(track[:, 0])], usable)
    moved = seatrial.motion(recording)
    for i, name in enumerate(("surge", "sway", "yaw")):
        shown = line(titled(figure, f"{name} velocity"), "five-point stencil")
        np.testing.assert_array_equal(shown[:, 1], moved.nu[:, i])
    commands = titled(figure, "commands\n[command units]")
    for i, name in enumerate(recording.commands.names):
        shown = line(commands, symbol(name))
        np.testing.assert_array_equal(shown[:, 1], recording.commands.values[:, i])
        np.testing.assert_array_equal(shown[:, 0], recording.seconds(recording.commands.stamps))
    assert next(one for one in commands.lines).get_drawstyle() == "steps-post"


def test_what_is_left_out_is_marked(recording, cse1):
    excluded = recording.without(20.0, 40.0)
    figure = drawn(excluded.plot())
    legends = [axes.get_legend() for axes in figure.axes if axes.get_legend()]
    texts = [text.get_text() for legend in legends for text in legend.get_texts()]
    assert "excluded" in texts
    count = int((~excluded.valid).sum())
    assert f"left out ({count} poses)" in texts
    ship = drawn(cse1["run1"].cut(0.0, 60.0).plot())
    assert titled(ship, "scales") is not None


def test_a_recording_too_short_for_velocities_has_no_empty_axes(recording):
    short = recording.cut(0.0, 4.2 * recording.period)
    assert len(short.t) in (4, 5)
    few = replace(short, valid=np.arange(len(short.t)) < 3)
    assert [axes.get_ylabel() for axes in drawn(few.plot()).axes] == [
        "y [m]",
        "commands\n[command units]",
    ]


@pytest.mark.parametrize("of", ["model", "scores", "recording"])
def test_plots_are_drawn_on_a_given_figure(of, request):
    given = Figure(figsize=(9, 6))
    assert request.getfixturevalue(of).plot(given) is given
    assert given.get_size_inches().tolist() == [9.0, 6.0]
    drawn(given)
    parts = Figure(figsize=(24, 8), layout="constrained").subfigures(1, 2)
    assert request.getfixturevalue(of).plot(parts[0]) is parts[0]
    parts[0].figure.draw_without_rendering()


@pytest.mark.parametrize("of", ["model", "scores", "recording"])
def test_a_notebook_shows_the_figure_as_a_picture_once(of, request):
    figure = request.getfixturevalue(of).plot()
    assert figure._repr_png_().startswith(b"\x89PNG\r\n\x1a\n")
    from matplotlib import pyplot as plt

    assert plt.get_fignums() == []  # pyplot would show it a second time


def test_names_from_files_are_no_mathematics(recording, scores, model):
    hostile = r"$\frac{" + "\n\x1b]0;x\x07_%{}^&#$$"
    figure = replace(recording, name=hostile).plot()
    assert "\n" not in figure.get_suptitle()
    drawn(figure)
    rows = [msgspec.structs.replace(scores.recordings[0], recording=hostile)]
    drawn(msgspec.structs.replace(scores, model=hostile, recordings=rows).plot())
    content = model.vehicle.to_mapping() | {"name": "$\\sqrt{"}
    drawn(replace(model, vehicle=vehicle_from(content, "v")).plot())


def test_text_keeps_its_letters():
    axes = Figure().subplots()
    for text in ("plain", "a$b", "$x$", r"a\$b", "50 %"):
        shown = axes.text(0, 0, literal(text))
        parsed, math = shown._preprocess_math(shown.get_text())
        assert (parsed, math) == (text, False)
    axes.plot([0, 1], label=literal("_hidden"))
    assert [text.get_text() for text in axes.legend().get_texts()] == [" _hidden"]
    assert len(literal("x" * 500)) <= 33
    assert symbol("X_uu") == "$X_{uu}$"
    assert symbol("lag.bow") == "lag.bow"
    assert mpl.rcParams["text.usetex"] is False


@pytest.mark.parametrize("of", ["model", "scores", "recording"])
def test_without_matplotlib_there_is_one_line_with_what_to_install(of, request, monkeypatch):
    thing = request.getfixturevalue(of)
    monkeypatch.delitem(sys.modules, "seatrial.display.shown_figure", raising=False)
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(
        SeatrialError, match=r"plots need Matplotlib 3.7 or later: pip install 'seatrial\[plot\]'"
    ):
        thing.plot()


def test_matplotlib_is_not_loaded_before_a_plot():
    code = (
        "import sys, seatrial; from seatrial.simulation.plan import load_plan; v = seatrial.load_vehicle('mallard-mp'); "
        "r = next(iter(seatrial.simulate(load_plan('clean'), v))).recording.cut(0, 5); r._repr_html_(); "
        "assert not {'matplotlib', 'pandas', 'plotly'} & set(sys.modules); r.plot(); assert 'matplotlib' in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
