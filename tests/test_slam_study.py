# SPDX-License-Identifier: MIT
"""The SLAM study: its rays, its scans that are swept, its matcher, its guesses, its tables."""

import numpy as np
import pytest
from scipy.linalg import expm

pytest.importorskip("small_gicp")
from benchmarks.studies.slam import lidar, localise, mapping, tables
from benchmarks.studies.slam.drives import drive
from benchmarks.studies.slam.guesses import (
    ConstantPose,
    ConstantVelocity,
    ModelOdometry,
    TrueMotion,
)
from benchmarks.studies.slam.localise import plausible
from benchmarks.studies.slam.mapping import Map, Match, matrix
from benchmarks.studies.slam.scene import pool_scene
from benchmarks.studies.slam.se2 import between, compose, exponential, inverse, logarithm, transform
from benchmarks.studies.slam.study import Case, Outcome, driven, error, scans, without_drop_outs
from seatrial.boat.model import Model
from seatrial.simulation.plan import load_plan
from seatrial.simulation.scene import Scene, box
from seatrial.simulation.trials import plant_model

ROOM = Scene(box(0.0, 0.0, 8.0, 6.0), np.array([[2.0, 0.0, 0.5]]))
NO_POSTS = np.zeros((0, 3))


@pytest.fixture(scope="module")
def true_model(mp) -> Model:
    return plant_model(load_plan("hard"), mp)


def test_rays_end_where_hand_and_ruler_say():
    angle = np.deg2rad([0.0, 90.0, 180.0, -90.0, 45.0])
    origin = np.tile([0.0, 0.0], (5, 1))
    expected = [1.5, 3.0, 4.0, 3.0, 3.0 * np.sqrt(2.0)]
    np.testing.assert_allclose(ROOM.ranges(origin, angle), expected, rtol=1e-12)
    # past the post by a hair, and onto it by a hair: at its side the way is the tangent's
    aim = np.arcsin(0.5 / 2.0)
    past, onto = ROOM.ranges(origin[:2], np.array([aim + 1e-9, aim - 1e-9]))
    assert past == pytest.approx(4.0 / np.cos(aim))
    assert onto == pytest.approx(2.0 * np.cos(aim), abs=1e-3)
    assert np.isinf(Scene(box(9.0, 0.0, 1.0, 1.0), NO_POSTS).ranges(origin[:1], angle[2:3]))[0]


def test_a_turned_box_is_seen_at_its_corner():
    diamond = Scene(box(3.0, 0.0, 1.0, 1.0, turn=np.pi / 4), NO_POSTS)
    seen = diamond.ranges(np.array([[0.0, 0.1]]), np.array([0.0]))
    assert seen[0] == pytest.approx(3.0 - np.sqrt(0.5) + 0.1)


def test_distances_to_walls_corners_and_posts():
    points = np.array([[0.0, 2.0], [5.0, 4.0], [2.0, 0.2], [1.0, 0.0], [-4.0, 1.0]])
    expected = [1.0, np.sqrt(2.0), 0.3, 0.5, 0.0]
    np.testing.assert_allclose(ROOM.distance(points), expected, atol=1e-12)


def test_poses_are_algebra():
    a, b = np.array([1.0, -2.0, 2.5]), np.array([0.3, 0.7, 1.2])
    np.testing.assert_allclose(matrix(compose(a, b)), matrix(a) @ matrix(b), atol=1e-12)
    np.testing.assert_allclose(matrix(inverse(a)), np.linalg.inv(matrix(a)), atol=1e-12)
    for twist in (np.array([0.4, -0.2, 0.9]), np.array([0.4, -0.2, 0.0])):
        u, v, r = twist
        generator = np.zeros((4, 4))
        generator[0, 1], generator[1, 0], generator[:2, 3] = -r, r, (u, v)
        np.testing.assert_allclose(matrix(exponential(twist)), expm(generator), atol=1e-12)
        np.testing.assert_allclose(logarithm(exponential(twist)), twist, atol=1e-12)


