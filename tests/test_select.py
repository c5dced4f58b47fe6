# SPDX-License-Identifier: MIT
"""Selection: exact aliases, tests of terms, repeats, held-out prediction, the command."""

import pickle
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from cli_tools import documented, done, refused
from scipy import stats

import seatrial
from seatrial import _core
from seatrial.identification.estimator import OutputErrorSettings, fit, output_error
from seatrial.identification.likelihood.optimiser import Outcome, full_pass
from seatrial.identification.selection.score_information import (
    ScoreInformation,
    score_information_of,
)
from seatrial.identification.selection.significance import estimate, repeats
from seatrial.identification.selection.terms import (
    default_candidates,
    given_candidates,
    select,
    selection_text,
)
from seatrial.identification.selection.terms import term_fit as term_fit_module
from seatrial.identification.selection.terms.block_prediction import BlockPrediction
from seatrial.identification.selection.terms.decisions import (
    TermTests,
    TermVerdict,
)
from seatrial.identification.selection.terms.held_out import (
    HeldOut,
    folds,
    retrained,
)
from seatrial.identification.selection.terms.stepwise import (
    TermSearch,
    candidate_information,
    predicted,
)
from seatrial.identification.selection.terms.term_fit import term_fit
from seatrial.io.trial_files import write_setting, write_trial
from seatrial.simulation.trials import plant_model, simulate
from seatrial.util.errors import IdentificationError, SeatrialError
from seatrial.util.parallel import Farm, working_on
from tests.boats.plans import planned

SIX = ("S1", "S2", "S3", "S4", "S5", "S6")
COUPLED = {"Y_r": 0.02}  # [m/s / rad] a term that the bundled structure lacks
TRIED = (
    "Y_r * r",
    "X_v * v",
    "N_v * v",
    "N_Fu * F_u",
    "Y_Fu * F_u",
    "X_Fv * F_v",
    "N_0",
    "Y_u * u",
)


def trials(vehicle, seed, names=SIX, extra=None):
    """Recordings of a boat that has `extra` terms besides its vehicle's."""
    plan = planned("paper-like", *names, seconds=60.0, seed=seed, coefficients=extra)
    more = [t for t in given_candidates(vehicle, TRIED) if t.coefficient in (extra or {})]
    driven = vehicle.with_terms((*vehicle.structure.terms, *more))
    return [t.recording for t in simulate(plan, driven, plant_model(plan, driven))]


@pytest.fixture(scope="module")
def six():
    return trials(seatrial.load_vehicle("mallard-mp"), 1)


@pytest.fixture(scope="module")
def solved(six):
    """The solution that a selection begins with."""
    return term_fit(fit(six, seatrial.load_vehicle("mallard-mp")))


@pytest.fixture(scope="module")
def fitted(six):
    return output_error(six, seatrial.load_vehicle("mallard-mp"))


def test_a_slow_search_for_other_terms_is_near_enough_and_one_far_off_is_refused(
    solved, monkeypatch
):
    """Under model mismatch a search may be out of steps: the selection goes on from there."""
    fewer = [t for t in solved.terms if t.coefficient != "N_uu"]
    slow = partial(term_fit_module.search, passes=1)
    monkeypatch.setattr(term_fit_module, "search", slow)
    near = solved.refitted(fewer)
    assert slow(near.problem, near.at.theta, near.at.noise)[1] is Outcome.OUT_OF_STEPS
    assert not near.settled
    exact = replace(solved, at=replace(solved.at, noise=0.01 * solved.at.noise))
    with pytest.raises(IdentificationError, match="no solution: the search does not converge; "):
        exact.refitted(fewer)


@pytest.fixture(scope="module")
def coupled():
    """What is selected from a boat with Y_r, of which the vehicle file knows nothing."""
    vehicle = seatrial.load_vehicle("mallard-mp")
    records = trials(vehicle, 3, extra=COUPLED)
    return select(records, vehicle, candidates=given_candidates(vehicle, TRIED))


def named(vehicle, *texts):
    return given_candidates(vehicle, texts)


