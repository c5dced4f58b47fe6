# SPDX-License-Identifier: MIT
"""The report's content: every number is the model's or validate()'s."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
import yaml
from conftest import TABLE_II, make_model
from html_tables import Tables

import seatrial
from seatrial.boat.schema import NoiseEntry, ProcessEntry
from seatrial.evaluation.assessment import assess
from seatrial.evaluation.filtering import filter_noise, run_filter
from seatrial.evaluation.prediction import Lookahead
from seatrial.evaluation.reference import smoothed_motion
from seatrial.evaluation.validation import validate
from seatrial.identification.uncertainty.identifiability import identifiability
from seatrial.recording.excitation import excitation
from seatrial.report import report
from seatrial.report.evidence.advice import advice
from seatrial.report.evidence.model_evidence import collect
from seatrial.report.evidence.runs import PLOT_WINDOW, busy_window, gather, time_base
from seatrial.report.evidence.verdict import verdict
from seatrial.report.figures.embed import decode
from seatrial.report.figures.errors import correlation, histogram
from seatrial.report.model_report import write_evidence
from seatrial.report.text.markup import number
from seatrial.report.text.numbers import ratio_word
from seatrial.util.statistics import NORMAL_95

SCORE_FIELDS = ("rms", "stays_constant", "ratio", "floor", "expected_rms", "excess", "bias", "kurtosis")  # fmt: skip


def shown(text: str) -> float:
    """A displayed number read back."""
    plain, _, power = text.replace("−", "-").partition("·10")
    digits = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
    return float(plain) * 10.0 ** int(power.translate(digits) or 0)


@pytest.fixture(scope="module")
def model(cse1_paper_model):
    return cse1_paper_model


@pytest.fixture(scope="module")
def evidence(model, cse1):
    return collect(model, list(cse1.values()), 1.0)


@pytest.fixture(scope="module")
def text(evidence, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "report.html"
    write_evidence(evidence, path)
    return path.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def tables(text):
    return Tables(text).found


@pytest.fixture(scope="module")
def runs(evidence):
    return evidence.runs


def boat(af, **changed):
    """Table II's, some coefficients changed, at a step that models are identified with."""
    return make_model(af, TABLE_II["AF"] | changed, step=1 / 30)


@pytest.fixture(scope="module")
def mallard(af):
    return boat(af)


@pytest.fixture(scope="module")
def backwards(af, surge):
    """Of a model whose surge thrust has the wrong sign."""
    return collect(boat(af, X_F=-0.14), [surge], 1.0)


@pytest.fixture(scope="module")
def surge(clean_af) -> seatrial.Recording:
    """A minute in which little but surge is driven."""
    return clean_af["S4"].recording.cut(0.0, 60.0)


def packed(text: str, place: int) -> dict:
    found = re.search(rf'id="run-{place}">(.*?)</script>', text, re.DOTALL)
    return json.loads(found[1])


def test_scores_are_those_of_validate(tables, model, cse1):
    expected = validate(model, list(cse1.values())).recordings
    (rows,) = tables["scores"]
    assert [row[0][0] for row in rows[1:] if len(row) == 1] == [
        r.recording + (" (seen)" if "random" in r.recording else "") for r in expected
    ]
    axes = [row for row in rows[1:] if len(row) > 1]
    assert len(axes) == 3 * len(expected)
    for row, (score, name) in zip(
        axes, ((r.scores[s], s) for r in expected for s in "uvr"), strict=True
    ):
        assert row[0][0].split()[1] == name
        scale = 1.0 if name == "r" else 100.0
        assert row[2][0] == ("rad/s" if name == "r" else "cm/s")
        cells = [row[1], *row[3:10]]
        for (told, values), field in zip(cells, SCORE_FIELDS, strict=True):
            exact = getattr(score, field)
            assert values == ([] if exact is None else [exact])
            if exact is None:  # a model without process noise has no expected RMS
                assert field == "expected_rms"
                continue
            factor = 1.0 if field in ("ratio", "kurtosis") else scale
            assert shown(told) == pytest.approx(
                exact * factor, rel=0.05 if field == "bias" else 5e-3
            )
        assert tuple(row[10][1]) == score.rms_interval
        assert tuple(row[11][1]) == score.ratio_interval


def test_the_expected_rms_is_in_table_and_verdict(model, cse1):
    runs = [cse1["random_run1"].cut(0.0, 120.0)]
    pushed = ProcessEntry(0.0, 0.0, 0.05, 0.05, 2.0)
    sure = replace(model, noise=NoiseEntry(7e-5, 3e-4, pushed))
    text = report(sure, runs)
    (rows,) = Tables(text).found["scores"]
    score = validate(sure, runs).recordings[0].scores
    assert rows[0][6][0] == "expected"
    for row, symbol in zip((r for r in rows[1:] if len(r) > 1), "uvr", strict=True):
        assert row[6][1] == [score[symbol].expected_rms]
        assert score[symbol].expected_rms > score[symbol].floor
    said = ", ".join(f"{score[s].rms / score[s].expected_rms:.2f}" for s in "uv")
    assert f"Error over expected RMS: {said} and " in text


