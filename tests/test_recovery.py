# SPDX-License-Identifier: MIT
"""The benchmark of recovery: its bounds against dense matrices, its scenes, its tables."""

import re
from dataclasses import replace
from functools import partial
from itertools import pairwise

import msgspec
import numpy as np
import pytest

from benchmarks.harness import store
from benchmarks.recovery import bounds, tables
from benchmarks.recovery.figure import draw, numbers
from benchmarks.recovery.work import work
from seatrial import _core
from seatrial.boat.model import thrust_trace
from seatrial.evaluation.filtering import START_VELOCITY_DEVIATION
from seatrial.simulation.plan import TrialEntry, load_plan
from tests.boats.scenes import (
    SIGMAS,
    by_thrusters,
    scenes,
    true_parameters,
    vehicle_of,
    without_faults,
)

BEGIN, END = 10.0, 15.0  # [s] of the dense matrices' recording
STEP = 1e-5  # of differences, relative
QUIET = np.array([4e-3, 4e-3, 1e-6, 1e-6, 1e-6, 1e-6, 1.0, 0.0, 0.0, 0.3, 0.0, 1.0])
# process noise of either kind
PUSHED = np.array([2e-3, 3e-3, 4e-3, 2e-2, 1e-2, 5e-2, 1.5, 0.0, 0.0, 0.3, 0.0, 1.0])


class Dense:
    """A short record whose covariances and sensitivities are built whole, by differences."""

    def __init__(self):
        plan = msgspec.structs.replace(
            load_plan("clean"), trials={"free": TrialEntry("courses", 20.0)}
        )
        (self.trial,) = replace(scenes()["hard MP"], plan=plan).trials(1, ["free"]).values()
        vehicle = vehicle_of("MP").with_chain(plan.plant.chain)
        self.problem = bounds.problem_of(vehicle, [self.trial.recording.cut(BEGIN, END)])
        self.theta = true_parameters(
            plan, self.problem.names[: self.problem.n_coefficients + self.problem.n_constants]
        )
        self.t = self.problem.recordings[0].t
        first = int(np.searchsorted(self.trial.truth_t, BEGIN - 1e-6))
        self.path = self.states(self.theta, self.trial.truth[first], np.zeros(3))
        moved = replace(self.problem.recordings[0], eta=self.path[:, :3])
        self.problem = replace(self.problem, recordings=(moved,))

    def states(self, theta, x0, push, t=None):
        """The boat under a constant push from x0 at t[0]."""
        n = self.problem.n_coefficients
        boat = _core.Boat(
            self.problem.structure, np.concatenate([theta[:n], push]), 0, self.problem.step
        )
        trace = thrust_trace(self.problem.vehicle, theta[n:].copy(), self.problem.recordings[0])
        return _core.simulate(boat, trace, x0.copy(), self.t if t is None else t.copy())[0]

    def slope(self, function, at):
        """Jacobian of a function's flattened value by central differences."""
        columns = []
        for i, value in enumerate(at):
            h = np.zeros_like(at)
            h[i] = STEP * max(abs(value), 0.1)
            columns.append((function(at + h) - function(at - h)).ravel() / (2 * h[i]))
        return np.array(columns).T

    def ahead(self, state, times):
        """The next state of the boat (6) from its own and the push (9)."""
        return self.states(self.theta, state[:6], state[6:], times)[1]

    def sensitivity(self):
        """Poses to parameters (3 n, p)."""
        return self.slope(lambda p: self.states(p, self.path[0], np.zeros(3))[:, :3], self.theta)

    def covariance(self, noise):
        """Of all poses (3 n, 3 n), from the states' recursion."""
        spread = np.diag(
            [*(3 * noise[[0, 0, 1]]) ** 2, *START_VELOCITY_DEVIATION**2, *noise[[4, 4, 5]] ** 2]
        )
        means, moves = [spread], []
        for k, (a, b) in enumerate(pairwise(self.t)):
            stays = np.exp(-(b - a) / noise[6])
            move = np.zeros((9, 9))
            ahead = partial(self.ahead, times=self.t[k : k + 2])
            move[:6] = self.slope(ahead, np.concatenate([self.path[k], np.zeros(3)]))
            move[6:, 6:] = stays * np.eye(3)
            moves.append(move)
            fresh = self.walked(noise, self.path[k, 2], b - a)
            fresh[6:, 6:] = np.diag(noise[[4, 4, 5]] ** 2 * (1 - stays**2))
            means.append(move @ means[-1] @ move.T + fresh)
        n = len(self.t)
        C = np.zeros((n, 3, n, 3))
        for i in range(n):
            across = means[i]
            for j in range(i, n):
                C[j, :, i] = across[:3, :3]
                C[i, :, j] = across[:3, :3].T
                across = moves[j] @ across if j < n - 1 else across
        return C.reshape(3 * n, 3 * n) + np.diag(np.tile(noise[[0, 0, 1]] ** 2, n))

    def walked(self, noise, psi, length):
        """A body-fixed random walk of the velocity, integrated into the pose."""
        turn = np.array([[np.cos(psi), -np.sin(psi), 0], [np.sin(psi), np.cos(psi), 0], [0, 0, 1]])
        q = np.diag(noise[[2, 2, 3]] ** 2)
        out = np.zeros((9, 9))
        out[:3, :3] = turn @ q @ turn.T * length**3 / 3
        out[:3, 3:6] = turn @ q * length**2 / 2
        out[3:6, :3] = out[:3, 3:6].T
        out[3:6, 3:6] = q * length
        return out