def test_recordings_of_a_kind_are_repeats_and_parts_where_there_is_none(six, mp):
    found = folds(mp, six)
    assert [[r.name for r in f.recordings] for f in found] == [
        ["S1-MP", "S2-MP", "S3-MP"], ["S4-MP", "S5-MP", "S6-MP"],
    ]  # fmt: skip
    first, second = folds(mp, six[:4])
    assert [len(first.recordings), len(second.recordings)] == [4, 4]
    assert first.recordings[0].duration == pytest.approx(six[0].duration / 2, abs=0.2)
    assert second.recordings[0].offset == pytest.approx(six[0].duration / 2, abs=0.2)


def test_what_the_score_says_of_a_term_is_what_a_refit_finds(six, solved, fitted, mp):
    """One Gauss-Newton step without refit, against the likelihood's maximum with the term."""
    term = named(mp, "N_v * v")[0]
    step = estimate(score_information_of(solved.at, [term]), "N_v")
    refit = output_error(six, mp.with_terms((*mp.structure.terms, term)), start=fitted)
    assert step.value == pytest.approx(refit.values["N_v"], abs=0.3 * refit.standard_errors["N_v"])
    assert 0.7 < step.error / refit.standard_errors["N_v"] < 1.6
    assert step.z == pytest.approx(step.value / step.error)


def test_more_candidates_than_the_core_has_room_for_are_tested_all_the_same(solved, mp):
    tried = default_candidates(mp)
    room = min(_core.MAX_TERMS - 13, 40 - 11) - 3
    assert len(tried) > room
    found = {
        t.coefficient: estimate(s, t.coefficient) for t, s in candidate_information(solved, tried)
    }
    assert set(found) == {t.coefficient for t in tried}
    for term in (tried[0], tried[-1]):
        alone = estimate(score_information_of(solved.at, [term]), term.coefficient)
        assert found[term.coefficient].value == pytest.approx(alone.value, rel=1e-6)
        assert found[term.coefficient].error == pytest.approx(alone.error, rel=1e-6)


def test_one_step_from_the_joint_fit_is_a_refit_of_each_repeat(six, solved, fitted, mp):
    """Without common parameters the fold's step is a fit of the fold alone."""
    parts = [[0, 1, 2], [3, 4, 5]]
    look = score_information_of(solved.at)
    found = repeats(look, "Y_v", parts)
    whole = fitted.standard_errors["Y_v"]
    weights = found.errors**-2.0
    mean = float(weights @ found.values / weights.sum())
    assert mean == pytest.approx(fitted.values["Y_v"], abs=0.5 * whole)  # joint: between the two
    for values, records in zip(found.values, (six[:3], six[3:]), strict=True):
        alone = output_error(records, mp, start=fitted, settings=OutputErrorSettings(block=5.0))
        assert values == pytest.approx(alone.values["Y_v"], abs=2.0 * alone.standard_errors["Y_v"])
    assert found.ratio**2 == pytest.approx(stats.chi2.isf(found.p, 1), rel=1e-6)


def test_a_step_goes_no_further_than_the_search_would(solved):
    """A short lag is hardly told from a latency: the linearisation would trade one for a second of the other."""
    look, problem = score_information_of(solved.at), solved.at.runs.problem
    low, high = (np.abs(bound - look.values) for bound in look.bounds)
    assert (low <= problem.step_limits).all() and (high <= problem.step_limits).all()
    assert np.isfinite(problem.step_limits[look.place("latency")])


def test_a_step_that_leads_out_of_bounds_ends_there(six, solved):
    """A recording left out may take with it what an edge of the dead zone is known from."""
    look = score_information_of(solved.at)
    edge = look.place("edge_forward")
    far = replace(look, gradient=look.gradient - 1e7 * (np.arange(len(look.names)) == edge))
    assert retrained(replace(far, bounds=(-np.inf, np.inf)), range(6), None)[edge] < 0.0
    found = retrained(far, range(6), None)
    assert found[edge] == 0.0
    # the others follow, as if it had been held there
    kept = ~(np.isclose(found, far.bounds[0]) | np.isclose(found, far.bounds[1]))
    assert kept.sum() > 10
    gradient = far.gradient.sum(axis=0) - far.information @ (found - far.values)
    scale = np.sqrt(np.diag(far.information))
    np.testing.assert_allclose(gradient[kept] / scale[kept], 0.0, atol=1e-6)
    halves = HeldOut(solved.model(), far, [[0, 1, 2], [3, 4, 5]], six, 1.0)
    assert np.isfinite(halves.without({"N_uu": 2})["N_uu"].percent)


