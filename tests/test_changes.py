# SPDX-License-Identifier: MIT
"""A change of the running boat: its evidence, its detection, and the model that follows it."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from changed_boats import SECONDS, drives_by_cause, findings, known_model, sent
from conftest import at_length
from scipy import stats

import seatrial
from benchmarks.studies.changes.boats import WEAK
from seatrial.boat.findings import FindingKind, finding_of
from seatrial.evaluation.comparison.cause_candidates import (
    BATTERY,
    MASS,
    NO_CHANGE,
    NONE_OF_THESE,
    OFF_CENTRE,
    ONE_THRUSTER,
)
from seatrial.monitoring.change_detector import CONFIRMATION, PASSING, ChangeDetector
from seatrial.monitoring.change_space import COUPLINGS, change_space
from seatrial.monitoring.change_test import (
    _maximum,
    fitted_changes,
    linear_evidences,
    linearised,
    log_ratio,
    mean_over_noises,
    probable_noises,
)
from seatrial.monitoring.recent_log import RecentLog
from seatrial.monitoring.running_likelihood import RunningLikelihood
from seatrial.monitoring.window_likelihood import Sums, dispersion, windows
from seatrial.onboard.boat_change import ChangeState
from seatrial.onboard.live.protocol import NANO
from seatrial.util.errors import ModelError
from tests.boats.scenes import driven, pushed, vehicle_of
from tests.boats.weather import GUSTS, SLOW_WIND, current, hand, waves

model, drives = known_model, drives_by_cause


def test_the_unchanged_boat_is_the_model(model):
    space = change_space(model)
    n = len(space.theta)
    assert {*model.parameters} < {*space.wider.parameters}
    for change in space.changes:
        np.testing.assert_array_equal(
            change.of(space.theta, np.zeros(change.unknowns)), space.theta
        )
    boat = space.boat(space.theta, np.zeros((n, n)))
    assert boat.vehicle == model.vehicle
    np.testing.assert_array_equal(boat.coefficients, model.coefficients)
    # acceleration by the widened model is the model's
    assert space.wider.values | model.values == space.wider.values
    assert {space.wider.values[name] for name in space.wider.values if name in COUPLINGS} == {0.0}
    assert [space.theta[place] for place in space.gains.values()] == [1.0] * 4


def test_a_heavier_boat_has_all_drag_and_thrust_over_one_factor(model):
    space = change_space(model)
    change = next(one for one in space.changes if one.cause == MASS)
    phi = np.array([1.0, 0.0, 0.0])
    moved = dict(zip(space.wider.parameters, change.of(space.theta, phi), strict=True))
    by_name = {name: moved[name] / value for name, value in model.values.items()}
    assert change.size(phi) == pytest.approx(1.0 / by_name["X_u"] - 1.0)
    assert by_name["X_u"] == by_name["X_F"] == by_name["X_uu"] < 1.0
    assert by_name["N_ud"] == 1.0  # of masses alone


def test_a_thruster_fails_at_most(model):
    space = change_space(model)
    change = next(one for one in space.changes if one.cause == ONE_THRUSTER)
    phi = np.array([-9.0])
    assert change.size(phi) == -1.0
    assert change.of(space.theta, phi)[space.gains[change.what]] == 0.0


def test_the_evidence_of_a_linear_change_is_the_closed_form(model, drives):
    """The window's estimate is normal about the boat's parameters, and these are about the model's."""
    space = change_space(model)
    seen = windows(model, drives[NO_CHANGE].cut(10.0, 30.0))[0].quadratic(space.wider, space.theta)
    none, free = (
        next(c for c in space.changes if c.cause == cause) for cause in (NO_CHANGE, NONE_OF_THESE)
    )

    def closed(covariance):
        values, vectors = np.linalg.eigh(seen.information)
        kept = values > 1e-12 * values.max()
        root = (vectors[:, kept] * np.sqrt(values[kept])).T
        z = root @ np.linalg.pinv(seen.information, rcond=1e-12) @ seen.gradient
        return stats.multivariate_normal(
            np.zeros(len(z)), np.eye(len(z)) + root @ covariance @ root.T
        ).logpdf(z)

    logs = [
        _maximum(space, c, seen, np.zeros(space.root.shape[1] + c.unknowns))[2]
        for c in (none, free)
    ]
    rows = free.of(np.zeros(len(space.theta)), np.zeros(free.unknowns))
    rows = np.stack([free.of(rows, e) for e in np.eye(free.unknowns)])
    known = space.wider.covariance
    exact = closed(known + rows.T @ rows) - closed(known)
    assert logs[1] - logs[0] == pytest.approx(exact, abs=0.01)
    logs = linear_evidences(space, [seen])
    linear = {one.change.cause: one.log_evidence for one in mean_over_noises(space, logs)}
    assert linear[NONE_OF_THESE] - linear[NO_CHANGE] == pytest.approx(exact, abs=0.01)


