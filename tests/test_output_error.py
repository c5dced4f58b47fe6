# SPDX-License-Identifier: MIT
"""Prediction-error estimation: the filter's likelihood against the dense one, recovery of known boats."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from conftest import at_length
from method_trials import driven
from scipy.linalg import expm

import seatrial
from seatrial import _core
from seatrial.boat.actuators import STAGES
from seatrial.boat.findings import FindingKind
from seatrial.boat.physics import direct_chain
from seatrial.boat.schema import ChainGroup
from seatrial.boat.vehicle import vehicle_from
from seatrial.identification.estimator import output_error, with_free_stages
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.uncertainty.covariance import SHORTEST_BLOCK
from seatrial.recording.from_poses import make_recording
from seatrial.recording.signal import Signal
from seatrial.simulation.plan import load_plan
from seatrial.util.errors import SeatrialError
from tests.boats.plans import driven_by, planned

DRAG = -0.7  # [1/s]
# position, heading, walks, disturbances, memory; correlated errors, their memory
NOISE = np.array([2e-3, 1e-9, 5e-3, 1e-12, 4e-3, 1e-12, 1.5, 0.0, 0.0, 0.3, 0.0, 1.0])
COLOUR_WORTH = np.array([*NOISE[:7], 3e-3, 0.0, 0.3, 0.0, 1.0])
SWINGING = np.array([*NOISE[:7], 3e-3, 0.0, 1.0, 4.0, 1.0])
CREEPING_BACK = np.array([*NOISE[:7], 3e-3, 0.0, 0.2, 4.0, 1.0])  # overdamped
START_SPREAD = np.array([0.05, 1e-9, 1e-9])


def straight_cost(t, x, noise, *, use=None, afresh=None, begin=0.0):
    """The filter's cost of positions along a line, of a boat with linear drag and no thrust."""
    rows = [(0, 0, 1.0, -1, [0]), *((axis, 1 + axis, 1.0, -1, []) for axis in range(3))]
    boat = _core.Boat(_core.Structure(rows, 4, 1), np.array([DRAG, 0.0, 0.0, 0.0]), 0, 1 / 240)
    trace = _core.ThrustTrace(
        direct_chain(1), np.zeros(0), np.array([-1.0]), np.zeros((1, 1)), np.zeros(0),
        np.zeros((0, 0)), True, [1, 2, 3], [],
    )  # fmt: skip
    eta = np.column_stack([x, np.zeros_like(x), np.zeros_like(x)])
    start = np.array([begin, 0.0, 0.0, 0.2, 0.0, 0.0])
    use = np.ones(len(t), dtype=np.int8) if use is None else use
    series = _core.Series(t, eta, use, start, START_SPREAD, afresh)
    return _core.innovations(boat, trace, series, noise, 1e9).cost


def dense_square(t, x, noise):
    """e' C^-1 e of the same positions, C built whole from the state's covariances."""
    sigma, walk, disturbance, memory, coloured, together, turn = noise[[0, 2, 4, 6, 7, 9, 10]]
    n = len(t)
    state = np.array([0.0, 0.2, 0.0])
    spread = np.diag([9 * (sigma**2 + coloured**2), START_SPREAD[0] ** 2, disturbance**2])
    means, states, steps = [state], [spread], []
    for a, b in pairwise(t):
        dt = b - a
        move = expm(np.array([[0.0, 1.0, 0.0], [0.0, DRAG, 1.0], [0.0, 0.0, 0.0]]) * dt)
        move[2, 2] = np.exp(-dt / memory)
        renewed = np.zeros((3, 3))
        renewed[:2, :2] = walk**2 * np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]])
        renewed[2, 2] = disturbance**2 * (1 - move[2, 2] ** 2)
        steps.append(move)
        means.append(move @ means[-1])
        states.append(move @ states[-1] @ move.T + renewed)
    C = np.zeros((n, n))
    for i in range(n):
        across = states[i]
        for j in range(i, n):
            C[i, j] = C[j, i] = across[0, 0]
            across = steps[j] @ across if j < n - 1 else across
    e = x - np.array([m[0] for m in means])
    apart = np.abs(t[:, None] - t)
    left = np.exp(-apart / together)
    if turn > 0.0:  # a damped oscillation's covariance
        rate = np.sqrt(complex(turn**2 - together**-2))
        left *= np.real(np.cos(rate * apart) + np.sin(rate * apart) / (rate * together))
    C += sigma**2 * np.eye(n) + coloured**2 * left
    return float(e @ np.linalg.solve(C, e))