def test_coefficients_are_the_models_and_those_of_its_file(tables, model, tmp_path):
    path = tmp_path / "model.yaml"
    seatrial.save(model, path)
    in_file = yaml.safe_load(path.read_text())["coefficients"]
    (rows,) = tables["coefficients"]
    assert "forward-right-down" in rows[0][6][0]
    for row, (name, value) in zip(rows[1:], model.values.items(), strict=True):
        error = model.standard_errors[name]
        assert row[0][0] == name.replace("_", "")
        assert row[1][1] == [value]
        assert shown(row[1][0]) == pytest.approx(value, rel=5e-4)
        assert row[2][1] == [error]
        assert row[3][1] == [value - NORMAL_95 * error, value + NORMAL_95 * error]
        assert row[4][0] == model.structure.units[name].replace("^", "")
        assert row[5][0].startswith("not distinguishable from zero") == (abs(value) < 2 * error)
        assert row[5][0].partition(",")[0] == identifiability(model)[name].verdict.value
        assert row[6][1] == [pytest.approx(in_file[name]["value"])]


def test_steps_are_the_estimators(tables, model):
    (rows,) = tables["steps"]
    for row, step in zip(rows[1:], model.estimator.steps, strict=True):
        assert row[0][0] == step.equation
        assert row[2][0] == ", ".join(step.recordings)
        assert int(row[3][0]) == step.rows
        assert row[4][1] == [step.condition]
        assert row[5][1] == [step.explained]


def test_faults_and_excitation_are_the_recordings(tables, model, cse1):
    for recording, kinds, every, excited in zip(
        cse1.values(), tables["fault-kinds"], tables["faults"], tables["excitation"], strict=True
    ):
        assert len(every) - 1 == len(recording.faults) == sum(int(r[1][0]) for r in kinds[1:])
        first, fault = every[1], recording.faults[0]
        assert (first[0][0], first[3][0]) == (fault.kind.value, str(fault.samples))
        assert float(first[1][0]) == pytest.approx(fault.start, abs=0.005)
        assert float(first[2][0]) == pytest.approx(fault.end, abs=0.005)
        found = excitation(model.vehicle, recording)
        for axis, row in enumerate(excited[1:]):
            assert row[1][1] == [found.rms[axis]]
            assert row[2][1] == [found.largest[axis]]
            assert row[4][0] == ("yes" if found.both_signs[axis] else "no")


def test_files_and_their_hashes_are_named(tables, cse1):
    (rows,) = tables["files"]
    for row, recording in zip(rows[1:], cse1.values(), strict=True):
        (source,) = recording.sources
        use = "identified from, predicted" if "random" in recording.name else "predicted"
        assert [cell[0] for cell in row[2:]] == [use, source.name, source.sha256]


def test_plots_hold_the_measured_and_the_predicted_velocities(text, model, cse1, runs):
    noise = filter_noise(model, list(cse1.values()))  # the paper's method states none
    for place, (recording, run) in enumerate(zip(cse1.values(), runs, strict=True)):
        content = packed(text, place)
        moving = smoothed_motion(model, recording, noise)
        filtered = run_filter(model, recording, noise)
        ahead = Lookahead(model, recording, filtered=filtered, smoothed=moving).predict(1.0)
        t, row = time_base(recording)
        both = np.full((2, len(t), 3), np.nan)
        both[0, row[moving.valid]] = moving.nu[moving.valid]
        both[1, row[ahead.index]] = ahead.nu
        assert len(run.shown) < 0.8 * len(t)  # three runs are more than is drawn of them
        for axis, sign in enumerate("uvr"):
            for trace, exact in zip(
                content["figures"][f"velocity-{sign}"]["data"], both, strict=False
            ):
                x, y = (decode(content["columns"][trace[k]["column"]]) for k in "xy")
                assert np.allclose(x, t[run.shown], atol=0.006)
                largest = np.nanmax(np.abs(exact[:, axis]))
                expected = exact[run.shown, axis]
                assert np.allclose(y, expected, atol=1e-4 * largest, equal_nan=True)


def test_lines_break_at_gaps_and_jumps(cse1, runs):
    for recording, run in zip(cse1.values(), runs, strict=True):
        t, row = time_base(recording)
        assert np.array_equal(t[row], recording.t)
        assert np.all(np.diff(t) > 0)
        good = np.flatnonzero(recording.valid)
        broken = np.diff(recording.segment[good]) != 0
        assert broken.any()
        for before, after in zip(good[:-1][broken], good[1:][broken], strict=True):
            between = slice(row[before] + 1, row[after])
            assert between.stop > between.start
            for line in (run.position, run.measured, run.predicted):
                assert np.isnan(line[between]).all()