@pytest.mark.system
def test_an_unchanged_boat_is_as_probable_as_ever(model, drives):
    space, recording = change_space(model), drives[NO_CHANGE]
    for start in np.arange(0.0, SECONDS - 10.0, 20.0):
        several = windows(model, recording.cut(start, start + 10.0))
        quadratics = linearised(space, several)
        ratio = log_ratio(fitted_changes(space, several, quadratics, len(several)))
        assert ratio < 0.0
        linear = linear_evidences(space, quadratics)
        assert log_ratio(mean_over_noises(space, linear)) == pytest.approx(ratio, abs=1.0)
        # noises that are left out as improbable change nothing
        kept = np.flatnonzero(probable_noises(linear))
        assert len(kept) < len(several)
        some = [several[i] for i in kept], [quadratics[i] for i in kept]
        assert log_ratio(fitted_changes(space, *some, len(several))) == pytest.approx(
            ratio, abs=0.01
        )


@pytest.mark.parametrize("cause", [at_length(NO_CHANGE), BATTERY])
def test_running_filters_know_the_evidence_of_a_window(model, drives, cause):
    """A filter that goes on with the drive against one that runs along the window alone."""
    space, log = change_space(model), RecentLog(model.vehicle, 60.0)
    running = RunningLikelihood(model, space.wider, space.theta, 42.0)
    compared, rows = [], sent(drives[cause].cut(0.0, 60.0))
    origin = following = rows[0][0]
    for stamp, kind, values in rows:
        log.add(kind, stamp, values)
        if stamp < following:
            continue
        following += 2 * NANO
        running.advance(log, origin, stamp)
        window = running.window(stamp - 20 * NANO, 20)
        if window is not None:
            recording = log.recording(stamp - 20 * NANO, stamp)
            alone = linearised(space, windows(model, recording, window.dispersion))
            logs = [linear_evidences(space, one) for one in (window.quadratics, alone)]
            compared.append([log_ratio(mean_over_noises(space, one)) for one in logs])
    goes_on, alone = np.array(compared).T
    assert len(compared) > 15
    # its windows begin and end up to 2 s earlier
    assert np.median(np.abs(goes_on - alone)) < 1.0 + 0.15 * np.median(np.abs(alone))
    assert (np.median(alone) > 10.0) == (np.median(goes_on) > 10.0) == (cause == BATTERY)


@pytest.mark.system
@pytest.mark.parametrize(
    ("cause", "what", "size"),
    [(MASS, "mass", 0.2), (BATTERY, "thrust", -0.2), (ONE_THRUSTER, "F_2", -0.4), (OFF_CENTRE, "mass", 0.2)],
)  # fmt: skip
def test_a_change_is_noticed_and_named_and_the_model_follows_it(model, drives, cause, what, size):
    detector, recording = ChangeDetector(model), drives[cause]
    noticed, confirmed = findings(detector, sent(recording))[:2]
    assert noticed.state is ChangeState.NOTICED
    assert (noticed.stamp - recording.stamps[0]) / NANO < 40.0  # the longest window
    assert confirmed.state is ChangeState.CONFIRMED
    assert (confirmed.stamp - noticed.stamp) / NANO < PASSING + CONFIRMATION + 4.0
    assert sum(confirmed.causes.values()) == pytest.approx(1.0)
    # 5 cm aside are little beside the mass itself: either is right
    right = {MASS, OFF_CENTRE} if cause in (MASS, OFF_CENTRE) else {cause}
    assert confirmed.cause in right
    assert confirmed.what == what
    assert confirmed.size == pytest.approx(size, abs=3.0 * confirmed.error)
    assert confirmed.error < 0.1
    # later poses are likelier by the changed boat's model
    later = recording.cut(70.0, SECONDS)
    old, new = (
        windows(boat, later)[0]
        .quadratic(boat, np.concatenate([boat.coefficients, boat.constants]))
        .value
        for boat in (model, confirmed.model)
    )
    assert new > old + 10.0
    assert confirmed.model.findings_of(FindingKind.ADAPTED)


