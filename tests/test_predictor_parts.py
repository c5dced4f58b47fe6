# SPDX-License-Identifier: MIT
"""On board, position and heading of sensors with stamps of their own."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

import seatrial
from seatrial.onboard.live import Reader, replay
from seatrial.onboard.odometer import Odometer
from seatrial.onboard.predictor import Health, Predictor, Taken
from seatrial.recording.asynchronous import joined
from seatrial.recording.from_poses import make_recording
from seatrial.simulation.plan import load_plan, with_seed
from seatrial.simulation.trials import plant_model, simulate
from seatrial.util.errors import LiveError, PredictorError

NANO = 10**9


@pytest.fixture(scope="module")
def boat(mp):
    """A model with GNSS noise, its drive, and the true states (n, 6) at times."""
    model = plant_model(load_plan("clean"), mp)
    noise = msgspec.structs.replace(model.noise, position=0.02, heading=0.02)
    trial = next(t for t in simulate(with_seed(load_plan("clean"), 3), mp) if t.name[:2] == "S3")

    def truth(t):
        return np.column_stack([np.interp(t, trial.truth_t, column) for column in trial.truth.T])

    return replace(model, noise=noise), trial, truth


def sensors(truth, seed=0):
    """Positions every 0.5 s, headings every 0.1 s, each at its own time."""
    rng = np.random.default_rng(seed)
    tp, th = np.arange(1.0, 100.0, 0.5), np.arange(1.03, 100.0, 0.1)
    xy = truth(tp)[:, :2] + rng.normal(0, 0.02, (len(tp), 2))
    return tp, xy, th, truth(th)[:, 2] + rng.normal(0, 0.02, len(th))


def driven(odometer, trial, measured):
    """All inputs in order of time."""
    tp, xy, th, psi = measured
    commands = trial.recording.commands
    inputs = [(1e-9 * t, 0, i) for i, t in enumerate(commands.stamps.tolist())]
    inputs += [(t, 1, i) for i, t in enumerate(tp.tolist())]
    inputs += [(t, 2, i) for i, t in enumerate(th.tolist())]
    for t, kind, i in sorted(inputs):
        if t > tp[-1]:
            break
        if kind == 0:
            odometer.command(t, commands.values[i])
        elif kind == 1:
            assert odometer.position(t, xy[i]) is Taken.USED
        else:
            assert odometer.heading(t, psi[i]) is Taken.USED


def test_motion_is_known_when_both_were_measured(boat):
    model, _, _ = boat
    predictor = Predictor(model)
    predictor.command(0.0, [0.0, 0.0, 0.0])
    predictor.position(0.1, [1.0, 2.0])
    assert Health.NO_POSE in predictor.at(0.1).health
    predictor.heading(0.2, 0.5)
    found = predictor.at(0.2)
    assert Health.NO_POSE not in found.health
    np.testing.assert_allclose(found.pose, [1.0, 2.0, 0.5], atol=0.02)


def test_headings_between_positions_make_the_yaw_rate_surer_and_honest(boat):
    model, trial, truth = boat
    tp, xy, th, psi = sensors(truth)
    both, few = Predictor(model), Predictor(model)
    driven(both, trial, (tp, xy, th, psi))
    near = np.searchsorted(th, tp, side="right") - 1
    slow = np.maximum(near, 0)
    driven(few, trial, (tp, xy, th[slow], psi[slow]))
    t = float(tp[-1])
    one, other = both.at(t), few.at(t)
    assert one.covariance[5, 5] < 0.8 * other.covariance[5, 5]
    error = np.concatenate([one.pose, one.velocity]) - truth(np.array([t]))[0]
    error[2] = np.remainder(error[2] + np.pi, 2 * np.pi) - np.pi
    assert error @ np.linalg.solve(one.covariance, error) < 22.5  # 99.9 % of chi-square, 6


def test_late_parts_count_at_their_time(boat):
    model, trial, truth = boat
    tp, xy, th, psi = sensors(truth)
    in_time, late = Predictor(model), Predictor(model)
    driven(in_time, trial, (tp, xy, th, psi))
    kept = th < tp[-1] - 0.2
    driven(late, trial, (tp, xy, th[kept], psi[kept]))
    for t, angle in zip(th[~kept].tolist(), psi[~kept].tolist(), strict=True):
        if t <= tp[-1]:
            assert late.heading(t, angle) is Taken.USED
    a, b = in_time.at(tp[-1]), late.at(tp[-1])
    np.testing.assert_array_equal(a.velocity, b.velocity)
    np.testing.assert_array_equal(a.covariance, b.covariance)


def test_a_position_off_the_origin_is_turned_by_the_filters_own_heading(boat):
    """Of an antenna ahead of the origin, with the lever that says so: the same motion."""
    model, trial, truth = boat
    tp, xy, th, psi = sensors(truth)
    turn = truth(tp)[:, 2]
    ahead = xy + 0.3 * np.column_stack([np.cos(turn), np.sin(turn)])
    plain, off = Odometer(model, lever=(0.0, 0.0)), Odometer(model, lever=(0.3, 0.0))

    class Seconds:
        def __init__(self, odometer):
            self.odometer = odometer

        def __getattr__(self, name):
            method = getattr(self.odometer, name)
            return lambda t, value: method(round(NANO * t), value)

    driven(Seconds(plain), trial, (tp, xy, th, psi))
    driven(Seconds(off), trial, (tp, ahead, th, psi))
    a, b = (o.look(round(NANO * float(tp[-1]))) for o in (plain, off))
    np.testing.assert_allclose(a.pose, b.pose, atol=0.01)
    np.testing.assert_allclose(a.velocity, b.velocity, atol=0.01)


def test_a_replay_uses_each_where_it_is_new(boat):
    model, trial, truth = boat
    tp, xy, th, psi = sensors(truth)
    stamps = [np.rint(NANO * t).astype(np.int64) for t in (tp, th)]
    poses = joined(stamps[0], xy, stamps[1], psi)
    recording = make_recording(
        "both", poses.stamps, poses.eta, trial.recording.commands,
        parts=poses.parts, asynchronous=poses.asynchronous,
    )  # fmt: skip
    rows = list(replay(model, recording, 10.0))
    predictor = Predictor(model)
    driven(predictor, trial, (tp, xy, th, psi))
    last = [row for row in rows if 1e-9 * row.stamp < tp[-1]][-1]
    np.testing.assert_allclose(
        last.motion.velocity, predictor.at(1e-9 * last.stamp).velocity, atol=2e-3
    )


def test_lines_have_positions_and_headings(boat):
    vehicle = boat[0].vehicle
    for form, position, heading in (
        ("json", '{"t": 1.5, "position": [1, 2]}', '{"t": 1.5, "heading": 0.5}'),
        ("csv", "position,1.5,1,2", "heading,1.5,0.5"),
    ):
        reader = Reader(vehicle, form)
        first, second = reader(position), reader(heading)
        assert (first.kind, first.values.tolist()) == ("position", [1.0, 2.0])
        assert (second.kind, second.values.tolist()) == ("heading", [0.5])
    with pytest.raises(LiveError, match="position: expected t, x, y"):
        Reader(vehicle, "csv")("position,1.5,1")


def test_a_covariance_of_another_shape_is_refused(boat):
    predictor = Predictor(boat[0])
    with pytest.raises(PredictorError, match=r"expected \(2, 2\)"):
        predictor.position(0.0, [0.0, 0.0], np.eye(3))
    assert predictor.heading(0.0, float("nan")) is Taken.NOT_A_NUMBER
    assert seatrial.Predictor is Predictor
