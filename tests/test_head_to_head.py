# SPDX-License-Identifier: MIT
"""Model and start side by side: with the truth at hand it is known what the table must say."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from test_filtering import trial, truth  # noqa: F401
from test_residuals import changed

from seatrial.boat.findings import FindingKind, of_kinds
from seatrial.evaluation.assessment import assess
from seatrial.evaluation.console import horizons_text
from seatrial.evaluation.head_to_head import CELLS, PAIRS, head_to_head, head_to_head_text
from seatrial.evaluation.scores import Scores, scores_json
from seatrial.evaluation.validation import validate
from seatrial.util.errors import ModelError


@pytest.fixture(scope="module")
def wrong(truth):  # noqa: F811
    """Half the drag in surge, and less torque."""
    return changed(truth, X_uu=-0.8, N_F=1.2)


@pytest.fixture(scope="module")
def table(truth, wrong, trial):  # noqa: F811
    known = {trial.recording.name: trial.true_motion}
    return head_to_head(truth, wrong, [trial.recording], velocities=known)


def test_the_right_model_from_its_filter_is_by_far_the_best(table):
    for duel in table.duels:
        rms = {name: duel.cells[name].rms for name in CELLS}
        assert min(rms, key=rms.get) == "model, filter"
        assert rms["model, filter"] < 0.25 * rms["model, stencil"]  # 4 mm of noise in the start
        assert duel.changes["start, under model"].significant
    by_symbol = {duel.symbol: duel for duel in table.duels}
    for symbol in "ur":  # where the other is wrong
        change = by_symbol[symbol].changes["model, from filter starts"]
        assert change.significant
        assert change.interval[1] < 0.7


def test_the_figures_are_those_of_its_cells(table):
    for duel in table.duels:
        cells = [duel.cells[name] for name in CELLS]
        for name, (over, under) in PAIRS.items():
            change, a, b = duel.changes[name], cells[over].rms, cells[under].rms
            assert change.difference == pytest.approx(a - b)
            assert change.ratio == pytest.approx(a / b)
            assert change.interval[0] <= change.ratio <= change.interval[1]
        assert cells[0].excess ** 2 + cells[0].floor ** 2 == pytest.approx(
            cells[0].rms ** 2, rel=0.3
        )


def test_a_right_models_cells_are_at_their_floors(truth, trial):  # noqa: F811
    """From the stencil and from the filter, against the stencil: floor computed, score measured."""
    duels = head_to_head(truth, truth, [trial.recording]).duels
    for duel in duels:
        for name in CELLS:
            assert duel.cells[name].rms == pytest.approx(duel.cells[name].floor, rel=0.12), name
        same = duel.changes["model, from filter starts"]
        assert (same.difference, same.ratio, same.significant) == (0.0, 1.0, False)
        assert duel.changes["start, under model"].significant
        assert duel.changes["start, under model"].ratio < 0.9


def test_every_horizon_has_its_floor_from_either_start(truth, trial):  # noqa: F811
    row = validate(truth, [trial.recording], reference="stencil").recordings[0]
    assert [(h.horizon, h.start) for h in row.horizons] == [
        (h, s) for h in (0.1, 0.2, 0.5, 1.0, 2.0, 5.0) for s in ("stencil", "filter")
    ]
    for found in row.horizons:
        for score in found.scores.values():
            chance = 4.0 / np.sqrt(2.0 * found.predictions) + 0.03  # of an RMS of so many errors
            assert score.rms == pytest.approx(score.floor, rel=chance), found
            assert score.rms_interval[0] < score.rms < score.rms_interval[1]
            assert score.ratio_interval[0] < score.ratio < score.ratio_interval[1]


def test_the_horizon_that_was_asked_for_is_among_them(truth, trial):  # noqa: F811
    recording = trial.recording.cut(0.0, 60.0)
    for reference, start, horizons in (("stencil", "stencil", 14), ("smoothed", "filter", 7)):
        row = validate(truth, [recording], 3.0, reference=reference).recordings[0]
        (own,) = [h for h in row.horizons if h.horizon == 3.0 and h.start == start]
        assert own.scores == row.scores
        assert len(row.horizons) == horizons


def test_scores_come_back_from_json(truth, wrong, trial):  # noqa: F811
    scores = validate(truth, [trial.recording], other=wrong)
    content = msgspec.json.encode(scores_json(scores))
    assert msgspec.json.decode(content, type=Scores) == scores
    assert scores.seatrial == "scores 6"
    assert "worse" in head_to_head_text(scores.against) or "better" in head_to_head_text(
        scores.against
    )


def test_a_horizon_that_a_recording_has_not_is_left_out(truth, trial):  # noqa: F811
    scores = validate(truth, [trial.recording.cut(0.0, 4.0)], reference="stencil")
    row = scores.recordings[0]
    assert {h.horizon for h in row.horizons} == {0.1, 0.2, 0.5, 1.0, 2.0}
    assert row.scores["u"].rms_interval is None  # 4 s hold three blocks
    assert "2 s     5 s" not in horizons_text(scores)
    assert "1 s     2 s" in horizons_text(scores)


def test_a_model_that_runs_away_further_on_says_so(truth, trial):  # noqa: F811
    """Surge that speeds up as its square is infinite after 1 / (2 u) seconds."""
    wild = changed(truth, X_u=0.0, X_uu=2.0)
    (found,) = assess(wild, [trial.recording.cut(0.0, 40.0)], 1.0)
    assert 0.1 <= max(horizon for horizon, _, _ in found.ahead) < 5.0
    (lost,) = of_kinds(found.findings, FindingKind.HORIZON_NOT_PREDICTED)
    assert "the model diverges" in lost.values["reason"]


def test_models_of_other_commands_are_not_compared(truth, trial, cse1_vehicle):  # noqa: F811
    from conftest import make_model

    names = cse1_vehicle.structure.coefficients
    ship = make_model(cse1_vehicle, dict.fromkeys(names, -0.1))
    with pytest.raises(ModelError, match="only models of one boat"):
        head_to_head(truth, replace(ship), [trial.recording])


def test_models_of_two_origins_are_not_compared(truth, trial):  # noqa: F811
    """The recordings are about the first one's: which is better would depend on the order."""
    there = replace(truth, vehicle=truth.vehicle.with_lever((0.3, 0.0)))
    for one, other in ((truth, there), (there, truth)):
        with pytest.raises(
            ModelError, match=r"the measured point is .* identify both with one lever"
        ):
            validate(one, [trial.recording], other=other)