@pytest.mark.parametrize("noise", [NOISE, COLOUR_WORTH, SWINGING, CREEPING_BACK])
def test_the_filters_likelihood_is_the_dense_one(noise):
    """Of two recordings the likelihoods differ as those of one joint normal distribution do."""
    rng = np.random.default_rng(3)
    t = np.cumsum(rng.uniform(0.04, 0.12, 60))
    first, second = (np.cumsum(rng.normal(0.01, 0.01, 60)) for _ in range(2))
    got = straight_cost(t, first, noise) - straight_cost(t, second, noise)
    want = dense_square(t, first, noise) - dense_square(t, second, noise)
    assert got == pytest.approx(want, rel=1e-6)


@pytest.fixture(scope="module")
def trials():
    def make(plan, name, seed):
        vehicle, recordings = driven(plan, name, seed)
        return vehicle, list(recordings)

    return make


@pytest.mark.parametrize(("plan", "seed"), [("paper-like", 1), ("hard", 2)])
def test_boat_and_thrusters_of_a_simulated_trial_are_found_whatever_the_noise(plan, seed, trials):
    vehicle, recordings = trials(plan, "mallard-mp", seed)
    model = output_error(recordings, vehicle)
    plant = load_plan(plan).plant
    for name, value in model.values.items():
        error = model.standard_errors[name]
        assert model.values[name] == pytest.approx(plant.coefficients[name], abs=4.5 * error), name
        assert error < 0.05 * max(abs(value), 0.2), name
    constants = dict(zip(model.vehicle.constants.names, model.constants, strict=True))
    assert constants["edge_forward"] == pytest.approx(0.08, abs=0.002)
    assert constants["edge_reverse"] == pytest.approx(0.08, abs=0.002)
    offset = load_plan(plan).joypad.clock_offset
    assert constants["lag"] + constants["latency"] == pytest.approx(0.08 - offset, abs=0.005)
    pose = load_plan(plan).pose
    assert model.noise.position == pytest.approx(pose.position_noise, rel=0.1)
    assert model.noise.heading == pytest.approx(pose.heading_noise, rel=0.1)
    assert model.noise.process.walk_linear < 1e-3  # the plant has no process noise
    assert model.noise.correlated is None


@pytest.mark.system
@pytest.mark.parametrize("sigma", [0.5e-3, 8e-3])
def test_errors_of_the_poses_that_hang_together_are_not_taken_for_motion(sigma):
    vehicle = seatrial.load_vehicle("mallard-mp")
    noise = {"position_noise": sigma, "heading_noise": sigma, "noise_correlation": 0.3}
    plan = planned("paper-like", "S1", "S2", "S3", seed=5, pose=noise)
    model = output_error(driven_by(plan, vehicle), vehicle)
    for name, value in model.values.items():
        error = model.standard_errors[name]
        assert value == pytest.approx(plan.plant.coefficients[name], abs=4.5 * error), name
        assert error < 0.05 * max(abs(value), 0.2), name
    coloured = model.noise.correlated
    assert coloured.position == pytest.approx(sigma, rel=0.1)
    assert coloured.heading == pytest.approx(sigma, rel=0.1)
    assert coloured.memory == pytest.approx(0.3, rel=0.1)
    assert model.noise.position < 0.2 * sigma


@pytest.mark.parametrize("hole", [at_length((100.0, 102.0)), (100.0, 105.0)])
def test_lost_commands_cost_no_more_than_the_poses_beside_them(hole):
    """What drove the boat there is not known: the filter begins afresh."""
    vehicle, (r, *others) = driven("paper-like", "mallard-mp", 8)
    c = r.commands
    t = r.seconds(c.stamps)
    kept = (t <= hole[0]) | (t >= hole[1])
    commands = Signal(c.names, c.stamps[kept], c.values[kept])
    holed = make_recording(r.name, r.stamps, r.eta, commands)
    whole, found = (output_error([one, *others], vehicle) for one in (r, holed))
    truth = load_plan("paper-like").plant.coefficients
    for name, value in found.values.items():
        error = found.standard_errors[name]
        assert value == pytest.approx(truth[name], abs=4.5 * error), name
        assert error < 2.0 * whole.standard_errors[name], name  # of two halves
    assert found.noise.process.disturbance_linear < 1e-4  # nothing pushed it


