# SPDX-License-Identifier: MIT
"""The predictor with an identified model on simulated drives: against truth, in any order, on bad input."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from conftest import ROOT, at_length, make_model
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import binom, chi2
from test_docs import blocks

import seatrial
from benchmarks.predictor import accuracy, board, consistency, matches, unknown
from seatrial import _core
from seatrial.boat.schema import EnvelopeEntry, Integration
from seatrial.onboard.odometer import Odometer
from seatrial.onboard.predictor import Health, Predictor, Taken
from seatrial.util.errors import PredictorError
from tests.boats import drives, scenes
from tests.boats.drives import CORRELATED, SCENES, drive, follow, model

SEED = accuracy.SEED
EXACT, PUSHED = SCENES
COLOUR_WORTH = (41, 42)
OWN_ERRORS = (SEED, 41, 43)  # the first one's model is that of other tests, too


def begun(trial: drives.Drive, seconds: float) -> drives.Drive:
    """The first seconds of a drive."""
    recording = trial.recording.cut(0.0, seconds)
    return drives.Drive(recording, drives.of_recording(recording), trial.truth[: len(recording.t)])


@pytest.fixture(scope="module")
def known() -> seatrial.Model:
    return model(EXACT, SEED)


@pytest.mark.parametrize("scene", [EXACT, at_length(PUSHED)])
def test_velocity_is_five_times_nearer_to_the_truth_than_the_stencils(scene):
    stencil, past, ours = (wrong for _, wrong in accuracy.velocity(scene))
    assert np.all(5.0 * ours < stencil)
    assert np.all(3.0 * ours < past)


@pytest.mark.parametrize("scene", [EXACT, at_length(PUSHED)])
@pytest.mark.parametrize("burst", [1, matches.BURST])
def test_no_false_match_is_used_and_the_pose_stays_within_three_centimetres(scene, burst):
    got = matches.outcome(scene, burst)
    assert got.false > 50
    assert got.accepted == 0
    assert got.rejected == 0
    assert got.errors.max() < 0.03


@pytest.mark.parametrize("current", unknown.CURRENTS)
def test_a_current_that_the_model_knows_nothing_of_overrules_it_and_is_followed_then(current):
    """Identified where nothing pushed the boat: nothing but recovery makes it count with one."""
    got = unknown.outcome(EXACT, current)
    late = got.t > unknown.FOUND
    assert got.doubted == any(current)
    assert len(got.overruled) <= 3
    assert np.sqrt(np.mean(got.pose[late, :2] ** 2)) < 0.004  # [m] that the poses are good to
    assert np.sqrt(np.mean(got.velocity[late, :2] ** 2)) < (0.01 if any(current) else 1e-4)  # [m/s]


@pytest.mark.system
def test_the_covariance_is_right_with_an_identified_model():
    found = np.concatenate([consistency.nees(PUSHED, seed) for seed in consistency.SEEDS[:2]])
    n = len(found)
    low, high = chi2.ppf([0.025, 0.975], consistency.SIZE * n) / n
    assert low < found.mean() < high
    inside = np.sum(found < chi2.ppf(consistency.LEVEL, consistency.SIZE))
    few, many = binom.ppf([0.025, 0.975], n, consistency.LEVEL)
    assert few <= inside <= many


@pytest.mark.system
def test_pose_errors_that_hang_together_are_believed_as_such():
    """As states the covariance is right and the velocity better; taken for white it is too small."""
    told, not_told, errors = [], [], []
    for seed in COLOUR_WORTH:
        known = model(CORRELATED[PUSHED], seed)
        assert known.noise.correlated.memory == pytest.approx(scenes.CORRELATION, rel=0.2)
        pair = known, consistency.as_white(known)
        ways = [consistency.followed(CORRELATED[PUSHED], seed, m) for m in pair]
        told.append(consistency.sampled(*ways[0]))
        not_told.append(consistency.sampled(*ways[1]))
        errors.append([accuracy.rms(e[track.t > drives.SETTLED, 3:]) for track, e in ways])
    found, n = np.concatenate(told), sum(map(len, told))
    low, high = chi2.ppf([0.025, 0.975], consistency.SIZE * n) / n
    assert low < found.mean() < high
    few, many = binom.ppf([0.025, 0.975], n, consistency.LEVEL)
    assert few <= np.sum(found < chi2.ppf(consistency.LEVEL, consistency.SIZE)) <= many
    assert np.concatenate(not_told).mean() > 2.0 * high
    ours, white = np.mean(errors, axis=0)
    assert np.all(ours < white)


@pytest.mark.system
def test_where_only_the_models_own_errors_are_left_the_covariance_is_not_too_small():
    found = np.concatenate([consistency.nees(EXACT, seed) for seed in OWN_ERRORS])
    assert 2.0 < found.mean() < consistency.SIZE
    # the samples of a seed share one model, whose errors don't change: few seeds say little of tails
    assert np.mean(found < chi2.ppf(consistency.LEVEL, consistency.SIZE)) > consistency.LEVEL - 0.05


@pytest.mark.system
def test_dead_reckoning_beats_the_papers_model_and_a_constant_velocity():
    trial = begun(drive(PUSHED, SEED), 150.0)
    ours = np.median(accuracy.reckoned(model(PUSHED, SEED), trial), axis=0)
    paper = np.median(accuracy.reckoned(model(PUSHED, SEED, "equation-error"), trial), axis=0)
    still = np.median(accuracy.constant(trial), axis=0)
    assert np.all(ours < paper)
    assert np.all(ours < still)
    assert ours[0] < 0.02


def test_its_mean_is_the_core_s_own_prediction(known):
    """Without poses but the first it goes where the library's roll-out of the same model goes."""
    trial = drive(EXACT, SEED)
    t = trial.recording.t[:150]
    constants = known.constants.copy()
    constants[known.vehicle.constants.names.index("latency")] = 0.03  # no command from the future
    fine = Integration("runge-kutta", 1e-3)  # steps are cut elsewhere: short enough not to matter
    sure = replace(known, constants=constants, integration=fine)
    inputs = accuracy.until(trial.inputs, -1.0, t[0], t[-1])
    track = follow(Predictor(sure), inputs, t)
    start = np.concatenate([inputs.pose[0], np.zeros(3)])

    states, _ = _core.simulate(
        sure.boat, sure.trace(trial.recording), start, np.ascontiguousarray(t)
    )
    np.testing.assert_allclose(track.errors(states), 0.0, atol=1e-7)