def test_every_beam_of_a_scan_has_its_own_time_and_heading(monkeypatch):
    """A boat that spins and sails: what a beam measures is from where the boat was just then."""
    monkeypatch.setattr(lidar, "NOISE", 0.0)
    twist, start = np.array([0.3, 0.1, 1.5]), np.array([-1.0, 0.5, 0.2])

    def poses(t):
        return compose(start, exponential((t - 7.0)[:, None] * twist))

    found = lidar.scan(ROOM, poses, 7.0, 0.0, np.random.default_rng(1))
    assert len(found.t) == 811
    # 135 of 360 degrees, at 15 turns a second
    assert found.t[0] == pytest.approx(7.0 - 135.0 / 360.0 / 15.0)
    assert found.end == pytest.approx(7.0 + 0.025)
    # the last beam, port and aft, by hand: 25 ms of turning at 1.5 rad/s are 2.1 degrees
    heading = 0.2 + 0.025 * 1.5 + np.deg2rad(135.0)
    at = poses(np.array([7.025]))[0, :2]
    to_walls = [(3.0 - at[1]) / np.sin(heading), (-4.0 - at[0]) / np.cos(heading)]
    expected = min(x for x in to_walls if x > 0)
    assert np.hypot(*found.points[-1]) == pytest.approx(expected, rel=1e-12)
    # undistorted by the true motion all points are on surfaces, as measured they are not
    straight = transform(start, lidar.undistorted(found, poses))
    np.testing.assert_allclose(ROOM.distance(straight), 0.0, atol=1e-12)
    assert ROOM.distance(transform(start, found.points)).max() > 0.08


def test_noise_and_bias_are_those_asked_for():
    far = Scene(box(0.0, 0.0, 30.0, 10.0), NO_POSTS)
    still = lambda t: np.zeros((len(t), 3))  # noqa: E731
    found = lidar.scan(far, still, 1.0, 0.05, np.random.default_rng(3))
    truth = far.ranges(np.zeros((811, 2)), lidar.ANGLES)
    off = np.hypot(*found.points.T) - truth
    assert off.mean() == pytest.approx(0.05, abs=4 * 0.02 / np.sqrt(811))
    assert off.std() == pytest.approx(0.02, rel=4 / np.sqrt(2 * 811))
    wide = Scene(box(0.0, 0.0, 60.0, 10.0), NO_POSTS)  # the far end is out of range
    assert len(lidar.scan(wide, still, 1.0, 0.0, np.random.default_rng(3)).t) < 811


def test_the_matcher_finds_a_known_displacement():
    scene, rng = pool_scene(), np.random.default_rng(5)
    begin, end = np.array([-1.0, 1.2, 0.4]), np.array([-0.8, 1.1, 0.7])
    first, second = (
        lidar.scan(scene, lambda t, p=pose: np.tile(p, (len(t), 1)), 0.0, 0.0, rng).points
        for pose in (begin, end)
    )
    chart = Map(first, begin)
    match = chart.match(second, begin)  # 0.22 m and 0.3 rad off
    off = between(end, match.pose)
    assert match.converged
    assert np.hypot(*off[:2]) < 0.01
    assert abs(off[2]) < 0.003
    assert match.share > 0.85
    assert 2 <= match.iterations < 20
    # a scan that is nowhere near: not on the map
    assert chart.match(second + np.array([40.0, 0.0]), begin).share < 0.1


def test_points_need_height_for_a_covariance_that_is_a_wall(monkeypatch):
    """Flat points lie in a level plane: the matcher takes that for the surface, and creeps."""
    scene, found = pool_scene(), {}
    begin, end = np.array([2.0, -1.4, 1.0]), np.array([2.2, -1.5, 1.3])
    for heights in (mapping.HEIGHTS, (0.0,)):
        monkeypatch.setattr(mapping, "HEIGHTS", heights)
        rng = np.random.default_rng(6)
        first, second = (
            lidar.scan(scene, lambda t, p=pose: np.tile(p, (len(t), 1)), 0.0, 0.0, rng).points
            for pose in (begin, end)
        )
        match = Map(first, begin).match(second, begin)
        found[len(heights)] = match.iterations
    assert found[1] > 2 * found[2]


def test_a_map_keeps_one_mean_a_cell():
    chart = Map(np.array([[0.51, 0.01], [0.53, 0.03], [1.02, -0.01]]), np.zeros(3))
    np.testing.assert_allclose(chart.points, [[0.52, 0.02], [1.02, -0.01]])
    chart.insert(np.array([[0.54, 0.04]]), np.zeros(3))
    np.testing.assert_allclose(chart.points, [[0.53, 0.03], [1.02, -0.01]])


def test_constant_velocity_goes_on_along_its_arc_for_a_second():
    twist, t0 = np.array([0.3, -0.1, 0.8]), 2.0
    on_arc = lambda t: exponential((t - t0) * twist)  # noqa: E731
    guess = ConstantVelocity(t0, np.zeros(3))
    np.testing.assert_array_equal(guess.poses(np.array([9.0])), np.zeros((1, 3)))
    guess.accepted(2.2, on_arc(2.2))
    np.testing.assert_allclose(guess.poses(np.array([2.5]))[0], on_arc(2.5), atol=1e-12)
    np.testing.assert_allclose(guess.poses(np.array([60.0]))[0], on_arc(3.2), atol=1e-12)