def test_histogram_counts_all_errors_under_a_normal_curve_of_their_spread(runs):
    run = runs[-1]
    for axis, scale in enumerate((100.0, 100.0, 1.0)):
        bars, curve = histogram(run, axis)["data"]
        errors = run.prediction.errors[:, axis] * scale
        inside = np.abs(errors - errors.mean()) <= 4.0 * errors.std()
        assert np.sum(bars["y"]) == pytest.approx(100.0 * inside.mean(), abs=0.05)
        width = bars["x"][1] - bars["x"][0]
        first = np.abs(errors - bars["x"][10]) < width / 2
        assert bars["y"][10] == pytest.approx(100.0 * first.mean(), abs=0.05)
        area = np.sum(curve["y"]) * (curve["x"][1] - curve["x"][0]) / width
        assert area == pytest.approx(100.0, rel=1e-3)
        mean = np.sum(curve["x"] * curve["y"]) / np.sum(curve["y"])
        spread = np.sqrt(np.sum((curve["x"] - mean) ** 2 * curve["y"]) / np.sum(curve["y"]))
        assert mean == pytest.approx(errors.mean(), abs=1e-6)
        assert spread == pytest.approx(errors.std(), rel=2e-3)


def test_autocorrelation_plot_against_numpy(mallard, surge):
    (run,) = gather(mallard, assess(mallard, [surge], 1.0))
    figure = correlation(run, 0)
    curve, area, upper, lower = figure["data"]
    errors = run.prediction.errors[:, 0]
    assert np.all(np.diff(run.prediction.index) == 1)
    centred = errors - errors.mean()
    full = np.correlate(centred, centred, "full")[len(errors) - 1 :]
    expected = full / np.arange(len(errors), 0, -1) / np.mean(centred**2)
    assert np.allclose(curve["y"], expected[: len(curve["y"])])
    assert curve["x"][-1] == pytest.approx(3.0)
    assert upper["y"][0] == -lower["y"][0] == pytest.approx(1.959964 / np.sqrt(len(errors)))
    k, n = run.prediction.steps, len(curve["y"])
    band = 1.959964 * np.sqrt((1 + 2 * np.sum(expected[1:k] ** 2)) / len(errors))
    assert area["y"][k] == pytest.approx(band)
    assert np.allclose(area["y"][:n], -area["y"][n:][::-1])
    assert figure["layout"]["shapes"][0]["x0"] == pytest.approx(1.0)


def test_window_is_the_busiest_stretch_that_can_be_predicted():
    t = np.arange(0.0, 200.0, 0.1)
    forces = np.where((t > 100) & (t < 130), 1.0, 0.1)[:, None]
    begin, end = busy_window(t, np.ones(len(t), dtype=bool), forces)
    assert end - begin == PLOT_WINDOW
    assert begin <= 100.0
    assert end >= 130.0
    begin, _ = busy_window(t, (t < 60), forces)
    assert begin < 25
    assert busy_window(t[:100], np.ones(100, dtype=bool), forces[:100]) == (0.0, t[99])


def test_verdict_is_three_sentences_about_recordings_that_were_not_seen(evidence, runs, text):
    what, ahead, following = verdict(evidence)
    assert what.startswith("cse1: 14 coefficients, identified by equation-error from 2 recordings")
    assert "17.8 min" in what  # 705.0 s + 365.2 s
    assert ahead.startswith("1 s ahead, on recordings that it has not seen (CSE1_data_run1)")
    score = next(r.score for r in runs if r.unseen).scores
    for sign, scale, name in (("u", 100, "cm/s"), ("r", 1, "rad/s")):
        assert f"{number(score[sign].rms * scale, 2)} {name}" in ahead
        assert number(score[sign].ratio, 2) in ahead
        assert f"{number(score[sign].floor * scale, 2)} {name}" in ahead
        assert ratio_word(score[sign].ratio) in ahead
    assert following.startswith("Next: ")
    assert "± covers scatter only. 0.07 mm and 0.3 mrad of pose noise are" in text


def test_without_an_unseen_recording_the_report_asks_for_one(evidence):
    assert not any("Validate on a recording" in line for line in advice(evidence))
    seen = replace(evidence, runs=tuple(r for r in evidence.runs if not r.unseen))
    assert sum("Validate on a recording" in line for line in advice(seen)) == 1


def test_poor_axes_and_one_sided_commands_get_advice(backwards, mallard, surge):
    assert any("surge prediction is worse" in line for line in advice(backwards))
    commands = replace(surge.commands, values=np.abs(surge.commands.values))
    sided = advice(collect(mallard, [replace(surge, commands=commands)], 1.0))
    assert any("surge commands have almost only one sign" in line for line in sided)
    good = advice(collect(mallard, [surge], 1.0))
    assert not any("surge prediction" in line or "only one sign" in line for line in good)


def test_a_wrong_sign_is_the_next_thing_to_do(backwards):
    following = verdict(backwards)[2]
    assert following.startswith("Next: X_F = -0.14 ± 0.014 is negative: F_u drives surge backwards")


def test_nothing_is_fetched_and_the_browser_would_refuse(text):
    assert "default-src 'none'" in text
    page = re.sub(r"<script.*?</script>", "", text, flags=re.DOTALL)
    assert "http:" not in page
    assert "https:" not in page
    assert "src=" not in page
    assert "@import" not in page
    assert "url(" not in page
    assert all(link.startswith("#") for link in re.findall(r'href="([^"]*)"', page))


def test_three_recordings_stay_below_three_megabytes(text):
    assert len(text.encode()) < 3e6