@pytest.fixture(scope="module")
def dense():
    return Dense()


@pytest.mark.parametrize("noise", [QUIET, PUSHED], ids=["quiet", "pushed"])
def test_the_filters_information_is_the_dense_one(dense, noise):
    """J' C^-1 J with the covariance of all poses; the filter starts from the stencil's velocity."""
    J = dense.sensitivity()
    want = J.T @ np.linalg.solve(dense.covariance(noise), J)
    got = bounds.whole(dense.problem, dense.theta, noise)
    scale = np.sqrt(np.diag(want))
    np.testing.assert_allclose(
        got / np.outer(scale, scale), want / np.outer(scale, scale), atol=2e-3
    )


def test_a_piece_is_least_squares_with_an_initial_state_of_its_own(dense):
    """The poses' information less what the initial state takes of it."""
    weight = np.tile(1 / QUIET[[0, 0, 1]], len(dense.t))[:, None]
    J = weight * dense.sensitivity()
    X = weight * dense.slope(
        lambda x0: dense.states(dense.theta, x0, np.zeros(3))[:, :3], dense.path[0]
    )
    want = J.T @ (J - X @ np.linalg.lstsq(X, J, rcond=None)[0])
    whole_truth = replace(dense.trial, truth=dense.path, arrived=np.ones(len(dense.t), dtype=bool))
    got = bounds.pieces(dense.problem, dense.theta, QUIET, [whole_truth], 2 * END)
    scale = np.sqrt(np.diag(want))
    np.testing.assert_allclose(
        got / np.outer(scale, scale), want / np.outer(scale, scale), atol=2e-3
    )


def test_variances_of_parameters_of_different_sizes_are_those_of_the_inverse():
    rng = np.random.default_rng(0)
    A = rng.normal(size=(9, 4)) * np.array([1e-4, 1.0, 1e3, 1e5])
    want = [1 / np.sum((a - np.delete(A, i, 1) @ np.linalg.lstsq(np.delete(A, i, 1), a)[0]) ** 2)
            for i, a in enumerate(A.T)]  # fmt: skip
    np.testing.assert_allclose(bounds.variances(A.T @ A), want, rtol=1e-6)


def test_with_and_without_faults_the_drive_and_the_noise_are_the_same():
    scene = scenes()["hard AF faults"]
    plan = msgspec.structs.replace(scene.plan, trials={"S1": TrialEntry("surge", 60.0)})
    scene = replace(scene, plan=plan)
    (faulty,), (clean,) = (s.trials(1, ["S1"]).values() for s in (scene, without_faults(scene)))
    np.testing.assert_array_equal(faulty.truth, clean.truth)
    same = np.abs(faulty.pose - clean.pose[faulty.arrived]).max(axis=1) == 0.0
    assert 0.005 < (~same).mean() < 0.04
    assert (~faulty.arrived).sum() >= 45  # 3 s at 15 Hz
    assert clean.arrived.all()


def test_commands_to_the_thrusters_give_the_forces_that_the_allocation_gave():
    plan = msgspec.structs.replace(load_plan("hard"), trials={"S1": TrialEntry("surge", 30.0)})
    scene = replace(scenes()["hard MP+AF"], plan=plan)
    trials = list(scene.trials(2, ["S1"]).values())
    vehicle, recordings = by_thrusters(trials)
    chain = plan.plant.chain
    assert [t.name for t in trials] == ["S1-MP", "S1-AF"]
    for trial, recording in zip(trials, recordings, strict=True):
        t = recording.t
        own, direct = (
            thrust_trace(v.with_chain(chain), v.with_chain(chain).constants.values, r).forces(t)
            for v, r in ((trial.vehicle, trial.recording), (vehicle, recording))
        )
        np.testing.assert_allclose(direct, own, atol=1e-12)