def test_a_filter_that_begins_afresh_is_two_filters():
    t, at = np.arange(40) / 15.0, 22
    x = 0.2 * t + 0.002 * np.random.default_rng(3).normal(size=len(t))
    use = np.ones(len(t), dtype=np.int8)
    use[at - 3 : at], use[at] = 0, 4
    velocity = np.full((len(t), 3), [0.2, 0.0, 0.0])
    both = straight_cost(t, x, NOISE, use=use, afresh=velocity)
    first = straight_cost(t[: at - 3], x[: at - 3], NOISE)
    assert both == pytest.approx(
        first + straight_cost(t[at:], x[at:], NOISE, begin=x[at]), rel=1e-9
    )


def test_under_always_forward_the_gain_past_the_dead_zones_edge_is_found(trials):
    """f > 0.08 all the time: thrust (f - 0.08) / 0.92, of which the 0.08 cancel in T f."""
    vehicle, recordings = trials("hard", "mallard-af", 3)
    model = output_error(recordings, vehicle)
    assert model.vehicle.constants.names == ("latency", "lag")
    truth = load_plan("hard").plant.coefficients
    for name in truth:
        error = model.standard_errors[name]
        scale = 1 / 0.92 if name.endswith("_F") else 1.0
        assert model.values[name] == pytest.approx(scale * truth[name], abs=4.5 * error), name


def test_a_lag_that_is_stated_for_one_thruster_is_sought_for_the_others(trials):
    vehicle, recordings = trials("paper-like", "mallard-mp", 4)
    stated = vehicle.with_chain([ChainGroup(name="a", actuators=["F_1"], lag=0.08)])
    whole = with_free_stages(stated, recordings)
    place = whole.constants.names.index("lag.lag_others")
    column = STAGES.index("lag")
    assert whole.constants.index[:, column].tolist() == [0, place, place, place]
    model = output_error(recordings, stated)
    found = dict(zip(model.parameters, [*model.coefficients, *model.constants], strict=True))
    assert found["lag.a"] == 0.08
    assert found["lag.lag_others"] == pytest.approx(0.08, abs=1e-3)
    assert found["N_uu"] == pytest.approx(0.63, abs=4.5 * model.standard_errors["N_uu"])


def test_what_the_vehicle_file_states_is_kept(trials):
    vehicle, recordings = trials("paper-like", "mallard-mp", 4)
    stated = vehicle.with_chain(load_plan("paper-like").plant.chain)
    whole = with_free_stages(stated, recordings)
    assert set(whole.constants.names) - set(stated.constants.names) == {"latency"}
    problem = Problem(whole, tuple(recordings), (0,), 1 / 20, 4.0, 10.0)
    assert problem.names[: problem.n_coefficients] == vehicle.structure.coefficients


@pytest.mark.system
def test_a_model_of_this_method_is_saved_loaded_and_better_on_trials_it_has_not_seen(
    trials, tmp_path
):
    vehicle, recordings = trials("paper-like", "mallard-mp", 5)
    found = {m: seatrial.identify(recordings, vehicle, method=m) for m in
             ("equation-error", "output-error")}  # fmt: skip
    seatrial.save(found["output-error"], tmp_path / "m.yaml")
    loaded = seatrial.load(tmp_path / "m.yaml")
    np.testing.assert_allclose(loaded.constants, found["output-error"].constants, rtol=1e-8)
    (unseen,) = driven_by(planned("paper-like", "S7", seed=5), vehicle)
    scores = {
        m: seatrial.validate(model, [unseen], reference="stencil").recordings[0].scores
        for m, model in found.items()
    }
    for symbol in "uvr":
        new, old = (scores[m][symbol] for m in ("output-error", "equation-error"))
        assert new.rms < old.rms
        assert new.rms < 1.1 * new.floor  # nothing is left but the noise of start and reference