arrivals = st.lists(st.floats(0.0, 0.5), min_size=1, max_size=40)


@settings(max_examples=25)
@given(delays=arrivals, begin=st.floats(20.0, 300.0), look=st.floats(-0.5, 2.0))
def test_what_arrives_late_gives_to_the_bit_what_arrives_in_time(delays, begin, look):
    model_ = model(EXACT, SEED)
    trial = drive(EXACT, SEED)
    spoiled, _ = matches.spoiled(trial.inputs, matches.BURST, 3)
    part = accuracy.until(spoiled, begin, begin + 3.0, begin + 3.0)
    events = [row[1:] for row in part.events()]
    late = sorted(enumerate(events), key=lambda e: (e[1][1] + delays[e[0] % len(delays)], e[0]))
    one, other = Predictor(model_), Predictor(model_)
    for event in events:
        assert drives.give(one, *event) is Taken.USED
    for _, event in late:
        assert drives.give(other, *event) is Taken.USED
        other.at(event[1])
    a, b = one.at(begin + 3.0 + look), other.at(begin + 3.0 + look)
    for name in ("pose", "velocity", "covariance", "disturbance"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name))
    assert a.health == b.health
    assert a.last_pose == b.last_pose


def test_what_is_no_number_is_refused_and_nothing_else_ever_comes_out(known):
    p = Predictor(known)
    assert p.at(1.0).health & Health.NO_POSE
    assert p.pose(0.0, [0.0, 0.0, 0.0]) is Taken.USED
    assert p.pose(0.0, [0.0, 0.0, 0.0]) is Taken.TWICE
    for odd in (np.nan, np.inf, -np.inf):
        assert p.pose(0.1, [odd, 0.0, 0.0]) is Taken.NOT_A_NUMBER
        assert p.pose(odd, [0.0, 0.0, 0.0]) is Taken.NOT_A_NUMBER
        assert p.command(0.1, [0.0, 0.0, odd]) is Taken.NOT_A_NUMBER
        assert p.pose(0.1, [0.0, 0.0, 0.0], np.full((3, 3), odd)) is Taken.NOT_A_NUMBER
        assert np.isfinite(p.at(odd).covariance).all()
    assert p.pose(0.1, [0.0, 0.0, 0.0], -np.eye(3)) is Taken.NOT_A_NUMBER
    assert p.pose(-1.0, [0.0, 0.0, 0.0]) is Taken.STALE
    assert p.pose(99.0, [0.0, 0.0, 0.0]) is Taken.AHEAD
    now = p.at(0.05)
    assert Health.BAD_INPUT in now.health
    assert any("refused" in words for words in now.health.advice)
    assert np.isfinite(now.velocity).all()
    with pytest.raises(ValueError, match="read-only"):
        now.pose[0] = 1.0
    p.forget()
    assert Health.NO_POSE in p.at(0.0).health
    assert p.at(0.0).last_pose == -np.inf


def test_a_poses_own_covariance_counts(known):
    p, q = Predictor(known), Predictor(known)
    for t in np.arange(0.0, 2.0, 0.1):
        p.pose(t, [0.0, 0.0, 0.0], np.diag([1e-6, 4.0, 1e-6]))
        q.pose(t, [0.0, 0.0, 0.0])
    sure, unsure, usual = *np.diag(p.at(1.9).covariance)[:2], q.at(1.9).covariance[0, 0]
    assert sure < usual < unsure