@pytest.mark.system
def test_a_seed_is_worked_stored_and_shown(tmp_path):
    """Two minutes of each trial, nearly: everything runs, and the boat comes back."""
    scene = scenes()["hard MP"]
    entries = {name: TrialEntry(entry.drive, 110.0) for name, entry in scene.plan.trials.items()}
    short = replace(scene, plan=msgspec.structs.replace(scene.plan, trials=entries))
    record = work(short, 7) | {"code": store.code("recovery")}
    assert "failed" not in record, record
    path = tmp_path / "results.jsonl"
    path.write_text(msgspec.json.encode(record).decode() + '\n{"scene": "cut o')
    (again,) = store.chosen(store.read(path), store.code("recovery"))
    off = np.abs(np.subtract(again["found"], again["truth"]))
    best = np.sqrt(again["bound"]["whole"])
    assert (off < 5 * best).all(), dict(zip(again["names"], off / best, strict=True))
    assert (best < np.sqrt(again["bound"]["20 s"])).all()
    assert (np.sqrt(again["bound"]["20 s"]) < np.sqrt(again["bound"]["3 s"])).all()
    ahead = again["ahead"]
    assert np.less(np.multiply(8, ahead["ours true"]), ahead["paper true"]).all()
    assert np.less(np.multiply(6, ahead["ours filter"]), ahead["paper stencil"]).all()
    shown = tables.recovery([again], "hard MP")
    assert "| X_u | -0.2 |" in shown
    ratio = off[0] / best[0]
    assert f"| {ratio:.2f} |" in shown.splitlines()[4]


def test_a_seed_that_frees_one_parameter_more_counts_in_those_that_all_have():
    def record(seed, names, found):
        return {
            "scene": "a", "group": "still", "seed": seed, "names": names, "truth": [1.0] * len(names),
            "found": found, "error": [0.1] * len(names),
            "bound": {"whole": [0.01] * len(names)},
        }  # fmt: skip

    plain = record(1, ["X_u", "lag"], [1.1, 1.2])
    wider = record(2, ["X_u", "reverse_ratio", "lag"], [0.9, 7.0, 1.0])
    shown = tables.recovery([plain, wider], "a").splitlines()
    assert [line.split("|")[1].strip() for line in shown[4:]] == ["X_u", "lag"]
    np.testing.assert_allclose(
        tables.stack(tables.good([plain, wider], "a"), "found"), [[1.1, 1.2], [0.9, 1.0]]
    )
    told = tables.further([plain, wider], ["a"]).splitlines()
    assert told[2:] == ["| a | 2 | reverse_ratio 7.00 ± 0.10 | -1.0 (X_u) |"]


def test_a_scene_in_which_no_model_is_found_says_why():
    scene = scenes()["hard MP pushed"]
    entries = {n: TrialEntry(e.drive, 12.0) for n, e in scene.plan.trials.items()}
    short = replace(scene, plan=msgspec.structs.replace(scene.plan, trials=entries))
    record = work(short, 1)
    assert "too short for 15 parameters; drive 60 s or more" in record["failed"]
    assert record["failed"] in tables.failures([record])


def test_the_figure_has_a_curve_for_each_noise_and_method(tmp_path):
    rng = np.random.default_rng(0)
    names = [n for n in scenes() if scenes()[n].group == "noise"]
    assert len(names) == 2 * len(SIGMAS)
    truth = rng.uniform(1, 2, 11).tolist()
    records = [
        {
            "scene": name, "names": [*"abcdefghijk"], "truth": truth,
            "found": np.multiply(truth, 1.01).tolist(), "error": [0.1] * 11,
            "paper": np.multiply(truth, 2.0).tolist(),
            "ahead": {"ours true": [0.001] * 3, "paper true": [0.03, 0.04, 0.0]},
        }
        for name in names
    ]  # fmt: skip
    draw(records, tmp_path / "noise.svg")
    drawn = (tmp_path / "noise.svg").read_text()
    assert len(re.findall(r'd="M[^"L]*(?:L[^"L]*){5}" fill="none" stroke="#', drawn)) == 8
    assert drawn.count("nan") == 0
    rows = [line for line in numbers(records).splitlines() if line.startswith("| white")]
    assert rows[0].count("| 1 ") == 6  # per cent
    assert rows[1].count("| 100 ") == 6
    assert rows[3].count("| 3.54 ") == 6  # cm/s