def test_a_recording_too_short_for_its_parameters_is_refused(trials):
    vehicle, recordings = trials("paper-like", "mallard-mp", 6)
    words = r"S1-MP, S2-MP, S3-MP: 45 s in all is too short for 15 parameters; drive 60 s or more"
    with pytest.raises(SeatrialError, match=words):
        output_error([r.cut(20, 35) for r in recordings], vehicle)
    short = output_error([r.cut(20, 50) for r in recordings], vehicle)
    (blocks,) = short.findings_of(FindingKind.SHORT_BLOCKS)
    assert blocks.number("length") == short.estimator.settings["block"]
    assert short.estimator.settings["block"] == pytest.approx(5.0, abs=0.02)


def with_holes(recording, holes, *, rows):
    """The recording without the poses in the holes [s], as rows that are gone or that are no numbers."""
    inside = np.any([(recording.t >= a) & (recording.t <= b) for a, b in holes], axis=0)
    raw = recording.raw.copy()
    raw[inside] = np.nan
    keep = ~inside if rows else np.ones(len(raw), dtype=bool)
    return make_recording(
        recording.name, recording.stamps[keep], raw[keep], recording.commands, timeout=None
    )


@pytest.mark.parametrize("rows", [True, False], ids=["no rows", "not numbers"])
def test_only_time_with_poses_counts_and_a_refusal_names_the_gaps(trials, rows):
    """A log with long holes needs shorter blocks, not a longer drive."""
    vehicle, recordings = trials("paper-like", "mallard-mp", 6)
    parts = [r.cut(20.0, 120.0) for r in recordings]
    model = output_error([with_holes(r, [(12, 40), (52, 95)], rows=rows) for r in parts], vehicle)
    assert SHORTEST_BLOCK <= model.estimator.settings["block"] < 6.0
    truth = load_plan("paper-like").plant.coefficients
    for name, value in model.values.items():
        assert value == pytest.approx(truth[name], abs=4.5 * model.standard_errors[name]), name
    words = (
        r"S1-MP, S2-MP, S3-MP: 300 s in all is too short for 15 parameters: no usable poses in 6 gaps of "
        r"40 to 48 s, 88 % of the time\. Repair the log \(seatrial inspect names the faults\), or drive 60 s or "
        "more without gaps"
    )
    with pytest.raises(SeatrialError, match=words):
        output_error([with_holes(r, [(6, 46), (48, 96)], rows=rows) for r in parts], vehicle)


def test_of_terms_that_can_not_be_told_apart_the_names_are_said(trials):
    vehicle, recordings = trials("paper-like", "mallard-mp", 6)
    content = vehicle.to_mapping()
    lines = vehicle.structure.lines()
    content["structure"] = lines | {"surge": [*lines["surge"], "X_a * |u| * u"]}
    with pytest.raises(SeatrialError, match=r"^X_uu, X_a can't be told apart: vary speed"):
        output_error(recordings, vehicle_from(content, "twins"))


@pytest.mark.system
def test_commands_of_another_trial_are_not_taken_for_a_boat(trials):
    vehicle, whole = trials("paper-like", "mallard-mp", 5)
    recordings = [r.cut(0.0, 100.0) for r in whole]
    others = [*recordings[1:], recordings[0]]
    strangers = [replace(a, commands=b.commands) for a, b in zip(recordings, others, strict=True)]
    assert output_error(strangers, vehicle).findings_of(FindingKind.NO_BETTER_THAN_CONSTANT)
    assert not output_error(recordings, vehicle).estimator.findings


@pytest.mark.system
def test_poses_that_go_nowhere_in_particular_are_an_outcome_with_advice(trials):
    vehicle, whole = trials("paper-like", "mallard-mp", 5)
    recordings = [r.cut(0.0, 100.0) for r in whole]
    rng = np.random.default_rng(1)
    steps = [0.02 * rng.normal(size=r.eta.shape) for r in recordings]
    lost = [replace(r, eta=np.cumsum(s, axis=0)) for r, s in zip(recordings, steps, strict=True)]
    advised = (FindingKind.NO_SIGNIFICANT_COEFFICIENT, FindingKind.NO_BETTER_THAN_CONSTANT)
    assert output_error(lost, vehicle).findings_of(*advised)
    assert all("Check with 'seatrial inspect'" in kind.advice for kind in advised)