def test_prediction_of_a_fold_gets_worse_without_a_term_that_matters(six, solved):
    parts = [[0, 1, 2], [3, 4, 5]]
    held = HeldOut(solved.model(), score_information_of(solved.at), parts, six, 1.0)
    drag, weak = held.without({"N_r": 2, "N_ud": 2}).values()
    assert drag.percent > 20
    assert drag.z > 2
    assert abs(weak.percent) < 1
    assert weak.moves < 1
    assert drag.moves > 20


class Elsewhere(Farm):
    """All travels as bytes, as to other computers, and the last item ends first."""

    def __init__(self):
        self.done = []

    def outcomes(self, work, common, items):
        for place in reversed(range(len(items))):
            does, shared, item = pickle.loads(pickle.dumps((work, common, items[place])))
            self.done.append(work)
            yield place, pickle.loads(pickle.dumps(does(shared, item)))


def blocks_of(fit):
    return partial(BlockPrediction.of, fit.model(), fit.problem, 1.0)


def test_tests_of_terms_are_the_same_to_the_bit_wherever_they_are_computed(six, solved, mp):
    search = TermSearch(mp, (tuple(named(mp, *TRIED)),), 1.0)

    def found():
        tests = TermTests(search, solved, folds(mp, six))
        evidence = {**tests.kept, **tests.others(search.candidates)}
        looked = dict(candidate_information(solved, search.candidates))
        gains = predicted(solved, looked, blocks_of(solved))
        return [
            (n, e.estimate, e.change, e.repeats.values.tolist(), e.repeats.p) for n, e in evidence.items()
        ], [(t, gain, ratio.tolist()) for t, (gain, ratio) in gains.items()]  # fmt: skip

    with working_on(farm := Elsewhere()):
        there = found()
    assert there == found()
    assert len(there[1]) == len(TRIED)
    # passes of candidates twice; predictions of kept terms, of others, of blocks before and with each
    assert len(farm.done) == 2 + len(there[0]) + 1 + len(TRIED)


def test_predictions_of_blocks_pass_over_seconds_without_a_usable_pose(solved, mp):
    """A gap of half a minute leaves whole blocks empty: they are in no fold."""
    first, *others = solved.problem.recordings
    there = first.valid & ((first.t < 12.0) | (first.t > 47.0))
    problem = replace(solved.problem, recordings=(replace(first, valid=there), *others))
    fitted = replace(solved, at=full_pass(problem, solved.at.theta, solved.at.noise))
    looked = dict(candidate_information(fitted, named(mp, "Y_r * r")))
    ((gain, ratio),) = predicted(fitted, looked, blocks_of(fitted)).values()
    assert gain.log == pytest.approx(0.0, abs=1e-3)  # the boat has no such term
    assert ratio == pytest.approx(np.ones(3), abs=1e-2)


def test_a_true_term_comes_in_absent_ones_stay_out_and_n_ud_is_called_weak(coupled):
    rows = {row.coefficient: row for row in coupled.rows}
    assert rows["Y_r"].verdict is TermVerdict.COMES
    assert coupled.model.values["Y_r"] == pytest.approx(COUPLED["Y_r"], rel=0.05)
    assert [n for n, r in rows.items() if r.verdict is TermVerdict.COMES] == ["Y_r"]
    assert not [n for n, r in rows.items() if r.verdict is TermVerdict.GOES]
    assert rows["N_ud"].verdict is TermVerdict.STAYS
    assert rows["N_ud"].reason.startswith("weak")
    assert [n for n, r in rows.items() if r.reason.startswith("weak")] == ["N_ud"]
    shown = selection_text(coupled)
    assert "Added: Y_r. Removed: none. Weak: N_ud. Aliased: none." in shown
    assert "v_dot = - u r + Y_v v" in shown.replace("= -u", "= - u")