@pytest.mark.system
def test_the_changed_model_is_kept_in_a_file(model, drives, tmp_path):
    found = findings(ChangeDetector(model), sent(drives[ONE_THRUSTER]))
    boat = found[1].model
    seatrial.save(boat, tmp_path / "changed.yaml")
    again = seatrial.load(tmp_path / "changed.yaml")
    np.testing.assert_allclose(again.constants, boat.constants, rtol=1e-8)
    assert again.parameters == boat.parameters
    assert not {*COUPLINGS} & {*again.parameters}
    found_gains = dict(zip(again.vehicle.constants.names, again.constants, strict=True))
    others = [found_gains[f"gain.F_{i}"] for i in (1, 3, 4)]
    assert np.mean([*others, found_gains["gain.F_2"]]) == pytest.approx(1.0)
    assert found_gains["gain.F_2"] / np.mean(others) == pytest.approx(WEAK, abs=0.1)
    assert again.values["X_F"] < 0.95 * model.values["X_F"]
    # it is the model of a detector again
    space = change_space(again)
    assert len(space.gains) == 4
    # another thruster fails, too: again a boat that a file can hold
    theta = space.theta.copy()
    theta[space.gains["F_3"]] *= 0.5
    worse = space.boat(theta, np.zeros((len(theta), len(theta))))
    seatrial.save(worse, tmp_path / "worse.yaml")
    both = dict(
        zip(worse.vehicle.constants.names, seatrial.load(tmp_path / "worse.yaml").constants, strict=True)
    )  # fmt: skip
    assert both["gain.F_3"] / both["gain.F_1"] == pytest.approx(0.5)


@pytest.mark.system
@pytest.mark.parametrize("motion", [waves, current])
def test_moving_water_is_no_change(model, drives, motion):
    """Of a model that was identified without it."""
    recording = motion(drives[NO_CHANGE], np.random.default_rng(1))
    assert not findings(ChangeDetector(model), sent(recording))


@pytest.mark.system
@pytest.mark.parametrize("wind", [GUSTS, SLOW_WIND])
def test_wind_is_no_change(model, wind):
    drive = driven(pushed("hard", wind), vehicle_of("MP"), 4003, ["S7"])["S7"]
    assert not findings(ChangeDetector(model), sent(drive.recording.cut(0.0, SECONDS)))


@pytest.mark.system
@pytest.mark.parametrize("seed", [1, 2])
def test_a_hand_is_withdrawn(model, drives, seed):
    """Somebody moves the boat by hand for two seconds: poses that no model explains, then the same boat."""
    recording = hand(drives[NO_CHANGE], np.random.default_rng(seed))
    states = [change.state for change in findings(ChangeDetector(model), sent(recording))]
    assert ChangeState.CONFIRMED not in states


def test_a_boat_at_rest_in_calm_water_has_not_changed(model):
    """Nothing moves it, also not the disturbance force of the drives that identified it."""
    rng, spread = np.random.default_rng(1), [model.noise.position] * 2 + [model.noise.heading]
    rows = []
    for i in range(15 * 60):
        stamp = i * NANO // 15
        rows += [(stamp, "command", np.zeros(3)), (stamp, "pose", rng.normal(0.0, spread))]
    assert not findings(ChangeDetector(model), rows)


def test_scores_that_scatter_more_than_stated_count_as_much_less():
    """Of blocks of independent scores the scatter is 1; of scores twice as large it is 4, also beside a change."""
    rng, found = np.random.default_rng(3), []
    for _ in range(200):
        blocks = []
        for _ in range(10):
            root = rng.normal(size=(8, 5)) * np.array([1.0, 10.0, 0.1, 3.0, 1.0])
            information = root.T @ root
            moved = information @ np.full(5, 0.7)
            blocks.append((moved, root.T @ rng.normal(size=8), information))
        one, two = (
            dispersion(
                [Sums(0.0, moved + k * own, information) for moved, own, information in blocks]
            )
            for k in (1.0, 2.0)
        )
        found.append((one, two))
    once, twice = np.mean(found, axis=0)
    assert once == pytest.approx(1.1, abs=0.1)  # 1 at least, so a little more
    assert twice == pytest.approx(4.0, rel=0.05)


def test_a_model_that_a_change_cant_be_told_from_is_refused(model):
    mismatch = finding_of(FindingKind.MODEL_MISMATCH, horizon=1.0)
    estimator = msgspec.structs.replace(model.estimator, findings=[mismatch])
    with pytest.raises(ModelError, match=r"innovations are correlated .*seatrial select"):
        ChangeDetector(replace(model, estimator=estimator))
    still = replace(model, noise=msgspec.structs.replace(model.noise, process=None))
    with pytest.raises(ModelError, match="no noise was estimated"):
        ChangeDetector(still)
