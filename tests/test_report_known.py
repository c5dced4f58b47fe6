# SPDX-License-Identifier: MIT
"""The report's section on what is known: verdicts before any residual, and the correlation map."""

import re
from dataclasses import replace

import numpy as np
import pytest

import seatrial
from seatrial.plan import load_plan
from seatrial.report import known
from seatrial.report.page import page
from seatrial.report.runs import gather
from seatrial.schema import EnvelopeEntry
from seatrial.simulate import plant_model, simulate


@pytest.fixture(scope="module")
def model():
    """X_u and X_uu loose and correlated by -0.99, the others sharp."""
    plant = plant_model(load_plan("clean"), seatrial.load_vehicle("mallard-mp"))
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
def runs(model):
    trial = next(iter(simulate(load_plan("clean"), seatrial.load_vehicle("mallard-mp"))))
    return gather(model, [trial.recording.cut(0.0, 30.0)], 1.0)


def test_verdicts_stand_before_any_residual(model, runs):
    text = page(model, runs, 1.0)
    assert text.index('id="known"') < text.index('id="recorded"') < text.index('id="prediction"')
    assert '<a href="#known">What is known</a>' in text


def test_the_table_has_a_verdict_for_every_parameter_and_marks_the_loose_ones(model):
    text = known.section(model)
    assert len(re.findall(r'<tr class="marked">', text)) == 1  # X_u; X_uu is known to 16 %
    for word, count in {"sharp": 9, "usable": 1, "weak": 1}.items():
        assert text.count(f"<td>{word}</td>") == count
    assert "X_u and X_uu can&#x27;t be told apart (-0.99): the drag at 0.25 m/s" in text


def test_the_map_has_a_shade_for_every_correlation(model):
    text = known.section(model)
    n = len(model.structure.coefficients)
    shades = re.findall(r"rgba\((.*?),(\d\.\d\d)\)\"><data value=\"(.*?)\">", text)
    assert len(shades) == n * (n - 1)
    strong = [s for s in shades if float(s[1]) > 0.5]
    assert {s[0] for s in strong} == {"0,114,178"}
    assert [float(s[2]) for s in strong] == [-0.99, -0.99]


def test_a_given_model_has_no_such_section(model, runs):
    given = replace(model, covariance=np.zeros_like(model.covariance))
    assert known.section(given) == ""
    assert "#known" not in page(given, runs, 1.0)
