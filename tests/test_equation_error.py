# SPDX-License-Identifier: MIT
"""The paper's least squares: exact where it must be, honest where it can't be."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from conftest import TABLE_II, make_model

import seatrial
from seatrial import _core
from seatrial.identification.methods import METHODS, EquationErrorSettings, identify
from seatrial.identification.regression.equation_error import equation_error
from seatrial.identification.regression.least_squares import solve_least_squares
from seatrial.recording.excitation import excitation, find_roles
from seatrial.recording.from_poses import make_recording
from seatrial.recording.signal import Signal
from seatrial.recording.velocity import Motion
from seatrial.util.errors import IdentificationError, ModelError, RecordingError

RATE = 15.0  # [Hz]


def euler_trial(model, axis: int, seconds: float = 60.0):
    """The paper's recursion driven by single-axis pulses; the recording and its true velocities."""
    rng = np.random.default_rng(axis)
    n = int(seconds * RATE)
    stamps = np.rint(np.arange(n) / RATE * 1e9).astype(np.int64)
    values = np.zeros((n, 3))
    values[:, axis] = np.repeat(rng.uniform(-1, 1, n // 10 + 1), 10)[:n]
    commands = Signal(("F_u", "F_v", "F_r"), stamps, values)
    blank = make_recording(f"S{axis + 1}", stamps, np.cumsum(np.ones((n, 3)), 0) * 1e-3, commands)
    states, _ = _core.simulate(model.boat, model.trace(blank), np.zeros(6), blank.t)
    record = make_recording(f"S{axis + 1}", stamps, states[:, :3], commands)
    return record, Motion(record.t, states[:, :3], states[:, 3:], np.ones(n, dtype=bool))


@pytest.mark.parametrize("column", ["MP", "AF"])
def test_all_eleven_coefficients_of_table_two_come_back_to_1e_9(mp, column):
    model = make_model(mp, TABLE_II[column], "forward-euler", 1 / RATE)
    data = [euler_trial(model, axis) for axis in range(3)]
    found = equation_error([r for r, _ in data], mp, motions=[m for _, m in data])
    for name, true in TABLE_II[column].items():
        assert found.values[name] == pytest.approx(true, abs=1e-9), name


def test_the_four_steps_are_the_papers(mp):
    model = make_model(mp, TABLE_II["AF"], "forward-euler", 1 / RATE)
    data = [euler_trial(model, axis) for axis in range(3)]
    found = equation_error([r for r, _ in data], mp, motions=[m for _, m in data])
    steps = [(s.equation, s.recordings, set(s.coefficients)) for s in found.estimator.steps]
    assert steps == [
        ("Eq. (14)", ["S1"], {"X_u", "X_uu", "X_F"}),
        ("Eq. (15)", ["S2"], {"Y_v", "Y_vv", "Y_F"}),
        ("Eq. (16)", ["S3"], {"N_r", "N_rr", "N_F"}),
        ("Eq. (17)", ["S1"], {"N_ud", "N_uu"}),
    ]


def test_equation_17_as_printed_does_not_return_the_truth_and_the_difference_is_the_delay(mp):
    model = make_model(mp, TABLE_II["MP"], "forward-euler", 1 / RATE)
    data = [euler_trial(model, axis) for axis in range(3)]
    records, motions = [r for r, _ in data], [m for _, m in data]
    found = equation_error(
        records, mp, motions=motions, settings=EquationErrorSettings(literal=True)
    )
    assert abs(found.values["N_ud"] - TABLE_II["MP"]["N_ud"]) > 0.01
    assert found.values["X_u"] == pytest.approx(TABLE_II["MP"]["X_u"], abs=1e-9)
    # by hand: the same regression with (u_k-1 - u_k-2) / dt
    nu, c = motions[0].nu, found.values
    F = records[0].commands.values
    k = np.arange(2, len(nu))
    r, u = nu[:, 2], nu[:, 0]
    a = (
        (r[k] - r[k - 1]) * RATE
        - (c["N_rr"] * abs(r[k - 1]) + c["N_r"]) * r[k - 1]
        - c["N_F"] * F[k - 1, 2]
    )
    B = np.column_stack([abs(u[k - 1]) * u[k - 1], (u[k - 1] - u[k - 2]) * RATE])
    by_hand = np.linalg.lstsq(B, a, rcond=None)[0]
    assert [c["N_uu"], c["N_ud"]] == pytest.approx(by_hand.tolist(), rel=1e-5)


def test_recorded_trials_without_noise_give_nearly_the_truth_past_the_dead_zones_edge(clean_af):
    records = [clean_af[s].recording for s in ("S1", "S2", "S3")]
    found = seatrial.identify(records, clean_af["S1"].vehicle, method="equation-error")
    past = 1 / (1 - 0.08)  # under AF alone only the gain past the edge can be seen
    for name in ("X_F", "Y_F", "N_F"):
        true = TABLE_II["AF"][name] * past
        assert found.values[name] == pytest.approx(true, rel=0.12), name  # the lag takes the rest


def test_pose_noise_biases_the_drag(af, clean_af, paper_af):
    """The paper's weakness, as the design's table has it: errors in variables."""
    drag = [
        equation_error([t[s].recording for s in ("S1", "S2", "S3")], af).values["X_uu"]
        for t in (clean_af, paper_af)
    ]
    assert drag[0] == pytest.approx(-1.55, rel=0.1)  # an independent simulator gave this
    assert drag[1] < 2 * drag[0]


def test_roles_are_found_from_the_excitation_or_given(clean_af, af):
    records = [clean_af[s].recording for s in ("S3", "S7", "S1", "S2")]
    assert find_roles(af, records) == ((2,), (3,), (0,))
    assert find_roles(af, records, {"surge": ["S7-AF", "S1-AF"]})[0] == (1, 2)
    assert find_roles(af, records[1:2]) == ((0,), (0,), (0,))
    with pytest.raises(RecordingError, match="no such recording"):
        find_roles(af, records, {"yaw": ["S9"]})
    with pytest.raises(RecordingError, match="sway is never excited"):
        only = make_recording(
            "surge", records[2].stamps, records[2].eta, _surge_only(records[2].commands)
        )
        find_roles(af, [only])
    assert excitation(af, records[2]).dominant == 0


@pytest.mark.parametrize("method", METHODS)
def test_commands_that_never_change_are_refused(clean_af, af, method):
    records = [clean_af[s].recording for s in ("S1", "S2", "S3")]
    held = [
        make_recording(
            r.name,
            r.stamps,
            r.eta,
            replace(r.commands, values=np.full_like(r.commands.values, 0.5)),
        )
        for r in records
    ]
    with pytest.raises(RecordingError, match=r"F_u is 0\.44 throughout.*surge pulses"):
        identify(held, af, method=method)
    find_roles(af, [*held[:2], records[2]])  # one in which they change will do


def _surge_only(commands: Signal) -> Signal:
    return Signal(commands.names, commands.stamps, commands.values * [1.0, 0.0, 0.0])


def test_mixed_driving_identifies_an_axis_in_one_step(clean_af, af):
    found = seatrial.identify([clean_af["S7"].recording], af, method="equation-error")
    assert [s.equation for s in found.estimator.steps] == ["Eq. (14)", "Eq. (15)", "Eq. (16)"]
    assert set(found.estimator.steps[2].coefficients) == {"N_r", "N_rr", "N_F", "N_ud", "N_uu"}


def test_the_covariance_equals_the_spread_over_many_noises():
    """White residuals: Newey-West must agree with sigma^2 (B'B)^-1 and with Monte Carlo."""
    rng = np.random.default_rng(0)
    B = rng.normal(size=(4000, 3)) @ np.array([[1, 0.5, 0], [0, 1, 0.2], [0, 0, 1]])
    theta, sigma = np.array([1.0, -2.0, 0.5]), 0.3
    fits = [
        solve_least_squares(B, B @ theta + sigma * rng.normal(size=4000), ["a", "b", "c"], "x", 10)
        for _ in range(300)
    ]
    spread = np.std([f.theta for f in fits], axis=0)
    exact = sigma * np.sqrt(np.diag(np.linalg.inv(B.T @ B)))
    claimed = np.sqrt(np.mean([np.diag(f.covariance) for f in fits], axis=0))
    np.testing.assert_allclose(spread, exact, rtol=0.15)
    np.testing.assert_allclose(claimed, exact, rtol=0.05)


def test_correlated_residuals_widen_the_intervals():
    rng = np.random.default_rng(1)
    n, runs = 3000, 200
    B = np.repeat(rng.normal(size=(n // 30, 1)), 30, axis=0)
    kernel = np.ones(10) / np.sqrt(10)
    fits = [
        solve_least_squares(
            B, B[:, 0] + np.convolve(rng.normal(size=n + 9), kernel, "valid"), ["a"], "x", 20
        )
        for _ in range(runs)
    ]
    spread = np.std([f.theta[0] for f in fits])
    claimed = np.sqrt(np.mean([f.covariance[0, 0] for f in fits]))
    naive = 1 / np.sqrt(np.sum(B**2))
    assert claimed == pytest.approx(spread, rel=0.2)
    assert claimed > 2 * naive


def test_the_end_of_one_recording_does_not_hang_together_with_the_next_one_s_begin():
    """Which of them is first says nothing: the same numbers in either order."""
    rng = np.random.default_rng(2)
    B, noise = np.ones((120, 1)), np.cumsum(rng.normal(size=120))
    swap = np.r_[np.arange(40, 120), np.arange(40)]
    a = solve_least_squares(B, noise, ["a"], "x", 30, rows=[40, 80])
    b = solve_least_squares(B[swap], noise[swap], ["a"], "x", 30, rows=[80, 40])
    one = solve_least_squares(B, noise, ["a"], "x", 30)
    assert a.covariance == pytest.approx(b.covariance, rel=1e-9)
    assert a.covariance != pytest.approx(one.covariance, rel=1e-3)


@pytest.mark.system
def test_standard_errors_of_all_four_steps_are_the_spread_over_repeated_trials(mp):
    """White accelerations: no errors in variables, so the claimed errors must be the true ones."""
    c, dt, runs, n = TABLE_II["AF"], 1 / RATE, 150, 900
    rng = np.random.default_rng(0)
    stamps = np.rint(np.arange(n) * dt * 1e9).astype(np.int64)
    names, noise = list(mp.structure.coefficients), np.array([0.02, 0.02, 0.1])  # [m/s^2, rad/s^2]
    records, speeds = [], []
    for axis in range(3):
        F = np.zeros((n, 3))
        F[:, axis] = np.repeat(rng.uniform(-1, 1, n // 10), 10)
        commands = Signal(("F_u", "F_v", "F_r"), stamps, F)
        records.append(
            make_recording(f"S{axis + 1}", stamps, np.cumsum(np.ones((n, 3)), 0) * 1e-3, commands)
        )
        nu = np.zeros((runs, n, 3))
        for k in range(n - 1):
            u, v, r = nu[:, k].T
            w = noise * rng.normal(size=(runs, 3))
            du = v * r + (c["X_u"] + c["X_uu"] * abs(u)) * u + c["X_F"] * F[k, 0] + w[:, 0]
            dv = -u * r + (c["Y_v"] + c["Y_vv"] * abs(v)) * v + c["Y_F"] * F[k, 1] + w[:, 1]
            dr = c["N_ud"] * du + (c["N_r"] + c["N_rr"] * abs(r)) * r + c["N_uu"] * abs(u) * u
            nu[:, k + 1] = nu[:, k] + dt * np.column_stack(
                [du, dv, dr + c["N_F"] * F[k, 2] + w[:, 2]]
            )
        speeds.append(nu)
    fits = []
    for i in range(runs):
        motions = [
            Motion(r.t, r.eta, nu[i], np.ones(n, bool))
            for r, nu in zip(records, speeds, strict=True)
        ]
        fits.append(equation_error(records, mp, motions=motions))
    theta = np.array([f.coefficients for f in fits])
    claimed = np.sqrt(np.mean([np.diag(f.covariance) for f in fits], axis=0))
    np.testing.assert_allclose(claimed, theta.std(axis=0), rtol=0.2)
    off = (theta.mean(axis=0) - [c[name] for name in names]) / (claimed / np.sqrt(runs))
    assert np.abs(off).max() < 4.5
    i, j = names.index("N_r"), names.index("N_uu")  # Eq. (16) into Eq. (17)
    between = np.mean([f.covariance[i, j] for f in fits])
    assert between == pytest.approx(
        np.cov(theta[:, i], theta[:, j])[0, 1], abs=0.25 * claimed[i] * claimed[j]
    )


def test_what_can_not_be_told_apart_is_named():
    rng = np.random.default_rng(0)
    x = rng.normal(size=(500, 1))
    with pytest.raises(IdentificationError, match="X_a, X_b can't be told apart"):
        solve_least_squares(
            np.hstack([x, 2 * x, rng.normal(size=(500, 1))]),
            x[:, 0],
            ["X_a", "X_b", "X_c"],
            "here",
            5,
        )
    with pytest.raises(IdentificationError, match="X_b can't be found"):
        solve_least_squares(np.hstack([x, 0 * x]), x[:, 0], ["X_a", "X_b"], "here", 5)
    with pytest.raises(IdentificationError, match="10 usable samples"):
        solve_least_squares(x[:10], x[:10, 0], ["X_a"], "here", 5)


def test_one_coefficient_of_two_axes_is_refused(mp, clean_mp):
    """Step after step the later axis would overwrite what the earlier one has of it."""
    lines = {
        axis: [t.replace("Y_v * v", "X_u * v") for t in own]
        for axis, own in mp.structure.lines().items()
    }
    twice = replace(mp, file=msgspec.structs.replace(mp.file, structure=lines))
    recordings = [clean_mp[s].recording for s in ("S1", "S2", "S3")]
    with pytest.raises(IdentificationError, match="X_u stands in surge and sway"):
        seatrial.identify(recordings, twice, method="equation-error")


def test_a_boat_without_drag_is_refused_as_unstable(mp):
    """Thrust along the velocity: the recordings grow, the model must not be handed out."""
    values = TABLE_II["AF"] | {"N_r": 0.15, "N_rr": 0.02}
    model = make_model(mp, values, "forward-euler", 1 / RATE)
    records = [
        euler_trial(make_model(mp, TABLE_II["AF"], "forward-euler", 1 / RATE), a)[0] for a in (0, 1)
    ]
    records.append(euler_trial(model, 2, 8.0)[0])
    with pytest.raises(ModelError, match=r"unstable: driven in .*, yaw passes \d+[.\d]* rad/s"):
        seatrial.identify(records, mp, method="equation-error")


def test_no_recordings_and_unknown_methods_are_one_line(mp, clean_mp):
    with pytest.raises(IdentificationError, match="no recording"):
        seatrial.identify([], mp)
    with pytest.raises(IdentificationError, match="no method 'magic'"):
        seatrial.identify([clean_mp["S1"].recording], mp, method="magic")
    with pytest.raises(IdentificationError, match="same name"):
        seatrial.identify([clean_mp["S1"].recording] * 2, mp)
