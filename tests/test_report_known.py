# SPDX-License-Identifier: MIT
"""The report's section on what is known: verdicts before any residual, and the correlation map."""

import re
from dataclasses import replace

import numpy as np
import pytest
from conftest import in_coarse_steps

import seatrial
from seatrial.boat.schema import EnvelopeEntry
from seatrial.evaluation.assessment import assess
from seatrial.identification.uncertainty.identifiability import identifiability
from seatrial.report.evidence.advice import poor_axes
from seatrial.report.evidence.model_evidence import Evidence, collect
from seatrial.report.evidence.runs import gather
from seatrial.report.model_report import write_evidence
from seatrial.report.sections import known
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model, simulate
from tests.boats.plans import driven_by, planned


@pytest.fixture(scope="module")
def model():
    """X_u and X_uu loose and correlated by -0.99, the others sharp."""
    plant = in_coarse_steps(plant_model(load_plan("clean"), seatrial.load_vehicle("mallard-mp")))
    errors = 0.01 * np.abs(plant.coefficients)
    errors[:2] = 0.07, 0.28
    correlation = np.eye(len(errors))
    correlation[0, 1] = correlation[1, 0] = -0.99
    covariance = np.outer(errors, errors) * correlation
    size = len(plant.parameters)
    whole = np.zeros((size, size))
    whole[: len(errors), : len(errors)] = covariance
    speeds = {"u": (-0.2, 0.2), "v": (-0.2, 0.2), "r": (-1.0, 1.0)}
    forces = dict.fromkeys(("F_u", "F_v", "F_r"), (-1.0, 1.0))
    return replace(plant, covariance=whole, envelope=EnvelopeEntry(speeds, forces))


@pytest.fixture(scope="module")
def recording():
    trial = next(iter(simulate(load_plan("clean"), seatrial.load_vehicle("mallard-mp"))))
    return trial.recording.cut(0.0, 30.0)


@pytest.fixture(scope="module")
def evidence(model, recording) -> Evidence:
    return collect(model, [recording], 1.0)


def test_verdicts_stand_before_any_residual(evidence, tmp_path):
    write_evidence(evidence, tmp_path / "report.html")
    text = (tmp_path / "report.html").read_text()
    order = (
        "verdict known model actuators recorded horizons prediction errors scores physics advice"
    )
    places = [text.index(f'id="{name}"') for name in order.split()]
    assert places == sorted(places)
    assert '<a href="#known">What is known</a>' in text


def test_the_table_has_a_verdict_for_every_parameter_and_marks_the_loose_ones(evidence):
    text = known.section(evidence).html
    assert len(re.findall(r'<tr class="marked">', text)) == 1  # X_u; X_uu is known to 16 %
    for word, count in {"sharp": 9, "usable": 1, "weak": 1}.items():
        assert len(re.findall(rf"<td[^>]*>{word}</td>", text)) == count
    both = "<i>X</i><sub>u</sub> and <i>X</i><sub>uu</sub> can&#x27;t be told apart (−0.99)"
    assert f"{both}: the drag at 0.25 m/s" in text


def test_the_plot_has_the_relative_error_of_every_parameter(evidence, model):
    (figures,) = known.section(evidence).figures.values()
    figure = figures["known"]
    shown = {}
    for trace in figure["data"]:
        shown |= dict(zip(trace["y"].tolist(), trace["x"].tolist(), strict=True))
    names = model.structure.coefficients
    expected = [100 * model.standard_errors[n] / abs(model.values[n]) for n in names]
    assert [shown[-float(i)] for i in range(len(names))] == pytest.approx(expected)
    assert {t["name"]: len(t["x"]) for t in figure["data"]} == {"sharp": 9, "usable": 1, "weak": 1}


def test_the_map_has_a_shade_for_every_correlation(evidence, model):
    text = known.section(evidence).html
    n = len(model.structure.coefficients)
    shades = re.findall(r"rgba\((.*?),(\d\.\d\d)\)\"><data value=\"(.*?)\">", text)
    assert len(shades) == n * (n - 1)
    strong = [s for s in shades if float(s[1]) > 0.5]
    assert {s[0] for s in strong} == {"0,114,178"}
    assert [float(s[2]) for s in strong] == [-0.99, -0.99]


def test_of_a_given_model_it_is_said_that_nothing_is_known(evidence, model):
    given = replace(model, covariance=np.zeros_like(model.covariance))
    told = known.section(replace(evidence, model=given, known=identifiability(given)))
    assert "Nothing was estimated" in told.html
    assert not told.tables
    assert not told.figures


def test_a_boat_that_changed_is_no_reason_to_drive_more(mp, paper_mp, paper_mp_model):
    """A fifth of the thrust for the same commands, as of slower propellers."""
    same, plan = paper_mp["S7"].recording, load_plan("paper-like")
    slow = {
        n: x * (0.2 if n in ("X_F", "Y_F", "N_F") else 1.0)
        for n, x in plan.plant.coefficients.items()
    }
    (drive,) = driven_by(planned(plan, "S7", coefficients=slow), mp)
    weak = replace(drive, name="weak")
    trained = [paper_mp[name].recording for name in ("S1", "S2", "S3")]
    both = gather(paper_mp_model, assess(paper_mp_model, [same, weak, *trained], 1.0))
    for other, told in ((both[0], []), (both[1], ["weak: surge, sway and yaw predictions"])):
        found = poor_axes(paper_mp_model, [other, *both[2:]])
        assert [text.partition(" are hardly better")[0] for text in found] == told
    # without the recordings that it is from, nothing tells the two apart
    alone = poor_axes(paper_mp_model, both[1:2])
    assert len(alone) == 3 and "drive one minute more of surge pulses" in alone[0]