@pytest.mark.system
def test_a_term_that_changes_sign_between_repeats_goes(mp):
    records = trials(mp, 5, names=SIX[:3], extra={"Y_r": 0.02})
    records += trials(mp, 5, names=SIX[3:], extra={"Y_r": -0.012})
    found = select(records, mp, candidates=named(mp, "Y_r * r"))
    row = next(r for r in found.rows if r.coefficient == "Y_r")
    assert row.verdict is TermVerdict.OUT
    assert row.reason.startswith("not repeatable: S1-MP, S2-MP, S3-MP: 0.01")
    values, errors = row.evidence.repeats.values, row.evidence.repeats.errors
    assert values[0] > 5 * errors[0]
    assert values[1] < -5 * errors[1]
    assert "Y_r" not in found.vehicle.structure.coefficients


def test_too_little_data_for_the_terms_is_refused(six, mp):
    """20 s for each coefficient and each constant that will be sought, said before anything is fitted."""
    with pytest.raises(IdentificationError, match=r"^50 s in all.* recordings of 300 s or more"):
        select([r.cut(0, 15) for r in six[:3]], mp)
    with pytest.raises(
        IdentificationError, match=r"^2[45]0 s in all.* recordings of 300 s or more"
    ):
        select([r.cut(0, 40) for r in six], mp)


def test_the_command_writes_a_vehicle_that_identifies(tmp_path, capsys, mp):
    plan = planned("paper-like", *SIX, seconds=60.0)
    write_setting(plan, mp, plant_model(plan, mp), tmp_path)
    records = [str(write_trial(t, tmp_path)) for t in simulate(plan, mp)]
    vehicle, out, scores = tmp_path / "vehicle-MP.yaml", tmp_path / "new.yaml", tmp_path / "s.json"
    common = ["select", *records, "--vehicle", str(vehicle)]
    terms = ("--candidates", "Y_r * r", "N_v * v")
    shown = done(capsys, *common, *terms, "-o", out, "--json", scores)
    assert "stays: weak: distinguishable from zero" in shown
    content = documented("select", scores)
    assert {t["coefficient"]: t["kept"] for t in content["terms"]}["Y_r"] is False
    assert content["structure"] == seatrial.load_vehicle(str(out)).structure.lines()
    assert seatrial.load_vehicle(str(out)).structure.coefficients == mp.structure.coefficients
    for odd, said in (
        (["--candidates", "Y_r * q"], "factor 'q'"),
        (["-o", str(vehicle)], "is an input"),
    ):
        assert said in refused(capsys, *common, *odd)


def test_a_recording_given_twice_is_refused(six, mp):
    with pytest.raises(SeatrialError, match="same name"):
        select([six[0], six[0]], mp)


def test_a_strong_term_that_acts_in_few_blocks_does_not_hide_itself():
    """All that 20 blocks know of it is in two; at zero, their scores are all of the scatter."""
    rng = np.random.default_rng(4)
    strength = np.where(np.arange(20) % 10 == 3, 1e4, 1.0)
    shares = strength[:, None, None] * np.eye(1)
    scores = shares[:, :, 0] * 0.3 + np.sqrt(strength)[:, None] * rng.normal(size=(20, 1))
    total = shares.sum(axis=0)[None]
    limits = (np.full(1, -np.inf), np.full(1, np.inf))
    gradient, recording = scores.sum(axis=0)[None], np.zeros(20, int)
    whole = ScoreInformation(
        ("N_uv",), np.zeros(1), limits, total, gradient, scores, shares, recording
    )
    found = estimate(whole, "N_uv")
    assert found.value == pytest.approx(0.3, abs=0.03)
    assert found.error < 0.015 and found.p < 1e-6


def test_blocks_share_the_information_of_their_recording(mp, paper_mp):
    recordings = [paper_mp[name].recording for name in ("S1", "S3")]
    look = score_information_of(term_fit(fit(recordings, mp)).at)
    for i in range(2):
        own = look.shares[look.recording == i].sum(axis=0)
        np.testing.assert_allclose(own, look.of_recordings[i], rtol=1e-9, atol=1e-9 * own.max())
    np.testing.assert_allclose(look.shares, look.shares.swapaxes(1, 2))
    assert (np.linalg.eigvalsh(look.shares)[:, -1] > 0).all()