def test_health_knows_where_the_model_was_identified(known):
    narrow = replace(known, envelope=EnvelopeEntry({"u": (-0.01, 0.01)}, {"F_u": (-0.1, 0.1)}))
    p = Predictor(narrow)
    p.pose(0.0, [0.0, 0.0, 0.0])
    p.command(0.0, [1.0, 0.0, 0.0])
    far = p.at(2.0).health
    assert Health.OUTSIDE_SPEEDS in far
    assert Health.OUTSIDE_COMMANDS in far
    assert Health.DEAD_RECKONING in far
    near = Predictor(known)
    near.pose(0.0, [0.0, 0.0, 0.0])
    near.command(0.0, [0.1, 0.0, 0.0])
    assert near.at(0.2).health == Health(0)
    assert near.at(0.2).health.advice == ()


def test_commands_time_out_as_the_vehicle_file_says(known):
    file = msgspec.structs.replace(known.vehicle.file, command_timeout=0.3)
    p = Predictor(replace(known, vehicle=replace(known.vehicle, file=file)))
    p.pose(0.0, [0.0, 0.0, 0.0])
    p.command(0.0, [1.0, 0.0, 0.0])
    assert Health.COMMAND_SILENCE not in p.at(0.2).health
    assert Health.COMMAND_SILENCE in p.at(0.4).health


def test_a_model_by_its_file_is_the_same(known, tmp_path):
    seatrial.save(known, tmp_path / "model.yaml")
    found = []
    for given_ in (known, tmp_path / "model.yaml", str(tmp_path / "model.yaml")):
        p = Predictor(given_)
        p.pose(0.0, [1.0, 2.0, 0.3])
        p.command(0.0, [0.5, 0.0, 0.5])
        found.append(p.at(1.0).velocity)
    np.testing.assert_allclose(found[1:], [found[0]] * 2, rtol=1e-9)


def test_the_documented_lines_run(known, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    seatrial.save(known, "model.yaml")
    here: dict[str, object] = {}
    exec(compile(blocks(ROOT / "docs" / "onboard.md", "python")[0], "onboard", "exec"), here)
    now = here["now"]
    assert isinstance(now, seatrial.Estimate)
    assert now.health == Health(0)
    assert 0.0 < now.velocity[0] < 0.01


def test_what_does_not_fit_is_told_in_a_line(known, mp):
    p = Predictor(known)
    with pytest.raises(PredictorError, match=r"command of shape \(2,\); expected 3 numbers: F_u"):
        p.command(0.0, [0.0, 0.0])
    with pytest.raises(PredictorError, match=r"pose of shape \(4,\)"):
        p.pose(0.0, [0.0] * 4)
    with pytest.raises(PredictorError, match=r"covariance of shape \(2, 2\)"):
        p.pose(0.0, [0.0] * 3, np.eye(2))
    with pytest.raises(PredictorError, match="expected 0 numbers: none"):
        p.scale(0.0, [1.0])
    with pytest.raises(PredictorError, match="'earth' or 'body'"):
        Predictor(known, disturbance="wind")
    with pytest.raises(PredictorError, match=r"current \[nan, 0.0\]; expected 2 numbers"):
        Predictor(known, current=(np.nan, 0.0))
    with pytest.raises(PredictorError, match="window"):
        Predictor(known, window=0.0)
    with pytest.raises(PredictorError, match=r"heading of shape \(1,\); expected psi"):
        p.heading(0.0, [1.0])
    with pytest.raises(PredictorError, match="deviation 'a'; expected one number"):
        p.heading(0.0, 1.0, "a")
    with pytest.raises(PredictorError, match=r"command \['a', 0, 0\]; expected 3 numbers"):
        p.command(0.0, ["a", 0, 0])
    for lever in ((1.0,), (np.nan, 0.0), "ab"):
        with pytest.raises(PredictorError, match=r"lever .*expected 2 numbers: forward"):
            Odometer(known, lever=lever)
    lines = {"surge": [f"X_{i} * u" for i in range(38)], "sway": ["Y_v * v"], "yaw": ["N_r * r"]}
    file = msgspec.structs.replace(mp.file, structure=lines)
    with pytest.raises(seatrial.SeatrialError, match="40 coefficients; at most 37"):
        replace(mp, file=file)  # three are kept for the disturbance
    lines["surge"] = lines["surge"][:35]
    full = replace(mp, file=msgspec.structs.replace(mp.file, structure=lines))
    values = dict.fromkeys(full.structure.coefficients, -0.1)
    assert len(values) == 37
    Predictor(make_model(full, values), disturbance="body")


def test_the_scale_signal_drives_the_thrust(cse1_vehicle):
    values = {name: (0.5 if "F" in name else -0.5) for name in cse1_vehicle.structure.coefficients}
    p = Predictor(make_model(cse1_vehicle, values))
    p.pose(0.0, [0.0, 0.0, 0.0])
    p.command(0.0, [0.5, 0.0, 0.5, 0.0, 0.0])
    p.scale(0.0, [0.4])
    full = p.at(1.0).velocity[0]
    p.scale(0.01, [0.2])
    assert p.at(1.0).velocity[0] == pytest.approx(full / 4.0, rel=0.05)


@pytest.mark.system
def test_the_benchmark_prints_its_tables():
    table = matches.table().splitlines()
    assert len(table) == 2 + 2 * len(SCENES)
    assert all(row.split("|")[3].strip() == "0" for row in table[2:])
    assert board.FLAGS[0] == "-std=c++17"