def test_odometry_knows_commands_up_to_now_and_the_matches_that_were_accepted(true_model):
    made = driven("aggressive", 51)
    t = np.arange(1.0, 30.0, 0.5)
    true = made.poses(t)
    guesses = {
        "predictor": ModelOdometry(t[0], true[0], true_model, made),
        "velocity": ConstantVelocity(t[0], true[0]),
        "none": ConstantPose(t[0], true[0]),
        "truth": TrueMotion(t[0], true[0], made.poses),
    }
    off = {name: [] for name in guesses}
    for now, pose in zip(t[1:], true[1:], strict=True):
        for name, guess in guesses.items():
            guess.commands_until(now)
            off[name].append(error(pose[None], guess.poses(np.array([now])))[0])
            guess.accepted(now, pose)
        heard = guesses["predictor"].taken
        assert made.command_sent[heard - 1] <= now < made.command_sent[heard]
    rms = {name: np.sqrt(np.mean(np.square(x), axis=0)) for name, x in off.items()}
    assert (rms["predictor"] < 0.5 * rms["velocity"]).all()
    assert (rms["velocity"] < rms["none"]).all()
    np.testing.assert_allclose(rms["truth"], 0.0, atol=1e-9)


def test_the_gate_asks_for_convergence_overlap_and_a_speed_that_boats_have():
    guess = ConstantPose(10.0, np.zeros(3))
    near = np.array([0.2, 0.0, 0.1])
    assert plausible(Match(near, True, 0.9, 5), guess, 10.5)
    assert not plausible(Match(near, False, 0.9, 5), guess, 10.5)
    assert not plausible(Match(near, True, 0.4, 5), guess, 10.5)
    far = np.array([0.45, 0.0, 0.0])  # 0.1 m and half a second at 0.6 m/s are 0.4 m
    assert not plausible(Match(far, True, 0.9, 5), guess, 10.5)
    assert plausible(Match(far, True, 0.9, 5), guess, 11.0)
    turned = np.array([0.0, 0.0, -1.15])
    assert not plausible(Match(turned, True, 0.9, 5), guess, 10.5)


@pytest.mark.system
def test_a_drive_keeps_clear_turns_as_fast_as_the_paper_s_boat_and_is_followed(true_model):
    made = drive("aggressive", 52)
    assert pool_scene().distance(made.truth[:, :2]).min() > 0.3
    assert 1.2 < np.abs(made.truth[:, 5]).max() < 1.7  # [rad/s]
    assert np.abs(drive("gentle", 52).truth[:, 5]).max() < 0.8
    chosen = scans("aggressive", 52)[:300:7]
    t = chosen[0].stamp
    pose = made.poses(np.array([t]))[0]
    found = localise.localise(chosen, ModelOdometry(t, pose, true_model, made))
    assert len(found.t) == len(chosen) - 1
    assert found.accepted.all()
    assert (error(made.poses(found.t), found.pose) < [0.1, 0.03]).all()
    assert (error(made.poses(found.t), found.guess) > 0.0).all()


def test_drop_outs_take_scans_away_but_never_the_first():
    given = scans("aggressive", 52)
    left = without_drop_outs(given, 52)
    gaps = np.diff([s.stamp for s in left])
    assert left[0] is given[0]
    assert 0.5 < gaps.max() < 4.0  # two may follow each other
    assert np.sum(gaps > 0.4) <= 16


def test_a_table_counts_what_was_rejected_false_and_lost():
    case = tables.CASES["reach"][0]
    good = np.full((10, 2), [0.01, 0.001])
    bad = good.copy()
    bad[8:] = [0.5, 0.0]
    accepted = np.arange(10) > 0
    made = [
        Outcome(case, seed, off, off, accepted, np.full(10, 3), np.array([0.01, 0.3]))
        for seed, off in ((1, good), (2, bad))
    ]
    assert tables.reach({case: made}).splitlines()[-1] == (
        "| 0.5 m | constant pose | 10 | 10 | 1 of 2 | 50 |"
    )
    row = tables.matched({case: made}).splitlines()[-1]
    assert row == "| 1 Hz | constant pose | 500 | 1 | 3.0 | 10 | 10 | 1 of 2 | 500 | 1 | 50 |"
    moved = Case("aggressive", "predictor", 3, undistort=False)
    row = tables.undistorted({moved: made[:1]}).splitlines()[-1]
    assert row == "| predictor | as measured | 10 | 1 | 212 |"
